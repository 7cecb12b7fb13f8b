//! Flows of least energy: fluids without inertia whose viscosity depends on the shear rate.

use rayon::prelude::*;

use super::flow_system::{Balance, Fields, FlowSystem, Residual, Terms};
use super::momentum::MomentumElement;
use super::nested_condensation::CondensedFactors;
use crate::AxisymmetricError;
use crate::curve::{BoundaryPart, Point};

/// Change at which Newton's method for a law may stagnate: rounding by viscosities that differ by
/// many orders of magnitude.
pub(super) const ROUNDING: f64 = 1e-9;

impl FlowSystem {
    /// Sum over all triangles.
    pub(super) fn sum(
        &self,
        positions: &[Point],
        fields: &Fields,
        terms: &Terms,
        of: impl Fn(&MomentumElement) -> f64 + Sync,
    ) -> Result<f64, AxisymmetricError> {
        let parts = (0..self.mesh.triangles.len())
            .into_par_iter()
            .map(|t| Ok(of(&self.element(t, positions, fields, terms)?)))
            .collect::<Result<Vec<_>, AxisymmetricError>>()?;
        Ok(parts.iter().sum())
    }

    /// Dissipation of a flow in the fluid that is meshed.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn dissipation(
        &self,
        positions: &[Point],
        fields: &Fields,
        terms: &Terms,
    ) -> Result<f64, AxisymmetricError> {
        self.sum(positions, fields, terms, |element| element.dissipation())
    }

    /// Power of what the regularisation of the viscosity law changes, relative to the dissipation.
    ///
    /// It bounds the change of forces on bodies that move alike to first order.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn regularised(
        &self,
        positions: &[Point],
        fields: &Fields,
        terms: &Terms,
    ) -> Result<f64, AxisymmetricError> {
        let changed = self.sum(positions, fields, terms, |element| element.regularised())?;
        Ok(match changed > 0.0 {
            true => changed / self.dissipation(positions, fields, terms)?,
            false => 0.0,
        })
    }

    /// Potential of the viscous forces less the work of the loads.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    fn energy(
        &self,
        positions: &[Point],
        fields: &Fields,
        terms: &Terms,
        balance: &Balance,
    ) -> Result<f64, AxisymmetricError> {
        let inside = self.sum(positions, fields, terms, |element| element.energy())?;
        let outside = self.exterior.as_ref().map_or(0.0, |exterior| {
            let (tractions, velocities) = exterior.tractions(&fields.velocity);
            0.5 * terms.coefficients.viscosity.constant * tractions.dot(&velocities)
        });
        let work = fields.motions.iter().zip(&balance.load).map(|(u, f)| u * f);
        Ok(inside + outside - work.sum::<f64>())
    }

    /// Forces on the fluid at the nodes of bodies, whose products with velocities of their surfaces
    /// are powers of the stress.
    ///
    /// They are the residuals and what the form of the constant viscosity omits, `c ∫ (∇u^T:∇v -
    /// ∇·u ∇·v)`: by the formula of [`crate::surface_modes::omitted_powers`] it is zero for
    /// surfaces that move rigidly along the axis, but not for slip.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn surface_forces(
        &self,
        residual: Residual,
        positions: &[Point],
        fields: &Fields,
        terms: &Terms,
    ) -> Result<Residual, AxisymmetricError> {
        let mut forces = residual;
        if terms.coefficients.viscosity.constant == 0.0 {
            return Ok(forces);
        }
        let [velocities, _] = &self.spaces;
        for (t, nodes) in velocities.nodes.iter().enumerate() {
            let is_on_body = |node: &u32| {
                let part = self.parts.get(*node as usize).copied().flatten();
                matches!(part, Some(BoundaryPart::Body(_)))
            };
            if !nodes.iter().any(is_on_body) {
                continue;
            }
            let omitted = self.element(t, positions, fields, terms)?.omitted_stress();
            let forces_at = nodes.iter().zip(omitted.row_iter());
            for (node, force) in forces_at.filter(|(node, _)| is_on_body(node)) {
                forces.momentum[*node as usize] += Point::new(force[0], force[1]);
            }
        }
        Ok(forces)
    }

    /// Power of the boundaries on the fluid: forces of [`FlowSystem::surface_forces`] times
    /// velocities at their nodes.
    pub fn boundary_power(&self, forces: &Residual, fields: &Fields) -> f64 {
        let nodes = self.parts.iter().enumerate();
        let moving = nodes
            .filter(|(_, part)| matches!(part, Some(BoundaryPart::Body(_) | BoundaryPart::Wall)));
        moving
            .map(|(node, _)| forces.momentum[node].dot(&fields.velocity[node]))
            .sum()
    }

    /// Finds the flow of least energy, without inertia, by Newton's method with backtracking.
    ///
    /// The energy is convex in flows without divergence, so that the method decreases it from any
    /// of them. Where the fluid hardly moves, the energy does not notice that Newton's method does
    /// not converge: for a power law of index below a half it overshoots by more than the error.
    /// Steps with frozen viscosity reduce the logarithm of every shear rate's error by the factor
    /// of one minus the index; some are taken whenever a step does not halve the change.
    ///
    /// The first iteration removes the divergence of a flow that is not `solenoidal`, at full
    /// length. Returns the number of iterations, the last change and the factors of the last
    /// matrix.
    ///
    /// # Errors
    /// Those of [`FlowSystem::iterate`].
    pub fn minimise(
        &self,
        positions: &[Point],
        fields: &mut Fields,
        terms: &Terms,
        balance: &Balance,
        solenoidal: bool,
        tolerance: f64,
    ) -> Result<(usize, f64, CondensedFactors), AxisymmetricError> {
        /// Power laws of index 0.2 in a ball of 1000 radii need 60.
        const MAX_ITERATIONS: usize = 100;
        /// Part of the predicted decrease that is required (Nocedal & Wright 2006, 3.1).
        const SUFFICIENT: f64 = 1e-4;
        /// Rounding of an energy that is a sum over many points.
        const ROUNDING_OF_ENERGY: f64 = 1e-13;
        let mut energy = match solenoidal {
            true => self.energy(positions, fields, terms, balance)?,
            false => f64::INFINITY,
        };
        let mut frozen_terms = *terms;
        frozen_terms.coefficients.viscosity.is_frozen = true;
        let (mut frozen_steps, mut next_frozen) = (0, 2);
        let (mut iteration, mut last) = (0, f64::INFINITY);
        loop {
            iteration += 1;
            let residual = self.residual(positions, fields, terms)?;
            let of_matrix = match frozen_steps {
                0 => terms,
                _ => &frozen_terms,
            };
            let factors = self.factor(positions, fields, of_matrix, balance)?;
            let change = self.change(fields, &residual, balance, &factors);
            let slope = self.slope(&residual, &change, balance);
            let mut length = 1.0;
            let mut next = fields.clone();
            next.add(&change, length);
            let mut reached = self.energy(positions, &next, terms, balance)?;
            let limit = |length: f64| {
                energy + SUFFICIENT * length * slope + ROUNDING_OF_ENERGY * energy.abs()
            };
            let decreases = |reached: f64, length: f64| reached <= limit(length);
            while energy.is_finite() && !decreases(reached, length) && length > f64::EPSILON {
                length *= 0.5;
                next.clone_from(fields);
                next.add(&change, length);
                reached = self.energy(positions, &next, terms, balance)?;
            }
            let size = change.relative_to(&next);
            *fields = next;
            energy = reached;
            let is_slow = size > 0.5 * last || length < 1.0;
            let is_solved = size <= tolerance && frozen_steps == 0 && length == 1.0;
            let is_rounding = size <= ROUNDING && is_slow && frozen_steps == 0;
            if is_solved || is_rounding || iteration == MAX_ITERATIONS || !size.is_finite() {
                return Ok((iteration, size, factors));
            }
            match frozen_steps {
                0 if is_slow => {
                    frozen_steps = next_frozen;
                    next_frozen *= 2;
                }
                steps => frozen_steps = steps.max(1) - 1,
            }
            last = size;
        }
    }

    /// Derivative of the energy along a change without divergence.
    fn slope(&self, residual: &Residual, change: &Fields, balance: &Balance) -> f64 {
        let of_fluid = (residual.momentum.iter().zip(&change.velocity)).map(|(r, u)| r.dot(u));
        let of_loads = balance.load.iter().zip(&change.motions).map(|(f, u)| f * u);
        of_fluid.sum::<f64>() - of_loads.sum::<f64>()
    }
}
