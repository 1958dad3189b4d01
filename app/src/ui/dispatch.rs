//! What commands do, and when they make sense.

use balayage_render::gpu::Terms;
use egui::Context;
use glam::Vec3;

use super::{
    Command, Editor,
    actions::{DialogAnswer, PendingAction},
};
use crate::{
    document::{Edit, Layer},
    tool::{Tool, ViewCamera},
};

impl Editor {
    /// Whether `command` makes sense now.
    pub(super) fn is_enabled(&self, command: Command) -> bool {
        let document = self.document.as_ref();
        match command {
            Command::Undo => document.is_some_and(|document| document.undo_label().is_some()),
            Command::Redo => document.is_some_and(|document| document.redo_label().is_some()),
            Command::Open | Command::OpenSample => self.opening.is_none(),
            Command::Quit | Command::Palette | Command::FullScreen | Command::HidePanels => true,
            Command::TakeSnapshot | Command::Compare => document.is_some() && self.lighting.is_some(),
            Command::DeleteLight => self.selected_light().is_some(),
            Command::SaveLights => self.lighting.is_some(),
            Command::PlaySequence | Command::NextMap | Command::PreviousMap => self.sequence().is_some(),
            Command::MergeDown => document.is_some_and(|document| {
                document
                    .project()
                    .layers
                    .first()
                    .is_some_and(|layer| layer.id != self.layer)
            }),
            _ => document.is_some(),
        }
    }

    /// Does `command`, where it makes sense.
    pub fn run(&mut self, context: &Context, command: Command) {
        if !self.is_enabled(command) {
            return;
        }
        match command {
            Command::Open => self.guarded(context, PendingAction::AskToOpen),
            Command::OpenSample => self.guarded(context, PendingAction::OpenSample),
            Command::Quit => self.guarded(context, PendingAction::Quit),
            Command::Save => match self.document.as_ref().and_then(|document| document.path()) {
                Some(path) => {
                    let path = path.to_owned();
                    self.save_to(context, &path);
                }
                None => self.ask_where_to_save(context),
            },
            Command::SaveAs => self.ask_where_to_save(context),
            Command::Undo | Command::Redo => self.step_history(command == Command::Undo),
            Command::FrameHair => {
                self.camera = self
                    .document
                    .as_ref()
                    .map(|document| ViewCamera::framing(document.groom().bounds(), self.aspect));
            }
            Command::ViewFront => self.look(|camera| camera.face(Vec3::Z)),
            Command::ViewBack => self.look(|camera| camera.face(Vec3::NEG_Z)),
            // Right and left are those of a viewer in front.
            Command::ViewRight => self.look(|camera| camera.face(Vec3::X)),
            Command::ViewLeft => self.look(|camera| camera.face(Vec3::NEG_X)),
            Command::ViewTop => self.look(|camera| camera.face(Vec3::Y)),
            Command::ViewBottom => self.look(|camera| camera.face(Vec3::NEG_Y)),
            Command::BrushSmaller => self.brush.scale_radius(1.0 / 1.15),
            Command::BrushLarger => self.brush.scale_radius(1.15),
            Command::BrushWeaker => self.brush.add_strength(-0.05),
            Command::BrushStronger => self.brush.add_strength(0.05),
            Command::BrushRadius | Command::BrushStrength => {
                self.adjust_brush(context, command == Command::BrushStrength);
            }
            Command::AddLayer => self.add_layer(),
            Command::DuplicateLayer => self.duplicate_layer(),
            Command::MergeDown => self.merge_down(),
            Command::Eyedropper => self.tool = Tool::Eyedropper,
            Command::OpenEnvironment => {
                self.ask_for_file(
                    context,
                    "Environment maps",
                    &["hdr", "exr"],
                    DialogAnswer::Environment,
                );
            }
            Command::OpenLights => self.ask_for_file(context, "Light lists", &["json"], DialogAnswer::Lights),
            Command::OpenSequence => self.ask_for_sequence(context, false),
            Command::OpenSequenceFolder => self.ask_for_sequence(context, true),
            Command::PlaySequence => self.play_or_pause(),
            Command::NextMap => self.step_sequence(1),
            Command::PreviousMap => self.step_sequence(-1),
            Command::SaveLights => self.ask_where_to_save_lights(context),
            Command::DeleteLight => self.delete_selected_light(),
            Command::Palette => self.toggle_palette(),
            Command::PaintTool => self.tool = Tool::Paint,
            Command::CombTool => self.tool = Tool::Comb,
            Command::EraseTool => self.tool = Tool::Erase,
            Command::SmoothTool => self.tool = Tool::Smooth,
            Command::MaskTool => self.tool = Tool::Mask,
            Command::LassoTool => self.tool = Tool::Lasso,
            Command::TakeSnapshot => self.take_snapshot(),
            Command::Compare => self.toggle_compare(),
            Command::Before => self.keeps_before = !self.keeps_before,
            Command::SoloNext => self.solo_next_term(),
            Command::AllLight => self.view.terms = Terms::ALL,
            Command::Turntable => self.turns = true,
            Command::FullScreen => Self::toggle_full_screen(context),
            Command::HidePanels => self.hides_panels = !self.hides_panels,
        }
    }

    fn step_history(&mut self, back: bool) {
        let Some(document) = &mut self.document else {
            return;
        };
        let stepped = if back { document.undo() } else { document.redo() };
        if let Some((label, changes)) = stepped {
            self.say(format!("{}: {label}", if back { "Undone" } else { "Done again" }));
            self.pass_on(&changes);
        }
    }

    /// A number that no layer has in its id.
    fn free_layer_number(&self) -> usize {
        let layers = self
            .document
            .as_ref()
            .map_or(&[][..], |document| &document.project().layers);
        (1..)
            .find(|n| layers.iter().all(|layer| layer.id != format!("layer-{n}")))
            .unwrap_or(1)
    }

    fn duplicate_layer(&mut self) {
        let id = format!("layer-{}", self.free_layer_number());
        self.edit(Edit::DuplicateLayer(self.layer.clone(), id.clone()));
        self.layer = id;
    }

    fn merge_down(&mut self) {
        let Some(document) = &self.document else { return };
        let layers = &document.project().layers;
        let position = layers.iter().position(|layer| layer.id == self.layer);
        let below = position
            .and_then(|position| position.checked_sub(1))
            .map(|below| layers[below].id.clone());
        let merged = std::mem::replace(&mut self.layer, below.unwrap_or_default());
        self.edit(Edit::MergeDown(merged.clone()));
        // Where merging was refused the layer is still there.
        let layers = self
            .document
            .as_ref()
            .map_or(&[][..], |document| &document.project().layers);
        if layers.iter().any(|layer| layer.id == merged) {
            self.layer = merged;
        }
    }

    fn add_layer(&mut self) {
        let Some(document) = &self.document else { return };
        let layers = &document.project().layers;
        let number = self.free_layer_number();
        let id = format!("layer-{number}");
        let edit = Edit::AddLayer(Layer::new(&id, format!("Layer {number}")), layers.len());
        self.edit(edit);
        self.layer = id;
    }
}
