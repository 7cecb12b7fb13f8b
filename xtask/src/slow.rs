//! Tests that are ignored because they are slow: run one by one, with the time of each.

use std::fs::{self, File};
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::cargo;
use crate::files::{files_below, read, root};

/// The page with the result of a run of all slow tests.
const PAGE: &str = "docs/slow-tests.md";

/// A test fails that takes this many times its stated time, and longer than [`PATIENCE`]: one that
/// does not end would keep the others from running.
const OVERRUN: f64 = 10.0;

/// Seconds that every test may take; those without a stated time may take ten times as many.
const PATIENCE: f64 = 300.0;

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
#[derive(Debug, PartialEq)]
pub struct Stated {
    /// Line number, starting at 1.
    pub line: usize,
    /// Name of the function.
    pub function: String,
    /// Seconds in the reason, `slow: 40 s` or `slow: 2 min`, followed by nothing or a comma.
    pub seconds: Option<f64>,
}

/// An ignored test of a compiled program.
#[derive(Clone, Debug, Default)]
struct SlowTest {
    /// Folder of its crate, relative to the root of the workspace.
    folder: String,
    executable: String,
    /// Name with its modules.
    name: String,
    /// Seconds that its source states.
    stated: Option<f64>,
    /// Wall-clock seconds of the run.
    seconds: f64,
    /// Whether it passed; false until it was run.
    has_passed: bool,
}

/// Reads the arguments of `cargo xtask slow` and runs the tests that they ask for.
pub fn run(arguments: &[String]) -> Result<()> {
    let (mut selection, mut package) = (Selection::All, None);
    for pair in arguments.chunks(2) {
        match pair {
            [option, text] if option == "--below" => {
                let seconds = text.parse();
                selection = Selection::Below(seconds.with_context(|| format!("--below {text}"))?);
            }
            [option, name] if option == "--package" => package = Some(name.as_str()),
            _ => bail!("usage: cargo xtask slow [--below SECONDS] [--package NAME]"),
        }
    }
    run_selection(selection, package).map(drop)
}

/// Runs the selected slow tests of a package, or of the workspace, and returns the names of those
/// that were not run. A run of all tests of the workspace writes the page of slow tests.
///
/// # Errors
/// Tests that fail, and tests that cannot be built or started.
pub fn run_selection(selection: Selection, package: Option<&str>) -> Result<Vec<String>> {
    eprintln!("== slow tests");
    let (mut selected, left_out) = select(slow_tests(package)?, selection);
    for SlowTest {
        name,
        folder,
        stated,
        ..
    } in &left_out
    {
        let stated = stated.map_or("no stated time".to_owned(), duration);
        eprintln!("not run: {name} ({folder}, {stated})");
    }
    for test in &mut selected {
        test.run()?;
        let (result, seconds) = (test.result(), duration(test.seconds));
        eprintln!("{result} in {seconds}: {} ({})", test.name, test.folder);
    }
    if selection == Selection::All && package.is_none() {
        fs::write(root().join(PAGE), page(&selected, &today()?, &machine()))
            .with_context(|| format!("could not write {PAGE}"))?;
    }
    let seconds = selected.iter().map(|test| test.seconds).sum();
    let (ran, not_run) = (selected.len(), left_out.len());
    eprintln!(
        "{ran} slow tests in {}; {not_run} not run",
        duration(seconds)
    );
    match selected.iter().filter(|test| !test.has_passed).count() {
        0 => Ok(left_out.into_iter().map(|test| test.name).collect()),
        count => bail!("{count} slow tests failed"),
    }
}

/// What the text of a source file says of its ignored tests.
pub fn stated(text: &str) -> Vec<Stated> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let ignored = (lines.iter().enumerate()).filter(|(_, line)| line.starts_with("#[ignore"));
    ignored
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
    Some(factor * number.parse::<f64>().ok()?)
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
        let mut in_sources = Vec::new();
        for file in files_below(&folder, ".rs")? {
            in_sources.extend(stated(&read(&root().join(file))?));
        }
        let program = SlowTest {
            folder,
            executable: executable.to_owned(),
            ..SlowTest::default()
        };
        let listing = program.output(&["--list", "--format", "terse"])?.1;
        for name in listing
            .lines()
            .filter_map(|line| line.strip_suffix(": test"))
        {
            let function = name.rsplit("::").next();
            let same = in_sources.iter().filter(|s| Some(&*s.function) == function);
            tests.push(SlowTest {
                name: name.to_owned(),
                stated: same.filter_map(|stated| stated.seconds).reduce(f64::max),
                ..program.clone()
            });
        }
    }
    Ok(tests)
}

/// Folder of the crate and path of the program, if a message of cargo is about a compiled test.
fn test_program(message: &str) -> Option<(String, &str)> {
    let (_, profile) = message.split_once(r#""profile":{"#)?;
    let is_test = profile.split_once('}')?.0.contains(r#""test":true"#);
    let text = |key| {
        let (_, rest) = message.split_once(&format!(r#""{key}":""#))?;
        rest.split('"').next()
    };
    let manifest = std::path::Path::new(text("manifest_path")?);
    let root = root().canonicalize().ok()?;
    let folder = manifest.parent()?.strip_prefix(root).ok()?;
    is_test.then_some((folder.to_string_lossy().into_owned(), text("executable")?))
}

impl SlowTest {
    /// Seconds after which the test is ended.
    fn limit(&self) -> f64 {
        let stated = self.stated.unwrap_or(PATIENCE);
        PATIENCE.max(OVERRUN * stated)
    }

    /// Runs the program of the test on ignored tests, as cargo does; whether it succeeded, and what
    /// it printed.
    fn output(&self, arguments: &[&str]) -> Result<(bool, String)> {
        let folder = root().join(&self.folder);
        // A file, since a full pipe would stop the program.
        let printed = root().join("target/slow-test.txt");
        fs::write(&printed, "")?;
        let mut program = Command::new(&self.executable)
            .env("CARGO_MANIFEST_DIR", &folder)
            .current_dir(folder)
            .arg("--ignored")
            .args(arguments)
            .stdout(File::options().append(true).open(&printed)?)
            .stderr(File::options().append(true).open(&printed)?)
            .spawn()
            .with_context(|| format!("could not start {}", self.executable))?;
        let (start, limit) = (Instant::now(), self.limit());
        while program.try_wait()?.is_none() {
            if start.elapsed().as_secs_f64() > limit {
                program.kill()?;
                eprintln!("ended after {}", duration(limit));
                break;
            }
            thread::sleep(Duration::from_millis(20));
        }
        let is_success = program.wait()?.success();
        let text = fs::read(printed)?;
        let text = String::from_utf8_lossy(&text).into_owned();
        Ok((is_success, text))
    }

    /// Runs the test alone; what it prints is shown if it fails.
    fn run(&mut self) -> Result<()> {
        let start = Instant::now();
        let (is_success, text) = self.output(&["--show-output", "--exact", &self.name])?;
        self.seconds = start.elapsed().as_secs_f64();
        // A name that fits no test succeeds as well.
        self.has_passed = is_success && text.contains(" 1 passed");
        if !self.has_passed {
            eprintln!("{text}");
        }
        Ok(())
    }

    fn result(&self) -> &'static str {
        if self.has_passed { "passed" } else { "FAILED" }
    }
}

/// The selected tests and the others; both by stated time, those without one last.
fn select(mut tests: Vec<SlowTest>, selection: Selection) -> (Vec<SlowTest>, Vec<SlowTest>) {
    let key = |test: &SlowTest| test.stated.unwrap_or(f64::INFINITY);
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

/// The page of all slow tests, the slowest first.
fn page(tests: &[SlowTest], day: &str, machine: &str) -> String {
    let mut tests: Vec<&SlowTest> = tests.iter().collect();
    tests.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    let total = duration(tests.iter().map(|test| test.seconds).sum());
    let failed = tests.iter().filter(|test| !test.has_passed).count();
    let rows = tests.iter().map(|test| {
        let stated = test.stated.map_or("none".to_owned(), duration);
        let crate_name = test.folder.rsplit('/').next().unwrap_or_default();
        let (name, time, result) = (&test.name, duration(test.seconds), test.result());
        format!("| `{name}` | `{crate_name}` | {time} | {stated} | {result} |\n")
    });
    format!(
        "# Slow tests\n\nTests that `cargo test` leaves out because they are slow, written by \
         `cargo xtask slow`: {day},\n{machine}. Each ran alone. {} tests took {total}; {failed} \
         failed.\n\nThe stated time is that in the source, by which continuous integration chooses \
         the tests that it runs.\n\n| test | crate | time | stated | result |\n|:--|:--|--:|--:|:--|\n\
         {}",
        tests.len(),
        rows.collect::<String>()
    )
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
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let mut lines = text.lines();
    let model = lines.find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let model = model.map_or("unknown processor", |(_, name)| name);
    let threads = thread::available_parallelism().map_or(1, usize::from);
    format!("{model}, {threads} threads")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stated_times_are_read() {
        let [large, random] = ["slow: 2 min, 3 GB", "slow: 1.5 s"];
        let text = format!(
            "\n#[ignore = \"{large}\"]\nfn large() {{}}\n    #[ignore = \"{random}\"]\n    // why\n    \
             fn random(\n#[ignore = \"a minute\"]\nfn vague() {{}}\n#[ignore]\nfn bare() {{}}"
        );
        let found = stated(&text);
        let found: Vec<(usize, &str, Option<f64>)> = (found.iter())
            .map(|stated| (stated.line, &*stated.function, stated.seconds))
            .collect();
        let timed = [(2, "large", Some(120.0)), (4, "random", Some(1.5))];
        assert_eq!(found[..2], timed);
        assert_eq!(found[2..], [(7, "vague", None), (9, "bare", None)]);
        for other in [
            "slow: ten seconds",
            "slow: 3 minutes",
            "slow: 3 s to 4 s",
            "20 s",
        ] {
            let attribute = format!("#[ignore = \"{other}\"]");
            assert_eq!(seconds_of(&attribute), None, "{other}");
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

    fn test(name: &str, stated: Option<f64>) -> SlowTest {
        SlowTest {
            folder: "crates/mesh".to_owned(),
            name: name.to_owned(),
            stated,
            ..SlowTest::default()
        }
    }

    #[test]
    fn tests_are_selected_by_stated_time() {
        let times = [
            ("a", Some(60.0)),
            ("b", None),
            ("c", Some(5.0)),
            ("d", Some(20.0)),
        ];
        for (selection, run, left_out) in [
            (Selection::All, "cdab", ""),
            (Selection::Below(20.0), "cd", "ab"),
            (Selection::Within(84.0), "cd", "ab"),
            (Selection::Within(85.0), "cda", "b"),
        ] {
            let tests = times.map(|(name, stated)| test(name, stated)).to_vec();
            let (selected, others) = select(tests, selection);
            let names = |tests: &[SlowTest]| tests.iter().map(|t| t.name.clone()).collect();
            let found: [String; 2] = [names(&selected), names(&others)];
            assert_eq!(found, [run, left_out], "{selection:?}");
        }
    }

    #[test]
    fn the_page_has_a_row_for_each_test() {
        let run = |name, stated, seconds, has_passed| SlowTest {
            seconds,
            has_passed,
            ..test(name, stated)
        };
        let tests = [
            run("a::fast", Some(5.0), 4.04, true),
            run("b::slow", None, 200.0, false),
        ];
        let page = page(&tests, "2026-11-23", "a processor, 2 threads");
        assert!(page.contains(
            "2026-11-23,\na processor, 2 threads. Each ran alone. 2 tests took 3.4 min; 1 failed."
        ));
        let rows: Vec<&str> = page
            .lines()
            .filter(|line| line.starts_with("| `"))
            .collect();
        let slow = "| `b::slow` | `mesh` | 3.3 min | none | FAILED |";
        let fast = "| `a::fast` | `mesh` | 4.0 s | 5.0 s | passed |";
        assert_eq!(rows, [slow, fast]);
    }
}
