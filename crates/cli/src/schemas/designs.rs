//! The schemas of designs: maps, optima, learning, sweeps.

use serde_json::Value;

use super::build::{
    MODEL, by_name, count, flag, list, number, object, or_null, text, tuple, vector,
};
use super::run::run;

pub fn map() -> Value {
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

pub fn share() -> Value {
    object(
        "what remains after a share of the table over shapes",
        &[
            (
                "points",
                list("number of shapes of the grid along each link", count("")),
            ),
            ("missing", count("shapes of other shares in this grid")),
        ],
    )
}

pub fn optimise() -> Value {
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
                or_null(number(
                    "change of the objective by the last increase of terms, null for the first terms",
                )),
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

pub fn wave() -> Value {
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
                            ("range", tuple("smallest and largest value", 2)),
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

pub fn frequency() -> Value {
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

pub fn sizes() -> Value {
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

pub fn learn() -> Value {
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

pub fn sweep() -> Value {
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
