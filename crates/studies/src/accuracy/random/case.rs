//! A random case with its errors, or the reason for which it was refused.

use std::fmt::Write;

use super::quantity::Comparison;

/// Error bar of the exact value, over the smaller one of the errors measured with it, above which
/// the comparison is dropped.
const INEXACT: f64 = 0.05;

/// A case and what became of it.
pub struct Case {
    /// `instant` or `stroke`.
    pub kind: &'static str,
    /// The seed from which it is drawn again.
    pub seed: u64,
    pub model: &'static str,
    /// Names of the groups that it belongs to.
    pub groups: Vec<&'static str>,
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
            self.kind,
            self.seed,
            self.model,
            self.groups.join(" "),
            self.gap
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

impl Comparison {
    /// Whether the exact value is not exact enough to measure an error.
    pub fn is_dropped(&self) -> bool {
        self.exact_bar > INEXACT * self.uncorrected.min(self.corrected)
    }
}
