//! The frame: what is stale is brought up to date, in the order of the crate's front page, then drawn.

use std::ops::Range;
use std::time::Instant;

use glam::Vec3;
use serde::Serialize;

use super::camera::{Camera, CameraUniform};
use super::head::{HeadBuffers, HeadPass, HeadTarget};
use super::raster::{PictureBuffers, Raster, ResolveUniform, SolidInputs};
use super::shade::{ShadePass, ShadeSettings};
use super::strands::StrandBuffers;
use super::view::{ViewPass, ViewTransform};
use super::{Gpu, GpuError};
use crate::groom::{Groom, Mesh, RefinedGroom};
use crate::image::Picture;
use crate::light::{EnvironmentMap, LightSet};
use crate::param::{LobeRatios, VertexParams};

/// Largest turn of the tangent between two shaded points, radians (4 degrees).
const MAX_TURN_RAD: f32 = 4.0 * std::f32::consts::PI / 180.0;

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
        }
    }
}

/// What a frame cost.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FrameReport {
    /// Passes that ran and their milliseconds, wall clock with the GPU waited for.
    pub passes: Vec<(String, f64)>,
    /// Named work counters.
    pub counters: Vec<(String, u64)>,
}

impl FrameReport {
    fn time<T>(&mut self, gpu: &Gpu, pass: &str, run: impl FnOnce(&mut Self) -> Result<T, GpuError>) -> Result<T, GpuError> {
        let start = Instant::now();
        let result = run(self)?;
        gpu.wait()?;
        self.passes.push((pass.to_owned(), start.elapsed().as_secs_f64() * 1e3));
        Ok(result)
    }

    fn count(&mut self, name: &str, value: u64) {
        self.counters.push((name.to_owned(), value));
    }

    /// The counter of that name, 0 where the work was not done.
    pub fn counter(&self, name: &str) -> u64 {
        self.counters.iter().filter(|(n, _)| n == name).map(|(_, v)| v).sum()
    }
}
