//! Sums over all pairs of spheres without a matrix: velocities by forces, strain rates by forces,
//! velocities by stresslets.
//!
//! At run time `pulp` selects the vector instructions of the processor. Each lane is one sphere at
//! which the flow is summed, in the order of the sources, so that a sum depends neither on the
//! number of lanes nor on that of threads.

use std::f64::consts::PI;
use std::marker::PhantomData;
use std::sync::OnceLock;

use nalgebra::{DVector, Matrix3, Vector3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use crate::Spheres;
use crate::fast_sums::{FastSums, Observed, SYMMETRIC, Singularities};
use crate::squirmer::{self, Squirmer};

/// Spheres that a thread treats at a time: a multiple of the lanes of all processors.
const BLOCK: usize = 32;

/// Number of spheres from which sums over all pairs take longer than by a fast multipole method:
/// 0.5 and 1.6 of its time for 3000 and 10 000 spheres in a cube.
pub(crate) const FAST_FROM: usize = 5000;

/// Largest number of spheres at which fast sums are compared with sums over all pairs, whose sums
/// take less than a product.
const SAMPLES: usize = 8 * BLOCK;

/// Factor on the largest error at these for that at all.
const SAMPLE_FACTOR: f64 = 2.0;

/// Centres and squared radii as columns, padded to whole blocks.
pub(crate) struct Columns {
    count: usize,
    /// Coordinates and squared radii.
    columns: [Vec<f64>; 4],
    /// The tree of the centres, once it is needed.
    fast: OnceLock<FastSums>,
}

/// The flow of a source at a sphere: adds to the sums.
///
/// `r` points from the source to the sphere, `inverse` is one over its length and zero for the
/// sphere itself. The squared radii are those of the sphere and of the source.
trait Flow {
    fn add<S: Simd>(
        simd: S,
        r: [S::f64s; 3],
        inverse: S::f64s,
        squares: [S::f64s; 2],
        source: [S::f64s; 6],
        sums: &mut [S::f64s; 6],
    );

    /// The singularities whose flow it is, for the six numbers and the squared radius of a source.
    fn singularities(source: &[f64; 6], square: f64) -> Singularities;

    /// What of the flow the six sums are.
    const OBSERVED: Observed;
}

/// A block of spheres and all sources.
struct Block<'a, F> {
    flow: PhantomData<F>,
    spheres: [&'a [f64]; 4],
    /// Coordinates and squared radii of the sources.
    places: &'a [[f64; 4]],
    sources: &'a [[f64; 6]],
    /// Six columns of the block.
    sums: &'a mut [f64],
}

impl<F: Flow> WithSimd for Block<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let [x, y, z, square] = self.spheres.map(|column| S::as_simd_f64s(column).0);
        let lanes = size_of::<S::f64s>() / size_of::<f64>();
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        for k in 0..x.len() {
            let mut sums = [zero; 6];
            for (place, source) in self.places.iter().zip(self.sources) {
                let r = [
                    simd.sub_f64s(x[k], simd.splat_f64s(place[0])),
                    simd.sub_f64s(y[k], simd.splat_f64s(place[1])),
                    simd.sub_f64s(z[k], simd.splat_f64s(place[2])),
                ];
                let squared = dot(simd, &r, &r);
                let inverse = simd.div_f64s(one, simd.sqrt_f64s(squared));
                let apart = simd.greater_than_f64s(squared, zero);
                let inverse = simd.select_f64s(apart, inverse, zero);
                let mut of_source = [zero; 6];
                for (lane, number) in of_source.iter_mut().zip(source) {
                    *lane = simd.splat_f64s(*number);
                }
                let squares = [square[k], simd.splat_f64s(place[3])];
                F::add(simd, r, inverse, squares, of_source, &mut sums);
            }
            for (component, sum) in sums.iter().enumerate() {
                let first = component * BLOCK + k * lanes;
                simd.partial_store_f64s(&mut self.sums[first..first + lanes], *sum);
            }
        }
    }
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: &[S::f64s; 3], b: &[S::f64s; 3]) -> S::f64s {
    let sum = simd.mul_f64s(a[0], b[0]);
    let sum = simd.mul_add_f64s(a[1], b[1], sum);
    simd.mul_add_f64s(a[2], b[2], sum)
}

#[inline(always)]
fn cross<S: Simd>(simd: S, a: &[S::f64s; 3], b: &[S::f64s; 3]) -> [S::f64s; 3] {
    [
        simd.sub_f64s(simd.mul_f64s(a[1], b[2]), simd.mul_f64s(a[2], b[1])),
        simd.sub_f64s(simd.mul_f64s(a[2], b[0]), simd.mul_f64s(a[0], b[2])),
        simd.sub_f64s(simd.mul_f64s(a[0], b[1]), simd.mul_f64s(a[1], b[0])),
    ]
}

/// Velocity and angular velocity by a force and a torque, times 8π.
///
/// ```text
/// U = (1 + s/(3 d²)) F/d + (1 - s/d²) r (r·F)/d³ + T × r/d³
/// ω = F × r/d³ + (3 r (r·T)/d⁵ - T/d³)/2
/// ```
struct Velocity;

impl Flow for Velocity {
    #[inline(always)]
    fn add<S: Simd>(
        simd: S,
        r: [S::f64s; 3],
        inverse: S::f64s,
        squares: [S::f64s; 2],
        [fx, fy, fz, tx, ty, tz]: [S::f64s; 6],
        sums: &mut [S::f64s; 6],
    ) {
        let (force, torque) = ([fx, fy, fz], [tx, ty, tz]);
        let second = simd.mul_f64s(inverse, inverse);
        let third = simd.mul_f64s(second, inverse);
        let s = simd.mul_f64s(simd.add_f64s(squares[0], squares[1]), second);
        let one = simd.splat_f64s(1.0);
        // (1 + s/(3 d²))/d, and (1 - s/d²) (r·F)/d³
        let across = simd.mul_add_f64s(s, simd.splat_f64s(1.0 / 3.0), one);
        let across = simd.mul_f64s(across, inverse);
        let along = simd.mul_f64s(simd.sub_f64s(one, s), third);
        let along = simd.mul_f64s(along, dot(simd, &r, &force));
        // (3/2) (r·T)/d⁵, and -1/(2 d³)
        let twist = simd.mul_f64s(simd.mul_f64s(third, second), dot(simd, &r, &torque));
        let twist = simd.mul_f64s(twist, simd.splat_f64s(1.5));
        let spin = simd.mul_f64s(third, simd.splat_f64s(-0.5));
        let of_torque = cross(simd, &torque, &r);
        let of_force = cross(simd, &force, &r);
        for k in 0..3 {
            let sum = simd.mul_add_f64s(across, force[k], sums[k]);
            let sum = simd.mul_add_f64s(along, r[k], sum);
            sums[k] = simd.mul_add_f64s(third, of_torque[k], sum);
            let sum = simd.mul_add_f64s(third, of_force[k], sums[k + 3]);
            let sum = simd.mul_add_f64s(twist, r[k], sum);
            sums[k + 3] = simd.mul_add_f64s(spin, torque[k], sum);
        }
    }

    fn singularities(source: &[f64; 6], square: f64) -> Singularities {
        of_load(source, square)
    }

    const OBSERVED: Observed = Observed::Velocity;
}

/// Singularities of a force and a torque on a sphere: `F`, `(b²/6) ∇²F`, and a rotlet.
fn of_load(&[fx, fy, fz, tx, ty, tz]: &[f64; 6], square: f64) -> Singularities {
    let force = Vector3::new(fx, fy, fz);
    Singularities {
        force,
        // D_kl = ε_mkl T_m/2
        force_dipole: Vector3::new(tx, ty, tz).cross_matrix().transpose() * 0.5,
        dipole: force * (square / 3.0),
        ..Singularities::default()
    }
}

/// Strain rate by a force and a torque, times 8π, averaged over a sphere of the radius `a` for a
/// sphere of the radius `b` as source.
///
/// With `c = a²/10 + b²/6` (Faxen's laws; Kim & Karrila 1991, section 3.2):
///
/// ```text
/// E = (r·F) (I/d³ - 3 r r/d⁵) + c [30 r r (r·F)/d⁷ - 6 (F r + r F)/d⁵ - 6 I (r·F)/d⁵]
///     - (3/2) [(T × r) r + r (T × r)]/d⁵
/// ```
struct StrainRate;

impl Flow for StrainRate {
    #[inline(always)]
    fn add<S: Simd>(
        simd: S,
        r: [S::f64s; 3],
        inverse: S::f64s,
        squares: [S::f64s; 2],
        [fx, fy, fz, tx, ty, tz]: [S::f64s; 6],
        sums: &mut [S::f64s; 6],
    ) {
        let (force, torque) = ([fx, fy, fz], [tx, ty, tz]);
        let second = simd.mul_f64s(inverse, inverse);
        let third = simd.mul_f64s(second, inverse);
        let fifth = simd.mul_f64s(third, second);
        let along = dot(simd, &r, &force);
        let c = simd.mul_f64s(squares[0], simd.splat_f64s(0.1));
        let c = simd.mul_add_f64s(squares[1], simd.splat_f64s(1.0 / 6.0), c);
        let dipole = simd.mul_f64s(simd.mul_f64s(c, fifth), simd.splat_f64s(-6.0));
        // of I: (r·F) (1/d³ - 6 c/d⁵); of r r: (r·F) (-3/d⁵ + 30 c/d⁷)
        let isotropic = simd.mul_f64s(along, simd.add_f64s(third, dipole));
        let of_r = simd.mul_f64s(fifth, simd.splat_f64s(-3.0));
        let of_r = simd.sub_f64s(
            of_r,
            simd.mul_f64s(simd.mul_f64s(dipole, second), simd.splat_f64s(5.0)),
        );
        let of_r = simd.mul_f64s(along, of_r);
        let swirl = cross(simd, &torque, &r);
        let rotlet = simd.mul_f64s(fifth, simd.splat_f64s(-1.5));
        // v r + r v has both -6 c F/d⁵ and -(3/2) T × r/d⁵
        let mut v = force;
        for k in 0..3 {
            v[k] = simd.mul_f64s(v[k], dipole);
            v[k] = simd.mul_add_f64s(swirl[k], rotlet, v[k]);
        }
        for (sum, (i, j)) in sums.iter_mut().zip(SYMMETRIC) {
            let mut part = simd.mul_f64s(simd.mul_f64s(of_r, r[i]), r[j]);
            part = simd.mul_add_f64s(v[i], r[j], part);
            part = simd.mul_add_f64s(v[j], r[i], part);
            if i == j {
                part = simd.add_f64s(part, isotropic);
            }
            *sum = simd.add_f64s(*sum, part);
        }
    }

    fn singularities(source: &[f64; 6], square: f64) -> Singularities {
        of_load(source, square)
    }

    const OBSERVED: Observed = Observed::StrainRate;
}

/// Velocity and angular velocity by a stresslet, times 8π: the adjoint of [`StrainRate`], for a
/// sphere of the radius `a` and a source of the radius `b`.
///
/// With `q = r·S r` and `c = a²/6 + b²/10`:
///
/// ```text
/// U = -3 r q/d⁵ + c [30 r q/d⁷ - 12 S r/d⁵]
/// ω = -3 (S r) × r/d⁵
/// ```
struct StressletVelocity;

impl Flow for StressletVelocity {
    #[inline(always)]
    fn add<S: Simd>(
        simd: S,
        r: [S::f64s; 3],
        inverse: S::f64s,
        squares: [S::f64s; 2],
        [xx, yy, zz, xy, xz, yz]: [S::f64s; 6],
        sums: &mut [S::f64s; 6],
    ) {
        let second = simd.mul_f64s(inverse, inverse);
        let fifth = simd.mul_f64s(simd.mul_f64s(second, second), inverse);
        let product = [
            dot(simd, &[xx, xy, xz], &r),
            dot(simd, &[xy, yy, yz], &r),
            dot(simd, &[xz, yz, zz], &r),
        ];
        let q = dot(simd, &product, &r);
        let c = simd.mul_f64s(squares[0], simd.splat_f64s(1.0 / 6.0));
        let c = simd.mul_add_f64s(squares[1], simd.splat_f64s(0.1), c);
        let dipole = simd.mul_f64s(simd.mul_f64s(c, fifth), simd.splat_f64s(-12.0));
        let of_r = simd.mul_f64s(fifth, simd.splat_f64s(-3.0));
        let of_r = simd.sub_f64s(
            of_r,
            simd.mul_f64s(simd.mul_f64s(dipole, second), simd.splat_f64s(2.5)),
        );
        let of_r = simd.mul_f64s(q, of_r);
        let swirl = cross(simd, &product, &r);
        let rotation = simd.mul_f64s(fifth, simd.splat_f64s(-3.0));
        for k in 0..3 {
            let sum = simd.mul_add_f64s(of_r, r[k], sums[k]);
            sums[k] = simd.mul_add_f64s(dipole, product[k], sum);
            sums[k + 3] = simd.mul_add_f64s(rotation, swirl[k], sums[k + 3]);
        }
    }

    fn singularities(&[xx, yy, zz, xy, xz, yz]: &[f64; 6], square: f64) -> Singularities {
        let stresslet = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        Singularities {
            force_dipole: -stresslet,
            // (b²/10) ∇² of it
            quadrupole: stresslet * (-square / 5.0),
            ..Singularities::default()
        }
    }

    const OBSERVED: Observed = Observed::Velocity;
}

/// Velocity by a dipole of a potential flow, the first three numbers, times 8π:
/// `U = 2 L/d³ - 6 r (r·L)/d⁵`, the same on average over a sphere.
struct DipoleVelocity;

impl Flow for DipoleVelocity {
    #[inline(always)]
    fn add<S: Simd>(
        simd: S,
        r: [S::f64s; 3],
        inverse: S::f64s,
        _: [S::f64s; 2],
        [x, y, z, ..]: [S::f64s; 6],
        sums: &mut [S::f64s; 6],
    ) {
        let dipole = [x, y, z];
        let second = simd.mul_f64s(inverse, inverse);
        let third = simd.mul_f64s(second, inverse);
        let across = simd.add_f64s(third, third);
        let along = simd.mul_f64s(simd.mul_f64s(third, second), simd.splat_f64s(-6.0));
        let along = simd.mul_f64s(along, dot(simd, &r, &dipole));
        for k in 0..3 {
            let sum = simd.mul_add_f64s(across, dipole[k], sums[k]);
            sums[k] = simd.mul_add_f64s(along, r[k], sum);
        }
    }

    fn singularities(&[x, y, z, ..]: &[f64; 6], _: f64) -> Singularities {
        Singularities {
            dipole: Vector3::new(x, y, z) * 2.0,
            ..Singularities::default()
        }
    }

    const OBSERVED: Observed = Observed::Velocity;
}

impl Columns {
    /// The columns of spheres with these radii; zero radii make points of them.
    pub fn new(centres: &[Vector3<f64>], radii: impl Iterator<Item = f64>) -> Self {
        let count = centres.len();
        let padded = count.next_multiple_of(BLOCK);
        let column = |of: &dyn Fn(usize) -> f64| {
            (0..padded)
                .map(|k| if k < count { of(k) } else { 0.0 })
                .collect()
        };
        let radii: Vec<f64> = radii.collect();
        Self {
            count,
            columns: [
                column(&|k| centres[k].x),
                column(&|k| centres[k].y),
                column(&|k| centres[k].z),
                column(&|k| radii[k].powi(2)),
            ],
            fast: OnceLock::new(),
        }
    }

    /// The tree of the centres.
    fn tree(&self) -> &FastSums {
        self.fast.get_or_init(|| {
            let centres: Vec<_> = (0..self.count).map(|k| self.centre(k)).collect();
            FastSums::new(&centres)
        })
    }

    fn centre(&self, k: usize) -> Vector3<f64> {
        let [x, y, z, _] = &self.columns;
        Vector3::new(x[k], y[k], z[k])
    }

    /// Columns of some of the spheres.
    fn part(&self, some: &[usize]) -> Self {
        let centres: Vec<_> = some.iter().map(|&k| self.centre(k)).collect();
        let [.., squares] = &self.columns;
        Self::new(&centres, some.iter().map(|&k| squares[k].sqrt()))
    }

    /// Largest errors of velocities and angular velocities by forces and by slip, from sums over
    /// all pairs at some spheres; zero where the sums are over all pairs.
    ///
    /// Cost: a product, and `O(n)`.
    pub fn errors(
        &self,
        spheres: &Spheres,
        forces: &DVector<f64>,
        squirmers: &[Squirmer],
    ) -> [f64; 2] {
        if self.count < FAST_FROM {
            return [0.0; 2];
        }
        let some = self.tree().corners(SAMPLES);
        let part = self.part(&some);
        let mut changes = vec![(self.velocities(forces), part.sums::<Velocity>(self, forces))];
        if !squirmers.is_empty() {
            let of = |columns: &Self| columns.velocities_by_slip(spheres, squirmers);
            changes.push((of(self), of(&part)));
        }
        [0, 3].map(|first| {
            let of_sphere = |sum: f64, (number, sphere): (usize, &usize)| {
                let errors = changes.iter().map(|(all, exact)| {
                    let all = all.fixed_rows::<3>(6 * sphere + first);
                    (all - exact.fixed_rows::<3>(6 * number + first)).norm()
                });
                // a NaN is the largest error
                let error = errors.sum::<f64>();
                if error <= sum || sum.is_nan() {
                    sum
                } else {
                    error
                }
            };
            SAMPLE_FACTOR * some.iter().enumerate().fold(0.0, of_sphere)
        })
    }

    /// Velocities and angular velocities by the forces and torques of all other spheres.
    pub fn velocities(&self, forces: &DVector<f64>) -> DVector<f64> {
        self.sums::<Velocity>(self, forces)
    }

    /// Velocities and angular velocities at points outside the spheres by their forces and torques,
    /// six numbers per point.
    pub fn velocities_at(&self, points: &[Vector3<f64>], forces: &DVector<f64>) -> DVector<f64> {
        Self::of_points(points).sums::<Velocity>(self, forces)
    }

    /// Strain rates by the forces and torques of all other spheres, as `xx, yy, zz, xy, xz, yz`.
    pub fn strain_rates(&self, forces: &DVector<f64>) -> DVector<f64> {
        self.sums::<StrainRate>(self, forces)
    }

    /// Velocities and angular velocities by the stresslets of all other spheres.
    pub fn stresslet_velocities(&self, stresslets: &DVector<f64>) -> DVector<f64> {
        self.sums::<StressletVelocity>(self, stresslets)
    }

    /// Velocities and angular velocities by dipoles and stresslets of squirmers at other places.
    ///
    /// A squirmer's stresslet has `a²/6` in place of the `a²/10` of a rigid sphere in a strain.
    pub fn velocities_by_slip(&self, spheres: &Spheres, squirmers: &[Squirmer]) -> DVector<f64> {
        let [dipoles, stresslets] = squirmer::singularities(spheres, squirmers);
        let widened = spheres.radii().iter().map(|a| a * (10.0_f64 / 6.0).sqrt());
        let sources = Self::new(spheres.centres(), widened);
        self.sums::<DipoleVelocity>(&sources, &dipoles)
            + self.sums::<StressletVelocity>(&sources, &stresslets)
    }

    /// Columns of points.
    pub fn of_points(points: &[Vector3<f64>]) -> Self {
        Self::new(points, points.iter().map(|_| 0.0))
    }

    /// Sums of six numbers per sphere for six numbers per source at `places`: `O(n²)` operations in
    /// parallel, `O(n)` numbers; `O(n)` operations for many spheres at the places of the sources.
    fn sums<F: Flow>(&self, places: &Self, sources: &DVector<f64>) -> DVector<f64> {
        let places_of = |columns: &Self| -> Vec<[f64; 4]> {
            (0..columns.count)
                .map(|k| columns.columns.each_ref().map(|column| column[k]))
                .collect()
        };
        let sources: Vec<[f64; 6]> = (sources.as_slice().chunks_exact(6))
            .map(|six| [six[0], six[1], six[2], six[3], six[4], six[5]])
            .collect();
        let mut result = DVector::zeros(6 * self.count);
        let own = places_of(self);
        if self.count >= FAST_FROM && self.columns[..3] == places.columns[..3] {
            let fast = self.tree();
            let order = fast.order();
            let sums = fast_sums::<F>(
                fast,
                &order.iter().map(|&k| own[k]).collect::<Vec<_>>(),
                &order
                    .iter()
                    .map(|&k| places.columns[3][k])
                    .collect::<Vec<_>>(),
                &order.iter().map(|&k| sources[k]).collect::<Vec<_>>(),
            );
            for (&k, sums) in order.iter().zip(sums) {
                result.as_mut_slice()[6 * k..6 * k + 6].copy_from_slice(&sums);
            }
        } else {
            let places = places_of(places);
            let blocks = result
                .as_mut_slice()
                .par_chunks_mut(6 * BLOCK)
                .zip(own.par_chunks(BLOCK));
            blocks.for_each(|(rows, spheres)| block_sums::<F>(spheres, &places, &sources, rows));
        }
        result / (8.0 * PI)
    }
}

/// Sums at no more than [`BLOCK`] spheres, six numbers for each, times 8π.
///
/// Spheres and sources are given by their coordinates and squared radii.
fn block_sums<F: Flow>(
    spheres: &[[f64; 4]],
    places: &[[f64; 4]],
    sources: &[[f64; 6]],
    rows: &mut [f64],
) {
    let mut columns = [[0.0; BLOCK]; 4];
    for (k, sphere) in spheres.iter().enumerate() {
        for (column, number) in columns.iter_mut().zip(sphere) {
            column[k] = *number;
        }
    }
    let mut sums = [0.0; 6 * BLOCK];
    Arch::new().dispatch(Block::<F> {
        flow: PhantomData,
        spheres: columns.each_ref().map(|column| &column[..]),
        places,
        sources,
        sums: &mut sums,
    });
    for (k, row) in rows.chunks_exact_mut(6).enumerate() {
        for (component, entry) in row.iter_mut().enumerate() {
            *entry = sums[component * BLOCK + k];
        }
    }
}

/// Sums by a fast multipole method, times 8π: near pairs one by one, the others by expansions.
///
/// All is in the order of the tree: coordinates and squared radii of the spheres, squared radii of
/// the sources, their six numbers.
fn fast_sums<F: Flow>(
    fast: &FastSums,
    spheres: &[[f64; 4]],
    squares: &[f64],
    sources: &[[f64; 6]],
) -> Vec<[f64; 6]> {
    let singularities: Vec<_> = (sources.iter().zip(squares))
        .map(|(source, square)| F::singularities(source, *square))
        .collect();
    let of_spheres: Vec<f64> = spheres.iter().map(|sphere| sphere[3]).collect();
    let mut sums = fast.far(&singularities, &of_spheres, F::OBSERVED);
    let mut rest = &mut sums[..];
    let leaves: Vec<_> = (fast.leaves().iter().enumerate())
        .map(|(leaf, range)| {
            let (own, others) = std::mem::take(&mut rest).split_at_mut(range.len());
            rest = others;
            (leaf, range, own)
        })
        .collect();
    leaves.into_par_iter().for_each(|(leaf, range, sums)| {
        let near: Vec<usize> = fast
            .neighbours(leaf)
            .flat_map(|near| fast.leaves()[near].clone())
            .collect();
        let place = |&k: &usize| [spheres[k][0], spheres[k][1], spheres[k][2], squares[k]];
        let places: Vec<_> = near.iter().map(place).collect();
        let sources: Vec<_> = near.iter().map(|&k| sources[k]).collect();
        let blocks = sums
            .chunks_mut(BLOCK)
            .zip(spheres[range.clone()].chunks(BLOCK));
        for (sums, spheres) in blocks {
            let mut rows = [0.0; 6 * BLOCK];
            block_sums::<F>(spheres, &places, &sources, &mut rows[..6 * sums.len()]);
            for (sum, row) in sums.iter_mut().flatten().zip(rows) {
                *sum += row;
            }
        }
    });
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Random numbers between -1 and 1, the same in each run.
    fn random(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    /// Columns of spheres in two clusters of different sizes.
    fn two_clusters(count: usize) -> Columns {
        let mut next = random(7);
        let centres: Vec<_> = (0..count)
            .map(|k| {
                let x = Vector3::from_fn(|_, _| next());
                match k % 3 {
                    0 => x * 5.0 + Vector3::new(300.0, 0.0, 10.0),
                    _ => x * 40.0,
                }
            })
            .collect();
        let radii: Vec<f64> = centres.iter().map(|_| 0.2 + 0.1 * next()).collect();
        Columns::new(&centres, radii.into_iter())
    }

    fn fast_and_direct<F: Flow>(columns: &Columns, sources: &DVector<f64>) -> f64 {
        let fast = columns.sums::<F>(columns, sources);
        // Sums at single spheres are never fast.
        let own = |k: usize| columns.columns.each_ref().map(|column| column[k]);
        let places: Vec<_> = (0..columns.count).map(own).collect();
        let sources: Vec<[f64; 6]> = (sources.as_slice().chunks_exact(6))
            .map(|six| six.try_into().unwrap())
            .collect();
        let (mut error, mut largest) = ([0.0_f64; 2], [0.0_f64; 2]);
        for k in (0..columns.count).step_by(97) {
            let mut direct = [0.0; 6];
            block_sums::<F>(&places[k..=k], &places, &sources, &mut direct);
            for (component, exact) in direct.iter().enumerate() {
                let exact = exact / (8.0 * PI);
                let part = component / 3;
                let difference = (fast[6 * k + component] - exact).abs();
                // the maximum would drop a NaN
                assert!(difference.is_finite(), "{component} at {k}");
                error[part] = error[part].max(difference);
                largest[part] = largest[part].max(exact.abs());
            }
        }
        (0..2)
            .map(|k| {
                if largest[k] > 0.0 {
                    error[k] / largest[k]
                } else {
                    0.0
                }
            })
            .fold(0.0, f64::max)
    }

    /// Relative to the largest ones, as [`crate::fast_sums`] says.
    #[test]
    fn fast_sums_are_those_over_all_pairs() {
        let columns = two_clusters(5000);
        let mut next = random(3);
        let sources = DVector::from_fn(6 * 5000, |_, _| next());
        for (flow, error) in [
            (
                "velocities",
                fast_and_direct::<Velocity>(&columns, &sources),
            ),
            (
                "strain rates",
                fast_and_direct::<StrainRate>(&columns, &sources),
            ),
            (
                "dipoles",
                fast_and_direct::<DipoleVelocity>(&columns, &sources),
            ),
        ] {
            assert!(error < 1e-5, "{flow}: {error:e}");
        }
        let traceless = DVector::from_fn(6 * 5000, |row, _| match row % 6 {
            2 => -sources[row - 2] - sources[row - 1],
            _ => sources[row],
        });
        let error = fast_and_direct::<StressletVelocity>(&columns, &traceless);
        assert!(error < 1e-5, "stresslets: {error:e}");
    }

    /// Bars contained no error of the sums, which is the largest one of dilute suspensions.
    ///
    /// In three dense clusters on a line it is larger than in random suspensions.
    #[test]
    fn bug_errors_of_fast_sums_were_in_no_bar() {
        let mut next = random(11);
        let mut clusters = |spread: f64, distance: f64| {
            let centres: Vec<_> = (0..FAST_FROM)
                .map(|k| {
                    let x = Vector3::from_fn(|_, _| next()) * spread;
                    x + Vector3::x() * (distance * (k % 3) as f64)
                })
                .collect();
            Spheres::new(centres, vec![1e-3; FAST_FROM]).unwrap()
        };
        for spheres in [clusters(1.0, 50.0), clusters(1.0, 4.0), clusters(10.0, 0.0)] {
            let columns = Columns::new(spheres.centres(), spheres.radii().iter().copied());
            let forces =
                DVector::from_fn(6 * FAST_FROM, |row, _| f64::from(u8::from(row % 6 == 1)));
            let velocities = columns.velocities(&forces);
            let bars = columns.errors(&spheres, &forces, &[]);
            let mut errors = [0.0_f64; 2];
            for first in (0..FAST_FROM).step_by(5 * BLOCK) {
                let some: Vec<usize> = (first..FAST_FROM.min(first + BLOCK)).collect();
                let part = columns.part(&some);
                let exact = part.sums::<Velocity>(&columns, &forces);
                for (number, k) in some.iter().enumerate() {
                    for (half, error) in errors.iter_mut().enumerate() {
                        let all = velocities.fixed_rows::<3>(6 * k + 3 * half);
                        let exact = exact.fixed_rows::<3>(6 * number + 3 * half);
                        *error = error.max((all - exact).norm());
                    }
                }
            }
            for (error, bar) in errors.into_iter().zip(bars) {
                assert!(error > 0.0 && error <= bar, "{error:e} {bar:e}");
                // A fifth of the spheres was compared, of which few are the corners of cells.
                assert!(bar <= 10.0 * SAMPLE_FACTOR * error, "{error:e} {bar:e}");
            }
        }
    }

    /// Conjugate gradients need a symmetric mobility: truncated expansions are symmetric up to
    /// their error, that of [`fast_sums_are_those_over_all_pairs`].
    #[test]
    fn fast_sums_are_symmetric_and_the_same_for_all_threads() {
        let columns = two_clusters(FAST_FROM);
        let mut next = random(5);
        let mut vector = || DVector::from_fn(6 * FAST_FROM, |_, _| next());
        let (first, second) = (vector(), vector());
        let [of_first, of_second] = [&first, &second].map(|forces| columns.velocities(forces));
        let (one, other) = (of_first.dot(&second), of_second.dot(&first));
        assert!((one - other).abs() < 1e-5 * of_first.norm() * second.norm());
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let again = pool.unwrap().install(|| columns.velocities(&first));
            assert_eq!(again, of_first);
        }
    }
}
