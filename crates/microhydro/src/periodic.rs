//! Sums over the periodic images of spheres in a box, by Ewald's method.
//!
//! The velocity by a force is `G F / (8π)` with the operator `G = (I ∇² - ∇∇) f` of a radial
//! function, `f = r` for one force in unbounded fluid. Following Hasimoto (1959), `f` is split into
//!
//! ```text
//! f(r) = r erfc(ξ r) - exp(-ξ² r²)/(ξ √π)      summed over images
//! H(k) = (1 + k²/(4ξ²)) exp(-k²/(4ξ²))         times the transform of r, summed over waves
//! ```
//!
//! Finite spheres (Beenakker 1986; Zuk, Wajnryb, Mizerski & Szymczak 2014) apply
//! `(1 + a²∇²/6)(1 + b²∇²/6)` to both parts, torques and angular velocities half a curl. Without
//! the wave `k = 0` the mean flow is zero: a pressure gradient balances the sum of the forces.

use std::f64::consts::PI;

use nalgebra::{Complex, DVector, Matrix3, Matrix6, Vector3, Vector6};
use rayon::prelude::*;

use crate::error::check_finite;
use crate::{HydroError, Spheres};

/// Argument of `erfc` and exponent of waves at which both sums end: `exp(-36) = 2e-16`.
const CUTOFF: f64 = 6.0;

/// Cost of a pair of spheres in the sum over images relative to a sphere and a wave.
const PAIR_COST: f64 = 10.0;

/// Largest number of waves, about two gigabytes.
const MAX_WAVES: f64 = 2e7;

/// Largest ratio of two edges of the box: images and waves along short edges are many.
const MAX_ASPECT: f64 = 50.0;

/// Spheres in a box that is repeated in all directions.
pub(crate) struct PeriodicSums {
    size: Vector3<f64>,
    centres: Vec<Vector3<f64>>,
    /// Radii in the interactions, zero for points.
    radii: Vec<f64>,
    /// `ξ`.
    splitting: f64,
    waves: Vec<Wave>,
    /// Images within the cutoff of spheres of the box.
    images: [i32; 3],
    /// Largest number of a wave along each axis.
    most: [i32; 3],
    /// For each sphere.
    phases: Vec<Phases>,
}

/// `exp(i 2π m x / L)` for each axis and `m` from 0.
type Phases = [Vec<Complex<f64>>; 3];

/// A wave; its opposite is the complex conjugate.
struct Wave {
    number: [i32; 3],
    k: Vector3<f64>,
    /// `2 H(k) / (k² V)`, for both.
    weight: f64,
}

/// Derivatives of a radial function, divided by the distance such that they multiply `I` and `r r`.
struct Radial {
    /// Coefficients of `I` and of `n n` in the velocity by a force.
    force: [f64; 2],
    /// Half of the derivative of `∇² f`: coefficients of `n ×` in the velocity by a torque and in
    /// the angular velocity by a force.
    coupling: [f64; 2],
    /// Coefficients of `I` and of `n n` in the angular velocity by a torque.
    torque: [f64; 2],
}

impl PeriodicSums {
    /// The sums for spheres with these radii in the interactions, split where both parts cost the
    /// same, or as given.
    ///
    /// # Errors
    /// [`HydroError::NotFinite`], [`HydroError::PeriodicBox`] for edges that are not positive, too
    /// different or too large for the spheres; [`HydroError::Touching`] and
    /// [`HydroError::TouchingImage`] for a sphere that touches an image.
    pub fn new(
        spheres: &Spheres,
        radii: Vec<f64>,
        size: &Vector3<f64>,
        splitting: Option<f64>,
    ) -> Result<Self, HydroError> {
        check_finite("an edge of the periodic box", size.as_slice())?;
        let problem = |problem: &'static str| HydroError::PeriodicBox {
            size: (*size).into(),
            problem,
        };
        if size.min() <= 0.0 {
            return Err(problem("edges must be greater than zero"));
        }
        if size.max() > MAX_ASPECT * size.min() {
            return Err(problem("no edge may be fifty times as long as another"));
        }
        check_images(spheres, size)?;
        let volume = size.product();
        // Both sums cost the same: with n spheres, n² (4π/3) (s/ξ)³/V pairs within the cutoff
        // and n V (2ξ s)³/(6π²) waves.
        let count = PAIR_COST * spheres.len().max(1) as f64;
        let splitting =
            splitting.unwrap_or_else(|| PI.sqrt() * (count / (volume * volume)).powf(1.0 / 6.0));
        let largest = 2.0 * splitting * CUTOFF;
        let most: [f64; 3] = [0, 1, 2].map(|axis| (largest * size[axis] / (2.0 * PI)).floor());
        let images: [f64; 3] = [0, 1, 2].map(|axis| (CUTOFF / splitting / size[axis] + 0.5).ceil());
        let boxes: f64 = most.iter().map(|m| 2.0 * m + 1.0).product();
        if boxes.max(images.iter().product()) > MAX_WAVES {
            return Err(problem(
                "the box has too many waves for this number of spheres",
            ));
        }
        let most = most.map(|m| m as i32);
        let [x, y, z] = most;
        let mut waves = Vec::new();
        for (i, j, k) in (0..=x)
            .flat_map(|i| (-y..=y).flat_map(move |j| (-z..=z).map(move |k| (i, j, k))))
            .filter(|number| *number > (0, 0, 0))
        {
            let wave = Vector3::new(f64::from(i), f64::from(j), f64::from(k)).component_div(size)
                * (2.0 * PI);
            let squared = wave.norm_squared();
            if squared > largest * largest {
                continue;
            }
            let part = squared / (4.0 * splitting * splitting);
            waves.push(Wave {
                number: [i, j, k],
                k: wave,
                weight: 2.0 * (1.0 + part) * (-part).exp() / (squared * volume),
            });
        }
        let centres = spheres.centres().to_vec();
        Ok(Self {
            size: *size,
            phases: centres.iter().map(|x| phases(x, size, most)).collect(),
            most,
            centres,
            radii,
            splitting,
            waves,
            images: images.map(|n| n as i32),
        })
    }

    /// Velocities and angular velocities by the forces and torques of all spheres and images,
    /// without what each has in unbounded fluid by its own.
    ///
    /// Cost: `O(n^1.5)` operations in parallel for spheres of a given concentration, and `O(n²)`
    /// distances.
    pub fn velocities(&self, forces: &DVector<f64>) -> DVector<f64> {
        let flows = self.flows(forces);
        let count = self.centres.len();
        let mut result = DVector::zeros(6 * count);
        let rows = result.as_mut_slice().par_chunks_mut(6).enumerate();
        rows.for_each(|(at, rows)| {
            let mut sum = self.own(at) * six(forces, at);
            for of in 0..count {
                self.for_images(at, of, |r| {
                    sum += self.image(&r, self.radii[at], self.radii[of]) * six(forces, of);
                });
            }
            for (wave, flow) in self.waves.iter().zip(&flows) {
                sum += self.at_sphere(wave, at, flow);
            }
            rows.copy_from_slice(sum.as_slice());
        });
        result
    }

    /// The same for one sphere by one: a block of the matrix.
    pub fn block(&self, at: usize, of: usize) -> Matrix6<f64> {
        let mut block = match at == of {
            true => self.own(at),
            false => Matrix6::zeros(),
        };
        self.for_images(at, of, |r| {
            block += self.image(&r, self.radii[at], self.radii[of])
        });
        for wave in &self.waves {
            for column in 0..6 {
                let mut unit = Vector6::zeros();
                unit[column] = 1.0;
                let flow = wave.flow(self.source(wave, of, &unit));
                let mut entries = block.column_mut(column);
                entries += self.at_sphere(wave, at, &flow);
            }
        }
        block
    }

    /// Flow of a wave, with its weight.
    fn flow(&self, wave: &Wave, forces: &DVector<f64>) -> Vector3<Complex<f64>> {
        let sources = (0..self.centres.len()).map(|of| self.source(wave, of, &six(forces, of)));
        wave.flow(sources.sum())
    }

    /// Amplitude of the force density of one sphere: `exp(-ik·x) [(1 - a²k²/6) F + i k × T / 2]`.
    fn source(&self, wave: &Wave, of: usize, load: &Vector6<f64>) -> Vector3<Complex<f64>> {
        let (force, torque) = (load.fixed_rows::<3>(0), load.fixed_rows::<3>(3));
        let real = force * wave.reduction(self.radii[of]);
        let imaginary = wave.k.cross(&torque) * 0.5;
        let phase = phase(&self.phases[of], wave).conj();
        real.zip_map(&imaginary, |re, im| phase * Complex::new(re, im))
    }

    /// Velocity and angular velocity of a sphere in the flow of a wave.
    fn at_sphere(&self, wave: &Wave, at: usize, flow: &Vector3<Complex<f64>>) -> Vector6<f64> {
        let local = flow * phase(&self.phases[at], wave);
        let velocity = local.map(|u| u.re) * wave.reduction(self.radii[at]);
        // The real part of i k × u / 2.
        let rotation = wave.k.cross(&local.map(|u| u.im)) * -0.5;
        let mut both = Vector6::zeros();
        both.fixed_rows_mut::<3>(0).copy_from(&velocity);
        both.fixed_rows_mut::<3>(3).copy_from(&rotation);
        both
    }

    /// Velocity of the fluid at a point by the forces and torques of all spheres and images; none
    /// inside a sphere of one of these radii.
    ///
    /// Cost: `O(n)` terms of images, and `O(n^0.5)` waves.
    pub fn flow_at(
        &self,
        x: &Vector3<f64>,
        (forces, flows): (&DVector<f64>, &[Vector3<Complex<f64>>]),
        solid: &[f64],
    ) -> Option<Vector3<f64>> {
        let mut sum = Vector3::zeros();
        for of in 0..self.centres.len() {
            let apart = nearest_image(&(x - self.centres[of]), &self.size);
            if apart.norm() < solid[of] {
                return None;
            }
            let load = six(forces, of);
            self.for_images_of(&apart, |_, r| {
                // The flow of a finite sphere at a point, which is one without a size.
                let velocity = self.image(&r, 0.0, self.radii[of]) * load;
                sum += velocity.fixed_rows::<3>(0);
            });
        }
        let phases = phases(x, &self.size, self.most);
        for (wave, flow) in self.waves.iter().zip(flows) {
            sum += (flow * phase(&phases, wave)).map(|u| u.re);
        }
        Some(sum)
    }

    /// Flows of all waves, with their weights.
    pub fn flows(&self, forces: &DVector<f64>) -> Vec<Vector3<Complex<f64>>> {
        let waves = self.waves.par_iter();
        waves.map(|wave| self.flow(wave, forces)).collect()
    }

    /// Calls `found` with the vectors to a sphere from the images of another one within the cutoff.
    fn for_images(&self, at: usize, of: usize, mut found: impl FnMut(Vector3<f64>)) {
        let nearest = nearest_image(&(self.centres[at] - self.centres[of]), &self.size);
        self.for_images_of(&nearest, |number, r| {
            if at != of || number != [0; 3] {
                found(r);
            }
        });
    }

    /// Calls `found` with the numbers of the images within the cutoff of a place whose nearest
    /// image is given, and with their vectors.
    fn for_images_of(&self, nearest: &Vector3<f64>, mut found: impl FnMut([i32; 3], Vector3<f64>)) {
        let cutoff = (CUTOFF / self.splitting).powi(2);
        let [x, y, z] = self.images;
        for i in -x..=x {
            for j in -y..=y {
                for k in -z..=z {
                    let image = Vector3::new(f64::from(i), f64::from(j), f64::from(k));
                    let r = nearest + image.component_mul(&self.size);
                    if r.norm_squared() < cutoff {
                        found([i, j, k], r);
                    }
                }
            }
        }
    }

    /// Mobility of a sphere at `r` from an image, of radii `a` and `b`.
    fn image(&self, r: &Vector3<f64>, a: f64, b: f64) -> Matrix6<f64> {
        let distance = r.norm();
        let radial = Radial::new(self.splitting, distance, a, b);
        let n = r / distance;
        let (identity, along) = (Matrix3::identity(), n * n.transpose());
        let [isotropic, axial] = radial.force;
        let velocity = identity * isotropic + along * axial;
        let coupling = radial.coupling.map(|factor| n.cross_matrix() * factor);
        let [isotropic, axial] = radial.torque;
        let rotation = identity * isotropic + along * axial;
        let mut block = Matrix6::zeros();
        block.fixed_view_mut::<3, 3>(0, 0).copy_from(&velocity);
        block.fixed_view_mut::<3, 3>(0, 3).copy_from(&coupling[0]);
        block.fixed_view_mut::<3, 3>(3, 0).copy_from(&coupling[1]);
        block.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
        block / (8.0 * PI)
    }

    /// What the waves contain of the flow of a sphere around itself in unbounded fluid, subtracted.
    ///
    /// With `f - r = -(ξ r² - ξ³ r⁴/6 + ξ⁵ r⁶/30 - ..)/√π` up to a constant, `G = 4 c I` for the
    /// coefficient `c` of `r²`.
    fn own(&self, sphere: usize) -> Matrix6<f64> {
        let (xi, a) = (self.splitting, self.radii[sphere]);
        let (first, second) = (a * a / 3.0, a.powi(4) / 36.0);
        let cube = xi.powi(3) * 10.0 / 3.0;
        let velocity = 4.0 * (-xi + first * cube - second * 28.0 * xi.powi(5));
        let diagonal = [velocity, velocity, velocity, -cube, -cube, -cube];
        Matrix6::from_diagonal(&(Vector6::from(diagonal) / (8.0 * PI * PI.sqrt())))
    }
}

impl Wave {
    /// Reduction of the force density, or of the mean velocity, over a sphere.
    fn reduction(&self, radius: f64) -> f64 {
        1.0 - radius * radius * self.k.norm_squared() / 6.0
    }

    /// The solenoidal part of a force density times the weight.
    fn flow(&self, source: Vector3<Complex<f64>>) -> Vector3<Complex<f64>> {
        let along = self.k.map(|k| Complex::new(k / self.k.norm_squared(), 0.0));
        let divergence: Complex<f64> = (self.k.iter().zip(&source)).map(|(k, f)| f * *k).sum();
        (source - along * divergence) * Complex::new(self.weight, 0.0)
    }
}

impl Radial {
    /// The part that is summed over images, for spheres of the radii `a` and `b`.
    ///
    /// `f' = erfc(ξ r)`; `h = ∇² f`, `q = ∇² h`, and the function of finite spheres is
    /// `f + (a² + b²) h/6 + a² b² q/36`, of one that translates and one that turns `f + a² h/6`.
    fn new(xi: f64, r: f64, a: f64, b: f64) -> Self {
        let x = xi * r;
        let erfc = libm::erfc(x);
        let gauss = (-x * x).exp() / PI.sqrt();
        let second = x * x;
        let f = [erfc, -2.0 * xi * gauss];
        let h = [
            -2.0 * erfc / (r * r) + gauss * (4.0 * xi * xi * x - 4.0 * xi / r),
            4.0 * erfc / r.powi(3) + gauss * xi.powi(3) * (8.0 / second + 12.0 - 8.0 * second),
        ];
        let q = [
            gauss * xi.powi(4) * x * (16.0 * second - 56.0),
            gauss * xi.powi(5) * (160.0 * second - 56.0 - 32.0 * second * second),
        ];
        let (c, d) = ((a * a + b * b) / 6.0, a * a * b * b / 36.0);
        let [first, second] = [0, 1].map(|k| f[k] + c * h[k] + d * q[k]);
        // ∇∇h - I ∇²h over four.
        let slope = h[0] / r;
        Self {
            force: [second + first / r, first / r - second],
            coupling: [a, b].map(|of_force| 0.5 * (h[0] + of_force * of_force * q[0] / 6.0)),
            torque: [0.25 * (-slope - h[1]), 0.25 * (h[1] - slope)],
        }
    }
}

/// The phases of a place.
fn phases(x: &Vector3<f64>, size: &Vector3<f64>, most: [i32; 3]) -> Phases {
    [0, 1, 2].map(|axis| {
        let angle = 2.0 * PI * (x[axis] / size[axis]).fract();
        let powers = 0..=most[axis];
        powers.map(|m| Complex::cis(f64::from(m) * angle)).collect()
    })
}

/// `exp(ik·x)` of a wave at a place with these phases.
fn phase(phases: &Phases, wave: &Wave) -> Complex<f64> {
    let factors = phases.iter().zip(wave.number).map(|(table, number)| {
        let factor = table[number.unsigned_abs() as usize];
        if number < 0 { factor.conj() } else { factor }
    });
    factors.product()
}

fn six(forces: &DVector<f64>, sphere: usize) -> Vector6<f64> {
    forces.fixed_rows::<6>(6 * sphere).into_owned()
}

/// The shortest of a vector and its images, along each edge.
fn nearest_image(r: &Vector3<f64>, size: &Vector3<f64>) -> Vector3<f64> {
    r.zip_map(size, |r, size| r - size * (r / size).round())
}

/// Checks that no sphere touches an image of itself or of another one.
fn check_images(spheres: &Spheres, size: &Vector3<f64>) -> Result<(), HydroError> {
    let (x, a) = (spheres.centres(), spheres.radii());
    for second in 0..x.len() {
        let of_images = size.min() - 2.0 * a[second];
        let pairs = (0..second).map(|first| {
            let apart = nearest_image(&(x[second] - x[first]), size).norm();
            (first, apart - a[first] - a[second])
        });
        let closest = pairs.min_by(|one, other| one.1.total_cmp(&other.1));
        if let Some((first, gap)) = closest.filter(|(_, gap)| *gap <= 0.0) {
            return Err(HydroError::Touching { first, second, gap });
        }
        if of_images <= 0.0 {
            return Err(HydroError::TouchingImage {
                sphere: second,
                gap: of_images,
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::{Medium, PointMobility, PointModel};

    const MODELS: [PointModel; 2] = [PointModel::Oseen, PointModel::Rpy];

    /// Spheres of three sizes in a box with different edges, two of them across a face.
    fn some_spheres() -> (Spheres, Vector3<f64>) {
        let centres = [
            [0.1, 0.3, 0.2],
            [6.8, 0.4, 0.5],
            [3.1, 4.2, 7.7],
            [-5.0, 12.3, 2.9],
        ];
        let radii = vec![1.0, 0.7, 1.3, 0.5];
        let spheres = Spheres::new(centres.map(Vector3::from).to_vec(), radii).unwrap();
        (spheres, Vector3::new(9.0, 8.0, 11.0))
    }

    fn matrix(mobility: &PointMobility) -> DMatrix<f64> {
        let all: Vec<usize> = (0..mobility.spheres().len()).collect();
        mobility.block(&all)
    }

    #[test]
    fn the_splitting_does_not_change_the_mobility() {
        let (spheres, size) = some_spheres();
        for model in MODELS {
            let [first, second] = [0.25, 0.6].map(|splitting| {
                let split = PointMobility::split_periodic(model, &spheres, &size, Some(splitting));
                matrix(&split.unwrap())
            });
            let largest = first.amax();
            let change = (first - second).amax() / largest;
            assert!(change < 1e-10, "{model:?}: {change:e}");
        }
    }

    #[test]
    fn the_mobility_is_symmetric_positive_definite_and_the_product_is_its() {
        let (spheres, size) = some_spheres();
        let mobility = PointMobility::periodic(PointModel::Rpy, &spheres, &size).unwrap();
        let all = matrix(&mobility);
        assert!((&all - all.transpose()).amax() < 1e-14 * all.amax());
        assert!(all.clone().symmetric_eigenvalues().min() > 0.0);
        let forces = DVector::from_fn(24, |k, _| ((k * k) as f64).sin());
        let difference = mobility.apply(&forces).unwrap() - &all * &forces;
        // Rounding of sums over some thousand waves.
        assert!(difference.amax() < 1e-13 * all.amax());
    }

    #[test]
    fn shifts_of_all_and_shifts_of_one_by_a_period_change_nothing() {
        let (spheres, size) = some_spheres();
        let shift = Vector3::new(2.3, -7.1, 0.4);
        let moved = spheres.centres().iter().enumerate().map(|(k, x)| match k {
            2 => x + shift + 2.0 * Vector3::new(size.x, -size.y, 0.0),
            _ => x + shift,
        });
        let moved = Spheres::new(moved.collect(), spheres.radii().to_vec()).unwrap();
        for model in MODELS {
            let [before, after] = [&spheres, &moved]
                .map(|spheres| matrix(&PointMobility::periodic(model, spheres, &size).unwrap()));
            assert!(
                (&before - after).amax() < 1e-13 * before.amax(),
                "{model:?}"
            );
        }
    }

    /// Drag of cubic arrays: Hasimoto (1959) `1 - c φ^(1/3) + φ - ..` with the constants that
    /// Sangani & Acrivos (1982) give to four decimals; of Rotne, Prager and Yamakawa the first
    /// three terms, of points the first two.
    #[test]
    fn cubic_arrays_have_the_drag_of_hasimoto() {
        let half = 5.0;
        let size = Vector3::repeat(2.0 * half);
        let corner = [0.0, 0.0, 0.0];
        let faces = [[half, half, 0.0], [half, 0.0, half], [0.0, half, half]];
        let lattices = [
            (1.7601, vec![corner]),
            (1.7918, vec![corner, [half; 3]]),
            (1.7917, [&[corner][..], &faces].concat()),
        ];
        let radius = 0.5;
        for (constant, places) in lattices {
            let count = places.len();
            let centres = places.into_iter().map(Vector3::from).collect();
            let spheres = Spheres::new(centres, vec![radius; count]).unwrap();
            let fraction = count as f64 * 4.0 / 3.0 * PI * radius.powi(3) / size.product();
            let mut forces = DVector::zeros(6 * count);
            (0..count).for_each(|k| forces[6 * k] = 6.0 * PI * radius);
            let [points, finite] = MODELS.map(|model| {
                let mobility = PointMobility::periodic(model, &spheres, &size).unwrap();
                mobility.apply(&forces).unwrap()[0]
            });
            // Half of the last decimal of the constants.
            let expected = 1.0 - constant * fraction.cbrt();
            assert!(
                (points - expected).abs() < 0.6e-4 * fraction.cbrt(),
                "{points} {expected}"
            );
            assert!((finite - points - fraction).abs() < 1e-13);
        }
    }

    #[test]
    fn a_sphere_in_a_cubic_array_turns_slower_by_the_volume_fraction() {
        let spheres = Spheres::new(vec![Vector3::zeros()], vec![1.0]).unwrap();
        let size = Vector3::repeat(6.0);
        let mobility = PointMobility::periodic(PointModel::Rpy, &spheres, &size).unwrap();
        let torque = DVector::from_column_slice(&[0.0, 0.0, 0.0, 0.0, 8.0 * PI, 0.0]);
        let turned = mobility.apply(&torque).unwrap();
        // ∇⁴ r = -8π δ, and the periodic sum has -8π (δ - 1/V): a sixth of 8π/V is lost.
        let expected = 1.0 - 4.0 / 3.0 * PI / size.product();
        assert!((turned[4] - expected).abs() < 1e-13);
    }

    #[test]
    fn pairs_in_a_large_box_are_those_of_unbounded_fluid() {
        let centres = vec![Vector3::zeros(), Vector3::new(2.5, 1.0, -0.5)];
        let spheres = Spheres::new(centres, vec![1.0, 0.6]).unwrap();
        let edge = 3000.0;
        for model in MODELS {
            let alone = PointMobility::new(model, &spheres, &Medium::Unbounded).unwrap();
            let boxed = PointMobility::periodic(model, &spheres, &Vector3::repeat(edge)).unwrap();
            // Equal and opposite forces: a dipole, whose images move by 1/(8π) |d|/L³ times a few.
            let mut forces = DVector::zeros(12);
            (forces[1], forces[7], forces[4], forces[11]) = (1.0, -1.0, 0.3, -0.2);
            let change = alone.apply(&forces).unwrap() - boxed.apply(&forces).unwrap();
            assert!(change.amax() < 10.0 / edge.powi(2), "{change}");
        }
    }

    /// Faxén: the velocity of a sphere is the mean of the flow of the images over its surface, and
    /// its own flow is constant there.
    #[test]
    fn the_flow_at_the_surface_of_a_sphere_is_its_velocity_in_the_mean() {
        let one = Spheres::new(vec![Vector3::new(4.0, -1.0, 9.5)], vec![1.0]).unwrap();
        let size = Vector3::new(9.0, 8.0, 11.0);
        let mobility = PointMobility::periodic(PointModel::Rpy, &one, &size).unwrap();
        let forces = DVector::from_column_slice(&[3.0, -2.0, 5.0, 0.0, 0.0, 0.0]);
        // An octahedron integrates polynomials of the third degree exactly; images have higher ones
        // of at most 3/4 (a/L)^5 each, relative to the velocity of one sphere by the force.
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let around = axes.into_iter().flat_map(|e| [e, -e]);
        let points: Vec<_> = around.map(|e| one.centres()[0] + e + 3.0 * size).collect();
        let flow = mobility.flow(&forces, &points).unwrap();
        let mean = flow.iter().map(|u| u.unwrap()).sum::<Vector3<f64>>() / 6.0;
        let velocity = mobility.apply(&forces).unwrap();
        let difference = (mean - velocity.fixed_rows::<3>(0)).norm();
        // The six nearest images; those along the shortest edge are at the distance 8.
        let alone = 38f64.sqrt() / (6.0 * PI);
        let bound = 6.0 * 0.75 * 8f64.powi(-5) * alone;
        assert!(difference < bound, "{difference:e} {bound:e}");
        let inside = mobility.flow(&forces, &[one.centres()[0] - size]).unwrap();
        assert_eq!(inside, [None]);
    }

    #[test]
    fn boxes_that_do_not_fit_are_refused() {
        let one = Spheres::new(vec![Vector3::zeros()], vec![1.0]).unwrap();
        let refused = |x: f64, y: f64, z: f64| {
            let size = Vector3::new(x, y, z);
            PointMobility::periodic(PointModel::Rpy, &one, &size)
                .err()
                .unwrap()
        };
        for (x, y) in [(0.0, 5.0), (-5.0, 5.0), (5.0, 1e3)] {
            assert!(matches!(refused(x, y, 5.0), HydroError::PeriodicBox { .. }));
        }
        assert!(matches!(
            refused(f64::NAN, 5.0, 5.0),
            HydroError::NotFinite { .. }
        ));
        assert!(matches!(
            refused(1.9, 5.0, 5.0),
            HydroError::TouchingImage { sphere: 0, gap } if (gap + 0.1).abs() < 1e-15
        ));
        let pair = vec![Vector3::zeros(), Vector3::new(8.5, 0.0, 0.0)];
        let pair = Spheres::new(pair, vec![1.0; 2]).unwrap();
        let touching = PointMobility::periodic(PointModel::Oseen, &pair, &Vector3::repeat(10.0));
        assert!(matches!(
            touching,
            Err(HydroError::Touching {
                first: 0,
                second: 1,
                ..
            })
        ));
        let mobility = PointMobility::periodic(PointModel::Rpy, &one, &Vector3::repeat(9.0));
        let mobility = mobility.unwrap();
        let forces = DVector::zeros(6);
        assert!(mobility.first_reflection(&forces).is_err());
    }
}
