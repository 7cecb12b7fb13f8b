//! VTU files (ParaView's XML unstructured grids) with quadratic cells, and PVD time series of them.

mod base64;
mod pvd;
mod xml;

use std::path::Path;

pub use pvd::Pvd;

use self::xml::{Array, Values};
use super::atomic::write_atomically;
use crate::{MeshError, TET_EDGES, TetMesh};

/// `VTK_QUADRATIC_TRIANGLE` of vtkCellType.h.
const QUADRATIC_TRIANGLE: u8 = 22;
/// `VTK_QUADRATIC_TETRA` of vtkCellType.h.
const QUADRATIC_TETRA: u8 = 24;

/// How a [`Vtu`] holds its numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VtuEncoding {
    /// Raw bytes behind the XML: smallest and fastest, but no XML parser reads it.
    #[default]
    Appended,
    /// Base64 in the XML: a third larger, and proper XML.
    Base64,
}

/// A VTU file in the making: the cells of a mesh, or its boundary facets, and fields over them.
///
/// Cells are `VTK_QUADRATIC_TETRA`, facets `VTK_QUADRATIC_TRIANGLE` with their tag as cell field `tag`; positions and
/// fields are 64-bit, little-endian.
///
/// ```
/// use mesh::{LinearTets, TetMesh, Vtu};
/// let mesh = TetMesh::straight(LinearTets::cube(2))?;
/// let height: Vec<f64> = mesh.points().iter().map(|p| p.z).collect();
/// let file = Vtu::cells(&mesh).point_field("height", 1, &height)?;
/// assert!(file.to_bytes().starts_with(b"<?xml"));
/// # Ok::<(), mesh::MeshError>(())
/// ```
pub struct Vtu<'a> {
    mesh: &'a TetMesh,
    encoding: VtuEncoding,
    /// Mesh nodes that are points of the file, and the file's cells in terms of those.
    nodes: Vec<u32>,
    connectivity: Vec<i64>,
    nodes_per_cell: usize,
    cell_type: u8,
    point_fields: Vec<Array>,
    cell_fields: Vec<Array>,
}

impl<'a> Vtu<'a> {
    /// The cells of the mesh; the points of the file are the points of the mesh.
    pub fn cells(mesh: &'a TetMesh) -> Self {
        Self {
            mesh,
            encoding: VtuEncoding::default(),
            nodes: (0..mesh.n_points() as u32).collect(),
            connectivity: mesh
                .cells()
                .iter()
                .flatten()
                .map(|&node| i64::from(node))
                .collect(),
            nodes_per_cell: 10,
            cell_type: QUADRATIC_TETRA,
            point_fields: Vec::new(),
            cell_fields: Vec::new(),
        }
    }

    /// The boundary facets of the mesh with the nodes on them; fields are given for the whole mesh all the same.
    pub fn boundary(mesh: &'a TetMesh) -> Self {
        let mut nodes: Vec<u32> = mesh.facets().iter().flat_map(|facet| facet.nodes).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut number = vec![0; mesh.n_points()];
        for (i, &node) in nodes.iter().enumerate() {
            number[node as usize] = i as i64;
        }
        let facets = mesh.facets().iter();
        let tags = facets.clone().map(|facet| f64::from(facet.tag)).collect();
        Self {
            mesh,
            encoding: VtuEncoding::default(),
            nodes,
            connectivity: facets
                .flat_map(|facet| facet.nodes)
                .map(|node| number[node as usize])
                .collect(),
            nodes_per_cell: 6,
            cell_type: QUADRATIC_TRIANGLE,
            point_fields: Vec::new(),
            cell_fields: vec![Array::new("tag", 1, Values::Reals(tags))],
        }
    }

    /// Holds the numbers in another way.
    pub fn encoding(mut self, encoding: VtuEncoding) -> Self {
        self.encoding = encoding;
        self
    }

    /// Adds a field over the points (P2): `components` consecutive numbers a point, three for a vector.
    ///
    /// # Errors
    /// [`MeshError::WrongLength`] unless `values` has `components * n_points` entries; [`MeshError::BadValue`] for NaN
    /// and infinity.
    pub fn point_field(
        mut self,
        name: &str,
        components: usize,
        values: &[f64],
    ) -> Result<Self, MeshError> {
        check(name, values, components * self.mesh.n_points())?;
        let rows = self.nodes.iter().map(|&node| node as usize * components);
        let picked = rows
            .flat_map(|row| &values[row..row + components])
            .copied()
            .collect();
        self.point_fields
            .push(Array::new(name, components, Values::Reals(picked)));
        Ok(self)
    }

    /// Adds a scalar field over the vertices (P1, such as the pressure); midside nodes get the mean of their edge's ends.
    ///
    /// # Errors
    /// As [`Vtu::point_field`], for `n_vertices` entries.
    pub fn vertex_field(self, name: &str, values: &[f64]) -> Result<Self, MeshError> {
        check(name, values, self.mesh.n_vertices())?;
        let mut all = values.to_vec();
        all.resize(self.mesh.n_points(), 0.0);
        for cell in self.mesh.cells() {
            for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
                // Halves first: the sum of two large numbers could overflow.
                all[cell[4 + k] as usize] =
                    0.5 * values[cell[i] as usize] + 0.5 * values[cell[j] as usize];
            }
        }
        self.point_field(name, 1, &all)
    }

    /// Adds a field over the cells (of [`Vtu::boundary`]: over the facets), `components` consecutive numbers a cell.
    ///
    /// # Errors
    /// As [`Vtu::point_field`], for `components` entries a cell.
    pub fn cell_field(
        mut self,
        name: &str,
        components: usize,
        values: &[f64],
    ) -> Result<Self, MeshError> {
        check(name, values, components * self.n_cells())?;
        self.cell_fields
            .push(Array::new(name, components, Values::Reals(values.to_vec())));
        Ok(self)
    }

    /// The file's bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let places = self
            .nodes
            .iter()
            .flat_map(|&node| self.mesh.points()[node as usize].into_iter());
        let places = Values::Reals(places.copied().collect());
        let ends = (1..=self.n_cells())
            .map(|i| (i * self.nodes_per_cell) as i64)
            .collect();
        xml::document(&xml::Piece {
            n_points: self.nodes.len(),
            n_cells: self.n_cells(),
            points: &[Array::new("Points", 3, places)],
            cells: &[
                Array::new(
                    "connectivity",
                    1,
                    Values::Integers(self.connectivity.clone()),
                ),
                Array::new("offsets", 1, Values::Integers(ends)),
                Array::new(
                    "types",
                    1,
                    Values::Bytes(vec![self.cell_type; self.n_cells()]),
                ),
            ],
            point_data: &self.point_fields,
            cell_data: &self.cell_fields,
            encoding: self.encoding,
        })
    }

    /// Writes the file: whole, or not at all.
    ///
    /// # Errors
    /// [`MeshError::Io`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), MeshError> {
        let bytes = self.to_bytes();
        write_atomically(path.as_ref(), |out| out.write_all(&bytes))
    }

    fn n_cells(&self) -> usize {
        self.connectivity.len() / self.nodes_per_cell
    }
}

fn check(name: &str, values: &[f64], expected: usize) -> Result<(), MeshError> {
    if values.len() != expected {
        return Err(MeshError::WrongLength {
            what: format!("field '{name}'"),
            expected,
            found: values.len(),
        });
    }
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(MeshError::BadValue {
            what: format!("field '{name}'"),
            index,
            value: values[index],
        }),
        None => Ok(()),
    }
}
