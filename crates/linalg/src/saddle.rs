//! The bordered saddle-point system.

use std::ops::Range;
use std::sync::Arc;

use crate::bordered::nodes;
use crate::columns::{assert_lengths, in_passes, split, split_mut};
use crate::csr::{Rows, check_finite, check_shape, diagonal, into_rows, positive_diagonal};
use crate::node_kernel::long_row;
use crate::row_blocks::RowBlocks;
use crate::transpose::transpose;
use crate::{Bordered, Csr, Csr3, LinalgError, LinearOperator};

/// A saddle-point system on vectors `[velocity: 3n | border: m | pressure: np]`.
///
/// ```text
/// [ K (x) I3   C    B^T  ]
/// [ C_l^T      M    E_l^T]      C_l = C and E_l = E unless given
/// [ B          E     0   ]
/// ```
///
/// The blocks are named after incompressible flow, where `B` (np x n, entries 3-vectors) and `E`
/// (np x m) are the discrete divergence `-∫ q div v`, and `B^T` and `E^T` the gradient. A velocity
/// node has three interleaved components. The pressure mass matrix serves the preconditioners: with
/// the factor `1 / viscosity` it approximates the Schur complement.
///
/// `B` is stored with its transpose (56 bytes per pair of entries), so that both products gather.
/// Cloning a system shares its matrices.
///
/// Cost of [`apply`](LinearOperator::apply): one pass over `K`, `B` and `B^T`; allocates nothing,
/// and is bitwise the same on any number of threads.
#[derive(Debug, Clone)]
pub struct SaddleSystem {
    blocks: Arc<Blocks>,
}

#[derive(Debug)]
struct Blocks {
    a: Bordered,
    b: Csr3,
    bt: Csr3,
    e: Csr,
    /// `E_l^T`, m x np.
    et: Csr,
    e_left: Option<Csr>,
    pressure_mass: Csr,
    pressure_blocks: RowBlocks,
    weights: Vec<f32>,
}

impl SaddleSystem {
    /// Assembles the system after checking its blocks.
    ///
    /// Shapes must fit, values be finite, the diagonal of the mass matrix positive, and the
    /// divergence large enough to count in a residual norm.
    ///
    /// # Errors
    /// [`LinalgError::Shape`], [`LinalgError::NotFinite`], [`LinalgError::NotPositive`],
    /// [`LinalgError::Unbalanced`].
    pub fn new(
        a: Bordered,
        b: Csr3,
        e: Csr,
        e_left: Option<Csr>,
        pressure_mass: Csr,
    ) -> Result<Self, LinalgError> {
        let (n, m, np) = (a.nodes(), a.border_len(), pressure_mass.rows());
        check_shape("pressure mass matrix", pressure_mass.shape(), (np, np))?;
        check_shape("divergence B", b.shape(), (np, n))?;
        check_shape("border divergence E", e.shape(), (np, m))?;
        check_finite("pressure mass matrix", pressure_mass.data())?;
        check_finite("divergence B", b.data().as_flattened())?;
        check_finite("border divergence E", e.data())?;
        if let Some(left) = &e_left {
            check_shape("left border divergence E_l", left.shape(), (np, m))?;
            check_finite("left border divergence E_l", left.data())?;
        }
        let mass_diagonal = positive_diagonal("pressure mass matrix", &pressure_mass)?;
        check_balance(&a, &b, &e)?;
        let weights = residual_weights(&a, &mass_diagonal);
        let (b, e) = (into_rows(b), into_rows(e));
        let e_left = e_left.map(into_rows);
        Ok(SaddleSystem {
            blocks: Arc::new(Blocks {
                bt: transpose(&b),
                et: transpose(e_left.as_ref().unwrap_or(&e)),
                pressure_blocks: RowBlocks::new(Rows::new(&b).indptr),
                pressure_mass: into_rows(pressure_mass),
                a,
                b,
                e,
                e_left,
                weights,
            }),
        })
    }

    /// The velocity and border block `[K (x) I3, C; C_l^T, M]`.
    pub fn velocity_block(&self) -> &Bordered {
        &self.blocks.a
    }

    /// The divergence `B`, np x n.
    pub fn divergence(&self) -> &Csr3 {
        &self.blocks.b
    }

    /// The gradient `B^T`, n x np.
    #[cfg(feature = "direct")]
    pub(crate) fn gradient(&self) -> &Csr3 {
        &self.blocks.bt
    }

    /// The divergence of the border motions `E`, np x m.
    pub fn border_divergence(&self) -> &Csr {
        &self.blocks.e
    }

    /// The left border divergence `E_l`, np x m, if it differs from `E`.
    pub fn border_divergence_left(&self) -> Option<&Csr> {
        self.blocks.e_left.as_ref()
    }

    /// `E_l^T`, m x np.
    #[cfg(feature = "direct")]
    pub(crate) fn border_gradient(&self) -> &Csr {
        &self.blocks.et
    }

    /// The pressure mass matrix, np x np, with the factor `1 / viscosity`.
    pub fn pressure_mass(&self) -> &Csr {
        &self.blocks.pressure_mass
    }

    /// Positions of the velocity dofs, `0..3n`.
    pub fn velocity_range(&self) -> Range<usize> {
        0..3 * self.blocks.a.nodes()
    }

    /// Positions of the border dofs, `3n..3n+m`.
    pub fn border_range(&self) -> Range<usize> {
        self.velocity_range().end..self.blocks.a.rows()
    }

    /// Positions of the pressure dofs, `3n+m..3n+m+np`.
    pub fn pressure_range(&self) -> Range<usize> {
        self.blocks.a.rows()..self.rows()
    }

    /// The function `i -> (B^T p)_i` for every column `p`.
    pub(crate) fn gradient_rows<const S: usize>(
        &self,
        p: [&[f64]; S],
    ) -> impl Fn(usize) -> [[f64; 3]; S] + Sync {
        let bt = Rows::new(&self.blocks.bt);
        move |i| {
            let mut gradient = [[0.0; 3]; S];
            add_gradient(bt, i, p, &mut gradient);
            gradient
        }
    }

    /// Computes `y = B^T p` on velocity rows.
    ///
    /// # Panics
    /// For vectors of wrong lengths.
    pub fn apply_gradient(&self, p: &[f64], y: &mut [f64]) {
        let lengths = (self.pressure_range().len(), self.velocity_range().len());
        assert_eq!((p.len(), y.len()), lengths, "lengths of p and y");
        let gradient = self.gradient_rows([p]);
        let y = crate::bordered::nodes_mut(y);
        let rows = self.blocks.a.node_blocks();
        rows.for_each(y, &|i, yi| [*yi] = gradient(i));
    }

    /// Computes `y = B u + E v` on pressure rows, with the velocity `u` and the border `v`.
    ///
    /// # Panics
    /// For vectors of wrong lengths.
    pub fn apply_divergence(&self, u: &[f64], v: &[f64], y: &mut [f64]) {
        let ranges = [
            self.velocity_range(),
            self.border_range(),
            self.pressure_range(),
        ];
        let found = [u.len(), v.len(), y.len()];
        assert_eq!(
            found,
            ranges.map(|range| range.len()),
            "lengths of u, v and y"
        );
        self.divergence_pass([u], [v], [y]);
    }

    /// `y <- y - E_l^T p` on border rows.
    pub(crate) fn subtract_border_gradient<const S: usize>(
        &self,
        p: [&[f64]; S],
        y: [&mut [f64]; S],
    ) {
        let gradient = self.border_gradient_rows(p);
        let rows = |rows: Range<usize>, mut y: [&mut [f64]; S]| {
            for (at, c) in rows.enumerate() {
                for (y, g) in y.iter_mut().zip(gradient(c)) {
                    y[at] -= g;
                }
            }
        };
        self.blocks.a.border_blocks().for_each_block(y, &rows);
    }

    /// The function `c -> (E_l^T p)_c` for every column `p`.
    fn border_gradient_rows<const S: usize>(
        &self,
        p: [&[f64]; S],
    ) -> impl Fn(usize) -> [f64; S] + Sync {
        let et = Rows::new(&self.blocks.et);
        move |c| long_row(et, c, |q| p.map(|p| p[q]))
    }

    /// `y <- B u + E v` on pressure rows.
    fn divergence_pass<const S: usize>(&self, u: [&[f64]; S], v: [&[f64]; S], y: [&mut [f64]; S]) {
        let (u, b, e) = (
            u.map(nodes),
            Rows::new(&self.blocks.b),
            Rows::new(&self.blocks.e),
        );
        let rows = |rows: Range<usize>, mut y: [&mut [f64]; S]| {
            for (at, q) in rows.enumerate() {
                let mut sums = [0.0; S];
                for (j, w) in b.row(q) {
                    for (sum, u) in sums.iter_mut().zip(u) {
                        let uj = u[j];
                        *sum += w[0] * uj[0] + w[1] * uj[1] + w[2] * uj[2];
                    }
                }
                for (c, w) in e.row(q) {
                    for (sum, v) in sums.iter_mut().zip(v) {
                        *sum += w * v[c];
                    }
                }
                for (y, sum) in y.iter_mut().zip(sums) {
                    y[at] = sum;
                }
            }
        };
        self.blocks.pressure_blocks.for_each_block(y, &rows);
    }

    fn pass<const S: usize>(&self, x: [&[f64]; S], y: [&mut [f64]; S]) {
        assert_lengths(&x, self.cols(), &y, self.rows());
        let (velocity, border) = (self.velocity_range().end, self.border_range().end);
        let (xa, p) = split(x, border);
        let (u, v) = split(xa, velocity);
        let (ya, yp) = split_mut(y, border);
        let (yu, yv) = split_mut(ya, velocity);
        let bt = Rows::new(&self.blocks.bt);
        self.blocks
            .a
            .apply_nodes(u, v, yu, |i, a| add_gradient(bt, i, p, a));
        self.blocks
            .a
            .apply_border(u, v, yv, self.border_gradient_rows(p));
        self.divergence_pass(u, v, yp);
    }
}

/// Reciprocal sizes of the rows, scaled so that they fit into f32.
///
/// The sizes are the diagonals of `K` and of the pressure mass matrix, which is close to the Schur
/// complement, and the largest entry of each row of the corner.
fn residual_weights(a: &Bordered, mass_diagonal: &[f64]) -> Vec<f32> {
    let stiffness = diagonal(a.stiffness());
    let border = a.corner().row_iter().map(|row| match row.amax() {
        0.0 => 1.0,
        largest => largest,
    });
    let sizes: Vec<f64> = stiffness
        .into_iter()
        .flat_map(|d| [d; 3])
        .chain(border)
        .chain(mass_diagonal.iter().copied())
        .collect();
    let smallest = sizes.iter().fold(f64::INFINITY, |m, &s| m.min(s));
    let weight = |size: &f64| ((smallest / size) as f32).max(f32::MIN_POSITIVE);
    sizes.iter().map(weight).collect()
}

/// Least ratio of the divergence to the stiffness.
///
/// Velocities are of size `b / K` and fluxes of size `B b / K`: below this ratio a residual of 1e-8
/// would allow more than 1e-4 of the divergence to go unnoticed.
const MIN_DIVERGENCE_RATIO: f64 = 1e-4;

/// Refuses a divergence that is small compared with the stiffness.
///
/// A large one needs no check: iterations then stagnate.
fn check_balance(a: &Bordered, b: &Csr3, e: &Csr) -> Result<(), LinalgError> {
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let divergence = largest(b.data().as_flattened()).max(largest(e.data()));
    let ratio = divergence / largest(&diagonal(a.stiffness()));
    if divergence > 0.0 && ratio < MIN_DIVERGENCE_RATIO {
        return Err(LinalgError::Unbalanced { ratio });
    }
    Ok(())
}

/// Adds `(B^T p)_i` of every column `p` to the same column of `a`.
#[inline(always)]
fn add_gradient<const S: usize>(
    bt: Rows<'_, [f64; 3]>,
    i: usize,
    p: [&[f64]; S],
    a: &mut [[f64; 3]; S],
) {
    for (q, w) in bt.row(i) {
        for (a, p) in a.iter_mut().zip(p) {
            let pq = p[q];
            a[0] += w[0] * pq;
            a[1] += w[1] * pq;
            a[2] += w[2] * pq;
        }
    }
}

impl LinearOperator for SaddleSystem {
    fn rows(&self) -> usize {
        self.blocks.a.rows() + self.blocks.pressure_mass.rows()
    }

    fn cols(&self) -> usize {
        self.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.pass([x], [y]);
    }

    fn apply_columns(&self, x: &[&[f64]], y: &mut [&mut [f64]]) {
        in_passes!(self.pass(x, y));
    }

    /// Reciprocal diagonals.
    ///
    /// The relative residual in this norm is about as large as the relative error of the border
    /// dofs. In the Euclidean norm it was 25 to 40 times smaller on the graded meshes measured.
    fn residual_weights(&self) -> Option<&[f32]> {
        Some(&self.blocks.weights)
    }

    /// Whether no left borders are given and the corner is symmetric.
    fn is_symmetric(&self) -> bool {
        self.blocks.a.is_symmetric() && self.blocks.e_left.is_none()
    }
}
