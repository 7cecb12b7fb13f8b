//! The two precisions of the kernels.

use std::ops::{Add, AddAssign, Mul, Sub};

/// `f64` for operators, `f32` inside preconditioners.
pub(crate) trait Scalar:
    Copy
    + Send
    + Sync
    + Default
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + AddAssign
{
    fn to_f64(self) -> f64;
}

impl Scalar for f32 {
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

impl Scalar for f64 {
    fn to_f64(self) -> f64 {
        self
    }
}
