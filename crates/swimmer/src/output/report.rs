//! JSON for other programs: `summary.json` and the output of `swim solve --json`.

use std::collections::HashMap;

use models::{ErrorEstimate, HoldingLoad, InstantaneousSolution, MeanFlow, Seconds};
use nalgebra::{DMatrix, Vector3};
use scene::Scene;
use serde_json::{Map, Value, json};

use crate::inertia_numbers::InertiaNumbers;
use crate::noise_numbers::NoiseNumbers;
use crate::outcome::Outcome;
use crate::swimmers::SwimmerOutcome;

/// The word of `tolerance_limits` in a summary for a model that controls its error.
pub const ALL_ERRORS: &str = "all errors";

/// The summary of a run, `summary.json`.
///
/// `swim schema run` describes all keys. Those with a convention:
///
/// - `scene`, `model`, `reasons` (for the model), `machine`, `version` (of the program);
/// - `bodies` and `links`, their names in the order of the scene, which
///   [`trajectory_npy`](super::trajectory_npy) has too;
/// - `displacement` (by body), `rotation` (vector of the frame of the first linkage in radians,
///   with full turns as far as its axis stays), `turned` (by body, the angle of its whole path),
///   `work` (of the bodies on the fluid), with `error_estimate`, `rotation_error` and `work_error`
///   (error bars, absolute in the scene's units; `total` is null if nothing was estimated),
///   `uncorrected` (displacement and work before estimated discretisation errors were subtracted);
/// - `shape_change`: null if the joints return to their values; otherwise the changes by `links`
///   and the `rigid_part` of the motion, that of the frame in which the shape is described (`body`,
///   `displacement`, `rotation`);
/// - `swimmers`: null for one; otherwise, for each connected set of bodies that can move itself,
///   its `name` (that of its first body), `bodies`, `displacement` (mean of its moving bodies),
///   `rotation` (of its first body, or of the first one whose velocity is given), `work` (null
///   where it is known in total only: with slip, inertia or thermal noise, or where swimmers share
///   a volume), and the error bars `error_estimate` of the displacement, `rotation_error` and
///   `work_error`;
/// - `mean_holding`: null without bodies whose velocity is given; otherwise `bodies` (by body, the
///   mean `force` and `torque` over the run that hold or drive it) with `force_error` and
///   `torque_error`;
/// - `mean_flow` over the run through a periodic box: its `velocity` and `pressure_gradient`
///   ([`models::MeanFlow`]) with the error bars of the one that the scene does not give,
///   `velocity_error` or `pressure_gradient_error`; null in other domains;
/// - `phases`, each with `link`, `displacement`, `solves`, `lookups`, `error_estimate`;
/// - `solves` (of the model), `table_solves` (those of them of which tables over shapes are made),
///   `lookups` (solutions that were looked up in these tables);
/// - `tolerance`, `tolerance_met`, `tolerance_limits` (the errors to which both refer),
///   `allowed_error` (the length that they allow);
/// - `inertia` of the fluid: its `terms` and `start` (the words of the scene), `periodic_start` (of
///   [`PeriodicStart`](crate::PeriodicStart), with the `error` of the displacement in a cycle by
///   what remains of the start, or null for other starts), the largest
///   `reynolds` number and the `frequency_parameter` ([`InertiaNumbers`]), and the
///   `kinetic_energy` at the end, of the `fluid` and the `bodies` with the `mesh_error` of both,
///   and the `added_mass` there, `force` and `torque` by body with their `mesh_error`
///   ([`AddedMassForces`](crate::AddedMassForces)); in space the errors of steps are not estimated;
///   or null;
/// - `thermal_noise`: its `energy` `k_B T` and `seed`, the number of `steps` and the longest
///   `time_step`, `diffusion` and `rotational_diffusion` of the first sphere alone
///   ([`NoiseNumbers`]), or null. Displacements are then those of one realisation, and their error
///   bars do not contain its spread;
/// - `facet_errors`: null without bodies of flat facets; otherwise by body the relative difference
///   of its size from that of the smooth surface through its vertices
///   ([`Scene::facet_errors`]), which no error bar contains;
/// - `repulsion` between surfaces: its `range` and `strength`, or null;
/// - `stopped`: why the run stopped before its end, such as contact, in words, or null;
/// - `cycles`, `duration`, `meshes`, `seconds`, `peak_rss_mib`.
///
/// [`Report::summary`](crate::Report::summary) adds `efficiency` (the `value`, `error` and `drag`
/// of [`Efficiency`](crate::Efficiency), or null for runs that do not swim), `neglected_inertia`
/// for a fluid with a density and `neglected_rheology` for one whose viscosity law is neglected
/// ([`Neglected::json`](crate::Neglected::json)).
///
/// `seconds.total` is the wall-clock time of the whole run, the other entries are sums over the
/// solves, which may run at the same time.
pub fn summary_json(
    scene: &Scene,
    model: &str,
    reasons: &[String],
    outcome: &Outcome,
    wall_seconds: f64,
) -> Value {
    let by_body = |displacement: &[Vector3<f64>]| -> Value {
        let entry = |(body, d): (&scene::Body, &Vector3<f64>)| (body.name.clone(), vector(d));
        Value::Object(scene.bodies().iter().zip(displacement).map(entry).collect())
    };
    let phases: Vec<Value> = outcome
        .spans
        .iter()
        .map(|span| {
            json!({
                "link": (!span.joints.is_empty()).then(|| scene.joint_names(&span.joints)),
                "displacement": by_body(&span.displacement),
                "solves": span.solves - span.lookups,
                "lookups": span.lookups,
                "error_estimate": estimate(&span.error_estimate),
            })
        })
        .collect();
    let turnings = outcome.samples.last().map(|last| &last.turnings);
    let turned = scene.bodies().iter().zip(turnings.into_iter().flatten());
    let turned: Map<String, Value> = turned
        .map(|(body, turning)| (body.name.clone(), json!(turning.angle)))
        .collect();
    // None of both if the method does not estimate its error.
    let limited =
        outcome
            .limited_error
            .map(|limited| match limited >= outcome.error_estimate.total() {
                true => ALL_ERRORS,
                false => "the error of the integration",
            });
    let shape_change = outcome.shape_change(scene).map(|change| {
        let joints = change.joints.iter();
        let links: Map<String, Value> = joints
            .map(|(joint, by)| (scene.joint_names(&[*joint]), json!(by)))
            .collect();
        json!({
            "links": links,
            "rigid_part": {
                "body": scene.bodies()[change.body].name,
                "displacement": vector(&change.displacement),
                "rotation": vector(&change.rotation),
            },
        })
    });
    let mean_holding = outcome.mean_holding().map(|means| {
        let of_body = |load: &HoldingLoad| {
            let means = json!({ "force": vector(&load.force), "torque": vector(&load.torque) });
            (scene.bodies()[load.body].name.clone(), means)
        };
        let bodies: Map<String, Value> = means.bodies.iter().map(of_body).collect();
        json!({
            "bodies": bodies,
            "force_error": estimate(&means.force_error),
            "torque_error": estimate(&means.torque_error),
        })
    });
    let mean_flow = outcome.mean_flow();
    let mean_flow = mean_flow.map(|mean| mean_flow_json(scene, &mean.flow, &mean.error));
    let of_swimmer = |swimmer: &SwimmerOutcome| {
        let names = swimmer
            .bodies
            .iter()
            .map(|&body| &scene.bodies()[body].name);
        json!({
            "name": swimmer.name(scene),
            "bodies": names.collect::<Vec<_>>(),
            "displacement": vector(&swimmer.displacement),
            "rotation": vector(&swimmer.rotation),
            "rotation_error": estimate(&swimmer.rotation_error),
            "work": swimmer.work,
            "work_error": swimmer.work_error.as_ref().map(estimate),
            "error_estimate": estimate(&swimmer.error_estimate),
        })
    };
    let facet_errors = scene.facet_errors().into_iter();
    let facet_errors: Map<String, Value> = facet_errors
        .map(|(body, error)| (scene.bodies()[body].name.clone(), json!(error)))
        .collect();
    let swimmers: Vec<Value> = outcome.swimmers(scene).iter().map(of_swimmer).collect();
    let periodic_start = outcome.periodic_start.map(|start| {
        json!({
            "cycles": start.cycles,
            "residual": start.residual,
            "energy_residual": start.energy_residual,
            "error": start.remainder.displacement,
        })
    });
    let added_mass = outcome.added_mass().map(|added_mass| {
        let forces = scene.bodies().iter().zip(&added_mass.bodies);
        let forces = forces.map(|(body, [force, torque])| {
            (
                body.name.clone(),
                json!({ "force": force, "torque": torque }),
            )
        });
        json!({
            "bodies": forces.collect::<Map<_, _>>(),
            "mesh_error": added_mass.mesh_error,
        })
    });
    let bodies: Vec<&str> = scene.bodies().iter().map(|b| b.name.as_str()).collect();
    let joints = scene.articulation().joints().iter();
    json!({
        "scene": scene.name(),
        "bodies": bodies,
        "links": joints.map(|joint| joint.name.as_str()).collect::<Vec<_>>(),
        "swimmers": (!swimmers.is_empty()).then_some(swimmers),
        "mean_holding": mean_holding,
        "mean_flow": mean_flow,
        "shape_change": shape_change,
        "net_displacement": {
            "vector": vector(&outcome.net_vector()),
            "length": outcome.resolved_net(),
            "error": outcome.error_estimate.estimated(),
            "definition": "mean of the displacements of the centres of the bodies that move",
        },
        "displacement": by_body(&outcome.displacement),
        "rotation": vector(&outcome.rotation),
        "rotation_error": estimate(&outcome.rotation_error),
        "turned": turned,
        "phases": phases,
        "solves": outcome.model_solves(),
        "lookups": outcome.lookups,
        "table_solves": outcome.tables.iter().sum::<usize>(),
        "error_estimate": estimate(&outcome.error_estimate),
        "uncorrected": (outcome.mesh_error.as_ref().map(|errors| {
            let computed: Vec<_> = outcome.displacement.iter().zip(errors).map(|(d, e)| d + e).collect();
            json!({ "displacement": by_body(&computed), "work": outcome.uncorrected_work() })
        })),
        "seconds": (Seconds { total: wall_seconds, ..outcome.seconds }),
        "model": model,
        "reasons": reasons,
        "cycles": scene.gait().cycles,
        "duration": scene.gait().duration(),
        "work": outcome.work,
        "work_error": estimate(&outcome.work_error),
        "tolerance": scene.model().tolerance,
        "tolerance_met": outcome.tolerance_met,
        "stopped": outcome.stopped,
        "thermal_noise": (NoiseNumbers::new(scene).ok().flatten().zip(scene.noise())).map(
            |(numbers, noise)| json!({
                "energy": noise.energy,
                "seed": noise.seed,
                "steps": numbers.steps,
                "time_step": numbers.time_step,
                "diffusion": numbers.diffusion,
                "rotational_diffusion": numbers.rotational_diffusion,
            })
        ),
        "facet_errors": (!facet_errors.is_empty()).then_some(facet_errors),
        "repulsion": (scene.repulsion().map(|repulsion| {
            json!({ "range": repulsion.range, "strength": repulsion.strength })
        })),
        "inertia": (InertiaNumbers::new(scene, outcome).map(|numbers| {
            json!({
                "terms": scene.inertia().kind.word(),
                "start": scene.inertia().start.word(),
                "periodic_start": periodic_start,
                "reynolds": numbers.reynolds,
                "frequency_parameter": numbers.frequency,
                "kinetic_energy": outcome.kinetic_energy(),
                "added_mass": added_mass,
            })
        })),
        "tolerance_limits": limited,
        "allowed_error": outcome.allowed_error,
        "meshes": outcome.meshes,
        "peak_rss_mib": peak_rss_mib(),
        "machine": processor(),
        "version": env!("CARGO_PKG_VERSION"),
    })
}

/// An instantaneous solution, as printed by `swim solve --json`.
///
/// `links` has the force and, about the pivot, the torque of each joint on the body that its key
/// `body` names; the opposite ones act on `to`. `drive` is the force of the drive, or its torque if
/// the value of the joint is an angle: its power on the bodies is `drive` times the rate.
/// `holding_force` and `holding_torque` of a body whose velocity is given are the load that holds
/// or drives it ([`models::HoldingLoad`]), null for other bodies; their error bars are those of the
/// forces and torques. `power` is that of the bodies on the fluid, by motion and slip. `mean_flow`
/// through a periodic box has the `velocity` and the `pressure_gradient` ([`models::MeanFlow`])
/// with the error bars of the one that the scene does not give; null in other domains.
/// `error_estimate` refers to the velocities; its entries `angular_velocity`, `force`, `torque` and
/// `stresslet` to the largest of each, `power` to the power. `stresslet` of a body is the matrix of
/// [`models::Stresslets`], with the sign of Batchelor (1970); null for models that do not compute
/// it. `uncorrected` has velocities, forces and power before estimated discretisation errors were
/// subtracted, `checks` independent computations of these forces and their power.
pub fn solution_json(scene: &Scene, model: &str, solution: &InstantaneousSolution) -> Value {
    let motion = |solution: &InstantaneousSolution| -> Map<String, Value> {
        let bodies = scene.bodies().iter().zip(&solution.bodies);
        let held: HashMap<usize, &HoldingLoad> = (solution.holding.iter())
            .map(|load| (load.body, load))
            .collect();
        let stresslet = |body: usize| {
            let stresslets = solution.stresslets.as_ref()?;
            stresslets
                .bodies
                .get(body)
                .map(|s| matrix_json(&DMatrix::from_column_slice(3, 3, s.as_slice())))
        };
        let holding = |body: usize| held.get(&body);
        let bodies: Vec<Value> = (bodies.enumerate())
            .map(|(number, (body, motion))| {
                json!({
                    "name": body.name,
                    "velocity": vector(&motion.velocity),
                    "angular_velocity": vector(&motion.angular_velocity),
                    "force": vector(&motion.force),
                    "torque": vector(&motion.torque),
                    "holding_force": holding(number).map(|load| vector(&load.force)),
                    "holding_torque": holding(number).map(|load| vector(&load.torque)),
                    "stresslet": stresslet(number),
                })
            })
            .collect();
        let joints = scene.articulation().joints().iter();
        let joints: Vec<Value> = joints
            .zip(&solution.joint_loads)
            .map(|(joint, load)| {
                json!({
                    "name": joint.name,
                    "force": vector(&load.force),
                    "torque": vector(&load.torque),
                    "drive": load.drive,
                })
            })
            .collect();
        let flow = (solution.mean_flow.as_ref())
            .map(|flow| mean_flow_json(scene, flow, &solution.mean_flow_error));
        // Lists of thousands are moved: `json!` would copy them.
        let values = [
            ("bodies", Value::Array(bodies)),
            ("links", Value::Array(joints)),
            ("power", json!(solution.power())),
            ("mean_flow", json!(flow)),
        ];
        values
            .map(|(key, value)| (key.to_owned(), value))
            .into_iter()
            .collect()
    };
    let mut estimates = estimate(&solution.error_estimate);
    if let Value::Object(estimates) = &mut estimates {
        for (name, bars) in [
            ("angular_velocity", &solution.angular_velocity_error),
            ("force", &solution.force_error),
            ("torque", &solution.torque_error),
            ("power", &solution.power_error),
        ] {
            estimates.insert(name.to_owned(), estimate(bars));
        }
    }
    let stresslets = solution.stresslets.as_ref();
    if let (Some(error), Value::Object(estimates)) =
        (stresslets.and_then(|s| s.error), &mut estimates)
    {
        estimates.insert("stresslet".to_owned(), json!(error));
    }
    let uncorrected = (solution.mesh_error.as_ref()).map(|_| motion(&solution.uncorrected()));
    let mut json = json!({
        "model": model,
        "dofs": solution.dofs,
        "solver": solution.solver,
        "seconds": solution.seconds,
        "peak_rss_mib": peak_rss_mib(),
        "error_estimate": estimates,
        "uncorrected": uncorrected,
        "checks": solution.checks,
    });
    if let Value::Object(all) = &mut json {
        all.extend(motion(solution));
    }
    json
}

/// A mean flow through a periodic box with its pressure gradient; the one of both that the scene
/// gives has no error bars.
fn mean_flow_json(scene: &Scene, flow: &MeanFlow, bars: &ErrorEstimate) -> Value {
    let finds_flow = scene.finds_mean_flow();
    json!({
        "velocity": vector(&flow.velocity),
        "velocity_error": finds_flow.then(|| estimate(bars)),
        "pressure_gradient": vector(&flow.pressure_gradient),
        "pressure_gradient_error": (!finds_flow).then(|| estimate(bars)),
    })
}

/// A matrix as a list of its rows.
pub fn matrix_json(matrix: &DMatrix<f64>) -> Value {
    let row = |row: usize| -> Value { matrix.row(row).iter().copied().collect() };
    (0..matrix.nrows()).map(row).collect()
}

fn vector(v: &Vector3<f64>) -> Value {
    json!([v.x, v.y, v.z])
}

/// The estimated error sources, their sum, and the names of the sources without an estimate.
///
/// The sum is null, not zero, if no source was estimated.
fn estimate(estimate: &ErrorEstimate) -> Value {
    let mut map = Map::new();
    let mut missing = Vec::new();
    for (name, value) in estimate.sources() {
        match value {
            Some(value) => drop(map.insert(name.to_owned(), json!(value))),
            None => missing.push(name),
        }
    }
    map.insert("total".to_owned(), json!(estimate.estimated()));
    map.insert("not_estimated".to_owned(), json!(missing));
    Value::Object(map)
}

/// Name of the processor and number of threads in use.
pub fn processor() -> String {
    let name = std::fs::read_to_string("/proc/cpuinfo")
        .ok()
        .and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        })
        .unwrap_or_else(|| format!("unknown processor ({})", std::env::consts::ARCH));
    format!("{} threads of {name}", rayon::current_num_threads())
}

/// The peak resident memory of this process in MiB; none on systems other than Linux.
///
/// Source: the line `VmHWM` of `/proc/self/status`.
pub fn peak_rss_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024.0)
}
