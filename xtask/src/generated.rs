//! Generated pages that are older than their generators.
//!
//! A page says in its first lines by which command it is made. `docs/generated.txt` has for each
//! of them the hash of its generator, the sources of the study or the script, those that they use
//! and the scenes that they name, as it was when the page was made. A generator that changes
//! afterwards is found here; that a change of a solver would change the numbers of a page is not.

use std::fmt::Write as _;

use anyhow::{Result, bail};

use crate::expect_none;
use crate::files::{files_below, read, root};

/// The hashes, a line per page.
const LIST: &str = "docs/generated.txt";

/// Number of lines at the start of a page among which that about its command is.
const FIRST_LINES: usize = 6;

/// A generated page with the files of its generator.
struct Generated {
    page: String,
    command: String,
    inputs: Vec<String>,
}

impl Generated {
    /// The hash of the generator as it is now.
    fn hash(&self) -> Result<u64> {
        let mut hash = FNV_BASIS;
        for name in &self.inputs {
            let text = read(&root().join(name))?;
            hash = hashed(hash, name.as_bytes());
            hash = hashed(hash, text.as_bytes());
        }
        Ok(hash)
    }
}

/// Checks the list; for pages that are named, writes the hashes of their generators into it.
pub fn run(made: &[&str]) -> Result<()> {
    eprintln!("== generated pages");
    let pages = generated()?;
    let list = match root().join(LIST).exists() {
        true => read(&root().join(LIST))?,
        false => String::new(),
    };
    if let Some(unknown) = (made.iter()).find(|name| pages.iter().all(|page| page.page != **name)) {
        bail!("{unknown} does not say in its first lines `Made by` which command");
    }
    let (mut older, mut text) = (Vec::new(), String::new());
    for name in without_page(&list, &pages) {
        older.push(format!(
            "{LIST} has {name}, which does not say in its first lines `Made by` which command; \
             write that, or remove the line"
        ));
    }
    for page in &pages {
        let hash = format!("{:016x}", page.hash()?);
        let known = list.lines().find_map(|line| {
            let (name, hash) = line.split_once(' ')?;
            (name == page.page).then(|| hash.to_owned())
        });
        let entered = match made.contains(&&*page.page) {
            true => Some(hash.clone()),
            false => known,
        };
        if entered.as_ref() != Some(&hash) {
            older.push(format!(
                "{} is older than {}: make it again by `{}`; then, or if the change does not touch \
                 its results, `cargo xtask generated {}`",
                page.page, page.inputs[0], page.command, page.page
            ));
        }
        // Formatting into a string does not fail.
        let _ = writeln!(text, "{} {}", page.page, entered.unwrap_or_default());
    }
    if !made.is_empty() {
        std::fs::write(root().join(LIST), text)?;
    }
    expect_none(&older, "pages are older than their generators")
}

/// Names in the list that are no generated pages.
fn without_page<'a>(list: &'a str, pages: &[Generated]) -> Vec<&'a str> {
    let names = list.lines().filter_map(|line| line.split(' ').next());
    let is_page = |name: &str| pages.iter().any(|page| page.page == name);
    names.filter(|name| !is_page(name)).collect()
}

/// The generated pages of the documentation.
fn generated() -> Result<Vec<Generated>> {
    let sources = files_below("crates/studies/src", ".rs")?;
    let mut found = Vec::new();
    for page in files_below("docs", ".md")? {
        let text = read(&root().join(&page))?;
        let Some(command) = command(&text) else {
            continue;
        };
        let mut inputs = generator(command, &sources);
        if inputs.is_empty() {
            bail!("{page} is made by `{command}`, which is no study and no script of docs/figures");
        }
        let mut number = 0;
        while let Some(name) = inputs.get(number).cloned() {
            number += 1;
            if name.ends_with(".toml") {
                continue;
            }
            let text = read(&root().join(&name))?;
            for used in [uses(&name, &text, &sources), scenes(&text)].concat() {
                if !inputs.contains(&used) {
                    inputs.push(used);
                }
            }
        }
        found.push(Generated {
            page,
            command: command.to_owned(),
            inputs,
        });
    }
    Ok(found)
}

/// The command by which a page says that it is made.
fn command(page: &str) -> Option<&str> {
    let mut lines = page.lines().take(FIRST_LINES);
    lines.find_map(|line| Some(line.split_once("Made by `")?.1.split_once('`')?.0))
}

/// The files of a generator: of a study among the `sources`, or the script.
fn generator(command: &str, sources: &[String]) -> Vec<String> {
    let mut words = command.split_whitespace();
    if let Some(script) = words.clone().find(|word| word.starts_with("docs/figures/")) {
        return vec![script.to_owned()];
    }
    let Some(name) = words.nth(2).filter(|_| command.starts_with("cargo xtask ")) else {
        return Vec::new();
    };
    sources_of(name, sources)
}

/// Modules that draw pages, whose changes touch no numbers.
const OF_PAGES: [&str; 4] = ["chart", "figures", "page", "table"];

/// Files that a source of a generator uses: modules of the studies among the `sources`, scripts
/// beside a script.
fn uses(name: &str, text: &str, sources: &[String]) -> Vec<String> {
    let is_script = name.ends_with(".py");
    let word = |line: &str| -> Option<String> {
        let rest = match is_script {
            true => line.strip_prefix("from ").or(line.strip_prefix("import ")),
            false => line
                .trim_start()
                .split_once("use crate::")
                .map(|(_, rest)| rest),
        };
        let end = |c: char| !(c.is_alphanumeric() || c == '_');
        Some(rest?.split(end).next()?.to_owned())
    };
    let words = text.lines().filter_map(word);
    let mut files = Vec::new();
    for module in words.filter(|word| !OF_PAGES.contains(&word.as_str())) {
        if is_script {
            let file = format!("docs/figures/{module}.py");
            files.extend(root().join(&file).exists().then_some(file));
        } else {
            files.extend(sources_of(&module, sources));
        }
    }
    files
}

/// The files of a module of the studies.
fn sources_of(module: &str, sources: &[String]) -> Vec<String> {
    let file = format!("crates/studies/src/{module}.rs");
    let folder = format!("crates/studies/src/{module}/");
    let is_own = |source: &&String| **source == file || source.starts_with(&folder);
    sources.iter().filter(is_own).cloned().collect()
}

/// Scenes of the repository that a generator names.
fn scenes(text: &str) -> Vec<String> {
    let words = text.split(|c: char| !(c.is_alphanumeric() || "/._-".contains(c)));
    let named = words.filter(|word| word.starts_with("scenes/") && word.ends_with(".toml"));
    let existing = named.filter(|name| root().join(name).exists());
    existing.map(str::to_owned).collect()
}

/// Start value and factor of the hash FNV-1a with 64 bits, the same on all machines.
const FNV_BASIS: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0100_0000_01b3;

/// The hash after these bytes and their end.
fn hashed(hash: u64, bytes: &[u8]) -> u64 {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(FNV_PRIME);
    step(bytes.iter().fold(hash, step), &0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generators_follow_from_the_words_of_a_page() {
        let page = "# Title\n\n2026, 2 threads. Made by `cargo xtask ale`. More `words`.\n";
        assert_eq!(command(page), Some("cargo xtask ale"));
        assert_eq!(command("# T\n\nMade by a study that is now `x`.\n"), None);
        let sources = ["ale/mod.rs", "ale/cases.rs", "alert.rs", "models.rs"];
        let sources = sources.map(|name| format!("crates/studies/src/{name}"));
        let of = |command: &str| generator(command, &sources);
        assert_eq!(of("cargo xtask ale"), sources[..2]);
        assert_eq!(of("cargo xtask models"), sources[3..]);
        assert_eq!(
            of("python docs/figures/many.py --quick"),
            ["docs/figures/many.py"]
        );
        assert!(of("cargo xtask none").is_empty() && of("make").is_empty());
    }

    #[test]
    fn a_hash_sees_every_byte_and_the_ends_of_files() {
        // The published value of FNV-1a for the letter a, before the end.
        assert_eq!(
            (FNV_BASIS ^ 97).wrapping_mul(FNV_PRIME),
            0xaf63_dc4c_8601_ec8c
        );
        let of = |parts: &[&str]| parts.iter().fold(FNV_BASIS, |h, p| hashed(h, p.as_bytes()));
        assert_ne!(of(&["ab", "c"]), of(&["a", "bc"]));
        assert_ne!(of(&["ab"]), of(&["ac"]));
    }

    /// Changes of what a generator uses, and pages that lost their command, were not found.
    #[test]
    fn bug_generators_were_hashed_without_what_they_use() {
        let pages = generated().unwrap();
        let has = |page: &str, input: &str| {
            let found = pages.iter().find(|of| of.page == page).unwrap();
            found.inputs.iter().any(|of| of == input)
        };
        assert!(has("docs/random-laws.md", "docs/figures/random_scenes.py"));
        assert!(has("docs/deforming.md", "docs/figures/helix.py"));
        assert!(!has("docs/deforming.md", "docs/figures/figures.py"));
        assert!(has("docs/newton.md", "crates/studies/src/oseen.rs"));
        assert!(has("docs/tolerances.md", "crates/studies/src/random.rs"));
        assert!(has("docs/models.md", "crates/studies/src/reference.rs"));
        assert!(!has("docs/models.md", "crates/studies/src/page.rs"));
        let list = "docs/models.md 0\ndocs/none.md 1\n";
        assert_eq!(without_page(list, &pages), ["docs/none.md"]);
    }

    #[test]
    fn scenes_that_a_generator_names_belong_to_it() {
        let text = "run(\"scenes/three-sphere.toml\", `scenes/none.toml`, scenes/x.stl)";
        assert_eq!(scenes(text), ["scenes/three-sphere.toml"]);
        let pages = generated().unwrap();
        assert!(pages.iter().any(|page| page.page == "docs/models.md"));
    }
}
