//! Bodies that move a mesh, and what their motion is on its boundary.

use mesh::{TET_EDGES, TetMesh, Vec3};
use nalgebra::{Isometry3, Matrix3};

use crate::AleError;

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

/// The nodes on each body's surface.
pub(crate) fn nodes_of(mesh: &TetMesh, bodies: &[MovingBody]) -> Result<Vec<Vec<u32>>, AleError> {
    bodies
        .iter()
        .map(|body| Ok(mesh.nodes_on(mesh.tag(&body.tag)?)))
        .collect()
}

/// Whether each vertex is on some boundary that is no mirror plane: on planes vertices follow, and stay in them if all bodies move along them.
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

/// An error unless there is one motion a body.
pub(crate) fn check_count(expected: usize, motions: &[Isometry3<f64>]) -> Result<(), AleError> {
    match motions.len() {
        found if found == expected => Ok(()),
        found => Err(AleError::Motions { expected, found }),
    }
}

/// `Q - I` of a motion.
pub(crate) fn turn(motion: &Isometry3<f64>) -> Matrix3<f64> {
    motion.rotation.to_rotation_matrix().into_inner() - Matrix3::identity()
}

/// Nodes on a body and the field there.
pub(crate) type OnBody<'a, T> = (&'a [u32], &'a dyn Fn(u32) -> T);

/// A field at the vertices continued to all nodes: midside nodes take the mean of their edge's ends, boundary nodes what `boundary` says:
/// one list of nodes with a function a part; on parts not listed the field is zero.
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
