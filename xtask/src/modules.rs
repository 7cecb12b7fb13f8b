//! Modules of a crate and the names that they use, read from the tokens of its files.
//!
//! Tokens suffice: items begin with a keyword, and bodies of macros contain paths like any other
//! code. Not seen are methods, which are called without a path, and items that a macro defines.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result, anyhow, bail};
use proc_macro2::{Delimiter, TokenStream, TokenTree};

use crate::files::folder_of;

/// Texts of the files of a crate by their paths.
pub type Files = BTreeMap<String, String>;

/// Segments of a path such as `crate::mesh::Mesh`.
pub type Path = Vec<String>;

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
#[derive(Debug, PartialEq)]
struct Import {
    /// Name in the module that imports it; `*` for all names.
    name: String,
    path: Path,
    /// Whether it has a visibility, and so belongs to what the module offers.
    is_reexport: bool,
}

/// What a path leads to.
#[derive(Debug, PartialEq)]
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
#[derive(Debug, PartialEq)]
pub struct Reference {
    pub from: String,
    pub to: String,
    pub item: String,
    /// Whether the file only offers the item under another path.
    pub is_reexport: bool,
}

/// The modules below one root such as `src/lib.rs`, in the order of their declarations.
#[derive(Debug, Default)]
pub struct Modules(Vec<Module>);

impl Modules {
    /// Reads the modules that the file `root` declares, directly and in turn; those of tests are
    /// left out.
    ///
    /// # Errors
    /// Files that are missing or are no Rust.
    pub fn new(files: &Files, root: &str) -> Result<Self> {
        let mut modules = Self::default();
        modules.read_file(files, root, folder_of(root), None)?;
        Ok(modules)
    }

    /// Files in which files declare modules, by the declared file.
    pub fn parents(&self) -> BTreeMap<&str, &str> {
        let pairs = self.0.iter().filter_map(|module| {
            let parent = &self.0[module.parent?];
            (parent.file != module.file).then_some((module.file.as_str(), parent.file.as_str()))
        });
        pairs.collect()
    }

    /// All names that one file uses and another defines.
    pub fn references(&self) -> Vec<Reference> {
        let mut references = Vec::new();
        for (index, module) in self.0.iter().enumerate() {
            let imports = module.imports.iter().map(|i| (&i.path, i.is_reexport));
            let mentions = module.mentions.iter().map(|path| (path, false));
            for (path, is_reexport) in imports.chain(mentions) {
                let is_glob = path.last().is_some_and(|last| last == "*");
                let (to, item) = match self.resolve(index, path, false, &mut BTreeSet::new()) {
                    Target::Item { file, name } => (file, name),
                    // Traits are used without their names.
                    Target::Module(of) if is_glob && !self.0[of].items.is_empty() => {
                        (self.0[of].file.clone(), "*".to_owned())
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
    fn read_file(
        &mut self,
        files: &Files,
        file: &str,
        folder: &str,
        parent: Option<usize>,
    ) -> Result<usize> {
        let text = files.get(file).with_context(|| format!("no file {file}"))?;
        let tokens: TokenStream = (text.parse()).map_err(|error| anyhow!("{file}: {error}"))?;
        self.read_items(files, file, folder, parent, tokens)
    }

    /// Reads the items of a module and returns its index.
    fn read_items(
        &mut self,
        files: &Files,
        file: &str,
        folder: &str,
        parent: Option<usize>,
        tokens: TokenStream,
    ) -> Result<usize> {
        let index = self.0.len();
        self.0.push(Module {
            file: file.to_owned(),
            parent,
            ..Module::default()
        });
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut rest = &tokens[..];
        while let Some(item) = Item::next(&mut rest) {
            if item.is_test {
                continue;
            }
            let module = &mut self.0[index];
            match (item.keyword.as_str(), item.name.clone()) {
                ("use", _) => {
                    let mut path = Vec::new();
                    read_use(
                        item.tokens,
                        &mut path,
                        item.has_visibility,
                        &mut module.imports,
                    );
                    continue;
                }
                ("mod", Some(name)) => {
                    let folder = format!("{folder}/{name}");
                    let child = match item.body() {
                        Some(body) => self.read_items(files, file, &folder, Some(index), body)?,
                        None => {
                            let candidates = [format!("{folder}.rs"), format!("{folder}/mod.rs")];
                            let Some(file) = candidates.iter().find(|f| files.contains_key(*f))
                            else {
                                bail!("{file}: there is no {}", candidates.join(" and no "));
                            };
                            self.read_file(files, file, &folder, Some(index))?
                        }
                    };
                    self.0[index].children.insert(name, child);
                    continue;
                }
                (_, Some(name)) => {
                    if item.is_exported {
                        self.0[0].items.insert(name.clone());
                    }
                    self.0[index].items.insert(name);
                }
                _ => {}
            }
            let module = &mut self.0[index];
            read_code(item.tokens, &mut module.imports, &mut module.mentions);
        }
        Ok(index)
    }

    /// What a path in a module leads to. Items that are not found where the path says, such as
    /// those that macros define, count as items of the last module found.
    fn resolve(
        &self,
        from: usize,
        path: &[String],
        wants_module: bool,
        visited: &mut BTreeSet<(usize, String, bool)>,
    ) -> Target {
        let Some((first, mut rest)) = path.split_first() else {
            return Target::Outside;
        };
        let parent = |of: usize| self.0[of].parent.map_or(Target::Outside, Target::Module);
        let is_last = |rest: &[String]| rest.is_empty() && !wants_module;
        let mut place = match first.as_str() {
            "crate" => Target::Module(0),
            "self" => Target::Module(from),
            "super" => parent(from),
            name => (self.look_up(from, name, !is_last(rest), visited)).unwrap_or(Target::Outside),
        };
        while let (Target::Module(module), Some((name, after))) = (&place, rest.split_first()) {
            rest = after;
            place =
                match name.as_str() {
                    "super" => parent(*module),
                    "*" => Target::Module(*module),
                    name => (self.look_up(*module, name, !is_last(rest), visited)).unwrap_or_else(
                        || Target::Item {
                            file: self.0[*module].file.clone(),
                            name: name.to_owned(),
                        },
                    ),
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
        visited: &mut BTreeSet<(usize, String, bool)>,
    ) -> Option<Target> {
        if !visited.insert((index, name.to_owned(), wants_module)) {
            return None;
        }
        let module = &self.0[index];
        let child = || module.children.get(name).copied().map(Target::Module);
        if let Some(child) = child().filter(|_| wants_module) {
            return Some(child);
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
        child().or_else(|| {
            let globs = module.imports.iter().filter(|import| import.name == "*");
            globs.into_iter().find_map(|glob| {
                match self.resolve(index, &glob.path, true, &mut visited.clone()) {
                    Target::Module(of) => self.look_up(of, name, wants_module, visited),
                    _ => None,
                }
            })
        })
    }
}

/// An item at the level of a module: its tokens from the keyword on.
struct Item<'a> {
    tokens: &'a [TokenTree],
    keyword: String,
    name: Option<String>,
    has_visibility: bool,
    /// Whether it is compiled for tests only.
    is_test: bool,
    /// Whether it is a macro that the root of the crate offers.
    is_exported: bool,
}

impl<'a> Item<'a> {
    /// Takes the next item, with its attributes, from the front of `rest`.
    fn next(rest: &mut &'a [TokenTree]) -> Option<Self> {
        let (mut is_test, mut is_exported) = (false, false);
        while let Some(attribute) = attribute(rest) {
            is_test |= is_test_only(&attribute);
            is_exported |= words(attribute).eq(["macro_export"]);
            *rest = &rest[rest.iter().position(|t| is_group(t, Delimiter::Bracket))? + 1..];
        }
        let has_visibility = is_word(rest.first()?, "pub");
        if has_visibility {
            let is_restricted = |token| is_group(token, Delimiter::Parenthesis);
            let skipped = 1 + usize::from(rest.get(1).is_some_and(is_restricted));
            *rest = &rest[skipped.min(rest.len())..];
        }
        // `const` begins a constant unless it belongs to a function.
        let modifiers = ["unsafe", "async", "extern", "default"];
        let is_modifier = |k: usize| {
            rest.get(k).is_some_and(|token| {
                let next = rest.get(k + 1).and_then(word);
                let next = next.as_deref().unwrap_or_default();
                matches!(token, TokenTree::Literal(_))
                    || modifiers.iter().any(|modifier| is_word(token, modifier))
                    || is_word(token, "const") && (next == "fn" || modifiers.contains(&next))
            })
        };
        let start = (0..).find(|k| !is_modifier(*k))?;
        let tokens = &rest[start.min(rest.len())..];
        let keyword = tokens.first().and_then(word).unwrap_or_default();
        let ends_with_semicolon = ["use", "const", "static", "type"].contains(&keyword.as_str());
        let is_end = |token: &TokenTree| {
            is_punct(token, ';') || !ends_with_semicolon && is_group(token, Delimiter::Brace)
        };
        let length = (tokens.iter().position(is_end)).map_or(tokens.len(), |last| last + 1);
        let name = match keyword.as_str() {
            "struct" | "enum" | "union" | "fn" | "trait" | "type" | "static" | "const" | "mod" => {
                let names = tokens.iter().skip(1).filter_map(word);
                names.into_iter().find(|name| name != "mut")
            }
            "macro_rules" => tokens.get(2).and_then(word),
            _ => None,
        };
        *rest = &tokens[length..];
        Some(Self {
            tokens: &tokens[..length],
            keyword,
            name,
            has_visibility,
            is_test,
            is_exported,
        })
    }

    /// What stands between the braces at the end.
    fn body(&self) -> Option<TokenStream> {
        match self.tokens.last()? {
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                Some(group.stream())
            }
            _ => None,
        }
    }
}

/// Content of the attribute at the front of `tokens`.
fn attribute(tokens: &[TokenTree]) -> Option<TokenStream> {
    let mut tokens = tokens.iter();
    if !is_punct(tokens.next()?, '#') {
        return None;
    }
    match tokens.find(|token| !is_punct(token, '!'))? {
        TokenTree::Group(group) if group.delimiter() == Delimiter::Bracket => Some(group.stream()),
        _ => None,
    }
}

/// Whether an attribute leaves out an item outside of tests: `cfg(test)`, alone or in `all`.
fn is_test_only(attribute: &TokenStream) -> bool {
    let words: Vec<String> = words(attribute.clone()).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["cfg", "test"] | ["test"] => true,
        ["cfg", "all", ..] => {
            words.contains(&"test") && !words.contains(&"not") && !words.contains(&"any")
        }
        _ => false,
    }
}

/// Words in tokens and in their groups.
fn words(tokens: TokenStream) -> impl Iterator<Item = String> {
    let nested = tokens.into_iter().flat_map(|token| match token {
        TokenTree::Group(group) => words(group.stream()).collect(),
        token => word(&token).into_iter().collect::<Vec<_>>(),
    });
    nested.collect::<Vec<_>>().into_iter()
}

/// Text of an identifier or keyword, without `r#`.
fn word(token: &TokenTree) -> Option<String> {
    match token {
        TokenTree::Ident(ident) => Some(ident.to_string().trim_start_matches("r#").to_owned()),
        _ => None,
    }
}

fn is_word(token: &TokenTree, text: &str) -> bool {
    matches!(token, TokenTree::Ident(ident) if ident == text)
}

fn is_punct(token: &TokenTree, character: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == character)
}

fn is_group(token: &TokenTree, delimiter: Delimiter) -> bool {
    matches!(token, TokenTree::Group(group) if group.delimiter() == delimiter)
}

/// Reads a `use` declaration, from the keyword on, or one branch of its braces behind `path`.
fn read_use(tokens: &[TokenTree], path: &mut Path, is_reexport: bool, imports: &mut Vec<Import>) {
    if tokens.is_empty() {
        return;
    }
    let start = path.len();
    let mut name = None;
    let mut tokens = tokens.iter().skip_while(|token| is_word(token, "use"));
    while let Some(token) = tokens.next() {
        match token {
            TokenTree::Group(group) => {
                let branches: Vec<TokenTree> = group.stream().into_iter().collect();
                for branch in branches.split(|token| is_punct(token, ',')) {
                    read_use(branch, path, is_reexport, imports);
                }
                path.truncate(start);
                return;
            }
            token if is_word(token, "as") => name = tokens.next().and_then(word),
            token if is_punct(token, '*') => path.push("*".to_owned()),
            token => path.extend(word(token)),
        }
    }
    // `a::{self}` is `a`.
    if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
        path.pop();
    }
    if let Some(last) = path.last() {
        imports.push(Import {
            name: name.unwrap_or_else(|| last.clone()),
            path: path.clone(),
            is_reexport,
        });
    }
    path.truncate(start);
}

/// Collects the paths in code, also in its groups and macros, and its `use` declarations.
fn read_code(tokens: &[TokenTree], imports: &mut Vec<Import>, mentions: &mut Vec<Path>) {
    let mut k = 0;
    while k < tokens.len() {
        if attribute(&tokens[k..]).is_some_and(|a| is_test_only(&a)) {
            let is_end = |t: &TokenTree| {
                is_punct(t, ';') || is_punct(t, ',') || is_group(t, Delimiter::Brace)
            };
            k += tokens[k..].iter().position(is_end).unwrap_or(tokens.len()) + 1;
            continue;
        }
        match &tokens[k] {
            TokenTree::Group(group) => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                read_code(&inner, imports, mentions);
            }
            token
                if is_word(token, "use")
                    && tokens.get(k + 1).is_some_and(|t| !is_punct(t, '<')) =>
            {
                let rest = &tokens[k..];
                let length = rest
                    .iter()
                    .position(|t| is_punct(t, ';'))
                    .unwrap_or(rest.len());
                read_use(&rest[..length], &mut Vec::new(), false, imports);
                k += length;
            }
            TokenTree::Ident(_) => {
                let length = path_length(&tokens[k..]);
                if is_start_of_path(tokens, k) {
                    let path: Path = tokens[k..k + length].iter().filter_map(word).collect();
                    if length > 1 || is_called_or_type(&path[0], tokens.get(k + 1)) {
                        mentions.push(path);
                    }
                }
                k += length - 1;
            }
            _ => {}
        }
        k += 1;
    }
}

/// Number of tokens of the path at the front: words with `::` between them.
fn path_length(tokens: &[TokenTree]) -> usize {
    let mut length = 1;
    while let [first, second, TokenTree::Ident(_), ..] = &tokens[length..] {
        if !is_punct(first, ':') || !is_punct(second, ':') {
            break;
        }
        length += 3;
    }
    length
}

/// Whether a path can begin at a word: it is no method, field, lifetime, new function or variable
/// of a macro, and no continuation of a path.
fn is_start_of_path(tokens: &[TokenTree], k: usize) -> bool {
    let before = |distance: usize, character| {
        (k.checked_sub(distance)).is_some_and(|k| is_punct(&tokens[k], character))
    };
    let is_member = before(1, '.') && !before(2, '.');
    let is_continued = before(1, ':') && before(2, ':');
    let is_variable = before(1, '$') && !is_word(&tokens[k], "crate");
    let is_new = k > 0 && is_word(&tokens[k - 1], "fn");
    !is_member && !is_continued && !is_variable && !is_new && !before(1, '\'')
}

/// Whether a word alone can be the name of an item: it begins with a capital, or is called.
fn is_called_or_type(name: &str, next: Option<&TokenTree>) -> bool {
    name.starts_with(char::is_uppercase)
        || next.is_some_and(|token| is_group(token, Delimiter::Parenthesis) || is_punct(token, '!'))
}
