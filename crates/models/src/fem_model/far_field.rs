//! Unbounded fluid as a large ball, and the correction for the effect of its wall; the fluid above
//! a plane wall as a large half ball.
//!
//! A force `F` on the fluid causes the far field `F / (8π μ r)`, so a wall at the distance `R`
//! reduces the velocity of a body of radius `a` by an amount of the order `a / R`. No ball of
//! practicable size makes this negligible. But to first order the effect of the wall near the
//! centre of a ball is known exactly: the uniform flow
//!
//! ```text
//! -3 F / (8π μ R)
//! ```
//!
//! (Oseen 1927; the first-order term in Haberman & Sayre 1958). The remaining error is of third
//! order in the extent of the bodies over `R`. A uniform flow moves all bodies alike and puts no
//! load on joints, so the correction is added to all velocities after the solve.
//!
//! Above a plane wall no correction is needed: the far field of a force at the height `h` parallel
//! to the wall is `3 F h x z r / (2π μ |r|^5)` (Blake 1971), so the effect of a half sphere of
//! radius `R` is of third order.

use std::f64::consts::PI;

use mesher::Sphere;
use nalgebra::{DMatrix, Matrix3, Vector3};
use rigid::{Articulation, Constraints, Drive, ExternalLoad, FlowSolution};
use stokes::{InitialGuesses, Options, Problem};

use crate::ModelError;
use crate::units::Scale;
use scene::{Domain, Scene};

/// Radius of the ball relative to the extent of the bodies.
///
/// The relative error is of third order in its inverse. Elements grow with the distance, so the
/// additional volume needs few of them.
const RELATIVE_RADIUS: f64 = 60.0;

/// Relative error of the corrected velocity over `(extent / R)^3`.
///
/// 5/2 for one sphere (Haberman & Sayre 1958).
const THIRD_ORDER: f64 = 2.5;

/// The same factor above a plane wall.
///
/// Measured with a half ball of six times the extent: 4.9 for a sphere pulled along the wall at a
/// height of two radii, where the effect is largest for a given extent; 0.1 for one pulled away.
const THIRD_ORDER_ABOVE_WALL: f64 = 5.0;

/// The ball that replaces unbounded fluid, in scaled units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarField {
    ball: Sphere,
    /// Whether only the half of the ball above the plane `z = 0` is filled.
    has_plane_wall: bool,
}

impl FarField {
    /// The ball around the bodies of a scene.
    pub fn new(scene: &Scene, scale: &Scale) -> Self {
        let positions = || scene.bodies().iter().map(|b| scale.length(b.position));
        let has_plane_wall = *scene.domain() == Domain::Wall;
        let mut centre = positions().sum::<Vector3<f64>>() / scene.bodies().len().max(1) as f64;
        if has_plane_wall {
            centre.z = 0.0;
        }
        let extent = scene
            .bodies()
            .iter()
            .zip(positions())
            .map(|(body, x)| (x - centre).norm() + scale.length(body.bounding_radius()))
            .fold(1.0, f64::max);
        Self {
            ball: Sphere {
                centre,
                radius: RELATIVE_RADIUS * extent,
            },
            has_plane_wall,
        }
    }

    /// Whether the fluid is bounded by the plane wall `z = 0`.
    pub fn has_plane_wall(&self) -> bool {
        self.has_plane_wall
    }

    /// The ball.
    pub fn ball(&self) -> Sphere {
        self.ball
    }

    /// Correction `3 F / (8π R)` of all velocities, for the total force `F` on the fluid.
    pub fn velocity_correction(&self, force: Vector3<f64>) -> Vector3<f64> {
        force * self.mobility()
    }

    /// Velocity at `x` on the wall of a source at `centre` with a flux; above a plane wall at first
    /// order in the height of the source.
    ///
    /// With `r = x - centre`, `Q r / (4π |r|³)` in unbounded fluid. Above a plane wall, with `r`
    /// from the centre of the half ball, `3 Q z² r / (2π |r|⁵)`: a Stokes flow with the flux `Q`
    /// that is zero on the wall.
    pub fn flow_of_source(
        &self,
        flux: f64,
        centre: &Vector3<f64>,
        x: &Vector3<f64>,
    ) -> Vector3<f64> {
        match self.has_plane_wall {
            false => {
                let arm = x - centre;
                flux / (4.0 * PI * arm.norm().powi(3)) * arm
            }
            true => {
                let arm = x - self.ball.centre;
                let size = arm.norm();
                // The centre of the half ball is on the plane wall.
                match size > 0.0 {
                    true => 3.0 * flux * arm.z * arm.z / (2.0 * PI * size.powi(5)) * arm,
                    false => Vector3::zeros(),
                }
            }
        }
    }

    /// Relative error of corrected velocities, for bodies with these centres and radii.
    pub fn relative_error(&self, bodies: impl Iterator<Item = (Vector3<f64>, f64)>) -> f64 {
        let extent = bodies
            .map(|(centre, radius)| (centre - self.ball.centre).norm() + radius)
            .fold(0.0, f64::max);
        let factor = match self.has_plane_wall {
            true => THIRD_ORDER_ABOVE_WALL,
            false => THIRD_ORDER,
        };
        factor * (extent / self.ball.radius).powi(3)
    }

    /// Grand resistance in unbounded fluid from the grand resistance in the ball.
    ///
    /// In the mobility matrix, every force adds the same velocity to every body.
    ///
    /// # Errors
    /// [`ModelError::Singular`] for a singular matrix.
    pub fn corrected(&self, resistance: DMatrix<f64>) -> Result<DMatrix<f64>, ModelError> {
        let mut mobility = inverse("grand resistance", resistance)?;
        let bodies = mobility.nrows() / 6;
        for (i, j) in (0..bodies).flat_map(|i| (0..bodies).map(move |j| (i, j))) {
            for axis in 0..3 {
                mobility[(6 * i + axis, 6 * j + axis)] += self.mobility();
            }
        }
        let resistance = inverse("corrected grand mobility", mobility)?;
        // The inversion leaves an asymmetry of the size of rounding errors.
        Ok(0.5 * (&resistance + resistance.transpose()))
    }

    fn mobility(&self) -> f64 {
        3.0 / (8.0 * PI * self.ball.radius)
    }
}

/// A problem with bodies whose velocities in the laboratory are given.
pub struct FixedBodies<'a> {
    pub problem: &'a Problem<'a>,
    pub symmetry_planes: [bool; 3],
    pub set: &'a Articulation,
    pub loads: &'a [ExternalLoad],
    pub options: &'a Options,
}

/// Constraints in the frame that moves with the correction, in which held bodies have another
/// velocity.
///
/// With the correction `u = c F` and the total force `F = F_0 + T u`, where `F_0` is the force with
/// the given velocities in the ball and `T` its change by the additional motion `-u`,
///
/// ```text
/// (I - c T) u = c F_0
/// ```
///
/// Cost: one solve for each of the `constraints`, and one for each direction of `u`. The solution
/// with the returned constraints is a combination of these, so it is its own initial guess.
///
/// # Errors
/// Those of [`Problem::solve_all`]; [`ModelError::Singular`].
pub fn in_moving_frame(
    fixed: &FixedBodies,
    far: FarField,
    constraints: Vec<Constraints>,
    guesses: &mut InitialGuesses,
) -> Result<Vec<Constraints>, ModelError> {
    let Some(first) = constraints.first() else {
        return Ok(constraints);
    };
    let &FixedBodies {
        problem,
        symmetry_planes,
        set,
        loads,
        options,
    } = fixed;
    let axes: Vec<usize> = (0..3).filter(|&axis| !symmetry_planes[axis]).collect();
    let moved = |&axis: &usize| (first.clone()).with_added_velocity(-Vector3::ith(axis, 1.0));
    let moved: Vec<Constraints> = axes.iter().map(moved).collect::<Result<_, _>>()?;
    let drive = |constraints| Drive {
        set,
        constraints,
        loads,
    };
    let drives: Vec<Drive> = constraints.iter().chain(&moved).map(drive).collect();
    let solved = problem.solve_all(&drives, options, guesses, None)?;
    let forces: Vec<Vector3<f64>> = solved.iter().map(|s| total_force(&s.flow)).collect();
    let (at_rest, in_motion) = forces.split_at(constraints.len());
    let mut matrix = Matrix3::identity();
    for (&axis, force) in axes.iter().zip(in_motion) {
        let change = far.velocity_correction(force - at_rest[0]);
        matrix.set_column(axis, &(matrix.column(axis) - change));
    }
    let singular = ModelError::Singular {
        matrix: "effect of uniform flows on fixed bodies",
        size: 3,
    };
    let inverse = matrix.try_inverse().ok_or(singular)?;
    (constraints.into_iter().zip(at_rest))
        .map(|(constraints, force)| {
            let velocity = inverse * far.velocity_correction(*force);
            Ok(constraints.with_added_velocity(-velocity)?)
        })
        .collect()
}

/// Total force of the bodies on the fluid.
pub fn total_force(flow: &FlowSolution) -> Vector3<f64> {
    let bodies = 0..flow.forces.len() / 6;
    bodies
        .map(|body| Vector3::from_fn(|axis, _| flow.forces[6 * body + axis]))
        .sum()
}

fn inverse(name: &'static str, matrix: DMatrix<f64>) -> Result<DMatrix<f64>, ModelError> {
    let size = matrix.nrows();
    let singular = ModelError::Singular { matrix: name, size };
    matrix.try_inverse().ok_or(singular)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_singular_resistance_is_named() {
        let far = FarField {
            ball: Sphere {
                centre: Vector3::zeros(),
                radius: 60.0,
            },
            has_plane_wall: false,
        };
        let error = far.corrected(DMatrix::zeros(6, 6)).unwrap_err();
        assert!(
            matches!(&error, ModelError::Singular { size: 6, .. }),
            "{error}"
        );
        assert!(
            error
                .to_string()
                .contains("grand resistance (6 x 6) is singular")
        );
    }
}
