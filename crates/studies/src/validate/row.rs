//! Rows of the validation: a computed value, the exact one, and what the program says about its
//! error.

use swimmer::models::{AccumulatedError, ErrorEstimate, InstantaneousSolution};

/// Largest error of a single row, in error bars.
///
/// A bar covers 95 of 100 errors, so some rows of a long table are outside; twice the bar covers
/// all.
pub const MAX_ERROR_IN_BARS: f64 = 2.0;

/// Cost of a row.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    pub dofs: usize,
    /// Largest number of iterations of a solve.
    pub iterations: usize,
    pub seconds: f64,
}

impl Cost {
    pub fn new(solution: &InstantaneousSolution) -> Self {
        Self {
            dofs: solution.dofs.total,
            iterations: solution.solver.iterations,
            seconds: solution.seconds.total,
        }
    }

    /// Adds another solve: sizes do not add up, seconds do.
    pub fn add(&mut self, other: &Self) {
        self.dofs = self.dofs.max(other.dofs);
        self.iterations = self.iterations.max(other.iterations);
        self.seconds += other.seconds;
    }
}

/// What the program says about the error of a value, in the unit of the value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimated {
    /// Estimated discretisation error that was subtracted, computed minus exact; `None` for methods
    /// without a correction.
    pub removed: Option<f64>,
    /// Error bar of the value.
    pub bar: f64,
}

impl Estimated {
    /// Estimate for the velocity of a body along x.
    pub fn velocity(solution: &InstantaneousSolution, body: usize) -> Self {
        let error = solution.mesh_error.as_ref();
        Self {
            removed: error.map(|error| error.bodies[body].velocity.x),
            bar: solution.error_estimate.total(),
        }
    }

    /// Estimate for the angular velocity of a body about z, if there is one.
    ///
    /// Its bar is the relative uncertainty of the correction, as for forces.
    pub fn angular_velocity(solution: &InstantaneousSolution, body: usize) -> Option<Self> {
        let error = solution.mesh_error.as_ref()?;
        let removed = error.bodies.get(body)?.angular_velocity.z;
        Some(Self {
            removed: Some(removed),
            bar: error.uncertainty.relative * removed.abs(),
        })
    }

    /// Estimate for the force of a body along x, if there is one.
    pub fn force(solution: &InstantaneousSolution, body: usize) -> Option<Self> {
        let error = solution.mesh_error.as_ref()?;
        Some(Self {
            removed: Some(error.bodies.get(body)?.force.x),
            bar: error.force_error_bar(),
        })
    }

    /// Estimate for the displacement along x of the first body, which does not rotate.
    pub fn displacement(accumulated: Option<&AccumulatedError>, bars: &ErrorEstimate) -> Self {
        Self {
            removed: accumulated.map(|sum| sum.displacement[0].x),
            bar: bars.total(),
        }
    }

    /// Error bar of a value that was not corrected.
    pub fn bound(bar: f64) -> Self {
        Self { removed: None, bar }
    }

    /// Estimate for a function of the value with this derivative.
    pub fn times(self, derivative: f64) -> Self {
        Self {
            removed: self.removed.map(|removed| derivative * removed),
            bar: derivative.abs() * self.bar,
        }
    }
}

/// A computed value and the exact one.
#[derive(Clone, Debug)]
pub struct Row {
    /// Key of the reference: `A` to `K`, or the name of a method's property.
    pub group: &'static str,
    pub name: String,
    pub exact: f64,
    /// Uncertainty of the exact value, relative to the scale.
    pub exact_bar: f64,
    pub computed: f64,
    /// Value to which the error is relative.
    pub scale: f64,
    /// Computed minus exact, over the scale.
    pub error: f64,
    pub tolerance: f64,
    /// Source of the tolerance.
    pub basis: Basis,
    pub estimated: Option<Estimated>,
    pub cost: Cost,
}

/// Source of a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    Interpolation,
    Halving,
    Order,
    Required,
    Facets,
    Promised,
    Limit,
}

/// All sources of tolerances with their footnotes, in the order of their letters `a`, `b`, ...
pub const BASES: [(Basis, &str); 7] = [
    (
        Basis::Interpolation,
        "bound of the uncorrected error: twice the energy of the interpolation error of the exact flow around one sphere, on a mesh of \
         the same sizes around this sphere alone; errors of matrix entries are relative to the largest entry",
    ),
    (
        Basis::Halving,
        "a third of the change from the mesh of twice the surface size, which is the remaining error at second order or better; in addition, as \
         in (a), the error of the lubrication flow in the gap, whose elements do not depend on that size",
    ),
    (
        Basis::Order,
        "theory: 4 curved, at least 3.3 before the asymptotic range; 2 straight, by geometry; corrected between 6, \
         that of cubic elements, and 4, that of the percent of the correction that its iterative solve leaves (absolute difference)",
    ),
    (
        Basis::Required,
        "required: with default settings 1e-3 for a step of the stroke and hence for speeds, 6e-4 for the net displacement; \
         at surface size 0.2 and on the mesh file 1e-4 for speeds, on the mesh file 1e-3 for forces; 1e-3 for bodies of other shapes",
    ),
    (
        Basis::Facets,
        "bound of the uncorrected error: twice the difference between the radius of the sphere and that of the ball with the volume inside the \
         flat facets",
    ),
    (
        Basis::Promised,
        "the tolerance given to the model: 1e-6 of the largest entry of a resistance matrix, 2e-5 of the net displacement of a stroke, for \
         which resistances, and hence forces and speeds, are computed to 1e-6",
    ),
    (
        Basis::Limit,
        "disk: half the difference between the drags of the spheroids inside and around it; torus: order of the error of the slender limit",
    ),
];

impl Basis {
    /// Letter of the footnote.
    pub fn letter(self) -> char {
        char::from(b'a' + self as u8)
    }
}

impl Row {
    /// Row of a value whose error is relative to the exact value.
    pub fn relative(
        group: &'static str,
        name: impl Into<String>,
        [exact, computed]: [f64; 2],
        tolerance: (f64, Basis),
        cost: Cost,
    ) -> Self {
        Self::scaled(group, name, [exact, computed], exact, tolerance, cost)
    }

    /// Row of a value whose error is relative to `scale`.
    pub fn scaled(
        group: &'static str,
        name: impl Into<String>,
        [exact, computed]: [f64; 2],
        scale: f64,
        (tolerance, basis): (f64, Basis),
        cost: Cost,
    ) -> Self {
        Self {
            group,
            name: name.into(),
            exact,
            exact_bar: 0.0,
            computed,
            scale,
            error: (computed - exact) / scale.abs(),
            tolerance,
            basis,
            estimated: None,
            cost,
        }
    }

    /// The row with an error estimate.
    pub fn with(self, estimated: impl Into<Option<Estimated>>) -> Self {
        let estimated = estimated.into();
        Self { estimated, ..self }
    }

    /// The row with an exact value that is uncertain, relative to the scale.
    pub fn with_exact_bar(self, exact_bar: f64) -> Self {
        Self { exact_bar, ..self }
    }

    /// The row with values in multiples of `unit`.
    pub fn in_units_of(self, unit: f64) -> Self {
        Self {
            exact: self.exact / unit,
            computed: self.computed / unit,
            scale: self.scale / unit,
            estimated: self.estimated.map(|own| own.times(1.0 / unit)),
            ..self
        }
    }

    /// Whether the error is within the tolerance and within [`MAX_ERROR_IN_BARS`]; never for NaN.
    pub fn passes(&self) -> bool {
        let holds = |bars: f64| bars <= MAX_ERROR_IN_BARS;
        self.error.abs() <= self.tolerance && self.error_in_bars().is_none_or(holds)
    }

    /// Error bar, relative to the scale of the row.
    pub fn bar(&self) -> Option<f64> {
        Some(self.estimated?.bar / self.scale.abs())
    }

    /// Error over the error bars of the computed and the exact value.
    pub fn error_in_bars(&self) -> Option<f64> {
        Some(self.error.abs() / (self.bar()? + self.exact_bar))
    }

    /// Error of the value before its correction, relative to the scale of the row.
    pub fn uncorrected_error(&self) -> Option<f64> {
        Some(self.error + self.estimated?.removed? / self.scale.abs())
    }

    /// Factor by which the correction reduced the error.
    pub fn gain(&self) -> Option<f64> {
        Some((self.uncorrected_error()? / self.error).abs())
    }
}

/// Panics unless the correction of a row is significant and its error bar holds.
///
/// The uncorrected error is above the bar; the error is within [`MAX_ERROR_IN_BARS`]; and it is
/// within one bar or below a quarter of the uncorrected error. Of the error of a single sphere,
/// curved elements of half a radius, the coarsest in the tests, leave 4 percent
/// (`stokes::estimate`). Where the errors of several bodies cancel, what is left of them need not,
/// hence the larger fraction.
#[cfg(test)]
pub fn assert_corrected(row: &Row) {
    const LEAST_GAIN: f64 = 4.0;
    let Some((bars, (uncorrected, bar))) = row
        .error_in_bars()
        .zip(row.uncorrected_error().zip(row.bar()))
    else {
        panic!("{}: no correction or no error bar", row.name);
    };
    let error = row.error.abs();
    assert!(
        uncorrected.abs() > bar
            && bars <= MAX_ERROR_IN_BARS
            && (bars <= 1.0 || LEAST_GAIN * error <= uncorrected.abs()),
        "{}: error {error:.3e}, bar {bar:.3e}, uncorrected {uncorrected:.3e}",
        row.name,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row with an error of 0.1, or 0.025 of its scale, and a correction of 0.4.
    fn corrected(bar: f64) -> Row {
        let values = [2.0, 2.1];
        let tolerance = (1.0, Basis::Order);
        Row::scaled("A", "drag", values, 4.0, tolerance, Cost::default()).with(Estimated {
            removed: Some(0.4),
            bar,
        })
    }

    #[test]
    fn a_corrected_row_has_a_bar_and_a_gain() {
        let row = corrected(0.08);
        assert!((row.bar().unwrap() - 0.02).abs() < 1e-12);
        assert!((row.error_in_bars().unwrap() - 1.25).abs() < 1e-12);
        assert!((row.uncorrected_error().unwrap() - 0.125).abs() < 1e-12);
        assert!((row.gain().unwrap() - 5.0).abs() < 1e-9);
        assert_corrected(&row);
    }

    #[test]
    fn errors_above_two_bars_fail_whatever_the_tolerance_and_nan_fails() {
        assert!(corrected(0.051).passes());
        assert!(!corrected(0.049).passes());
        assert!(!corrected(f64::NAN).passes());
        let tolerance = (1e-2, Basis::Interpolation);
        let row = |computed| Row::relative("A", "", [2.0, computed], tolerance, Cost::default());
        let passes = [2.01, 2.03, 1.97, f64::NAN].map(|computed| row(computed).passes());
        assert_eq!(passes, [true, false, false, false]);
    }

    #[test]
    #[should_panic(expected = "uncorrected")]
    fn a_correction_below_its_bar_shows_nothing() {
        assert_corrected(&corrected(0.6));
    }

    #[test]
    fn derivatives_change_the_sign_of_errors_but_not_of_bars() {
        let estimated = corrected(0.01).estimated.unwrap().times(-2.0);
        assert_eq!((estimated.removed, estimated.bar), (Some(-0.8), 0.02));
    }
}
