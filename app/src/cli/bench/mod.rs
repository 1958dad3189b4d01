//! `balayage bench`: run time against error, one file a benchmark. Times compare what one run on one machine measured.

mod end_to_end;
mod frame;
mod furnace;
mod generated;
mod light_steps;
mod lights;
mod load;
mod methods;
mod paint;
mod picture;
mod plot;
mod report;
mod scatter;
mod stress;
mod volume;
mod volume_build;
mod volume_drawing;

use clap::{Args, Subcommand};

use super::{CliError, Console};

#[derive(Args)]
pub(super) struct BenchArgs {
    #[command(subcommand)]
    what: Bench,
}

#[derive(Subcommand)]
enum Bench {
    /// Single scattering: schemes and quality levels against the float64 reference.
    Scatter(scatter::ScatterArgs),
    /// Environment maps: hair error of SRBF lights and of spherical harmonics.
    Lights(lights::LightsArgs),
    /// The frame: what each edit costs, what each saving saves, how cost grows.
    Frame(frame::FrameArgs),
    /// From a file of many strands to a painted, saved picture: seconds and bytes.
    Load(load::LoadArgs),
    /// Painting: milliseconds and work of each step from the pointer to the picture.
    Paint(paint::PaintArgs),
    /// The picture, first frame and refined, against path tracing.
    Picture(Box<picture::PictureArgs>),
    /// The hair volume: visibility against exact rays, building and painting; strands drawn in two ways.
    Volume(volume::VolumeArgs),
    /// White hair in uniform light, from the surface of a ball to its middle.
    Furnace(furnace::FurnaceArgs),
    /// Edges of every range and poison values through the scattering shaders.
    Stress(stress::StressArgs),
}

pub(super) fn run(args: &BenchArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    match &args.what {
        Bench::Scatter(args) => scatter::run(args, console),
        Bench::Lights(args) => lights::run(args, console),
        Bench::Frame(args) => frame::run(args, console),
        Bench::Load(args) => load::run(args, console),
        Bench::Paint(args) => paint::run(args, console),
        Bench::Picture(args) => picture::run(args, console),
        Bench::Volume(args) => volume::run(args, console),
        Bench::Furnace(args) => furnace::run(args, console),
        Bench::Stress(args) => stress::run(args, console),
    }
}
