//! The flow of the last solution, for all files that show it.

use std::cell::OnceCell;

use models::{FlowField, Hydrodynamics};

/// The flow of the last solution of a model, computed at most once.
pub struct LastFlow<'a> {
    model: &'a dyn Hydrodynamics,
    flow: OnceCell<Option<FlowField>>,
}

impl<'a> LastFlow<'a> {
    /// The flow of the last solution of a model, which is not yet computed.
    pub fn new(model: &'a dyn Hydrodynamics) -> Self {
        Self {
            model,
            flow: OnceCell::new(),
        }
    }

    /// The flow; `None` for models without a mesh.
    pub fn get(&self) -> Option<&FlowField> {
        self.flow.get_or_init(|| self.model.last_flow()).as_ref()
    }

    /// The flow itself; `None` for models without a mesh.
    pub fn into_flow(self) -> Option<FlowField> {
        let Self { model, flow } = self;
        flow.into_inner().unwrap_or_else(|| model.last_flow())
    }
}
