//! The joints of scene files: words, the keys that belong to each, and the motions that they mean.
//!
//! What depends on the word of a joint stands here, in functions that list all words or all kinds.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rigid::JointKind;
use serde::{Deserialize, Serialize};
use strum::VariantNames;

use crate::keys::{KeyType, Kind, Words};
use crate::words::words;

words! {
    /// Relative motion that a joint allows.
    pub enum JointWord = Slide {
        /// The distance of the two centres changes along their line.
        Slide,
        /// Rotation about an axis through a pivot.
        Hinge,
        /// Rotation about an axis through the centre of the body.
        Rotor,
        /// Free rotation about a pivot.
        Ball,
        /// Rotation about an axis with a proportional translation along it.
        Screw,
        /// No relative motion.
        Fixed,
        /// Two spheres exchange volume; the sum of both stays. It does not hold them together.
        Exchange,
    }
}

impl JointWord {
    /// The keys that belong to the joint, in addition to those of all joints.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Slide | Self::Fixed | Self::Exchange => &[],
            Self::Hinge | Self::Rotor => &["axis", "pivot"],
            Self::Screw => &["axis", "pivot", "pitch"],
            Self::Ball => &["pivot"],
        }
    }
}

/// The word of a joint and its keys.
#[derive(Clone, Copy, Default)]
pub(crate) struct JointKeys {
    pub word: JointWord,
    pub axis: Option<[f64; 3]>,
    pub pivot: Option<[f64; 3]>,
    pub pitch: Option<f64>,
}

impl JointKeys {
    /// The relative motion that a joint between bodies at the positions `body` and `to` allows.
    ///
    /// Hinges and balls turn about the position of `to` unless a pivot is given, rotors and screws
    /// about an axis through `body`, from `to` to `body` unless one is given.
    ///
    /// # Errors
    /// A key and its problem.
    pub fn kind(
        &self,
        body: Vector3<f64>,
        to: Vector3<f64>,
    ) -> Result<JointKind, (&'static str, String)> {
        for (name, is_given) in [
            ("axis", self.axis.is_some()),
            ("pivot", self.pivot.is_some()),
            ("pitch", self.pitch.is_some()),
        ] {
            if is_given && !self.word.keys().contains(&name) {
                let word = self.word.word();
                return Err((
                    name,
                    format!("is no part of the joint \"{word}\"; remove it"),
                ));
            }
        }
        let pivot = |default| self.pivot.map_or(default, Vector3::from);
        let axis = |default: Option<Vector3<f64>>| {
            let problem = |problem: &str| ("axis", problem.to_owned());
            let axis = self.axis.map(Vector3::from).or(default);
            let axis = axis.ok_or_else(|| problem("is missing: the axis of rotation"))?;
            let unit = axis.try_normalize(0.0);
            unit.ok_or_else(|| problem("has no direction; it must not be zero"))
        };
        let turn = |axis, pivot, advance| JointKind::Turn {
            axis,
            pivot,
            advance,
        };
        let line = (body - to)
            .try_normalize(0.0)
            .filter(|line| line.iter().all(|x| x.is_finite()));
        Ok(match self.word {
            JointWord::Slide => JointKind::Slide,
            JointWord::Fixed => JointKind::Fixed,
            JointWord::Exchange => JointKind::Deformation { length_power: 3 },
            JointWord::Hinge => turn(axis(None)?, pivot(to), 0.0),
            JointWord::Rotor => turn(axis(line)?, pivot(body), 0.0),
            JointWord::Screw => {
                let problem = "is missing: the translation along the axis per turn";
                let pitch = self.pitch.ok_or_else(|| ("pitch", problem.to_owned()))?;
                turn(axis(line)?, pivot(body), pitch / TAU)
            }
            JointWord::Ball => JointKind::Ball { pivot: pivot(to) },
        })
    }

    /// The keys of a kind of joint.
    pub fn from_kind(kind: &JointKind) -> Self {
        match *kind {
            JointKind::Slide => Self::default(),
            JointKind::Fixed => Self {
                word: JointWord::Fixed,
                ..Self::default()
            },
            JointKind::Deformation { .. } => Self {
                word: JointWord::Exchange,
                ..Self::default()
            },
            JointKind::Ball { pivot } => Self {
                word: JointWord::Ball,
                pivot: Some(pivot.into()),
                ..Self::default()
            },
            JointKind::Turn {
                axis,
                pivot,
                advance,
            } => Self {
                word: match advance {
                    0.0 => JointWord::Hinge,
                    _ => JointWord::Screw,
                },
                axis: Some(axis.into()),
                pivot: Some(pivot.into()),
                pitch: (advance != 0.0).then_some(TAU * advance),
            },
        }
    }

    /// The lengths of a joint with their keys.
    pub fn lengths(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let pivot = self.pivot.map(|pivot| Vector3::from(pivot).amax());
        let all = [("pivot", pivot), ("pitch", self.pitch.map(f64::abs))];
        all.into_iter()
            .filter_map(|(key, length)| Some((key, length?)))
    }
}
