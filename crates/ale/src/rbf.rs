//! Extension by radial basis functions centred at the boundary vertices.

use mesh::Vec3;
use nalgebra::{DMatrix, Matrix4x3, RowVector3, Vector4};
use rayon::prelude::*;

use crate::{AleError, MeshMotion, MovingMesh};

/// A radial basis function of the distance `r`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kernel {
    /// `φ(r) = r`, the fundamental solution of the biharmonic equation in three dimensions.
    Linear,
    /// `φ(r) = r^3`, the fundamental solution of the triharmonic equation; smoother.
    #[default]
    Cubic,
}

/// Interpolation of the displacements of all boundary vertices `x_j` by radial basis functions
/// (de Boer, van der Schoot & Bijl, Computers & Structures 85, 2007).
///
/// ```text
/// d(X) = sum_j α_j φ(|X - x_j|) + a + A X,   sum_j α_j = 0,   sum_j α_j x_j = 0
/// ```
///
/// It uses no connectivity. Cost for `n_B` boundary vertices: a dense factorisation with `n_B^3`
/// operations and `8 n_B^2` bytes, and `n_B` evaluations of `φ` per vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rbf(
    /// The radial basis function `φ`.
    pub Kernel,
);

/// Largest number of boundary vertices, for which the matrix takes 200 MB and half a minute.
const MAX_CENTRES: usize = 5000;

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

    fn extend(&self, moving: &MovingMesh<'_>, fields: &mut [Vec<Vec3>]) -> Result<usize, AleError> {
        moving.check(fields)?;
        // Coordinates scaled to order one, so that polynomial and kernel rows have similar
        // magnitude.
        let [low, high] = moving.mesh.bounding_box();
        let scale = 1.0 / (high - low).amax();
        let position = |vertex: usize| scale * (moving.mesh.points()[vertex] - low);
        let fixed: Vec<usize> = (0..moving.prescribed.len())
            .filter(|&vertex| moving.prescribed[vertex])
            .collect();
        if fixed.len() > MAX_CENTRES {
            return Err(AleError::TooManyCentres {
                centres: fixed.len(),
                limit: MAX_CENTRES,
            });
        }
        let centres: Vec<Vec3> = fixed.iter().map(|&vertex| position(vertex)).collect();
        let n = centres.len();
        let polynomial = |x: &Vec3, k: usize| if k == 0 { 1.0 } else { x[k - 1] };
        let matrix = DMatrix::from_fn(n + 4, n + 4, |i, j| match (i < n, j < n) {
            (true, true) => self.0.at((centres[i] - centres[j]).norm()),
            (true, false) => polynomial(&centres[i], j - n),
            (false, true) => polynomial(&centres[j], i - n),
            (false, false) => 0.0,
        });
        let rhs = DMatrix::from_fn(n + 4, 3 * fields.len(), |i, j| {
            if i < n {
                fields[j / 3][fixed[i]][j % 3]
            } else {
                0.0
            }
        });
        let weights = matrix.lu().solve(&rhs).ok_or(AleError::Singular)?;
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
                    let x = position(vertex);
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
        Ok(0)
    }
}
