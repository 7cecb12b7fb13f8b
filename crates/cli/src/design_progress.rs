//! Progress of the design of strokes on stderr.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use design::DesignProgress;
use indicatif::{ProgressBar, ProgressStyle};

use super::run::watch_signals;
use super::text::{count, message};

/// A spinner on a terminal, a line per part of the work elsewhere.
pub struct Progress {
    spinner: Option<ProgressBar>,
    quiet: bool,
    interrupted: Arc<AtomicBool>,
}

impl Progress {
    /// Progress that Ctrl-C interrupts; nothing is printed if `quiet`.
    pub fn new(quiet: bool) -> Self {
        let spinner = (std::io::stderr().is_terminal() && !quiet).then(|| {
            let spinner = ProgressBar::new_spinner();
            // The template is constant and valid; the default style only avoids a panic.
            spinner.set_style(
                ProgressStyle::with_template("{spinner} {msg}, {elapsed} elapsed")
                    .unwrap_or_else(|_| ProgressStyle::default_spinner()),
            );
            spinner.enable_steady_tick(std::time::Duration::from_millis(200));
            spinner
        });
        Self {
            spinner,
            quiet,
            interrupted: watch_signals(),
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(spinner) = &self.spinner {
            spinner.finish_and_clear();
        }
    }
}

impl DesignProgress for Progress {
    fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    fn tabulated(&mut self, points: usize) {
        if let Some(spinner) = &self.spinner {
            spinner.set_message(format!("table: {}", count(points, "solve")));
        }
    }

    fn begins(&mut self, what: &str) {
        match &self.spinner {
            Some(spinner) => spinner.set_message(what.to_owned()),
            None if self.quiet => {}
            None => message(what),
        }
    }
}
