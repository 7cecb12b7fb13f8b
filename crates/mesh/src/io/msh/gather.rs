//! Nodes, elements and groups as they come out of a file, whatever its version.

use std::collections::BTreeMap;

use super::MshFile;
use super::scan::Scanner;
use crate::{LinearTets, MeshError, QuadraticTets, Vec3};

/// What a boundary triangle belongs to; the order is the order of the tags.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Group {
    /// A physical group of the file.
    Physical(i32),
    /// A geometric surface that is in no group.
    Surface(i32),
}

/// What to do with an element type of Gmsh.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    /// Points and curves: not needed.
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
    /// Volume elements other than tets, surface elements other than triangles, orders above two.
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

    /// Nodes of the element.
    pub(super) fn nodes(self) -> usize {
        match self {
            Self::Skip { nodes } | Self::Triangle { nodes } | Self::Tet { nodes } => nodes,
        }
    }
}

/// What has been read so far.
#[derive(Default)]
pub(super) struct Gather {
    /// Tags and places of the nodes, sorted by tag once all are read.
    nodes: Vec<(u64, Vec3)>,
    nodes_read: bool,
    /// Nodes of the triangles; first-order ones use three.
    triangles: Vec<([u32; 6], Group)>,
    /// Nodes of the tets in VTK order; first-order ones use four.
    tets: Vec<[u32; 10]>,
    /// Whether elements are of second order, once one is read.
    second_order: Option<bool>,
    /// Names of the physical surface groups.
    names: BTreeMap<i32, String>,
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

    pub(super) fn add_node(&mut self, tag: u64, place: Vec3) {
        self.nodes.push((tag, place));
    }

    /// Ends the nodes. Sorting by tag makes the mesh independent of the order in the file.
    pub(super) fn finish_nodes(&mut self, scanner: &Scanner) -> Result<(), MeshError> {
        self.nodes.sort_by_key(|node| node.0);
        self.nodes_read = true;
        match self.nodes.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => scanner.error(format!("$Nodes has node {} twice", pair[0].0)),
            None => Ok(()),
        }
    }

    /// That elements can refer to nodes.
    pub(super) fn need_nodes(&self, scanner: &Scanner) -> Result<(), MeshError> {
        if self.nodes_read {
            Ok(())
        } else {
            scanner.error("$Elements comes before $Nodes; save the file again with Gmsh")
        }
    }

    /// Reads the nodes of one element, each by `next`, and keeps it if it is a triangle or a tet.
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
                // Gmsh has the middles of edges 23 and 13 last, VTK those of 13 and 23.
                nodes.swap(8, 9);
                self.tets.push(nodes);
            }
        }
        Ok(())
    }

    pub(super) fn name_group(&mut self, group: i32, name: String) {
        self.names.insert(group, name);
    }

    /// Index of the node with this tag; tags without gaps need no search.
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

    fn same_order(&mut self, scanner: &Scanner, second: bool) -> Result<(), MeshError> {
        if *self.second_order.get_or_insert(second) == second {
            Ok(())
        } else {
            scanner.error(
                "elements of order 1 and 2 are mixed; save one order (Gmsh: Mesh.ElementOrder)",
            )
        }
    }

    /// The mesh in plain arrays: nodes that no kept element has are dropped, tags come in order of their groups' numbers.
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
        let mut new = vec![u32::MAX; self.nodes.len()];
        for &node in of_tets.chain(of_faces) {
            new[node as usize] = 0;
        }
        let mut points = Vec::with_capacity(self.nodes.len());
        for (new, node) in new.iter_mut().zip(&self.nodes) {
            if *new == 0 {
                *new = points.len() as u32;
                points.push(node.1);
            }
        }

        let mut tag_of: BTreeMap<Group, u16> =
            self.triangles.iter().map(|face| (face.1, 0)).collect();
        if tag_of.len() > u16::MAX as usize {
            return scanner.error(format!(
                "{} boundary parts, more than {}",
                tag_of.len(),
                u16::MAX
            ));
        }
        let mut tags = Vec::new();
        for (group, tag) in &mut tag_of {
            *tag = tags.len() as u16;
            tags.push(match group {
                Group::Physical(number) => match self.names.get(number) {
                    Some(name) => name.clone(),
                    None => number.to_string(),
                },
                Group::Surface(number) => format!("surface {number}"),
            });
        }
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
            })
        })
    }
}
