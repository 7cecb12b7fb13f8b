//! Packages of the publishable crates: complete, accepted by `cargo package`, and built without
//! their default features.

use anyhow::Result;

use crate::files::root;
use crate::manifests::members;
use crate::{cargo, expect_none};

/// Files that every package contains: its front page and, as links, the texts of the licences.
const FILES: [&str; 3] = ["README.md", "LICENSE-MIT", "LICENSE-APACHE"];

/// Builds the archives of all publishable crates, without compiling them again.
pub fn run() -> Result<()> {
    eprintln!("== packages");
    expect_none(&missing_files()?, "files are missing in packages")?;
    // Packages of one call may depend on each other without being in the registry.
    let mut arguments = vec!["package", "--workspace", "--no-verify", "--allow-dirty"];
    arguments.extend(["--locked", "--offline", "--quiet"]);
    let members = members()?;
    let excluded =
        (members.iter()).filter(|member| !member.is_excluded && !member.is_publishable());
    for package in excluded.filter_map(|member| member.package()) {
        arguments.extend(["--exclude", package]);
    }
    cargo::run(&arguments, &[])
}

/// Checks each crate that has default features without them; alone, because crates that are built
/// together share their features.
pub fn without_default_features() -> Result<()> {
    for member in members()? {
        let features = member.manifest.get("features");
        let has_defaults = features.is_some_and(|features| features.get("default").is_some());
        let Some(package) = member
            .package()
            .filter(|_| has_defaults && !member.is_excluded)
        else {
            continue;
        };
        let arguments = ["check", "--package", package, "--lib", "--locked"];
        cargo::run(&[&arguments[..], &["--no-default-features"]].concat(), &[])?;
    }
    Ok(())
}

/// Files that publishable crates lack.
fn missing_files() -> Result<Vec<String>> {
    let members = members()?;
    let publishable = members.iter().filter(|member| member.is_publishable());
    Ok(publishable
        .flat_map(|member| FILES.map(|file| format!("{}/{file}", member.folder)))
        .filter(|path| !root().join(path).exists())
        .collect())
}
