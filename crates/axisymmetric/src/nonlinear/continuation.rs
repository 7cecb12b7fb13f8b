//! What an integration remembers between steps, to go on in another process.

use super::bodies::check_length;
use super::flow_transfer::Level;
use super::integrator::{AxialIntegrator, LEVELS, system_around};
use super::mesh_motion::MeshMotion;
use crate::AxisymmetricError;

/// What the steps of an [`AxialIntegrator`] depend on besides its problem.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
pub struct AxialState {
    /// Centres of the bodies, and displacements that the forcing gave to them, when the mesh was
    /// generated.
    centres: Vec<f64>,
    start: Vec<f64>,
    levels: Vec<Level>,
    largest: f64,
    momentum_jump: Option<f64>,
    meshes: usize,
}

impl AxialIntegrator<'_> {
    /// What the next steps depend on.
    ///
    /// Factors of matrices of earlier steps are forgotten: this integrator goes on with the same
    /// bits as one that continues from the result.
    pub fn remembered(&mut self) -> AxialState {
        self.factors = None;
        AxialState {
            centres: (self.bodies.iter()).map(|body| body.shape.centre).collect(),
            start: self.start.clone(),
            levels: self.levels.clone(),
            largest: self.largest,
            momentum_jump: self.momentum_jump,
            meshes: self.meshes,
        }
    }

    /// Continues from what an integrator of the same problem remembered, on the same mesh.
    ///
    /// # Errors
    /// Lists that do not fit the problem or the mesh, times out of order; centres around which
    /// there is no mesh.
    pub fn continue_from(&mut self, state: AxialState) -> Result<(), AxisymmetricError> {
        let (n_bodies, n_motions) = (self.bodies.len(), self.levels[0].displacements.len());
        check_length("centres of bodies", n_bodies, state.centres.len())?;
        check_length("displacements of bodies", n_bodies, state.start.len())?;
        let bodies = self.bodies_at(&state.centres);
        let system = system_around(&bodies, self.surroundings, &self.parameters)?;
        let (nodes, rest) = (system.positions().len(), system.rest());
        for level in &state.levels {
            let Level { fields, .. } = level;
            for (what, expected, found) in [
                ("positions of nodes", nodes, level.nodes.len()),
                ("velocities", rest.velocity.len(), fields.velocity.len()),
                ("pressures", rest.pressure.len(), fields.pressure.len()),
                ("velocities of motions", n_motions, fields.motions.len()),
                ("displacements", n_motions, level.displacements.len()),
                ("given displacements", n_bodies, level.given.len()),
                ("velocities of bodies", n_bodies, level.velocities.len()),
            ] {
                check_length(what, expected, found)?;
            }
        }
        let levels = &state.levels;
        let ordered = levels.is_sorted_by(|newer, older| newer.time > older.time);
        let is_speed = state.largest >= 0.0;
        if !(1..=LEVELS).contains(&levels.len()) || !ordered || !is_speed {
            return Err(AxisymmetricError::InvalidNumber {
                what: "the number of levels in the order of their times",
                value: levels.len() as f64,
                range: "between 1 and 3, with a largest speed that is zero or positive",
            });
        }
        self.motion = MeshMotion::new(&system, n_bodies)?;
        (self.system, self.bodies) = (system, bodies);
        self.start = state.start;
        self.levels = state.levels;
        self.factors = None;
        self.largest = state.largest;
        self.momentum_jump = state.momentum_jump;
        self.meshes = state.meshes;
        Ok(())
    }
}
