//! Grand resistance matrix of the bodies of a problem.

use linalg::{KrylovParams, fgmres_columns};
use rigid::{Arms, Articulation, BodyKind, Drive, ExternalLoad, GrandResistance, Independent};

use crate::StokesError;
use crate::linear::MAX_COLUMNS;
use crate::problem::Problem;

impl Problem<'_> {
    /// Grand resistance and mobility matrices of the bodies without links.
    ///
    /// `F = R U` with six entries per body: `(U, ω)` and `(F, T)`.
    ///
    /// Cost: six solves per body with one preconditioner, three at a time, each to the true
    /// relative residual `rtol`.
    ///
    /// # Errors
    /// A system that cannot be built or solved, a mobility that is not positive definite.
    pub fn resistance(&self, rtol: f64) -> Result<GrandResistance, StokesError> {
        let bodies = self.bodies.len();
        let set = Articulation::new(
            &vec![BodyKind::Rigid; bodies],
            Vec::new(),
            Arms::Clamped,
            &self.centres(),
        )?;
        let drive = Drive {
            set: &set,
            constraints: &set.constraints(&set.initial_state(), &[], &[])?,
            loads: &vec![ExternalLoad::default(); bodies],
        };
        let system = self.assemble(&drive, &Independent)?;
        let mut preconditioner = system.preconditioner()?;
        let parameters = KrylovParams::default().with_rel_tol(rtol);
        GrandResistance::of(&system, MAX_COLUMNS, |rhs, solutions| {
            let system = &system.system;
            fgmres_columns(system, &mut preconditioner, rhs, solutions, &parameters)?;
            Ok(())
        })
    }
}
