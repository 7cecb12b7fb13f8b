//! Tests that are ignored because they are slow: run one by one, with the time of each.

use std::fmt::Write as _;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::cargo;
use crate::files::{files_below, read, root};

/// The page with the result of a run of all slow tests.
const PAGE: &str = "docs/slow-tests.md";

/// Which of the slow tests are run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Selection {
    /// All, also those without a stated time.
    All,
    /// Those with a stated time of at most so many seconds.
    Below(f64),
    /// The fastest, as many as by their stated times take so many seconds together.
    Within(f64),
}

/// What a source file says of an ignored test.
#[derive(Clone, Debug, PartialEq)]
pub struct Stated {
    /// Line number, starting at 1.
    pub line: usize,
    /// Name of the function.
    pub function: String,
    /// Seconds in the reason, `slow: 40 s` or `slow: 2 min`, followed by nothing or a comma.
    pub seconds: Option<f64>,
}

/// An ignored test of a compiled program.
#[derive(Clone, Debug)]
struct SlowTest {
    /// Folder of its crate, relative to the root of the workspace.
    folder: String,
    executable: String,
    /// Name with its modules.
    name: String,
    seconds: Option<f64>,
}

/// How a test ended.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Ending {
    Passed,
    /// It passed and printed that it was skipped, because it needs a file that is not there.
    Skipped,
    Failed,
}

impl Ending {
    /// Word for readers.
    fn word(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Skipped => "skipped",
            Self::Failed => "FAILED",
        }
    }
}

/// A test that was run.
struct Run {
    test: SlowTest,
    /// Wall-clock seconds.
    seconds: f64,
    ending: Ending,
}

/// Reads the arguments of `cargo xtask slow` and runs the tests that they ask for.
pub fn run(arguments: &[String]) -> Result<()> {
    let (mut selection, mut package) = (Selection::All, None);
    let mut arguments = arguments.iter();
    while let Some(option) = arguments.next() {
        let value = arguments.next().map(String::as_str);
        match (option.as_str(), value) {
            ("--below", Some(text)) => {
                let seconds = text.parse();
                selection = Selection::Below(seconds.with_context(|| format!("--below {text}"))?);
            }
            ("--package", Some(name)) => package = Some(name),
            _ => bail!("usage: cargo xtask slow [--below SECONDS] [--package NAME]"),
        }
    }
    run_selection(selection, package).map(|_| ())
}

/// Runs the selected slow tests of a package, or of the workspace, and returns the names of those
/// that were not run. A run of all tests of the workspace writes the page of slow tests.
///
/// # Errors
/// Tests that fail, and tests that cannot be built or started.
pub fn run_selection(selection: Selection, package: Option<&str>) -> Result<Vec<String>> {
    eprintln!("== slow tests");
    let tests = slow_tests(package)?;
    let (selected, left_out) = select(tests, selection);
    let mut not_run = Vec::new();
    for test in &left_out {
        let stated = test.seconds.map_or("no stated time".to_owned(), duration);
        eprintln!("not run: {} ({}, {stated})", test.name, test.folder);
        not_run.push(test.name.clone());
    }
    let mut runs = Vec::new();
    for test in selected {
        let run = run_test(test)?;
        if run.ending == Ending::Skipped {
            not_run.push(run.test.name.clone());
        }
        eprintln!(
            "{} in {}: {} ({})",
            run.ending.word(),
            duration(run.seconds),
            run.test.name,
            run.test.folder
        );
        runs.push(run);
    }
    if selection == Selection::All && package.is_none() {
        std::fs::write(root().join(PAGE), page(&runs, &today()?, &machine()))
            .with_context(|| format!("could not write {PAGE}"))?;
    }
    let count = |ending| runs.iter().filter(|run| run.ending == ending).count();
    let seconds = runs.iter().fold(0.0, |sum, run| sum + run.seconds);
    eprintln!(
        "{} slow tests in {}; {} skipped or not run",
        runs.len(),
        duration(seconds),
        not_run.len()
    );
    match count(Ending::Failed) {
        0 => Ok(not_run),
        count => bail!("{count} slow tests failed"),
    }
}

/// What the text of a source file says of its ignored tests.
pub fn stated(text: &str) -> Vec<Stated> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let ignored = lines.iter().enumerate();
    ignored
        .filter(|(_, line)| line.starts_with("#[ignore"))
        .map(|(index, line)| {
            let mut functions = lines[index..].iter().filter_map(|line| {
                let (_, rest) = line.split_once("fn ")?;
                rest.split(['(', '<']).next()
            });
            Stated {
                line: index + 1,
                function: functions.next().unwrap_or_default().to_owned(),
                seconds: seconds_of(line),
            }
        })
        .collect()
}

/// Seconds in an attribute such as `#[ignore = "slow: 2 min, 3 GB"]`.
fn seconds_of(attribute: &str) -> Option<f64> {
    let reason = attribute.split('"').nth(1)?.strip_prefix("slow: ")?;
    let (number, unit) = reason.split(',').next()?.split_once(' ')?;
    let factor = match unit {
        "s" => 1.0,
        "min" => 60.0,
        _ => return None,
    };
    let number: f64 = number.parse().ok()?;
    Some(factor * number)
}

/// Builds the tests of a package, or of the workspace, and lists those that are ignored.
fn slow_tests(package: Option<&str>) -> Result<Vec<SlowTest>> {
    let mut arguments = vec![
        "test",
        "--no-run",
        "--message-format=json-render-diagnostics",
    ];
    match package {
        Some(name) => arguments.extend(["--package", name]),
        None => arguments.push("--workspace"),
    }
    let messages = cargo::output(&arguments)?;
    let mut tests = Vec::new();
    for (folder, executable) in messages.lines().filter_map(test_program) {
        let stated = stated_in(&folder)?;
        for name in ignored_names(&folder, executable)? {
            let function = name.rsplit("::").next().unwrap_or(&name);
            let seconds = (stated.iter().filter(|s| s.function == function))
                .filter_map(|stated| stated.seconds)
                .reduce(f64::max);
            tests.push(SlowTest {
                folder: folder.clone(),
                executable: executable.to_owned(),
                name,
                seconds,
            });
        }
    }
    Ok(tests)
}

/// Folder of the crate and path of the program, if a message of cargo is about a compiled test.
fn test_program(message: &str) -> Option<(String, &str)> {
    let (_, profile) = message.split_once(r#""profile":{"#)?;
    let (profile, _) = profile.split_once('}')?;
    let is_test = profile.contains(r#""test":true"#);
    let text = |key| {
        let (_, rest) = message.split_once(&format!(r#""{key}":""#))?;
        rest.split('"').next()
    };
    let manifest = std::path::Path::new(text("manifest_path")?);
    let root = root().canonicalize().ok()?;
    let folder = manifest.parent()?.strip_prefix(root).ok()?;
    let folder = folder.to_string_lossy().into_owned();
    is_test.then_some((folder, text("executable")?))
}

/// What the sources of a crate say of their ignored tests.
fn stated_in(folder: &str) -> Result<Vec<Stated>> {
    let mut all = Vec::new();
    for file in files_below(folder, ".rs")? {
        all.extend(stated(&read(&root().join(file))?));
    }
    Ok(all)
}

/// Names of the ignored tests of a compiled program.
fn ignored_names(folder: &str, executable: &str) -> Result<Vec<String>> {
    let output = test_command(folder, executable)
        .args(["--list", "--ignored", "--format", "terse"])
        .output()
        .with_context(|| format!("could not start {executable}"))?;
    if !output.status.success() {
        bail!("{executable} could not list its tests: {}", output.status);
    }
    let listing = String::from_utf8(output.stdout).context("a test program printed no UTF-8")?;
    let names = listing
        .lines()
        .filter_map(|line| line.strip_suffix(": test"));
    Ok(names.map(str::to_owned).collect())
}

/// Command that starts the tests of a crate as cargo does.
fn test_command(folder: &str, executable: &str) -> Command {
    let folder = root().join(folder);
    let mut command = Command::new(executable);
    command
        .env("CARGO_MANIFEST_DIR", &folder)
        .current_dir(folder);
    command
}

/// The selected tests and the others; both by stated time, those without one last.
fn select(mut tests: Vec<SlowTest>, selection: Selection) -> (Vec<SlowTest>, Vec<SlowTest>) {
    let key = |test: &SlowTest| test.seconds.unwrap_or(f64::INFINITY);
    tests.sort_by(|a, b| key(a).total_cmp(&key(b)));
    let mut sum = 0.0;
    tests.into_iter().partition(|test| {
        sum += key(test);
        match selection {
            Selection::All => true,
            Selection::Below(seconds) => key(test) <= seconds,
            Selection::Within(seconds) => sum <= seconds,
        }
    })
}

/// Runs one test alone; what it prints is shown if it fails.
fn run_test(test: SlowTest) -> Result<Run> {
    let start = Instant::now();
    let output = test_command(&test.folder, &test.executable)
        .args(["--ignored", "--show-output", "--exact", &test.name])
        .output()
        .with_context(|| format!("could not start {}", test.executable))?;
    let seconds = start.elapsed().as_secs_f64();
    let text = String::from_utf8_lossy(&output.stdout);
    // A name that fits no test passes as well.
    let ending = match output.status.success() && text.contains(" 1 passed") {
        true if text.contains(": skipped") => Ending::Skipped,
        true => Ending::Passed,
        false => Ending::Failed,
    };
    if ending == Ending::Failed {
        eprintln!("{text}{}", String::from_utf8_lossy(&output.stderr));
    }
    Ok(Run {
        test,
        seconds,
        ending,
    })
}

/// The page of all slow tests, the slowest first.
fn page(runs: &[Run], day: &str, machine: &str) -> String {
    let mut runs: Vec<&Run> = runs.iter().collect();
    runs.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    let total: f64 = runs.iter().map(|run| run.seconds).sum();
    let count = |ending| runs.iter().filter(|run| run.ending == ending).count();
    let (failed, skipped) = (count(Ending::Failed), count(Ending::Skipped));
    let mut page = format!(
        "# Slow tests\n\nTests that `cargo test` leaves out because they are slow, written by \
         `cargo xtask slow`: {day},\n{machine}. Each ran alone. {} tests took {}; {skipped} \
         skipped, {failed} failed.\n\nThe stated time is that in the source, by which continuous integration \
         chooses the tests that it runs.\n\n| test | crate | time | stated | result |\n\
         |:--|:--|--:|--:|:--|\n",
        runs.len(),
        duration(total)
    );
    for run in runs {
        let SlowTest {
            folder,
            name,
            seconds,
            ..
        } = &run.test;
        let stated = seconds.map_or("none".to_owned(), duration);
        let result = run.ending.word();
        let time = duration(run.seconds);
        let crate_name = folder.rsplit('/').next().unwrap_or(folder);
        // Writing to a string cannot fail.
        let _ = writeln!(
            page,
            "| `{name}` | `{crate_name}` | {time} | {stated} | {result} |"
        );
    }
    page
}

/// A time for readers: `0.4 s`, `12 s` or `3.5 min`.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 9.95 => format!("{s:.1} s"),
        s if s < 119.5 => format!("{s:.0} s"),
        s => format!("{:.1} min", s / 60.0),
    }
}

/// Today as `year-month-day`, in universal time.
fn today() -> Result<String> {
    let output = Command::new("date").args(["-u", "+%F"]).output();
    let output = output.context("could not start date")?;
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Model of the processor, as far as it is known, and number of its threads.
fn machine() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let model = model.map_or("unknown processor", |(_, name)| name);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{model}, {threads} threads")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stated_times_are_read() {
        let text = [
            "#[test]",
            "#[ignore = \"slow: 2 min, 3 GB\"]",
            "fn large() {}",
            "    #[ignore = \"slow: 1.5 s\"]",
            "    // why",
            "    fn random(",
            "#[ignore = \"a minute\"]",
            "fn vague() {}",
            "#[ignore]",
            "fn bare() {}",
        ]
        .join("\n");
        let found: Vec<(usize, String, Option<f64>)> = (stated(&text).into_iter())
            .map(|stated| (stated.line, stated.function, stated.seconds))
            .collect();
        assert_eq!(
            found,
            [
                (2, "large".to_owned(), Some(120.0)),
                (4, "random".to_owned(), Some(1.5)),
                (7, "vague".to_owned(), None),
                (9, "bare".to_owned(), None),
            ]
        );
        for other in [
            "slow: ten seconds",
            "slow: 3 minutes",
            "slow: 3 s to 4 s",
            "20 s",
        ] {
            assert_eq!(
                seconds_of(&format!("#[ignore = \"{other}\"]")),
                None,
                "{other}"
            );
        }
    }

    #[test]
    fn messages_of_cargo_name_the_programs_of_tests() {
        let root = root().canonicalize().unwrap();
        let message = |is_test| {
            format!(
                "{{\"reason\":\"compiler-artifact\",\"manifest_path\":\"{}/crates/mesh/Cargo.toml\",\
                 \"target\":{{\"test\":true}},\"profile\":{{\"opt_level\":\"3\",\"test\":{is_test}}},\
                 \"executable\":\"/build/mesh-1\",\"fresh\":true}}",
                root.display()
            )
        };
        let expected = Some(("crates/mesh".to_owned(), "/build/mesh-1"));
        assert_eq!(test_program(&message(true)), expected);
        assert_eq!(test_program(&message(false)), None);
    }

    fn test(name: &str, seconds: Option<f64>) -> SlowTest {
        SlowTest {
            folder: "crates/mesh".to_owned(),
            executable: String::new(),
            name: name.to_owned(),
            seconds,
        }
    }

    #[test]
    fn tests_are_selected_by_stated_time() {
        let tests = || {
            let rows = [
                ("a", Some(60.0)),
                ("b", None),
                ("c", Some(5.0)),
                ("d", Some(20.0)),
            ];
            rows.map(|(name, seconds)| test(name, seconds)).to_vec()
        };
        for (selection, run, left_out) in [
            (Selection::All, "cdab", ""),
            (Selection::Below(20.0), "cd", "ab"),
            (Selection::Within(84.0), "cd", "ab"),
            (Selection::Within(85.0), "cda", "b"),
        ] {
            let (selected, others) = select(tests(), selection);
            let names = |tests: &[SlowTest]| tests.iter().map(|t| t.name.clone()).collect();
            let found: (String, String) = (names(&selected), names(&others));
            assert_eq!(
                found,
                (run.to_owned(), left_out.to_owned()),
                "{selection:?}"
            );
        }
    }

    #[test]
    fn the_page_has_a_row_for_each_test() {
        let run = |name, stated, seconds, ending| Run {
            test: test(name, stated),
            seconds,
            ending,
        };
        let runs = [
            run("a::fast", Some(5.0), 4.04, Ending::Passed),
            run("b::slow", None, 200.0, Ending::Failed),
            run("c::absent", Some(60.0), 0.0, Ending::Skipped),
        ];
        let page = page(&runs, "2026-11-23", "a processor, 2 threads");
        assert!(page.contains(
            "2026-11-23,\na processor, 2 threads. Each ran alone. 3 tests took 3.4 min; 1 skipped, 1 failed."
        ));
        let rows: Vec<&str> = page
            .lines()
            .filter(|line| line.starts_with("| `"))
            .collect();
        assert_eq!(
            rows,
            [
                "| `b::slow` | `mesh` | 3.3 min | none | FAILED |",
                "| `a::fast` | `mesh` | 4.0 s | 5.0 s | passed |",
                "| `c::absent` | `mesh` | 0.0 s | 60 s | skipped |",
            ]
        );
    }
}
