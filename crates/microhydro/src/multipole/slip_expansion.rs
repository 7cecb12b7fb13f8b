//! Velocities of the surfaces of spheres in vector spherical harmonics: slip, background flow,
//! changes of the radii.

use faer::Mat;
use nalgebra::{DVector, Vector3};

use super::coupling::Expansion;
use super::frame::{Frame, Surroundings};
use super::interior;
use super::memory;
use super::modes::Modes;
use super::orders::Orders;
use super::rotation::AXIS_OF_M;
use super::scaled::drag_units;
use super::sources::Sources;
use super::system::{MultiVector, System};
use super::truncation::MAX_ORDER_OFF_AXIS;
use super::vector_harmonics::{VectorHarmonics, quadrature, spiral};
use crate::error::{check_entries, check_finite};
use crate::{HydroError, Medium, Spheres};

/// Velocity of the surface of a sphere relative to a rigid motion.
///
/// Arguments are the number of the sphere and the outward unit normal. It is expanded in vector
/// spherical harmonics. Velocities whose components are polynomials in the normal up to degree 25,
/// such as the squirming modes `B_1` to `B_24` (Blake 1971), are represented to rounding, others to
/// a relative remainder of `1e-8` if 26 orders suffice, as they do for smooth ones. The remainder
/// is measured at twice as many points as the expansion uses, as a root mean square over the sphere
/// relative to the largest root mean square of all spheres. Remainders above `1e-4` are refused
/// ([`HydroError::SlipNotResolved`]).
///
/// A net flux through a sphere that exceeds the remainder and `1e-12` is that of a sphere whose
/// radius changes: the flow has a source at its centre, `Q x / |x|^3` with `Q = a^2` times the mean
/// normal component. Beside a plane wall, and of [`SlipModes`], it is refused
/// ([`HydroError::NetFlux`]). In a container the wall lets out the sum of all fluxes uniformly, so
/// that sums of velocities for which it vanishes have the flow of a wall at rest.
///
/// Cost: the lowest order takes 384 evaluations per sphere and represents polynomials up to degree
/// three; the highest takes 16224 evaluations and tenths of a second.
pub type SphereSlip<'a> = dyn Fn(usize, &Vector3<f64>) -> Vector3<f64> + Sync + 'a;

/// Orders of the expansions that are tried, and the lowest order of all flows with slip.
///
/// An order contains the polynomials in the normal of lower degrees: the first one has the linear
/// and quadratic background flows and the squirming modes `B_1` and `B_2`. The last one leaves two
/// orders for the error estimate.
const SLIP_ORDERS: [usize; 4] = [4, 8, 16, MAX_ORDER_OFF_AXIS - 2];

/// Largest remainder of a slip velocity at which its order is not raised further.
///
/// The change of the power is of the order of its square.
const TARGET_REMAINDER: f64 = 1e-8;

/// Largest remainder of a slip velocity that is accepted at the highest order.
const MAX_REMAINDER: f64 = 1e-4;

/// Largest net flux that is rounding: 64 roundings of sums of the 1352 points of the highest order.
const ROUNDING_FLUX: f64 = 1e-12;

/// Residual of iterations with surface velocities, relative to the largest coefficient.
pub(super) const MAX_SURFACE_RESIDUAL: f64 = 1e-12;

/// Error of velocities by the residual of iterations and rounding, relative to the largest velocity
/// of a surface, and that of powers and stresslets relative to themselves.
///
/// The residual of the iteration, doubled. Errors in concentric gaps from 0.001 to 0.1 radii are
/// below it (test `squirmers_in_concentric_gaps_are_inside_the_bar`).
pub(super) const SURFACE_ROUNDING: f64 = 2.0 * MAX_SURFACE_RESIDUAL;

/// Slip velocities of all spheres in the modes of each one.
pub(super) struct SlipExpansion {
    spheres: Vec<SlipOfSphere>,
    columns: usize,
    /// Largest remainder over all spheres and velocities, relative to the largest root mean square
    /// of all spheres.
    pub remainder: f64,
    /// Root mean square of the velocities on the sphere where it is largest, one for each column.
    pub speeds: Vec<f64>,
    sources: Sources,
}

/// Slip of many spheres in unbounded fluid or in a periodic box, expanded for
/// [`super::MultipoleMobility`].
pub struct SlipModes {
    expansion: SlipExpansion,
}

impl SlipModes {
    /// Expands a slip velocity to the orders that it needs.
    ///
    /// # Errors
    /// [`HydroError::NotFinite`]; [`HydroError::SlipNotResolved`]; [`HydroError::NetFlux`] for a
    /// sphere whose volume changes.
    pub fn new(spheres: &Spheres, slip: &SphereSlip<'_>) -> Result<Self, HydroError> {
        let frame = Frame::laboratory(spheres);
        let expansion = SlipExpansion::expand(&frame, spheres.radii(), &[slip], false)?;
        Ok(Self { expansion })
    }

    /// Lowest order of a sphere that contains its slip; zero where there is none.
    pub(super) fn order(&self, sphere: usize) -> usize {
        let of = &self.expansion.spheres[sphere];
        if of.sizes[0] > 0.0 { of.modes.order } else { 0 }
    }

    /// Coefficients in scaled modes, and their power on the flow inside the spheres.
    pub(super) fn traces(&self, expansions: &[Expansion]) -> (MultiVector, f64) {
        let traces = self.expansion.traces(expansions);
        let power = interior::powers(expansions, &traces)[(0, 0)];
        (traces, power)
    }

    /// Root mean square of the velocities on the sphere where it is largest.
    pub(super) fn speed(&self) -> f64 {
        self.expansion.speeds[0]
    }
}

/// Slip velocities of one sphere, one column per velocity.
struct SlipOfSphere {
    modes: Modes,
    /// Coefficients in scaled modes.
    coefficients: Mat<f64>,
    /// Sum of the squared norms of all modes of each order, per column.
    squares: Vec<Vec<f64>>,
    /// Root mean square of the velocities.
    sizes: Vec<f64>,
    /// Root mean square of what the expansion and the flux lack.
    remainders: Vec<f64>,
    /// Mean normal component.
    fluxes: Vec<f64>,
}

impl SlipExpansion {
    /// Expands slip velocities to the orders that they need.
    ///
    /// # Errors
    /// [`HydroError::NotFinite`]; [`HydroError::SlipNotResolved`]; [`HydroError::NetFlux`].
    pub fn new(
        frame: &Frame,
        radii: &[f64],
        slips: &[&SphereSlip<'_>],
    ) -> Result<Self, HydroError> {
        let may_grow = frame.surroundings != Surroundings::Wall;
        Self::expand(frame, radii, slips, may_grow)
    }

    /// The same, with sources in spheres whose radii change or without.
    fn expand(
        frame: &Frame,
        radii: &[f64],
        slips: &[&SphereSlip<'_>],
        may_grow: bool,
    ) -> Result<Self, HydroError> {
        let all: Vec<usize> = (0..radii.len()).collect();
        let mut spheres = project(frame, radii, &all, slips, SLIP_ORDERS[0])?;
        let size = |column: usize| {
            spheres
                .iter()
                .map(|of| of.sizes[column])
                .fold(0.0, f64::max)
        };
        let sizes: Vec<f64> = (0..slips.len()).map(size).collect();
        for order in &SLIP_ORDERS[1..] {
            let unresolved: Vec<usize> = (all.iter().copied())
                .filter(|&sphere| !spheres[sphere].is_within(TARGET_REMAINDER, &sizes))
                .collect();
            let found = project(frame, radii, &unresolved, slips, *order)?;
            for (sphere, found) in unresolved.into_iter().zip(found) {
                spheres[sphere] = found.without_small_orders(&sizes);
            }
        }
        let mut sources = Sources::new(frame, radii, slips.len());
        let mut largest: f64 = 0.0;
        for (sphere, of) in spheres.iter().enumerate() {
            for (column, &size) in sizes.iter().enumerate().filter(|(_, size)| **size > 0.0) {
                let remainder = of.remainders[column] / size;
                largest = largest.max(remainder);
                // What polynomials do not represent can also appear as a flux at the points of the
                // quadrature.
                let flux = of.fluxes[column] / size;
                let highest = ROUNDING_FLUX.max(remainder);
                if flux.abs() > highest {
                    if !may_grow {
                        return Err(HydroError::NetFlux {
                            sphere,
                            flux,
                            highest,
                        });
                    }
                    sources.strengths[(sphere, column)] = radii[sphere].powi(2) * of.fluxes[column];
                }
                if remainder > MAX_REMAINDER {
                    return Err(HydroError::SlipNotResolved {
                        sphere,
                        degree: of.modes.order - 1,
                        remainder,
                        highest: MAX_REMAINDER,
                    });
                }
            }
        }
        Ok(Self {
            spheres,
            columns: slips.len(),
            remainder: largest,
            speeds: sizes,
            sources,
        })
    }

    /// Lowest orders that contain the slip velocities, raised by `margin`.
    pub fn orders(&self, medium: &Medium, margin: usize) -> Orders {
        let of_sources = self.sources.orders();
        let of_spheres = (self.spheres.iter().zip(&of_sources))
            .map(|(of, of_sources)| of.modes.order.max(*of_sources) + margin);
        let of_container = of_sources.last().copied().unwrap_or_default();
        let highest =
            (of_spheres.clone()).fold((SLIP_ORDERS[0]).max(of_container) + margin, usize::max);
        Orders {
            spheres: of_spheres.collect(),
            ..Orders::all(self.spheres.len(), medium, highest)
        }
    }

    /// Coefficients of the velocities in scaled modes without those of the sources, one column per
    /// velocity: what the rest of the flow has on the surfaces.
    ///
    /// The container is at rest.
    pub fn traces_of_rest(&self, system: &System) -> MultiVector {
        let mut traces = self.traces(&system.expansions);
        self.sources.subtract(system, &mut traces);
        traces
    }

    /// The sources at the centres of the spheres.
    pub fn sources(&self) -> &Sources {
        &self.sources
    }

    /// The sources alone.
    pub fn into_sources(self) -> Sources {
        self.sources
    }

    /// Coefficients of the velocities in scaled modes, one column per velocity; zeros for a
    /// container after the spheres.
    pub fn traces(&self, expansions: &[Expansion]) -> MultiVector {
        let zeros = |of: &Expansion| Mat::zeros(of.modes.len(), self.columns);
        let mut traces: MultiVector = expansions.iter().map(zeros).collect();
        let expansions = expansions.iter().zip(&mut traces);
        for ((expansion, trace), of) in expansions.zip(&self.spheres) {
            for (family, l) in of.modes.shells() {
                let own = of.modes.shell(family, l);
                for (row, own) in expansion.modes.shell(family, l).zip(own) {
                    for column in 0..self.columns {
                        trace[(row, column)] = of.coefficients[(own, column)];
                    }
                }
            }
        }
        traces
    }
}

impl SlipOfSphere {
    fn new(expansion: &Expansion, columns: usize) -> Self {
        Self {
            modes: expansion.modes,
            coefficients: Mat::zeros(expansion.modes.len(), columns),
            squares: vec![vec![0.0; expansion.modes.order + 1]; columns],
            sizes: vec![0.0; columns],
            remainders: vec![0.0; columns],
            fluxes: vec![0.0; columns],
        }
    }

    /// Whether all remainders are at most `tolerance` times the sizes of the velocities.
    fn is_within(&self, tolerance: f64, sizes: &[f64]) -> bool {
        let mut pairs = self.remainders.iter().zip(sizes);
        pairs.all(|(remainder, size)| *remainder <= tolerance * size)
    }

    /// The same velocities without the highest orders, as far as [`TARGET_REMAINDER`] allows.
    fn without_small_orders(mut self, sizes: &[f64]) -> Self {
        // What remains without the orders above each one; the modes are orthogonal.
        let remainder = |of: &Self, column: usize, order: usize| {
            let omitted: f64 = of.squares[column][order + 1..].iter().sum();
            of.remainders[column].hypot((omitted / FULL_ANGLE).sqrt())
        };
        let suffices = |order: &usize| {
            (0..sizes.len())
                .all(|column| remainder(&self, column, *order) <= TARGET_REMAINDER * sizes[column])
        };
        let Some(order) = (SLIP_ORDERS[0]..self.modes.order).find(suffices) else {
            return self;
        };
        let (all, modes) = (self.modes, Modes { order });
        let mut coefficients = Mat::zeros(modes.len(), sizes.len());
        for (family, l) in modes.shells() {
            for (row, old) in modes.shell(family, l).zip(all.shell(family, l)) {
                for column in 0..sizes.len() {
                    coefficients[(row, column)] = self.coefficients[(old, column)];
                }
            }
        }
        self.remainders = (0..sizes.len())
            .map(|column| remainder(&self, column, order))
            .collect();
        (self.modes, self.coefficients) = (modes, coefficients);
        self
    }
}

/// Area of the unit sphere.
const FULL_ANGLE: f64 = 4.0 * std::f64::consts::PI;

/// Expands the velocities of some spheres to one order, and measures what remains.
///
/// The quadrature with `2n²`, `n = 2 order`, points is exact for products of modes with polynomials
/// of degree `3 order`. The remainder is measured at twice as many other points, which also find
/// higher degrees that are zero at the points of the quadrature or that alias there.
///
/// # Errors
/// [`HydroError::NotFinite`].
fn project(
    frame: &Frame,
    radii: &[f64],
    spheres: &[usize],
    slips: &[&SphereSlip<'_>],
    order: usize,
) -> Result<Vec<SlipOfSphere>, HydroError> {
    let modes = Modes { order };
    let expansion = |&sphere: &usize| Expansion {
        radius: radii[sphere],
        modes,
    };
    let expansions: Vec<Expansion> = spheres.iter().map(expansion).collect();
    let new = |of: &Expansion| SlipOfSphere::new(of, slips.len());
    let mut found: Vec<SlipOfSphere> = expansions.iter().map(new).collect();
    if found.is_empty() || slips.is_empty() {
        return Ok(found);
    }
    let harmonics = VectorHarmonics::new(modes);
    let from_axes = frame.to_axes.inverse();
    let in_axes = |slip: &SphereSlip<'_>, sphere: usize, normal: &Vector3<f64>| {
        let value = slip(sphere, &(from_axes * normal));
        check_finite("the velocity of a surface", &value)?;
        Ok::<_, HydroError>(frame.to_axes * value)
    };
    for point in quadrature(2 * order) {
        let values = harmonics.at(&point);
        for ((sphere, expansion), of) in spheres.iter().zip(&expansions).zip(&mut found) {
            for (column, slip) in slips.iter().enumerate() {
                let value = in_axes(slip, *sphere, &point.normal)?;
                of.sizes[column] += point.weight * value.norm_squared();
                of.fluxes[column] += point.weight / FULL_ANGLE * point.normal.dot(&value);
                for (family, l) in modes.shells() {
                    let weight = expansion.weight(family, l);
                    let factor = point.weight * weight / VectorHarmonics::norm_squared(family, l);
                    for row in modes.shell(family, l) {
                        of.coefficients[(row, column)] += factor * values[row].dot(&value);
                    }
                }
            }
        }
    }
    // The modes themselves, without their scaling.
    let unscaled = |(of, expansion): (&SlipOfSphere, &Expansion)| {
        let mut unscaled = of.coefficients.clone();
        for (family, l) in modes.shells() {
            for row in modes.shell(family, l) {
                for column in 0..slips.len() {
                    unscaled[(row, column)] /= expansion.weight(family, l);
                }
            }
        }
        unscaled
    };
    let unscaled: Vec<Mat<f64>> = found.iter().zip(&expansions).map(unscaled).collect();
    let mut sizes = vec![vec![0.0; slips.len()]; found.len()];
    for point in spiral(2 * (2 * order) * (4 * order)) {
        let values = harmonics.at(&point);
        for (index, (sphere, of)) in spheres.iter().zip(&mut found).enumerate() {
            for (column, slip) in slips.iter().enumerate() {
                let value = in_axes(slip, *sphere, &point.normal)?;
                let coefficients = unscaled[index].col_as_slice(column);
                let expanded: Vector3<f64> =
                    (values.iter().zip(coefficients)).map(|(v, c)| v * *c).sum();
                sizes[index][column] += point.weight * value.norm_squared();
                let rest = value - expanded - of.fluxes[column] * point.normal;
                of.remainders[column] += point.weight * rest.norm_squared();
            }
        }
    }
    for (index, of) in found.iter_mut().enumerate() {
        for column in 0..slips.len() {
            // A velocity may vanish at all points of one of the two sets.
            let square = of.sizes[column].max(sizes[index][column]);
            of.sizes[column] = (square / FULL_ANGLE).sqrt();
            of.remainders[column] = (of.remainders[column] / FULL_ANGLE).sqrt();
            for (family, l) in modes.shells() {
                let norm = VectorHarmonics::norm_squared(family, l);
                let shell = modes.shell(family, l);
                let squares = shell.map(|row| unscaled[index][(row, column)].powi(2));
                of.squares[column][l + family.shift()] += norm * squares.sum::<f64>();
            }
        }
    }
    Ok(found)
}

/// Checks that the spheres lie in the medium and are not too many.
///
/// # Errors
/// Spheres outside the medium; [`HydroError::TooLarge`].
pub(super) fn check(spheres: &Spheres, medium: &Medium) -> Result<(), HydroError> {
    spheres.check_inside(medium)?;
    memory::check_spheres(spheres.len())
}

/// Largest coefficient.
pub(super) fn largest(coefficients: &MultiVector) -> f64 {
    coefficients.iter().map(Mat::norm_max).fold(0.0, f64::max)
}

/// Coefficients in scaled modes of the velocities of spheres that move, and of their surfaces.
///
/// `velocities` has six entries `(U, ω)` per sphere.
///
/// # Errors
/// [`HydroError::Length`], [`HydroError::NotFinite`] for the velocities.
pub(super) fn of_moving_spheres(
    system: &System,
    frame: &Frame,
    velocities: &DVector<f64>,
    slip: Option<&SlipExpansion>,
) -> Result<MultiVector, HydroError> {
    let (expected, found) = (6 * system.spheres, velocities.len());
    check_entries("velocities of the spheres", expected, found)?;
    check_finite("a velocity of a sphere", velocities)?;
    let mut coefficients = match slip {
        Some(slip) => slip.traces_of_rest(system),
        None => system.zeros(1),
    };
    let spheres = system.expansions.iter().take(system.spheres);
    let radii: Vec<f64> = spheres.map(|sphere| sphere.radius).collect();
    let units = drag_units(&radii);
    for sphere in 0..system.spheres {
        for (k, row) in system.rigid_rows(sphere).into_iter().enumerate() {
            let first = 6 * sphere + 3 * (k / 3);
            let local = frame.to_axes * velocities.fixed_rows::<3>(first).into_owned();
            coefficients[sphere][(row, 0)] += units[6 * sphere + k] * local[AXIS_OF_M[k % 3]];
        }
    }
    Ok(coefficients)
}
