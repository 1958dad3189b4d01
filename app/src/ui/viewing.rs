//! Commands of the view: one term alone, full screen, the turntable.

use std::time::Duration;

use balayage_render::gpu::Terms;
use egui::{Context, Event, ViewportCommand};
use glam::Vec2;

use super::Editor;

/// Turns of the turntable a second.
const TURNS_PER_SEC: f32 = 1.0 / 12.0;
/// Time between two views of the turntable.
const TURNTABLE_STEP: Duration = Duration::from_millis(33);

impl Editor {
    /// Shows the next term of scattering alone; after the last one, all of them.
    pub(super) fn solo_next_term(&mut self) {
        let count = Terms::NAMES.len();
        let shown = (0..count).find(|bit| self.view.terms == Terms(1 << bit));
        let next = shown.map_or(0, |bit| bit + 1);
        if next < count {
            self.view.terms = Terms(1 << next);
            self.say(format!("Only {}", Terms::NAMES[next]));
        } else {
            self.view.terms = Terms::ALL;
            self.say("All light");
        }
    }

    pub(super) fn toggle_full_screen(context: &Context) {
        let is_full = context.input(|input| input.viewport().fullscreen.unwrap_or(false));
        context.send_viewport_cmd(ViewportCommand::Fullscreen(!is_full));
    }

    /// Turns the view on while the turntable runs; any press of a button or key and the wheel stop it.
    pub(super) fn drive_turntable(&mut self, context: &Context) {
        if !self.turns {
            return;
        }
        let (stops, seconds) = context.input(|input| {
            let is_touch = |event: &Event| {
                matches!(
                    event,
                    Event::Key {
                        pressed: true,
                        repeat: false,
                        ..
                    } | Event::PointerButton { pressed: true, .. }
                        | Event::MouseWheel { .. }
                )
            };
            (input.events.iter().any(is_touch), input.stable_dt.min(0.1))
        });
        if stops {
            self.turns = false;
            self.say("The turntable stands");
            return;
        }
        // A drag over the height of the viewport is half a turn.
        self.look(|camera| camera.orbit(Vec2::new(-2.0 * TURNS_PER_SEC * seconds, 0.0)));
        context.request_repaint_after(TURNTABLE_STEP);
    }
}
