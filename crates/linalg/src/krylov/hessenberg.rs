//! The small least-squares problem of GMRES.

/// The least-squares problem `min ||beta e1 - H y||`, kept triangular by Givens rotations.
pub(super) struct Hessenberg {
    columns: Vec<Vec<f64>>,
    rotations: Vec<(f64, f64)>,
    rhs: Vec<f64>,
    y: Vec<f64>,
}

impl Hessenberg {
    /// The problem before the first step; it grows with the steps.
    pub fn new() -> Self {
        Hessenberg {
            columns: Vec::new(),
            rotations: Vec::new(),
            rhs: Vec::new(),
            y: Vec::new(),
        }
    }

    /// Starts a new cycle from a residual of norm `beta`.
    pub fn start(&mut self, beta: f64) {
        self.rhs.fill(0.0);
        self.rhs.resize(self.columns.len() + 1, 0.0);
        self.rhs[0] = beta;
    }

    /// Column `j`, whose first `j + 1` entries the caller fills.
    pub fn column(&mut self, j: usize) -> &mut [f64] {
        for known in self.columns.len()..=j {
            self.columns.push(vec![0.0; known + 2]);
            self.rotations.push((1.0, 0.0));
            self.rhs.push(0.0);
            self.y.push(0.0);
        }
        &mut self.columns[j]
    }

    /// Norm of column `j`, which rotations do not change.
    pub fn column_norm(&self, j: usize) -> f64 {
        self.columns[j].iter().map(|h| h * h).sum::<f64>().sqrt()
    }

    /// Finishes column `j` with `below` under the diagonal and returns the residual norm.
    pub fn rotate(&mut self, j: usize, below: f64) -> f64 {
        let column = &mut self.columns[j];
        for (i, &(c, s)) in self.rotations[..j].iter().enumerate() {
            let (a, b) = (column[i], column[i + 1]);
            column[i] = c * a + s * b;
            column[i + 1] = c * b - s * a;
        }
        let diagonal = column[j];
        let r = diagonal.hypot(below);
        let (c, s) = if r > 0.0 {
            (diagonal / r, below / r)
        } else {
            (1.0, 0.0)
        };
        column[j] = r;
        column[j + 1] = 0.0;
        self.rotations[j] = (c, s);
        self.rhs[j + 1] = -s * self.rhs[j];
        self.rhs[j] *= c;
        self.rhs[j + 1].abs()
    }

    /// The coefficients of the first `steps` vectors, zero at a singular last pivot.
    pub fn solve(&mut self, steps: usize) -> &[f64] {
        for i in (0..steps).rev() {
            let known: f64 = (i + 1..steps).map(|j| self.columns[j][i] * self.y[j]).sum();
            let pivot = self.columns[i][i];
            self.y[i] = if pivot.abs() > f64::EPSILON * self.column_norm(i) {
                (self.rhs[i] - known) / pivot
            } else {
                0.0
            };
        }
        &self.y[..steps]
    }
}
