//! Environments that change: which files, in which order.

use std::path::{Path, PathBuf};

use super::InputError;
use super::error::Refusal;

/// The maps (.hdr, .exr) of a folder in the order of their names, where "2" comes before "10".
///
/// # Errors
/// [`InputError`] where the folder cannot be read or holds no map.
pub fn frames(folder: &Path) -> Result<Vec<PathBuf>, InputError> {
    let refused = |reason: String| {
        Refusal::new(
            "whole folder",
            reason,
            "name a folder of numbered .hdr or .exr maps",
        )
        .of(folder)
    };
    let entries = std::fs::read_dir(folder).map_err(|error| refused(error.to_string()))?;
    let mut files = Vec::new();
    for entry in entries {
        let path = entry.map_err(|error| refused(error.to_string()))?.path();
        let extension = path.extension().and_then(|text| text.to_str());
        if extension.is_some_and(|text| {
            ["hdr", "exr"]
                .iter()
                .any(|known| text.eq_ignore_ascii_case(known))
        }) {
            files.push(path);
        }
    }
    if files.is_empty() {
        return Err(refused("it holds no environment map".to_owned()));
    }
    files.sort_by_cached_key(|path| natural_key(&path.to_string_lossy()));
    Ok(files)
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
