//! Python bindings of microswim: the extension module `swimmer._swimmer`.
//!
//! Functions return dictionaries of numbers and arrays; the Python package `swimmer` gives them
//! their types and their documentation.
#![forbid(unsafe_code)]

mod convert;
mod design;
mod errors;
mod job;
mod motion;
mod scene;

use pyo3::prelude::*;

/// The extension module.
#[pymodule]
mod _swimmer {
    use pyo3::prelude::*;

    use crate::errors::{InternalError, RunStopped, SceneException, SolveError, ToleranceMissed};

    #[pymodule_export]
    use crate::design::PyStrokeMap;
    #[pymodule_export]
    use crate::motion::PyMotion;
    #[pymodule_export]
    use crate::scene::PyScene;

    /// Names and texts of the example scenes.
    #[pyfunction]
    fn templates() -> Vec<(&'static str, &'static str)> {
        swimmer::TEMPLATES.to_vec()
    }

    /// Panics in a computation, for the test of the exception that it becomes.
    #[pyfunction]
    fn panic_for_test(py: Python<'_>, text: String) -> PyResult<()> {
        crate::job::run(py, None, move |_| panic!("{text}"))
    }

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let py = module.py();
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("SceneError", py.get_type::<SceneException>())?;
        module.add("SolveError", py.get_type::<SolveError>())?;
        module.add("RunStopped", py.get_type::<RunStopped>())?;
        module.add("ToleranceMissed", py.get_type::<ToleranceMissed>())?;
        module.add("InternalError", py.get_type::<InternalError>())
    }
}
