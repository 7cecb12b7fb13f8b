//! What a boundary adds to the velocities of spheres without reflections, without a matrix.

use faer::Mat;
use nalgebra::{DVector, Vector3};
use rayon::prelude::*;

use super::coupling::{Coupling, Expansion};
use super::frame::{Frame, Surroundings};
use super::modes::Modes;
use super::rotation::AXIS_OF_M;
use super::scaled::drag_units;
use super::truncation::{self, GapCoordinates};
use super::wall_image::image_coupling;
use crate::{Medium, Spheres};

/// Order of the container for mobilities without reflections between spheres.
pub(super) fn container_order(spheres: &Spheres, medium: &Medium) -> usize {
    let xi = GapCoordinates {
        spheres: Vec::new(),
        container: truncation::container_coordinate(spheres, medium),
    };
    truncation::for_tolerance(&xi, medium, 1e-10)
        .container
        .min(truncation::MAX_ORDER_ON_CONTAINER)
}

/// Velocities that the boundary of the medium adds for given forces, six entries per sphere.
///
/// The product with the difference of [`super::rigid_mobility`] and the mobility in unbounded
/// fluid. Time: `O(n²)` beside a wall, `O(n L³)` in a ball whose expansion has order `L`; memory:
/// `O(n)` and `O(n L²)`. The same for any number of threads.
pub(crate) fn boundary_product(
    spheres: &Spheres,
    medium: &Medium,
    forces: &DVector<f64>,
) -> DVector<f64> {
    let frame = Frame::new(spheres, medium);
    let units = drag_units(spheres.radii());
    let local = |of: &DVector<f64>, sphere: usize, part: usize| {
        of.fixed_rows::<3>(6 * sphere + 3 * part).into_owned()
    };
    let scaled = |sphere: usize| {
        let rotated = [0, 1].map(|part| frame.to_axes * local(forces, sphere, part));
        Mat::from_fn(6, 1, |k, _| {
            rotated[k / 3][AXIS_OF_M[k % 3]] / units[6 * sphere + k]
        })
    };
    let forces: Vec<Mat<f64>> = (0..spheres.len()).map(scaled).collect();
    let velocities = match frame.surroundings {
        Surroundings::Unbounded => vec![Mat::zeros(6, 1); spheres.len()],
        Surroundings::Wall => by_images(&frame, spheres.radii(), &forces),
        Surroundings::Ball(radius) => {
            let order = container_order(spheres, medium);
            by_container(&frame, spheres.radii(), (radius, order), &forces)
        }
    };
    let mut product = DVector::zeros(6 * spheres.len());
    for (sphere, scaled) in velocities.iter().enumerate() {
        for part in [0, 1] {
            let mut velocity = Vector3::zeros();
            for k in 3 * part..3 * part + 3 {
                velocity[AXIS_OF_M[k % 3]] = scaled[(k, 0)] / units[6 * sphere + k];
            }
            let rotated = frame.to_axes.inverse() * velocity;
            product
                .fixed_rows_mut::<3>(6 * sphere + 3 * part)
                .copy_from(&rotated);
        }
    }
    product
}

/// Rigid motions of a sphere.
fn rigid(radius: f64) -> Expansion {
    Expansion {
        radius,
        modes: Modes { order: 1 },
    }
}

/// Number of spheres whose products with all others are computed at a time.
const SPHERES_PER_BATCH: usize = 64;

/// Scaled velocities due to the images of all spheres in a wall.
fn by_images(frame: &Frame, radii: &[f64], forces: &[Mat<f64>]) -> Vec<Mat<f64>> {
    let x = &frame.centres;
    let mut velocities = vec![Mat::zeros(6, 1); forces.len()];
    let spheres: Vec<usize> = (0..forces.len()).collect();
    for batch in spheres.chunks(SPHERES_PER_BATCH) {
        // what two spheres do to each other is a matrix and its transpose
        let product = |to: usize, from: usize| {
            let (source, target) = (rigid(radii[from]), rigid(radii[to]));
            let coupling = image_coupling((&source, &x[from]), (&target, &x[to]));
            [
                &coupling * &forces[from],
                coupling.transpose() * &forces[to],
            ]
        };
        let products: Vec<Vec<[Mat<f64>; 2]>> = batch
            .par_iter()
            .map(|&to| (0..=to).map(|from| product(to, from)).collect())
            .collect();
        // in a fixed order
        for (&to, products) in batch.iter().zip(products) {
            for (from, [of_source, of_target]) in products.into_iter().enumerate() {
                velocities[to] += of_source;
                if from != to {
                    velocities[from] += of_target;
                }
            }
        }
    }
    velocities
}

/// Scaled velocities due to the wall of a container, `-C^T C f` with the couplings `C`.
fn by_container(
    frame: &Frame,
    radii: &[f64],
    (radius, order): (f64, usize),
    forces: &[Mat<f64>],
) -> Vec<Mat<f64>> {
    let container = Expansion {
        radius,
        modes: Modes { order },
    };
    let coupling = |sphere: usize| {
        let target = rigid(radii[sphere]);
        Coupling::with_container((1, 0), &container, &target, &frame.centres[sphere])
    };
    let reflected = |sphere: usize| {
        let mut modes = Mat::zeros(container.modes.len(), 1);
        coupling(sphere).add(forces[sphere].as_ref(), modes.as_mut(), true);
        modes
    };
    let spheres = 0..forces.len();
    let parts: Vec<Mat<f64>> = spheres.clone().into_par_iter().map(reflected).collect();
    let mut modes = Mat::zeros(container.modes.len(), 1);
    // In a fixed order.
    parts.iter().for_each(|part| modes -= part);
    let velocity = |sphere: usize| {
        let mut velocity = Mat::zeros(6, 1);
        coupling(sphere).add(modes.as_ref(), velocity.as_mut(), false);
        velocity
    };
    spheres.into_par_iter().map(velocity).collect()
}
