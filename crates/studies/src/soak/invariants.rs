//! What every instant of every scene must satisfy.

use nalgebra::Vector3;
use rigid::Arms;
use swimmer::models::{Hydrodynamics, InstantaneousSolution};
use swimmer::{Leg, LegSolution, Observer, Scene, SwimError};

/// The largest misfits of the balances over the instants of a scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Misfits {
    /// Of forces and torques of a linkage against its loads, over the largest force times the reach.
    pub balance: f64,
    /// Of the power into the fluid against that of links and loads, over the sizes of its terms.
    pub power: f64,
    /// Instants seen.
    pub instants: usize,
}

/// Watches a run.
pub struct Watch<'a> {
    pub scene: &'a Scene,
    pub misfits: Misfits,
}

impl Observer for Watch<'_> {
    fn solved(
        &mut self,
        leg: &Leg,
        solved: &LegSolution,
        _: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        let set = self.scene.articulation();
        let places: Vec<Vector3<f64>> = set
            .place(&solved.state, &leg.lengths(solved.s))?
            .iter()
            .map(|pose| pose.translation.vector)
            .collect();
        let directions: Vec<Vector3<f64>> = (0..set.links().len())
            .map(|link| set.direction(&solved.state, link))
            .collect();
        let seen = of_instant(
            self.scene,
            &solved.solution,
            &places,
            &directions,
            &leg.rates(),
        );
        self.misfits.balance = self.misfits.balance.max(seen.balance);
        self.misfits.power = self.misfits.power.max(seen.power);
        self.misfits.instants += 1;
        Ok(())
    }
}

/// The misfits of one instant.
pub fn of_instant(
    scene: &Scene,
    instant: &InstantaneousSolution,
    places: &[Vector3<f64>],
    directions: &[Vector3<f64>],
    rates: &[f64],
) -> Misfits {
    let set = scene.articulation();
    let largest = instant
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
        let (mut force, mut torque, mut reach) = (Vector3::zeros(), Vector3::zeros(), 1.0_f64);
        for &body in &linkage.bodies {
            let (b, given) = (&instant.bodies[body], &scene.bodies()[body]);
            let arm = places[body] - root;
            reach = reach.max(arm.norm());
            force += b.force - given.force;
            torque += arm.cross(&(b.force - given.force)) + b.torque - given.torque;
        }
        balance = balance.max(force.norm() / largest);
        // arms that keep their direction in the laboratory are held by a torque from outside
        if set.arms() != Arms::Lab || linkage.bodies.len() == 1 {
            balance = balance.max(torque.norm() / (largest * reach));
        }
    }
    let mut into_fluid = 0.0;
    let mut size = 0.0;
    for (b, given) in instant.bodies.iter().zip(scene.bodies()) {
        let terms = [
            b.force.dot(&b.velocity),
            b.torque.dot(&b.angular_velocity),
            -given.force.dot(&b.velocity),
            -given.torque.dot(&b.angular_velocity),
        ];
        into_fluid += terms.iter().sum::<f64>();
        size += terms.iter().map(|x| x.abs()).sum::<f64>();
    }
    let links: f64 = instant
        .link_forces
        .iter()
        .zip(directions)
        .zip(rates)
        .map(|((f, e), rate)| f.dot(e) * rate)
        .sum();
    Misfits {
        balance,
        power: match size > 0.0 {
            true => (into_fluid - links).abs() / size,
            false => 0.0,
        },
        instants: 1,
    }
}
