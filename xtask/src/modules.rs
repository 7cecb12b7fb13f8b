//! Modules of a crate and the names that they use, read from the tokens of its files.
//!
//! Tokens suffice: items begin with a keyword, and bodies of macros contain paths like any other
//! code. Not seen are methods, which are called without a path, and items that a macro defines.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Result, anyhow, bail};
use proc_macro2::{Delimiter, TokenStream, TokenTree};

use crate::files::folder_of;

/// Texts of the files of a crate by their paths.
pub type Files = BTreeMap<String, String>;

/// Segments of a path such as `crate::mesh::Mesh`.
type Path = Vec<String>;

/// A module, in a file of its own or inside one.
#[derive(Debug, Default)]
struct Module {
    file: String,
    parent: Option<usize>,
    children: BTreeMap<String, usize>,
    /// Names that the module defines itself.
    items: BTreeSet<String>,
    imports: Vec<Import>,
    /// Names in code outside `use`.
    mentions: Vec<Path>,
}

/// One name of a `use` declaration.
#[derive(Debug)]
struct Import {
    /// Name in the module that imports it; `*` for all names.
    name: String,
    path: Path,
    /// Whether it has a visibility, and so belongs to what the module offers.
    is_reexport: bool,
}

/// What a path leads to.
enum Target {
    Module(usize),
    Item {
        file: String,
        name: String,
    },
    /// Something of another crate, or of no file.
    Outside,
}

/// A name that one file uses and another defines.
#[derive(Debug)]
pub struct Reference {
    pub from: String,
    pub to: String,
    pub item: String,
    /// Whether the file only offers the item under another path.
    pub is_reexport: bool,
}

/// Names that were looked up on the way, so that imports in circles end.
type Visited = BTreeSet<(usize, String, bool)>;

/// The modules below one root such as `src/lib.rs`, in the order of their declarations.
#[derive(Debug)]
pub struct Modules<'a> {
    files: &'a Files,
    list: Vec<Module>,
}

impl<'a> Modules<'a> {
    /// Reads the modules that the file `root` declares, directly and in turn; those of tests are
    /// left out.
    ///
    /// # Errors
    /// Files that are missing or are no Rust.
    pub fn new(files: &'a Files, root: &str) -> Result<Self> {
        let list = Vec::new();
        let mut modules = Self { files, list };
        modules.read_file(root, folder_of(root), None)?;
        Ok(modules)
    }

    /// Files in which files declare modules, by the declared file.
    pub fn parents(&self) -> BTreeMap<&str, &str> {
        let pairs = self.list.iter().filter_map(|module| {
            let parent = &self.list[module.parent?];
            (parent.file != module.file).then_some((module.file.as_str(), parent.file.as_str()))
        });
        pairs.collect()
    }

    /// All names that one file uses and another defines.
    pub fn references(&self) -> Vec<Reference> {
        let mut references = Vec::new();
        for (index, module) in self.list.iter().enumerate() {
            let imports = module.imports.iter().map(|i| (&i.path, i.is_reexport));
            let mentions = module.mentions.iter().map(|path| (path, false));
            for (path, is_reexport) in imports.chain(mentions) {
                let is_glob = path.last().is_some_and(|last| last == "*");
                let (to, item) = match self.resolve(index, path, false, &mut Visited::new()) {
                    Target::Item { file, name } => (file, name),
                    // Traits are used without their names.
                    Target::Module(of) if is_glob && !self.list[of].items.is_empty() => {
                        (self.list[of].file.clone(), "*".to_owned())
                    }
                    // The name of a module alone needs nothing of its file.
                    _ => continue,
                };
                if to != module.file {
                    references.push(Reference {
                        from: module.file.clone(),
                        to,
                        item,
                        is_reexport,
                    });
                }
            }
        }
        references
    }

    /// Reads a file as a module, whose children are in `folder`, and returns its index.
    fn read_file(&mut self, file: &str, folder: &str, parent: Option<usize>) -> Result<usize> {
        let text = (self.files.get(file)).ok_or_else(|| anyhow!("there is no {file}"))?;
        let stream = (text.parse()).map_err(|error| anyhow!("{file}: {error}"))?;
        let mut tokens = Vec::new();
        flatten(stream, &mut tokens);
        let tokens: Vec<&str> = tokens.iter().map(String::as_str).collect();
        self.read_module(file, folder, parent, &tokens)
    }

    /// Reads the tokens of a module and returns its index.
    fn read_module(
        &mut self,
        file: &str,
        folder: &str,
        parent: Option<usize>,
        tokens: &[&str],
    ) -> Result<usize> {
        let index = self.list.len();
        self.list.push(Module {
            file: file.to_owned(),
            parent,
            ..Module::default()
        });
        let (mut k, mut depth, mut is_exported) = (0, 0, false);
        while let Some(&token) = tokens.get(k) {
            let rest = &tokens[k..];
            k += match *rest {
                ["#", "[", ..] | ["#", "!", "[", ..] => {
                    let length = group_length(rest);
                    is_exported |= rest[..length].contains(&"macro_export");
                    // Other attributes are read as code.
                    match is_test_only(&rest[..length]) {
                        true => length + item_length(&rest[length..], depth > 0),
                        false => 1,
                    }
                }
                ["{" | "(" | "[" | "}" | ")" | "]", ..] => {
                    depth += if "{([".contains(token) { 1 } else { -1 };
                    1
                }
                ["use", next, ..] if next != "<" => {
                    let length = item_length(rest, false);
                    // `pub` or `pub(...)` stands before.
                    let before = tokens[..k].iter().rev().take_while(|t| !";}".contains(**t));
                    let is_reexport = depth == 0 && before.clone().any(|token| *token == "pub");
                    let imports = &mut self.list[index].imports;
                    read_use(&rest[1..length], Vec::new(), is_reexport, imports);
                    length
                }
                ["mod", name, "{" | ";", ..] if depth == 0 => {
                    let folder = format!("{folder}/{name}");
                    let length = group_length(&rest[1..]) + 1;
                    let child = match rest[2] {
                        "{" => {
                            self.read_module(file, &folder, Some(index), &rest[3..length - 1])?
                        }
                        _ => self.read_declared(file, &folder, index)?,
                    };
                    self.list[index].children.insert(name.to_owned(), child);
                    if rest[2] == "{" { length } else { 3 }
                }
                ["macro_rules", "!", name, ..] | [_, "mut", name, ..] | [_, name, ..]
                    if depth == 0
                        && KEYWORDS.contains(&token)
                        && is_word(name)
                        && !tokens[..k].ends_with(&["'"]) =>
                {
                    let is_of_root = token == "macro_rules" && std::mem::take(&mut is_exported);
                    // `const` and `unsafe` may stand before the keyword of a function.
                    if !KEYWORDS.contains(&name) && name != "unsafe" {
                        let root = is_of_root.then_some(0);
                        for module in root.into_iter().chain([index]) {
                            self.list[module].items.insert(name.to_owned());
                        }
                    }
                    1
                }
                _ if is_word(token) => {
                    let length = path_length(rest);
                    let path = rest[..length].iter().filter(|t| **t != ":");
                    let is_name = length > 1 || is_called_or_type(token, rest.get(1));
                    if is_name && is_start_of_path(&tokens[..k], token) {
                        let path = path.map(|&t| t.to_owned()).collect();
                        self.list[index].mentions.push(path);
                    }
                    length
                }
                _ => 1,
            };
        }
        Ok(index)
    }

    /// Reads the file of a module that `file` declares.
    fn read_declared(&mut self, file: &str, folder: &str, parent: usize) -> Result<usize> {
        let candidates = [format!("{folder}.rs"), format!("{folder}/mod.rs")];
        match candidates.iter().find(|own| self.files.contains_key(*own)) {
            Some(own) => self.read_file(own, folder, Some(parent)),
            None => bail!("{file}: there is no {}", candidates.join(" and no ")),
        }
    }

    /// What a path in a module leads to. Items that are not found where the path says, such as
    /// those that macros define, count as items of the last module found.
    fn resolve(
        &self,
        from: usize,
        path: &[String],
        wants_module: bool,
        visited: &mut Visited,
    ) -> Target {
        let Some((first, mut rest)) = path.split_first() else {
            return Target::Outside;
        };
        let parent = |of: usize| self.list[of].parent.map_or(Target::Outside, Target::Module);
        let is_inner = |rest: &[String]| !rest.is_empty() || wants_module;
        let mut place = match first.as_str() {
            "crate" => Target::Module(0),
            "self" => Target::Module(from),
            "super" => parent(from),
            name => (self.look_up(from, name, is_inner(rest), visited)).unwrap_or(Target::Outside),
        };
        while let (&Target::Module(module), Some((name, after))) = (&place, rest.split_first()) {
            rest = after;
            place = match name.as_str() {
                "super" => parent(module),
                "*" => place,
                name => {
                    (self.look_up(module, name, is_inner(rest), visited)).unwrap_or_else(|| {
                        Target::Item {
                            file: self.list[module].file.clone(),
                            name: name.to_owned(),
                        }
                    })
                }
            };
        }
        place
    }

    /// What a name in a module stands for, through imports and globs.
    fn look_up(
        &self,
        index: usize,
        name: &str,
        wants_module: bool,
        visited: &mut Visited,
    ) -> Option<Target> {
        if !visited.insert((index, name.to_owned(), wants_module)) {
            return None;
        }
        let module = &self.list[index];
        let child = module.children.get(name).copied();
        if let Some(child) = child.filter(|_| wants_module) {
            return Some(Target::Module(child));
        }
        if module.items.contains(name) {
            return Some(Target::Item {
                file: module.file.clone(),
                name: name.to_owned(),
            });
        }
        if let Some(import) = module.imports.iter().find(|import| import.name == name) {
            return Some(self.resolve(index, &import.path, wants_module, visited));
        }
        let mut globs = module.imports.iter().filter(|import| import.name == "*");
        child.map(Target::Module).or_else(|| {
            globs.find_map(|glob| {
                match self.resolve(index, &glob.path, true, &mut visited.clone()) {
                    Target::Module(of) => self.look_up(of, name, wants_module, visited),
                    _ => None,
                }
            })
        })
    }
}

/// Keywords before the name of an item.
const KEYWORDS: [&str; 9] = [
    "struct",
    "enum",
    "union",
    "fn",
    "trait",
    "type",
    "static",
    "const",
    "macro_rules",
];

/// Texts of all tokens; brackets are tokens, and identifiers have no `r#`.
fn flatten(stream: TokenStream, tokens: &mut Vec<String>) {
    for token in stream {
        match token {
            TokenTree::Group(group) => {
                let [open, close] = match group.delimiter() {
                    Delimiter::Brace => ["{", "}"],
                    Delimiter::Bracket => ["[", "]"],
                    _ => ["(", ")"],
                };
                tokens.push(open.to_owned());
                flatten(group.stream(), tokens);
                tokens.push(close.to_owned());
            }
            token => tokens.push(token.to_string().trim_start_matches("r#").to_owned()),
        }
    }
}

/// Number of tokens up to the end of the first group, or of all.
fn group_length(tokens: &[&str]) -> usize {
    let mut depth = 0;
    let end = tokens.iter().position(|token| {
        depth += i32::from("{([".contains(token)) - i32::from("})]".contains(token));
        depth == 0 && "})]".contains(token)
    });
    end.map_or(tokens.len(), |end| end + 1)
}

/// Number of tokens of an item: up to a semicolon or behind a block; a part of an expression or of
/// a type may also end with a comma or with the group around it.
fn item_length(tokens: &[&str], is_part: bool) -> usize {
    let mut k = 0;
    while let Some(&token) = tokens.get(k) {
        match token {
            ";" => return k + 1,
            "," if is_part => return k + 1,
            "}" | ")" | "]" => return k,
            "{" if tokens[0] != "use" => return k + group_length(&tokens[k..]),
            "{" | "(" | "[" => k += group_length(&tokens[k..]),
            _ => k += 1,
        }
    }
    k
}

/// Whether an attribute leaves out an item outside of tests: `cfg(test)`, alone or in `all`.
fn is_test_only(attribute: &[&str]) -> bool {
    let words: Vec<&str> = attribute
        .iter()
        .copied()
        .filter(|token| is_word(token))
        .collect();
    match words[..] {
        ["cfg", "test"] | ["test"] => true,
        ["cfg", "all", ..] => {
            words.contains(&"test") && !words.contains(&"not") && !words.contains(&"any")
        }
        _ => false,
    }
}

/// Whether a token is an identifier or keyword.
fn is_word(token: &str) -> bool {
    token.chars().all(|c| c.is_alphanumeric() || c == '_')
        && !token.starts_with(|c: char| c.is_ascii_digit())
}

/// Reads a `use` declaration behind its keyword, or one branch of its braces behind `path`.
fn read_use(mut tokens: &[&str], mut path: Path, is_reexport: bool, imports: &mut Vec<Import>) {
    let mut name = None;
    while let Some((&token, rest)) = tokens.split_first() {
        match token {
            "{" => {
                let mut branches = &rest[..group_length(tokens) - 2];
                while !branches.is_empty() {
                    let length = item_length(branches, true);
                    let (branch, after) = branches.split_at(length.max(1));
                    read_use(branch, path.clone(), is_reexport, imports);
                    branches = after;
                }
                return;
            }
            "as" => {
                name = rest.first().map(|&name| name.to_owned());
                break;
            }
            ":" | ";" | "," => {}
            token => path.push(token.to_owned()),
        }
        tokens = rest;
    }
    // `a::{self}` is `a`.
    if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
        path.pop();
    }
    if let Some(last) = path.last() {
        imports.push(Import {
            name: name.unwrap_or_else(|| last.clone()),
            path,
            is_reexport,
        });
    }
}

/// Number of tokens of the path at the front: words with `::` between them.
fn path_length(tokens: &[&str]) -> usize {
    let segments = tokens[1..].chunks_exact(3);
    let is_next = |t: &&[&str]| t[..2] == [":", ":"] && is_word(t[2]);
    1 + 3 * segments.take_while(is_next).count()
}

/// Whether a path can begin at a word: it is no method, field, lifetime, new function or variable
/// of a macro, and no continuation of a path.
fn is_start_of_path(before: &[&str], word: &str) -> bool {
    match before {
        [.., first, "."] => *first == ".",
        [.., ":", ":"] | [.., "fn" | "'"] => false,
        [.., "$"] => word == "crate",
        _ => true,
    }
}

/// Whether a word alone can be the name of an item: it begins with a capital, or is called.
fn is_called_or_type(name: &str, next: Option<&&str>) -> bool {
    name.starts_with(char::is_uppercase) || matches!(next, Some(&("(" | "!")))
}
