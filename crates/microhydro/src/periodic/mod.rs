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
//! `(1 + a²∇²/6)(1 + b²∇²/6)` to both parts, torques and angular velocities half a curl; squirmers
//! are stresslets `S : ∇G` and dipoles `∇²G L`. Without the wave `k = 0` the mean flow is zero: a
//! pressure gradient balances the sum of the forces.
//!
//! Tensors of derivatives of a radial function follow from the powers of `D = (1/r) d/dr`:
//! `∇∇g = Dg I + D²g r r`, `∇²g = 3 Dg + r² D²g`.

mod images;
mod source;
mod waves;

use std::f64::consts::PI;

use nalgebra::{DVector, Matrix3, Matrix6, Vector3, Vector6};
use rayon::prelude::*;

use self::source::Source;
use self::waves::{Flow, Phases, Placed, Waves};
use crate::error::check_finite;
use crate::{HydroError, Spheres, Squirmer};

/// Argument of `erfc` and exponent of waves at which both sums end: `exp(-36) = 2e-16`.
const CUTOFF: f64 = 6.0;

/// Cost of a pair of spheres in the sum over images relative to a sphere and a wave.
const PAIR_COST: f64 = 25.0;

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
    waves: Waves,
    /// For each sphere.
    phases: Vec<Phases>,
}

/// Sources of all spheres with the flows of their waves.
pub(crate) struct PeriodicFlow {
    sources: Vec<Source>,
    waves: Vec<Flow>,
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
        check_box(spheres, size)?;
        Self::of_points(spheres.centres().to_vec(), radii, size, splitting)
    }

    /// The same for points, which may be as near to each other and to their images as they like,
    /// in a box that [`check_box`] accepts.
    ///
    /// # Errors
    /// [`HydroError::PeriodicBox`] for a box that is too large for the points.
    pub fn of_points(
        centres: Vec<Vector3<f64>>,
        radii: Vec<f64>,
        size: &Vector3<f64>,
        splitting: Option<f64>,
    ) -> Result<Self, HydroError> {
        let splitting = splitting.unwrap_or_else(|| Self::splitting(centres.len(), size, 1.0));
        let largest = 2.0 * splitting * CUTOFF;
        let most = Waves::most(size, largest).map(|m| 2.0 * m + 1.0);
        let images = size.map(|edge| 2.0 * CUTOFF / splitting / edge + 1.0);
        if most.iter().product::<f64>().max(images.product()) > MAX_WAVES {
            return Err(bad_box(
                size,
                "the box has too many waves for this number of spheres",
            ));
        }
        let waves = Waves::new(size, splitting, largest);
        Ok(Self {
            size: *size,
            phases: centres.iter().map(|x| waves.phases(x)).collect(),
            centres,
            radii,
            splitting,
            waves,
        })
    }

    /// The splitting for which the sums over waves take as long as those over images, if these are
    /// found once for a number of products.
    pub fn splitting(spheres: usize, size: &Vector3<f64>, products: f64) -> f64 {
        // With n spheres, n² (4π/3) (s/ξ)³/V pairs within the cutoff and n V (2ξ s)³/(6π²) waves.
        let count = PAIR_COST / products * spheres.max(1) as f64;
        PI.sqrt() * (count / size.product().powi(2)).powf(1.0 / 6.0)
    }

    /// The part of the velocity of a point that is summed over images, by a force on one, as a
    /// matrix.
    pub fn images_of_point(&self, at: usize, of: usize) -> Matrix3<f64> {
        let mut sum = match at == of {
            true => {
                let unit = Source::of_load(&Vector6::x());
                Matrix3::from_diagonal_element(images::own(self.splitting, 0.0, &unit)[0])
            }
            false => Matrix3::zeros(),
        };
        let apart = nearest_image(&(self.centres[at] - self.centres[of]), &self.size);
        self.for_images(&apart, |is_nearest, r| {
            if at != of || !is_nearest {
                sum += images::point(self.splitting, &r);
            }
        });
        sum
    }

    /// The other part of the velocities of all points by forces on them.
    pub fn by_waves(&self, forces: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let source = |force: &Vector3<f64>| Source {
            force: *force,
            torque: Vector3::zeros(),
            slip: None,
        };
        let placed: Vec<Placed> = (forces.iter().enumerate())
            .map(|(of, force)| self.placed(of, source(force)))
            .collect();
        let flows = self.waves.flows(&placed);
        let at = |phases: &Phases| {
            self.waves
                .at(phases, 0.0, &flows)
                .fixed_rows::<3>(0)
                .into_owned()
        };
        self.phases.par_iter().map(at).collect()
    }

    /// Velocities and angular velocities by the forces and torques of all spheres and images,
    /// without each sphere's own contribution in unbounded fluid.
    ///
    /// Cost: `O(n^1.5)` operations in parallel for spheres of a given concentration, and `O(n²)`
    /// distances.
    pub fn velocities(&self, forces: &DVector<f64>) -> DVector<f64> {
        self.sums(&self.flow(forces, &[]))
    }

    /// Velocities and angular velocities by squirmers and their images, without each one's own
    /// contribution in unbounded fluid.
    pub fn velocities_by_slip(&self, squirmers: &[Squirmer]) -> DVector<f64> {
        let forces = DVector::zeros(6 * self.centres.len());
        self.sums(&self.flow(&forces, squirmers))
    }

    fn sums(&self, flow: &PeriodicFlow) -> DVector<f64> {
        let count = self.centres.len();
        let mut result = DVector::zeros(6 * count);
        let rows = result.as_mut_slice().par_chunks_mut(6).enumerate();
        rows.for_each(|(at, rows)| {
            let size = self.size_of(at);
            let mut sum = images::own(self.splitting, self.radii[at], &flow.sources[at]);
            for of in 0..count {
                sum += self.by_images(at, of, &flow.sources[of]);
            }
            sum += self.waves.at(&self.phases[at], size, &flow.waves);
            rows.copy_from_slice(sum.as_slice());
        });
        result
    }

    /// The mobility of one sphere by one: a block of the matrix.
    pub fn block(&self, at: usize, of: usize) -> Matrix6<f64> {
        Matrix6::from_columns(&[0, 1, 2, 3, 4, 5].map(|column| {
            let mut unit = Vector6::zeros();
            unit[column] = 1.0;
            let source = Source::of_load(&unit);
            let mut sum = self.by_images(at, of, &source);
            if at == of {
                sum += images::own(self.splitting, self.radii[at], &source);
            }
            let waves = self.waves.flows(&[self.placed(of, source)]);
            sum + self.waves.at(&self.phases[at], self.size_of(at), &waves)
        }))
    }

    /// Flow by forces and torques, and by squirmers, of all spheres or of none.
    pub fn flow(&self, forces: &DVector<f64>, squirmers: &[Squirmer]) -> PeriodicFlow {
        let source = |k: usize| {
            let slip = squirmers.get(k).map(|own| {
                let radius = self.radii[k];
                (own.dipole(radius), own.stresslet(radius))
            });
            let load = forces.fixed_rows::<6>(6 * k).into_owned();
            Source {
                slip,
                ..Source::of_load(&load)
            }
        };
        let sources: Vec<Source> = (0..self.centres.len()).map(source).collect();
        let placed: Vec<Placed> = (sources.iter().enumerate())
            .map(|(of, source)| self.placed(of, *source))
            .collect();
        PeriodicFlow {
            waves: self.waves.flows(&placed),
            sources,
        }
    }

    /// Velocity of the fluid at a point; none inside a sphere of one of these radii.
    ///
    /// Cost: `O(n)` terms of images, and `O(n^0.5)` waves.
    pub fn flow_at(
        &self,
        x: &Vector3<f64>,
        flow: &PeriodicFlow,
        solid: &[f64],
    ) -> Option<Vector3<f64>> {
        let mut sum = Vector6::zeros();
        for (of, source) in flow.sources.iter().enumerate() {
            let apart = nearest_image(&(x - self.centres[of]), &self.size);
            if apart.norm() < solid[of] {
                return None;
            }
            self.for_images(&apart, |_, r| {
                // The flow of a finite sphere at a point, which is one without a size.
                sum += images::velocity(self.splitting, &r, [0.0, self.radii[of]], source);
            });
        }
        sum += self.waves.at(&self.waves.phases(x), 0.0, &flow.waves);
        Some(sum.fixed_rows::<3>(0).into_owned())
    }

    fn placed(&self, of: usize, source: Source) -> Placed<'_> {
        Placed {
            phases: &self.phases[of],
            size: self.size_of(of),
            source,
        }
    }

    /// The square of a radius over six.
    fn size_of(&self, sphere: usize) -> f64 {
        self.radii[sphere].powi(2) / 6.0
    }

    /// Velocity and angular velocity of a sphere by the images of a source within the cutoff.
    fn by_images(&self, at: usize, of: usize, source: &Source) -> Vector6<f64> {
        let apart = nearest_image(&(self.centres[at] - self.centres[of]), &self.size);
        let radii = [self.radii[at], self.radii[of]];
        let mut sum = Vector6::zeros();
        self.for_images(&apart, |is_nearest, r| {
            if at != of || !is_nearest {
                sum += images::velocity(self.splitting, &r, radii, source);
            }
        });
        sum
    }

    /// Calls `found` with the vectors to a place from the images within the cutoff of another one
    /// whose nearest image is given, and whether it is that.
    fn for_images(&self, nearest: &Vector3<f64>, mut found: impl FnMut(bool, Vector3<f64>)) {
        let cutoff = CUTOFF / self.splitting;
        images_within(cutoff, nearest, &self.size, |image, r| {
            found(image == [0; 3], r);
        });
    }
}

/// Calls `found` with the images of a vector that are shorter than `cutoff`, and their shifts in
/// edges of the box.
pub(crate) fn images_within(
    cutoff: f64,
    vector: &Vector3<f64>,
    size: &Vector3<f64>,
    mut found: impl FnMut([i32; 3], Vector3<f64>),
) {
    let range = |axis: usize| {
        let (x, edge) = (vector[axis], size[axis]);
        ((-cutoff - x) / edge).ceil() as i32..=((cutoff - x) / edge).floor() as i32
    };
    for i in range(0) {
        for j in range(1) {
            for k in range(2) {
                let image = Vector3::new(f64::from(i), f64::from(j), f64::from(k));
                let r = vector + image.component_mul(size);
                if r.norm_squared() < cutoff * cutoff {
                    found([i, j, k], r);
                }
            }
        }
    }
}

fn bad_box(size: &Vector3<f64>, problem: &'static str) -> HydroError {
    HydroError::PeriodicBox {
        size: (*size).into(),
        problem,
    }
}

/// Checks the edges of a box, and that no sphere in it touches an image.
///
/// # Errors
/// [`HydroError::PeriodicBox`], [`HydroError::Touching`], [`HydroError::TouchingImage`].
pub(crate) fn check_box(spheres: &Spheres, size: &Vector3<f64>) -> Result<(), HydroError> {
    check_finite("an edge of the periodic box", size.as_slice())?;
    if size.min() <= 0.0 {
        return Err(bad_box(size, "edges must be greater than zero"));
    }
    if size.max() > MAX_ASPECT * size.min() {
        return Err(bad_box(
            size,
            "no edge may be fifty times as long as another",
        ));
    }
    check_images(spheres, size)
}

/// The shortest of a vector and its images, along each edge.
pub(crate) fn nearest_image(r: &Vector3<f64>, size: &Vector3<f64>) -> Vector3<f64> {
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
        let flow = mobility.flow(&forces, &[], &points).unwrap();
        let mean = flow.iter().map(|u| u.unwrap()).sum::<Vector3<f64>>() / 6.0;
        let velocity = mobility.apply(&forces).unwrap();
        let difference = (mean - velocity.fixed_rows::<3>(0)).norm();
        // The six nearest images; those along the shortest edge are at the distance 8.
        let alone = 38f64.sqrt() / (6.0 * PI);
        let bound = 6.0 * 0.75 * 8f64.powi(-5) * alone;
        assert!(difference < bound, "{difference:e} {bound:e}");
        let inside = mobility
            .flow(&forces, &[], &[one.centres()[0] - size])
            .unwrap();
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
