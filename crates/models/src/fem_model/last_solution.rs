//! The last solution of the finite-element model, for output and for adapted meshes.

use mesh::TetMesh;
use nalgebra::{Isometry3, Point3, Vector3};
use rigid::FlowSolution;
use stokes::Estimate;

use super::moving_frame::MovingFrame;
use crate::solution::FlowField;
use crate::surface_motion::SurfaceMotion;
use crate::units::Scale;

/// The last solution, in scaled units.
pub(super) struct Last {
    pub(super) mesh: TetMesh,
    pub(super) poses: Vec<Isometry3<f64>>,
    pub(super) flow: FlowSolution,
    /// Motion of the surfaces; `flow` is the disturbance of the background flow.
    pub(super) motion: Option<SurfaceMotion>,
    /// The frame of mesh and flow, if it moves.
    pub(super) frame: Option<MovingFrame>,
    /// Its error estimate, until it is used to adapt the mesh.
    pub(super) estimate: Option<Estimate>,
}

impl Last {
    /// The flow with the background flow, in the units of the scene and the laboratory frame.
    pub(super) fn flow_field(&self, scale: &Scale) -> Option<FlowField> {
        let Self {
            mesh,
            flow,
            motion,
            frame,
            ..
        } = self;
        let background = |node: usize| {
            let of_node = |motion: &SurfaceMotion| motion.background(&mesh.points()[node]);
            motion.as_ref().map_or_else(Vector3::zeros, of_node)
        };
        let background_pressure = |node: usize| {
            let of_node = |motion: &SurfaceMotion| motion.background_pressure(&mesh.points()[node]);
            motion.as_ref().map_or(0.0, of_node)
        };
        // A mesh that ends at symmetry planes is unfolded to the whole domain.
        let whole = scale.mesh_to_scene(mesh).ok()?.unfolded().ok()?;
        let velocity = whole.sources.iter().map(|(node, signs)| {
            let node = *node as usize;
            let velocity = flow.velocity[node] + background(node);
            scale.velocity_to_scene(velocity.component_mul(signs))
        });
        let of_vertices = whole.sources.iter().take(whole.mesh.n_vertices());
        let pressure = of_vertices.map(|(vertex, _)| {
            let vertex = *vertex as usize;
            flow.pressure[vertex] + background_pressure(vertex)
        });
        let mut field = FlowField {
            velocity: velocity.collect(),
            pressure: pressure.map(|p| scale.pressure_to_scene(p)).collect(),
            mesh: whole.mesh,
        };
        if let Some(frame) = frame {
            let (rotation, to_laboratory) = (frame.rotation(), frame.to_laboratory(1.0));
            let points = field.mesh.points().iter();
            let points = points
                .map(|x| to_laboratory * Point3::from(*x))
                .map(|x| x.coords);
            field.mesh = field.mesh.with_points(points.collect()).ok()?;
            field.velocity.iter_mut().for_each(|u| *u = rotation * *u);
        }
        Some(field)
    }
}
