//! `balayage relink`: a project whose groom, head or light was moved.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::{CliError, Console};
use crate::{
    Problem,
    document::{
        MAX_PROJECT_BYTES, Project, UserState, files, json as project_json,
        relink::{self, Role},
    },
};

#[derive(Args)]
pub(super) struct RelinkArgs {
    /// Project whose files are not where it says.
    project: PathBuf,
    /// The groom; files that are not named are searched by their content, beside the project and in recent folders.
    #[arg(long, value_name = "FILE")]
    groom: Option<PathBuf>,
    /// The environment map or light list.
    #[arg(long, value_name = "FILE")]
    env: Option<PathBuf>,
    /// The head.
    #[arg(long, value_name = "FILE")]
    head: Option<PathBuf>,
    /// Project to write instead of the one that is relinked.
    #[arg(short, long, value_name = "OUT.json")]
    output: Option<PathBuf>,
}

pub(super) fn run(args: &RelinkArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let path = args.project.as_path();
    let folder = path.parent().unwrap_or(Path::new(""));
    let text = files::read_text(path, MAX_PROJECT_BYTES)?;
    let mut project = Project::parse(&text).map_err(|p| p.in_file(path))?;

    let named = [
        (Role::Groom, &args.groom),
        (Role::Head, &args.head),
        (Role::Light, &args.env),
    ];
    let mut linked = Vec::new();
    for (role, file) in named {
        let Some(file) = file else { continue };
        let note = relink::set_file(&mut project, folder, role, file)?;
        note.iter().for_each(|note| console.warn(note));
        linked.push((role, file.clone()));
    }
    let state = UserState::of_user();
    let (moved, missing) = relink::find_moved(&mut project, folder, state.recent_folders());
    linked.extend(moved.into_iter().map(|moved| (moved.role, moved.to)));
    for missing in &missing {
        console.warn(&format!(
            "{}: the {} is not there, and no file near the project has its content",
            missing.path.display(),
            missing.role.name()
        ));
    }
    if linked.is_empty() && !missing.is_empty() {
        let remedy = "say where they are with --groom, --env or --head";
        return Err(Problem::at("", "nothing was found", remedy).in_file(path).into());
    }

    // The project's other words stay as they are: only its paths are new.
    let output = args.output.as_deref().unwrap_or(path);
    if !linked.is_empty() || output != path {
        let _lock = super::recover::lock(output)?;
        let target = output.parent().unwrap_or(Path::new(""));
        project.map_paths(|reference| match reference.starts_with("builtin:") {
            true => reference.to_owned(),
            false => files::relative(&files::resolve(reference, folder), target),
        });
        let text = project_json::to_text(&project)
            .map_err(|e| Problem::at("", e.to_string(), "report this as a bug").in_file(output))?;
        files::write_atomic(output, text.as_bytes())?;
    }
    let linked_json: Vec<_> = linked
        .iter()
        .map(|(role, file)| json!({"role": role.name(), "file": file}))
        .collect();
    let missing_json: Vec<_> = missing
        .iter()
        .map(|missing| json!({"role": missing.role.name(), "file": missing.path}))
        .collect();
    let value = json!({"output": output, "linked": linked_json, "missing": missing_json});
    let names: Vec<String> = linked
        .iter()
        .map(|(role, file)| format!("{} is {}", role.name(), file.display()))
        .collect();
    let text = match names.as_slice() {
        [] => "every file is where the project says".to_owned(),
        names => names.join(", "),
    };
    Ok(console.result(value, &format!("{}: {text}", output.display()))?)
}
