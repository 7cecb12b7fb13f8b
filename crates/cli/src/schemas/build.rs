//! The parts of which schemas are built.

use serde_json::{Map, Value, json};

/// Meanings of keys that mean the same in every object, for schemas that say no more about them.
const MEANINGS: [(&str, &str); 67] = [
    ("assembly", "assembly of the linear systems"),
    (
        "change",
        "relative change of the velocity in the last iteration",
    ),
    ("cycles", "gait.cycles"),
    (
        "derivative",
        "of the net displacement along its direction, per unit of the parameter",
    ),
    ("displacement", "in the unit of length of the scene"),
    ("displacement_error", "error bar of the displacement"),
    (
        "displacement_per_time",
        "displacement divided by the period",
    ),
    (
        "displacement_vector",
        "displacement in the frame of the start",
    ),
    (
        "dissipation",
        "of the power from the dissipation in the fluid",
    ),
    ("drag", "force per velocity of the rigid swimmer"),
    ("efficiency", "Lighthill's; null for runs that do not swim"),
    (
        "efficiency_error",
        "error bar of the efficiency; null without an estimate",
    ),
    ("energy", "work of one period on the fluid"),
    ("energy_error", "error bar of the energy"),
    ("error", "error bar"),
    ("error_estimate", "error bars by source"),
    ("estimate", "estimates of the discretisation error"),
    ("fluid", "of the fluid"),
    (
        "force_by_stress",
        "of the forces from the stress at the surfaces",
    ),
    ("force_error", "error bars of the forces"),
    (
        "formulation",
        "how rigid motions are imposed, as of fem.formulation",
    ),
    ("frequency", "cycles per time"),
    ("frequency_error", "error bar of the frequency"),
    (
        "holding_torque",
        "as `holding_force`, about the centre of the body",
    ),
    ("interpolation", "error of the interpolation between shapes"),
    ("iterations", "number of iterations"),
    ("joints", "names of the joints that learn"),
    ("keys", "keys of the scene that vary"),
    ("links", "names of links"),
    ("max_power", "largest power on the fluid"),
    ("mesh", "generation and motion of meshes"),
    ("model", "error of the model at the shapes"),
    ("name", "name in the scene"),
    ("objective", "what is largest, as optimise.objective"),
    ("period", "of one cycle"),
    (
        "period_energy_product",
        "period times energy, at constant power",
    ),
    ("points", "number of shapes"),
    (
        "position",
        "change while the swimmer moves in its container",
    ),
    (
        "position_error",
        "change while the swimmer moves in its container",
    ),
    ("power", "of the power on the fluid"),
    ("pressure", "of the pressure"),
    ("reason", "why a mesh was generated"),
    ("reynolds", "Reynolds number"),
    ("rotation", "rotation vector in radians"),
    (
        "rotation_error",
        "error bar of the rotation in radians; null without an estimate",
    ),
    (
        "rotational_diffusion",
        "of the rotation of the first sphere alone",
    ),
    ("rows", "one per point, in order"),
    ("runs", "number of runs"),
    ("seconds", "wall-clock time"),
    ("seed", "fluid.seed"),
    ("setup", "preconditioners and factorisations"),
    ("solve", "solution of the linear systems"),
    ("solver", "method and result of the linear solver"),
    ("solves", "number of solutions of the model"),
    ("steps", "number of steps in time"),
    ("table", "the table over shapes"),
    ("time", "in the unit of the scene, from the start"),
    (
        "tolerance_met",
        "whether the error bar is within the tolerance",
    ),
    ("torque_error", "error bars of the torques"),
    ("total", "of all"),
    (
        "true_relative_residual",
        "recomputed from the solution, relative to the right-hand side",
    ),
    ("value", "the value"),
    (
        "variables",
        "keys of the scene that vary, with their best values",
    ),
    ("vector", "in the frame of the scene"),
    ("velocity", "of the centre of the body"),
    ("work", "work of the bodies on the fluid"),
    (
        "work_error",
        "error bar of the work; null without an estimate",
    ),
];

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
    let mut list = plain("array", description);
    list["items"] = items;
    list
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
    let mut object = plain("object", description);
    object["additionalProperties"] = values;
    object
}

/// An object with these keys and no others; those that end with a question mark may be absent.
/// Keys without a description have that of [`MEANINGS`].
pub fn object(description: &str, keys: &[(&str, Value)]) -> Value {
    let name = |key: &str| key.trim_end_matches('?').to_owned();
    let meaning = |key: &str| MEANINGS.iter().find(|(known, _)| *known == key);
    let described = |(key, value): &(&str, Value)| {
        let (key, mut value) = (name(key), value.clone());
        if let (true, Some((_, meaning))) = (value["description"].is_null(), meaning(&key)) {
            value["description"] = (*meaning).into();
        }
        (key, value)
    };
    let properties: Map<String, Value> = keys.iter().map(described).collect();
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

/// The mean flow through a periodic box.
pub fn mean_flow(description: &str) -> Value {
    let given = || or_null(bars("null if the scene gives it", &[]));
    or_null(object(
        &format!("{description}, through a periodic box; null in other domains"),
        &[
            ("velocity", vector("of fluid and bodies together")),
            ("velocity_error", given()),
            (
                "pressure_gradient",
                vector("sum of the forces on the fluid over the volume of the box"),
            ),
            ("pressure_gradient_error", given()),
        ],
    ))
}

/// What neglecting a term costs, whose parts depend on the term and the model.
pub fn neglected(description: &str) -> Value {
    plain("object", description)
}

/// Description of the key `model`.
pub const MODEL: &str = "name of the model, as of model.kind";
