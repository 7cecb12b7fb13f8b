//! Two rules of style that a program can check: width of comments, length of files.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::manifests::{read, root};

/// Largest width of a comment line, in columns.
const WIDEST: usize = 100;

/// Largest number of lines of a source file; longer files contain more than one concept.
const LONGEST: usize = 400;

/// Checks every Rust file of the workspace and lists all violations.
pub fn run() -> Result<()> {
    eprintln!("== widths of comments, lengths of files");
    let root = root();
    let mut violations = Vec::new();
    for folder in ["crates", "xtask", "fuzz", "python"] {
        for file in rust_files(&root.join(folder))? {
            let text = read(&file)?;
            let name = file.strip_prefix(&root).unwrap_or(&file).display();
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

/// All Rust files below a folder, except in build folders.
fn rust_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let entries = std::fs::read_dir(folder)
        .with_context(|| format!("could not list {}", folder.display()))?;
    for entry in entries {
        let path = entry?.path();
        if path.is_dir() {
            if path.file_name().is_some_and(|name| name != "target") {
                files.extend(rust_files(&path)?);
            }
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
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
