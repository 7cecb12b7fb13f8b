//! Steady states of a scene in a fluid with inertia, in the frame of its bodies.

use std::time::Instant;

use axisymmetric::SteadyDrive;
use inertia::stokes::SurfaceFlow;
use inertia::{InertiaError, SteadyFlow, SteadyParameters};
use models::{AxialFlow, BodySolution, InstantaneousSolution, ModelError, MovingAxis, MovingScene};
use nalgebra::Vector3;
use rigid::Drive;
use scene::{Domain, Scene};

use crate::error::SwimError;
use crate::integrate::{COARSER, share_of_sizes};
use crate::observer::Progress;
use crate::planning::{Discretisation, discretisation};

/// A steady state and how it was found.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SteadySolution {
    /// Name of the model, as of `model.kind`: where the flow was computed.
    pub model: &'static str,
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

/// Reynolds number up to which usual meshes resolve the layers of vorticity at bodies.
///
/// Layers are as thick as the radius over the root of the Reynolds number, and above this number
/// elements become smaller with them. At 47 the drag on the usual mesh has an error of 2.8 %, and
/// its bar was 0.9 %.
const THICK_LAYERS: f64 = 10.0;

/// Bar over the difference between two meshes whose element sizes differ by [`COARSER`].
///
/// By the second order the error is 1.04 times the difference, by the fourth 0.35 times. Of the
/// speeds of squirmers with ratios of their modes from -3 to 3, densities of 0.1 to 10 and size
/// factors of 0.6 to 3 the error is at most 0.65 times the difference or [`FINER`] times the
/// other one, 0.2 times at the median (`docs/decisions.md`).
const BAR: f64 = 1.5;

/// Factor from the difference between the two coarser of three meshes to that of the two finer.
///
/// It is that of the second order, as for [`COARSER`]. Two meshes agree by accident where an error
/// changes its sign between them; the third then disagrees.
const FINER: f64 = 0.5;

/// Numbers of densities on the way, in the order in which they are tried.
const STAGES: [usize; 2] = [1, 4];

/// Distance of a centre from that of the ball, relative to its radius, that is none.
const CONCENTRIC: f64 = 1e-9;

/// The steady Navier-Stokes flow of a scene with the joints of its start.
///
/// Bodies that are all fixed are in a container of any shape. Bodies that move, one or several that
/// are linked, have a steady flow in the frame of the first one only: the container is a ball about
/// its centre, which moves with it, and whose wall is at rest in the laboratory.
///
/// By elements of increasing order in the meridian plane, to 1e-7, where the scene has an axis and
/// `model.kind` does not say otherwise. In space the error bars are from two coarser meshes.
///
/// # Errors
/// [`SwimError::NotApplicable`] for a scene without a density of the fluid or without a steady
/// state; [`SwimError::Inertia`] if none is found; errors of meshes.
pub fn solve_steady(
    scene: &Scene,
    progress: &mut dyn Progress,
) -> Result<SteadySolution, SwimError> {
    let moves = check(scene)?;
    match discretisation(scene)? {
        Discretisation::Meridian => {
            progress.works("the steady flow in the meridian plane", 0.0, 0.0);
            in_meridian_plane(scene, moves)
        }
        Discretisation::Spatial => in_space(scene, moves, progress),
    }
}

/// The steady state on meshes in space, with error bars from two coarser ones.
fn in_space(
    scene: &Scene,
    moves: bool,
    progress: &mut dyn Progress,
) -> Result<SteadySolution, SwimError> {
    MovingScene::check_convection(scene)?;
    // Parts of the work are in proportion to the cells.
    let [coarse_part, coarsest_part] = [COARSER.powi(-3), COARSER.powi(-6)];
    let all = 1.0 + coarse_part + coarsest_part;
    progress.works("the steady flow", 0.0, all);
    let mut steady = on_mesh(&MovingScene::new(scene)?, moves)?;
    let mut resolved = None;
    if scene.fem().size_factor.is_none() && steady.reynolds > THICK_LAYERS {
        let factor = (THICK_LAYERS / steady.reynolds).sqrt();
        let finer = scene.with_size_factor(Some(factor))?;
        let work = format!("the steady flow with fem.size_factor = {factor:.3}");
        progress.works(&work, 0.0, all);
        steady = on_mesh(&MovingScene::new(&finer)?, moves)?;
        resolved = Some(finer);
    }
    let scene = resolved.as_ref().unwrap_or(scene);
    // A flow that has no solution on a coarser mesh has no estimate of its error.
    let mut coarser =
        |factor: f64, done: f64| -> Result<Option<InstantaneousSolution>, SwimError> {
            progress.works(
                "the steady flow on a coarser mesh, for the error bar",
                done,
                all,
            );
            let moving = MovingScene::coarser(scene, factor)?;
            let found = moving.and_then(|moving| on_mesh(&moving, moves).ok());
            Ok(found.map(|steady| steady.solution))
        };
    let Some(coarse) = coarser(COARSER, 1.0)? else {
        return Ok(steady);
    };
    // Where there is no third mesh, two have to do.
    let coarsest = coarser(COARSER * COARSER, 1.0 + coarse_part)?;
    let fine = &mut steady.solution;
    let Some(share) = share_of_sizes([fine.dofs.total, coarse.dofs.total]) else {
        return Ok(steady);
    };
    let pairs = |of: &dyn Fn([&InstantaneousSolution; 2]) -> f64| {
        let next = coarsest.as_ref().map_or(0.0, |third| of([&coarse, third]));
        BAR * share * of([fine, &coarse]).max(FINER * next)
    };
    let largest = |of: fn(&BodySolution) -> Vector3<f64>| {
        pairs(&|[one, other]| {
            let bodies = one.bodies.iter().zip(&other.bodies);
            bodies.fold(0.0, |m: f64, (a, b)| m.max((of(a) - of(b)).norm()))
        })
    };
    let errors = [
        largest(|body| body.velocity),
        largest(|body| body.angular_velocity),
        largest(|body| body.force),
        largest(|body| body.torque),
        pairs(&|[one, other]| (one.power() - other.power()).abs()),
    ];
    enter_bars(fine, errors);
    Ok(steady)
}

/// Enters bars of velocities, angular velocities, forces, torques and the power.
fn enter_bars(solution: &mut InstantaneousSolution, bars: [f64; 5]) {
    for (estimate, bar) in solution.error_bars_mut().into_iter().zip(bars) {
        estimate.mesh = Some(bar);
    }
}

/// The steady state in the meridian plane, by elements whose order rises until it changes little.
fn in_meridian_plane(scene: &Scene, moves: bool) -> Result<SteadySolution, SwimError> {
    const TOLERANCE: f64 = 1e-7;
    /// Accepted where elements of the highest order do not reach the first.
    const MAX_TOLERANCE: f64 = 1e-3;
    let moving = MovingAxis::new(scene)?;
    let bodies = moving.bodies();
    let shape = scene.articulation().initial_shape();
    let at_rest = vec![0.0; shape.len()];
    let numbers = || 0..bodies.len();
    let velocities: Vec<f64> = numbers()
        .map(|body| moving.displacement_rate(0.0, shape, &at_rest, body))
        .collect();
    let loads: Vec<f64> = numbers().map(|body| moving.load(0.0, body)).collect();
    let slip = |body: usize, x: [f64; 2]| moving.slip(body, x);
    let drive = SteadyDrive {
        velocities: &velocities,
        loads: &loads,
        slip: moving.has_slip().then_some(&slip),
        wall_velocity: 0.0,
        moves_with_body: moves,
    };
    let clock = Instant::now();
    let parameters = axisymmetric::SteadyParameters::new(moving.density());
    let mut parameters = (parameters.with_tolerance(TOLERANCE)).with_accepted(MAX_TOLERANCE);
    if let Some(law) = moving.law() {
        parameters = parameters.with_law(law);
    }
    let found = axisymmetric::steady_state(bodies, moving.surroundings(), &drive, &parameters)
        .map_err(ModelError::from)?;
    let positions: Vec<f64> = bodies.iter().map(|body| body.shape.centre).collect();
    let flow = AxialFlow {
        time: 0.0,
        positions: &positions,
        velocities: &found.velocities,
        forces: &found.forces,
        momentum_rates: &[],
        slip_power: found.slip_power,
    };
    let mut solution = moving.answer(&flow, shape, (found.dofs, found.change))?;
    let total = clock.elapsed().as_secs_f64();
    solution.seconds.solve = total;
    solution.seconds.total = total;
    let error = found.relative_error;
    let set = scene.articulation();
    // Without joints or held bodies the forces are the given loads.
    let are_given = set.joints().is_empty() && set.held_bodies().next().is_none();
    let of_forces = if are_given { 0.0 } else { error };
    let bars = [
        moving.length_to_scene(error * found.speed),
        0.0,
        moving.force_to_scene(of_forces * found.force),
        0.0,
        // Of a product of both.
        moving.power_to_scene(2.0 * error * found.force * found.speed),
    ];
    enter_bars(&mut solution, bars);
    for bar in solution.error_bars_mut() {
        // The relative error contains the effect of a regularisation.
        bar.model.get_or_insert(0.0);
    }
    Ok(SteadySolution {
        model: "axisymmetric",
        reynolds: reynolds(scene, &solution),
        iterations: found.iterations,
        change: found.change,
        solution,
    })
}

/// Reynolds number of a steady state.
fn reynolds(scene: &Scene, solution: &InstantaneousSolution) -> f64 {
    let of_bodies = scene.bodies().iter().zip(&solution.bodies);
    let largest = of_bodies.map(|(body, motion)| {
        let slip = body.slip.map_or(0.0, |slip| slip.speed());
        motion.velocity.norm().max(slip) * body.bounding_radius()
    });
    largest.fold(0.0, f64::max) * scene.fluid_density() / scene.viscosity()
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
    if scene.rheology().is_some_and(|rheology| !rheology.is_kept()) {
        return refuse(
            "fluid.rheology",
            "steady states with inertia do not say what a neglected viscosity law would change; \
             set fluid.rheology = \"full\", or give the fluid a viscosity without a law",
        );
    }
    if scene.deforms() {
        return refuse(
            "bodies",
            "a body deforms, so that there is no steady state; `swim solve` gives Stokes flow",
        );
    }
    if scene.depends_on_time() {
        return refuse(
            "bodies",
            "a force, torque or velocity oscillates, so that there is no steady state; make it \
             constant",
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
fn on_mesh(moving: &MovingScene, moves_with_body: bool) -> Result<SteadySolution, SwimError> {
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
        moving,
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
    if let Some(law) = moving.law() {
        parameters = parameters.with_law(law);
    }
    let solve = |stages| flow.solve(&drive, moving.density(), &parameters.with_stages(stages));
    let mut found = match solve(STAGES[0]) {
        Err(InertiaError::NotSteady { .. } | InertiaError::Unresolved { .. }) => solve(STAGES[1])?,
        first => first?,
    };
    let solution = moving.answer(&mut found.solved, &poses, 0.0, Some(mesh))?;
    Ok(SteadySolution {
        model: "fem",
        reynolds: reynolds(moving.scene(), &solution),
        iterations: found.iterations,
        change: found.change,
        solution,
    })
}
