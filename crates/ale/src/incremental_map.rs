//! Mesh motion step by step: each mesh is made from the one before.

use fem::TaylorHood;
use mesh::{TetMesh, Vec3};
use nalgebra::Isometry3;

use crate::bodies::{OnBody, at_all_nodes, boundary_vertices, check_count, nodes_of};
use crate::{AleError, MeshMotion, MovingBody, MovingMesh};

/// A mesh that is moved on and on, the extension computed anew on the mesh of every step.
///
/// Larger motions stay valid than from a reference, as elements that have become small are stiffened; in return a closed stroke
/// does not come back to the mesh it started from, and every step costs a solve.
pub struct IncrementalMap {
    mesh: TetMesh,
    space: TaylorHood,
    prescribed: Vec<bool>,
    bodies: Vec<Surface>,
    motion: Box<dyn MeshMotion>,
}

/// A body's centre and surface in the first mesh.
struct Surface {
    centre: Vec3,
    turns: bool,
    nodes: Vec<u32>,
    arms: Vec<Vec3>,
}

impl IncrementalMap {
    /// Starts from `mesh`.
    ///
    /// # Errors
    /// A tag that the mesh does not have.
    pub fn new(
        mesh: TetMesh,
        bodies: &[MovingBody],
        motion: Box<dyn MeshMotion>,
    ) -> Result<Self, AleError> {
        let surface = |(body, nodes): (&MovingBody, Vec<u32>)| Surface {
            centre: body.centre,
            turns: body.turns,
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

    /// The mesh of the last step.
    pub fn mesh(&self) -> &TetMesh {
        &self.mesh
    }

    /// Moves on to where body `i` is moved by `motions[i]` from the *first* mesh, as for [`ReferenceMap::moved`](crate::ReferenceMap::moved).
    ///
    /// # Errors
    /// [`AleError::Invalid`] if an element would be inverted: the mesh stays as it was, try a smaller step or remesh.
    pub fn advance(&mut self, motions: &[Isometry3<f64>]) -> Result<&TetMesh, AleError> {
        check_count(self.bodies.len(), motions)?;
        let old = self.mesh.points();
        let mut displacement = vec![Vec3::zeros(); self.mesh.n_points()];
        for (body, motion) in self.bodies.iter().zip(motions) {
            for (&node, arm) in body.nodes.iter().zip(&body.arms) {
                let arm = if body.turns {
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
