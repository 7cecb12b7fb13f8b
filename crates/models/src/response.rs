//! Motion and loads of the bodies, which form a vector space.

use std::ops::{Add, AddAssign, Mul, Sub, SubAssign};

use nalgebra::{UnitQuaternion, Vector3};
use rigid::{JointLoad, StateVelocity};
use serde::{Deserialize, Serialize};

/// Motion and loads of the bodies of a scene: all that depends linearly on what drives the flow.
///
/// Solutions, their errors and their differences are responses. Sums, differences and multiples are
/// those of all numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// Rate of change of the state.
    pub motion: StateVelocity,
    /// One entry per body of the scene, in its order; points have zero force and torque.
    pub bodies: Vec<BodySolution>,
    /// One entry per joint of the scene: the force and torque of the joint on the body named by its
    /// key `body`, and the force or torque of its drive.
    ///
    /// The opposite force and torque act on the body named by its key `to`.
    pub joint_loads: Vec<JointLoad>,
    /// The loads that hold bodies whose velocities are given, one per such body in the order of the
    /// scene.
    pub holding: Vec<HoldingLoad>,
    /// The mean flow through a periodic box; none in other domains.
    pub mean_flow: Option<MeanFlow>,
    /// Power of the slip of the bodies on the fluid, in addition to that of their motion, less that
    /// of random loads ([`Query::random_loads`](crate::Query::random_loads)).
    pub slip_power: f64,
    /// Rates of the amplitudes of deformations, one per joint of the scene and zero for joints that
    /// move bodies; empty if no body deforms.
    ///
    /// The power of a deformation on the fluid is its rate times the drive of its joint.
    pub amplitude_rates: Vec<f64>,
}

impl Response {
    /// Power of the bodies on the fluid: of their motion, their deformation and their slip.
    pub fn power(&self) -> f64 {
        self.power_in(self) + self.slip_power
    }

    /// Power of the loads of the bodies on the fluid in another motion and deformation of them.
    pub fn power_in(&self, motion: &Self) -> f64 {
        let bodies = self.bodies.iter().zip(&motion.bodies);
        let of_bodies = bodies.map(|(own, moving)| {
            own.force.dot(&moving.velocity) + own.torque.dot(&moving.angular_velocity)
        });
        let rates = self.drives().zip(&motion.amplitude_rates);
        of_bodies.sum::<f64>() + rates.map(|(drive, rate)| drive * rate).sum::<f64>()
    }

    /// Upper bound of the speed of the points of all bodies and frames within the distance `radius`
    /// of their centres: `|U| + radius |ω|`.
    pub(crate) fn largest_speed(&self, radius: f64) -> f64 {
        let bodies = self.bodies.iter().map(|b| (b.velocity, b.angular_velocity));
        let frames = self.motion.frames.iter().map(|t| (t.linear, t.angular));
        let spins = self.motion.spins.iter().map(|s| (Vector3::zeros(), *s));
        bodies
            .chain(frames)
            .chain(spins)
            .map(|(linear, angular)| linear.norm() + radius * angular.norm())
            .fold(0.0, f64::max)
    }

    /// The vectors in a fixed order: of the frames, spins, bodies, joints, held bodies and the mean
    /// flow.
    pub(crate) fn vectors(&self) -> impl Iterator<Item = &Vector3<f64>> {
        let frames = self.motion.frames.iter();
        (frames.flat_map(|frame| [&frame.linear, &frame.angular]))
            .chain(&self.motion.spins)
            .chain(self.bodies.iter().flat_map(BodySolution::vectors))
            .chain((self.joint_loads.iter()).flat_map(|load| [&load.force, &load.torque]))
            .chain((self.holding.iter()).flat_map(|load| [&load.force, &load.torque]))
            .chain(
                (self.mean_flow.iter()).flat_map(|flow| [&flow.velocity, &flow.pressure_gradient]),
            )
    }

    pub(crate) fn vectors_mut(&mut self) -> impl Iterator<Item = &mut Vector3<f64>> {
        let frames = self.motion.frames.iter_mut();
        (frames.flat_map(|frame| [&mut frame.linear, &mut frame.angular]))
            .chain(&mut self.motion.spins)
            .chain(self.bodies.iter_mut().flat_map(BodySolution::vectors_mut))
            .chain(
                (self.joint_loads.iter_mut()).flat_map(|load| [&mut load.force, &mut load.torque]),
            )
            .chain((self.holding.iter_mut()).flat_map(|load| [&mut load.force, &mut load.torque]))
            .chain(
                (self.mean_flow.iter_mut())
                    .flat_map(|flow| [&mut flow.velocity, &mut flow.pressure_gradient]),
            )
    }

    /// Force or torque of the drive of each joint.
    pub(crate) fn drives(&self) -> impl Iterator<Item = f64> {
        self.joint_loads.iter().map(|load| load.drive)
    }

    pub(crate) fn drives_mut(&mut self) -> impl Iterator<Item = &mut f64> {
        self.joint_loads.iter_mut().map(|load| &mut load.drive)
    }

    /// Rotates all vectors, for a configuration that is rotated as a whole.
    pub fn rotate(&mut self, rotation: &UnitQuaternion<f64>) {
        self.vectors_mut().for_each(|v| *v = rotation * *v);
    }

    /// Adds `factor` times another response.
    pub(crate) fn accumulate(&mut self, factor: f64, other: &Self) {
        self.zip_apply(other, |a, b| *a += factor * b);
    }

    /// The response of the same bodies whose numbers are all zero.
    pub(crate) fn zero(mut self) -> Self {
        self.apply(|x| *x = 0.0);
        self
    }

    fn apply(&mut self, f: impl Fn(&mut f64)) {
        self.vectors_mut().for_each(|v| v.apply(&f));
        self.motion.joints.iter_mut().for_each(&f);
        self.drives_mut().for_each(&f);
        self.amplitude_rates.iter_mut().for_each(&f);
        f(&mut self.slip_power);
    }

    /// Applies `f` to the numbers of both.
    fn zip_apply(&mut self, other: &Self, f: impl Fn(&mut f64, f64)) {
        let vectors = self.vectors_mut().zip(other.vectors());
        vectors.for_each(|(a, b)| a.zip_apply(b, &f));
        let joints = self.motion.joints.iter_mut().zip(&other.motion.joints);
        joints.for_each(|(a, b)| f(a, *b));
        let drives = self.drives_mut().zip(other.drives());
        drives.for_each(|(a, b)| f(a, b));
        let rates = self.amplitude_rates.iter_mut().zip(&other.amplitude_rates);
        rates.for_each(|(a, b)| f(a, *b));
        f(&mut self.slip_power, other.slip_power);
    }
}

impl AddAssign<&Self> for Response {
    fn add_assign(&mut self, other: &Self) {
        self.zip_apply(other, |a, b| *a += b);
    }
}

impl SubAssign<&Self> for Response {
    fn sub_assign(&mut self, other: &Self) {
        self.zip_apply(other, |a, b| *a -= b);
    }
}

impl Add<&Self> for Response {
    type Output = Self;
    fn add(mut self, other: &Self) -> Self {
        self += other;
        self
    }
}

impl Sub for &Response {
    type Output = Response;
    fn sub(self, other: Self) -> Response {
        let mut difference = self.clone();
        difference -= other;
        difference
    }
}

impl Mul<f64> for &Response {
    type Output = Response;
    fn mul(self, factor: f64) -> Response {
        let mut product = self.clone();
        product.apply(|x| *x *= factor);
        product
    }
}

/// Force and torque by which whatever holds or drives a body acts on it.
///
/// A fixed body that holds a swimmer receives the opposite of its thrust. The part that is not
/// held, such as the torque on a body of which the velocity alone is given, is zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct HoldingLoad {
    /// Index of the body.
    pub body: usize,
    /// Force on the body.
    pub force: Vector3<f64>,
    /// Torque on the body, about its centre.
    pub torque: Vector3<f64>,
}

/// The mean flow through a periodic box and the mean pressure gradient that goes with it.
///
/// The scene gives one of both, by default a mean flow of zero, and the other one is a result. The
/// forces on the fluid in a box of the volume `V` balance: with the forces `F_i` of the bodies on
/// the fluid and the mean pressure gradient `P`
///
/// ```text
/// sum_i F_i - V P = 0
/// ```
///
/// so that the pressure falls along a flow past bodies that are held. The mean flow is that of the
/// whole box, in which bodies move as they do: the superficial velocity for bodies at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct MeanFlow {
    /// Mean velocity of fluid and bodies.
    pub velocity: Vector3<f64>,
    /// Mean of the gradient of the pressure.
    pub pressure_gradient: Vector3<f64>,
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
    fn vectors(&self) -> [&Vector3<f64>; 4] {
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
}
