//! Links of the documentation: files, headings, files that a page names, and the contents of the
//! book.

use std::path::Path;

use anyhow::Result;

use crate::expect_none;
use crate::files::{files_below, read, root};
use crate::pages::{named_paths, prose};

/// The page about earlier versions, which may name what no longer exists.
const HISTORY: &str = "CHANGELOG.md";

/// Checks the links of all Markdown files and lists those that lead nowhere.
pub fn run() -> Result<()> {
    eprintln!("== links of the documentation");
    let root = root();
    let mut broken = Vec::new();
    let contents = read(&root.join("docs/SUMMARY.md"))?;
    let files = files_below(".", "")?;
    for name in files.iter().filter(|name| name.ends_with(".md")) {
        let file = root.join(name);
        let page = read(&file)?;
        for target in targets(&page) {
            if !leads_somewhere(&file, &target) {
                broken.push(format!("{name}: {target}"));
            }
        }
        let named = named_paths(&page).into_iter().filter(|_| name != HISTORY);
        for missing in named.filter(|path| !path.exists(name, &files)) {
            broken.push(format!("{name}:{}: {}", missing.line, missing.path));
        }
        let Some(in_docs) = name.strip_prefix("docs/") else {
            continue;
        };
        let link = format!("({in_docs})");
        if in_docs != "SUMMARY.md" && !contents.contains(&link) {
            broken.push(format!("docs/SUMMARY.md lacks {link}"));
        }
    }
    expect_none(&broken, "links of the documentation lead nowhere")
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

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "# The `first` heading, again\n\
                        See [a](b.md#c), ![d](e.svg) and <img src=\"f.svg\">.\n\
                        ```text\n# no heading [g](h.md)\n```\n";

    #[test]
    fn links_pictures_and_headings_outside_code_are_found() {
        assert_eq!(targets(PAGE), ["b.md#c", "e.svg", "f.svg"]);
        assert_eq!(
            anchors(PAGE).collect::<Vec<_>>(),
            ["the-first-heading-again"]
        );
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
