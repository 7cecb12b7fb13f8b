//! What the page of a run shows.

use std::path::{Path, PathBuf};

use scene::Scene;
use serde_json::Value;

use crate::error::PictureError;
use crate::flow_slices::{StoredSlice, StoredSlices};
use crate::plot::{MovieFrame, movie_svg, nearest_in_time};
use swimmer::output::ALL_ERRORS;
use swimmer::{Checkpoint, Folder, Outcome, SwimError};

/// Name of the animated picture.
const MOVIE: &str = "movie.svg";

/// A finished run, as its page shows it.
#[derive(Debug)]
pub struct RunRecord {
    /// Name of the scene.
    pub(super) name: String,
    pub(super) scene: Scene,
    /// The text of the scene, if it is known; all keys of the scene otherwise.
    pub(super) scene_text: Option<String>,
    pub(super) outcome: Outcome,
    /// Contents of `summary.json`.
    pub(super) summary: Value,
    pub(super) slices: StoredSlices,
    /// The map of `swim map` in the same folder.
    pub(super) map: Option<String>,
}

impl RunRecord {
    /// The record of a run that has just ended, with the map in its folder.
    pub(crate) fn new(
        scene: &Scene,
        outcome: &Outcome,
        summary: &Value,
        slices: StoredSlices,
        folder: &Path,
    ) -> Self {
        Self {
            name: scene.name().to_owned(),
            scene: scene.clone(),
            scene_text: None,
            outcome: outcome.clone(),
            summary: summary.clone(),
            slices,
            map: std::fs::read_to_string(folder.join("map.svg")).ok(),
        }
    }

    /// The record of an earlier run, from `checkpoint.json`, `summary.json` and
    /// `flow_slices.json` in its folder.
    ///
    /// Files that the scene names, such as meshes, are searched from the current folder.
    ///
    /// # Errors
    /// [`SwimError::Read`] and [`SwimError::Checkpoint`] for missing and damaged files; a run that
    /// has not ended has no summary.
    pub fn read(folder: impl AsRef<Path>) -> Result<Self, PictureError> {
        let folder = folder.as_ref();
        let path = folder.join("summary.json");
        let failed = |source: std::io::Error| SwimError::Read {
            path: path.clone(),
            source,
        };
        let text = std::fs::read_to_string(&path).map_err(failed)?;
        let summary: Value =
            serde_json::from_str(&text).map_err(|error| failed(std::io::Error::other(error)))?;
        let (scene, text, mut outcome) = Checkpoint::read(folder)?.into_outcome(folder)?;
        // The tolerance is compared at the end of a run, after its last checkpoint.
        let controls_error = summary["tolerance_limits"] == ALL_ERRORS;
        outcome.check_tolerance(&scene, controls_error);
        let of_folder = folder
            .file_name()
            .map(|name| name.to_string_lossy().into_owned());
        let name = summary["scene"].as_str().map(str::to_owned).or(of_folder);
        Ok(Self {
            name: name.unwrap_or_else(|| scene.name().to_owned()),
            scene,
            scene_text: Some(text),
            outcome,
            summary,
            slices: StoredSlices::read(folder),
            map: std::fs::read_to_string(folder.join("map.svg")).ok(),
        })
    }

    /// Why the page shows no flow, or less of it than there could be.
    pub fn missing_flow(&self) -> Option<&str> {
        self.slices.missing.as_deref()
    }

    /// Writes `movie.svg` into a folder: the flow in a plane over the first cycle, animated.
    ///
    /// Returns the path of the file.
    ///
    /// # Errors
    /// [`PictureError::NoFlow`] for a run whose folder has no flow; [`PictureError::Plot`],
    /// [`SwimError::Write`].
    pub fn write_movie(&self, folder: &Folder) -> Result<PathBuf, PictureError> {
        let frame = |stored: &StoredSlice| {
            let nearest = nearest_in_time(&self.outcome.samples, stored.time)?;
            Some(MovieFrame {
                time: stored.time,
                poses: nearest.poses.clone(),
                slice: stored.slice()?,
                shape: nearest.shape.clone(),
            })
        };
        let frames: Vec<_> = self.slices.slices.iter().filter_map(frame).collect();
        if frames.is_empty() {
            return Err(PictureError::NoFlow {
                folder: folder.path().to_owned(),
                reason: (self.missing_flow())
                    .unwrap_or("its file is damaged; repeat the run")
                    .to_owned(),
            });
        }
        let cycle = self.scene.gait().cycle_duration();
        let movie = movie_svg(&self.name, &self.scene, &frames, cycle)?;
        Ok(folder.write(MOVIE, |file| file.write_all(movie.as_bytes()))?)
    }
}
