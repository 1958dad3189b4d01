//! Playing a sequence of maps: every map in turn, never faster than the rate, each fitted from the lights of the one before.

use std::time::{Duration, Instant};

use egui::{Context, DragValue, Slider, Ui};

use super::{Command, Editor};
use crate::document::{Edit, Environment, LightSettings, Sequence};

/// A sequence that plays.
#[derive(Clone, Copy)]
pub(super) struct Playing {
    /// When the next map is due.
    due: Instant,
    /// Pictures shown before the newest map: the next one waits until it was seen.
    frames_shown: u64,
}

impl Editor {
    /// The sequence that lights the hair, if one does.
    pub(super) fn sequence(&self) -> Option<&Sequence> {
        match &self.document.as_ref()?.project().light.environment {
            Environment::Sequence(sequence) => Some(sequence),
            _ => None,
        }
    }

    /// True while a sequence plays.
    pub fn is_playing(&self) -> bool {
        self.light_tab.playing.is_some()
    }

    pub(super) fn stop_sequence(&mut self) {
        self.light_tab.playing = None;
    }

    pub(super) fn play_or_pause(&mut self) {
        if self.is_playing() {
            self.stop_sequence();
            self.measure_fit();
        } else {
            self.light_tab.playing = Some(Playing {
                due: Instant::now(),
                frames_shown: 0,
            });
        }
    }

    /// Shows the map `by` places on, round and round; a sequence that plays is paused.
    pub(super) fn step_sequence(&mut self, by: i64) {
        self.stop_sequence();
        self.show_map(by);
    }

    fn show_map(&mut self, by: i64) {
        let Some(sequence) = self.sequence() else { return };
        let count = sequence.maps.len() as i64;
        let Some(document) = &mut self.document else {
            return;
        };
        let frame = (i64::from(document.project().frame) + by).rem_euclid(count.max(1));
        document.set_frame(frame as u32);
        self.refresh_light();
    }

    /// Asks for the next map once the last one is fitted and seen and the time has come.
    pub(super) fn drive_sequence(&mut self, context: &Context) {
        let Some(playing) = self.light_tab.playing else {
            return;
        };
        let Some(sequence) = self.sequence() else {
            return self.stop_sequence();
        };
        let period = Duration::from_secs_f32(1.0 / sequence.fps);
        if self.fitting.is_some() || self.frames_shown <= playing.frames_shown {
            return;
        }
        let now = Instant::now();
        if now < playing.due {
            return context.request_repaint_after(playing.due - now);
        }
        // A map that came late does not make the next one come early.
        self.light_tab.playing = Some(Playing {
            due: (playing.due + period).max(now),
            frames_shown: self.frames_shown,
        });
        self.show_map(1);
    }

    /// Play, pause, step, rate.
    pub(super) fn sequence_controls(&mut self, ui: &mut Ui) {
        let Some(sequence) = self.sequence().cloned() else {
            return;
        };
        let Some(document) = &self.document else { return };
        let light = document.project().light.clone();
        let frame = sequence.index(document.project().frame);
        ui.horizontal(|ui| {
            let play = if self.is_playing() { "Pause" } else { "Play" };
            for (name, hint, command) in [
                ("Back", "The map before", Command::PreviousMap),
                (play, "Plays the maps in turn", Command::PlaySequence),
                ("Step", "The next map", Command::NextMap),
            ] {
                if ui.button(name).on_hover_text(hint).clicked() {
                    self.run(ui.ctx(), command);
                }
            }
            let mut fps = sequence.fps;
            let rate = DragValue::new(&mut fps)
                .range(0.1..=60.0)
                .speed(0.1)
                .max_decimals(1)
                .suffix(" maps/s");
            let rate = ui
                .add(rate)
                .on_hover_text("Never faster than this; every map is shown");
            rate.widget_info(|| egui::WidgetInfo::slider(true, f64::from(fps), "Rate"));
            if rate.changed() {
                let environment = Environment::Sequence(Sequence {
                    fps,
                    ..sequence.clone()
                });
                self.edit_by(&rate, Edit::SetLight(LightSettings { environment, ..light }));
            }
        });
        let mut number = frame + 1;
        let slider = ui
            .add(Slider::new(&mut number, 1..=sequence.maps.len()).text("Map"))
            .on_hover_text(&sequence.maps[frame]);
        if slider.changed() {
            self.step_sequence(number as i64 - 1 - frame as i64);
        }
    }
}
