//! New meshes during an integration.

use mesh::TetMesh;
use nalgebra::{Isometry3, Vector3};
use rigid::BodyKind;
use stokes::SurfaceFlow;

use crate::bodies::SlipAt;
use crate::projection::project;
use crate::step::Level;
use crate::{InertiaError, Integrator};

impl Integrator<'_> {
    /// Velocities of a level at the nodes of bodies and walls of another mesh; zero at other nodes.
    ///
    /// Slip and arms of all levels are those at the present poses: only then has no level a net
    /// flux through the surfaces of the new mesh.
    fn boundary_velocity(
        &self,
        mesh: &TetMesh,
        poses: &[Isometry3<f64>],
        level: &Level,
    ) -> Result<Vec<Vector3<f64>>, InertiaError> {
        let mut velocity = vec![Vector3::zeros(); mesh.n_points()];
        if self.forcing.has_moving_walls() {
            for part in &self.bodies.walls {
                for node in mesh.nodes_on(mesh.tag(part)?) {
                    let x = &mesh.points()[node as usize];
                    velocity[node as usize] = self.forcing.wall_velocity(level.time, x);
                }
            }
        }
        let (set, layout) = (self.bodies.set, self.bodies.set.velocity_layout());
        let surfaced = self.bodies.surfaced(poses);
        let slip = self.forcing.has_slip().then_some(SlipAt {
            forcing: self.forcing,
            time: level.time,
            poses: &surfaced,
        });
        let rigid = (set.kinds().iter().enumerate())
            .filter(|(_, kind)| **kind == BodyKind::Rigid)
            .map(|(body, _)| body);
        for (surface, (part, body)) in self.bodies.surfaces.iter().zip(rigid).enumerate() {
            let Some(first) = layout.body(body) else {
                continue;
            };
            let generalised = &level.generalised;
            let linear = Vector3::from_column_slice(&generalised[first..first + 3]);
            let angular = Vector3::from_column_slice(&generalised[first + 3..first + 6]);
            for node in mesh.nodes_on(mesh.tag(part)?) {
                let x = &mesh.points()[node as usize];
                let arm = x - poses[body].translation.vector;
                let relative = slip.as_ref().map(|slip| slip.slip(surface, x));
                velocity[node as usize] =
                    linear + angular.cross(&arm) + relative.unwrap_or_default();
            }
        }
        for (node, axes) in mesh.nodes_on_symmetry_planes() {
            for axis in (0..3).filter(|&axis| axes[axis]) {
                velocity[node as usize][axis] = 0.0;
            }
        }
        Ok(velocity)
    }

    /// Replaces the mesh by a new one at the present time; `false` if there is none.
    ///
    /// The velocities of all levels are projected onto it, divergence-free and with the motions of
    /// the bodies; earlier positions of its nodes are those of the old mesh there.
    ///
    /// # Errors
    /// A mesh of another domain, those of the projection.
    pub fn renew_mesh(&mut self) -> Result<bool, InertiaError> {
        let poses = self.poses()?;
        let Some(new) = self
            .meshes
            .renew(self.time(), &self.bodies.surfaced(&poses))?
        else {
            return Ok(false);
        };
        let (new, space) = new.with_space()?;
        let old = self.mesh.clone();
        let parts = self.bodies.surfaces.iter().chain(&self.bodies.walls);
        let boundary_parts: Vec<&str> = parts.map(String::as_str).collect();
        let mut levels = self.levels.clone();
        let mut jumps = Vec::new();
        for level in &mut levels {
            let displaced: Vec<Vector3<f64>> = level
                .points
                .iter()
                .zip(old.points())
                .map(|(x, now)| x - now)
                .collect();
            let at_nodes = |field: &[Vector3<f64>]| at_points(&old, field, new.points());
            let boundary = self.boundary_velocity(&new, &poses, level)?;
            let options = &self.parameters.options;
            let (velocity, jump) = project(
                (&old, &level.velocity),
                &new,
                &space,
                &boundary_parts,
                &boundary,
                options.rtol,
            )?;
            let displaced = at_nodes(&displaced)?;
            level.points = new
                .points()
                .iter()
                .zip(displaced)
                .map(|(x, d)| x + d)
                .collect();
            level.velocity = velocity;
            jumps.push(jump);
        }
        self.levels = levels;
        self.jump = jumps.first().copied();
        self.mesh = new;
        self.space = space;
        self.warm.clear();
        Ok(true)
    }
}

/// Values of a field at points, those slightly outside by the nearest cell.
fn at_points(
    mesh: &TetMesh,
    field: &[Vector3<f64>],
    points: &[Vector3<f64>],
) -> Result<Vec<Vector3<f64>>, InertiaError> {
    let values = fem::evaluate(mesh, field, points)?;
    Ok(values.into_iter().map(|(value, _)| value).collect())
}
