//! Why meshes are made anew, and the record of it.

use serde::{Deserialize, Serialize};

/// Why the mesh of an instant was made anew instead of moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Remesh {
    /// There was none.
    First,
    /// A cell would have been inverted.
    Inverted,
    /// The smallest Jacobian of a curved cell, over that of the straight one, fell too low.
    Jacobian(f64),
    /// The smallest mean ratio of a cell fell too low.
    Quality(f64),
    /// Cells in a gap became so long against its width.
    Gap(f64),
    /// The bodies came so many radii near to an end of the piece of a cylinder that was meshed.
    End(f64),
}

impl std::fmt::Display for Remesh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::First => write!(f, "first mesh"),
            Self::Inverted => write!(f, "a moved cell would be inverted"),
            Self::Jacobian(value) => write!(f, "smallest Jacobian of a moved cell {value:.3}"),
            Self::Quality(value) => write!(f, "smallest quality of a moved cell {value:.3}"),
            Self::Gap(ratio) => write!(
                f,
                "moved cells {ratio:.2} times as long as their gap is wide"
            ),
            Self::End(distance) => write!(
                f,
                "the meshed piece of the cylinder ends {distance:.2} radii from a body"
            ),
        }
    }
}

/// A mesh that was made during a run.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct NewMesh {
    /// Time of the shape it was made for.
    pub time: f64,
    /// Number of the phase, from one, over all cycles.
    pub phase: usize,
    /// Why.
    pub reason: String,
}
