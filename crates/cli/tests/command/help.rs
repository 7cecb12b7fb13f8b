//! Help texts: examples that run, exit codes, completions, manual pages.

use std::path::Path;

use crate::{shell, text};

fn help(command: &str) -> String {
    let output = shell(Path::new("."), &format!("swim {command} --help"));
    assert_eq!(output.status.code(), Some(0));
    text(&output.stdout)
}

/// The commands that `swim --help` lists.
fn commands() -> Vec<String> {
    let help = help("");
    let (_, rest) = help.split_once("\nCommands:\n").unwrap();
    let entries = rest.lines().take_while(|line| !line.is_empty());
    // Lines that continue a description have a larger indentation.
    let names = entries.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = names.filter_map(|line| line.split_whitespace().next());
    let commands: Vec<String> = names
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect();
    assert!(commands.len() >= 10, "{commands:?}");
    commands
}

#[test]
fn every_help_ends_with_examples_that_run_and_the_exit_codes() {
    for command in commands().iter().map(String::as_str).chain([""]) {
        let help = help(command);
        let (_, end) = help.split_once("\nExamples:\n").unwrap();
        let (examples, codes) = end.split_once("\nExit codes:\n").unwrap();
        for code in ["  0 ", "  2 ", "  3 ", "  130 "] {
            assert!(codes.contains(code), "{command}: {codes}");
        }
        let folder = tempfile::tempdir().unwrap();
        let examples: Vec<&str> = examples.trim_end().lines().map(str::trim).collect();
        let of_command = format!("swim {command}");
        assert!(examples.iter().any(|line| line.starts_with(&of_command)));
        for line in examples {
            let output = shell(folder.path(), line);
            assert!(output.status.success(), "{line}: {}", text(&output.stderr));
        }
    }
}

#[test]
fn completions_and_manual_pages_name_every_command() {
    let commands = commands();
    let folder = tempfile::tempdir().unwrap();
    for name in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = shell(folder.path(), &format!("swim completions {name}"));
        assert!(output.status.success());
        let script = text(&output.stdout);
        for command in &commands {
            assert!(script.contains(command.as_str()), "{name}: {command}");
        }
        assert!(script.contains("sensitivities"), "{name}");
    }
    assert!(shell(folder.path(), "swim man pages").status.success());
    for command in &commands {
        let page = folder.path().join(format!("pages/swim-{command}.1"));
        let page = std::fs::read_to_string(page).unwrap();
        assert!(page.contains("Exit codes"), "{command}");
    }
    assert!(folder.path().join("pages/swim.1").exists());
    let output = shell(folder.path(), "touch file; swim man file/pages");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn a_quiet_run_prints_its_summary_as_json_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str| {
        let output = shell(folder.path(), line);
        assert!(output.status.success(), "{line}: {}", text(&output.stderr));
        (text(&output.stdout), text(&output.stderr))
    };
    run("swim new three-sphere");
    let (_, progress) = run("swim run three-sphere.toml");
    assert!(progress.contains("phase 1/4 (left-arm)"), "{progress}");
    let (printed, progress) = run("swim run three-sphere.toml --json -q");
    assert_eq!(progress, "");
    let parse = |text: &str| -> serde_json::Value { serde_json::from_str(text).unwrap() };
    let [mut printed, mut stored] = [
        parse(&printed),
        parse(
            &std::fs::read_to_string(folder.path().join("out/three-sphere/summary.json")).unwrap(),
        ),
    ];
    for summary in [&mut printed, &mut stored] {
        // The memory may have grown since the file was written.
        summary["peak_rss_mib"].take();
    }
    assert_eq!(printed, stored);
    // Errors and warnings remain, without colours, since stderr is no terminal.
    let output = shell(folder.path(), "swim --quiet check none.toml");
    assert!(text(&output.stderr).starts_with("error: cannot read none.toml"));
}
