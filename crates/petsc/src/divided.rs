//! The system of all processes as an operator and a preconditioner of `linalg`.

use linalg::{LinearOperator, Preconditioner, PreconditionerKind, SumOverProcesses};

use crate::PetscError;
use crate::assembly::OwnEntries;
use crate::handles::{OneThread, Session};
use crate::solver::Solver;

/// The matrix of a solver on vectors of the parts, with zeros for entries of other processes.
pub struct DividedMatrix<'a, 's> {
    solver: OneThread<&'a Solver<'s>>,
    entries: &'a OwnEntries,
    weights: Vec<f32>,
}

impl<'a, 's> DividedMatrix<'a, 's> {
    /// The matrix of `solver`, whose rows have these sizes, in the order of PETSc's vectors.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn new(
        session: &Session,
        solver: &'a Solver<'s>,
        entries: &'a OwnEntries,
        sizes: &[f64],
    ) -> Result<Self, PetscError> {
        // As in `linalg`: relative to the smallest size, so that they fit into f32.
        let mut smallest = vec![0.0; session.ranks()];
        smallest[session.rank()] = sizes.iter().fold(f64::INFINITY, |m, &s| m.min(s));
        session.sum(&mut smallest)?;
        let smallest = smallest.into_iter().fold(f64::INFINITY, f64::min);
        let own: Vec<f64> = sizes.iter().map(|size| smallest / size).collect();
        let mut weights = vec![0.0; entries.len()];
        entries.write(&own, &mut weights);
        // Entries of other processes are zero, so their weights have no effect.
        let weight = |weight: &f64| (*weight as f32).max(f32::MIN_POSITIVE);
        Ok(Self {
            solver: OneThread::new(solver),
            entries,
            weights: weights.iter().map(weight).collect(),
        })
    }
}

/// Replaces numbers by their sums over all processes, or by NaN if that fails.
fn sum(values: &mut [f64]) {
    if Session::with_current(|session| session.sum(values)).is_err() {
        values.fill(f64::NAN);
    }
}

impl LinearOperator for DividedMatrix<'_, '_> {
    fn rows(&self) -> usize {
        self.entries.len()
    }

    fn cols(&self) -> usize {
        self.entries.len()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let product = (self.solver.get()).map(|solver| solver.multiply(&self.entries.of(x)));
        match product {
            Some(Ok(product)) => self.entries.write(&product, y),
            // Solvers report numbers that are not finite.
            _ => y.fill(f64::NAN),
        }
    }

    fn residual_weights(&self) -> Option<&[f32]> {
        Some(&self.weights)
    }

    fn sum_over_processes(&self) -> Option<&SumOverProcesses<'_>> {
        Some(&sum)
    }
}

/// The preconditioner of a solver on vectors of the parts.
pub struct DividedPreconditioner<'a, 's> {
    pub solver: &'a Solver<'s>,
    pub entries: &'a OwnEntries,
}

impl Preconditioner for DividedPreconditioner<'_, '_> {
    fn size(&self) -> usize {
        self.entries.len()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        match self.solver.precondition(&self.entries.of(r)) {
            Ok(result) => self.entries.write(&result, z),
            // Solvers report numbers that are not finite.
            Err(_) => z.fill(f64::NAN),
        }
    }

    fn kind(&self) -> PreconditionerKind {
        // Options of the command line may select methods that change from call to call.
        PreconditionerKind::Variable
    }
}
