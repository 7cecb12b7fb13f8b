//! Rules of style that a program can check: widths of comments, one file for a module, and the
//! times of slow tests.

use anyhow::Result;

use crate::expect_none;
use crate::files::{SOURCE_FOLDERS, files_below, read, root};
use crate::slow::stated;

/// Largest width of a comment line, in columns.
const MAX_COMMENT_WIDTH: usize = 100;

/// Number of lines above which a source file may contain more than one concept.
const LONG: usize = 800;

/// Checks every Rust file of the repository and lists all violations; also lists long files.
pub fn run() -> Result<()> {
    eprintln!("== widths of comments, places of modules, times of slow tests");
    let mut violations = Vec::new();
    for folder in SOURCE_FOLDERS {
        let names = files_below(folder, ".rs")?;
        violations.extend(doubled_modules(&names));
        for name in &names {
            let text = read(&root().join(name))?;
            violations.extend(of_text(&text).map(|violation| format!("{name}{violation}")));
            let lines = text.lines().count();
            if lines > LONG {
                eprintln!("hint: {name}: {lines} lines, is it one concept?");
            }
        }
    }
    expect_none(&violations, "violations of the rules of style")
}

/// Violations in one file, in the form `:line: message`, to be appended to the file name.
fn of_text(text: &str) -> impl Iterator<Item = String> {
    let widths = (text.lines().zip(1..)).map(|(line, number)| (line.chars().count(), line, number));
    let wide = widths
        .filter(|(width, line, _)| {
            *width > MAX_COMMENT_WIDTH && line.trim_start().starts_with("//")
        })
        .map(|(width, _, number)| {
            format!(":{number}: comment of {width} columns, {MAX_COMMENT_WIDTH} are allowed")
        });
    let untimed = stated(text)
        .into_iter()
        .filter(|test| test.seconds.is_none());
    wide.chain(untimed.map(|test| {
        format!(
            ":{}: `{}` states no time: write #[ignore = \"slow: 40 s\"]",
            test.line, test.function
        )
    }))
}

/// Files `name.rs` next to a folder `name` with files of its own.
fn doubled_modules(names: &[String]) -> impl Iterator<Item = String> {
    let doubled = names.iter().filter(|name| {
        let folder = name.replace(".rs", "/");
        names.iter().any(|other| other.starts_with(&folder))
    });
    doubled.map(|name| {
        let folder = name.trim_end_matches(".rs");
        format!("{name}: next to the folder {folder}, where it should be mod.rs")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn violations(text: &str) -> Vec<String> {
        of_text(text).collect()
    }

    #[test]
    fn wide_comments_are_found() {
        let wide = format!("let x = 1;\n    /// {}\n", "μ".repeat(MAX_COMMENT_WIDTH));
        assert_eq!(
            violations(&wide),
            [":2: comment of 108 columns, 100 are allowed"]
        );
        let code = format!("let wide = \"{}\";", "x".repeat(200));
        assert_eq!(violations(&code), [""; 0]);
    }

    #[test]
    fn slow_tests_must_state_their_time() {
        let text = "#[ignore = \"slow: 3 s\"]\nfn a() {}\n#[ignore = \"long\"]\nfn b() {}\n";
        assert_eq!(
            violations(text),
            [":3: `b` states no time: write #[ignore = \"slow: 40 s\"]"]
        );
    }

    #[test]
    fn a_module_has_one_place() {
        let names = [
            "src/a.rs",
            "src/a/b.rs",
            "src/ab.rs",
            "src/c/mod.rs",
            "src/c/d.rs",
        ];
        let found: Vec<String> = doubled_modules(&names.map(str::to_owned)).collect();
        assert_eq!(
            found,
            ["src/a.rs: next to the folder src/a, where it should be mod.rs"]
        );
    }
}
