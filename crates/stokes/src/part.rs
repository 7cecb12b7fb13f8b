//! Assembly of a part of a problem that is divided between processes.

use fem::TaylorHood;
use mesh::Submesh;
use rigid::{Constrained, Drive, FluidNodes, Formulation, MeshPart, RigidFluid};

use crate::StokesError;
use crate::matrices::fluid_matrices;
use crate::problem::Problem;

impl Problem<'_> {
    /// Assembles the equations of the nodes that this process owns.
    ///
    /// `submesh` has all cells around these nodes, `part` says which of its nodes they are. Rows of
    /// other nodes are incomplete. Border, right-hand side of the border and corner are those of
    /// the whole problem, the same on every process; columns of the border have the rows of owned
    /// nodes only. Every process calls this function, because it sums over processes.
    ///
    /// Pressure Laplacians for narrow gaps and channels are not assembled: they need
    /// [`Problem::permeability`] of the whole mesh.
    ///
    /// # Errors
    /// Those of [`Problem::assemble`].
    pub fn assemble_part(
        &self,
        submesh: &Submesh,
        part: MeshPart,
        drive: &Drive,
        formulation: &dyn Formulation,
    ) -> Result<Constrained, StokesError> {
        let mesh = &submesh.mesh;
        let restricted = |values: &[_]| -> Vec<_> {
            let nodes = submesh.nodes.iter();
            nodes.map(|&node| values[node as usize]).collect()
        };
        let all_roles = self.roles();
        let roles: Vec<_> = (submesh.nodes.iter())
            .map(|&node| all_roles[node as usize])
            .collect();
        drop(all_roles);
        let on_planes = self.mesh.nodes_on_symmetry_planes();
        let on_planes = on_planes.into_iter().filter_map(|(node, axes)| {
            let number = submesh.number(node)?;
            Some((number, axes))
        });
        let surfaces = self.nodal_surface_flow()?;
        let velocity = surfaces.as_ref().map(|s| restricted(&s.velocity));
        let mut nodes = FluidNodes::new(mesh.points(), &roles)
            .with_symmetry_planes(on_planes.collect())
            .with_part(part);
        if let (Some(surfaces), Some(velocity)) = (&surfaces, &velocity) {
            nodes = nodes.with_surface_velocity(velocity, &surfaces.moments);
        }
        let matrices = TaylorHood::new(mesh)?.matrices(mesh)?;
        let fluid = RigidFluid::new(fluid_matrices(matrices), nodes, &self.surface_bodies()?)?;
        Ok(formulation.constrain(fluid, drive)?)
    }
}
