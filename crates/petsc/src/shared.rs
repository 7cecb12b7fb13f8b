//! Nodes and faces that several processes have in their parts of the mesh.

use std::sync::{Arc, OnceLock};

use mesh::Submesh;
use rigid::{Constrained, SumOverParts};
use stokes::fem::SurplusSpace;

use crate::PetscError;
use crate::handles::{Exchange, Session};
use crate::partition::Partition;

/// Pairs of a process and an entity of the part, ascending.
type Pairs = Vec<(u32, u32)>;

/// The entities of a part that other processes have too.
///
/// A process has all cells around its own vertices. It needs the values of the other nodes and
/// faces of these cells from their owners; both sides list them in the order of the whole mesh.
#[derive(Default)]
pub struct Shared {
    /// Own nodes with the processes that need them, and nodes of other processes.
    nodes: [Pairs; 2],
    /// The same for face bubbles.
    faces: [Pairs; 2],
}

/// Owner of a face or a cell: that of its vertex with the lowest number.
pub fn owner_of(partition: &Partition, submesh: &Submesh, vertices: &[u32]) -> usize {
    let lowest = vertices.iter().min().copied().unwrap_or_default();
    partition.owner(submesh.nodes[lowest as usize])
}

/// The vertices of each face of a cell, by the opposite vertex.
pub fn faces(cell: &[u32; 10]) -> [[u32; 3]; 4] {
    let [a, b, c, d, ..] = *cell;
    [[b, c, d], [a, c, d], [a, b, d], [a, b, c]]
}

impl Shared {
    /// The nodes that process `rank` shares, and its faces if it has `space`.
    pub fn new(
        partition: &Partition,
        submesh: &Submesh,
        space: Option<&SurplusSpace>,
        rank: usize,
    ) -> Self {
        let mut shared = Self::default();
        for (number, cell) in submesh.mesh.cells().iter().enumerate() {
            let owner_of_node = |node: u32| partition.owner(submesh.nodes[node as usize]);
            let mut others: Vec<usize> = cell[..4].iter().map(|&v| owner_of_node(v)).collect();
            others.sort_unstable();
            others.dedup();
            others.retain(|&owner| owner != rank);
            if others.is_empty() {
                continue;
            }
            let add = |[sent, received]: &mut [Pairs; 2], owner: usize, entity: u32| {
                if owner == rank {
                    sent.extend(others.iter().map(|&other| (other as u32, entity)));
                } else {
                    received.push((owner as u32, entity));
                }
            };
            for &node in cell {
                add(&mut shared.nodes, owner_of_node(node), node);
            }
            if let Some(space) = space {
                for (vertices, face) in faces(cell).iter().zip(space.face_bubbles(number)) {
                    let owner = owner_of(partition, submesh, vertices);
                    add(&mut shared.faces, owner, face);
                }
            }
        }
        for pairs in shared.nodes.iter_mut().chain(&mut shared.faces) {
            pairs.sort_unstable();
            pairs.dedup();
        }
        shared
    }

    /// The exchange of vectors `[velocity | border | pressure]` of the system of a part.
    ///
    /// The border belongs to the first process.
    ///
    /// # Errors
    /// [`PetscError::TooLarge`].
    pub fn of_system(
        &self,
        session: &Session,
        submesh: &Submesh,
        system: &Constrained,
    ) -> Result<Exchange, PetscError> {
        let mut row_of = vec![None; submesh.nodes.len()];
        for (row, &node) in system.free_nodes().iter().enumerate() {
            row_of[node as usize] = Some(3 * row);
        }
        let blocks = &system.system;
        let (border, vertices) = (blocks.border_range(), submesh.mesh.n_vertices());
        let entries = |node: u32| {
            let node = node as usize;
            let velocity = row_of[node].map_or(0..0, |first| first..first + 3);
            let pressure = (node < vertices).then(|| blocks.pressure_range().start + node);
            velocity.chain(pressure)
        };
        let [mut sent, mut received] =
            (self.nodes.each_ref()).map(|pairs| by_process(session, pairs, entries));
        let border = border.map(|entry| entry as u32);
        match session.rank() {
            0 => (sent.iter_mut().skip(1)).for_each(|list| list.extend(border.clone())),
            _ => received[0].extend(border),
        }
        Exchange::new(&sent, &received)
    }

    /// The exchange of vectors of the extension: three numbers per bubble, then one per edge.
    ///
    /// # Errors
    /// [`PetscError::TooLarge`].
    pub fn of_extension(
        &self,
        session: &Session,
        submesh: &Submesh,
        space: &SurplusSpace,
    ) -> Result<Exchange, PetscError> {
        let vertices = submesh.mesh.n_vertices();
        let of_node = |node: u32| {
            let edge = (node as usize).checked_sub(vertices);
            let bubble = edge.map_or(0..0, |edge| 3 * edge..3 * edge + 3);
            bubble.chain(edge.map(|edge| 3 * space.n_bubbles() + edge))
        };
        let of_face = |face: u32| 3 * face as usize..3 * face as usize + 3;
        let lists = |k: usize| {
            let mut lists = by_process(session, &self.nodes[k], of_node);
            let of_faces = by_process(session, &self.faces[k], of_face);
            for (list, faces) in lists.iter_mut().zip(of_faces) {
                list.extend(faces);
            }
            lists
        };
        Exchange::new(&lists(0), &lists(1))
    }
}

/// The entries of all entities, one list per process.
fn by_process<I: Iterator<Item = usize>>(
    session: &Session,
    pairs: &[(u32, u32)],
    entries: impl Fn(u32) -> I,
) -> Vec<Vec<u32>> {
    let mut lists = vec![Vec::new(); session.ranks()];
    for &(process, entity) in pairs {
        lists[process as usize].extend(entries(entity).map(|entry| entry as u32));
    }
    lists
}

/// An exchange that is known later than the closure that runs it.
#[derive(Clone, Default)]
pub struct LateExchange(Arc<OnceLock<Exchange>>);

impl LateExchange {
    /// Sets the exchange, once.
    pub fn set(&self, exchange: Exchange) {
        // A second exchange would be that of another system.
        debug_assert!(self.0.get().is_none());
        self.0.get_or_init(|| exchange);
    }

    /// The exchange in the form that `rigid` and `fem` take.
    ///
    /// Before it is set, on another thread, after the end of the session or after an error it
    /// writes NaN.
    pub fn function(&self) -> SumOverParts {
        let exchange = self.0.clone();
        Arc::new(move |vector: &mut [f64]| {
            let updated = exchange.get().map(|exchange| {
                Session::with_current(|session| exchange.update(session, vector)).is_ok()
            });
            if updated != Some(true) {
                vector.fill(f64::NAN);
            }
        })
    }
}
