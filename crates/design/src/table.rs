//! The table of connection and metric over the limits of a scene, stored on disk.

use std::time::{Duration, Instant as Clock};

use models::{ModelError, ShapeGeometry, ShapeSpace, SolvedShapes, TablePart};
use scene::{Scene, SourceFile};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use swimmer::output::{read_sealed, write_sealed};
use swimmer::{Folder, choose};

use super::limits::StrokeLimits;
use crate::error::{DesignError, DesignProgress, check_interruption};

/// Name of the file of a table.
const FILE: &str = "table.json";

/// Beginning of the names of the files of the shapes that are solved while a table is computed.
const PARTIAL: &str = "table.partial";

/// Name of the file of the shapes that a computation has solved.
fn partial_file(part: TablePart) -> String {
    match part {
        TablePart::Share { number, count } => format!("{PARTIAL}.{number}-of-{count}.json"),
        TablePart::Whole | TablePart::Known => format!("{PARTIAL}.json"),
    }
}

/// Time between two writes of the shapes that are solved: all that an interrupted computation loses
/// beside its last shape.
const BETWEEN_WRITES: Duration = Duration::from_secs(5);

/// A table or a part of it, with what it was computed from.
#[derive(Deserialize, Serialize)]
struct Stored<T> {
    /// The scene as TOML.
    scene: String,
    /// The files that the scene names, with the hashes of their contents.
    files: Vec<SourceFile>,
    ranges: Vec<(f64, f64)>,
    tolerance: f64,
    model: String,
    table: T,
}

impl Stored<()> {
    /// The same origin with a table.
    fn with<T>(&self, table: T) -> Stored<T> {
        Stored {
            scene: self.scene.clone(),
            files: self.files.clone(),
            ranges: self.ranges.clone(),
            tolerance: self.tolerance,
            model: self.model.clone(),
            table,
        }
    }
}

/// A table, and where it is from.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct StrokeTable {
    /// Connection and metric.
    pub geometry: ShapeGeometry,
    /// Name of the model.
    pub model: String,
    /// Number of its shapes that were read from the folder.
    pub stored: usize,
}

impl StrokeTable {
    /// Error bar of the displacement of a closed stroke, given by values of joints along it: the
    /// errors of the table for a unit rate times the length of the stroke, summed over the joints.
    pub fn displacement_error(&self, shapes: &[Vec<f64>]) -> f64 {
        let (interpolation, model) = self.geometry.errors();
        let next = shapes.iter().cycle().skip(1);
        let changes = shapes.iter().zip(next).flat_map(|(a, b)| a.iter().zip(b));
        let length: f64 = changes.map(|(a, b)| (a - b).abs()).sum();
        (interpolation + model + self.geometry.position_error()) * length
    }
}

/// Tabulates connection and metric over the limits, or reads them from the folder of an earlier run
/// of the same flow problem.
///
/// Shapes that an interrupted computation has solved are in the folder too, and are used by the
/// next one, which ends with the same bits as one that was not interrupted. Several computations
/// can share the work in one folder, each with its own `part`.
///
/// # Errors
/// A scene whose motion depends on more than the shape, errors of the model, files that cannot be
/// written, [`DesignError::Stopped`]; [`ModelError::MissingShapes`] after a part that does not
/// complete the table.
pub fn tabulate(
    scene: &Scene,
    limits: &StrokeLimits,
    tolerance: f64,
    (folder, part): (Option<&Folder>, TablePart),
    progress: &mut dyn DesignProgress,
) -> Result<StrokeTable, DesignError> {
    DesignError::check_rheology(scene)?;
    if !scene.is_driven_by_shape() {
        return Err(DesignError::not_applicable(
            scene,
            "optimise",
            "tables over shapes require a motion that the joints determine: one linkage without \
             external loads, masses, slip, background flow and passive joints",
        ));
    }
    let stored = folder.and_then(|folder| read::<ShapeGeometry>(folder, FILE, scene, limits));
    if let Some(stored) = stored.filter(|stored| stored.tolerance <= tolerance) {
        return Ok(StrokeTable {
            stored: stored.table.points(),
            geometry: stored.table,
            model: stored.model,
        });
    }
    let mut model = choose(scene)?.model;
    let name = model.name();
    let partial_files = partial_files(folder);
    let read = |file: &String| read::<SolvedShapes>(folder?, file, scene, limits);
    let mut solved = SolvedShapes::default();
    for found in partial_files.iter().filter_map(read) {
        if found.model == name {
            solved.merge(found.table);
        }
    }
    let known = solved.len();
    let origin = Stored {
        scene: scene.to_toml()?,
        files: scene.source_files(),
        ranges: limits.ranges.clone(),
        tolerance,
        model: name.to_owned(),
        table: (),
    };
    progress.counted("shapes of the table", known, known);
    let mut recorder = Recorder::new(folder, part, origin, known);
    let space = ShapeSpace::tabulate_from(
        scene,
        model.as_mut(),
        &limits.ranges,
        tolerance,
        (solved, part),
        &mut |solved| recorder.solved(solved, progress),
    );
    if let Some(error) = recorder.failed {
        return Err(error);
    }
    let done = recorder.done;
    check_interruption(progress, || {
        format!("{done} shapes of the table; the same command continues with them")
    })?;
    let Recorder { file, origin, .. } = recorder;
    if let (Err(ModelError::MissingShapes { .. }), Some(folder), Some(last)) =
        (&space, folder, &recorder.last)
    {
        write(folder, &file, &origin.with(last))?;
    }
    let geometry = space?.geometry()?;
    if let Some(folder) = folder {
        write(folder, FILE, &origin.with(&geometry))?;
        for file in partial_files.iter().chain([&file]) {
            // A part that cannot be removed is read again, to no harm.
            let _ = std::fs::remove_file(folder.path().join(file));
        }
    }
    Ok(StrokeTable {
        geometry,
        model: name.to_owned(),
        stored: known,
    })
}

/// Writes the shapes that are solved while a table is computed.
struct Recorder<'a> {
    folder: Option<&'a Folder>,
    file: String,
    keeps_last: bool,
    origin: Stored<()>,
    /// Number of the shapes that are solved.
    done: usize,
    last: Option<SolvedShapes>,
    failed: Option<DesignError>,
    written: Clock,
}

impl<'a> Recorder<'a> {
    fn new(folder: Option<&'a Folder>, part: TablePart, origin: Stored<()>, done: usize) -> Self {
        Self {
            folder,
            file: partial_file(part),
            keeps_last: part != TablePart::Whole,
            origin,
            done,
            last: None,
            failed: None,
            written: Clock::now(),
        }
    }

    /// Notes the shapes; an error, to be replaced by one of this crate, ends the computation.
    fn solved(
        &mut self,
        solved: &SolvedShapes,
        progress: &mut dyn DesignProgress,
    ) -> Result<(), ModelError> {
        self.done = solved.len();
        progress.counted("shapes of the table", self.done, solved.wanted());
        let is_interrupted = progress.is_interrupted();
        if let Some(folder) = self.folder
            && (is_interrupted || self.written.elapsed() >= BETWEEN_WRITES)
        {
            self.failed = write(folder, &self.file, &self.origin.with(solved)).err();
            self.written = Clock::now();
        }
        if self.keeps_last {
            self.last = Some(solved.clone());
        }
        match is_interrupted || self.failed.is_some() {
            true => Err(ModelError::ShapeSpace {
                problem: "interrupted".to_owned(),
            }),
            false => Ok(()),
        }
    }
}

/// Names of the files of solved shapes in a folder, in a fixed order.
fn partial_files(folder: Option<&Folder>) -> Vec<String> {
    let entries = folder.and_then(|folder| std::fs::read_dir(folder.path()).ok());
    let entries = entries.into_iter().flatten();
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let is_partial = |name: &String| name.starts_with(PARTIAL) && name.ends_with(".json");
    let mut names: Vec<String> = names.filter(is_partial).collect();
    names.sort_unstable();
    names
}

fn write<T: Serialize>(
    folder: &Folder,
    name: &str,
    stored: &Stored<&T>,
) -> Result<(), DesignError> {
    Ok(write_sealed(folder, name, stored)?)
}

/// The hashes of files; their names depend on the working directory.
fn hashes(files: &[SourceFile]) -> impl Iterator<Item = u64> {
    files.iter().map(|file| file.hash)
}

/// The contents of a file of a folder, if it is of the same flow problem and limits.
fn read<T: DeserializeOwned>(
    folder: &Folder,
    name: &str,
    scene: &Scene,
    limits: &StrokeLimits,
) -> Option<Stored<T>> {
    let stored: Stored<T> = read_sealed(folder.path().join(name)).ok()?;
    let other = Scene::parse(&stored.scene).ok()?;
    let is_same = scene.differing_key(&other).is_none()
        && other.initial_state() == scene.initial_state()
        && other.model() == scene.model()
        && other.fem() == scene.fem()
        && stored.ranges == limits.ranges
        && hashes(&stored.files).eq(hashes(&scene.source_files()));
    is_same.then_some(stored)
}
