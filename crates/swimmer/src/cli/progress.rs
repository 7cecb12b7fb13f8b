//! Progress on stderr: a bar on a terminal, plain lines elsewhere.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use swimmer::{Leg, LegResult, LegSolution, Scene, Trial};

pub struct Progress {
    bar: Option<ProgressBar>,
    legs: usize,
    links: Vec<String>,
    started: Instant,
    /// Raised when the user wants the run to end.
    interrupted: Arc<AtomicBool>,
}

impl Progress {
    pub fn new(scene: &Scene, interrupted: Arc<AtomicBool>) -> Self {
        let legs = scene.gait().phases.len() * scene.gait().cycles as usize;
        let links = scene.articulation().links();
        Self {
            bar: None,
            legs,
            links: links.iter().map(|link| link.name.clone()).collect(),
            started: Instant::now(),
            interrupted,
        }
    }

    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    fn what(&self, leg: &Leg) -> &str {
        leg.link.map_or("lengths held", |link| &self.links[link])
    }

    fn elapsed(&self) -> String {
        super::duration(self.started.elapsed().as_secs_f64())
    }
}

impl swimmer::Progress for Progress {
    fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    fn tried(&mut self, trial: &Trial) {
        super::say(&format!(
            "a stroke with elements {:.2} times the default ones errs by {:.1e} by the mesh, {}",
            trial.size_factor,
            trial.relative_error,
            self.elapsed()
        ));
    }

    fn chose_size_factor(&mut self, target: f64, size_factor: f64) {
        super::say(&format!(
            "fem.target = {target:e} asks for fem.size_factor = {size_factor:.3}"
        ));
    }

    fn begins(&mut self, _: &Scene, done: usize) {
        self.bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(self.legs as u64);
            let template = "{bar:30} phase {pos}/{len} done, {msg}, {elapsed} elapsed, {eta} to go";
            // The template is a constant: if it were wrong, the default bar would do.
            bar.set_style(
                ProgressStyle::with_template(template)
                    .unwrap_or_else(|_| ProgressStyle::default_bar()),
            );
            bar.enable_steady_tick(std::time::Duration::from_millis(200));
            bar.set_position(done as u64);
            bar
        });
        if done > 0 && self.bar.is_none() {
            super::say(&format!("going on after {done} of {} phases", self.legs));
        }
    }

    fn solved(&mut self, leg: &Leg, solved: &LegSolution) {
        if let Some(bar) = &self.bar {
            bar.set_message(format!(
                "{}: solve {} ({} iterations)",
                self.what(leg),
                solved.number + 1,
                solved.solution.solver.iterations
            ));
        }
    }

    fn leg_done(&mut self, leg: &Leg, result: &LegResult) {
        match &self.bar {
            Some(bar) => bar.inc(1),
            None => super::say(&format!(
                "phase {}/{} {}: {} solves, {} elapsed",
                leg.number + 1,
                self.legs,
                self.what(leg),
                result.solves,
                self.elapsed(),
            )),
        }
    }
}
