//! The solver of a distributed system: FGMRES with a split into motion and pressure.

use crate::PetscError;
use crate::assembly::Blocks;
use crate::handles::{Krylov, Matrix, NullSpace, Session, Vector, release_memory};
use crate::hierarchy::Hierarchy;
use crate::numbering::Numbering;
use crate::pressure::{no_entries, null_vector, weak_rows};

/// Basis vectors of FGMRES before a restart, as in `linalg`.
const RESTART: usize = 60;

/// Bound on iterations, as in `linalg`.
const MAX_ITERATIONS: usize = 300;

/// Eigenvalues of the Jacobi-scaled mass matrix of linear tetrahedra (Wathen 1987).
const MASS_EIGENVALUES: [f64; 2] = [0.5, 2.5];

/// Chebyshev steps on the mass matrix, as in `linalg`.
const MASS_STEPS: usize = 3;

/// Ratio of the smoother's interval, and safety factor of the estimated largest eigenvalue, as in
/// `linalg`.
const SMOOTHING_RANGE: f64 = 7.0;
const UPPER_MARGIN: f64 = 1.05;

/// Role of a smoother, before the number of its level.
const SMOOTHER: &str = "smoother of level";

/// Ratio of the estimated error of the border dofs to the weighted residual; see
/// [`SolveReport::error_estimate`](linalg::SolveReport::error_estimate).
const ERROR_OVER_RESIDUAL: f64 = 2.0;

/// Norm of the image of a unit vector below which it is a null vector: rounding leaves 1e-13.
const MAX_NULL_IMAGE: f64 = 1e-9;

/// Shift of the pressure block of the direct solver, as a multiple of the mass matrix.
///
/// The shifted matrix is quasi-definite; FGMRES removes the error of the shift in a few steps.
const DIRECT_SHIFT: f64 = 1e-7;

/// Largest number of restarts of FGMRES from the last solution with a smaller tolerance.
const MAX_CONTINUATIONS: usize = 5;

/// How the linear system is solved.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// FGMRES with a block-triangular preconditioner, multigrid for velocities and bodies.
    Block,
    /// LDLT factors by MUMPS, refined by FGMRES.
    Direct,
}

impl Method {
    /// The method of a solver of `stokes`.
    ///
    /// # Errors
    /// [`PetscError::Unsupported`].
    pub fn new(solver: stokes::Solver) -> Result<Self, PetscError> {
        match solver {
            stokes::Solver::Block => Ok(Self::Block),
            stokes::Solver::Direct => Ok(Self::Direct),
            other => Err(PetscError::Unsupported { what: other.name() }),
        }
    }
}

/// A solution with the figures of its computation.
pub struct Solved {
    /// Entries of this process, motion then pressure.
    pub solution: Vec<f64>,
    pub iterations: usize,
    /// `|b - A x| / |b|`, recomputed.
    pub true_relative_residual: f64,
    /// Estimated relative error of the border dofs: twice the residual in the weighted norm.
    pub error_estimate: f64,
    pub levels: usize,
}

/// The scaled system and its solver.
pub struct Solver<'s> {
    session: &'s Session,
    matrix: Matrix<'s>,
    /// The constant pressure, where the matrix maps it to zero.
    null_space: Option<NullSpace<'s>>,
    outer: Krylov<'s>,
    /// Inner solvers with their roles; their convergence is checked too.
    inner: Vec<(String, Krylov<'s>)>,
    /// Scaling of the entries of this process, motion then pressure.
    factors: Vec<f64>,
    levels: usize,
}

impl<'s> Solver<'s> {
    /// Scales the system and sets up its solver.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn new(
        session: &'s Session,
        mut blocks: Blocks<'s>,
        method: Method,
        numbering: &Numbering,
        free_vertices: &[u32],
    ) -> Result<Self, PetscError> {
        let factors = blocks.scale(session)?;
        // A factorisation needs the entries of the transpose.
        let gradient = match method {
            Method::Block => blocks.divergence.transposed_view()?,
            Method::Direct => blocks.divergence.transpose()?,
        };
        let weak = weak_rows(&blocks.divergence)?;
        let mut schur = blocks.pressure_mass;
        schur.multiply_by(-1.0)?;
        let zero = no_entries(session, numbering.own_pressure().len())?;
        let mut matrix =
            Matrix::nested([[&blocks.motion, &gradient], [&blocks.divergence, &zero]])?;
        let null = null_vector(session, &factors)?;
        let mut image = Vector::new(session, factors.iter().map(Vec::len).sum())?;
        matrix.apply(&null, &mut image)?;
        let null_space = match image.norm()? < MAX_NULL_IMAGE {
            true => Some(matrix.set_null_vector(&null)?),
            false => None,
        };
        let outer = Krylov::new(session)?;
        outer.set_type(c"fgmres")?;
        outer.set_restart(RESTART)?;
        outer.stop_by_true_residual()?;
        let mut solver = Self {
            session,
            matrix,
            null_space,
            outer,
            inner: Vec::new(),
            factors: factors.concat(),
            levels: 0,
        };
        match method {
            Method::Block => {
                let hierarchy = Hierarchy::new(
                    session,
                    blocks.motion,
                    blocks.prolongation,
                    numbering,
                    free_vertices,
                )?;
                release_memory();
                let laplacian = blocks.pressure_laplacian;
                solver.split_fields(&schur, weak, laplacian, hierarchy)?;
            }
            Method::Direct => {
                let mut shift = schur;
                shift.multiply_by(DIRECT_SHIFT)?;
                let shifted =
                    Matrix::nested([[&blocks.motion, &gradient], [&blocks.divergence, &shift]])?;
                let mut shifted = shifted.to_sparse()?;
                shifted.declare_symmetric()?;
                solver.factorise(&shifted)?;
            }
        }
        Ok(solver)
    }

    /// The block-triangular preconditioner.
    fn split_fields(
        &mut self,
        schur: &Matrix<'s>,
        weak: Vec<f64>,
        laplacian: Option<Matrix<'s>>,
        hierarchy: Hierarchy<'s>,
    ) -> Result<(), PetscError> {
        self.outer.set_operators(&self.matrix, &self.matrix)?;
        let split = self.outer.preconditioner()?;
        split.split_by_fields(&self.matrix, [c"motion", c"pressure"], schur)?;
        self.outer.read_options()?;
        self.outer.set_up()?;
        let [motion, pressure] = split.fields()?;
        // Before anything else, because inner solvers inherit the prefix when they are created.
        motion.set_prefix(c"motion_")?;
        pressure.set_prefix(c"pressure_")?;
        self.set_up_motion(&motion, hierarchy)?;
        pressure.set_type(c"preonly")?;
        let cycle = match laplacian {
            Some(mut laplacian) => {
                laplacian.declare_symmetric()?;
                let cycle = Krylov::new(self.session)?;
                cycle.set_type(c"preonly")?;
                cycle.set_prefix(c"pressure_laplacian_")?;
                cycle.set_operators(&laplacian, &laplacian)?;
                cycle.preconditioner()?.set_algebraic_multigrid()?;
                cycle.read_options()?;
                cycle.set_up()?;
                Some(cycle)
            }
            None => None,
        };
        let correction = (weak, cycle.as_ref());
        let mass = (pressure.preconditioner()?).set_solver_and_correction(correction)?;
        mass.set_type(c"chebyshev")?;
        mass.set_steps(MASS_STEPS)?;
        let [smallest, largest] = MASS_EIGENVALUES;
        mass.set_eigenvalues(smallest, largest)?;
        mass.preconditioner()?.set_type(c"jacobi")?;
        for (name, field) in [("motion", motion), ("pressure", pressure)] {
            field.read_options()?;
            field.set_up()?;
            self.inner.push((name.to_owned(), field));
        }
        for (_, smoother) in self
            .inner
            .iter()
            .filter(|(name, _)| name.starts_with(SMOOTHER))
        {
            smoother.keep_eigenvalues()?;
        }
        self.inner.push(("pressure mass matrix".to_owned(), mass));
        let named = cycle.map(|cycle| ("pressure Laplacian".to_owned(), cycle));
        self.inner.extend(named);
        Ok(())
    }

    /// Sets up one V-cycle as the solver of the motion.
    fn set_up_motion(
        &mut self,
        motion: &Krylov<'s>,
        hierarchy: Hierarchy<'s>,
    ) -> Result<(), PetscError> {
        motion.set_type(c"preonly")?;
        let multigrid = motion.preconditioner()?;
        multigrid.set_multigrid(&hierarchy.prolongations)?;
        let coarsest = hierarchy.prolongations.len();
        self.levels = coarsest + 1;
        for (depth, level) in hierarchy.levels.into_iter().enumerate() {
            let smoother = multigrid.smoother(coarsest - depth)?;
            let mut matrix = level.matrix;
            matrix.declare_symmetric()?;
            smoother.set_operators(&matrix, &matrix)?;
            let name = if depth == coarsest {
                smoother.set_type(c"preonly")?;
                let factor = smoother.preconditioner()?.redundant()?;
                factor.set_type(c"preonly")?;
                // A border with multipliers has zeros on the diagonal and needs pivots.
                factor.preconditioner()?.set_ldlt(c"mumps")?;
                self.inner.push(("coarsest factors".to_owned(), factor));
                "coarsest level".to_owned()
            } else {
                smoother.set_type(c"chebyshev")?;
                smoother.set_steps(if depth == 0 { 1 } else { 2 })?;
                smoother.estimate_eigenvalues(UPPER_MARGIN / SMOOTHING_RANGE, UPPER_MARGIN)?;
                let diagonal = level.inverse_diagonal;
                smoother.preconditioner()?.set_diagonal(diagonal)?;
                format!("{SMOOTHER} {depth}")
            };
            self.inner.push((name, smoother));
        }
        Ok(())
    }

    /// Direct factors of `shifted` as the preconditioner.
    fn factorise(&mut self, shifted: &Matrix<'s>) -> Result<(), PetscError> {
        self.outer.set_operators(&self.matrix, shifted)?;
        self.outer.preconditioner()?.set_ldlt(c"mumps")?;
        self.outer.read_options()?;
        self.outer.set_up()
    }

    /// Product of the matrix with a vector, both given by the entries of this process.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn multiply(&self, x: &[f64]) -> Result<Vec<f64>, PetscError> {
        let scaled: Vec<f64> = x.iter().zip(&self.factors).map(|(x, f)| x / f).collect();
        let mut product = Vector::new(self.session, x.len())?;
        (self.matrix).apply(&Vector::from_slice(self.session, &scaled)?, &mut product)?;
        let scaled = product.local()?;
        Ok(scaled
            .iter()
            .zip(&self.factors)
            .map(|(y, f)| y / f)
            .collect())
    }

    /// The preconditioner applied to a vector, both given by the entries of this process.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn precondition(&self, r: &[f64]) -> Result<Vec<f64>, PetscError> {
        let mut result = Vector::new(self.session, r.len())?;
        (self.outer.preconditioner()?).apply(&self.scaled(r)?, &mut result)?;
        if let Some(null_space) = &self.null_space {
            null_space.remove(&mut result)?;
        }
        self.unscaled(&result)
    }

    /// Frees the basis of the outer iteration, after the last solve.
    ///
    /// It takes 16 bytes per dof and iteration. Matrix and preconditioner remain.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn free_basis(&self) -> Result<(), PetscError> {
        self.outer.set_type(c"preonly")?;
        release_memory();
        Ok(())
    }

    /// A right-hand side of the scaled system.
    fn scaled(&self, rhs: &[f64]) -> Result<Vector<'s>, PetscError> {
        let scaled: Vec<f64> = rhs.iter().zip(&self.factors).map(|(b, f)| b * f).collect();
        Vector::from_slice(self.session, &scaled)
    }

    /// A solution of the system before scaling.
    fn unscaled(&self, solution: &Vector<'s>) -> Result<Vec<f64>, PetscError> {
        let mut values = solution.local()?;
        (values.iter_mut().zip(&self.factors)).for_each(|(x, factor)| *x *= factor);
        Ok(values)
    }

    /// Solves until the Euclidean residual and the estimated error are below `rtol`.
    ///
    /// `rhs` has the entries of this process, motion then pressure, and so has the solution.
    ///
    /// # Errors
    /// [`PetscError::NotConverged`] for the outer or an inner solver, and those of PETSc.
    pub fn solve(&self, rhs: &[f64], rtol: f64) -> Result<Solved, PetscError> {
        let mut rhs = self.scaled(rhs)?;
        if let Some(null_space) = &self.null_space {
            null_space.remove(&mut rhs)?;
        }
        let mut x = Vector::new(self.session, self.factors.len())?;
        let mut iterations = 0;
        let mut inner_rtol = rtol / ERROR_OVER_RESIDUAL;
        let mut continuations = 0;
        loop {
            self.outer.set_tolerance(inner_rtol, MAX_ITERATIONS)?;
            self.outer.solve(&rhs, &mut x)?;
            iterations += self.outer.iterations()?;
            let [euclidean, weighted] = self.residuals(&rhs, &x)?;
            let error_estimate = ERROR_OVER_RESIDUAL * weighted;
            self.check_reasons(iterations, euclidean)?;
            // Written so that NaN does not count as converged.
            let larger = euclidean.max(error_estimate);
            if larger <= rtol && !weighted.is_nan() {
                return Ok(Solved {
                    solution: self.unscaled(&x)?,
                    iterations,
                    true_relative_residual: euclidean,
                    error_estimate,
                    levels: self.levels,
                });
            }
            if continuations == MAX_CONTINUATIONS || !larger.is_finite() {
                return Err(PetscError::NotConverged {
                    role: "system".to_owned(),
                    iterations,
                    reason: self.outer.reason()?,
                    true_relative_residual: larger,
                });
            }
            // FGMRES measures the weighted residual. It has to fall by the factor `rtol / larger`,
            // with a margin for rounding.
            inner_rtol = 0.5 * weighted * rtol / larger;
            self.outer.start_from_guess()?;
            continuations += 1;
        }
    }

    /// `|b - A x| / |b|` of the system before scaling, in the Euclidean and in the weighted norm.
    fn residuals(&self, rhs: &Vector<'s>, x: &Vector<'s>) -> Result<[f64; 2], PetscError> {
        let mut residual = Vector::new(self.session, self.factors.len())?;
        self.matrix.apply(x, &mut residual)?;
        residual.subtract_from(rhs)?;
        let weighted = relative(residual.norm()?, rhs.norm()?);
        let unscaled = |vector: &Vector<'s>| {
            let scaled = vector.local()?;
            let values: Vec<f64> = scaled
                .iter()
                .zip(&self.factors)
                .map(|(r, f)| r / f)
                .collect();
            Vector::from_slice(self.session, &values)?.norm()
        };
        let euclidean = relative(unscaled(&residual)?, unscaled(rhs)?);
        Ok([euclidean, weighted])
    }

    /// Returns an error if any solver reports that it did not converge.
    fn check_reasons(
        &self,
        iterations: usize,
        true_relative_residual: f64,
    ) -> Result<(), PetscError> {
        let outer = [("system", &self.outer)].into_iter();
        let inner = self
            .inner
            .iter()
            .map(|(role, solver)| (role.as_str(), solver));
        for (role, solver) in outer.chain(inner) {
            let reason = solver.reason()?;
            if reason < 0 {
                return Err(PetscError::NotConverged {
                    role: role.to_owned(),
                    iterations,
                    reason,
                    true_relative_residual,
                });
            }
        }
        Ok(())
    }
}

/// `residual / rhs`; zero if both are zero.
fn relative(residual: f64, rhs: f64) -> f64 {
    if rhs == 0.0 && residual == 0.0 {
        return 0.0;
    }
    residual / rhs
}
