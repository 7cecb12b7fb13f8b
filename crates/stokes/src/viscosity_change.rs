//! What a viscosity that depends on the shear rate would change about a flow, to first order.

use nalgebra::Vector3;
use rheology::ViscosityLaw;
use rigid::{Drive, FlowSolution};

use crate::StokesError;
use crate::linear::solve_system;
use crate::options::Options;
use crate::problem::Problem;
use crate::viscous_stress::{ViscousStress, shear};

/// First-order changes of a Newtonian flow by a viscosity law that it neglects, in two forms.
///
/// Where the law begins with a term of the second order in the rate, the change of the flow was
/// between both forms in all known cases: the first is too large, the second too small.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ViscosityChange {
    /// With the term of the law of second order in the rate, `η(g) - 1 = c g^2`; none if the law
    /// does not begin with it.
    pub second_order: Option<FlowSolution>,
    /// With the viscosity `η(g)` at the rates of the flow.
    pub full: FlowSolution,
}

/// Rate, over the largest one of a flow, at which the second-order term of a law is read off.
///
/// Terms of the fourth order are then 1e-6 of it, and rounding of `η - 1` is 1e-10.
const SMALL_RATE: f64 = 1e-3;

/// Largest relative difference of the coefficient at this rate and at its half: a law that begins
/// with another power has 0.4 for the first, and 1 for the third power.
const MAX_DIFFERENCE: f64 = 0.05;

/// Coefficient `c` of a law `η(g) = 1 + c g^2 + ...`, for flows with rates up to `largest`.
fn second_order(law: &dyn ViscosityLaw, largest: f64) -> Option<f64> {
    let coefficient = |rate: f64| (law.viscosity(rate) - law.viscosity(0.0)) / (rate * rate);
    let rates = [SMALL_RATE * largest, 0.5 * SMALL_RATE * largest];
    let [coarse, fine] = rates.map(coefficient);
    let is_even = (coarse - fine).abs() <= MAX_DIFFERENCE * fine.abs();
    (is_even && fine.is_finite()).then_some(fine)
}

impl Problem<'_> {
    /// First-order changes of a flow of viscosity 1 by a law whose viscosity at rest is 1.
    ///
    /// ```text
    /// -∇·(2 D(u_1)) + ∇p_1 = ∇·(2 (η(g_0) - 1) D(u_0)),   ∇·u_1 = 0
    /// ```
    ///
    /// with rigid motions on the bodies, the same joints and surface velocities as `u_0`. By the
    /// reciprocal theorem the change of a velocity is `V_1 = -∫ 2 (η - 1) D(u_0):∇z dV` with its
    /// adjoint solution `z`, which the solution of the symmetric discrete equations is to rounding,
    /// for all velocities and forces at once (Datt & Elfring 2018). In `drive` all rates and loads
    /// are zero. Cost: an assembly, two passes over the cells, and one solve for two right-hand
    /// sides.
    ///
    /// # Errors
    /// Those of [`Problem::assemble`]; a velocity of the wrong length; [`StokesError::Linalg`]
    /// without convergence.
    pub fn viscosity_change(
        &self,
        drive: &Drive,
        velocity: &[Vector3<f64>],
        law: &dyn ViscosityLaw,
        options: &Options,
    ) -> Result<ViscosityChange, StokesError> {
        let stress = ViscousStress {
            mesh: self.mesh,
            law,
            velocity,
        };
        let coefficient = second_order(law, stress.root_mean_square_rate()?);
        let at_rest = law.viscosity(0.0);
        let mut forces = vec![stress.forces_of(&|rate| law.viscosity(rate) - at_rest)?];
        if let Some(coefficient) = coefficient {
            forces.push(stress.forces_of(&|rate| coefficient * rate * rate)?);
        }
        let system = self.assemble_with(drive, options.formulation, None)?;
        let no_sources = vec![0.0; self.mesh.n_vertices()];
        let rhs = forces
            .iter()
            .map(|forces| system.rhs_of_forces(forces, &no_sources));
        let rhs: Vec<Vec<f64>> = rhs.collect::<Result<_, _>>()?;
        let columns: Vec<&[f64]> = rhs.iter().map(Vec::as_slice).collect();
        let method = (options.solver, options.rtol);
        let solved = solve_system(&system, &columns, method, &Default::default(), &mut None)?;
        let change = |number: usize| -> Result<FlowSolution, StokesError> {
            let (solution, _) = &solved.columns[number];
            Ok(system.change(solution, &forces[number], drive.set)?)
        };
        Ok(ViscosityChange {
            second_order: coefficient.map(|_| change(1)).transpose()?,
            full: change(0)?,
        })
    }
}

impl ViscousStress<'_> {
    /// Forces `-∫ 2 c(g) D ∇N_i` of a stress with the coefficient `c` on the nodes.
    pub fn forces_of(
        &self,
        coefficient: &(dyn Fn(f64) -> f64 + Sync),
    ) -> Result<Vec<Vector3<f64>>, StokesError> {
        let form = |point: &fem::PointValues<'_>, load: &mut [Vector3<f64>; 10]| {
            let (twice, rate) = shear(&point.gradient(self.velocity));
            let stress = twice * coefficient(rate);
            point.add_load(load, |v| -(stress * v.gradient));
        };
        Ok(fem::assemble_load(
            self.mesh,
            crate::viscous_stress::DEGREE,
            form,
        )?)
    }
}
