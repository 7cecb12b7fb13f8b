//! What the program says of its own errors, beside the true ones.

use swimmer::models::{AccumulatedError, ErrorEstimate, InstantaneousSolution};

use super::table::Row;

/// What came with a value about its error, in the value's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimated {
    /// Computed less exact, where it is known with its sign.
    pub error: Option<f64>,
    /// The error bar.
    pub bar: f64,
    /// A smaller error than this is an accident that no estimate can see: three times the algebraic bar, or what the estimate says it may
    /// err by itself.
    pub floor: f64,
}

/// What the estimates' ratio to the true errors shall be.
pub const WINDOW: std::ops::Range<f64> = 0.7..1.4;

/// What a true error must be in algebraic bars to be one of the method.
const ALGEBRAIC: f64 = 3.0;

impl Estimated {
    /// That of a body's velocity along x.
    pub fn velocity(instant: &InstantaneousSolution, body: usize) -> Self {
        let error = instant.mesh_error.as_ref();
        Self::new(
            error.map(|e| (e.bodies[body].x, e.uncertainty)),
            &instant.error_estimate,
        )
    }

    /// That of a body's force along x; none where nobody knows.
    pub fn force(instant: &InstantaneousSolution, body: usize) -> Option<Self> {
        let errors = instant.mesh_error.as_ref()?;
        Some(Self::signed(errors.forces.get(body)?.x))
    }

    /// That of a displacement along x of a body without turns.
    pub fn displacement(drift: Option<&AccumulatedError>, bars: &ErrorEstimate) -> Self {
        Self::new(drift.map(|d| (d.displacement[0].x, d.uncertainty)), bars)
    }

    fn new(by_mesh: Option<(f64, f64)>, bars: &ErrorEstimate) -> Self {
        let algebraic = ALGEBRAIC * bars.algebraic.unwrap_or(0.0);
        let (error, spread) = by_mesh.unzip();
        Self {
            error,
            bar: bars.total(),
            floor: algebraic.max(spread.unwrap_or(0.0)),
        }
    }

    /// A bar that is meant as a bound.
    pub fn bound(bar: f64) -> Self {
        Self {
            error: None,
            bar,
            floor: 0.0,
        }
    }

    /// An error that is known with its sign and nothing besides.
    pub fn signed(error: f64) -> Self {
        Self {
            error: Some(error),
            bar: error.abs(),
            floor: 0.0,
        }
    }

    /// That of another value with this derivative.
    pub fn times(self, derivative: f64) -> Self {
        Self {
            error: self.error.map(|error| derivative * error),
            bar: derivative.abs() * self.bar,
            floor: derivative.abs() * self.floor,
        }
    }
}

impl Row {
    /// The error bar over the scale of the row's error.
    pub fn bar(&self) -> Option<f64> {
        Some(self.estimated?.bar / self.scale.abs())
    }

    /// Estimated over true error, the effectivity, and whether the true error is large enough for it to mean something.
    pub fn effectivity(&self) -> Option<(f64, bool)> {
        let estimated = self.estimated?;
        let error = (self.computed - self.exact).abs();
        Some((estimated.bar / error, error > estimated.floor))
    }

    /// The value less its estimated error, and by what factor that is nearer to the exact one.
    pub fn corrected(&self) -> Option<(f64, f64)> {
        let corrected = self.computed - self.estimated?.error?;
        let gain = (self.computed - self.exact).abs() / (corrected - self.exact).abs();
        Some((corrected, gain))
    }
}

/// How the estimates of all rows did, in words: the rule, the rows outside the window, and bounds apart.
pub fn notes(rows: &[Row]) -> Vec<String> {
    let meaningful = rows.iter().filter_map(|row| {
        let (ratio, means) = row.effectivity()?;
        means.then_some((row, ratio))
    });
    let (judged, bounds): (Vec<_>, Vec<_>) =
        meaningful.partition(|(row, _)| row.corrected().is_some());
    let estimated = rows.iter().filter(|row| row.estimated.is_some()).count();
    let outside: Vec<String> = judged
        .iter()
        .filter(|(_, e)| !WINDOW.contains(e))
        .map(|(row, e)| format!("{} {}, {e:.2}", row.group, row.name))
        .collect();
    let mut notes = vec![format!(
        "estimated: the error bar that came with the value, on the scale of the error; ratio: estimated over true error, in brackets where the true \
         error is below three algebraic bars or below what the estimate says that it may err by itself (its spread): such errors are accidents, a few \
         signs of cells that cancel. corrected: the value less its estimated error; gain: by how much it is nearer to the exact one. {estimated} rows \
         have an estimate; of errors with a sign {} ratios are not in brackets, {} of them between {} and {}.",
        judged.len(),
        judged.len() - outside.len(),
        WINDOW.start,
        WINDOW.end,
    )];
    if !outside.is_empty() {
        notes.push(format!("Ratios outside: {}.", outside.join("; ")));
    }
    if let Some(largest) = bounds.iter().map(|(_, e)| *e).reduce(f64::max) {
        let smallest = bounds.iter().fold(largest, |m, (_, e)| m.min(*e));
        notes.push(format!(
            "Bars without a sign are meant as bounds: {} ratios from {smallest:.2} to {largest:.2}.",
            bounds.len()
        ));
    }
    notes
}

/// Panics unless the row's estimate means something and is within the window.
#[cfg(test)]
pub fn assert_effective(row: &Row) {
    let ratio = row.effectivity();
    assert!(
        ratio.is_some_and(|(ratio, means)| means && WINDOW.contains(&ratio)),
        "{}: error {:.3e}, ratio {ratio:?}",
        row.name,
        row.error
    );
}

#[cfg(test)]
mod tests {
    use super::super::table::{Basis, Cost};
    use super::*;

    fn row(estimated: Estimated) -> Row {
        Row::scaled(
            "A",
            "drag",
            [2.0, 2.1],
            4.0,
            (1.0, Basis::Order),
            Cost::default(),
        )
        .with(Some(estimated))
    }

    #[test]
    fn a_row_with_an_estimate_has_ratio_and_gain() {
        let row = row(Estimated::signed(0.08));
        let (ratio, means) = row.effectivity().expect("there is one");
        assert!((ratio - 0.8).abs() < 1e-12 && means);
        assert!((row.bar().expect("there is one") - 0.02).abs() < 1e-12);
        let (corrected, gain) = row.corrected().expect("there is one");
        assert!((corrected - 2.02).abs() < 1e-12 && (gain - 5.0).abs() < 1e-9);
        assert_eq!(notes(&[row]).len(), 1);
    }

    #[test]
    fn errors_below_the_floor_are_not_judged_and_bars_off_the_window_are_told() {
        let accident = row(Estimated {
            error: None,
            bar: 0.5,
            floor: 0.2,
        });
        assert_eq!(accident.effectivity().map(|(_, means)| means), Some(false));
        assert_eq!(accident.corrected(), None);
        assert_eq!(notes(std::slice::from_ref(&accident)).len(), 1);
        let bound = Estimated {
            floor: 0.0,
            ..accident.estimated.expect("it has one")
        };
        assert!(notes(&[row(bound)])[1].contains("1 ratios from 5.00 to 5.00"));
        let wide = row(Estimated::signed(0.5));
        assert!(notes(&[wide])[1].contains("A drag, 5.00"));
    }

    #[test]
    fn derivatives_turn_signs_and_not_bars() {
        let estimated = Estimated::signed(0.1).times(-2.0);
        assert_eq!((estimated.error, estimated.bar), (Some(-0.2), 0.2));
    }
}
