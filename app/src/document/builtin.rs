//! Files inside the program: what `builtin:` names in a project.

use std::path::Path;

use balayage_render::light::EnvironmentMap;

use crate::Problem;

/// A path of a project that starts like this names a file inside the program.
const PREFIX: &str = "builtin:";

const FILES: &[(&str, &[u8])] = &[
    (
        "grooms/wavy-bob.hair",
        include_bytes!("../../../projects/grooms/wavy-bob.hair"),
    ),
    (
        "environments/city.hdr",
        include_bytes!("../../../projects/environments/city.hdr"),
    ),
    (
        "environments/studio.hdr",
        include_bytes!("../../../projects/environments/studio.hdr"),
    ),
    (
        "environments/sunrise.hdr",
        include_bytes!("../../../projects/environments/sunrise.hdr"),
    ),
    ("head.obj", include_bytes!("../../../projects/head.obj")),
];

/// The bytes that `reference` names, if it names a file inside the program that exists.
pub(super) fn bytes(reference: &str) -> Option<&'static [u8]> {
    let name = reference.strip_prefix(PREFIX)?;
    FILES
        .iter()
        .find(|(file, _)| *file == name)
        .map(|(_, bytes)| *bytes)
}

/// `path` of a project beside the built-in files, as a reference to the built-in file where there is one.
pub(super) fn reference_to(path: &str) -> String {
    let builtin = format!("{PREFIX}{path}");
    if bytes(&builtin).is_some() {
        builtin
    } else {
        path.to_owned()
    }
}

/// The text of the sample project.
pub(super) const SAMPLE: &str = include_str!("../../../projects/wavy-bob.json");

/// The environment maps inside the program, by name.
///
/// # Errors
/// A map that is refused, which a test rules out.
pub fn builtin_environments() -> Result<Vec<(String, EnvironmentMap)>, Problem> {
    let named = FILES.iter().filter_map(|(file, bytes)| {
        let name = file.strip_prefix("environments/")?.strip_suffix(".hdr")?;
        Some((name, bytes))
    });
    named
        .map(|(name, bytes)| {
            let (map, _) = EnvironmentMap::from_bytes(bytes, Path::new(name)).map_err(Problem::from)?;
            Ok((name.to_owned(), map))
        })
        .collect()
}
