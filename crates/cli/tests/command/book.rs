//! The commands of the book `docs/book`: they run, and print what the page says.
//!
//! A block `console` has commands behind `$`, with further lines of a command behind `>`. The other
//! lines are lines of its output, in this order; lines of the output may be left out. Each page
//! starts in an empty folder with the scenes of the repository. Blocks `console slow` run with
//! `cargo test -- --ignored`. Blocks `sh` have commands that build or install.

use std::path::{Path, PathBuf};

use crate::{shell, text};

/// Commands of blocks `sh`, which are not run from here: checks and wheel are those of `.ci`,
/// examples are run by the tests of their crates, benchmarks take minutes.
const ELSEWHERE: [&str; 7] = [
    "cargo bench -p microswim-linalg",
    "cargo install --path crates/cli",
    "cargo run --release -p microswim-models --example own_model",
    "cargo run --release -p microswim-stokes --example drag",
    "cargo xtask ci",
    "cargo xtask validate --quick",
    "pip install ./python",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The pages of the book, with their names.
fn pages() -> Vec<(String, String)> {
    let files = std::fs::read_dir(root().join("docs/book")).unwrap();
    let mut pages: Vec<(String, String)> = files
        .map(|file| file.unwrap().path())
        .map(|path| {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, std::fs::read_to_string(path).unwrap())
        })
        .collect();
    pages.sort();
    pages
}

/// The fenced blocks of a page: kind and text.
fn blocks(page: &str) -> Vec<(String, String)> {
    let mut blocks = Vec::new();
    let mut parts = page.split("\n```");
    parts.next();
    while let Some(block) = parts.next() {
        let (kind, text) = block.split_once('\n').unwrap();
        blocks.push((kind.to_owned(), format!("{text}\n")));
        // The text after the block.
        parts.next();
    }
    blocks
}

/// A command with the lines of its output that the page shows.
struct Example {
    command: String,
    printed: Vec<String>,
}

fn examples(block: &str) -> Vec<Example> {
    let mut examples: Vec<Example> = Vec::new();
    for line in block.lines() {
        if let Some(command) = line.strip_prefix("$ ") {
            examples.push(Example {
                command: command.to_owned(),
                printed: Vec::new(),
            });
            continue;
        }
        let example = examples.last_mut().expect("a block begins with a command");
        match line.strip_prefix('>') {
            Some(more) => {
                example.command += "\n";
                example.command += more.strip_prefix(' ').unwrap_or(more);
            }
            None => example.printed.push(line.to_owned()),
        }
    }
    examples
}

/// Runs the blocks of one kind of all pages and compares what they print.
///
/// A shown line is a printed line or the beginning of one.
fn run_blocks(kind: &str) {
    let mut commands = 0;
    let mut differences = String::new();
    for (name, page) in pages() {
        let folder = tempfile::tempdir().unwrap();
        let scenes = folder.path().join("scenes");
        std::fs::create_dir(&scenes).unwrap();
        for file in std::fs::read_dir(root().join("scenes")).unwrap() {
            let file = file.unwrap();
            std::fs::copy(file.path(), scenes.join(file.file_name())).unwrap();
        }
        for (_, block) in blocks(&page).iter().filter(|block| block.0 == kind) {
            for Example { command, printed } in examples(block) {
                // A page may write the same template twice, for readers who begin in the middle.
                if let Some(template) = command.strip_prefix("swim new ") {
                    let _ = std::fs::remove_file(folder.path().join(format!("{template}.toml")));
                }
                let output = shell(folder.path(), &command);
                let errors = text(&output.stderr);
                assert!(output.status.success(), "{name}: {command}: {errors}");
                let text = text(&output.stdout);
                let mut lines = text.lines();
                let missing = printed
                    .iter()
                    .find(|shown| !lines.any(|line| line.starts_with(*shown)));
                if let Some(shown) = missing {
                    differences += &format!("{name}: {command}: no line '{shown}' in\n{text}\n");
                }
                commands += 1;
            }
        }
    }
    assert!(commands > 0);
    assert!(differences.is_empty(), "{differences}");
}

#[test]
fn the_commands_of_the_book_print_what_it_says() {
    run_blocks("console");
}

#[test]
#[ignore = "slow: 2 min"]
fn the_slow_commands_of_the_book_print_what_it_says() {
    run_blocks("console slow");
}

#[test]
fn other_blocks_of_the_book_are_known() {
    for (name, page) in pages() {
        for (kind, block) in blocks(&page) {
            match kind.as_str() {
                "sh" => {
                    for line in block.lines() {
                        assert!(ELSEWHERE.contains(&line), "{name}: {line}");
                    }
                }
                // The lines of the example that the tests of the Python package run.
                "python" => {
                    let example = root().join("python/examples/three_spheres.py");
                    let example = std::fs::read_to_string(example).unwrap();
                    for line in block.lines() {
                        assert!(example.lines().any(|known| known == line), "{name}: {line}");
                    }
                }
                // Lines that a reader adds to an existing file.
                "rust,ignore" => {}
                "console" | "console slow" | "text" | "toml" => {}
                other => panic!("{name}: unknown kind of block '{other}'"),
            }
        }
    }
}
