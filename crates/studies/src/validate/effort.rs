//! Size of the validation.

/// How much to compute.
#[derive(Clone, Copy, PartialEq)]
pub enum Effort {
    /// Under two minutes on two cores.
    Quick,
    /// Finer meshes, closer spheres, more strokes.
    Full,
}
