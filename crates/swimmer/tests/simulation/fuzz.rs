//! Checkpoints with random edits are read or refused, without a panic.

use proptest::prelude::*;
use swimmer::choose;
use swimmer::{Checkpoint, Folder, Interim, Scene, checkpoint};

const SCENE: &str = include_str!("../../../../scenes/three-sphere.toml");

/// A change of a text as by a slip of the keyboard or a damaged disk.
#[derive(Clone, Debug)]
enum Edit {
    Remove { at: usize, len: usize },
    Insert { at: usize, text: String },
    Repeat { at: usize, len: usize },
    Swap { at: usize, with: usize },
}

fn edit() -> impl Strategy<Value = Edit> {
    // Pieces with a meaning in TOML, in JSON or in numbers.
    let text = prop::sample::select(vec![
        "[",
        "]",
        "[[",
        "]]",
        "{",
        "}",
        "=",
        ",",
        "\"",
        "'",
        "\n",
        "#",
        ".",
        "-",
        "e",
        "nan",
        "inf",
        "-1",
        "0",
        "1e999",
        "1e-400",
        "99999999999999999999",
        "true",
        "null",
        "\u{0}",
        "é",
        "[[bodies]]\n",
        "cycles = 4294967295\n",
        "radius = -0.0\n",
    ]);
    // Taken modulo the length of the text when it is applied.
    let place = || 0usize..1 << 20;
    prop_oneof![
        (place(), 1usize..40).prop_map(|(at, len)| Edit::Remove { at, len }),
        (place(), text).prop_map(|(at, text)| Edit::Insert {
            at,
            text: text.to_owned()
        }),
        (place(), 1usize..200).prop_map(|(at, len)| Edit::Repeat { at, len }),
        (place(), place()).prop_map(|(at, with)| Edit::Swap { at, with }),
    ]
}

fn edited(text: &str, edits: &[Edit]) -> String {
    let mut chars: Vec<char> = text.chars().collect();
    for edit in edits {
        let size = chars.len().max(1);
        let end = |at: usize, len: usize| (at + len).min(chars.len());
        match edit {
            Edit::Remove { at, len } => {
                let at = (at % size).min(chars.len());
                drop(chars.drain(at..end(at, *len)));
            }
            Edit::Insert { at, text } => {
                let at = (at % size).min(chars.len());
                drop(chars.splice(at..at, text.chars()));
            }
            Edit::Repeat { at, len } => {
                let at = (at % size).min(chars.len());
                let part = chars[at..end(at, *len)].to_vec();
                drop(chars.splice(at..at, part));
            }
            Edit::Swap { at, with } if !chars.is_empty() => chars.swap(at % size, with % size),
            Edit::Swap { .. } => {}
        }
    }
    chars.into_iter().collect()
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    prop::collection::vec(edit(), 1..6)
}

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
