//! Answers of the elements in the scene's units.

use nalgebra::{Isometry3, Vector3};
use rigid::Twist;
use stokes::{Estimate, Solution};

use super::FemModel;
use super::far_field::FarField;
use crate::error_estimate::ErrorEstimate;
use crate::mesh_error::MeshError;
use crate::remesh::Remesh;
use crate::solution::{BodySolution, InstantaneousSolution};

impl FemModel {
    /// A solved flow in the scene's units.
    pub(super) fn in_scene_units(
        &self,
        solved: &Solution,
        remeshed: Option<Remesh>,
        poses: &[Isometry3<f64>],
    ) -> InstantaneousSolution {
        let (scale, set) = (&self.scaled.scale, &self.scaled.set);
        let flow = &solved.flow;
        let mut bodies = vec![BodySolution::default(); set.kinds().len()];
        let layout = set.velocity_layout();
        let at = |first: usize| Vector3::from_fn(|axis, _| flow.generalised[first + axis]);
        for (body, entry) in bodies.iter_mut().enumerate() {
            entry.velocity = scale.velocity_back(at(layout.body(body)));
            entry.angular_velocity = flow.state.spins[body];
        }
        for (number, body) in self.meshes.surfaced_bodies().enumerate() {
            let part =
                |first: usize| Vector3::from_fn(|axis, _| flow.forces[6 * number + first + axis]);
            bodies[body].force = scale.force_back(part(0));
            bodies[body].torque = scale.torque_back(part(3));
        }
        let link_forces = (0..set.links().len())
            .map(|link| scale.force_back(flow.link_force(link)))
            .collect();
        let speed = largest(bodies.iter().map(|b| b.velocity));
        let container = self.meshes.container_error(poses);
        InstantaneousSolution {
            bodies,
            link_forces,
            motion: scale.motion_back(&flow.state),
            dofs: solved.dofs,
            // A container of the scene's own is no error, and nothing of Stokes flow is left out.
            error_estimate: ErrorEstimate {
                container: Some(container * speed),
                model: Some(0.0),
                algebraic: Some(solved.algebraic_error * speed),
                ..ErrorEstimate::default()
            },
            mesh_error: None,
            checks: solved.checks,
            solver: solved.solver.clone(),
            seconds: solved.seconds,
            remeshed,
        }
    }

    /// Adds what the wall that stands for infinity took from all velocities.
    pub(super) fn add_taken(&self, far: FarField, flow: &mut rigid::FlowSolution) {
        let set = &self.scaled.set;
        let entry = |body: usize, axis: usize| flow.forces[6 * body + axis];
        let forces = (0..flow.forces.len() / 6)
            .map(|body| Vector3::from_fn(|axis, _| entry(body, axis)))
            .sum();
        let taken = far.taken(forces);
        flow.velocity.iter_mut().for_each(|u| *u += taken);
        let layout = set.velocity_layout();
        for body in 0..set.kinds().len() {
            let mut velocity = flow.generalised.fixed_rows_mut::<3>(layout.body(body));
            velocity += taken;
        }
        for frame in &mut flow.state.frames {
            frame.linear += taken;
        }
        for body in 0..flow.bodies.len() / 6 {
            let mut velocity = flow.bodies.fixed_rows_mut::<3>(6 * body);
            velocity += taken;
        }
    }

    /// Enters estimated errors into an instant in the scene's units.
    pub(super) fn enter_errors(
        &self,
        instant: &mut InstantaneousSolution,
        estimate: &Estimate,
        poses: &[Isometry3<f64>],
    ) {
        let (scale, set) = (&self.scaled.scale, &self.scaled.set);
        let mut by_mesh = vec![Vector3::zeros(); poses.len()];
        for (linkage, frame) in set.linkages().iter().zip(&estimate.frames) {
            for &body in &linkage.bodies {
                let [at, root] = [body, linkage.root].map(|b| poses[b].translation.vector);
                let error = frame.linear + frame.angular.cross(&(at - root));
                by_mesh[body] = scale.velocity_back(error);
            }
        }
        let uncertainty = scale.speed_back(estimate.uncertainty);
        instant.error_estimate.mesh = Some(largest(by_mesh.iter().copied()).hypot(uncertainty));
        instant.mesh_error = Some(MeshError {
            frames: estimate
                .frames
                .iter()
                .map(|frame| Twist {
                    linear: scale.velocity_back(frame.linear),
                    angular: frame.angular,
                })
                .collect(),
            bodies: by_mesh,
            uncertainty,
            // Where no link holds, forces are the loads.
            forces: if set.links().is_empty() {
                vec![Vector3::zeros(); instant.bodies.len()]
            } else {
                let forces = instant.bodies.iter().map(|b| b.force);
                forces
                    .map(|force| estimate.relative_energy * force)
                    .collect()
            },
        });
    }
}

/// The largest of their norms.
fn largest(vectors: impl Iterator<Item = Vector3<f64>>) -> f64 {
    vectors.fold(0.0, |m, v| m.max(v.norm()))
}
