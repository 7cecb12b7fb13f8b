//! Products of the equations in cubic velocities and quadratic pressures on one cell.
//!
//! These products take a third of the time of a corrected solution. At run time `pulp` selects the
//! version that is compiled for the vector instructions of the processor. A function is part of
//! that version only if it is `inline(always)` and contains no closures.

use nalgebra::Matrix3;
use pulp::NullaryFnOnce;

use super::cubic_tables::{
    AffineCell, AffineMap, CurvedCell, Divergence, Stiffness, Vectors, reference_divergence,
};

/// Element matrices of a cell.
pub(super) enum Cell {
    Affine(AffineMap),
    Curved(Box<CurvedCell>),
}

/// Values of one cell, or rows of a product: velocities by component, and pressures.
#[derive(Default)]
pub(super) struct CellValues {
    pub coarse: CoarseValues,
    pub bubbles: Vectors,
    pub edges: [f64; 6],
}

/// Values or rows of one cell for quadratic velocities and linear pressures.
#[derive(Default)]
pub(super) struct CoarseValues {
    pub nodes: Vectors,
    pub linear: [f64; 4],
}

impl Cell {
    /// Divergence tables, and the matrix that maps their components to components in space.
    ///
    /// `J^-T det J` for an affine cell, whose tables are those of the reference cell.
    #[inline(always)]
    fn divergence(&self) -> (&Divergence, Matrix3<f64>) {
        match self {
            Self::Affine(map) => (reference_divergence(), AffineCell::new(map).pull),
            Self::Curved(cell) => (&cell.divergence, Matrix3::identity()),
        }
    }
}

/// Writes all rows of [`product`](super::cubic::CubicExtension::product) of a cell.
pub(super) struct Product<'a> {
    pub cell: &'a Cell,
    pub values: &'a CellValues,
    pub rows: &'a mut CellValues,
}

impl NullaryFnOnce for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { cell, values, rows } = self;
        let CellValues {
            coarse: CoarseValues { nodes, linear },
            bubbles,
            edges,
        } = values;
        let affine;
        let stiffness = match cell {
            Cell::Affine(map) => {
                affine = Stiffness::affine(&AffineCell::new(map));
                &affine
            }
            Cell::Curved(cell) => &cell.stiffness,
        };
        // Local sums stay in registers.
        let mut to_bubbles = ZERO;
        stiffness.add_to_bubbles(nodes, bubbles, &mut to_bubbles);
        let mut to_nodes = ZERO;
        stiffness.add_to_nodes(bubbles, &mut to_nodes);

        let (divergence, pull) = cell.divergence();
        let of_bubbles = pulled(&pull, bubbles);
        rows.coarse.linear = divergence.linear.minus_divergence(&of_bubbles);
        let of_nodes = pulled(&pull, nodes);
        let of_bubbles = divergence.edges.minus_divergence(&of_bubbles);
        let of_nodes = divergence.from_nodes.minus_divergence(&of_nodes);
        for ((row, a), b) in rows.edges.iter_mut().zip(of_bubbles).zip(of_nodes) {
            *row = a + b;
        }

        let mut gradient = ZERO;
        divergence.from_nodes.add_gradient(edges, &mut gradient);
        rows.coarse.nodes = minus_pushed(to_nodes, &pull, &gradient);
        let mut gradient = ZERO;
        divergence.linear.add_gradient(linear, &mut gradient);
        divergence.edges.add_gradient(edges, &mut gradient);
        rows.bubbles = minus_pushed(to_bubbles, &pull, &gradient);
    }
}

/// Writes the rows of [`coarse_rows`](super::cubic::CubicExtension::coarse_rows) of a cell.
pub(super) struct CoarseRows<'a> {
    pub cell: &'a Cell,
    pub bubbles: &'a Vectors,
    pub edges: &'a [f64; 6],
    pub rows: &'a mut CoarseValues,
}

impl NullaryFnOnce for CoarseRows<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            cell,
            bubbles,
            edges,
            rows,
        } = self;
        let mut to_nodes = ZERO;
        match cell {
            Cell::Affine(map) => Stiffness::affine_between_nodes_and_bubbles(&AffineCell::new(map))
                .add_to_nodes(bubbles, &mut to_nodes),
            Cell::Curved(cell) => cell.stiffness.add_to_nodes(bubbles, &mut to_nodes),
        }
        let (divergence, pull) = cell.divergence();
        rows.linear = (divergence.linear).minus_divergence(&pulled(&pull, bubbles));
        let mut gradient = ZERO;
        divergence.from_nodes.add_gradient(edges, &mut gradient);
        rows.nodes = minus_pushed(to_nodes, &pull, &gradient);
    }
}

/// Writes the rows of [`gradient`](super::cubic::CubicExtension::gradient) of a cell.
pub(super) struct Gradient<'a> {
    pub cell: &'a Cell,
    pub edges: &'a [f64; 6],
    pub rows: &'a mut Vectors,
}

impl NullaryFnOnce for Gradient<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (divergence, pull) = self.cell.divergence();
        let mut gradient = ZERO;
        divergence.edges.add_gradient(self.edges, &mut gradient);
        *self.rows = minus_pushed(ZERO, &pull, &gradient);
    }
}

const ZERO: Vectors = [[0.0; 10]; 3];

/// Velocities in the components of the divergence tables: `pull^T` times those in space.
#[inline(always)]
fn pulled(pull: &Matrix3<f64>, velocities: &Vectors) -> Vectors {
    let [x, y, z] = velocities;
    let mut result = ZERO;
    for (d, result) in result.iter_mut().enumerate() {
        let (a, b, c) = (pull[(0, d)], pull[(1, d)], pull[(2, d)]);
        for k in 0..10 {
            result[k] = a * x[k] + b * y[k] + c * z[k];
        }
    }
    result
}

/// `rows - pull gradient`, with `gradient` in the components of the divergence tables.
#[inline(always)]
fn minus_pushed(mut rows: Vectors, pull: &Matrix3<f64>, gradient: &Vectors) -> Vectors {
    let [x, y, z] = gradient;
    for (c, rows) in rows.iter_mut().enumerate() {
        let (a, b, c) = (pull[(c, 0)], pull[(c, 1)], pull[(c, 2)]);
        for k in 0..10 {
            rows[k] -= a * x[k] + b * y[k] + c * z[k];
        }
    }
    rows
}
