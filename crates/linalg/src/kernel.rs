//! Kernels that the roofline study measures, with their memory traffic.

/// A kernel of the block solver and its least memory traffic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kernel {
    /// Name of the computation.
    pub name: &'static str,
    /// Bytes that must be read or written once.
    ///
    /// Matrices with columns and row pointers, and vectors. A cache line that is overwritten counts
    /// once, as in STREAM (McCalpin 1995).
    pub bytes: usize,
    /// Number of separate runs per iteration of [`fgmres`](crate::fgmres).
    ///
    /// Zero for sums of other kernels.
    pub runs: f64,
}

/// Receives a kernel and a function that runs it.
pub type Measure<'a> = dyn FnMut(Kernel, &mut dyn FnMut()) + 'a;
