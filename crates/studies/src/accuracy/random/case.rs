//! A random case with its errors, or the reason for which it was refused.

use std::fmt::Write;

use super::quantity::Comparison;

/// Error bar of the exact value, over the smaller one of the errors measured with it, above which
/// the comparison is dropped.
const INEXACT: f64 = 0.05;

/// A case and what became of it.
pub struct Case {
    /// `instant`, `squirmer` or `stroke`.
    pub kind: String,
    /// The seed from which it is drawn again.
    pub seed: u64,
    pub model: String,
    /// Names of the groups that it belongs to, separated by spaces.
    pub groups: String,
    /// Smallest gap, in radii of the smaller neighbour.
    pub gap: f64,
    /// What was drawn, without commas.
    pub description: String,
    pub end: End,
}

/// Result of a case.
pub enum End {
    Compared {
        comparisons: Vec<Comparison>,
        dofs: usize,
        seconds: f64,
    },
    Refused(String),
}

impl Case {
    /// Whether it belongs to a group.
    pub fn is_in(&self, group: &str) -> bool {
        format!(" {} ", self.groups).contains(&format!(" {group} "))
    }

    /// Comparisons of a case, without those whose exact value is not exact enough.
    pub fn comparisons(&self) -> impl Iterator<Item = &Comparison> {
        let comparisons = match &self.end {
            End::Compared { comparisons, .. } => &comparisons[..],
            End::Refused(_) => &[],
        };
        comparisons.iter().filter(|c| !c.is_dropped())
    }

    /// Number of comparisons whose exact value is not exact enough.
    pub fn dropped(&self) -> usize {
        match &self.end {
            End::Compared { comparisons, .. } => {
                comparisons.iter().filter(|c| c.is_dropped()).count()
            }
            End::Refused(_) => 0,
        }
    }

    /// The head of [`Case::csv`].
    pub const CSV_HEAD: &'static str = "kind,seed,model,groups,gap,quantity,scale,uncorrected,\
         corrected,bar,beside_mesh,estimate,effectivity,exact_bar,dropped,dofs,seconds,drawn,refused\n";

    /// One line per quantity.
    pub fn csv(&self) -> String {
        let head = format!(
            "{},{},{},{},{:.4}",
            self.kind, self.seed, self.model, self.groups, self.gap
        );
        match &self.end {
            End::Compared {
                comparisons,
                dofs,
                seconds,
            } => {
                let mut text = String::new();
                for c in comparisons {
                    let bar = c.bar.map_or(String::new(), |bar| format!("{bar:.4e}"));
                    // Writing to a String cannot fail.
                    let _ = writeln!(
                        text,
                        "{head},{},{:e},{:.4e},{:.4e},{bar},{:.2e},{:.4e},{:.4},{:.1e},{},{dofs},\
                         {seconds:.2},{},",
                        c.name,
                        c.scale,
                        c.uncorrected,
                        c.corrected,
                        c.beside_mesh,
                        c.estimate,
                        c.effectivity,
                        c.exact_bar,
                        c.is_dropped(),
                        self.description
                    );
                }
                text
            }
            End::Refused(reason) => {
                let reason = reason.replace(',', ";").replace('\n', " ");
                format!("{head},,,,,,,,,,,,,{},{reason}\n", self.description)
            }
        }
    }
}

/// Cases of the text of `random.csv`, without those of an incomplete last line.
pub fn read(text: &str) -> Vec<Case> {
    let mut cases: Vec<Case> = Vec::new();
    for line in text.lines().skip(1) {
        let columns: Vec<&str> = line.split(',').collect();
        let Some((mut case, comparison)) = parse(&columns) else {
            break;
        };
        let last = cases.last_mut().filter(|last| {
            [&last.kind, &last.model] == [&case.kind, &case.model] && last.seed == case.seed
        });
        match (last.map(|last| &mut last.end), &mut case.end) {
            (Some(End::Compared { comparisons, .. }), End::Compared { .. }) => {
                comparisons.extend(comparison);
            }
            (_, End::Compared { comparisons, .. }) => {
                comparisons.extend(comparison);
                cases.push(case);
            }
            (_, End::Refused(_)) => cases.push(case),
        }
    }
    cases
}

/// A case without comparisons, and the comparison of one line.
fn parse(columns: &[&str]) -> Option<(Case, Option<Comparison>)> {
    let [
        kind,
        seed,
        model,
        groups,
        gap,
        name,
        scale,
        uncorrected,
        corrected,
        bar,
        beside_mesh,
        estimate,
        effectivity,
        exact_bar,
        _,
        dofs,
        seconds,
        description,
        refused,
    ] = columns
    else {
        return None;
    };
    let comparison = match refused.is_empty() {
        false => None,
        true => Some(Comparison {
            name: (*name).to_owned(),
            scale: scale.parse().ok()?,
            uncorrected: uncorrected.parse().ok()?,
            corrected: corrected.parse().ok()?,
            bar: match bar.is_empty() {
                true => None,
                false => Some(bar.parse().ok()?),
            },
            beside_mesh: beside_mesh.parse().ok()?,
            estimate: estimate.parse().ok()?,
            effectivity: effectivity.parse().ok()?,
            exact_bar: exact_bar.parse().ok()?,
        }),
    };
    let case = Case {
        kind: (*kind).to_owned(),
        seed: seed.parse().ok()?,
        model: (*model).to_owned(),
        groups: (*groups).to_owned(),
        gap: gap.parse().ok()?,
        description: (*description).to_owned(),
        end: match refused.is_empty() {
            false => End::Refused((*refused).to_owned()),
            true => End::Compared {
                comparisons: Vec::new(),
                dofs: dofs.parse().ok()?,
                seconds: seconds.parse().ok()?,
            },
        },
    };
    Some((case, comparison))
}

impl Comparison {
    /// Whether the exact value is not exact enough to measure an error.
    pub fn is_dropped(&self) -> bool {
        self.exact_bar > INEXACT * self.uncorrected.min(self.corrected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_read_as_it_was_written_up_to_an_incomplete_line() {
        let comparison = |name: &str, bar: Option<f64>| Comparison {
            name: name.to_owned(),
            scale: 0.5,
            uncorrected: 2e-3,
            corrected: 1e-4,
            bar,
            beside_mesh: 0.0,
            estimate: 1.9e-3,
            effectivity: 0.95,
            exact_bar: 1e-6,
        };
        let case = |seed: u64, end: End| Case {
            kind: "instant".to_owned(),
            seed,
            model: "fem".to_owned(),
            groups: "all ball gap below 0.2".to_owned(),
            gap: 0.125,
            description: "radii 1 2".to_owned(),
            end,
        };
        let comparisons = vec![
            comparison("velocity", Some(3e-4)),
            comparison("torque", None),
        ];
        let compared = End::Compared {
            comparisons,
            dofs: 1000,
            seconds: 1.5,
        };
        let cases = [case(7, compared), case(8, End::Refused("no".to_owned()))];
        let lines: String = cases.iter().map(Case::csv).collect();
        let whole = Case::CSV_HEAD.to_owned() + &lines;
        let found = read(&(whole.clone() + "instant,9,fem,all"));
        let again: String = found.iter().map(Case::csv).collect();
        assert_eq!(Case::CSV_HEAD.to_owned() + &again, whole);
        assert_eq!((found.len(), found[0].comparisons().count()), (2, 2));
        let groups = ["all", "ball", "gap below 0.2", "al", "gap below 0"];
        assert_eq!(
            groups.map(|group| found[0].is_in(group)),
            [true, true, true, false, false]
        );
    }
}
