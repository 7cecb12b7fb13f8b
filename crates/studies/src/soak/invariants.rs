//! Balances that every instantaneous solution must satisfy.

use nalgebra::Vector3;
use rigid::Arms;
use swimmer::models::{Hydrodynamics, InstantaneousSolution};
use swimmer::{Observer, PhaseSpan, Scene, SpanSolution, SwimError};

/// Largest relative imbalances over the instantaneous solutions of a scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Imbalances {
    /// Forces and torques of a linkage minus its loads, over the largest force times the size.
    pub balance: f64,
    /// Power into the fluid minus power of joints and loads, over the sum of magnitudes of the
    /// terms.
    pub power: f64,
    /// Number of solutions.
    pub solutions: usize,
}

/// Observer of a run that records the imbalances.
pub struct Watch<'a> {
    pub scene: &'a Scene,
    pub imbalances: Imbalances,
}

impl Observer for Watch<'_> {
    fn solved(
        &mut self,
        span: &PhaseSpan,
        solved: &SpanSolution,
        _: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        let set = self.scene.articulation();
        let places: Vec<Vector3<f64>> = set
            .place(&solved.state, &span.shape(solved.s))?
            .iter()
            .map(|pose| pose.translation.vector)
            .collect();
        let directions = set.directions(&solved.state, &span.shape(solved.s))?;
        let seen = of_solution(
            self.scene,
            &solved.solution,
            &places,
            &directions,
            &span.rates(0.0),
        );
        self.imbalances.balance = self.imbalances.balance.max(seen.balance);
        self.imbalances.power = self.imbalances.power.max(seen.power);
        self.imbalances.solutions += 1;
        Ok(())
    }
}

/// Imbalances of one instantaneous solution.
pub fn of_solution(
    scene: &Scene,
    solution: &InstantaneousSolution,
    places: &[Vector3<f64>],
    directions: &[Vector3<f64>],
    rates: &[f64],
) -> Imbalances {
    let set = scene.articulation();
    let largest = solution
        .bodies
        .iter()
        .map(|b| b.force.norm())
        .chain(scene.bodies().iter().map(|b| b.force.norm()))
        .fold(f64::MIN_POSITIVE, f64::max);
    let mut balance = 0.0_f64;
    for linkage in set.linkages() {
        if set.fixed()[linkage.root] {
            continue;
        }
        let root = places[linkage.root];
        let (mut force, mut torque, mut size_of_linkage) =
            (Vector3::zeros(), Vector3::zeros(), 1.0_f64);
        for &body in &linkage.bodies {
            let (b, given) = (&solution.bodies[body], &scene.bodies()[body]);
            let arm = places[body] - root;
            size_of_linkage = size_of_linkage.max(arm.norm());
            force += b.force - given.force;
            torque += arm.cross(&(b.force - given.force)) + b.torque - given.torque;
        }
        balance = balance.max(force.norm() / largest);
        // Arms with a fixed direction in the laboratory need an external torque.
        if set.arms() != Arms::Lab || linkage.bodies.len() == 1 {
            balance = balance.max(torque.norm() / (largest * size_of_linkage));
        }
    }
    let mut into_fluid = 0.0;
    let mut size = 0.0;
    for (b, given) in solution.bodies.iter().zip(scene.bodies()) {
        let terms = [
            b.force.dot(&b.velocity),
            b.torque.dot(&b.angular_velocity),
            -given.force.dot(&b.velocity),
            -given.torque.dot(&b.angular_velocity),
        ];
        into_fluid += terms.iter().sum::<f64>();
        size += terms.iter().map(|x| x.abs()).sum::<f64>();
    }
    let joints: f64 = solution
        .joint_forces
        .iter()
        .zip(directions)
        .zip(rates)
        .map(|((f, e), rate)| f.dot(e) * rate)
        .sum();
    Imbalances {
        balance,
        power: match size > 0.0 {
            true => (into_fluid - joints).abs() / size,
            false => 0.0,
        },
        solutions: 1,
    }
}
