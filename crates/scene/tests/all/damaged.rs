//! Scene files with random edits are read or refused, without a panic.

use proptest::prelude::*;
use scene::Scene;

use super::edits::{edited, edits};

const SCENE: &str = include_str!("../../../../scenes/three-sphere.toml");

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, ..ProptestConfig::default() })]

    #[test]
    fn edited_scenes_are_read_or_refused(edits in edits()) {
        match Scene::parse(&edited(SCENE, &edits)) {
            // A scene that was read can be written and read again.
            Ok(scene) => prop_assert!(Scene::parse(&scene.to_toml().unwrap()).is_ok()),
            Err(error) => {
                prop_assert!(!error.to_string().is_empty());
            }
        }
    }
}
