//! Steady states of a scene in a fluid with inertia, in the frame of its bodies.

use inertia::stokes::SurfaceFlow;
use inertia::{InertiaError, SteadyFlow, SteadyParameters};
use models::{InstantaneousSolution, MovingScene};
use nalgebra::Vector3;
use rigid::Drive;
use scene::{Domain, Scene};

use crate::error::SwimError;

/// A steady state and how it was found.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SteadySolution {
    /// Velocities in the laboratory, forces, and their error bars.
    pub solution: InstantaneousSolution,
    /// Reynolds number `ρ U a / μ`, the largest of a body with the radius `a` and the speed `U`, or
    /// the speed of its slip if that is larger.
    pub reynolds: f64,
    /// Iterations for the nonlinear equations.
    pub iterations: usize,
    /// Relative change of the velocity in the last of them.
    pub change: f64,
}

/// Factor on the element sizes of the mesh that the error bar is from.
///
/// With errors of the second order, which is what is left of the third or fourth where wakes are
/// under-resolved, those on this mesh are twice as large, and the difference between both meshes is
/// the error.
const COARSER: f64 = 1.4;

/// Bar over the difference between both meshes.
///
/// Of eleven exact forces and speeds at Reynolds numbers up to 20 the error is 0.3 to 1.13 times
/// the difference (test `steady_states_are_exact_within_their_bars`).
const BAR: f64 = 2.0;

/// Numbers of densities on the way, in the order in which they are tried.
const STAGES: [usize; 2] = [1, 4];

/// Distance of a centre from that of the ball, relative to its radius, that is none.
const CONCENTRIC: f64 = 1e-9;

/// The steady Navier-Stokes flow of a scene with the joints of its start.
///
/// Bodies that are all fixed are in a container of any shape. Bodies that move, one or several that
/// are linked, have a steady flow in the frame of the first one only: the container is a ball about
/// its centre, which moves with it, and whose wall is at rest in the laboratory. Error bars are
/// from a coarser mesh.
///
/// # Errors
/// [`SwimError::NotApplicable`] for a scene without a density of the fluid or without a steady
/// state; [`SwimError::Inertia`] if none is found; errors of meshes.
pub fn solve_steady(scene: &Scene) -> Result<SteadySolution, SwimError> {
    let moves = check(scene)?;
    let mut steady = on_mesh(scene, moves)?;
    let factor = COARSER * scene.fem().size_factor.unwrap_or(1.0);
    if !matches!(scene.domain(), Domain::Mesh { .. }) {
        let coarse = on_mesh(&scene.with_size_factor(Some(factor))?, moves)?;
        let (fine, coarse) = (&mut steady.solution, &coarse.solution);
        let bodies = || fine.response.bodies.iter().zip(&coarse.response.bodies);
        let largest = |of: &dyn Fn(&models::BodySolution) -> Vector3<f64>| {
            BAR * bodies().fold(0.0, |m: f64, (a, b)| m.max((of(a) - of(b)).norm()))
        };
        let errors = [
            largest(&|body| body.velocity),
            largest(&|body| body.angular_velocity),
            largest(&|body| body.force),
            largest(&|body| body.torque),
        ];
        let power = BAR * (fine.power() - coarse.power()).abs();
        fine.error_estimate.mesh = Some(errors[0]);
        fine.angular_velocity_error.mesh = Some(errors[1]);
        fine.force_error.mesh = Some(errors[2]);
        fine.torque_error.mesh = Some(errors[3]);
        fine.power_error.mesh = Some(power);
    }
    Ok(steady)
}

/// Refuses a scene without a steady state; whether the frame moves with the first body.
fn check(scene: &Scene) -> Result<bool, SwimError> {
    let refuse = |key: &str, problem: &str| {
        Err(SwimError::NotApplicable {
            place: format!("{}: {key}", scene.place(key)),
            problem: problem.to_owned(),
        })
    };
    if scene.fluid_density() <= 0.0 {
        return refuse(
            "fluid.density",
            "a steady state in a fluid with inertia needs its density; without it `swim solve` \
             gives Stokes flow",
        );
    }
    if scene.background().is_some() {
        return refuse(
            "background",
            "steady states with inertia have no background flow; give bodies a velocity instead",
        );
    }
    if !scene.domain().is_container() {
        return refuse(
            "domain.kind",
            "a steady state with inertia needs a container; choose a ball, a box or a surface",
        );
    }
    if scene.bodies().iter().all(|body| body.fixed) {
        return Ok(false);
    }
    if scene.articulation().linkages().len() > 1 {
        return refuse(
            "bodies",
            "bodies that are not linked move apart, and there is no steady state; link or fix them",
        );
    }
    let centre = scene
        .bodies()
        .first()
        .map_or(0.0, |body| body.position.norm());
    match scene.domain() {
        Domain::Ball { radius } if centre <= CONCENTRIC * radius => Ok(true),
        _ => refuse(
            "domain.kind",
            "a body that moves has a steady flow in its frame only: choose domain.kind = \"ball\" \
             about the centre of the first body, or fix the bodies",
        ),
    }
}

/// The slip of the bodies of a scene at its start.
struct Slip<'a> {
    moving: &'a MovingScene,
    centres: &'a [Vector3<f64>],
}

impl SurfaceFlow for Slip<'_> {
    fn slip(&self, body: usize, x: &Vector3<f64>) -> Vector3<f64> {
        self.moving.slip(body, &(x - self.centres[body]))
    }

    fn background(&self, _: &Vector3<f64>) -> Vector3<f64> {
        Vector3::zeros()
    }

    fn background_pressure(&self, _: &Vector3<f64>) -> f64 {
        0.0
    }
}

/// The steady state on the mesh of a scene.
fn on_mesh(scene: &Scene, moves_with_body: bool) -> Result<SteadySolution, SwimError> {
    let moving = MovingScene::new(scene)?;
    let set = moving.set();
    let (state, shape) = (set.initial_state(), set.initial_shape());
    let poses = set.place(&state, shape)?;
    let surfaced: Vec<_> = moving.surfaced().map(|body| poses[body]).collect();
    let mesh = moving.meshes()?.renewed(&surfaced)?;
    let centres: Vec<_> = surfaced
        .iter()
        .map(|pose| pose.translation.vector)
        .collect();
    let names = moving.surface_names().iter().map(String::as_str);
    let bodies: Vec<_> = names.zip(centres.iter().copied()).collect();
    let walls: Vec<&str> = moving.walls().iter().map(String::as_str).collect();
    let slip = Slip {
        moving: &moving,
        centres: &centres,
    };
    let flow = SteadyFlow {
        mesh: &mesh,
        bodies: &bodies,
        walls: &walls,
        slip: moving.has_slip().then_some(&slip as &dyn SurfaceFlow),
        wall_velocity: None,
        moves_with_body,
    };
    let joints = set.constraints(&state, shape, &vec![0.0; shape.len()])?;
    let drive = Drive {
        set,
        constraints: &moving.constraints(0.0, joints)?,
        loads: &moving.loads(0.0, &poses),
    };
    let mut parameters = SteadyParameters::default();
    parameters.options = moving.options();
    let solve = |stages| flow.solve(&drive, moving.density(), &parameters.with_stages(stages));
    let mut found = match solve(STAGES[0]) {
        Err(InertiaError::NotSteady { .. } | InertiaError::Stokes(_)) => solve(STAGES[1])?,
        first => first?,
    };
    let solution = moving.answer(&mut found.solved, &poses, Some(mesh))?;
    let of_bodies = scene.bodies().iter().zip(&solution.bodies);
    let reynolds = of_bodies.map(|(body, motion)| {
        let slip = body.slip.map_or(0.0, |slip| slip.speed());
        motion.velocity.norm().max(slip) * body.bounding_radius()
    });
    Ok(SteadySolution {
        reynolds: reynolds.fold(0.0, f64::max) * scene.fluid_density() / scene.viscosity(),
        iterations: found.iterations,
        change: found.change,
        solution,
    })
}
