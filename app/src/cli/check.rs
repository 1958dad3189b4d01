//! `balayage check`: reads anything and says what is in it.

use std::path::{Path, PathBuf};

use balayage_render::{
    groom::{Mesh, read_painted_groom},
    light::{EnvironmentMap, LightSet},
};
use clap::Args;
use serde_json::{Value, json};

use super::{CliError, Console, groom_options::GroomOptions};
use crate::{
    Problem,
    document::{
        CameraPose, Environment, MAX_PROJECT_BYTES, UserState, check_camera, files, map_warnings, recover,
    },
    paint::StrokeFile,
};

#[derive(Args)]
pub(super) struct CheckArgs {
    /// Project, groom, strokes, lights, camera, environment map or head.
    file: PathBuf,
    #[command(flatten)]
    groom: GroomOptions,
}

pub(super) fn run(args: &CheckArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let file = args.file.as_path();
    let extension = file
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    let (value, text) = match extension.as_str() {
        "json" => check_json(file, &args.groom, console)?,
        "hair" | "tfx" | "usd" | "usda" | "usdc" | "abc" => {
            let (loaded, _) = read_painted_groom(file, args.groom.read())?;
            let value = json!({"kind": "groom", "groom": loaded.report, "hash": loaded.groom.content_hash()});
            (value, format!("groom, {}", loaded.report))
        }
        "hdr" | "exr" => {
            let (map, report) = EnvironmentMap::read(file).map_err(Problem::from)?;
            for warning in map_warnings(&report, file) {
                console.warn(&warning);
            }
            let value = json!({"kind": "environment", "width": map.width, "height": map.height});
            (
                value,
                format!("environment map, {} x {} pixels", map.width, map.height),
            )
        }
        "obj" => {
            let mesh = Mesh::read_obj(file)?;
            let (vertices, triangles) = (mesh.positions().len(), mesh.triangles().len());
            let value = json!({"kind": "head", "vertices": vertices, "triangles": triangles});
            (value, format!("head, {vertices} vertices, {triangles} triangles"))
        }
        _ => {
            let remedy = "check files that end in .json, .hair, .tfx, .usda, .usdc, .abc, .hdr, .exr or .obj";
            return Err(Problem::at("", "the extension names no known format", remedy)
                .in_file(file)
                .into());
        }
    };
    let mut value = value;
    value["file"] = json!(file);
    Ok(console.result(value, &format!("{}: {text}", file.display()))?)
}

/// Tells of edits that a crash left in journals of a project.
fn recovery_of(file: &Path, console: &mut Console<'_>) -> Vec<Value> {
    let journals = recover::journals_of(Some(file), UserState::of_user().folder());
    let summaries = journals
        .iter()
        .filter_map(|contents| recover::summary(contents, Some(file)));
    summaries
        .map(|summary| {
            console.warn(&format!(
                "{}: {summary}; recover them with `balayage recover` or in the editor",
                summary.journal.display()
            ));
            super::recover::to_json(&summary)
        })
        .collect()
}

/// A JSON file is told by its keys.
fn check_json(
    file: &Path,
    options: &GroomOptions,
    console: &mut Console<'_>,
) -> Result<(Value, String), CliError> {
    let text = files::read_text(file, MAX_PROJECT_BYTES)?;
    let keys: serde_json::Map<String, Value> =
        serde_json::from_str(&text).map_err(|e| Problem::json(&e).in_file(file))?;
    if keys.get("groom").is_some_and(Value::is_object) {
        drop((keys, text));
        let document = super::open(file, options, console)?;
        let project = document.project();
        let (layers, operations) = (project.layers.len(), project.operations.len());
        let (strands, points) = (document.groom().strand_count(), document.groom().point_count());
        let hand_lights = project.light.hand.len();
        let environment = match &project.light.environment {
            Environment::Sky => "sky",
            Environment::Preset(_) => "preset",
            Environment::Constant(_) => "constant",
            Environment::Map(_) => "map",
            Environment::Lights(_) => "lights",
            Environment::Sequence(_) => "sequence",
        };
        let light_files = document.light_files();
        for file in light_files.iter().filter(|file| !file.exists()) {
            console.warn(&format!(
                "{}: the project's light names it, but it is not there; restore it or choose another light",
                file.display()
            ));
        }
        let journals = recovery_of(file, console);
        let value = json!({
            "kind": "project", "journals": journals, "version": project.version, "layers": layers, "operations": operations,
            "strands": strands, "points": points,
            "light": {"environment": environment, "files": light_files.len(), "hand_lights": hand_lights},
        });
        let text = format!(
            "project, {strands} strands, {points} points, {layers} layers, {operations} operations, light: {environment}, {} files, \
             {hand_lights} lights by hand",
            light_files.len()
        );
        return Ok((value, text));
    }
    if keys.contains_key("operations") {
        let strokes = StrokeFile::parse(&text).map_err(|p| p.in_file(file))?;
        let dabs: usize = strokes
            .operations
            .iter()
            .map(|operation| operation.dabs.len())
            .sum();
        let value = json!({"kind": "strokes", "operations": strokes.operations.len(), "dabs": dabs});
        return Ok((
            value,
            format!("strokes, {} operations, {dabs} dabs", strokes.operations.len()),
        ));
    }
    if keys.contains_key("world_from_camera") {
        let camera: CameraPose = serde_json::from_str(&text).map_err(|e| Problem::json(&e).in_file(file))?;
        check_camera(&camera).map_err(|p| p.in_file(file))?;
        let value = json!({"kind": "camera", "fov_y_deg": camera.fov_y_deg});
        return Ok((
            value,
            format!("camera, field of view {} degrees", camera.fov_y_deg),
        ));
    }
    if keys.contains_key("lights") || keys.contains_key("constant") {
        let lights = LightSet::from_json(&text, file).map_err(Problem::from)?;
        let value = json!({"kind": "lights", "lights": lights.lights.len(), "constant": lights.constant});
        return Ok((value, format!("{} lights", lights.lights.len())));
    }
    let remedy = "a project has \"groom\", strokes have \"operations\", lights \"lights\", a camera \"world_from_camera\"";
    Err(Problem::at("top level", "the keys name no known file", remedy)
        .in_file(file)
        .into())
}
