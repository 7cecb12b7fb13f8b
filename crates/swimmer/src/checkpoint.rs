//! Checkpoints: what a run needs to go on where it was, bit for bit.
//!
//! A checkpoint is taken between legs. Numbers are written in the shortest decimals that read back as the same bits, and
//! the model's history is part of it, so an interrupted and resumed run ends as one that never stopped.

use std::path::Path;

use nalgebra::{Isometry3, UnitQuaternion};
use rigid::State;
use serde::{Deserialize, Serialize};

use crate::outcome::{Interim, Outcome};
use crate::{Folder, SwimError};
use models::{History, Hydrodynamics};
use scene::Scene;

/// Name of the file in the output folder.
pub const FILE: &str = "checkpoint.json";

/// Raised whenever older checkpoints can no longer be read.
const VERSION: u32 = 1;

/// Files larger than this are no checkpoints of ours: a hundred thousand legs take about as much.
const LARGEST: u64 = 1 << 31;

/// Norms of quaternions that were written as they are differ from 1 by rounding.
const ROTATION_ROUNDING: f64 = 1e-9;

/// A run between two legs.
#[derive(Debug, Deserialize, Serialize)]
pub struct Checkpoint {
    version: u32,
    /// The scene with every key written out.
    scene: String,
    frames: Vec<Isometry3<f64>>,
    attitudes: Vec<UnitQuaternion<f64>>,
    /// What the model's answers depend on besides the placement.
    history: History,
    outcome: Outcome,
    /// Times and names of the flow files that belong to the trajectory.
    flows: Vec<(f64, String)>,
}

impl Checkpoint {
    /// Everything that the rest of the run depends on.
    ///
    /// # Errors
    /// A scene that cannot be written as TOML.
    pub fn new(
        scene: &Scene,
        state: &State,
        outcome: &Outcome,
        model: &dyn Hydrodynamics,
        flows: &[(f64, String)],
    ) -> Result<Self, SwimError> {
        Ok(Self {
            version: VERSION,
            scene: scene.to_toml()?,
            frames: state.frames.clone(),
            attitudes: state.attitudes.clone(),
            history: model.history()?,
            outcome: outcome.clone(),
            flows: flows.to_vec(),
        })
    }

    /// Writes it into a folder; the old one stays until the new one is whole.
    ///
    /// # Errors
    /// [`SwimError::Write`].
    pub fn write(&self, folder: &Folder) -> Result<(), SwimError> {
        folder
            .write(FILE, |file| Ok(serde_json::to_writer(file, self)?))
            .map(drop)
    }

    /// Reads the checkpoint of a folder.
    ///
    /// # Errors
    /// [`SwimError::Read`] when there is none, [`SwimError::Checkpoint`] when it is damaged or of another version.
    pub fn read(folder: &Path) -> Result<Self, SwimError> {
        let path = folder.join(FILE);
        let read = || -> std::io::Result<String> {
            if std::fs::metadata(&path)?.len() > LARGEST {
                return Err(std::io::Error::other("the file is too large"));
            }
            std::fs::read_to_string(&path)
        };
        let text = read().map_err(|source| SwimError::Read {
            path: path.clone(),
            source,
        })?;
        Self::parse(&text, &path)
    }

    /// Reads the text of a checkpoint; `path` is what messages call it.
    ///
    /// # Errors
    /// [`SwimError::Checkpoint`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, SwimError> {
        let damaged = |problem: String| SwimError::Checkpoint {
            path: path.to_owned(),
            problem,
        };
        let checkpoint: Self =
            serde_json::from_str(text).map_err(|error| damaged(format!("is damaged: {error}")))?;
        if checkpoint.version != VERSION {
            return Err(damaged(format!(
                "is of version {}, this program reads version {VERSION}",
                checkpoint.version
            )));
        }
        Ok(checkpoint)
    }

    /// The factor on element sizes of the run, whoever chose it; none if the scene does not parse.
    pub fn size_factor(&self) -> Option<f64> {
        Scene::parse(&self.scene).ok()?.fem().size_factor
    }

    /// Gives the model its history back and says where the run goes on.
    ///
    /// More cycles than before may be asked for; everything else in the scene must be as it was.
    ///
    /// # Errors
    /// [`SwimError::Checkpoint`] when it is another scene's; what the model fails with.
    pub fn restore(
        self,
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
        folder: &Path,
    ) -> Result<(Interim, Vec<(f64, String)>), SwimError> {
        let bad = |problem: String| SwimError::Checkpoint {
            path: folder.join(FILE),
            problem,
        };
        let now = scene.to_toml()?;
        let kept = |text: &str| -> Vec<String> {
            let lines = text.lines().filter(|line| !line.starts_with("cycles ="));
            lines.map(str::to_owned).collect()
        };
        let (before, after) = (kept(&self.scene), kept(&now));
        if before != after {
            let pairs = before.iter().zip(&after).find(|(a, b)| a != b);
            let difference = pairs.map_or_else(
                || "one has more keys".to_owned(),
                |(a, b)| format!("it has '{a}' where the scene has '{b}'"),
            );
            return Err(bad(format!("belongs to another scene: {difference}")));
        }
        let legs = scene.gait().phases.len() * scene.gait().cycles as usize;
        let set = scene.articulation();
        let outcome = self.outcome;
        let fits = self.frames.len() == set.linkages().len()
            && self.attitudes.len() == scene.bodies().len()
            && outcome_fits(&outcome, scene);
        if !fits || outcome.legs.len() > legs {
            return Err(bad(format!(
                "does not fit the scene: it has {} phases done of {legs}, {} frames, {} bodies",
                outcome.legs.len(),
                self.frames.len(),
                self.attitudes.len()
            )));
        }
        let turns =
            (self.frames.iter().map(|frame| frame.rotation)).chain(self.attitudes.iter().copied());
        for turn in turns {
            let off = (turn.norm() - 1.0).abs();
            if off.is_nan() || off > ROTATION_ROUNDING {
                return Err(bad(format!(
                    "is damaged: a rotation is {off:e} away from being one"
                )));
            }
        }
        model.restore(&self.history)?;
        let state = State {
            frames: self.frames,
            attitudes: self.attitudes,
        };
        Ok((Interim { state, outcome }, self.flows))
    }
}

/// Whether every list of an outcome has an entry for each body or link that later steps and pictures look up.
fn outcome_fits(outcome: &Outcome, scene: &Scene) -> bool {
    let (bodies, links) = (scene.bodies().len(), scene.articulation().links().len());
    outcome.displacement.len() == bodies
        && !outcome.samples.is_empty()
        && outcome.samples.iter().all(|sample| {
            sample.lengths.len() == links
                && sample.poses.len() == bodies
                && sample
                    .bodies
                    .as_ref()
                    .is_none_or(|list| list.len() == bodies)
        })
        && !outcome.curve.is_empty()
        && outcome
            .curve
            .iter()
            .all(|(_, places)| places.len() == bodies)
        && outcome
            .legs
            .iter()
            .all(|leg| leg.displacement.len() == bodies && leg.link.is_none_or(|link| link < links))
        && outcome
            .mesh_error
            .as_ref()
            .is_none_or(|errors| errors.len() == bodies)
}
