//! Extension by the biharmonic equation with zero normal derivative on the boundary.

use fem::DirichletCondition;
use linalg::{
    Bordered, Csr, LinearOperator, Multigrid, MultigridParams, Preconditioner, PreconditionerKind,
};
use mesh::{TetMesh, Vec3};

use crate::extension::{extend, krylov, scalar_product};
use crate::{AleError, MeshMotion, MovingMesh};

/// Biharmonic extension: `Δ² d = 0` for each component, with `∂d/∂n = 0` on the boundary.
///
/// The mesh close to a body moves with it almost rigidly (Helenbrook, Int. J. Numer. Meth. Engng
/// 56, 2003).
///
/// Mixed linear elements with lumped mass: `K M^-1 K d = 0` at free vertices. The rows of `K d` on
/// the boundary impose the normal derivative weakly. Cost: CG preconditioned by two multigrid
/// cycles, one on each side of `M`; the number of iterations grows as elements become smaller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Biharmonic;

/// The operator `K M^-1 K` on the free vertices.
struct BiharmonicOperator<'a> {
    condition: &'a DirichletCondition,
    stiffness: &'a Csr,
    inverse_mass: &'a [f64],
}

impl BiharmonicOperator<'_> {
    /// `K M^-1 K d` at all vertices.
    fn image(&self, d: &[Vec3]) -> Vec<Vec3> {
        let mut flux = scalar_product(self.stiffness, d);
        flux.iter_mut()
            .zip(self.inverse_mass)
            .for_each(|(w, m)| *w *= *m);
        scalar_product(self.stiffness, &flux)
    }
}

impl LinearOperator for BiharmonicOperator<'_> {
    fn rows(&self) -> usize {
        3 * self.condition.n_free()
    }

    fn cols(&self) -> usize {
        self.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let mut d = vec![Vec3::zeros(); self.inverse_mass.len()];
        let free = self.condition.free_nodes();
        for (value, &node) in x.as_chunks::<3>().0.iter().zip(free) {
            d[node as usize] = Vec3::from(*value);
        }
        let image = self.image(&d);
        for (value, &node) in y.as_chunks_mut::<3>().0.iter_mut().zip(free) {
            *value = image[node as usize].into();
        }
    }

    fn is_symmetric(&self) -> bool {
        true
    }
}

/// The preconditioner `V M V` with the multigrid cycle `V` of `K`.
struct TwoCycles {
    cycle: Multigrid,
    mass: Vec<f64>,
    /// `V r`, between the two cycles.
    between: Vec<f64>,
}

impl Preconditioner for TwoCycles {
    fn size(&self) -> usize {
        3 * self.mass.len()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        self.cycle.apply(r, &mut self.between);
        for (components, mass) in self
            .between
            .as_chunks_mut::<3>()
            .0
            .iter_mut()
            .zip(&self.mass)
        {
            components.iter_mut().for_each(|w| *w *= mass);
        }
        self.cycle.apply(&self.between, z);
    }

    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::PositiveDefinite
    }
}

/// Relative residual of the extension.
///
/// Rounding limits it to the machine precision times the condition number of `K M^-1 K`, which is
/// 1e8 on graded meshes.
const RESIDUAL_TOLERANCE: f64 = 1e-6;

impl MeshMotion for Biharmonic {
    fn name(&self) -> &'static str {
        "biharmonic"
    }

    fn is_scalar(&self) -> bool {
        true
    }

    fn extend(&self, moving: &MovingMesh<'_>, fields: &mut [Vec<Vec3>]) -> Result<usize, AleError> {
        moving.check(fields)?;
        let condition = DirichletCondition::new(moving.prescribed);
        if condition.n_free() == 0 {
            return Ok(0);
        }
        let stiffness = moving.space.vertex_stiffness(moving.mesh)?;
        let mass = lumped_mass(moving.mesh);
        let inverse_mass: Vec<f64> = mass.iter().map(|m| 1.0 / m).collect();
        let free = Bordered::scalar(condition.restrict_matrix(&stiffness, 1)?)?;
        let free_mass = (0..mass.len())
            .filter(|&v| !moving.prescribed[v])
            .map(|v| mass[v]);
        let mut preconditioner = TwoCycles {
            cycle: Multigrid::new(&free, &MultigridParams::default())?,
            mass: free_mass.collect(),
            between: vec![0.0; 3 * condition.n_free()],
        };
        let operator = BiharmonicOperator {
            condition: &condition,
            stiffness: &stiffness,
            inverse_mass: &inverse_mass,
        };
        let params = krylov(3000).with_rel_tol(RESIDUAL_TOLERANCE);
        let apply = |field: &[Vec3]| operator.image(field);
        extend(
            &condition,
            &apply,
            &operator,
            &mut preconditioner,
            &params,
            fields,
        )
    }
}

/// The lumped mass of each vertex: a quarter of the volume of the cells around it.
fn lumped_mass(mesh: &TetMesh) -> Vec<f64> {
    let mut mass = vec![0.0; mesh.n_vertices()];
    for (cell, nodes) in mesh.cells().iter().enumerate() {
        let quarter = 0.25 * mesh.cell_volume(cell);
        nodes[..4]
            .iter()
            .for_each(|&vertex| mass[vertex as usize] += quarter);
    }
    mass
}
