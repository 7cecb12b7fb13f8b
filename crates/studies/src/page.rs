//! Pages with headings, texts, tables and charts, written as Markdown and as one HTML file.

use std::path::Path;

use anyhow::{Context, Result};
use swimmer::output::processor;

use crate::chart::LogLog;
use crate::table::{Table, escape};

/// Part of a page.
enum Part {
    Heading(String),
    /// A paragraph, in Markdown.
    Text(String),
    /// Large figures with their captions, side by side; only in HTML.
    Figures(Vec<(String, &'static str)>),
    /// An SVG picture with its name, without extension, and its description.
    Picture(&'static str, &'static str, String),
    Table(Table),
}

/// A page of a study.
pub struct Page {
    title: &'static str,
    parts: Vec<Part>,
}

/// Style sheet: text of a readable width, tables and charts as wide as the window.
const STYLE: &str = "
:root { --ink: #1d2126; --soft: #5c6570; --line: #e3e6ea; --paper: #fff; --wash: #f6f7f9; --good: #00705a; --bad: #b3261e; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e8eb; --soft: #9aa4af; --line: #333a42; --paper: #15181c; --wash: #1d2126; --good: #4cc3a3; --bad: #ff8a80; }
  figure { background: #fff; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 72rem; padding: 2rem 1.25rem 4rem; color: var(--ink); background: var(--paper);
  font: 16px/1.55 system-ui, sans-serif; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.25rem; margin: 2.5rem 0 .75rem; padding-top: 1rem; border-top: 1px solid var(--line); }
p { max-width: 46rem; color: var(--soft); }
nav { display: flex; flex-wrap: wrap; gap: .25rem 1.25rem; margin: 1rem 0; }
a { color: inherit; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(9rem, 1fr)); gap: 1rem; margin: 1.25rem 0; }
.figures div { background: var(--wash); border-radius: .5rem; padding: .9rem 1rem; }
.figures b { display: block; font-size: 1.5rem; font-variant-numeric: tabular-nums; }
.figures span { color: var(--soft); font-size: .875rem; }
figure { margin: 1rem 0; border: 1px solid var(--line); border-radius: .5rem; padding: .5rem; overflow-x: auto; }
figure svg { width: 100%; height: auto; min-width: 34rem; display: block; }
.table { overflow-x: auto; border: 1px solid var(--line); border-radius: .5rem; }
table { border-collapse: collapse; width: 100%; font-size: .875rem; font-variant-numeric: tabular-nums; }
th, td { padding: .35rem .7rem; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--line); }
th { position: sticky; top: 0; background: var(--wash); font-weight: 600; }
th:first-child, td:first-child { text-align: left; }
tr:last-child td { border-bottom: 0; }
tr.bad td { color: var(--bad); font-weight: 600; }
td:last-child { color: var(--good); }
tr.bad td:last-child { color: var(--bad); }
";

impl Page {
    /// A page that begins with the day, the machine, the command that made it and a text.
    pub fn new(title: &'static str, command: &str, text: impl AsRef<str>) -> Self {
        let parts = Vec::new();
        let mut page = Self { title, parts };
        page.text(format!(
            "{}, {}. Made by `cargo xtask {command}`. {}",
            today(),
            processor(),
            text.as_ref()
        ));
        page
    }

    pub fn heading(&mut self, text: impl Into<String>) {
        self.parts.push(Part::Heading(text.into()));
    }

    pub fn text(&mut self, text: impl Into<String>) {
        self.parts.push(Part::Text(text.into()));
    }

    pub fn figures(&mut self, figures: impl IntoIterator<Item = (String, &'static str)>) {
        self.parts
            .push(Part::Figures(figures.into_iter().collect()));
    }

    pub fn table(&mut self, table: Table) {
        self.parts.push(Part::Table(table));
    }

    /// A chart that is written to `name.svg`.
    pub fn chart(&mut self, name: &'static str, text: &'static str, it: &LogLog) -> Result<()> {
        self.parts.push(Part::Picture(name, text, it.svg()?));
        Ok(())
    }

    /// The page as Markdown; pictures are links to files.
    pub fn markdown(&self) -> String {
        let parts = self.parts.iter().map(|part| match part {
            Part::Heading(text) => format!("\n## {text}\n"),
            Part::Text(text) => format!("\n{}\n", text.trim()),
            Part::Figures(_) => String::new(),
            Part::Picture(name, description, _) => format!("\n![{description}]({name}.svg)\n"),
            Part::Table(table) => format!("\n{}", table.markdown()),
        });
        format!("# {}\n", self.title) + &parts.collect::<String>()
    }

    /// The page as HTML, without references to other files.
    pub fn html(&self) -> String {
        let (mut body, mut headings) = (String::new(), String::new());
        let plain = |text: &str| escape(&text.replace(['`', '*'], ""));
        for (number, part) in self.parts.iter().enumerate() {
            body += &match part {
                Part::Heading(text) => {
                    let text = plain(text);
                    headings += &format!("<a href=\"#s{number}\">{text}</a>");
                    format!("<h2 id=\"s{number}\">{text}</h2>\n")
                }
                Part::Text(text) => format!("<p>{}</p>\n", plain(text)),
                Part::Figures(figures) => {
                    let cells = figures.iter().map(|(figure, caption)| {
                        format!("<div><b>{}</b><span>{caption}</span></div>", plain(figure))
                    });
                    let cells: String = cells.collect();
                    format!("<div class=\"figures\">{cells}</div>\n")
                }
                Part::Picture(_, _, svg) => format!("<figure>{}</figure>\n", scalable(svg)),
                Part::Table(table) => table.html() + "\n",
            };
        }
        let title = escape(self.title);
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n\
             <body>\n<h1>{title}</h1>\n<nav>{headings}</nav>\n{body}</body>\n</html>\n"
        )
    }

    /// Writes the page to `name.html` in a folder, and its pictures beside it.
    pub fn write_html(&self, out: &Path, name: &str) -> Result<()> {
        write(out, &format!("{name}.html"), &self.html())?;
        self.write_pictures(out)
    }

    /// Prints the page, and writes it to `name.md` in a folder, with its pictures beside it.
    pub fn write(&self, out: &Path, name: &str) -> Result<()> {
        let text = self.markdown();
        println!("{text}");
        write(out, &format!("{name}.md"), &text)?;
        self.write_pictures(out)
    }

    fn write_pictures(&self, out: &Path) -> Result<()> {
        self.parts.iter().try_for_each(|part| match part {
            Part::Picture(name, _, svg) => write(out, &format!("{name}.svg"), svg),
            _ => Ok(()),
        })
    }
}

/// SVG picture that scales with the page: its fixed size, which comes first, is left out.
fn scalable(svg: &str) -> String {
    match svg.split_once(" viewBox=") {
        Some((_, rest)) => format!("<svg viewBox={rest}"),
        None => svg.to_owned(),
    }
}

/// Writes a file into a folder, which is created if necessary.
pub fn write(folder: &Path, name: &str, content: &str) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| {
        let folder = folder.display();
        format!("could not create the folder {folder}; choose another with --out")
    })?;
    let path = folder.join(name);
    std::fs::write(&path, content).with_context(|| {
        let path = path.display();
        format!("could not write {path}; choose another folder with --out")
    })
}

/// Today as `year-month-day`, in universal time.
fn today() -> String {
    let now = jiff::Timestamp::now();
    now.to_zoned(jiff::tz::TimeZone::UTC).date().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_begins_with_day_and_command_and_is_written_in_two_ways() {
        let mut page = Page::new("a < b", "validate", "Rows.");
        page.heading("rows & columns");
        let mut table = Table::new(["x"]);
        table.push_marked(true, ["<script>".into()]);
        page.table(table);
        let svg = "<svg width=\"10\" height=\"20\" viewBox=\"0 0 10 20\"/>";
        let picture = Part::Picture("errors", "errors over seconds", svg.into());
        page.parts.push(picture);
        let html = page.html();
        assert!(html.contains("<h1>a &lt; b</h1>") && html.contains("href=\"#s1\""));
        assert!(html.contains("<tr class=\"bad\"><td>&lt;script&gt;</td></tr>"));
        assert!(html.contains("<svg viewBox=\"0 0 10 20\"/>"));
        let text = page.markdown();
        assert!(text.contains("Made by `cargo xtask validate`. Rows.\n\n## rows & columns"));
        assert!(text.contains("![errors over seconds](errors.svg)"));
        let day: Vec<usize> = today().split('-').map(str::len).collect();
        assert_eq!(day, [4, 2, 2]);
    }
}
