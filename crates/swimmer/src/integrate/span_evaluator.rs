//! The model's solutions at points of a phase span, each of them checked.

use models::{
    BodyInertia, Capabilities, Configuration, Hydrodynamics, InstantaneousSolution, ModelError,
    Query, RoughModel, Seconds,
};
use nalgebra::{DMatrix, DVector};
use rigid::{RigidError, State, StateBounds};
use scene::{
    BodyPath, Contact, PathContact, PhaseSpan, Scene, closest_contact, contacts, first_contact,
};

use super::passive_joints::JointNewton;
use super::piece::PathPiece;
use crate::added_mass::AddedMassForces;
use crate::error::SwimError;
use crate::kinetic_energy::KineticEnergy;

/// Why the error of a phase span whose path is a program's may not become small.
const OWN_PATH_HINT: &str = ", or begin another phase where the path of the joints has a corner: \
    it must be smooth within a phase";

/// Why the error of a phase span on meshes may not become small.
const MESH_HINT: &str = ". With finite elements the change of velocities by a new mesh may \
    prevent convergence: reduce fem.surface_size, and keep fem.estimates";

/// What keeps surfaces apart that thermal noise brings together.
const NOISE_REMEDY: &str = "thermal noise brings surfaces together: give contact = { range = .., \
                            strength = .. }, a repulsion that keeps them apart, or a smaller \
                            fluid.time_step";

/// Smallest part of a step on which contact is looked for. Each part has thousands of placements,
/// so a narrow gap then takes as long as some solves.
const LEAST_CHECKED_PART: f64 = 1.0 / 64.0;

/// Gap over the smaller radius below which the speed of an approach tells how it goes on: forces of
/// lubrication are then inversely proportional to the gap up to two per cent (Cox & Brenner 1967).
const NARROW_GAP: f64 = 1e-2;

/// Smallest gap over the smaller radius that is followed: that to which expansions in multipoles
/// are verified. Meshes end at wider gaps.
const SMALLEST_GAP: f64 = 1e-3;

/// Part of a step over which the speed of a gap is measured: the error is that part of it.
const RATE_PART: f64 = 1e-3;

/// The model's solution at a point of a phase span.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SpanSolution {
    /// Number of the solve from zero, over the whole simulation.
    pub number: usize,
    /// Position on the phase span, from 0 at its start to 1 at its end.
    pub s: f64,
    /// The state for which the solution was computed.
    pub state: State,
    /// The solution.
    pub solution: InstantaneousSolution,
    /// Kinetic energy of fluid and bodies, for fluids with inertia.
    pub kinetic_energy: Option<KineticEnergy>,
    /// Forces that accelerate the fluid, for fluids with inertia.
    pub added_mass: Option<AddedMassForces>,
}

/// Sets the number of solves of a table in a list of all tables.
pub(crate) fn enter_table(tables: &mut Vec<usize>, table: usize, solves: usize) {
    tables.resize(tables.len().max(table + 1), 0);
    tables[table] = solves;
}

/// Called with every solution and the model; an error ends the integration.
pub type ObserveSolution<'a> =
    &'a mut dyn FnMut(&SpanSolution, &dyn Hydrodynamics) -> Result<(), SwimError>;

/// Evaluates the model along one phase span, counts the solves and adds up their time.
pub(super) struct SpanEvaluator<'a> {
    pub scene: &'a Scene,
    pub span: &'a PhaseSpan,
    pub seconds: Seconds,
    /// Number of solutions.
    pub solves: usize,
    /// Number of solutions that were looked up in tables.
    pub lookups: usize,
    /// Number of solves of each table that was looked up in.
    pub tables: Vec<usize>,
    /// Number of solutions on another mesh than the solution before.
    pub mesh_changes: usize,
    /// Degrees of freedom of the last solution, which differ between meshes.
    dofs: Option<usize>,
    /// Integration error that the scene's tolerance allows for the phase span, if it is known.
    pub tolerance: Option<f64>,
    /// Intervals of the values of the joints along the phase span.
    pub ranges: Vec<(f64, f64)>,
    /// Largest second derivatives of the values of the joints along the phase span.
    second_derivatives: Vec<f64>,
    /// Largest displacement in the steps before, for methods whose steps may come to rest.
    pub moved: f64,
    /// Whether solutions are shown to the observer with their flow.
    pub flows: bool,
    /// Longest relaxation time of a body, for errors of velocities with inertia.
    pub relaxation: f64,
    model: &'a mut dyn Hydrodynamics,
    observe: ObserveSolution<'a>,
}

impl<'a> SpanEvaluator<'a> {
    pub fn new(
        scene: &'a Scene,
        model: &'a mut dyn Hydrodynamics,
        span: &'a PhaseSpan,
        tolerance: Option<f64>,
        observe: ObserveSolution<'a>,
    ) -> Self {
        Self {
            scene,
            span,
            seconds: Seconds::default(),
            solves: 0,
            lookups: 0,
            tables: Vec::new(),
            mesh_changes: 0,
            dofs: None,
            tolerance,
            ranges: span.ranges(),
            second_derivatives: span.second_derivatives(),
            moved: 0.0,
            flows: false,
            relaxation: 0.0,
            model,
            observe,
        }
    }

    /// The solutions at several points, at once if the model gains by that.
    pub fn solve_points(
        &mut self,
        points: Vec<(f64, State)>,
        estimates: bool,
    ) -> Result<Vec<SpanSolution>, SwimError> {
        if !self.model.capabilities().solves_together {
            let solve = |(s, state): &(f64, State)| self.solve(*s, state, estimates, None);
            return points.iter().map(solve).collect();
        }
        let mut inputs = Vec::with_capacity(points.len());
        for (s, state) in &points {
            let shape = self.span.shape(*s);
            self.check_clearance(*s, state, &shape)?;
            inputs.push((shape, [self.span.rates(*s)], self.span.time(*s)));
        }
        let queries = points.iter().zip(&inputs);
        let queries = queries.map(|((_, state), (shape, rates, time))| {
            Query::new(Configuration::new(state, shape).at_time(*time), rates)
                .with_estimates(estimates)
                .with_flows(self.flows)
        });
        let solved = self.model.solve_all(&queries.collect::<Vec<_>>())?;
        (points.iter().zip(solved))
            .map(|((s, state), of_rates)| self.record(*s, state, self.only(of_rates)?))
            .collect()
    }

    /// The solution for the only set of rates of a query.
    fn only(
        &self,
        mut solutions: Vec<InstantaneousSolution>,
    ) -> Result<InstantaneousSolution, ModelError> {
        solutions.pop().ok_or(ModelError::NoSolution {
            model: self.model.name(),
        })
    }

    /// The model's solution at the position `s` in [0, 1] on the phase span, with or without its
    /// estimates of the discretisation error, and with the terms of an implicit step for bodies
    /// with mass.
    pub fn solve(
        &mut self,
        s: f64,
        state: &State,
        estimates: bool,
        inertia: Option<&[BodyInertia]>,
    ) -> Result<SpanSolution, SwimError> {
        let rates = [self.span.rates(s)];
        let flows = self.flows;
        let solutions = self.query(s, state, |model, configuration| {
            let query = Query::new(configuration, &rates)
                .with_estimates(estimates)
                .with_flows(flows);
            model.solve(&match inertia {
                Some(inertia) => query.with_inertia(inertia),
                None => query,
            })
        })?;
        self.record(s, state, self.only(solutions)?)
    }

    /// The random loads of thermal noise at the position `s` on the phase span, from standard
    /// normal numbers.
    pub fn random_loads(
        &mut self,
        s: f64,
        state: &State,
        power: f64,
        normal: &mut dyn FnMut() -> f64,
    ) -> Result<DVector<f64>, SwimError> {
        self.query(s, state, |model, configuration| {
            (model.fluctuations()?).random_loads(configuration, power, normal)
        })
    }

    /// The model's solution at the position `s` on the phase span with random loads.
    pub fn solve_with_loads(
        &mut self,
        s: f64,
        state: &State,
        loads: &DVector<f64>,
    ) -> Result<SpanSolution, SwimError> {
        let rates = [self.span.rates(s)];
        let flows = self.flows;
        let solutions = self.query(s, state, |model, configuration| {
            let query = Query::new(configuration, &rates).without_estimates();
            model.solve(&query.with_flows(flows).with_random_loads(loads))
        })?;
        self.record(s, state, self.only(solutions)?)
    }

    /// The grand resistance matrix at the position `s` on the phase span.
    pub fn resistance(&mut self, s: f64, state: &State) -> Result<DMatrix<f64>, SwimError> {
        self.query(s, state, |model, configuration| {
            Ok(model.resistances()?.resistance(configuration)?.matrix)
        })
    }

    /// The derivatives of the motion with respect to the values of passive joints; none without
    /// springs.
    pub fn joint_newton(
        &mut self,
        s: f64,
        state: &State,
    ) -> Result<Option<JointNewton>, SwimError> {
        let set = self.scene.articulation();
        let mut drives = set.passive_drives().map(|(_, drive)| drive);
        if drives.all(|drive| drive.stiffness == 0.0) {
            return Ok(None);
        }
        let responses = self.query(s, state, |model, configuration| {
            if let Some(own) = model.joint_responses(configuration)? {
                return Ok(own);
            }
            let own = RoughModel::new(model.scene())?.joint_responses(configuration)?;
            Ok(own.unwrap_or_default())
        })?;
        let drives = set.passive_drives().map(|(_, drive)| drive);
        Ok(Some(JointNewton::new(&responses, drives)))
    }

    /// What the model can do, and when.
    pub fn capabilities(&self) -> Capabilities {
        self.model.capabilities()
    }

    /// Queries the model, after a check that bodies and walls do not touch.
    fn query<T>(
        &mut self,
        s: f64,
        state: &State,
        evaluate: impl FnOnce(&mut dyn Hydrodynamics, Configuration<'_>) -> Result<T, ModelError>,
    ) -> Result<T, SwimError> {
        let shape = self.span.shape(s);
        self.check_clearance(s, state, &shape)?;
        let configuration = Configuration::new(state, &shape).at_time(self.span.time(s));
        Ok(evaluate(self.model, configuration)?)
    }

    /// Checks and counts a solution, and shows it to the observer.
    pub fn record(
        &mut self,
        s: f64,
        state: &State,
        solution: InstantaneousSolution,
    ) -> Result<SpanSolution, SwimError> {
        self.record_with_inertia(s, state, solution, (None, None))
    }

    /// As [`SpanEvaluator::record`], with what a fluid with inertia has besides.
    ///
    /// # Errors
    /// Those of [`SpanEvaluator::record`].
    pub fn record_with_inertia(
        &mut self,
        s: f64,
        state: &State,
        solution: InstantaneousSolution,
        (kinetic_energy, added_mass): (Option<KineticEnergy>, Option<AddedMassForces>),
    ) -> Result<SpanSolution, SwimError> {
        solution.check(self.model)?;
        self.seconds += solution.seconds;
        let dofs = self.dofs.replace(solution.dofs.total);
        let has_other_dofs = dofs.is_some_and(|before| before != solution.dofs.total);
        self.mesh_changes += usize::from(solution.remeshed.is_some() || has_other_dofs);
        let mut span_solution = SpanSolution {
            number: self.solves,
            s,
            state: state.clone(),
            solution,
            kinetic_energy,
            added_mass,
        };
        self.solves += 1;
        if let Some(lookup) = span_solution.solution.lookup {
            self.lookups += 1;
            enter_table(&mut self.tables, lookup.table, lookup.solves);
        }
        (self.observe)(&span_solution, &*self.model)?;
        // The observer keeps the flows that it needs.
        span_solution.solution.flow = None;
        Ok(span_solution)
    }

    /// The solution rotated to another state with the same shape, for scenes whose motion depends
    /// on the shape alone.
    pub fn rotated(&self, solution: &SpanSolution, state: &State) -> SpanSolution {
        let rotation = state.frames[0].rotation * solution.state.frames[0].rotation.inverse();
        let mut rotated = SpanSolution {
            state: state.clone(),
            ..solution.clone()
        };
        rotated.solution.rotate(&rotation);
        rotated
    }

    /// Names of the joints that change their values, for messages.
    pub fn joint_name(&self) -> String {
        self.scene.joint_label(&self.span.joints)
    }

    /// The error of a method whose smallest steps have too large an error.
    pub fn not_integrated(&self, error: f64, tolerance: f64, parts: usize) -> SwimError {
        SwimError::NotIntegrated {
            phase: self.span.number + 1,
            joint: self.joint_name(),
            error,
            tolerance,
            parts,
            hint: match (self.span.is_own_path(), self.capabilities().has_mesh) {
                (true, _) => OWN_PATH_HINT,
                (false, true) => MESH_HINT,
                (false, false) => "",
            },
        }
    }

    /// Gaps between surfaces at the position `s` of a path, in a fixed order.
    pub fn gaps(&self, path: &PathPiece, s: f64) -> Result<Vec<f64>, SwimError> {
        let contacts = self.contacts(path, s)?.into_iter();
        Ok(contacts.map(|contact| contact.gap).collect())
    }

    /// All pairs of surfaces at the position `s` of a path, with their gaps.
    fn contacts(&self, path: &PathPiece, s: f64) -> Result<Vec<Contact>, SwimError> {
        let set = self.scene.articulation();
        let shape = self.span.shape(s);
        let poses = set.place(&path.state(set, s)?, &shape)?;
        let bodies = self.scene.bodies_at(&shape);
        Ok(contacts(&bodies, self.scene.domain(), &poses).collect())
    }

    /// Refuses a step along which bodies or walls touch, at whatever place of it, or that
    /// lubrication keeps from touching forever.
    ///
    /// Contact that cannot be excluded is looked for on parts of the step, and in the end counts,
    /// since it can be on shorter steps.
    pub fn check_path(&self, path: &PathPiece) -> Result<(), SwimError> {
        let ends = (path.from, path.to);
        let joints = self.span.value_bounds(&self.second_derivatives, ends);
        let bounds = path.bounds(self.scene.articulation(), joints);
        let mut parts = vec![ends];
        while let Some((from, to)) = parts.pop() {
            let width = (to - from) / (path.to - path.from);
            let Some(found) = self.contact(path, (from, to), &bounds.over_part(width))? else {
                continue;
            };
            if found.is_certain || width <= LEAST_CHECKED_PART {
                let at = from + found.at * (to - from);
                return Err(self.collision(at, &found.contact, found.is_certain));
            }
            let middle = 0.5 * (from + to);
            parts.extend([(middle, to), (from, middle)]);
        }
        self.check_approach(path)
    }

    /// The first contact along a part of a path, with bounds on the motion along it.
    fn contact(
        &self,
        path: &PathPiece,
        (from, to): (f64, f64),
        bounds: &StateBounds,
    ) -> Result<Option<PathContact>, RigidError> {
        let set = self.scene.articulation();
        let at = |t: f64| -> Result<_, RigidError> {
            let s = from + t * (to - from);
            Ok((path.state(set, s)?, self.span.shape(s)))
        };
        first_contact(&BodyPath {
            bodies: self.scene.bodies(),
            set,
            domain: self.scene.domain(),
            at: &at,
            bounds,
        })
    }

    /// Refuses a step in a gap below [`NARROW_GAP`] that closes as lubrication lets it, ever more
    /// slowly, if it would be narrower than [`SMALLEST_GAP`] at the end of the phase span.
    ///
    /// That is foreseen where neither the gait nor loads change in time, and neither repulsion nor
    /// thermal noise keeps the surfaces apart.
    fn check_approach(&self, path: &PathPiece) -> Result<(), SwimError> {
        let changes = self.scene.depends_on_time() || !self.span.joints.is_empty();
        if changes || self.scene.repulsion().is_some() || self.scene.noise().is_some() {
            return Ok(());
        }
        let bodies = self.scene.bodies();
        let before = self.contacts(path, path.from)?;
        let size = |contact: &Contact| {
            let other = contact.other.unwrap_or(contact.body);
            bodies[contact.body]
                .bounding_radius()
                .min(bodies[other].bounding_radius())
        };
        if before
            .iter()
            .all(|contact| contact.gap > NARROW_GAP * size(contact))
        {
            return Ok(());
        }
        let part = RATE_PART * (path.to - path.from);
        let [near_start, near_end, after] =
            [path.from + part, path.to - part, path.to].map(|s| self.gaps(path, s));
        let (near_start, near_end, after) = (near_start?, near_end?, after?);
        for (k, contact) in before.iter().enumerate() {
            let speed = |from: f64, to: f64| (from - to) / (part * self.span.duration);
            let [first, last] = [(contact.gap, near_start[k]), (near_end[k], after[k])];
            let (first, last) = (speed(first.0, first.1), speed(last.0, last.1));
            let is_narrow = contact.gap <= NARROW_GAP * size(contact);
            let smallest = SMALLEST_GAP * size(contact);
            let decay = contact.gap / first;
            let left = (1.0 - path.from) * self.span.duration;
            let goes_too_far = contact.gap * (-left / decay).exp() < smallest;
            // The speed of bodies that lubrication slows down is proportional to the gap; without
            // lubrication it is constant.
            let slows = last / first <= (after[k] / contact.gap).sqrt();
            if is_narrow && first > 0.0 && after[k] < contact.gap && slows && goes_too_far {
                return Err(SwimError::Approach {
                    phase: self.span.number + 1,
                    joint: self.joint_name(),
                    percent: 100.0 * path.from,
                    time: self.span.time(path.from),
                    bodies: self.pair_name(contact),
                    gap: contact.gap,
                    speed: first,
                    decay,
                    smallest,
                    until: self.span.time(path.from)
                        + decay * (contact.gap / smallest).ln().max(0.0),
                });
            }
        }
        Ok(())
    }

    /// Two bodies, or a body and the wall, in words.
    fn pair_name(&self, contact: &Contact) -> String {
        let name = |body: usize| &self.scene.bodies()[body].name;
        match contact.other {
            Some(other) if other == contact.body => {
                format!("body '{}' and its own periodic image", name(other))
            }
            Some(other) => format!("bodies '{}' and '{}'", name(contact.body), name(other)),
            None => format!("body '{}' and the wall", name(contact.body)),
        }
    }

    fn check_clearance(&self, s: f64, state: &State, shape: &[f64]) -> Result<(), SwimError> {
        let poses = self.scene.articulation().place(state, shape)?;
        let bodies = self.scene.bodies_at(shape);
        match closest_contact(&bodies, self.scene.domain(), &poses) {
            Some(contact) if contact.touches(bodies[contact.body].bounding_radius()) => {
                Err(self.collision(s, &contact, true))
            }
            _ => Ok(()),
        }
    }

    /// The error of contact at the position `s` on the phase span, or of contact that cannot be
    /// excluded there.
    fn collision(&self, s: f64, contact: &Contact, is_certain: bool) -> SwimError {
        let (name, gap) = (&self.scene.bodies()[contact.body].name, contact.gap);
        SwimError::Collision {
            phase: self.span.number + 1,
            joint: self.joint_name(),
            percent: 100.0 * s,
            time: self.span.time(s),
            remedy: match self.scene.noise() {
                Some(_) => NOISE_REMEDY,
                None => "shorten the stroke or place the bodies farther apart",
            },
            problem: match (contact.other, is_certain) {
                (Some(_), true) => format!("{} touch (gap {gap:.1e})", self.pair_name(contact)),
                (Some(_), false) => format!(
                    "{} come so close (gap {gap:.1e}) that contact cannot be excluded",
                    self.pair_name(contact)
                ),
                (None, true) => format!("body '{name}' touches the wall (gap {gap:.1e})"),
                (None, false) => format!(
                    "body '{name}' comes so close to the wall (gap {gap:.1e}) that contact cannot \
                     be excluded"
                ),
            },
        }
    }
}
