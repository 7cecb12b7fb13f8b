//! Solutions of models: motion and forces, with their error bars.

use mesh::{PointLocator, TetMesh};
use nalgebra::{UnitQuaternion, Vector3};
use rayon::prelude::*;
use rigid::StateVelocity;
use serde::{Deserialize, Serialize};
use stokes::{Checks, Dofs, Seconds, SolverReport};

use crate::discretisation_error::DiscretisationError;
use crate::error::ModelError;
use crate::error_estimate::ErrorEstimate;
use crate::hydrodynamics::Hydrodynamics;
use crate::remesh::Remesh;
use crate::stresslets::Stresslets;

/// Solution for one configuration and one set of joint rates, in the scene's units.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct InstantaneousSolution {
    /// One entry per body of the scene, in its order; points have zero force and torque.
    pub bodies: Vec<BodySolution>,
    /// One entry per joint of the scene: the force of the joint on the body named by its key
    /// `body`.
    ///
    /// The opposite force acts on the body named by its key `to`.
    pub joint_forces: Vec<Vector3<f64>>,
    /// Stresslets of the bodies, with their error bar; `None` for models that do not compute them
    /// and, where they cost an additional solve, for queries without
    /// [`Query::with_stresslets`](crate::Query::with_stresslets).
    pub stresslets: Option<Stresslets>,
    /// Rate of change of the state.
    pub motion: StateVelocity,
    /// Size of the linear system.
    pub dofs: Dofs,
    /// How the linear system was solved.
    pub solver: SolverReport,
    /// Computing times.
    pub seconds: Seconds,
    /// Power of the slip of the bodies on the fluid, beside that of their motion.
    pub slip_power: f64,
    /// Error bars of the velocities.
    pub error_estimate: ErrorEstimate,
    /// Error bars of the forces on the fluid.
    pub force_error: ErrorEstimate,
    /// Error bars of the power of the bodies on the fluid.
    pub power_error: ErrorEstimate,
    /// The estimated discretisation error that was subtracted, if estimates were requested.
    pub mesh_error: Option<DiscretisationError>,
    /// Comparison with independent computations, if estimates were requested.
    pub checks: Option<Checks>,
    /// Why this solution has a new mesh, or one moved by another method than before; `None` if a
    /// mesh was moved as before or not needed.
    pub remeshed: Option<Remesh>,
}

impl InstantaneousSolution {
    /// Creates a solution from motion and forces, without error bars, sizes and times.
    ///
    /// Shapes: `bodies` one entry per body of the scene, `joint_forces` one entry per joint.
    pub fn new(
        bodies: Vec<BodySolution>,
        joint_forces: Vec<Vector3<f64>>,
        motion: StateVelocity,
    ) -> Self {
        Self {
            bodies,
            joint_forces,
            stresslets: None,
            motion,
            dofs: Dofs::default(),
            solver: SolverReport::default(),
            seconds: Seconds::default(),
            slip_power: 0.0,
            error_estimate: ErrorEstimate::default(),
            force_error: ErrorEstimate::default(),
            power_error: ErrorEstimate::default(),
            mesh_error: None,
            checks: None,
            remeshed: None,
        }
    }

    /// Subtracts an estimated discretisation error, and enters the error bars that remain.
    pub fn correct(&mut self, error: DiscretisationError) {
        self.shift(&error, -1.0);
        self.set_mesh_error(error);
    }

    /// Enters an error that was subtracted before, and the error bars that remain.
    pub(crate) fn set_mesh_error(&mut self, error: DiscretisationError) {
        self.error_estimate.mesh = Some(error.velocity_error_bar());
        self.force_error.mesh = Some(error.force_error_bar());
        self.mesh_error = Some(error);
        let removed = self.uncorrected_power() - self.power();
        let error = self.mesh_error.as_ref();
        self.power_error.mesh = error.map(|error| error.power_error_bar(removed));
    }

    /// Motion and loads as they were computed, before the correction.
    #[must_use]
    pub fn uncorrected(&self) -> Self {
        let mut computed = self.clone();
        if let Some(error) = computed.mesh_error.take() {
            computed.shift(&error, 1.0);
        }
        if let Some(stresslets) = &mut computed.stresslets {
            stresslets.bodies.clone_from(&stresslets.uncorrected);
        }
        computed
    }

    /// Power of the bodies on the fluid before the correction.
    pub fn uncorrected_power(&self) -> f64 {
        self.uncorrected().power()
    }

    fn shift(&mut self, error: &DiscretisationError, factor: f64) {
        for (body, error) in self.bodies.iter_mut().zip(&error.bodies) {
            for (value, error) in body.vectors_mut().into_iter().zip(error.vectors()) {
                *value += factor * error;
            }
        }
        let forces = self.joint_forces.iter_mut().zip(&error.joint_forces);
        forces.for_each(|(force, error)| *force += factor * error);
        let frames = self.motion.frames.iter_mut().zip(&error.motion.frames);
        frames.for_each(|(frame, error)| *frame = *frame + *error * factor);
        let spins = self.motion.spins.iter_mut().zip(&error.motion.spins);
        spins.for_each(|(spin, error)| *spin += factor * error);
        let joints = self.motion.joints.iter_mut().zip(&error.motion.joints);
        joints.for_each(|(rate, error)| *rate += factor * error);
        self.slip_power += factor * error.slip_power;
    }

    /// Rotates all motions and loads, for a configuration that is rotated as a whole.
    pub fn rotate(&mut self, rotation: &UnitQuaternion<f64>) {
        let rotate = |vector: &mut Vector3<f64>| *vector = rotation * *vector;
        for_each_vector(
            &mut self.motion,
            &mut self.bodies,
            &mut self.joint_forces,
            rotate,
        );
        if let Some(stresslets) = &mut self.stresslets {
            stresslets.rotate(rotation);
        }
        if let Some(error) = &mut self.mesh_error {
            for_each_vector(
                &mut error.motion,
                &mut error.bodies,
                &mut error.joint_forces,
                rotate,
            );
        }
    }

    /// Power of the bodies on the fluid: of their motion and of their slip.
    pub fn power(&self) -> f64 {
        self.bodies.iter().map(BodySolution::power).sum::<f64>() + self.slip_power
    }

    /// Relative error bars of the forces and of the velocities, for the discretisation.
    ///
    /// They are relative to the largest force and the largest velocity, and zero if nothing was
    /// estimated or nothing moves.
    pub fn relative_mesh_errors(&self) -> [f64; 2] {
        let largest = |of: fn(&BodySolution) -> f64| self.bodies.iter().map(of).fold(0.0, f64::max);
        let over = |error: f64, size: f64| if size > 0.0 { error / size } else { 0.0 };
        [
            over(
                self.force_error.mesh.unwrap_or(0.0),
                largest(|body| body.force.norm()),
            ),
            over(
                self.error_estimate.mesh.unwrap_or(0.0),
                largest(|body| body.velocity.norm()),
            ),
        ]
    }

    /// Checks that the solution of a model has the bodies and linkages of its scene, and that all
    /// velocities and forces are finite.
    ///
    /// # Errors
    /// [`ModelError::WrongCount`], [`ModelError::NotFinite`].
    pub fn check(&self, model: &dyn Hydrodynamics) -> Result<(), ModelError> {
        let (scene, model) = (model.scene(), model.name());
        let (bodies, linkages) = (scene.bodies().len(), scene.articulation().linkages().len());
        for (what, found, expected) in [
            ("bodies", self.bodies.len(), bodies),
            ("angular velocities", self.motion.spins.len(), bodies),
            ("frames", self.motion.frames.len(), linkages),
        ] {
            if found != expected {
                return Err(ModelError::WrongCount {
                    model,
                    what,
                    found,
                    expected,
                });
            }
        }
        let finite = |v: &Vector3<f64>| v.iter().all(|c| c.is_finite());
        let motion = &self.motion;
        let moves = motion
            .frames
            .iter()
            .all(|f| finite(&f.linear) && finite(&f.angular))
            && motion.spins.iter().all(finite);
        let loads = self.bodies.iter().all(|b| {
            [b.velocity, b.angular_velocity, b.force, b.torque]
                .iter()
                .all(finite)
        }) && self.joint_forces.iter().all(finite);
        match (moves, loads) {
            (true, true) => Ok(()),
            (false, _) => Err(ModelError::NotFinite {
                model,
                what: "a velocity",
            }),
            (_, false) => Err(ModelError::NotFinite {
                model,
                what: "a body's velocity or force",
            }),
        }
    }
}

/// Applies `f` to all vectors of a motion and its loads.
pub(crate) fn for_each_vector(
    motion: &mut StateVelocity,
    bodies: &mut [BodySolution],
    joint_forces: &mut [Vector3<f64>],
    f: impl Fn(&mut Vector3<f64>),
) {
    for frame in &mut motion.frames {
        f(&mut frame.linear);
        f(&mut frame.angular);
    }
    motion.spins.iter_mut().for_each(&f);
    for body in bodies {
        body.vectors_mut().into_iter().for_each(&f);
    }
    joint_forces.iter_mut().for_each(&f);
}

/// Motion and load of one body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct BodySolution {
    /// Velocity of the centre.
    pub velocity: Vector3<f64>,
    /// Angular velocity.
    pub angular_velocity: Vector3<f64>,
    /// Force that the body exerts on the fluid.
    pub force: Vector3<f64>,
    /// Torque that the body exerts on the fluid, about its centre.
    pub torque: Vector3<f64>,
}

impl BodySolution {
    /// Velocity, angular velocity, force, torque.
    pub(crate) fn vectors(&self) -> [&Vector3<f64>; 4] {
        [
            &self.velocity,
            &self.angular_velocity,
            &self.force,
            &self.torque,
        ]
    }

    /// Velocity, angular velocity, force, torque.
    pub(crate) fn vectors_mut(&mut self) -> [&mut Vector3<f64>; 4] {
        [
            &mut self.velocity,
            &mut self.angular_velocity,
            &mut self.force,
            &mut self.torque,
        ]
    }

    /// Power of the body on the fluid: `F · U + T · ω`.
    pub fn power(&self) -> f64 {
        self.force.dot(&self.velocity) + self.torque.dot(&self.angular_velocity)
    }
}

/// Velocity and pressure at a point of the fluid, in the scene's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointFlow {
    /// Velocity.
    pub velocity: Vector3<f64>,
    /// Pressure; `None` for models that do not compute it.
    pub pressure: Option<f64>,
}

/// A velocity and pressure field on the nodes of a mesh, in the scene's units.
#[derive(Clone, Debug)]
pub struct FlowField {
    /// The mesh.
    pub mesh: TetMesh,
    /// Velocity at every node of the mesh.
    pub velocity: Vec<Vector3<f64>>,
    /// Pressure at every vertex of the mesh; empty for models that do not compute it.
    pub pressure: Vec<f64>,
}

impl FlowField {
    /// Velocity and pressure at points, interpolated as the elements are; `None` for a point
    /// outside the mesh.
    ///
    /// Cost: a box for each cell, and a hierarchy of those that meet the bounding box of the
    /// points.
    pub fn at(&self, points: &[Vector3<f64>]) -> Vec<Option<PointFlow>> {
        let infinite = Vector3::repeat(f64::INFINITY);
        let bounds = points.iter().fold([infinite, -infinite], |[min, max], x| {
            [min.inf(x), max.sup(x)]
        });
        let locator = PointLocator::within(&self.mesh, &bounds[0], &bounds[1]);
        let values = |x: &Vector3<f64>| {
            let found = locator.locate(x)?;
            let nodes = self.mesh.cells()[found.cell].map(|node| node as usize);
            let weighted = nodes.iter().zip(found.quadratic());
            let velocity = weighted.map(|(node, n)| n * self.velocity[*node]).sum();
            let vertices = nodes.iter().zip(found.barycentric);
            let pressure = (!self.pressure.is_empty())
                .then(|| vertices.map(|(node, l)| l * self.pressure[*node]).sum());
            Some(PointFlow { velocity, pressure })
        };
        points.par_iter().map(values).collect()
    }
}
