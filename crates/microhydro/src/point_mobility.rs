//! Mobilities of point forces as operators, for arrangements of thousands of spheres.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;

use crate::error::{check_entries, check_finite};
use crate::pair_sums::{Columns, FAST_FROM};
use crate::periodic::PeriodicSums;
use crate::{HydroError, Medium, Spheres, Squirmer, oseen, pair_mobility, rpy};

/// A model of spheres that act on each other as forces and torques alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointModel {
    /// Point forces ([`oseen`](crate::oseen)).
    Oseen,
    /// Rotne-Prager-Yamakawa ([`rpy`](crate::rpy)).
    Rpy,
}

/// The mobility of spheres by a model of point forces, without a matrix in unbounded fluid.
///
/// In a ball and beside a wall the matrix is computed once.
pub struct PointMobility<'a> {
    model: PointModel,
    spheres: &'a Spheres,
    medium: Medium,
    columns: Columns,
    /// The matrix in media with a boundary.
    matrix: Option<DMatrix<f64>>,
    /// Sums over images in a periodic box.
    periodic: Option<PeriodicSums>,
}

/// Number of spheres, of which an error message has the eigenvalues.
const MAX_EIGENVALUE_SPHERES: usize = 100;

/// Depth below the surface of a sphere, relative to its radius, that is rounding.
const ON_SURFACE: f64 = 1e-12;

impl<'a> PointMobility<'a> {
    /// The mobility of spheres in a medium.
    ///
    /// # Errors
    /// Those of [`oseen::mobility`] and [`rpy::mobility`].
    pub fn new(
        model: PointModel,
        spheres: &'a Spheres,
        medium: &Medium,
    ) -> Result<Self, HydroError> {
        spheres.check_inside(medium)?;
        let columns = match model {
            PointModel::Oseen => oseen::columns(spheres),
            PointModel::Rpy => rpy::columns(spheres),
        };
        let matrix = match (medium, model) {
            (Medium::Unbounded, _) => None,
            (_, PointModel::Oseen) => Some(oseen::mobility(spheres, medium)?),
            (_, PointModel::Rpy) => Some(rpy::mobility(spheres, medium)?),
        };
        Ok(Self {
            model,
            spheres,
            medium: *medium,
            columns,
            matrix,
            periodic: None,
        })
    }

    /// The mobility of spheres in a box with these edges that is repeated in all directions.
    ///
    /// The mean flow is zero: a pressure gradient balances the sum of the forces. Centres may be
    /// anywhere, and only their places relative to the box count. Products cost `O(n^1.5)`
    /// operations for spheres of a given concentration, to a relative error of about 1e-12.
    ///
    /// # Errors
    /// [`HydroError::PeriodicBox`]; [`HydroError::Touching`] for a sphere and an image of another
    /// one, [`HydroError::TouchingImage`] of itself.
    ///
    /// ```
    /// use microhydro::{PointMobility, PointModel, Spheres};
    /// use nalgebra::{DVector, Vector3};
    /// let one = Spheres::new(vec![Vector3::zeros()], vec![1.0])?;
    /// let mobility = PointMobility::periodic(PointModel::Rpy, &one, &Vector3::repeat(20.0))?;
    /// let mut force = DVector::zeros(6);
    /// force[0] = 6.0 * std::f64::consts::PI;
    /// let velocity = mobility.apply(&force)?[0];
    /// // Hasimoto (1959): 1 - 1.7601 φ^(1/3) + φ for the volume fraction φ
    /// let fraction = 4.0 / 3.0 * std::f64::consts::PI / 8000.0;
    /// assert!((velocity - (1.0 - 1.7601 * fraction.cbrt() + fraction)).abs() < 1e-5);
    /// # Ok::<(), microhydro::HydroError>(())
    /// ```
    pub fn periodic(
        model: PointModel,
        spheres: &'a Spheres,
        size: &Vector3<f64>,
    ) -> Result<Self, HydroError> {
        Self::split_periodic(model, spheres, size, None)
    }

    /// The same with a given splitting of Ewald's sums, which does not change the result.
    pub(crate) fn split_periodic(
        model: PointModel,
        spheres: &'a Spheres,
        size: &Vector3<f64>,
        splitting: Option<f64>,
    ) -> Result<Self, HydroError> {
        let radii = match model {
            PointModel::Oseen => vec![0.0; spheres.len()],
            PointModel::Rpy => spheres.radii().to_vec(),
        };
        let periodic = PeriodicSums::new(spheres, radii, size, splitting)?;
        Ok(Self {
            periodic: Some(periodic),
            ..Self::new(model, spheres, &Medium::Unbounded)?
        })
    }

    fn check_not_periodic(&self) -> Result<(), HydroError> {
        match self.periodic {
            None => Ok(()),
            Some(_) => Err(HydroError::Unsupported {
                model: self.name(),
                medium: "the reflections in a periodic box",
                instead: "unbounded fluid",
            }),
        }
    }

    fn name(&self) -> &'static str {
        match self.model {
            PointModel::Oseen => "oseen",
            PointModel::Rpy => "rpy",
        }
    }

    /// The spheres.
    pub fn spheres(&self) -> &Spheres {
        self.spheres
    }

    /// Velocities and angular velocities for forces and torques, six entries per sphere.
    ///
    /// Cost: `O(n²)` operations in parallel, in unbounded fluid `O(n)` from 5000 spheres on, with
    /// the errors of [`PointMobility::sum_errors`], 1e-7 to 1e-5 of the largest velocity; the
    /// operator is symmetric to that accuracy. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`HydroError::Length`], [`HydroError::NotFinite`].
    pub fn apply(&self, forces: &DVector<f64>) -> Result<DVector<f64>, HydroError> {
        let sums = |forces: &DVector<f64>| match &self.periodic {
            Some(periodic) => periodic.velocities(forces),
            None => self.columns.velocities(forces),
        };
        match &self.matrix {
            None => pair_mobility::apply(self.spheres, forces, sums),
            Some(matrix) => {
                check_entries(
                    "forces and torques on the spheres",
                    matrix.ncols(),
                    forces.len(),
                )?;
                Ok(matrix * forces)
            }
        }
    }

    /// Number of pairs of spheres whose sums take as long as a product with the mobility of
    /// `spheres` of them in unbounded fluid.
    pub fn pairs_of_product(spheres: usize) -> f64 {
        spheres as f64 * spheres.min(FAST_FROM) as f64
    }

    /// Bars of the velocities and angular velocities that [`PointMobility::apply`] and
    /// [`PointMobility::by_slip`] have because sums over thousands of spheres are not over all
    /// pairs: from sums over all pairs at up to 256 spheres; zero below 5000 spheres.
    ///
    /// Cost: twice that of the products.
    ///
    /// # Errors
    /// [`HydroError::Length`].
    pub fn sum_errors(
        &self,
        forces: &DVector<f64>,
        squirmers: &[Squirmer],
    ) -> Result<[f64; 2], HydroError> {
        let count = self.spheres.len();
        check_entries("forces and torques on the spheres", 6 * count, forces.len())?;
        if !squirmers.is_empty() {
            check_entries("squirmers", count, squirmers.len())?;
        }
        match self.matrix.is_some() || self.periodic.is_some() {
            true => Ok([0.0; 2]),
            false => Ok(self.columns.errors(self.spheres, forces, squirmers)),
        }
    }

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
        check_entries("squirmers", self.spheres.len(), squirmers.len())?;
        let unsupported = |model: &'static str, medium: &'static str| HydroError::Unsupported {
            model,
            medium,
            instead: "multipole",
        };
        if self.model == PointModel::Oseen {
            return Err(unsupported(self.name(), "slip of points"));
        }
        if self.medium != Medium::Unbounded {
            return Err(unsupported(self.name(), "slip beside a wall or in a ball"));
        }
        let mut velocities = match &self.periodic {
            Some(periodic) => periodic.velocities_by_slip(squirmers),
            None => self.columns.velocities_by_slip(self.spheres, squirmers),
        };
        for (k, squirmer) in squirmers.iter().enumerate() {
            let mut own = velocities.fixed_rows_mut::<3>(6 * k);
            own += squirmer.velocity();
        }
        check_finite("a velocity of a sphere", &velocities)?;
        Ok(velocities)
    }

    /// Velocity of the fluid at points, by forces and torques on the spheres and by the slip of
    /// squirmers, of all or of none: the sum of the flows of lone spheres, or of points; `None` for
    /// a point inside a sphere.
    ///
    /// It has the error of the model: on the surface of a sphere it differs from the velocity there
    /// by what the other spheres' flows vary over it. Cost: `O(n)` operations per point, in
    /// parallel.
    ///
    /// # Errors
    /// [`HydroError::Unsupported`] in media with a boundary; [`HydroError::Length`],
    /// [`HydroError::NotFinite`].
    ///
    /// ```
    /// use microhydro::{Medium, PointMobility, PointModel, Spheres};
    /// use nalgebra::{DVector, Vector3};
    /// let one = Spheres::new(vec![Vector3::zeros()], vec![2.0])?;
    /// let mobility = PointMobility::new(PointModel::Rpy, &one, &Medium::Unbounded)?;
    /// let mut forces = DVector::zeros(6);
    /// forces[0] = 12.0 * std::f64::consts::PI;
    /// let at = [Vector3::new(0.0, 2.0, 0.0), Vector3::new(4.0, 0.0, 0.0), Vector3::x()];
    /// let flow = mobility.flow(&forces, &[], &at)?;
    /// // Stokes (1851): the velocity of the sphere on its surface, 3/2 a/d - (a/d)³/2 of it ahead
    /// assert!((flow[0].unwrap() - Vector3::x()).norm() < 1e-15);
    /// assert!((flow[1].unwrap() - Vector3::new(0.75 - 0.0625, 0.0, 0.0)).norm() < 1e-15);
    /// assert!(flow[2].is_none());
    /// # Ok::<(), microhydro::HydroError>(())
    /// ```
    pub fn flow(
        &self,
        forces: &DVector<f64>,
        squirmers: &[Squirmer],
        points: &[Vector3<f64>],
    ) -> Result<Vec<Option<Vector3<f64>>>, HydroError> {
        let spheres = self.spheres;
        if self.medium != Medium::Unbounded {
            return Err(HydroError::Unsupported {
                model: self.name(),
                medium: "flow beside a wall or in a ball",
                instead: "multipole",
            });
        }
        check_entries(
            "forces and torques on the spheres",
            6 * spheres.len(),
            forces.len(),
        )?;
        if !squirmers.is_empty() {
            check_entries("squirmers", spheres.len(), squirmers.len())?;
        }
        if let Some(periodic) = &self.periodic {
            let solid: Vec<f64> = (spheres.radii().iter())
                .map(|a| a * (1.0 - ON_SURFACE))
                .collect();
            let flow = periodic.flow(forces, squirmers);
            let velocity = |x: &Vector3<f64>| {
                let velocity = periodic.flow_at(x, &flow, &solid);
                velocity.map_or(Ok(None), |u| {
                    check_finite("a velocity of the fluid", &u).map(|()| Some(u))
                })
            };
            return points.par_iter().map(velocity).collect();
        }
        let mut found = self.columns.velocities_at(points, forces);
        if !squirmers.is_empty() {
            found += Columns::of_points(points).velocities_by_slip(spheres, squirmers);
        }
        let is_inside = |x: &Vector3<f64>| {
            let mut all = spheres.centres().iter().zip(spheres.radii());
            all.any(|(centre, a)| (x - centre).norm_squared() < (a * (1.0 - ON_SURFACE)).powi(2))
        };
        let outside: Vec<bool> = points.par_iter().map(|x| !is_inside(x)).collect();
        let velocity = |(k, outside): (usize, bool)| {
            let velocity = outside.then(|| found.fixed_rows::<3>(6 * k).into_owned());
            velocity.map_or(Ok(None), |u| {
                check_finite("a velocity of the fluid", &u).map(|()| Some(u))
            })
        };
        outside.into_iter().enumerate().map(velocity).collect()
    }

    /// The error for spheres that are too close for the model.
    pub(crate) fn not_positive_definite(&self) -> HydroError {
        let all: Vec<usize> = (0..self.spheres.len().min(MAX_EIGENVALUE_SPHERES)).collect();
        pair_mobility::not_positive_definite(
            &self.block(&all),
            self.spheres,
            &self.medium,
            self.name(),
        )
    }

    /// The block of the mobility matrix of some spheres, in their order.
    pub fn block(&self, some: &[usize]) -> DMatrix<f64> {
        let rows = || some.iter().flat_map(|&k| 6 * k..6 * k + 6);
        if let Some(matrix) = &self.matrix {
            let rows: Vec<usize> = rows().collect();
            return matrix.select_rows(&rows).select_columns(&rows);
        }
        if let Some(periodic) = &self.periodic {
            return pair_mobility::block(some, pair_mobility::periodic(self.spheres, periodic));
        }
        self.block_without_images(some)
    }

    /// The same without periodic images, as in unbounded fluid: an approximation for
    /// preconditioners, where a block with images costs as much as products with all spheres.
    pub(crate) fn block_without_images(&self, some: &[usize]) -> DMatrix<f64> {
        if self.matrix.is_some() {
            return self.block(some);
        }
        let s = |a, b| match self.model {
            PointModel::Oseen => 0.0,
            PointModel::Rpy => a * a + b * b,
        };
        pair_mobility::block(some, pair_mobility::unbounded(self.spheres, s))
    }

    /// Change of the velocities by the stresslets that rigid spheres have in the flow of the forces
    /// and torques: what the model neglects to the order `(a/d)^4` (for points `(a/d)^3`).
    ///
    /// A sphere in the strain rate `E` of the others has the stresslet `20π/3 a³ E` (Batchelor
    /// 1970). The change is a symmetric, negative semi-definite operator on the forces; for points
    /// it contains the difference from Rotne-Prager-Yamakawa, too. In unbounded fluid: walls are
    /// ignored. Cost: two or four products.
    ///
    /// # Errors
    /// [`HydroError::Unsupported`] in a periodic box; [`HydroError::Length`],
    /// [`HydroError::NotFinite`].
    pub fn first_reflection(&self, forces: &DVector<f64>) -> Result<DVector<f64>, HydroError> {
        self.check_not_periodic()?;
        let spheres = self.spheres;
        let mut change = DVector::zeros(6 * spheres.len());
        let finite;
        let columns = match self.model {
            PointModel::Rpy => &self.columns,
            PointModel::Oseen => {
                finite = rpy::columns(spheres);
                change +=
                    pair_mobility::apply(spheres, forces, |forces| finite.velocities(forces))?;
                change -= pair_mobility::apply(spheres, forces, |forces| {
                    self.columns.velocities(forces)
                })?;
                &finite
            }
        };
        let mut stresslets = columns.strain_rates(forces);
        for (k, a) in spheres.radii().iter().enumerate() {
            let mut rows = stresslets.rows_mut(6 * k, 6);
            rows *= 20.0 / 3.0 * PI * a.powi(3);
        }
        change += columns.stresslet_velocities(&stresslets);
        check_finite("a velocity of a sphere", &change)?;
        Ok(change)
    }
}
