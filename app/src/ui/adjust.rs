//! The brush set by moving the pointer, no button held, as Blender's F and Shift+F do.

use egui::{Context, PointerButton, Pos2, Ui};
use glam::Vec2;

use super::{Editor, viewport::Gesture};

/// Change of the radius's logarithm a point of the way.
const RADIUS_STEP: f32 = 0.01;
/// Change of the strength a point of the way.
const STRENGTH_STEP: f32 = 0.004;

/// What is being set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Adjusting {
    /// Else the radius.
    is_strength: bool,
    /// Where the ring stays meanwhile.
    pub(super) at: Pos2,
    /// Radius, centimetres, and strength before.
    before: [f32; 2],
}

impl Editor {
    /// From now on the pointer's way to the right and up sets the brush's radius or strength, until a click.
    pub(super) fn adjust_brush(&mut self, context: &Context, is_strength: bool) {
        let at = context.input(|input| input.pointer.latest_pos());
        if let (Some(at), Gesture::None) = (at, self.gesture) {
            self.gesture = Gesture::Adjust(Adjusting {
                is_strength,
                at,
                before: [self.brush.radius_cm, self.brush.strength],
            });
        }
    }

    /// Follows the pointer by `delta` points; a click keeps the value, `escape` and the other buttons put the old one back.
    pub(super) fn continue_adjusting(&mut self, ui: &Ui, adjusting: Adjusting, delta: Vec2, escape: bool) {
        let way = delta.x - delta.y;
        if adjusting.is_strength {
            self.brush.add_strength(STRENGTH_STEP * way);
        } else if way != 0.0 {
            self.brush.scale_radius((RADIUS_STEP * way).exp());
        }
        let (keeps, other) = ui.input(|input| {
            let clicked = |button| input.pointer.button_pressed(button);
            let other = clicked(PointerButton::Secondary) || clicked(PointerButton::Middle);
            (clicked(PointerButton::Primary), other)
        });
        if escape || other {
            [self.brush.radius_cm, self.brush.strength] = adjusting.before;
        }
        if keeps || other || escape {
            self.gesture = Gesture::None;
        }
    }
}
