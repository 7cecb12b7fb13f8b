//! Viscous stress of a generalised Newtonian fluid, and its exact derivative.
//!
//! A constant part `c` of the viscosity has the form of [`crate::forms`], the rest the symmetric
//! one:
//!
//! ```text
//! c a(u, v) + ∫ c (∇·u) (∇·v) + ∫ 2 (η(g) - c) D(u):D(v),    g^2 = 2 D:D
//! ```
//!
//! with `D_zz = ∂u_z/∂z`, `D_rr = ∂u_r/∂r`, `D_θθ = u_r / r`, `2 D_zr = ∂u_z/∂r + ∂u_r/∂z`. The
//! terms with `c` differ from `∫ 2 c D:D` by `∫ c (∇·u ∇·v - ∇u^T:∇v)`, which is an integral of
//! tangential derivatives over the boundary: forces on surfaces that do not rotate are the same,
//! and the form stays convex in flows whose divergence vanishes only weakly. The constant part is
//! that of unbounded fluid, whose open boundary belongs to the form of [`crate::forms`].

use nalgebra::{DMatrix, DVector};
use rheology::ViscosityLaw;

use crate::element::Table;
use crate::forms::{derivatives, scaled, transposed};
use crate::geometry_map::MapPoint;

/// The viscosity of a fluid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Viscosity<'a> {
    /// The constant part `c`.
    pub constant: f64,
    /// The law of the whole viscosity; without one it is the constant part.
    pub law: Option<&'a dyn ViscosityLaw>,
    /// Whether the derivative of the viscosity is left out of that of the stress.
    pub is_frozen: bool,
}

impl Default for Viscosity<'_> {
    fn default() -> Self {
        Self::constant(1.0)
    }
}

impl<'a> Viscosity<'a> {
    /// A Newtonian fluid.
    pub fn constant(constant: f64) -> Self {
        Self {
            constant,
            law: None,
            is_frozen: false,
        }
    }

    /// The viscosity at a shear rate.
    pub fn at(&self, shear_rate: f64) -> f64 {
        self.law
            .map_or(self.constant, |law| law.viscosity(shear_rate))
    }

    /// The part of the viscosity at a shear rate that is not constant.
    pub fn excess(&self, shear_rate: f64) -> f64 {
        self.at(shear_rate) - self.constant
    }
}

/// A law without its regularisation; where its viscosity is infinite, at rest, with it.
#[derive(Debug)]
pub(crate) struct Unregularised<'a>(pub &'a dyn ViscosityLaw);

impl ViscosityLaw for Unregularised<'_> {
    fn viscosity(&self, shear_rate: f64) -> f64 {
        match self.0.unregularised_viscosity(shear_rate) {
            viscosity if viscosity.is_finite() => viscosity,
            _ => self.0.viscosity(shear_rate),
        }
    }

    fn derivative(&self, shear_rate: f64) -> f64 {
        self.0.derivative(shear_rate)
    }

    fn potential(&self, shear_rate: f64) -> f64 {
        self.0.potential(shear_rate)
    }
}

/// The rate of strain at a point: `√2 D_zz`, `√2 D_rr`, `√2 D_θθ` and `2 D_zr`.
///
/// The product of two such lists is `2 D:D`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strain([f64; 4]);

impl Strain {
    /// The strain for a gradient `∂u_i/∂x_d` at `[i][d]` and a hoop strain `u_r / r`.
    pub fn new(gradient: &[[f64; 2]; 2], hoop: f64) -> Self {
        let root = std::f64::consts::SQRT_2;
        Self([
            root * gradient[0][0],
            root * gradient[1][1],
            root * hoop,
            gradient[0][1] + gradient[1][0],
        ])
    }

    /// The shear rate `g = sqrt(2 D:D)`.
    pub fn rate(&self) -> f64 {
        self.dot(self).sqrt()
    }

    /// The product `2 D:D'`.
    pub fn dot(&self, other: &Self) -> f64 {
        self.0.iter().zip(other.0).map(|(a, b)| a * b).sum()
    }
}

/// Derivative of the viscous form without `c a(u, v)`, as a matrix of the axial and then the radial
/// velocities of an element.
///
/// `∫ 2 (η - c) D(w):D(v) + (η'/g) (2 D:D(w)) (2 D:D(v)) + c (∇·w) (∇·v)`, by the strains at the
/// points.
pub(crate) fn tangent(
    viscosity: &Viscosity,
    points: &[MapPoint],
    velocity: &Table,
    strains: &[Strain],
) -> DMatrix<f64> {
    let [by_z, by_r] = derivatives(points, velocity);
    let over_radius = scaled(&velocity.values, |q| 1.0 / points[q].radius);
    let (n, m) = velocity.values.shape();
    let root = std::f64::consts::SQRT_2;
    let zero = DMatrix::zeros(n, m);
    // components of the strain of each basis function: axial ones above radial ones
    let stack = |axial: &DMatrix<f64>, radial: &DMatrix<f64>, factor: f64| {
        let mut rows = DMatrix::zeros(2 * n, m);
        rows.rows_mut(0, n).copy_from(axial);
        rows.rows_mut(n, n).copy_from(radial);
        rows * factor
    };
    let components = [
        stack(&by_z, &zero, root),
        stack(&zero, &by_r, root),
        stack(&zero, &over_radius, root),
        stack(&by_r, &by_z, 1.0),
    ];
    let rates: Vec<f64> = strains.iter().map(Strain::rate).collect();
    let excess = DVector::from_fn(m, |q, _| points[q].measure * viscosity.excess(rates[q]));
    let mut matrix = DMatrix::zeros(2 * n, 2 * n);
    let mut along = DMatrix::zeros(2 * n, m);
    for (component, rows) in components.iter().enumerate() {
        matrix.gemm(1.0, rows, &transposed(&scaled(rows, |q| excess[q])), 1.0);
        along += scaled(rows, |q| match rates[q] > 0.0 {
            true => strains[q].0[component] / rates[q],
            false => 0.0,
        });
    }
    if let Some(law) = viscosity.law.filter(|_| !viscosity.is_frozen) {
        let slopes = DVector::from_fn(m, |q, _| match rates[q] > 0.0 {
            true => {
                let slope = law.tangent_viscosity(rates[q]) - law.viscosity(rates[q]);
                points[q].measure * slope
            }
            // the limit of g η'
            false => 0.0,
        });
        matrix.gemm(
            1.0,
            &along,
            &transposed(&scaled(&along, |q| slopes[q])),
            1.0,
        );
    }
    if viscosity.constant != 0.0 {
        let divergence = stack(&by_z, &(by_r + over_radius), 1.0);
        let weighted = scaled(&divergence, |q| points[q].measure * viscosity.constant);
        matrix.gemm(1.0, &divergence, &transposed(&weighted), 1.0);
    }
    matrix
}
