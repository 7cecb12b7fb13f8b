//! Motion of spheres that joints connect: conjugate gradients without the mobility matrix.

use nalgebra::{Cholesky, DMatrix, DVector, DVectorViewMut, Dyn, SymmetricEigen, Vector3};
use rayon::prelude::*;

use crate::error::{check_entries, check_finite};
use crate::inverse_root::inverse_root;
use crate::mean_flow::{FlowColumns, UnknownFlow};
use crate::{HydroError, PointMobility, Spheres};

/// A mobility `M` that is never formed, and that may be the Schur complement of further degrees of
/// freedom `x` of the fluid, on which nothing acts:
///
/// ```text
/// U = M_0 f + C x      0 = C^T f + H x
/// ```
///
/// The whole matrix is symmetric positive definite. `x` are scaled such that the diagonal of `H` is
/// one; six forces and torques, or velocities and angular velocities, belong to each sphere.
pub trait Mobility: Sync {
    /// The spheres.
    fn spheres(&self) -> &Spheres;

    /// Number of further degrees of freedom.
    fn hidden(&self) -> usize {
        0
    }

    /// `M_0 f + C x` and `C^T f + H x`.
    ///
    /// # Errors
    /// [`HydroError::Length`], [`HydroError::NotFinite`].
    fn product(
        &self,
        forces: &DVector<f64>,
        hidden: &DVector<f64>,
    ) -> Result<[DVector<f64>; 2], HydroError>;

    /// An approximation to the block of some spheres, positive definite: for a preconditioner.
    fn own_block(&self, some: &[usize]) -> DMatrix<f64>;

    /// Multiplies further degrees of freedom by an approximate inverse of `H`, symmetric and
    /// positive definite: for a preconditioner.
    fn precondition_hidden(&self, _: &mut DVector<f64>) {}

    /// Sets the places among further degrees of freedom to zero that belong to the forces.
    fn clear_places_of_forces(&self, _: &mut DVector<f64>) {}

    /// The error for a matrix that is not positive definite.
    fn not_positive_definite(&self) -> HydroError;
}

impl Mobility for PointMobility<'_> {
    fn spheres(&self) -> &Spheres {
        self.spheres()
    }

    fn product(
        &self,
        forces: &DVector<f64>,
        _: &DVector<f64>,
    ) -> Result<[DVector<f64>; 2], HydroError> {
        Ok([self.apply(forces)?, DVector::zeros(0)])
    }

    fn own_block(&self, some: &[usize]) -> DMatrix<f64> {
        self.block_without_images(some)
    }

    fn not_positive_definite(&self) -> HydroError {
        self.not_positive_definite()
    }
}

/// Spheres that move together: their velocities are `U = S v + W` with free coordinates `v`.
///
/// Each sphere belongs to one linkage; a sphere without joints is a linkage with the identity as
/// `S`.
#[derive(Clone, Debug)]
pub struct Linkage {
    /// The spheres, by their indices.
    pub spheres: Vec<usize>,
    /// `S`, six rows per sphere, of full column rank.
    pub basis: DMatrix<f64>,
    /// `W`, six entries per sphere.
    pub offset: DVector<f64>,
    /// Loads `g` on the coordinates.
    pub load: DVector<f64>,
    /// Resistances `D` of dashpots to the coordinates: symmetric, positive semi-definite.
    pub damping: DMatrix<f64>,
}

/// Motion and forces of linked spheres.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LinkedMotion {
    /// Forces and torques on the fluid, six entries per sphere. They balance the loads exactly.
    pub forces: DVector<f64>,
    /// The coordinates `v` of each linkage.
    pub coordinates: Vec<DVector<f64>>,
    /// Forces of the dashpots of each linkage.
    dashpots: Vec<DVector<f64>>,
    /// The further degrees of freedom of the mobility.
    pub hidden: DVector<f64>,
    /// The mean flow, where the total force is given instead
    /// ([`LinkedSpheres::with_total_force`]); zero elsewhere.
    pub mean_flow: Vector3<f64>,
    /// Number of iterations.
    pub iterations: usize,
    /// Norm of the velocities that the joints do not allow, recomputed from the forces, relative to
    /// that of what drives them.
    pub residual: f64,
}

/// Linked spheres in a fluid, whose forces `f` and coordinates `v` satisfy
///
/// ```text
/// M f = S v + W      S^T f + D v = g
/// ```
///
/// with the mobility `M`. In each linkage the columns of `Z` span the forces that do no work on its
/// motions (`S^T Z = 0`, orthonormal), so that with forces `f0` that balance the loads
///
/// ```text
/// f = f0 + Z λ       Z^T M Z λ = Z^T (W - M f0)
/// ```
///
/// The matrix is symmetric positive definite and is never formed: conjugate gradients apply `M`,
/// preconditioned by the factorised blocks of the linkages alone. Further degrees of freedom of the
/// mobility join the multipliers; slip drives them ([`LinkedSpheres::with_hidden`]).
/// A dashpot is one more force, with its coefficient as mobility.
/// Memory: `O(n)` for linkages of bounded size.
pub struct LinkedSpheres<'a, M = PointMobility<'a>> {
    mobility: &'a M,
    linkages: Vec<Eliminated>,
    /// Entry of the first multiplier of each linkage, and the number of all.
    first: Vec<usize>,
    /// None where the mean flow is given.
    flow: Option<UnknownFlow>,
    /// Right-hand side of the further degrees of freedom.
    hidden: DVector<f64>,
}

/// A linkage whose loads are balanced.
struct Eliminated {
    linkage: Linkage,
    /// Orthonormal columns that span `S` with the dashpots, and the triangular factor.
    range: DMatrix<f64>,
    triangle: DMatrix<f64>,
    /// `Z`.
    complement: DMatrix<f64>,
    /// Cholesky factor of `Z^T M Z` for the linkage alone.
    factor: Cholesky<f64, Dyn>,
}

/// Rounding of the difference of two velocities, relative to them: of sums over a few operations.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Change of the velocities, relative to the mean flow that is solved for, below which there is
/// none: arrays need no iteration by symmetry, and sums over images are accurate to 1e-12.
const NO_CHANGE: f64 = 1e-10;

/// Iterations between two computations of the true residual, and in all.
const MAX_ITERATIONS: usize = 1000;

/// Times that the iteration is started again from its result, if rounding separated the residual of
/// its recursion from the true one.
const MAX_STARTS: usize = 3;

/// Linkages that a thread treats at a time: of three spheres in some ten microseconds.
const AT_ONCE: usize = 32;

/// Eigenvalue of dashpots, relative to the largest one, below which there is none.
const NO_DASHPOT: f64 = 1e-14;

impl Eliminated {
    fn new(linkage: Linkage, mobility: &impl Mobility) -> Result<Self, HydroError> {
        let (rows, free) = (6 * linkage.spheres.len(), linkage.basis.ncols());
        check_entries("rows of a basis", rows, linkage.basis.nrows())?;
        check_entries("velocities of a linkage", rows, linkage.offset.len())?;
        check_entries("loads on coordinates", free, linkage.load.len())?;
        check_entries("rows of dashpots", free, linkage.damping.nrows())?;
        check_entries("columns of dashpots", free, linkage.damping.ncols())?;
        let dashpots = dashpots(&linkage.damping);
        let all = rows + dashpots.nrows();
        let mut basis = DMatrix::zeros(all, all);
        basis
            .view_mut((0, 0), (rows, free))
            .copy_from(&linkage.basis);
        (basis.view_mut((rows, 0), dashpots.shape())).copy_from(&dashpots);
        // The other columns are zero: reflections of a square matrix give its whole orthogonal
        // factor.
        let decomposition = basis.qr();
        let orthogonal = decomposition.q();
        let triangle = decomposition.r().view((0, 0), (free, free)).into_owned();
        let complement = orthogonal.columns(free, all - free).into_owned();
        let mut own = DMatrix::identity(all, all);
        own.view_mut((0, 0), (rows, rows))
            .copy_from(&mobility.own_block(&linkage.spheres));
        let factor = Cholesky::new(complement.tr_mul(&(own * &complement)))
            .ok_or_else(|| mobility.not_positive_definite())?;
        Ok(Self {
            linkage,
            range: orthogonal.columns(0, free).into_owned(),
            triangle,
            complement,
            factor,
        })
    }

    /// Forces of spheres and dashpots that balance the loads, of the smallest norm.
    fn balancing(&self) -> DVector<f64> {
        let free = self.triangle.ncols();
        let coefficients = self.triangle.tr_solve_upper_triangular(&self.linkage.load);
        &self.range * coefficients.unwrap_or_else(|| DVector::zeros(free))
    }

    /// Number of rows: of forces and torques, and of dashpots.
    fn rows(&self) -> usize {
        self.complement.nrows()
    }
}

/// `L^T` with `L L^T = D`: the rate of each dashpot by the coordinates, for a coefficient of one.
fn dashpots(damping: &DMatrix<f64>) -> DMatrix<f64> {
    // An empty matrix has no eigenvalues.
    if damping.iter().all(|entry| *entry == 0.0) {
        return DMatrix::zeros(0, damping.ncols());
    }
    let eigen = SymmetricEigen::new(damping.clone());
    let largest = eigen.eigenvalues.amax();
    let acting = (0..damping.ncols()).filter(|&k| eigen.eigenvalues[k] > NO_DASHPOT * largest);
    let rows = acting.map(|k| {
        let rate = eigen.eigenvectors.column(k) * eigen.eigenvalues[k].sqrt();
        rate.transpose()
    });
    DMatrix::from_rows(&rows.collect::<Vec<_>>())
}

/// Forces of the spheres, and of the dashpots of each linkage.
struct Forces {
    spheres: DVector<f64>,
    dashpots: Vec<DVector<f64>>,
    /// Further degrees of freedom of the mobility, or the residuals of their equations.
    hidden: DVector<f64>,
}

impl<'a, M: Mobility> LinkedSpheres<'a, M> {
    /// Prepares linkages that consist of all spheres.
    ///
    /// Cost: for linkages of `k` spheres `O(k³)` each, in parallel.
    ///
    /// # Errors
    /// [`HydroError::Length`] for lists of the wrong length and spheres that belong to no linkage
    /// or to several; [`HydroError::NotPositiveDefinite`].
    pub fn new(mobility: &'a M, linkages: Vec<Linkage>) -> Result<Self, HydroError> {
        let mut members: Vec<usize> = (linkages.iter())
            .flat_map(|linkage| linkage.spheres.iter().copied())
            .collect();
        members.sort_unstable();
        let once = members.iter().enumerate().take_while(|(k, m)| k == *m);
        let count = mobility.spheres().len();
        check_entries("spheres of one linkage each", count, once.count())?;
        check_entries("spheres of one linkage each", count, members.len())?;
        let linkages: Vec<Eliminated> = linkages
            .into_par_iter()
            .map(|linkage| Eliminated::new(linkage, mobility))
            .collect::<Result<_, _>>()?;
        let mut first = vec![0];
        for linkage in &linkages {
            first.push(first[first.len() - 1] + linkage.complement.ncols());
        }
        Ok(Self {
            mobility,
            linkages,
            first,
            flow: None,
            hidden: DVector::zeros(mobility.hidden()),
        })
    }

    /// The same where the further degrees of freedom are driven: `C^T f + H x = h` with this `h`.
    ///
    /// # Errors
    /// [`HydroError::Length`], [`HydroError::NotFinite`].
    pub fn with_hidden(mut self, hidden: DVector<f64>) -> Result<Self, HydroError> {
        check_entries("multipoles", self.mobility.hidden(), hidden.len())?;
        check_finite("the velocity of a surface", &hidden)?;
        self.hidden = hidden;
        Ok(self)
    }

    /// The same in a uniform flow `u` that is unknown, where the total force of the spheres on the
    /// fluid is given instead: `M f + u = S v + W`, and the forces add up to `total`.
    ///
    /// In a periodic box the mean pressure gradient is the total force over the volume of the box.
    ///
    /// # Errors
    /// [`HydroError::NothingHeld`] if all linkages can move along a direction: their loads then are
    /// the total force already, and any flow carries them.
    pub fn with_total_force(mut self, total: Vector3<f64>) -> Result<Self, HydroError> {
        let count = self.multipliers() + self.mobility.hidden();
        let (mut columns, mut solved) = (FlowColumns::zeros(count), FlowColumns::zeros(count));
        for axis in 0..3 {
            let mut column = DVector::zeros(count);
            for (k, one) in self.linkages.iter().enumerate() {
                let mut unit = DVector::zeros(one.rows());
                for sphere in 0..one.linkage.spheres.len() {
                    unit[6 * sphere + axis] = 1.0;
                }
                let mut rows = column.rows_mut(self.first[k], one.complement.ncols());
                rows.gemv_tr(1.0, &one.complement, &unit, 0.0);
            }
            columns.set_column(axis, &column);
            solved.set_column(axis, &self.preconditioned(&column));
        }
        let spheres = self.mobility.spheres().len();
        self.flow = Some(UnknownFlow::new(total, columns, solved, spheres)?);
        Ok(self)
    }

    /// Number of multipliers: of forces that do no work on the motions of their linkages.
    pub fn multipliers(&self) -> usize {
        self.first[self.linkages.len()]
    }

    /// Numbers in the matrices of all linkages: `O(n)` for linkages of bounded size.
    pub fn stored_numbers(&self) -> usize {
        let of_linkage = |one: &Eliminated| {
            let Linkage { basis, damping, .. } = &one.linkage;
            let matrices = [basis, damping, &one.range, &one.triangle, &one.complement];
            let factor = one.factor.l_dirty().len();
            matrices.iter().map(|m| m.len()).sum::<usize>() + factor
        };
        self.linkages.iter().map(of_linkage).sum()
    }

    /// Forces and coordinates to a relative residual of `tolerance`, or to the rounding of the
    /// velocities where these nearly cancel.
    ///
    /// # Errors
    /// [`HydroError::NotConverged`]; [`HydroError::NotPositiveDefinite`] for point forces too close
    /// to each other; [`HydroError::NotFinite`].
    pub fn solve(&self, tolerance: f64) -> Result<LinkedMotion, HydroError> {
        self.motion_from(None, tolerance)
    }

    /// Forces and coordinates from these multipliers and this mean flow, or from none.
    fn motion_from(
        &self,
        start: Option<(DVector<f64>, Vector3<f64>)>,
        tolerance: f64,
    ) -> Result<LinkedMotion, HydroError> {
        let balancing = self.linkages.iter().map(Eliminated::balancing).collect();
        let offsets = self.linkages.iter().map(|one| &one.linkage.offset);
        let offsets: Vec<DVector<f64>> = offsets.cloned().collect();
        let total = self.flow.as_ref().map(|flow| flow.total);
        self.motion(
            (balancing, total),
            (&offsets, &self.hidden),
            tolerance,
            start,
        )
    }

    /// The same from the forces of other joints of the same spheres, or by another mobility; the
    /// residual is relative to that of these forces.
    ///
    /// # Errors
    /// Those of [`LinkedSpheres::solve`]; [`HydroError::Length`].
    pub fn solve_near(
        &self,
        start: &LinkedMotion,
        tolerance: f64,
    ) -> Result<LinkedMotion, HydroError> {
        let count = 6 * self.mobility.spheres().len();
        check_entries(
            "forces and torques on the spheres",
            count,
            start.forces.len(),
        )?;
        check_entries("multipoles", self.mobility.hidden(), start.hidden.len())?;
        let mut multipliers = DVector::zeros(self.multipliers() + start.hidden.len());
        for (k, one) in self.linkages.iter().enumerate() {
            let none = DVector::zeros(0);
            let dashpots = start.dashpots.get(k).unwrap_or(&none).iter();
            let of_spheres = one.linkage.spheres.iter();
            let of_spheres = of_spheres.flat_map(|&k| &start.forces.as_slice()[6 * k..6 * k + 6]);
            let all: Vec<f64> = of_spheres.chain(dashpots).copied().collect();
            let forces = DVector::from_vec(all).resize_vertically(one.rows(), 0.0);
            let mut rows = multipliers.rows_mut(self.first[k], one.complement.ncols());
            rows.gemv_tr(1.0, &one.complement, &forces, 0.0);
        }
        let mut rows = multipliers.rows_mut(self.multipliers(), start.hidden.len());
        rows.copy_from(&start.hidden);
        self.motion_from(Some((multipliers, start.mean_flow)), tolerance)
    }

    /// Change of forces and coordinates for a small change `δU` of the velocities by given forces:
    /// `M δf + δU = S δv`, `S^T δf + D δv = 0`.
    ///
    /// # Errors
    /// Those of [`LinkedSpheres::solve`]; [`HydroError::Length`].
    pub fn change(
        &self,
        velocities: &DVector<f64>,
        tolerance: f64,
    ) -> Result<LinkedMotion, HydroError> {
        let count = 6 * self.mobility.spheres().len();
        check_entries("changes of velocities", count, velocities.len())?;
        let balancing = self.linkages.iter().map(|one| DVector::zeros(one.rows()));
        let offsets = self.linkages.iter().map(|one| {
            let of_sphere = |&k: &usize| velocities.as_slice()[6 * k..6 * k + 6].iter().map(|u| -u);
            let entries = one.linkage.spheres.iter().flat_map(of_sphere);
            DVector::from_iterator(one.linkage.offset.len(), entries)
        });
        let offsets: Vec<_> = offsets.collect();
        let total = self.flow.as_ref().map(|_| Vector3::zeros());
        let at_rest = DVector::zeros(self.hidden.len());
        let driven = (&offsets[..], &at_rest);
        self.motion((balancing.collect(), total), driven, tolerance, None)
    }

    /// The motion by forces that balance the loads, and the total force, if that is given;
    /// `driven` are the given velocities of all linkages and the right-hand side of the further
    /// degrees of freedom.
    fn motion(
        &self,
        (balancing, total): (Vec<DVector<f64>>, Option<Vector3<f64>>),
        (offsets, driven): (&[DVector<f64>], &DVector<f64>),
        tolerance: f64,
        start: Option<(DVector<f64>, Vector3<f64>)>,
    ) -> Result<LinkedMotion, HydroError> {
        let (count, hidden) = (self.multipliers(), self.mobility.hidden());
        let none = || (DVector::zeros(count + hidden), Vector3::zeros());
        let (mut multipliers, start_flow) = start.unwrap_or_else(none);
        if let Some((flow, total)) = self.flow.as_ref().zip(total) {
            let given = (self.linkages.iter().zip(&balancing)).map(|(one, forces)| {
                let spheres = 0..one.linkage.spheres.len();
                spheres
                    .map(|k| forces.fixed_rows::<3>(6 * k).into_owned())
                    .sum::<Vector3<f64>>()
            });
            flow.balance(&mut multipliers, &(total - given.sum::<Vector3<f64>>()));
        }
        let of_multipliers = |multipliers: &DVector<f64>| {
            let all = self.of_each(|k, one| {
                &balancing[k] + &one.complement * self.of_linkage(multipliers, k)
            });
            self.gathered(&all, multipliers.rows(count, hidden).into_owned())
        };
        let relative_velocities = |forces: &Forces| {
            let mut velocities = self.velocities(forces)?;
            velocities.hidden -= driven;
            Ok::<_, HydroError>(velocities)
        };
        let mut forces = of_multipliers(&multipliers);
        let mut velocities = relative_velocities(&forces)?;
        let mut residual = self.unbalanced(&velocities, offsets);
        let mut mean_flow = self.split(&mut residual);
        // With the change of the flow, which the residual is without.
        let of_flow = [mean_flow - start_flow, NO_CHANGE * mean_flow];
        let scale = residual.norm()
            + of_flow
                .map(|flow| self.flow_norm(&flow))
                .iter()
                .sum::<f64>();
        let given = offsets.iter().map(|w| w.norm_squared()).sum::<f64>().sqrt();
        let target = |velocities: &Forces| {
            let rounding = ROUNDING * (velocities.spheres.norm() + given);
            rounding.max(tolerance * scale)
        };
        let mut iterations = 0;
        for _ in 0..MAX_STARTS {
            let target = target(&velocities);
            if residual.norm() <= target {
                break;
            }
            iterations += self.iterate(&mut multipliers, residual.clone(), target)?;
            forces = of_multipliers(&multipliers);
            velocities = relative_velocities(&forces)?;
            residual = self.unbalanced(&velocities, offsets);
            mean_flow = self.split(&mut residual);
        }
        let reached = residual.norm();
        // Restarts reach rounding; an error of the recursion that is left is within a factor.
        let target = target(&velocities);
        let is_reached = reached <= 10.0 * target;
        if !is_reached {
            return Err(HydroError::NotConverged {
                iterations,
                residual: reached,
                target,
            });
        }
        for sphere in 0..velocities.spheres.len() / 6 {
            let mut rows = velocities.spheres.fixed_rows_mut::<3>(6 * sphere);
            rows += mean_flow;
        }
        let coordinates = self.of_each(|k, one| {
            let projected = (one.range).tr_mul(&self.relative(&velocities, k, &offsets[k]));
            let free = projected.len();
            let solved = one.triangle.solve_upper_triangular(&projected);
            solved.unwrap_or_else(|| DVector::zeros(free))
        });
        Ok(LinkedMotion {
            coordinates,
            forces: forces.spheres,
            dashpots: forces.dashpots,
            hidden: forces.hidden,
            mean_flow,
            iterations,
            residual: if scale > 0.0 { reached / scale } else { 0.0 },
        })
    }

    /// Preconditioned conjugate gradients for the multipliers, from the residual of the present
    /// ones; returns the number of iterations.
    fn iterate(
        &self,
        multipliers: &mut DVector<f64>,
        mut residual: DVector<f64>,
        target: f64,
    ) -> Result<usize, HydroError> {
        let mut preconditioned = self.preconditioned(&residual);
        let mut direction = preconditioned.clone();
        let mut product = residual.dot(&preconditioned);
        for iteration in 0..MAX_ITERATIONS {
            if residual.norm() <= target {
                return Ok(iteration);
            }
            let image = self.image(&direction)?;
            let curvature = direction.dot(&image);
            if curvature.is_nan() || curvature <= 0.0 {
                return Err(self.mobility.not_positive_definite());
            }
            let step = product / curvature;
            multipliers.axpy(step, &direction, 1.0);
            residual.axpy(-step, &image, 1.0);
            self.split(&mut residual);
            preconditioned = self.preconditioned(&residual);
            let next = residual.dot(&preconditioned);
            direction.axpy(1.0, &preconditioned, next / product);
            product = next;
        }
        Err(HydroError::NotConverged {
            iterations: MAX_ITERATIONS,
            residual: residual.norm(),
            target,
        })
    }

    /// `Z^T M Z` times multipliers.
    fn image(&self, multipliers: &DVector<f64>) -> Result<DVector<f64>, HydroError> {
        let all = self.of_each(|k, one| &one.complement * self.of_linkage(multipliers, k));
        let hidden = multipliers.rows(self.multipliers(), self.mobility.hidden());
        let velocities = self.velocities(&self.gathered(&all, hidden.into_owned()))?;
        Ok(self.stacked(&velocities.hidden, |k, one, mut rows| {
            rows.gemv_tr(1.0, &one.complement, &self.own(&velocities, k), 0.0);
        }))
    }

    /// A vector for each linkage, in parallel.
    fn of_each(
        &self,
        vector: impl Fn(usize, &Eliminated) -> DVector<f64> + Sync,
    ) -> Vec<DVector<f64>> {
        let all = self.linkages.par_iter().with_min_len(AT_ONCE).enumerate();
        all.map(|(k, one)| vector(k, one)).collect()
    }

    /// Numbers for the multipliers of each linkage, entered in parallel, and further ones.
    fn stacked(
        &self,
        hidden: &DVector<f64>,
        enter: impl Fn(usize, &Eliminated, DVectorViewMut<f64>) + Sync,
    ) -> DVector<f64> {
        let count = self.multipliers();
        let mut all = DVector::zeros(count + hidden.len());
        all.rows_mut(count, hidden.len()).copy_from(hidden);
        let mut rest = all.as_mut_slice();
        let mut parts = Vec::with_capacity(self.linkages.len());
        for one in &self.linkages {
            let (own, others) = rest.split_at_mut(one.complement.ncols());
            parts.push(own);
            rest = others;
        }
        let parts = parts.into_par_iter().with_min_len(AT_ONCE).enumerate();
        parts.for_each(|(k, own)| {
            let length = own.len();
            enter(
                k,
                &self.linkages[k],
                DVectorViewMut::from_slice(own, length),
            );
        });
        all
    }

    /// The unknown mean flow of a residual, which then is without it; zero where it is given.
    fn split(&self, residual: &mut DVector<f64>) -> Vector3<f64> {
        (self.flow.as_ref()).map_or_else(Vector3::zeros, |flow| flow.split(residual))
    }

    /// The norm of the part of a residual that a mean flow is; zero where it is given.
    fn flow_norm(&self, flow: &Vector3<f64>) -> f64 {
        self.flow.as_ref().map_or(0.0, |own| own.norm(flow))
    }

    fn preconditioned(&self, residual: &DVector<f64>) -> DVector<f64> {
        let hidden = residual.rows(self.multipliers(), self.mobility.hidden());
        let mut hidden = hidden.into_owned();
        self.mobility.precondition_hidden(&mut hidden);
        self.stacked(&hidden, |k, one, mut rows| {
            rows.copy_from(&self.of_linkage(residual, k));
            one.factor.solve_mut(&mut rows);
        })
    }

    /// `Z^T (W - U)` for velocities `U`, of dashpots too.
    fn unbalanced(&self, velocities: &Forces, offsets: &[DVector<f64>]) -> DVector<f64> {
        self.stacked(&-&velocities.hidden, |k, one, mut rows| {
            let relative = self.relative(velocities, k, &offsets[k]);
            rows.gemv_tr(-1.0, &one.complement, &relative, 0.0);
        })
    }

    /// Multipliers of a linkage.
    fn of_linkage<'v>(
        &self,
        all: &'v DVector<f64>,
        linkage: usize,
    ) -> nalgebra::DVectorView<'v, f64> {
        let columns = self.linkages[linkage].complement.ncols();
        all.rows(self.first[linkage], columns)
    }

    /// Velocities of the spheres and dashpots of a linkage.
    fn own(&self, velocities: &Forces, linkage: usize) -> DVector<f64> {
        let spheres = &self.linkages[linkage].linkage.spheres;
        let all = velocities.spheres.as_slice();
        let of_spheres = spheres.iter().flat_map(|&k| &all[6 * k..6 * k + 6]);
        let entries = of_spheres.chain(velocities.dashpots[linkage].iter());
        DVector::from_iterator(self.linkages[linkage].rows(), entries.copied())
    }

    /// The same relative to given velocities of the spheres.
    fn relative(&self, velocities: &Forces, linkage: usize, offset: &DVector<f64>) -> DVector<f64> {
        let mut own = self.own(velocities, linkage);
        let mut rows = own.rows_mut(0, offset.len());
        rows -= offset;
        own
    }

    /// Forces of all spheres from those of the linkages.
    fn gathered(&self, linkages: &[DVector<f64>], hidden: DVector<f64>) -> Forces {
        let mut spheres = DVector::zeros(6 * self.mobility.spheres().len());
        let mut dashpots = Vec::with_capacity(linkages.len());
        for (one, forces) in self.linkages.iter().zip(linkages) {
            for (number, &k) in one.linkage.spheres.iter().enumerate() {
                let own = forces.rows(6 * number, 6);
                spheres.rows_mut(6 * k, 6).copy_from(&own);
            }
            let count = 6 * one.linkage.spheres.len();
            dashpots.push(forces.rows(count, forces.len() - count).into_owned());
        }
        Forces {
            spheres,
            dashpots,
            hidden,
        }
    }

    /// Velocities by forces; the mobility of a dashpot is one.
    fn velocities(&self, forces: &Forces) -> Result<Forces, HydroError> {
        let [spheres, hidden] = self.mobility.product(&forces.spheres, &forces.hidden)?;
        Ok(Forces {
            spheres,
            dashpots: forces.dashpots.clone(),
            hidden,
        })
    }
}

impl<M: Mobility> LinkedSpheres<'_, M> {
    /// Random loads on the coordinates of each linkage, with the covariance `S^T M^-1 S + D` for
    /// independent standard normal numbers.
    ///
    /// They are `S^T f` for forces `f` of covariance `M^-1`, those in `G^T (G A G^T)^(-1/2) w` with
    /// the whole matrix `A` of forces and further degrees of freedom, whose inverse has `M^-1` as
    /// the block of forces. As preconditioner `G` has the factorised blocks of the linkages alone
    /// (Chow & Saad 2014, SIAM J. Sci. Comput. 36, A588), and those of dashpots. For one linkage
    /// without further degrees of freedom this is a Cholesky factorisation. The square root is that
    /// of Lanczos, to a relative accuracy of 1e-6. Cost: one product with the mobility per step.
    ///
    /// # Errors
    /// [`HydroError::NotPositiveDefinite`] for point forces too close to each other, and
    /// [`HydroError::FactorisationFailed`] for expansions; [`HydroError::RootNotConverged`];
    /// [`HydroError::NotFinite`].
    pub fn random_loads(
        &self,
        normal: &mut dyn FnMut() -> f64,
    ) -> Result<Vec<DVector<f64>>, HydroError> {
        let not_positive_definite = || self.mobility.not_positive_definite();
        let factors: Vec<DMatrix<f64>> = (self.linkages.par_iter())
            .map(|one| {
                let block = self.mobility.own_block(&one.linkage.spheres);
                let factor = Cholesky::new(block).ok_or_else(not_positive_definite)?;
                Ok(factor.unpack())
            })
            .collect::<Result<_, HydroError>>()?;
        let mut first = vec![0];
        for factor in &factors {
            first.push(first[first.len() - 1] + factor.nrows());
        }
        let (of_spheres, hidden) = (first[factors.len()], self.mobility.hidden());
        let of_linkage = |all: &DVector<f64>, k: usize| {
            let own = all.rows(first[k], factors[k].nrows());
            let solved = factors[k].tr_solve_lower_triangular(&own);
            solved.ok_or_else(not_positive_definite)
        };
        let with_dashpots = |k: usize, forces: DVector<f64>| {
            let rows = self.linkages[k].rows();
            forces.resize_vertically(rows, 0.0)
        };
        // L^-1 A L^-T with the factors L of the blocks
        let apply = |all: &DVector<f64>| {
            let forces = (0..factors.len()).map(|k| Ok(with_dashpots(k, of_linkage(all, k)?)));
            let forces: Vec<_> = forces.collect::<Result<_, HydroError>>()?;
            let further = all.rows(of_spheres, hidden).into_owned();
            let velocities = self.velocities(&self.gathered(&forces, further))?;
            let mut image = DVector::zeros(all.len());
            (image.rows_mut(of_spheres, hidden)).copy_from(&velocities.hidden);
            for (k, factor) in factors.iter().enumerate() {
                let count = factor.nrows();
                let own = self.own(&velocities, k).resize_vertically(count, 0.0);
                let solved = factor.solve_lower_triangular(&own);
                let solved = solved.ok_or_else(not_positive_definite)?;
                image.rows_mut(first[k], count).copy_from(&solved);
            }
            Ok(image)
        };
        let mut normals = DVector::from_fn(of_spheres, |_, _| normal());
        let mut further = DVector::from_fn(hidden, |_, _| normal());
        self.mobility.clear_places_of_forces(&mut further);
        normals.extend(further.iter().copied());
        let root = inverse_root(&normals, apply)?.ok_or_else(not_positive_definite)?;
        let loads = self.linkages.iter().enumerate().map(|(k, one)| {
            let spheres = factors[k].nrows();
            let mut forces = with_dashpots(k, of_linkage(&root, k)?);
            for dashpot in spheres..one.rows() {
                forces[dashpot] = normal();
            }
            Ok(one.triangle.tr_mul(&one.range.tr_mul(&forces)))
        });
        loads.collect()
    }
}
