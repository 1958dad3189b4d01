//! What single points of the hair send out, whether a camera sees them or not.

use glam::Vec3;

use super::{Changes, FrameReport, RenderSettings, Renderer, Saving};
use crate::gpu::GpuError;
use crate::gpu::shade::ShadeInputs;

impl Renderer {
    /// Scene-linear radiance that groom `points` send towards `eye`, a world position; nothing that lies between counts.
    ///
    /// # Errors
    /// [`GpuError::Refused`] without a groom or for a point that it does not have, [`GpuError::TooLarge`], [`GpuError::Lost`].
    pub fn radiance_of_points(
        &mut self,
        points: &[u32],
        eye: Vec3,
        settings: &RenderSettings,
    ) -> Result<Vec<Vec3>, GpuError> {
        self.changes = Changes::ALL;
        self.take_lights(settings, &mut FrameReport::default())?;
        let gpu = self.gpu.clone();
        let refused = |reason: String| GpuError::Refused {
            what: "the radiance of points".to_owned(),
            reason,
        };
        let scene = self
            .scene
            .as_ref()
            .ok_or_else(|| refused("no groom was given".to_owned()))?;
        if let Some(point) = points.iter().find(|&&point| point as usize >= scene.point_count) {
            return Err(refused(format!("the groom has no point {point}")));
        }

        // The next picture wants other vertices and sees them from elsewhere.
        self.raster.forget();
        self.last = None;
        let strands = &scene.strands;
        strands.forget_shading(&gpu);
        let vertex_of: Vec<u32> = gpu.read(&strands.point_vertices, scene.point_count)?;
        let mut wanted_points = vec![0_u32; scene.point_count];
        let mut wanted_vertices = vec![0_u32; strands.vertex_count as usize];
        for &point in points {
            // A vertex at a point interpolates towards the next one by nothing, but reads it.
            wanted_points[point as usize] = 1;
            wanted_points[(point as usize + 1).min(scene.point_count - 1)] = 1;
            wanted_vertices[vertex_of[point as usize] as usize] = 1;
        }
        for (buffer, flags) in [
            (&strands.wanted_points, &wanted_points),
            (&strands.wanted_vertices, &wanted_vertices),
        ] {
            gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(flags));
        }

        self.transmittance.set_model(&gpu, settings.shade.method.model)?;
        self.transmittance
            .set_visibility_source(&gpu, settings.shade.visibility)?;
        self.transmittance.want_path_sums(settings.shade.sums_ways());
        self.transmittance.update(
            &gpu,
            Some(&strands.wanted_points),
            false,
            settings.visibility_rays,
        )?;
        if settings.shade.is_traced() {
            self.scattered.set_lights(&self.lights.lights);
            self.scattered.update(&gpu, settings, None)?;
        }
        let inputs = ShadeInputs {
            camera_position: eye,
            params: &scene.params,
            has_elliptic: scene.has_elliptic,
            lights: &self.lights.buffer,
            real_light_count: self.lights.real_count(),
            constant: self.lights.constant(),
            transmittance: &self.transmittance,
            field: self.scattered.buffers(),
            // The points are wanted themselves, whatever they lie between.
            savings: settings.savings.without(Saving::Straight),
            frame: self.frame,
            interrupt: None,
        };
        self.shade.run(&gpu, &settings.shade, strands, &inputs)?;
        let radiance: Vec<[f32; 4]> = gpu.read(&strands.radiance, strands.vertex_count as usize)?;
        Ok(points
            .iter()
            .map(|&point| {
                let [r, g, b, _] = radiance[vertex_of[point as usize] as usize];
                self.lights.gain * Vec3::new(r, g, b)
            })
            .collect())
    }
}
