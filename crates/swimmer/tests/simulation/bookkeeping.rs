//! Counts, times, meshes and samples of a run.

use nalgebra::Vector3;
use swimmer::models::{Hydrodynamics, Remesh, Seconds};
use swimmer::{
    Method, Observer, Outcome, PhaseSpan, Scene, SpanSolution, SwimError, simulate, spans,
};
use testkit::{Recording, within};

use crate::accumulated::stroke;
use crate::support::{Tensor, TestModel};

const SECONDS: Seconds = Seconds {
    mesh: 1.0,
    assembly: 2.0,
    setup: 3.0,
    solve: 4.0,
    estimate: 5.0,
    total: 16.0,
};

const REMESHED: usize = 20;

/// Time and phase of the solution on a new mesh.
#[derive(Default)]
struct Remeshed(Option<(f64, usize)>);

impl Observer for Remeshed {
    fn solved(
        &mut self,
        span: &PhaseSpan,
        solution: &SpanSolution,
        _: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        if solution.number == REMESHED {
            self.0 = Some((span.start + solution.s * span.duration, span.number + 1));
        }
        Ok(())
    }
}

/// The stroke by the test model, with given computing times, whose twentieth solution is on a new
/// mesh; and the number of solutions.
fn follow(observer: &mut Remeshed) -> (Outcome, usize) {
    let mut solves = 0;
    let model = TestModel::new(&stroke(), Tensor::Rpy);
    let mut model = Recording::changing(model, |_, solutions| {
        for solution in solutions {
            solution.seconds = SECONDS;
            solution.remeshed = (solves == REMESHED).then_some(Remesh::First);
            solves += 1;
        }
    });
    let outcome = simulate(&stroke(), &mut model, Method::Collocation, observer).unwrap();
    drop(model);
    (outcome, solves)
}

#[test]
fn solves_seconds_and_meshes_of_all_spans_are_counted() {
    let mut observer = Remeshed::default();
    let (outcome, solves) = follow(&mut observer);
    assert_eq!(outcome.solves, solves);
    let of_spans: Vec<usize> = outcome.spans.iter().map(|span| span.solves).collect();
    assert_eq!(of_spans.iter().sum::<usize>(), solves);
    assert!(of_spans.len() == 4 && of_spans.iter().all(|&solves| solves >= 3));
    let times = |s: Seconds| [s.mesh, s.assembly, s.setup, s.solve, s.estimate, s.total];
    // Integers, so that the sums are exact.
    let expected = times(SECONDS).map(|seconds| solves as f64 * seconds);
    assert_eq!(times(outcome.seconds), expected);
    // The mesh has the time and the phase of its solve.
    let (time, phase) = observer.0.unwrap();
    assert!(phase > 1 && time > 0.5);
    let [mesh] = &outcome.meshes[..] else {
        panic!("{:?}", outcome.meshes)
    };
    assert_eq!((mesh.time, mesh.phase), (time, phase));
    assert_eq!(mesh.reason, Remesh::First.to_string());
}

#[test]
fn samples_and_curve_are_the_trajectory_at_their_times() {
    let (outcome, _) = follow(&mut Remeshed::default());
    let scene = stroke();
    let initial = scene.articulation().initial_shape();
    let all: Vec<PhaseSpan> = spans(scene.gait(), initial).unwrap().collect();
    let lengths_at = |time: f64| {
        let span = all
            .iter()
            .find(|span| time <= span.start + span.duration + 1e-12);
        let span = span.unwrap();
        span.shape((time - span.start) / span.duration)
    };
    let arms = |x: &[Vector3<f64>]| [(x[0] - x[1]).norm(), (x[2] - x[1]).norm()];
    let check = |time: f64, positions: &[Vector3<f64>]| {
        for (found, expected) in arms(positions).into_iter().zip(lengths_at(time)) {
            within(found - expected, 1e-13, "rounding of lengths of about ten");
        }
    };
    for samples in outcome.samples.windows(2) {
        assert!(samples[0].time < samples[1].time);
    }
    let mut on_curve = 0;
    for sample in &outcome.samples {
        let positions: Vec<_> = sample
            .poses
            .iter()
            .map(|pose| pose.translation.vector)
            .collect();
        check(sample.time, &positions);
        for (found, expected) in sample.shape.iter().zip(arms(&positions)) {
            within(found - expected, 1e-13, "rounding of lengths of about ten");
        }
        for (time, curve) in &outcome.curve {
            if (time - sample.time).abs() < 1e-12 {
                on_curve += 1;
                for (a, b) in curve.iter().zip(&positions) {
                    within((a - b).norm(), 1e-10, "the polynomial of the curve");
                }
            }
        }
    }
    // At least at the start and the ends of the four phase spans.
    assert!(on_curve >= 5, "{on_curve}");
    for points in outcome.curve.windows(2) {
        assert!(points[0].0 < points[1].0);
    }
    for (time, positions) in &outcome.curve {
        check(*time, positions);
    }
    let [first, last] = [outcome.curve.first(), outcome.curve.last()].map(|point| point.unwrap().0);
    assert_eq!((first, last), (0.0, scene.gait().duration()));
}

#[test]
fn a_run_without_files_has_the_result_of_one_with_files() {
    let text = include_str!("../../templates/three-sphere.toml");
    let folder = tempfile::tempdir().unwrap();
    let parsed = || Scene::parse(text).unwrap();
    let with_files = swimmer::run(parsed(), folder.path(), false, &mut (), &mut ()).unwrap();
    let without = swimmer::run_without_files(parsed(), &mut ()).unwrap();
    assert_eq!(
        without.outcome.displacement,
        with_files.outcome.displacement
    );
    assert_eq!(without.outcome.solves, with_files.outcome.solves);

    /// Stops a run after its first solve.
    struct Stop;
    impl swimmer::Progress for Stop {
        fn is_interrupted(&self) -> bool {
            true
        }
    }
    let stopped = swimmer::run_without_files(parsed(), &mut Stop);
    assert!(matches!(stopped, Err(SwimError::Interrupted { .. })));
}
