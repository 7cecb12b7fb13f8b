//! Direct solution of unsymmetric element systems by nested static condensation.
//!
//! Elements are merged in pairs, along a binary tree of geometric bisections. As soon as all
//! elements of a degree of freedom are merged, it is eliminated by a dense LU factorisation with
//! partial pivoting ([`super::front`]; the multifrontal method, Duff & Reid 1983, on the tree of
//! nested dissection, George 1973). For `N` unknowns in the plane this takes `N^1.5` time and `N
//! log N` memory.
//!
//! The block that is eliminated belongs to velocities and pressures in the interior of a union of
//! triangles. Pressures in the interior vanish on the boundary of the union, so that no constant is
//! among them, and the block is regular where the whole system is.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::front::{Eliminated, eliminate};
use crate::curve::Point;

/// The unknown of each row of an element matrix; `None` for rows and columns that are left out.
pub(crate) type ElementUnknowns = Vec<Option<u32>>;

/// The order in which the unknowns of a list of elements are eliminated.
pub(crate) struct NestedCondensation {
    root: Branch,
    n_unknowns: usize,
}

/// A union of elements.
struct Branch {
    part: Part,
    /// Unknowns that no other element has, in ascending order.
    inner: Vec<u32>,
    /// Unknowns shared with other elements, in ascending order.
    outer: Vec<u32>,
}

enum Part {
    /// The number of an element, and the places of its unknowns.
    Element(usize, Places),
    /// Two branches, and the places of their outer unknowns.
    Halves(Box<[Branch; 2]>, [Places; 2]),
}

/// Rows of a matrix in that of a branch, in which inner unknowns come first; `None` for rows and
/// columns that are left out.
type Places = Vec<Option<u32>>;

/// The factors of a system.
pub(crate) struct CondensedFactors {
    symbolic: Arc<NestedCondensation>,
    root: Factor,
}

/// The elimination of the inner unknowns of a branch.
struct Factor {
    halves: Option<Box<[Factor; 2]>>,
    /// `None` if there are no inner unknowns.
    eliminated: Option<Eliminated>,
}

/// A singular block of the elements around this one.
#[derive(Debug)]
pub(crate) struct Singular {
    pub element: usize,
}

impl NestedCondensation {
    /// The order of elimination for elements with these unknowns and centres.
    ///
    /// `unknowns[e]` lists the unknowns of element `e`, below `n_unknowns`, in the order of its
    /// matrix. One may occur twice: its rows and columns are then added. The unknowns `kept` are
    /// not eliminated.
    pub fn new(
        unknowns: Vec<ElementUnknowns>,
        centres: &[Point],
        n_unknowns: usize,
        kept: &[u32],
    ) -> Self {
        let mut elements = vec![0; n_unknowns];
        for list in &unknowns {
            for id in distinct(list) {
                elements[id as usize] += 1;
            }
        }
        for id in kept {
            // more elements than there are, so that they never all are merged
            elements[*id as usize] = u32::MAX;
        }
        let mut numbered: Vec<_> = unknowns.into_iter().enumerate().collect();
        let (root, _) = Branch::new(&mut numbered, centres, &elements);
        Self { root, n_unknowns }
    }

    /// Factorises the system whose element matrices are `matrix(e)`, in parallel.
    ///
    /// # Errors
    /// Those of `matrix`, and [`Singular`].
    pub fn factor<E: From<Singular> + Send>(
        self: &Arc<Self>,
        matrix: &(impl Fn(usize) -> Result<DMatrix<f64>, E> + Sync),
    ) -> Result<CondensedFactors, E> {
        let (root, _) = self.root.factor(matrix)?;
        Ok(CondensedFactors {
            symbolic: Arc::clone(self),
            root,
        })
    }

    /// The Schur complement of the kept unknowns, in ascending order.
    ///
    /// # Errors
    /// Those of [`NestedCondensation::factor`].
    pub fn condensed<E: From<Singular> + Send>(
        &self,
        matrix: &(impl Fn(usize) -> Result<DMatrix<f64>, E> + Sync),
    ) -> Result<DMatrix<f64>, E> {
        Ok(self.root.factor(matrix)?.1)
    }
}

impl CondensedFactors {
    /// The solution for a right-hand side, which has one number per unknown.
    ///
    /// Unknowns without an element are zero.
    pub fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; self.symbolic.n_unknowns];
        let mut rhs = rhs.to_vec();
        self.root.forward(&self.symbolic.root, &mut rhs, &mut x);
        self.root.backward(&self.symbolic.root, &mut x);
        x
    }
}

impl Branch {
    /// The tree over some elements, and the number of these that each outer unknown is in.
    fn new(
        elements: &mut [(usize, ElementUnknowns)],
        centres: &[Point],
        total: &[u32],
    ) -> (Self, Vec<(u32, u32)>) {
        let (branches, counts) = match elements {
            [(_, unknowns)] => {
                let counts = distinct(unknowns).into_iter().map(|id| (id, 1)).collect();
                (None, counts)
            }
            _ => {
                sort_along_extent(elements, centres);
                let (left, right) = elements.split_at_mut(elements.len() / 2);
                let (left, first) = Self::new(left, centres, total);
                let (right, second) = Self::new(right, centres, total);
                let mut counts: Vec<(u32, u32)> = first.into_iter().chain(second).collect();
                counts.sort_unstable();
                counts.dedup_by(|next, kept| {
                    let same = next.0 == kept.0;
                    if same {
                        kept.1 += next.1;
                    }
                    same
                });
                (Some(Box::new([left, right])), counts)
            }
        };
        let (inner, outer): (Vec<_>, Vec<_>) =
            (counts.into_iter()).partition(|(id, count)| *count == total[*id as usize]);
        let inner: Vec<u32> = inner.into_iter().map(|(id, _)| id).collect();
        let later: Vec<u32> = outer.iter().map(|(id, _)| *id).collect();
        let place = |id: &u32| match inner.binary_search(id) {
            Ok(k) => Some(k as u32),
            Err(_) => (later.binary_search(id).ok()).map(|k| (inner.len() + k) as u32),
        };
        let part = match (branches, elements) {
            (Some(branches), _) => {
                let places = |half: usize| branches[half].outer.iter().map(place).collect();
                let places = [0, 1].map(places);
                Part::Halves(branches, places)
            }
            (None, [(number, unknowns), ..]) => {
                let places = unknowns.iter().map(|id| id.as_ref().and_then(place));
                Part::Element(*number, places.collect())
            }
            // no branch without elements
            (None, []) => Part::Element(0, Vec::new()),
        };
        let branch = Self {
            part,
            inner,
            outer: later,
        };
        (branch, outer)
    }

    /// The elimination of this branch and the matrix of its outer unknowns after it.
    fn factor<E: From<Singular> + Send>(
        &self,
        matrix: &(impl Fn(usize) -> Result<DMatrix<f64>, E> + Sync),
    ) -> Result<(Factor, DMatrix<f64>), E> {
        let size = self.inner.len() + self.outer.len();
        let mut sum = DMatrix::zeros(size, size);
        let halves = match &self.part {
            Part::Element(number, places) => {
                add(&matrix(*number)?, places, &mut sum);
                None
            }
            Part::Halves(halves, places) => {
                let [left, right] = halves.as_ref();
                let (first, second) = rayon::join(|| left.factor(matrix), || right.factor(matrix));
                let ((first, of_first), (second, of_second)) = (first?, second?);
                add(&of_first, &places[0], &mut sum);
                add(&of_second, &places[1], &mut sum);
                Some(Box::new([first, second]))
            }
        };
        if self.inner.is_empty() {
            let factor = Factor {
                halves,
                eliminated: None,
            };
            return Ok((factor, sum));
        }
        let Some((eliminated, outer)) = eliminate(sum, self.inner.len()) else {
            let element = self.first_element();
            return Err(Singular { element }.into());
        };
        let factor = Factor {
            halves,
            eliminated: Some(eliminated),
        };
        Ok((factor, outer))
    }

    fn first_element(&self) -> usize {
        match &self.part {
            Part::Element(number, _) => *number,
            Part::Halves(halves, _) => halves[0].first_element(),
        }
    }
}

/// Adds a matrix to that of a branch, in which its rows and columns have these places.
fn add(matrix: &DMatrix<f64>, places: &Places, sum: &mut DMatrix<f64>) {
    let placed = places.iter().enumerate();
    let placed: Vec<(usize, usize)> = placed
        .filter_map(|(from, to)| Some((from, (*to)? as usize)))
        .collect();
    let (rows, rows_of_sum) = (matrix.nrows(), sum.nrows());
    let (values, sums) = (matrix.as_slice(), sum.as_mut_slice());
    for &(from, to) in &placed {
        let column = &values[from * rows..(from + 1) * rows];
        let sum = &mut sums[to * rows_of_sum..(to + 1) * rows_of_sum];
        for &(row, place) in &placed {
            sum[place] += column[row];
        }
    }
}

impl Factor {
    /// Eliminates the inner unknowns from the right-hand side.
    fn forward(&self, branch: &Branch, rhs: &mut [f64], x: &mut [f64]) {
        if let (Some(factors), Part::Halves(branches, _)) = (&self.halves, &branch.part) {
            for (factor, branch) in factors.iter().zip(branches.iter()) {
                factor.forward(branch, rhs, x);
            }
        }
        let Some(eliminated) = &self.eliminated else {
            return;
        };
        let mut values = gather(&branch.inner, rhs);
        let change = eliminated.forward(&mut values);
        for (id, value) in branch.outer.iter().zip(change.iter()) {
            rhs[*id as usize] -= value;
        }
        for (id, value) in branch.inner.iter().zip(values.iter()) {
            x[*id as usize] = *value;
        }
    }

    /// Inserts the outer unknowns.
    fn backward(&self, branch: &Branch, x: &mut [f64]) {
        if let Some(eliminated) = &self.eliminated {
            let mut values = gather(&branch.inner, x);
            eliminated.backward(&mut values, &gather(&branch.outer, x));
            for (id, value) in branch.inner.iter().zip(values.iter()) {
                x[*id as usize] = *value;
            }
        }
        if let (Some(factors), Part::Halves(branches, _)) = (&self.halves, &branch.part) {
            for (factor, branch) in factors.iter().zip(branches.iter()) {
                factor.backward(branch, x);
            }
        }
    }
}

fn gather(ids: &[u32], from: &[f64]) -> DVector<f64> {
    DVector::from_iterator(ids.len(), ids.iter().map(|id| from[*id as usize]))
}

/// The unknowns of an element, in ascending order.
fn distinct(unknowns: &[Option<u32>]) -> Vec<u32> {
    let mut list: Vec<u32> = unknowns.iter().flatten().copied().collect();
    list.sort_unstable();
    list.dedup();
    list
}

/// Sorts elements from left to right or from below to above, along the longer extent.
fn sort_along_extent<T>(elements: &mut [(usize, T)], centres: &[Point]) {
    let infinite = Point::repeat(f64::INFINITY);
    let (low, high) = (elements.iter()).fold((infinite, -infinite), |(low, high), (e, _)| {
        (low.inf(&centres[*e]), high.sup(&centres[*e]))
    });
    let axis = usize::from(high.y - low.y > high.x - low.x);
    elements.sort_by(|(one, _), (other, _)| {
        let by_centre = centres[*one][axis].total_cmp(&centres[*other][axis]);
        by_centre.then(one.cmp(other))
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unknowns, centres and matrices of elements.
    type Chain = (Vec<ElementUnknowns>, Vec<Point>, Vec<DMatrix<f64>>);

    /// A chain of elements of three unknowns each: two ends, and one inside. All share the last
    /// unknown, and the first one is left out.
    fn chain(n: usize) -> Chain {
        let last = 2 * n as u32 + 1;
        let unknowns = (0..n as u32).map(|e| {
            let first = (e > 0).then_some(2 * e);
            vec![first, Some(2 * e + 1), Some(2 * e + 2), Some(last)]
        });
        let centres = (0..n).map(|e| Point::new(e as f64, 0.3 * (e % 3) as f64));
        let matrices = (0..n).map(|e| {
            DMatrix::from_fn(4, 4, |i, j| {
                let generic = ((7 * e + 5 * i + 3 * j) as f64).sin();
                if i == j { 3.0 + generic } else { generic }
            })
        });
        (unknowns.collect(), centres.collect(), matrices.collect())
    }

    #[test]
    fn solutions_are_those_of_the_dense_unsymmetric_system() {
        for n in [1, 2, 13] {
            let (unknowns, centres, matrices) = chain(n);
            let size = 2 * n + 2;
            let mut dense = DMatrix::<f64>::zeros(size, size);
            dense[(0, 0)] = 1.0;
            for (unknowns, matrix) in unknowns.iter().zip(&matrices) {
                for (i, row) in unknowns.iter().enumerate() {
                    for (j, column) in unknowns.iter().enumerate() {
                        if let (Some(row), Some(column)) = (row, column) {
                            dense[(*row as usize, *column as usize)] += matrix[(i, j)];
                        }
                    }
                }
            }
            let condensation = Arc::new(NestedCondensation::new(unknowns, &centres, size, &[]));
            let matrix = |e: usize| Ok::<_, Singular>(matrices[e].clone());
            let factors = condensation.factor(&matrix).expect("regular");
            let exact = DVector::from_fn(size, |i, _| if i == 0 { 0.0 } else { (i as f64).cos() });
            let found = factors.solve((&dense * &exact).as_slice());
            for (found, exact) in found.iter().zip(exact.iter()) {
                assert!((found - exact).abs() < 1e-12, "{n}: {found} {exact}");
            }
        }
    }

    #[test]
    fn kept_unknowns_are_left_with_their_schur_complement() {
        let (unknowns, centres, matrices) = chain(6);
        let matrix = |e: usize| Ok::<_, Singular>(matrices[e].clone());
        let kept = [4, 13];
        let whole = Arc::new(NestedCondensation::new(unknowns.clone(), &centres, 14, &[]));
        let factors = whole.factor(&matrix).expect("regular");
        let schur = NestedCondensation::new(unknowns, &centres, 14, &kept)
            .condensed(&matrix)
            .expect("regular");
        // the inverse of the Schur complement is a block of the inverse
        let block = DMatrix::from_fn(2, 2, |i, j| {
            let mut unit = [0.0; 14];
            unit[kept[j] as usize] = 1.0;
            factors.solve(&unit)[kept[i] as usize]
        });
        assert!((schur * block - DMatrix::identity(2, 2)).amax() < 1e-12);
    }

    #[test]
    fn singular_systems_are_refused() {
        let (unknowns, centres, matrices) = chain(5);
        let condensation = Arc::new(NestedCondensation::new(unknowns, &centres, 12, &[]));
        let matrix = |e: usize| Ok::<_, Singular>(0.0 * &matrices[e]);
        assert!(condensation.factor(&matrix).is_err());
    }
}
