//! `swim schema`: JSON schemas of what the commands write and print with `--json`.
//!
//! A test compares them with real output: every key must be described, and every described key be
//! there unless its name ends with a question mark here.

use serde_json::{Map, Value, json};

use super::error::CliError;
use super::text::entry;

/// Names of the schemas, with the outputs that they describe and the functions that make them.
const SCHEMAS: [(&str, &str, fn() -> Value); 9] = [
    ("run", "summary.json of swim run, and swim run --json", run),
    ("solve", "swim solve --json", solve),
    ("map", "swim map --json", map),
    (
        "optimise",
        "optimum.json of swim optimise for a stroke",
        optimise,
    ),
    (
        "wave",
        "optimum.json of swim optimise for a tube that waves",
        wave,
    ),
    ("frequency", "swim frequency --json", frequency),
    ("sizes", "swim sizes --json", sizes),
    (
        "learn",
        "learned.json of swim learn, and swim learn --json",
        learn,
    ),
    ("sweep", "swim sweep --json", sweep),
];

/// The schema with a name, or without a name the list of all.
pub fn schema(name: Option<&str>) -> Result<String, CliError> {
    let Some(name) = name else {
        return Ok(SCHEMAS
            .iter()
            .map(|(name, what, _)| entry(name, what))
            .collect());
    };
    let Some((_, what, make)) = SCHEMAS.iter().find(|(known, ..)| *known == name) else {
        return Err(CliError::NotApplicable {
            place: format!("swim schema {name}"),
            problem: format!("unknown; choose one of {}", SCHEMAS.map(|s| s.0).join(", ")),
        });
    };
    let mut schema = make();
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
    schema["title"] = (*what).into();
    Ok(format!("{schema:#}\n"))
}

fn plain(kind: &str, description: &str) -> Value {
    match description.is_empty() {
        true => json!({ "type": kind }),
        false => json!({ "type": kind, "description": description }),
    }
}

fn text(description: &str) -> Value {
    plain("string", description)
}

fn number(description: &str) -> Value {
    plain("number", description)
}

fn count(description: &str) -> Value {
    plain("integer", description)
}

fn flag(description: &str) -> Value {
    plain("boolean", description)
}

fn list(description: &str, items: Value) -> Value {
    json!({ "type": "array", "description": description, "items": items })
}

fn tuple(description: &str, length: usize) -> Value {
    let mut list = list(description, number(""));
    list["minItems"] = length.into();
    list["maxItems"] = length.into();
    list
}

fn vector(description: &str) -> Value {
    tuple(description, 3)
}

/// An object whose keys are names of the scene.
fn by_name(description: &str, values: Value) -> Value {
    json!({ "type": "object", "description": description, "additionalProperties": values })
}

/// An object with these keys and no others; those that end with a question mark may be absent.
fn object(description: &str, keys: &[(&str, Value)]) -> Value {
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
fn or_null(mut schema: Value) -> Value {
    schema["type"] = json!([schema["type"], "null"]);
    schema
}

/// Error bars by source; `more` are bars of other quantities beside them.
fn bars(description: &str, more: &[(&str, Value)]) -> Value {
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

fn seconds() -> Value {
    let parts = ["mesh", "assembly", "setup", "solve", "estimate", "total"];
    let parts = parts.map(|part| (part, number("")));
    object(
        "wall-clock time of the parts of the work, and of all of it",
        &parts,
    )
}

/// What neglecting a term costs, whose parts depend on the term and the model.
fn neglected(description: &str) -> Value {
    plain("object", description)
}

const MODEL: &str = "name of the model, as of model.kind";

fn run() -> Value {
    let on_body = || object("", &[("force", vector("")), ("torque", vector(""))]);
    let displacements = || by_name("by body", vector(""));
    object(
        "a run in the units of the scene; forces and work are those on the fluid",
        &[
            ("scene", text("name of the scene")),
            ("model", text(MODEL)),
            ("reasons", list("why the model was chosen", text(""))),
            (
                "net_displacement",
                object(
                    "how far the swimmer swam",
                    &[
                        ("vector", vector("")),
                        ("length", number("its length, zero if that is rounding")),
                        (
                            "error",
                            or_null(number("error bar; null if it was not estimated")),
                        ),
                        ("definition", text("definition in words")),
                    ],
                ),
            ),
            ("displacement", displacements()),
            (
                "error_estimate",
                bars("error bars of the displacements", &[]),
            ),
            (
                "rotation",
                vector("rotation vector of the first linkage, with full turns"),
            ),
            ("rotation_error", bars("error bars of it, in radians", &[])),
            (
                "turned",
                by_name("by body, the angle of its whole path", number("")),
            ),
            ("work", number("work of the bodies on the fluid")),
            ("work_error", bars("error bars of the work", &[])),
            (
                "efficiency",
                or_null(object(
                    "Lighthill's efficiency; null for runs that do not swim",
                    &[
                        ("value", number("")),
                        ("error", or_null(number("error bar"))),
                        ("drag", number("force per velocity of the rigid swimmer")),
                    ],
                )),
            ),
            (
                "swimmers",
                or_null(list(
                    "results of each swimmer; null for one alone",
                    object(
                        "",
                        &[
                            ("name", text("name of its first body")),
                            ("bodies", list("", text(""))),
                            ("displacement", vector("mean of its moving bodies")),
                            ("rotation", vector("")),
                            (
                                "work",
                                or_null(number("null where only the total is known")),
                            ),
                            ("error_estimate", bars("of the displacement", &[])),
                        ],
                    ),
                )),
            ),
            (
                "mean_holding",
                or_null(object(
                    "means over the run of what holds or drives bodies of given velocity",
                    &[
                        ("bodies", by_name("by body", on_body())),
                        ("force_error", bars("", &[])),
                        ("torque_error", bars("", &[])),
                    ],
                )),
            ),
            (
                "shape_change",
                or_null(object(
                    "null if the joints return to their values",
                    &[
                        (
                            "links",
                            by_name("change of the value of each link", number("")),
                        ),
                        (
                            "rigid_part",
                            object(
                                "motion of the frame in which the shape is described",
                                &[
                                    ("body", text("the body at its origin")),
                                    ("displacement", vector("")),
                                    ("rotation", vector("")),
                                ],
                            ),
                        ),
                    ],
                )),
            ),
            (
                "phases",
                list(
                    "the phases of all cycles, in order",
                    object(
                        "",
                        &[
                            ("link", or_null(text("the links that move"))),
                            ("displacement", displacements()),
                            ("error_estimate", bars("", &[])),
                            ("solves", count("")),
                            ("lookups", count("solutions that a table gave")),
                        ],
                    ),
                ),
            ),
            ("cycles", count("")),
            ("duration", number("of the gait")),
            (
                "solves",
                count("solutions of the model, with those of tables"),
            ),
            ("lookups", count("solutions that tables over shapes gave")),
            (
                "table_solves",
                count("solutions of which these tables are made"),
            ),
            ("tolerance", number("model.tolerance")),
            ("tolerance_met", flag("")),
            (
                "tolerance_limits",
                or_null(text("the errors to which it refers")),
            ),
            (
                "allowed_error",
                number("the length that the tolerance allows"),
            ),
            (
                "stopped",
                or_null(text("why the run stopped before its end, such as contact")),
            ),
            (
                "uncorrected",
                or_null(object(
                    "before estimated discretisation errors were subtracted",
                    &[("displacement", displacements()), ("work", number(""))],
                )),
            ),
            (
                "thermal_noise",
                or_null(object(
                    "of the only realisation, whose spread no error bar contains",
                    &[
                        ("energy", number("k_B T")),
                        ("seed", count("")),
                        ("steps", count("")),
                        ("time_step", number("the longest one")),
                        ("diffusion", number("of the first sphere alone")),
                        ("rotational_diffusion", number("")),
                    ],
                )),
            ),
            (
                "repulsion",
                or_null(object(
                    "of surfaces that nearly touch",
                    &[("range", number("")), ("strength", number(""))],
                )),
            ),
            (
                "inertia",
                or_null(object(
                    "of the fluid",
                    &[
                        ("terms", text("fluid.inertia")),
                        ("start", text("fluid.start")),
                        ("reynolds", number("the largest Reynolds number")),
                        ("frequency_parameter", or_null(number(""))),
                        (
                            "kinetic_energy",
                            or_null(object(
                                "at the end",
                                &[
                                    ("fluid", number("")),
                                    ("bodies", number("")),
                                    ("mesh_error", or_null(tuple("of both", 2))),
                                ],
                            )),
                        ),
                        (
                            "added_mass",
                            or_null(object(
                                "forces that accelerate the fluid, at the end",
                                &[
                                    ("bodies", by_name("by body", on_body())),
                                    ("mesh_error", or_null(tuple("of forces and torques", 2))),
                                ],
                            )),
                        ),
                    ],
                )),
            ),
            (
                "neglected_inertia?",
                neglected("what neglecting inertia costs"),
            ),
            (
                "neglected_rheology?",
                neglected("what neglecting the viscosity law costs"),
            ),
            (
                "sensitivities?",
                list(
                    "with --sensitivities: derivatives of the net displacement",
                    object(
                        "",
                        &[
                            ("parameter", text("in words")),
                            ("value", number("in the scene")),
                            ("derivative", number("")),
                            ("error", number("error bar of the derivative")),
                        ],
                    ),
                ),
            ),
            (
                "meshes",
                list(
                    "meshes that were generated on the way",
                    object(
                        "",
                        &[
                            ("time", number("")),
                            ("phase", count("from one")),
                            ("reason", text("")),
                        ],
                    ),
                ),
            ),
            ("seconds", seconds()),
            (
                "peak_rss_mib",
                or_null(number("largest memory of the process")),
            ),
            ("machine", text("threads and processor")),
            ("version", text("of the program")),
        ],
    )
}

fn solve() -> Value {
    let matrix = |description| list(description, list("", number("")));
    let motion = || {
        let bodies = list(
            "in the order of the scene",
            object(
                "",
                &[
                    ("name", text("")),
                    ("velocity", vector("")),
                    ("angular_velocity", vector("")),
                    ("force", vector("on the fluid")),
                    ("torque", vector("on the fluid")),
                    (
                        "holding_force",
                        or_null(vector("what holds or drives a body of given velocity")),
                    ),
                    ("holding_torque", or_null(vector(""))),
                    (
                        "stresslet",
                        or_null(matrix("with the sign of Batchelor (1970)")),
                    ),
                ],
            ),
        );
        let links = list(
            "in the order of the scene",
            object(
                "",
                &[
                    ("name", text("")),
                    ("force", vector("on the body that the key `body` names")),
                    ("torque", vector("about the pivot")),
                    ("drive", number("force or torque of the drive")),
                ],
            ),
        );
        [
            ("bodies", bodies),
            ("links", links),
            ("power", number("on the fluid")),
        ]
    };
    let [bodies, links, power] = motion();
    object(
        "the instantaneous solution at the start, in the units of the scene",
        &[
            ("model", text(MODEL)),
            bodies,
            links,
            power,
            (
                "error_estimate",
                bars(
                    "error bars of the velocities, and of other quantities",
                    &[
                        ("angular_velocity", bars("", &[])),
                        ("force", bars("of the largest force", &[])),
                        ("torque", bars("of the largest torque", &[])),
                        ("power", bars("", &[])),
                        ("stresslet?", number("of the Frobenius norm")),
                    ],
                ),
            ),
            (
                "uncorrected",
                or_null(object(
                    "before estimated discretisation errors were subtracted",
                    &motion(),
                )),
            ),
            (
                "checks",
                or_null(object(
                    "relative differences from independent computations",
                    &[("force_by_stress", number("")), ("dissipation", number(""))],
                )),
            ),
            (
                "dofs",
                object(
                    "size of the linear system",
                    &[
                        ("velocity", count("")),
                        ("pressure", count("")),
                        ("total", count("")),
                    ],
                ),
            ),
            (
                "solver",
                object(
                    "",
                    &[
                        ("formulation", text("")),
                        ("solver", text("")),
                        ("iterations", count("")),
                        ("true_relative_residual", number("")),
                    ],
                ),
            ),
            ("tolerance?", number("model.tolerance")),
            ("tolerance_met?", or_null(flag(""))),
            ("tolerance_limits?", text("the errors to which it refers")),
            (
                "decision?",
                text("whether a neglected term is kept, and why"),
            ),
            (
                "neglected_inertia?",
                neglected("what neglecting inertia costs"),
            ),
            (
                "neglected_rheology?",
                neglected("what neglecting the viscosity law costs"),
            ),
            (
                "resistance?",
                matrix("with --resistance: rows (F, T) of each body"),
            ),
            (
                "steady?",
                object(
                    "with --steady",
                    &[
                        ("reynolds", number("")),
                        ("iterations", count("")),
                        ("change", number("")),
                    ],
                ),
            ),
            ("seconds", seconds()),
            (
                "peak_rss_mib",
                or_null(number("largest memory of the process")),
            ),
        ],
    )
}

fn map() -> Value {
    object(
        "the table over shapes",
        &[
            ("model", text(MODEL)),
            ("links", list("the links that move", text(""))),
            ("ranges", list("limits of each", tuple("", 2))),
            ("degrees", list("of the interpolant", count(""))),
            ("points", count("number of shapes")),
            (
                "error_estimate",
                object(
                    "per unit rate of a link",
                    &[
                        ("interpolation", number("")),
                        ("model", number("")),
                        ("position", number("")),
                    ],
                ),
            ),
            (
                "middle",
                list("the shape in the middle of the limits", number("")),
            ),
            (
                "curvature",
                list(
                    "at the middle, for each two links",
                    object(
                        "",
                        &[
                            ("links", list("", text(""))),
                            (
                                "curvature",
                                tuple("displacement and rotation vector per area", 6),
                            ),
                        ],
                    ),
                ),
            ),
            (
                "gait",
                or_null(object(
                    "the gait of the scene by the table",
                    &[
                        ("displacement", vector("")),
                        ("rotation", vector("")),
                        ("period_energy_product", number("at constant power")),
                    ],
                )),
            ),
        ],
    )
}

fn optimise() -> Value {
    object(
        "the best stroke",
        &[
            ("displacement", number("by the table")),
            ("displacement_vector", vector("")),
            ("rotation", vector("")),
            ("energy", number("")),
            ("period", number("")),
            ("displacement_per_time", number("")),
            ("max_rate", list("of each link", number(""))),
            ("max_power", number("")),
            ("period_energy_product", number("at constant power")),
            ("efficiency", number("Lighthill's")),
            ("terms", count("of the series, or corners")),
            (
                "refinement_error",
                number("change of the objective by the last increase of terms"),
            ),
            (
                "at_limits",
                flag("whether the stroke touches the limits of the links"),
            ),
            (
                "lengths",
                list(
                    "values of the links at equal steps of time",
                    list("", number("")),
                ),
            ),
            (
                "table",
                object(
                    "",
                    &[
                        ("model", text(MODEL)),
                        ("points", count("")),
                        ("displacement_error", number("")),
                        (
                            "errors",
                            tuple("of the interpolation and of the model, per unit rate", 2),
                        ),
                        ("position_error", number("")),
                    ],
                ),
            ),
            (
                "run",
                object(
                    "the stroke by the full model",
                    &[
                        ("model", text(MODEL)),
                        ("displacement", number("")),
                        ("displacement_error", number("")),
                        ("rotation", vector("")),
                        ("energy", number("")),
                        ("energy_error", number("")),
                        (
                            "efficiency",
                            or_null(object(
                                "",
                                &[
                                    ("value", number("")),
                                    ("error", or_null(number(""))),
                                    ("drag", number("")),
                                ],
                            )),
                        ),
                        ("solves", count("")),
                    ],
                ),
            ),
            (
                "gait",
                or_null(object(
                    "the gait of the scene by the table",
                    &[
                        ("displacement", number("")),
                        ("period_energy_product", number("")),
                    ],
                )),
            ),
        ],
    )
}

fn wave() -> Value {
    object(
        "the best wave of a tube",
        &[
            (
                "variables",
                list(
                    "",
                    object(
                        "",
                        &[
                            ("key", text("of the scene")),
                            ("range", tuple("", 2)),
                            ("value", number("the best one")),
                            ("error", or_null(number("null at the end of the range"))),
                        ],
                    ),
                ),
            ),
            ("objective", text("what is largest")),
            ("value", number("the objective of the run of the best wave")),
            ("error", or_null(number("error bar"))),
            ("by_table", number("by the interpolant of the table")),
            ("table", sweep()),
            ("run", run()),
        ],
    )
}

fn frequency() -> Value {
    object(
        "the frequency of the largest net displacement per cycle",
        &[
            ("frequency", number("")),
            ("frequency_error", number("")),
            ("period", number("")),
            ("displacement", number("per cycle")),
            ("displacement_error", number("")),
            (
                "runs",
                list(
                    "frequency, displacement and error bar of each",
                    tuple("", 3),
                ),
            ),
        ],
    )
}

fn sizes() -> Value {
    let results = ["displacement", "work", "efficiency"];
    let names = results.map(|name| (name, format!("{name}_error")));
    let results: Vec<(&str, Value)> = (names.iter())
        .flat_map(|(name, error)| [(*name, number("")), (error, number("error bar"))])
        .collect();
    let size = &[
        ("value", number("")),
        ("error", number("")),
        ("scene", number("before")),
    ];
    object(
        "the best radii and arm lengths",
        &[
            ("objective", text("")),
            ("sizes", by_name("by size, in words", object("", size))),
            ("at_limits", list("limits that are active", text(""))),
            ("best", object("at the best sizes", &results)),
            ("scene", object("at those of the scene", &results)),
            ("runs", count("")),
        ],
    )
}

fn learn() -> Value {
    let cycle = || {
        [
            (
                "policy",
                list(
                    "states: one digit per joint, 1 if it is contracted",
                    text(""),
                ),
            ),
            (
                "actions",
                list("the joint that changes in each state", text("")),
            ),
            ("per_step", number("mean displacement")),
            ("per_cycle", number("displacement")),
        ]
    };
    let mut keys = cycle().to_vec();
    keys.extend([
        ("model", text(MODEL)),
        ("joints", list("", text(""))),
        ("optimum", object("the best possible cycle", &cycle())),
        ("is_optimal", flag("whether the learned cycle is as good")),
        (
            "reward_error",
            number("error bar of the displacement of a step"),
        ),
        (
            "curve",
            list("mean displacement of a step in each episode", number("")),
        ),
        (
            "values",
            list("of each action in each state", list("", number(""))),
        ),
    ]);
    object("the cycle that was learned", &keys)
}

fn sweep() -> Value {
    let result = object(
        "null for a run that failed",
        &[
            ("model", text(MODEL)),
            ("tolerance_met", flag("")),
            ("stopped", or_null(text("why it stopped before its end"))),
            ("displacement", vector("net displacement")),
            ("displacement_error", or_null(number(""))),
            ("rotation", vector("")),
            ("rotation_error", or_null(number(""))),
            ("work", number("on the fluid")),
            ("work_error", or_null(number(""))),
            ("efficiency", or_null(number(""))),
            ("efficiency_error", or_null(number(""))),
            ("seconds", number("")),
        ],
    );
    let row = object(
        "",
        &[
            ("values", list("of the keys, as in a scene", text(""))),
            (
                "status",
                text("met, tolerance missed, or why the run stopped or failed"),
            ),
            ("result", or_null(result)),
        ],
    );
    object(
        "runs with other values of some keys",
        &[("keys", list("", text(""))), ("rows", list("", row))],
    )
}
