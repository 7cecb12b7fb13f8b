//! Mesh motion as a map from a reference mesh: the moved mesh depends on where bodies are, not on how they came there.

use fem::TaylorHood;
use mesh::{TetMesh, Vec3};
use nalgebra::{Isometry3, Matrix3};

use crate::bodies::{at_all_nodes, boundary_vertices, check_count, nodes_of, turn};
use crate::{AleError, MeshMotion, MovingBody, MovingMesh};

/// Extensions of the rigid motions of each body into a reference mesh.
///
/// For a body at `c` that is moved by `t` and turned by `Q`, the displacement of a node at `X` is
/// $d(X) = \sum_i \Phi_i(X) t_i + \sum_{ib} \Psi_{ib}(X) (Q_i - I) e_b$, where the matrix field $\Phi_i$ extends $I$ on body `i` and 0 on every other
/// boundary, and $\Psi_{ib}$ likewise $I (X - c_i)_b$. The extensions are computed once;
/// a new shape then costs no solve, and a closed stroke returns to exactly the mesh it started from. For
/// [scalar](MeshMotion::is_scalar) motions the matrices are numbers times `I`: one field a body, four if it turns.
///
/// Extensions are piecewise linear on the vertices. Midside nodes in the fluid follow the mean of their edge's
/// ends, nodes on a body move exactly with it, nodes on other boundaries stay.
#[derive(Clone, Debug)]
pub struct ReferenceMap {
    mesh: TetMesh,
    /// Of each body: of its translation and, if it turns, of the three columns of `Q - I`.
    influences: Vec<Vec<Influence>>,
}

/// What every node takes of a vector that a body is moved by.
#[derive(Clone, Debug)]
enum Influence {
    Scalar(Vec<f64>),
    Matrix(Vec<Matrix3<f64>>),
}

impl ReferenceMap {
    /// Computes the extensions of the bodies' motions into `mesh`.
    ///
    /// Cost: one [`MeshMotion::extend`]; of a third of a field a body (four thirds if it turns) for scalar motions, of three (twelve) for others.
    ///
    /// # Errors
    /// A tag that the mesh does not have, or a solve that fails.
    pub fn new(
        mesh: TetMesh,
        bodies: &[MovingBody],
        motion: &dyn MeshMotion,
    ) -> Result<Self, AleError> {
        let on_body = nodes_of(&mesh, bodies)?;
        let prescribed = boundary_vertices(&mesh);
        // One scalar boundary condition an influence: 1 on the body, then the components of its arms.
        let mut conditions: Vec<(usize, Condition)> = Vec::new();
        for (number, body) in bodies.iter().enumerate() {
            conditions.push((number, Condition::One));
            if body.turns {
                conditions.extend((0..3).map(|axis| (number, Condition::Arm(body.centre, axis))));
            }
        }
        // A field carries three conditions of a scalar motion, one in each component; others need a field a component.
        let scalar = motion.is_scalar();
        let places: Vec<(usize, usize, usize)> = (0..conditions.len())
            .flat_map(|k| (0..if scalar { 1 } else { 3 }).map(move |axis| (k, axis)))
            .enumerate()
            .map(|(index, (k, axis))| {
                if scalar {
                    (k, index / 3, index % 3)
                } else {
                    (k, index, axis)
                }
            })
            .collect();
        let n_fields = places.last().map_or(0, |&(_, field, _)| field + 1);
        let mut fields = vec![vec![Vec3::zeros(); mesh.n_vertices()]; n_fields];
        for &(k, field, component) in &places {
            let (body, condition) = &conditions[k];
            for &node in on_body[*body]
                .iter()
                .filter(|&&n| (n as usize) < mesh.n_vertices())
            {
                fields[field][node as usize][component] =
                    condition.at(&mesh.points()[node as usize]);
            }
        }
        let moving = MovingMesh {
            mesh: &mesh,
            space: &TaylorHood::new(&mesh)?,
            prescribed: &prescribed,
        };
        motion.extend(&moving, &mut fields)?;
        let mut influences = vec![Vec::new(); bodies.len()];
        for (k, (body, condition)) in conditions.iter().enumerate() {
            let nodes = on_body[*body].as_slice();
            let value = |node: u32| condition.at(&mesh.points()[node as usize]);
            influences[*body].push(if scalar {
                let (_, field, component) = places[k];
                let share = fields[field].iter().map(|d| d[component]).collect();
                Influence::Scalar(at_all_nodes(&mesh, share, 0.0, &[(nodes, &value)]))
            } else {
                let [x, y, z] = [0, 1, 2].map(|axis| &fields[3 * k + axis]);
                let columns = x.iter().zip(y).zip(z);
                let share = columns.map(|((&x, &y), &z)| Matrix3::from_columns(&[x, y, z]));
                let exact = |node: u32| Matrix3::from_diagonal_element(value(node));
                let all = [(nodes, &exact as &dyn Fn(u32) -> Matrix3<f64>)];
                Influence::Matrix(at_all_nodes(&mesh, share.collect(), Matrix3::zeros(), &all))
            });
        }
        Ok(Self { mesh, influences })
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
        check_count(self.influences.len(), motions)?;
        let mut points = self.mesh.points().to_vec();
        for (motion, influences) in motions.iter().zip(&self.influences) {
            let turn = turn(motion);
            let parts = [motion.translation.vector]
                .into_iter()
                .chain((0..3).map(|axis| turn.column(axis).into_owned()));
            for (influence, part) in influences.iter().zip(parts) {
                influence.add(&part, &mut points);
            }
        }
        Ok(self.mesh.with_points(points)?)
    }
}

/// A scalar condition on a body's surface.
enum Condition {
    One,
    /// A component of the arm from the body's centre.
    Arm(Vec3, usize),
}

impl Condition {
    fn at(&self, x: &Vec3) -> f64 {
        match self {
            Self::One => 1.0,
            Self::Arm(centre, axis) => x[*axis] - centre[*axis],
        }
    }
}

impl Influence {
    fn add(&self, part: &Vec3, points: &mut [Vec3]) {
        match self {
            Self::Scalar(share) => {
                points
                    .iter_mut()
                    .zip(share)
                    .for_each(|(x, &s)| *x += s * part);
            }
            Self::Matrix(share) => {
                points
                    .iter_mut()
                    .zip(share)
                    .for_each(|(x, s)| *x += s * part);
            }
        }
    }
}
