//! Reinforcement learning on shapes whose joints are contracted or extended.
//!
//! Tsang, Tong, Nallan & Pak (2020) let a chain of spheres learn to swim: a state is the set of
//! contracted arms, an action changes one arm, the reward is the displacement. The swimmer has no
//! inertia, so that rewards depend on state and action alone, and the best policy repeats the cycle
//! of states with the largest mean reward, which [`best_cycle`] computes exactly.

mod cycle;
mod learned_stroke;
mod q_learning;
mod rewards;

pub use cycle::{Cycle, best_cycle, greedy_cycle};
pub use learned_stroke::{LearnedStroke, learn_stroke};
pub use q_learning::{Learned, LearningOptions, learn};
pub use rewards::{Rewards, rewards};

/// An environment with states and actions that are numbered from zero.
///
/// ```
/// use design::learn::Environment;
///
/// /// A walk on a ring of five states, with a reward for every step to the right.
/// struct Ring(usize);
///
/// impl Environment for Ring {
///     fn states(&self) -> usize {
///         5
///     }
///     fn actions(&self) -> usize {
///         2
///     }
///     fn reset(&mut self) -> usize {
///         self.0 = 0;
///         0
///     }
///     fn step(&mut self, action: usize) -> (usize, f64, bool) {
///         self.0 = (self.0 + if action == 0 { 1 } else { 4 }) % 5;
///         (self.0, if action == 0 { 1.0 } else { -1.0 }, false)
///     }
/// }
/// let mut ring = Ring(3);
/// assert_eq!((ring.reset(), ring.step(1)), (0, (4, -1.0, false)));
/// ```
pub trait Environment {
    /// Number of states.
    fn states(&self) -> usize;

    /// Number of actions, the same in all states.
    fn actions(&self) -> usize;

    /// Starts an episode; returns the state.
    fn reset(&mut self) -> usize;

    /// Acts; returns the new state, the reward and whether the episode ends.
    ///
    /// # Panics
    /// May panic for an action that does not exist.
    fn step(&mut self, action: usize) -> (usize, f64, bool);
}

/// A swimmer whose joints are contracted or extended; an action changes one of them.
///
/// Bit `k` of a state is set if joint `k` is contracted. Episodes start with all joints extended
/// and have no end.
#[derive(Clone, Debug)]
pub struct ArmStates<'a> {
    rewards: &'a Rewards,
    state: usize,
}

impl<'a> ArmStates<'a> {
    /// The environment with these rewards.
    pub fn new(rewards: &'a Rewards) -> Self {
        Self { rewards, state: 0 }
    }
}

impl Environment for ArmStates<'_> {
    fn states(&self) -> usize {
        self.rewards.states()
    }

    fn actions(&self) -> usize {
        self.rewards.joints.len()
    }

    fn reset(&mut self) -> usize {
        self.state = 0;
        0
    }

    fn step(&mut self, action: usize) -> (usize, f64, bool) {
        let reward = self.rewards.of(self.state, action);
        self.state ^= 1 << action;
        (self.state, reward, false)
    }
}
