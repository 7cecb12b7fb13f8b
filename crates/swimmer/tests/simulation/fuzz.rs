//! Checkpoints with random edits, and the corpus of the fuzz targets, are read or refused, without
//! a panic.

use proptest::prelude::*;
use swimmer::choose;
use swimmer::output::sealed;
use swimmer::{Checkpoint, Folder, Interim, Scene, checkpoint};

use super::edits::{edited, edits};

#[path = "../../../../fuzz/src/checkpoint.rs"]
mod checkpoint_target;
#[path = "../../../../fuzz/src/corpus.rs"]
mod corpus;
#[path = "../../../../fuzz/src/gait_table.rs"]
mod gait_table_target;
#[path = "../../../../fuzz/src/msh.rs"]
mod msh_target;
#[path = "../../../../fuzz/src/scene.rs"]
mod scene_target;

const SCENE: &str = include_str!("../../../../scenes/three-sphere.toml");

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, ..ProptestConfig::default() })]

    #[test]
    fn edited_checkpoints_are_read_or_refused(edits in edits()) {
        let scene = Scene::parse(SCENE).unwrap();
        let mut model = choose(&scene).unwrap().model;
        let Interim { state, outcome, .. } = Interim::start(&scene).unwrap();
        let temporary = tempfile::tempdir().unwrap();
        let folder = Folder::create(temporary.path()).unwrap();
        Checkpoint::new(&scene, &state, &outcome, model.as_ref(), &[]).unwrap().write(&folder).unwrap();
        let path = temporary.path().join(checkpoint::FILE);
        let text = std::fs::read_to_string(&path).unwrap();
        let text = edited(&text, &edits);
        // With a checksum of its own, so that more than the checksum is tried.
        let value = serde_json::from_str::<serde_json::Value>(&text).ok();
        let text = value.and_then(|value| sealed(&value).ok()).unwrap_or(text);
        std::fs::write(&path, text).unwrap();
        let restored = Checkpoint::read(temporary.path())
            .and_then(|checkpoint| checkpoint.restore(&scene, model.as_mut(), temporary.path()));
        if let Err(error) = restored {
            prop_assert!(!error.to_string().is_empty());
        }
    }
}

#[test]
fn the_corpus_of_scenes_is_read_or_refused() {
    corpus::replay("scene", scene_target::read);
}

#[test]
fn the_corpus_of_checkpoints_is_read_or_refused() {
    corpus::replay("checkpoint", checkpoint_target::read);
}

/// Mutations of a checkpoint that is refused for its version reach nothing behind it. Where the
/// format has changed, `fuzz/own_files.py` writes the corpus again.
#[test]
fn bug_the_corpus_of_checkpoints_was_of_an_older_version() {
    let text = include_str!("../../../../fuzz/corpus/checkpoint/whole.json");
    Checkpoint::parse(text, "whole.json").unwrap();
}

#[test]
fn the_corpus_of_meshes_is_read_or_refused() {
    corpus::replay("msh", msh_target::read);
}

#[test]
fn the_corpus_of_gait_tables_is_read_or_refused() {
    corpus::replay("gait_table", gait_table_target::read);
}
