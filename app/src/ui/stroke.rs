//! What the tools do to the hair under the pointer: strokes, picking, the lasso.

use balayage_render::{gpu::Camera, param::Channel};
use egui::{Modifiers, Pos2, Rect};
use glam::{Vec2, Vec3};

use super::{
    Editor,
    viewport::{Gesture, in_picture},
};
use crate::{
    document::{Edit, Layer},
    paint::{Dab, Mask, MaskKind, MaskPart, Mode, Reach},
    tool::{StrokePath, Tool, dab_at, dabs_through, mirrored, place_on_strands},
};

impl Editor {
    /// Limits the layer to strands that are rooted inside the outline that was drawn: each of its corners counts as the root of
    /// the strand that is seen there.
    pub(super) fn close_lasso(&mut self, rect: Rect) {
        let outline = std::mem::take(&mut self.outline);
        let roots: Vec<[f32; 3]> = outline
            .into_iter()
            .filter_map(|place| self.dabs(place, rect).first().map(|dab| dab.root))
            .collect();
        let layer = self.document.as_ref().and_then(|document| {
            let layers = &document.project().layers;
            layers.iter().find(|layer| layer.id == self.layer).cloned()
        });
        let Some(layer) = layer else { return };
        if roots.len() < 3 {
            self.say("Lasso: draw round hair, so that the outline meets strands");
            return;
        }
        let part = MaskPart {
            kind: MaskKind::Region {
                outline: roots,
                soften_mm: 5.0,
            },
            invert: false,
        };
        let mut parts = layer.mask.parts.clone();
        parts.push(part);
        self.edit(Edit::SetLayer(Layer {
            mask: Mask {
                parts,
                ..layer.mask.clone()
            },
            ..layer
        }));
    }

    /// Starts a stroke; Ctrl inverts it (erases), Shift smooths.
    pub(super) fn begin_stroke(&mut self, at: Pos2, rect: Rect, modifiers: Modifiers) -> Gesture {
        let tool = match self.tool {
            Tool::Paint | Tool::Comb if modifiers.shift => Tool::Smooth,
            Tool::Paint | Tool::Comb if modifiers.command => Tool::Erase,
            tool => tool,
        };
        let Some(document) = &mut self.document else {
            return Gesture::None;
        };
        let Some(mut operation) = self.brush.operation(tool, &self.layer, document) else {
            return Gesture::None;
        };
        if tool == Tool::Mask && modifiers.command {
            operation.mode = Mode::Erase;
        }
        if let Err(problem) = document.begin_stroke(operation) {
            self.complain(&problem);
            return Gesture::None;
        }
        let place = Vec2::new(at.x, at.y);
        self.paint_at(&[place], rect);
        Gesture::Stroke(StrokePath::new(place))
    }

    /// Goes on along the pointer's `way` in this frame.
    pub(super) fn continue_stroke(&mut self, mut path: StrokePath, way: &[Pos2], rect: Rect) {
        let mut places = Vec::new();
        for at in way {
            let step = (self.brush.spacing * self.ring_radius(*at, rect)).max(2.0);
            let brush = path.pulled(Vec2::new(at.x, at.y), self.brush.string);
            places.extend(path.advance(brush, step));
        }
        self.gesture = Gesture::Stroke(path);
        self.paint_at(&places, rect);
    }

    pub(super) fn cancel_stroke(&mut self) {
        if let Some(document) = &mut self.document {
            let dirty = document.cancel_stroke();
            self.viewer.set_params(document.params(), &dirty);
        }
        self.gesture = Gesture::None;
        self.say("Stroke cancelled");
    }

    /// Adds the dabs that belong to places on the screen.
    fn paint_at(&mut self, places: &[Vec2], rect: Rect) {
        let dabs: Vec<Dab> = places.iter().flat_map(|place| self.dabs(*place, rect)).collect();
        let Some(document) = &mut self.document else {
            return;
        };
        match document.extend_stroke(dabs) {
            Ok(dirty) => self.viewer.set_params(document.params(), &dirty),
            Err(problem) => self.complain(&problem),
        }
    }

    /// The dabs at one place of the screen: one on the visible strand, or one for each depth.
    fn dabs(&self, place: Vec2, rect: Rect) -> Vec<Dab> {
        let (Some((camera, point)), Some(document)) = (self.touched(place, rect), &self.document) else {
            return Vec::new();
        };
        let radius = 0.01 * self.brush.radius_cm / document.groom().metres_per_unit();
        let index = document.index();
        let pressure = if self.brush.uses_pressure {
            self.pressure
        } else {
            1.0
        };
        let eye = camera.position();
        let sides = [(eye, point), (mirrored(eye), mirrored(point))];
        let count = if self.brush.mirror { 2 } else { 1 };
        let of_side = |(eye, point)| {
            if self.brush.reach == Reach::Through && self.tool != Tool::Comb {
                dabs_through(index, eye, point, radius, pressure)
            } else {
                dab_at(index, point, radius, pressure).into_iter().collect()
            }
        };
        sides.into_iter().take(count).flat_map(of_side).collect()
    }

    /// The hair that is touched at a place of the screen, and the camera that it is seen with; before the first picture the groom's
    /// strands tell.
    fn touched(&self, place: Vec2, rect: Rect) -> Option<(Camera, Vec3)> {
        let at = in_picture(place, rect);
        if let Some(picks) = self.shown.as_ref().and_then(|shown| shown.picks.as_ref()) {
            return Some((picks.camera, picks.place(at)?));
        }
        let camera = *self.camera.as_ref()?.camera();
        let groom = self.document.as_ref()?.groom();
        let aspect = rect.width().max(1.0) / rect.height().max(1.0);
        Some((camera, place_on_strands(&camera, aspect, groom, at)?))
    }

    /// Takes the value of the touched hair into the brush.
    pub(super) fn pick_value(&mut self, at: Pos2, rect: Rect) {
        let Some(dab) = self.dabs(Vec2::new(at.x, at.y), rect).into_iter().next() else {
            return;
        };
        let Some(document) = &self.document else { return };
        let radius = 0.01 * self.brush.radius_cm / document.groom().metres_per_unit();
        let mut nearest = (f32::INFINITY, 0);
        document
            .index()
            .for_each_near(dab.position.into(), radius, |point, distance| {
                if distance < nearest.0 {
                    nearest = (distance, point);
                }
            });
        let point = nearest.1 as usize;
        if self.picks_seen_colour {
            let sigma_a = document.params()[point].sigma_a;
            self.brush.channel = Channel::Dye;
            self.brush.dye = sigma_a;
            self.brush.dye_strength = 1.0;
            self.say("Took the seen colour from the hair: all of its absorption, as dye for bleached hair");
            return;
        }
        let values = document.values()[point];
        match self.brush.channel {
            Channel::Dye => {
                self.brush.dye = values.dye;
                self.brush.dye_strength = 1.0;
            }
            channel => self.brush.value = values.get(channel)[0],
        }
        self.say(format!("Took {} from the hair", self.brush.channel.name()));
    }
}
