//! Circles of files: files of a crate that use each other, directly or in turn.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use anyhow::{Context, Result};

use crate::expect_none;
use crate::files::{files_below, read, root};
use crate::manifests::crate_folders;
use crate::modules::{Files, Modules, Reference};

/// Names of the items that a file uses, by their files, by the file that uses them.
type Uses = BTreeMap<String, BTreeMap<String, BTreeSet<String>>>;

/// Files each of which uses all others, directly or in turn, with what they use of each other.
#[derive(Debug, PartialEq)]
struct Circle(Uses);

impl fmt::Display for Circle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (from, uses) in &self.0 {
            for (to, items) in uses {
                let items: Vec<&str> = items.iter().map(String::as_str).collect();
                writeln!(f, "    {from} -> {to} ({})", items.join(", "))?;
            }
        }
        Ok(())
    }
}

/// Looks for circles in all crates and lists them.
pub fn run() -> Result<()> {
    eprintln!("== circles of files");
    let mut found = Vec::new();
    for folder in crate_folders()? {
        let circles = circles_of_crate(&folder)?;
        found.extend(circles.iter().map(|circle| {
            let edges = circle.to_string();
            format!("{folder}: {} files\n{}", circle.0.len(), edges.trim_end())
        }));
    }
    expect_none(&found, "circles of files")
}

/// Circles of the files of a crate, below all roots of its modules.
fn circles_of_crate(folder: &str) -> Result<Vec<Circle>> {
    let mut files = Files::new();
    for path in files_below(folder, ".rs")? {
        let name = path[folder.len() + 1..].to_owned();
        files.insert(name, read(&root().join(path))?);
    }
    let is_program = |name: &str| {
        let folders = ["src/bin/", "fuzz_targets/"];
        (folders
            .iter()
            .filter_map(|folder| name.strip_prefix(folder)))
        .any(|name| !name.contains('/') || name.ends_with("/main.rs"))
    };
    let is_root = |name: &str| ["src/lib.rs", "src/main.rs"].contains(&name) || is_program(name);
    let mut circles = Vec::new();
    for name in files.keys().filter(|name| is_root(name)) {
        circles.extend(circles_below(&files, name).with_context(|| folder.to_owned())?);
    }
    Ok(circles)
}

/// Circles of the files that are modules below the file `root`.
fn circles_below(files: &Files, root: &str) -> Result<Vec<Circle>> {
    let modules = Modules::new(files, root)?;
    let parents = modules.parents();
    let mut uses = Uses::new();
    for reference in modules.references() {
        if !is_allowed(&reference, &parents) {
            let of_file = uses.entry(reference.from).or_default();
            of_file
                .entry(reference.to)
                .or_default()
                .insert(reference.item);
        }
    }
    Ok(circles(&uses))
}

/// Whether a reference may be part of a circle: a module and its own children may know each other,
/// and a module may offer what its descendants define.
fn is_allowed(reference: &Reference, parents: &BTreeMap<&str, &str>) -> bool {
    let (from, to) = (reference.from.as_str(), reference.to.as_str());
    let parent = |file: &str| parents.get(file).copied();
    let mut ancestors = std::iter::successors(parent(to), |file| parent(file));
    parent(from) == Some(to)
        || parent(to) == Some(from)
        || reference.is_reexport && ancestors.any(|file| file == from)
}

/// Strongly connected components of more than one file.
fn circles(uses: &Uses) -> Vec<Circle> {
    let reached: BTreeMap<&str, BTreeSet<&str>> = (uses.keys())
        .map(|file| (file.as_str(), reached_from(uses, file)))
        .collect();
    let mut circles = Vec::new();
    let mut done = BTreeSet::new();
    for (&file, targets) in &reached {
        let is_in_circle =
            |other: &&str| reached.get(other).is_some_and(|back| back.contains(file));
        let members: BTreeSet<&str> = targets.iter().copied().filter(is_in_circle).collect();
        if !members.is_empty() && done.insert(members.clone()) {
            circles.push(Circle(within(uses, &members)));
        }
    }
    circles
}

/// Files that a file uses, directly or in turn.
fn reached_from<'a>(uses: &'a Uses, file: &str) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::new();
    let mut waiting = vec![file];
    while let Some(file) = waiting.pop() {
        for target in uses.get(file).into_iter().flat_map(BTreeMap::keys) {
            if reached.insert(target.as_str()) {
                waiting.push(target);
            }
        }
    }
    reached
}

/// The uses among some of the files.
fn within(uses: &Uses, members: &BTreeSet<&str>) -> Uses {
    let is_member = |file: &str| members.contains(file);
    let of_members = uses.iter().filter(|(from, _)| is_member(from));
    of_members
        .map(|(from, targets)| {
            let targets = targets.iter().filter(|(to, _)| is_member(to));
            let targets = targets.map(|(to, items)| (to.clone(), items.clone()));
            (from.clone(), targets.collect())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Edges of all circles in a crate of the given files, one line each.
    fn edges(files: &[(&str, &str)]) -> Vec<String> {
        let files: Files = (files.iter())
            .map(|(name, text)| (format!("src/{name}"), (*text).to_owned()))
            .collect();
        let circles = circles_below(&files, "src/lib.rs").unwrap();
        let text: String = circles.iter().map(Circle::to_string).collect();
        text.lines()
            .map(|line| line.trim().replace("src/", ""))
            .collect()
    }

    /// Edges of the circle of `a.rs`, with the given code, and `b.rs`, which uses `crate::a::A`.
    fn edges_of_a(a: &str) -> Vec<String> {
        let a = format!("pub struct A; pub fn f() {{}}\n{a}");
        let b = "use crate::a::A; pub struct B; pub struct C; pub fn g(_: A) {}";
        edges(&[("lib.rs", "mod a; mod b;"), ("a.rs", &a), ("b.rs", b)])
    }

    #[test]
    fn imports_and_paths_in_code_make_circles() {
        for (code, item) in [
            ("use crate::b::B;", "B"),
            ("use super::b::B as Other;", "B"),
            ("use crate::b::{self}; fn h() { b::g(A) }", "g"),
            ("use crate::{b::{C, B as _}};", "B, C"),
            ("use crate::b::*;", "*"),
            ("fn h(b: &super::b::B) {}", "B"),
            ("fn h() { let x = vec![crate::b::B]; }", "B"),
            (
                "macro_rules! m { () => { $crate::b::g($crate::a::A) }; }",
                "g",
            ),
            ("fn h() { use super::b; for _ in 0..b::g(A) {} }", "g"),
            ("mod inner { use super::super::b::B; }", "B"),
            (
                "mod inner { pub mod deep { fn h() { crate::b::g(super::super::A) } } }",
                "g",
            ),
            ("impl<T: Into<crate::b::C>> From<T> for A {}", "C"),
            ("pub const X: Option<crate::b::B> = { None };", "B"),
        ] {
            let expected = [
                format!("a.rs -> b.rs ({item})"),
                "b.rs -> a.rs (A)".to_owned(),
            ];
            assert_eq!(edges_of_a(code), expected, "{code}");
        }
    }

    #[test]
    fn tests_comments_texts_and_other_crates_make_none() {
        for code in [
            "",
            "#[cfg(test)] mod tests { use crate::b::B; }",
            "#[cfg(all(test, unix))] use crate::b::B;",
            "impl A { #[cfg(test)] fn h() { crate::b::g(A) } pub fn i() {} }",
            "/// [`crate::b::B`]\npub fn h() { let _ = \"crate::b::B\"; /* crate::b::B */ }",
            "use b::B; fn h<'b>(x: &'b str) { x.b::<u8>(); }",
            "pub(in crate::b) fn h() {}",
            "use super::b; fn h(x: X) { x.g(); x.b; }",
        ] {
            assert_eq!(edges_of_a(code), [""; 0], "{code}");
        }
        let in_plain_code = edges_of_a("#[cfg(not(test))] use crate::b::B;");
        assert_eq!(in_plain_code.len(), 2);
    }

    #[test]
    fn reexports_lead_to_the_file_that_defines() {
        let files = |lib, b| {
            edges(&[
                ("lib.rs", lib),
                (
                    "a/mod.rs",
                    "mod low; pub use low::Low as Deep; pub mod high;",
                ),
                ("a/low.rs", "pub struct Low;"),
                ("a/high.rs", "use crate::b::B; pub struct High;"),
                ("b.rs", b),
            ])
        };
        let lib = "mod a; mod b; pub use a::*; pub use b::B as C;";
        let circle = ["a/high.rs -> b.rs (B)", "b.rs -> a/high.rs (High)"];
        assert_eq!(files(lib, "use crate::Deep; pub struct B;"), [""; 0]);
        assert_eq!(files(lib, "use crate::high::High; pub struct B;"), circle);
        assert_eq!(
            files(lib, "use crate::*; pub struct B(high::High);"),
            circle
        );
        let lib = "mod a; mod b; pub use a::{self as first, high::{self as top, High}};";
        assert_eq!(files(lib, "use crate::High; pub struct B;"), circle);
        assert_eq!(files(lib, "pub struct B(crate::top::High);"), circle);
        assert_eq!(
            files(lib, "use crate::first; pub struct B(first::high::High);"),
            circle
        );
        assert_eq!(
            files(lib, "use crate::first; pub struct B(first::Deep);"),
            [""; 0]
        );
    }

    #[test]
    fn names_of_globs_lead_to_the_file_that_defines() {
        let found = edges(&[
            ("lib.rs", "mod a; mod b; mod c;"),
            (
                "a.rs",
                "use crate::c::*; pub fn f() { g(); let x = y.g2(); }",
            ),
            ("b.rs", "use super::a::f; pub fn g() {} pub fn g2() {}"),
            ("c/mod.rs", "pub use crate::b::*; mod d;"),
            ("c/d.rs", ""),
        ]);
        assert_eq!(found, ["a.rs -> b.rs (g)", "b.rs -> a.rs (f)"]);
    }

    #[test]
    fn modules_and_their_own_children_know_each_other() {
        let tree = |deep| {
            edges(&[
                (
                    "lib.rs",
                    "mod a; pub use a::b::{B, deep::Deep}; pub struct Error;",
                ),
                ("a/mod.rs", "pub mod b; pub struct A(b::B);"),
                (
                    "a/b/mod.rs",
                    "pub mod deep; use super::A; pub struct B(crate::Error);",
                ),
                ("a/b/deep.rs", deep),
            ])
        };
        assert_eq!(
            tree("use super::B; use crate::Error; pub struct Deep;"),
            [""; 0]
        );
        // A file that declares modules in a folder of its name is no exception.
        let found = edges(&[
            ("lib.rs", "mod a;"),
            ("a.rs", "mod b; use b::B; use b::c::C; pub struct A;"),
            ("a/b.rs", "pub mod c; use super::A; pub struct B;"),
            ("a/b/c.rs", "use crate::a::A; pub struct C;"),
        ]);
        assert_eq!(found, ["a.rs -> a/b/c.rs (C)", "a/b/c.rs -> a.rs (A)"]);
    }

    #[test]
    fn circles_through_several_files_are_told_apart() {
        let found = edges(&[
            ("lib.rs", "mod a; mod b; mod c; mod d; mod e;"),
            ("a.rs", "use crate::b::B; use crate::d::D; pub struct A;"),
            ("b.rs", "use crate::c::C; pub struct B;"),
            ("c.rs", "use crate::a::A; pub struct C;"),
            ("d.rs", "use crate::e::E; pub struct D;"),
            ("e.rs", "use crate::d::D; pub struct E;"),
        ]);
        let expected = [
            "a.rs -> b.rs (B)",
            "b.rs -> c.rs (C)",
            "c.rs -> a.rs (A)",
            "d.rs -> e.rs (E)",
            "e.rs -> d.rs (D)",
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn missing_files_are_errors() {
        let files = Files::from([("src/lib.rs".to_owned(), "mod a;".to_owned())]);
        let error = circles_below(&files, "src/lib.rs").unwrap_err();
        assert_eq!(
            error.to_string(),
            "src/lib.rs: there is no src/a.rs and no src/a/mod.rs"
        );
    }
}
