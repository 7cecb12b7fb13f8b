//! A steady flow around bodies on one axis, and its solution by elements of one order.

use std::f64::consts::PI;

use nalgebra::DMatrix;
use rheology::{Law, ViscosityLaw};

use super::bodies::{AxialBody, check_length, domain, motions, shapes};
use super::drive::{SteadyDrive, SteadyParameters};
use super::energy::ROUNDING;
use super::flow_system::{Balance, BoundaryVelocity, Fields, FlowSystem, Residual, Terms};
use super::momentum::Coefficients;
use super::nested_condensation::CondensedFactors;
use super::orders::FIRST_ORDER;
use super::response::Responses;
use super::viscosity::{Unregularised, Viscosity};
use crate::curve::Point;
use crate::generate::generate;
use crate::meridian::Meridian;
use crate::surface_modes::normal;
use crate::{AxisymmetricError, Surroundings};

/// Smallest relative change at which Newton's method ends; rounding is a hundredth of it.
const NEWTON_TOLERANCE: f64 = 1e-11;

/// Part of the tolerance at which Newton's method for a law ends: where the fluid hardly moves, a
/// steep law takes tens of iterations from there on to the smallest change.
const NEWTON_SHARE: f64 = 1e-4;

/// Changes of a flow to first order in what is changed.
pub(super) struct FirstOrderChange {
    /// Of the velocities of the bodies.
    pub velocities: Vec<f64>,
    /// Of their forces on the fluid.
    pub forces: Vec<f64>,
    /// Power of what is changed, relative to a drag.
    pub size: f64,
}

/// Part of a tolerance that neglecting a law in unbounded fluid beyond the mesh may take.
pub(super) const SHARE_OUTSIDE: f64 = 0.1;

/// A steady flow, before it is discretised.
pub(super) struct Problem<'a> {
    bodies: Vec<AxialBody>,
    drive: SteadyDrive<'a>,
    density: f64,
    law: Option<&'a dyn ViscosityLaw>,
    /// Viscosity without a law.
    constant: f64,
    /// Relative change at which Newton's method for the law ends.
    newton_tolerance: f64,
    growth: f64,
    meridian: Meridian,
    motions: Vec<Option<usize>>,
    n_motions: usize,
    /// Prescribed velocities of the bodies.
    velocities: Vec<f64>,
    /// External forces on the free motions.
    loads: Vec<f64>,
}

/// A steady state.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SteadyState {
    /// Velocity of each body along the axis, in the laboratory.
    pub velocities: Vec<f64>,
    /// Force that each body exerts on the fluid.
    pub forces: Vec<f64>,
    /// Power of the surfaces of bodies and of the wall on the fluid.
    pub power: f64,
    /// Power of the slip of all surfaces on the fluid.
    pub slip_power: f64,
    /// Dissipation `∫ 2 η D:D` in the fluid that is meshed; without inertia it is the power.
    pub dissipation: f64,
    /// Estimated error of velocities and forces, relative to `speed` and `force`: the last change
    /// of the order, and what the regularisation of a viscosity law and neglecting it far away
    /// change.
    pub relative_error: f64,
    /// Largest velocity of the fluid.
    pub speed: f64,
    /// Largest force, or the drag of the largest body at that velocity if that is larger.
    pub force: f64,
    /// Polynomial degree of the velocities.
    pub order: usize,
    /// Number of degrees of freedom.
    pub dofs: usize,
    /// Iterations of Newton's method, of all orders.
    pub iterations: usize,
    /// Relative change of the velocity in the last of them.
    pub change: f64,
}

/// A flow by elements of one order.
pub(super) struct Level {
    system: FlowSystem,
    positions: Vec<Point>,
    fields: Fields,
    /// Factors of the last matrix, without inertia.
    factors: Option<CondensedFactors>,
    /// Velocities, forces and powers, without an error; iterations are those of all orders so far.
    pub state: SteadyState,
    /// Estimated relative error by the viscosity of the fluid outside the mesh.
    pub outside: f64,
    /// Power of what the law changes about the viscosity at rest, relative to a drag; zero in
    /// containers.
    pub excess: f64,
    /// Relative change of the power by the regularisation of the viscosity law.
    pub regularised: f64,
}

/// Values at the nodes of a triangle.
pub(crate) struct TriangleValues {
    pub positions: Vec<Point>,
    pub velocities: Vec<Point>,
    pub pressures: Vec<f64>,
}

impl Level {
    /// The flow on each triangle.
    fn triangles(&self) -> impl Iterator<Item = TriangleValues> + '_ {
        let [velocities, pressures] = &self.system.spaces;
        velocities
            .nodes
            .iter()
            .zip(&pressures.nodes)
            .map(|(u, p)| TriangleValues {
                positions: u
                    .iter()
                    .map(|&node| self.positions[node as usize])
                    .collect(),
                velocities: u
                    .iter()
                    .map(|&node| self.fields.velocity[node as usize])
                    .collect(),
                pressures: p
                    .iter()
                    .map(|&node| self.fields.pressure[node as usize])
                    .collect(),
            })
    }
}

impl<'a> Problem<'a> {
    pub fn new(
        bodies: &[AxialBody],
        surroundings: Surroundings,
        drive: &SteadyDrive<'a>,
        parameters: &SteadyParameters<'a>,
    ) -> Result<Self, AxisymmetricError> {
        let meridian = match surroundings {
            Surroundings::Unbounded if parameters.density == 0.0 => {
                check_plateau(parameters.law)?;
                Meridian::new(&shapes(bodies), surroundings)?
            }
            _ => domain(bodies, surroundings)?,
        };
        let list = |what, given: &[f64]| match given.is_empty() {
            true => Ok(vec![0.0; bodies.len()]),
            false => finite_list(what, bodies.len(), given),
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
            bodies: bodies.to_vec(),
            drive: *drive,
            density: parameters.density,
            law: parameters.law,
            constant: 1.0,
            newton_tolerance: (NEWTON_SHARE * parameters.tolerance).max(NEWTON_TOLERANCE),
            growth: parameters.growth,
            meridian,
            motions,
            n_motions,
            velocities,
            loads,
        })
    }

    /// Prescribes other velocities.
    ///
    /// # Errors
    /// Velocities that are not one finite number per body.
    pub fn set_velocities(&mut self, velocities: &[f64]) -> Result<(), AxisymmetricError> {
        self.velocities = finite_list("velocities", self.bodies.len(), velocities)?;
        Ok(())
    }

    /// Multiplies the lengths of edges by a factor, unless `growth` falls below the least one;
    /// whether it did.
    pub fn refine(&mut self, factor: f64, least: f64) -> bool {
        let growth = factor * self.growth;
        let can = growth > least * (1.0 - f64::EPSILON.sqrt());
        if can {
            self.growth = growth;
        }
        can
    }

    /// Enlarges the mesh of unbounded fluid until neglecting the law beyond it changes forces by
    /// this part.
    ///
    /// # Errors
    /// Those of [`Problem::solve`]; [`AxisymmetricError::NoPlateau`].
    pub fn choose_open_radius(&mut self, tolerance: f64) -> Result<(), AxisymmetricError> {
        self.enlarge_until(|level| level.outside <= tolerance)
    }

    /// Enlarges the mesh of unbounded fluid until neglecting the change of the viscosity beyond it
    /// takes this part of all of it.
    ///
    /// # Errors
    /// As [`Problem::choose_open_radius`].
    pub fn choose_open_radius_for_change(
        &mut self,
        tolerance: f64,
    ) -> Result<(), AxisymmetricError> {
        self.enlarge_until(|level| level.outside <= tolerance * level.excess)
    }

    fn enlarge_until(
        &mut self,
        is_enough: impl Fn(&Level) -> bool,
    ) -> Result<(), AxisymmetricError> {
        /// Largest radius relative to the one of Stokes flow.
        const MAX_FACTOR: f64 = 2048.0;
        let (Some(law), Some(_)) = (self.law, self.meridian.open_radius()) else {
            return Ok(());
        };
        let mut factor = 1.0;
        loop {
            if is_enough(&self.solve(FIRST_ORDER, None)?) {
                return Ok(());
            }
            factor *= 2.0;
            if factor > MAX_FACTOR {
                return Err(AxisymmetricError::NoPlateau {
                    viscosity: law.unregularised_viscosity(0.0),
                });
            }
            self.meridian = self.meridian.clone().enlarged(2.0);
        }
    }

    /// The same flow at the viscosity that the law has at rest.
    pub fn newtonian(self) -> Self {
        Self {
            constant: self.law.map_or(self.constant, |law| law.viscosity(0.0)),
            law: None,
            ..self
        }
    }

    /// The terms of a flow without inertia whose viscosity has this law beside the constant part.
    fn terms_of_law<'b>(&self, law: Option<&'b dyn ViscosityLaw>) -> Terms<'b> {
        Terms {
            coefficients: Coefficients {
                viscosity: Viscosity {
                    law,
                    ..Viscosity::constant(self.constant)
                },
                ..Coefficients::default()
            },
            ..Terms::default()
        }
    }

    /// Changes of velocities and forces, to first order, if the viscosity of a Newtonian flow
    /// changes to that of a law.
    ///
    /// The form `∫ 2 (η(g) - η_0) D(u):D(v)` of the Newtonian flow `u` is a load on the same linear
    /// system. By the reciprocal theorem the change of a velocity is minus its value for the flow
    /// `v` of a unit force in place of the motion; one solution for the load has all of them.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`], [`AxisymmetricError::SingularElement`].
    pub fn first_order_change(
        &self,
        level: &Level,
        law: &dyn ViscosityLaw,
    ) -> Result<FirstOrderChange, AxisymmetricError> {
        let Level {
            system,
            positions,
            fields,
            ..
        } = level;
        let newtonian = self.terms_of_law(None);
        // by the same quadrature, so that its errors are those of the change only
        let rest = Law::Newtonian {
            viscosity: self.constant,
        };
        let terms = self.terms_of_law(Some(law));
        let mut load = system.residual(positions, fields, &terms)?;
        load.subtract(&system.residual(positions, fields, &self.terms_of_law(Some(&rest)))?);
        let factors = system.factor(positions, fields, &newtonian, &self.no_loads())?;
        let [velocities, forces] = self.change_by(&load, level, &newtonian, &factors)?;
        let (size, speed) = (self.size(), level.state.speed);
        Ok(FirstOrderChange {
            velocities,
            forces,
            size: system.relative_excess(positions, fields, &terms, size, speed)?,
        })
    }

    /// Changes of the velocities and the forces of bodies, to first order, by a load on the
    /// momentum of a flow without inertia.
    fn change_by(
        &self,
        load: &Residual,
        level: &Level,
        terms: &Terms,
        factors: &CondensedFactors,
    ) -> Result<[Vec<f64>; 2], AxisymmetricError> {
        let system = &level.system;
        let change = system.change(&system.rest(), load, &self.no_loads(), factors);
        let own = system.forces(load);
        let of_change = system.forces_of_change(&level.positions, &level.fields, terms, &change)?;
        let velocities = (self.motions.iter())
            .map(|motion| motion.map_or(0.0, |g| change.motions[g]))
            .collect();
        let forces = own.iter().zip(of_change).map(|(a, b)| a + b).collect();
        Ok([velocities, forces])
    }

    /// Changes of the velocities and the forces of bodies, to first order and without inertia, if
    /// the law loses its regularisation.
    ///
    /// The stress that the regularisation takes away is a load on the linearised flow. Its power is
    /// a bound for bodies that move alike only: around bodies with slip it is that of the slip.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`], [`AxisymmetricError::SingularElement`].
    pub fn change_by_regularisation(
        &self,
        level: &Level,
    ) -> Result<[Vec<f64>; 2], AxisymmetricError> {
        let Some(law) = self.law.filter(|_| level.regularised > 0.0) else {
            let none = vec![0.0; self.bodies.len()];
            return Ok([none.clone(), none]);
        };
        let unregularised = Unregularised(law);
        let mut regular = self.terms_of_law(Some(law));
        regular.coefficients.viscosity.constant = self.viscosity().constant;
        let mut exact = regular;
        exact.coefficients.viscosity.law = Some(&unregularised);
        let (system, positions, fields) = (&level.system, &level.positions, &level.fields);
        let mut load = system.residual(positions, fields, &exact)?;
        load.subtract(&system.residual(positions, fields, &regular)?);
        match &level.factors {
            Some(factors) => self.change_by(&load, level, &regular, factors),
            None => {
                let factors = system.factor(positions, fields, &regular, &self.no_loads())?;
                self.change_by(&load, level, &regular, &factors)
            }
        }
    }

    /// Effect of the regularisation on velocities and forces, relative to `speed` and `force` of
    /// the state.
    ///
    /// # Errors
    /// Those of [`Problem::change_by_regularisation`].
    pub fn effect_of_regularisation(&self, level: &Level) -> Result<f64, AxisymmetricError> {
        let changes = self.change_by_regularisation(level)?;
        let none = [0, 1].map(|k| vec![0.0; changes[k].len()]);
        let effect = self.relative_difference(&none, &changes, level);
        // The linearised flow has no inertia.
        Ok(match self.density > 0.0 {
            true => effect.max(level.regularised),
            false => effect,
        })
    }

    fn system(&self, order: usize) -> Result<FlowSystem, AxisymmetricError> {
        let mesh = generate(&self.meridian, self.growth)?;
        let frame = match self.drive.moves_with_body {
            true => self.motions[0],
            false => None,
        };
        let motions = self.motions.clone();
        let open_sphere = self.meridian.open_sphere();
        FlowSystem::new(mesh, order, motions, self.n_motions, frame, open_sphere)
    }

    /// The viscosity of the fluid; that at rest is its constant part where there is an open
    /// boundary.
    fn viscosity(&self) -> Viscosity<'a> {
        let Some(law) = self.law else {
            return Viscosity::constant(self.constant);
        };
        let constant = match self.meridian.open_radius() {
            Some(_) => law.viscosity(0.0),
            None => 0.0,
        };
        Viscosity {
            law: Some(law),
            ..Viscosity::constant(constant)
        }
    }

    /// The flow by elements of one order, from that of the same or a lower order or from a
    /// Newtonian flow.
    ///
    /// # Errors
    /// [`AxisymmetricError::LawNotSolved`], [`AxisymmetricError::NotSteady`], slip that is not
    /// finite, domains that cannot be meshed.
    pub fn solve(&self, order: usize, lower: Option<&Level>) -> Result<Level, AxisymmetricError> {
        let system = self.system(order)?;
        let positions = system.positions();
        let start = lower.map(|level| system.interpolated(&level.system, &level.fields));
        let iterations = lower.map_or(0, |level| level.state.iterations);
        self.solve_on(system, positions, start, false, order, iterations)
    }

    /// The flow after a change of the prescribed velocities, from its linear responses.
    ///
    /// # Errors
    /// Those of [`Problem::solve`].
    pub fn solve_again(&self, from: Level) -> Result<Level, AxisymmetricError> {
        let responses = self.responses(&from)?;
        let mut start = from.fields;
        for ((new, old), flow) in
            (self.velocities.iter().zip(&from.state.velocities)).zip(&responses.flows)
        {
            start.add(flow, new - old);
        }
        let (order, iterations) = (from.state.order, from.state.iterations);
        self.solve_on(
            from.system,
            from.positions,
            Some(start),
            true,
            order,
            iterations,
        )
    }

    /// The linear responses of a flow without inertia to the velocities of its bodies.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`], [`AxisymmetricError::SingularElement`].
    pub fn responses(&self, level: &Level) -> Result<Responses, AxisymmetricError> {
        let terms = Terms {
            coefficients: Coefficients {
                viscosity: self.viscosity(),
                ..Coefficients::default()
            },
            ..Terms::default()
        };
        let Level {
            system,
            positions,
            fields,
            ..
        } = level;
        match &level.factors {
            Some(factors) => system.responses(positions, fields, &terms, factors),
            None => {
                let factors = system.factor(positions, fields, &terms, &self.balance())?;
                system.responses(positions, fields, &terms, &factors)
            }
        }
    }

    /// The balance of changes at the same loads.
    fn no_loads(&self) -> Balance {
        Balance {
            load: vec![0.0; self.n_motions],
            ..self.balance()
        }
    }

    fn balance(&self) -> Balance {
        Balance {
            matrix: DMatrix::zeros(self.n_motions, self.n_motions),
            load: self.loads.clone(),
        }
    }

    /// Velocities on the boundary.
    fn boundary(
        &self,
        system: &FlowSystem,
        positions: &[Point],
    ) -> Result<BoundaryVelocity, AxisymmetricError> {
        let slip = match self.drive.slip {
            Some(slip) => system.slip(positions, |body, x| {
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
        Ok(BoundaryVelocity {
            bodies: self.velocities.clone(),
            slip,
            wall: self.drive.wall_velocity,
        })
    }

    fn solve_on(
        &self,
        system: FlowSystem,
        positions: Vec<Point>,
        start: Option<Fields>,
        solenoidal: bool,
        order: usize,
        mut iterations: usize,
    ) -> Result<Level, AxisymmetricError> {
        let boundary = self.boundary(&system, &positions)?;
        // the velocity of the frame that is not that of its free motion
        let frame = match self.drive.moves_with_body {
            true => self.velocities[0],
            false => 0.0,
        };
        let mesh_velocity = vec![frame; positions.len()];
        let balance = self.balance();
        let terms = |viscosity: Viscosity<'a>, density: f64| Terms {
            coefficients: Coefficients {
                viscosity,
                convection: density,
                mass: 0.0,
            },
            mesh_velocity: Some(&mesh_velocity),
            history: None,
        };
        let typical = self.typical_viscosity(&boundary);
        let from_rest = start.is_none();
        let mut fields = start.unwrap_or_else(|| system.rest());
        system.set_boundary(&boundary, &mut fields);
        let (mut factors, mut last_change) = (None, 0.0);
        if self.law.is_some() && (self.density == 0.0 || from_rest) {
            if from_rest {
                let newtonian = terms(Viscosity::constant(typical), 0.0);
                system.iterate(&positions, &mut fields, &newtonian, &balance, &mut None)?;
            }
            let (count, change, last) = system.minimise(
                &positions,
                &mut fields,
                &terms(self.viscosity(), 0.0),
                &balance,
                solenoidal || from_rest,
                self.newton_tolerance,
            )?;
            iterations += count;
            if change.is_nan() || change > self.newton_tolerance.max(ROUNDING) {
                return Err(AxisymmetricError::LawNotSolved {
                    iterations: count,
                    change,
                });
            }
            (factors, last_change) = (Some(last), change);
        }
        let terms = |density: f64| terms(self.viscosity(), density);
        if self.law.is_none() || self.density > 0.0 {
            factors = None;
            let solve = |density: f64, fields: &mut Fields| {
                let terms = terms(density);
                system.solve(
                    &positions,
                    fields,
                    &terms,
                    &balance,
                    &mut None,
                    NEWTON_TOLERANCE,
                )
            };
            let (count, change) = self.raise_density(from_rest, &mut fields, solve)?;
            iterations += count;
            last_change = change;
        }
        let terms = terms(self.density);
        let residual = system.residual(&positions, &fields, &terms)?;
        let (size, speed) = (self.size(), largest_speed(&fields));
        let forces = system.forces(&residual);
        let of_surfaces = system.surface_forces(residual, &positions, &fields, &terms)?;
        let drag = 6.0 * PI * typical * size * speed;
        let state = SteadyState {
            velocities: system.body_velocities(&fields, &boundary),
            power: system.boundary_power(&of_surfaces, &fields),
            slip_power: of_surfaces.power(&boundary.slip),
            dissipation: system.dissipation(&positions, &fields, &terms)?,
            relative_error: f64::INFINITY,
            speed,
            force: forces.iter().fold(drag, |m, f| m.max(f.abs())),
            forces,
            order,
            dofs: system.n_dofs(),
            iterations,
            change: last_change,
        };
        Ok(Level {
            state,
            excess: match self.meridian.open_radius() {
                Some(_) => system.relative_excess(&positions, &fields, &terms, size, speed)?,
                None => 0.0,
            },
            outside: system.neglected_outside(&positions, &fields, &terms, size, speed)?,
            regularised: system.regularised(&positions, &fields, &terms)?,
            system,
            positions,
            fields,
            factors,
        })
    }

    /// Solves at the density of the fluid, by steps of the density from rest where that is needed;
    /// returns the number of iterations and the change in the last one.
    fn raise_density(
        &self,
        from_rest: bool,
        fields: &mut Fields,
        solve: impl Fn(f64, &mut Fields) -> Result<(usize, f64), AxisymmetricError>,
    ) -> Result<(usize, f64), AxisymmetricError> {
        let mut reached = if from_rest { 0.0 } else { self.density };
        let (mut step, mut iterations) = (self.density, 0);
        loop {
            let mut found = fields.clone();
            let (count, change) = solve(reached, &mut found)?;
            iterations += count;
            if change <= NEWTON_TOLERANCE {
                *fields = found;
                if reached == self.density {
                    return Ok((iterations, change));
                }
            } else {
                reached -= step;
                step *= 0.5;
                // a step that is a hundredth of the density makes progress impossible
                if !from_rest || step <= 0.01 * self.density || reached < 0.0 {
                    return Err(AxisymmetricError::NotSteady {
                        density: self.density,
                        reached: reached.max(0.0),
                        change,
                    });
                }
            }
            reached = (reached + step).min(self.density);
        }
    }

    /// The viscosity at the largest speed of a surface over the smallest semi-axis of a body, or at
    /// the rate at which a sphere is driven by the loads.
    fn typical_viscosity(&self, boundary: &BoundaryVelocity) -> f64 {
        let Some(law) = self.law else {
            return self.constant;
        };
        let speed = (boundary.bodies.iter())
            .chain(&[boundary.wall])
            .chain(boundary.slip.iter().flatten())
            .fold(0.0, |largest: f64, u| largest.max(u.abs()));
        let size = (self.bodies.iter())
            .map(|body| body.shape.axial.min(body.shape.equatorial))
            .fold(f64::INFINITY, f64::min);
        let load = self.loads.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        let stress = load / (6.0 * PI * size * size);
        let mut rate = (speed / size).max(f64::MIN_POSITIVE);
        while law.viscosity(rate) * rate < stress && rate < f64::MAX / 2.0 {
            rate *= 2.0;
        }
        law.viscosity(rate)
    }

    /// The largest semi-axis.
    fn size(&self) -> f64 {
        (self.bodies.iter())
            .map(|body| body.shape.axial.max(body.shape.equatorial))
            .fold(0.0, f64::max)
    }

    /// Difference of two states relative to the largest velocity of the fluid, and to the largest
    /// force or the drag of the largest body at that velocity.
    pub fn difference(&self, before: &Level, after: &Level) -> f64 {
        let lists = |level: &Level| [level.state.velocities.clone(), level.state.forces.clone()];
        self.relative_difference(&lists(before), &lists(after), after)
    }

    /// Difference of two changes, relative to their size in a flow.
    pub fn difference_of_changes(
        &self,
        before: &FirstOrderChange,
        after: &FirstOrderChange,
        flow: &Level,
    ) -> f64 {
        let lists = |change: &FirstOrderChange| [change.velocities.clone(), change.forces.clone()];
        let difference = self.relative_difference(&lists(before), &lists(after), flow);
        match difference > 0.0 {
            true => difference / after.size,
            false => 0.0,
        }
    }

    /// Difference of velocities and forces relative to those of a flow.
    fn relative_difference(
        &self,
        before: &[Vec<f64>; 2],
        after: &[Vec<f64>; 2],
        flow: &Level,
    ) -> f64 {
        let largest = |list: &mut dyn Iterator<Item = f64>| list.map(f64::abs).fold(0.0, f64::max);
        let change = |k: usize| {
            let pairs = before[k].iter().zip(&after[k]);
            largest(&mut pairs.map(|(a, b)| a - b))
        };
        let relative = |change: f64, size: f64| if change > 0.0 { change / size } else { 0.0 };
        relative(change(0), flow.state.speed).max(relative(change(1), flow.state.force))
    }

    /// Largest velocity of a flow over the largest semi-axis.
    pub fn typical_rate(&self, level: &Level) -> f64 {
        level.state.speed / self.size()
    }
}

/// The flow around bodies with given velocities and slip in a fluid with a viscosity law, on each
/// triangle of a mesh, by elements of this order.
///
/// Unbounded fluid is meshed to `enlarged` times the radius of Stokes flow at least.
///
/// # Errors
/// Those of [`Problem::solve`].
pub(crate) fn law_flow(
    bodies: &[AxialBody],
    surroundings: Surroundings,
    drive: &SteadyDrive,
    parameters: &SteadyParameters,
    order: usize,
    enlarged: f64,
) -> Result<Vec<TriangleValues>, AxisymmetricError> {
    let mut problem = Problem::new(bodies, surroundings, drive, parameters)?;
    problem.meridian = problem.meridian.enlarged(enlarged);
    problem.choose_open_radius(SHARE_OUTSIDE * parameters.tolerance)?;
    Ok(problem.solve(order, None)?.triangles().collect())
}

/// Largest component of a velocity of a flow.
fn largest_speed(fields: &Fields) -> f64 {
    (fields.velocity.iter()).fold(0.0, |largest, u| largest.max(u.amax()))
}

/// A list of one finite number per body.
fn finite_list(
    what: &'static str,
    bodies: usize,
    given: &[f64],
) -> Result<Vec<f64>, AxisymmetricError> {
    check_length(what, bodies, given.len())?;
    match given.iter().find(|value| !value.is_finite()) {
        None => Ok(given.to_vec()),
        Some(&value) => Err(AxisymmetricError::InvalidNumber {
            what,
            value,
            range: "finite",
        }),
    }
}

/// Refuses laws whose viscosity at rest is not a positive number.
pub(super) fn check_plateau(law: Option<&dyn ViscosityLaw>) -> Result<(), AxisymmetricError> {
    let Some(law) = law else { return Ok(()) };
    let viscosity = law.unregularised_viscosity(0.0);
    if viscosity > 0.0 && viscosity.is_finite() {
        return Ok(());
    }
    Err(AxisymmetricError::NoPlateau { viscosity })
}
