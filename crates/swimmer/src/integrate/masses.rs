//! Masses and momenta of bodies.

use std::f64::consts::PI;

use models::BodyInertia;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector6};
use rigid::{ExternalLoad, Reduction, State};
use scene::{Gait, Scene, spans};

use super::span_evaluator::{SpanEvaluator, SpanSolution};
use crate::error::SwimError;

/// Velocities `(U, ω)` of all bodies of the scene.
pub(super) type Velocities = Vec<Vector6<f64>>;

/// The velocities of bodies at rest.
pub(super) fn at_rest(scene: &Scene) -> Velocities {
    vec![Vector6::zeros(); scene.bodies().len()]
}

/// The velocities as one list, six numbers per body.
pub(super) fn numbers_of(velocities: &Velocities) -> Vec<f64> {
    velocities.iter().flatten().copied().collect()
}

/// Parts of a phase at whose ends the radii of bodies count.
const PARTS_OF_PHASE: u32 = 8;

/// Mass over Stokes drag of a lone sphere with the smallest bounding radius in the first cycle.
///
/// Zero without masses. Among others and near walls bodies relax faster. Cost: that of all phases.
pub(crate) fn relaxation_time(scene: &Scene) -> f64 {
    if !scene.has_masses() {
        return 0.0;
    }
    let gait = Gait {
        cycles: 1,
        ..scene.gait().clone()
    };
    let start = scene.articulation().initial_shape();
    let mut shapes = vec![start.to_vec()];
    // the gait of a scene has no errors
    for span in spans(&gait, start).into_iter().flatten() {
        let parts = (1..=PARTS_OF_PHASE).map(|k| f64::from(k) / f64::from(PARTS_OF_PHASE));
        shapes.extend(parts.map(|s| span.shape(s)));
    }
    let times = scene.bodies().iter().filter_map(|body| {
        let (mass, _) = body.mass_matrix()?;
        let radii = shapes.iter().map(|shape| body.bounding_radius_at(shape));
        let radius = radii.fold(f64::INFINITY, f64::min);
        Some(mass / (6.0 * PI * scene.viscosity() * radius))
    });
    times.fold(0.0, f64::max)
}

/// Velocities of the bodies in a solution.
pub(super) fn velocities_of(solution: &SpanSolution) -> Velocities {
    let twist = |body: &models::BodySolution| {
        let mut twist = Vector6::zeros();
        twist.fixed_rows_mut::<3>(0).copy_from(&body.velocity);
        twist
            .fixed_rows_mut::<3>(3)
            .copy_from(&body.angular_velocity);
        twist
    };
    solution.solution.bodies.iter().map(twist).collect()
}

/// The terms of an implicit step of this `time` from known momenta: `dp/dt = (M U - p) / time`.
pub(super) fn implicit_terms(
    masses: &[Matrix6<f64>],
    known: &Velocities,
    time: f64,
) -> Vec<BodyInertia> {
    let scale = 1.0 / time;
    let term = |(mass, momentum): (&Matrix6<f64>, &Vector6<f64>)| {
        let load = scale * momentum;
        BodyInertia {
            damping: scale * mass,
            load: ExternalLoad {
                force: load.fixed_rows::<3>(0).into(),
                torque: load.fixed_rows::<3>(3).into(),
            },
        }
    };
    masses.iter().zip(known).map(term).collect()
}

/// Mass matrices of all bodies in the laboratory axes; zero for bodies without mass.
pub(super) fn mass_matrices(
    evaluator: &SpanEvaluator,
    s: f64,
    state: &State,
) -> Result<Vec<Matrix6<f64>>, SwimError> {
    let scene = evaluator.scene;
    let shape = evaluator.span.shape(s);
    let poses = scene.articulation().place(state, &shape)?;
    let matrix = |(body, pose): (&scene::Body, &nalgebra::Isometry3<f64>)| {
        let mut matrix = Matrix6::zeros();
        if let Some((mass, inertia)) = body.mass_matrix_at(&shape) {
            let rotation = pose.rotation.to_rotation_matrix();
            let inertia = rotation.matrix() * inertia * rotation.matrix().transpose();
            (matrix.fixed_view_mut::<3, 3>(0, 0)).copy_from(&(mass * Matrix3::identity()));
            matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
        }
        matrix
    };
    Ok(scene.bodies().iter().zip(&poses).map(matrix).collect())
}

/// Power `U·(dM/dt) U / 2` of bodies that change their size and rotate.
///
/// It is the part of the power of the inertia, `U·d(M U)/dt`, that is no kinetic energy: what the
/// mass of a body gives off when it moves outwards.
pub(super) fn power_of_growth(
    evaluator: &SpanEvaluator,
    s: f64,
    masses: &[Matrix6<f64>],
    velocities: &Velocities,
) -> f64 {
    let (shape, rates) = (evaluator.span.shape(s), evaluator.span.rates(s));
    let bodies = evaluator.scene.bodies().iter();
    let power = |((body, mass), velocity): ((&scene::Body, &Matrix6<f64>), &Vector6<f64>)| {
        let turning = velocity.fixed_rows::<3>(3);
        let momentum = mass.fixed_view::<3, 3>(3, 3) * turning;
        body.growth_rate(&shape, &rates) * turning.dot(&momentum)
    };
    (bodies.zip(masses).zip(velocities)).map(power).sum()
}

pub(super) fn momenta(
    evaluator: &SpanEvaluator,
    s: f64,
    state: &State,
    velocities: &Velocities,
) -> Result<Velocities, SwimError> {
    let masses = mass_matrices(evaluator, s, state)?;
    Ok(masses.iter().zip(velocities).map(|(m, u)| m * u).collect())
}

/// The velocities after the impulse by which joints enforce the rates at the start of the phase
/// span.
///
/// Of all velocities `S v + W` that the joints allow, those are taken whose momenta differ from
/// those before by an impulse of the joints alone: `S^T M (S v + W - U) = 0`.
pub(super) fn after_impulse(
    evaluator: &SpanEvaluator,
    state: &State,
    velocities: &Velocities,
) -> Result<Velocities, SwimError> {
    let set = evaluator.scene.articulation();
    let (shape, rates) = (evaluator.span.shape(0.0), evaluator.span.rates(0.0));
    let constraints =
        evaluator
            .scene
            .constraints(state, &shape, &rates, evaluator.span.time(0.0))?;
    let reduction = Reduction::new(set, &constraints)?;
    let masses = mass_matrices(evaluator, 0.0, state)?;
    let surfaced: Vec<usize> = (0..masses.len())
        .filter(|&body| evaluator.scene.bodies()[body].bounding_radius() > 0.0)
        .collect();
    let (basis, offset) = (&reduction.surface_basis, &reduction.surface_offset);
    let mut mass = DMatrix::zeros(basis.ncols(), basis.ncols());
    let mut rhs = DVector::zeros(basis.ncols());
    for (number, &body) in surfaced.iter().enumerate() {
        let rows = basis.fixed_rows::<6>(6 * number);
        mass += rows.transpose() * (masses[body] * rows);
        let difference = velocities[body] - offset.fixed_rows::<6>(6 * number);
        rhs += rows.transpose() * (masses[body] * difference);
    }
    // Motions without mass follow the flow at once, whatever they are here.
    let scale = mass.amax();
    let v = match mass.svd(true, true).solve(&rhs, 1e-12 * scale) {
        Ok(v) => v,
        Err(_) => DVector::zeros(basis.ncols()),
    };
    let after = basis * v + offset;
    let mut result = velocities.clone();
    for (number, &body) in surfaced.iter().enumerate() {
        result[body] = after.fixed_rows::<6>(6 * number).into();
    }
    Ok(result)
}
