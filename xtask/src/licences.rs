//! Licence check: no GPL or AGPL in the default dependency graph.

use std::collections::BTreeSet;

use anyhow::Result;

use crate::{cargo, expect_none};

/// Licences, with exceptions, that the default graph may use.
///
/// `LicenseRef` and unknown licences are refused.
const ALLOWED: &[&str] = &[
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-1-Clause",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "MPL-2.0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];

/// Lists the packages of the default graph and fails on a licence that is not allowed.
pub fn run() -> Result<()> {
    eprintln!("== licences of the default dependency graph");
    let mut arguments = vec!["tree", "--workspace", "--edges", "normal,build", "--locked"];
    arguments.extend(["--prefix", "none", "--format", "{p}|{l}"]);
    let listing = cargo::output(&arguments)?;
    let packages: BTreeSet<&str> = listing
        .lines()
        .map(|l| l.trim_end_matches(" (*)"))
        .filter(|l| !l.is_empty())
        .collect();
    let is_refused = |line: &&&str| {
        let licence = line.split_once('|').map(|(_, licence)| licence);
        !licence.is_some_and(allowed)
    };
    let refused: Vec<&str> = packages.iter().filter(is_refused).copied().collect();
    eprintln!("{} packages", packages.len());
    expect_none(&refused, "packages have a licence that is not allowed")
}

/// Whether an SPDX expression can be satisfied by allowed licences; invalid expressions cannot.
fn allowed(expression: &str) -> bool {
    // Old manifests write `OR` as `/`, which the lax mode accepts.
    spdx::Expression::parse_mode(expression, spdx::ParseMode::LAX).is_ok_and(|expression| {
        expression.evaluate(|licence| ALLOWED.contains(&licence.to_string().as_str()))
    })
}

#[cfg(test)]
mod tests {
    use super::allowed;

    #[test]
    fn expressions_are_read_as_spdx() {
        assert!(allowed("MIT OR Apache-2.0"));
        assert!(allowed("MIT/Apache-2.0"));
        assert!(allowed("GPL-3.0 OR MIT"));
        assert!(allowed("(MIT OR Apache-2.0) AND Unicode-3.0"));
        assert!(allowed("(MIT OR GPL-3.0-only) AND (Zlib OR AGPL-3.0-only)"));
        assert!(!allowed("GPL-2.0"));
        assert!(!allowed("AGPL-3.0-only"));
        assert!(!allowed("(MIT OR Apache-2.0) AND GPL-3.0"));
        assert!(!allowed(""));
    }
}
