//! Cells of spheres that act on distant ones together.
//!
//! What spheres do far away is what one expansion about the centre of a cell around them does
//! (Greengard & Rokhlin 1987). Pairs of cells are found by a walk through the pairs of a binary
//! tree (Dehnen 2002, J. Comput. Phys. 179, 27): two cells couple as two spheres do, with the
//! orders that the truncation of their expansions needs, if that takes fewer operations than their
//! halves; otherwise the larger one is divided.
//!
//! Bodies are the spheres, and after them the cells.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::line_of_centres::PairOrders;
use super::orders::LOWEST_ORDER;
use super::pair_product;
use super::truncation::{self, Neglected};
use crate::Spheres;

/// Highest order of a cell: 343 to 8000 spheres in cubes at gaps of 0.1 to 4 took the fewest
/// operations with 12 to 14, up to 1.4 times as many with 10 and 16.
pub(super) const MAX_CELL_ORDER: usize = 12;

/// Time of an operation of cells over that of pairs of spheres: with it 1000 spheres at gaps of 0.1
/// take 6.7 s instead of 7.6.
pub(super) const SLOWER: usize = 2;

/// Number of spheres from which cells couple: 300 in swimmers took 0.8 of the time of pairs, 99
/// took 1.4 of it.
const MANY: usize = 150;

/// Least gap between the nearest spheres of two cells that couple, in sums of the radii.
const DISTANT: f64 = 0.5;

/// A cell whose expansion is used.
pub(super) struct Cell {
    pub centre: Vector3<f64>,
    /// Radius of a ball around the spheres.
    pub radius: f64,
    /// Order of the expansion.
    pub order: usize,
    /// Bodies with the expansions that make up its own.
    pub parts: Vec<usize>,
}

/// A cell of the tree.
struct Node {
    centre: Vector3<f64>,
    radius: f64,
    /// Its halves: bodies.
    parts: [usize; 2],
    /// Number of spheres, and the radii of the smallest and of the largest one.
    spheres: usize,
    radii: [f64; 2],
}

/// All spheres, and a binary tree of them.
pub(super) struct Tree<'a> {
    spheres: &'a Spheres,
    /// Radius of the smallest sphere.
    smallest: f64,
    /// Both parts of a cell come before it: the last one is the root.
    cells: Vec<Node>,
}

/// Bodies that couple.
pub(super) struct CoupledBodies {
    pub ends: [usize; 2],
    /// The orders, and those that neglect more; none of pairs of spheres.
    pub orders: Option<(PairOrders, PairOrders)>,
}

impl<'a> Tree<'a> {
    /// Cost: `O(n log n)`.
    pub fn new(spheres: &'a Spheres) -> Self {
        let mut tree = Self {
            spheres,
            smallest: spheres
                .radii()
                .iter()
                .copied()
                .fold(f64::INFINITY, f64::min),
            cells: Vec::with_capacity(spheres.len()),
        };
        let mut all: Vec<usize> = (0..spheres.len()).collect();
        if !all.is_empty() {
            tree.divide(&mut all);
        }
        tree
    }

    /// The body of some spheres: halves along the longest edge of their box.
    fn divide(&mut self, some: &mut [usize]) -> usize {
        if let &mut [sphere] = some {
            return sphere;
        }
        let x = self.spheres.centres();
        let (low, high) = some
            .iter()
            .fold((x[some[0]], x[some[0]]), |(low, high), &k| {
                (low.inf(&x[k]), high.sup(&x[k]))
            });
        let (centre, axis) = ((low + high) / 2.0, (high - low).imax());
        let reach = |&k: &usize| (x[k] - centre).norm() + self.spheres.radii()[k];
        let radius = some.iter().map(reach).fold(0.0, f64::max);
        let a = some.iter().map(|&k| self.spheres.radii()[k]);
        let radii = a.fold([f64::INFINITY, 0.0], |[low, high], a| {
            [a.min(low), a.max(high)]
        });
        let spheres = some.len();
        let middle = some.len() / 2;
        some.select_nth_unstable_by(middle, |&i, &j| {
            x[i][axis].total_cmp(&x[j][axis]).then(i.cmp(&j))
        });
        let (first, second) = some.split_at_mut(middle);
        let parts = [self.divide(first), self.divide(second)];
        self.cells.push(Node {
            centre,
            radius,
            parts,
            spheres,
            radii,
        });
        self.spheres.len() + self.cells.len() - 1
    }

    /// The cell of a body; none of a sphere.
    fn cell(&self, body: usize) -> Option<&Node> {
        self.cells.get(body.checked_sub(self.spheres.len())?)
    }

    fn centre(&self, body: usize) -> &Vector3<f64> {
        (self.cell(body)).map_or_else(|| &self.spheres.centres()[body], |cell| &cell.centre)
    }

    fn radius(&self, body: usize) -> f64 {
        (self.cell(body)).map_or_else(|| self.spheres.radii()[body], |cell| cell.radius)
    }

    /// Radii of the smallest and of the largest sphere in a body.
    fn radii(&self, body: usize) -> [f64; 2] {
        (self.cell(body)).map_or_else(|| [self.spheres.radii()[body]; 2], |cell| cell.radii)
    }

    fn count(&self, body: usize) -> usize {
        self.cell(body).map_or(1, |cell| cell.spheres)
    }

    /// Smallest bispherical coordinate of a sphere with all others.
    pub fn narrowest(&self, sphere: usize) -> f64 {
        let (x, a) = (self.spheres.centres()[sphere], self.spheres.radii()[sphere]);
        // at most that of any sphere in a body: it is lowest beside the smallest one
        let least = |body: usize| {
            let [smallest, _] = self.radii(body);
            let distance = (self.centre(body) - x).norm() - self.radius(body) + smallest;
            match distance > a + smallest {
                true => truncation::outside(distance, a, smallest).0,
                false => 0.0,
            }
        };
        let mut narrowest = f64::INFINITY;
        let root = self.cells.last().map(|root| root.parts);
        let mut open: Vec<(f64, usize)> = root.iter().flatten().map(|&part| (0.0, part)).collect();
        while let Some((found, body)) = open.pop() {
            match self.cell(body) {
                _ if found >= narrowest || body == sphere => {}
                None => narrowest = narrowest.min(least(body)),
                Some(cell) => {
                    let [first, second] = cell.parts.map(|part| (least(part), part));
                    // the nearer one is treated next
                    let is_nearer = first.0 < second.0;
                    open.extend(if is_nearer {
                        [second, first]
                    } else {
                        [first, second]
                    });
                }
            }
        }
        narrowest
    }

    /// All bodies that couple: each pair of spheres is in one pair of them.
    pub fn couples(&self, neglected: Neglected) -> Vec<CoupledBodies> {
        let of_halves = |cell: &Node| self.couples_of(cell.parts, neglected);
        self.cells.par_iter().flat_map_iter(of_halves).collect()
    }

    /// The bodies in two bodies that couple.
    fn couples_of(&self, ends: [usize; 2], neglected: Neglected) -> Vec<CoupledBodies> {
        let cheapest = |ends| (ends, self.cheapest(ends, neglected));
        let (mut found, mut pairs) = (Vec::new(), vec![cheapest(ends)]);
        while let Some((ends, (operations, orders))) = pairs.pop() {
            if ends.iter().all(|&body| self.cell(body).is_none()) {
                found.push(CoupledBodies { ends, orders: None });
                continue;
            }
            let divided = self.divided(ends).map(cheapest);
            let [(_, (first, _)), (_, (second, _))] = divided;
            if orders.is_some() && operations <= first + second {
                found.push(CoupledBodies { ends, orders });
            } else {
                pairs.extend(divided);
            }
        }
        found
    }

    /// A pair with the larger body divided, which is a cell.
    fn divided(&self, ends: [usize; 2]) -> [[usize; 2]; 2] {
        let of = |body: usize| self.cell(body).map_or(0.0, |cell| cell.radius);
        let end = usize::from(of(ends[0]) < of(ends[1]));
        let parts = self.cell(ends[end]).map_or(ends, |cell| cell.parts);
        parts.map(|part| {
            let mut divided = ends;
            divided[end] = part;
            divided
        })
    }

    /// Operations of two bodies, and the orders at which they couple with those that neglect more;
    /// none if the pairs of their spheres take fewer.
    fn cheapest(
        &self,
        ends: [usize; 2],
        neglected: Neglected,
    ) -> (usize, Option<(PairOrders, PairOrders)>) {
        let distance = self.distance(ends);
        let [first, second] = ends.map(|body| self.radius(body));
        let [[_, a], [_, b]] = ends.map(|body| self.radii(body));
        let of = |orders: PairOrders| pair_product::operations(orders, orders[0].max(orders[1]));
        let of_cells = |orders: PairOrders| SLOWER * of(orders);
        let of_pair = truncation::for_pair(distance.max(a + b), a, b, neglected.of_spheres);
        let of_pair = [of_pair.0, of_pair.1].map(|order| order.clamp(LOWEST_ORDER, MAX_CELL_ORDER));
        let by_spheres = self.count(ends[0]) * self.count(ends[1]) * of(of_pair);
        // also the nearest spheres in them are distant
        let is_distant = distance - first - second > DISTANT * (a + b);
        if self.spheres.len() < MANY
            || !is_distant
            || ends.iter().all(|&body| self.cell(body).is_none())
        {
            return (by_spheres, None);
        }
        let reach = [distance - second, distance - first];
        let with = |neglected| [0, 1].map(|end| self.order(ends[end], reach[end], neglected));
        let orders = with(neglected);
        if orders.iter().any(|&order| order > MAX_CELL_ORDER) || of_cells(orders) >= by_spheres {
            return (by_spheres, None);
        }
        let fewer = with(neglected.more());
        let fewer = [0, 1].map(|end| fewer[end].min(orders[end] - 1));
        (of_cells(orders), Some((orders, fewer)))
    }

    fn distance(&self, [first, second]: [usize; 2]) -> f64 {
        (self.centre(second) - self.centre(first)).norm()
    }

    /// Order of a body for other surfaces at a distance of `reach` from its centre.
    ///
    /// What touches the ball around a cell has a flow that decays as `(radius/reach)^l`.
    fn order(&self, body: usize, reach: f64, neglected: Neglected) -> usize {
        let (radius, [_, own]) = (self.radius(body), self.radii(body));
        // distance of the centres of the nearest spheres, of which a large one beside a small one
        // needs most
        let nearest = (reach - radius).max(0.0) + own + self.smallest;
        let of_spheres = truncation::for_pair(nearest, own, self.smallest, neglected.of_spheres).0;
        let of_cell = match self.cell(body) {
            Some(_) => {
                let decay = (reach / radius).max(1.0).ln();
                (-neglected.of_cells.ln() / decay).ceil() as usize
            }
            None => 0,
        };
        of_spheres.max(of_cell).max(LOWEST_ORDER)
    }

    /// The cells that couple, with their orders and parts, and the bodies that take the place of
    /// those of the tree: of spheres themselves, none of other cells.
    pub fn coupled_cells(self, couples: &[CoupledBodies], neglected: Neglected) -> CoupledCells {
        let n = self.spheres.len();
        // smallest distances of the centres from surfaces for which flows are needed
        let mut reach = vec![f64::INFINITY; n + self.cells.len()];
        for CoupledBodies { ends, .. } in couples.iter().filter(|couple| couple.orders.is_some()) {
            let distance = self.distance(*ends);
            for end in 0..2 {
                let other = self.radius(ends[1 - end]);
                reach[ends[end]] = reach[ends[end]].min(distance - other);
            }
        }
        let mut around = vec![None; n + self.cells.len()];
        for (number, cell) in self.cells.iter().enumerate() {
            for part in cell.parts {
                around[part] = Some(n + number);
            }
        }
        // with those of the cells around a body; none if its flow is not needed
        let order = |body: usize| {
            let (mut least, mut cell) = (reach[body], around[body]);
            while let Some(other) = cell {
                least = least.min(reach[other] - self.distance([other, body]));
                cell = around[other];
            }
            let is_needed = least.is_finite();
            is_needed.then(|| self.order(body, least, neglected))
        };
        let mut bodies: Vec<Option<usize>> = (0..n).map(Some).collect();
        let mut cells = Vec::new();
        for (number, cell) in self.cells.iter().enumerate() {
            let is_coupled = reach[n + number].is_finite();
            bodies.push(is_coupled.then_some(n + cells.len()));
            if is_coupled {
                let (mut parts, mut open) = (Vec::new(), cell.parts.to_vec());
                while let Some(part) = open.pop() {
                    match bodies[part] {
                        Some(body) => parts.push(body),
                        None => open.extend(&self.cells[part - n].parts),
                    }
                }
                // what it passes on to cells around it has no more degrees than these
                let order = order(n + number).unwrap_or_default();
                cells.push(Cell {
                    order: order.min(MAX_CELL_ORDER),
                    centre: cell.centre,
                    radius: cell.radius,
                    parts,
                });
            }
        }
        CoupledCells {
            of_spheres: (0..n)
                .map(|sphere| order(sphere).unwrap_or_default())
                .collect(),
            cells,
            bodies,
        }
    }
}

/// What couples of a tree.
pub(super) struct CoupledCells {
    pub cells: Vec<Cell>,
    /// Orders of the spheres as parts of cells; zero of those in none.
    pub of_spheres: Vec<usize>,
    /// Number of each body of the tree among the spheres and these cells; none of other cells.
    pub bodies: Vec<Option<usize>>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two clusters of spheres of two sizes, and lonely ones.
    fn spheres() -> Spheres {
        let cluster = |k: usize| {
            let cell = Vector3::new((k % 6) as f64, (k / 6 % 6) as f64, (k / 36) as f64);
            let shift = Vector3::new(0.2 * (k as f64).sin(), 0.0, 0.3 * (k as f64).cos());
            2.6 * cell + shift
        };
        let lonely = |k: usize| Vector3::new(40.0 + 9.0 * k as f64, -30.0, 5.0 * k as f64);
        let centres = (0..200).map(cluster);
        let centres = centres.chain((0..90).map(|k| cluster(k) + Vector3::new(3.0, 45.0, -8.0)));
        let centres: Vec<_> = centres.chain((0..5).map(lonely)).collect();
        let radii = (0..centres.len()).map(|k| [1.0, 0.6][k % 2]).collect();
        Spheres::new(centres, radii).unwrap()
    }

    const NEGLECTED: Neglected = Neglected {
        of_spheres: 1e-6,
        of_cells: 1e-3,
    };

    #[test]
    fn each_pair_of_spheres_couples_once_and_far_enough() {
        let spheres = spheres();
        let n = spheres.len();
        let tree = Tree::new(&spheres);
        let inside = |body: usize| {
            let (mut found, mut open) = (Vec::new(), vec![body]);
            while let Some(body) = open.pop() {
                match tree.cell(body) {
                    Some(cell) => open.extend(&cell.parts),
                    None => found.push(body),
                }
            }
            found
        };
        let mut coupled = vec![0; n * n];
        let couples = tree.couples(NEGLECTED);
        for CoupledBodies { ends, orders } in &couples {
            let [first, second] = ends.map(inside);
            assert_eq!(
                orders.is_none(),
                first.len() * second.len() == 1 && ends.iter().all(|&b| b < n)
            );
            for &i in &first {
                for &j in &second {
                    coupled[i * n + j] += 1;
                    coupled[j * n + i] += 1;
                    let distance = (spheres.centres()[i] - spheres.centres()[j]).norm();
                    let gap = distance - spheres.radii()[i] - spheres.radii()[j];
                    assert!(orders.is_none() || gap > DISTANT * 1.2, "{gap}");
                }
            }
        }
        for i in 0..n {
            for j in 0..n {
                assert_eq!(coupled[i * n + j], usize::from(i != j), "{i} {j}");
            }
        }
        assert!(couples.len() < n * (n - 1) / 6, "{}", couples.len());
    }

    /// The bound of a cell was that of its largest sphere: a small one in a gap was not found.
    #[test]
    fn bug_a_small_sphere_in_the_cell_of_a_large_one_had_no_narrow_gap() {
        let centres = [
            [1.03, 0.0],
            [-2.05, 0.0],
            [11.03, 0.0],
            [21.03, 0.0],
            [0.0, 0.0],
        ];
        let centres = centres.map(|[x, y]| Vector3::new(x, y, 0.0));
        let radii = vec![0.02, 1.0, 1.0, 0.02, 1.0];
        let spheres = Spheres::new(centres.to_vec(), radii).unwrap();
        let exact = truncation::outside(1.03, 1.0, 0.02).0;
        assert_eq!(Tree::new(&spheres).narrowest(4), exact);
        assert!(exact < truncation::outside(2.05, 1.0, 1.0).0);
    }

    #[test]
    fn the_narrowest_gap_of_a_sphere_is_that_of_all_pairs() {
        let spheres = spheres();
        let tree = Tree::new(&spheres);
        let (x, a) = (spheres.centres(), spheres.radii());
        for i in 0..spheres.len() {
            let others = (0..spheres.len()).filter(|&j| j != i);
            let xi = others.map(|j| truncation::outside((x[j] - x[i]).norm(), a[i], a[j]).0);
            assert_eq!(tree.narrowest(i), xi.fold(f64::INFINITY, f64::min));
        }
    }

    /// Every sphere of a cell is in one of its parts, and cells come after their parts.
    #[test]
    fn cells_that_couple_are_made_of_all_their_spheres() {
        let spheres = spheres();
        let n = spheres.len();
        let tree = Tree::new(&spheres);
        let couples = tree.couples(NEGLECTED);
        let counts: Vec<usize> = (0..n + tree.cells.len())
            .map(|body| tree.count(body))
            .collect();
        let coupled = tree.coupled_cells(&couples, NEGLECTED);
        let mut of_bodies = vec![1; n];
        for cell in &coupled.cells {
            let parts = cell.parts.iter().map(|&part| of_bodies[part]);
            of_bodies.push(parts.sum::<usize>());
        }
        for (body, count) in coupled.bodies.iter().zip(counts) {
            assert!(body.is_none_or(|body| of_bodies[body] == count));
        }
        assert!(coupled.cells.len() > 10, "{}", coupled.cells.len());
    }
}
