//! The parts of which schemas are built.

use serde_json::{Map, Value, json};

/// A value of a kind.
pub fn plain(kind: &str, description: &str) -> Value {
    match description.is_empty() {
        true => json!({ "type": kind }),
        false => json!({ "type": kind, "description": description }),
    }
}

pub fn text(description: &str) -> Value {
    plain("string", description)
}

pub fn number(description: &str) -> Value {
    plain("number", description)
}

pub fn count(description: &str) -> Value {
    plain("integer", description)
}

pub fn flag(description: &str) -> Value {
    plain("boolean", description)
}

/// An array.
pub fn list(description: &str, items: Value) -> Value {
    json!({ "type": "array", "description": description, "items": items })
}

/// An array of numbers of this length.
pub fn tuple(description: &str, length: usize) -> Value {
    let mut list = list(description, number(""));
    list["minItems"] = length.into();
    list["maxItems"] = length.into();
    list
}

pub fn vector(description: &str) -> Value {
    tuple(description, 3)
}

/// An object whose keys are names of the scene.
pub fn by_name(description: &str, values: Value) -> Value {
    json!({ "type": "object", "description": description, "additionalProperties": values })
}

/// An object with these keys and no others; those that end with a question mark may be absent.
pub fn object(description: &str, keys: &[(&str, Value)]) -> Value {
    let name = |key: &str| key.trim_end_matches('?').to_owned();
    let properties: Map<String, Value> = keys
        .iter()
        .map(|(key, value)| (name(key), value.clone()))
        .collect();
    let required: Vec<&str> = keys
        .iter()
        .map(|(key, _)| *key)
        .filter(|key| !key.ends_with('?'))
        .collect();
    let mut object = plain("object", description);
    object["properties"] = properties.into();
    object["required"] = required.into();
    object["additionalProperties"] = false.into();
    object
}

/// The same or null.
pub fn or_null(mut schema: Value) -> Value {
    schema["type"] = json!([schema["type"], "null"]);
    schema
}

/// Error bars by source; `more` are bars of other quantities beside them.
pub fn bars(description: &str, more: &[(&str, Value)]) -> Value {
    let mut keys = vec![
        ("mesh?", number("discretisation on a mesh")),
        (
            "container?",
            number("a finite container instead of unbounded fluid"),
        ),
        ("model?", number("deviation of the model from Stokes flow")),
        ("algebraic?", number("tolerance of the linear solver")),
        ("integration?", number("integration in time along the gait")),
        (
            "total",
            or_null(number(
                "sum of the estimated ones; null if nothing was estimated",
            )),
        ),
        (
            "not_estimated",
            list("sources without an estimate", text("")),
        ),
    ];
    keys.extend_from_slice(more);
    object(description, &keys)
}

/// Times of the parts of the work.
pub fn seconds() -> Value {
    let parts = ["mesh", "assembly", "setup", "solve", "estimate", "total"];
    let parts = parts.map(|part| (part, number("")));
    object(
        "wall-clock time of the parts of the work, and of all of it",
        &parts,
    )
}

/// What neglecting a term costs, whose parts depend on the term and the model.
pub fn neglected(description: &str) -> Value {
    plain("object", description)
}

/// Description of the key `model`.
pub const MODEL: &str = "name of the model, as of model.kind";
