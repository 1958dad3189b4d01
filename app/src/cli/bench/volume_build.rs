//! What building a density volume and painting in it costs, in seconds and in work.

use std::time::Instant;

use balayage_render::gpu::{Gpu, MeanFibre, Transmittance};
use balayage_render::groom::{GeneratorSettings, Groom, HairStyle, Mesh, generate};
use balayage_render::param::{LobeRatios, PigmentSet, PointValues};
use balayage_render::volume::{Strands, VolumeSettings};

use super::plot::{Plot, Series};
use super::report::{Cell, Report, Table};
use crate::cli::{CliError, Console};
use crate::document::Document;

/// Strands of generated hair.
const STRANDS: [u32; 6] = [1_000, 2_000, 5_000, 10_000, 20_000, 50_000];
/// Points of a strand.
pub(super) const POINTS: u32 = 16;
/// Strands of the grooms that resolution and paint are varied on.
const MIDDLE: u32 = 10_000;
/// Voxel sizes in fibre spacings.
const SPACINGS: [f32; 5] = [0.75, 1.0, 1.25, 1.5, 2.0];
/// Size of the voxels that stays while strands are added, in those of the middle groom.
const FIXED_VOXEL: f32 = 2.0;
/// Shares of the strands that are painted.
const DIRTY: [f32; 5] = [0.001, 0.01, 0.1, 0.4, 1.0];

/// Adds the tables `build` and `paint` and their plot.
pub(super) fn measure(gpu: &Gpu, report: &mut Report, console: &mut Console<'_>) -> Result<(), CliError> {
    let head = Document::sample()?.document.load_head()?;
    let head =
        head.ok_or_else(|| CliError::Input("the built-in sample has no head: reinstall".to_owned()))?;
    report.notes.push(format!(
        "build: generated straight hair, {POINTS} points a strand, without its head; clipped and summed on the CPU, sent to the device"
    ));
    let progress = console.progress((STRANDS.len() + SPACINGS.len() + DIRTY.len()) as u64, "building");
    let mut table = Table::new(
        "build",
        [
            "strands",
            "voxel",
            "voxel size, mm",
            "seconds",
            "segments clipped",
            "parts",
            "voxels filled",
            "voxels stored",
            "MiB",
        ],
    );
    let mut transmittance = Transmittance::new(gpu)?;
    let mut row =
        |transmittance: &mut Transmittance, groom: &Groom, voxel: String, settings: &VolumeSettings| {
            let start = Instant::now();
            let volume = transmittance.set_strands(gpu, &Strands::from(groom), None, settings)?;
            gpu.wait()?;
            let seconds = start.elapsed().as_secs_f64();
            table.row([
                Cell::Count(groom.strand_count() as u64),
                voxel.into(),
                f64::from(volume.voxel_size * groom.metres_per_unit() * 1e3).into(),
                seconds.into(),
                Cell::Count(volume.segments as u64),
                Cell::Count(volume.shares as u64),
                Cell::Count(volume.filled_voxels as u64),
                Cell::Count(u64::from(volume.stored_voxels)),
                (volume.bytes as f64 / f64::from(1 << 20)).into(),
            ]);
            Ok::<_, CliError>((volume, seconds))
        };

    // One voxel size for all, so that only the strands differ.
    let middle = hair(MIDDLE, &head)?;
    let (usual, _) = row(
        &mut transmittance,
        &middle,
        "1.25 spacings".to_owned(),
        &VolumeSettings::default(),
    )?;
    let fixed = VolumeSettings {
        voxel_size: Some(FIXED_VOXEL * usual.voxel_size),
        ..VolumeSettings::default()
    };
    let mut points = Vec::new();
    for (step, strands) in STRANDS.into_iter().enumerate() {
        let groom = hair(strands, &head)?;
        let (_, seconds) = row(&mut transmittance, &groom, "fixed".to_owned(), &fixed)?;
        points.push((f64::from(strands), seconds));
        progress.at(step as u64 + 1);
    }
    for (step, voxel_spacings) in SPACINGS.into_iter().enumerate() {
        let settings = VolumeSettings {
            voxel_spacings,
            ..VolumeSettings::default()
        };
        row(
            &mut transmittance,
            &middle,
            format!("{voxel_spacings} spacings"),
            &settings,
        )?;
        progress.at((STRANDS.len() + step) as u64 + 1);
    }
    report.tables.push(table);
    report.plots.push(Plot {
        name: "build",
        title: "Building the volume, voxels of one size".to_owned(),
        x_label: "strands",
        y_label: "seconds",
        series: vec![Series {
            name: "generated hair".to_owned(),
            points,
        }],
    });

    let params = vec![
        PointValues::default().vertex_params(PigmentSet::default(), &LobeRatios::default());
        middle.point_count()
    ];
    let buffer = gpu.storage_of("parameters", &params)?;
    let mean = MeanFibre::of(&params);
    transmittance.set_strands(gpu, &Strands::from(&middle), None, &VolumeSettings::default())?;
    transmittance.set_params(&buffer, mean, &[]);
    transmittance.update(gpu, None, false, 0)?;
    let mut table = Table::new(
        "paint",
        ["strands painted", "points painted", "voxels painted", "ms"],
    );
    for (step, share) in DIRTY.into_iter().enumerate() {
        let strands = ((share * MIDDLE as f32) as usize).max(1);
        let dirty = 0..middle.first_point()[strands];
        let start = Instant::now();
        transmittance.set_params(&buffer, mean, std::slice::from_ref(&dirty));
        let done = transmittance.update(gpu, None, false, 0)?;
        gpu.wait()?;
        table.row([
            Cell::Count(strands as u64),
            Cell::Count(u64::from(dirty.end)),
            Cell::Count(done.painted_voxels),
            (1e3 * start.elapsed().as_secs_f64()).into(),
        ]);
        progress.at((STRANDS.len() + SPACINGS.len() + step) as u64 + 1);
    }
    report.tables.push(table);
    Ok(())
}

/// Generated straight hair of that many strands of [`POINTS`] points.
pub(super) fn hair(strand_count: u32, head: &Mesh) -> Result<Groom, CliError> {
    let settings = GeneratorSettings {
        strand_count,
        points_per_strand: POINTS,
        ..GeneratorSettings::new(HairStyle::Straight)
    };
    Ok(generate(&settings, head)?)
}
