//! Collects nodes, elements and groups from files of any version.

use std::collections::BTreeMap;

use super::MshFile;
use super::scan::Scanner;
use crate::{LinearTets, MeshError, QuadraticTets, Regions, SurfaceMesh, Vec3, used_points};

/// The group of a triangle or tet; tags and regions are in this order.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Group {
    /// A physical group of the file.
    Physical(i32),
    /// A geometric surface or volume that is in no group.
    Entity(i32),
}

/// Kinds of elements, by their use in a mesh.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    /// Points and curves, which are skipped.
    Skip { nodes: usize },
    /// Triangles with 3 or 6 nodes.
    Triangle { nodes: usize },
    /// Tets with 4 or 10 nodes.
    Tet { nodes: usize },
}

impl Kind {
    /// Reads an element type (Gmsh reference manual, "MSH file format").
    ///
    /// # Errors
    /// [`MeshError::Malformed`] for volume elements other than tets, surface elements other than
    /// triangles, and orders above two.
    pub(super) fn read(scanner: &mut Scanner) -> Result<Self, MeshError> {
        let code = scanner.int()?;
        let name = match code {
            15 => return Ok(Self::Skip { nodes: 1 }),
            1 => return Ok(Self::Skip { nodes: 2 }),
            8 => return Ok(Self::Skip { nodes: 3 }),
            2 => return Ok(Self::Triangle { nodes: 3 }),
            9 => return Ok(Self::Triangle { nodes: 6 }),
            4 => return Ok(Self::Tet { nodes: 4 }),
            11 => return Ok(Self::Tet { nodes: 10 }),
            3 | 10 | 16 | 36 | 37 | 47 | 57..=61 => "quadrangles",
            5 | 12 | 17 | 92 | 93 => "hexahedra",
            6 | 13 | 18 | 90 | 91 => "prisms",
            7 | 14 | 19 | 118 | 119 => "pyramids",
            20..=25 | 42..=46 => "triangles of order above two",
            26..=28 | 62..=66 => "curves of order above two",
            29..=33 | 71..=75 => "tetrahedra of order above two",
            _ => "elements of unknown kind",
        };
        scanner.error(format!(
            "{name} (element type {code}) cannot be used; mesh with tetrahedra of order 1 or 2 and triangles"
        ))
    }

    /// Number of nodes of the element.
    pub(super) fn nodes(self) -> usize {
        match self {
            Self::Skip { nodes } | Self::Triangle { nodes } | Self::Tet { nodes } => nodes,
        }
    }
}

/// The contents of the file read so far.
#[derive(Default)]
pub(super) struct Gather {
    /// Tags and positions of the nodes, sorted by tag once all are read.
    nodes: Vec<(u64, Vec3)>,
    nodes_read: bool,
    /// Nodes of the triangles; first-order triangles use the first three.
    triangles: Vec<([u32; 6], Group)>,
    /// Nodes of the tets in VTK order; first-order tets use the first four.
    tets: Vec<[u32; 10]>,
    /// Groups of the tets, each with the first tet of a run of that group.
    regions: Vec<(Group, usize)>,
    /// Whether elements are of second order; known after the first element.
    second_order: Option<bool>,
    /// Names of the physical groups, by dimension and number.
    names: BTreeMap<(i32, i32), String>,
}

impl Gather {
    pub(super) fn reserve_nodes(
        &mut self,
        scanner: &Scanner,
        count: usize,
    ) -> Result<(), MeshError> {
        if self.nodes_read {
            return scanner.error("a second $Nodes section; keep one");
        }
        if count > i32::MAX as usize {
            return Err(MeshError::TooLarge {
                what: "nodes",
                count,
            });
        }
        self.nodes.reserve(count);
        Ok(())
    }

    pub(super) fn add_node(&mut self, tag: u64, position: Vec3) {
        self.nodes.push((tag, position));
    }

    /// Sorts the nodes by tag, which makes the mesh independent of their order in the file.
    pub(super) fn finish_nodes(&mut self, scanner: &Scanner) -> Result<(), MeshError> {
        self.nodes.sort_by_key(|node| node.0);
        self.nodes_read = true;
        match self.nodes.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => scanner.error(format!("$Nodes has node {} twice", pair[0].0)),
            None => Ok(()),
        }
    }

    /// Checks that the nodes have been read, so that elements can refer to them.
    pub(super) fn need_nodes(&self, scanner: &Scanner) -> Result<(), MeshError> {
        if self.nodes_read {
            Ok(())
        } else {
            scanner.error("$Elements comes before $Nodes; save the file again with Gmsh")
        }
    }

    /// Reads the nodes of one element, each by `next`, and keeps the element if it is a triangle or
    /// a tet.
    pub(super) fn read_element<'a>(
        &mut self,
        scanner: &mut Scanner<'a>,
        kind: Kind,
        group: Group,
        next: impl Fn(&mut Scanner<'a>) -> Result<u64, MeshError>,
    ) -> Result<(), MeshError> {
        let mut nodes = [0; 10];
        for node in &mut nodes[..kind.nodes()] {
            let tag = next(scanner)?;
            if !matches!(kind, Kind::Skip { .. }) {
                *node = self.find(scanner, tag)?;
            }
        }
        match kind {
            Kind::Skip { .. } => {}
            Kind::Triangle { nodes: n } => {
                self.same_order(scanner, n == 6)?;
                let [a, b, c, d, e, f, ..] = nodes;
                self.triangles.push(([a, b, c, d, e, f], group));
            }
            Kind::Tet { nodes: n } => {
                self.same_order(scanner, n == 10)?;
                // The last two midside nodes are those of edges 23 and 13 in Gmsh, 13 and 23 in
                // VTK.
                nodes.swap(8, 9);
                if self.regions.last().is_none_or(|run| run.0 != group) {
                    self.regions.push((group, self.tets.len()));
                }
                self.tets.push(nodes);
            }
        }
        Ok(())
    }

    pub(super) fn name_group(&mut self, dimension: i32, group: i32, name: String) {
        self.names.insert((dimension, group), name);
    }

    /// Index of the node with this tag; consecutive tags need no search.
    fn find(&self, scanner: &Scanner, tag: u64) -> Result<u32, MeshError> {
        let first = self.nodes.first().map_or(0, |node| node.0);
        let guess = tag.wrapping_sub(first) as usize;
        let index = match self.nodes.get(guess) {
            Some(node) if node.0 == tag => Ok(guess),
            _ => self.nodes.binary_search_by_key(&tag, |node| node.0),
        };
        match index {
            Ok(index) => Ok(index as u32),
            Err(_) => scanner.error(format!(
                "the element has node {tag}, which $Nodes does not have"
            )),
        }
    }

    /// Checks that all elements have the same order.
    fn same_order(&mut self, scanner: &Scanner, second: bool) -> Result<(), MeshError> {
        if *self.second_order.get_or_insert(second) == second {
            Ok(())
        } else {
            scanner.error(
                "elements of order 1 and 2 are mixed; save one order (Gmsh: Mesh.ElementOrder)",
            )
        }
    }

    /// The mesh in plain arrays, without the nodes that belong to no triangle or tet.
    pub(super) fn finish(self, scanner: &Scanner) -> Result<MshFile, MeshError> {
        if self.tets.is_empty() {
            return scanner.error(
                "the file has no tetrahedra; mesh the volume, and if physical groups are saved give the fluid one",
            );
        }
        let second = self.second_order == Some(true);
        let (tet_nodes, face_nodes) = if second { (10, 6) } else { (4, 3) };
        let of_tets = self.tets.iter().flat_map(|tet| &tet[..tet_nodes]);
        let of_faces = self.triangles.iter().flat_map(|face| &face.0[..face_nodes]);
        let positions: Vec<Vec3> = self.nodes.iter().map(|node| node.1).collect();
        let (points, new) = used_points(&positions, of_tets.chain(of_faces).copied());
        let groups = self.triangles.iter().map(|face| face.1);
        let (tag_of, tags) = self.numbered(scanner, groups, 2, "boundary parts")?;
        let regions = self.regions(scanner)?;
        let tets = self.tets.iter();
        let faces = self
            .triangles
            .iter()
            .map(|(nodes, group)| (nodes, tag_of[group]));
        Ok(if second {
            MshFile::Quadratic(QuadraticTets {
                points,
                tets: tets.map(|tet| tet.map(|v| new[v as usize])).collect(),
                faces: faces
                    .map(|(face, tag)| (face.map(|v| new[v as usize]), tag))
                    .collect(),
                tags,
                regions,
            })
        } else {
            let corners =
                |tet: &[u32; 10]| [tet[0], tet[1], tet[2], tet[3]].map(|v| new[v as usize]);
            MshFile::Linear(LinearTets {
                points,
                tets: tets.map(corners).collect(),
                faces: faces
                    .map(|(face, tag)| ([face[0], face[1], face[2]].map(|v| new[v as usize]), tag))
                    .collect(),
                tags,
                regions,
            })
        })
    }

    /// The triangles alone; those of second order become four.
    pub(super) fn surface(self) -> SurfaceMesh {
        let second = self.second_order == Some(true);
        let parts = |[a, b, c, ab, bc, ca]: [u32; 6]| match second {
            true => vec![[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]],
            false => vec![[a, b, c]],
        };
        let mut mesh = SurfaceMesh::default();
        let mut new = vec![u32::MAX; self.nodes.len()];
        for triangle in self.triangles.iter().flat_map(|(nodes, _)| parts(*nodes)) {
            mesh.triangles.push(triangle.map(|node| {
                let new = &mut new[node as usize];
                if *new == u32::MAX {
                    *new = mesh.points.len() as u32;
                    mesh.points.push(self.nodes[node as usize].1);
                }
                *new
            }));
        }
        mesh
    }

    /// Regions of the tets if there are several.
    fn regions(&self, scanner: &Scanner) -> Result<Regions, MeshError> {
        let groups = self.regions.iter().map(|run| run.0);
        let (number_of, names) = self.numbered(scanner, groups, 3, "regions")?;
        if names.len() < 2 {
            return Ok(Regions::default());
        }
        let mut of_cells = Vec::with_capacity(self.tets.len());
        for (k, (group, _)) in self.regions.iter().enumerate() {
            let end = self
                .regions
                .get(k + 1)
                .map_or(self.tets.len(), |next| next.1);
            of_cells.resize(end, number_of[group]);
        }
        Ok(Regions { names, of_cells })
    }

    /// Numbers of groups of a dimension in ascending order, and their names.
    fn numbered(
        &self,
        scanner: &Scanner,
        groups: impl Iterator<Item = Group>,
        dimension: i32,
        what: &str,
    ) -> Result<(BTreeMap<Group, u16>, Vec<String>), MeshError> {
        let mut numbers: BTreeMap<Group, u16> = groups.map(|group| (group, 0)).collect();
        let count = numbers.len();
        if count > u16::MAX as usize {
            return scanner.error(format!("{count} {what}, more than {}", u16::MAX));
        }
        for (number, slot) in (0..).zip(numbers.values_mut()) {
            *slot = number;
        }
        let names = numbers.keys().map(|group| self.name_of(dimension, *group));
        let names = names.collect();
        Ok((numbers, names))
    }

    /// Name of a group of surfaces (dimension 2) or volumes (dimension 3).
    fn name_of(&self, dimension: i32, group: Group) -> String {
        match group {
            Group::Physical(number) => match self.names.get(&(dimension, number)) {
                Some(name) => name.clone(),
                None => number.to_string(),
            },
            Group::Entity(number) if dimension == 2 => format!("surface {number}"),
            Group::Entity(number) => format!("volume {number}"),
        }
    }
}
