//! What the document holds, what the last picture and the last stroke cost, and everything that was said.

use egui::{Grid, Ui};

use super::Editor;

/// Bytes in a mebibyte.
const MIB: f64 = 1_048_576.0;

impl Editor {
    pub(super) fn statistics_panel(&mut self, ui: &mut Ui) {
        let mut rows: Vec<(String, String)> = Vec::new();
        let mut row = |name: &str, value: String| rows.push((name.to_owned(), value));
        if let Some(document) = &self.document {
            let (groom, project) = (document.groom(), document.project());
            row("Strands", groom.strand_count().to_string());
            row("Points", groom.point_count().to_string());
            row("Layers", project.layers.len().to_string());
            row("Strokes and operations", project.operations.len().to_string());
            let bytes = document.history_bytes() as f64;
            row("History", format!("{:.1} MiB", bytes / MIB));
        }
        if let Some(lights) = self.lights() {
            row("Lights", lights.lights.len().to_string());
        }
        table(ui, "document", &rows);

        if let Some(shown) = &self.shown {
            ui.strong("Last picture");
            let [width, height] = shown.texture.size();
            let state = if shown.is_draft { "draft" } else { "refined" };
            let mut rows = vec![
                ("Size".to_owned(), format!("{width} x {height}")),
                ("State".to_owned(), state.to_owned()),
                ("All of it".to_owned(), format!("{:.1} ms", shown.milliseconds)),
            ];
            let passes = shown.report.passes.iter();
            rows.extend(passes.map(|(name, ms)| (name.clone(), format!("{ms:.1} ms"))));
            let counters = shown.report.counters.iter();
            rows.extend(counters.map(|(name, n)| (name.clone(), n.to_string())));
            table(ui, "picture", &rows);
            if !shown.report.shaders.is_empty() {
                ui.strong("On the GPU");
                let shaders = shown.report.shaders.iter();
                let rows: Vec<_> = shaders
                    .map(|(name, ms)| (name.clone(), format!("{ms:.2} ms")))
                    .collect();
                table(ui, "gpu", &rows);
            }
            let skipped = [
                ("vertices shaded", "Shading: nothing that is seen had changed"),
                ("visibility rays", "Shadows: strands and lights are as before"),
                (
                    "voxels painted",
                    "Light's losses on its way: kept from the picture before",
                ),
                ("fragments", "Drawing: only the display transform was new"),
            ];
            let skipped = skipped
                .into_iter()
                .filter(|(name, _)| shown.report.counter(name) == 0);
            let skipped: Vec<&str> = skipped.map(|(_, what)| what).collect();
            if !skipped.is_empty() {
                ui.strong("Not computed");
                for what in skipped {
                    ui.weak(what);
                }
            }
        }
        if let Some(document) = &self.document {
            let work = document.paint_work();
            let ms = |time: std::time::Duration| format!("{:.2} ms", 1e3 * time.as_secs_f64());
            ui.strong("Since the last stroke began");
            let rows = [
                ("Points the brush looked at", work.measured.to_string()),
                ("Points painted", work.blended.to_string()),
                ("Points composited", work.composed.to_string()),
                ("Points changed", work.changed.to_string()),
                ("Finding them", ms(work.query)),
                ("Painting them", ms(work.blend)),
                ("Compositing them", ms(work.compose)),
            ];
            let rows = rows.map(|(name, value)| (name.to_owned(), value));
            table(ui, "stroke", &rows);
        }
        if let Some(adapter) = &self.adapter {
            ui.weak(format!("Drawn by {adapter}"));
        }
        egui::CollapsingHeader::new("Log").show(ui, |ui| {
            for message in &self.messages {
                ui.label(&message.text);
            }
        });
    }
}

fn table(ui: &mut Ui, id: &str, rows: &[(String, String)]) {
    Grid::new(id).num_columns(2).striped(true).show(ui, |ui| {
        for (name, value) in rows {
            ui.label(name);
            ui.monospace(value);
            ui.end_row();
        }
    });
}
