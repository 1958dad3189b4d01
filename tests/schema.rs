//! The published schemas are those of the types, and they describe what the samples say.
//!
//! `BALAYAGE_WRITE_SAMPLES=1 cargo test --workspace --test suite published_schemas` writes them anew.

use std::fs;

use balayage::document::{json, project_schema, stroke_schema};
use balayage_tests::repository;
use serde_json::{Map, Value};

#[test]
fn published_schemas_are_those_of_the_types() {
    for (file, schema) in [
        ("projects/project.schema.json", project_schema()),
        ("projects/strokes.schema.json", stroke_schema()),
    ] {
        let (path, text) = (repository(file), json::to_text(&schema).unwrap());
        if std::env::var_os("BALAYAGE_WRITE_SAMPLES").is_some() {
            fs::write(&path, &text).unwrap();
        }
        let published = fs::read_to_string(&path).unwrap();
        assert!(
            published == text,
            "{file} is stale: BALAYAGE_WRITE_SAMPLES=1 writes it anew"
        );
    }
}

/// Keys of `value` that no branch of `schema` names, with their places.
fn undescribed(schema: &Value, root: &Value, value: &Value, place: &str, found: &mut Vec<String>) {
    let branches = branches(schema, root);
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                let place = format!("{place}.{key}");
                let known: Vec<&Value> = branches
                    .iter()
                    .filter_map(|branch| branch.get("properties")?.get(key))
                    .collect();
                let is_map = branches
                    .iter()
                    .any(|branch| branch.get("additionalProperties").is_some_and(Value::is_object));
                match known.as_slice() {
                    [] if is_map => {}
                    [] => found.push(place),
                    // Of several branches one has to describe all of it.
                    known => {
                        let misses = known.iter().map(|schema| {
                            let mut missed = Vec::new();
                            undescribed(schema, root, value, &place, &mut missed);
                            missed
                        });
                        found.extend(misses.min_by_key(Vec::len).unwrap_or_default());
                    }
                }
            }
        }
        Value::Array(values) => {
            let items = branches.iter().find_map(|branch| branch.get("items"));
            if let Some(items) = items {
                for (i, value) in values.iter().enumerate() {
                    undescribed(items, root, value, &format!("{place}[{i}]"), found);
                }
            }
        }
        _ => {}
    }
}

/// The schema, what it refers to, and what it combines.
fn branches<'a>(schema: &'a Value, root: &'a Value) -> Vec<&'a Map<String, Value>> {
    let Some(object) = schema.as_object() else {
        return Vec::new();
    };
    let mut all = vec![object];
    if let Some(reference) = object.get("$ref").and_then(Value::as_str) {
        let pointer = reference.trim_start_matches('#');
        all.extend(branches(root.pointer(pointer).unwrap(), root));
    }
    for key in ["allOf", "anyOf", "oneOf"] {
        for branch in object.get(key).and_then(Value::as_array).into_iter().flatten() {
            all.extend(branches(branch, root));
        }
    }
    all
}

#[test]
fn schemas_describe_the_samples() {
    let (project, strokes) = (project_schema().to_value(), stroke_schema().to_value());
    let check = |schema: &Value, value: &Value| {
        let mut found = Vec::new();
        undescribed(schema, schema, value, "", &mut found);
        found
    };
    let cases = [
        ("projects/curly.json", &project),
        ("projects/long-straight.json", &project),
        ("projects/wavy-bob.json", &project),
        ("projects/demo.json", &project),
        ("projects/older/version-1.json", &project),
        ("projects/strokes/demo.json", &strokes),
        ("projects/strokes/salon.json", &strokes),
    ];
    for (file, schema) in cases {
        let text = fs::read_to_string(repository(file)).unwrap();
        let mut value: Value = serde_json::from_str(&text).unwrap();
        let found = check(schema, &value);
        assert!(found.is_empty(), "{file}: {found:?}");

        // A key that no type has is noticed, deep inside as well.
        let operation = value.pointer_mut("/operations/0").and_then(Value::as_object_mut);
        let wrong = 1 + operation.iter().count();
        operation.map(|operation| operation.insert("stength".to_owned(), 1.into()));
        value["novel"] = 1.into();
        assert_eq!(check(schema, &value).len(), wrong, "{file}");
    }
}
