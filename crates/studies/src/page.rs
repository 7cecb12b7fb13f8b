//! Self-contained HTML pages with headings, notes, tables and charts, for wide and narrow screens.

use std::fmt::Write;

/// Part of a page.
pub enum Part {
    /// A heading, linked from the list at the top of the page.
    Heading(String),
    /// A paragraph of plain text.
    Text(String),
    /// Large figures with their captions, side by side.
    Figures(Vec<(String, String)>),
    /// An SVG picture.
    Chart(String),
    /// Column heads and rows; the flag of a row marks it as failed.
    Table {
        heads: Vec<String>,
        rows: Vec<(Vec<String>, bool)>,
    },
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

/// HTML text of a page, without references to other files.
pub fn html(title: &str, parts: &[Part]) -> String {
    let mut body = String::new();
    let mut joints = String::new();
    let mut anchors = 0;
    // Writing to a String cannot fail.
    for part in parts {
        let _ = match part {
            Part::Heading(text) => {
                anchors += 1;
                let _ = write!(joints, "<a href=\"#s{anchors}\">{}</a>", escape(text));
                writeln!(body, "<h2 id=\"s{anchors}\">{}</h2>", escape(text))
            }
            Part::Text(text) => writeln!(body, "<p>{}</p>", escape(text)),
            Part::Figures(figures) => {
                let cells: String = figures
                    .iter()
                    .map(|(figure, caption)| {
                        format!(
                            "<div><b>{}</b><span>{}</span></div>",
                            escape(figure),
                            escape(caption)
                        )
                    })
                    .collect();
                writeln!(body, "<div class=\"figures\">{cells}</div>")
            }
            Part::Chart(svg) => writeln!(body, "<figure>{}</figure>", scalable(svg)),
            Part::Table { heads, rows } => {
                let cells = |tag: &str, cells: &[String]| -> String {
                    cells
                        .iter()
                        .map(|cell| format!("<{tag}>{}</{tag}>", escape(cell)))
                        .collect()
                };
                let lines: String = rows
                    .iter()
                    .map(|(row, failed)| {
                        let class = if *failed { " class=\"bad\"" } else { "" };
                        format!("<tr{class}>{}</tr>\n", cells("td", row))
                    })
                    .collect();
                writeln!(
                    body,
                    "<div class=\"table\"><table><thead><tr>{}</tr></thead><tbody>\n{lines}</tbody></table></div>",
                    cells("th", heads)
                )
            }
        };
    }
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n\
         <body>\n<h1>{title}</h1>\n<nav>{joints}</nav>\n{body}</body>\n</html>\n"
    )
}

/// SVG picture that scales with the page: the fixed size is replaced by a view box.
fn scalable(svg: &str) -> String {
    let attribute = |name: &str| -> Option<&str> {
        let rest = svg.split_once(&format!("{name}=\""))?.1;
        Some(rest.split_once('"')?.0)
    };
    match (attribute("width"), attribute("height")) {
        (Some(width), Some(height)) if !svg.contains("viewBox") => svg.replacen(
            &format!("width=\"{width}\" height=\"{height}\""),
            &format!("viewBox=\"0 0 {width} {height}\""),
            1,
        ),
        (Some(width), Some(height)) => {
            svg.replacen(&format!("width=\"{width}\" height=\"{height}\" "), "", 1)
        }
        _ => svg.to_owned(),
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_escapes_text_marks_failures_and_joints_headings() {
        let page = html(
            "a < b",
            &[
                Part::Heading("rows & columns".into()),
                Part::Table {
                    heads: vec!["x".into()],
                    rows: vec![(vec!["<script>".into()], true)],
                },
                Part::Chart("<svg width=\"10\" height=\"20\" viewBox=\"0 0 10 20\"/>".into()),
            ],
        );
        assert!(page.contains("<h1>a &lt; b</h1>") && page.contains("href=\"#s1\""));
        assert!(page.contains("<tr class=\"bad\"><td>&lt;script&gt;</td></tr>"));
        assert!(page.contains("<svg viewBox=\"0 0 10 20\"/>"));
    }
}
