//! The approximate inverse of the pressure's Schur complement.

use crate::vector::max_abs;
use crate::{
    Bordered, Csr, LinalgError, MassInverse, Multigrid, MultigridParams, Preconditioner,
    SaddleSystem, csr,
};

/// Chebyshev steps on the pressure mass matrix: two or three need the same iterations, one needs three more (methods note 1.2).
pub(crate) const MASS_STEPS: usize = 3;

/// Part of the mass matrix that is added to the stiffness of gaps, whose constants are its null space. A residual of the divergence adds up to
/// zero, so that only rounding sees it.
const SHIFT: f64 = 1e-3;

/// `M_p^-1`, and where there are narrow gaps `M_p^-1 + L^-1`.
///
/// In a gap of width h the pressure drives a flux of `h^2 / 12` times its gradient, as in lubrication, instead of the strain rate that the mass
/// matrix stands for. For fields that are longer than the gap is wide this is much less, and the mass matrix much too large. The sum of both inverses is that of Cahouet & Chabert
/// (Int. J. Numer. Methods Fluids 8, 1988) for the two parts of an unsteady problem, with the walls of a gap for the inertia.
pub(crate) struct PressureInverse {
    mass: MassInverse,
    gaps: Option<Gaps>,
}

/// One V-cycle for `L`, in the first of three components.
struct Gaps {
    cycle: Multigrid,
    solution: Vec<f64>,
}

impl PressureInverse {
    /// The mass matrix alone.
    pub fn new(system: &SaddleSystem) -> Result<Self, LinalgError> {
        Ok(PressureInverse {
            mass: MassInverse::new(system.pressure_mass(), MASS_STEPS)?,
            gaps: None,
        })
    }

    /// With the stiffness of gaps `L`, symmetric and positive semidefinite.
    pub fn with_pressure_laplacian(
        mut self,
        system: &SaddleSystem,
        stiffness: &Csr,
    ) -> Result<Self, LinalgError> {
        let mass = system.pressure_mass();
        csr::check_shape("stiffness of gaps", stiffness.shape(), mass.shape())?;
        let shifted = stiffness + &mass.map(|v| SHIFT * v);
        let cycle = Multigrid::new(&Bordered::scalar(shifted)?, &MultigridParams::default())?;
        self.gaps = Some(Gaps {
            solution: vec![0.0; cycle.size()],
            cycle,
        });
        Ok(self)
    }

    /// Overwrites the columns `z` with the approximate solutions for `r`.
    pub fn pass<const S: usize>(&mut self, r: [&[f64]; S], mut z: [&mut [f64]; S]) {
        self.mass.pass(r, z.each_mut().map(|z| &mut **z));
        if let Some(gaps) = &mut self.gaps {
            gaps.add(&r, &mut z);
        }
    }
}

#[cfg(feature = "roofline")]
impl PressureInverse {
    /// The part that every system has.
    pub fn mass(&mut self) -> &mut MassInverse {
        &mut self.mass
    }

    /// Bytes that one application moves at least.
    pub fn bytes(&self) -> usize {
        self.mass.bytes() + self.gaps.as_ref().map_or(0, |gaps| gaps.cycle.bytes())
    }
}

impl Gaps {
    /// Adds the solutions for `r` to `z`, one by one: side by side in the three components they might round otherwise than alone.
    fn add(&mut self, r: &[&[f64]], z: &mut [&mut [f64]]) {
        for (r, z) in r.iter().zip(z) {
            let rows = |q: usize| [[r[q], 0.0, 0.0]];
            let solution = &mut self.solution;
            self.cycle.apply_to([max_abs(r)], rows, [&[]], [solution]);
            for (z, [v, ..]) in z.iter_mut().zip(solution.as_chunks::<3>().0) {
                *z += v;
            }
        }
    }
}
