//! Checkpoints, from which an interrupted run continues with bitwise the same results.
//!
//! A checkpoint is written between phase spans. Numbers are written with the fewest decimals that
//! restore the same bits, and the history of the model is included, so a resumed run gives the
//! results of an uninterrupted one.

use std::path::Path;

use mesh::InputFile;
use models::{History, Hydrodynamics, ModelError, NeglectedTerm};
use nalgebra::{Isometry3, UnitQuaternion};
use rigid::State;
use scene::{Scene, SourceFile};
use serde::{Deserialize, Serialize};

use crate::error::SwimError;
use crate::integrate::UnsteadyState;
use crate::neglected::is_automatic;
use crate::outcome::{Interim, Outcome};
use crate::output::{Folder, from_sealed, read_own, write_sealed};

/// Name of the file in the output folder.
pub const FILE: &str = "checkpoint.json";

/// Version of the format; increased when older checkpoints can no longer be read.
const VERSION: u32 = 11;

/// Largest deviation from 1 of the norm of a quaternion, for those that differ by rounding alone.
const UNIT_TOLERANCE: f64 = 1e-9;

/// The state of a run between two phase spans, with the history of its model.
#[derive(Debug, Deserialize, Serialize)]
pub struct Checkpoint {
    version: u32,
    /// The scene as TOML, with all default values.
    scene: String,
    /// The files that the scene names, with the hashes of their contents.
    files: Vec<SourceFile>,
    frames: Vec<Isometry3<f64>>,
    attitudes: Vec<UnitQuaternion<f64>>,
    /// Values of the passive joints.
    joints: Vec<f64>,
    /// State of the model on which its solutions depend besides the configuration.
    history: History,
    /// The fluid if it has inertia; none at a start that is not periodic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fluid: Option<UnsteadyState>,
    outcome: Outcome,
    /// Times and names of the flow files that belong to the trajectory.
    flows: Vec<(f64, String)>,
    /// The outcome of a run that stopped within the next phase, up to there. A resumed run repeats
    /// that phase.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    stopped: Option<Outcome>,
}

impl Checkpoint {
    /// A checkpoint of a run with this state, outcome and flow files (times and names).
    ///
    /// # Errors
    /// A history of the model or a scene that cannot be written.
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
            files: scene.source_files(),
            frames: state.frames.clone(),
            attitudes: state.attitudes.clone(),
            joints: state.joints.clone(),
            history: model.history()?,
            fluid: None,
            outcome: outcome.clone(),
            flows: flows.to_vec(),
            stopped: None,
        })
    }

    /// The same checkpoint of a fluid with inertia
    /// ([`SpanResult::fluid`](crate::SpanResult::fluid)).
    #[must_use]
    pub fn with_fluid(self, fluid: Option<&UnsteadyState>) -> Self {
        Self {
            fluid: fluid.cloned(),
            ..self
        }
    }

    /// The same checkpoint of a run that has stopped within the next phase, with the outcome there.
    pub(crate) fn with_stopped(self, outcome: &Outcome) -> Self {
        Self {
            stopped: Some(outcome.clone()),
            ..self
        }
    }

    /// What the run has reached.
    pub fn outcome(&self) -> &Outcome {
        &self.outcome
    }

    /// Writes the checkpoint into a folder; an older one stays until the new one is complete.
    ///
    /// # Errors
    /// [`SwimError::Write`].
    pub fn write(&self, folder: &Folder) -> Result<(), SwimError> {
        write_sealed(folder, FILE, self)
    }

    /// Reads the checkpoint of a folder.
    ///
    /// # Errors
    /// [`SwimError::Read`] when there is none, [`SwimError::Checkpoint`] when it is damaged or of
    /// another version.
    pub fn read(folder: impl AsRef<Path>) -> Result<Self, SwimError> {
        let path = folder.as_ref().join(FILE);
        match read_own(&path).and_then(InputFile::into_text) {
            Ok(text) => Self::parse(&text, &path),
            Err(source) => Err(SwimError::Read { path, source }),
        }
    }

    /// Reads the text of a checkpoint; messages name it by `path`.
    ///
    /// # Errors
    /// [`SwimError::Checkpoint`].
    pub fn parse(text: &str, path: impl AsRef<Path>) -> Result<Self, SwimError> {
        let path = path.as_ref();
        #[derive(Deserialize)]
        struct Versioned {
            version: u32,
        }
        let bad = |problem: String| SwimError::Checkpoint {
            path: path.to_owned(),
            problem,
        };
        let of_version = |version: u32| {
            bad(format!(
                "is of version {version}, this program reads version {VERSION}"
            ))
        };
        match from_sealed::<Self>(text) {
            Ok(checkpoint) if checkpoint.version == VERSION => Ok(checkpoint),
            Ok(checkpoint) => Err(of_version(checkpoint.version)),
            // Checkpoints of other versions have other fields, and once had no checksum.
            Err(error) => Err(match serde_json::from_str(text) {
                Ok(Versioned { version }) if version != VERSION => of_version(version),
                _ => bad(format!("is damaged: {error}")),
            }),
        }
    }

    /// The factor on the element sizes of the run, given or chosen; 1 if the scene has none or
    /// cannot be read.
    pub fn size_factor(&self) -> f64 {
        let scene = Scene::parse(&self.scene).ok();
        scene
            .and_then(|scene| scene.fem().size_factor)
            .unwrap_or(1.0)
    }

    /// The factor on the tolerance of single solutions with which the interrupted run went on.
    pub fn tolerance_factor(&self) -> Option<f64> {
        Scene::parse(&self.scene).ok()?.model().tolerance_factor
    }

    /// Whether the interrupted run had gone on with a term that `scene` leaves to be decided.
    pub(crate) fn decided_for(&self, scene: &Scene, term: NeglectedTerm) -> bool {
        let is_decided = |before: &Scene| !is_automatic(before, term);
        is_automatic(scene, term) && Scene::parse(&self.scene).is_ok_and(|s| is_decided(&s))
    }

    /// The scene with its text, and the outcome so far: of a run that stopped within a phase, up to
    /// there.
    ///
    /// # Errors
    /// [`SwimError::Checkpoint`] for an outcome that does not fit the scene, and for files of the
    /// scene that have changed since; errors of the scene.
    pub fn into_outcome(
        self,
        folder: impl AsRef<Path>,
    ) -> Result<(Scene, String, Outcome), SwimError> {
        let scene = Scene::parse(&self.scene)?;
        let bad = |problem: String| SwimError::Checkpoint {
            path: folder.as_ref().join(FILE),
            problem,
        };
        check_files(&self.files, &scene).map_err(bad)?;
        let outcome = self.stopped.unwrap_or(self.outcome);
        match outcome_fits(&outcome, &scene) {
            true => Ok((scene, self.scene, outcome)),
            false => Err(bad("does not fit its scene".to_owned())),
        }
    }

    /// Restores the history of the model and returns the state and the flow files of the run.
    ///
    /// The number of cycles in `scene` may differ; everything else must equal the scene of the
    /// checkpoint.
    ///
    /// # Errors
    /// [`SwimError::Checkpoint`] for a checkpoint of another scene, or of a scene whose files have
    /// changed; errors of the model.
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
        let text = scene.to_toml()?;
        let without_cycles = |text: &str| -> Vec<String> {
            let lines = text.lines().filter(|line| !line.starts_with("cycles ="));
            lines.map(str::to_owned).collect()
        };
        let (before, after) = (without_cycles(&self.scene), without_cycles(&text));
        if before != after {
            let pairs = before.iter().zip(&after).find(|(a, b)| a != b);
            let difference = pairs.map_or_else(
                || "one of the two has more keys".to_owned(),
                |(a, b)| format!("the checkpoint has '{a}', the scene has '{b}'"),
            );
            return Err(bad(format!("belongs to another scene: {difference}")));
        }
        check_files(&self.files, scene).map_err(bad)?;
        let spans = scene.gait().phases.len() * scene.gait().cycles as usize;
        let set = scene.articulation();
        let outcome = self.outcome;
        let fits = self.frames.len() == set.linkages().len()
            && self.attitudes.len() == scene.bodies().len()
            && self.joints.len() == set.passive_joints().count()
            && self.joints.iter().all(|value| value.is_finite())
            && outcome_fits(&outcome, scene);
        if !fits || outcome.spans.len() > spans {
            return Err(bad(format!(
                "does not fit the scene: it has {} completed phases of {spans}, {} frames, {} bodies",
                outcome.spans.len(),
                self.frames.len(),
                self.attitudes.len()
            )));
        }
        let rotations =
            (self.frames.iter().map(|frame| frame.rotation)).chain(self.attitudes.iter().copied());
        for rotation in rotations {
            let deviation = (rotation.norm() - 1.0).abs();
            if deviation.is_nan() || deviation > UNIT_TOLERANCE {
                return Err(bad(format!(
                    "is damaged: the norm of a quaternion differs from 1 by {deviation:e}"
                )));
            }
        }
        model.restore(&self.history).map_err(|error| match error {
            ModelError::History(problem) => {
                bad(format!("is damaged: the history of the model {problem}"))
            }
            error => error.into(),
        })?;
        let state = State {
            frames: self.frames,
            attitudes: self.attitudes,
            joints: self.joints,
        };
        let interim = Interim {
            state,
            fluid: self.fluid,
            outcome,
        };
        Ok((interim, self.flows))
    }
}

/// Refuses files of a scene whose contents are not those of the checkpoint.
fn check_files(before: &[SourceFile], scene: &Scene) -> Result<(), String> {
    let now = scene.source_files();
    let changed = before.iter().zip(&now).find(|(before, now)| before != now);
    match changed.map(|(_, now)| now) {
        Some(file) => Err(format!(
            "was computed with other contents of the file {}: put back the old file to continue",
            file.path
        )),
        None if before.len() != now.len() => Err(format!(
            "was computed with {} files, and the scene names {}",
            before.len(),
            now.len()
        )),
        None => Ok(()),
    }
}

/// Whether the lists of an outcome have one entry per body or joint of the scene.
fn outcome_fits(outcome: &Outcome, scene: &Scene) -> bool {
    let (bodies, joints) = (scene.bodies().len(), scene.articulation().joints().len());
    outcome.displacement.len() == bodies
        && !outcome.samples.is_empty()
        && outcome.samples.iter().all(|sample| {
            sample.shape.len() == joints
                && sample.poses.len() == bodies
                && [&sample.bodies, &sample.interpolated]
                    .iter()
                    .all(|list| list.as_ref().is_none_or(|list| list.len() == bodies))
        })
        && !outcome.curve.is_empty()
        && outcome
            .curve
            .iter()
            .all(|(_, positions)| positions.len() == bodies)
        && outcome.spans.iter().all(|span| {
            span.displacement.len() == bodies && span.joints.iter().all(|joint| *joint < joints)
        })
        && outcome
            .mesh_error
            .as_ref()
            .is_none_or(|errors| errors.len() == bodies)
}
