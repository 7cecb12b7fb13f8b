//! Motion of force-free spheres whose surfaces move: squirmers, spheres in a background flow.

use faer::Mat;
use nalgebra::DMatrix;

use super::frame::Frame;
use super::interior;
use super::modes::{Family, Modes};
use super::orders::Orders;
use super::rotation::AXIS_OF_M;
use super::scaled::drag_units;
use super::slip_expansion::{self, SURFACE_ROUNDING, SlipExpansion, SphereSlip};
use super::surface_orders::SurfaceOrders;
use super::system::{MultiVector, System};
use crate::error::check_finite;
use crate::{HydroError, Medium, Spheres};

/// Velocities of force-free spheres whose surfaces move relative to them, and the power for it.
///
/// With the surface velocities `s_i` (columns) and the grand resistance `R`, spheres with the
/// velocities `U` exert the forces
///
/// ```text
/// F = R (U - sum_i U_i)
/// ```
///
/// on the fluid, where `U_i` are the velocities of force-free spheres with `s_i`. The powers are
/// `P_ij = ∮ s_i · f_j dS` with the forces `f_j` of the surface on the fluid while the spheres move
/// with `U_j`; the matrix is symmetric. Viscosity 1. Spheres whose radii change have surface
/// velocities with a flux, see [`SphereSlip`]; a single one of radius `a` dissipates `16π a a'^2`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfaceFlow {
    /// `(U, ω)` of each sphere: six rows per sphere, one column per surface velocity.
    pub velocities: DMatrix<f64>,
    /// The powers `P_ij`.
    pub powers: DMatrix<f64>,
    /// Powers `∮ s_i · t_j dS` of the tractions `t_j = σ n` of the flows inside the spheres with
    /// the velocities `s_j` on their surfaces.
    pub inner_powers: DMatrix<f64>,
    /// The velocities by expansions whose orders are lower by two; with narrow gaps extrapolated,
    /// so that they differ from [`SurfaceFlow::velocities`] by the estimated error.
    pub coarser_velocities: DMatrix<f64>,
    /// The powers by these expansions.
    pub coarser_powers: DMatrix<f64>,
    /// Velocities that differ from [`SurfaceFlow::velocities`] by the error of the iteration and
    /// rounding.
    pub rounded_velocities: DMatrix<f64>,
    /// Powers that differ from [`SurfaceFlow::powers`] by the error of the iteration and rounding.
    pub rounded_powers: DMatrix<f64>,
    /// Factor that turns the change of the order into an error estimate.
    pub tail: f64,
    /// Largest relative remainder of the surface velocities in their expansions, see
    /// [`SphereSlip`].
    pub remainder: f64,
}

/// Solves for the motion of force-free spheres with given surface velocities.
///
/// `orders` are those of the resistance of the spheres, [`crate::Resistance::orders`], and are
/// raised to those that the surface velocities need. The error of the velocities is of the order of
/// that of the resistance if the surface velocities are in the lowest modes; the change from
/// [`SurfaceFlow::coarser_velocities`] times [`SurfaceFlow::tail`] estimates it in all cases.
/// The high degrees of narrow gaps are eliminated for their two surfaces alone, as for the
/// resistance. Cost: three solves of the system of spheres off an axis for all columns, the
/// elimination in narrow gaps, and the expansion of the [`SphereSlip`]s.
///
/// ```
/// use microhydro::{Accuracy, Medium, Spheres, multipole};
/// use nalgebra::{Vector3, DVector};
/// let sphere = Spheres::new(vec![Vector3::zeros()], vec![1.0])?;
/// let orders = multipole::resistance(&sphere, &Medium::Unbounded, &Accuracy::relative(1e-6))?;
/// // a squirmer with the first mode alone swims at two thirds of it (Lighthill 1952)
/// let k = Vector3::z();
/// let slip = |_: usize, n: &Vector3<f64>| n * n.dot(&k) - k;
/// let flow =
///     multipole::surface_flow(&sphere, &Medium::Unbounded, orders.orders(), &[&slip])?;
/// assert!((flow.velocities[(2, 0)] - 2.0 / 3.0).abs() < 1e-12);
/// # Ok::<(), microhydro::HydroError>(())
/// ```
///
/// # Errors
/// Spheres outside the medium; [`HydroError::SlipNotResolved`]; [`HydroError::NetFlux`];
/// [`HydroError::TooLarge`]; [`HydroError::NotConverged`]; [`HydroError::NotFinite`].
pub fn surface_flow(
    spheres: &Spheres,
    medium: &Medium,
    orders: &Orders,
    surface_velocities: &[&SphereSlip<'_>],
) -> Result<SurfaceFlow, HydroError> {
    slip_expansion::check(spheres, medium)?;
    let frame = Frame::new(spheres, medium);
    let slip = SlipExpansion::new(&frame, spheres.radii(), surface_velocities)?;
    let columns = surface_velocities.len();
    let orders = SurfaceOrders {
        spheres,
        medium,
        frame: &frame,
        of_resistance: orders,
        // The lower order must contain the surface velocities too.
        lowest: &slip.orders(medium, 2),
        columns,
    };
    let found = orders.estimate(&|system, included, x| {
        let traces = slip.traces_of_rest(system);
        let target = slip_expansion::MAX_SURFACE_RESIDUAL * slip_expansion::largest(&traces);
        system.solve(&not_rigid(system, included), &traces, x, target)?;
        let inner_powers = interior::powers(
            &system.expansions[..system.spheres],
            &slip.traces(&system.expansions),
        );
        let (velocities, powers) = motion(system, &frame, spheres, &traces, x);
        let powers = powers - &inner_powers + slip.sources().powers();
        Ok(vec![velocities, powers, inner_powers])
    })?;
    for matrix in found.values.iter().chain(&found.coarser) {
        check_finite("the velocity of a surface", matrix)?;
    }
    let matrix = |of: &[DMatrix<f64>], index: usize| of.get(index).cloned().unwrap_or_default();
    let (velocities, powers) = (matrix(&found.values, 0), matrix(&found.values, 1));
    Ok(SurfaceFlow {
        rounded_velocities: with_rounding(&velocities, spheres.radii(), &slip.speeds),
        rounded_powers: &powers * (1.0 + SURFACE_ROUNDING),
        velocities,
        powers,
        inner_powers: matrix(&found.values, 2),
        coarser_velocities: matrix(&found.coarser, 0),
        coarser_powers: matrix(&found.coarser, 1),
        tail: found.tail,
        remainder: slip.remainder,
    })
}

/// Velocities with the errors of the iteration and rounding for surfaces of the largest `speeds`,
/// one for each column.
///
/// The signs alternate between neighbours, so that the gaps between them change.
fn with_rounding(velocities: &DMatrix<f64>, radii: &[f64], speeds: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(velocities.nrows(), velocities.ncols(), |row, column| {
        let sphere = row / 6;
        let sign = if sphere % 2 == 0 { 1.0 } else { -1.0 };
        let error = sign * SURFACE_ROUNDING * speeds[column];
        let is_rotation = row % 6 >= 3;
        let error = if is_rotation {
            error / radii[sphere]
        } else {
            error
        };
        velocities[(row, column)] + error
    })
}

/// Which modes are not rigid motions of spheres, among those `included`.
fn not_rigid(system: &System, included: &dyn Fn(Modes, Family, usize) -> bool) -> Vec<Vec<bool>> {
    let mut mask = system.mask(included);
    for (sphere, mask) in mask.iter_mut().enumerate().take(system.spheres) {
        for row in system.rigid_rows(sphere) {
            mask[row] = false;
        }
    }
    mask
}

/// Velocities and powers of a solution `x` without forces and torques.
///
/// With the rigid modes `r` and all others `h`, the velocities are `A_rh x_h - t_r` for the traces
/// `t`, and the powers are `t_h^T x_h`,
/// with those of the flows inside the spheres.
fn motion(
    system: &System,
    frame: &Frame,
    spheres: &Spheres,
    traces: &MultiVector,
    x: &MultiVector,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let columns = traces.first().map_or(0, Mat::ncols);
    let product = system.apply(x);
    let units = drag_units(spheres.radii());
    let mut velocities = DMatrix::zeros(6 * spheres.len(), columns);
    for sphere in 0..spheres.len() {
        for (k, row) in system.rigid_rows(sphere).into_iter().enumerate() {
            for column in 0..columns {
                let scaled = product[sphere][(row, column)] - traces[sphere][(row, column)];
                let physical = 6 * sphere + 3 * (k / 3) + AXIS_OF_M[k % 3];
                velocities[(physical, column)] = scaled / units[6 * sphere + k];
            }
        }
    }
    let to_laboratory = frame.to_axes.inverse();
    for first in (0..velocities.nrows()).step_by(3) {
        for column in 0..columns {
            let local = velocities.fixed_view::<3, 1>(first, column).into_owned();
            let rotated = to_laboratory * local;
            velocities
                .fixed_view_mut::<3, 1>(first, column)
                .copy_from(&rotated);
        }
    }
    let mut powers = DMatrix::zeros(columns, columns);
    // Rigid modes of x are zero.
    for (trace, x) in traces.iter().zip(x) {
        let block = trace.transpose() * x;
        powers += DMatrix::from_fn(columns, columns, |i, j| block[(i, j)]);
    }
    (velocities, (&powers + powers.transpose()) * 0.5)
}
