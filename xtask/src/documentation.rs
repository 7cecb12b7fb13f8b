//! The pages of rustdoc, crate by crate: rustdoc turns the name of an item of another crate into a
//! link only if the pages of that crate exist already.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Result, bail};

use crate::architecture::{manifest_dependencies, workspace_crates};
use crate::files::root;
use crate::manifests::{Member, manifest, members};
use crate::{cargo, expect_none};

/// Builds the pages of the crates of the workspace, those that others depend on first, and lists
/// names in brackets that did not become links.
pub fn run() -> Result<()> {
    let crates = workspace_crates(&manifest(".")?);
    let mut waiting = members()?;
    waiting.retain(|member| !member.is_excluded);
    let mut libraries = Vec::new();
    while !waiting.is_empty() {
        let names: BTreeSet<String> = waiting.iter().map(|m| m.name().to_owned()).collect();
        let is_ready =
            |member: &Member| manifest_dependencies(&member.manifest, &crates).is_disjoint(&names);
        let (ready, others): (Vec<_>, Vec<_>) = waiting.into_iter().partition(is_ready);
        if ready.is_empty() {
            bail!("crates depend on each other in a circle: {names:?}");
        }
        let mut arguments = vec!["doc", "--no-deps", "--locked"];
        for package in ready.iter().filter_map(Member::package) {
            arguments.extend(["--package", package]);
        }
        cargo::run(&arguments, &[("RUSTDOCFLAGS", "-D warnings")])?;
        // Others, such as programs, inherit documentation of clap, which has no pages here.
        let documented = ready.iter().filter(|member| member.is_publishable());
        libraries.extend(documented.map(|member| member.name().to_owned()));
        waiting = others;
    }
    let mut unlinked = Vec::new();
    for library in libraries {
        find_unlinked(&root().join("target/doc").join(library), &mut unlinked)?;
    }
    expect_none(&unlinked, "names in brackets without a link")
}

/// What stands before a name that rustdoc could not link.
const UNLINKED: &str = "[<code>";

/// Adds the names in the pages of a folder that rustdoc could not link.
fn find_unlinked(folder: &Path, found: &mut Vec<String>) -> Result<()> {
    if !folder.is_dir() {
        return Ok(());
    }
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            find_unlinked(&path, found)?;
        } else if path
            .extension()
            .is_some_and(|extension| extension == "html")
        {
            let page = std::fs::read_to_string(&path)?;
            found.extend(unlinked(&page).map(|name| format!("{}: {name}", path.display())));
        }
    }
    Ok(())
}

/// The names in brackets of a page.
fn unlinked(page: &str) -> impl Iterator<Item = &str> {
    let after = page.split(UNLINKED).skip(1);
    after.filter_map(|text| Some(text.split_once("</code>]")?.0).filter(|name| !name.contains('<')))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_without_a_link_are_found() {
        let page = "<p>see <a href=\"x\"><code>Arms</code></a>, [<code>rigid::Arms</code>] and \
                    <code>[f64; 3]</code></p>";
        assert_eq!(unlinked(page).collect::<Vec<_>>(), ["rigid::Arms"]);
    }
}
