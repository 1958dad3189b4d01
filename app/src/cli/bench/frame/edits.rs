//! What each kind of edit costs.

use balayage_render::gpu::{Camera, Quality, RenderSettings, Saving, Savings};
use balayage_render::light::SrbfLight;
use glam::Quat;

use super::super::report::{Cell, Table};
use super::{Bench, Cost};
use crate::cli::CliError;

/// Share of the strands and of the pixels' sides while the view moves.
const MOVING_SHARE: f32 = 0.25;

/// Passes and counters of the tables, with their units.
const PASSES: [&str; 6] = [
    "transmittance",
    "scattered light",
    "head shading",
    "strand shading",
    "strand drawing",
    "view",
];
const WORK: [&str; 10] = [
    "parameter bytes uploaded",
    "voxels painted",
    "visibility rays",
    "path rays",
    "photon rays",
    "vertices shaded",
    "single scattering evaluations",
    "multiple scattering evaluations",
    "hidden lights skipped",
    "fragments",
];

impl Bench {
    /// The camera turned about the hair.
    pub(super) fn orbited(&self, degrees: f32) -> Camera {
        let turn = Quat::from_rotation_y(degrees.to_radians());
        let eye = self.centre + turn * (self.camera.position() - self.centre);
        Camera::look_at(eye, self.centre, self.camera.fov_y_rad)
    }

    /// What each kind of edit costs.
    pub(super) fn edits(&mut self) -> Result<Vec<Table>, CliError> {
        let full = RenderSettings::default();
        let moving = RenderSettings {
            interactive: true,
            ..full
        };
        let mut draft = moving;
        draft.shade.method.quality = Quality::Draft;
        let everything = RenderSettings {
            savings: Savings::ALL.without(Saving::Untouched),
            ..full
        };
        let mut costs: Vec<(String, Cost)> = Vec::new();
        self.frame(&full)?;
        costs.push(("everything anew".into(), Cost::of(&[self.frame(&everything)?])));
        self.frame(&full)?;
        costs.push(("nothing".into(), self.cost(&full, |_, _| Ok(()))?));
        let mut ev = full;
        let mut reports = Vec::new();
        for k in 0..self.frames {
            ev.view_exposure_ev = 0.1 * (k + 1) as f32;
            reports.push(self.frame(&ev)?);
        }
        costs.push(("exposure of the display".into(), Cost::of(&reports)));
        self.frame(&full)?;
        let lights = self.lights.clone();
        let scaled = |k: u32| {
            let mut set = lights.clone();
            for light in &mut set.lights {
                light.radiance *= 1.0 + 0.1 * (k + 1) as f32;
            }
            set
        };
        costs.push((
            "exposure of the light".into(),
            self.cost(&full, |bench, k| {
                bench.renderer.set_lights(&scaled(k));
                Ok(())
            })?,
        ));
        let one = |k: u32, change: &dyn Fn(&mut SrbfLight, f32)| {
            let mut set = lights.clone();
            if let Some(light) = set.lights.first_mut() {
                change(light, (k + 1) as f32);
            }
            set
        };
        self.frame(&moving)?;
        costs.push((
            "colour of one light".into(),
            self.cost(&moving, |bench, k| {
                let set = one(k, &|light, k| light.radiance *= 1.0 + 0.1 * k);
                bench.renderer.set_lights(&set);
                Ok(())
            })?,
        ));
        costs.push((
            "one light moved".into(),
            self.cost(&moving, |bench, k| {
                let set = one(k, &|light, k| {
                    light.direction = Quat::from_rotation_y(0.05 * k) * light.direction;
                });
                bench.renderer.set_lights(&set);
                Ok(())
            })?,
        ));
        costs.push((
            "light turned by 3 degrees".into(),
            self.cost(&moving, |bench, k| {
                let turn = 3f32.to_radians() * (k + 1) as f32;
                bench.renderer.set_lights(&lights.rotated(turn));
                Ok(())
            })?,
        ));
        self.renderer.set_lights(&lights);
        self.frame(&full)?;
        self.frame(&draft)?;
        for share in [0.01, 0.05, 0.2] {
            costs.push((
                format!("dye on {:.0} % of the points, draft", 100.0 * share),
                self.cost(&draft, |bench, k| bench.dye(share, k))?,
            ));
        }
        self.frame(&full)?;
        let (camera, size) = (self.camera, self.size);
        for (name, settings, share) in [
            ("view turned by 3 degrees", full, 1.0),
            ("view turned by 1 degree, draft", draft, 1.0),
            (
                "the same with a quarter of strands and pixels",
                draft,
                MOVING_SHARE,
            ),
        ] {
            let settings = RenderSettings {
                strand_share: share,
                ..settings
            };
            if share < 1.0 {
                self.size = size.map(|side| side.div_ceil(2));
            }
            let step = if settings.interactive { 1.0 } else { 3.0 };
            self.frame(&settings)?;
            let cost = self.cost(&settings, |bench, _| {
                bench.camera = bench.orbited(step);
                Ok(())
            })?;
            costs.push((name.into(), cost));
            (self.camera, self.size) = (camera, size);
        }
        let columns = ["edit", "all ms"].into_iter().chain(PASSES);
        let mut times = Table::new("frame_ms", columns);
        let mut work = Table::new("frame_work", ["edit"].into_iter().chain(WORK));
        for (name, cost) in &costs {
            let passes = PASSES.map(|pass| Cell::Number(cost.pass(pass)));
            times.row(
                [Cell::from(name.as_str()), cost.total().into()]
                    .into_iter()
                    .chain(passes),
            );
            let counts = WORK.map(|counter| Cell::Count(cost.report.counter(counter)));
            work.row([Cell::from(name.as_str())].into_iter().chain(counts));
        }
        Ok(vec![times, work])
    }
}
