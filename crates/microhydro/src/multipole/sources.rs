//! Sources at the centres of spheres whose radii change, and their velocities on other surfaces.
//!
//! The flow around a sphere of radius `a` that grows at the rate `a'` is that of a source,
//! `Q x / |x|^3` with `Q = a^2 a'`. It has no pressure, and on the sphere exactly the velocity of
//! the surface. The flow around several surfaces is the sum `S` of all sources and a rest `w`,
//! which has the velocity of each surface minus those of all sources but its own: without flux, so
//! that the expansions represent it.
//!
//! On a sphere with a source at `d` from its centre, and on a container about the origin with a
//! source at `x`, the velocities are
//!
//! ```text
//! -Q sum_l 4π / (2l+1) a^(l-1) / |d|^(l+1) sum_m Y_lm(d) W_lm
//! -Q sum_l 4π / (2l+1) |x|^l / b^(l+2)     sum_m Y_lm(x) V_lm      without the mean flux
//! ```
//!
//! The power of the whole flow follows by the reciprocal theorem. A source exerts a uniform normal
//! traction on its own sphere, of which the rest of the flow has no flux, and on another sphere it
//! is a flow that continues inside; so the powers are those of the densities of `w` with the
//! velocities of `w`, minus those of the velocities of the surfaces without sources in the flows
//! inside, plus the powers `16π a a'^2` of single spheres.

use std::f64::consts::PI;

use nalgebra::{DMatrix, Vector3};

use super::frame::{Frame, Surroundings};
use super::modes::Family;
use super::system::{MultiVector, System};
use super::truncation::MAX_ORDER_OFF_AXIS;
use super::vector_harmonics::VectorHarmonics;

/// Velocity of a source on another surface that is neglected, relative to the velocity of its own.
///
/// A high degree acts on other spheres by as much as it is part of the velocity of a source, so
/// that errors of motions and powers are of the size of its square.
const NEGLECTED: f64 = 1e-7;

/// Sources at the centres of spheres, in the frame of the expansions.
pub(super) struct Sources {
    centres: Vec<Vector3<f64>>,
    radii: Vec<f64>,
    container: Option<f64>,
    /// `Q`: one row per sphere, one column per velocity.
    pub strengths: DMatrix<f64>,
}

impl Sources {
    /// Sources without strength.
    pub fn new(frame: &Frame, radii: &[f64], columns: usize) -> Self {
        Self {
            centres: frame.centres.clone(),
            radii: radii.to_vec(),
            container: match frame.surroundings {
                Surroundings::Ball(radius) => Some(radius),
                Surroundings::Unbounded | Surroundings::Wall => None,
            },
            strengths: DMatrix::zeros(radii.len(), columns),
        }
    }

    /// Numbers of the spheres with sources.
    fn active(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.radii.len()).filter(|&k| self.strengths.row(k).amax() > 0.0)
    }

    /// Orders that contain the velocities of the sources on each sphere, then on the container.
    pub fn orders(&self) -> Vec<usize> {
        let needed = |ratio: f64| {
            let degrees = (NEGLECTED.ln() / ratio.ln()).ceil();
            // `W_l` and `V_l` have the orders l and l + 2.
            (degrees.clamp(0.0, MAX_ORDER_OFF_AXIS as f64) as usize + 2).min(MAX_ORDER_OFF_AXIS - 2)
        };
        let on_sphere = |sphere: usize| {
            let others = self.active().filter(|&k| k != sphere);
            let ratio =
                |k: usize| self.radii[sphere] / (self.centres[k] - self.centres[sphere]).norm();
            needed(others.map(ratio).fold(0.0, f64::max))
        };
        let container = self.container.map(|radius| {
            let ratio = |k: usize| self.centres[k].norm() / radius;
            needed(self.active().map(ratio).fold(0.0, f64::max))
        });
        (0..self.radii.len())
            .map(on_sphere)
            .chain(container)
            .collect()
    }

    /// Subtracts the velocities of the sources on all other surfaces from coefficients in scaled
    /// modes.
    pub fn subtract(&self, system: &System, traces: &mut MultiVector) {
        for (number, (expansion, trace)) in system.expansions.iter().zip(traces).enumerate() {
            let is_sphere = number < self.radii.len();
            let family = match is_sphere {
                true => Family::Stokeslet,
                false => Family::Source,
            };
            let harmonics = VectorHarmonics::new(expansion.modes);
            for source in self.active().filter(|&k| k != number) {
                let offset = match is_sphere {
                    true => self.centres[source] - self.centres[number],
                    false => self.centres[source],
                };
                let (distance, radius) = (offset.norm(), expansion.radius);
                let values = harmonics.scalar(&offset);
                for l in 1..=expansion.modes.max_degree(family) {
                    let degree = l as i32;
                    let power = match is_sphere {
                        true => (radius / distance).powi(degree + 1) / (radius * radius),
                        false => (distance / radius).powi(degree) / (radius * radius),
                    };
                    let factor = 4.0 * PI / (2.0 * l as f64 + 1.0) * power;
                    let weight = expansion.weight(family, l);
                    let shell = expansion.modes.shell(family, l);
                    for (row, value) in shell.zip(&values[l * l - 1..]) {
                        for column in 0..self.strengths.ncols() {
                            let strength = self.strengths[(source, column)];
                            trace[(row, column)] += strength * factor * weight * value;
                        }
                    }
                }
            }
        }
    }

    /// Powers `16π a a'_i a'_j` of all single spheres.
    pub fn powers(&self) -> DMatrix<f64> {
        let columns = self.strengths.ncols();
        DMatrix::from_fn(columns, columns, |i, j| {
            let of_sphere = |k: usize| {
                let rates = self.strengths[(k, i)] * self.strengths[(k, j)];
                16.0 * PI * rates / self.radii[k].powi(3)
            };
            (0..self.radii.len()).map(of_sphere).sum()
        })
    }

    /// Velocity of the sources of a column at a point outside the spheres.
    pub fn velocity(&self, point: &Vector3<f64>, column: usize) -> Vector3<f64> {
        let of_sphere = |k: usize| {
            let offset = point - self.centres[k];
            offset * (self.strengths[(k, column)] / offset.norm().powi(3))
        };
        self.active().map(of_sphere).sum()
    }
}
