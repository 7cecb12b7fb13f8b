//! Flows around spheres on the axis that deform, by elements of increasing order on one mesh.

use std::f64::consts::PI;

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::AxisymmetricError;
use crate::axial_shape::AxialShape;
use crate::curve::{BoundaryPart, Point};
use crate::deformed_sphere::DeformedSphere;
use crate::generate::generate;
use crate::meridian::{GROWTH, Meridian, Surroundings};
use crate::open_boundary::exterior_flow;
use crate::resistance::AxialResistance;
use crate::solver::{check_tolerance, raised_orders};
use crate::stokes::stokes;
use crate::surface_modes::{SurfaceColumns, direction_from};
use crate::system::{Element, Solution};

/// Velocities of the surfaces of spheres that deform.
///
/// A column is the velocity of all surfaces for a rate of one of an amplitude, relative to the
/// velocities of the centres.
pub trait DeformationRates: Sync {
    /// Number of columns.
    fn count(&self) -> usize;

    /// Velocity along the axis and away from it of the surface of a body at a position `[z, r]` on
    /// it, relative to its centre.
    fn velocity(&self, column: usize, body: usize, from_centre: [f64; 2]) -> [f64; 2];

    /// Rate of the volume of a body.
    fn volume_rate(&self, column: usize, body: usize) -> f64;
}

/// The velocities as columns of the equations.
struct Columns<'a> {
    bodies: &'a [DeformedSphere],
    rates: &'a dyn DeformationRates,
}

impl SurfaceColumns for Columns<'_> {
    fn count(&self) -> usize {
        self.rates.count()
    }

    fn at(&self, body: usize, x: &Point) -> Vec<(usize, [f64; 2])> {
        let from_centre = [x.x - self.bodies[body].centre, x.y];
        let of = |column| (column, self.rates.velocity(column, body, from_centre));
        (0..self.rates.count()).map(of).collect()
    }

    fn outwards(&self, body: usize, x: &Point) -> [f64; 2] {
        direction_from(self.bodies[body].centre, x)
    }

    fn flux(&self, column: usize, body: usize) -> f64 {
        self.rates.volume_rate(column, body)
    }
}

/// Intervals of the angle for integrals over a surface, whose midpoint rule converges
/// geometrically.
const INTERVALS: usize = 2000;

/// Step of central differences in the angle: its fourth power and rounding over it are below 1e-11.
const DIFFERENCE_STEP: f64 = 2e-3;

impl Columns<'_> {
    /// Powers that the form `∫ ∇u:∇v` omits for the columns of a body.
    ///
    /// ```text
    /// 2 ∫ D(u):D(v) = ∫ ∇u:∇v - ∮ (u·t) (n·∂_s v) - (u·n) (t·∂_s v + v_r / r) dS
    /// ```
    ///
    /// for divergence-free flows, with the normal `n` out of the body, the tangent `t` along the
    /// meridian and the arc `s`.
    fn omitted_powers(&self, body: usize) -> DMatrix<f64> {
        let sphere = &self.bodies[body];
        let count = self.rates.count();
        let position = |angle: f64| {
            let radius = sphere.radius_at(angle);
            [radius * angle.cos(), radius * angle.sin()]
        };
        // Of an angle beyond a pole, by the reflection in the axis.
        let velocities = |angle: f64| -> Vec<[f64; 2]> {
            let [z, r] = position(angle);
            let at = |column| {
                let [axial, away] = self.rates.velocity(column, body, [z, r.abs()]);
                [axial, away * r.signum()]
            };
            (0..count).map(at).collect()
        };
        let step = PI / INTERVALS as f64;
        let mut powers = DMatrix::zeros(count, count);
        for interval in 0..INTERVALS {
            let angle = (interval as f64 + 0.5) * step;
            let [radius, slope] = sphere.with_slope(angle);
            let (sin, cos) = angle.sin_cos();
            let speed = radius.hypot(slope);
            let tangent = [
                (slope * cos - radius * sin) / speed,
                (slope * sin + radius * cos) / speed,
            ];
            // With the angle from the right pole the body is on the left of the tangent.
            let normal = [tangent[1], -tangent[0]];
            let [_, r] = position(angle);
            let own = velocities(angle);
            let around = [-2.0, -1.0, 1.0, 2.0].map(|k| velocities(angle + k * DIFFERENCE_STEP));
            let along_arc = |column: usize| {
                [0, 1].map(|k| {
                    let [a, b, c, d] = [0, 1, 2, 3].map(|p: usize| around[p][column][k]);
                    (a - 8.0 * b + 8.0 * c - d) / (12.0 * DIFFERENCE_STEP * speed)
                })
            };
            let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
            let weight = 2.0 * PI * r * speed * step;
            for j in 0..count {
                let slope = along_arc(j);
                let bending = dot(normal, slope);
                let stretching = dot(tangent, slope) + own[j][1] / r;
                for i in 0..count {
                    let u = own[i];
                    powers[(i, j)] -=
                        weight * (dot(u, tangent) * bending - dot(u, normal) * stretching);
                }
            }
        }
        0.5 * (&powers + powers.transpose())
    }
}

/// Resistance to motions along the axis and to the deformations of spheres, with an error estimate.
///
/// The matrix has one row for the velocity of each sphere, then one for each column of the `rates`.
/// It is the bilinear form of the power `2 ∫ D:D`: its product with velocities and rates are the
/// forces on the fluid that are conjugate to them. In a container the wall moves so that it lets
/// out what a column displaces; only sums of columns that keep the volume have the flow of a wall
/// at rest. Viscosity 1.
///
/// If the tolerance is out of reach, the result has the highest order and its error estimate.
///
/// Cost: as [`axial_resistance`](crate::axial_resistance), with more elements around spheres that
/// are not round.
///
/// # Errors
/// Those of [`axial_resistance`](crate::axial_resistance) except
/// [`AxisymmetricError::NotConverged`].
///
/// # Examples
/// A sphere that grows at the rate one dissipates `16π a`.
///
/// ```
/// use axisymmetric::{DeformationRates, DeformedSphere, RADIAL_DEGREES, Surroundings};
///
/// struct Growth;
/// impl DeformationRates for Growth {
///     fn count(&self) -> usize {
///         1
///     }
///     fn velocity(&self, _: usize, _: usize, [z, r]: [f64; 2]) -> [f64; 2] {
///         [z / z.hypot(r), r / z.hypot(r)]
///     }
///     fn volume_rate(&self, _: usize, _: usize) -> f64 {
///         4.0 * std::f64::consts::PI
///     }
/// }
/// let amplitudes = [0.0; RADIAL_DEGREES];
/// let sphere = DeformedSphere { centre: 0.0, radius: 1.0, power: 1.0, amplitudes };
/// let unbounded = Surroundings::Unbounded;
/// let found = axisymmetric::deforming_resistance(&[sphere], unbounded, &Growth, 1e-6)?;
/// let power = found.matrix()[(1, 1)];
/// assert!((power / (16.0 * std::f64::consts::PI) - 1.0).abs() < 1e-6);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
pub fn deforming_resistance(
    spheres: &[DeformedSphere],
    surroundings: Surroundings,
    rates: &dyn DeformationRates,
    tolerance: f64,
) -> Result<AxialResistance, AxisymmetricError> {
    check_tolerance(tolerance)?;
    let shapes: Vec<AxialShape> = spheres.iter().map(|sphere| (*sphere).into()).collect();
    let meridian = Meridian::around(&shapes, surroundings)?;
    let mesh = generate(&meridian, GROWTH)?;
    let columns = Columns {
        bodies: spheres,
        rates,
    };
    let n = spheres.len();
    let of_bodies: Vec<_> = (0..n)
        .into_par_iter()
        .map(|body| columns.omitted_powers(body))
        .collect();
    let mut omitted = DMatrix::zeros(rates.count(), rates.count());
    of_bodies.iter().for_each(|powers| omitted += powers);
    let solve = |orders: Vec<usize>| -> Result<Vec<Solution>, AxisymmetricError> {
        let one = |order: usize| {
            let mut system = stokes(&mesh, order, Some((n, &columns)))?;
            if let Some(sphere) = &meridian.open_sphere() {
                let matrix = exterior_flow(&mesh, order, sphere);
                // the pressures on the boundary are not degrees of freedom of the flow beyond it
                let dofs = system.trace(BoundaryPart::Open)[..matrix.nrows()].to_vec();
                system.elements.push(Element { dofs, matrix });
            }
            let mut solution = system.resistance(n + rates.count())?;
            let mut own = solution.resistance.view_mut((n, n), omitted.shape());
            own += &omitted;
            Ok(solution)
        };
        orders.into_par_iter().map(one).collect()
    };
    raised_orders(tolerance, mesh.triangles.len(), solve)
}
