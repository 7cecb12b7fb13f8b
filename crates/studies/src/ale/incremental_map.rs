//! Incremental mesh motion: each mesh is obtained from the previous one.

use ale::{AleError, MeshMotion, MovingBody, MovingMesh};
use fem::TaylorHood;
use mesh::{TET_EDGES, TetMesh, Vec3};
use nalgebra::Isometry3;

/// A mesh that moves step by step, with an extension computed on the current mesh at each step.
///
/// Larger motions stay valid than with a [`ReferenceMap`](ale::ReferenceMap), because elements
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
    /// [`AleError::NoSurface`] for a body's tag that the mesh does not have.
    pub fn new(
        mesh: TetMesh,
        bodies: &[MovingBody],
        motion: Box<dyn MeshMotion>,
    ) -> Result<Self, AleError> {
        let surface = |body: &MovingBody| {
            let tag = mesh.tag(&body.tag).map_err(AleError::NoSurface)?;
            let nodes = mesh.nodes_on(tag);
            let arm = |&node: &u32| mesh.points()[node as usize] - body.centre;
            Ok(Surface {
                centre: body.centre,
                rotates: body.rotates,
                arms: nodes.iter().map(arm).collect(),
                nodes,
            })
        };
        let bodies = bodies
            .iter()
            .map(surface)
            .collect::<Result<_, AleError>>()?;
        let mut prescribed = vec![false; mesh.n_vertices()];
        for facet in (mesh.facets().iter()).filter(|f| !mesh.is_symmetry_plane(f.tag)) {
            for &vertex in &facet.nodes[..3] {
                prescribed[vertex as usize] = true;
            }
        }
        Ok(Self {
            space: TaylorHood::new(&mesh)?,
            prescribed,
            bodies,
            mesh,
            motion,
        })
    }

    /// Moves the mesh to the configuration where body `i` has moved by `motions[i]` in total.
    ///
    /// Motions are relative to the *initial* mesh, as in
    /// [`ReferenceMap::moved`](ale::ReferenceMap::moved).
    ///
    /// # Errors
    /// [`AleError::Motions`] for another number of motions than bodies, [`AleError::Invalid`] if an
    /// element would be inverted. The mesh is then unchanged.
    pub fn advance(&mut self, motions: &[Isometry3<f64>]) -> Result<&TetMesh, AleError> {
        let (expected, found) = (self.bodies.len(), motions.len());
        if found != expected {
            return Err(AleError::Motions { expected, found });
        }
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
        let field = self.at_all_nodes(field, &displacement);
        let points = old.iter().zip(field).map(|(x, d)| x + d).collect();
        self.mesh = self.mesh.with_points(points)?;
        Ok(&self.mesh)
    }
    /// Extends a field from the vertices to all nodes, with the exact values on bodies.
    ///
    /// Midside nodes in the fluid get the mean of the ends of their edge, those on other boundaries
    /// zero.
    fn at_all_nodes(&self, mut field: Vec<Vec3>, on_bodies: &[Vec3]) -> Vec<Vec3> {
        let mesh = &self.mesh;
        field.resize(mesh.n_points(), Vec3::zeros());
        for cell in mesh.cells() {
            for (&middle, [a, b]) in cell[4..].iter().zip(TET_EDGES) {
                field[middle as usize] = (field[cell[a] as usize] + field[cell[b] as usize]) * 0.5;
            }
        }
        for facet in (mesh.facets().iter()).filter(|f| !mesh.is_symmetry_plane(f.tag)) {
            for &node in &facet.nodes[3..] {
                field[node as usize] = Vec3::zeros();
            }
        }
        for &node in self.bodies.iter().flat_map(|body| &body.nodes) {
            field[node as usize] = on_bodies[node as usize];
        }
        field
    }
}

#[cfg(test)]
mod tests {
    use ale::ReferenceMap;
    use mesher::{Container, GenerateParams, MeshedBody, Spheroid};
    use nalgebra::{Translation3, UnitQuaternion};

    use super::super::methods::METHODS;
    use super::*;

    /// A spheroid in a ball.
    fn bead() -> (TetMesh, MovingBody) {
        let spheroid = Spheroid {
            centre: Vec3::new(0.5, 0.0, 0.0),
            axis: Vec3::x(),
            axial: 1.6,
            equatorial: 1.0,
        };
        let container = Container::Ball(mesher::Sphere {
            centre: Vec3::zeros(),
            radius: 6.0,
        });
        let body = MeshedBody {
            name: "bead",
            surface: &spheroid,
            size: 0.7,
        };
        let tets = mesher::generate(&[body], &container, &GenerateParams::default());
        let surfaces = [
            ("bead", body.surface),
            (Container::TAG, container.surface()),
        ];
        let moving = MovingBody {
            tag: "bead".into(),
            centre: spheroid.centre,
            rotates: true,
        };
        (
            TetMesh::curved(tets.unwrap().mesh, &surfaces).unwrap(),
            moving,
        )
    }

    /// Both solve the extension on the same mesh, to relative residuals of 1e-8 (1e-6 for the
    /// biharmonic one) with condition numbers below 1e3; on the surface both are exact.
    #[test]
    fn the_first_step_equals_the_reference_map_and_follows_the_body() {
        let (mesh, body) = bead();
        let motion = Isometry3::from_parts(
            Translation3::new(0.2, 0.1, -0.1),
            UnitQuaternion::from_scaled_axis(Vec3::new(0.0, 0.1, 0.2)),
        );
        let bodies = [body];
        for method in METHODS {
            let map = ReferenceMap::new(mesh.clone(), &bodies, (method.make)().as_ref()).unwrap();
            let from_reference = map.moved(&[motion]).unwrap();
            let mut steps = IncrementalMap::new(mesh.clone(), &bodies, (method.make)()).unwrap();
            let stepped = steps.advance(&[motion]).unwrap();
            let pairs = from_reference.points().iter().zip(stepped.points());
            let difference = pairs.map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
            assert!(difference < 1e-4, "{}: {difference:e}", method.name);
            let nodes = mesh.nodes_on(mesh.tag("bead").unwrap());
            assert!(!nodes.is_empty());
            for node in nodes {
                let arm = mesh.points()[node as usize] - bodies[0].centre;
                let turned = motion.rotation * arm;
                let expected = bodies[0].centre + motion.translation.vector + turned;
                let error = (stepped.points()[node as usize] - expected).amax();
                assert!(error < 1e-13, "{}: {error:e}", method.name);
            }
        }
    }

    #[test]
    fn refused_steps_leave_the_mesh_unchanged_and_unknown_parts_are_refused() {
        let (mesh, body) = bead();
        for method in METHODS {
            let bodies = std::slice::from_ref(&body);
            let mut steps = IncrementalMap::new(mesh.clone(), bodies, (method.make)()).unwrap();
            let through_the_wall = [Isometry3::translation(5.0, 0.0, 0.0)];
            let refused = steps.advance(&through_the_wall);
            assert!(matches!(refused, Err(AleError::Invalid(_))));
            assert_eq!(steps.mesh.points(), mesh.points());
            let refused = steps.advance(&[]);
            assert!(matches!(
                refused,
                Err(AleError::Motions {
                    expected: 1,
                    found: 0
                })
            ));
            let small = [Isometry3::translation(0.1, 0.0, 0.0)];
            steps.advance(&small).unwrap();
            let misspelt = [MovingBody {
                tag: "bed".into(),
                ..body.clone()
            }];
            let refused = IncrementalMap::new(mesh.clone(), &misspelt, (method.make)());
            assert!(matches!(refused.map(drop), Err(AleError::NoSurface(_))));
        }
    }
}
