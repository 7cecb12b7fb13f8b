//! Errors, corrected errors and error bars of random instantaneous solutions and random strokes.

mod arrangement;
mod comparison;
mod instants;
mod strokes;

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};
use clap::Args;

use crate::page::{self, Page};
use crate::table::{Cell, Table, count, exp, fixed, median, optional, percent};
use comparison::{Case, Comparison, End};

/// The cases of a study.
#[derive(Args)]
pub struct Choice {
    /// Number of random instantaneous solutions.
    #[arg(long, default_value_t = 100, requires = "random")]
    instants: usize,
    /// Number of random instantaneous solutions of bodies with slip.
    #[arg(long, default_value_t = 20, requires = "random")]
    squirmers: usize,
    /// Number of random strokes.
    #[arg(long, default_value_t = 30, requires = "random")]
    strokes: usize,
    /// Seed of the first random case; each following one has the next seed.
    #[arg(long, default_value_t = 1, requires = "random")]
    seed: u64,
    /// Continues with the cases of `random.jsonl` in the folder.
    #[arg(long, requires = "random")]
    resume: bool,
}

/// Kinds of cases with the groups of the summary and, for one row per case, a title and quantities.
const KINDS: [(&str, &[&str], &str, &[&str]); 3] = [
    (
        "instant",
        &[
            "all",
            "free",
            "linked",
            "ball",
            "unbounded",
            "curved",
            "straight",
            "axisymmetric",
            "three-dimensional",
            "gap below 0.2",
            "meridian plane",
        ],
        "Instants: the velocities",
        &["velocity"],
    ),
    (
        "squirmer",
        &[
            "all",
            "free",
            "linked",
            "ball",
            "unbounded",
            "curved",
            "straight",
            "gap below 0.2",
            "meridian plane",
        ],
        "Squirmers",
        &["velocity", "power", "stresslet"],
    ),
    (
        "stroke",
        &[
            "all",
            "plain",
            "ball",
            "straight",
            "two cycles",
            "angle",
            "gap below 0.5",
            "gap below 0.2",
            "tolerance missed",
        ],
        "Strokes",
        &["displacement", "rotation", "work"],
    ),
];

/// Quantities of the summary, in its order.
const QUANTITIES: [&str; 10] = [
    "velocity",
    "angular velocity",
    "force",
    "torque",
    "link force",
    "power",
    "stresslet",
    "displacement",
    "rotation",
    "work",
];

/// Computes the cases of successive seeds and writes `random.md` and `random.csv`.
///
/// Each case is written to `random.jsonl` as soon as it is known. To resume, cases of this file are
/// not computed again.
///
/// # Errors
/// Scenes that are invalid; files that cannot be written.
pub fn run(choice: &Choice, out: &Path) -> Result<()> {
    let path = out.join("random.jsonl");
    let mut cases = match choice.resume {
        true => read(
            &fs::read_to_string(&path)
                .with_context(|| format!("could not read {}", path.display()))?,
        ),
        false => Vec::new(),
    };
    let lines: String = cases.iter().map(json).collect::<Result<_>>()?;
    page::write(out, "random.jsonl", &lines)?;
    let mut file = File::options().append(true).open(&path)?;
    for (kind, number_of_cases) in [
        ("instant", choice.instants),
        ("squirmer", choice.squirmers),
        ("stroke", choice.strokes),
    ] {
        for number in 0..number_of_cases {
            let seed = choice.seed.wrapping_add(number as u64);
            if cases
                .iter()
                .any(|case| case.kind == kind && case.seed == seed)
            {
                continue;
            }
            let more = match kind {
                "stroke" => strokes::case(seed).map(|case| vec![case]),
                _ => instants::cases(seed, kind == "squirmer"),
            };
            for case in more.with_context(|| format!("{kind} of seed {seed}"))? {
                file.write_all(json(&case)?.as_bytes())
                    .with_context(|| format!("could not write {}", path.display()))?;
                eprintln!("{kind} {}/{number_of_cases}: {}", number + 1, line(&case));
                cases.push(case);
            }
        }
    }
    page::write(out, "random.csv", &values(&cases).csv())?;
    page(&cases, choice.seed).write(out, "random")
}

fn json(case: &Case) -> Result<String> {
    Ok(serde_json::to_string(case)? + "\n")
}

/// Cases of the lines of a file, without those after an incomplete line.
fn read(text: &str) -> Vec<Case> {
    let cases = text.lines().map(serde_json::from_str);
    cases.map_while(Result::ok).collect()
}

/// All values, one row per case and quantity.
fn values(cases: &[Case]) -> Table {
    let mut table = Table::new([
        "kind",
        "seed",
        "model",
        "groups",
        "gap",
        "dofs",
        "seconds",
        "drawn",
        "refused",
        "quantity",
        "scale",
        "uncorrected",
        "corrected",
        "bar",
        "bar_without_mesh",
        "estimate",
        "effectivity",
        "exact_bar",
        "dropped",
    ]);
    for case in cases {
        let (dofs, seconds, refused) = match &case.end {
            End::Compared { dofs, seconds, .. } => (count(*dofs), fixed(*seconds, 1), ""),
            End::Refused(reason) => (count(0), fixed(0.0, 1), reason.as_str()),
        };
        let head: [Cell; 9] = [
            case.kind.clone().into(),
            case.seed.to_string().into(),
            case.model.clone().into(),
            case.groups.join("; ").into(),
            fixed(case.gap, 4),
            dofs,
            seconds,
            case.description.clone().into(),
            refused.into(),
        ];
        if !refused.is_empty() {
            table.push(head.clone());
        }
        for c in case.comparisons() {
            let values = [
                c.name.clone().into(),
                exp(c.scale, 4),
                exp(c.uncorrected, 4),
                exp(c.corrected, 4),
                optional(c.bar, |bar| exp(bar, 4)),
                exp(c.bar_without_mesh, 2),
                exp(c.estimate, 4),
                optional(c.effectivity, |ratio| fixed(ratio, 4)),
                exp(c.exact_bar, 1),
                c.is_dropped().to_string().into(),
            ];
            table.push(head.iter().cloned().chain(values));
        }
    }
    table
}

fn page(cases: &[Case], seed: u64) -> Page {
    let number = |kind: &str| {
        let of_kind = |case: &&Case| case.kind == kind && case.model == "fem";
        cases.iter().filter(of_kind).count()
    };
    let dropped = cases
        .iter()
        .flat_map(Case::comparisons)
        .filter(|c| c.is_dropped())
        .count();
    let command = format!(
        "accuracy --random --instants {} --squirmers {} --strokes {} --seed {seed}",
        number("instant"),
        number("squirmer"),
        number("stroke")
    );
    let text = format!(
        "Errors are relative to the largest exact value of the quantity among the bodies. uncorrected: the value of the discrete problem; corrected: this value \
         minus its estimated error. estimate / error: the signed estimate over the true error, projected on it. Exact values: multipoles at a tolerance of 1e-7 (instants in three dimensions), 1e-12 (on an axis) and 1e-8 (strokes); \
         {dropped} comparisons were dropped because their exact values have bars above 5 % of an error. Elements have their default sizes; in the meridian plane the \
         tolerance is 1e-4. `--seed S --instants 1 --squirmers 0 --strokes 0` (or another 1) draws the case of seed S again.\n\n\
         Instants: 2 to 5 spheres, radii 0.2 to 2, smallest gap 0.02 to 3 radii of the smaller neighbour, half of them on a line, half in a ball, half linked, a \
         quarter with straight facets. Squirmers: the same with slip, b1 up to 1 and b2 up to 2. Strokes: three spheres, radii 0.6 to 1.6, arms 5 to 10, closing to gaps of 0.05 to 3 radii of the smaller neighbour."
    );
    let mut page = Page::new("Random cases", &command, text);
    page.heading("Summary");
    page.table(summary(cases));
    page.heading("Refused");
    let refused = cases.iter().filter_map(|case| match &case.end {
        End::Refused(reason) => Some(format!(
            "- {} of seed {} ({}, {}): {reason}",
            case.kind, case.seed, case.model, case.description
        )),
        End::Compared { .. } => None,
    });
    let refused: Vec<String> = refused.collect();
    page.text(match refused.is_empty() {
        true => "None.".to_owned(),
        false => refused.join("\n"),
    });
    for (kind, _, title, quantities) in KINDS {
        let of_kind: Vec<&Case> = cases.iter().filter(|case| case.kind == kind).collect();
        if !of_kind.is_empty() {
            page.heading(title);
            page.table(errors_in_bars(&of_kind, quantities));
        }
    }
    page
}

/// One row per case and quantity.
fn errors_in_bars(cases: &[&Case], quantities: &[&str]) -> Table {
    let mut table = Table::new([
        "seed",
        "model",
        "drawn",
        "quantity",
        "exact",
        "uncorrected",
        "corrected",
        "bar",
        "uncorrected / bar",
        "corrected / bar",
        "seconds",
    ]);
    for case in cases {
        let End::Compared { seconds, .. } = case.end else {
            continue;
        };
        for c in case.exact_comparisons() {
            if quantities.contains(&c.name.as_str()) {
                let over_bar = |error: f64| optional(c.bar, |bar| fixed(error / bar, 2));
                table.push([
                    case.seed.to_string().into(),
                    case.model.clone().into(),
                    case.description.clone().into(),
                    c.name.clone().into(),
                    fixed(c.scale, 10),
                    exp(c.uncorrected, 1),
                    exp(c.corrected, 1),
                    optional(c.bar, |bar| exp(bar, 1)),
                    over_bar(c.uncorrected),
                    over_bar(c.corrected),
                    fixed(seconds, 1),
                ]);
            }
        }
    }
    table
}

/// One row per group and quantity.
fn summary(cases: &[Case]) -> Table {
    let mut table = Table::new([
        "group",
        "quantity",
        "cases",
        "uncorrected in bar",
        "corrected in bar",
        "largest uncorrected / bar",
        "largest corrected / bar",
        "median bar / uncorrected",
        "median bar / corrected",
        "median uncorrected",
        "median corrected",
        "median uncorrected / corrected",
        "estimate / error (least, median, largest)",
    ]);
    for (kind, groups, ..) in KINDS {
        for group in groups {
            let is_in = |case: &&Case| case.kind == kind && case.groups.iter().any(|g| g == group);
            for quantity in QUANTITIES {
                let of_group = cases.iter().filter(is_in).flat_map(Case::exact_comparisons);
                let found: Vec<&Comparison> = of_group.filter(|c| c.name == quantity).collect();
                if !found.is_empty() {
                    let group = format!("{kind}s, {group}");
                    table.push([vec![group.into(), quantity.into()], statistics(&found)].concat());
                }
            }
        }
    }
    table
}

/// The cells of the summary after the names.
fn statistics(found: &[&Comparison]) -> Vec<Cell> {
    let of = |value: &dyn Fn(&Comparison) -> Option<f64>| -> Vec<f64> {
        let values = found.iter().map(|c| value(c));
        values.flatten().collect()
    };
    let known = |values: &[f64], value: f64, cell: fn(f64) -> Cell| {
        optional((!values.is_empty()).then_some(value), cell)
    };
    let factor = |value: f64| fixed(value, 2);
    let largest = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let over_bar = [
        of(&|c| Some(c.uncorrected / c.bar?)),
        of(&|c| Some(c.corrected / c.bar?)),
    ];
    let within = over_bar.each_ref().map(|ratios| {
        let within = ratios.iter().filter(|ratio| **ratio <= 1.0).count();
        known(ratios, within as f64 / ratios.len() as f64, percent)
    });
    let worst = over_bar
        .each_ref()
        .map(|ratios| known(ratios, largest(ratios), factor));
    let over_error = over_bar
        .each_ref()
        .map(|ratios| known(ratios, median(ratios.clone()).recip(), factor));
    let errors = [of(&|c| Some(c.uncorrected)), of(&|c| Some(c.corrected))];
    let errors = errors.map(|errors| exp(median(errors), 1));
    let gain = of(&|c| Some(c.uncorrected / c.corrected));
    let ratios = of(&|c| c.effectivity);
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let three = [least, median(ratios.clone()), largest(&ratios)];
    let three = three.map(|ratio| format!("{ratio:.2}")).join(", ");
    let cells = [within, worst, over_error, errors].concat();
    let mut all = vec![count(found.len())];
    all.extend(cells);
    all.extend([factor(median(gain)), three.into()]);
    all
}

/// One line for the progress of the study.
fn line(case: &Case) -> String {
    let end = match &case.end {
        End::Compared { seconds, .. } => {
            let errors = case.comparisons().iter();
            let errors =
                errors.map(|c| format!("{} {:.1e} {:.1e}", c.name, c.uncorrected, c.corrected));
            format!("{} ({seconds:.1} s)", errors.collect::<Vec<_>>().join(", "))
        }
        End::Refused(reason) => format!("refused: {reason}"),
    };
    format!(
        "seed {}, {}, gap {:.3}: {end}",
        case.seed, case.model, case.gap
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_are_read_as_they_were_written_up_to_an_incomplete_line() {
        let comparison = |name: &str, bar: Option<f64>| Comparison {
            name: name.to_owned(),
            scale: 0.5,
            uncorrected: 2e-3,
            corrected: 1e-4,
            bar,
            bar_without_mesh: 0.0,
            estimate: 1.9e-3,
            effectivity: Some(0.95),
            exact_bar: 1e-6,
        };
        let case = |seed: u64, end: End| Case {
            kind: "instant".to_owned(),
            seed,
            model: "fem".to_owned(),
            groups: ["all", "gap below 0.2"].map(str::to_owned).to_vec(),
            gap: 0.125,
            description: "radii 1, 2".to_owned(),
            end,
        };
        let compared = End::Compared {
            comparisons: vec![
                comparison("velocity", Some(3e-4)),
                comparison("torque", None),
            ],
            dofs: 1000,
            seconds: 1.5,
        };
        let cases = [case(7, compared), case(8, End::Refused("no".to_owned()))];
        let lines: String = cases.iter().map(|case| json(case).unwrap()).collect();
        assert_eq!(read(&(lines + "{\"kind\": \"inst")), cases);
        let rows = values(&cases).csv();
        let rows: Vec<&str> = rows.lines().collect();
        assert_eq!(rows.len(), 1 + 2 + 1);
        let last = "instant,8,fem,all; gap below 0.2,0.125,0,0.0,\"radii 1, 2\",no,,";
        assert!(rows[3].starts_with(last), "{}", rows[3]);
        let groups = summary(&cases).markdown();
        assert_eq!(
            groups.matches("instants, gap below 0.2").count(),
            2,
            "{groups}"
        );
        assert!(!groups.contains("instants, ball"));
    }
}
