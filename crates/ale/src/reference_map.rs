//! Mesh motion as a map from a reference mesh.
//!
//! The moved mesh depends on the configuration of the bodies, not on their path.

use std::sync::Arc;

use fem::TaylorHood;
use mesh::{TetMesh, Vec3};
use nalgebra::{Isometry3, Matrix3};

use crate::bodies::{
    at_all_nodes, boundary_vertices, check_motions, check_twists, nodes_of, rotation_increment,
};
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
///
/// [`MeshMotion`] itself is linear in the boundary displacement: extended velocities of the
/// boundary are the velocities of a mesh that is moved step by step.
#[derive(Clone, Debug)]
pub struct ReferenceMap {
    mesh: Arc<TetMesh>,
    iterations: usize,
    /// Per body: the field of its translation and, if it rotates, those of the columns of `Q - I`.
    influences: Vec<Vec<Influence>>,
    /// Nodes on the surface of each body.
    on_body: Vec<Vec<u32>>,
}

/// Displacement of the surface of a body relative to its rigid motion, at a point of the reference
/// mesh.
///
/// It is evaluated at all vertices: away from the surface at any smooth continuation.
pub type SurfaceDisplacement<'a> = dyn Fn(&Vec3) -> Vec3 + 'a;

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
        mesh: impl Into<Arc<TetMesh>>,
        bodies: &[MovingBody],
        motion: &dyn MeshMotion,
    ) -> Result<Self, AleError> {
        let mesh = mesh.into();
        let space = TaylorHood::new(&mesh)?;
        Self::with_space(mesh, &space, bodies, motion)
    }

    /// As [`new`](Self::new), with the space on the cells of the mesh, which takes time and memory.
    ///
    /// # Errors
    /// As [`new`](Self::new); a space of other cells.
    pub fn with_space(
        mesh: Arc<TetMesh>,
        space: &TaylorHood,
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
            space,
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
            on_body,
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
        let rigid = vec![None; self.influences.len()];
        self.moved_and_deformed(motions, &rigid)
    }

    /// As [`moved`](Self::moved), with bodies whose surfaces are displaced in addition.
    ///
    /// The displacement `s_i` of the surface of body `i` along the axes of the laboratory, after
    /// the rigid motion, adds `Φ_i(X) s_i(X)` at the vertices. Nodes on the body move by `s_i`
    /// exactly, so that they are on its true surface; `None` stands for a rigid body. Cost: one
    /// evaluation per vertex and body that deforms.
    ///
    /// # Errors
    /// As [`moved`](Self::moved); [`AleError::NotFinite`] for a displacement.
    pub fn moved_and_deformed(
        &self,
        motions: &[Isometry3<f64>],
        displacements: &[Option<&SurfaceDisplacement<'_>>],
    ) -> Result<TetMesh, AleError> {
        check_motions(self.influences.len(), motions)?;
        if displacements.len() != motions.len() {
            return Err(AleError::Length {
                what: "displacements of surfaces",
                expected: motions.len(),
                found: displacements.len(),
            });
        }
        let mut points = self.mesh.points().to_vec();
        self.add(&mut points, |body| {
            let motion = &motions[body];
            (motion.translation.vector, rotation_increment(motion))
        });
        for (body, displacement) in displacements.iter().enumerate() {
            if let Some(displacement) = displacement {
                self.add_displacement(&mut points, body, displacement)?;
            }
        }
        Ok(self.mesh.with_points(points)?)
    }

    /// Adds the displacement of the surface of a body, extended into the mesh.
    fn add_displacement(
        &self,
        points: &mut [Vec3],
        body: usize,
        displacement: &SurfaceDisplacement<'_>,
    ) -> Result<(), AleError> {
        let (mesh, nodes) = (&self.mesh, &self.on_body[body]);
        let Some(influence) = self.influences[body].first() else {
            return Ok(());
        };
        let vertices = mesh.points()[..mesh.n_vertices()].iter().enumerate();
        let field = vertices.map(|(vertex, x)| influence.at(vertex, &displacement(x)));
        let exact = |node: u32| displacement(&mesh.points()[node as usize]);
        let all = [(nodes.as_slice(), &exact as &dyn Fn(u32) -> Vec3)];
        let field = at_all_nodes(mesh, field.collect(), Vec3::zeros(), &all);
        if field
            .iter()
            .flatten()
            .any(|component| !component.is_finite())
        {
            let what = "the displacement of the surface of body";
            return Err(AleError::NotFinite { what, index: body });
        }
        points.iter_mut().zip(field).for_each(|(x, d)| *x += d);
        Ok(())
    }

    /// Velocity of each node of the mesh [`moved`](Self::moved) by `motions` while the bodies move.
    ///
    /// The exact derivative of the map. For body `i` with the velocity `U_i` of its centre and the
    /// angular velocity `ω_i`, both along the axes of the laboratory:
    ///
    /// ```text
    /// w(X) = sum_i Φ_i(X) U_i + sum_ib Ψ_ib(X) ω_i × Q_i e_b
    /// ```
    ///
    /// Shapes: one motion and one twist `[U_i, ω_i]` per body, one vector per node. Nodes on a body
    /// move rigidly with it, `U_i + ω_i × (x - c_i - t_i)`; on a body that does not
    /// [rotate](MovingBody::rotates) they have the velocity `U_i`. Nodes on other boundaries are at
    /// rest. Linear in the twists. Cost: one pass over the nodes per field.
    ///
    /// ```
    /// use ale::{Harmonic, MovingBody, ReferenceMap, Stiffening};
    /// use mesh::{LinearTets, TetMesh, Vec3};
    /// use nalgebra::Isometry3;
    /// // The side x = 1 of a cube moves; the other sides are at rest.
    /// let mesh = TetMesh::straight(LinearTets::cube(4))?;
    /// let side = MovingBody { tag: "x1".into(), centre: Vec3::x(), rotates: true };
    /// let map = ReferenceMap::new(mesh, &[side], &Harmonic(Stiffening::None))?;
    /// let motion = Isometry3::translation(0.1, 0.0, 0.0);
    /// let velocities = map.velocity(&[motion], &[[Vec3::y(), Vec3::x()]])?;
    /// let moved = map.moved(&[motion])?;
    /// for node in moved.nodes_on(moved.tag("x1")?) {
    ///     let x = moved.points()[node as usize];
    ///     let rigid = Vec3::y() + Vec3::x().cross(&(x - Vec3::new(1.1, 0.0, 0.0)));
    ///     assert!((velocities[node as usize] - rigid).norm() < 1e-14);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`moved`](Self::moved) for the motions, which need not leave a valid mesh;
    /// [`AleError::Twists`], [`AleError::NotFinite`] for the twists.
    pub fn velocity(
        &self,
        motions: &[Isometry3<f64>],
        twists: &[[Vec3; 2]],
    ) -> Result<Vec<Vec3>, AleError> {
        check_motions(self.influences.len(), motions)?;
        check_twists(self.influences.len(), twists)?;
        let mut velocities = vec![Vec3::zeros(); self.mesh.n_points()];
        self.add(&mut velocities, |body| {
            let [velocity, angular_velocity] = twists[body];
            let rotation = motions[body].rotation.to_rotation_matrix();
            let of_axes = angular_velocity.cross_matrix() * rotation.matrix();
            (velocity, of_axes)
        });
        Ok(velocities)
    }

    /// Adds the fields of all bodies for their vectors: that of the translation, and those of the
    /// three axes as the columns of a matrix.
    fn add(&self, points: &mut [Vec3], vectors: impl Fn(usize) -> (Vec3, Matrix3<f64>)) {
        for (body, influences) in self.influences.iter().enumerate() {
            let (translation, of_axes) = vectors(body);
            let vectors = [translation]
                .into_iter()
                .chain((0..3).map(|axis| of_axes.column(axis).into_owned()));
            for (influence, vector) in influences.iter().zip(vectors) {
                influence.add(&vector, points);
            }
        }
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
    /// The displacement of a node caused by `vector`.
    fn at(&self, node: usize, vector: &Vec3) -> Vec3 {
        match self {
            Self::Scalar(share) => share[node] * vector,
            Self::Matrix(share) => share[node] * vector,
        }
    }

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
