//! Cycles of states: that of a policy, and the one with the largest mean reward.

use super::rewards::Rewards;

/// A cycle of states.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Cycle {
    /// The states, each once, in the order in which they are visited.
    pub states: Vec<usize>,
    /// The action in each state.
    pub actions: Vec<usize>,
    /// Sum of the rewards.
    pub per_cycle: f64,
}

impl Cycle {
    /// Mean reward of a step.
    pub fn per_step(&self) -> f64 {
        self.per_cycle / self.states.len() as f64
    }

    fn new(rewards: &Rewards, mut actions: Vec<(usize, usize)>) -> Self {
        // Cycles are written from their smallest state on, so that equal ones compare equal.
        let first = (actions.iter().enumerate()).min_by_key(|(_, (state, _))| *state);
        let first = first.map_or(0, |(position, _)| position);
        actions.rotate_left(first);
        Self {
            per_cycle: actions
                .iter()
                .map(|&(state, action)| rewards.of(state, action))
                .sum(),
            states: actions.iter().map(|step| step.0).collect(),
            actions: actions.into_iter().map(|step| step.1).collect(),
        }
    }
}

/// The cycle of the largest mean reward of a step (Karp 1978).
///
/// With the largest sum `D_k(v)` of `k` steps to the state `v`, the mean is
/// `max_v min_k (D_n(v) - D_k(v)) / (n - k)` over `n` states, and the walk of `n` steps to the best
/// `v` contains the cycle. Cost: states squared times actions.
pub fn best_cycle(rewards: &Rewards) -> Cycle {
    let (n, actions) = (rewards.states(), rewards.joints.len());
    let mut sums = vec![vec![f64::NEG_INFINITY; n]; n + 1];
    let mut last_action = vec![vec![0; n]; n + 1];
    // All states can be reached from the first one.
    sums[0][0] = 0.0;
    for k in 0..n {
        for state in 0..n {
            for action in 0..actions {
                let (next, sum) = (
                    state ^ 1 << action,
                    sums[k][state] + rewards.of(state, action),
                );
                if sum > sums[k + 1][next] {
                    sums[k + 1][next] = sum;
                    last_action[k + 1][next] = action;
                }
            }
        }
    }
    let mean = |v: usize| {
        let means = (0..n).filter(|&k| sums[k][v].is_finite());
        means
            .map(|k| (sums[n][v] - sums[k][v]) / (n - k) as f64)
            .fold(f64::INFINITY, f64::min)
    };
    let reached = (0..n).filter(|&v| sums[n][v].is_finite());
    let end = reached
        .max_by(|&a, &b| mean(a).total_cmp(&mean(b)))
        .unwrap_or(0);
    // The walk backwards; the first state that it meets twice closes a cycle of the largest mean.
    let mut walk = Vec::new();
    let mut seen = vec![None; n];
    let (mut state, mut k) = (end, n);
    let mut best: Option<Cycle> = None;
    seen[state] = Some(0);
    while k > 0 {
        let action = last_action[k][state];
        state ^= 1 << action;
        k -= 1;
        walk.push((state, action));
        if let Some(from) = seen[state] {
            let steps: Vec<(usize, usize)> = walk[from..].iter().rev().copied().collect();
            let cycle = Cycle::new(rewards, steps);
            if best
                .as_ref()
                .is_none_or(|best| cycle.per_step() > best.per_step())
            {
                best = Some(cycle);
            }
        }
        seen[state] = Some(walk.len());
    }
    best.unwrap_or_else(|| Cycle::new(rewards, vec![(0, 0), (1, 0)]))
}

/// The cycle that a policy, one action per state, ends in from the first state.
pub fn greedy_cycle(rewards: &Rewards, policy: &[usize]) -> Cycle {
    let mut seen = vec![None; rewards.states()];
    let (mut state, mut walk) = (0, Vec::new());
    while seen[state].is_none() {
        seen[state] = Some(walk.len());
        walk.push((state, policy[state]));
        state ^= 1 << policy[state];
    }
    Cycle::new(rewards, walk.split_off(seen[state].unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rewards that are differences of a potential, and `bonus` for one direction of a square.
    fn square(bonus: f64) -> Rewards {
        let potential = [0.3, -0.2, 0.7, 0.1];
        let mut table = vec![vec![0.0; 2]; 4];
        for state in 0..4_usize {
            for action in 0..2 {
                let next = state ^ 1 << action;
                let turns = [(0, 1), (1, 3), (3, 2), (2, 0)];
                let sign = |pair: (usize, usize)| f64::from(u8::from(turns.contains(&pair)));
                table[state][action] = potential[next] - potential[state]
                    + bonus * (sign((state, next)) - sign((next, state)));
            }
        }
        Rewards::new(table).unwrap()
    }

    #[test]
    fn the_best_cycle_goes_round_in_the_direction_of_the_bonus() {
        for (bonus, states) in [(0.1, [0, 1, 3, 2]), (-0.1, [0, 2, 3, 1])] {
            let cycle = best_cycle(&square(bonus));
            assert_eq!(cycle.states, states);
            assert!((cycle.per_step() - 0.1).abs() < 1e-14);
        }
    }

    #[test]
    fn a_policy_that_goes_back_and_forth_gains_nothing() {
        let cycle = greedy_cycle(&square(0.1), &[1, 0, 1, 1]);
        assert_eq!(cycle.states, [0, 2]);
        assert!(cycle.per_cycle.abs() < 1e-14);
    }
}
