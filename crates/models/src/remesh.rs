//! Reasons for new meshes and for other ways to move a mesh, and their record.

use serde::{Deserialize, Serialize};

/// Why the mesh of a configuration was not obtained by moving an existing one as before.
///
/// A new mesh was generated, or the mesh of a file was moved by another method.
#[derive(Clone, Debug, PartialEq)]
pub enum Remesh {
    /// There was no mesh before.
    First,
    /// A cell would have been inverted by the motion.
    Inverted,
    /// The smallest Jacobian of a curved cell, relative to the straight cell, was too small.
    Jacobian(f64),
    /// The smallest mean ratio of a cell was too small.
    Quality(f64),
    /// Cells in a gap were too long: their length relative to the width of the gap.
    Gap(f64),
    /// A body was too close to an end of the meshed part of a cylinder: their distance in radii.
    End(f64),
    /// The mesh of a file was moved by another method than before.
    Motion {
        /// Name of the method, a value of `fem.mesh_motion`.
        name: &'static str,
        /// The methods before, each with the reason why its mesh was too poor.
        tried: String,
    },
    /// The fluid between the walls of a file and the bodies was meshed again.
    InsideFile {
        /// The methods that moved the mesh of the file, each with the reason why it was too poor.
        tried: String,
    },
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
                "the meshed part of the cylinder ends {distance:.2} radii from a body"
            ),
            Self::Motion { name, tried } => {
                write!(f, "mesh of the file moved by {name} ({tried})")
            }
            Self::InsideFile { tried } => {
                write!(f, "meshed again inside the walls of the file ({tried})")
            }
        }
    }
}

/// A mesh that was generated during a run, or a change of the method that moves the mesh of a file.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct NewMesh {
    /// Time of the configuration that it was needed for.
    pub time: f64,
    /// Number of the phase, counted from one over all cycles.
    pub phase: usize,
    /// Why it was needed.
    pub reason: String,
}
