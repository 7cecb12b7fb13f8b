//! Steady states by Newton's method and elements of increasing order.

use nalgebra::DMatrix;

use super::bodies::{AxialBody, check, check_growth, check_length, domain, motions};
use super::flow_system::{Balance, BoundaryVelocity, Fields, FlowSystem, Terms};
use super::momentum::Coefficients;
use super::orders::{GROWTH, raise_order};
use crate::curve::Point;
use crate::generate::generate;
use crate::meridian::Meridian;
use crate::surface_modes::normal;
use crate::{AxisymmetricError, Surroundings};

/// The velocity of a surface relative to its body, along the axis and away from it, at a point
/// relative to the centre of the body.
pub type Slip<'a> = &'a (dyn Fn(usize, [f64; 2]) -> [f64; 2] + Sync);

/// What drives a steady flow.
#[derive(Clone, Copy, Default)]
pub struct SteadyDrive<'a> {
    /// Velocity of each body along the axis: of a prescribed body in the laboratory, of a free one
    /// relative to its swimmer. Empty if all are zero.
    pub velocities: &'a [f64],
    /// External force along the axis on each body. Empty if all are zero.
    pub loads: &'a [f64],
    /// Slip of the surfaces.
    pub slip: Option<Slip<'a>>,
    /// Velocity of the wall along the axis, in the laboratory.
    pub wall_velocity: f64,
    /// Whether the fluid domain moves with the first body, walls included.
    ///
    /// The flow is then steady in its frame: fluid enters and leaves through the boundary of the
    /// domain, at the velocity that the walls have in the laboratory.
    pub moves_with_body: bool,
}

/// Parameters of a steady state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SteadyParameters {
    /// Density of the fluid, at viscosity 1.
    pub density: f64,
    /// Largest estimated error of velocities and forces, relative to the largest ones.
    pub tolerance: f64,
    /// Edge length relative to the distance from the focus of the nearest body.
    ///
    /// Boundary layers at walls need a small one, as the mesh is graded for bodies.
    pub growth: f64,
}

impl SteadyParameters {
    /// The Navier-Stokes equations with this density, to 1e-6.
    pub fn new(density: f64) -> Self {
        Self {
            density,
            tolerance: 1e-6,
            growth: GROWTH,
        }
    }

    /// The same with another tolerance.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// The same with a mesh that is graded otherwise.
    #[must_use]
    pub fn with_growth(self, growth: f64) -> Self {
        Self { growth, ..self }
    }
}

/// A steady state.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SteadyState {
    /// Velocity of each body along the axis, in the laboratory.
    pub velocities: Vec<f64>,
    /// Force that each body exerts on the fluid.
    pub forces: Vec<f64>,
    /// Power of the slip of all surfaces on the fluid.
    pub slip_power: f64,
    /// Estimated error of velocities and forces, relative to `speed` and `force`: the last change
    /// of the order.
    pub relative_error: f64,
    /// Largest velocity of the fluid.
    pub speed: f64,
    /// Largest force, or the drag of the largest body at that velocity if that is larger.
    pub force: f64,
    /// Polynomial degree of the velocities.
    pub order: usize,
    /// Number of unknowns.
    pub dofs: usize,
    /// Iterations of Newton's method, of all orders.
    pub iterations: usize,
    /// Relative change of the velocity in the last of them.
    pub change: f64,
}

/// Relative change at which Newton's method ends; rounding is a hundredth of it.
const NEWTON_TOLERANCE: f64 = 1e-11;

/// Finds the steady flow around bodies on one axis in a container.
///
/// Navier-Stokes equations at viscosity 1 with elements of increasing order on one mesh, until the
/// results change by less than the tolerance. Newton's method starts from Stokes flow; where it
/// does not converge, the density is increased in steps. The velocities of free bodies are unknowns
/// of the same system, with the balance of the forces as their equations.
///
/// Cost: a few seconds for 1e-6.
///
/// ```
/// use axisymmetric::{AxialBody, AxialSpheroid, Surroundings};
/// use axisymmetric::{SteadyDrive, SteadyParameters, steady_state};
///
/// // A neutral squirmer in a ball that moves with it: its speed does not depend on inertia.
/// let squirmer = AxialBody::free(AxialSpheroid::sphere(0.0, 1.0), 1.0, 0);
/// let slip = |_: usize, [z, r]: [f64; 2]| [-1.5 * r * r, 1.5 * z * r];
/// let drive = SteadyDrive { slip: Some(&slip), moves_with_body: true, ..SteadyDrive::default() };
/// let parameters = SteadyParameters::new(5.0).with_tolerance(1e-5);
/// let ball = Surroundings::Ball { radius: 10.0 };
/// let found = steady_state(&[squirmer], ball, &drive, &parameters)?;
/// // The exact speed in a ball: Stokes flow, whose vorticity over r is constant.
/// let l: f64 = 0.1;
/// let exact = (1.0 - 2.5 * l.powi(3) + 1.5 * l.powi(5)) / (1.0 - l.powi(5));
/// assert!((found.velocities[0] - exact).abs() < 1e-5);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
///
/// # Errors
/// [`AxisymmetricError::NoContainer`], [`AxisymmetricError::NotSteady`],
/// [`AxisymmetricError::FlowNotConverged`], numbers out of range, lists that do not fit the
/// bodies, and domains that cannot be meshed.
pub fn steady_state(
    bodies: &[AxialBody],
    surroundings: Surroundings,
    drive: &SteadyDrive,
    parameters: &SteadyParameters,
) -> Result<SteadyState, AxisymmetricError> {
    check("the density of the fluid", parameters.density)?;
    check_growth(parameters.growth)?;
    let problem = Problem::new(bodies, surroundings, drive, parameters.density)?;
    let solve = |order: usize, lower: Option<&Level>| {
        let system = problem.system(parameters.growth, order)?;
        let (fields, mut state) = problem.solve(&system, lower)?;
        state.order = order;
        state.iterations += lower.map_or(0, |level| level.state.iterations);
        Ok(Level {
            system,
            fields,
            state,
        })
    };
    let (level, error) = raise_order(parameters.tolerance, solve, |before, after| {
        difference(&before.state, &after.state)
    })?;
    Ok(SteadyState {
        relative_error: error,
        ..level.state
    })
}

/// The steady state by elements of one order.
struct Level {
    system: FlowSystem,
    fields: Fields,
    state: SteadyState,
}

/// A steady flow, before it is discretised.
struct Problem<'a> {
    bodies: &'a [AxialBody],
    drive: &'a SteadyDrive<'a>,
    density: f64,
    meridian: Meridian,
    motions: Vec<Option<usize>>,
    n_motions: usize,
    velocities: Vec<f64>,
    /// External forces on the free motions.
    loads: Vec<f64>,
}

impl<'a> Problem<'a> {
    fn new(
        bodies: &'a [AxialBody],
        surroundings: Surroundings,
        drive: &'a SteadyDrive<'a>,
        density: f64,
    ) -> Result<Self, AxisymmetricError> {
        let meridian = domain(bodies, surroundings)?;
        let list = |what, given: &[f64]| {
            if given.is_empty() {
                return Ok(vec![0.0; bodies.len()]);
            }
            check_length(what, bodies.len(), given.len())?;
            match given.iter().find(|value| !value.is_finite()) {
                None => Ok(given.to_vec()),
                Some(&value) => Err(AxisymmetricError::InvalidNumber {
                    what,
                    value,
                    range: "finite",
                }),
            }
        };
        let velocities = list("velocities", drive.velocities)?;
        let (motions, n_motions) = motions(bodies);
        let mut loads = vec![0.0; n_motions];
        for (motion, load) in motions.iter().zip(list("loads", drive.loads)?) {
            if let Some(motion) = motion {
                loads[*motion] += load;
            }
        }
        Ok(Self {
            bodies,
            drive,
            density,
            meridian,
            motions,
            n_motions,
            velocities,
            loads,
        })
    }

    fn system(&self, growth: f64, order: usize) -> Result<FlowSystem, AxisymmetricError> {
        let mesh = generate(&self.meridian, growth)?;
        let frame = match self.drive.moves_with_body {
            true => self.motions[0],
            false => None,
        };
        FlowSystem::new(mesh, order, self.motions.clone(), self.n_motions, frame)
    }

    /// The steady state by elements of one order, from that of a lower order or from Stokes flow.
    fn solve(
        &self,
        system: &FlowSystem,
        lower: Option<&Level>,
    ) -> Result<(Fields, SteadyState), AxisymmetricError> {
        let positions = system.positions();
        let slip = match self.drive.slip {
            Some(slip) => system.slip(&positions, |body, x| {
                let shape = &self.bodies[body].shape;
                let from_centre = [x.x - shape.centre, x.y];
                [
                    Point::from(slip(body, from_centre)),
                    Point::from(normal(shape, x)),
                ]
            })?,
            None => Vec::new(),
        };
        if let Some(value) = slip.iter().flatten().find(|value| !value.is_finite()) {
            return Err(AxisymmetricError::InvalidNumber {
                what: "the slip of a surface",
                value: *value,
                range: "finite",
            });
        }
        let boundary = BoundaryVelocity {
            bodies: self.velocities.clone(),
            slip,
            wall: self.drive.wall_velocity,
        };
        // the velocity of the frame that is not that of its free motion
        let frame = match self.drive.moves_with_body {
            true => self.velocities[0],
            false => 0.0,
        };
        let mesh_velocity = vec![frame; positions.len()];
        let balance = Balance {
            matrix: DMatrix::zeros(self.n_motions, self.n_motions),
            load: self.loads.clone(),
        };
        let terms = |density: f64| Terms {
            coefficients: Coefficients {
                convection: density,
                mass: 0.0,
            },
            mesh_velocity: Some(&mesh_velocity),
            history: None,
        };
        let (mut fields, mut reached) = match lower {
            Some(level) => {
                let start = system.interpolated(&level.system, &level.fields);
                (start, self.density)
            }
            None => (system.rest(), 0.0),
        };
        system.set_boundary(&boundary, &mut fields);
        let (mut iterations, mut step) = (0, self.density);
        let last_change = loop {
            let mut found = fields.clone();
            let mut factors = None;
            let (count, change) = system.solve(
                &positions,
                &mut found,
                &terms(reached),
                &balance,
                &mut factors,
                NEWTON_TOLERANCE,
            )?;
            iterations += count;
            let converged = change <= NEWTON_TOLERANCE;
            if converged {
                fields = found;
                if reached == self.density {
                    break change;
                }
            } else {
                reached -= step;
                step *= 0.5;
                // a step that is a hundredth of the density makes progress impossible
                if lower.is_some() || step < 0.01 * self.density || reached < 0.0 {
                    return Err(AxisymmetricError::NotSteady {
                        density: self.density,
                        reached: reached.max(0.0),
                        change,
                    });
                }
            }
            reached = (reached + step).min(self.density);
        };
        let residual = system.residual(&positions, &fields, &terms(self.density))?;
        let forces = system.forces(&residual);
        let speed = largest(fields.velocity.iter().map(|u| u.amax()));
        let sizes = self.bodies.iter();
        let size = largest(sizes.map(|b| b.shape.axial.max(b.shape.equatorial)));
        let drag = 6.0 * std::f64::consts::PI * size * speed;
        let state = SteadyState {
            velocities: system.body_velocities(&fields, &boundary),
            slip_power: (boundary.slip.iter().zip(&residual.momentum))
                .map(|(slip, force)| slip.dot(force))
                .sum(),
            relative_error: f64::INFINITY,
            speed,
            force: largest(forces.iter().copied()).max(drag),
            forces,
            order: 0,
            dofs: system.n_dofs(),
            iterations,
            change: last_change,
        };
        Ok((fields, state))
    }
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, f64::max)
}

/// Difference of the velocities and forces of two states, relative to the sizes of the second.
fn difference(before: &SteadyState, after: &SteadyState) -> f64 {
    let change = |a: &[f64], b: &[f64]| largest(a.iter().zip(b).map(|(a, b)| a - b));
    let relative = |change: f64, size: f64| if change > 0.0 { change / size } else { 0.0 };
    relative(change(&before.velocities, &after.velocities), after.speed)
        .max(relative(change(&before.forces, &after.forces), after.force))
}
