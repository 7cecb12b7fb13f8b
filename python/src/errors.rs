//! Errors of the library as Python exceptions with the same texts.

use design::DesignError;
use pyo3::create_exception;
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use swimmer::{SceneError, SwimError};

mod exceptions {
    //! The exception types; the macro writes no documentation for the compiler.
    #![allow(missing_docs)]
    use super::{PyRuntimeError, PyValueError, create_exception};

    create_exception!(
        swimmer,
        SceneError,
        PyValueError,
        "A scene, or a call that does not fit it: the text names the place and the remedy."
    );
    create_exception!(
        swimmer,
        SolveError,
        PyRuntimeError,
        "A method that failed: the text says how, and what to change."
    );
    create_exception!(
        swimmer,
        ToleranceMissed,
        SolveError,
        "A finished run whose error bar is larger than the tolerance; `run` has the result."
    );
    create_exception!(
        swimmer,
        RunStopped,
        SolveError,
        "A run that stopped before its end, such as at contact; `run` has the result up to there."
    );
    create_exception!(
        swimmer,
        InternalError,
        PyRuntimeError,
        "A defect of the program. Please report it with the scene."
    );
}

pub use exceptions::{
    InternalError, RunStopped, SceneError as SceneException, SolveError, ToleranceMissed,
};

/// The exception for an error of a run or a design.
pub fn exception(error: impl Into<DesignError>) -> PyErr {
    let error = error.into();
    let text = error.to_string();
    match error {
        DesignError::Swim(
            SwimError::Read { source, .. }
            | SwimError::Write { source, .. }
            | SwimError::Scene(SceneError::Read { source, .. }),
        ) => {
            // The subclass of OSError for the kind, such as FileNotFoundError.
            std::io::Error::new(source.kind(), text).into()
        }
        error => match error.exit_code() {
            2 => SceneException::new_err(text),
            130 => PyKeyboardInterrupt::new_err(text),
            _ => SolveError::new_err(text),
        },
    }
}

/// The exception for a finished run whose error bar is larger than the tolerance, with the run.
pub fn tolerance_missed(missed: &SwimError, result: &Bound<'_, PyDict>) -> PyErr {
    with_result(ToleranceMissed::new_err(missed.to_string()), result)
}

/// The exception for a run that stopped before its end, with the run up to there.
pub fn run_stopped(stopped: &SwimError, result: &Bound<'_, PyDict>) -> PyErr {
    with_result(RunStopped::new_err(stopped.to_string()), result)
}

fn with_result(exception: PyErr, result: &Bound<'_, PyDict>) -> PyErr {
    let set = exception.value(result.py()).setattr("result", result);
    set.err().unwrap_or(exception)
}
