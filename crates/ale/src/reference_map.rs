//! Mesh motion as a map from a reference mesh.
//!
//! The moved mesh depends on the configuration of the bodies, not on their path.

use fem::TaylorHood;
use mesh::{TetMesh, Vec3};
use nalgebra::{Isometry3, Matrix3};

use crate::bodies::{at_all_nodes, boundary_vertices, check_motions, nodes_of, rotation_increment};
use crate::{AleError, MeshMotion, MovingBody, MovingMesh};

/// Precomputed extensions of the rigid motions of all bodies into a reference mesh.
///
/// When body `i` with centre `c_i` is translated by `t_i` and rotated by `Q_i`, a node at `X` has
/// the displacement
///
/// ```text
/// d(X) = sum_i Φ_i(X) t_i + sum_ib Ψ_ib(X) (Q_i - I) e_b
/// ```
///
/// The matrix field `Φ_i` equals `I` on body `i` and `Ψ_ib` equals `(X - c_i)_b I` there; both are
/// zero on all other boundaries. The extensions are computed once. A new configuration then costs
/// no solve, and a closed stroke returns exactly to the initial mesh. For
/// [scalar](MeshMotion::is_scalar) motions the matrices are multiples of `I`: one scalar field per
/// body, four if it rotates.
///
/// Extensions are piecewise linear on the vertices. Midside nodes in the fluid move with the mean
/// of the ends of their edge, nodes on a body move exactly with it, nodes on other boundaries are
/// fixed.
#[derive(Clone, Debug)]
pub struct ReferenceMap {
    mesh: TetMesh,
    iterations: usize,
    /// Per body: the field of its translation and, if it rotates, those of the columns of `Q - I`.
    influences: Vec<Vec<Influence>>,
}

/// The displacement of each node caused by a unit vector of a body's motion.
#[derive(Clone, Debug)]
enum Influence {
    Scalar(Vec<f64>),
    Matrix(Vec<Matrix3<f64>>),
}

impl ReferenceMap {
    /// Computes the extensions of the bodies' motions into `mesh`.
    ///
    /// Cost: one call of [`MeshMotion::extend`]. Scalar motions need a third of a vector field per
    /// body (four thirds if it rotates), others three (twelve).
    ///
    /// # Errors
    /// [`AleError::NoSurface`] for a body's tag that the mesh does not have,
    /// [`AleError::SharedSurface`], a centre that is not finite, or a failure of
    /// [`MeshMotion::extend`].
    pub fn new(
        mesh: TetMesh,
        bodies: &[MovingBody],
        motion: &dyn MeshMotion,
    ) -> Result<Self, AleError> {
        let on_body = nodes_of(&mesh, bodies)?;
        let prescribed = boundary_vertices(&mesh);
        // One scalar boundary condition per influence: 1 on the body, then each component of X - c.
        let mut conditions: Vec<(usize, Condition)> = Vec::new();
        for (number, body) in bodies.iter().enumerate() {
            conditions.push((number, Condition::One));
            if body.rotates {
                conditions.extend((0..3).map(|axis| (number, Condition::Arm(body.centre, axis))));
            }
        }
        // For scalar motions a vector field carries three conditions, one in each component; for
        // others each condition needs three fields.
        let scalar = motion.is_scalar();
        // (condition, field, component)
        let slots: Vec<(usize, usize, usize)> = (0..conditions.len())
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
        let n_fields = slots.last().map_or(0, |&(_, field, _)| field + 1);
        let mut fields = vec![vec![Vec3::zeros(); mesh.n_vertices()]; n_fields];
        for &(k, field, component) in &slots {
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
        let iterations = motion.extend(&moving, &mut fields)?;
        let mut influences = vec![Vec::new(); bodies.len()];
        for (k, (body, condition)) in conditions.iter().enumerate() {
            let nodes = on_body[*body].as_slice();
            let value = |node: u32| condition.at(&mesh.points()[node as usize]);
            influences[*body].push(if scalar {
                let (_, field, component) = slots[k];
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
        Ok(Self {
            mesh,
            iterations,
            influences,
        })
    }

    /// The reference mesh.
    pub fn reference(&self) -> &TetMesh {
        &self.mesh
    }

    /// Number of iterations that the extensions took, zero for direct methods.
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    /// The mesh after body `i` has moved by `motions[i]` from the reference mesh.
    ///
    /// The translation moves the body's centre; the rotation is about that centre.
    ///
    /// # Errors
    /// [`AleError::Motions`], [`AleError::NotFinite`] and [`AleError::NotRotation`] for motions
    /// that do not fit; [`AleError::Invalid`] if an element, straight or curved, is inverted:
    /// remesh in this case.
    pub fn moved(&self, motions: &[Isometry3<f64>]) -> Result<TetMesh, AleError> {
        check_motions(self.influences.len(), motions)?;
        let mut points = self.mesh.points().to_vec();
        for (motion, influences) in motions.iter().zip(&self.influences) {
            let increment = rotation_increment(motion);
            let vectors = [motion.translation.vector]
                .into_iter()
                .chain((0..3).map(|axis| increment.column(axis).into_owned()));
            for (influence, vector) in influences.iter().zip(vectors) {
                influence.add(&vector, &mut points);
            }
        }
        Ok(self.mesh.with_points(points)?)
    }
}

/// A scalar boundary condition on a body's surface.
enum Condition {
    /// The constant 1.
    One,
    /// A component of the vector from the body's centre.
    Arm(Vec3, usize),
}

impl Condition {
    /// The prescribed value at `x`.
    fn at(&self, x: &Vec3) -> f64 {
        match self {
            Self::One => 1.0,
            Self::Arm(centre, axis) => x[*axis] - centre[*axis],
        }
    }
}

impl Influence {
    /// Adds the displacement caused by `vector` to all points.
    fn add(&self, vector: &Vec3, points: &mut [Vec3]) {
        match self {
            Self::Scalar(share) => {
                points
                    .iter_mut()
                    .zip(share)
                    .for_each(|(x, &s)| *x += s * vector);
            }
            Self::Matrix(share) => {
                points
                    .iter_mut()
                    .zip(share)
                    .for_each(|(x, s)| *x += s * vector);
            }
        }
    }
}
