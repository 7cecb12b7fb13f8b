//! Tabular Q-learning and double Q-learning.

use fastrand::Rng;

use swimmer::scene::{LearnKind, LearnOptions};

use super::Environment;

/// Numbers of a learner.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LearningOptions {
    /// Two tables that evaluate each other's choices (van Hasselt 2010) instead of one, the
    /// default.
    pub is_double: bool,
    /// Number of episodes; 100 by default.
    pub episodes: usize,
    /// Number of steps of an episode; 100 by default.
    pub steps: usize,
    /// Discount of rewards per step; 0.9 by default.
    pub discount: f64,
    /// Share of an update that replaces the old value; 0.5 by default.
    pub rate: f64,
    /// Probability of a random action; 0.3 by default.
    pub exploration: f64,
    /// Seed of the random numbers; 1 by default.
    pub seed: u64,
}

impl From<&LearnOptions> for LearningOptions {
    /// Those of the keys `learn` of a scene.
    fn from(keys: &LearnOptions) -> Self {
        Self {
            is_double: keys.method == LearnKind::DoubleQ,
            episodes: keys.episodes as usize,
            steps: keys.steps as usize,
            discount: keys.discount,
            rate: keys.rate,
            exploration: keys.exploration,
            seed: u64::from(keys.seed),
        }
    }
}

impl Default for LearningOptions {
    /// The defaults of the keys `learn` of scenes.
    fn default() -> Self {
        Self::from(&LearnOptions::default())
    }
}

setters!(LearningOptions {
    with_is_double(is_double: bool),
    with_episodes(episodes: usize),
    with_steps(steps: usize),
    with_discount(discount: f64),
    with_rate(rate: f64),
    with_exploration(exploration: f64),
    with_seed(seed: u64),
});

/// What was learned.
#[derive(Clone, Debug)]
pub struct Learned {
    /// Value of each action in each state; of two tables, their mean.
    pub values: Vec<Vec<f64>>,
    /// The best action in each state, the first one of equal ones.
    pub policy: Vec<usize>,
    /// Mean reward of a step in each episode, random actions included.
    pub curve: Vec<f64>,
}

/// Learns the values of actions (Watkins & Dayan 1992).
///
/// ```text
/// Q(s, a) <- Q(s, a) + rate (r + discount max_b Q(s', b) - Q(s, a))
/// ```
///
/// Actions are random with the probability `exploration`, else the best ones so far. The same seed
/// gives the same result.
pub fn learn(environment: &mut dyn Environment, options: &LearningOptions) -> Learned {
    let (states, actions) = (environment.states(), environment.actions());
    let mut random = Rng::with_seed(options.seed);
    let mut tables = vec![vec![vec![0.0; actions]; states]; if options.is_double { 2 } else { 1 }];
    let mut curve = Vec::with_capacity(options.episodes);
    for _ in 0..options.episodes {
        let mut state = environment.reset();
        let (mut sum, mut steps) = (0.0, 0);
        while steps < options.steps {
            steps += 1;
            let action = match random.f64() < options.exploration {
                true => random.usize(..actions),
                false => best(&mean(&tables, state)),
            };
            let (next, reward, is_done) = environment.step(action);
            let (own, other) = match options.is_double {
                true if random.bool() => (0, 1),
                true => (1, 0),
                false => (0, 0),
            };
            let choice = best(&tables[own][next]);
            let future = if is_done {
                0.0
            } else {
                tables[other][next][choice]
            };
            let value = &mut tables[own][state][action];
            *value += options.rate * (reward + options.discount * future - *value);
            sum += reward;
            state = next;
            if is_done {
                break;
            }
        }
        curve.push(sum / steps.max(1) as f64);
    }
    let values: Vec<Vec<f64>> = (0..states).map(|state| mean(&tables, state)).collect();
    Learned {
        policy: values.iter().map(|row| best(row)).collect(),
        values,
        curve,
    }
}

/// Mean of the tables in a state.
fn mean(tables: &[Vec<Vec<f64>>], state: usize) -> Vec<f64> {
    let count = tables.len() as f64;
    (0..tables[0][state].len())
        .map(|action| tables.iter().map(|table| table[state][action]).sum::<f64>() / count)
        .collect()
}

/// Position of the largest value, the first one of equal ones.
fn best(values: &[f64]) -> usize {
    (0..values.len()).fold(0, |best, k| if values[k] > values[best] { k } else { best })
}
