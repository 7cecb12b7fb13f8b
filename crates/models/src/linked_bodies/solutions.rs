//! Velocities and forces of linked bodies by a resistance or a mobility.

use microhydro::{Linkage, LinkedMotion, LinkedSpheres, Mobility, PointMobility};
use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;
use rigid::ExternalLoad;

use super::SomeLinkages;
use super::moving_linkage::cholesky;
use crate::error::ModelError;
use crate::scaled_scene::MeanFlowCondition;
use crate::surface_motion::SurfaceEffect;

/// Velocities and forces of linked bodies, in scaled units.
#[derive(Clone)]
pub(crate) struct MobilitySolution {
    /// Generalised velocities of all bodies and frames.
    pub generalised: DVector<f64>,
    /// Forces and torques that the bodies with surfaces exert on the fluid.
    pub forces: DVector<f64>,
    /// Loads that hold bodies, with the indices of the bodies.
    pub(super) holding: Vec<(usize, ExternalLoad)>,
    /// Mean flow of a periodic box; zero elsewhere.
    pub mean_flow: Vector3<f64>,
    /// Residual of the equations, relative to the right-hand side.
    pub residual: f64,
    /// Power of the slip on the fluid, less that of random loads, which are the fluid's own.
    pub slip_power: f64,
    /// Rates of the amplitudes of deformations, and the forces on them.
    pub(super) amplitudes: Vec<(f64, f64)>,
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

impl MobilitySolution {
    /// Sum of the forces on the fluid.
    pub fn total_force(&self) -> Vector3<f64> {
        let loads = self.forces.as_slice().chunks_exact(6);
        loads
            .map(|load| Vector3::from_column_slice(&load[..3]))
            .sum()
    }

    /// The solution with the powers of slip and deformation, for these further degrees of freedom
    /// of the mobility.
    fn with_powers(mut self, effect: Option<&SurfaceEffect>, hidden: &DVector<f64>) -> Self {
        if let Some(effect) = effect {
            let powers = effect.powers(&self.forces, hidden);
            self.slip_power += powers.as_slice().first().copied().unwrap_or_default();
            let of_amplitudes = powers.iter().skip(1).copied();
            self.amplitudes = effect.rates.iter().copied().zip(of_amplitudes).collect();
        }
        self
    }
}

/// Linked spheres whose further degrees of freedom an effect drives.
///
/// # Errors
/// An effect for others.
fn driven<'m, M: Mobility>(
    system: LinkedSpheres<'m, M>,
    effect: Option<&SurfaceEffect>,
) -> Result<LinkedSpheres<'m, M>, ModelError> {
    Ok(match effect {
        Some(effect) if !effect.hidden.is_empty() => system.with_hidden(effect.hidden.clone())?,
        _ => system,
    })
}

impl SomeLinkages<'_> {
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
    /// Where the total force is given instead of the mean flow, minus the flow is three more of
    /// these motions, on which this force acts.
    ///
    /// # Errors
    /// `S^T R S` that is not positive definite.
    pub fn by_resistance(
        &self,
        resistance: &DMatrix<f64>,
        effect: Option<&SurfaceEffect>,
    ) -> Result<MobilitySolution, ModelError> {
        let (mut s, w, mut matrix) = self.reduced(resistance);
        let loads = self
            .linkages
            .iter()
            .flat_map(|one| one.load.iter().copied());
        let mut load = DVector::from_iterator(matrix.nrows(), loads);
        if let MeanFlowCondition::TotalForce(total) = self.mean_flow {
            let free = s.ncols();
            s = s.resize_horizontally(free + 3, 0.0);
            for row in 0..s.nrows() {
                if row % 6 < 3 {
                    s[(row, free + row % 6)] = 1.0;
                }
            }
            let flow = s.columns(free, 3);
            let of_flow = s.tr_mul(&(resistance * flow));
            matrix = matrix.resize(free + 3, free + 3, 0.0);
            matrix.columns_mut(free, 3).copy_from(&of_flow);
            matrix.rows_mut(free, 3).copy_from(&of_flow.transpose());
            load = load.resize_vertically(free + 3, 0.0);
            load.fixed_rows_mut::<3>(free).copy_from(&total);
        }
        let force_free = self.force_free(effect, &self.given_flow());
        let relative_to_fluid = |velocities: &DVector<f64>| velocities - &force_free;
        let rhs = load - s.tr_mul(&(resistance * relative_to_fluid(&w)));
        let coefficients = cholesky(matrix.clone())?.solve(&rhs);
        let scale = rhs.amax();
        let residual = (&matrix * &coefficients - &rhs).amax();
        let velocities = &s * &coefficients + &w;
        let forces = resistance * relative_to_fluid(&velocities);
        let own = self.of_linkages(&coefficients);
        let mean_flow = match self.mean_flow {
            MeanFlowCondition::Velocity(velocity) => velocity,
            MeanFlowCondition::TotalForce(_) => {
                -coefficients.fixed_rows::<3>(coefficients.len() - 3)
            }
        };
        let residual = if scale > 0.0 { residual / scale } else { 0.0 };
        let solution = self.solution(&own, forces, mean_flow, residual)?;
        Ok(solution.with_powers(effect, &DVector::zeros(0)))
    }

    /// The coordinates of each linkage, one after the other in all.
    pub(super) fn of_linkages(&self, all: &DVector<f64>) -> Vec<DVector<f64>> {
        let mut first = 0;
        let of_linkages = self.linkages.iter().map(|one| {
            let own = all.rows(first, one.load.len()).into_owned();
            first += own.len();
            own
        });
        of_linkages.collect()
    }

    /// `S`, `W` and `S^T (R + D) S`.
    pub(super) fn reduced(
        &self,
        resistance: &DMatrix<f64>,
    ) -> (DMatrix<f64>, DVector<f64>, DMatrix<f64>) {
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
        let solution = self.solution_of(&found, effect)?;
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
        effect: Option<&SurfaceEffect>,
        (near, residual): (&LinkedMotion, f64),
    ) -> Result<(MobilitySolution, LinkedMotion), ModelError> {
        let system = self.spheres(mobility, effect)?;
        let found = system.solve_near(near, residual)?;
        Ok((self.solution_of(&found, effect)?, found))
    }

    /// The solution of linked spheres with an effect of their surfaces.
    ///
    /// # Errors
    /// Joints that contradict each other.
    fn solution_of(
        &self,
        found: &LinkedMotion,
        effect: Option<&SurfaceEffect>,
    ) -> Result<MobilitySolution, ModelError> {
        let solution = self.solution(
            &found.coordinates,
            found.forces.clone(),
            self.flow_of(found),
            found.residual,
        )?;
        Ok(solution.with_powers(effect, &found.hidden))
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
        effect: Option<&SurfaceEffect>,
        (near, residual): (&LinkedMotion, f64),
    ) -> Result<DVector<f64>, ModelError> {
        let velocities = solution.generalised.select_rows(&self.surface_velocities);
        let velocities = velocities - self.force_free(effect, &solution.mean_flow);
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
        let system = driven(LinkedSpheres::new(mobility, held.collect())?, effect)?;
        Ok(system.solve_near(near, residual)?.forces)
    }

    /// The mean flow if it is given; zero where its part is found beside the motions.
    fn given_flow(&self) -> Vector3<f64> {
        match self.mean_flow {
            MeanFlowCondition::Velocity(velocity) => velocity,
            MeanFlowCondition::TotalForce(_) => Vector3::zeros(),
        }
    }

    /// The mean flow of linked spheres.
    fn flow_of(&self, found: &LinkedMotion) -> Vector3<f64> {
        self.given_flow() + found.mean_flow
    }

    /// Velocities `U_0` of force-free bodies: those of an effect and of the mean flow.
    fn force_free(&self, effect: Option<&SurfaceEffect>, mean_flow: &Vector3<f64>) -> DVector<f64> {
        let mut velocities = match effect {
            Some(effect) => effect.velocities.clone(),
            None => DVector::zeros(self.surface_velocities.len()),
        };
        for sphere in 0..velocities.len() / 6 {
            let mut rows = velocities.fixed_rows_mut::<3>(6 * sphere);
            rows += mean_flow;
        }
        velocities
    }

    /// The linked spheres of a mobility.
    ///
    /// # Errors
    /// Spheres too close for the model.
    pub(super) fn spheres<'m, M: Mobility>(
        &self,
        mobility: &'m M,
        effect: Option<&SurfaceEffect>,
    ) -> Result<LinkedSpheres<'m, M>, ModelError> {
        let force_free = self.force_free(effect, &self.given_flow());
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
        let system = driven(LinkedSpheres::new(mobility, linkages.collect())?, effect)?;
        Ok(match self.mean_flow {
            MeanFlowCondition::Velocity(_) => system,
            MeanFlowCondition::TotalForce(total) => system.with_total_force(total)?,
        })
    }

    /// The solution with these coefficients of each linkage, these forces and this mean flow.
    ///
    /// # Errors
    /// Joints that contradict each other.
    pub fn solution(
        &self,
        coefficients: &[DVector<f64>],
        forces: DVector<f64>,
        mean_flow: Vector3<f64>,
        residual: f64,
    ) -> Result<MobilitySolution, ModelError> {
        let count = self.velocities.iter().map(Vec::len).sum();
        let mut solution = MobilitySolution {
            generalised: DVector::zeros(count),
            forces,
            holding: Vec::new(),
            mean_flow,
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
}
