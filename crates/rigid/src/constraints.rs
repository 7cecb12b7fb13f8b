//! Velocity constraints of joints, clamps and held bodies: the rows of `C q = w`.

use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector3};

use crate::error::{check_finite, check_length};
use crate::placement::Placement;
use crate::{
    Arms, Articulation, BodyKind, RigidError, State, StateVelocity, Twist, VelocityLayout,
};

/// The velocity constraints `C q = w` of an articulated set in one configuration.
///
/// With `Ω` and `Ω'` the angular velocities of the frames of `to` and `body`, and the rate `dv/dt`
/// of the joint:
///
/// ```text
/// slide along e:   U_body - U_to - Ω × (x_body - x_to) = (dv/dt) e
/// turn about a:    U_body + Ω' × (p - x_body) - U_to - Ω × (p - x_to) = h (dv/dt) a
///                  Ω' - Ω = (dv/dt) a
/// ```
///
/// with the pivot `p` and the advance `h`. A fixed joint is a slide, a ball a turn without the
/// second row, both with the rate zero. The rate of a passive joint is one of the velocities `q`. A
/// body clamped to its arms: `ω_i - Ω = 0`. A held body: `U_i` or `ω_i` is given. With
/// [`Arms::Lab`], `Ω = 0` and the rows of joints are equation (11) of Berti et al. (2021).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Constraints {
    /// `C`, one row per scalar constraint.
    pub matrix: DMatrix<f64>,
    /// `w`, one entry per row.
    pub rates: DVector<f64>,
    /// Name of each row for messages: that of its joint or body.
    pub labels: Vec<String>,
    /// Meaning of the columns.
    pub layout: VelocityLayout,
    /// Forces of the drives on the passive joints, without those of dashpots.
    pub joint_forces: Vec<f64>,
    /// Coefficients of the dashpots of the passive joints.
    pub joint_damping: Vec<f64>,
    /// Rigid bodies with a resistance in addition to that of the fluid, in the laboratory axes:
    /// masses over time steps. Empty by default.
    pub body_damping: Vec<(usize, Matrix6<f64>)>,
    /// Loads conjugate to the generalised velocities, in addition to those of bodies and joints:
    /// random forces of the fluid. None by default.
    pub random_loads: Option<DVector<f64>>,
    /// Rows of each joint.
    pub(crate) joint_rows: Vec<JointRows>,
    /// Rows of the held bodies.
    pub(crate) held_rows: Vec<HeldRows>,
    /// Position of each rigid body.
    pub(crate) rigid_positions: Vec<Vector3<f64>>,
}

impl Constraints {
    /// The same constraints with a given velocity of a held body, in place of zero; the part that
    /// is not held has no effect.
    ///
    /// # Errors [`RigidError::HeldBody`] for a body that is not held, [`RigidError::OtherSet`] for
    /// fields that were changed, [`RigidError::NotFinite`].
    pub fn with_held_velocity(mut self, body: usize, velocity: Twist) -> Result<Self, RigidError> {
        self.check()?;
        let mut rows = self
            .held_rows
            .iter()
            .filter(|rows| rows.body == body)
            .peekable();
        if rows.peek().is_none() {
            let problem = "its velocity is determined by the flow";
            return Err(RigidError::HeldBody { body, problem });
        }
        for rows in rows {
            let given = match rows.is_rotation {
                true => velocity.angular,
                false => velocity.linear,
            };
            check_finite("the velocity of a held body", &given)?;
            self.rates.fixed_rows_mut::<3>(rows.first).copy_from(&given);
        }
        Ok(self)
    }

    /// The same constraints, with a velocity added to those of all bodies whose translation is
    /// held.
    ///
    /// In a frame that moves with a uniform flow, bodies have the opposite velocity in addition to
    /// their own.
    ///
    /// # Errors
    /// [`RigidError::OtherSet`] for fields that were changed, [`RigidError::NotFinite`].
    pub fn with_added_velocity(mut self, velocity: Vector3<f64>) -> Result<Self, RigidError> {
        self.check()?;
        check_finite("the velocity of the held bodies", &velocity)?;
        for held in self.held_rows.iter().filter(|held| !held.is_rotation) {
            let mut rows = self.rates.fixed_rows_mut::<3>(held.first);
            rows += velocity;
        }
        Ok(self)
    }

    /// Refuses public fields that were changed so that they no longer fit each other.
    ///
    /// # Errors
    /// [`RigidError::OtherSet`] for another number of rows or columns, [`RigidError::NotFinite`].
    pub(crate) fn check(&self) -> Result<(), RigidError> {
        let (rows, columns) = self.matrix.shape();
        let held_end = self.held_rows.iter().map(|held| held.first + 3).max();
        if held_end.is_some_and(|end| end > rows) {
            return Err(RigidError::OtherSet);
        }
        let fits = [self.rates.len(), self.labels.len(), self.layout.len()];
        let joints = [self.joint_forces.len(), self.joint_damping.len()];
        let is_rigid = |(body, _): &(usize, _)| self.layout.is_rigid(*body);
        if !self.body_damping.iter().all(is_rigid) {
            return Err(RigidError::OtherSet);
        }
        if fits != [rows, rows, columns] || joints != [self.layout.joints().count(); 2] {
            return Err(RigidError::OtherSet);
        }
        let random = self.random_loads.iter();
        if random.clone().any(|loads| loads.len() != columns) {
            return Err(RigidError::OtherSet);
        }
        let entries = (self.matrix.iter())
            .chain(random.flatten())
            .chain(self.rates.iter())
            .chain(&self.joint_forces)
            .chain(&self.joint_damping)
            .chain(self.body_damping.iter().flat_map(|(_, block)| block));
        check_finite("a constraint", entries)
    }
}

/// Load of a joint, which balances its two bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct JointLoad {
    /// Force on `body`; the opposite force acts on `to`. It acts at the pivot of joints that turn.
    pub force: Vector3<f64>,
    /// Torque on `body` about the pivot; the opposite torque acts on `to`. Zero for joints that do
    /// not constrain the relative rotation, and for slides, whose bodies share a frame. About the
    /// axis of a hinge or rotor it is [`drive`](Self::drive), which is part of it.
    pub torque: Vector3<f64>,
    /// Force or torque of the drive: its power on the bodies is `drive dv/dt` with the value `v` of
    /// the joint. Positive if it increases the value; for passive joints, that of the spring, the
    /// dashpot and the given force together. Zero for amplitudes of deformations, whose forces the
    /// surfaces of the bodies have and not their motion.
    pub drive: f64,
}

impl JointLoad {
    /// The load of a force, a torque and a drive, each with the meaning of its field.
    pub fn new(force: Vector3<f64>, torque: Vector3<f64>, drive: f64) -> Self {
        Self {
            force,
            torque,
            drive,
        }
    }
}

/// Rows of a joint in [`Constraints::matrix`]; none of an amplitude of a deformation.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct JointRows {
    /// The three rows from it belong to the force on `body`; for joints about an axis the next
    /// three belong to the torque about the pivot.
    pub first: usize,
    /// Number of rows.
    pub len: usize,
    /// `x_body - x_to`.
    ///
    /// It does not affect the loads, but distinguishes drives at different values: with
    /// [`Arms::Lab`](crate::Arms::Lab) the rows contain no lengths.
    pub vector: Vector3<f64>,
    /// Relative velocity at the pivot per rate of the value.
    pub translation: Vector3<f64>,
    /// Relative angular velocity per rate of the value, if the joint constrains the rotation.
    pub rotation: Option<Vector3<f64>>,
}

impl JointRows {
    /// The load of a joint, by the rows of all joints, from the loads of all rows.
    ///
    /// # Errors
    /// [`RigidError::NoSuchJoint`], also for a list of loads that ends before its rows.
    pub fn load_of(
        all: &[Self],
        loads: &DVector<f64>,
        joint: usize,
    ) -> Result<JointLoad, RigidError> {
        let is_known = |rows: &&Self| rows.first + rows.len <= loads.len();
        let rows = all.get(joint).filter(is_known);
        let joints = all.len();
        let rows = rows.ok_or(RigidError::NoSuchJoint { joint, joints })?;
        if rows.len == 0 {
            return Ok(JointLoad::default());
        }
        let force: Vector3<f64> = loads.fixed_rows::<3>(rows.first).into();
        let mut load = JointLoad {
            force,
            torque: Vector3::zeros(),
            drive: rows.translation.dot(&force),
        };
        if let Some(rotation) = rows.rotation {
            load.torque = loads.fixed_rows::<3>(rows.first + 3).into();
            load.drive += rotation.dot(&load.torque);
        }
        Ok(load)
    }
}

/// The three rows of [`Constraints::matrix`] that give the velocity or angular velocity of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct HeldRows {
    pub body: usize,
    pub is_rotation: bool,
    pub first: usize,
}

impl Articulation {
    /// The constraints in one configuration, where the values of the joints change at `rates` (one
    /// per joint; those of passive joints have no effect).
    ///
    /// # Errors
    /// Arrays whose lengths do not fit the set, a rate that is not finite, values that
    /// [`Articulation::place`] refuses.
    pub fn constraints(
        &self,
        state: &State,
        shape: &[f64],
        rates: &[f64],
    ) -> Result<Constraints, RigidError> {
        check_length("rates of the links", rates.len(), self.joints().len())?;
        check_finite("the rate of a link", rates)?;
        let placement = self.placement(state, shape)?;
        let layout = self.velocity_layout();
        let frame_of = |body: usize| layout.frame(self.frame_of()[body]);
        let is_rigid = |body: &usize| self.kinds()[*body] == BodyKind::Rigid;
        let clamped: Vec<(usize, usize)> = match self.arms() {
            Arms::Clamped => (0..self.kinds().len())
                .filter(is_rigid)
                .filter_map(|body| Some((body, frame_of(body)?)))
                .collect(),
            Arms::Free | Arms::Lab => Vec::new(),
        };
        let held: Vec<(usize, bool)> = (self.held_bodies())
            .flat_map(|body| [(body, false), (body, true)])
            .filter(|&(body, is_rotation)| match is_rotation {
                true => self.held_rotation()[body],
                false => self.held_translation()[body],
            })
            .collect();
        let joint_rows: usize = self.joints().iter().map(|joint| joint.kind.rows()).sum();
        let rows = joint_rows + 3 * clamped.len() + 3 * held.len();
        let mut constraints = Constraints {
            matrix: DMatrix::zeros(rows, layout.len()),
            rates: DVector::zeros(rows),
            labels: Vec::with_capacity(rows),
            joint_forces: (self.passive_drives())
                .map(|(joint, drive)| drive.static_force(placement.values[joint]))
                .collect(),
            body_damping: Vec::new(),
            random_loads: None,
            joint_damping: self
                .passive_drives()
                .map(|(_, drive)| drive.damping)
                .collect(),
            joint_rows: Vec::with_capacity(self.joints().len()),
            held_rows: Vec::with_capacity(held.len()),
            rigid_positions: (placement.positions.iter().zip(self.kinds()))
                .filter(|(_, kind)| **kind == BodyKind::Rigid)
                .map(|(position, _)| *position)
                .collect(),
            layout,
        };
        for (joint, &rate) in rates.iter().enumerate() {
            self.add_joint(&mut constraints, &placement, joint, rate);
        }
        for (body, frame) in clamped {
            let row = constraints.labels.len();
            let spin = constraints.layout.bodies()[body] + 3;
            add_block(
                &mut constraints.matrix,
                row,
                Some(spin),
                &Matrix3::identity(),
            );
            add_block(
                &mut constraints.matrix,
                row,
                Some(frame),
                &-Matrix3::identity(),
            );
            let label = format!("clamp of body {}", self.body_number(body));
            constraints.labels.extend(std::iter::repeat_n(label, 3));
        }
        for (body, is_rotation) in held {
            let row = constraints.labels.len();
            constraints.held_rows.push(HeldRows {
                body,
                is_rotation,
                first: row,
            });
            let column = constraints.layout.bodies()[body] + 3 * usize::from(is_rotation);
            let identity = Matrix3::identity();
            add_block(&mut constraints.matrix, row, Some(column), &identity);
            let label = format!("held body {}", self.body_number(body));
            constraints.labels.extend(std::iter::repeat_n(label, 3));
        }
        Ok(constraints)
    }

    /// Adds the rows of a joint.
    fn add_joint(&self, to: &mut Constraints, placement: &Placement, joint: usize, rate: f64) {
        let (number, joint) = (joint, &self.joints()[joint]);
        let row = to.labels.len();
        let rows = joint.kind.rows();
        if rows == 0 {
            to.joint_rows.push(JointRows {
                first: row,
                len: rows,
                vector: Vector3::zeros(),
                translation: Vector3::zeros(),
                rotation: None,
            });
            return;
        }
        let layout = &to.layout;
        let direction = self.direction(placement, number);
        let [far, near] = [joint.body, joint.to].map(|body| placement.positions[body]);
        let [far_frame, near_frame] =
            [joint.body, joint.to].map(|body| layout.frame(self.frame_of()[body]));
        // The point at which the two frames have the same velocity, but for the rate of the joint.
        let pivot = match joint.kind.turns() {
            false => far,
            true => {
                let rotation = placement.rotations[self.frame_of()[joint.body]];
                far + rotation * self.arm_vectors()[number].far
            }
        };
        let identity = Matrix3::identity();
        let matrix = &mut to.matrix;
        add_block(matrix, row, Some(layout.bodies()[joint.body]), &identity);
        add_block(matrix, row, Some(layout.bodies()[joint.to]), &-identity);
        // Ω' × r = -[r]_× Ω'
        add_block(matrix, row, far_frame, &-(pivot - far).cross_matrix());
        add_block(matrix, row, near_frame, &(pivot - near).cross_matrix());
        let (translation, rotation) = joint.kind.twist(direction);
        to.joint_rows.push(JointRows {
            first: row,
            len: rows,
            vector: far - near,
            translation,
            rotation,
        });
        let mut along_joint = vec![translation];
        if let Some(axis) = rotation {
            add_block(matrix, row + 3, far_frame, &identity);
            add_block(matrix, row + 3, near_frame, &-identity);
            along_joint.push(axis);
        }
        for (part, vector) in along_joint.into_iter().enumerate() {
            let row = row + 3 * part;
            match layout.joint(number) {
                Some(column) => (matrix.fixed_view_mut::<3, 1>(row, column)).copy_from(&-vector),
                None => (to.rates.fixed_rows_mut::<3>(row)).copy_from(&(rate * vector)),
            }
            to.labels.extend(std::iter::repeat_n(joint.name.clone(), 3));
        }
    }

    /// Rate of change of the state for generalised velocities `q`.
    ///
    /// # Errors
    /// A `q` of the wrong length.
    pub fn state_velocity(&self, q: &[f64]) -> Result<StateVelocity, RigidError> {
        let layout = self.velocity_layout();
        check_length("generalised velocities", q.len(), layout.len())?;
        let at = |first: usize| Vector3::new(q[first], q[first + 1], q[first + 2]);
        let frame_spin = |body: usize| {
            let linkage = &self.linkages()[self.linkage_of()[body]];
            match (layout.frame(self.frame_of()[body]), &linkage.bodies[..]) {
                (Some(frame), _) => at(frame),
                // The frame of a body without joints rotates with the body.
                (None, &[body]) if self.kinds()[body] == BodyKind::Rigid => {
                    at(layout.bodies()[body] + 3)
                }
                (None, _) => Vector3::zeros(),
            }
        };
        Ok(StateVelocity {
            frames: self
                .linkages()
                .iter()
                .map(|linkage| Twist {
                    linear: at(layout.bodies()[linkage.root]),
                    angular: frame_spin(linkage.root),
                })
                .collect(),
            spins: (0..self.kinds().len())
                .map(|body| match self.kinds()[body] {
                    BodyKind::Rigid => at(layout.bodies()[body] + 3),
                    BodyKind::Point => frame_spin(body),
                })
                .collect(),
            joints: layout.joints().map(|column| q[column]).collect(),
        })
    }
}

/// Adds a 3 x 3 block to a matrix; nothing without a column.
fn add_block(matrix: &mut DMatrix<f64>, row: usize, column: Option<usize>, block: &Matrix3<f64>) {
    if let Some(column) = column {
        let mut view = matrix.fixed_view_mut::<3, 3>(row, column);
        view += block;
    }
}
