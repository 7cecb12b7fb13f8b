//! Two rules of style that a program can check: width of comments, length of files.

use anyhow::{Result, bail};

use crate::files::{SOURCE_FOLDERS, files_below, read, root};

/// Largest width of a comment line, in columns.
const WIDEST: usize = 100;

/// Largest number of lines of a source file; longer files contain more than one concept.
const LONGEST: usize = 400;

/// Checks every Rust file of the workspace and lists all violations.
pub fn run() -> Result<()> {
    eprintln!("== widths of comments, lengths of files");
    let mut violations = Vec::new();
    for folder in SOURCE_FOLDERS {
        for name in files_below(folder, ".rs")? {
            let text = read(&root().join(&name))?;
            violations.extend(
                of_text(&text)
                    .into_iter()
                    .map(|violation| format!("{name}{violation}")),
            );
        }
    }
    for violation in &violations {
        eprintln!("{violation}");
    }
    match violations.len() {
        0 => Ok(()),
        count => bail!("{count} violations of the rules of style"),
    }
}

/// Violations in one file, in the form `:line: message`, to be appended to the file name.
fn of_text(text: &str) -> Vec<String> {
    let mut violations: Vec<String> = text
        .lines()
        .enumerate()
        .filter(|(_, line)| line.trim_start().starts_with("//") && line.chars().count() > WIDEST)
        .map(|(number, line)| {
            let width = line.chars().count();
            format!(
                ":{}: comment of {width} columns, {WIDEST} are allowed",
                number + 1
            )
        })
        .collect();
    let lines = text.lines().count();
    if lines > LONGEST {
        violations.push(format!(": {lines} lines, {LONGEST} are allowed"));
    }
    violations
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_comments_and_long_files_are_found() {
        let wide = format!("let x = 1;\n    /// {}\n", "μ".repeat(WIDEST));
        assert_eq!(
            of_text(&wide),
            [":2: comment of 108 columns, 100 are allowed"]
        );
        assert!(of_text(&format!("let wide = \"{}\";", "x".repeat(200))).is_empty());
        assert_eq!(of_text(&"\n".repeat(LONGEST)), [""; 0]);
        assert_eq!(
            of_text(&"\n".repeat(LONGEST + 1)),
            [": 401 lines, 400 are allowed"]
        );
    }
}
