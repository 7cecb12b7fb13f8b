//! The schemas of `swim schema` describe real output, and are those that are published.

use std::path::Path;

use serde_json::Value;

use crate::{printed, refused};

/// What of the output of a command its schema does not allow.
pub fn output_problems(folder: &Path, name: &str, output: &Value) -> Vec<String> {
    problems(&schema(folder, name), output, name)
}

/// Keys of a schema without a description.
fn undescribed(schema: &Value, at: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (key, value) in schema["properties"].as_object().into_iter().flatten() {
        let at = format!("{at}.{key}");
        if value["description"].as_str().is_none_or(str::is_empty) {
            found.push(at.clone());
        }
        found.extend(undescribed(value, &at));
    }
    for inner in ["items", "additionalProperties"] {
        if schema[inner].is_object() {
            found.extend(undescribed(&schema[inner], at));
        }
    }
    found
}

/// What of a value its schema does not allow, by the words of JSON Schema that ours use.
fn problems(schema: &Value, value: &Value, at: &str) -> Vec<String> {
    let kind = match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(number) if number.is_f64() => "number",
        Value::Number(_) => "integer",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    };
    let allows = |allowed: &Value| allowed == kind || (allowed == "number" && kind == "integer");
    let is_allowed = match &schema["type"] {
        Value::Array(kinds) => kinds.iter().any(allows),
        allowed => allows(allowed),
    };
    if !is_allowed {
        return vec![format!("{at} is {kind}, not {}", schema["type"])];
    }
    let mut found = Vec::new();
    if let Value::Array(items) = value {
        let bound = |name: &str| schema[name].as_u64().map(|count| count as usize);
        if bound("minItems").is_some_and(|least| items.len() < least)
            || bound("maxItems").is_some_and(|most| items.len() > most)
        {
            found.push(format!("{at} has {} items", items.len()));
        }
        for (number, item) in items.iter().enumerate() {
            found.extend(problems(&schema["items"], item, &format!("{at}[{number}]")));
        }
    }
    let Value::Object(entries) = value else {
        return found;
    };
    for key in schema["required"].as_array().into_iter().flatten() {
        if !entries.contains_key(key.as_str().unwrap()) {
            found.push(format!("{at} lacks {key}"));
        }
    }
    for (key, entry) in entries {
        let at = format!("{at}.{key}");
        match (&schema["properties"][key], &schema["additionalProperties"]) {
            (Value::Null, Value::Bool(false)) => found.push(format!("{at} is not described")),
            // Without a word anything is allowed.
            (Value::Null, Value::Null) => {}
            (Value::Null, others) => found.extend(problems(others, entry, &at)),
            (known, _) => found.extend(problems(known, entry, &at)),
        }
    }
    found
}

fn schema(folder: &Path, name: &str) -> Value {
    serde_json::from_str(&printed(folder, &["schema", name])).unwrap()
}

fn output(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&printed(folder, arguments)).unwrap()
}

#[test]
fn schemas_describe_every_key_of_real_output() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let by_elements = "--set domain={kind=\"ball\",radius=40} --set model.kind=\"fem\" \
                       --set fem.size_factor=2.5 --set model.accept=\"best\"";
    let cases = [
        ("run", "three-sphere", "run", "--sensitivities".to_owned()),
        ("run", "squirmer", "run", String::new()),
        (
            "run",
            "elastic-arm",
            "run",
            "--set fluid.density=1e-3".to_owned(),
        ),
        ("run", "brownian-swimmer", "run", String::new()),
        (
            "run",
            "three-sphere",
            "run",
            "--set bodies.left.fixed=true".to_owned(),
        ),
        ("solve", "three-sphere", "solve", "--resistance".to_owned()),
        ("solve", "squirmer", "solve", String::new()),
        ("solve", "three-sphere", "solve", by_elements.to_owned()),
        ("run", "fall", "run", String::new()),
        ("solve", "drag", "solve", "--steady".to_owned()),
        (
            "share",
            "optimal-stroke",
            "map",
            "--shard 1/2 --out share".to_owned(),
        ),
        ("map", "optimal-stroke", "map", String::new()),
        ("optimise", "optimal-stroke", "optimise", String::new()),
        ("frequency", "elastic-arm", "frequency", String::new()),
        (
            "sizes",
            "three-sphere",
            "sizes",
            "--set optimise.radii=[0.5,2]".to_owned(),
        ),
        ("learn", "learning", "learn", String::new()),
        (
            "sweep",
            "three-sphere",
            "sweep",
            "--vary bodies.left.radius=1,-1".to_owned(),
        ),
    ];
    let inertia = "fluid = { density = 1, inertia = \"full\" }\n\
                   domain = { kind = \"ball\", radius = 5 }\nmodel.tolerance = 3e-2\n";
    let fall = "gravity = [0, 0, -1]\ngait.phases = [{ duration = 1 }]\n\
                bodies = [{ name = \"a\", radius = 1, density = 2, position = [0, 0, 0] }]";
    let drag = "bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0], \
                velocity = [1, 0, 0] }]";
    for (name, rest) in [("fall", fall), ("drag", drag)] {
        std::fs::write(
            folder.join(format!("{name}.toml")),
            format!("{inertia}{rest}"),
        )
        .unwrap();
    }
    for (name, template, command, options) in cases {
        let scene = format!("{template}.toml");
        if !folder.join(&scene).exists() {
            printed(folder, &["new", template]);
        }
        let mut arguments = vec![command, &scene, "--json", "--quiet"];
        arguments.extend(options.split_whitespace());
        let found = output_problems(folder, name, &output(folder, &arguments));
        assert!(found.is_empty(), "{arguments:?}: {found:#?}");
    }
    // The comparison finds what is wrong.
    let mut summary = output(folder, &["run", "three-sphere.toml", "--json", "--quiet"]);
    let entries = summary.as_object_mut().unwrap();
    entries.remove("work");
    entries.insert("new".to_owned(), Value::Null);
    entries.insert("rotation".to_owned(), serde_json::json!([0, 0]));
    entries.insert("scene".to_owned(), serde_json::json!(1));
    assert_eq!(problems(&schema(folder, "run"), &summary, "run").len(), 4);
}

#[test]
fn published_schemas_are_those_of_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let list = printed(folder.path(), &["schema"]);
    let published = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schemas");
    let mut names = Vec::new();
    for line in list.lines() {
        let name = line.split_whitespace().next().unwrap();
        let file = published.join(format!("{name}.json"));
        let text = std::fs::read_to_string(&file).unwrap_or_default();
        let found = printed(folder.path(), &["schema", name]);
        assert_eq!(text, found, "swim schema {name} > {}", file.display());
        let missing = undescribed(&serde_json::from_str(&found).unwrap(), name);
        assert!(missing.is_empty(), "{missing:#?}");
        names.push(format!("{name}.json"));
    }
    for entry in std::fs::read_dir(published).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(names.contains(&name), "docs/schemas/{name} has no schema");
    }
    let message = refused(folder.path(), &["schema", "runs"]);
    assert!(message.contains("choose one of run, solve"), "{message}");
}
