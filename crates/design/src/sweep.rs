//! Runs of a scene with other values of some keys: all combinations of them, or random ones.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use nalgebra::Vector3;
use scene::{Document, Scene, SourceFile};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use swimmer::output::{Folder, read_sealed, write_sealed};
use swimmer::{Report, SwimError, mean_of_moving};

use crate::error::{DesignError, DesignProgress};
use crate::sensitivities::{Parameter, parameter::with_values_at, parameters};
use crate::swept_points::{RandomPoints, VariedKey, positive, sweep_points};

/// Name of the file from which an interrupted sweep continues.
const FILE: &str = "sweep.json";

/// Version of its format.
const VERSION: u32 = 2;

/// Time between two looks at interruptions, and the shortest one between two writes of the rows.
const TICK: Duration = Duration::from_millis(100);
const WRITE_INTERVAL: Duration = Duration::from_secs(2);

/// The result of one point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SweepRow {
    /// Number of the point.
    pub number: usize,
    /// Values of the keys.
    pub values: Vec<String>,
    /// Files that the scene of the point names.
    files: Vec<SourceFile>,
    /// What the run gave, or why there is none.
    pub result: Result<SweepResult, String>,
}

/// The numbers of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SweepResult {
    /// Name of the model.
    pub model: String,
    /// Whether the error bar is within `model.tolerance`.
    pub tolerance_met: bool,
    /// Why the run stopped before its end, such as contact.
    pub stopped: Option<String>,
    /// Net displacement.
    pub displacement: Vector3<f64>,
    /// Its error bar.
    pub displacement_error: Option<f64>,
    /// Rotation vector in radians.
    pub rotation: Vector3<f64>,
    /// Its error bar.
    pub rotation_error: Option<f64>,
    /// Work of the bodies on the fluid.
    pub work: f64,
    /// Its error bar.
    pub work_error: Option<f64>,
    /// Lighthill's efficiency ([`swimmer::Efficiency`]); none of a run that does not swim.
    pub efficiency: Option<f64>,
    /// Its error bar.
    pub efficiency_error: Option<f64>,
    /// Wall-clock time in seconds.
    pub seconds: f64,
}

impl SweepResult {
    /// The numbers of a report.
    pub(crate) fn from_report(report: &Report) -> Self {
        let outcome = &report.outcome;
        Self {
            model: report.model.to_owned(),
            tolerance_met: outcome.tolerance_met,
            stopped: report.stopped.as_ref().map(ToString::to_string),
            displacement: mean_of_moving(&outcome.displacement),
            displacement_error: outcome.error_estimate.estimated(),
            rotation: outcome.rotation,
            rotation_error: outcome.rotation_error.estimated(),
            work: outcome.work,
            work_error: outcome.work_error.estimated(),
            efficiency: report.efficiency.map(|of| of.value),
            efficiency_error: report.efficiency.and_then(|of| of.error),
            seconds: report.seconds,
        }
    }
}

/// The results of a sweep.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Sweep {
    /// The keys that vary.
    pub keys: Vec<String>,
    /// Results of all points, in their order.
    pub rows: Vec<SweepRow>,
    /// Number of results that are those of an earlier, interrupted sweep.
    pub kept: usize,
}

/// What is read again after an interruption.
#[derive(Serialize, Deserialize)]
struct Stored {
    version: u32,
    program: String,
    scene: String,
    keys: Vec<String>,
    rows: Vec<SweepRow>,
}

/// How the points of a sweep are computed.
#[derive(Clone, Copy, Debug)]
pub struct SweepOptions<'a> {
    /// Number of runs at the same time, by default that of the threads.
    pub jobs: Option<usize>,
    /// Folder for the rows; without one an interrupted sweep is lost.
    pub folder: Option<&'a Folder>,
    /// Whether to continue an interrupted sweep in this folder.
    pub resume: bool,
}

/// Runs a scene at all points; a run that fails is a row with its reason.
///
/// The rows do not depend on the number of jobs. With a folder they are written to `sweep.csv`, and
/// to `sweep.json` to continue from.
///
/// # Errors
/// A scene without a gait, a key that it does not have, a sweep of another scene in the folder,
/// [`DesignError::Stopped`].
pub fn sweep(
    scene: &Scene,
    keys: &[VariedKey],
    random: Option<RandomPoints>,
    options: SweepOptions,
    progress: &mut dyn DesignProgress,
) -> Result<Sweep, DesignError> {
    scene.require_gait()?;
    let points = sweep_points(keys, random)?;
    let text = scene.to_toml()?;
    let varied = Varied::new(scene, &text, keys)?;
    varied.document(&points[0])?;
    let mut stored = Stored {
        version: VERSION,
        program: env!("CARGO_PKG_VERSION").to_owned(),
        scene: text,
        keys: varied.keys.clone(),
        rows: Vec::new(),
    };
    if let (Some(folder), true) = (options.folder, options.resume) {
        stored.rows = stored.kept_rows(folder, &varied, &points)?;
    }
    let kept = stored.rows.len();
    progress.counted("points", kept, points.len());
    let known: BTreeSet<usize> = stored.rows.iter().map(|row| row.number).collect();
    let todo: Vec<usize> = (0..points.len()).filter(|k| !known.contains(k)).collect();
    let (next, is_interrupted) = (AtomicUsize::new(0), AtomicBool::new(false));
    let (sender, receiver) = channel();
    let run_points = || {
        let sender = sender.clone();
        let (varied, todo, points) = (&varied, &todo, &points);
        let (next, is_interrupted) = (&next, &is_interrupted);
        move || {
            while let Some(&number) = todo.get(next.fetch_add(1, Ordering::Relaxed)) {
                let row = varied.row(number, &points[number], is_interrupted);
                if is_interrupted.load(Ordering::Relaxed) || sender.send(row).is_err() {
                    return;
                }
            }
        }
    };
    let jobs = options.jobs.unwrap_or_else(rayon::current_num_threads);
    let jobs = jobs.clamp(1, todo.len().max(1));
    let workers: Vec<_> = (0..jobs).map(|_| run_points()).collect();
    drop(sender);
    let (mut written, mut stopped) = (Instant::now(), false);
    let mut interval = WRITE_INTERVAL;
    std::thread::scope(|scope| {
        for worker in workers {
            scope.spawn(worker);
        }
        // Also if a file cannot be written, the other runs end.
        let stop = StopOnDrop(&is_interrupted);
        loop {
            match receiver.recv_timeout(TICK) {
                Ok(row) => {
                    stored.rows.push(row);
                    progress.counted("points", stored.rows.len(), points.len());
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if progress.is_interrupted() {
                stopped = true;
                break;
            }
            if written.elapsed() > interval {
                let begun = Instant::now();
                stored.write(options.folder)?;
                written = Instant::now();
                // All rows are written each time, which takes a tenth of the time at most.
                interval = WRITE_INTERVAL.max(10 * begun.elapsed());
            }
        }
        drop(stop);
        Ok::<_, SwimError>(())
    })?;
    stored.write(options.folder)?;
    if stopped {
        let (done, all) = (stored.rows.len(), points.len());
        return Err(DesignError::Stopped {
            what: format!("{done} of {all} points"),
        });
    }
    let Stored { keys, rows, .. } = stored;
    Ok(Sweep { keys, rows, kept })
}

/// Checks that a sweep has begun in a folder, before one that continues it makes the folder.
///
/// # Errors
/// [`DesignError::NotApplicable`].
pub fn require_sweep(folder: &Path) -> Result<(), DesignError> {
    let path = folder.join(FILE);
    match path.exists() {
        true => Ok(()),
        false => Err(DesignError::NotApplicable {
            place: path.display().to_string(),
            problem: "does not exist: no sweep has begun in this folder; name the folder of the \
                      sweep, or leave out --resume"
                .to_owned(),
        }),
    }
}

/// Stops the runs that are left.
struct StopOnDrop<'a>(&'a AtomicBool);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// A flag that stops runs.
struct Flag<'a>(&'a AtomicBool);

impl swimmer::Progress for Flag<'_> {
    fn is_interrupted(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// A scene whose keys vary.
struct Varied {
    document: Document,
    keys: Vec<String>,
    /// The parameters that no single key gives, with the number of their key.
    parameters: Vec<(usize, Parameter)>,
}

impl Varied {
    /// The scene of a text, with the keys to vary.
    fn new(scene: &Scene, text: &str, keys: &[VariedKey]) -> Result<Self, DesignError> {
        let document = Document::parse(text, "scene")?;
        let mut known = Vec::new();
        if keys.iter().any(|varied| varied.key.starts_with("links")) {
            known = parameters(scene)?;
        }
        let of_key = |key: &str| {
            let path = document.full_path(key);
            let is_own = |of: &&Parameter| {
                let [name, number] = of.keys(scene).unwrap_or_default();
                name == key || path.as_deref() == Some(&number)
            };
            known.iter().find(is_own).cloned()
        };
        let of_number =
            |(number, varied): (usize, &VariedKey)| Some((number, of_key(&varied.key)?));
        let varied = Self {
            parameters: keys.iter().enumerate().filter_map(of_number).collect(),
            keys: keys.iter().map(|varied| varied.key.clone()).collect(),
            document,
        };
        for (number, parameter) in &varied.parameters {
            keys[*number].values.require_positive(&keys[*number].key)?;
            varied.require_no_other_key(scene, *number, parameter)?;
        }
        Ok(varied)
    }

    /// Refuses keys that a parameter changes too: the scene would have other values of them than
    /// the row.
    fn require_no_other_key(
        &self,
        scene: &Scene,
        number: usize,
        parameter: &Parameter,
    ) -> Result<(), DesignError> {
        let changed = parameter.changed_keys(scene)?;
        let own = &self.keys[number];
        for (other, key) in self.keys.iter().enumerate() {
            if self.parameters.iter().any(|(of, _)| *of == other) {
                continue;
            }
            let path = self.document.full_path(key).unwrap_or_default();
            let is_same = |of: &String| path.starts_with(of.as_str()) || of.starts_with(&path);
            if !path.is_empty() && changed.iter().any(is_same) {
                return Err(DesignError::NotApplicable {
                    place: key.clone(),
                    problem: format!("changes with {own}, which varies too; vary one of them"),
                });
            }
        }
        Ok(())
    }

    /// The values of all keys at a point, in words.
    fn words(&self, values: &[String]) -> String {
        let words = self.keys.iter().zip(values);
        let words: Vec<String> = words.map(|(key, value)| format!("{key}={value}")).collect();
        words.join(", ")
    }

    /// The document at a point, without its parameters.
    fn document(&self, values: &[String]) -> Result<Document, DesignError> {
        let place = self.words(values);
        let mut document = self.document.clone().located(&place);
        for (number, (key, value)) in self.keys.iter().zip(values).enumerate() {
            if self.parameters.iter().all(|(own, _)| *own != number) {
                document.set_at(&format!("{key}={value}"), &place)?;
            }
        }
        Ok(document)
    }

    /// The scene at a point: first its keys, then its parameters.
    fn scene(&self, values: &[String]) -> Result<Scene, DesignError> {
        let scene = Scene::from_document(self.document(values)?)?;
        if self.parameters.is_empty() {
            return Ok(scene);
        }
        let place = self.words(values);
        let now = parameters(&scene)?;
        let mut changes = Vec::new();
        for (number, parameter) in &self.parameters {
            let refuse = |problem: String| DesignError::NotApplicable {
                place: place.clone(),
                problem,
            };
            let value = positive(&values[*number])
                .ok_or_else(|| refuse(format!("{} must be positive", self.keys[*number])))?;
            let parameter = now.iter().find(|now| now.name == parameter.name);
            let parameter = parameter.ok_or_else(|| {
                refuse(format!("{} has no value in this gait", self.keys[*number]))
            })?;
            changes.push((parameter, value));
        }
        with_values_at(&scene, &changes, &place)
    }

    /// The run of one point.
    fn row(&self, number: usize, values: &[String], is_interrupted: &AtomicBool) -> SweepRow {
        let started = Instant::now();
        let mut files = Vec::new();
        let mut run = || -> Result<SweepResult, DesignError> {
            let scene = self.scene(values)?;
            files = scene.source_files();
            let report = swimmer::run_without_files(scene, &mut Flag(is_interrupted))?;
            Ok(SweepResult {
                seconds: started.elapsed().as_secs_f64(),
                ..SweepResult::from_report(&report)
            })
        };
        let result = run().map_err(|error| error.to_string());
        SweepRow {
            number,
            values: values.to_vec(),
            files,
            result,
        }
    }
}

impl Stored {
    /// Writes the rows, in the order of their points.
    fn write(&mut self, folder: Option<&Folder>) -> Result<(), SwimError> {
        self.rows.sort_by_key(|row| row.number);
        let Some(folder) = folder else { return Ok(()) };
        write_sealed(folder, FILE, self)?;
        let text = csv(&self.keys, &self.rows);
        folder
            .write("sweep.csv", |file| file.write_all(text.as_bytes()))
            .map(drop)
    }

    /// The rows of an earlier sweep of the same scene, keys and files.
    fn kept_rows(
        &self,
        folder: &Folder,
        varied: &Varied,
        points: &[Vec<String>],
    ) -> Result<Vec<SweepRow>, DesignError> {
        let path = folder.path().join(FILE);
        let place = path.display().to_string();
        require_sweep(folder.path())?;
        let before: Self = read_sealed(&path).map_err(|source| SwimError::Read { path, source })?;
        for (what, is_same) in [
            ("format", before.version == self.version),
            ("version of the program", before.program == self.program),
            ("scene", before.scene == self.scene),
            ("list of keys", before.keys == self.keys),
        ] {
            if !is_same {
                return Err(DesignError::NotApplicable {
                    place,
                    problem: format!(
                        "is of another {what}; choose another folder, or leave out --resume"
                    ),
                });
            }
        }
        let is_kept = |row: &SweepRow| {
            let files = || {
                let scene = varied.scene(&row.values);
                scene.map_or_else(|_| Vec::new(), |scene| scene.source_files())
            };
            points.get(row.number) == Some(&row.values) && row.files == files()
        };
        Ok(before.rows.into_iter().filter(is_kept).collect())
    }
}

impl Sweep {
    /// Rows whose runs failed.
    pub fn failed(&self) -> impl Iterator<Item = &SweepRow> {
        self.rows.iter().filter(|row| row.result.is_err())
    }

    /// The keys and rows for other programs: `keys`, and `rows` with `values`, `status` and
    /// `result`, null for a run that failed.
    pub fn json(&self) -> Value {
        let row = |row: &SweepRow| json!({ "values": row.values, "status": row.status(), "result": row.result.as_ref().ok() });
        json!({ "keys": self.keys, "rows": self.rows.iter().map(row).collect::<Vec<_>>() })
    }

    /// The rows as comma-separated values below a header.
    pub fn csv(&self) -> String {
        csv(&self.keys, &self.rows)
    }
}

impl SweepRow {
    /// What became of the run, in words: `met`, `tolerance missed`, or the reason why it stopped or
    /// failed.
    pub fn status(&self) -> String {
        match &self.result {
            Err(reason) => format!("failed: {reason}"),
            Ok(SweepResult {
                stopped: Some(reason),
                ..
            }) => format!("stopped: {reason}"),
            Ok(result) if result.tolerance_met => "met".to_owned(),
            Ok(_) => "tolerance missed".to_owned(),
        }
    }
}

/// The columns after those of the keys.
const COLUMNS: &str = "model,status,displacement_x,displacement_y,displacement_z,\
    displacement_error,rotation_x,rotation_y,rotation_z,rotation_error,work,work_error,efficiency,\
    efficiency_error,seconds";

fn csv(keys: &[String], rows: &[SweepRow]) -> String {
    let quoted = |text: &String| match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.clone(),
    };
    let optional = |value: Option<f64>| value.map_or(String::new(), |x| format!("{x:?}"));
    let line = |row: &SweepRow| {
        let mut fields: Vec<String> = row.values.iter().map(quoted).collect();
        let result = row.result.as_ref().ok();
        fields.push(result.map_or(String::new(), |result| result.model.clone()));
        fields.push(quoted(&row.status()));
        let empty = COLUMNS.split(',').count() - 2;
        match result {
            None => fields.extend(std::iter::repeat_n(String::new(), empty)),
            Some(found) => {
                fields.extend(found.displacement.iter().map(|x| format!("{x:?}")));
                fields.push(optional(found.displacement_error));
                fields.extend(found.rotation.iter().map(|x| format!("{x:?}")));
                fields.push(optional(found.rotation_error));
                fields.push(format!("{:?}", found.work));
                fields.push(optional(found.work_error));
                fields.push(optional(found.efficiency));
                fields.push(optional(found.efficiency_error));
                fields.push(format!("{:?}", found.seconds));
            }
        }
        fields.join(",") + "\n"
    };
    let head: Vec<String> = keys.iter().map(quoted).collect();
    format!(
        "{},{COLUMNS}\n{}",
        head.join(","),
        rows.iter().map(line).collect::<String>()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without a fluid between them, a sphere under a force moves at `F / (6 π μ a)`; the third
    /// viscosity is refused, and its row says so.
    #[test]
    fn rows_are_those_of_single_runs_for_any_number_of_jobs() {
        let scene = Scene::parse(
            "bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0], force = [1, 0, 0] }]\n\
             gait.phases = [{ duration = 1 }]\nmodel.kind = \"multipole\"",
        )
        .unwrap();
        let keys =
            ["fluid.viscosity=1,2,-1", "bodies.a.radius=0.5:1:2"].map(|k| k.parse().unwrap());
        let of_jobs = |jobs| {
            let options = SweepOptions {
                jobs: Some(jobs),
                folder: None,
                resume: false,
            };
            sweep(&scene, &keys, None, options, &mut ()).unwrap()
        };
        let found = of_jobs(1);
        assert_eq!(found.rows.len(), 6);
        for row in &found.rows {
            let [viscosity, radius] = [0, 1].map(|k| row.values[k].parse::<f64>().unwrap());
            let Ok(result) = &row.result else {
                assert_eq!(viscosity, -1.0);
                assert!(row.status().contains("fluid.viscosity"), "{}", row.status());
                continue;
            };
            let exact = 1.0 / (6.0 * std::f64::consts::PI * viscosity * radius);
            assert!((result.displacement[0] - exact).abs() < 1e-12 * exact);
        }
        let numbers = |sweep: &Sweep| -> Vec<_> {
            let of_row = |row: &SweepRow| row.result.as_ref().ok().map(|r| r.displacement);
            sweep.rows.iter().map(of_row).collect()
        };
        assert_eq!(numbers(&found), numbers(&of_jobs(3)));
        assert_eq!(found.csv().lines().count(), 7);
        let unknown = ["fluid.colour=1,2".parse().unwrap()];
        let options = SweepOptions {
            jobs: Some(1),
            folder: None,
            resume: false,
        };
        let error = sweep(&scene, &unknown, None, options, &mut ()).unwrap_err();
        assert_eq!(error.exit_code(), 2);
    }

    /// A swimmer of three spheres by point forces, whose arms of ten close to six.
    const SWIMMER: &str = "model.kind = \"rpy\"\n\
        bodies = [{ name = \"left\", radius = 1, position = [-10, 0, 0] },\n\
        { name = \"centre\", radius = 1, position = [0, 0, 0] },\n\
        { name = \"right\", radius = 1, position = [10, 0, 0] }]\n\
        links = [{ name = \"left-arm\", body = \"left\", to = \"centre\" },\n\
        { name = \"right-arm\", body = \"right\", to = \"centre\" }]\n\
        gait.phases = [{ link = \"left-arm\", length = 6 }, { link = \"right-arm\", length = 6 },\n\
        { link = \"left-arm\", length = 10 }, { link = \"right-arm\", length = 10 }]";

    /// The length of a link is that at the start, and the gait changes by the same amount: the row
    /// is that of the scene written by hand. Where the arm would close, the row names the value.
    #[test]
    fn the_length_and_the_amplitude_of_a_link_vary() {
        let scene = Scene::parse(SWIMMER).unwrap();
        let options = SweepOptions {
            jobs: Some(1),
            folder: None,
            resume: false,
        };
        let run = |key: &str| sweep(&scene, &[key.parse().unwrap()], None, options, &mut ());
        let net = |sweep: &Sweep, row: usize| {
            let result = sweep.rows[row].result.as_ref();
            result.unwrap().displacement[0]
        };
        let lengths = run("links.left-arm.length=6:10:9").unwrap();
        assert_eq!(lengths.rows.len(), 9);
        let closed = lengths.rows[0].status();
        assert!(
            closed.starts_with("failed: links.left-arm.length=6: ") && closed.contains("touch"),
            "{closed}"
        );
        let amplitudes = run("links.left-arm.amplitude=1,2").unwrap();
        let by_hand = |replaced: [(&str, &str); 3]| {
            let text = (replaced.iter()).fold(SWIMMER.to_owned(), |text, (old, new)| {
                assert!(text.contains(old));
                text.replace(old, new)
            });
            let scene = Scene::parse(&text).unwrap();
            let key = "fluid.viscosity=1".parse().unwrap();
            net(&sweep(&scene, &[key], None, options, &mut ()).unwrap(), 0)
        };
        let shorter = by_hand([
            ("[-10, 0, 0]", "[-8, 0, 0]"),
            ("\"left-arm\", length = 6", "\"left-arm\", length = 4"),
            ("\"left-arm\", length = 10", "\"left-arm\", length = 8"),
        ]);
        let unchanged = ("model", "model");
        let weaker = by_hand([
            ("\"left-arm\", length = 6", "\"left-arm\", length = 8"),
            unchanged,
            unchanged,
        ]);
        let whole = by_hand([unchanged; 3]);
        // The same scene, with numbers that are rounded in other places.
        for (found, expected) in [
            (net(&lengths, 4), shorter),
            (net(&lengths, 8), whole),
            (net(&amplitudes, 0), weaker),
            (net(&amplitudes, 1), whole),
        ] {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        assert!((shorter - whole).abs() > 1e-3 && (weaker - whole).abs() > 1e-3);
    }

    /// Keys were set first and then changed by the parameters, so that rows told other values than
    /// the scene had; values that no scene can have made rows that all failed.
    #[test]
    fn bug_values_of_a_sweep_were_not_those_of_its_scenes() {
        let scene = Scene::parse(SWIMMER).unwrap();
        let varied = |keys: &[&str]| {
            let keys: Vec<VariedKey> = keys.iter().map(|key| key.parse().unwrap()).collect();
            let varied = Varied::new(&scene, &scene.to_toml().unwrap(), &keys);
            varied.map_err(|error| error.to_string())
        };
        let length = "links.left-arm.length=8";
        for other in [
            "gait.phases.0.length=6,7",
            "bodies.left.position=[-9, 0, 0]",
            "bodies.2.position=[9, 0, 0]",
        ] {
            let error = varied(&[other, length]).err().unwrap();
            assert!(
                error.contains("changes with links.left-arm.length"),
                "{error}"
            );
        }
        let amplitude = "links.left-arm.amplitude=1";
        assert!(varied(&["gait.phases.2.length=9", amplitude]).is_ok());
        assert!(varied(&["gait.phases.0.length=7", amplitude]).is_err());
        assert!(varied(&["gait.phases.1.length=7", "bodies.left.radius=1,2", length]).is_ok());
        for bad in ["abc,1", "8,-1", "0,1", "-1:3", "inf"] {
            let error = varied(&[&format!("links.left-arm.length={bad}")])
                .err()
                .unwrap();
            assert!(error.contains("give positive numbers"), "{error}");
        }
        // Links have numbers too, as for other keys.
        let numbered = varied(&["links.0.length=8"]).unwrap();
        let named = varied(&[length]).unwrap();
        assert_eq!(numbered.parameters, named.parameters);
        assert_eq!(named.parameters.len(), 1);
    }

    #[test]
    fn bug_reasons_of_failed_points_name_lines_of_a_text_that_nobody_has() {
        let scene = Scene::parse(SWIMMER).unwrap();
        let keys = ["bodies.left.radius=1,5", "fluid.viscosity=1,2"].map(|k| k.parse().unwrap());
        let options = SweepOptions {
            jobs: Some(1),
            folder: None,
            resume: false,
        };
        let found = sweep(&scene, &keys, None, options, &mut ()).unwrap();
        let reason = found.rows[3].status();
        let start = "failed: bodies.left.radius=5, fluid.viscosity=2: bodies 'left' and 'centre'";
        assert!(reason.starts_with(start), "{reason}");
        // A link without a driven length is answered with the keys that exist.
        let error = sweep(
            &scene,
            &["links.0.angle=1,2".parse().unwrap()],
            None,
            options,
            &mut (),
        );
        let error = error.unwrap_err().to_string();
        assert!(
            error.contains("gait.phases.0.length, gait.phases.2.length"),
            "{error}"
        );
        assert!(error.contains("bodies.left.position"), "{error}");
    }

    /// Interrupts after some rows.
    struct Impatient(std::cell::Cell<usize>);

    impl DesignProgress for Impatient {
        fn is_interrupted(&self) -> bool {
            self.0.set(self.0.get().saturating_sub(1));
            self.0.get() == 0
        }
    }

    #[test]
    fn an_interrupted_sweep_continues_and_refuses_another_scene() {
        let text = "bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0], \
                    force = [1, 0, 0] }]\ngait.phases = [{ duration = 1 }]\n\
                    model.kind = \"multipole\"";
        let scene = Scene::parse(text).unwrap();
        let keys = ["fluid.viscosity=1:9:9".parse().unwrap()];
        let temporary = tempfile::tempdir().unwrap();
        let folder = Folder::create(temporary.path()).unwrap();
        let options = |resume| SweepOptions {
            jobs: Some(1),
            folder: Some(&folder),
            resume,
        };
        let mut impatient = Impatient(4.into());
        let stopped = sweep(&scene, &keys, None, options(false), &mut impatient).unwrap_err();
        assert_eq!(stopped.exit_code(), 130, "{stopped}");
        let resumed = sweep(&scene, &keys, None, options(true), &mut ()).unwrap();
        assert!((1..9).contains(&resumed.kept), "{}", resumed.kept);
        assert_eq!(resumed.rows.len(), 9);
        let numbers: Vec<usize> = resumed.rows.iter().map(|row| row.number).collect();
        assert_eq!(numbers, (0..9).collect::<Vec<_>>());
        let table = std::fs::read_to_string(temporary.path().join("sweep.csv")).unwrap();
        assert_eq!(table, resumed.csv());
        let other = Scene::parse(&text.replace("radius = 1", "radius = 2")).unwrap();
        let error = sweep(&other, &keys, None, options(true), &mut ()).unwrap_err();
        assert!(error.to_string().contains("another scene"), "{error}");
    }
}
