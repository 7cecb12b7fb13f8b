//! VTU files (ParaView's XML unstructured grids) with quadratic cells, and PVD time series of them.

mod xml;

use std::path::Path;

use super::atomic_file::write_file;
use crate::{MeshError, TET_EDGES, TetMesh};
pub use xml::VtuEncoding;
use xml::{Array, Piece, Values, document, escape};

/// `VTK_QUADRATIC_TRIANGLE` of vtkCellType.h.
const QUADRATIC_TRIANGLE: u8 = 22;
/// `VTK_QUADRATIC_TETRA` of vtkCellType.h.
const QUADRATIC_TETRA: u8 = 24;

/// Builder of a VTU file: the cells of a mesh, or its boundary facets, with fields on them.
///
/// Cells are `VTK_QUADRATIC_TETRA`, facets `VTK_QUADRATIC_TRIANGLE` with their tag as cell field
/// `tag`. Positions and fields are 64-bit and little-endian.
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
    /// Mesh nodes that are points of the file.
    nodes: Vec<u32>,
    /// Points of each cell of the file, as indices into `nodes`.
    connectivity: Vec<i64>,
    nodes_per_cell: usize,
    cell_type: u8,
    point_fields: Vec<Array>,
    cell_fields: Vec<Array>,
    file_fields: Vec<Array>,
}

impl<'a> Vtu<'a> {
    /// File with the cells of the mesh; the points of the file are the nodes of the mesh.
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
            file_fields: Vec::new(),
        }
    }

    /// File with the boundary facets of the mesh and the nodes on them.
    ///
    /// Point and vertex fields are still given on all nodes or vertices of the mesh.
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
            file_fields: Vec::new(),
        }
    }

    /// Sets the encoding of the numbers.
    #[must_use]
    pub fn with_encoding(mut self, encoding: VtuEncoding) -> Self {
        self.encoding = encoding;
        self
    }

    /// Adds a field on the nodes (P2): `components` consecutive numbers per node, three for a
    /// vector.
    ///
    /// # Errors
    /// [`MeshError::BadParameter`] for zero components, [`MeshError::WrongLength`] unless `values`
    /// has `components * n_points` entries;
    /// [`MeshError::BadValue`] for NaN and infinity; [`MeshError::DuplicateField`] if another field
    /// on the nodes or vertices has the same name.
    pub fn point_field(
        mut self,
        name: &str,
        components: usize,
        values: &[f64],
    ) -> Result<Self, MeshError> {
        check(name, values, components, self.mesh.n_points())?;
        check_name(name, &self.point_fields)?;
        let rows = self.nodes.iter().map(|&node| node as usize * components);
        let picked = rows
            .flat_map(|row| &values[row..row + components])
            .copied()
            .collect();
        self.point_fields
            .push(Array::new(name, components, Values::Reals(picked)));
        Ok(self)
    }

    /// Adds a field on the vertices (P1, such as the pressure): `components` consecutive numbers
    /// per vertex.
    ///
    /// Midside nodes get the mean of the two ends of their edge.
    ///
    /// # Errors
    /// As [`Vtu::point_field`], for `components * n_vertices` entries.
    pub fn vertex_field(
        self,
        name: &str,
        components: usize,
        values: &[f64],
    ) -> Result<Self, MeshError> {
        check(name, values, components, self.mesh.n_vertices())?;
        let mut all = values.to_vec();
        all.resize(components * self.mesh.n_points(), 0.0);
        for cell in self.mesh.cells() {
            let nodes = cell.map(|node| node as usize * components);
            for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
                for c in 0..components {
                    // Halves first: the sum of two large numbers could overflow.
                    all[nodes[4 + k] + c] = 0.5 * values[nodes[i] + c] + 0.5 * values[nodes[j] + c];
                }
            }
        }
        self.point_field(name, components, &all)
    }

    /// Adds a field on the cells of the file: `components` consecutive numbers per cell.
    ///
    /// The cells of [`Vtu::boundary`] are the facets of the mesh.
    ///
    /// # Errors
    /// As [`Vtu::point_field`], for `components` entries per cell and among the fields on the
    /// cells.
    pub fn cell_field(
        mut self,
        name: &str,
        components: usize,
        values: &[f64],
    ) -> Result<Self, MeshError> {
        check(name, values, components, self.n_cells())?;
        check_name(name, &self.cell_fields)?;
        self.cell_fields
            .push(Array::new(name, components, Values::Reals(values.to_vec())));
        Ok(self)
    }

    /// Adds numbers that belong to the whole file, `components` consecutive ones per row.
    ///
    /// ParaView shows them as field data.
    ///
    /// # Errors
    /// As [`Vtu::point_field`], for whole rows and among the fields of this kind.
    pub fn file_field(
        mut self,
        name: &str,
        components: usize,
        values: &[f64],
    ) -> Result<Self, MeshError> {
        check(name, values, components, values.len() / components.max(1))?;
        check_name(name, &self.file_fields)?;
        self.file_fields
            .push(Array::new(name, components, Values::Reals(values.to_vec())));
        Ok(self)
    }

    /// Contents of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let places = self
            .nodes
            .iter()
            .flat_map(|&node| self.mesh.points()[node as usize].into_iter());
        let places = Values::Reals(places.copied().collect());
        let ends = (1..=self.n_cells())
            .map(|i| (i * self.nodes_per_cell) as i64)
            .collect();
        document(&Piece {
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
            file_data: &self.file_fields,
            encoding: self.encoding,
        })
    }

    /// Writes the file; it is complete or absent, never half written.
    ///
    /// # Errors
    /// [`MeshError::Io`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), MeshError> {
        let bytes = self.to_bytes();
        write_file(path.as_ref(), |out| out.write_all(&bytes))
    }

    fn n_cells(&self) -> usize {
        self.connectivity.len() / self.nodes_per_cell
    }
}

/// Checks the number of components and the length of a field, and that its values are finite.
fn check(name: &str, values: &[f64], components: usize, items: usize) -> Result<(), MeshError> {
    if components == 0 {
        return Err(MeshError::BadParameter {
            what: format!("number of components of field '{name}'"),
            value: 0.0,
            requirement: "it must be at least one",
        });
    }
    let expected = components.saturating_mul(items);
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

/// Checks that no field in `others` has this name.
fn check_name(name: &str, others: &[Array]) -> Result<(), MeshError> {
    if others.iter().any(|other| other.name() == name) {
        return Err(MeshError::DuplicateField { name: name.into() });
    }
    Ok(())
}

/// A time series for ParaView: times and the names of their files, relative to the PVD file.
///
/// Write it again after each step: the file on disk is complete at any time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pvd {
    frames: Vec<(f64, String)>,
}

impl Pvd {
    /// Series without frames.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the file of one time.
    pub fn push(&mut self, time: f64, file: impl Into<String>) {
        self.frames.push((time, file.into()));
    }

    /// The times and their files.
    pub fn frames(&self) -> &[(f64, String)] {
        &self.frames
    }

    /// Writes the file; it is complete or absent, never half written.
    ///
    /// # Errors
    /// [`MeshError::BadValue`] for a time that is NaN or infinite, [`MeshError::Io`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), MeshError> {
        if let Some(index) = self.frames.iter().position(|frame| !frame.0.is_finite()) {
            return Err(MeshError::BadValue {
                what: "list of times".into(),
                index,
                value: self.frames[index].0,
            });
        }
        write_file(path.as_ref(), |out| {
            writeln!(out, "<?xml version=\"1.0\"?>")?;
            writeln!(
                out,
                "<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>"
            )?;
            for (time, file) in &self.frames {
                let file = escape(file);
                writeln!(
                    out,
                    "<DataSet timestep=\"{time}\" part=\"0\" file=\"{file}\"/>"
                )?;
            }
            writeln!(out, "</Collection>\n</VTKFile>")
        })
    }
}
