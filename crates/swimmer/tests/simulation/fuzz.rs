//! Checkpoints with random edits are read or refused, without a panic.

use proptest::prelude::*;
use swimmer::choose;
use swimmer::{Checkpoint, Folder, Interim, Scene, checkpoint};

use super::edits::{edited, edits};

const SCENE: &str = include_str!("../../../../scenes/three-sphere.toml");

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, ..ProptestConfig::default() })]

    #[test]
    fn edited_checkpoints_are_read_or_refused(edits in edits()) {
        let scene = Scene::parse(SCENE).unwrap();
        let mut model = choose(&scene).unwrap().model;
        let Interim { state, outcome } = Interim::start(&scene).unwrap();
        let temporary = tempfile::tempdir().unwrap();
        let folder = Folder::create(temporary.path()).unwrap();
        Checkpoint::new(&scene, &state, &outcome, model.as_ref(), &[]).unwrap().write(&folder).unwrap();
        let path = temporary.path().join(checkpoint::FILE);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, edited(&text, &edits)).unwrap();
        let restored = Checkpoint::read(temporary.path())
            .and_then(|checkpoint| checkpoint.restore(&scene, model.as_mut(), temporary.path()));
        if let Err(error) = restored {
            prop_assert!(!error.to_string().is_empty());
        }
    }
}
