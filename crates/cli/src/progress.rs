//! Progress on stderr: a bar on a terminal, plain lines elsewhere.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use design::DesignProgress;
use indicatif::{ProgressBar, ProgressStyle};
#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use swimmer::{MissedTarget, PhaseSpan, Scene, SpanResult, SpanSolution};

use super::text::{count, duration, message, percent, printable, two_digits, warn};
use super::time_left::{TimeLeft, about};

/// Largest share of a phase that counts as done before it is: it takes as many solves as its
/// tolerance needs.
const LARGEST_SHARE: f64 = 0.9;

/// Progress of a run.
pub struct RunBar {
    bar: Option<ProgressBar>,
    spans: usize,
    scene: Scene,
    started: Instant,
    left: TimeLeft,
    /// Phases that are done, and the solves of those of this process.
    done: usize,
    solves_of_done: usize,
    /// Solves of the phase that is being computed, and the share of it that is done.
    solves: usize,
    share: f64,
    /// Phases that were done before this process.
    done_before: usize,
    /// Seconds at which the next line of a long phase is printed where there is no bar.
    next_line: f64,
    quiet: bool,
    /// Before the gait and after it.
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
            left: TimeLeft::default(),
            done: 0,
            solves_of_done: 0,
            solves: 0,
            share: 0.0,
            done_before: 0,
            next_line: PATIENCE.as_secs_f64(),
            quiet,
            waiting: Some(preparing(quiet)),
            interrupted,
        }
    }

    /// Says that the gait is done once more for a reason, and waits until it begins.
    fn begin_again(&mut self, reason: &str) {
        self.finish();
        self.line(&format!("{reason}, {} elapsed", self.elapsed()));
        self.waiting = Some(preparing(self.quiet));
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

    /// The share of the present phase that is done: the position `s` in time where the steps of an
    /// integration go there, else that of the solves that a phase of this run took; none of the
    /// first phase, since free joints and masses need many times as many as others.
    fn share_at(&self, s: f64) -> f64 {
        if self.scene.inertia().is_kept() || self.scene.noise().is_some() {
            return s.clamp(0.0, 1.0);
        }
        let phases = self.done - self.done_before;
        if phases == 0 {
            return 0.0;
        }
        let per_phase = self.solves_of_done as f64 / phases as f64;
        (self.solves as f64 / per_phase.max(1.0)).min(LARGEST_SHARE)
    }

    /// Words on the time left; empty without any.
    fn remaining(&mut self) -> String {
        let now = self.started.elapsed().as_secs_f64();
        let done = self.done as f64 + self.share;
        let left = self.left.at(now, done, self.spans as f64);
        left.map_or(String::new(), |left| format!(", {}", about(left)))
    }

    fn line(&self, text: &str) {
        if !self.quiet {
            message(text);
        }
    }
}

/// Waits until the gait of a run begins.
fn preparing(quiet: bool) -> Waiting {
    Waiting::new("preparing the run", quiet)
}

impl swimmer::Progress for RunBar {
    fn is_interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    fn works(&mut self, work: &str, done: f64, all: f64) {
        if self.waiting.is_none() {
            // After the gait.
            self.finish();
        }
        let waiting = self
            .waiting
            .get_or_insert_with(|| Waiting::new(work, self.quiet));
        waiting.counts(work, done, all);
    }

    fn chose_size_factor(&mut self, target: f64, size_factor: f64) {
        self.waiting = None;
        self.line(&format!(
            "chosen for fem.target = {target:e} ({}): fem.size_factor = {size_factor:.3}",
            percent(target)
        ));
        self.waiting = Some(preparing(self.quiet));
    }

    fn missed_target(&mut self, missed: &MissedTarget) {
        self.begin_again(&format!(
            "fem.size_factor = {:.3} leaves a discretisation error of {} of the net displacement",
            missed.size_factor,
            percent(missed.relative_error)
        ));
    }

    fn missed_tolerance(&mut self, error: f64, allowed: f64, tolerance_factor: f64) {
        self.begin_again(&format!(
            "the error bar is {}, {} is allowed; once more with model.tolerance_factor = {}",
            two_digits(error),
            two_digits(allowed),
            two_digits(tolerance_factor)
        ));
    }

    fn keeps_term(&mut self, reason: &str) {
        self.begin_again(&format!("{reason}; once more with it"));
    }

    fn searched_cycle(&mut self, cycles: usize, remains: f64, allowed: f64) {
        if let Some(waiting) = &self.waiting {
            let cycles = count(cycles, "cycle");
            waiting.says(&match remains.is_finite() {
                false => format!("{cycles} before the periodic state"),
                true => format!(
                    "{cycles} before the periodic state, {} from it, {} allowed",
                    two_digits(remains),
                    two_digits(allowed)
                ),
            });
        }
    }

    fn begins(&mut self, _: &Scene, done: usize) {
        self.waiting = None;
        (self.done, self.done_before) = (done, done);
        (self.solves, self.solves_of_done, self.share) = (0, 0, 0.0);
        self.left = TimeLeft::default();
        let _ = self.remaining();
        self.bar = (std::io::stderr().is_terminal() && !self.quiet).then(|| {
            let bar = ProgressBar::new(self.spans as u64);
            let template = "{bar:30} {pos}/{len} phases, {elapsed} elapsed{msg}";
            tick(&bar, template);
            bar.set_position(done as u64);
            bar
        });
        if done > 0 && self.bar.is_none() {
            self.line(&format!("resuming after {done} of {} phases", self.spans));
        }
    }

    fn solved(&mut self, span: &PhaseSpan, solution: &SpanSolution) {
        self.solves += 1;
        // A step that is repeated goes back.
        self.share = self.share.max(self.share_at(solution.s));
        let remaining = self.remaining();
        if let Some(bar) = &self.bar {
            bar.set_message(format!(
                "{remaining}; {}: solve {} ({})",
                self.joint_name(span),
                solution.number + 1,
                count(solution.solution.solver.iterations, "iteration")
            ));
        } else if self.started.elapsed().as_secs_f64() >= self.next_line {
            self.next_line = 2.0 * self.started.elapsed().as_secs_f64();
            self.line(&format!(
                "phase {}/{} ({}): {} so far, {} elapsed{remaining}",
                span.number + 1,
                self.spans,
                self.joint_name(span),
                count(self.solves, "solve"),
                self.elapsed(),
            ));
        }
    }

    fn span_done(&mut self, span: &PhaseSpan, result: &SpanResult) {
        self.done = span.number + 1;
        self.solves_of_done += self.solves;
        (self.solves, self.share) = (0, 0.0);
        self.next_line = 2.0 * self.started.elapsed().as_secs_f64();
        let remaining = self.remaining();
        match &self.bar {
            Some(bar) => bar.inc(1),
            None => self.line(&format!(
                "phase {}/{} ({}): {}, {} elapsed{remaining}",
                span.number + 1,
                self.spans,
                self.joint_name(span),
                count(result.solves, "solve"),
                self.elapsed(),
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

/// Time between two looks at a prediction on a terminal.
const LOOK: Duration = Duration::from_secs(1);

/// Says on stderr what some work is if it takes more than two seconds, until it is dropped: by a
/// spinner on a terminal, by lines at doubling times elsewhere; with the time left where that is
/// known.
pub struct Waiting {
    /// Closed at the end of the work.
    done: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
    work: Arc<Mutex<Work>>,
    started: Instant,
}

/// Work that goes on, in seconds since it began.
struct Work {
    what: String,
    left: TimeLeft,
    /// Predicted end, if there is a prediction.
    end: Option<f64>,
}

impl Work {
    fn new(what: &str) -> Self {
        Self {
            what: what.to_owned(),
            left: TimeLeft::default(),
            end: None,
        }
    }

    /// The work goes on with this; `done` of `all` parts of it are done, none are counted if `all`
    /// is zero.
    fn goes_on(&mut self, now: f64, what: &str, done: f64, all: f64) {
        what.clone_into(&mut self.what);
        if all > 0.0 {
            let left = self.left.at(now, done, all);
            self.end = left.map(|left| now + left);
        } else {
            (self.left, self.end) = (TimeLeft::default(), None);
        }
    }

    /// What the work is, with the time left where it is known.
    fn words(&self, now: f64) -> String {
        let left = self.end.map(|end| end - now).filter(|left| *left > 0.0);
        let left = left.map_or(String::new(), |left| format!(", {}", about(left)));
        printable(&self.what) + &left
    }
}

impl Waiting {
    /// Work begins; nothing is said if `quiet`.
    pub fn new(what: &str, quiet: bool) -> Self {
        let work = Arc::new(Mutex::new(Work::new(what)));
        let started = Instant::now();
        let (done, waits) = std::sync::mpsc::channel::<()>();
        let shown = Arc::clone(&work);
        let show = move || {
            let mut patience = PATIENCE;
            let mut spinner = None;
            while waits.recv_timeout(patience) == Err(RecvTimeoutError::Timeout) {
                let seconds = started.elapsed().as_secs_f64();
                let words = locked(&shown).words(seconds);
                if std::io::stderr().is_terminal() {
                    let spinner = spinner.get_or_insert_with(|| {
                        let spinner = ProgressBar::new_spinner().with_elapsed(started.elapsed());
                        tick(&spinner, "{spinner} {msg}, {elapsed} elapsed");
                        spinner
                    });
                    spinner.set_message(words);
                    patience = LOOK;
                } else {
                    message(&format!("{words}, {} elapsed", duration(seconds)));
                    patience = started.elapsed();
                }
            }
            if let Some(spinner) = spinner {
                spinner.finish_and_clear();
            }
        };
        let thread = (!quiet).then(|| std::thread::Builder::new().spawn(show));
        Self {
            done: Some(done),
            // Without a thread the work is done in silence.
            thread: thread.and_then(Result::ok),
            work,
            started,
        }
    }

    /// The work goes on with this, of which no parts are counted.
    pub fn says(&self, what: &str) {
        self.counts(what, 0.0, 0.0);
    }

    /// The work goes on with this, of which so many parts of all are done.
    pub fn counts(&self, what: &str, done: f64, all: f64) {
        let now = self.started.elapsed().as_secs_f64();
        locked(&self.work).goes_on(now, what, done, all);
    }

    /// The work is predicted to take so many seconds from now on.
    pub fn predicts(&self, seconds: f64) {
        // Not a number would be a time that never ends.
        let end = self.started.elapsed().as_secs_f64() + seconds;
        locked(&self.work).end = Some(end).filter(|end| end.is_finite());
    }
}

/// Progress of work without a gait.
impl swimmer::Progress for &Waiting {
    fn works(&mut self, work: &str, done: f64, all: f64) {
        self.counts(work, done, all);
    }
}

/// The work in a lock, which no panic leaves half written.
fn locked(work: &Mutex<Work>) -> MutexGuard<'_, Work> {
    work.lock().unwrap_or_else(PoisonError::into_inner)
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
    /// What is being done, and the parts of it in words.
    what: String,
    counted: String,
    started: Instant,
    left: TimeLeft,
    /// Seconds at which the next line about parts is printed where there is no spinner.
    next_line: f64,
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
            what: String::new(),
            counted: String::new(),
            started: Instant::now(),
            left: TimeLeft::default(),
            next_line: PATIENCE.as_secs_f64(),
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

    fn counted(&mut self, what: &str, done: usize, all: usize) {
        let now = self.started.elapsed().as_secs_f64();
        let left = self.left.at(now, done as f64, all as f64);
        let left = left.map_or(String::new(), |left| format!(", {}", about(left)));
        self.counted = match done < all {
            true => format!("{done} of {all} {what}{left}"),
            // The next part of the work says what it is.
            false => String::new(),
        };
        if self.spinner.is_some() {
            self.show();
        } else if !self.quiet && now >= self.next_line && done < all {
            self.next_line = 2.0 * now;
            message(&format!("{}, {} elapsed", self.counted, duration(now)));
        }
    }

    fn begins(&mut self, what: &str) {
        what.clone_into(&mut self.what);
        match &self.spinner {
            Some(_) => self.show(),
            None if self.quiet => {}
            None => message(what),
        }
    }
}

impl DesignSpinner {
    /// Shows what is being done.
    fn show(&self) {
        if let Some(spinner) = &self.spinner {
            let words = [&self.what, &self.counted];
            let words = words.into_iter().filter(|words| !words.is_empty());
            let words: Vec<&str> = words.map(String::as_str).collect();
            spinner.set_message(printable(&words.join(", ")));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_says_what_it_is_and_the_time_left_where_parts_are_counted() {
        let mut work = Work::new("choosing the model");
        assert_eq!(work.words(9.0), "choosing the model");
        work.goes_on(10.0, "the first trial", 0.0, 4.0);
        assert_eq!(work.words(20.0), "the first trial");
        work.goes_on(20.0, "the second trial", 2.0, 4.0);
        assert_eq!(work.words(20.0), "the second trial, about 10 s left");
        assert_eq!(work.words(25.5), "the second trial, about 5 s left");
        // It takes longer than predicted.
        assert_eq!(work.words(31.0), "the second trial");
        // Other work, of which nothing is counted.
        work.goes_on(22.0, "solving", 0.0, 0.0);
        assert_eq!(work.words(23.0), "solving");
        // Words of a scene may not control the terminal.
        work.goes_on(24.0, "the phase \u{1b}[2J", 0.0, 0.0);
        assert!(!work.words(24.0).contains('\u{1b}'));
    }
}
