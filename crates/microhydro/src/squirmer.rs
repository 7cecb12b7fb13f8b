//! Squirmers as singularities: what a sphere with two modes of slip does to the fluid around it.

use std::f64::consts::PI;

use nalgebra::{DVector, Matrix3, Vector3};

use crate::Spheres;
use crate::error::{check_entries, check_finite};
use crate::{HydroError, PointMobility};

/// Slip of a sphere with the outward normal `n` and the unit axis `k` (Lighthill 1952; Blake
/// 1971), relative to the motion of the sphere:
///
/// ```text
/// u_s = -(B1 + B2 n·k) (I - n n) k
/// ```
///
/// Alone and free it swims at `2 B1 k/3`. Its flow is exactly that of two singularities, with the
/// tensor `G/(8π)` of a point force in a fluid of viscosity one:
///
/// ```text
/// u = (L·∇²G + (1 + a²∇²/6) S : ∇G)/(8π)     L = -4π/3 a³ B1 k     S = 4π/3 a² B2 (3 k k - I)
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Squirmer {
    /// Coefficient `B1`, a velocity.
    pub b1: f64,
    /// Coefficient `B2`, a velocity: positive for pullers, negative for pushers, if `B1 > 0`.
    pub b2: f64,
    /// Unit vector `k`.
    pub axis: Vector3<f64>,
}

impl Squirmer {
    /// A sphere without slip.
    pub const NONE: Self = Self {
        b1: 0.0,
        b2: 0.0,
        axis: Vector3::new(0.0, 0.0, 1.0),
    };

    /// Velocity of the surface relative to the sphere where its outward unit normal is `normal`.
    pub fn slip(&self, normal: &Vector3<f64>) -> Vector3<f64> {
        let cosine = normal.dot(&self.axis);
        (self.axis - normal * cosine) * -(self.b1 + self.b2 * cosine)
    }

    /// Velocity of the sphere where it is alone and free.
    pub fn velocity(&self) -> Vector3<f64> {
        self.axis * (2.0 / 3.0 * self.b1)
    }

    /// Source dipole `L` of a sphere of this radius.
    pub fn dipole(&self, radius: f64) -> Vector3<f64> {
        self.axis * (-4.0 / 3.0 * PI * radius.powi(3) * self.b1)
    }

    /// Stresslet `S` of a sphere of this radius.
    pub fn stresslet(&self, radius: f64) -> Matrix3<f64> {
        let strength = 4.0 / 3.0 * PI * radius.powi(2) * self.b2;
        (self.axis * self.axis.transpose() * 3.0 - Matrix3::identity()) * strength
    }

    /// Power of the slip of a lone free sphere on the fluid: `8π a (2 B1² + B2²)/3` (Blake 1971).
    pub fn power(&self, radius: f64) -> f64 {
        8.0 / 3.0 * PI * radius * (2.0 * self.b1.powi(2) + self.b2.powi(2))
    }
}

impl PointMobility<'_> {
    /// Velocities and angular velocities of free spheres, six entries per sphere, by their slip.
    ///
    /// Each sphere moves by its own slip and with the flow of the others, averaged over its surface
    /// (Faxén's laws): the order of Rotne, Prager and Yamakawa, with a relative error like
    /// `(a/d)^5` for free squirmers. Forces add to it what [`PointMobility::apply`] gives.
    /// Cost: that of a product.
    ///
    /// # Errors
    /// [`HydroError::Unsupported`] for points and in media with a boundary;
    /// [`HydroError::Length`], [`HydroError::NotFinite`].
    ///
    /// ```
    /// use microhydro::{PointMobility, PointModel, Spheres, Squirmer};
    /// use nalgebra::Vector3;
    /// let one = Spheres::new(vec![Vector3::zeros()], vec![1.0])?;
    /// let mobility = PointMobility::periodic(PointModel::Rpy, &one, &Vector3::repeat(8.0))?;
    /// let squirmer = Squirmer { b1: 1.5, b2: 0.0, axis: Vector3::z() };
    /// let velocity = mobility.by_slip(&[squirmer])?[2];
    /// // in a cubic array slower by the volume fraction
    /// let fraction = 4.0 / 3.0 * std::f64::consts::PI / 512.0;
    /// assert!((velocity - (1.0 - fraction)).abs() < 1e-12);
    /// # Ok::<(), microhydro::HydroError>(())
    /// ```
    pub fn by_slip(&self, squirmers: &[Squirmer]) -> Result<DVector<f64>, HydroError> {
        let spheres = self.spheres();
        check_entries("squirmers", spheres.len(), squirmers.len())?;
        let mut velocities = self.sums_by_slip(squirmers)?;
        for (k, squirmer) in squirmers.iter().enumerate() {
            let mut own = velocities.fixed_rows_mut::<3>(6 * k);
            own += squirmer.velocity();
        }
        check_finite("a velocity of a sphere", &velocities)?;
        Ok(velocities)
    }
}

/// Dipoles and stresslets of squirmers, six numbers each.
pub(crate) fn singularities(spheres: &Spheres, squirmers: &[Squirmer]) -> [DVector<f64>; 2] {
    let (mut dipoles, mut stresslets) = (Vec::new(), Vec::new());
    for (squirmer, &radius) in squirmers.iter().zip(spheres.radii()) {
        let dipole = squirmer.dipole(radius);
        dipoles.extend([dipole.x, dipole.y, dipole.z, 0.0, 0.0, 0.0]);
        let s = squirmer.stresslet(radius);
        stresslets.extend([s.m11, s.m22, s.m33, s.m12, s.m13, s.m23]);
    }
    [dipoles, stresslets].map(DVector::from_vec)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Accuracy, Medium, PointModel, multipole};

    fn squirmer(b1: f64, b2: f64, axis: [f64; 3]) -> Squirmer {
        let axis = Vector3::from(axis).normalize();
        Squirmer { b1, b2, axis }
    }

    fn four() -> [Squirmer; 4] {
        [
            squirmer(1.0, -2.0, [1.0, 0.2, -0.4]),
            squirmer(0.5, 1.0, [-0.3, 0.9, 0.1]),
            squirmer(0.0, 1.5, [0.2, 0.1, 1.0]),
            squirmer(-0.8, 0.3, [0.5, -0.5, 0.6]),
        ]
    }

    /// Blake (1971): `u_r = (2/3) B1 cos θ/r³ + B2 (1/r⁴ - 1/r²) P2`,
    /// `u_θ = (1/3) B1 sin θ/r³ + B2 sin θ cos θ/r⁴` around a free squirmer of radius one.
    #[test]
    fn the_flow_of_a_squirmer_is_exact() {
        let one = Spheres::new(vec![Vector3::new(1.0, 2.0, 3.0)], vec![1.0]).unwrap();
        let mobility = PointMobility::new(PointModel::Rpy, &one, &Medium::Unbounded).unwrap();
        let own = squirmer(0.7, -1.3, [0.0, 0.0, 1.0]);
        let (r, cosine) = (1.7_f64, 0.6_f64);
        let sine = (1.0 - cosine * cosine).sqrt();
        let (n, t) = (
            Vector3::new(sine, 0.0, cosine),
            Vector3::new(cosine, 0.0, -sine),
        );
        let radial = 2.0 / 3.0 * own.b1 * cosine / r.powi(3)
            + own.b2 * (r.powi(-4) - r.powi(-2)) * 0.5 * (3.0 * cosine * cosine - 1.0);
        let tangential = own.b1 * sine / 3.0 / r.powi(3) + own.b2 * sine * cosine * r.powi(-4);
        let at = [one.centres()[0] + n * r];
        let flow = mobility.flow(&DVector::zeros(6), &[own], &at).unwrap()[0].unwrap();
        assert!(
            (flow - n * radial - t * tangential).norm() < 1e-15,
            "{flow}"
        );
    }

    /// What is neglected is the strain `(a/d)^3` that one squirmer meets by the stresslet of the
    /// other, whose stresslet acts back like `(a/d)^2`.
    #[test]
    fn two_squirmers_have_the_velocities_of_expansions_up_to_the_fifth_power() {
        let error = |distance: f64| {
            let apart = Vector3::new(0.6, 0.0, 0.8) * distance;
            let pair = Spheres::new(vec![Vector3::zeros(), apart], vec![1.0, 0.7]).unwrap();
            let mobility = PointMobility::new(PointModel::Rpy, &pair, &Medium::Unbounded).unwrap();
            let squirmers = &four()[..2];
            let slip = |k: usize, n: &Vector3<f64>| squirmers[k].slip(n);
            let accuracy = Accuracy::relative(1e-11);
            let resistance = multipole::resistance(&pair, &Medium::Unbounded, &accuracy).unwrap();
            let exact =
                multipole::surface_flow(&pair, &Medium::Unbounded, resistance.orders(), &[&slip]);
            let exact = exact.unwrap().velocities.column(0).into_owned();
            (mobility.by_slip(squirmers).unwrap() - exact).amax()
        };
        let [near, far] = [error(10.0), error(20.0)];
        // The leading term is 5/2 (a/d)^5 times the larger B2 and factors of about one; the next
        // is two powers higher, 4 % of it at the nearer distance for each unit of its factor.
        assert!(near < 5.0 * 2.0 * 1e-5, "{near:e}");
        let order = (near / far).log2();
        assert!((order - 5.0).abs() < 0.3, "{order}");
    }

    fn some_squirmers() -> (Spheres, Vector3<f64>) {
        let places = [
            [0.1, 0.3, 0.2],
            [6.8, 0.4, 0.5],
            [3.1, 4.2, 7.7],
            [-5.0, 12.3, 2.9],
        ];
        let spheres = Spheres::new(places.map(Vector3::from).to_vec(), vec![1.0, 0.7, 1.3, 0.5]);
        (spheres.unwrap(), Vector3::new(9.0, 8.0, 11.0))
    }

    #[test]
    fn the_splitting_of_periodic_sums_does_not_change_velocities_by_slip() {
        let (spheres, size) = some_squirmers();
        let [first, second] = [0.25, 0.6].map(|splitting| {
            let model = PointModel::Rpy;
            let split = PointMobility::split_periodic(model, &spheres, &size, Some(splitting));
            split.unwrap().by_slip(&four()).unwrap()
        });
        let change = (&first - second).amax() / first.amax();
        assert!(change < 1e-11, "{change:e}");
    }

    #[test]
    fn squirmers_in_a_large_box_are_those_of_unbounded_fluid() {
        let (spheres, _) = some_squirmers();
        let edge = 2000.0;
        let boxed =
            PointMobility::periodic(PointModel::Rpy, &spheres, &Vector3::repeat(edge)).unwrap();
        let alone = PointMobility::new(PointModel::Rpy, &spheres, &Medium::Unbounded).unwrap();
        let change = boxed.by_slip(&four()).unwrap() - alone.by_slip(&four()).unwrap();
        // Images of stresslets: gradients that are constant near the box, |S|/L³ times the
        // distances of 13 and a few.
        assert!(change.amax() < 1e3 / edge.powi(3), "{:e}", change.amax());
    }

    #[test]
    fn the_flow_of_squirmers_in_a_box_moves_their_surfaces() {
        let one = Spheres::new(vec![Vector3::new(4.0, -1.0, 9.5)], vec![1.0]).unwrap();
        let size = Vector3::repeat(7.0);
        let mobility = PointMobility::periodic(PointModel::Rpy, &one, &size).unwrap();
        let own = squirmer(1.0, -2.0, [1.0, 1.0, 0.0]);
        let velocity = mobility.by_slip(&[own]).unwrap();
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let around: Vec<_> = axes.into_iter().flat_map(|e| [e, -e]).collect();
        let points: Vec<_> = around
            .iter()
            .map(|e| one.centres()[0] + e + 2.0 * size)
            .collect();
        let flow = mobility.flow(&DVector::zeros(6), &[own], &points).unwrap();
        // The mean of flow minus slip over the surface is the velocity: an octahedron integrates
        // the third degree exactly, and the images have (a/L)^5 |S| of higher degrees.
        let mean = flow
            .iter()
            .zip(&around)
            .map(|(u, n)| u.unwrap() - own.slip(n));
        let mean = mean.sum::<Vector3<f64>>() / 6.0;
        let difference = (mean - velocity.fixed_rows::<3>(0)).norm();
        assert!(difference < 26.0 * 2.0 * 7f64.powi(-5), "{difference:e}");
    }

    #[test]
    fn slip_of_points_and_beside_walls_is_refused() {
        let one = Spheres::new(vec![Vector3::z() * 3.0], vec![1.0]).unwrap();
        let wall = Medium::wall(Vector3::zeros(), Vector3::z()).unwrap();
        for (model, medium) in [
            (PointModel::Oseen, Medium::Unbounded),
            (PointModel::Rpy, wall),
        ] {
            let mobility = PointMobility::new(model, &one, &medium).unwrap();
            let found = mobility.by_slip(&[Squirmer::NONE]);
            assert!(matches!(found, Err(HydroError::Unsupported { .. })));
        }
        let mobility = PointMobility::new(PointModel::Rpy, &one, &Medium::Unbounded).unwrap();
        assert!(matches!(
            mobility.by_slip(&[]),
            Err(HydroError::Length { .. })
        ));
    }
}
