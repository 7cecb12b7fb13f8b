//! Named parts of the volume.

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
