//! Axial resistance matrices with error estimates: elements of rising order on one mesh.

use std::f64::consts::PI;

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::AxisymmetricError;
use crate::meridian::{Meridian, Spheroid, Surroundings};
use crate::mesh::MeridianMesh;
use crate::stokes::stokes;
use crate::swirl::{missing_torque, swirl};
use crate::system::Solution;

/// How forces follow from velocities along the axis, or torques from angular velocities about it, with what lower orders of elements give.
///
/// $F_i = R_{ij} U_j$ is what the bodies exert on the fluid; viscosity 1. Symmetric positive definite.
#[derive(Clone, Debug, PartialEq)]
pub struct AxialResistance {
    matrix: DMatrix<f64>,
    coarser: DMatrix<f64>,
    tail: f64,
    far: f64,
    unknowns: usize,
    order: usize,
    triangles: usize,
    residual: f64,
}

/// Edges over the distance from the focus of the nearest body. Smaller ones need more unknowns for the same error, larger ones more
/// orders; between 0.6 and 1 it matters little (measured on spheres and spheroids in balls and tubes).
const GROWTH: f64 = 0.65;

/// Order of the last rung: above, the tables of the nodal basis lose digits.
const LAST: usize = 10;

/// The first of three orders of which the last is likely to meet a tolerance: errors are about a tenth to the power of the order. Not below
/// three, five and above fall evenly enough for the estimate.
fn first_order(tolerance: f64) -> usize {
    ((-tolerance.log10()).ceil() as usize).clamp(5, LAST) - 2
}

/// Bounds on the factor by which an order lessens the error, where it is used to continue the last change: below, luck; above, no
/// convergence yet.
const FALL: [f64; 2] = [0.08, 0.6];

/// Least tolerance: rounding in the factors leaves about a hundredth of it.
const FINEST: f64 = 1e-11;

/// Computes the resistance to relative `tolerance`, 1e-11 or what orders up to ten reach at the finest.
///
/// Velocities of degree `k` and pressures of degree `k - 1` on curved triangles, `k` from three on until the change from the order below,
/// continued geometrically, is less than the tolerance. For smooth bodies the error falls by a factor of five to ten an order.
/// Unbounded fluid is a ball a thousand times as large, whose image is taken out to first order in the inverse radius.
///
/// Cost: 1500 to 3000 unknowns a body for 1e-6, 4000 more in unbounded fluid; 0.1 s to 1 s.
///
/// ```
/// use axisymmetric::{Spheroid, Surroundings, axial_resistance};
///
/// let sphere = Spheroid::sphere(0.0, 1.0);
/// let drag = axial_resistance(&[sphere], Surroundings::Ball { radius: 2.0 }, 1e-6)?;
/// let exact = 7.294117647058823 * 6.0 * std::f64::consts::PI; // Haberman & Sayre 1958
/// assert!((drag.matrix()[(0, 0)] / exact - 1.0).abs() < 1e-6);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
///
/// # Errors
/// [`AxisymmetricError`] for bodies that touch, gaps below 1e-4 of a radius, sizes that are not positive; failures of the solve.
pub fn axial_resistance(
    bodies: &[Spheroid],
    surroundings: Surroundings,
    tolerance: f64,
) -> Result<AxialResistance, AxisymmetricError> {
    climb(bodies, surroundings, tolerance, Motion::Along)
}

/// Computes how torques follow from angular velocities about the axis, as [`axial_resistance`] does for forces.
///
/// A scalar equation without pressure, a third of the unknowns. The ball that stands for unbounded fluid changes torques by the third power of
/// the inverse of its size over the bodies', 1e-9.
///
/// ```
/// use axisymmetric::{Spheroid, Surroundings, spin_resistance};
///
/// let sphere = Spheroid::sphere(0.0, 1.0);
/// let torque = spin_resistance(&[sphere], Surroundings::Ball { radius: 2.0 }, 1e-6)?;
/// let exact = 8.0 * std::f64::consts::PI * 8.0 / 7.0; // 1 / (1 - 2^-3)
/// assert!((torque.matrix()[(0, 0)] / exact - 1.0).abs() < 1e-6);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
///
/// # Errors
/// As [`axial_resistance`].
pub fn spin_resistance(
    bodies: &[Spheroid],
    surroundings: Surroundings,
    tolerance: f64,
) -> Result<AxialResistance, AxisymmetricError> {
    climb(bodies, surroundings, tolerance, Motion::About)
}

/// How bodies move.
#[derive(Clone, Copy, PartialEq)]
enum Motion {
    /// Along the axis.
    Along,
    /// About it.
    About,
}

fn climb(
    bodies: &[Spheroid],
    surroundings: Surroundings,
    tolerance: f64,
    motion: Motion,
) -> Result<AxialResistance, AxisymmetricError> {
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return Err(AxisymmetricError::InvalidTolerance { tolerance });
    }
    let meridian = Meridian::new(bodies, surroundings)?;
    let mesh = MeridianMesh::generate(&meridian, GROWTH)?;
    let climb = Climb {
        meridian: &meridian,
        mesh: &mesh,
        unbounded: surroundings == Surroundings::Unbounded,
        bodies,
        motion,
    };
    let first = first_order(tolerance);
    // the factors are too small to be computed by many threads, but there are three of them
    let mut last: Vec<Solution> = [first, first + 1, first + 2]
        .into_par_iter()
        .map(|order| climb.solve(order))
        .collect::<Result<_, AxisymmetricError>>()?;
    let mut order = first + 2;
    loop {
        let found = climb.judged(order, &last);
        if found.relative_error() <= tolerance.max(FINEST) || order == LAST {
            return Ok(found);
        }
        order += 1;
        last.rotate_left(1);
        last[2] = climb.solve(order)?;
    }
}

/// What solutions of all orders have in common.
struct Climb<'a> {
    meridian: &'a Meridian,
    mesh: &'a MeridianMesh,
    unbounded: bool,
    /// In the order given.
    bodies: &'a [Spheroid],
    motion: Motion,
}

impl Climb<'_> {
    fn solve(&self, order: usize) -> Result<Solution, AxisymmetricError> {
        let n = self.bodies.len();
        match self.motion {
            Motion::Along => {
                let mut solution = stokes(self.mesh, order)?.resistance(n)?;
                if self.unbounded {
                    solution.resistance = self.without_image(&solution.resistance)?;
                }
                Ok(solution)
            }
            Motion::About => {
                let mut solution = swirl(self.mesh, order)?.resistance(n)?;
                for (i, body) in self.bodies.iter().enumerate() {
                    solution.resistance[(i, i)] += missing_torque(body);
                }
                Ok(solution)
            }
        }
    }

    /// The resistance without the ball around: its image of a force `F` anywhere near its centre is the uniform flow
    /// $-\tfrac94 F / (6 \pi R)$ to first order (Haberman & Sayre 1958; Maul & Kim 1994), the same for all mobilities.
    fn without_image(&self, resistance: &DMatrix<f64>) -> Result<DMatrix<f64>, AxisymmetricError> {
        let inverse =
            |m: DMatrix<f64>| m.try_inverse().ok_or(AxisymmetricError::SingularResistance);
        let radius = self.meridian.ball_radius().unwrap_or(f64::INFINITY);
        let mobility = inverse(resistance.clone())?.add_scalar(2.25 / (6.0 * PI * radius));
        inverse(mobility)
    }

    /// The last of three rungs, by elements of `order`, with its error.
    fn judged(&self, order: usize, rungs: &[Solution]) -> AxialResistance {
        let [first, second, last] = [0, 1, 2].map(|k| &rungs[k]);
        let before = distance(&first.resistance, &second.resistance);
        let change = distance(&second.resistance, &last.resistance);
        let fall = (change / before).clamp(FALL[0], FALL[1]);
        AxialResistance {
            matrix: last.resistance.clone(),
            coarser: second.resistance.clone(),
            // the rest of a geometric series
            tail: if fall.is_nan() {
                1.0
            } else {
                fall / (1.0 - fall)
            },
            far: if self.unbounded {
                self.left_by_image()
            } else {
                0.0
            },
            unknowns: last.unknowns,
            order,
            triangles: self.mesh.triangles.len(),
            residual: last.residual,
        }
    }

    /// What the image leaves of errors relative to a body's own mobility, $1 / (6 \pi a)$: terms in the inverse third power of the ball's radius,
    /// with the factors 5/2 for a sphere at the centre and about 8/3 for the places of force and body off the centre each.
    fn left_by_image(&self) -> f64 {
        let radius = self.meridian.ball_radius().unwrap_or(f64::INFINITY);
        let [length, width] = self.meridian.extent();
        8.0 * width * length.max(width).powi(2) / radius.powi(3)
    }
}

/// Largest difference of an entry $R_{ij}$ over $\sqrt{R_{ii} R_{jj}}$ of the second.
fn distance(one: &DMatrix<f64>, other: &DMatrix<f64>) -> f64 {
    let mut largest = 0.0_f64;
    for i in 0..one.nrows() {
        for j in 0..one.ncols() {
            let size = (other[(i, i)] * other[(j, j)]).abs().sqrt();
            largest = largest.max((one[(i, j)] - other[(i, j)]).abs() / size);
        }
    }
    largest
}

impl AxialResistance {
    /// The matrix, bodies in the order given.
    pub fn matrix(&self) -> &DMatrix<f64> {
        &self.matrix
    }

    /// The matrix by elements of one order less: what is computed from both tells the error, see [`AxialResistance::tail`].
    pub fn coarser(&self) -> &DMatrix<f64> {
        &self.coarser
    }

    /// The error of anything computed from [`AxialResistance::matrix`] is estimated as its change from [`AxialResistance::coarser`] times this.
    pub fn tail(&self) -> f64 {
        self.tail
    }

    /// Relative error by the ball that stands for unbounded fluid; zero for others.
    pub fn far_error(&self) -> f64 {
        self.far
    }

    /// Largest estimated error by the elements of an entry $R_{ij}$ relative to $\sqrt{R_{ii} R_{jj}}$.
    pub fn relative_error(&self) -> f64 {
        self.tail * distance(&self.coarser, &self.matrix)
    }

    /// Velocities and pressures of the last system.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Degree of the velocities.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.triangles
    }

    /// Largest true relative residual of a solve.
    pub fn residual(&self) -> f64 {
        self.residual
    }
}
