//! The page of the random cases.

use std::fmt::Write;

use super::case::{Case, End};
use super::quantity::Comparison;
use crate::machine;

/// Groups of the summary, in its order: kind of the case and name.
const GROUPS: &[(&str, &str)] = &[
    ("instant", "all"),
    ("instant", "free"),
    ("instant", "linked"),
    ("instant", "ball"),
    ("instant", "unbounded"),
    ("instant", "curved"),
    ("instant", "straight"),
    ("instant", "axisymmetric"),
    ("instant", "three-dimensional"),
    ("instant", "gap below 0.2"),
    ("instant", "meridian plane"),
    ("squirmer", "all"),
    ("squirmer", "free"),
    ("squirmer", "linked"),
    ("squirmer", "ball"),
    ("squirmer", "unbounded"),
    ("squirmer", "curved"),
    ("squirmer", "straight"),
    ("squirmer", "gap below 0.2"),
    ("squirmer", "meridian plane"),
    ("stroke", "all"),
    ("stroke", "plain"),
    ("stroke", "ball"),
    ("stroke", "straight"),
    ("stroke", "two cycles"),
    ("stroke", "angle"),
    ("stroke", "gap below 0.5"),
    ("stroke", "gap below 0.2"),
    ("stroke", "tolerance missed"),
];

/// Quantities of the summary, in its order.
const QUANTITIES: &[&str] = &[
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

/// The page.
pub fn markdown(cases: &[Case], seed: u64) -> String {
    let count = |kind: &str| {
        let cases = cases.iter().filter(|case| case.kind == kind);
        cases.filter(|case| case.model == "fem").count()
    };
    let dropped: usize = cases.iter().map(Case::dropped).sum();
    let mut text = format!(
        "# Random cases\n\n{}, {}. Made by `cargo xtask accuracy --random --instants {} --squirmers {} --strokes {} --seed {seed}`. \
         Errors are relative to the largest exact value of the quantity among the bodies. uncorrected: the value of the discrete problem; corrected: this value \
         minus its estimated error. estimate / error: the signed estimate over the true error, projected on it. Exact values: multipoles at a tolerance of 1e-7 (instants in three dimensions), 1e-12 (on an axis) and 1e-8 (strokes); \
         {dropped} comparisons were dropped because their exact values have bars above 5 % of an error. Elements have their default sizes; in the meridian plane the \
         tolerance is 1e-4. `--seed S --instants 1 --squirmers 0 --strokes 0` (or another 1) draws the case of seed S again.\n\n\
         Instants: 2 to 5 spheres, radii 0.2 to 2, smallest gap 0.02 to 3 radii of the smaller neighbour, half of them on a line, half in a ball, half linked, a \
         quarter with straight facets. Squirmers: the same with slip, b1 up to 1 and b2 up to 2. Strokes: three spheres, radii 0.6 to 1.6, arms 5 to 10, closing to gaps of 0.05 to 3 radii of the smaller neighbour.\n",
        machine::today(),
        machine::processor(),
        count("instant"),
        count("squirmer"),
        count("stroke"),
    );
    text.push_str("\n## Summary\n\n");
    text.push_str(
        "| group | quantity | cases | uncorrected in bar | corrected in bar | largest uncorrected / bar | largest corrected / bar | median bar / uncorrected | median bar / \
         corrected | median uncorrected | median corrected | median uncorrected / corrected | estimate / error (least, median, largest) |\n\
         |:--|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for (kind, group) in GROUPS {
        for quantity in QUANTITIES {
            let found: Vec<&Comparison> = cases
                .iter()
                .filter(|case| case.kind == *kind && case.is_in(group))
                .flat_map(Case::comparisons)
                .filter(|comparison| comparison.name == *quantity)
                .collect();
            if !found.is_empty() {
                // Writing to a String cannot fail.
                let _ = writeln!(text, "| {kind}s, {group} | {quantity} {}", summary(&found));
            }
        }
    }
    text.push_str("\n## Refused\n\n");
    let refused = cases.iter().filter_map(|case| match &case.end {
        End::Refused(reason) => Some((case, reason)),
        End::Compared { .. } => None,
    });
    let mut count = 0;
    for (case, reason) in refused {
        count += 1;
        let _ = writeln!(
            text,
            "- {} of seed {} ({}, {}): {reason}",
            case.kind, case.seed, case.model, case.description
        );
    }
    if count == 0 {
        text.push_str("None.\n");
    }
    for (kind, title, quantities) in [
        (
            "stroke",
            "Strokes",
            &["displacement", "rotation", "work"][..],
        ),
        ("instant", "Instants: the velocities", &["velocity"][..]),
        (
            "squirmer",
            "Squirmers",
            &["velocity", "power", "stresslet"][..],
        ),
    ] {
        if cases.iter().any(|case| case.kind == kind) {
            rows(&mut text, title, quantities, cases, kind);
        }
    }
    text
}

/// One row per case and quantity.
fn rows(text: &mut String, title: &str, quantities: &[&str], cases: &[Case], kind: &str) {
    let _ = write!(
        text,
        "\n## {title}\n\n| seed | model | drawn | quantity | exact | uncorrected | corrected | bar | uncorrected / bar | corrected / bar | seconds |\n\
         |--:|:--|:--|:--|--:|--:|--:|--:|--:|--:|--:|\n"
    );
    for case in cases.iter().filter(|case| case.kind == kind) {
        let End::Compared { seconds, .. } = case.end else {
            continue;
        };
        let comparisons = case.comparisons();
        for c in comparisons.filter(|c| quantities.contains(&c.name.as_str())) {
            let over_bar = |error: f64| match c.bar {
                Some(bar) => format!("{:.2}", error / bar),
                None => "-".to_owned(),
            };
            let bar = c.bar.map_or("-".to_owned(), |bar| format!("{bar:.1e}"));
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {:.10} | {:.1e} | {:.1e} | {bar} | {} | {} | {seconds:.1} |",
                case.seed,
                case.model,
                case.description,
                c.name,
                c.scale,
                c.uncorrected,
                c.corrected,
                over_bar(c.uncorrected),
                over_bar(c.corrected)
            );
        }
    }
}

/// The columns of the summary after the names.
fn summary(found: &[&Comparison]) -> String {
    let of = |value: &dyn Fn(&Comparison) -> Option<f64>| -> Vec<f64> {
        let mut values: Vec<f64> = found.iter().filter_map(|c| value(c)).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let over_bar = [
        of(&|c| Some(c.uncorrected / c.bar?)),
        of(&|c| Some(c.corrected / c.bar?)),
    ];
    let shares = over_bar.each_ref().map(|ratios| match ratios.len() {
        0 => "-".to_owned(),
        count => {
            let within = ratios.iter().filter(|ratio| **ratio <= 1.0).count();
            format!("{:.0} %", 100.0 * within as f64 / count as f64)
        }
    });
    let largest = over_bar.each_ref().map(|ratios| factor(ratios.last()));
    let over_error = over_bar
        .each_ref()
        .map(|ratios| factor(median(ratios).map(f64::recip).as_ref()));
    let errors = [of(&|c| Some(c.uncorrected)), of(&|c| Some(c.corrected))];
    let errors = errors.map(|e| format!("{:.1e}", median(&e).unwrap_or(f64::NAN)));
    let gain = of(&|c| Some(c.uncorrected / c.corrected));
    let effectivity = of(&|c| Some(c.effectivity));
    format!(
        "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {}, {}, {} |",
        found.len(),
        shares[0],
        shares[1],
        largest[0],
        largest[1],
        over_error[0],
        over_error[1],
        errors[0],
        errors[1],
        factor(median(&gain).as_ref()),
        factor(effectivity.first()),
        factor(median(&effectivity).as_ref()),
        factor(effectivity.last()),
    )
}

fn factor(value: Option<&f64>) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.2}"))
}

/// Middle of sorted values.
fn median(sorted: &[f64]) -> Option<f64> {
    sorted.get(sorted.len() / 2).copied()
}

/// One line for the progress of the study.
pub fn line(case: &Case) -> String {
    let end = match &case.end {
        End::Compared {
            comparisons,
            seconds,
            ..
        } => {
            let errors: Vec<String> = comparisons
                .iter()
                .map(|c| format!("{} {:.1e} {:.1e}", c.name, c.uncorrected, c.corrected))
                .collect();
            format!("{} ({seconds:.1} s)", errors.join(", "))
        }
        End::Refused(reason) => format!("refused: {reason}"),
    };
    format!(
        "seed {}, {}, gap {:.3}: {end}",
        case.seed, case.model, case.gap
    )
}
