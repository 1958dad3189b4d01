//! Names of pictures: the frame's number stands for `####`, the file of a wedge for `{NAME}`.

use std::{
    collections::HashSet,
    path::{Path, PathBuf},
};

use super::CliError;

/// Digits of a frame's number where the name has no `#`.
const USUAL_DIGITS: usize = 4;

/// What the extension of the output asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Format {
    /// As seen on a display.
    Png,
    /// Scene-linear.
    Exr,
}

impl Format {
    pub(super) fn of(path: &Path) -> Result<Self, CliError> {
        let extension = path
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_ascii_lowercase();
        match extension.as_str() {
            "png" => Ok(Self::Png),
            "exr" => Ok(Self::Exr),
            _ => Err(CliError::Usage(format!(
                "--output {}: the extension names no picture format; write .png or .exr",
                path.display()
            ))),
        }
    }
}

/// The picture of a frame and of a choice of wedge files (name of the wedge and file each).
///
/// A frame's number takes the place of the last run of `#`, as many digits as it is long; without one it goes before the extension with a
/// hyphen. A wedge's file, without folder and extension, takes the place of `{NAME}`; without that it goes before the number.
pub(super) fn picture(output: &Path, frame: Option<u32>, wedge: &[(String, PathBuf)]) -> PathBuf {
    let mut name = output
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    for (key, file) in wedge {
        let label = file.file_stem().unwrap_or_default().to_string_lossy();
        let place = format!("{{{key}}}");
        if name.contains(&place) {
            name = name.replace(&place, &label);
        } else {
            let number = hashes(&name).map(|run| run.start);
            let end = number.or_else(|| name.rfind('.')).unwrap_or(name.len());
            let end = name[..end].trim_end_matches(['.', '-', '_']).len();
            name.insert_str(end, &format!("-{label}"));
        }
    }
    if let Some(frame) = frame {
        match hashes(&name) {
            Some(run) => {
                let digits = run.len();
                name.replace_range(run, &format!("{frame:0digits$}"));
            }
            None => {
                let end = name.rfind('.').unwrap_or(name.len());
                name.insert_str(end, &format!("-{frame:0USUAL_DIGITS$}"));
            }
        }
    }
    output.with_file_name(name)
}

/// The last run of `#`.
fn hashes(name: &str) -> Option<std::ops::Range<usize>> {
    let end = name.rfind('#')? + 1;
    Some(name[..end].trim_end_matches('#').len()..end)
}

/// Refuses pictures that would be written over each other.
pub(super) fn check_distinct<'a>(mut pictures: impl Iterator<Item = &'a PathBuf>) -> Result<(), CliError> {
    let mut seen = HashSet::new();
    match pictures.find(|picture| !seen.insert(*picture)) {
        None => Ok(()),
        Some(picture) => Err(CliError::Usage(format!(
            "--wedge: two files lead to one picture, {}; give the files different names",
            picture.display()
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_wedges_have_their_places() {
        let wedge = [("dye".to_owned(), PathBuf::from("looks/rose.json"))];
        for (output, frame, wedge, expected) in [
            ("out/f.####.exr", Some(7), &wedge[..0], "out/f.0007.exr"),
            ("f##.png", Some(123), &wedge[..0], "f123.png"),
            ("out/f.png", Some(7), &wedge[..0], "out/f-0007.png"),
            ("f.png", None, &wedge[..], "f-rose.png"),
            ("f.####.exr", Some(1), &wedge[..], "f-rose.0001.exr"),
            ("####.exr", Some(1), &wedge[..], "-rose0001.exr"),
            ("{dye}/f.exr", None, &wedge[..0], "{dye}/f.exr"),
            ("f_{dye}_###.exr", Some(12), &wedge[..], "f_rose_012.exr"),
        ] {
            assert_eq!(
                picture(Path::new(output), frame, wedge),
                Path::new(expected),
                "{output}"
            );
        }
        let twice = [PathBuf::from("a.png"), PathBuf::from("a.png")];
        assert!(check_distinct(twice.iter()).is_err() && check_distinct(twice[..1].iter()).is_ok());
    }
}
