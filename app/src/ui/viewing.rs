//! Commands of the view: one term alone, false colours, full screen, the turntable.

use std::time::Duration;

use balayage_render::gpu::{DebugView, Terms};
use balayage_render::volume::VolumeSettings;
use egui::{Color32, Context, Event, Rect, Ui, ViewportCommand};
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

    /// The picture, or one of the quantities behind it in false colours.
    pub(super) fn false_colours_menu(&mut self, ui: &mut Ui) {
        ui.radio_value(&mut self.view.debug, None, "Off: the picture");
        for (view, _, name) in DebugView::ALL {
            ui.radio_value(&mut self.view.debug, Some(view), name);
        }
    }

    /// How finely the hair is divided for light's way through it.
    pub(super) fn hair_volume_menu(&mut self, ui: &mut Ui) {
        let before = self.view.voxel_spacings;
        for (spacings, name, hint) in [
            (0.75, "Fine", "Sharper shadows at once; more memory and time"),
            (
                VolumeSettings::default().voxel_spacings,
                "Usual",
                "A little wider than the distance between fibres",
            ),
            (
                2.0,
                "Coarse",
                "Less memory and time; shadows from voxels are softer until exact rays refine them",
            ),
            (4.0, "Very coarse", "For grooms that hardly fit into memory"),
        ] {
            ui.radio_value(&mut self.view.voxel_spacings, spacings, name)
                .on_hover_text(hint);
        }
        if self.view.voxel_spacings != before {
            self.refresh_scene();
        }
    }

    /// What false colours mean, in the lower left corner of the viewport.
    pub(super) fn legend(&self, ui: &Ui, rect: Rect) {
        let Some(legend) = self.shown.as_ref().and_then(|shown| shown.legend.as_ref()) else {
            return;
        };
        let shown = DebugView::ALL
            .iter()
            .find(|(view, ..)| Some(*view) == self.view.debug);
        let name = shown.map_or("", |(_, _, name)| name);
        let font = egui::TextStyle::Body.resolve(ui.style());
        let at = rect.left_bottom() + egui::Vec2::new(10.0, -8.0);
        let text = format!("{name}: {legend}");
        ui.painter()
            .text(at, egui::Align2::LEFT_BOTTOM, text, font, Color32::from_gray(200));
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
