//! Linear responses of a flow to the velocities of its bodies, and to a change of its viscosity.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::flow_system::{Balance, Fields, FlowSystem, Residual, Terms};
use super::nested_condensation::CondensedFactors;
use crate::AxisymmetricError;
use crate::curve::{BoundaryPart, Point};
use crate::quadrature::gauss;

/// Changes of a flow by unit velocities of its bodies, to first order.
pub(crate) struct Responses {
    /// Change of the flow by each velocity.
    pub flows: Vec<Fields>,
    /// Derivative of the forces on the bodies by the velocities.
    pub forces: DMatrix<f64>,
}

impl FlowSystem {
    /// The responses of a flow to the velocities of its bodies, all of which are prescribed.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn responses(
        &self,
        positions: &[Point],
        fields: &Fields,
        terms: &Terms,
        factors: &CondensedFactors,
    ) -> Result<Responses, AxisymmetricError> {
        let n = self.motions.len();
        let no_loads = Balance {
            matrix: DMatrix::zeros(0, 0),
            load: Vec::new(),
        };
        let mut flows: Vec<Fields> = (0..n)
            .map(|body| {
                let mut unit = self.rest();
                for (node, _) in self.nodes_on_bodies().filter(|(_, on)| *on == body) {
                    unit.velocity[node] = Point::new(1.0, 0.0);
                }
                unit
            })
            .collect();
        let at_rest = self.rest();
        let residuals = self.products_at_bodies(positions, fields, terms, &flows)?;
        for (flow, residual) in flows.iter_mut().zip(&residuals) {
            flow.add(&self.change(&at_rest, residual, &no_loads, factors), 1.0);
        }
        let residuals = self.products_at_bodies(positions, fields, terms, &flows)?;
        let forces: Vec<f64> = residuals.iter().flat_map(|r| self.forces(r)).collect();
        Ok(Responses {
            flows,
            forces: DMatrix::from_vec(n, n, forces),
        })
    }

    /// Changes of the forces on the bodies with a change of the flow, to first order.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn forces_of_change(
        &self,
        positions: &[Point],
        fields: &Fields,
        terms: &Terms,
        change: &Fields,
    ) -> Result<Vec<f64>, AxisymmetricError> {
        let flows = std::slice::from_ref(change);
        let products = self.products_at_bodies(positions, fields, terms, flows)?;
        Ok(products.iter().flat_map(|r| self.forces(r)).collect())
    }

    /// Products of the Jacobian of the triangles at bodies with several flows.
    ///
    /// They are complete in the rows of the nodes on bodies, and everywhere for flows that differ
    /// from zero at these nodes only.
    fn products_at_bodies(
        &self,
        positions: &[Point],
        fields: &Fields,
        terms: &Terms,
        flows: &[Fields],
    ) -> Result<Vec<Residual>, AxisymmetricError> {
        let on_body = |node: &u32| {
            let part = self.parts.get(*node as usize).copied().flatten();
            matches!(part, Some(BoundaryPart::Body(_)))
        };
        let at_bodies: Vec<usize> = (0..self.mesh.triangles.len())
            .filter(|&t| self.spaces[0].nodes[t].iter().any(on_body))
            .collect();
        let products = (at_bodies.par_iter())
            .map(|&t| {
                let matrix = self.element(t, positions, fields, terms)?.jacobian();
                let [velocities, pressures] = [0, 1].map(|k| &self.spaces[k].nodes[t]);
                let columns = flows.iter().map(|flow| {
                    let u = |d: usize| {
                        (velocities.iter()).map(move |&node| flow.velocity[node as usize][d])
                    };
                    let p = pressures.iter().map(|&node| flow.pressure[node as usize]);
                    &matrix * DVector::from_iterator(matrix.nrows(), u(0).chain(u(1)).chain(p))
                });
                Ok(columns.collect::<Vec<_>>())
            })
            .collect::<Result<Vec<_>, AxisymmetricError>>()?;
        let mut residuals: Vec<Residual> = flows.iter().map(|_| self.no_residual()).collect();
        for (&t, columns) in at_bodies.iter().zip(&products) {
            for (residual, column) in residuals.iter_mut().zip(columns) {
                self.add_local(t, column, residual);
            }
        }
        Ok(residuals)
    }

    /// Power of the part of the viscosity that is not constant, in the fluid that is meshed,
    /// relative to the Newtonian drag of a body of this size at this speed.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn relative_excess(
        &self,
        positions: &[Point],
        fields: &Fields,
        terms: &Terms,
        size: f64,
        speed: f64,
    ) -> Result<f64, AxisymmetricError> {
        let power = self.sum(positions, fields, terms, |element| element.excess())?;
        let drag = 6.0 * PI * terms.coefficients.viscosity.constant * size * speed * speed;
        Ok(if power > 0.0 { power / drag } else { 0.0 })
    }

    /// Estimated change of a force by the varying viscosity beyond an open boundary, relative to
    /// the Newtonian drag of a body of this size at this speed.
    ///
    /// Only the viscosity `η_0` at rest is known there. Shear rates decay at least like those of a
    /// force, `g (R / r)^2` with the largest rate `g` on the boundary, so that
    ///
    /// ```text
    /// ∫ |η - η_0| g g' dV <= 4 π R^3 g g' ∫ |η(g s^2) - η_0| ds,    s from 0 to 1
    /// ```
    ///
    /// bounds the change in the reciprocal theorem with the flow of the drag, whose shear rate is
    /// `g' = 3 a / (2 R^2)` times the speed.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn neglected_outside(
        &self,
        positions: &[Point],
        fields: &Fields,
        terms: &Terms,
        size: f64,
        speed: f64,
    ) -> Result<f64, AxisymmetricError> {
        let Some(exterior) = &self.exterior else {
            return Ok(0.0);
        };
        let radius = exterior.radius;
        let mut rate = 0.0_f64;
        for t in 0..self.mesh.triangles.len() {
            let open = |edge: &usize| {
                self.mesh.boundary[*edge].is_some_and(|b| b.part() == BoundaryPart::Open)
            };
            if !self.mesh.edges[t].iter().any(open) {
                continue;
            }
            for (x, at) in self.element(t, positions, fields, terms)?.shear_rates() {
                let distance = (x.x - exterior.centre).hypot(x.y);
                rate = rate.max(at * (distance / radius).powi(2));
            }
        }
        let viscosity = &terms.coefficients.viscosity;
        let of_drag = (1.5 * size * speed / (radius * radius)).max(rate);
        /// The viscosity is a smooth function of the shear rate.
        const POINTS: usize = 12;
        let mean: f64 = (gauss(POINTS).into_iter())
            .map(|(s, weight)| weight * viscosity.excess(rate * s * s).abs())
            .sum();
        let change = 4.0 * PI * radius.powi(3) * rate * of_drag * mean;
        let drag = 6.0 * PI * viscosity.constant * size * speed * speed;
        Ok(if change > 0.0 { change / drag } else { 0.0 })
    }
}
