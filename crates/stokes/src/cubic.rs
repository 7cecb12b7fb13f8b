//! Correction of a flow by functions of the next degree: Taylor-Hood elements P3/P2.

use fem::{
    BoundaryBubbles, BoundaryFlow, CubicExtension, CubicProduct, FacetGeometry, SurfaceVelocity,
};
use linalg::{
    KrylovParams, LinalgError, LinearOperator, Preconditioner, PreconditionerKind,
    SumOverProcesses, fgmres,
};
use mesh::TetMesh;
use nalgebra::Vector3;
use rigid::{Articulation, FlowSolution};

use crate::StokesError;
use crate::equations::Equations;
use crate::linear::solve_in_groups;
use crate::surface_flow::NodalSurfaceFlow;

/// Number of iterations with the extended system, from zero.
///
/// For spheres in balls of 3 to 40 radii, with edges of 0.3 to 0.5 radii, the corrections are then
/// within 1.5 percent of those of the converged system, once [`COARSE_RTOL`] is met. The number
/// changes only where the residual stays above [`MAX_RESIDUAL`], so corrections are a smooth
/// function of the configuration. Opposite flows have opposite corrections: a reciprocal stroke has
/// no net displacement.
const FIRST_ITERATIONS: usize = 8;

/// Relative residual of the extended system, in the norm of its weights, above which it is iterated
/// again, with twice as many iterations.
///
/// For spheres at gaps of 0.01 to 1 radii, in balls and in unbounded fluid, and for all example
/// scenes it is 0.013 to 0.04 after the first ones, in a thinning fluid at most 0.11. Euclidean
/// residuals, there 0.03 to 2, are those of the largest cells, far from the bodies.
const MAX_RESIDUAL: f64 = 0.05;

/// Largest number of iterations without a restart; if it does not suffice, the solve fails.
///
/// A stroke that closes to a gap of 0.08 radii stalled at a Euclidean residual of 0.65 with
/// restarts after every eight iterations.
const MAX_ITERATIONS: usize = 128;

/// Largest number of iterations to a prescribed residual.
const MAX_CONVERGED_ITERATIONS: usize = 2000;

/// Relative residual to which the Taylor-Hood part of a correction is solved at the end.
///
/// The error that the iteration leaves in this part is smooth and affects all bodies; the error
/// that it leaves in the bubbles is local. Without the final solve the mobility between two bodies
/// has an error of a third of its correction (measured after six iterations), with it of one
/// percent. On fine meshes a residual of 1e-3 would dominate the remaining error: the drag of a
/// sphere would converge with order 4.4 instead of 5.4 (`docs/decisions.md`).
const COARSE_RTOL: f64 = 1e-4;

/// The matrix of P3/P2 elements with the constraints of the bodies, in a hierarchical basis.
///
/// Dofs are those of the Taylor-Hood system, then those of the [`CubicExtension`].
struct CubicSystem<'a> {
    equations: Equations<'a>,
    extension: &'a CubicExtension<'a>,
    weights: Vec<f32>,
}

/// Multiplicative preconditioner of a [`CubicSystem`]: pressures, bubbles, Taylor-Hood system.
///
/// Diagonals stand for the first two, because the hierarchical basis is well conditioned
/// (Yserentant 1986; Bank 1996); the last is that of the Taylor-Hood system.
struct CubicPreconditioner<'a> {
    system: &'a CubicSystem<'a>,
    coarse: &'a mut dyn Preconditioner,
}

impl<'a> CubicSystem<'a> {
    fn new(equations: Equations<'a>, extension: &'a CubicExtension<'a>) -> Self {
        let of_coarse = equations.operator.residual_weights().unwrap_or_default();
        let mut weights = of_coarse.to_vec();
        if !weights.is_empty() {
            weights.extend((0..extension.len()).map(|k| (1.0 / extension.diagonal(k)) as f32));
        }
        Self {
            equations,
            extension,
            weights,
        }
    }

    fn first(&self) -> usize {
        self.equations.operator.rows()
    }

    /// Right-hand side that balances the coarse rows of a product.
    fn coarse_rows(&self, product: &CubicProduct) -> Result<Vec<f64>, StokesError> {
        let (velocity, pressure) = (&product.velocity, &product.pressure);
        Ok(self.equations.system.rhs_of_forces(velocity, pressure)?)
    }

    /// `y <- A x`.
    fn multiply(&self, x: &[f64], y: &mut [f64]) -> Result<(), StokesError> {
        let (coarse, extension) = x.split_at(self.first());
        let (velocity, pressure) = self.equations.system.flow_of_loads(coarse)?;
        let (rows, rows_of_extension) = y.split_at_mut(self.first());
        let product =
            (self.extension).product_into(&velocity, &pressure, extension, rows_of_extension)?;
        self.equations.operator.apply(coarse, rows);
        for (row, value) in rows.iter_mut().zip(self.coarse_rows(&product)?) {
            *row += value;
        }
        Ok(())
    }

    /// Change from one solution to the next over the first, in the nodal velocities and bubbles.
    fn reduction(&self, first: &[f64], next: &[f64]) -> f64 {
        let velocities = 0..self.equations.system.system.pressure_range().start;
        let bubbles = self.first()..self.first() + self.extension.first_pressure();
        let (mut change, mut size) = (0.0, 0.0);
        for k in velocities.chain(bubbles) {
            change += (next[k] - first[k]).powi(2);
            size += first[k].powi(2);
        }
        match size > 0.0 {
            true => f64::sqrt(change / size),
            // Nothing was wrong, or the first step is not one: as large as the correction.
            false => f64::from(u8::from(change != 0.0)),
        }
    }

    /// Pressures and bubbles of the preconditioner, and the coarse residual that they leave.
    fn relax(&self, r: &[f64], extension: &mut [f64]) -> Result<Vec<f64>, StokesError> {
        let (coarse, r) = r.split_at(self.first());
        let first_pressure = self.extension.first_pressure();
        for k in first_pressure..r.len() {
            extension[k] = -r[k] / self.extension.diagonal(k);
        }
        self.extension.gradient(extension)?;
        for k in 0..first_pressure {
            extension[k] = (r[k] - extension[k]) / self.extension.diagonal(k);
        }
        let product = self.extension.coarse_rows(extension)?;
        let rows = self.coarse_rows(&product)?;
        Ok(coarse.iter().zip(rows).map(|(r, row)| r - row).collect())
    }
}

impl LinearOperator for CubicSystem<'_> {
    fn rows(&self) -> usize {
        self.first() + self.extension.len()
    }

    fn cols(&self) -> usize {
        self.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        if self.multiply(x, y).is_err() {
            // Solvers report numbers that are not finite.
            y.fill(f64::NAN);
        }
    }

    fn residual_weights(&self) -> Option<&[f32]> {
        (!self.weights.is_empty()).then_some(&self.weights)
    }

    fn sum_over_processes(&self) -> Option<&SumOverProcesses<'_>> {
        self.equations.operator.sum_over_processes()
    }
}

impl Preconditioner for CubicPreconditioner<'_> {
    fn size(&self) -> usize {
        self.system.rows()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        let (coarse, extension) = z.split_at_mut(self.system.first());
        match self.system.relax(r, extension) {
            Ok(residual) => self.coarse.apply(&residual, coarse),
            // Solvers report numbers that are not finite.
            Err(_) => coarse.fill(f64::NAN),
        }
    }

    fn kind(&self) -> PreconditionerKind {
        self.coarse.kind().max(PreconditionerKind::Linear)
    }
}

impl CubicPreconditioner<'_> {
    /// Iterates towards the solution for the right-hand side `b`: to `rtol`, or as far as needed.
    fn iterate(&mut self, b: &[f64], x: &mut [f64], rtol: Option<f64>) -> Result<(), StokesError> {
        let system = self.system;
        if let Some(rtol) = rtol {
            let parameters = KrylovParams::default()
                .with_rel_tol(rtol)
                .with_max_iterations(MAX_CONVERGED_ITERATIONS)
                .with_restart(MAX_ITERATIONS);
            fgmres(system, self, b, x, &parameters)?;
            return Ok(());
        }
        let mut iterations = FIRST_ITERATIONS;
        loop {
            let parameters = KrylovParams::default()
                .with_rel_tol(COARSE_RTOL)
                .with_max_iterations(iterations)
                .with_restart(iterations);
            match fgmres(system, self, b, x, &parameters) {
                Err(LinalgError::NotConverged {
                    weighted_rel_residual,
                    ..
                }) if weighted_rel_residual <= MAX_RESIDUAL => return Ok(()),
                Err(LinalgError::NotConverged { .. }) if iterations < MAX_ITERATIONS => {
                    iterations *= 2;
                }
                result => return Ok(result.map(|_| ())?),
            }
        }
    }
}

/// Estimated change of a flow, exact minus computed.
pub struct Change {
    /// Change of velocities, forces and pressure.
    pub flow: FlowSolution,
    /// Dofs of the extension of the corrected flow, with the velocities of surfaces.
    pub extension: Vec<f64>,
    /// Size of the second step of Newton's method over that of the first; zero where there is none.
    pub reduction: f64,
}

/// Corrections of flows that were solved with one matrix.
pub struct Correction<'a> {
    mesh: &'a TetMesh,
    pub(crate) equations: Equations<'a>,
    pub(crate) extension: CubicExtension<'a>,
    pub(crate) geometry: &'a FacetGeometry<'a>,
    set: &'a Articulation,
    surfaces: Option<(&'a NodalSurfaceFlow, &'a SurfaceVelocity<'a>)>,
    rtol: Option<f64>,
}

impl<'a> Correction<'a> {
    /// Corrections of the solutions of `equations` for the bodies `set` on a mesh.
    ///
    /// The equations are those of the mesh, or a part of them. `geometry` has the facets whose true
    /// surface is known, `surfaces` the velocities of surfaces that do not move rigidly. Systems
    /// are solved to the relative residual `rtol`, or as accurately as the uncertainty requires.
    ///
    /// # Errors
    /// A mesh that does not belong to the space; an inverted cell.
    pub fn new(
        mesh: &'a TetMesh,
        equations: Equations<'a>,
        geometry: &'a FacetGeometry<'a>,
        set: &'a Articulation,
        surfaces: Option<(&'a NodalSurfaceFlow, &'a SurfaceVelocity<'a>)>,
        rtol: Option<f64>,
    ) -> Result<Self, StokesError> {
        let extension = CubicExtension::new(equations.space, equations.mesh)?;
        Ok(Self {
            mesh,
            extension: match equations.varying {
                None => extension,
                Some(flow) => extension.with_viscosity(flow.viscosity)?,
            },
            equations,
            geometry,
            set,
            surfaces,
            rtol,
        })
    }

    /// Bubbles of the velocities of surfaces.
    ///
    /// None for surfaces that move rigidly in a fluid of constant viscosity: they are zero then.
    fn bubbles_of_surfaces(&self) -> Result<Option<Vec<f64>>, StokesError> {
        if self.surfaces.is_none() && self.equations.varying.is_none() {
            return Ok(None);
        }
        let mut dofs = vec![0.0; self.extension.len()];
        if let Some((nodal, velocity)) = self.surfaces {
            self.interpolate(nodal, velocity, &nodal.velocity, &mut dofs)?;
        }
        Ok(Some(dofs))
    }

    /// Writes the bubbles of a velocity of all surfaces, with these nodal values, into dofs.
    pub(crate) fn interpolate(
        &self,
        surfaces: &NodalSurfaceFlow,
        velocity: &SurfaceVelocity<'_>,
        nodal: &[Vector3<f64>],
        dofs: &mut [f64],
    ) -> Result<(), StokesError> {
        for &tag in &surfaces.tags {
            let bubbles = BoundaryBubbles::new(self.mesh, tag, velocity, nodal)?;
            let number = |node| self.equations.number(node);
            self.extension.interpolate(tag, &bubbles, number, dofs)?;
        }
        Ok(())
    }

    /// Estimated changes of flows, exact minus computed.
    ///
    /// A change is that from quadratic to cubic elements (P2/P1 to P3/P2) on the same mesh, with
    /// that from its facets to the true surfaces of the bodies ([`FacetGeometry`]). The system of
    /// P3/P2 elements, with the velocities of surfaces in bubbles, is iterated for the difference
    /// only: it is small, so a few iterations leave an error far below that of the estimate.
    ///
    /// Where the viscosity varies a second step of Newton's method follows, with the same matrix.
    ///
    /// Cost per flow and step: [`FIRST_ITERATIONS`] iterations, each of three passes over the
    /// cells, a matrix product and a preconditioner; then a solve of the Taylor-Hood system to
    /// [`COARSE_RTOL`].
    ///
    /// # Errors
    /// Solves that do not converge, cells that are inverted.
    pub fn changes(
        &self,
        flows: &[FlowSolution],
        preconditioner: &mut dyn Preconditioner,
    ) -> Result<Vec<Change>, StokesError> {
        let equations = self.equations;
        let system = CubicSystem::new(equations, &self.extension);
        let of_surfaces = self.bubbles_of_surfaces()?;
        let mut solutions = vec![vec![0.0; system.rows()]; flows.len()];
        let (mut forces, mut rhs) = (Vec::new(), Vec::new());
        for (flow, zeros) in flows.iter().zip(&solutions) {
            let of_surfaces = of_surfaces.as_deref().unwrap_or(&zeros[system.first()..]);
            let (of_flow, column) = self.residual(flow, of_surfaces)?;
            forces.push(of_flow);
            rhs.push(column);
        }
        let mut extended = CubicPreconditioner {
            system: &system,
            coarse: &mut *preconditioner,
        };
        let mut reductions = vec![0.0; flows.len()];
        let of_columns = rhs.iter_mut().zip(&mut forces).zip(&mut solutions);
        for (((b, forces), x), reduction) in of_columns.zip(&mut reductions) {
            extended.iterate(b, x, self.rtol)?;
            if let (Some(of_surfaces), true) = (&of_surfaces, equations.varying.is_some()) {
                let first = x.clone();
                self.add_remainder(x, of_surfaces, forces, b)?;
                extended.iterate(b, x, self.rtol)?;
                *reduction = system.reduction(&first, x);
            }
        }
        self.solve_coarse(&system, &rhs, &mut solutions, &mut forces, preconditioner)?;

        let first = system.first();
        let mut changes = Vec::with_capacity(flows.len());
        for ((solution, forces), reduction) in solutions.iter().zip(&forces).zip(reductions) {
            let flow = equations.change(&solution[..first], forces, self.set)?;
            let mut flow = equations.of_whole_mesh(flow)?;
            let mean = fem::mean_pressure(self.mesh, &flow.pressure)?;
            flow.pressure.iter_mut().for_each(|p| *p -= mean);
            let mut extension = solution[first..].to_vec();
            for (own, of_surface) in extension.iter_mut().zip(of_surfaces.iter().flatten()) {
                *own += of_surface;
            }
            changes.push(Change {
                flow,
                extension,
                reduction,
            });
        }
        Ok(changes)
    }

    /// The nodal forces that a flow leaves unbalanced in cubic elements on the true surfaces, and
    /// the right-hand side of the correction.
    fn residual(
        &self,
        flow: &FlowSolution,
        of_surfaces: &[f64],
    ) -> Result<(Vec<Vector3<f64>>, Vec<f64>), StokesError> {
        let equations = self.equations;
        let of_facets = self.geometry.functional(BoundaryFlow {
            velocity: &flow.velocity,
            surface_velocity: self.surfaces.map(|(_, velocity)| velocity),
        })?;
        let velocity = equations.restricted(&flow.velocity);
        let pressure = equations.restricted(&flow.pressure);
        let residual = (self.extension).residual(&velocity, &pressure, of_surfaces)?;
        let loads = equations.restricted(&of_facets.velocity);
        let rows = loads.iter().zip(&residual.velocity);
        let forces: Vec<_> = rows.map(|(load, row)| -load - row).collect();
        let loads = equations.restricted(&of_facets.pressure);
        let rows = loads.iter().zip(&residual.pressure);
        let sources: Vec<f64> = rows.map(|(load, row)| -load - row).collect();
        let mut rhs = equations.system.rhs_of_forces(&forces, &sources)?;
        rhs.extend(residual.extension.iter().map(|r| -r));
        Ok((forces, rhs))
    }

    /// Subtracts the part of the stress that is of second order in a change from its right-hand
    /// side and its forces: with them the solution is that of a second step of Newton's method,
    /// with the matrix of the first.
    ///
    /// Energy and forces have errors of second order in the error of the flow. The derivative of
    /// the stress has one part of them, this is the other where viscosities vary.
    fn add_remainder(
        &self,
        solution: &[f64],
        of_surfaces: &[f64],
        forces: &mut [Vector3<f64>],
        rhs: &mut [f64],
    ) -> Result<(), StokesError> {
        let equations = self.equations;
        let first = equations.operator.rows();
        let (velocity, _) = equations.system.flow_of_loads(&solution[..first])?;
        let remainder = (self.extension).remainder(of_surfaces, &velocity, &solution[first..])?;
        let on_nodes: Vec<_> = remainder.velocity.iter().map(|row| -row).collect();
        let rows = (equations.system).rhs_of_forces(&on_nodes, &remainder.pressure)?;
        let of_extension = remainder.extension.iter().map(|row| -row);
        for (rhs, row) in rhs.iter_mut().zip(rows.into_iter().chain(of_extension)) {
            *rhs += row;
        }
        for (force, row) in forces.iter_mut().zip(&on_nodes) {
            *force += row;
        }
        Ok(())
    }

    /// Solves the Taylor-Hood part of the solutions again, accurately, and subtracts the forces
    /// that their bubbles balance.
    fn solve_coarse(
        &self,
        system: &CubicSystem<'_>,
        rhs: &[Vec<f64>],
        solutions: &mut [Vec<f64>],
        forces: &mut [Vec<Vector3<f64>>],
        preconditioner: &mut dyn Preconditioner,
    ) -> Result<(), StokesError> {
        let first = system.first();
        let mut coarse_rhs = Vec::with_capacity(rhs.len());
        for ((forces, x), column) in forces.iter_mut().zip(&*solutions).zip(rhs) {
            let product = self.extension.coarse_rows(&x[first..])?;
            let rows = column.iter().zip(system.coarse_rows(&product)?);
            coarse_rhs.push(rows.map(|(b, row)| b - row).collect::<Vec<_>>());
            for (force, product) in forces.iter_mut().zip(&product.velocity) {
                *force -= product;
            }
        }
        let columns: Vec<&[f64]> = coarse_rhs.iter().map(Vec::as_slice).collect();
        let mut coarse: Vec<&mut [f64]> = solutions.iter_mut().map(|x| &mut x[..first]).collect();
        let parameters = KrylovParams::default().with_rel_tol(self.rtol.unwrap_or(COARSE_RTOL));
        let operator = self.equations.operator;
        solve_in_groups(operator, preconditioner, &columns, &mut coarse, &parameters)?;
        Ok(())
    }
}
