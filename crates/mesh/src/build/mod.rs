//! Construction of checked 10-node meshes: from separate tets and tagged triangles, by moving the
//! nodes of a mesh, from some of its cells, and by reflecting it in symmetry planes.

mod boundary_nodes;
mod input_checks;
mod red_refinement;

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use crate::jacobian::straight_jacobian;
use crate::reverse_cuthill_mckee::reverse_cuthill_mckee;
use crate::tet_mesh::{NamedSurface, Topology, check_finite};
use crate::topology::{EdgeIndex, match_boundary};
use crate::{
    Facet, LinearTets, MeshError, QuadraticTets, Regions, SYMMETRY_PLANE_TAGS, TET_EDGES, TetMesh,
    Vec3, has_volume, used_points,
};
use boundary_nodes::project;
use input_checks::{check_numbers, check_regions, check_tags, check_vertices};

/// Cells per parallel task.
const CHUNK: usize = 4096;

impl TetMesh {
    /// Straight-sided mesh of `tets`: midside nodes are midpoints.
    ///
    /// Inverted tets are reoriented; tagged faces are matched with the boundary faces one to one
    /// and oriented out of the fluid; vertices and cells are renumbered for locality. Cost: O(n log
    /// n); about 2 microseconds per tet (71 614 tets, Nov 2026).
    ///
    /// ```
    /// use mesh::{LinearTets, TetMesh};
    /// let mesh = TetMesh::straight(LinearTets::cube(2))?;
    /// assert_eq!((mesh.n_vertices(), mesh.n_points()), (27, 125));
    /// assert!((mesh.volume() - 1.0).abs() < 1e-14);
    /// # Ok::<(), mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// A [`MeshError`] that says what is wrong with `tets` and where: no tets, NaN, flat or
    /// duplicate tets, unused or duplicate vertices, untagged boundary faces, tagged faces that are
    /// not boundary faces, tags without faces, bad names.
    pub fn straight(tets: LinearTets) -> Result<Self, MeshError> {
        Self::curved(tets, &[])
    }

    /// Mesh of `tets` whose boundary follows the given surfaces.
    ///
    /// Vertices and midside nodes on a named boundary part move to the closest point of its
    /// surface; vertices must be within 1e-6 of the surface's radius of it. Other parts stay flat.
    ///
    /// # Errors
    /// As [`TetMesh::straight`]; also [`MeshError::UnknownTag`], [`MeshError::OffSurface`], and
    /// [`MeshError::InvertedCell`] where elements are too large to follow the surface.
    pub fn curved(tets: LinearTets, surfaces: &[NamedSurface]) -> Result<Self, MeshError> {
        build(tets, &[], surfaces)
    }

    /// Mesh of a second-order file.
    ///
    /// Nodes on named parts move to their surfaces as in [`TetMesh::curved`].
    ///
    /// # Errors
    /// As [`TetMesh::curved`]; also [`MeshError::BadMidside`] if two cells have different midside
    /// nodes on the same edge.
    pub fn quadratic(tets: QuadraticTets, surfaces: &[NamedSurface]) -> Result<Self, MeshError> {
        let (linear, middles) = tets.split()?;
        build(linear, &middles, surfaces)
    }

    /// Mesh of `tets` with the midside nodes of some edges; the others have theirs at midpoints.
    ///
    /// The keys of `middles` have the smaller vertex first. Nodes on named parts move to their
    /// surfaces as in [`TetMesh::curved`].
    ///
    /// # Errors
    /// As [`TetMesh::curved`].
    pub fn with_middles(
        tets: LinearTets,
        middles: &HashMap<[u32; 2], Vec3>,
        surfaces: &[NamedSurface],
    ) -> Result<Self, MeshError> {
        check_numbers(&tets)?;
        let middle = |edge: [u32; 2]| {
            let midpoint = || 0.5 * (tets.points[edge[0] as usize] + tets.points[edge[1] as usize]);
            middles.get(&edge).copied().unwrap_or_else(midpoint)
        };
        let edges = EdgeIndex::new(tets.points.len(), &tets.tets);
        let middles: Vec<Vec3> = edges.iter().map(middle).collect();
        build(tets, &middles, surfaces)
    }
}

/// Builds the mesh.
///
/// `middles` contains the midside node of every edge, in the numbering of [`EdgeIndex`] of the
/// given tets, or is empty for midpoints.
fn build(
    mut linear: LinearTets,
    middles: &[Vec3],
    surfaces: &[NamedSurface],
) -> Result<TetMesh, MeshError> {
    check_numbers(&linear)?;
    check_vertices(&linear)?;
    check_regions(&linear)?;
    orient(&mut linear)?;
    let old_edges = EdgeIndex::new(linear.points.len(), &linear.tets);
    let order = reverse_cuthill_mckee(linear.points.len(), &old_edges);
    let tets = renumber(&mut linear, &order)?;
    let (boundary, edges) = rayon::join(
        || match_boundary(&linear.points, &tets, &linear.faces, &linear.tags),
        || EdgeIndex::new(linear.points.len(), &tets),
    );
    let boundary = boundary?;
    let n_vertices = linear.points.len();
    if n_vertices + edges.len() > i32::MAX as usize {
        return Err(MeshError::TooLarge {
            what: "nodes",
            count: n_vertices + edges.len(),
        });
    }
    // `find` succeeds because every pair is an edge of some tet; the default is never used.
    let node = |a: u32, b: u32| (n_vertices + edges.find(a, b).unwrap_or_default()) as u32;
    let cells = tets
        .par_iter()
        .with_min_len(CHUNK)
        .map(|v| {
            let m = TET_EDGES.map(|[i, j]| node(v[i], v[j]));
            [v[0], v[1], v[2], v[3], m[0], m[1], m[2], m[3], m[4], m[5]]
        })
        .collect();
    let mut facets: Vec<Facet> = boundary
        .iter()
        .map(|face| {
            let [a, b, c] = face.vertices;
            Facet {
                nodes: [a, b, c, node(a, b), node(b, c), node(c, a)],
                cell: face.cell,
                tag: face.tag,
            }
        })
        .collect();
    facets.sort_unstable_by_key(|facet| (facet.tag, facet.cell, facet.nodes));
    check_tags(&linear.tags, &facets)?;
    let mut points = linear.points;
    // Vertices are projected first, because midpoints are computed from their final positions.
    project(&mut points, &facets, 0..3, &linear.tags, surfaces)?;
    let middle = |[a, b]: [u32; 2]| {
        let midpoint = 0.5 * (points[a as usize] + points[b as usize]);
        if middles.is_empty() {
            return midpoint;
        }
        let [old_a, old_b] = [a, b].map(|v| order[v as usize]);
        let given = old_edges.find(old_a, old_b).and_then(|e| middles.get(e));
        given.copied().unwrap_or(midpoint)
    };
    let middles: Vec<Vec3> = edges.iter().map(middle).collect();
    points.extend(middles);
    project(&mut points, &facets, 3..6, &linear.tags, surfaces)?;
    check_finite(&points)?;
    let topology = Topology {
        n_vertices,
        cells,
        facets,
        tags: linear.tags,
        regions: linear.regions,
    };
    TetMesh::checked(points, Arc::new(topology))
}

/// Makes every tet positively oriented.
///
/// # Errors
/// [`MeshError::FlatCell`].
fn orient(linear: &mut LinearTets) -> Result<(), MeshError> {
    for (cell, tet) in linear.tets.iter_mut().enumerate() {
        let x = tet.map(|v| linear.points[v as usize]);
        if !has_volume(x) {
            return Err(MeshError::FlatCell {
                cell,
                at: ((x[0] + x[1] + x[2] + x[3]) / 4.0).into(),
            });
        }
        if straight_jacobian(x) < 0.0 {
            tet.swap(2, 3);
        }
    }
    Ok(())
}

/// Renumbers points and faces by `order[new] = old`.
///
/// Returns the renumbered tets, sorted by their vertices.
///
/// The regions of the cells follow the tets.
///
/// # Errors
/// [`MeshError::DuplicateCell`].
fn renumber(linear: &mut LinearTets, order: &[u32]) -> Result<Vec<[u32; 4]>, MeshError> {
    let mut new = vec![0; order.len()];
    for (number, &old) in order.iter().enumerate() {
        new[old as usize] = number as u32;
    }
    linear.points = order
        .iter()
        .map(|&old| linear.points[old as usize])
        .collect();
    for (face, _) in &mut linear.faces {
        *face = face.map(|v| new[v as usize]);
    }
    let regions = &mut linear.regions.of_cells;
    let mut keyed: Vec<(u128, [u32; 4], u16)> = (linear.tets.par_iter().enumerate())
        .with_min_len(CHUNK)
        .map(|(cell, tet)| {
            let tet = tet.map(|v| new[v as usize]);
            (key(&tet), tet, regions.get(cell).copied().unwrap_or(0))
        })
        .collect();
    keyed.par_sort_unstable();
    for (region, &(_, _, of_cell)) in regions.iter_mut().zip(&keyed) {
        *region = of_cell;
    }
    match keyed.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(pair) => {
            let x = pair[0].1.map(|v| linear.points[v as usize]);
            Err(MeshError::DuplicateCell {
                at: ((x[0] + x[1] + x[2] + x[3]) / 4.0).into(),
            })
        }
        None => Ok(keyed.into_iter().map(|(_, tet, _)| tet).collect()),
    }
}

/// The vertices of a tet in ascending order, as one number.
fn key(tet: &[u32; 4]) -> u128 {
    let mut sorted = *tet;
    sorted.sort_unstable();
    sorted.iter().fold(0, |key, &v| key << 32 | u128::from(v))
}

impl TetMesh {
    /// Copy of the mesh with other node positions: `points[i]` is the new position of node `i`.
    ///
    /// The topology is shared, not copied. Cost: one Jacobian bound per curved cell, in parallel.
    ///
    /// # Errors
    /// [`MeshError::WrongLength`], [`MeshError::NotFinite`], and [`MeshError::InvertedCell`] with
    /// the worst cell if the motion turns any cell inside out.
    pub fn with_points(&self, points: Vec<Vec3>) -> Result<Self, MeshError> {
        if points.len() != self.n_points() {
            return Err(MeshError::WrongLength {
                what: "list of moved nodes".into(),
                expected: self.n_points(),
                found: points.len(),
            });
        }
        check_finite(&points)?;
        Self::checked(points, Arc::clone(&self.topology))
    }

    /// The mesh with these points and this topology, if every cell is valid.
    ///
    /// # Errors
    /// [`MeshError::InvertedCell`] with the worst cell.
    pub(crate) fn checked(points: Vec<Vec3>, topology: Arc<Topology>) -> Result<Self, MeshError> {
        let mesh = Self { points, topology };
        mesh.check_jacobians()?;
        Ok(mesh)
    }

    /// Checks that the geometry map of every cell is one-to-one.
    ///
    /// # Errors
    /// [`MeshError::InvertedCell`] with the worst cell.
    fn check_jacobians(&self) -> Result<(), MeshError> {
        let worst: Vec<(f64, usize)> = (0..self.n_cells().div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                (chunk * CHUNK..self.n_cells().min((chunk + 1) * CHUNK))
                    .map(|cell| (self.scaled_jacobian(cell), cell))
                    .fold((f64::INFINITY, 0), smaller)
            })
            .collect();
        let (jacobian, cell) = worst.into_iter().fold((f64::INFINITY, 0), smaller);
        if jacobian > 0.0 {
            return Ok(());
        }
        let [a, b, c, d] = self.cell_vertices(cell);
        Err(MeshError::InvertedCell {
            cell,
            at: ((a + b + c + d) / 4.0).into(),
            jacobian,
        })
    }
}

/// The cell with the smaller Jacobian, or with one that overflowed to NaN.
fn smaller(a: (f64, usize), b: (f64, usize)) -> (f64, usize) {
    if b.0 < a.0 || b.0.is_nan() { b } else { a }
}

/// Number of a node that is not in the submesh.
const ABSENT: u32 = u32::MAX;

/// Some cells of a mesh as a mesh of their own, in the order of the whole mesh.
///
/// Faces at which the mesh was cut have no facet and no tag; all other properties of a
/// [`TetMesh`] hold.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Submesh {
    /// The cells with their nodes, vertices first, both in ascending order of the whole mesh.
    pub mesh: TetMesh,
    /// Number of each node in the whole mesh, ascending among vertices and among midside nodes.
    pub nodes: Vec<u32>,
}

impl Submesh {
    /// Number in the submesh of a node of the whole mesh; none if it is not in the submesh.
    pub fn number(&self, node: u32) -> Option<u32> {
        // Vertices come before midside nodes in both meshes, each in ascending order.
        let number = self.nodes.binary_search(&node);
        number.ok().map(|number| number as u32)
    }
}

impl TetMesh {
    /// The cells for which `is_kept` holds, with the boundary faces that belong to them.
    ///
    /// Tags keep their numbers, also those without a facet here. Cost: one pass over the mesh.
    ///
    /// ```
    /// use mesh::{LinearTets, TetMesh};
    /// let mesh = TetMesh::straight(LinearTets::cube(2))?;
    /// let half = mesh.submesh(|cell| cell < mesh.n_cells() / 2)?;
    /// assert_eq!(2 * half.mesh.n_cells(), mesh.n_cells());
    /// assert_eq!(half.mesh.points()[0], mesh.points()[half.nodes[0] as usize]);
    /// # Ok::<(), mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::Empty`] if no cell is kept.
    pub fn submesh(&self, is_kept: impl Fn(usize) -> bool) -> Result<Submesh, MeshError> {
        let kept: Vec<u32> = (0..self.n_cells() as u32)
            .filter(|&cell| is_kept(cell as usize))
            .collect();
        if kept.is_empty() {
            return Err(MeshError::Empty);
        }
        let used = kept.iter().flat_map(|&cell| self.cells()[cell as usize]);
        let (points, number) = used_points(self.points(), used);
        let nodes: Vec<u32> = (0..self.n_points() as u32)
            .filter(|&node| number[node as usize] != ABSENT)
            .collect();
        let mut cell_number = vec![ABSENT; self.n_cells()];
        for (own, &cell) in kept.iter().enumerate() {
            cell_number[cell as usize] = own as u32;
        }
        let facets = self.facets().iter().filter_map(|facet| {
            let cell = cell_number[facet.cell as usize];
            (cell != ABSENT).then(|| Facet {
                nodes: facet.nodes.map(|node| number[node as usize]),
                cell,
                tag: facet.tag,
            })
        });
        let of_cells = &self.regions().of_cells;
        let regions = Regions {
            names: self.regions().names.clone(),
            of_cells: (kept.iter())
                .filter_map(|&cell| of_cells.get(cell as usize).copied())
                .collect(),
        };
        let topology = Topology {
            n_vertices: nodes.partition_point(|&node| (node as usize) < self.n_vertices()),
            cells: (kept.iter())
                .map(|&cell| self.cells()[cell as usize].map(|node| number[node as usize]))
                .collect(),
            facets: facets.collect(),
            tags: self.tags().to_vec(),
            regions,
        };
        Ok(Submesh {
            // The cells are those of a mesh that was checked.
            mesh: TetMesh {
                points,
                topology: Arc::new(topology),
            },
            nodes,
        })
    }
}

/// A whole mesh, composed of a part and its reflections.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Unfolded {
    /// The whole mesh. Its nodes are numbered differently from those of the part, see `sources`.
    pub mesh: TetMesh,
    /// Source of each node of the whole: the node of the part of which it is an image.
    ///
    /// The vector contains the factors (1 or -1) by which the reflection multiplies the components
    /// of a vector.
    pub sources: Vec<(u32, Vec3)>,
}

impl TetMesh {
    /// The whole mesh that this part represents: the part and its reflections in all symmetry
    /// planes.
    ///
    /// The reflections share the nodes on the planes. A mesh without symmetry planes is returned
    /// unchanged. Vertices come first, as in every mesh; cells come image by image.
    /// Cost: one pass over nodes and cells per image.
    ///
    /// ```
    /// use mesh::{LinearTets, SYMMETRY_PLANE_TAGS, TetMesh};
    /// let mut cube = LinearTets::cube(1);
    /// cube.tags[0] = SYMMETRY_PLANE_TAGS[0].into();
    /// let whole = TetMesh::straight(cube)?.unfolded()?.mesh;
    /// assert_eq!((whole.n_vertices(), whole.n_cells(), whole.facets().len()), (12, 12, 20));
    /// # Ok::<(), mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::OffSymmetryPlane`] for a node on a symmetry plane whose coordinate is not
    /// exactly zero; [`MeshError::TooLarge`].
    pub fn unfolded(&self) -> Result<Unfolded, MeshError> {
        let planes = self.symmetry_planes();
        let on = self.checked_symmetry_planes()?;
        // For each image, the axes along which it is reflected.
        let images: Vec<[bool; 3]> = (0..8usize)
            .map(|bits| [0, 1, 2].map(|axis| bits >> axis & 1 == 1))
            .filter(|image| (0..3).all(|axis| planes[axis] || !image[axis]))
            .collect();
        if images.len() * self.n_points() > i32::MAX as usize {
            return Err(MeshError::TooLarge {
                what: "nodes",
                count: images.len() * self.n_points(),
            });
        }
        let mut sources = Vec::new();
        let mut number = vec![vec![0u32; self.n_points()]; images.len()];
        let mut n_vertices = 0;
        for range in [0..self.n_vertices(), self.n_vertices()..self.n_points()] {
            for (k, image) in images.iter().enumerate() {
                for node in range.clone() {
                    // A node on a plane is its own image in that plane.
                    let moved = [0, 1, 2].map(|axis| image[axis] && !on[node][axis]);
                    number[k][node] = if moved == *image {
                        sources.push((node as u32, signs(*image)));
                        sources.len() as u32 - 1
                    } else {
                        let first = images.iter().position(|other| *other == moved);
                        number[first.unwrap_or_default()][node]
                    };
                }
            }
            if range.start == 0 {
                n_vertices = sources.len();
            }
        }
        let points = sources
            .iter()
            .map(|(node, signs)| self.points()[*node as usize].component_mul(signs))
            .collect();
        let topology = self.images(&images, &number, n_vertices);
        Ok(Unfolded {
            mesh: TetMesh::checked(points, Arc::new(topology))?,
            sources,
        })
    }

    /// For each node, the symmetry planes on which it lies, exactly.
    ///
    /// # Errors
    /// [`MeshError::OffSymmetryPlane`].
    fn checked_symmetry_planes(&self) -> Result<Vec<[bool; 3]>, MeshError> {
        let mut on = vec![[false; 3]; self.n_points()];
        for (node, axes) in self.nodes_on_symmetry_planes() {
            on[node as usize] = axes;
            let at = self.points()[node as usize];
            if let Some(axis) = (0..3).find(|&axis| axes[axis] && at[axis] != 0.0) {
                return Err(MeshError::OffSymmetryPlane {
                    node: node as usize,
                    plane: SYMMETRY_PLANE_TAGS[axis],
                    distance: at[axis].abs(),
                });
            }
        }
        Ok(on)
    }

    /// Cells and facets of all images, with the `number` of each node in each image.
    fn images(&self, images: &[[bool; 3]], number: &[Vec<u32>], n_vertices: usize) -> Topology {
        let mut cells = Vec::with_capacity(images.len() * self.n_cells());
        let mut facets = Vec::new();
        let tags: Vec<String> = self
            .tags()
            .iter()
            .filter(|tag| !SYMMETRY_PLANE_TAGS.contains(&tag.as_str()))
            .cloned()
            .collect();
        for (image, number) in images.iter().zip(number) {
            let is_odd = image.iter().filter(|&&axis| axis).count() % 2 == 1;
            let first_cell = cells.len() as u32;
            cells.extend(self.cells().iter().map(|cell| {
                let n = cell.map(|node| number[node as usize]);
                if is_odd {
                    [n[1], n[0], n[2], n[3], n[4], n[6], n[5], n[8], n[7], n[9]]
                } else {
                    n
                }
            }));
            for facet in self.facets() {
                let name = &self.tags()[usize::from(facet.tag)];
                let Some(tag) = tags.iter().position(|tag| tag == name) else {
                    continue;
                };
                let n = facet.nodes.map(|node| number[node as usize]);
                facets.push(Facet {
                    nodes: if is_odd {
                        [n[1], n[0], n[2], n[3], n[5], n[4]]
                    } else {
                        n
                    },
                    cell: first_cell + facet.cell,
                    tag: tag as u16,
                });
            }
        }
        facets.sort_unstable_by_key(|facet| (facet.tag, facet.cell, facet.nodes));
        Topology {
            n_vertices,
            cells,
            facets,
            tags,
            regions: Regions {
                names: self.regions().names.clone(),
                of_cells: self.regions().of_cells.repeat(images.len()),
            },
        }
    }
}

/// Factors by which the reflection along the axes of `image` multiplies the components of a vector.
fn signs(image: [bool; 3]) -> Vec3 {
    Vec3::from(image.map(|reflected| if reflected { -1.0 } else { 1.0 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_keep_their_positions_and_facets_their_tags() {
        let mesh = TetMesh::straight(LinearTets::cube(3)).unwrap();
        let part = mesh.submesh(|cell| cell % 3 == 1).unwrap();
        let cells = (0..mesh.n_cells()).filter(|cell| cell % 3 == 1);
        for (own, cell) in cells.enumerate() {
            assert_eq!(part.mesh.cell_points(own), mesh.cell_points(cell));
        }
        let kept = mesh.facets().iter().filter(|facet| facet.cell % 3 == 1);
        assert_eq!(kept.clone().count(), part.mesh.facets().len());
        for (own, facet) in part.mesh.facets().iter().zip(kept) {
            assert_eq!(own.nodes.map(|node| part.nodes[node as usize]), facet.nodes);
            assert_eq!(own.tag, facet.tag);
        }
        assert!(part.nodes[..part.mesh.n_vertices()].is_sorted());
        assert!(part.nodes[part.mesh.n_vertices()..].is_sorted());
    }

    #[test]
    fn a_submesh_without_cells_is_an_error() {
        let mesh = TetMesh::straight(LinearTets::cube(1)).unwrap();
        assert!(mesh.submesh(|_| false).is_err());
    }

    /// A unit cube whose sides at zero, normal to the axes in `planes`, are symmetry planes.
    fn part(n: u32, planes: &[usize]) -> TetMesh {
        let mut cube = LinearTets::cube(n);
        for &axis in planes {
            cube.tags[2 * axis] = SYMMETRY_PLANE_TAGS[axis].into();
        }
        TetMesh::straight(cube).unwrap()
    }

    #[test]
    fn images_fill_the_whole_mesh() {
        for planes in [&[][..], &[1], &[0, 2], &[0, 1, 2]] {
            let part = part(2, planes);
            let whole = part.unfolded().unwrap();
            let parts = 1 << planes.len();
            assert_eq!(whole.mesh.n_cells(), parts * part.n_cells());
            assert!((whole.mesh.volume() - parts as f64).abs() < 1e-13);
            // All cells are affine: every midside node is the midpoint of its edge. Facets lie on
            // their cells and point outwards.
            assert!((0..whole.mesh.n_cells()).all(|cell| whole.mesh.is_affine(cell)));
            let facets = whole.mesh.facets();
            assert_eq!(facets.len(), 8 * (6 - planes.len()) * parts);
            for facet in facets {
                let x = facet.nodes.map(|node| whole.mesh.points()[node as usize]);
                let normal = (x[1] - x[0]).cross(&(x[2] - x[0]));
                let centre = whole.mesh.cell_points(facet.cell as usize)[..4]
                    .iter()
                    .sum::<Vec3>()
                    / 4.0;
                assert!(normal.dot(&(x[0] - centre)) > 0.0);
                assert!((x[3] - 0.5 * (x[0] + x[1])).norm() < 1e-14);
                assert!((x[5] - 0.5 * (x[2] + x[0])).norm() < 1e-14);
                assert!(whole.mesh.cells()[facet.cell as usize].contains(&facet.nodes[4]));
            }
            // No two nodes coincide.
            let mut places: Vec<[i64; 3]> = whole
                .mesh
                .points()
                .iter()
                .map(|p| [p.x, p.y, p.z].map(|x| (x * 64.0).round() as i64))
                .collect();
            places.sort_unstable();
            places.dedup();
            assert_eq!(places.len(), whole.mesh.n_points());
        }
    }

    #[test]
    fn nodes_on_symmetry_planes_have_a_zero_coordinate() {
        let part = part(1, &[0, 2]);
        for (node, planes) in part.nodes_on_symmetry_planes() {
            let x = part.points()[node as usize];
            assert_eq!(planes, [x.x == 0.0, false, x.z == 0.0]);
        }
        assert_eq!(part.symmetry_planes(), [true, false, true]);
    }
}
