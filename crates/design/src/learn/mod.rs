//! Reinforcement learning on shapes whose joints are contracted or extended.
//!
//! Tsang, Tong, Nallan & Pak (2020) let a chain of spheres learn to swim: a state is the set of
//! contracted arms, an action changes one arm, the reward is the displacement. The swimmer has no
//! inertia, so that rewards depend on state and action alone, and the best policy repeats the cycle
//! of states with the largest mean reward, which [`best_cycle`] computes exactly.

mod cycle;
mod environment;
mod q_learning;
mod rewards;

pub use cycle::{Cycle, best_cycle, greedy_cycle};
pub use environment::{ArmStates, Environment};
pub use q_learning::{Learned, LearningOptions, learn};
pub use rewards::{Rewards, rewards};
