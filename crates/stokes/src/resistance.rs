//! Grand resistance matrix of the bodies of a problem.

use fem::SurplusSpace;
use linalg::{KrylovParams, fgmres_columns};
use rigid::{Arms, Articulation, BodyKind, Drive, ExternalLoad, GrandResistance, Independent};

use crate::StokesError;
use crate::cubic::Correction;
use crate::equations::Equations;
use crate::linear::MAX_COLUMNS;
use crate::problem::Problem;

impl Problem<'_> {
    /// Grand resistance and mobility matrices of the bodies without joints.
    ///
    /// `F = R U` with six entries per body: `(U, ω)` and `(F, T)`.
    ///
    /// Cost: six solves per body with one preconditioner, three at a time, each to the true
    /// relative residual `rtol`.
    ///
    /// # Errors
    /// A system that cannot be built or solved, a mobility that is not positive definite.
    pub fn resistance(&self, rtol: f64) -> Result<GrandResistance, StokesError> {
        self.condensed(rtol, None)
    }

    /// The matrices of [`Problem::resistance`] with corrected velocities.
    ///
    /// The correction is that of [`Estimate::change`](crate::Estimate::change). Both matrices are
    /// symmetrised; the asymmetry before is of the accuracy of the corrections, some percent of
    /// them. Cost: about twice that of [`Problem::resistance`].
    ///
    /// # Errors
    /// Those of [`Problem::resistance`].
    pub fn corrected_resistance(&self, rtol: f64) -> Result<GrandResistance, StokesError> {
        self.condensed(rtol, Some(&SurplusSpace::new(self.mesh)?))
    }

    fn condensed(
        &self,
        rtol: f64,
        surplus: Option<&SurplusSpace>,
    ) -> Result<GrandResistance, StokesError> {
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
        let system = self.assemble_with(&drive, &Independent, None)?;
        let mut preconditioner = system.preconditioner()?;
        let parameters = KrylovParams::default().with_rel_tol(rtol);
        let geometry = self.facet_geometry()?;
        let corrections = surplus
            .map(|space| {
                let equations = Equations::whole(self.mesh, space, &system);
                Correction::new(self.mesh, equations, &geometry, &set, None, None)
            })
            .transpose()?;
        let velocities = system.system.border_range();
        GrandResistance::new(&system, MAX_COLUMNS, |rhs, solutions| {
            let matrix = &system.system;
            fgmres_columns(matrix, &mut preconditioner, rhs, solutions, &parameters)?;
            let Some(corrections) = &corrections else {
                return Ok(());
            };
            let flows = solutions.iter().map(|solution| system.flow(solution, &set));
            let flows: Vec<_> = flows.collect::<Result<_, _>>()?;
            let changes = corrections.changes(&flows, &mut preconditioner)?;
            for (solution, change) in solutions.iter_mut().zip(changes) {
                let own = solution[velocities.clone()].iter_mut();
                own.zip(change.flow.bodies.iter())
                    .for_each(|(u, du)| *u += du);
            }
            Ok(())
        })
    }
}
