//! Progress on stderr: a bar on a terminal, plain lines elsewhere.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use design::DesignProgress;
use indicatif::{ProgressBar, ProgressStyle};
#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use swimmer::{MissedTarget, PhaseSpan, Scene, SpanResult, SpanSolution};

use super::text::{count, duration, message, percent, printable, two_digits, warn};

/// Progress of a run.
pub struct RunBar {
    bar: Option<ProgressBar>,
    spans: usize,
    scene: Scene,
    started: Instant,
    /// When the gait began or was continued, and the phases that were done then.
    begun: (Instant, usize),
    quiet: bool,
    /// Until the gait begins; none if nothing is printed.
    waiting: Option<Waiting>,
    /// Set when the user interrupts the run.
    interrupted: Arc<AtomicBool>,
}

impl RunBar {
    /// Progress of the run of a scene that `interrupted` stops; nothing is printed if `quiet`.
    pub fn new(scene: &Scene, interrupted: Arc<AtomicBool>, quiet: bool) -> Self {
        let spans = scene.gait().phases.len() * scene.gait().cycles as usize;
        Self {
            bar: None,
            spans,
            scene: scene.clone(),
            started: Instant::now(),
            begun: (Instant::now(), 0),
            quiet,
            waiting: (!quiet).then(|| Waiting::new("preparing the run")),
            interrupted,
        }
    }

    /// Removes the bar.
    pub fn finish(&mut self) {
        self.waiting = None;
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    fn joint_name(&self, span: &PhaseSpan) -> String {
        printable(&self.scene.joint_label(&span.joints))
    }

    fn elapsed(&self) -> String {
        duration(self.started.elapsed().as_secs_f64())
    }

    /// Words on the time that the phases after the first `done` take, if they take as long as
    /// those of this process; empty after the last one.
    fn remaining(&self, done: usize) -> String {
        let (begun, done_before) = self.begun;
        let per_phase = begun.elapsed().as_secs_f64() / (done - done_before).max(1) as f64;
        match self.spans - done {
            0 => String::new(),
            phases => format!(", {} remaining", duration(per_phase * phases as f64)),
        }
    }

    fn line(&self, text: &str) {
        if !self.quiet {
            message(text);
        }
    }
}

impl swimmer::Progress for RunBar {
    fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    fn chose_size_factor(&mut self, target: f64, size_factor: f64) {
        self.waiting = None;
        self.line(&format!(
            "chosen for fem.target = {target:e} ({}): fem.size_factor = {size_factor:.3}",
            percent(target)
        ));
    }

    fn missed_target(&mut self, missed: &MissedTarget) {
        self.finish();
        self.line(&format!(
            "fem.size_factor = {:.3} leaves a discretisation error of {} of the net displacement, \
             {} elapsed",
            missed.size_factor,
            percent(missed.relative_error),
            self.elapsed()
        ));
    }

    fn missed_tolerance(&mut self, error: f64, allowed: f64, tolerance_factor: f64) {
        self.finish();
        self.line(&format!(
            "the error bar is {}, {} is allowed; once more with model.tolerance_factor = \
             {}, {} elapsed",
            two_digits(error),
            two_digits(allowed),
            two_digits(tolerance_factor),
            self.elapsed()
        ));
    }

    fn keeps_term(&mut self, reason: &str) {
        self.finish();
        self.line(&format!(
            "{reason}; once more with it, {} elapsed",
            self.elapsed()
        ));
    }

    fn begins(&mut self, _: &Scene, done: usize) {
        self.waiting = None;
        self.begun = (Instant::now(), done);
        self.bar = (std::io::stderr().is_terminal() && !self.quiet).then(|| {
            let bar = ProgressBar::new(self.spans as u64);
            let template = "{bar:30} {pos}/{len} phases, {msg}, {elapsed} elapsed, {eta} remaining";
            tick(&bar, template);
            bar.set_position(done as u64);
            bar
        });
        if done > 0 && self.bar.is_none() {
            self.line(&format!("resuming after {done} of {} phases", self.spans));
        }
    }

    fn solved(&mut self, span: &PhaseSpan, solution: &SpanSolution) {
        if let Some(bar) = &self.bar {
            bar.set_message(format!(
                "{}: solve {} ({})",
                self.joint_name(span),
                solution.number + 1,
                count(solution.solution.solver.iterations, "iteration")
            ));
        }
    }

    fn span_done(&mut self, span: &PhaseSpan, result: &SpanResult) {
        match &self.bar {
            Some(bar) => bar.inc(1),
            None => self.line(&format!(
                "phase {}/{} ({}): {}, {} elapsed{}",
                span.number + 1,
                self.spans,
                self.joint_name(span),
                count(result.solves, "solve"),
                self.elapsed(),
                self.remaining(span.number + 1),
            )),
        }
    }
}

/// Makes the loss of the terminal (SIGHUP) set a flag, unless it is ignored, as `nohup` does.
///
/// Where the system does not show what is ignored, the signal ends the program as before. Shells
/// repeat it, so a second one does not end the program at once.
#[cfg(unix)]
fn watch_hangup(interrupted: &Arc<AtomicBool>) -> std::io::Result<()> {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    if mask.is_some_and(|mask| mask >> (SIGHUP - 1) & 1 == 0) {
        signal_hook::flag::register(SIGHUP, interrupted.clone())?;
    }
    Ok(())
}

/// Makes a file that exceeds the size limit of the shell an error when it is written, where the
/// signal SIGXFSZ would end the program without a word.
pub fn watch_file_limit() {
    // Without the handler the signal ends the program as before.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
}

/// A flag that the first Ctrl-C or termination signal sets, whose second ends the program at once,
/// and the loss of the terminal.
pub fn watch_signals() -> Arc<AtomicBool> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let register = || -> std::io::Result<()> {
        for signal in [SIGINT, SIGTERM] {
            // The order matters: the shutdown must read the flag before this signal sets it.
            signal_hook::flag::register_conditional_shutdown(signal, 130, interrupted.clone())?;
            signal_hook::flag::register(signal, interrupted.clone())?;
        }
        #[cfg(unix)]
        watch_hangup(&interrupted)?;
        Ok(())
    };
    if let Err(error) = register() {
        warn(&format!(
            "cannot handle signals ({error}): Ctrl-C ends the run at once and the current phase \
             is lost; --resume continues with the last completed phase"
        ));
    }
    interrupted
}

/// Time after which work says what it is.
const PATIENCE: Duration = Duration::from_secs(2);

/// Does some work and says on stderr what it is, as [`Waiting`], unless `quiet`.
pub fn with_progress<T>(what: &str, quiet: bool, work: impl FnOnce() -> T) -> T {
    let _waiting = (!quiet).then(|| Waiting::new(what));
    work()
}

/// Says on stderr what some work is if it takes more than two seconds, until it is dropped: by a
/// spinner on a terminal, by lines at doubling times elsewhere.
struct Waiting {
    /// Closed at the end of the work.
    done: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Waiting {
    fn new(what: &str) -> Self {
        let what = what.to_owned();
        let (done, waits) = std::sync::mpsc::channel::<()>();
        let thread = std::thread::Builder::new().spawn(move || {
            let started = Instant::now();
            let mut patience = PATIENCE;
            let mut spinner = None;
            while waits.recv_timeout(patience) == Err(RecvTimeoutError::Timeout) {
                if std::io::stderr().is_terminal() {
                    spinner.get_or_insert_with(|| {
                        let spinner = ProgressBar::new_spinner();
                        tick(&spinner, "{spinner} {msg}, {elapsed} elapsed");
                        spinner.with_message(what.clone())
                    });
                } else {
                    let elapsed = duration(started.elapsed().as_secs_f64());
                    message(&format!("{what}, {elapsed} elapsed"));
                }
                patience = started.elapsed();
            }
            if let Some(spinner) = spinner {
                spinner.finish_and_clear();
            }
        });
        Self {
            done: Some(done),
            // Without a thread the work is done in silence.
            thread: thread.ok(),
        }
    }
}

impl Drop for Waiting {
    fn drop(&mut self) {
        self.done = None;
        if let Some(thread) = self.thread.take() {
            // It only prints, and a failure to do so ends no work.
            let _ = thread.join();
        }
    }
}

/// Shows a bar by a template, with a time that goes on.
fn tick(bar: &ProgressBar, template: &str) {
    // The template is constant and valid; the default style only avoids a panic.
    let style = ProgressStyle::with_template(template);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(200));
}

/// A spinner on a terminal, a line per part of the work elsewhere.
pub struct DesignSpinner {
    spinner: Option<ProgressBar>,
    quiet: bool,
    interrupted: Arc<AtomicBool>,
}

impl DesignSpinner {
    /// Progress that Ctrl-C interrupts; nothing is printed if `quiet`.
    pub fn new(quiet: bool) -> Self {
        let spinner = (std::io::stderr().is_terminal() && !quiet).then(|| {
            let spinner = ProgressBar::new_spinner();
            tick(&spinner, "{spinner} {msg}, {elapsed} elapsed");
            spinner
        });
        Self {
            spinner,
            quiet,
            interrupted: watch_signals(),
        }
    }
}

impl Drop for DesignSpinner {
    fn drop(&mut self) {
        if let Some(spinner) = &self.spinner {
            spinner.finish_and_clear();
        }
    }
}

impl DesignProgress for DesignSpinner {
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
            Some(spinner) => spinner.set_message(printable(what)),
            None if self.quiet => {}
            None => message(what),
        }
    }
}
