//! Which files make a sequence of environment maps.

use std::{
    fs,
    path::{Path, PathBuf},
};

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
            maps.extend(maps_in(path)?);
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

fn maps_in(folder: &Path) -> Result<Vec<PathBuf>, Problem> {
    let failed = |e: std::io::Error| Problem::io(folder, "reading the folder", &e);
    let mut maps = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        if extension == "hdr" || extension == "exr" {
            maps.push(path);
        }
    }
    if maps.is_empty() {
        let remedy = "choose a folder of .hdr or .exr maps";
        return Err(Problem::at("", "the folder holds no environment map", remedy).in_file(folder));
    }
    maps.sort_by_cached_key(|path| natural_key(&path.to_string_lossy()));
    Ok(maps)
}

/// Text and numbers in turn, so that names compare as a person counts; the name itself breaks ties.
fn natural_key(name: &str) -> (Vec<(String, u128)>, String) {
    let mut parts = Vec::new();
    let mut rest = name;
    while !rest.is_empty() {
        let digits_at = rest.find(|c: char| c.is_ascii_digit()).unwrap_or(rest.len());
        let (text, tail) = rest.split_at(digits_at);
        let digits = tail.find(|c: char| !c.is_ascii_digit()).unwrap_or(tail.len());
        let (number, tail) = tail.split_at(digits);
        parts.push((text.to_owned(), number.parse().unwrap_or(0)));
        rest = tail;
    }
    (parts, name.to_owned())
}

#[cfg(test)]
mod tests {
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
