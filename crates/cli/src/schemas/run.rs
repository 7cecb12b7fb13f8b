//! The schema of `summary.json`.

use serde_json::Value;

use super::build::{
    MODEL, bars, by_name, count, flag, list, mean_flow, neglected, number, object, or_null,
    seconds, text, tuple, vector,
};

pub fn run() -> Value {
    let loads = |force: &str, torque: &str| {
        object("", &[("force", vector(force)), ("torque", vector(torque))])
    };
    let displacements = || by_name("by body", vector(""));
    object(
        "a run in the units of the scene; forces and work are those on the fluid",
        &[
            ("scene", text("name of the scene")),
            (
                "bodies",
                list("names of the bodies in the order of the scene", text("")),
            ),
            (
                "links",
                list("names of the links in the order of the scene", text("")),
            ),
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
                "facet_errors",
                or_null(by_name(
                    "by body with flat facets, the relative difference of its size from that of \
                     the smooth surface through its vertices",
                    number(""),
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
                            ("bodies", list("names of its bodies", text(""))),
                            ("displacement", vector("mean of its moving bodies")),
                            ("rotation", vector("")),
                            ("rotation_error", bars("", &[])),
                            (
                                "work_error",
                                or_null(bars("of the work; null where that is", &[])),
                            ),
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
                        (
                            "bodies",
                            by_name(
                                "by body",
                                loads("on the body", "on the body, about its centre"),
                            ),
                        ),
                        ("force_error", bars("", &[])),
                        ("torque_error", bars("", &[])),
                    ],
                )),
            ),
            ("mean_flow", mean_flow("means over the run")),
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
                    &[
                        (
                            "range",
                            number("gap over which it falls by a factor e where it is small"),
                        ),
                        (
                            "strength",
                            number("the force at the gap `range` times ln 2"),
                        ),
                    ],
                )),
            ),
            (
                "inertia",
                or_null(object(
                    "of the fluid",
                    &[
                        ("terms", text("fluid.inertia")),
                        ("start", text("fluid.start")),
                        (
                            "periodic_start",
                            or_null(object(
                                "of the cycles before the run",
                                &[
                                    ("cycles", count("cycles before the run")),
                                    (
                                        "residual",
                                        number("difference of the displacements in the last two"),
                                    ),
                                    (
                                        "energy_residual",
                                        number(
                                            "relative difference of the energies around the last",
                                        ),
                                    ),
                                    (
                                        "error",
                                        number("of the displacement in a cycle by what remains"),
                                    ),
                                ],
                            )),
                        ),
                        ("reynolds", number("the largest Reynolds number")),
                        (
                            "frequency_parameter",
                            or_null(number(
                                "radius squared times the angular frequency over the kinematic \
                                 viscosity; null without a period",
                            )),
                        ),
                        (
                            "kinetic_energy",
                            or_null(object(
                                "at the end",
                                &[
                                    ("fluid", number("")),
                                    ("bodies", number("of the bodies")),
                                    ("mesh_error", or_null(tuple("of both", 2))),
                                ],
                            )),
                        ),
                        (
                            "added_mass",
                            or_null(object(
                                "forces that accelerate the fluid, at the end",
                                &[
                                    (
                                        "bodies",
                                        by_name(
                                            "by body",
                                            loads("on the fluid", "on the fluid, about the centre"),
                                        ),
                                    ),
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
