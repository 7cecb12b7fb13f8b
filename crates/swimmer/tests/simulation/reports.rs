//! JSON and CSV for other programs: every number stands under its own key, and in its own column.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rigid::{JointLoad, StateVelocity};
use serde_json::{Value, json};
use swimmer::models::Hydrodynamics;
use swimmer::models::{
    AccumulatedError, BodySolution, Checks, DiscretisationError, Dofs, ErrorEstimate, HoldingLoad,
    InstantaneousSolution, MeanFlow, NewMesh, Seconds, SolverReport, Uncertainty,
};
use swimmer::output::{solution_json, summary_json, trajectory_csv, trajectory_npy};
use swimmer::{
    Method, Motion, Observer, Outcome, PhaseSpan, Sample, Scene, SpanResult, SwimError, simulate,
};
use testkit::{SceneText, run_by, within};

use crate::support::{Tensor, TestModel};

/// Two spheres with an arm that closes, rests and opens, twice.
fn two_spheres() -> Scene {
    SceneText::new()
        .sphere("a", 1.0, [0; 3])
        .sphere("b, the large", 1.5, [5, 0, 0])
        .slide("arm", "b, the large", "a")
        .phase("link = \"arm\", length = 4, duration = 0.5")
        .phase("duration = 0.25")
        .phase("link = \"arm\", length = 5")
        .with("gait.cycles", 2)
        .model("rpy", 1e-4)
        .scene()
}

fn outcome(scene: &Scene) -> Outcome {
    run_by(&mut TestModel::new(scene, Tensor::Rpy), Method::Collocation)
}

/// A vector that no other number gives.
fn vector(number: f64) -> Vector3<f64> {
    Vector3::new(number, number + 0.25, number + 0.5)
}

fn list(number: f64) -> Value {
    json!([number, number + 0.25, number + 0.5])
}

/// An error estimate without that of the container.
fn estimate(unit: f64) -> ErrorEstimate {
    ErrorEstimate {
        mesh: Some(unit),
        container: None,
        model: Some(2.0 * unit),
        algebraic: Some(4.0 * unit),
        integration: Some(8.0 * unit),
    }
}

fn estimate_json(unit: f64) -> Value {
    json!({
        "mesh": unit,
        "model": 2.0 * unit,
        "algebraic": 4.0 * unit,
        "integration": 8.0 * unit,
        "total": 15.0 * unit,
        "not_estimated": ["container"],
    })
}

fn seconds(unit: f64) -> Seconds {
    Seconds {
        mesh: unit,
        assembly: 2.0 * unit,
        setup: 3.0 * unit,
        solve: 4.0 * unit,
        estimate: 5.0 * unit,
        total: 6.0 * unit,
    }
}

fn seconds_json(unit: f64, total: f64) -> Value {
    json!({
        "mesh": unit,
        "assembly": 2.0 * unit,
        "setup": 3.0 * unit,
        "solve": 4.0 * unit,
        "estimate": 5.0 * unit,
        "total": total,
    })
}

/// A report without the memory of this process.
fn without_memory(mut report: Value) -> Value {
    assert!(report.as_object_mut().unwrap().contains_key("peak_rss_mib"));
    report.as_object_mut().unwrap().remove("peak_rss_mib");
    report
}

#[test]
fn the_summary_has_every_number_of_the_outcome() {
    let scene = two_spheres();
    let mut outcome = outcome(&scene);
    outcome.displacement = vec![vector(1.0), vector(2.0)];
    outcome.mesh_error = Some(vec![vector(0.125), vector(0.25)]);
    outcome.rotation = vector(3.0);
    outcome.rotation_error = estimate(0.125);
    for (number, turning) in outcome
        .samples
        .last_mut()
        .unwrap()
        .turnings
        .iter_mut()
        .enumerate()
    {
        turning.angle = 5.0 + number as f64;
    }
    (outcome.solves, outcome.lookups, outcome.tables) = (41, 30, vec![9, 17]);
    outcome.error_estimate = estimate(0.5);
    outcome.work = 42.0;
    outcome.accumulated_error = Some(AccumulatedError {
        work: 2.5,
        ..AccumulatedError::default()
    });
    outcome.work_error = estimate(0.25);
    let held = |number: f64| HoldingLoad {
        body: 1,
        force: vector(number),
        torque: vector(number + 1.0),
    };
    // Over the duration 3.5.
    outcome.holding.bodies = vec![HoldingLoad {
        force: 3.5 * held(21.0).force,
        torque: 3.5 * held(21.0).torque,
        ..held(21.0)
    }];
    outcome.holding.force_error = estimate(3.5);
    outcome.holding.torque_error = estimate(7.0);
    outcome.tolerance_met = false;
    outcome.stopped = Some("where".to_owned());
    outcome.allowed_error = 0.375;
    outcome.seconds = seconds(1.0);
    outcome.meshes = vec![NewMesh {
        time: 0.75,
        phase: 2,
        reason: "a reason".to_owned(),
    }];
    for (number, span) in outcome.spans.iter_mut().enumerate() {
        let unit = number as f64;
        span.displacement = vec![vector(10.0 + unit), vector(20.0 + unit)];
        (span.solves, span.lookups) = (50 + number, 7);
        span.error_estimate = estimate(1.0 + unit);
    }
    let phases: Vec<Value> = (0..6)
        .map(|number| {
            let unit = f64::from(number);
            json!({
                "link": (number % 3 != 1).then_some("arm"),
                "displacement": { "a": list(10.0 + unit), "b, the large": list(20.0 + unit) },
                "solves": 43 + number,
                "lookups": 7,
                "error_estimate": estimate_json(1.0 + unit),
            })
        })
        .collect();
    let mut report = summary_json(&scene, "a model", &["why".to_owned()], &outcome, 77.0);
    let machine = report.as_object_mut().unwrap().remove("machine").unwrap();
    assert!(machine.is_string());
    let means = report
        .as_object_mut()
        .unwrap()
        .remove("mean_holding")
        .unwrap();
    for (key, exact) in [
        ("/bodies/b, the large/force/0", 21.0),
        ("/bodies/b, the large/force/2", 21.5),
        ("/bodies/b, the large/torque/1", 22.25),
        ("/force_error/total", 15.0),
        ("/torque_error/total", 30.0),
    ] {
        let found = means.pointer(key).and_then(Value::as_f64).expect(key);
        within(found - exact, 1e-14 * exact, "rounding");
    }
    assert_eq!(
        without_memory(report),
        json!({
            "scene": scene.name(),
            "bodies": ["a", "b, the large"],
            "links": ["arm"],
            "inertia": null,
            "version": env!("CARGO_PKG_VERSION"),
            "net_displacement": {
                "vector": [1.5, 1.75, 2.0],
                "length": 9.3125_f64.sqrt(),
                "error": estimate_json(0.5)["total"],
                "definition": "mean of the displacements of the centres of the bodies that move",
            },
            "displacement": { "a": list(1.0), "b, the large": list(2.0) },
            "rotation": list(3.0),
            "rotation_error": estimate_json(0.125),
            "turned": { "a": 5.0, "b, the large": 6.0 },
            "shape_change": null,
            "phases": phases,
            "solves": 41 - 30 + 9 + 17,
            "lookups": 30,
            "table_solves": 26,
            "error_estimate": estimate_json(0.5),
            "facet_errors": null,
            "uncorrected": {
                "displacement": {
                    "a": [1.125, 1.625, 2.125],
                    "b, the large": [2.25, 2.75, 3.25],
                },
                "work": 44.5,
            },
            "seconds": seconds_json(1.0, 77.0),
            "model": "a model",
            "reasons": ["why"],
            "cycles": 2,
            // Two cycles of 0.5 + 0.25 + 1.
            "duration": 3.5,
            "work": 42.0,
            "work_error": estimate_json(0.25),
            "tolerance": 1e-4,
            "tolerance_met": false,
            "tolerance_limits": "the error of the integration",
            "allowed_error": 0.375,
            "swimmers": null,
            "mean_flow": null,
            "stopped": "where",
            "repulsion": null,
            "thermal_noise": null,
            "meshes": [{ "time": 0.75, "phase": 2, "reason": "a reason" }],
        })
    );
    outcome.mesh_error = None;
    let report = summary_json(&scene, "a model", &[], &outcome, 77.0);
    assert_eq!(report["uncorrected"], Value::Null);
}

fn body(unit: f64) -> BodySolution {
    BodySolution {
        velocity: vector(unit),
        angular_velocity: vector(unit + 1.0),
        force: vector(unit + 2.0),
        torque: vector(unit + 3.0),
    }
}

#[test]
fn the_json_of_a_solution_has_every_number_of_it() {
    let scene = two_spheres();
    let motion = StateVelocity {
        frames: Vec::new(),
        spins: Vec::new(),
        joints: vec![],
    };
    let bodies = vec![body(10.0), body(20.0)];
    let load = JointLoad::new(vector(30.0), vector(31.0), 32.0);
    let mut solution = InstantaneousSolution::new(bodies, vec![load], motion);
    solution.dofs = Dofs {
        velocity: 3,
        pressure: 4,
        total: 9,
    };
    solution.solver = SolverReport {
        formulation: "p-tilde".to_owned(),
        solver: "block".to_owned(),
        iterations: 17,
        true_relative_residual: 1e-9,
    };
    solution.seconds = seconds(1.0);
    let mut checks = Checks::default();
    (checks.force_by_stress, checks.dissipation) = (0.01, 0.02);
    solution.checks = Some(checks);
    // Half of the numbers was subtracted.
    let mut error = DiscretisationError::between(&solution, &solution, Uncertainty::default());
    error.bodies = solution.bodies.clone();
    error.joint_loads = solution.joint_loads.clone();
    error.uncertainty.relative = 0.5;
    let twice = |v: &mut Vector3<f64>| *v *= 2.0;
    for body in &mut solution.bodies {
        [
            &mut body.velocity,
            &mut body.angular_velocity,
            &mut body.force,
            &mut body.torque,
        ]
        .into_iter()
        .for_each(twice);
    }
    for load in &mut solution.joint_loads {
        [&mut load.force, &mut load.torque]
            .into_iter()
            .for_each(twice);
        load.drive *= 2.0;
    }
    solution.correct(error);
    // Half of the larger of the errors of the two forces.
    assert_eq!(solution.force_error.mesh, Some(0.5 * vector(22.0).norm()));
    let spins = solution.angular_velocity_error.mesh;
    assert_eq!(spins, Some(0.5 * vector(21.0).norm()));
    assert_eq!(solution.torque_error.mesh, Some(0.5 * vector(23.0).norm()));
    (solution.error_estimate, solution.force_error) = (estimate(0.5), estimate(3.0));
    solution.power_error = estimate(5.0);
    solution.mean_flow = Some(MeanFlow {
        velocity: vector(40.0),
        pressure_gradient: vector(41.0),
    });
    solution.mean_flow_error = estimate(8.0);
    // The scene gives the flow, and not the gradient.
    let mean_flow = json!({
        "velocity": list(40.0),
        "velocity_error": null,
        "pressure_gradient": list(41.0),
        "pressure_gradient_error": estimate_json(8.0),
    });
    (solution.angular_velocity_error, solution.torque_error) = (estimate(6.0), estimate(7.0));
    let mut estimates = estimate_json(0.5);
    estimates["angular_velocity"] = estimate_json(6.0);
    estimates["force"] = estimate_json(3.0);
    estimates["torque"] = estimate_json(7.0);
    estimates["power"] = estimate_json(5.0);
    // The sum of the products of velocities and forces.
    let product = |a: f64, b: f64| vector(a).dot(&vector(b));
    let power: f64 = [10.0, 20.0]
        .map(|unit| product(unit, unit + 2.0) + product(unit + 1.0, unit + 3.0))
        .iter()
        .sum();
    let body_json = |name: &str, unit: f64| {
        json!({
            "name": name,
            "velocity": list(unit),
            "angular_velocity": list(unit + 1.0),
            "force": list(unit + 2.0),
            "torque": list(unit + 3.0),
            "holding_force": null,
            "holding_torque": null,
            "stresslet": null,
        })
    };
    let link = |drive: f64| json!({ "name": "arm", "force": list(30.0), "torque": list(31.0), "drive": drive });
    let twice = |mut value: Value| {
        for entry in value.as_object_mut().unwrap().values_mut() {
            for number in entry.as_array_mut().into_iter().flatten() {
                *number = json!(2.0 * number.as_f64().unwrap());
            }
        }
        value
    };
    let uncorrected = json!({
        "bodies": [twice(body_json("a", 10.0)), twice(body_json("b, the large", 20.0))],
        "links": [twice(link(64.0))],
        "power": 4.0 * power,
        "mean_flow": mean_flow,
    });
    assert_eq!(
        without_memory(solution_json(&scene, "a model", &solution)),
        json!({
            "model": "a model",
            "bodies": [body_json("a", 10.0), body_json("b, the large", 20.0)],
            "links": [link(32.0)],
            "power": power,
            "mean_flow": mean_flow,
            "dofs": { "velocity": 3, "pressure": 4, "total": 9 },
            "solver": {
                "formulation": "p-tilde",
                "solver": "block",
                "iterations": 17,
                "true_relative_residual": 1e-9,
            },
            "seconds": seconds_json(1.0, 6.0),
            "error_estimate": estimates,
            "uncorrected": uncorrected,
            "checks": { "force_by_stress": 0.01, "dissipation": 0.02 },
        })
    );
}

/// A total of 0 beside "not_estimated" with all sources was taken for an exact result.
#[test]
fn bug_errors_that_were_not_estimated_had_a_total_of_zero() {
    let scene = two_spheres();
    let mut outcome = outcome(&scene);
    outcome.error_estimate = ErrorEstimate::default();
    let summary = summary_json(&scene, "a model", &[], &outcome, 1.0);
    let estimate = &summary["error_estimate"];
    assert!(estimate["total"].is_null(), "{estimate}");
    assert_eq!(estimate["not_estimated"].as_array().unwrap().len(), 5);
    // A bar that was estimated as zero is another thing.
    outcome.error_estimate.integration = Some(0.0);
    let summary = summary_json(&scene, "a model", &[], &outcome, 1.0);
    assert_eq!(summary["error_estimate"]["total"], json!(0.0));
}

#[test]
fn the_trajectory_has_every_number_of_the_samples_in_its_own_column() {
    let scene = two_spheres();
    let mut samples = outcome(&scene).samples;
    // Two cycles of three phases, with solves in each: all phase span numbers occur.
    assert!((0..6).all(|span| samples.iter().any(|s| s.span == span && s.bodies.is_some())));
    for (number, sample) in samples.iter_mut().enumerate() {
        let unit = 100.0 * number as f64;
        sample.shape = vec![unit + 7.0];
        for (body, pose) in sample.poses.iter_mut().enumerate() {
            let rotation = UnitQuaternion::from_scaled_axis(0.01 * vector(body as f64));
            *pose = Isometry3::from_parts(Translation3::from(vector(unit + body as f64)), rotation);
            // Four full turns more, in the direction of the rotation vector.
            let turns = 4.0 * TAU * rotation.scaled_axis().normalize();
            sample.turnings[body].vector = rotation.scaled_axis() + turns;
        }
        let loads = sample.bodies.iter_mut().chain(&mut sample.interpolated);
        for (number, entry) in loads.flatten().enumerate() {
            *entry = body(unit + 10.0 * (number + 1) as f64);
        }
    }
    let csv = trajectory_csv(&scene, &samples);
    binary_has_the_numbers_of_the_text(&scene, &samples, &csv);
    let names = [
        "x", "y", "z", "rx", "ry", "rz", "vx", "vy", "vz", "wx", "wy", "wz", "fx", "fy", "fz",
        "tx", "ty", "tz",
    ];
    let columns = |body: &str| names.map(|name| body.replace('*', name)).join(",");
    let header = format!(
        "time,cycle,phase,arm.length,{},{},solved",
        columns("a.*"),
        columns("\"b, the large.*\"")
    );
    let mut lines = csv.lines();
    assert_eq!(lines.next().unwrap(), header);
    assert_eq!(csv.lines().count(), samples.len() + 1);
    for (line, sample) in lines.zip(&samples) {
        let row: Vec<&str> = line.split(',').collect();
        let number = |k: usize| row[k].parse::<f64>().unwrap();
        assert_eq!(number(0), sample.time);
        assert_eq!(number(1) as usize, sample.span / 3 + 1);
        assert_eq!(number(2) as usize, sample.span % 3 + 1);
        assert_eq!(number(3), sample.shape[0]);
        assert_eq!(number(40), f64::from(u8::from(sample.bodies.is_some())));
        for (body, pose) in sample.poses.iter().enumerate() {
            let first = 4 + 18 * body;
            let vector = |k: usize| Vector3::from_fn(|axis, _| number(first + 3 * k + axis));
            assert_eq!(vector(0), pose.translation.vector);
            let expected = 0.01 * self::vector(body as f64);
            let expected = expected + 4.0 * TAU * expected.normalize();
            assert!((vector(1) - expected).norm() < 1e-12);
            let bodies = sample.loads().unwrap();
            let found = [2, 3, 4, 5].map(vector);
            let body = &bodies[body];
            let expected = [
                body.velocity,
                body.angular_velocity,
                body.force,
                body.torque,
            ];
            assert_eq!(found, expected);
        }
    }
}

/// The array of NumPy has a header, whose length makes the data begin at a multiple of 64 bytes,
/// and the numbers of the text, by quantity and then by body.
fn binary_has_the_numbers_of_the_text(scene: &Scene, samples: &[Sample], csv: &str) {
    let bytes = trajectory_npy(scene, samples);
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let begin = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!(begin % 64, 0);
    let header = std::str::from_utf8(&bytes[10..begin]).unwrap();
    let of_bodies = "position rotation velocity angular_velocity force torque"
        .split(' ')
        .map(|name| format!(", ('{name}', '<f8', (2, 3))"));
    let expected = format!(
        "{{'descr': [('time', '<f8'), ('cycle', '<u4'), ('phase', '<u4'), ('solved', '|b1'), \
         ('joints', '<f8', (1,)){}], 'fortran_order': False, 'shape': ({},), }}",
        of_bodies.collect::<String>(),
        samples.len()
    );
    assert_eq!(header.trim_end(), expected);
    assert!(header.ends_with('\n'));
    let record = 8 + 4 + 4 + 1 + 8 + 6 * 2 * 3 * 8;
    assert_eq!(bytes.len(), begin + record * samples.len());
    let records = bytes[begin..].chunks_exact(record);
    for (record, line) in records.zip(csv.lines().skip(1)) {
        let row: Vec<&str> = line.split(',').collect();
        let number = |at: usize| f64::from_le_bytes(record[at..at + 8].try_into().unwrap());
        let count = |at: usize| u32::from_le_bytes(record[at..at + 4].try_into().unwrap());
        assert_eq!(number(0).to_string(), row[0]);
        assert_eq!([count(8).to_string(), count(12).to_string()], row[1..3]);
        assert_eq!(record[16].to_string(), row[row.len() - 1]);
        assert_eq!(number(17).to_string(), row[3]);
        for (quantity, body, axis) in
            (0..6).flat_map(|q| (0..2).flat_map(move |b| (0..3).map(move |x| (q, b, x))))
        {
            let found = number(25 + 8 * (6 * quantity + 3 * body + axis));
            let written = row[4 + 18 * body + 3 * quantity + axis];
            assert_eq!(
                found,
                written.parse::<f64>().unwrap(),
                "{quantity} {body} {axis}"
            );
        }
    }
}

/// Collects the motion of a run.
#[derive(Default)]
struct Collector(Motion);

impl Observer for Collector {
    fn span_done(
        &mut self,
        span: &PhaseSpan,
        result: &SpanResult,
        _: &Outcome,
        _: &mut dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        self.0.append(span, result);
        Ok(())
    }
}

#[test]
fn the_motion_of_a_run_has_the_positions_of_its_samples_and_solutions_at_any_time() {
    let scene = two_spheres();
    let set = scene.articulation();
    let mut model = TestModel::new(&scene, Tensor::Rpy);
    let mut collector = Collector::default();
    let outcome = simulate(&scene, &mut model, Method::Collocation, &mut collector).unwrap();
    let stored = serde_json::to_value(&collector.0).unwrap();
    let motion: Motion = serde_json::from_value(stored).unwrap();
    for sample in &outcome.samples {
        let moment = motion.at(&scene, sample.time).unwrap();
        within(
            moment.time - sample.time,
            1e-12,
            "rounding of sums of durations",
        );
        let poses = set.place(&moment.state, &moment.shape).unwrap();
        for (found, expected) in poses.iter().zip(&sample.poses) {
            let apart = (found.translation.vector - expected.translation.vector).norm();
            within(apart, 1e-12, "rounding");
        }
    }
    // Solves are at states of the iteration, which differ from the path by the tolerance 1e-4.
    // Between them and the ends the forces, which change by a fifth along an arm that closes by
    // one, are those of a polynomial. At another phase they have the opposite sign or vanish.
    let mut compare = |time: f64, expected: &[BodySolution], allowed: f64| {
        let found = motion.solve(&scene, &mut model, time).unwrap();
        for (found, expected) in found.bodies.iter().zip(expected) {
            let largest = expected.force.norm();
            within(
                (found.force - expected.force).norm(),
                allowed * largest,
                "forces",
            );
        }
    };
    for sample in &outcome.samples {
        if let Some(solved) = &sample.bodies {
            compare(sample.time, solved, 1e-3);
        }
    }
    let [first, last] = [outcome.samples.first(), outcome.samples.last()].map(Option::unwrap);
    for row in [first, last] {
        assert!(row.bodies.is_none());
        compare(row.time, row.loads().unwrap(), 2e-2);
    }
    for time in [-0.1, f64::NAN, 1.1 * last.time] {
        let error = motion.at(&scene, time).unwrap_err().to_string();
        let known = format!("known from 0 to {}", scene.gait().duration());
        assert!(error.contains(&known), "{error}");
    }
    let heavy =
        Scene::parse("bodies = [{ name = \"a\", radius = 1, mass = 1, position = [0, 0, 0] }]\n");
    let heavy = heavy.unwrap();
    let mut model = TestModel::new(&heavy, Tensor::Rpy);
    let error = Motion::default()
        .solve(&heavy, &mut model, 0.0)
        .unwrap_err();
    assert!(
        error.to_string().contains("do not determine the flow"),
        "{error}"
    );
}

/// Rows at equal intervals of time lie on the path of the run: positions follow from velocities,
/// and the forces on a free swimmer vanish in sum.
#[test]
fn the_trajectory_at_equal_times_has_motions_and_loads_in_every_row() {
    let scene = SceneText::new()
        .sphere("a", 1.0, [0; 3])
        .sphere("b", 1.5, [5, 0, 0])
        .slide("arm", "b", "a")
        .phase("link = \"arm\", length = 4, duration = 0.5")
        .phase("link = \"arm\", length = 5, duration = 1.5")
        .with("gait.cycles", 2)
        .with("output.samples", 400)
        .model("rpy", 1e-4)
        .scene();
    let methods = [
        Method::Collocation,
        Method::RungeKutta,
        Method::Euler { steps: 200 },
    ];
    for method in methods {
        let mut model = TestModel::new(&scene, Tensor::Rpy);
        let outcome = run_by(&mut model, method);
        let rows = &outcome.uniform_samples;
        assert_eq!(rows.len(), 401);
        let step = scene.gait().duration() / 400.0;
        for (number, row) in rows.iter().enumerate() {
            within(row.time - number as f64 * step, 1e-12, "the time");
            let bodies = row.bodies.as_ref().unwrap();
            let force: Vector3<f64> = bodies.iter().map(|body| body.force).sum();
            let largest = bodies
                .iter()
                .map(|body| body.force.norm())
                .fold(0.0, f64::max);
            within(
                force.norm(),
                1e-9 * largest,
                "rounding of a sum that vanishes",
            );
        }
        let (first, last) = (&rows[0], rows.last().unwrap());
        assert_eq!(
            first.poses[0].translation.vector,
            scene.bodies()[0].position
        );
        let end = outcome.samples.last().unwrap();
        let apart = (end.poses[1].translation.vector - last.poses[1].translation.vector).norm();
        within(apart, 1e-12, "rounding of the end");
        // Trapezoidal rule within phases, which end at rows: the second derivative of the velocity
        // is below 1 (an arm of 4 to 5, a rate of 2), a twelfth of it over three units of time,
        // times the square of the step.
        for pair in rows.windows(2).filter(|pair| pair[0].span == pair[1].span) {
            let velocity = |row: &Sample| row.bodies.as_ref().unwrap()[1].velocity;
            let moved = pair[1].poses[1].translation.vector - pair[0].poses[1].translation.vector;
            let mean = 0.5 * (velocity(&pair[0]) + velocity(&pair[1]));
            within((moved / step - mean).norm(), 1e-2, format!("{method:?}"));
        }
    }
}
