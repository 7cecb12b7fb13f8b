//! Velocities and forces of linked bodies, linkage by linkage.

use microhydro::{Linkage, LinkedMotion, LinkedSpheres, Mobility, PointMobility};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Vector3};
use rayon::prelude::*;
use rigid::{
    Articulation, BodyKind, Constraints, Drive, ExternalLoad, JointLoad, LinkagePart, Reduction,
    StateVelocity,
};

use crate::error::ModelError;
use crate::query::{Configuration, Query};
use crate::response::Response;
use crate::scaled_scene::{ScaledResponse, ScaledScene};
use crate::surface_motion::SurfaceEffect;

/// One linkage in one configuration, for one set of rates, in scaled units.
#[derive(Clone)]
struct MovingLinkage<'a> {
    part: &'a LinkagePart,
    constraints: Constraints,
    loads: Vec<ExternalLoad>,
    reduction: Reduction,
    /// `B^T (F - D W)` for the loads `F`, the dashpots `D` and the basis `B` of all velocities.
    load: DVector<f64>,
    /// `B^T D B`.
    damping: DMatrix<f64>,
    /// The part of the load that is random.
    random: Option<DVector<f64>>,
}

/// All linkages of a scene in one configuration, for one set of rates.
///
/// Linkages act on each other by the fluid alone: everything else is done for each by itself, which
/// costs `O(n)` for `n` linkages.
pub(crate) struct LinkedBodies<'a> {
    scaled: &'a ScaledScene,
    time: f64,
    linkages: Vec<MovingLinkage<'a>>,
    /// Mean flow of a periodic box.
    mean_flow: Vector3<f64>,
}

/// Some linkages as if there were no others.
pub(crate) struct SomeLinkages<'a> {
    linkages: Vec<&'a MovingLinkage<'a>>,
    /// For each linkage the places of its velocities among all.
    velocities: Vec<Vec<usize>>,
    /// For each linkage the numbers of its bodies with surfaces among all.
    surfaces: Vec<Vec<usize>>,
    /// Place of the first velocity of each body.
    bodies: Vec<usize>,
    /// Places of the velocities of bodies with surfaces, six per body.
    surface_velocities: Vec<usize>,
    /// Mean flow of a periodic box.
    mean_flow: Vector3<f64>,
}

/// Velocities and forces of linked bodies, in scaled units.
#[derive(Clone)]
pub(crate) struct MobilitySolution {
    /// Generalised velocities of all bodies and frames.
    pub generalised: DVector<f64>,
    /// Forces and torques that the bodies with surfaces exert on the fluid.
    pub forces: DVector<f64>,
    /// Loads that hold bodies, with the indices of the bodies.
    holding: Vec<(usize, ExternalLoad)>,
    /// Residual of the equations, relative to the right-hand side.
    pub residual: f64,
    /// Power of the slip on the fluid, less that of random loads, which are the fluid's own.
    pub slip_power: f64,
    /// Rates of the amplitudes of deformations, and the forces on them.
    amplitudes: Vec<(f64, f64)>,
}

/// A solution by a mobility without a matrix, with the operators that it was found by.
pub(crate) struct IteratedSolution<'a, M = PointMobility<'a>> {
    pub mobility: &'a M,
    pub system: LinkedSpheres<'a, M>,
    pub found: LinkedMotion,
    pub solution: MobilitySolution,
}

/// Residual of the velocities that the joints do not allow, relative to those that they impose.
///
/// Far below the errors of point forces, and above rounding for thousands of spheres.
const RESIDUAL: f64 = 1e-10;

/// Largest differences between two solutions, or sums of them, in scaled units.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LargestDifferences {
    pub velocity: f64,
    pub angular_velocity: f64,
    pub force: f64,
    pub torque: f64,
    pub power: f64,
}

impl LargestDifferences {
    /// Adds `factor` times other differences.
    pub fn add(&mut self, factor: f64, other: &Self) {
        let mut other = *other;
        for (sum, term) in self.numbers().into_iter().zip(other.numbers()) {
            *sum += factor * *term;
        }
    }

    /// The larger of each of two.
    pub fn raise(&mut self, other: &Self) {
        let mut other = *other;
        for (most, found) in self.numbers().into_iter().zip(other.numbers()) {
            *most = most.max(*found);
        }
    }

    /// The same number for all.
    pub fn of_all(number: f64) -> Self {
        let mut all = Self::default();
        all.numbers().into_iter().for_each(|own| *own = number);
        all
    }

    /// Products of corresponding numbers.
    pub fn times(mut self, factors: &Self) -> Self {
        let mut factors = *factors;
        for (own, factor) in self.numbers().into_iter().zip(factors.numbers()) {
            *own *= *factor;
        }
        self
    }

    /// Quotients of corresponding numbers, at most `largest`; zero over zero.
    pub fn over(mut self, others: &Self, largest: f64) -> Self {
        let mut others = *others;
        for (own, other) in self.numbers().into_iter().zip(others.numbers()) {
            *own = if *other > 0.0 {
                (*own / *other).min(largest)
            } else {
                0.0
            };
        }
        self
    }

    fn numbers(&mut self) -> [&mut f64; 5] {
        [
            &mut self.velocity,
            &mut self.angular_velocity,
            &mut self.force,
            &mut self.torque,
            &mut self.power,
        ]
    }
}

impl MobilitySolution {
    /// The solution with the powers of slip and deformation.
    fn with_powers(mut self, effect: Option<&SurfaceEffect>) -> Self {
        if let Some(effect) = effect {
            let powers = effect.powers(&self.forces);
            self.slip_power += powers.as_slice().first().copied().unwrap_or_default();
            let of_amplitudes = powers.iter().skip(1).copied();
            self.amplitudes = effect.rates.iter().copied().zip(of_amplitudes).collect();
        }
        self
    }
}

impl<'a> MovingLinkage<'a> {
    fn new(
        part: &'a LinkagePart,
        mut constraints: Constraints,
        loads: Vec<ExternalLoad>,
    ) -> Result<Self, ModelError> {
        let reduction = Reduction::new(part.set(), &constraints)?;
        if let Some(random) = &mut constraints.random_loads {
            // The motions that no surface resists turn with the linkage.
            let places = part.set().state_velocities();
            let unresisted = &reduction.all.unresisted;
            let power = unresisted.tr_mul(random);
            let own = on_state(unresisted, &places, &power)?;
            places
                .iter()
                .zip(own.iter())
                .for_each(|(&k, load)| random[k] -= load);
        }
        let drive = Drive {
            set: part.set(),
            constraints: &constraints,
            loads: &loads,
        };
        let all = &reduction.all;
        let acting = drive.generalised_loads()? - drive.damping_times(&all.offset)?;
        let (load, damping) = (
            all.basis.tr_mul(&acting),
            drive.damping_projected(&all.basis, &all.basis)?,
        );
        let random = constraints.random_loads.as_ref();
        Ok(Self {
            part,
            random: random.map(|random| reduction.all.basis.tr_mul(random)),
            reduction,
            load,
            damping,
            constraints,
            loads,
        })
    }

    fn set(&self) -> &Articulation {
        self.part.set()
    }

    fn drive(&self) -> Drive<'_> {
        Drive {
            set: self.set(),
            constraints: &self.constraints,
            loads: &self.loads,
        }
    }
}

impl<'a> LinkedBodies<'a> {
    /// The linkages of a scene for a query and one of its sets of rates.
    ///
    /// # Errors
    /// Values of joints for which a loop does not close; joints that contradict each other.
    pub fn new(scaled: &'a ScaledScene, query: &Query, rates: &[f64]) -> Result<Self, ModelError> {
        let loads = scaled.loads(query.configuration, query.inertia)?;
        let constraints = scaled.part_constraints(query, rates)?;
        let parts = scaled.parts.par_iter().zip(constraints);
        let linkages = parts.map(|(part, constraints)| {
            MovingLinkage::new(part, constraints?, part.of_bodies(&loads))
        });
        Ok(Self {
            scaled,
            time: query.configuration.time,
            linkages: linkages.collect::<Result<_, _>>()?,
            mean_flow: scaled.mean_flow(),
        })
    }

    /// The linkages at rest and without loads, but for a unit force on one passive joint, if there
    /// is one, by its place among these.
    ///
    /// # Errors
    /// Those of [`LinkedBodies::new`].
    pub fn at_rest(
        scaled: &'a ScaledScene,
        configuration: Configuration,
        unit_force: Option<usize>,
    ) -> Result<Self, ModelError> {
        let rates = [vec![0.0; scaled.set.joints().len()]];
        let query = Query::new(configuration, &rates);
        let parts = scaled.parts.iter();
        let linkages =
            parts
                .zip(scaled.part_constraints(&query, &rates[0])?)
                .map(|(part, constraints)| {
                    let mut constraints = constraints?;
                    // All else is at rest, also bodies whose velocities are given.
                    constraints.rates.fill(0.0);
                    constraints.joint_forces.fill(0.0);
                    let own = part
                        .passive_joints()
                        .iter()
                        .position(|&place| Some(place) == unit_force);
                    if let Some(own) = own
                        && let Some(joint) = part.set().passive_joints().nth(own)
                    {
                        constraints.joint_forces[own] = scaled.scale.joint_force(joint, 1.0);
                    }
                    let loads = vec![ExternalLoad::default(); part.bodies().len()];
                    MovingLinkage::new(part, constraints, loads)
                });
        Ok(Self {
            scaled,
            time: configuration.time,
            linkages: linkages.collect::<Result<_, _>>()?,
            mean_flow: Vector3::zeros(),
        })
    }

    /// All linkages, in the numbering of the scene.
    pub fn all(&self) -> SomeLinkages<'_> {
        let set = &self.scaled.set;
        let mut numbers = vec![0; set.kinds().len()];
        for (number, body) in self.scaled.surfaced().enumerate() {
            numbers[body] = number;
        }
        let surfaces = self.linkages.iter().map(|one| {
            let bodies = surfaced(one.set()).map(|own| numbers[one.part.bodies()[own]]);
            bodies.collect()
        });
        let velocities = self
            .linkages
            .iter()
            .map(|one| one.part.velocities().to_vec());
        SomeLinkages {
            velocities: velocities.collect(),
            surfaces: surfaces.collect(),
            bodies: set.velocity_layout().bodies().to_vec(),
            surface_velocities: set.surface_velocities(),
            linkages: self.linkages.iter().collect(),
            mean_flow: self.mean_flow,
        }
    }

    /// Some linkages, numbered in their order.
    pub fn some(&self, numbers: &[usize]) -> SomeLinkages<'_> {
        let mut some = SomeLinkages {
            linkages: numbers.iter().map(|&k| &self.linkages[k]).collect(),
            velocities: Vec::new(),
            surfaces: Vec::new(),
            bodies: Vec::new(),
            surface_velocities: Vec::new(),
            mean_flow: self.mean_flow,
        };
        let (mut first, mut surface) = (0, 0);
        for one in &some.linkages {
            let layout = one.set().velocity_layout();
            some.bodies
                .extend(layout.bodies().iter().map(|k| first + k));
            let own = one.set().surface_velocities();
            some.surface_velocities
                .extend(own.iter().map(|k| first + k));
            some.velocities
                .push((first..first + layout.len()).collect());
            let count = own.len() / 6;
            some.surfaces.push((surface..surface + count).collect());
            (first, surface) = (first + layout.len(), surface + count);
        }
        some
    }

    /// Motion and loads in the scene's units, of a solution for all linkages.
    ///
    /// # Errors
    /// Joints that contradict each other.
    pub fn response(&self, solution: &MobilitySolution) -> Result<Response, ModelError> {
        self.converted(solution, |scaled| {
            self.scaled.response_to_scene(self.time, scaled)
        })
    }

    /// Change of motion and loads in the scene's units, of a solution for all linkages at rest.
    ///
    /// # Errors
    /// As [`LinkedBodies::response`].
    pub fn change(&self, solution: &MobilitySolution) -> Result<Response, ModelError> {
        self.converted(solution, |scaled| self.scaled.change_to_scene(scaled))
    }

    fn converted(
        &self,
        solution: &MobilitySolution,
        to_scene: impl FnOnce(ScaledResponse) -> Response,
    ) -> Result<Response, ModelError> {
        let set = &self.scaled.set;
        let all = self.all();
        let mut joint_loads = vec![JointLoad::default(); set.joints().len()];
        let of_linkages = all.each().map(|(one, own)| {
            let (forces, velocities) = all.of(own, solution);
            one.drive().joint_loads(&forces, &velocities)
        });
        for (one, loads) in self.linkages.iter().zip(of_linkages.collect::<Vec<_>>()) {
            for (&joint, load) in one.part.joints().iter().zip(loads?) {
                joint_loads[joint] = load;
            }
        }
        Ok(to_scene(ScaledResponse {
            motion: &set.state_velocity(solution.generalised.as_slice())?,
            generalised: &solution.generalised,
            forces: &solution.forces,
            joint_loads,
            holding: solution.holding.clone(),
            slip_power: solution.slip_power,
            amplitudes: solution.amplitudes.clone(),
        }))
    }
}

/// Own numbers of the bodies with surfaces.
fn surfaced(set: &Articulation) -> impl Iterator<Item = usize> {
    let kinds = set.kinds().iter().enumerate();
    kinds
        .filter(|(_, kind)| **kind == BodyKind::Rigid)
        .map(|(body, _)| body)
}

impl SomeLinkages<'_> {
    /// The linkages with their numbers, in parallel.
    fn each(&self) -> impl IndexedParallelIterator<Item = (&MovingLinkage<'_>, usize)> {
        let numbered = self.linkages.par_iter().enumerate();
        numbered.map(|(own, one)| (*one, own))
    }

    /// Forces and generalised velocities of a linkage in a solution.
    fn of(&self, linkage: usize, solution: &MobilitySolution) -> (DVector<f64>, DVector<f64>) {
        let rows: Vec<usize> = (self.surfaces[linkage].iter())
            .flat_map(|&k| 6 * k..6 * k + 6)
            .collect();
        let velocities = &self.velocities[linkage];
        (
            solution.forces.select_rows(&rows),
            solution.generalised.select_rows(velocities),
        )
    }

    /// The solution for the grand resistance matrix of the bodies with surfaces (formulation
    /// P-tilde).
    ///
    /// With a basis `S` of the motions that the joints leave free, the motion `W` that their rates
    /// impose, the resistance `R`, the coefficients `D` of dashpots, the external loads `F` and the
    /// velocities `U_0` of force-free bodies by the velocities of their `effect`, the coefficients
    /// `v` satisfy
    ///
    /// ```text
    /// S^T (R + D) S v = S^T (F - D W - R (W - U_0))
    /// ```
    ///
    /// # Errors
    /// `S^T R S` that is not positive definite.
    pub fn by_resistance(
        &self,
        resistance: &DMatrix<f64>,
        effect: Option<&SurfaceEffect>,
    ) -> Result<MobilitySolution, ModelError> {
        let (s, w, matrix) = self.reduced(resistance);
        let loads = self
            .linkages
            .iter()
            .flat_map(|one| one.load.iter().copied());
        let load = DVector::from_iterator(matrix.nrows(), loads);
        let force_free = self.force_free(effect);
        let relative_to_fluid = |velocities: &DVector<f64>| velocities - &force_free;
        let rhs = load - s.tr_mul(&(resistance * relative_to_fluid(&w)));
        let coefficients = cholesky(matrix.clone())?.solve(&rhs);
        let scale = rhs.amax();
        let residual = (&matrix * &coefficients - &rhs).amax();
        let velocities = &s * &coefficients + &w;
        let forces = resistance * relative_to_fluid(&velocities);
        let mut first = 0;
        let own = self.linkages.iter().map(|one| {
            first += one.load.len();
            coefficients
                .rows(first - one.load.len(), one.load.len())
                .into_owned()
        });
        let residual = if scale > 0.0 { residual / scale } else { 0.0 };
        let solution = self.solution(&own.collect::<Vec<_>>(), forces, residual)?;
        Ok(solution.with_powers(effect))
    }

    /// `S`, `W` and `S^T (R + D) S`.
    fn reduced(&self, resistance: &DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>, DMatrix<f64>) {
        let rows = self.surface_velocities.len();
        let free: usize = self.linkages.iter().map(|one| one.load.len()).sum();
        let (mut s, mut w) = (DMatrix::zeros(rows, free), DVector::zeros(rows));
        let mut damping = DMatrix::zeros(free, free);
        let mut first = 0;
        for (one, bodies) in self.linkages.iter().zip(&self.surfaces) {
            let own = one.load.len();
            for (number, &body) in bodies.iter().enumerate() {
                let basis = one.reduction.surface_basis.rows(6 * number, 6);
                s.view_mut((6 * body, first), (6, own)).copy_from(&basis);
                let offset = one.reduction.surface_offset.rows(6 * number, 6);
                w.rows_mut(6 * body, 6).copy_from(&offset);
            }
            let mut block = damping.view_mut((first, first), (own, own));
            block.copy_from(&one.damping);
            first += own;
        }
        let matrix = damping + s.tr_mul(&(resistance * &s));
        (s, w, matrix)
    }

    /// The solution by a model of point forces, with the velocities of force-free bodies by their
    /// `effect`.
    ///
    /// # Errors
    /// Spheres too close for the model; joints that contradict each other.
    pub fn by_point_forces<'m>(
        &self,
        mobility: &'m PointMobility<'m>,
        effect: Option<&SurfaceEffect>,
    ) -> Result<IteratedSolution<'m>, ModelError> {
        self.by_mobility(mobility, effect, RESIDUAL)
    }

    /// The solution by a mobility without a matrix, to a relative residual.
    ///
    /// # Errors
    /// Spheres too close for the model; joints that contradict each other.
    pub fn by_mobility<'m, M: Mobility>(
        &self,
        mobility: &'m M,
        effect: Option<&SurfaceEffect>,
        residual: f64,
    ) -> Result<IteratedSolution<'m, M>, ModelError> {
        let system = self.spheres(mobility, effect)?;
        let found = system.solve(residual)?;
        let solution = self
            .solution(&found.coordinates, found.forces.clone(), found.residual)?
            .with_powers(effect);
        Ok(IteratedSolution {
            mobility,
            system,
            found,
            solution,
        })
    }

    /// The solution by another mobility of the same spheres; the residual is relative to that of
    /// the forces `near`, from which the iteration starts.
    ///
    /// # Errors
    /// Spheres too close for the model; joints that contradict each other.
    pub fn by_similar_mobility(
        &self,
        mobility: &impl Mobility,
        near: &LinkedMotion,
        residual: f64,
    ) -> Result<(MobilitySolution, LinkedMotion), ModelError> {
        let found = self.spheres(mobility, None)?.solve_near(near, residual)?;
        let forces = found.forces.clone();
        Ok((
            self.solution(&found.coordinates, forces, found.residual)?,
            found,
        ))
    }

    /// Forces of spheres that move as in a solution, by another mobility, as in
    /// [`SomeLinkages::by_similar_mobility`].
    ///
    /// # Errors
    /// Spheres too close for the model.
    pub fn forces_of_motion(
        &self,
        solution: &MobilitySolution,
        mobility: &impl Mobility,
        near: &LinkedMotion,
        residual: f64,
    ) -> Result<DVector<f64>, ModelError> {
        let velocities = solution.generalised.select_rows(&self.surface_velocities);
        let velocities = velocities - self.force_free(None);
        let held = self.surfaces.iter().map(|spheres| {
            let entries = (spheres.iter()).flat_map(|&k| &velocities.as_slice()[6 * k..6 * k + 6]);
            let rows = 6 * spheres.len();
            Linkage {
                spheres: spheres.clone(),
                basis: DMatrix::zeros(rows, 0),
                offset: DVector::from_iterator(rows, entries.copied()),
                load: DVector::zeros(0),
                damping: DMatrix::zeros(0, 0),
            }
        });
        let system = LinkedSpheres::new(mobility, held.collect())?;
        Ok(system.solve_near(near, residual)?.forces)
    }

    /// Velocities `U_0` of force-free bodies: those of an effect and of the mean flow.
    fn force_free(&self, effect: Option<&SurfaceEffect>) -> DVector<f64> {
        let mut velocities = match effect {
            Some(effect) => effect.velocities.clone(),
            None => DVector::zeros(self.surface_velocities.len()),
        };
        for sphere in 0..velocities.len() / 6 {
            let mut rows = velocities.fixed_rows_mut::<3>(6 * sphere);
            rows += self.mean_flow;
        }
        velocities
    }

    /// The linked spheres of a mobility.
    ///
    /// # Errors
    /// Spheres too close for the model.
    fn spheres<'m, M: Mobility>(
        &self,
        mobility: &'m M,
        effect: Option<&SurfaceEffect>,
    ) -> Result<LinkedSpheres<'m, M>, ModelError> {
        let force_free = self.force_free(effect);
        let linkages = self.linkages.iter().zip(&self.surfaces);
        let linkages = linkages.map(|(one, spheres)| {
            let mut offset = one.reduction.surface_offset.clone();
            // M f + U_0 = S v + W
            for (own, &sphere) in spheres.iter().enumerate() {
                let mut rows = offset.rows_mut(6 * own, 6);
                rows -= force_free.rows(6 * sphere, 6);
            }
            Linkage {
                spheres: spheres.clone(),
                basis: one.reduction.surface_basis.clone(),
                offset,
                load: one.load.clone(),
                damping: one.damping.clone(),
            }
        });
        Ok(LinkedSpheres::new(mobility, linkages.collect())?)
    }

    /// The solution with these coefficients of each linkage and these forces.
    ///
    /// # Errors
    /// Joints that contradict each other.
    pub fn solution(
        &self,
        coefficients: &[DVector<f64>],
        forces: DVector<f64>,
        residual: f64,
    ) -> Result<MobilitySolution, ModelError> {
        let count = self.velocities.iter().map(Vec::len).sum();
        let mut solution = MobilitySolution {
            generalised: DVector::zeros(count),
            forces,
            holding: Vec::new(),
            residual,
            slip_power: 0.0,
            amplitudes: Vec::new(),
        };
        for (number, one) in self.linkages.iter().enumerate() {
            let random = one.random.as_ref();
            let power = random.map_or(0.0, |random| random.dot(&coefficients[number]));
            solution.slip_power -= power;
            let own = one.reduction.velocities(&coefficients[number])?;
            for (&place, velocity) in self.velocities[number].iter().zip(own.iter()) {
                solution.generalised[place] = *velocity;
            }
        }
        let holding = self.each().map(|(one, own)| {
            if one.set().held_bodies().next().is_none() {
                return Ok(Vec::new());
            }
            let (forces, velocities) = self.of(own, &solution);
            let loads = one.drive().holding_loads(&forces, &velocities)?;
            let bodies = one.part.bodies();
            Ok(loads
                .into_iter()
                .map(|(body, load)| (bodies[body], load))
                .collect())
        });
        let holding: Vec<Vec<_>> = holding.collect::<Result<_, ModelError>>()?;
        solution.holding = holding.into_iter().flatten().collect();
        solution.holding.sort_by_key(|(body, _)| *body);
        Ok(solution)
    }

    /// Random loads on all generalised velocities, of the resistance as covariance, from standard
    /// normal numbers.
    ///
    /// # Errors
    /// A resistance that is not positive definite.
    pub fn random_loads(
        &self,
        resistance: &DMatrix<f64>,
        normal: &mut dyn FnMut() -> f64,
    ) -> Result<DVector<f64>, ModelError> {
        let (_, _, matrix) = self.reduced(resistance);
        let numbers = DVector::from_fn(matrix.nrows(), |_, _| normal());
        let loads = cholesky(matrix)?.l() * numbers;
        let mut first = 0;
        let of_linkages = self.linkages.iter().map(|one| {
            first += one.load.len();
            loads
                .rows(first - one.load.len(), one.load.len())
                .into_owned()
        });
        self.on_state(&of_linkages.collect::<Vec<_>>())
    }

    /// The same by a model of point forces, without the resistance.
    ///
    /// # Errors
    /// Spheres too close for the model.
    pub fn random_loads_of_points(
        &self,
        mobility: &PointMobility,
        normal: &mut dyn FnMut() -> f64,
    ) -> Result<DVector<f64>, ModelError> {
        self.on_state(&self.spheres(mobility, None)?.random_loads(normal)?)
    }

    /// Loads on the velocities of the state that do the work of loads on the coordinates of each
    /// linkage.
    fn on_state(&self, loads: &[DVector<f64>]) -> Result<DVector<f64>, ModelError> {
        let count = self.velocities.iter().map(Vec::len).sum();
        let mut all = DVector::zeros(count);
        for ((one, velocities), own) in self.linkages.iter().zip(&self.velocities).zip(loads) {
            let places = one.set().state_velocities();
            let loads = on_state(&one.reduction.all.basis, &places, own)?;
            for (&place, load) in places.iter().zip(loads.iter()) {
                all[velocities[place]] += load;
            }
        }
        Ok(all)
    }

    /// Number of linkages.
    pub fn count(&self) -> usize {
        self.linkages.len()
    }

    /// Whether joints and given velocities determine all motions.
    pub fn is_held(&self) -> bool {
        self.linkages.iter().all(|one| one.load.is_empty())
    }

    /// Whether no joint and no given velocity takes part, so that all forces are given.
    pub fn has_given_forces(&self) -> bool {
        let mut linkages = self.linkages.iter().zip(&self.surfaces);
        linkages.all(|(one, spheres)| one.load.len() == 6 * spheres.len())
    }

    /// Bodies with surfaces of some linkages, by their numbers.
    pub fn spheres_of(&self, linkages: &[usize]) -> Vec<usize> {
        let lists = linkages.iter().map(|&k| &self.surfaces[k]);
        lists.flatten().copied().collect()
    }

    /// The linkage of each body with a surface.
    pub fn linkage_of_spheres(&self) -> Vec<usize> {
        let mut of_sphere = vec![0; self.surface_velocities.len() / 6];
        for (linkage, spheres) in self.surfaces.iter().enumerate() {
            for &sphere in spheres {
                of_sphere[sphere] = linkage;
            }
        }
        of_sphere
    }

    /// The linkage whose velocities differ most between two solutions.
    pub fn farthest_change(&self, one: &MobilitySolution, other: &MobilitySolution) -> usize {
        largest_of(&self.velocities, |k| {
            one.generalised[k] - other.generalised[k]
        })
    }

    /// The linkage with the largest velocities.
    pub fn fastest(&self, solution: &MobilitySolution) -> usize {
        largest_of(&self.velocities, |k| solution.generalised[k])
    }

    /// The linkage with the largest forces on the fluid.
    pub fn strongest(&self, solution: &MobilitySolution) -> usize {
        let force = |sphere: usize| solution.forces.fixed_rows::<3>(6 * sphere).norm();
        largest_of(&self.surfaces, force)
    }

    /// Power of the bodies, their deformation and their slip on the fluid.
    pub fn power(&self, solution: &MobilitySolution) -> f64 {
        let velocities = solution.generalised.select_rows(&self.surface_velocities);
        let amplitudes = solution.amplitudes.iter();
        let of_deformation: f64 = amplitudes.map(|(rate, drive)| rate * drive).sum();
        solution.forces.dot(&velocities) + solution.slip_power + of_deformation
    }

    /// Largest differences between the motions and loads of a body in two solutions, and that of
    /// the power.
    pub fn largest_differences(
        &self,
        one: &MobilitySolution,
        other: &MobilitySolution,
    ) -> LargestDifferences {
        type Part = fn(&MobilitySolution) -> &DVector<f64>;
        let difference = |of: Part, rows: &mut dyn Iterator<Item = usize>| {
            let norms = rows.map(|k| (vector(of(one), k) - vector(of(other), k)).norm());
            norms.fold(0.0, f64::max)
        };
        let velocities: Part = |solution| &solution.generalised;
        let forces: Part = |solution| &solution.forces;
        // Six rows per body with a surface, of which the last three are its angular velocity.
        let spins = self.surface_velocities.iter().copied().skip(3).step_by(6);
        let loads = one.forces.len();
        let of_holding = |part: fn(&ExternalLoad) -> &Vector3<f64>| {
            let pairs = one.holding.iter().zip(&other.holding);
            let norms = pairs.map(|((_, a), (_, b))| (part(a) - part(b)).norm());
            norms.fold(0.0, f64::max)
        };
        LargestDifferences {
            velocity: difference(velocities, &mut self.bodies.iter().copied()),
            angular_velocity: difference(velocities, &mut { spins }),
            force: difference(forces, &mut (0..loads).step_by(6))
                .max(of_holding(|load| &load.force)),
            torque: difference(forces, &mut (3..loads).step_by(6))
                .max(of_holding(|load| &load.torque)),
            power: (self.power(one) - self.power(other)).abs(),
        }
    }
}

/// Velocities in the scene's units for a unit force on each passive joint, all else at rest, by the
/// solutions of `solve`.
///
/// # Errors
/// Joints that contradict each other; those of `solve`.
pub(crate) fn joint_responses(
    scaled: &ScaledScene,
    configuration: Configuration,
    solve: impl Fn(&LinkedBodies) -> Result<MobilitySolution, ModelError>,
) -> Result<Vec<StateVelocity>, ModelError> {
    let passive = 0..scaled.set.passive_joints().count();
    let response = |joint: usize| {
        let solved = solve(&LinkedBodies::at_rest(scaled, configuration, Some(joint))?)?;
        let motion = scaled.set.state_velocity(solved.generalised.as_slice())?;
        Ok(scaled.motion_to_scene(&motion))
    };
    passive.map(response).collect()
}

/// Loads of the smallest norm on the velocities at `places` that do the work of `loads` on the
/// motions in the columns of `basis`.
///
/// # Errors
/// Motions that do not differ at these places.
fn on_state(
    basis: &DMatrix<f64>,
    places: &[usize],
    loads: &DVector<f64>,
) -> Result<DVector<f64>, ModelError> {
    let moved = basis.select_rows(places);
    Ok(&moved * cholesky(moved.tr_mul(&moved))?.solve(loads))
}

/// The factor of a resistance to the motions of linkages.
///
/// # Errors
/// A matrix that is not positive definite.
fn cholesky(matrix: DMatrix<f64>) -> Result<Cholesky<f64, Dyn>, ModelError> {
    matrix.clone().cholesky().ok_or_else(|| {
        let name = "resistance of the motions that the links leave free";
        let remedy = "the bodies are too close for this model; use a more accurate one";
        ModelError::not_positive_definite(name, &matrix, remedy)
    })
}

/// Three successive entries.
fn vector(list: &DVector<f64>, first: usize) -> Vector3<f64> {
    list.fixed_rows::<3>(first).into_owned()
}

/// Number of the first group whose entries have the largest sum of squares.
fn largest_of(groups: &[Vec<usize>], entry: impl Fn(usize) -> f64) -> usize {
    let squares = groups
        .iter()
        .map(|group| group.iter().map(|&k| entry(k).powi(2)).sum::<f64>());
    let largest = squares.enumerate().fold(
        (0, -1.0),
        |most, found| {
            if found.1 > most.1 { found } else { most }
        },
    );
    largest.0
}
