//! `flow_slices.json` and `table.json`, as they are and with a checksum that belongs to them:
//! otherwise the checksum would keep the fuzzer from everything behind it.

use design::{DesignError, DesignProgress, StrokeLimits, StrokeTable, tabulate};
use pictures::RunRecord;
use swimmer::models::TablePart;
use swimmer::output::sealed;
use swimmer::{Checkpoint, Folder};

/// The checkpoint of the run whose flow is read, and of the scene whose table is read.
const CHECKPOINT: &str = include_str!("../corpus/checkpoint/whole.json");

/// The text of a file, and the same values with their checksum.
fn versions(bytes: &[u8]) -> Vec<String> {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return Vec::new();
    };
    let value = serde_json::from_str::<serde_json::Value>(text).ok();
    let sealed = value.and_then(|value| sealed(&value).ok());
    [Some(text.to_owned()), sealed]
        .into_iter()
        .flatten()
        .collect()
}

/// Calls `read` with a folder for each version of a file in it.
fn in_folder(name: &str, bytes: &[u8], mut read: impl FnMut(&Folder)) {
    let temporary = tempfile::tempdir().expect("a folder of temporary files");
    let folder = Folder::create(temporary.path()).expect("a folder");
    for text in versions(bytes) {
        std::fs::write(folder.path().join(name), text).expect("a file of this folder");
        read(&folder);
    }
}

/// Reads the flow of a run, and writes its page and its movie.
///
/// # Panics
/// If the folder of temporary files cannot be written.
pub fn read_flow_slices(bytes: &[u8]) {
    in_folder("flow_slices.json", bytes, |folder| {
        let write = |name: &str, contents: &str| {
            std::fs::write(folder.path().join(name), contents).expect("a file of this folder");
        };
        write("checkpoint.json", CHECKPOINT);
        write("summary.json", "{}");
        let record = RunRecord::read(folder.path()).expect("the checkpoint of the corpus");
        drop(record.write_page(folder));
        drop(record.write_movie(folder));
    });
}

/// Solves nothing.
struct Interrupted;

impl DesignProgress for Interrupted {
    fn is_interrupted(&self) -> bool {
        true
    }
}

/// Reads the table of a scene, and evaluates what was read; solves nothing where it is refused.
///
/// # Panics
/// If the folder of temporary files cannot be written.
pub fn read_table(bytes: &[u8]) {
    in_folder("table.json", bytes, |folder| {
        if let Ok(table) = table_in(folder) {
            let shapes = [vec![4.0], vec![5.0], vec![f64::NAN]];
            table.displacement_error(&shapes);
        }
    });
}

/// The table in a folder, of the scene of the corpus.
///
/// # Errors
/// A table of another scene or that is damaged: its computation does not begin.
///
/// # Panics
/// If the corpus of checkpoints is of an older version.
pub fn table_in(folder: &Folder) -> Result<StrokeTable, DesignError> {
    let checkpoint = Checkpoint::parse(CHECKPOINT, "whole.json").expect("this version");
    let (scene, ..) = checkpoint.into_outcome("whole.json").expect("a run");
    let limits = StrokeLimits::from_scene(&scene)?;
    let folder = (Some(folder), TablePart::Whole);
    tabulate(&scene, &limits, 1.0, folder, &mut Interrupted)
}
