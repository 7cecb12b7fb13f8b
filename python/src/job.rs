//! Computations without the interpreter lock, which Ctrl-C ends within a second.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use ::design::{DesignError, DesignProgress};
use pyo3::prelude::*;
use swimmer::{MissedTarget, Motion, PhaseSpan, Scene, SpanResult, SpanSolution};

use crate::errors::{InternalError, SceneException, exception};

/// Time between two looks at signals and progress.
const TICK: Duration = Duration::from_millis(50);

/// Time in which an interrupted computation may end by itself, for example to leave a checkpoint.
const GRACE: Duration = Duration::from_millis(500);

/// The process that computed first; 0 before.
static OWNER: AtomicU32 = AtomicU32::new(0);

/// What a computation and its caller share.
#[derive(Default)]
struct Shared {
    interrupted: AtomicBool,
    done: AtomicUsize,
    total: AtomicUsize,
    text: Mutex<String>,
}

/// The progress of a computation, as the library sees it.
#[derive(Clone, Default)]
pub struct Watch {
    shared: Arc<Shared>,
    motion: Motion,
}

impl Watch {
    /// The motion of the run that was watched.
    pub fn into_motion(self) -> Motion {
        self.motion
    }

    fn say(&self, text: String) {
        *self
            .shared
            .text
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = text;
    }

    fn is_stopped(&self) -> bool {
        self.shared.interrupted.load(Ordering::Relaxed)
    }
}

impl swimmer::Progress for Watch {
    fn is_interrupted(&self) -> bool {
        self.is_stopped()
    }

    fn missed_target(&mut self, missed: &MissedTarget) {
        self.shared.done.store(0, Ordering::Relaxed);
        self.say(format!(
            "fem.target missed with fem.size_factor = {:.3}",
            missed.size_factor
        ));
    }

    fn begins(&mut self, scene: &Scene, done: usize) {
        let all = scene.gait().phases.len() * scene.gait().cycles as usize;
        self.shared.total.store(all, Ordering::Relaxed);
        self.shared.done.store(done, Ordering::Relaxed);
        self.motion = Motion::default();
    }

    fn solved(&mut self, _: &PhaseSpan, solution: &SpanSolution) {
        self.say(format!("solve {}", solution.number + 1));
    }

    fn span_done(&mut self, span: &PhaseSpan, result: &SpanResult) {
        self.motion.append(span, result);
        self.shared.done.fetch_add(1, Ordering::Relaxed);
    }
}

impl DesignProgress for Watch {
    fn is_interrupted(&self) -> bool {
        self.is_stopped()
    }

    fn counted(&mut self, what: &str, done: usize, all: usize) {
        self.shared.total.store(all, Ordering::Relaxed);
        self.shared.done.store(done, Ordering::Relaxed);
        self.say(what.to_owned());
    }

    fn begins(&mut self, what: &str) {
        self.say(what.to_owned());
    }
}

/// Runs `work` on a thread of its own, and meanwhile looks at signals.
///
/// `report` is called with the numbers of completed and of all parts, and a text. After Ctrl-C the
/// work is told to stop and the call returns; work between two looks at [`Watch`] ends later, and
/// its result is dropped.
///
/// # Errors
/// Exceptions of signal handlers and of `report`, [`exception`] for errors of the work,
/// [`InternalError`] for a panic.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    report: Option<Py<PyAny>>,
    work: impl FnOnce(Watch) -> Result<T, DesignError> + Send + 'static,
) -> PyResult<T> {
    check_process()?;
    let watch = Watch::default();
    let of_work = watch.clone();
    let (sender, mut receiver) = sync_channel(1);
    std::thread::Builder::new()
        .name("swimmer".to_owned())
        .spawn(move || {
            let result = catch_unwind(AssertUnwindSafe(|| work(of_work)));
            // Nobody receives the result of interrupted work.
            let _ = sender.send(result);
        })?;
    let mut wait = |time| {
        // Exclusive, because a receiver must not be shared between threads.
        let receiver = &mut receiver;
        py.detach(move || receiver.recv_timeout(time))
    };
    loop {
        match wait(TICK) {
            Ok(result) => return finished(result),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(InternalError::new_err(
                    "the computation ended without a result",
                ));
            }
            Err(RecvTimeoutError::Timeout) => {
                if let Err(stop) = look(py, &watch, report.as_ref()) {
                    watch.shared.interrupted.store(true, Ordering::Relaxed);
                    let _ = wait(GRACE);
                    return Err(stop);
                }
            }
        }
    }
}

/// Runs `work` in the calling thread: for work of milliseconds, to which a thread would add a part
/// of its time.
///
/// # Errors
/// Those of [`run`] without signals.
pub fn run_here<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, DesignError> + Send,
) -> PyResult<T> {
    check_process()?;
    let result = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    finished(result)
}

/// Refuses to compute in a child of a process that has computed: the threads of the pool exist in
/// the parent only, and the child would wait for them for ever. Refuses absurd numbers of threads.
fn check_process() -> PyResult<()> {
    let own = std::process::id();
    match OWNER.compare_exchange(0, own, Ordering::Relaxed, Ordering::Relaxed) {
        Err(owner) if owner != own => Err(SceneException::new_err(
            "this process was forked from one that has already computed; start processes with \
             multiprocessing.set_start_method(\"spawn\")",
        )),
        _ => swimmer::check_threads().map_err(exception),
    }
}

/// Looks for signals, and reports the progress.
fn look(py: Python<'_>, watch: &Watch, report: Option<&Py<PyAny>>) -> PyResult<()> {
    py.check_signals()?;
    if let Some(report) = report {
        let shared = &watch.shared;
        let text = shared.text.lock().unwrap_or_else(PoisonError::into_inner);
        let (done, total) = (&shared.done, &shared.total);
        let numbers = (done.load(Ordering::Relaxed), total.load(Ordering::Relaxed));
        let text = text.clone();
        report.call1(py, (numbers.0, numbers.1, text))?;
    }
    Ok(())
}

fn finished<T>(result: Result<Result<T, DesignError>, Box<dyn Any + Send>>) -> PyResult<T> {
    match result {
        Ok(result) => result.map_err(exception),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            Err(InternalError::new_err(format!(
                "a defect of the program: {}",
                text.unwrap_or("panic without a text")
            )))
        }
    }
}
