//! Long run of random scenes through all models.
//!
//! It checks balances of forces and power, that numbers are finite, that one thread gives the same
//! bits as several, and that memory does not grow.

mod random_scenes;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, bail};
use nalgebra::Vector3;
use rigid::Arms;
use swimmer::models::{Hydrodynamics, InstantaneousSolution, ModelError};
use swimmer::output::processor;
use swimmer::{
    Method, Observer, PhaseSpan, Scene, SpanSolution, SwimError, choose, simulate, solve_start,
};

use self::random_scenes::{FINITE_ELEMENTS, draw};
use crate::random::Random;
use crate::table::{Table, count, exp, fixed};

/// Largest allowed imbalance where the equations of the bodies are solved directly.
const DIRECT_IMBALANCE: f64 = 1e-9;

/// Largest allowed imbalance for finite elements.
///
/// Their systems are solved to 1e-8 of the right-hand side, and forces are differences of larger
/// numbers.
const ITERATED: f64 = 1e-5;

/// Allowed growth of resident memory: a mesh-free run takes 10 MiB, finite elements 300.
const SLACK_MIB: f64 = 400.0;

/// Results of the scenes of one model in one domain.
#[derive(Default)]
struct Tally {
    scenes: usize,
    refused: usize,
    seconds: f64,
    imbalances: Imbalances,
}

/// Runs random scenes until the time is over.
///
/// # Errors
/// The first scene that violates an invariant, with its text; growing memory.
pub fn run(minutes: f64, seed: u64) -> Result<()> {
    check_memory(&run_scenes(minutes, seed, FINITE_ELEMENTS)?)
}

/// Results of each model in each domain.
type Tallies = BTreeMap<(String, &'static str), Tally>;

/// Runs random scenes with all checks except that of memory; returns seconds and MiB.
fn run_scenes(minutes: f64, seed: u64, elements: f64) -> Result<Vec<(f64, f64)>> {
    let clock = Instant::now();
    let limit = Duration::try_from_secs_f64(60.0 * minutes).context("minutes must be positive")?;
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut random = Random(seed);
    let mut tallies = Tallies::new();
    let mut refusals: BTreeMap<&'static str, usize> = BTreeMap::new();
    let mut memory: Vec<(f64, f64)> = Vec::new();
    while clock.elapsed() < limit {
        let (text, scene) = draw(&mut random, elements);
        // The model is the second table of the text.
        let kind = text.0.split("kind = \"").nth(2).unwrap_or_default();
        let kind = kind.split('"').next().unwrap_or_default().to_owned();
        let start = Instant::now();
        let on_all = results(&scene);
        let on_one = one_thread.install(|| results(&scene));
        let key = (kind.clone(), scene.domain().kind().word());
        let tally = tallies.entry(key).or_default();
        tally.scenes += 1;
        let checked = check(&kind, on_all, on_one);
        match checked.map_err(|what| anyhow!("{what}\nin the scene\n{}", text.0))? {
            Ok(imbalances) => {
                tally.imbalances.add(imbalances);
            }
            Err(reason) => {
                *refusals.entry(reason).or_default() += 1;
                tally.refused += 1;
            }
        }
        tally.seconds += start.elapsed().as_secs_f64();
        memory.extend(resident_mib().map(|mib| (clock.elapsed().as_secs_f64(), mib)));
    }
    report(&tallies, &refusals, clock.elapsed().as_secs_f64());
    Ok(memory)
}

/// Results of a scene as text, and its imbalances.
type Results = Result<(String, Imbalances), SwimError>;

/// Checks the results of a scene on all threads and on one thread: the imbalances, or the reason of
/// an expected refusal.
///
/// # Errors
/// The invariant that is violated.
fn check(
    kind: &str,
    on_all: Results,
    on_one: Results,
) -> Result<Result<Imbalances, &'static str>, String> {
    let ending = |results: &Results| match results {
        Ok((text, _)) => text.clone(),
        Err(error) => error.to_string(),
    };
    if ending(&on_all) != ending(&on_one) {
        let [all, one] = [on_all, on_one].map(|results| results.map(|_| "a solution"));
        return Err(format!(
            "one thread gives other bits than all threads: {one:?}, {all:?}"
        ));
    }
    match on_all {
        Ok((_, imbalances)) => {
            let bar = if kind == "fem" {
                ITERATED
            } else {
                DIRECT_IMBALANCE
            };
            // In this form the check fails for NaN.
            match imbalances.balance <= bar && imbalances.power <= bar {
                true => Ok(Ok(imbalances)),
                false => Err(format!("balances are violated: {imbalances:?}")),
            }
        }
        Err(error) => match expected(&error) {
            Some(reason) => Ok(Err(reason)),
            None => Err(format!("failed: {error}")),
        },
    }
}

/// All results of a scene except times, as text, and its imbalances.
fn results(scene: &Scene) -> Results {
    let mut model = choose(scene)?.model;
    if scene.gait().phases.is_empty() {
        let solution = solve_start(scene, model.as_mut())?;
        let places: Vec<_> = scene.bodies().iter().map(|b| b.position).collect();
        let imbalances = imbalances(scene, &solution, &places, &[], &[]);
        let values = format!("{:?} {:?}", solution.bodies, solution.error_estimate);
        return Ok((values, imbalances));
    }
    let mut watch = Watch {
        scene,
        imbalances: Imbalances::default(),
    };
    let mut outcome = simulate(scene, model.as_mut(), Method::Collocation, &mut watch)?;
    outcome.seconds = Default::default();
    // Debug formatting writes the shortest decimals that are read back as the same bits.
    Ok((format!("{outcome:?}"), watch.imbalances))
}

/// Reason if a valid scene may fail with this error; the path of the bodies is not known in
/// advance.
fn expected(error: &SwimError) -> Option<&'static str> {
    use mesher::GenerateError::BodiesTouch;
    use microhydro::HydroError::{GapTooNarrow, NotPositiveDefinite, TooClose};
    Some(match error {
        SwimError::Collision { .. } => "bodies touched on their way",
        SwimError::Model(ModelError::Spheres(NotPositiveDefinite { .. })) => {
            "too close for oseen or rpy"
        }
        SwimError::Model(ModelError::Spheres(TooClose { .. } | GapTooNarrow { .. })) => {
            "a gap too narrow for the accuracy"
        }
        SwimError::NotIntegrated { .. } => "not integrated to the tolerance",
        SwimError::Model(ModelError::Mesh(BodiesTouch { .. })) => "a gap too narrow for the mesh",
        _ => return None,
    })
}

fn report(tallies: &Tallies, refusals: &BTreeMap<&'static str, usize>, seconds: f64) {
    let headings = "model,domain,scenes,solves,stopped,s per scene,forces,power";
    let mut table = Table::new(headings.split(','));
    for ((model, domain), t) in tallies {
        table.push([
            model.as_str().into(),
            (*domain).into(),
            count(t.scenes),
            count(t.imbalances.solutions),
            count(t.refused),
            fixed(t.seconds / t.scenes as f64, 4),
            exp(t.imbalances.balance, 1),
            exp(t.imbalances.power, 1),
        ]);
    }
    println!("{seconds:.0} s on {}\n{}", processor(), table.markdown());
    for (reason, count) in refusals {
        println!("stopped, {reason}: {count}");
    }
}

/// Largest relative imbalances over the instantaneous solutions of a scene.
#[derive(Clone, Copy, Debug, Default)]
struct Imbalances {
    /// Forces and torques of a linkage minus its loads, over the largest force times the size.
    balance: f64,
    /// Power into the fluid minus power of joints and loads, over the sum of magnitudes of the
    /// terms.
    power: f64,
    /// Number of solutions.
    solutions: usize,
}

impl Imbalances {
    fn add(&mut self, other: Self) {
        self.balance = self.balance.max(other.balance);
        self.power = self.power.max(other.power);
        self.solutions += other.solutions;
    }
}

/// Observer of a run that records the imbalances.
struct Watch<'a> {
    scene: &'a Scene,
    imbalances: Imbalances,
}

impl Observer for Watch<'_> {
    fn solved(
        &mut self,
        span: &PhaseSpan,
        solved: &SpanSolution,
        _: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        let set = self.scene.articulation();
        let poses = set.place(&solved.state, &span.shape(solved.s))?;
        let places: Vec<_> = poses.iter().map(|pose| pose.translation.vector).collect();
        let directions = set.directions(&solved.state, &span.shape(solved.s))?;
        let rates = span.rates(0.0);
        let seen = imbalances(self.scene, &solved.solution, &places, &directions, &rates);
        self.imbalances.add(seen);
        Ok(())
    }
}

/// Imbalances of one instantaneous solution.
fn imbalances(
    scene: &Scene,
    solution: &InstantaneousSolution,
    places: &[Vector3<f64>],
    directions: &[Vector3<f64>],
    rates: &[f64],
) -> Imbalances {
    let set = scene.articulation();
    let given = scene.bodies().iter().map(|b| b.force.norm());
    let forces = solution.bodies.iter().map(|b| b.force.norm());
    let largest = forces.chain(given).fold(f64::MIN_POSITIVE, f64::max);
    let mut balance = 0.0_f64;
    for linkage in set.linkages() {
        if set.held_translation()[linkage.root] {
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
    let joints = solution.joint_loads.iter().zip(directions).zip(rates);
    let joints: f64 = joints
        .map(|((load, e), rate)| load.force.dot(e) * rate)
        .sum();
    let power = match size > 0.0 {
        true => (into_fluid - joints).abs() / size,
        false => 0.0,
    };
    Imbalances {
        balance,
        power,
        solutions: 1,
    }
}

/// Compares the peak memory of the second half of a run with that of the first.
fn check_memory(samples: &[(f64, f64)]) -> Result<()> {
    let Some(end) = samples.last().map(|s| s.0) else {
        return Ok(());
    };
    let peak = |from: f64, to: f64| {
        let within = samples
            .iter()
            .filter(|s| s.0 >= from * end && s.0 <= to * end);
        within.fold(0.0_f64, |m, s| m.max(s.1))
    };
    let (first, second) = (peak(0.0, 0.5), peak(0.5, 1.0));
    println!(
        "resident memory: at most {first:.0} MiB in the first half, {second:.0} MiB in the second, {:.0} MiB at the end, peak {:.0} MiB",
        samples.last().map_or(0.0, |s| s.1),
        swimmer::output::peak_rss_mib().unwrap_or(f64::NAN)
    );
    if second > first + SLACK_MIB {
        bail!("memory grows: {first:.0} MiB in the first half, {second:.0} MiB in the second");
    }
    Ok(())
}

/// Resident memory of this process; `None` except on Linux.
fn resident_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "slow: 3 s"]
    fn two_seconds_of_scenes_pass() {
        // Memory is not checked: it is that of the whole process, which runs other tests as well.
        run_scenes(0.03, 1, 0.0).unwrap();
    }

    #[test]
    fn growing_memory_is_an_error() {
        let flat: Vec<(f64, f64)> = (0..100).map(|k| (f64::from(k), 300.0)).collect();
        assert!(check_memory(&flat).is_ok());
        let growing: Vec<(f64, f64)> = (0..100)
            .map(|k| (f64::from(k), 300.0 + 20.0 * f64::from(k)))
            .collect();
        assert!(check_memory(&growing).is_err());
    }
}
