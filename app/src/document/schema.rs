//! The JSON schemas of the files that people and other programs write: made from the types that read them.

use schemars::{Schema, schema_for};

use super::Project;
use crate::paint::StrokeFile;

/// The schema of a project file. It describes form, not ranges: `balayage check` tells those.
pub fn project_schema() -> Schema {
    titled(schema_for!(Project), "Balayage project")
}

/// The schema of a stroke file.
pub fn stroke_schema() -> Schema {
    titled(schema_for!(StrokeFile), "Balayage strokes")
}

fn titled(mut schema: Schema, title: &str) -> Schema {
    schema.insert("title".to_owned(), title.into());
    schema
}
