//! Solutions and runs of scenes, by the model that the scene chooses or by a given one.

use std::cell::Cell;
use std::path::Path;

use models::{Configuration, Hydrodynamics, InstantaneousSolution};
use nalgebra::{DMatrix, Vector3};
use rigid::State;
use scene::Scene;
use swimmer::{Method, Outcome, PhaseSpan, Progress, Report, SpanResult, SwimError};

/// The model that a scene chooses.
pub fn boxed(scene: &Scene) -> Box<dyn Hydrodynamics> {
    swimmer::choose(scene).expect("a supported scene").model
}

/// The gait of a scene by the model and the method that it chooses.
pub fn run(scene: &Scene) -> Outcome {
    run_by(boxed(scene).as_mut(), Method::from_scene(scene))
}

/// The gait of the scene of a model.
pub fn run_by(model: &mut dyn Hydrodynamics, method: Method) -> Outcome {
    let scene = model.scene().clone();
    swimmer::simulate(&scene, model, method, &mut ()).unwrap_or_else(|error| panic!("{error}"))
}

/// The solution at the start of a scene, by the model that it chooses.
pub fn start(scene: &Scene) -> InstantaneousSolution {
    start_by(boxed(scene).as_mut())
}

/// The solution of a model at the start of its scene.
pub fn start_by(model: &mut dyn Hydrodynamics) -> InstantaneousSolution {
    let scene = model.scene().clone();
    swimmer::solve_start(&scene, model).unwrap_or_else(|error| panic!("{error}"))
}

/// The grand resistance matrix at the start of a scene, by the model that it chooses.
pub fn start_resistance(scene: &Scene) -> DMatrix<f64> {
    let resistance = swimmer::start_resistance(scene, boxed(scene).as_mut());
    resistance.expect("a resistance")
}

/// A configuration of bodies.
pub fn at<'a>(state: &'a State, shape: &'a [f64]) -> Configuration<'a> {
    Configuration::new(state, shape)
}

/// The solution of a model for a shape, with the bodies where they are at the start.
pub fn solve_at(
    model: &mut dyn Hydrodynamics,
    shape: &[f64],
    rates: &[f64],
) -> InstantaneousSolution {
    let state = &model.scene().initial_state();
    let solution = model.solve_one(at(state, shape), rates);
    solution.expect("a solution")
}

/// Sum and largest norm of the forces of all bodies.
pub fn forces(solution: &InstantaneousSolution) -> (Vector3<f64>, f64) {
    let forces = || solution.bodies.iter().map(|body| body.force);
    (
        forces().sum(),
        forces().map(|f| f.norm()).fold(0.0, f64::max),
    )
}

/// Interrupts a run after some phases.
struct After(Cell<usize>);

impl Progress for After {
    fn is_interrupted(&self) -> bool {
        self.0.get() == 0
    }

    fn span_done(&mut self, _: &PhaseSpan, _: &SpanResult) {
        self.0.set(self.0.get().saturating_sub(1));
    }
}

/// Interrupts a run after `phases` phases, those of earlier attempts included; its checkpoint is in
/// the folder.
///
/// Returns the number of completed phases of the last attempt.
pub fn interrupted(scene: Scene, phases: usize, folder: &Path) -> usize {
    let mut progress = After(Cell::new(phases));
    match swimmer::run(scene, folder, false, &mut (), &mut progress) {
        Err(SwimError::Interrupted { phases, .. }) => phases,
        other => panic!("not interrupted: {other:?}"),
    }
}

/// A run with files that is interrupted after its first phase, and resumed from its checkpoint.
pub fn resumed_after_one_phase(scene: impl Fn() -> Scene) -> Report {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(interrupted(scene(), 1, folder.path()), 1);
    swimmer::run(scene(), folder.path(), true, &mut (), &mut ()).unwrap()
}
