//! Programs of the crates' README files, built as their readers would build them: with the
//! dependencies that the README states and no others.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};
use toml::{Table, Value};

use crate::cargo;
use crate::files::{read, root};
use crate::manifests::{Member, manifest, members};

/// Folder of the packages that are built, relative to the root of the workspace.
const FOLDER: &str = "target/readmes";

/// Builds the program of every README of a publishable library.
pub fn run() -> Result<()> {
    eprintln!("== programs of READMEs");
    let members = members()?;
    let folder = root().join(FOLDER);
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    let workspace = manifest(".")?;
    let mut packages = Vec::new();
    let version = &workspace["workspace"]["package"]["version"];
    for member in members
        .iter()
        .filter(|member| member.is_publishable() && !member.is_excluded)
    {
        let readme = read(&root().join(&member.folder).join("README.md"))?;
        let programs = blocks(&readme, "rust");
        if programs.is_empty() {
            continue;
        }
        write_package(&folder, member, &readme, &programs, &members, version)
            .with_context(|| format!("{}/README.md", member.folder))?;
        packages.push(Value::from(member.name()));
    }
    // The profiles of the workspace, so that what it has built serves here too.
    let mut root_manifest = Table::new();
    let settings = Table::from_iter([
        ("members".to_owned(), Value::Array(packages)),
        ("resolver".to_owned(), Value::from("3")),
    ]);
    root_manifest.insert("workspace".to_owned(), Value::Table(settings));
    if let Some(profiles) = workspace.get("profile") {
        root_manifest.insert("profile".to_owned(), profiles.clone());
    }
    fs::write(folder.join("Cargo.toml"), toml::to_string(&root_manifest)?)?;
    fs::copy(root().join("Cargo.lock"), folder.join("Cargo.lock"))?;
    let manifest = format!("{FOLDER}/Cargo.toml");
    let target = root().join("target");
    let target = target
        .to_str()
        .context("the path of the workspace is not UTF-8")?;
    cargo::run(
        &["check", "--manifest-path", &manifest, "--offline"],
        &[("CARGO_TARGET_DIR", target)],
    )
}

/// Writes the package of a README: its dependencies, its programs, and the folders of examples
/// that they include.
fn write_package(
    folder: &Path,
    member: &Member,
    readme: &str,
    programs: &[String],
    members: &[Member],
    version: &Value,
) -> Result<()> {
    let package = folder.join(member.name());
    let tables = blocks(readme, "toml");
    let stated = tables
        .iter()
        .find(|table| table.starts_with("[dependencies]"))
        .context("has a program, but no block of TOML with [dependencies]")?;
    let name = format!("readme-of-{}", member.name());
    let stated: Table = stated.parse()?;
    let dependencies = with_paths(&stated["dependencies"], members, version)?;
    let manifest = Table::from_iter([
        ("package".to_owned(), Value::Table(header(&name))),
        ("dependencies".to_owned(), Value::Table(dependencies)),
    ]);
    fs::create_dir_all(package.join("src/bin"))?;
    fs::write(package.join("Cargo.toml"), toml::to_string(&manifest)?)?;
    for (number, program) in programs.iter().enumerate() {
        let file = package.join(format!("src/bin/{}-{number}.rs", member.name()));
        fs::write(file, whole_program(program))?;
    }
    copy_folders(
        &root().join(&member.folder).join("examples"),
        &package.join("examples"),
    )
}

/// The head of a manifest.
fn header(name: &str) -> Table {
    Table::from_iter([
        ("name".to_owned(), Value::from(name)),
        ("edition".to_owned(), Value::from("2024")),
        ("autoexamples".to_owned(), Value::from(false)),
    ])
}

/// The dependencies of a README with the paths of the crates, whose versions it must name.
fn with_paths(stated: &Value, members: &[Member], version: &Value) -> Result<Table> {
    let mut dependencies = Table::new();
    for (name, stated) in stated.as_table().context("[dependencies] is no table")? {
        let package = stated.get("package").and_then(Value::as_str);
        let package = package.unwrap_or(name);
        let member = members
            .iter()
            .find(|member| member.package() == Some(package))
            .with_context(|| format!("depends on {package}, which is not in the workspace"))?;
        let found = stated.get("version").unwrap_or(stated);
        if found != version {
            bail!("states version {found} of {package}, which has {version}");
        }
        let mut dependency = stated.as_table().cloned().unwrap_or_default();
        let path = root().canonicalize()?.join(&member.folder);
        let path = path
            .to_str()
            .context("the path of the workspace is not UTF-8")?;
        dependency.insert("path".to_owned(), Value::from(path));
        dependencies.insert(name.clone(), Value::Table(dependency));
    }
    Ok(dependencies)
}

/// Blocks of code in a language, without the fences.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let Some(found) = line.strip_prefix("```") else {
            continue;
        };
        let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        if found == language {
            blocks.push(block.join("\n"));
        }
    }
    blocks
}

/// The program that rustdoc makes of a block: hidden lines are part of it, and it is the body of
/// `main` unless it has one.
fn whole_program(block: &str) -> String {
    let mut program = String::new();
    for line in block.lines() {
        let line = line.strip_prefix("# ").unwrap_or(line);
        let _ = writeln!(program, "{line}");
    }
    if program.contains("fn main()") {
        return program;
    }
    format!("fn main() {{\n    let result = || {{\n{program}}};\n    result().unwrap();\n}}\n")
}

/// Copies the folders in a folder, which are modules of examples, with their files.
fn copy_folders(from: &Path, to: &Path) -> Result<()> {
    let Ok(entries) = fs::read_dir(from) else {
        return Ok(());
    };
    for entry in entries {
        let entry = entry?;
        if !entry.path().is_dir() {
            continue;
        }
        let target = to.join(entry.file_name());
        fs::create_dir_all(&target)?;
        for file in fs::read_dir(entry.path())? {
            let file = file?;
            fs::copy(file.path(), target.join(file.file_name()))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_a_language_are_found_and_made_programs() {
        let page =
            "a\n```toml\n[dependencies]\n```\n```rust\nlet x = 1;\n# Ok::<(), ()>(())\n```\n";
        assert_eq!(blocks(page, "toml"), ["[dependencies]"]);
        let [program] = &blocks(page, "rust")[..] else {
            panic!("one program");
        };
        let whole = whole_program(program);
        assert!(whole.contains("let x = 1;\nOk::<(), ()>(())\n"), "{whole}");
        assert_eq!(whole_program("fn main() {}"), "fn main() {}\n");
    }
}
