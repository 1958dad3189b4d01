//! `--wedge NAME=A.json,B.json`: the same picture once for every file.

use std::{path::PathBuf, str::FromStr};

use serde_json::Value;

use super::CliError;
use crate::{
    Problem,
    document::{MAX_PROJECT_BYTES, Project, files},
    paint::StrokeFile,
};

/// A wedge: its name and the files that take turns.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wedge {
    name: String,
    files: Vec<PathBuf>,
}

impl FromStr for Wedge {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let usage = || "write NAME=A.json,B.json".to_owned();
        let (name, files) = text.split_once('=').ok_or_else(usage)?;
        let files: Vec<PathBuf> = files.split(',').map(PathBuf::from).collect();
        let word = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_');
        if name.is_empty() || !name.chars().all(word) || files.iter().any(|file| file.as_os_str().is_empty())
        {
            return Err(usage());
        }
        Ok(Self {
            name: name.to_owned(),
            files,
        })
    }
}

/// Every choice of one file of each wedge, the last wedge turning fastest; one empty choice without wedges.
pub(super) fn choices(wedges: &[Wedge]) -> Vec<Vec<(String, PathBuf)>> {
    wedges.iter().fold(vec![Vec::new()], |choices, wedge| {
        let longer = |choice: &Vec<(String, PathBuf)>| {
            let choice = choice.clone();
            let files = wedge.files.iter().cloned();
            files
                .map(|file| [choice.clone(), vec![(wedge.name.clone(), file)]].concat())
                .collect::<Vec<_>>()
        };
        choices.iter().flat_map(longer).collect()
    })
}

/// The project with the files of a choice: a stroke file's operations are added, any other file's fields replace the project's.
///
/// # Errors
/// A file that is refused, and what it makes of the project where that is.
pub(super) fn varied(project: &Project, choice: &[(String, PathBuf)]) -> Result<Project, CliError> {
    let mut project = project.clone();
    for (_, file) in choice {
        let text = files::read_text(file, MAX_PROJECT_BYTES)?;
        let patch: Value = serde_json::from_str(&text).map_err(|e| Problem::json(&e).in_file(file))?;
        if !patch.is_object() {
            let remedy = "write the fields of a project that differ, as {\"hair\": {\"base\": {\"bleach\": 0.5}}}, or a stroke file";
            return Err(Problem::at("top level", "this is no object", remedy)
                .in_file(file)
                .into());
        }
        if patch.get("operations").is_some() {
            let strokes = StrokeFile::parse(&text).map_err(|p| p.in_file(file))?;
            project.operations.extend(strokes.operations);
            project.add_missing_layers();
        } else {
            let failed = |e: serde_json::Error| Problem::json(&e).in_file(file);
            let mut tree = serde_json::to_value(&project).map_err(failed)?;
            merge(&mut tree, patch);
            project = Project::parse(&tree.to_string()).map_err(|p| p.in_file(file))?;
        }
    }
    Ok(project)
}

/// JSON merge patch, RFC 7386: fields of objects are merged, null removes, all else replaces.
fn merge(target: &mut Value, patch: Value) {
    let Value::Object(fields) = patch else {
        *target = patch;
        return;
    };
    if !target.is_object() {
        *target = Value::Object(serde_json::Map::new());
    }
    if let Value::Object(map) = target {
        for (key, value) in fields {
            if value.is_null() {
                map.remove(&key);
            } else {
                merge(map.entry(key).or_insert(Value::Null), value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn wedges_multiply() {
        let wedge = |text: &str| text.parse::<Wedge>().unwrap();
        assert_eq!(choices(&[]), [vec![]]);
        let all = choices(&[wedge("a=x.json,y.json"), wedge("b=1.json,2.json,3.json")]);
        assert_eq!(all.len(), 6);
        assert_eq!(
            all[4],
            [
                ("a".to_owned(), "y.json".into()),
                ("b".to_owned(), "2.json".into())
            ]
        );
        for text in ["", "a", "=x.json", "a=", "a=x.json,", "a/b=x.json"] {
            assert!(text.parse::<Wedge>().is_err(), "{text}");
        }
    }

    #[test]
    fn merge_patches_as_the_rfc_says() {
        // Cases of RFC 7386, appendix A.
        for (target, patch, expected) in [
            (json!({"a": "b"}), json!({"a": "c"}), json!({"a": "c"})),
            (json!({"a": "b", "b": "c"}), json!({"a": null}), json!({"b": "c"})),
            (
                json!({"a": {"b": "c"}}),
                json!({"a": {"b": "d", "c": null}}),
                json!({"a": {"b": "d"}}),
            ),
            (json!(["a", "b"]), json!(["c"]), json!(["c"])),
            (json!([1, 2]), json!({"a": "b", "c": null}), json!({"a": "b"})),
            (
                json!({}),
                json!({"a": {"bb": {"ccc": null}}}),
                json!({"a": {"bb": {}}}),
            ),
        ] {
            let mut tree = target;
            merge(&mut tree, patch);
            assert_eq!(tree, expected);
        }
    }
}
