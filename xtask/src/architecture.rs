//! The table of dependencies in ARCHITECTURE.md against the manifests.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;
use toml::Table;

use crate::expect_none;
use crate::files::{read, root};
use crate::manifests::{manifest, members};
use crate::pages::code_spans;

/// Dependencies of each crate on other crates of the workspace.
type Dependencies = BTreeMap<String, BTreeSet<String>>;

/// The last column of a crate that depends on no other crate of the workspace.
const NO_DEPENDENCIES: &str = "nothing of ours";

/// Compares the table in ARCHITECTURE.md with the manifests and lists all differences.
pub fn run() -> Result<()> {
    eprintln!("== ARCHITECTURE.md against manifests");
    let what = "differences between ARCHITECTURE.md and the manifests";
    expect_none(&differences()?, what)
}

/// All differences between ARCHITECTURE.md and the manifests, one line each.
fn differences() -> Result<Vec<String>> {
    let page = read(&root().join("ARCHITECTURE.md"))?;
    let crates = workspace_crates(&manifest(".")?);
    let from_manifests: Dependencies = members()?
        .iter()
        .map(|member| {
            let dependencies = manifest_dependencies(&member.manifest, &crates);
            (member.name().to_owned(), dependencies)
        })
        .collect();
    Ok(compare(&table_dependencies(&page), &from_manifests))
}

/// Keys of `[workspace.dependencies]` that stand for crates of the workspace.
pub fn workspace_crates(workspace: &Table) -> BTreeSet<String> {
    let dependencies = workspace
        .get("workspace")
        .and_then(|table| table.get("dependencies"))
        .and_then(|table| table.as_table());
    let has_path = |value: &toml::Value| value.get("path").is_some();
    dependencies
        .into_iter()
        .flatten()
        .filter(|(_, value)| has_path(value))
        .map(|(name, _)| name.clone())
        .collect()
}

/// Normal and build dependencies of a manifest that are among `crates`; tests may use any crate.
pub fn manifest_dependencies(manifest: &Table, crates: &BTreeSet<String>) -> BTreeSet<String> {
    ["dependencies", "build-dependencies"]
        .iter()
        .filter_map(|key| manifest.get(*key)?.as_table())
        .flat_map(Table::keys)
        .filter(|name| crates.contains(*name))
        .cloned()
        .collect()
}

/// Rows of the table whose heads are `crate`, `holds` and `depends on`.
fn table_dependencies(page: &str) -> Dependencies {
    let rows = page
        .lines()
        .skip_while(|line| !line.starts_with("| crate | holds | depends on |"))
        .skip(2)
        .take_while(|line| line.starts_with('|'));
    rows.filter_map(|row| {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let [name, _, last] = cells[..] else {
            return None;
        };
        let name = code_spans(name).next()?.to_owned();
        let dependencies = match last {
            NO_DEPENDENCIES => BTreeSet::new(),
            list => code_spans(list).map(str::to_owned).collect(),
        };
        Some((name, dependencies))
    })
    .collect()
}

/// Differences between the dependencies in the table and those in the manifests.
fn compare(table: &Dependencies, manifests: &Dependencies) -> Vec<String> {
    let mut differences = Vec::new();
    for (name, documented) in table {
        let Some(actual) = manifests.get(name) else {
            differences.push(format!("the table lists `{name}`, which is not a crate"));
            continue;
        };
        for other in documented.difference(actual) {
            differences.push(format!(
                "the table says that `{name}` depends on `{other}`, its manifest does not"
            ));
        }
        for other in actual.difference(documented) {
            differences.push(format!(
                "`{name}` depends on `{other}`, which is missing in the table"
            ));
        }
    }
    for name in manifests.keys().filter(|name| !table.contains_key(*name)) {
        differences.push(format!("the crate `{name}` is missing in the table"));
    }
    differences
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "\
| crate | holds | depends on |
|---|---|---|
| `low` | foundations | nothing of ours |
| `high` | programs | `low` |
";

    fn dependencies(rows: &[(&str, &[&str])]) -> Dependencies {
        rows.iter()
            .map(|(name, others)| {
                let others = others.iter().map(|other| (*other).to_owned()).collect();
                ((*name).to_owned(), others)
            })
            .collect()
    }

    #[test]
    fn the_table_is_read() {
        let expected = dependencies(&[("low", &[]), ("high", &["low"])]);
        assert_eq!(table_dependencies(PAGE), expected);
    }

    #[test]
    fn manifests_are_read_without_outside_and_test_dependencies() {
        let workspace = "[workspace.dependencies]\nlow = { path = \"crates/low\" }\n\
                         high = { path = \"crates/high\" }\nserde = \"1\"\n";
        let crates = workspace_crates(&workspace.parse().unwrap());
        let manifest = "[dependencies]\nlow.workspace = true\nserde.workspace = true\n\
                        [dev-dependencies]\nhigh.workspace = true\n";
        let found = manifest_dependencies(&manifest.parse().unwrap(), &crates);
        assert_eq!(found, BTreeSet::from(["low".to_owned()]));
    }

    #[test]
    fn differences_are_found_in_both_directions() {
        let table = table_dependencies(PAGE);
        assert_eq!(compare(&table, &table), [""; 0]);
        let manifests = dependencies(&[("low", &["new"]), ("high", &[]), ("new", &[])]);
        assert_eq!(
            compare(&table, &manifests),
            [
                "the table says that `high` depends on `low`, its manifest does not",
                "`low` depends on `new`, which is missing in the table",
                "the crate `new` is missing in the table",
            ]
        );
        let manifests = dependencies(&[("low", &[])]);
        assert_eq!(
            compare(&table, &manifests),
            ["the table lists `high`, which is not a crate"]
        );
    }

    #[test]
    fn the_page_agrees_with_the_workspace() {
        assert_eq!(differences().unwrap(), [""; 0]);
    }
}
