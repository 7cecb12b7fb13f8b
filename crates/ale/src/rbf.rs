//! Extension by radial basis functions on the boundary's vertices.

use mesh::Vec3;
use nalgebra::{DMatrix, Matrix4x3, RowVector3, Vector4};
use rayon::prelude::*;

use crate::{AleError, MeshMotion, MovingMesh};

/// A radial function of the distance `r`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kernel {
    /// $r$, the fundamental solution of the biharmonic equation in space.
    Linear,
    /// $r^3$, that of the triharmonic equation: smoother.
    #[default]
    Cubic,
}

/// $d(X) = \sum_j \alpha_j \varphi(|X - x_j|) + a + A X$ through the displacements of all boundary vertices $x_j$, with $\sum_j \alpha_j = 0$ and
/// $\sum_j \alpha_j x_j = 0$ (de Boer, van der Schoot & Bijl, Computers & Structures 85, 2007).
///
/// No mesh is needed. Cost: a dense factorisation, $n_B^3$ operations and $8 n_B^2$ bytes for $n_B$ boundary vertices, and $n_B$ evaluations a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rbf(
    /// The radial function.
    pub Kernel,
);

/// Boundary vertices at most: 200 MB and half a minute.
const MOST_CENTRES: usize = 5000;

impl Kernel {
    fn at(self, r: f64) -> f64 {
        match self {
            Self::Linear => r,
            Self::Cubic => r * r * r,
        }
    }
}

impl MeshMotion for Rbf {
    fn name(&self) -> &'static str {
        match self.0 {
            Kernel::Linear => "rbf-linear",
            Kernel::Cubic => "rbf-cubic",
        }
    }

    fn is_scalar(&self) -> bool {
        true
    }

    fn extend(&self, moving: &MovingMesh<'_>, fields: &mut [Vec<Vec3>]) -> Result<(), AleError> {
        // Coordinates of size one: rows of the polynomial and of the kernel are then of one size.
        let [low, high] = moving.mesh.bounding_box();
        let scale = 1.0 / (high - low).amax();
        let place = |vertex: usize| scale * (moving.mesh.points()[vertex] - low);
        let fixed: Vec<usize> = (0..moving.prescribed.len())
            .filter(|&vertex| moving.prescribed[vertex])
            .collect();
        if fixed.len() > MOST_CENTRES {
            return Err(AleError::TooManyCentres {
                centres: fixed.len(),
                most: MOST_CENTRES,
            });
        }
        let centres: Vec<Vec3> = fixed.iter().map(|&vertex| place(vertex)).collect();
        let n = centres.len();
        let polynomial = |x: &Vec3, k: usize| if k == 0 { 1.0 } else { x[k - 1] };
        let matrix = DMatrix::from_fn(n + 4, n + 4, |i, j| match (i < n, j < n) {
            (true, true) => self.0.at((centres[i] - centres[j]).norm()),
            (true, false) => polynomial(&centres[i], j - n),
            (false, true) => polynomial(&centres[j], i - n),
            (false, false) => 0.0,
        });
        let right = DMatrix::from_fn(n + 4, 3 * fields.len(), |i, j| {
            if i < n {
                fields[j / 3][fixed[i]][j % 3]
            } else {
                0.0
            }
        });
        let weights = matrix.lu().solve(&right).ok_or(AleError::Singular)?;
        if weights.iter().any(|w| !w.is_finite()) {
            return Err(AleError::Singular);
        }
        for (number, field) in fields.iter_mut().enumerate() {
            let weights = weights.columns(3 * number, 3);
            let alpha: Vec<RowVector3<f64>> = (0..n)
                .map(|j| RowVector3::from_fn(|_, c| weights[(j, c)]))
                .collect();
            let affine = Matrix4x3::from_fn(|k, c| weights[(n + k, c)]);
            field.par_iter_mut().enumerate().for_each(|(vertex, d)| {
                if !moving.prescribed[vertex] {
                    let x = place(vertex);
                    let ones = Vector4::new(1.0, x.x, x.y, x.z);
                    let radial: RowVector3<f64> = alpha
                        .iter()
                        .zip(&centres)
                        .map(|(a, centre)| a * self.0.at((x - centre).norm()))
                        .sum();
                    *d = (radial + ones.transpose() * affine).transpose();
                }
            });
        }
        Ok(())
    }
}
