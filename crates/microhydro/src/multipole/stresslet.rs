//! Stresslets of spheres: the second degree of the force density.

use std::f64::consts::PI;

use faer::Mat;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::coupling::Expansion;
use super::frame::Frame;
use super::modes::Family;
use super::orders::Orders;
use super::slip_expansion::{self, SlipExpansion, SphereSlip};
use super::surface_orders::SurfaceOrders;
use super::system::{MultiVector, System};
use crate::{HydroError, Medium, Spheres};

/// Stresslets of spheres with their estimated errors. Viscosity 1.
///
/// The stresslet has the sign of Batchelor (1970): with the traction `σ n` of the fluid on the
/// sphere, the normal `n` out of it, and positions `x` relative to its centre
///
/// ```text
/// S = ∮ [(σ n) x^T + x (σ n)^T] / 2 - I (x · σ n) / 3 - (u n^T + n u^T) dS
/// ```
///
/// It is symmetric without trace, and `20π/3 a^3 E` for a rigid sphere in the strain `E`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SphereStresslets {
    /// The stresslet of each sphere.
    pub values: Vec<Matrix3<f64>>,
    /// Estimated errors: what expansions whose orders are lower by two change, times the factor of
    /// what remains, and the stresslets of the errors of the velocities.
    pub errors: Vec<Matrix3<f64>>,
    /// Error of the iteration and rounding, relative to the largest stresslet.
    pub rounding: f64,
    /// Relative remainder of the surface velocity in its expansion, see [`SphereSlip`]; zero
    /// without one.
    pub remainder: f64,
}

/// Stresslets of spheres with given velocities, and surfaces that move relative to them.
///
/// The first array has the velocities, six entries `(U, ω)` per sphere; the second one their
/// estimated errors with the signs of a change to the order below, zeros for given velocities: at a
/// lower order free spheres in a narrow gap move such that the stresslets change little.
/// `surface_velocity` is relative to this motion and to the background flow, `None` for rigid
/// surfaces in a fluid at rest. `orders` are those of the resistance,
/// [`crate::Resistance::orders`]. The error is of the order of that of the resistance, because a
/// stresslet tests the flow with a velocity in the lowest modes. Orders are raised to those that
/// the [`SphereSlip`] needs. The high degrees of narrow gaps are eliminated for their two surfaces
/// alone. Cost: three solves off an axis.
///
/// ```
/// use microhydro::{Accuracy, Medium, Spheres, multipole};
/// use nalgebra::{DMatrix, DVector, Vector3};
/// let sphere = Spheres::new(vec![Vector3::zeros()], vec![2.0])?;
/// let orders = multipole::resistance(&sphere, &Medium::Unbounded, &Accuracy::relative(1e-6))?;
/// // A free sphere in the extension u = (x, -y, 0): the surface moves with -u relative to it.
/// let against = |_: usize, n: &Vector3<f64>| 2.0 * Vector3::new(-n.x, n.y, 0.0);
/// let at_rest = DVector::zeros(6);
/// let (orders, motion) = (orders.orders(), [&at_rest, &at_rest]);
/// let found = multipole::stresslets(&sphere, &Medium::Unbounded, orders, motion, Some(&against))?;
/// let exact = 20.0 / 3.0 * std::f64::consts::PI * 8.0;
/// assert!((found.values[0][(0, 0)] / exact - 1.0).abs() < 1e-12);
/// # Ok::<(), microhydro::HydroError>(())
/// ```
///
/// # Errors
/// Spheres outside the medium; [`HydroError::Length`] for velocities of the wrong length;
/// [`HydroError::SlipNotResolved`]; [`HydroError::NetFlux`]; [`HydroError::TooLarge`];
/// [`HydroError::NotConverged`]; [`HydroError::NotFinite`].
pub fn stresslets(
    spheres: &Spheres,
    medium: &Medium,
    orders: &Orders,
    [velocities, velocity_errors]: [&DVector<f64>; 2],
    surface_velocity: Option<&SphereSlip<'_>>,
) -> Result<SphereStresslets, HydroError> {
    slip_expansion::check(spheres, medium)?;
    let frame = Frame::new(spheres, medium);
    let slip = surface_velocity
        .map(|slip| SlipExpansion::new(&frame, spheres.radii(), &[slip]))
        .transpose()?;
    // The lower order must contain `W_2` and the surface velocities too.
    let lowest = match &slip {
        Some(slip) => slip.orders(medium, 2),
        None => Orders::all(spheres.len(), medium, 4),
    };
    let orders = SurfaceOrders {
        spheres,
        medium,
        frame: &frame,
        of_resistance: orders,
        lowest: &lowest,
        columns: 2,
    };
    let found = orders.estimate(&|system, included, x| {
        let moving =
            |velocities, slip| slip_expansion::of_moving_spheres(system, &frame, velocities, slip);
        let (of_motion, of_errors) = (
            moving(velocities, slip.as_ref())?,
            moving(velocity_errors, None)?,
        );
        let both = |(motion, error): (&Mat<f64>, &Mat<f64>)| {
            let column = [motion, error];
            Mat::from_fn(motion.nrows(), 2, |row, k| column[k][(row, 0)])
        };
        let rhs = of_motion.iter().zip(&of_errors).map(both).collect();
        let target = slip_expansion::MAX_SURFACE_RESIDUAL * slip_expansion::largest(&rhs);
        system.solve(&system.mask(included), &rhs, x, target)?;
        let of_sphere = |stresslet: Matrix3<f64>| DMatrix::from_fn(3, 3, |i, j| stresslet[(i, j)]);
        let found = [0, 1]
            .into_iter()
            .flat_map(|column| of_densities(system, &frame, x, column));
        Ok(found.map(of_sphere).collect())
    })?;
    let fixed = |matrix: &DMatrix<f64>| Matrix3::from_fn(|i, j| matrix[(i, j)]);
    let values: Vec<Matrix3<f64>> = found.values.iter().map(fixed).collect();
    let (values, of_errors) = values.split_at(spheres.len());
    let changes = values
        .iter()
        .zip(found.coarser.iter().map(fixed))
        .zip(of_errors);
    Ok(SphereStresslets {
        errors: changes
            .map(|((value, coarser), of_error)| found.tail * (coarser - value) + of_error)
            .collect(),
        values: values.to_vec(),
        rounding: slip_expansion::SURFACE_ROUNDING,
        remainder: slip.map_or(0.0, |slip| slip.remainder),
    })
}

/// Stresslets of the force densities of a column of a solution.
///
/// The density with the velocity `W_2 = 2 A n` on the sphere, `Y_2 = n · A n`, is `5 / a` of it,
/// and `∮ (A n) n^T dS = 4π/3 a^2 A`. Other modes have no symmetric first moment. The density is
/// the traction on the fluid outside minus that of the flow inside, whose moment is the integral of
/// `u n^T + n u^T` in the stresslet.
fn of_densities(
    system: &System,
    frame: &Frame,
    x: &MultiVector,
    column: usize,
) -> Vec<Matrix3<f64>> {
    let rotation = frame.to_axes.to_rotation_matrix();
    let expansions = system.expansions.iter().zip(x).take(system.spheres);
    let stresslet = |(expansion, x): (&Expansion, &Mat<f64>)| {
        let rows = expansion.modes.shell(Family::Stokeslet, 2);
        let modes: Vec<f64> = rows.map(|row| x[(row, column)]).collect();
        let local = stresslet_of_modes(expansion, &modes);
        rotation.matrix().transpose() * local * rotation.matrix()
    };
    expansions.map(stresslet).collect()
}

/// Stresslet of the five modes `W_2` of an expansion.
pub(super) fn stresslet_of_modes(expansion: &Expansion, modes: &[f64]) -> Matrix3<f64> {
    let weight = expansion.weight(Family::Stokeslet, 2);
    let moments = modes.iter().zip(second_harmonics());
    let moment: Matrix3<f64> = moments.map(|(x, harmonic)| harmonic * (x / weight)).sum();
    moment * (-40.0 * PI / 3.0 * expansion.radius.powi(2))
}

/// Matrices `A` of the real orthonormal harmonics `Y_2m = n · A n`, for `m = -2 ..= 2`.
fn second_harmonics() -> [Matrix3<f64>; 5] {
    let product = |i: usize, j: usize| {
        let mut matrix = Matrix3::zeros();
        matrix[(i, j)] = 0.25 * (15.0 / PI).sqrt();
        matrix[(j, i)] = matrix[(i, j)];
        matrix
    };
    let diagonal = |x: f64, y: f64, z: f64| Matrix3::from_diagonal(&Vector3::new(x, y, z));
    [
        product(0, 1),
        product(1, 2),
        0.25 * (5.0 / PI).sqrt() * diagonal(-1.0, -1.0, 2.0),
        product(0, 2),
        0.25 * (15.0 / PI).sqrt() * diagonal(1.0, -1.0, 0.0),
    ]
}
