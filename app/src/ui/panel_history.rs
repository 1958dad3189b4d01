//! What was done, step by step, and how much memory may be spent on undoing it at once.

use egui::Ui;

use super::{Command, Editor};

/// Height of the list, in points.
const LIST_HEIGHT: f32 = 220.0;
/// Bytes in a mebibyte.
const MIB: f32 = 1_048_576.0;
/// Largest limit that the slider offers, MiB.
const MOST_MIB: f32 = 4096.0;

impl Editor {
    pub(super) fn history_panel(&mut self, ui: &mut Ui) {
        let Some(document) = &self.document else { return };
        let (labels, done) = document.history_labels();
        let labels: Vec<String> = labels.into_iter().map(str::to_owned).collect();
        let (limit, kept) = (document.history_limit_bytes(), document.history_bytes());
        if labels.is_empty() {
            ui.weak("Nothing was done yet.");
        }
        let mut wanted = None;
        let row = ui.spacing().interact_size.y;
        egui::ScrollArea::vertical()
            .id_salt("history")
            .max_height(LIST_HEIGHT)
            .auto_shrink([false, true])
            .show_rows(ui, row, labels.len(), |ui, rows| {
                for i in rows {
                    let text = egui::RichText::new(format!("{}. {}", i + 1, labels[i]));
                    let text = if i < done { text } else { text.weak() };
                    let step = ui.selectable_label(i + 1 == done, text);
                    if step.on_hover_text("Goes back or forward to this state").clicked() {
                        wanted = Some(i + 1);
                    }
                }
            });
        if let Some(wanted) = wanted {
            let (command, steps) = if wanted < done {
                (Command::Undo, done - wanted)
            } else {
                (Command::Redo, wanted - done)
            };
            for _ in 0..steps {
                self.run(ui.ctx(), command);
            }
        }
        let mut mib = limit as f32 / MIB;
        let slider = egui::Slider::new(&mut mib, 0.0..=MOST_MIB)
            .logarithmic(true)
            .text("Memory")
            .suffix(" MiB");
        let hint =
            "What does not fit is undone by painting everything again, which takes longer, or forgotten";
        if ui.add(slider).on_hover_text(hint).changed()
            && let Some(document) = &mut self.document
        {
            document.set_history_bytes((mib * MIB) as usize);
        }
        ui.weak(format!("{:.1} MiB kept", kept as f32 / MIB));
        ui.separator();
        self.snapshot_list(ui);
    }
}
