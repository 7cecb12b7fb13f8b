//! Velocity constraints of links, clamps and fixed bodies: the rows of `C q = w`.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::error::check_length;
use crate::{Arms, Articulation, BodyKind, RigidError, State, StateVelocity, Twist};

/// Positions of the velocities of bodies and frames in the vector of generalised velocities `q`.
///
/// Order: the bodies one after the other (rigid: `U`, `ω`; point: `U`), then the angular velocity
/// of the frame of each linkage of two or more bodies, unless arms keep their direction
/// ([`Arms::Lab`]).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VelocityLayout {
    bodies: Vec<usize>,
    frames: Vec<Option<usize>>,
    len: usize,
}

impl VelocityLayout {
    /// Number of generalised velocities.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no generalised velocities.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Index of the first velocity component of a body; for a rigid body `ω` follows `U`.
    ///
    /// `None` for a body that does not exist.
    pub fn body(&self, body: usize) -> Option<usize> {
        self.bodies.get(body).copied()
    }

    /// Index of the first component of a frame's angular velocity, if the frame has its own.
    pub fn frame(&self, linkage: usize) -> Option<usize> {
        self.frames.get(linkage).copied().flatten()
    }

    /// Index of the first velocity component of each body.
    pub fn bodies(&self) -> &[usize] {
        &self.bodies
    }
}

/// The velocity constraints `C q = w` of an articulated set in one configuration.
///
/// A link of length `l` and direction `e` from `to` to `body`, on a frame of angular velocity `Ω`:
/// `U_body - U_to - Ω × (x_body - x_to) = (dl/dt) e`. A body clamped to its arms: `ω_i - Ω = 0`. A
/// fixed body: `U_i = 0`, `ω_i = 0`. With [`Arms::Lab`], `Ω = 0` and the rows of links are equation
/// (11) of Berti et al. (2021).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Constraints {
    /// `C`, one row per scalar constraint.
    pub matrix: DMatrix<f64>,
    /// `w`, one entry per row.
    pub rates: DVector<f64>,
    /// Name of each row for messages: that of its link or body.
    pub labels: Vec<String>,
    /// Meaning of the columns.
    pub layout: VelocityLayout,
    /// Vector of each link, `x_body - x_to`.
    pub(crate) link_vectors: Vec<Vector3<f64>>,
    /// Position of each rigid body.
    pub(crate) rigid_positions: Vec<Vector3<f64>>,
}

impl Constraints {
    /// The same constraints with all fixed bodies of the set `set` in translation at `velocity`.
    ///
    /// In a frame that moves with a uniform flow, bodies that are fixed in space have the opposite
    /// velocity.
    ///
    /// # Errors
    /// [`RigidError::OtherSet`] for constraints of another set, [`RigidError::NotFinite`].
    pub fn with_fixed_velocity(
        mut self,
        set: &Articulation,
        velocity: Vector3<f64>,
    ) -> Result<Self, RigidError> {
        self.check()?;
        if self.layout != set.velocity_layout() {
            return Err(RigidError::OtherSet);
        }
        if velocity.iter().any(|v| !v.is_finite()) {
            return Err(RigidError::NotFinite {
                what: "the velocity of the fixed bodies",
            });
        }
        let fixed = set.fixed().iter().filter(|&&fixed| fixed).count();
        // The rows of the fixed bodies are the last ones.
        let first = self.rates.len().checked_sub(6 * fixed);
        let first = first.ok_or(RigidError::OtherSet)?;
        for body in 0..fixed {
            (self.rates.fixed_rows_mut::<3>(first + 6 * body)).copy_from(&velocity);
        }
        Ok(self)
    }

    /// Refuses public fields that were changed so that they no longer fit each other.
    ///
    /// # Errors
    /// [`RigidError::OtherSet`] for another number of rows or columns, [`RigidError::NotFinite`].
    pub(crate) fn check(&self) -> Result<(), RigidError> {
        let (rows, columns) = self.matrix.shape();
        let fits = [self.rates.len(), self.labels.len(), self.layout.len];
        if fits != [rows, rows, columns] {
            return Err(RigidError::OtherSet);
        }
        let mut entries = self.matrix.iter().chain(self.rates.iter());
        if !entries.all(|entry| entry.is_finite()) {
            return Err(RigidError::NotFinite {
                what: "a constraint",
            });
        }
        Ok(())
    }
}

impl Articulation {
    /// Positions of all velocities in the vector of generalised velocities.
    pub fn velocity_layout(&self) -> VelocityLayout {
        let mut len = 0;
        let bodies = self
            .kinds()
            .iter()
            .map(|kind| {
                let first = len;
                len += if *kind == BodyKind::Rigid { 6 } else { 3 };
                first
            })
            .collect();
        let frames = self
            .linkages()
            .iter()
            .map(|linkage| {
                (self.arms() != Arms::Lab && linkage.bodies.len() > 1).then(|| {
                    len += 3;
                    len - 3
                })
            })
            .collect();
        VelocityLayout {
            bodies,
            frames,
            len,
        }
    }

    /// Indices of the generalised velocities `(U, ω)` of bodies with surfaces, six per body.
    pub fn surface_velocities(&self) -> Vec<usize> {
        let layout = self.velocity_layout();
        (0..self.kinds().len())
            .filter(|&body| self.kinds()[body] == BodyKind::Rigid)
            .flat_map(|body| layout.bodies[body]..layout.bodies[body] + 6)
            .collect()
    }

    /// The constraints in one configuration, where the lengths change at `rates` (one per link).
    ///
    /// # Errors
    /// Arrays whose lengths do not fit the set, a rate that is not finite, lengths that
    /// [`Articulation::place`] refuses.
    pub fn constraints(
        &self,
        state: &State,
        lengths: &[f64],
        rates: &[f64],
    ) -> Result<Constraints, RigidError> {
        check_length("rates of the links", rates.len(), self.links().len())?;
        if rates.iter().any(|r| !r.is_finite()) {
            return Err(RigidError::NotFinite {
                what: "the rate of a link",
            });
        }
        let poses = self.place(state, lengths)?;
        let layout = self.velocity_layout();
        let clamped_bodies: Vec<usize> = (0..self.kinds().len())
            .filter(|&body| {
                self.arms() == Arms::Clamped
                    && self.kinds()[body] == BodyKind::Rigid
                    && layout.frame(self.linkage_of()[body]).is_some()
            })
            .collect();
        let fixed_bodies: Vec<usize> = (0..self.kinds().len())
            .filter(|&body| self.fixed()[body])
            .collect();
        let moving_rows = 3 * (self.links().len() + clamped_bodies.len());
        let rows = moving_rows + 6 * fixed_bodies.len();
        let mut matrix = DMatrix::zeros(rows, layout.len());
        let mut rhs = DVector::zeros(rows);
        let mut labels = Vec::with_capacity(rows);
        let mut link_vectors = Vec::with_capacity(self.links().len());
        let identity = Matrix3::<f64>::identity();
        for (number, link) in self.links().iter().enumerate() {
            let row = 3 * number;
            matrix
                .fixed_view_mut::<3, 3>(row, layout.bodies[link.body])
                .copy_from(&identity);
            matrix
                .fixed_view_mut::<3, 3>(row, layout.bodies[link.to])
                .copy_from(&-identity);
            let arm = poses[link.body].translation.vector - poses[link.to].translation.vector;
            link_vectors.push(arm);
            if let Some(frame) = layout.frame(self.linkage_of()[link.body]) {
                // -Ω × arm = [arm]_× Ω
                matrix
                    .fixed_view_mut::<3, 3>(row, frame)
                    .copy_from(&arm.cross_matrix());
            }
            rhs.fixed_rows_mut::<3>(row)
                .copy_from(&(rates[number] * self.rotated_direction(state, number)));
            labels.extend(std::iter::repeat_n(link.name.clone(), 3));
        }
        for (number, &body) in clamped_bodies.iter().enumerate() {
            let row = 3 * (self.links().len() + number);
            matrix
                .fixed_view_mut::<3, 3>(row, layout.bodies[body] + 3)
                .copy_from(&identity);
            if let Some(frame) = layout.frame(self.linkage_of()[body]) {
                matrix
                    .fixed_view_mut::<3, 3>(row, frame)
                    .copy_from(&-identity);
            }
            labels.extend(std::iter::repeat_n(format!("clamp of body {body}"), 3));
        }
        for (number, &body) in fixed_bodies.iter().enumerate() {
            matrix
                .fixed_view_mut::<6, 6>(moving_rows + 6 * number, layout.bodies[body])
                .fill_with_identity();
            labels.extend(std::iter::repeat_n(format!("fixed body {body}"), 6));
        }
        Ok(Constraints {
            matrix,
            rates: rhs,
            labels,
            layout,
            link_vectors,
            rigid_positions: (poses.iter().zip(self.kinds()))
                .filter(|(_, kind)| **kind == BodyKind::Rigid)
                .map(|(pose, _)| pose.translation.vector)
                .collect(),
        })
    }

    /// Rate of change of the state for generalised velocities `q`.
    ///
    /// # Errors
    /// A `q` of the wrong length.
    pub fn state_velocity(&self, q: &[f64]) -> Result<StateVelocity, RigidError> {
        let layout = self.velocity_layout();
        check_length("generalised velocities", q.len(), layout.len())?;
        let at = |first: usize| Vector3::new(q[first], q[first + 1], q[first + 2]);
        let frame_spin =
            |linkage: usize| match (layout.frame(linkage), &self.linkages()[linkage].bodies[..]) {
                (Some(frame), _) => at(frame),
                // The frame of a body without links rotates with the body.
                (None, &[body]) if self.kinds()[body] == BodyKind::Rigid => {
                    at(layout.bodies[body] + 3)
                }
                (None, _) => Vector3::zeros(),
            };
        Ok(StateVelocity {
            frames: self
                .linkages()
                .iter()
                .enumerate()
                .map(|(number, linkage)| Twist {
                    linear: at(layout.bodies[linkage.root]),
                    angular: frame_spin(number),
                })
                .collect(),
            spins: (0..self.kinds().len())
                .map(|body| match self.kinds()[body] {
                    BodyKind::Rigid => at(layout.bodies[body] + 3),
                    BodyKind::Point => frame_spin(self.linkage_of()[body]),
                })
                .collect(),
        })
    }
}
