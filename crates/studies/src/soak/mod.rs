//! Long run of random scenes through all models.
//!
//! It checks balances of forces and power, that numbers are finite, that one thread gives the same
//! bits as several, and that memory does not grow.

mod invariants;
mod scenes;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use swimmer::choose;
use swimmer::models::ModelError;
use swimmer::{Method, Scene, SwimError, simulate, solve_start};

use self::invariants::{Imbalances, Watch};
use self::scenes::{FINITE_ELEMENTS, draw};
use crate::machine;
use crate::random::Random;

/// Largest allowed imbalance where the equations of the bodies are solved directly.
const DIRECT: f64 = 1e-9;

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
    solutions: usize,
    refused: usize,
    seconds: f64,
    balance: f64,
    power: f64,
}

/// Runs random scenes until the time is over.
///
/// # Errors
/// The first scene that violates an invariant, with its text; growing memory.
pub fn run(minutes: f64, seed: u64) -> Result<()> {
    check_memory(&run_scenes(minutes, seed, FINITE_ELEMENTS)?)
}

/// Runs random scenes with all checks except that of memory; returns seconds and MiB.
fn run_scenes(minutes: f64, seed: u64, elements: f64) -> Result<Vec<(f64, f64)>> {
    let clock = Instant::now();
    let limit = Duration::try_from_secs_f64(60.0 * minutes).context("minutes must be positive")?;
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut random = Random(seed);
    let mut tallies: BTreeMap<(String, &'static str), Tally> = BTreeMap::new();
    let mut refusals: BTreeMap<&'static str, usize> = BTreeMap::new();
    let mut memory: Vec<(f64, f64)> = Vec::new();
    let mut printed = Instant::now();
    while clock.elapsed() < limit {
        let (text, scene) = draw(&mut random, elements);
        let start = Instant::now();
        let wrong = |what: String| anyhow::anyhow!("{what}\nin the scene\n{text}");
        let on_all = results(&scene);
        let on_one = one_thread.install(|| results(&scene));
        let tally = tallies
            .entry((kind(&text), scene.domain().kind().word()))
            .or_default();
        tally.scenes += 1;
        match (on_all, on_one) {
            (Ok((text_on_all, imbalances)), Ok((text_on_one, _))) => {
                if text_on_all != text_on_one {
                    return Err(wrong("one thread gives other bits than all threads".into()));
                }
                let bar = if kind(&text) == "fem" {
                    ITERATED
                } else {
                    DIRECT
                };
                // In this form the check fails for NaN.
                if !(imbalances.balance <= bar && imbalances.power <= bar) {
                    return Err(wrong(format!("balances are violated: {imbalances:?}")));
                }
                tally.solutions += imbalances.solutions;
                tally.balance = tally.balance.max(imbalances.balance);
                tally.power = tally.power.max(imbalances.power);
            }
            (Err(on_all), Err(on_one)) if on_all.to_string() == on_one.to_string() => {
                let reason = expected(&on_all).ok_or_else(|| wrong(format!("failed: {on_all}")))?;
                *refusals.entry(reason).or_default() += 1;
                tally.refused += 1;
            }
            (on_all, on_one) => {
                let outcome = |r: &Result<_, SwimError>| match r {
                    Ok(_) => "a solution".to_owned(),
                    Err(error) => error.to_string(),
                };
                let (a, b) = (outcome(&on_all), outcome(&on_one));
                return Err(wrong(format!("on all threads: {a}; on one thread: {b}")));
            }
        }
        tally.seconds += start.elapsed().as_secs_f64();
        if let Some(now) = resident_mib() {
            memory.push((clock.elapsed().as_secs_f64(), now));
        }
        if printed.elapsed() > Duration::from_secs(30) {
            printed = Instant::now();
            let scenes: usize = tallies.values().map(|t| t.scenes).sum();
            eprintln!("{:.0} s, {scenes} scenes", clock.elapsed().as_secs_f64());
        }
    }
    report(&tallies, &refusals, clock.elapsed().as_secs_f64());
    Ok(memory)
}

/// Model in the text of a scene.
fn kind(text: &str) -> String {
    text.split("kind = \"").nth(2).map_or("?".into(), |rest| {
        rest.split('"').next().unwrap_or("?").to_owned()
    })
}

/// All results of a scene except times, as text, and its imbalances.
fn results(scene: &Scene) -> Result<(String, Imbalances), SwimError> {
    let mut model = choose(scene)?.model;
    if scene.gait().phases.is_empty() {
        let solution = solve_start(scene, model.as_mut())?;
        let places: Vec<_> = scene.bodies().iter().map(|b| b.position).collect();
        let imbalances = invariants::of_solution(scene, &solution, &places, &[], &[]);
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
    match error {
        SwimError::Collision { .. } => Some("bodies touched on their way"),
        SwimError::Model(ModelError::Spheres(microhydro::HydroError::NotPositiveDefinite {
            ..
        })) => Some("too close for oseen or rpy"),
        SwimError::Model(ModelError::Spheres(microhydro::HydroError::TooClose { .. })) => {
            Some("a gap too narrow for the accuracy")
        }
        SwimError::NotIntegrated { .. } => Some("not integrated to the tolerance"),
        SwimError::Model(ModelError::Mesh(mesher::GenerateError::BodiesTouch { .. })) => {
            Some("a gap too narrow for the mesh")
        }
        _ => None,
    }
}

fn report(
    tallies: &BTreeMap<(String, &'static str), Tally>,
    refusals: &BTreeMap<&'static str, usize>,
    seconds: f64,
) {
    println!("{seconds:.0} s on {}", machine::processor());
    println!("| model | domain | scenes | solves | stopped | s per scene | forces | power |");
    println!("|:--|:--|--:|--:|--:|--:|--:|--:|");
    for ((model, domain), t) in tallies {
        println!(
            "| {model} | {domain} | {} | {} | {} | {:.4} | {:.1e} | {:.1e} |",
            t.scenes,
            t.solutions,
            t.refused,
            t.seconds / t.scenes as f64,
            t.balance,
            t.power
        );
    }
    for (reason, count) in refusals {
        println!("stopped, {reason}: {count}");
    }
}

/// Compares the peak memory of the second half of a run with that of the first.
fn check_memory(samples: &[(f64, f64)]) -> Result<()> {
    let Some(end) = samples.last().map(|s| s.0) else {
        return Ok(());
    };
    let peak = |from: f64, to: f64| {
        samples
            .iter()
            .filter(|s| s.0 >= from * end && s.0 <= to * end)
            .fold(0.0_f64, |m, s| m.max(s.1))
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
    #[ignore = "two seconds, and as long as the last scene takes"]
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
