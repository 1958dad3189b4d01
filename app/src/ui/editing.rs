//! Edits on their way: from a widget to the document, from the document to the viewer.

use std::sync::Arc;

use super::{Editor, viewer::SceneInput};
use crate::{
    Problem,
    document::{Changes, Document, Edit},
};

impl Editor {
    /// Applies an edit and passes on what it changed.
    pub(super) fn edit(&mut self, edit: Edit) {
        let Some(document) = &mut self.document else {
            return;
        };
        let result = document.apply(edit);
        self.took(result);
    }

    /// Applies an edit of a slider; the changes of one drag are one history entry.
    pub(super) fn edit_by(&mut self, response: &egui::Response, edit: Edit) {
        let Some(document) = &mut self.document else {
            return;
        };
        let continues = self.slider == Some(response.id);
        let is_held = response
            .ctx
            .input(|input| input.pointer.any_down() || input.pointer.any_released());
        self.slider = is_held.then_some(response.id);
        let result = if continues {
            document.apply_continuing(edit)
        } else {
            document.apply(edit)
        };
        self.took(result);
    }

    /// Applies an edit that goes on from the newest one where that was of the same kind, as typing does.
    pub(super) fn edit_on(&mut self, edit: Edit) {
        let Some(document) = &mut self.document else {
            return;
        };
        let result = document.apply_continuing(edit);
        self.took(result);
    }

    fn took(&mut self, result: Result<Changes, Problem>) {
        match result {
            Ok(changes) => self.pass_on(&changes),
            Err(problem) => self.complain(&problem),
        }
    }

    /// Tells the viewer what changed.
    pub(super) fn pass_on(&mut self, changes: &Changes) {
        let Some(document) = &self.document else { return };
        self.viewer.set_params(document.params(), &changes.points);
        if changes.light {
            self.refresh_light();
        }
        if changes.head || changes.diameter {
            self.refresh_scene();
        }
        let layers = &document_layers(self.document.as_ref());
        if !layers.contains(&self.layer) {
            self.layer = layers.last().cloned().unwrap_or_default();
        }
    }

    /// Sends groom, head and all parameters.
    pub(super) fn refresh_scene(&mut self) {
        let Some(document) = &self.document else { return };
        let scene = document.groom_as_drawn().and_then(|groom| {
            Ok(SceneInput {
                groom,
                head: document.load_head()?.map(Arc::new),
                voxel_spacings: self.view.voxel_spacings,
            })
        });
        match scene {
            Ok(scene) => self.send_scene(scene),
            Err(problem) => self.complain(&problem),
        }
    }

    pub(super) fn send_scene(&mut self, scene: SceneInput) {
        let Some(document) = &self.document else { return };
        let all = crate::paint::DirtyRanges::all(document.groom().point_count());
        self.viewer.set_scene(scene.clone());
        self.viewer.set_params(document.params(), &all);
        self.scene = Some(scene);
    }
}

/// Ids of the layers, lowest first.
fn document_layers(document: Option<&Document>) -> Vec<String> {
    document.map_or_else(Vec::new, |document| {
        document
            .project()
            .layers
            .iter()
            .map(|layer| layer.id.clone())
            .collect()
    })
}
