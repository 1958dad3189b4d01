//! The status bar: what the picture costs, what is under way, the newest message.

use balayage_render::gpu::Terms;
use egui::{ProgressBar, Ui};

use super::{Editor, job::Job};

impl Editor {
    pub(super) fn status_bar(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            self.view_controls(ui);
            ui.separator();
            self.costs(ui);
            self.jobs(ui);
            if let Some(message) = self.messages.last() {
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    let color = if message.is_error {
                        ui.visuals().error_fg_color
                    } else {
                        ui.visuals().weak_text_color()
                    };
                    let log: Vec<&str> = self
                        .messages
                        .iter()
                        .map(|message| message.text.as_str())
                        .collect();
                    ui.add(egui::Label::new(egui::RichText::new(&message.text).color(color)).truncate())
                        .on_hover_text(log.join("\n"));
                });
            }
        });
    }

    fn view_controls(&mut self, ui: &mut Ui) {
        let names = [
            ("All light", Terms::ALL),
            ("Single", Terms::SINGLE),
            ("Multiple", Terms::MULTIPLE),
        ];
        let single = Terms::NAMES
            .iter()
            .enumerate()
            .map(|(bit, name)| (*name, Terms(1 << bit)));
        let choices: Vec<_> = names.into_iter().chain(single).collect();
        let current = choices
            .iter()
            .find(|(_, terms)| *terms == self.view.terms)
            .map_or("", |(name, _)| name);
        egui::ComboBox::from_label("Terms")
            .selected_text(current)
            .width(80.0)
            .show_ui(ui, |ui| {
                for (name, terms) in choices {
                    ui.selectable_value(&mut self.view.terms, terms, name);
                }
            });
        ui.add(
            egui::DragValue::new(&mut self.view.exposure_ev)
                .range(-10.0..=10.0)
                .speed(0.02)
                .suffix(" EV"),
        )
        .on_hover_text("Display exposure: of the picture only, not of the light");
    }

    fn costs(&self, ui: &mut Ui) {
        let Some(document) = &self.document else { return };
        let points = document.groom().point_count();
        let lights = self
            .lighting
            .as_ref()
            .map_or(0, |lighting| lighting.lights.lights.len());
        let mut text = format!("{points} points · {lights} lights");
        let Some(shown) = &self.shown else {
            ui.label(text);
            return;
        };
        text += &format!(" · shaded {}", shown.report.counter("vertices shaded"));
        text += &format!(
            " · {:.0} ms · {}",
            shown.milliseconds,
            if shown.is_draft { "draft" } else { "refined" }
        );
        let mut table: Vec<String> = shown
            .report
            .passes
            .iter()
            .map(|(name, ms)| format!("{name}: {ms:.1} ms"))
            .collect();
        table.extend(
            shown
                .report
                .counters
                .iter()
                .map(|(name, n)| format!("{name}: {n}")),
        );
        table.extend(self.adapter.clone());
        ui.label(text).on_hover_text(table.join("\n"));
    }

    fn jobs(&mut self, ui: &mut Ui) {
        // The thread ends by itself; nobody waits for what it brings.
        if self.opening.as_ref().is_some_and(|job| bar(ui, job)) {
            self.opening = None;
        }
        // The maps of a sequence that plays follow each other too fast for a bar.
        if !self.is_playing() && self.fitting.as_ref().is_some_and(|job| bar(ui, job)) {
            self.stop_fitting();
        }
    }
}

/// A job's bar with its estimate; true when the person cancelled it.
fn bar<T: Send + 'static>(ui: &mut Ui, job: &Job<T>) -> bool {
    let left = job
        .time_left()
        .map(|left| format!(", {} s left", left.as_secs() + 1))
        .unwrap_or_default();
    let text = format!("{}{left}", job.what());
    ui.add(
        ProgressBar::new(job.share())
            .desired_width(220.0)
            .text(text)
            .animate(true),
    );
    ui.button("Cancel").clicked()
}
