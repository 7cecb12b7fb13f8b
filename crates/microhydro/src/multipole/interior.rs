//! Power of surface velocities on the fluid that would be inside the spheres.
//!
//! The force density of an expansion is the difference of the tractions outside and inside its
//! sphere. A rigid motion has no stress inside, other velocities do: their power on the fluid
//! outside is that of the density minus the power inside.
//!
//! The flow inside has Lamb's coefficients `φ`, `χ`, `p` of [`super::lamb`] for the harmonics of
//! the trace. With `t = -p n + ∂u/∂r - u/r + ∇(r·u)/r` (Kim & Karrila 1991, section 4.2.1) its
//! traction on the unit sphere is
//!
//! ```text
//! φ: 2 (k - 1) W_k,     χ: (k - 1) X_k,     p: (α + β / (2k + 1)) W_k - β / (2k + 1) V_k
//! α = 2 k c_k - e_k,    β = 2 k c_k - (k + 2) e_k - 1
//! ```

use faer::Mat;
use nalgebra::DMatrix;

use super::coupling::Expansion;
use super::lamb::{c, e};
use super::modes::Family;
use super::system::MultiVector;

/// Powers `∮ s_i · t_j dS` of the tractions inside the spheres, for the traces of velocities.
///
/// The matrix is symmetric.
pub(super) fn powers(expansions: &[Expansion], traces: &MultiVector) -> DMatrix<f64> {
    let columns = traces.first().map_or(0, Mat::ncols);
    let mut powers = DMatrix::zeros(columns, columns);
    for (expansion, trace) in expansions.iter().zip(traces) {
        let modes = expansion.modes;
        for l in 1..=modes.max_degree(Family::Stokeslet) {
            // Modes that the expansion does not have are zero.
            let coefficient = |family: Family, k: usize, column: usize| match modes
                .contains(family, l)
            {
                true => {
                    trace[(modes.shell(family, l).start + k, column)] / expansion.weight(family, l)
                }
                false => 0.0,
            };
            let degree = l as f64;
            let shear = degree - 1.0;
            let norms = [
                degree * (2.0 * degree + 1.0),
                degree * (degree + 1.0),
                (degree + 1.0) * (2.0 * degree + 1.0),
            ];
            let (alpha, beta) = (
                2.0 * degree * c(l) - e(l),
                2.0 * degree * c(l) - (degree + 2.0) * e(l) - 1.0,
            );
            let radial = e(l) / (2.0 * degree + 1.0);
            let share = beta / (2.0 * degree + 1.0);
            for k in 0..2 * l + 1 {
                let trace = |column: usize| {
                    [Family::Stokeslet, Family::Rotlet, Family::Source]
                        .map(|family| coefficient(family, k, column))
                };
                for j in 0..columns {
                    let [w, x, v] = trace(j);
                    let p = v / radial;
                    let phi = w - (c(l) - radial) * p;
                    let traction = [
                        2.0 * shear * phi + (alpha + share) * p,
                        shear * x,
                        -share * p,
                    ];
                    for i in 0..columns {
                        let terms = trace(i).into_iter().zip(traction).zip(norms);
                        let sum: f64 = terms.map(|((s, t), norm)| s * t * norm).sum();
                        powers[(i, j)] += expansion.radius * sum;
                    }
                }
            }
        }
    }
    powers
}
