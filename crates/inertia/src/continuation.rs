//! What an integration remembers between steps, to go on in another process.

use crate::error::check_length;
use crate::integrator::LEVELS;
use crate::step::Level;
use crate::{InertiaError, Integrator, SuppliedMesh};

/// What the steps of an [`Integrator`] depend on besides its problem and the connectivity of its
/// mesh.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
pub struct IntegratorState {
    levels: Vec<Level>,
    largest: [f64; 2],
}

/// Largest deviation from 1 of the norm of a quaternion, for those that differ by rounding alone.
const UNIT_TOLERANCE: f64 = 1e-9;

impl IntegratorState {
    /// The present time.
    pub fn time(&self) -> Option<f64> {
        self.levels.first().map(|level| level.time)
    }
}

impl Integrator<'_> {
    /// What the next steps depend on.
    ///
    /// Earlier solutions, from which linear solves start, are forgotten: this integrator goes on
    /// with the same bits as one that continues from the result.
    pub fn remembered(&mut self) -> IntegratorState {
        self.warm.clear();
        IntegratorState {
            levels: self.levels.clone(),
            largest: self.largest,
        }
    }

    /// Continues from what an integrator of the same problem remembered.
    ///
    /// `mesh` has the connectivity of its mesh, whatever the positions of the nodes;
    /// [`Meshes::mesh`](crate::Meshes::mesh) must move that one from now on.
    /// [`Integrator::last_jump`] is not remembered.
    ///
    /// # Errors
    /// Levels that do not fit the problem or the mesh; a mesh with an inverted cell.
    pub fn continue_from(
        &mut self,
        state: IntegratorState,
        mesh: SuppliedMesh,
    ) -> Result<(), InertiaError> {
        let IntegratorState { levels, largest } = state;
        let Some(present) = levels.first().filter(|_| levels.len() <= LEVELS) else {
            return Err(InertiaError::OutOfRange {
                what: "the number of levels",
                value: levels.len() as f64,
                range: "between 1 and 3",
            });
        };
        let (mesh, space) = mesh.with_space()?;
        for level in &levels {
            level.check_like(&self.levels[0], mesh.n_points())?;
        }
        let ordered = levels.is_sorted_by(|newer, older| newer.time > older.time);
        if !ordered || !largest.into_iter().all(|speed| speed >= 0.0) {
            return Err(InertiaError::OutOfRange {
                what: "the time or the largest speed of a level",
                value: present.time,
                range: "after those of older levels, with speeds that are zero or positive",
            });
        }
        self.mesh = mesh.with_points(present.points.clone())?;
        self.space = space;
        self.levels = levels;
        self.largest = largest;
        self.jump = None;
        self.warm.clear();
        Ok(())
    }
}

impl Level {
    /// Refuses a level whose numbers of values differ from those of `other` or of so many nodes, or
    /// whose quaternions are no rotations.
    fn check_like(&self, other: &Self, nodes: usize) -> Result<(), InertiaError> {
        check_length("positions of nodes", nodes, self.points.len())?;
        check_length("velocities of nodes", nodes, self.velocity.len())?;
        let lists = |level: &Self| {
            [
                level.state.frames.len(),
                level.state.attitudes.len(),
                level.state.joints.len(),
                level.shape.len(),
                level.generalised.len(),
                level.momenta.len(),
            ]
        };
        for (expected, found) in lists(other).into_iter().zip(lists(self)) {
            check_length("values of bodies and joints", expected, found)?;
        }
        for velocity in [Some(&self.rate), self.increment.as_ref()]
            .into_iter()
            .flatten()
        {
            for (expected, found) in [
                (other.rate.frames.len(), velocity.frames.len()),
                (other.rate.spins.len(), velocity.spins.len()),
                (other.rate.joints.len(), velocity.joints.len()),
            ] {
                check_length("velocities of frames and joints", expected, found)?;
            }
        }
        let frames = self.state.frames.iter().map(|frame| frame.rotation);
        let mut rotations = frames.chain(self.state.attitudes.iter().copied());
        let is_unit = |norm: f64| (norm - 1.0).abs() <= UNIT_TOLERANCE;
        match rotations.find(|rotation| !is_unit(rotation.norm())) {
            None => Ok(()),
            Some(rotation) => Err(InertiaError::OutOfRange {
                what: "the norm of a quaternion",
                value: rotation.norm(),
                range: "1",
            }),
        }
    }
}
