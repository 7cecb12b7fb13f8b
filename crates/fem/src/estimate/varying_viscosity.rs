//! Viscosity that depends on the shear rate, in the equations of cubic elements.

use mesh::{TetMesh, Vec3};
use nalgebra::Matrix3;
use rayon::prelude::*;

use super::bubbles::{RULE_POINTS, rule};
use crate::FemError;
use crate::error::check_vectors;
use crate::geometry::MapAt;
use crate::quantity::gradient_in_cell;
use crate::sum::CELLS_PER_TASK;

/// Viscosity `η(g)` and `η'(g) / g` at a shear rate `g = sqrt(2 D:D)`.
///
/// The second is zero for `g = 0`.
pub type ViscosityOfRate<'a> = dyn Fn(f64) -> [f64; 2] + Sync + 'a;

/// The stress `2 η(g) D` at a flow, and its derivative there, for estimates of errors.
///
/// Equations with it have the stress in place of `∇u`, and no terms on surfaces.
pub struct VaryingViscosity<'a> {
    law: &'a ViscosityOfRate<'a>,
    cells: Vec<[PointStress; RULE_POINTS]>,
}

/// The stress at a quadrature point.
#[derive(Clone, Copy)]
pub(super) struct PointStress {
    viscosity: f64,
    /// `η' / g`.
    thinning: f64,
    /// `2 D`.
    twice_rate: Matrix3<f64>,
}

/// What of a stress that varies with the shear rate equations contain.
#[derive(Clone, Copy)]
pub(super) enum StressOf {
    /// Its derivative, times a change of the flow.
    Derivative,
    /// The stress of the flow itself, whose velocity comes without the background flow.
    Flow,
}

/// The shear rate `sqrt(2 D:D)` for `2 D`.
fn shear(twice_rate: &Matrix3<f64>) -> f64 {
    (0.5 * twice_rate.dot(twice_rate)).sqrt()
}

impl PointStress {
    fn new(law: &ViscosityOfRate, gradient: &Matrix3<f64>) -> Self {
        let twice_rate = gradient + gradient.transpose();
        let [viscosity, thinning] = law(shear(&twice_rate));
        Self {
            viscosity,
            thinning,
            twice_rate,
        }
    }

    /// The stress.
    pub fn stress(&self) -> Matrix3<f64> {
        self.twice_rate * self.viscosity
    }

    /// Its derivative in the direction of a velocity with this gradient.
    pub fn derivative(&self, gradient: &Matrix3<f64>) -> Matrix3<f64> {
        let twice_rate = gradient + gradient.transpose();
        twice_rate * self.viscosity
            + self.twice_rate * (self.thinning * self.twice_rate.dot(gradient))
    }

    /// What the stress changes beyond its derivative when a velocity with the gradient `change` is
    /// added to one with the gradient `before`: `τ(D + b + c) - τ(D + b) - τ'(D) c`.
    pub fn remainder(
        &self,
        law: &ViscosityOfRate,
        before: &Matrix3<f64>,
        change: &Matrix3<f64>,
    ) -> Matrix3<f64> {
        self.changed(law, &(before + change)) - self.changed(law, before) - self.derivative(change)
    }

    /// The stress after a change of the velocity with this gradient.
    pub fn changed(&self, law: &ViscosityOfRate, gradient: &Matrix3<f64>) -> Matrix3<f64> {
        let twice_rate = self.twice_rate + gradient + gradient.transpose();
        twice_rate * law(shear(&twice_rate))[0]
    }
}

impl<'a> VaryingViscosity<'a> {
    /// The viscosity of a flow with the velocity `velocity` at the nodes of a mesh.
    ///
    /// Memory: 1.2 kB per cell.
    ///
    /// # Errors
    /// A velocity of the wrong length or not finite; an inverted cell.
    pub fn new(
        mesh: &TetMesh,
        velocity: &[Vec3],
        law: &'a ViscosityOfRate<'a>,
    ) -> Result<Self, FemError> {
        check_vectors("the velocity", velocity, mesh.n_points())?;
        let of_cell = |cell: usize| {
            let (nodes, positions) = (&mesh.cells()[cell], mesh.cell_points(cell));
            let mut points = [PointStress::new(law, &Matrix3::zeros()); RULE_POINTS];
            for (stress, point) in points.iter_mut().zip(rule()) {
                let map = MapAt::new(cell, &positions, point.at)?;
                let gradient = gradient_in_cell(nodes, velocity, &map.gradients(point.at));
                *stress = PointStress::new(law, &gradient);
            }
            Ok(points)
        };
        let cells = (0..mesh.n_cells())
            .into_par_iter()
            .with_min_len(CELLS_PER_TASK)
            .map(of_cell)
            .collect::<Result<_, FemError>>()?;
        Ok(Self { law, cells })
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.cells.len()
    }

    /// The viscosity of a flow with this `2 D`.
    pub(super) fn at(&self, twice_rate: &Matrix3<f64>) -> f64 {
        (self.law)(shear(twice_rate))[0]
    }

    /// The stress at the quadrature points of a cell.
    pub(super) fn of_cell(&self, cell: usize) -> &[PointStress; RULE_POINTS] {
        &self.cells[cell]
    }

    /// Viscosity of a cell, the mean over its quadrature points.
    pub(super) fn mean(&self, cell: usize) -> f64 {
        let points = self.cells[cell].iter();
        points.map(|point| point.viscosity).sum::<f64>() / RULE_POINTS as f64
    }

    /// The viscosity at a shear rate, and its derivative.
    pub(super) fn law(&self) -> &ViscosityOfRate<'a> {
        self.law
    }
}
