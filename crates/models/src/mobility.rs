//! Velocities and forces of linked bodies from their grand resistance matrix.

use nalgebra::{DMatrix, DVector, Vector3};
use rigid::{Articulation, Constraints, Drive, ExternalLoad, Joint, Reduction, StateVelocity};

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
    /// Loads that hold bodies, with the indices of the bodies.
    holding: Vec<(usize, ExternalLoad)>,
    /// Residual of the balance of forces, relative to the right-hand side.
    pub residual: f64,
    /// Power of the slip on the fluid.
    pub slip_power: f64,
    /// Rates of the amplitudes of deformations, and the forces on them.
    amplitudes: Vec<(f64, f64)>,
}

/// Largest differences between two solutions, or sums of them, in scaled units.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LargestDifferences {
    pub velocity: f64,
    pub angular_velocity: f64,
    pub force: f64,
    pub torque: f64,
}

impl LargestDifferences {
    /// Adds `factor` times other differences.
    pub fn add(&mut self, factor: f64, other: &Self) {
        self.velocity += factor * other.velocity;
        self.angular_velocity += factor * other.angular_velocity;
        self.force += factor * other.force;
        self.torque += factor * other.torque;
    }
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
        let powers = surfaces.map(|surfaces| surfaces.powers(&forces));
        let powers = powers.as_ref().map_or(&[][..], DVector::as_slice);
        let rates = surfaces.iter().flat_map(|surfaces| &surfaces.rates);
        Ok(Self {
            holding: drive.holding_loads(&forces, &generalised)?,
            slip_power: powers.first().copied().unwrap_or_default(),
            amplitudes: (rates.copied())
                .zip(powers.iter().skip(1).copied())
                .collect(),
            forces,
            generalised,
            residual: if scale > 0.0 { residual / scale } else { 0.0 },
        })
    }

    /// Largest differences between the motions and loads of a body in two solutions.
    pub fn largest_differences(&self, other: &Self, set: &Articulation) -> LargestDifferences {
        let difference = |of: fn(&Self) -> &DVector<f64>, rows: &mut dyn Iterator<Item = usize>| {
            let norms = rows.map(|k| (vector(of(self), k) - vector(of(other), k)).norm());
            norms.fold(0.0, f64::max)
        };
        let velocities: fn(&Self) -> &DVector<f64> = |solution| &solution.generalised;
        let forces: fn(&Self) -> &DVector<f64> = |solution| &solution.forces;
        let layout = set.velocity_layout();
        // Six rows per body with a surface, of which the last three are its angular velocity.
        let spins = set.surface_velocities().into_iter().skip(3).step_by(6);
        let loads = self.forces.len();
        let of_holding = |part: fn(&ExternalLoad) -> &Vector3<f64>| {
            let pairs = self.holding.iter().zip(&other.holding);
            let norms = pairs.map(|((_, a), (_, b))| (part(a) - part(b)).norm());
            norms.fold(0.0, f64::max)
        };
        LargestDifferences {
            velocity: difference(velocities, &mut layout.bodies().iter().copied()),
            angular_velocity: difference(velocities, &mut spins.into_iter()),
            force: difference(forces, &mut (0..loads).step_by(6))
                .max(of_holding(|load| &load.force)),
            torque: difference(forces, &mut (3..loads).step_by(6))
                .max(of_holding(|load| &load.torque)),
        }
    }

    /// Power of the bodies, their deformation and their slip on the fluid.
    pub fn power(&self, set: &Articulation) -> f64 {
        let velocities = self.generalised.select_rows(&set.surface_velocities());
        let of_deformation: f64 = self
            .amplitudes
            .iter()
            .map(|(rate, drive)| rate * drive)
            .sum();
        self.forces.dot(&velocities) + self.slip_power + of_deformation
    }

    /// Motion and loads at a time, in the scene's units.
    ///
    /// # Errors
    /// Joints that contradict each other; a solution for another set of bodies.
    pub fn response(
        &self,
        scaled: &ScaledScene,
        time: f64,
        constraints: &Constraints,
        loads: &[ExternalLoad],
    ) -> Result<Response, ModelError> {
        let to_scene = |response: ScaledResponse| scaled.response_to_scene(time, response);
        self.converted(&scaled.set, constraints, loads, to_scene)
    }

    /// Change of motion and loads without external loads, in the scene's units.
    ///
    /// # Errors
    /// As [`MobilitySolution::response`].
    pub fn change(
        &self,
        scaled: &ScaledScene,
        constraints: &Constraints,
    ) -> Result<Response, ModelError> {
        let no_loads = vec![ExternalLoad::default(); scaled.set.kinds().len()];
        let to_scene = |response: ScaledResponse| scaled.change_to_scene(response);
        self.converted(&scaled.set, constraints, &no_loads, to_scene)
    }

    fn converted(
        &self,
        set: &Articulation,
        constraints: &Constraints,
        loads: &[ExternalLoad],
        to_scene: impl FnOnce(ScaledResponse) -> Response,
    ) -> Result<Response, ModelError> {
        let drive = Drive {
            set,
            constraints,
            loads,
        };
        Ok(to_scene(ScaledResponse {
            motion: &set.state_velocity(self.generalised.as_slice())?,
            generalised: &self.generalised,
            forces: &self.forces,
            joint_loads: drive.joint_loads(&self.forces, &self.generalised)?,
            holding: self.holding.clone(),
            slip_power: self.slip_power,
            amplitudes: self.amplitudes.clone(),
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
    // All else is at rest, also bodies whose velocities are given.
    constraints.rates.fill(0.0);
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
