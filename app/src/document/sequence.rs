//! Which files make a sequence of environment maps.

use std::path::PathBuf;

use balayage_render::light::frames;

use crate::Problem;

/// Sequences of more maps than this are refused.
pub const MAX_MAPS: usize = 10_000;

/// The maps of a sequence: those in a folder, in the order of their names where "2" comes before "10", or the files themselves.
///
/// # Errors
/// A folder that cannot be read or holds no map, more than [`MAX_MAPS`] maps.
pub fn maps_of(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Problem> {
    let mut maps = Vec::new();
    for path in paths {
        if path.is_dir() {
            maps.extend(frames(path).map_err(Problem::from)?);
        } else {
            maps.push(path.clone());
        }
    }
    if maps.len() > MAX_MAPS {
        let reason = format!("{} maps in one sequence", maps.len());
        let remedy = format!("choose at most {MAX_MAPS}");
        return Err(Problem::at("", reason, remedy));
    }
    Ok(maps)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_folder_gives_its_maps_as_a_person_counts() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["sky-10.hdr", "sky-9.HDR", "sky-1.exr", "notes.txt"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let names = |paths: &[PathBuf]| -> Vec<String> {
            let name = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
            maps_of(paths).unwrap().iter().map(name).collect()
        };
        let expected = ["sky-1.exr", "sky-9.HDR", "sky-10.hdr"];
        assert_eq!(names(&[folder.path().to_owned()]), expected);
        assert_eq!(names(&["b.hdr".into(), "a.hdr".into()]), ["b.hdr", "a.hdr"]);
        let empty = tempfile::tempdir().unwrap();
        assert!(maps_of(&[empty.path().to_owned()]).is_err());
    }
}
