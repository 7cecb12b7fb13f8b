//! The schema of `swim solve --json`.

use serde_json::Value;

use super::build::{
    MODEL, bars, count, flag, list, mean_flow, neglected, number, object, or_null, seconds, text,
    vector,
};

pub fn solve() -> Value {
    let matrix = |description| list(description, list("", number("")));
    let motion = || {
        let bodies = list(
            "in the order of the scene",
            object(
                "",
                &[
                    ("name", text("")),
                    ("velocity", vector("")),
                    (
                        "angular_velocity",
                        vector("in radians per time, in the frame of the scene"),
                    ),
                    ("force", vector("on the fluid")),
                    (
                        "torque",
                        vector("on the fluid, about the centre of the body"),
                    ),
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
            ("mean_flow", mean_flow("at this instant")),
        ]
    };
    let [bodies, links, power, flow] = motion();
    object(
        "the instantaneous solution at the start, in the units of the scene",
        &[
            ("model", text(MODEL)),
            bodies,
            links,
            power,
            flow,
            (
                "error_estimate",
                bars(
                    "error bars of the velocities, and of other quantities",
                    &[
                        ("angular_velocity", bars("of the angular velocities", &[])),
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
                        ("velocity", count("of the velocity")),
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
