//! Mesh motion as a map from a reference mesh: the moved mesh depends on where bodies are, not on how they came there.

use fem::TaylorHood;
use mesh::{TetMesh, Vec3};
use nalgebra::Isometry3;

use crate::dirichlet::DirichletSolver;
use crate::{AleError, Stiffening};

/// A body that moves the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingBody {
    /// Tag of its surface.
    pub tag: String,
    /// Its centre in the reference mesh.
    pub centre: Vec3,
    /// Whether its surface turns with it. A sphere's surface need not: turned by any angle it is the same sphere.
    pub turns: bool,
}

/// Harmonic extensions of the rigid motions of each body into a reference mesh.
///
/// For a body at `c` that is moved by `t` and turned by `Q`, the displacement of a node at `X` is
/// $d(X) = \sum_i \varphi_i(X) t_i + (Q_i - I) \psi_i(X)$ with $\nabla\cdot(c \nabla \varphi_i) = 0$, $\varphi_i = 1$ on body `i` and
/// 0 on every other boundary, and $\psi_i$ likewise the extension of $X - c_i$. The extensions are computed once;
/// a new shape then costs no solve, and a closed stroke returns to exactly the mesh it started from.
///
/// Extensions are piecewise linear on the vertices. Midside nodes in the fluid follow the mean of their edge's
/// ends, nodes on a body move exactly with it, nodes on other boundaries stay.
#[derive(Clone, Debug)]
pub struct ReferenceMap {
    mesh: TetMesh,
    extensions: Vec<Extension>,
}

/// Extensions of one body's translation and, if it turns, of its arms `X - c`, at every node.
#[derive(Clone, Debug)]
struct Extension {
    translation: Vec<f64>,
    arm: Vec<Vec3>,
}

impl ReferenceMap {
    /// Computes the extensions of the bodies' motions into `mesh`: one scalar field a body, four if it turns.
    ///
    /// Cost: one assembly of the vertex stiffness, one multigrid set-up, one solve for every three fields.
    ///
    /// # Errors
    /// A tag that the mesh does not have, or a solve that fails.
    pub fn new(
        mesh: TetMesh,
        bodies: &[MovingBody],
        stiffening: Stiffening,
    ) -> Result<Self, AleError> {
        let vertices = mesh.n_vertices();
        let on_body: Vec<Vec<u32>> = bodies
            .iter()
            .map(|body| Ok(mesh.nodes_on(mesh.tag(&body.tag)?)))
            .collect::<Result<_, AleError>>()?;
        let mut prescribed = vec![false; vertices];
        for facet in mesh.facets() {
            for &vertex in &facet.nodes[..3] {
                prescribed[vertex as usize] = true;
            }
        }
        // One scalar boundary condition an extension: 1 on the body, then the components of its arms.
        let mut conditions = Vec::new();
        for (body, nodes) in bodies.iter().zip(&on_body) {
            let on_vertices = || {
                nodes
                    .iter()
                    .map(|&node| node as usize)
                    .filter(|&node| node < vertices)
            };
            let mut add = |value: &dyn Fn(usize) -> f64| {
                let mut condition = vec![0.0; vertices];
                on_vertices().for_each(|vertex| condition[vertex] = value(vertex));
                conditions.push(condition);
            };
            add(&|_| 1.0);
            if body.turns {
                (0..3).for_each(|axis| add(&|vertex| (mesh.points()[vertex] - body.centre)[axis]));
            }
        }
        let stiffness = TaylorHood::new(&mesh)?
            .weighted_vertex_stiffness(&mesh, &stiffening.coefficients(&mesh))?;
        let mut fields = DirichletSolver::new(&stiffness, &prescribed)?
            .extend(&conditions)?
            .into_iter();
        let extensions = bodies
            .iter()
            .zip(&on_body)
            .map(|(body, nodes)| {
                let mut next = || fields.next().unwrap_or_default();
                let translation = next();
                let arm = if body.turns {
                    (0..3).map(|_| next()).collect()
                } else {
                    Vec::new()
                };
                Extension::at_all_nodes(&mesh, translation, arm, nodes, body.centre)
            })
            .collect();
        Ok(Self { mesh, extensions })
    }

    /// The reference mesh.
    pub fn reference(&self) -> &TetMesh {
        &self.mesh
    }

    /// The mesh when body `i` is moved by `motions[i]`: its centre by the translation, its surface turned about it.
    ///
    /// # Errors
    /// [`AleError::Invalid`] if an element is inverted, curved elements included: then remesh.
    pub fn moved(&self, motions: &[Isometry3<f64>]) -> Result<TetMesh, AleError> {
        if motions.len() != self.extensions.len() {
            return Err(AleError::Motions {
                expected: self.extensions.len(),
                found: motions.len(),
            });
        }
        let mut points = self.mesh.points().to_vec();
        for (motion, extension) in motions.iter().zip(&self.extensions) {
            for (point, &share) in points.iter_mut().zip(&extension.translation) {
                *point += share * motion.translation.vector;
            }
            let turn =
                motion.rotation.to_rotation_matrix().into_inner() - nalgebra::Matrix3::identity();
            for (point, arm) in points.iter_mut().zip(&extension.arm) {
                *point += turn * arm;
            }
        }
        Ok(self.mesh.with_points(points)?)
    }
}

impl Extension {
    /// From the values at the vertices: `translation`, and the three components of `arm` if the body turns.
    fn at_all_nodes(
        mesh: &TetMesh,
        mut translation: Vec<f64>,
        arm: Vec<Vec<f64>>,
        on_body: &[u32],
        centre: Vec3,
    ) -> Self {
        let turns = !arm.is_empty();
        let mut arm: Vec<Vec3> = match &arm[..] {
            [x, y, z] => x
                .iter()
                .zip(y)
                .zip(z)
                .map(|((&x, &y), &z)| Vec3::new(x, y, z))
                .collect(),
            _ => Vec::new(),
        };
        translation.resize(mesh.n_points(), 0.0);
        if turns {
            arm.resize(mesh.n_points(), Vec3::zeros());
        }
        for cell in mesh.cells() {
            for (&middle, [a, b]) in cell[4..].iter().zip(mesh::TET_EDGES) {
                let (a, b) = (cell[a] as usize, cell[b] as usize);
                translation[middle as usize] = 0.5 * (translation[a] + translation[b]);
                if turns {
                    arm[middle as usize] = 0.5 * (arm[a] + arm[b]);
                }
            }
        }
        for facet in mesh.facets() {
            for &node in &facet.nodes[3..] {
                translation[node as usize] = 0.0;
                if turns {
                    arm[node as usize] = Vec3::zeros();
                }
            }
        }
        for &node in on_body {
            translation[node as usize] = 1.0;
            if turns {
                arm[node as usize] = mesh.points()[node as usize] - centre;
            }
        }
        Self { translation, arm }
    }
}
