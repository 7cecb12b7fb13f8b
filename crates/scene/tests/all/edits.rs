//! Random edits of a text. The tests of checkpoints in `swimmer` include this file too.

use proptest::prelude::*;

/// A change of a text as by a slip of the keyboard or a damaged disk.
#[derive(Clone, Debug)]
pub enum Edit {
    Remove { at: usize, len: usize },
    Insert { at: usize, text: String },
    Repeat { at: usize, len: usize },
    Swap { at: usize, with: usize },
}

fn edit() -> impl Strategy<Value = Edit> {
    // Pieces with a meaning in TOML, in JSON or in numbers.
    let words = "[ ] [[ ]] { } = , \" ' # . - e nan inf -1 0 1e999 1e-400 99999999999999999999 true \
                 null \u{0} é";
    let lines = [
        "\n",
        "[[bodies]]\n",
        "cycles = 4294967295\n",
        "radius = -0.0\n",
    ];
    let text = prop::sample::select(words.split(' ').chain(lines).collect::<Vec<_>>());
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

/// The text after these edits.
pub fn edited(text: &str, edits: &[Edit]) -> String {
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

/// A few random edits.
pub fn edits() -> impl Strategy<Value = Vec<Edit>> {
    prop::collection::vec(edit(), 1..6)
}
