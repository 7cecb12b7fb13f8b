//! Parameters of mesh generation.

/// Parameters of mesh generation: grading of the edge lengths, symmetry planes, effort.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GenerateParams {
    /// Growth of the edge length per unit of distance from the nearest body, above 0 and at most
    /// 0.6.
    ///
    /// Vertices and mean quality for three spheres of size 0.3 in a ball of radius 40: 0.2: 12147,
    /// 0.901; 0.25: 7775, 0.896; 0.3: 5256, 0.889; 0.35: 3804, 0.879; 0.4: 2819, 0.866;
    /// 0.5: 1900, 0.833.
    pub growth: f64,
    /// Largest ratio of the edge length in a gap to the sum of the distances from its two surfaces.
    ///
    /// 0.6 puts one layer of vertices into the middle of a gap, with regular tets on both sides,
    /// whose height is 0.816 edges. From 0.83 on, tets extend from surface to surface: their
    /// velocities are those of the bodies, and their angles cannot be improved.
    pub gap: f64,
    /// Longest edge anywhere.
    pub max_size: f64,
    /// Smallest allowed distance between bodies and to the wall, as a fraction of the (smaller)
    /// radius.
    ///
    /// The edges in a gap are about as long as its width, and the number of triangles around it
    /// grows inversely with the width.
    pub min_gap: f64,
    /// The axes whose coordinate planes are symmetry planes.
    ///
    /// Only the part of the fluid with positive coordinates is meshed.
    ///
    /// The container must be symmetric about each plane, and every body too unless it lies on the
    /// positive side. The faces on the planes are
    /// tagged [`SYMMETRY_PLANE_TAGS`](mesh::SYMMETRY_PLANE_TAGS), and
    /// [`TetMesh::unfolded`](mesh::TetMesh::unfolded) returns the whole mesh. Spheres are then
    /// triangulated from the octahedron, whose triangles do not cross the planes.
    pub symmetry_planes: [bool; 3],
    /// Number of smoothing sweeps.
    ///
    /// In the example of [`growth`](Self::growth) the mean quality after 4, 6, 8, 10, 20 sweeps is
    /// 0.856, 0.880, 0.885, 0.889, 0.891. With fewer sweeps hill climbing takes longer.
    pub sweeps: usize,
    /// Target of the worst dihedral angle, in degrees.
    ///
    /// Single vertices move until all angles are between `target_dihedral` and 180 minus
    /// `target_dihedral`, or no longer improve.
    pub target_dihedral: f64,
    /// Largest number of vertices; generation fails if more are needed.
    pub max_vertices: usize,
}

impl Default for GenerateParams {
    fn default() -> Self {
        GenerateParams {
            growth: 0.3,
            gap: 0.6,
            max_size: f64::INFINITY,
            min_gap: 1e-3,
            symmetry_planes: [false; 3],
            sweeps: 10,
            target_dihedral: 22.0,
            max_vertices: 4_000_000,
        }
    }
}
