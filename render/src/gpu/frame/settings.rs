//! How a frame is drawn.

use crate::gpu::{Quality, Savings, ShadeSettings, ViewTransform};

/// How a frame is drawn; what is drawn is the renderer's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// What light does.
    pub shade: ShadeSettings,
    /// Camera samples a pixel (>= 1); coverage is exact with one, more smooth the shading between vertices.
    pub samples: u32,
    /// Display transform.
    pub view: ViewTransform,
    /// Display exposure in stops, on the picture only.
    pub view_exposure_ev: f32,
    /// Shows the environment behind the hair.
    pub show_background: bool,
    /// Display-linear colour behind the picture, a = 0: transparent.
    pub backdrop: [f32; 4],
    /// Exact rays per point and light that visibility comes from; 0: from the density of the voxels. More rays are a refinement: what was
    /// traced for a picture stays for the next ones until strands or lights change.
    pub visibility_rays: u32,
    /// True while a hand moves something: what light loses on its way through freshly painted hair stays as it was (the paint itself is
    /// shown), so that only painted vertices are shaded again, and so do other things that [`Saving`](crate::gpu::Saving) names. The next frame without it
    /// brings everything up to date.
    pub interactive: bool,
    /// Share of the strands that is drawn, each wider, so that the hair's area stays; 1: all of them.
    pub strand_share: f32,
    /// What need not be done.
    pub savings: Savings,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            shade: ShadeSettings::default(),
            samples: 1,
            view: ViewTransform::Neutral,
            view_exposure_ev: 0.0,
            show_background: false,
            backdrop: [0.0; 4],
            visibility_rays: 0,
            interactive: false,
            strand_share: 1.0,
            savings: Savings::ALL,
        }
    }
}

impl RenderSettings {
    /// The settings with the savings that their quality bears: the highest is there to be compared with.
    pub(super) fn of_its_quality(&self) -> Self {
        let mut settings = *self;
        if settings.shade.method.quality == Quality::High {
            settings.savings = settings.savings.exact();
        }
        settings
    }
}
