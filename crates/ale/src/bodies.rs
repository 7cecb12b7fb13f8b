//! Moving bodies and the displacement of the mesh boundary that they prescribe.

use mesh::{TET_EDGES, TetMesh, Vec3};
use nalgebra::{Isometry3, Matrix3};

use crate::AleError;

/// A rigid body whose surface is part of the mesh boundary and moves.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingBody {
    /// Boundary tag of its surface.
    pub tag: String,
    /// Its centre in the reference mesh.
    pub centre: Vec3,
    /// Whether the nodes on its surface rotate with it.
    ///
    /// A sphere does not need this: its surface does not change when the sphere rotates.
    pub rotates: bool,
}

/// The nodes on the surface of each body.
///
/// # Errors
/// [`AleError::NoSurface`], [`AleError::SharedSurface`], [`AleError::NotFinite`] for a centre.
pub(crate) fn nodes_of(mesh: &TetMesh, bodies: &[MovingBody]) -> Result<Vec<Vec<u32>>, AleError> {
    let nodes = |(index, body): (usize, &MovingBody)| {
        if bodies[..index].iter().any(|other| other.tag == body.tag) {
            let tag = body.tag.clone();
            return Err(AleError::SharedSurface { tag });
        }
        if !body.centre.iter().all(|component| component.is_finite()) {
            let what = "the centre of body";
            return Err(AleError::NotFinite { what, index });
        }
        Ok(mesh.nodes_on(mesh.tag(&body.tag).map_err(AleError::NoSurface)?))
    };
    bodies.iter().enumerate().map(nodes).collect()
}

/// Whether each vertex is on a boundary other than a symmetry plane.
///
/// Vertices on symmetry planes are free. They stay in the plane if all bodies move parallel to it.
pub(crate) fn boundary_vertices(mesh: &TetMesh) -> Vec<bool> {
    let mut on_boundary = vec![false; mesh.n_vertices()];
    for facet in mesh
        .facets()
        .iter()
        .filter(|f| !mesh.is_symmetry_plane(f.tag))
    {
        facet.nodes[..3]
            .iter()
            .for_each(|&vertex| on_boundary[vertex as usize] = true);
    }
    on_boundary
}

/// Largest difference from 1 of the length of a quaternion that counts as a rotation.
///
/// A text file with seven digits reaches 1e-7; the surface of a body then changes its size by less
/// than any mesh resolves.
const MAX_NORM_ERROR: f64 = 1e-6;

/// Refuses motions unless there is one rigid motion per body.
///
/// # Errors
/// [`AleError::Motions`], [`AleError::NotFinite`], [`AleError::NotRotation`].
pub(crate) fn check_motions(expected: usize, motions: &[Isometry3<f64>]) -> Result<(), AleError> {
    let found = motions.len();
    if found != expected {
        return Err(AleError::Motions { expected, found });
    }
    for (index, motion) in motions.iter().enumerate() {
        if !motion.translation.vector.iter().all(|x| x.is_finite()) {
            let what = "the translation of body";
            return Err(AleError::NotFinite { what, index });
        }
        let length = motion.rotation.norm();
        if length.is_nan() || (length - 1.0).abs() > MAX_NORM_ERROR {
            return Err(AleError::NotRotation {
                body: index,
                length,
            });
        }
    }
    Ok(())
}

/// Refuses twists unless there is one finite twist per body.
///
/// # Errors
/// [`AleError::Twists`], [`AleError::NotFinite`].
pub(crate) fn check_twists(expected: usize, twists: &[[Vec3; 2]]) -> Result<(), AleError> {
    let found = twists.len();
    if found != expected {
        return Err(AleError::Twists { expected, found });
    }
    let is_finite = |twist: &[Vec3; 2]| twist.iter().flatten().all(|x| x.is_finite());
    match twists.iter().position(|twist| !is_finite(twist)) {
        Some(index) => Err(AleError::NotFinite {
            what: "the twist of body",
            index,
        }),
        None => Ok(()),
    }
}

/// `Q - I` for the rotation `Q` of a motion: `2 (w [v]× + [v]×²)` with the quaternion `(w, v)`.
///
/// The difference of the matrices would have rounding errors along the axis, which take nodes off
/// symmetry planes.
pub(crate) fn rotation_increment(motion: &Isometry3<f64>) -> Matrix3<f64> {
    let cross = motion.rotation.imag().cross_matrix();
    2.0 * (motion.rotation.w * cross + cross * cross)
}

/// Nodes on a body and the values of a field there.
pub(crate) type OnBody<'a, T> = (&'a [u32], &'a dyn Fn(u32) -> T);

/// Extends a field from the vertices to all nodes.
///
/// Midside nodes in the fluid get the mean of the ends of their edge; nodes of bodies get the
/// values in `on_bodies`; midside nodes of other boundaries get zero.
pub(crate) fn at_all_nodes<T>(
    mesh: &TetMesh,
    mut field: Vec<T>,
    zero: T,
    on_bodies: &[OnBody<'_, T>],
) -> Vec<T>
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>,
{
    field.resize(mesh.n_points(), zero);
    for cell in mesh.cells() {
        for (&middle, [a, b]) in cell[4..].iter().zip(TET_EDGES) {
            field[middle as usize] = (field[cell[a] as usize] + field[cell[b] as usize]) * 0.5;
        }
    }
    for facet in mesh
        .facets()
        .iter()
        .filter(|f| !mesh.is_symmetry_plane(f.tag))
    {
        facet.nodes[3..]
            .iter()
            .for_each(|&node| field[node as usize] = zero);
    }
    for (nodes, value) in on_bodies {
        nodes
            .iter()
            .for_each(|&node| field[node as usize] = value(node));
    }
    field
}
