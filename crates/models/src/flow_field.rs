//! Flow fields: at points, on the nodes of a mesh, and of a solution.

use std::sync::{Arc, OnceLock};

use mesh::{PointLocator, TetMesh};
use nalgebra::{Isometry3, Matrix3, Vector3};
use rayon::prelude::*;

use crate::error::ModelError;

/// Velocity and pressure at a point of the fluid, in the scene's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointFlow {
    /// Velocity.
    pub velocity: Vector3<f64>,
    /// Pressure; `None` for models that do not compute it.
    pub pressure: Option<f64>,
}

/// A velocity and pressure field on the nodes of a mesh, in the scene's units.
#[derive(Clone, Debug)]
pub struct FlowField {
    /// The mesh.
    pub mesh: TetMesh,
    /// Velocity at every node of the mesh.
    pub velocity: Vec<Vector3<f64>>,
    /// Pressure at every vertex of the mesh; empty for models that do not compute it.
    pub pressure: Vec<f64>,
}

impl FlowField {
    /// Moves the mesh, and turns the velocities with it.
    ///
    /// # Errors
    /// Points that overflow.
    pub(crate) fn move_by(&mut self, motion: &Isometry3<f64>) -> Result<(), ModelError> {
        let points = self.mesh.points().iter();
        let points = points.map(|x| motion.rotation * x + motion.translation.vector);
        self.mesh = self.mesh.with_points(points.collect())?;
        for velocity in &mut self.velocity {
            *velocity = motion.rotation * *velocity;
        }
        Ok(())
    }

    /// Vorticity `∇ × u` at every vertex of the mesh, of second order.
    ///
    /// # Errors
    /// Velocities that are not finite.
    pub fn vorticity(&self) -> Result<Vec<Vector3<f64>>, ModelError> {
        let gradients = fem::vertex_gradients(&self.mesh, &self.velocity)?;
        // g_ck = du_c/dx_k
        let curl = |g: &Matrix3<f64>| {
            Vector3::new(
                g[(2, 1)] - g[(1, 2)],
                g[(0, 2)] - g[(2, 0)],
                g[(1, 0)] - g[(0, 1)],
            )
        };
        Ok(gradients.iter().map(curl).collect())
    }

    /// Velocity and pressure at points, interpolated as the elements are; `None` for a point
    /// outside the mesh.
    ///
    /// Cost: a box for each cell, and a hierarchy of those that meet the bounding box of the
    /// points.
    pub fn at(&self, points: &[Vector3<f64>]) -> Vec<Option<PointFlow>> {
        let infinite = Vector3::repeat(f64::INFINITY);
        let bounds = points.iter().fold([infinite, -infinite], |[min, max], x| {
            [min.inf(x), max.sup(x)]
        });
        let locator = PointLocator::within(&self.mesh, &bounds[0], &bounds[1]);
        let values = |x: &Vector3<f64>| {
            let found = locator.locate(x)?;
            let nodes = self.mesh.cells()[found.cell].map(|node| node as usize);
            let weighted = nodes.iter().zip(found.quadratic());
            let velocity = weighted.map(|(node, n)| n * self.velocity[*node]).sum();
            let vertices = nodes.iter().zip(found.barycentric);
            let pressure = (!self.pressure.is_empty())
                .then(|| vertices.map(|(node, l)| l * self.pressure[*node]).sum());
            Some(PointFlow { velocity, pressure })
        };
        points.par_iter().map(values).collect()
    }
}

/// The value of a cell, which is computed if there is none.
///
/// # Errors
/// Those of the computation.
pub(crate) fn get_or_try<T, E>(
    cell: &OnceLock<T>,
    compute: impl FnOnce() -> Result<T, E>,
) -> Result<&T, E> {
    match cell.get() {
        Some(value) => Ok(value),
        None => {
            let value = compute()?;
            Ok(cell.get_or_init(|| value))
        }
    }
}

type Compute = dyn Fn() -> Result<FlowField, ModelError> + Send + Sync;

/// The flow of one solution, which is converted to a field on a mesh when it is first needed.
#[derive(Clone)]
pub struct SolutionFlow(Arc<LazyField>);

struct LazyField {
    field: OnceLock<FlowField>,
    compute: Arc<Compute>,
}

impl SolutionFlow {
    /// A flow whose field is computed by `compute`, which owns or shares all that it needs.
    pub fn new(
        compute: impl Fn() -> Result<FlowField, ModelError> + Send + Sync + 'static,
    ) -> Self {
        Self(Arc::new(LazyField {
            field: OnceLock::new(),
            compute: Arc::new(compute),
        }))
    }

    /// The flow on its mesh. Cost: that of a mesh for the first call, none for later ones.
    ///
    /// # Errors
    /// A mesh that cannot be converted to the units and the place of the scene.
    pub fn field(&self) -> Result<&FlowField, ModelError> {
        get_or_try(&self.0.field, || (self.0.compute)())
    }

    /// The same flow without its field, which is computed again if it is needed.
    ///
    /// For flows that are kept while others are computed: on large meshes the field takes more
    /// memory than the flow.
    #[must_use]
    pub fn without_field(&self) -> Self {
        Self(Arc::new(LazyField {
            field: OnceLock::new(),
            compute: Arc::clone(&self.0.compute),
        }))
    }

    /// The flow on its mesh, without a copy if nothing else refers to it.
    ///
    /// # Errors
    /// As [`SolutionFlow::field`].
    pub fn into_field(self) -> Result<FlowField, ModelError> {
        self.field()?;
        let known = match Arc::try_unwrap(self.0) {
            Ok(own) => own.field.into_inner(),
            Err(shared) => shared.field.get().cloned(),
        };
        known.ok_or(ModelError::NoMesh)
    }
}

impl std::fmt::Debug for SolutionFlow {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("SolutionFlow").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use mesh::LinearTets;

    use super::*;

    /// Twice the angular velocity in solid rotation, whatever is added to it without rotation.
    #[test]
    fn the_vorticity_of_a_linear_flow_is_exact() {
        let mesh = TetMesh::straight(LinearTets::cube(2)).unwrap();
        let spin = Vector3::new(0.3, -1.0, 2.0);
        let strain = Vector3::new(1.0, -3.0, 2.0);
        let velocity = |x: &Vector3<f64>| spin.cross(x) + strain.component_mul(x);
        let flow = FlowField {
            velocity: mesh.points().iter().map(velocity).collect(),
            pressure: Vec::new(),
            mesh,
        };
        let vorticity = flow.vorticity().unwrap();
        assert_eq!(vorticity.len(), flow.mesh.n_vertices());
        assert!(vorticity.iter().all(|w| (w - 2.0 * spin).norm() < 1e-13));
    }
}
