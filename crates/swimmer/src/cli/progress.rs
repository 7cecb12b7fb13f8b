//! Progress on stderr: a bar on a terminal, plain lines elsewhere.

use std::io::IsTerminal;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use swimmer::{Leg, LegResult, Scene};

pub struct Progress {
    bar: Option<ProgressBar>,
    legs: usize,
    links: Vec<String>,
    started: Instant,
}

impl Progress {
    pub fn new(scene: &Scene) -> Self {
        let legs = scene.gait.phases.len() * scene.gait.cycles as usize;
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(legs as u64);
            let template = "{bar:30} phase {pos}/{len} done, {msg}, {elapsed} elapsed, {eta} to go";
            // The template is a constant: if it were wrong, the default bar would do.
            bar.set_style(
                ProgressStyle::with_template(template)
                    .unwrap_or_else(|_| ProgressStyle::default_bar()),
            );
            bar.enable_steady_tick(std::time::Duration::from_millis(200));
            bar
        });
        let links = scene
            .articulation
            .links()
            .iter()
            .map(|link| link.name.clone())
            .collect();
        Self {
            bar,
            legs,
            links,
            started: Instant::now(),
        }
    }

    pub fn solved(&self, leg: &Leg, number: usize, iterations: usize) {
        if let Some(bar) = &self.bar {
            bar.set_message(format!(
                "{}: solve {} ({iterations} iterations)",
                self.what(leg),
                number + 1
            ));
        }
    }

    /// Counts the phases that an earlier run has done.
    pub fn resumed(&self, done: usize) {
        match &self.bar {
            Some(bar) => bar.set_position(done as u64),
            None => super::say(&format!("going on after {done} of {} phases", self.legs)),
        }
    }

    pub fn leg_done(&self, leg: &Leg, result: &LegResult) {
        match &self.bar {
            Some(bar) => bar.inc(1),
            None => super::say(&format!(
                "phase {}/{} {}: {} solves, {} elapsed",
                leg.number + 1,
                self.legs,
                self.what(leg),
                result.solves,
                super::duration(self.started.elapsed().as_secs_f64()),
            )),
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
}
