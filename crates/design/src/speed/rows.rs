//! Linear functions with few coefficients, and their bounds.

use nalgebra::{DMatrix, DVector};

use crate::evaluation::Bounds;

/// Rows of a matrix `Φ` with the bounds of `Φ x`.
pub struct SparseRows {
    /// Indices and coefficients of each row.
    rows: Vec<Vec<(usize, f64)>>,
    columns: usize,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl SparseRows {
    /// No rows, for this number of variables.
    pub fn new(columns: usize) -> Self {
        Self {
            rows: Vec::new(),
            columns,
            lower: Vec::new(),
            upper: Vec::new(),
        }
    }

    /// Adds a row with its bounds, one of which may be infinite.
    pub fn push(&mut self, row: Vec<(usize, f64)>, bounds: (f64, f64)) {
        self.rows.push(row);
        self.lower.push(bounds.0);
        self.upper.push(bounds.1);
    }

    /// Number of variables.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The bounds.
    pub fn bounds(&self) -> Bounds {
        Bounds {
            lower: DVector::from_column_slice(&self.lower),
            upper: DVector::from_column_slice(&self.upper),
        }
    }

    /// `Φ x`.
    pub fn product(&self, x: &DVector<f64>) -> DVector<f64> {
        let value = |row: &Vec<(usize, f64)>| row.iter().map(|(k, c)| c * x[*k]).sum::<f64>();
        DVector::from_iterator(self.rows.len(), self.rows.iter().map(value))
    }

    /// `Φ^T values`.
    pub fn transposed(&self, values: &DVector<f64>) -> DVector<f64> {
        let mut sum = DVector::zeros(self.columns);
        for (row, value) in self.rows.iter().zip(values.iter()) {
            for (k, coefficient) in row {
                sum[*k] += coefficient * value;
            }
        }
        sum
    }

    /// `Φ^T diag(weights) Φ`.
    pub fn weighted_product(&self, weights: &DVector<f64>) -> DMatrix<f64> {
        let mut product = DMatrix::zeros(self.columns, self.columns);
        for (row, weight) in self.rows.iter().zip(weights.iter()) {
            for (i, a) in row {
                for (j, b) in row {
                    product[(*i, *j)] += weight * a * b;
                }
            }
        }
        product
    }
}
