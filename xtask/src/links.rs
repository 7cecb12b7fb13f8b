//! Links of the documentation: files, headings, files of the code, and the contents of the book.

use std::path::Path;

use anyhow::{Result, bail};

use crate::files::{files_below, read, root};

/// Checks the links of all Markdown files and lists those that lead nowhere.
pub fn run() -> Result<()> {
    eprintln!("== links of the documentation");
    let root = root();
    let mut broken = Vec::new();
    let contents = read(&root.join("docs/SUMMARY.md"))?;
    for name in files_below(".", ".md")? {
        let file = root.join(&name);
        let page = read(&file)?;
        for target in targets(&page) {
            if !leads_somewhere(&file, &target) {
                broken.push(format!("{name}: {target}"));
            }
        }
        let Some(in_docs) = name.strip_prefix("docs/") else {
            continue;
        };
        if in_docs.starts_with("book/") {
            for path in code_paths(&page) {
                if !root.join(path).exists() {
                    broken.push(format!("{name}: {path}"));
                }
            }
        }
        let link = format!("({in_docs})");
        if in_docs != "SUMMARY.md" && !contents.contains(&link) {
            broken.push(format!("docs/SUMMARY.md lacks {link}"));
        }
    }
    for link in &broken {
        eprintln!("{link}");
    }
    match broken.len() {
        0 => Ok(()),
        count => bail!("{count} links of the documentation lead nowhere"),
    }
}

/// Lines of a page outside fenced blocks.
fn prose(page: &str) -> impl Iterator<Item = &str> {
    let mut is_code = false;
    page.lines().filter(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    })
}

/// Targets of the links and pictures of a page.
fn targets(page: &str) -> Vec<String> {
    let mut targets = Vec::new();
    for line in prose(page) {
        let links = line.split("](").skip(1);
        let pictures = line.split("src=\"").skip(1);
        let of_links = links.filter_map(|rest| rest.split_once(')'));
        let of_pictures = pictures.filter_map(|rest| rest.split_once('"'));
        targets.extend(
            of_links
                .chain(of_pictures)
                .map(|(target, _)| target.to_owned()),
        );
    }
    targets
}

/// Whether the target of a link in `file` exists; addresses of other sites are not looked up.
fn leads_somewhere(file: &Path, target: &str) -> bool {
    if target.contains("://") || target.starts_with("mailto:") {
        return true;
    }
    let (path, heading) = target.split_once('#').unwrap_or((target, ""));
    let path = match path {
        "" => file.to_owned(),
        path => file.with_file_name("").join(path),
    };
    if heading.is_empty() {
        return path.exists();
    }
    read(&path).is_ok_and(|page| anchors(&page).any(|anchor| anchor == heading))
}

/// Names by which links reach the headings of a page: lower case, hyphens for spaces, and no
/// punctuation.
fn anchors(page: &str) -> impl Iterator<Item = String> {
    let headings = prose(page).filter_map(|line| {
        let text = line.trim_start_matches('#');
        (text.len() < line.len() && text.starts_with(' ')).then(|| text.trim())
    });
    headings.map(|heading| {
        let kept = |c: &char| c.is_alphanumeric() || " -_".contains(*c);
        let letters = heading.chars().filter(kept).flat_map(char::to_lowercase);
        letters.map(|c| if c == ' ' { '-' } else { c }).collect()
    })
}

/// Paths of source files that a page names in code spans or blocks.
fn code_paths(page: &str) -> impl Iterator<Item = &str> {
    let words = page.split(|c: char| c.is_whitespace() || "`(),;|:".contains(c));
    words.filter(|word| word.starts_with("crates/") && word.ends_with(".rs"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "# The `first` heading, again\n\
                        See [a](b.md#c), ![d](e.svg) and <img src=\"f.svg\">.\n\
                        ```text\n# no heading [g](h.md)\n```\n\
                        `crates/a/src/b.rs`, crates/c.\n";

    #[test]
    fn links_pictures_and_headings_outside_code_are_found() {
        assert_eq!(targets(PAGE), ["b.md#c", "e.svg", "f.svg"]);
        assert_eq!(
            anchors(PAGE).collect::<Vec<_>>(),
            ["the-first-heading-again"]
        );
        assert_eq!(code_paths(PAGE).collect::<Vec<_>>(), ["crates/a/src/b.rs"]);
    }

    #[test]
    fn files_and_headings_must_exist() {
        let file = root().join("CONTRIBUTING.md");
        for (target, exists) in [
            ("ARCHITECTURE.md", true),
            ("ARCHITECTURE.md#birds-eye-view", true),
            ("#style", true),
            ("https://example.org/none", true),
            ("ARCHITECTURE.md#none", false),
            ("docs/none.md", false),
        ] {
            assert_eq!(leads_somewhere(&file, target), exists, "{target}");
        }
    }
}
