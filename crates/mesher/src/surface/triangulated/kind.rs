//! Smooth and faceted triangulations.

/// How the triangles of a surface are understood.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TriangleKind {
    /// The surface is curved through the vertices: between them it follows the normals that the
    /// triangles give. Edges at which the normals differ by more than 40 degrees are kept sharp.
    #[default]
    Smooth,
    /// The triangles are flat faces. Edges at which the normals differ by more than 5 degrees are
    /// kept; across others, midside nodes lie on the faces and edges of the mesh need not be
    /// theirs.
    Faceted,
}

impl TriangleKind {
    /// Angle between normals above which an edge is sharp, in degrees.
    ///
    /// Forty degrees is between the 30 degrees of coarse, but usable triangulations (twelve
    /// segments around a tube) and the 45 degrees of a chamfer.
    pub(super) fn sharp_angle(self) -> f64 {
        match self {
            Self::Smooth => 40.0,
            Self::Faceted => 5.0,
        }
    }
}
