//! Velocities and forces of linked bodies from their grand resistance matrix.

use nalgebra::{DMatrix, DVector, Vector3};
use rigid::{
    Articulation, Constraints, Drive, ExternalLoad, Joint, Reduction, RigidError, StateVelocity,
};

use crate::error::ModelError;
use crate::query::Configuration;
use crate::response::Response;
use crate::scaled_scene::{ScaledResponse, ScaledScene};
use crate::surface_motion::SurfaceEffect;

/// Velocities and forces of linked bodies, in scaled units.
#[derive(Clone)]
pub(crate) struct MobilitySolution {
    /// Generalised velocities of all bodies and frames.
    pub generalised: DVector<f64>,
    /// Forces and torques that the bodies with surfaces exert on the fluid.
    pub forces: DVector<f64>,
    /// Residual of the balance of forces, relative to the right-hand side.
    pub residual: f64,
    /// Power of the slip on the fluid.
    pub slip_power: f64,
}

impl MobilitySolution {
    /// Solves for the motions that the joints leave free (formulation P-tilde).
    ///
    /// With a basis `S` of these motions, the motion `W` that the rates of the joints impose, the
    /// grand resistance `R`, the coefficients `D` of dashpots, the external loads `F` and the
    /// velocities `U_0` of force-free bodies by the velocities of their `surfaces`, the
    /// coefficients `v` satisfy
    ///
    /// ```text
    /// S^T (R + D) S v = S^T (F - D W - R (W - U_0))
    /// ```
    ///
    /// # Errors
    /// Joints that contradict each other; `S^T R S` that is not positive definite.
    pub fn new(
        resistance: &DMatrix<f64>,
        set: &Articulation,
        constraints: &Constraints,
        loads: &[ExternalLoad],
        surfaces: Option<&SurfaceEffect>,
    ) -> Result<Self, ModelError> {
        let reduction = Reduction::new(set, constraints)?;
        let drive = Drive {
            set,
            constraints,
            loads,
        };
        let force_free = surfaces.map(|surfaces| &surfaces.velocities);
        let relative_to_fluid = |velocities: &DVector<f64>| match force_free {
            Some(force_free) => velocities - force_free,
            None => velocities.clone(),
        };
        let s = &reduction.surface_basis;
        let w = &relative_to_fluid(&reduction.surface_offset);
        let all = &reduction.all;
        let loads = drive.generalised_loads()? - drive.damping_times(&all.offset)?;
        let rhs = all.basis.tr_mul(&loads) - s.tr_mul(&(resistance * w));
        let dashpots = drive.damping_projected(&all.basis, &all.basis)?;
        let matrix = s.tr_mul(&(resistance * s)) + dashpots;
        let coefficients = matrix
            .clone()
            .cholesky()
            .ok_or_else(|| {
                let name = "resistance of the motions that the links leave free";
                let remedy = "the bodies are too close for this model; use a more accurate one";
                ModelError::not_positive_definite(name, &matrix, remedy)
            })?
            .solve(&rhs);
        let scale = rhs.amax();
        let residual = (&matrix * &coefficients - &rhs).amax();
        let generalised = reduction.velocities(&coefficients)?;
        let velocities = generalised.select_rows(&set.surface_velocities());
        let forces = resistance * relative_to_fluid(&velocities);
        Ok(Self {
            slip_power: surfaces.map_or(0.0, |surfaces| surfaces.power(&forces)),
            forces,
            generalised,
            residual: if scale > 0.0 { residual / scale } else { 0.0 },
        })
    }

    /// Largest difference between the velocities of a body in two solutions.
    pub fn largest_difference(&self, other: &Self, set: &Articulation) -> f64 {
        let layout = set.velocity_layout();
        (0..set.kinds().len())
            .map(|body| {
                let velocity =
                    |solution: &Self| vector(&solution.generalised, layout.bodies()[body]);
                (velocity(self) - velocity(other)).norm()
            })
            .fold(0.0, f64::max)
    }

    /// Largest difference between the forces of a body in two solutions.
    pub fn largest_force_difference(&self, other: &Self) -> f64 {
        let first = (0..self.forces.len()).step_by(6);
        first.fold(0.0_f64, |largest, k| {
            largest.max((vector(&self.forces, k) - vector(&other.forces, k)).norm())
        })
    }

    /// Power of the bodies and their slip on the fluid.
    pub fn power(&self, set: &Articulation) -> f64 {
        let velocities = self.generalised.select_rows(&set.surface_velocities());
        self.forces.dot(&velocities) + self.slip_power
    }

    /// Motion and loads in the scene's units.
    ///
    /// # Errors
    /// Joints that contradict each other; a solution for another set of bodies.
    pub fn response(
        &self,
        scaled: &ScaledScene,
        constraints: &Constraints,
        loads: &[ExternalLoad],
    ) -> Result<Response, ModelError> {
        let set = &scaled.set;
        let drive = Drive {
            set,
            constraints,
            loads,
        };
        let joint_loads = drive.joint_loads(&self.forces, &self.generalised)?;
        let joints = 0..set.joints().len();
        let joint_forces: Result<_, RigidError> = joints
            .map(|joint| {
                constraints
                    .joint_load(&joint_loads, joint)
                    .map(|load| load.force)
            })
            .collect();
        Ok(scaled.response_to_scene(ScaledResponse {
            motion: &set.state_velocity(self.generalised.as_slice())?,
            generalised: &self.generalised,
            forces: &self.forces,
            joint_forces: joint_forces?,
            slip_power: self.slip_power,
        }))
    }
}

/// Velocities in the scene's units for a unit force on each passive joint, all else at rest, from
/// the grand resistance.
///
/// # Errors
/// Joints that contradict each other; bodies too close for the resistance.
pub(crate) fn joint_responses(
    scaled: &ScaledScene,
    configuration: Configuration,
    resistance: &DMatrix<f64>,
) -> Result<Vec<StateVelocity>, ModelError> {
    let set = &scaled.set;
    let at_rest = vec![0.0; set.joints().len()];
    let mut constraints = scaled.constraints(configuration, &at_rest)?;
    let loads = vec![ExternalLoad::default(); set.kinds().len()];
    let joints = set.passive_joints().enumerate();
    let response = |(number, joint): (usize, &Joint)| {
        constraints.joint_forces.fill(0.0);
        constraints.joint_forces[number] = scaled.scale.joint_force(joint, 1.0);
        let solved = MobilitySolution::new(resistance, set, &constraints, &loads, None)?;
        let motion = set.state_velocity(solved.generalised.as_slice())?;
        Ok(scaled.motion_to_scene(&motion))
    };
    joints.map(response).collect()
}

/// Three successive entries.
fn vector(list: &DVector<f64>, first: usize) -> Vector3<f64> {
    list.fixed_rows::<3>(first).into_owned()
}
