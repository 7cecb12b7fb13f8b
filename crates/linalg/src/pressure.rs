//! Approximate inverse of the Schur complement of the pressure.

use nalgebra::{DMatrix, DVector};

use crate::csr::Rows;
use crate::product::build_rows;
use crate::transpose::transpose;
use crate::{
    Bordered, Csr, CsrOperator, LinalgError, LinearOperator, MassInverse, MultigridParams,
    SaddleSystem, ScalarMultigrid, csr,
};

/// Chebyshev steps on the pressure mass matrix.
///
/// Two or three need the same iterations, one needs three more.
pub(crate) const MASS_STEPS: usize = 3;

/// Multiple of the mass matrix that is added to the Laplacian, whose null space is the constants.
///
/// Residuals of the divergence sum to zero, so that the shift acts on rounding errors only.
const MASS_SHIFT: f64 = 1e-3;

/// Multiple of `s_q` that approximates the Schur complement of a weak row.
///
/// Iterations with an exact velocity solve on Gmsh meshes of boxes, tubes and balls: equal within
/// one from 3.3 to 5, one or two more with 2.5.
const WEAK_ROW_FACTOR: f64 = 4.0;

/// Approximate inverse of the Schur complement: `M_p^-1 + W`, or `M_p^-1 + W + L^-1`.
///
/// `W` is a diagonal matrix, zero for most rows. A pressure at an edge or a corner of the fluid
/// acts on few free velocities, and its Schur complement is up to ten times smaller than the mass
/// matrix. With the diagonal `D` of the stiffness, `s_q = (B D^-1 B^T)_qq` tells such rows:
/// `W_qq = max(0, 1 / (4 s_q) - 1 / m_q)` for the diagonal `m` of the mass matrix. Inside the
/// fluid, `s_q` is 0.36 to 0.47 times `m_q`, at flat walls 0.23, at edges of 90 degrees 0.12 and at
/// corners 0.07 (medians on Gmsh meshes).
///
/// Symmetric and positive definite. For the Laplacian `L` see
/// [`BlockTriangular::with_pressure_laplacian`](crate::BlockTriangular::with_pressure_laplacian).
pub(crate) struct PressureInverse {
    mass: MassInverse,
    /// The nonzeros of `W`, with their rows.
    weak: Vec<(u32, f64)>,
    laplacian: Option<ScalarMultigrid>,
    inertial: Option<InertialInverse>,
}

impl PressureInverse {
    /// Uses the mass matrix alone.
    pub fn new(system: &SaddleSystem) -> Result<Self, LinalgError> {
        Ok(PressureInverse {
            mass: MassInverse::new(system.pressure_mass(), MASS_STEPS)?,
            weak: weak_rows(system, |_, stiffness| stiffness, 1.0),
            laplacian: None,
            inertial: None,
        })
    }

    /// Adds the inverse of `laplacian`, a symmetric positive semidefinite matrix.
    pub fn with_pressure_laplacian(mut self, laplacian: &Csr) -> Result<Self, LinalgError> {
        self.laplacian = Some(shifted_cycle(laplacian, self.mass.matrix())?);
        Ok(self)
    }

    /// Adds the parts of inertia in the velocity block; see
    /// [`BlockTriangular::with_inertia`](crate::BlockTriangular::with_inertia).
    pub fn with_inertia(
        mut self,
        system: &SaddleSystem,
        inertia: &SchurInertia,
    ) -> Result<Self, LinalgError> {
        let (nodes, mass) = (system.velocity_block().nodes(), self.mass.matrix());
        let diagonal = inertia.mass_diagonal;
        csr::check_shape(
            "diagonal of the mass matrix",
            (diagonal.len(), 1),
            (nodes, 1),
        )?;
        for matrix in inertia.convection.iter().flatten() {
            csr::check_shape("convection of the pressure", matrix.shape(), mass.shape())?;
        }
        let viscous = |node: usize, d: f64| d - inertia.coefficient * diagonal[node];
        let cycle = shifted_cycle(inertia.laplacian, mass)?;
        self.inertial = Some(InertialInverse::new(system, inertia, cycle)?);
        self.weak = weak_rows(system, viscous, inertia.scale);
        Ok(self)
    }

    /// Overwrites the columns `z` with the approximate solutions for `r`.
    pub fn pass<const S: usize>(&mut self, r: [&[f64]; S], mut z: [&mut [f64]; S]) {
        match self.inertial.take() {
            None => self.mass.pass(r, z.each_mut().map(|z| &mut **z)),
            Some(mut inertial) => {
                for (r, z) in r.iter().zip(&mut z) {
                    inertial.solve(r);
                    self.mass.pass([inertial.convected(r)], [&mut **z]);
                    inertial.add(z);
                }
                self.inertial = Some(inertial);
            }
        }
        for (r, z) in r.iter().zip(&mut z) {
            for &(q, w) in &self.weak {
                z[q as usize] += w * r[q as usize];
            }
        }
        // one by one: as the three components of one cycle, columns might be rounded differently
        if let Some(cycle) = &mut self.laplacian {
            for (r, z) in r.iter().zip(&mut z) {
                cycle.solve_into(r, z, |z, v| *z += v);
            }
        }
        if let Some(inertial) = &self.inertial {
            let unscaled = (inertial.scale * inertial.scale).recip();
            for z in z {
                z.iter_mut().for_each(|z| *z *= unscaled);
            }
        }
    }
}

/// Inertia in the velocity block of a system, for the Schur complement of its preconditioner.
///
/// The velocity block is `K + κ M + N` with a mass matrix `M` and convection `N`; the pressure mass
/// matrix of the system belongs to `K` alone.
#[derive(Clone, Copy, Debug)]
pub struct SchurInertia<'a> {
    /// `κ`, zero or positive.
    pub coefficient: f64,
    /// Factor that the divergences `B` and `E` of the system have, the inverse of that of the
    /// pressures. With `κ^(1/2)` residuals of the momentum and of the divergence count alike in the
    /// residual norm also where the mass matrix dominates.
    pub scale: f64,
    /// Diagonal of `M`, one entry per node.
    pub mass_diagonal: &'a [f64],
    /// `L = ∫ ∇psi_p · ∇psi_q` over the pressures, with natural boundary conditions.
    pub laplacian: &'a Csr,
    /// Convection `N_p = ρ ∫ psi_p (c · ∇psi_q)` of the pressures, and diffusion `D_p` of theirs
    /// along the convecting velocity by which it is stabilised; none in a linear flow.
    ///
    /// A pressure of the size of a cell, in velocities with a large Peclet number there, has a
    /// smaller Schur complement than `N_p` says, because the gradient of a linear function is no
    /// eigenvector of the convection of quadratic ones.
    pub convection: Option<[&'a Csr; 2]>,
}

/// Part of the convection through the inflow boundary that the convection of the pressure loses.
///
/// FGMRES iterations to 1e-8 with an exact velocity solve, for a sphere that moves in a ball of ten
/// radii at a Reynolds number of 10, with parts of 0, 1/2 and 1 at the inflow and 0, 1/2 and 1 at
/// the outflow: 99, over 100 and over 100; 39, 46, over 100; 41, 49, over 100.
const INFLOW_PART: f64 = 0.5;

/// Convection of the pressures without a part of that through the inflow boundary.
///
/// `N_p + N_p^T` is the boundary term `∮ (c · n) psi_p psi_q` up to the divergence of `c`; rows
/// with a negative sum are those at the inflow. With natural conditions there, the product with the
/// inverse Laplacian does not approximate the Schur complement of a velocity that is prescribed
/// (Elman, Tuminaro, Electron. Trans. Numer. Anal. 35, 2009).
fn without_inflow(convection: &Csr) -> Csr {
    let transposed = transpose(convection);
    let (rows, columns) = (Rows::new(convection), Rows::new(&transposed));
    let pressures = convection.rows();
    let flux = |q: usize| {
        let both = rows.row(q).chain(columns.row(q));
        both.map(|(_, value)| value).sum::<f64>()
    };
    let at_inflow: Vec<f64> = (0..pressures)
        .map(|q| if flux(q) < 0.0 { 1.0 } else { 0.0 })
        .collect();
    build_rows(pressures, pressures, |q, row| {
        for (r, value) in rows.row(q) {
            row.add(r, value);
        }
        for (r, value) in rows.row(q).chain(columns.row(q)) {
            let part = 0.5 * (at_inflow[q] + at_inflow[r]);
            row.add(r, -INFLOW_PART * part * value);
        }
    })
}

/// A V-cycle for a Laplacian whose null space is the constants.
fn shifted_cycle(laplacian: &Csr, mass: &Csr) -> Result<ScalarMultigrid, LinalgError> {
    csr::check_shape("pressure Laplacian", laplacian.shape(), mass.shape())?;
    let shifted = laplacian + &mass.map(|v| MASS_SHIFT * v);
    ScalarMultigrid::from_scalar(&Bordered::scalar(shifted)?, &MultigridParams::default())
}

/// The parts of inertia in the approximate inverse of the Schur complement.
///
/// `κ M` alone has the Schur complement `L / κ`, with the Laplacian `L` of the pressure and natural
/// boundary conditions. Border dofs with the divergence `E` and the corner `G` add `E G^-1 E_l^T`.
/// With `V` the V-cycle for `L` the inverse of the sum is (Woodbury)
///
/// ```text
/// κ (V - V E (G / κ + E_l^T V E)^-1 E_l^T V)
/// ```
///
/// Light bodies have a small `G`. They then move with the fluid that surrounds them, and the term
/// is as large as the first one, which would prescribe their velocity as that of a wall.
///
/// Convection adds `M_p^-1 (N_r + D_p) V`, the pressure convection-diffusion preconditioner (Kay,
/// Loghin, Wathen 2002), whose other terms are those above, with `N_r` of [`without_inflow`].
struct InertialInverse {
    coefficient: f64,
    /// Factor of the divergence in the system.
    scale: f64,
    cycle: ScalarMultigrid,
    convection: Option<CsrOperator>,
    /// `E_l` without the scale, np x m.
    divergence: Csr,
    /// Columns of `V E`.
    moved: Vec<Vec<f64>>,
    /// `(G / κ + E_l^T V E)^-1`, m x m; empty for `κ = 0`.
    core: DMatrix<f64>,
    /// The last `V r`.
    potential: Vec<f64>,
    /// The last `r + (N_r + D_p) V r`.
    convected: Vec<f64>,
}

impl InertialInverse {
    fn new(
        system: &SaddleSystem,
        inertia: &SchurInertia,
        mut cycle: ScalarMultigrid,
    ) -> Result<Self, LinalgError> {
        let &SchurInertia {
            coefficient, scale, ..
        } = inertia;
        let of_columns = system.border_divergence();
        let divergence = system.border_divergence_left().unwrap_or(of_columns);
        let divergence = divergence.map(|e| e / scale);
        let (pressures, columns) = of_columns.shape();
        let m = if coefficient > 0.0 { columns } else { 0 };
        let mut moved = Vec::with_capacity(m);
        let mut core = match m {
            0 => DMatrix::zeros(0, 0),
            _ => system.velocity_block().corner() / coefficient,
        };
        for column in 0..m {
            let entry = |row| Rows::new(of_columns).entry(row, column) / scale;
            let flux: Vec<f64> = (0..pressures).map(entry).collect();
            let mut potential = vec![0.0; pressures];
            cycle.solve_into(&flux, &mut potential, |z, v| *z = v);
            let response = transposed_product(&divergence, &potential);
            let mut of_column = core.column_mut(column);
            of_column += DVector::from_vec(response);
            moved.push(potential);
        }
        let core = core
            .try_inverse()
            .ok_or_else(|| LinalgError::Factorisation {
                what: "the border in the Schur complement of the mass matrix",
                detail: "singular: some border dof has neither a corner nor a divergence".into(),
            })?;
        let stabilised = |[convection, diffusion]: [&Csr; 2]| {
            CsrOperator::new(&without_inflow(convection) + diffusion)
        };
        let convection = inertia.convection.map(stabilised);
        Ok(Self {
            coefficient,
            scale,
            cycle,
            convection: convection.transpose()?,
            divergence,
            moved,
            core,
            potential: vec![0.0; pressures],
            convected: vec![0.0; pressures],
        })
    }

    /// Computes `V r`.
    fn solve(&mut self, r: &[f64]) {
        self.cycle.solve_into(r, &mut self.potential, |z, v| *z = v);
    }

    /// `r + (N_r + D_p) V r` with the last `V r`.
    fn convected<'a>(&'a mut self, r: &'a [f64]) -> &'a [f64] {
        let Some(convection) = &self.convection else {
            return r;
        };
        convection.apply(&self.potential, &mut self.convected);
        self.convected.iter_mut().zip(r).for_each(|(t, r)| *t += r);
        &self.convected
    }

    /// Adds the part of the mass matrix with the last `V r`.
    fn add(&mut self, z: &mut [f64]) {
        if self.coefficient == 0.0 {
            return;
        }
        let flux = DVector::from_vec(transposed_product(&self.divergence, &self.potential));
        let velocity = &self.core * flux;
        for (moved, velocity) in self.moved.iter().zip(&velocity) {
            for (p, moved) in self.potential.iter_mut().zip(moved) {
                *p -= velocity * moved;
            }
        }
        for (z, p) in z.iter_mut().zip(&self.potential) {
            *z += self.coefficient * *p;
        }
    }
}

/// `A^T x` for a matrix with few columns; serial, so that the order of the sum is fixed.
fn transposed_product(matrix: &Csr, x: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; matrix.cols()];
    let rows = Rows::new(matrix);
    for (row, x) in x.iter().enumerate() {
        rows.row(row)
            .for_each(|(column, a)| product[column] += a * x);
    }
    product
}

/// The nonzeros of the diagonal matrix `W` of [`PressureInverse`].
///
/// `viscous(node, d)` is the viscous part of the diagonal entry `d` of the stiffness, `scale` the
/// factor of the divergence in the system.
fn weak_rows(
    system: &SaddleSystem,
    viscous: impl Fn(usize, f64) -> f64,
    scale: f64,
) -> Vec<(u32, f64)> {
    let mut stiffness = csr::diagonal(system.velocity_block().stiffness());
    for (node, d) in stiffness.iter_mut().enumerate() {
        *d = viscous(node, *d);
    }
    let mass = csr::diagonal(system.pressure_mass());
    let divergence = Rows::new(system.divergence());
    let excess = |(q, m): (usize, &f64)| {
        let row = divergence.row(q);
        let schur: f64 = row
            .map(|(j, [x, y, z])| (x * x + y * y + z * z) / stiffness[j])
            .sum();
        let schur = schur / (scale * scale);
        let excess = (WEAK_ROW_FACTOR * schur).recip() - m.recip();
        // a row without free velocities has no Schur complement to approximate
        (excess > 0.0 && excess.is_finite()).then_some((q as u32, excess))
    };
    mass.iter().enumerate().filter_map(excess).collect()
}
