//! What the distant images of spheres in a periodic box do, by low multipoles.
//!
//! Near images couple as pairs do ([`super::pair_product`]). The flow of all others is smooth at a
//! sphere, so that low multipoles and the values at few points of the surface suffice. With the
//! weights `A` of point forces that stand for force densities, and the periodic flow `G` of point
//! forces without the near images,
//!
//! ```text
//! y = A^T G A x
//! ```
//!
//! The operator is symmetric for any points, and does not depend on how Ewald's sums are split. The
//! mean flow is zero, as in [`crate::PointMobility::periodic`].

use std::f64::consts::PI;

use nalgebra::{DVector, Vector3};
use rayon::prelude::*;

use super::modes::Modes;
use super::vector_harmonics::{VectorHarmonics, quadrature};
use crate::periodic::PeriodicSums;
use crate::{HydroError, Spheres};

/// Modes of the distant images: all densities of degrees below this order.
pub(super) const FAR_ORDER: usize = 4;

/// Gauss points of the quadrature along a meridian.
///
/// Its degree is seven: exact for densities of the highest degree in flows of the same degree and
/// one more, the first that is left out.
const MERIDIAN_POINTS: usize = 4;

/// Number of point forces of a sphere.
pub(super) const POINTS: usize = 2 * MERIDIAN_POINTS * MERIDIAN_POINTS;

pub(super) struct FarImages {
    sums: PeriodicSums,
    /// Points of all spheres, one sphere after the other.
    points: Vec<Vector3<f64>>,
    /// Forces at the points of a sphere of radius one by each mode with a self energy of one.
    forces: Vec<Vec<Vector3<f64>>>,
    /// Square roots of the radii.
    scales: Vec<f64>,
    /// For each sphere the spheres that are near, with the shifts of their images; itself too.
    near: Vec<Vec<(usize, Vector3<f64>)>>,
}

impl FarImages {
    /// `near` lists the pairs of spheres that couple as pairs, with the shift of the second one.
    ///
    /// # Errors
    /// [`HydroError::PeriodicBox`].
    pub fn new(
        spheres: &Spheres,
        size: &Vector3<f64>,
        near: impl Iterator<Item = ([usize; 2], Vector3<f64>)>,
    ) -> Result<Self, HydroError> {
        let modes = Modes { order: FAR_ORDER };
        let harmonics = VectorHarmonics::new(modes);
        let quadrature = quadrature(MERIDIAN_POINTS);
        // A density over the surface is the velocity over the eigenvalue: the self energy over the
        // squared norm of the harmonic.
        let weights: Vec<f64> = (modes.shells())
            .flat_map(|(family, l)| {
                let weight =
                    family.energy(l, 1.0).sqrt() / VectorHarmonics::norm_squared(family, l);
                std::iter::repeat_n(weight, 2 * l + 1)
            })
            .collect();
        let forces = quadrature.iter().map(|point| {
            let modes = harmonics.at(point).into_iter().zip(&weights);
            modes
                .map(|(h, weight)| point.weight * *weight * h)
                .collect()
        });
        let all = spheres.centres().iter().zip(spheres.radii());
        let points: Vec<Vector3<f64>> = all
            .flat_map(|(x, a)| quadrature.iter().map(move |point| x + *a * point.normal))
            .collect();
        let mut lists: Vec<Vec<_>> = (0..spheres.len())
            .map(|sphere| vec![(sphere, Vector3::zeros())])
            .collect();
        for ([first, second], shift) in near {
            lists[first].push((second, shift));
            lists[second].push((first, -shift));
        }
        Ok(Self {
            sums: PeriodicSums::of_points(points.clone(), vec![0.0; points.len()], size, None)?,
            points,
            forces: forces.collect(),
            scales: spheres.radii().iter().map(|a| a.sqrt()).collect(),
            near: lists,
        })
    }

    /// Operations of a product, roughly.
    pub fn operations(spheres: usize) -> f64 {
        PAIR_OPERATIONS * (POINTS * spheres) as f64 * (POINTS * spheres) as f64
    }

    /// `y` for the modes of all spheres.
    pub fn product(&self, x: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut forces = DVector::zeros(6 * self.points.len());
        for (sphere, x) in x.iter().enumerate() {
            for (point, of_modes) in self.forces.iter().enumerate() {
                let force: Vector3<f64> = of_modes.iter().zip(x).map(|(f, x)| f * *x).sum();
                let row = 6 * (POINTS * sphere + point);
                (forces.fixed_rows_mut::<3>(row)).copy_from(&(self.scales[sphere] * force));
            }
        }
        let velocities = self.sums.velocities(&forces);
        let of_sphere = |sphere: usize| {
            let mut y = vec![0.0; self.forces[0].len()];
            for (point, of_modes) in self.forces.iter().enumerate() {
                let row = POINTS * sphere + point;
                let velocity = velocities.fixed_rows::<3>(6 * row) - self.by_near(row, &forces);
                for (y, force) in y.iter_mut().zip(of_modes) {
                    *y += self.scales[sphere] * force.dot(&velocity);
                }
            }
            y
        };
        (0..x.len()).into_par_iter().map(of_sphere).collect()
    }

    /// Velocity at a point by the forces on near spheres, itself excluded, in unbounded fluid.
    fn by_near(&self, row: usize, forces: &DVector<f64>) -> Vector3<f64> {
        let mut velocity = Vector3::zeros();
        for (of, shift) in &self.near[row / POINTS] {
            for other in POINTS * of..POINTS * (of + 1) {
                let r = self.points[row] - self.points[other] - shift;
                let square = r.norm_squared();
                if square > 0.0 {
                    let force = forces.fixed_rows::<3>(6 * other);
                    velocity += (force + r * (r.dot(&force) / square)) / square.sqrt();
                }
            }
        }
        velocity / (8.0 * PI)
    }
}

/// Operations of a pair of points.
const PAIR_OPERATIONS: f64 = 30.0;
