//! The cells of a mesh that stay when the fluid around its bodies is meshed again.

use crate::delaunay::LinkedTets;
use mesh::{Grouped, Surface, TET_EDGES, TetMesh, Vec3};
use nalgebra::{Isometry3, Point3};
use rayon::prelude::*;

/// Cells stay if their distance from the wall is below this fraction of that from each body.
const NEAR_WALL: f64 = 0.5;

/// Smallest distance of a cell that stays from bodies, in lengths of its longest edge.
///
/// There is room for two layers of new cells between them.
const CLEARANCE: f64 = 2.5;

/// The same for cells that stay because one of their faces is not a face of the new cells.
const TIGHT_CLEARANCE: f64 = 1.0;

/// Largest number of changes of a cell.
const MAX_CHANGES: u8 = 3;

/// The part of cells and vertices that move with none.
const NO_PART: u32 = u32::MAX;

/// A surface of the boundary in its new place.
pub(super) struct MovedPart<'a> {
    /// The surface in its new place, negative inside the body or container.
    pub surface: &'a dyn Surface,
    /// Motion from the mesh to the new place.
    pub motion: Isometry3<f64>,
    /// Whether its triangles are those of the mesh.
    pub is_given: bool,
    /// Whether the fluid is inside the surface.
    pub is_wall: bool,
}

impl MovedPart<'_> {
    /// Distance of a point of the fluid from the surface; negative on its other side.
    pub fn distance(&self, x: Vec3) -> f64 {
        let distance = self.surface.signed_distance(x);
        if self.is_wall { -distance } else { distance }
    }

    /// The new place of a point that moves with the part.
    pub fn moved(&self, x: Vec3) -> Vec3 {
        // Walls keep their coordinates to the last bit.
        match self.motion == Isometry3::identity() {
            true => x,
            false => self.motion.transform_point(&Point3::from(x)).coords,
        }
    }
}

/// The cells that stay, each of which moves with a body or rests with the walls.
pub(super) struct KeptCells<'a> {
    mesh: &'a TetMesh,
    /// The bodies, then the walls.
    parts: &'a [MovedPart<'a>],
    linked: LinkedTets,
    /// Groups of cells of which either all stay or none.
    ///
    /// Their common faces are not locally Delaunay, so they would not be faces of new tets.
    groups: Groups,
    /// The part with which each cell moves; [`NO_PART`] for cells that do not stay.
    part_of_cells: Vec<u32>,
    /// The part with which each vertex moves; [`NO_PART`] for vertices inside the fluid.
    part_of_vertices: Vec<u32>,
    /// How often each group was kept, or given up, because of a face that was missing.
    changes: Vec<u8>,
}

/// A triangle between the cells that stay and the fluid that is meshed again.
#[derive(Clone, Copy)]
pub(super) struct FrontFace {
    /// Vertices of the mesh; the normal points out of the fluid that is meshed again.
    pub vertices: [u32; 3],
    /// The cell behind that stays; `None` on the boundary of the mesh.
    pub behind: Option<usize>,
    /// The cell on the other side, which does not stay.
    pub ahead: usize,
}

impl<'a> KeptCells<'a> {
    /// Chooses the cells near the walls.
    ///
    /// `part_of_tags` has the part of each boundary tag.
    pub fn near_walls(mesh: &'a TetMesh, parts: &'a [MovedPart<'a>], part_of_tags: &[u32]) -> Self {
        let tets: Vec<[u32; 4]> = (mesh.cells().iter())
            .map(|nodes| [nodes[0], nodes[1], nodes[2], nodes[3]])
            .collect();
        let mut part_of_vertices = vec![NO_PART; mesh.n_vertices()];
        for facet in mesh.facets() {
            for &vertex in &facet.nodes[..3] {
                part_of_vertices[vertex as usize] = part_of_tags[usize::from(facet.tag)];
            }
        }
        let linked = LinkedTets::new(mesh.n_vertices(), tets);
        let pairs = linked.pairs_not_delaunay(&mesh.points()[..mesh.n_vertices()]);
        let mut kept = Self {
            mesh,
            parts,
            groups: Groups::new(mesh.n_cells(), &pairs),
            linked,
            part_of_cells: vec![NO_PART; mesh.n_cells()],
            part_of_vertices,
            changes: vec![0; mesh.n_cells()],
        };
        let walls = parts.len() - 1;
        let is_near_wall = |cell: usize| {
            let (centre, longest) = kept.extent(cell);
            let to_wall = parts[walls].surface.signed_distance(centre).abs();
            let to_bodies = kept.distance_from_bodies(centre);
            to_wall < NEAR_WALL * to_bodies && to_bodies > CLEARANCE * longest
        };
        let cells = (0..mesh.n_cells()).into_par_iter();
        let is_near: Vec<bool> = cells.map(is_near_wall).collect();
        for group in 0..kept.groups.len() {
            if kept.groups.of(group).iter().all(|&c| is_near[c as usize]) {
                kept.keep(group, walls as u32);
            }
        }
        kept.fill_notches(walls as u32);
        kept
    }

    /// Also keeps cells between cells that stay, where new cells would have sharp edges.
    fn fill_notches(&mut self, part: u32) {
        let notches: Vec<usize> = (0..self.mesh.n_cells())
            .filter(|&cell| {
                let neighbours = self.linked.neighbours(cell);
                let kept = (neighbours.into_iter().flatten())
                    .filter(|&n| self.part_of_cells[n] == part)
                    .count();
                self.part_of_cells[cell] == NO_PART && kept >= 2
            })
            .collect();
        for cell in notches {
            let group = self.groups.number(cell);
            if self.may_keep(group, part) {
                self.keep(group, part);
            }
        }
    }

    /// Centroid and longest edge of a cell.
    fn extent(&self, cell: usize) -> (Vec3, f64) {
        let x = self.mesh.cell_vertices(cell);
        let lengths = TET_EDGES.iter().map(|&[i, j]| (x[i] - x[j]).norm());
        (
            (x[0] + x[1] + x[2] + x[3]) / 4.0,
            lengths.fold(0.0, f64::max),
        )
    }

    /// Distance of a point at rest from the bodies, in the mesh and in their new places.
    fn distance_from_bodies(&self, x: Vec3) -> f64 {
        let bodies = self.parts[..self.parts.len() - 1].iter();
        let distances = bodies.flat_map(|body| [x, body.moved(x)].map(|x| (body, x)));
        distances
            .map(|(body, x)| body.surface.signed_distance(x))
            .fold(f64::INFINITY, f64::min)
    }

    /// Whether a cell that moves with a part is clear of the other parts.
    fn is_clear(&self, cell: usize, part: u32) -> bool {
        let (centre, longest) = self.extent(cell);
        let moved = self.parts[part as usize].moved(centre);
        let mut others = (self.parts.iter().enumerate()).filter(|(k, _)| *k != part as usize);
        others.all(|(_, other)| other.distance(moved) > TIGHT_CLEARANCE * longest)
    }

    /// Whether a group of cells can move with a part.
    fn may_keep(&self, group: usize, part: u32) -> bool {
        let mut cells = self.groups.of(group).iter().map(|&cell| cell as usize);
        cells.all(|cell| self.may_move_with(cell, part) && self.is_clear(cell, part))
    }

    /// Whether no vertex of a cell moves with another part.
    fn may_move_with(&self, cell: usize, part: u32) -> bool {
        let vertices = self.linked.tets()[cell].iter();
        let mut parts = vertices.map(|&v| self.part_of_vertices[v as usize]);
        parts.all(|other| other == NO_PART || other == part)
    }

    /// Keeps a group of cells.
    fn keep(&mut self, group: usize, part: u32) {
        for &cell in self.groups.of(group) {
            self.part_of_cells[cell as usize] = part;
            for &v in &self.linked.tets()[cell as usize] {
                self.part_of_vertices[v as usize] = part;
            }
        }
    }

    /// No longer keeps a group of cells.
    fn give_up(&mut self, group: usize) {
        for &cell in self.groups.of(group) {
            self.part_of_cells[cell as usize] = NO_PART;
        }
    }

    /// The triangles of a part between cells that stay and the fluid that is meshed again.
    pub fn front(&self, part: u32) -> Vec<FrontFace> {
        let mut faces = Vec::new();
        for cell in (0..self.mesh.n_cells()).filter(|&c| self.part_of_cells[c] == NO_PART) {
            for (i, behind) in self.linked.neighbours(cell).into_iter().enumerate() {
                let vertices = self.linked.outward_face(cell, i);
                let is_front = match behind {
                    Some(neighbour) => self.part_of_cells[neighbour] == part,
                    None => vertices
                        .iter()
                        .all(|&v| self.part_of_vertices[v as usize] == part),
                };
                if is_front {
                    faces.push(FrontFace {
                        vertices,
                        behind,
                        ahead: cell,
                    });
                }
            }
        }
        faces
    }

    /// The cells that stay, each with its part.
    pub fn cells(&self) -> impl Iterator<Item = (usize, u32)> + '_ {
        (self.part_of_cells.iter().copied().enumerate()).filter(|&(_, part)| part != NO_PART)
    }

    /// Circumscribed tet vertices of the ball that must be empty for a face of the front: the
    /// vertices of the cell behind it in their new places.
    pub fn placed_vertices(&self, cell: usize, part: u32) -> [Vec3; 4] {
        let x = self.mesh.cell_vertices(cell);
        x.map(|x| self.parts[part as usize].moved(x))
    }

    /// Changes whether one of the cells at a face of the front stays.
    ///
    /// The cell ahead is kept or, unless it `keeps_only`, the cell behind is not; `shrinks` says
    /// which is tried first. No cell changes more than [`MAX_CHANGES`] times; returns false if none
    /// can change.
    pub fn change(&mut self, face: &FrontFace, part: u32, shrinks: bool, keeps_only: bool) -> bool {
        let order: &[bool] = match (keeps_only, shrinks) {
            (true, _) => &[true],
            (false, true) => &[false, true],
            (false, false) => &[true, false],
        };
        for &keeps in order {
            let cell = if keeps { Some(face.ahead) } else { face.behind };
            let Some(group) = cell.map(|cell| self.groups.number(cell)) else {
                continue;
            };
            if keeps && self.part_of_cells[face.ahead] != NO_PART {
                // Kept because of another of its faces.
                return true;
            }
            if self.changes[group] >= MAX_CHANGES || keeps && !self.may_keep(group, part) {
                continue;
            }
            self.changes[group] += 1;
            match keeps {
                true => self.keep(group, part),
                false => self.give_up(group),
            }
            return true;
        }
        false
    }
}

/// The numbers below some `n`, divided into groups.
struct Groups {
    /// The group of each number.
    group: Vec<u32>,
    /// The numbers of each group, ascending.
    members: Grouped<u32>,
}

impl Groups {
    /// Groups of the numbers below `n` that are connected by chains of pairs.
    pub fn new(n: usize, pairs: &[[usize; 2]]) -> Self {
        let mut parent: Vec<usize> = (0..n).collect();
        fn root(parent: &mut [usize], mut k: usize) -> usize {
            while parent[k] != k {
                parent[k] = parent[parent[k]];
                k = parent[k];
            }
            k
        }
        for &[a, b] in pairs {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            parent[a.max(b)] = a.min(b);
        }
        // The root is the smallest number of its group, so it is numbered first.
        let mut group = vec![0; n];
        let mut n_groups = 0;
        for k in 0..n {
            let root = root(&mut parent, k);
            group[k] = if root == k { n_groups } else { group[root] };
            n_groups += u32::from(root == k);
        }
        let members = Grouped::new(n_groups as usize, || group.iter().copied().zip(0..));
        Self { group, members }
    }

    /// Number of groups.
    pub fn len(&self) -> usize {
        self.members.n_keys()
    }

    /// The group of a number.
    pub fn number(&self, k: usize) -> usize {
        self.group[k] as usize
    }

    /// The members of a group, ascending.
    pub fn of(&self, group: usize) -> &[u32] {
        self.members.of(group as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_of_pairs_are_groups() {
        let groups = Groups::new(7, &[[5, 2], [6, 5], [1, 0]]);
        let all: Vec<&[u32]> = (0..groups.len()).map(|k| groups.of(k)).collect();
        assert_eq!(all, [&[0, 1][..], &[2, 5, 6], &[3], &[4]]);
        assert!((0..7).all(|k| groups.of(groups.number(k)).contains(&(k as u32))));
    }
}
