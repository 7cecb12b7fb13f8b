//! Pages in Markdown: their text outside code, and the files that they name.

use crate::files::{folder_of, root};

/// Folders of the root whose files are named by their full paths.
const FOLDERS: [&str; 8] = [
    ".ci/", ".github/", "crates/", "docs/", "fuzz/", "python/", "scenes/", "xtask/",
];

/// A path that a page names, with its place in the page.
#[derive(Debug, PartialEq)]
pub struct NamedPath<'a> {
    /// Line number, starting at 1.
    pub line: usize,
    pub path: &'a str,
    /// Crates in the heading of the section, to whose `src` folders the path may be relative.
    crates: Vec<&'a str>,
}

impl NamedPath<'_> {
    /// Whether the path exists: from the root, from the folder of the page, from the sources of the
    /// crates in the heading of its section, or, for a path without the folders before it and
    /// outside such sections, anywhere in the crate of the page or in the repository.
    pub fn exists(&self, page: &str, files: &[String]) -> bool {
        let path = self.path;
        let folder = folder_of(page);
        let in_sources =
            (self.crates.iter()).map(|name| format!("{}/src/{path}", crate_folder(name)));
        let mut candidates = in_sources.chain([path.to_owned(), format!("{folder}/{path}")]);
        if candidates.any(|candidate| root().join(candidate.trim_start_matches('/')).exists()) {
            return true;
        }
        let is_whole = FOLDERS.iter().any(|folder| path.starts_with(folder));
        let scope = if folder.starts_with("docs") {
            ""
        } else {
            folder
        };
        let is_meant = |file: &String| {
            file.starts_with(scope)
                && file.match_indices(path).any(|(start, _)| {
                    let ends = path.ends_with('/') || start + path.len() == file.len();
                    ends && file[..start].ends_with('/')
                })
        };
        !is_whole && self.crates.is_empty() && files.iter().any(is_meant)
    }
}

/// Folder of a crate of the workspace.
fn crate_folder(name: &str) -> String {
    match name {
        "xtask" => name.to_owned(),
        name => format!("crates/{name}"),
    }
}

/// Lines of a page with their numbers, and whether they stand in a fenced block.
fn lines(page: &str) -> impl Iterator<Item = (usize, &str, bool)> {
    let mut is_code = false;
    page.lines().zip(1..).map(move |(line, number)| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        (number, line, is_code || is_fence)
    })
}

/// Lines of a page outside fenced blocks.
pub fn prose(page: &str) -> impl Iterator<Item = &str> {
    lines(page).filter_map(|(_, line, is_code)| (!is_code).then_some(line))
}

/// Texts between backticks in one line.
pub fn code_spans(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

/// All files and folders that a page names: by full paths anywhere, and in code spans by names of
/// Rust files and of folders, these with a slash at the end.
pub fn named_paths(page: &str) -> Vec<NamedPath<'_>> {
    let mut paths = Vec::new();
    let mut crates = Vec::new();
    for (number, line, is_code) in lines(page) {
        if !is_code && line.starts_with('#') {
            let is_crate = |name: &&str| {
                !name.contains('/') && root().join(crate_folder(name)).join("Cargo.toml").exists()
            };
            crates = code_spans(line).filter(is_crate).collect();
        }
        let words = line.split(|c: char| c.is_whitespace() || "`\"'()[]<>,;|:".contains(c));
        let whole = words
            .map(|word| word.trim_end_matches('.'))
            .filter(|word| FOLDERS.iter().any(|folder| word.starts_with(folder)));
        let is_whole = |span: &&str| FOLDERS.iter().any(|folder| span.starts_with(folder));
        let spans = code_spans(line).filter(|span| !is_code && !is_whole(span));
        let parts = spans.filter(|span| span.ends_with(".rs") || span.ends_with('/'));
        let named = whole.chain(parts).filter(|path| is_path(path));
        paths.extend(named.map(|path| NamedPath {
            line: number,
            path,
            crates: crates.clone(),
        }));
    }
    paths
}

/// Whether a word can be a path in the repository: no pattern, no web address, and not built.
fn is_path(word: &str) -> bool {
    let is_plain = |c: char| c.is_alphanumeric() || "/._-".contains(c);
    word.chars().all(is_plain) && !word.contains("..") && !word.contains("/target/")
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "\
# A page of `fem/` and `c.rs`

Start at `crates/high/src/main.rs`, scenes/a.toml.

```text
`drawn.rs` but run docs/b.md
```

### `mesh`

`a.rs` and `folder/b.rs`; `Type` in `folder/`, `crates/*/x.rs`, `a b.rs` and [`d`](docs/d.md).

### `rigid` and `xtask`

`ci.rs`
";

    #[test]
    fn paths_are_found_with_the_crates_of_their_section() {
        let found = named_paths(PAGE);
        let paths: Vec<(usize, &str)> =
            found.iter().map(|named| (named.line, named.path)).collect();
        assert_eq!(
            paths,
            [
                (1, "fem/"),
                (1, "c.rs"),
                (3, "crates/high/src/main.rs"),
                (3, "scenes/a.toml"),
                (6, "docs/b.md"),
                (11, "docs/d.md"),
                (11, "a.rs"),
                (11, "folder/b.rs"),
                (11, "folder/"),
                (15, "ci.rs"),
            ]
        );
        let crates: Vec<_> = found.iter().map(|named| &named.crates[..]).collect();
        assert_eq!(crates[0], [""; 0]);
        assert_eq!(crates[6], ["mesh"]);
        assert_eq!(crates[9], ["rigid", "xtask"]);
        assert_eq!(prose(PAGE).count(), 12);
    }

    #[test]
    fn paths_exist_from_the_root_the_page_the_section_or_as_an_end() {
        let files = ["crates/mesh/src/io/gmsh.rs", "crates/fem/src/forms/mass.rs"];
        let files = files.map(str::to_owned);
        for (page, path, crates, exists) in [
            ("docs/a.md", "xtask/src/ci.rs", &[][..], true),
            ("docs/a.md", "xtask/src/none.rs", &[], false),
            ("xtask/README.md", "src/ci.rs", &[], true),
            ("CONTRIBUTING.md", "docs/", &[], true),
            ("ARCHITECTURE.md", "ci.rs", &["mesh", "xtask"], true),
            ("ARCHITECTURE.md", "mass.rs", &["mesh", "xtask"], false),
            ("docs/a.md", "mass.rs", &[], true),
            ("docs/a.md", "forms/mass.rs", &[], true),
            ("docs/a.md", "forms/", &[], true),
            ("docs/a.md", "ass.rs", &[], false),
            ("docs/a.md", "form/", &[], false),
            ("docs/a.md", "orms/", &[], false),
            ("crates/fem/README.md", "mass.rs", &[], true),
            ("crates/mesh/README.md", "mass.rs", &[], false),
            ("crates/mesh/README.md", "gmsh.rs", &[], true),
        ] {
            let named = NamedPath {
                line: 1,
                path,
                crates: crates.to_vec(),
            };
            assert_eq!(named.exists(page, &files), exists, "{path} in {page}");
        }
    }
}
