//! Progress of the design of strokes.

/// Callbacks that inform the caller about the progress, and stop the work.
pub trait DesignProgress {
    /// Whether the work is to stop; checked after every solve and search.
    fn is_interrupted(&self) -> bool {
        false
    }

    /// The model has been solved for this number of shapes.
    fn tabulated(&mut self, points: usize) {
        let _ = points;
    }

    /// A part of the work begins.
    fn begins(&mut self, what: &str) {
        let _ = what;
    }
}

/// No callbacks.
impl DesignProgress for () {}
