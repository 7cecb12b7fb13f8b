//! Incremental mesh motion: each mesh is obtained from the previous one.

use fem::TaylorHood;
use mesh::{TetMesh, Vec3};
use nalgebra::Isometry3;

use crate::bodies::{OnBody, at_all_nodes, boundary_vertices, check_motions, nodes_of};
use crate::{AleError, MeshMotion, MovingBody, MovingMesh};

/// A mesh that moves step by step, with an extension computed on the current mesh at each step.
///
/// Larger motions stay valid than with a [`ReferenceMap`](crate::ReferenceMap), because elements
/// that have become small are stiffened. However, a closed stroke does not return to the initial
/// mesh, and every step costs a solve.
pub struct IncrementalMap {
    mesh: TetMesh,
    space: TaylorHood,
    prescribed: Vec<bool>,
    bodies: Vec<Surface>,
    motion: Box<dyn MeshMotion>,
}

/// A body's centre and surface in the initial mesh.
struct Surface {
    centre: Vec3,
    rotates: bool,
    nodes: Vec<u32>,
    /// Vectors from the centre to the nodes.
    arms: Vec<Vec3>,
}

impl IncrementalMap {
    /// The map with `mesh` as its initial mesh.
    ///
    /// # Errors
    /// [`AleError::NoSurface`] for a body's tag that the mesh does not have,
    /// [`AleError::SharedSurface`], a centre that is not finite.
    pub fn new(
        mesh: TetMesh,
        bodies: &[MovingBody],
        motion: Box<dyn MeshMotion>,
    ) -> Result<Self, AleError> {
        let surface = |(body, nodes): (&MovingBody, Vec<u32>)| Surface {
            centre: body.centre,
            rotates: body.rotates,
            arms: nodes
                .iter()
                .map(|&n| mesh.points()[n as usize] - body.centre)
                .collect(),
            nodes,
        };
        let bodies = bodies
            .iter()
            .zip(nodes_of(&mesh, bodies)?)
            .map(surface)
            .collect();
        Ok(Self {
            space: TaylorHood::new(&mesh)?,
            prescribed: boundary_vertices(&mesh),
            bodies,
            mesh,
            motion,
        })
    }

    /// The current mesh.
    pub fn mesh(&self) -> &TetMesh {
        &self.mesh
    }

    /// Moves the mesh to the configuration where body `i` has moved by `motions[i]` in total.
    ///
    /// Motions are relative to the *initial* mesh, as in
    /// [`ReferenceMap::moved`](crate::ReferenceMap::moved).
    ///
    /// # Errors
    /// [`AleError::Motions`], [`AleError::NotFinite`] and [`AleError::NotRotation`] for motions
    /// that do not fit; [`AleError::Invalid`] if an element would be inverted. The mesh is then
    /// unchanged: try a smaller step or remesh.
    pub fn advance(&mut self, motions: &[Isometry3<f64>]) -> Result<&TetMesh, AleError> {
        check_motions(self.bodies.len(), motions)?;
        let old = self.mesh.points();
        let mut displacement = vec![Vec3::zeros(); self.mesh.n_points()];
        for (body, motion) in self.bodies.iter().zip(motions) {
            for (&node, arm) in body.nodes.iter().zip(&body.arms) {
                let arm = if body.rotates {
                    motion.rotation * arm
                } else {
                    *arm
                };
                let new = body.centre + motion.translation.vector + arm;
                displacement[node as usize] = new - old[node as usize];
            }
        }
        let moving = MovingMesh {
            mesh: &self.mesh,
            space: &self.space,
            prescribed: &self.prescribed,
        };
        let mut fields = [displacement[..self.mesh.n_vertices()].to_vec()];
        self.motion.extend(&moving, &mut fields)?;
        let [field] = fields;
        let exact = |node: u32| displacement[node as usize];
        let surfaces: Vec<OnBody<'_, Vec3>> = self
            .bodies
            .iter()
            .map(|body| (body.nodes.as_slice(), &exact as _))
            .collect();
        let field = at_all_nodes(&self.mesh, field, Vec3::zeros(), &surfaces);
        let points = old.iter().zip(field).map(|(x, d)| x + d).collect();
        self.mesh = self.mesh.with_points(points)?;
        Ok(&self.mesh)
    }
}
