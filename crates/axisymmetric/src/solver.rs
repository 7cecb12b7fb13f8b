//! Computation of resistances by elements of increasing order on one mesh.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

use crate::AxisymmetricError;
use crate::canonical::Canonical;
use crate::collar::{Collars, Motion};
use crate::curve::BoundaryPart;
use crate::generate::generate;
use crate::meridian::{GROWTH, Meridian, Surroundings};
use crate::mesh::MeridianMesh;
use crate::open_boundary::{exterior_flow, exterior_swirl};
use crate::resistance::{AxialResistance, SurfaceResistance, distance};
use crate::spheroid::AxialSpheroid;
use crate::surface_modes::{MODES, omitted_powers};
use crate::swirl::omitted_torque;
use crate::system::{Dof, Element, Solution};

/// Highest order: above it the tabulated nodal basis loses digits.
pub(crate) const MAX_ORDER: usize = 10;

/// The first of three orders, of which the last is likely to meet the tolerance.
///
/// The error of order `k` is about `10^(-1.2 k)`. The three orders are at least 3, 4, 5: from five
/// on the error decreases regularly enough for the estimate.
fn first_order(tolerance: f64) -> usize {
    ((-tolerance.log10() / 1.2).ceil() as usize).clamp(5, MAX_ORDER) - 2
}

/// Bounds on the factor by which one order reduces the error, when the last change is extrapolated.
///
/// A smaller observed factor is considered accidental: with the smallest one here, estimates are
/// 0.76 to 1.8 times the true error in 13 cases with exact values. A larger one means that the
/// orders do not converge yet.
const REDUCTION_BOUNDS: [f64; 2] = [0.055, 0.6];

/// Smallest tolerance; rounding in the factorisation causes errors of about a hundredth of it.
const MIN_TOLERANCE: f64 = 1e-11;

/// Computes the resistance to motion along the axis to a relative `tolerance`.
///
/// Uses velocities of degree `k` and pressures of degree `k - 1` on curved triangles. The order `k`
/// increases from three or more until the estimated error, the change from order `k - 1`
/// extrapolated as a geometric series, is below the tolerance. For smooth bodies each order reduces
/// the error by a factor of five to ten. The result is the same, to the last bit, for bodies in any
/// order and for a mirror image.
///
/// Unbounded fluid, or that in a large ball, is meshed within a ball around the bodies. The flow
/// beyond it is expanded in spherical harmonics and joined to the mesh without an approximation
/// (Givoli & Keller 1989).
///
/// Cost: 500 to 1000 degrees of freedom per body for 1e-6; 0.1 s to 1 s. For many configurations
/// of the same bodies [`ResistanceSolver`] is faster.
///
/// ```
/// use axisymmetric::{AxialSpheroid, Surroundings, axial_resistance};
///
/// let sphere = AxialSpheroid::sphere(0.0, 1.0);
/// let drag = axial_resistance(&[sphere], Surroundings::Ball { radius: 2.0 }, 1e-6)?;
/// let exact = 7.294117647058823 * 6.0 * std::f64::consts::PI; // Haberman & Sayre 1958
/// assert!((drag.matrix()[(0, 0)] / exact - 1.0).abs() < 1e-6);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
///
/// # Errors
/// [`AxisymmetricError`] for sizes that are not positive, bodies that overlap or touch, gaps below
/// 1e-4 of a radius, lengths that differ by more than a factor of 1e6, a tolerance outside
/// [1e-11, 1), an error above the tolerance at the highest order
/// ([`AxisymmetricError::NotConverged`]; [`ResistanceSolver::axial_best`] returns the result then),
/// and failures of the solver.
pub fn axial_resistance(
    bodies: &[AxialSpheroid],
    surroundings: Surroundings,
    tolerance: f64,
) -> Result<AxialResistance, AxisymmetricError> {
    ResistanceSolver::new().axial(bodies, surroundings, tolerance)
}

/// Computes the resistance to rotation about the axis to a relative `tolerance`.
///
/// Solves a scalar equation without pressure, with a third of the degrees of freedom of
/// [`axial_resistance`].
///
/// ```
/// use axisymmetric::{AxialSpheroid, Surroundings, spin_resistance};
///
/// let sphere = AxialSpheroid::sphere(0.0, 1.0);
/// let torque = spin_resistance(&[sphere], Surroundings::Ball { radius: 2.0 }, 1e-6)?;
/// let exact = 8.0 * std::f64::consts::PI * 8.0 / 7.0; // 1 / (1 - 2^-3)
/// assert!((torque.matrix()[(0, 0)] / exact - 1.0).abs() < 1e-6);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
///
/// # Errors
/// Those of [`axial_resistance`].
pub fn spin_resistance(
    bodies: &[AxialSpheroid],
    surroundings: Surroundings,
    tolerance: f64,
) -> Result<AxialResistance, AxisymmetricError> {
    ResistanceSolver::new().spin(bodies, surroundings, tolerance)
}

/// Computes the resistances of successive configurations, and keeps what they have in common.
///
/// Around each body with enough clearance lies a collar: the fluid up to a confocal spheroid of one
/// of a few sizes. It moves rigidly with the body, so its matrices do not change. They are computed
/// once for each shape of body and size of collar, and condensed to the degrees of freedom on the
/// outline. A solution then takes the fluid between the collars only. Results are kept as well: a
/// configuration, or its mirror image, is solved once.
///
/// Results do not depend on what was computed before, not even in the last bit. Copies share what
/// they keep, so several threads may compute with them or with one of them.
///
/// ```
/// use axisymmetric::{ResistanceSolver, AxialSpheroid, Surroundings};
///
/// let solver = ResistanceSolver::new();
/// let attraction = |distance| {
///     let pair = [AxialSpheroid::sphere(0.0, 1.0), AxialSpheroid::sphere(distance, 1.0)];
///     let found = solver.axial(&pair, Surroundings::Unbounded, 1e-4)?;
///     Ok::<f64, axisymmetric::AxisymmetricError>(found.matrix()[(0, 1)])
/// };
/// assert!(attraction(6.0)? < attraction(10.0)?);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct ResistanceSolver {
    collars: Arc<Collars>,
    results: Arc<Mutex<Results>>,
}

type Results = BTreeMap<Question, Result<AxialResistance, AxisymmetricError>>;

/// What a result depends on.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Question {
    configuration: Vec<u64>,
    motion: Motion,
    /// Bits of the tolerance.
    tolerance: u64,
}

/// Largest number of results kept; those of a stroke are a few dozen.
const MAX_RESULTS: usize = 2000;

impl ResistanceSolver {
    /// A solver that has not computed anything.
    pub fn new() -> Self {
        Self::default()
    }

    /// As [`axial_resistance`].
    ///
    /// # Errors
    /// Those of [`axial_resistance`].
    pub fn axial(
        &self,
        bodies: &[AxialSpheroid],
        surroundings: Surroundings,
        tolerance: f64,
    ) -> Result<AxialResistance, AxisymmetricError> {
        self.converged(bodies, surroundings, tolerance, Motion::Translation)
    }

    /// As [`ResistanceSolver::axial`], but if the tolerance is out of reach, the resistance of the
    /// highest order with its error estimate.
    ///
    /// # Errors
    /// Those of [`axial_resistance`] except [`AxisymmetricError::NotConverged`].
    pub fn axial_best(
        &self,
        bodies: &[AxialSpheroid],
        surroundings: Surroundings,
        tolerance: f64,
    ) -> Result<AxialResistance, AxisymmetricError> {
        Ok(self
            .best(bodies, surroundings, tolerance, Motion::Translation)?
            .0)
    }

    /// As [`spin_resistance`].
    ///
    /// # Errors
    /// Those of [`axial_resistance`].
    pub fn spin(
        &self,
        bodies: &[AxialSpheroid],
        surroundings: Surroundings,
        tolerance: f64,
    ) -> Result<AxialResistance, AxisymmetricError> {
        self.converged(bodies, surroundings, tolerance, Motion::Rotation)
    }

    /// As [`ResistanceSolver::axial_best`], for rotation about the axis.
    ///
    /// # Errors
    /// Those of [`ResistanceSolver::axial_best`].
    pub fn spin_best(
        &self,
        bodies: &[AxialSpheroid],
        surroundings: Surroundings,
        tolerance: f64,
    ) -> Result<AxialResistance, AxisymmetricError> {
        Ok(self
            .best(bodies, surroundings, tolerance, Motion::Rotation)?
            .0)
    }

    /// Resistance to motion along the axis and to the modes of the surfaces.
    ///
    /// If the tolerance is out of reach, the result has the highest order and its error estimate.
    ///
    /// # Errors
    /// Those of [`axial_resistance`] except [`AxisymmetricError::NotConverged`].
    pub fn surfaces(
        &self,
        bodies: &[AxialSpheroid],
        surroundings: Surroundings,
        tolerance: f64,
    ) -> Result<SurfaceResistance, AxisymmetricError> {
        let (found, _) = self.best(bodies, surroundings, tolerance, Motion::Surfaces)?;
        Ok(SurfaceResistance::new(found, bodies))
    }

    /// The resistance, if its estimated error is below `tolerance`.
    fn converged(
        &self,
        bodies: &[AxialSpheroid],
        surroundings: Surroundings,
        tolerance: f64,
        motion: Motion,
    ) -> Result<AxialResistance, AxisymmetricError> {
        let (found, reached) = self.best(bodies, surroundings, tolerance, motion)?;
        if reached <= tolerance {
            return Ok(found);
        }
        Err(AxisymmetricError::NotConverged {
            tolerance,
            reached,
            order: found.order,
        })
    }

    /// The resistance of the first order that meets `tolerance`, else of the highest one, and its
    /// estimated error, which does not depend on the unit of length.
    fn best(
        &self,
        bodies: &[AxialSpheroid],
        surroundings: Surroundings,
        tolerance: f64,
        motion: Motion,
    ) -> Result<(AxialResistance, f64), AxisymmetricError> {
        check_tolerance(tolerance)?;
        // the message of an error names bodies and lengths of the caller
        Meridian::new(bodies, surroundings)?;
        let canonical = Canonical::new(bodies, surroundings);
        let question = Question {
            configuration: canonical.bits(),
            motion,
            tolerance: tolerance.to_bits(),
        };
        let known = self.results().get(&question).cloned();
        let result = known.unwrap_or_else(|| self.raise_order(&canonical, tolerance, motion));
        let mut results = self.results();
        if results.len() >= MAX_RESULTS {
            results.clear();
        }
        results.insert(question, result.clone());
        drop(results);
        let found = result?;
        let reached = found.relative_error();
        Ok((canonical.in_units_of_caller(found, motion)?, reached))
    }

    fn results(&self) -> MutexGuard<'_, Results> {
        self.results.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Raises the order until the estimated error is below `tolerance`, at most to [`MAX_ORDER`].
    fn raise_order(
        &self,
        canonical: &Canonical,
        tolerance: f64,
        motion: Motion,
    ) -> Result<AxialResistance, AxisymmetricError> {
        let (bodies, surroundings) = (&canonical.bodies, canonical.surroundings);
        let meridian = Meridian::new(bodies, surroundings)?.meshed_part();
        let mesh = generate(&meridian, GROWTH)?;
        let discretisation = Discretisation {
            meridian: &meridian,
            mesh: &mesh,
            bodies,
            motion,
        };
        let solve = |orders: Vec<usize>| -> Result<Vec<Solution>, AxisymmetricError> {
            self.collars.provide(&meridian, motion, &orders)?;
            let collars = &*self.collars;
            // each factorisation is too small for many threads, so orders are solved in parallel,
            // the highest first, which takes as long as two others
            let solved = orders.into_par_iter().rev();
            let mut solved = solved
                .map(|order| discretisation.solve(order, collars))
                .collect::<Result<Vec<_>, _>>()?;
            solved.reverse();
            Ok(solved)
        };
        raised_orders(tolerance, mesh.triangles.len(), solve)
    }
}

/// The problem and its mesh, which solutions of all orders share.
struct Discretisation<'a> {
    meridian: &'a Meridian,
    mesh: &'a MeridianMesh,
    bodies: &'a [AxialSpheroid],
    motion: Motion,
}

impl Discretisation<'_> {
    /// The resistance by elements of this order.
    fn solve(&self, order: usize, collars: &Collars) -> Result<Solution, AxisymmetricError> {
        let n = self.bodies.len();
        let mut system = self.motion.system(self.mesh, order, self.bodies)?;
        for (number, body, outline) in self.meridian.collars() {
            let mut dofs = system.trace(BoundaryPart::Interface(number)).to_vec();
            dofs.extend(self.motion.of_body(number, n).map(Dof::Body));
            let matrix = collars.matrix(&body, &outline, self.motion, order);
            system.elements.push(Element { dofs, matrix });
        }
        if let Some(sphere) = &self.meridian.open_sphere() {
            let matrix = match self.motion {
                Motion::Translation | Motion::Surfaces => exterior_flow(self.mesh, order, sphere),
                Motion::Rotation => exterior_swirl(self.mesh, order, sphere),
            };
            // the pressures on the boundary are not degrees of freedom of the flow beyond it
            let dofs = system.trace(BoundaryPart::Open)[..matrix.nrows()].to_vec();
            system.elements.push(Element { dofs, matrix });
        }
        let mut solution = system.resistance(self.motion.prescribed(n))?;
        for (i, body) in self.bodies.iter().enumerate() {
            match self.motion {
                Motion::Translation => {}
                Motion::Rotation => solution.resistance[(i, i)] += omitted_torque(body),
                Motion::Surfaces => {
                    let first = n + MODES * i;
                    let mut own =
                        (solution.resistance).fixed_view_mut::<MODES, MODES>(first, first);
                    own += omitted_powers(body);
                }
            }
        }
        Ok(solution)
    }
}

/// Refuses tolerances that no order meets.
pub(crate) fn check_tolerance(tolerance: f64) -> Result<(), AxisymmetricError> {
    match (MIN_TOLERANCE..1.0).contains(&tolerance) {
        true => Ok(()),
        false => Err(AxisymmetricError::InvalidTolerance {
            tolerance,
            limit: MIN_TOLERANCE,
        }),
    }
}

/// Raises the order of elements on a mesh of some triangles until the estimated error is below
/// `tolerance`, at most to [`MAX_ORDER`]; `solve` has the solutions of some orders.
///
/// # Errors
/// Those of `solve`.
pub(crate) fn raised_orders(
    tolerance: f64,
    triangles: usize,
    mut solve: impl FnMut(Vec<usize>) -> Result<Vec<Solution>, AxisymmetricError>,
) -> Result<AxialResistance, AxisymmetricError> {
    let first = first_order(tolerance);
    let mut last = solve(vec![first, first + 1, first + 2])?;
    let mut order = first + 2;
    loop {
        let found = estimated(order, &last, triangles);
        if order == MAX_ORDER || found.relative_error() <= tolerance {
            return Ok(found);
        }
        order += 1;
        last.rotate_left(1);
        last[2] = solve(vec![order])?.remove(0);
    }
}

/// The last of three solutions of successive orders on a mesh of some triangles, with its estimated
/// error.
fn estimated(order: usize, solutions: &[Solution], triangles: usize) -> AxialResistance {
    let [first, second, last] = [0, 1, 2].map(|k| &solutions[k]);
    let change_before = distance(&first.resistance, &second.resistance);
    let change = distance(&second.resistance, &last.resistance);
    let reduction = (change / change_before).clamp(REDUCTION_BOUNDS[0], REDUCTION_BOUNDS[1]);
    AxialResistance {
        matrix: last.resistance.clone(),
        lower_order: second.resistance.clone(),
        // the remaining sum of the geometric series
        error_factor: if reduction.is_nan() {
            1.0
        } else {
            reduction / (1.0 - reduction)
        },
        dofs: last.n_dofs,
        order,
        triangles,
        residual: last.residual,
    }
}
