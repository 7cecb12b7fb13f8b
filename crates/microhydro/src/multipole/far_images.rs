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
//! The operator is symmetric for any points, and does not depend on how Ewald's sums are split:
//! what is summed over images is one matrix for each pair of spheres, found once, and the waves are
//! summed in each product. The mean flow is zero, as in [`crate::PointMobility::periodic`].

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rayon::prelude::*;

use super::memory::mib;
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

/// Products of a solution with its error bar, for which the sums over images are stored.
const PRODUCTS: f64 = 40.0;

/// Most memory of what is stored, in MiB: of 300 spheres. More spheres find it in each product.
const MOST_STORED: f64 = 800.0;

pub(super) struct FarImages {
    sums: PeriodicSums,
    /// Points of all spheres, one sphere after the other.
    points: Vec<Vector3<f64>>,
    /// Forces at the points of a sphere of radius one by each mode with a self energy of one: three
    /// rows for each point.
    forces: DMatrix<f64>,
    /// Square roots of the radii.
    scales: Vec<f64>,
    /// For each sphere the spheres that are near, with the shifts of their images; itself too.
    near: Vec<Vec<(usize, Vector3<f64>)>>,
    /// For each sphere the blocks of itself and of those before it, if there is room for them.
    blocks: Option<Vec<Vec<DMatrix<f64>>>>,
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
        let mut forces = DMatrix::zeros(3 * POINTS, weights.len());
        for (number, point) in quadrature.iter().enumerate() {
            for (mode, (h, weight)) in harmonics.at(point).into_iter().zip(&weights).enumerate() {
                let mut entries = forces.fixed_view_mut::<3, 1>(3 * number, mode);
                entries.copy_from(&(point.weight * *weight * h));
            }
        }
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
        let none = vec![0.0; points.len()];
        let is_stored = stored_numbers(spheres.len()) > 0.0;
        let products = if is_stored { PRODUCTS } else { 1.0 };
        let splitting = PeriodicSums::splitting(points.len(), size, products);
        let mut far = Self {
            sums: PeriodicSums::of_points(points.clone(), none, size, Some(splitting))?,
            points,
            forces,
            scales: spheres.radii().iter().map(|a| a.sqrt()).collect(),
            near: lists,
            blocks: None,
        };
        if is_stored {
            let blocks = |sphere: usize| (0..=sphere).map(|of| far.block(sphere, of)).collect();
            far.blocks = Some((0..spheres.len()).into_par_iter().map(blocks).collect());
        }
        Ok(far)
    }

    /// What the modes of one sphere are for those of another one by images, without near ones.
    fn block(&self, sphere: usize, of: usize) -> DMatrix<f64> {
        let scale = self.scales[sphere] * self.scales[of];
        self.forces
            .tr_mul(&(self.tensors(sphere, of) * &self.forces))
            * scale
    }

    /// Velocities at the points of one sphere by forces at those of another one.
    fn tensors(&self, sphere: usize, of: usize) -> DMatrix<f64> {
        let near = self.near[sphere].iter().filter(|(near, _)| *near == of);
        let shifts: Vec<Vector3<f64>> = near.map(|(_, shift)| *shift).collect();
        let mut tensors = DMatrix::zeros(3 * POINTS, 3 * POINTS);
        for (row, column) in (0..POINTS).flat_map(|row| (0..POINTS).map(move |of| (row, of))) {
            let [at, of] = [POINTS * sphere + row, POINTS * of + column];
            let mut tensor = self.sums.images_of_point(at, of);
            for shift in &shifts {
                let r = self.points[at] - self.points[of] - shift;
                let square = r.norm_squared();
                if square > 0.0 {
                    let stokeslet = Matrix3::identity() + r * r.transpose() / square;
                    tensor -= stokeslet / (8.0 * PI * square.sqrt());
                }
            }
            let mut entries = tensors.fixed_view_mut::<3, 3>(3 * row, 3 * column);
            entries.copy_from(&tensor);
        }
        tensors
    }

    /// Operations of a product and of what is stored, roughly, and numbers of the latter.
    pub fn cost(spheres: usize) -> ([f64; 2], f64) {
        let (pairs, rows) = ((spheres as f64).powi(2), 3.0 * POINTS as f64);
        let modes = (Modes { order: FAR_ORDER }).len() as f64;
        let tensors = PAIR_OPERATIONS * (POINTS as f64).powi(2);
        let numbers = stored_numbers(spheres);
        let operations = match numbers > 0.0 {
            true => [
                modes * modes,
                0.5 * (tensors + rows * modes * (rows + modes)),
            ],
            false => [tensors + rows * rows, 0.0],
        };
        (operations.map(|of_pair| of_pair * pairs), numbers)
    }

    /// `y` for the modes of all spheres.
    pub fn product(&self, x: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let x: Vec<DVector<f64>> = x.iter().map(|x| DVector::from_column_slice(x)).collect();
        let of_sphere = |(sphere, x): (usize, &DVector<f64>)| {
            let forces = &self.forces * x * self.scales[sphere];
            (0..POINTS).map(move |point| forces.fixed_rows::<3>(3 * point).into_owned())
        };
        let forces: Vec<Vector3<f64>> = x.iter().enumerate().flat_map(of_sphere).collect();
        let by_waves = self.sums.by_waves(&forces);
        let of_sphere = |sphere: usize| {
            let of_points = |of: usize, all: &[Vector3<f64>]| {
                let own = &all[POINTS * of..POINTS * (of + 1)];
                DVector::from_iterator(3 * POINTS, own.iter().flatten().copied())
            };
            let mut own = of_points(sphere, &by_waves);
            if self.blocks.is_none() {
                for of in 0..x.len() {
                    own.gemv(1.0, &self.tensors(sphere, of), &of_points(of, &forces), 1.0);
                }
            }
            let mut y = self.forces.tr_mul(&own) * self.scales[sphere];
            for (of, x) in x.iter().enumerate() {
                match &self.blocks {
                    Some(blocks) if of <= sphere => y.gemv(1.0, &blocks[sphere][of], x, 1.0),
                    Some(blocks) => y.gemv_tr(1.0, &blocks[of][sphere], x, 1.0),
                    None => break,
                }
            }
            y.as_slice().to_vec()
        };
        (0..x.len()).into_par_iter().map(of_sphere).collect()
    }
}

/// Numbers of the blocks of all pairs; zero if there is no room for them.
fn stored_numbers(spheres: usize) -> f64 {
    let modes = (Modes { order: FAR_ORDER }).len();
    let numbers = 0.5 * ((modes * spheres) as f64).powi(2);
    if mib(numbers) <= MOST_STORED {
        numbers
    } else {
        0.0
    }
}

/// Operations of a pair of points.
const PAIR_OPERATIONS: f64 = 30.0;
