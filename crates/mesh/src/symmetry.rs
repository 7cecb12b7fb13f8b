//! Meshes cut at symmetry planes, and the whole meshes that they represent.

use std::sync::Arc;

use crate::tet_mesh::Topology;
use crate::{Facet, MeshError, Regions, SYMMETRY_PLANE_TAGS, TetMesh, Vec3};

/// A whole mesh, composed of a part and its reflections.
#[derive(Clone, Debug)]
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
    use crate::LinearTets;

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
