//! Reverse Cuthill-McKee numbering: neighbours in space become neighbours in memory.

use crate::Grouped;
use crate::topology::EdgeIndex;

/// Reverse Cuthill-McKee order of the vertices: `order[new] = old`.
///
/// A breadth-first search from a pseudo-peripheral vertex visits neighbours by ascending degree;
/// the order is then reversed (George 1971; Gibbs, Poole & Stockmeyer 1976 for the start). Ties go
/// to the lower old number, so the result is unique. Connected components follow one another. Cost:
/// O(edges).
///
/// Measured time per nonzero of the product of a scalar P2 matrix with three vectors (98 994 nodes,
/// vertices first, one thread, Nov 2026): 1.5 to 1.6 ns in this order and along a Hilbert curve,
/// 2.1 ns in random order. Numbering midside nodes among the vertices gains more; solvers do that.
pub(crate) fn reverse_cuthill_mckee(n_vertices: usize, edges: &EdgeIndex) -> Vec<u32> {
    let pairs = || edges.iter().flat_map(|[a, b]| [(a, b), (b, a)]);
    let neighbours = Grouped::new(n_vertices, pairs);
    let mut order = Vec::with_capacity(n_vertices);
    let mut placed = vec![false; n_vertices];
    let mut level = vec![UNREACHED_LEVEL; n_vertices];
    for seed in 0..n_vertices as u32 {
        if !placed[seed as usize] {
            let start = pseudo_peripheral(&neighbours, seed, &mut level);
            let first = order.len();
            order.push(start);
            placed[start as usize] = true;
            let mut next = first;
            while next < order.len() {
                let level_from = order.len();
                for &w in neighbours.of(order[next]) {
                    if !placed[w as usize] {
                        placed[w as usize] = true;
                        order.push(w);
                    }
                }
                order[level_from..].sort_unstable_by_key(|&w| (neighbours.of(w).len(), w));
                next += 1;
            }
        }
    }
    order.reverse();
    order
}

/// Level of a vertex that the search has not reached.
const UNREACHED_LEVEL: u32 = u32::MAX;

/// A pseudo-peripheral vertex: repeated searches from the far end find no deeper tree.
fn pseudo_peripheral(neighbours: &Grouped<u32>, seed: u32, level: &mut [u32]) -> u32 {
    let (mut start, mut depth) = (seed, 0);
    loop {
        let (far, new_depth) = farthest(neighbours, start, level);
        // The depth grows strictly, so the loop ends.
        if new_depth <= depth {
            return start;
        }
        (start, depth) = (far, new_depth);
    }
}

/// The vertex of lowest degree in the last breadth-first level, and the number of that level.
///
/// `level` is all `UNREACHED_LEVEL` before and after, so that a search costs no more than the
/// connected component it visits.
fn farthest(neighbours: &Grouped<u32>, from: u32, level: &mut [u32]) -> (u32, u32) {
    let mut queue = vec![from];
    level[from as usize] = 0;
    let mut next = 0;
    while next < queue.len() {
        let v = queue[next];
        for &w in neighbours.of(v) {
            if level[w as usize] == UNREACHED_LEVEL {
                level[w as usize] = level[v as usize] + 1;
                queue.push(w);
            }
        }
        next += 1;
    }
    let depth = level[queue[next - 1] as usize];
    let far = queue
        .iter()
        .rev()
        .take_while(|&&v| level[v as usize] == depth)
        .min_by_key(|&&v| (neighbours.of(v).len(), v));
    let far = far.copied().unwrap_or(from);
    for v in queue {
        level[v as usize] = UNREACHED_LEVEL;
    }
    (far, depth)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shuffled_strip_of_tets_gets_bandwidth_three() {
        // Tet i has the vertices i..i+4 of a strip, so the best bandwidth is 3. The vertices are
        // renumbered by 7 i mod 23.
        let name = |i: u32| 7 * i % 23;
        let tets: Vec<[u32; 4]> = (0..20)
            .map(|i| [i, i + 1, i + 2, i + 3].map(name))
            .collect();
        let edges = EdgeIndex::new(23, &tets);
        let order = reverse_cuthill_mckee(23, &edges);
        let mut new = [0; 23];
        for (i, &old) in order.iter().enumerate() {
            new[old as usize] = i as i64;
        }
        let bandwidth = edges
            .iter()
            .map(|[a, b]| (new[a as usize] - new[b as usize]).abs())
            .max();
        assert_eq!(bandwidth, Some(3));
    }

    #[test]
    fn both_connected_components_are_ordered() {
        let edges = EdgeIndex::new(8, &[[0, 1, 2, 3], [4, 5, 6, 7]]);
        let mut order = reverse_cuthill_mckee(8, &edges);
        order.sort_unstable();
        assert_eq!(order, [0, 1, 2, 3, 4, 5, 6, 7]);
    }
}
