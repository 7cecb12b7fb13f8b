//! Points, tets and tagged faces as plain arrays, and the local numbering of a tet.

use std::collections::BTreeSet;

use nalgebra::Vector3;

/// A point or a displacement in space.
pub type Vec3 = Vector3<f64>;

/// Local vertex pairs whose midside nodes are local nodes 4..10 (VTK order of
/// `VTK_QUADRATIC_TETRA`).
pub const TET_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// Local vertices of face `i`, opposite vertex `i`; in a positively oriented tet the normal points
/// outwards.
pub(crate) const TET_FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Named parts of a mesh's volume, such as two fluids or a porous layer.
///
/// Most meshes have one region and name none: both lists are then empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Regions {
    /// Names of the regions.
    pub names: Vec<String>,
    /// For each cell, the index of its region's name.
    pub of_cells: Vec<u16>,
}

impl Regions {
    /// Whether no region is named.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }
}

/// Vertices, tets and tagged boundary triangles.
///
/// [`TetMesh::straight`](crate::TetMesh::straight) and [`TetMesh::curved`](crate::TetMesh::curved)
/// turn it into a mesh with midside nodes.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LinearTets {
    /// Vertices.
    pub points: Vec<Vec3>,
    /// Tets, positively oriented: `det(x1 - x0, x2 - x0, x3 - x0) > 0`.
    pub tets: Vec<[u32; 4]>,
    /// Boundary triangles, normal out of the fluid, with the index of their tag.
    pub faces: Vec<([u32; 3], u16)>,
    /// Names of the boundary parts.
    pub tags: Vec<String>,
    /// Named parts of the volume.
    pub regions: Regions,
}

/// Largest number of cubes along a side of [`LinearTets::cube`].
///
/// `6 n^3` is then at most 2^28, the largest number of cells that `fem` numbers.
const MOST_CUBES: u32 = 354;

impl LinearTets {
    /// The unit cube divided into `n^3` cubes of six tets each (Kuhn 1960).
    ///
    /// It has `(n + 1)^3` vertices, `6 n^3` tets and `12 n^2` boundary faces, with sides tagged
    /// `x0 x1 y0 y1 z0 z1`: a mesh for tests of exactness. `n = 0` counts as 1. For `n` above 354,
    /// with more than 2^28 tets, it has no tets, and no mesh can be made of it.
    ///
    /// ```
    /// let cube = mesh::LinearTets::cube(2);
    /// assert_eq!((cube.points.len(), cube.tets.len(), cube.faces.len()), (27, 48, 48));
    /// ```
    pub fn cube(n: u32) -> Self {
        if n > MOST_CUBES {
            return Self::default();
        }
        let n = n.max(1);
        let vertex = |[i, j, k]: [u32; 3]| (i * (n + 1) + j) * (n + 1) + k;
        let grid = |end: u32| {
            (0..end).flat_map(move |i| (0..end).flat_map(move |j| (0..end).map(move |k| [i, j, k])))
        };
        // Each tet follows a path from corner (0,0,0) to (1,1,1) along the axes in one order; for
        // odd permutations the orientation is reversed.
        const PATHS: [([usize; 3], bool); 6] = [
            ([0, 1, 2], false),
            ([1, 2, 0], false),
            ([2, 0, 1], false),
            ([0, 2, 1], true),
            ([1, 0, 2], true),
            ([2, 1, 0], true),
        ];
        let mut tets = Vec::new();
        for corner in grid(n) {
            for (path, is_odd) in PATHS {
                let mut at = corner;
                let [a, b, c, d] =
                    [None, Some(path[0]), Some(path[1]), Some(path[2])].map(|axis| {
                        if let Some(axis) = axis {
                            at[axis] += 1;
                        }
                        vertex(at)
                    });
                tets.push(if is_odd { [a, c, b, d] } else { [a, b, c, d] });
            }
        }
        let mut faces = Vec::new();
        for axis in 0..3 {
            for side in [0, 1] {
                for [_, j, k] in grid(n).filter(|at| at[0] == 0) {
                    let corner = |u: u32, v: u32| {
                        let mut at = [0; 3];
                        at[axis] = side * n;
                        at[(axis + 1) % 3] = j + u;
                        at[(axis + 2) % 3] = k + v;
                        vertex(at)
                    };
                    // Each square is divided along the diagonal from its lowest to its highest
                    // corner, as the faces of the tets are.
                    let tag = 2 * axis as u16 + side as u16;
                    for [a, b, c] in [
                        [corner(0, 0), corner(1, 0), corner(1, 1)],
                        [corner(0, 0), corner(1, 1), corner(0, 1)],
                    ] {
                        faces.push((if side == 1 { [a, b, c] } else { [a, c, b] }, tag));
                    }
                }
            }
        }
        let h = 1.0 / f64::from(n);
        Self {
            points: grid(n + 1)
                .map(|at| Vec3::from(at.map(f64::from)) * h)
                .collect(),
            tets,
            faces,
            tags: ["x0", "x1", "y0", "y1", "z0", "z1"]
                .map(String::from)
                .into(),
            regions: Regions::default(),
        }
    }

    /// The mesh without the tets whose centroid `is_removed`, with the tag `tag` on the faces of
    /// the cavity: a body cut out of the fluid.
    ///
    /// Removed tets at the boundary take their faces with them, and points that no tet uses are
    /// dropped. Cost: O(n log n).
    ///
    /// ```
    /// use mesh::{LinearTets, TetMesh, Vec3};
    /// // a cube of side 1/2 in the unit cube
    /// let middle = Vec3::repeat(0.5);
    /// let tets = LinearTets::cube(4).without_tets("body", |x| (x - middle).amax() < 0.25);
    /// let mesh = TetMesh::straight(tets)?;
    /// assert_eq!((mesh.n_cells(), mesh.facets().len()), (6 * (64 - 8), 12 * (16 + 4)));
    /// assert!((mesh.volume() - 0.875).abs() < 1e-14);
    /// # Ok::<(), mesh::MeshError>(())
    /// ```
    #[must_use]
    pub fn without_tets(mut self, tag: &str, is_removed: impl Fn(&Vec3) -> bool) -> Self {
        let centroid = |tet: &[u32; 4]| {
            let sum: Vec3 = tet.iter().map(|&v| self.points[v as usize]).sum();
            sum / 4.0
        };
        let removed: Vec<bool> = self.tets.iter().map(|t| is_removed(&centroid(t))).collect();
        let sorted = |mut face: [u32; 3]| {
            face.sort_unstable();
            face
        };
        let faces = |tet: [u32; 4]| TET_FACES.map(|face| face.map(|corner| tet[corner]));
        let of = |is_wanted: bool| {
            let tets = self.tets.iter().zip(&removed);
            tets.filter(move |(_, is_removed)| **is_removed == is_wanted)
                .flat_map(move |(&tet, _)| faces(tet))
        };
        let of_removed: BTreeSet<[u32; 3]> = of(true).map(sorted).collect();
        let is_of_removed = |face: &[u32; 3]| of_removed.contains(&sorted(*face));
        // A face of a kept and of a removed tet.
        let cut: Vec<[u32; 3]> = of(false).filter(is_of_removed).collect();
        self.faces
            .retain(|(face, _)| !of_removed.contains(&sorted(*face)));
        let known = self.tags.iter().position(|name| name == tag);
        let number = known.unwrap_or(self.tags.len()) as u16;
        if known.is_none() {
            self.tags.push(tag.to_owned());
        }
        self.faces
            .extend(cut.into_iter().map(|face| (face, number)));
        let mut kept = removed.iter().map(|is_removed| !is_removed);
        self.tets.retain(|_| kept.next().unwrap_or(true));
        let mut kept = removed.iter().map(|is_removed| !is_removed);
        self.regions
            .of_cells
            .retain(|_| kept.next().unwrap_or(true));
        let (points, number) = used_points(&self.points, self.tets.as_flattened().iter().copied());
        self.points = points;
        let renumber = |vertex: &mut u32| *vertex = number[*vertex as usize];
        self.tets.as_flattened_mut().iter_mut().for_each(renumber);
        (self.faces.iter_mut()).for_each(|(face, _)| face.iter_mut().for_each(renumber));
        self
    }
}

/// The points that are `used`, in their order, and the new number of each; `u32::MAX` for others.
///
/// # Panics
/// If a used point does not exist.
pub fn used_points(points: &[Vec3], used: impl IntoIterator<Item = u32>) -> (Vec<Vec3>, Vec<u32>) {
    let mut numbers = vec![u32::MAX; points.len()];
    used.into_iter().for_each(|v| numbers[v as usize] = 0);
    let mut kept = Vec::new();
    for (number, point) in numbers.iter_mut().zip(points) {
        if *number == 0 {
            *number = kept.len() as u32;
            kept.push(*point);
        }
    }
    (kept, numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_of_the_reference_tet_point_outwards() {
        let x = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        for (opposite, face) in TET_FACES.iter().enumerate() {
            let [a, b, c] = face.map(|i| x[i]);
            assert!((b - a).cross(&(c - a)).dot(&(x[opposite] - a)) < 0.0);
        }
    }
}
