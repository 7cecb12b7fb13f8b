//! Flows on a new mesh of the same fluid.

use rayon::prelude::*;

use super::flow_system::{BoundaryVelocity, Fields, FlowSystem};
use super::locator::Place;
use super::nested_condensation::CondensedFactors;
use crate::AxisymmetricError;
use crate::curve::Point;

/// What is known at one time.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
pub(super) struct Level {
    pub(super) time: f64,
    /// Positions of the nodes, and the flow there.
    pub(super) nodes: Vec<Point>,
    pub(super) fields: Fields,
    /// Displacements of the free motions since the mesh was generated.
    pub(super) displacements: Vec<f64>,
    /// Displacements that the forcing gives to the bodies.
    pub(super) given: Vec<f64>,
    /// Velocities of the bodies.
    pub(super) velocities: Vec<f64>,
}

/// Carries flows from the mesh of one system to that of another one.
///
/// Velocities are interpolated, those on the boundary are given, and the gradient of a pressure
/// makes the sum free of divergence: with the interpolant `u_I`
///
/// ```text
/// κ (u, v) + (∇u, ∇v) - (p, ∇·v) = κ (u_I, v) + (∇u_I, ∇v),   (q, ∇·u) = 0
/// ```
///
/// Interpolation alone would leave a divergence, and the next step a pressure of the size `1 / Δt`.
pub(crate) struct FlowTransfer<'a> {
    old: &'a FlowSystem,
    new: &'a FlowSystem,
    /// Positions of the new nodes at the present time.
    nodes: Vec<Point>,
    /// Where each new node is in the old mesh.
    places: Vec<Place>,
    /// The new system with prescribed motions, and the factors of the projection.
    held: FlowSystem,
    factors: CondensedFactors,
}

/// Coefficient `κ` of the mass matrix, in units of the viscous term at the size of the smallest
/// body.
///
/// Components of the length `κ^(-1/2)`, that of small elements on a body, count alike in both
/// terms.
const PROJECTION_COEFFICIENT: f64 = 1e2;

/// Solves by which the divergence vanishes on the mesh of an earlier time too, by the factors of
/// the present one: each reduces it by the relative change of the mesh between both.
const SOLVES: usize = 3;

impl<'a> FlowTransfer<'a> {
    /// Between the systems, the nodes of the first of which are here; `size` is that of the
    /// smallest body.
    ///
    /// # Errors
    /// [`AxisymmetricError::OutsideMesh`], failures of the factorisation.
    pub fn new(
        (old, nodes): (&'a FlowSystem, &[Point]),
        new: &'a FlowSystem,
        size: f64,
    ) -> Result<Self, AxisymmetricError> {
        let positions = new.positions();
        let locator = old.locator(nodes);
        let places = (positions.par_iter())
            .map(|x| locator.locate(x))
            .collect::<Result<_, _>>()?;
        let held = new.held()?;
        let factors = held.factor_projection(&positions, PROJECTION_COEFFICIENT / (size * size))?;
        Ok(Self {
            old,
            new,
            nodes: positions,
            places,
            held,
            factors,
        })
    }

    /// Carries a level, whose mesh at the `present` time is that of this transfer; returns the
    /// change of the momentum over the density.
    ///
    /// # Errors
    /// A mesh of the earlier time that is inverted, failures of the projection.
    pub fn carry(
        &self,
        level: &mut Level,
        present: &Level,
        boundary: &BoundaryVelocity,
    ) -> Result<f64, AxisymmetricError> {
        let moved: Vec<Point> = (level.nodes.iter().zip(&present.nodes))
            .map(|(then, now)| then - now)
            .collect();
        let before = self.old.momentum(&level.nodes, &level.fields)?;
        let at_places = |field: &[Point]| -> Vec<Point> {
            (self.places.par_iter())
                .map(|place| self.old.value(place, field))
                .collect()
        };
        // The motion is along the axis.
        let nodes: Vec<Point> = (self.nodes.iter().zip(at_places(&moved)))
            .map(|(x, moved)| Point::new(x.x + moved.x, x.y))
            .collect();
        let mut fields = Fields {
            velocity: at_places(&level.fields.velocity),
            motions: level.fields.motions.clone(),
            ..self.new.rest()
        };
        for (x, u) in self.nodes.iter().zip(&mut fields.velocity) {
            if x.y == 0.0 {
                u.y = 0.0;
            }
        }
        self.held.set_boundary(boundary, &mut fields);
        for _ in 0..SOLVES {
            (self.held).remove_divergence(&nodes, &mut fields, &self.factors)?;
        }
        let after = self.new.momentum(&nodes, &fields)?;
        level.nodes = nodes;
        level.fields = fields;
        Ok(after - before)
    }
}
