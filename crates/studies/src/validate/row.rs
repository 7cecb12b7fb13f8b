//! Rows of the validation: a computed value beside the exact one.

use swimmer::models::InstantaneousSolution;

use super::bars;
use super::estimated::Estimated;

/// Cost of a row.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    pub dofs: usize,
    /// Largest number of iterations of a solve.
    pub iterations: usize,
    pub seconds: f64,
}

impl Cost {
    pub fn of(solution: &InstantaneousSolution) -> Self {
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

/// A computed value beside the exact one.
#[derive(Clone, Debug)]
pub struct Row {
    /// Key of the reference: `A` to `K`, or the name of a method's property.
    pub group: &'static str,
    pub name: String,
    pub exact: f64,
    /// What is uncertain about the exact value, relative to the scale.
    pub exact_bar: f64,
    pub computed: f64,
    /// Value to which the error is relative.
    pub scale: f64,
    /// Computed minus exact, over the scale.
    pub error: f64,
    pub tolerance: f64,
    /// Source of the tolerance.
    pub basis: Basis,
    /// What the program says about the error of the value.
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
    Flat,
    Promised,
    Limit,
}

impl Basis {
    /// All sources of tolerances, in the order of the footnotes.
    pub const ALL: [Self; 7] = [
        Self::Interpolation,
        Self::Halving,
        Self::Order,
        Self::Required,
        Self::Flat,
        Self::Promised,
        Self::Limit,
    ];

    /// Letter in the table.
    pub fn mark(self) -> char {
        match self {
            Self::Interpolation => 'a',
            Self::Halving => 'b',
            Self::Order => 'c',
            Self::Required => 'd',
            Self::Flat => 'e',
            Self::Promised => 'f',
            Self::Limit => 'g',
        }
    }

    /// Text of the footnote.
    pub fn note(self) -> &'static str {
        match self {
            Self::Interpolation => {
                "bound of the uncorrected error: twice the energy of the interpolation error of the exact flow around one sphere, on a mesh of \
                 the same sizes around this sphere alone; errors of matrix entries are relative to the largest entry"
            }
            Self::Halving => {
                "a third of the change from the mesh of twice the surface size, which is the remaining error at second order or better; in addition, as \
                 in (a), the error of the lubrication flow in the gap, whose elements do not depend on that size"
            }
            Self::Order => {
                "theory: 4 curved, at least 3.3 before the asymptotic range; 2 straight, by geometry; corrected between 6, \
                 that of cubic elements, and 4, that of the percent of the correction that its iterative solve leaves (absolute difference)"
            }
            Self::Required => {
                "required: with default settings 1e-3 for a step of the stroke and hence for speeds, 6e-4 for the net displacement; \
                 at surface size 0.2 and on the mesh file 1e-4 for speeds, on the mesh file 1e-3 for forces; 1e-3 for bodies of other shapes"
            }
            Self::Flat => {
                "bound of the uncorrected error: twice the difference between the radius of the sphere and that of the ball with the volume inside the \
                 flat facets"
            }
            Self::Promised => {
                "the tolerance given to the model: 1e-6 of the largest entry of a resistance matrix, 2e-5 of the net displacement of a stroke, for \
                 which resistances, and hence forces and speeds, are computed to 1e-6"
            }
            Self::Limit => {
                "disk: half the difference between the drags of the spheroids inside and around it; torus: order of the error of the slender limit"
            }
        }
    }
}

impl Row {
    /// Row of a value whose error is relative to the exact value.
    pub fn relative(
        group: &'static str,
        name: impl Into<String>,
        [exact, computed]: [f64; 2],
        (tolerance, basis): (f64, Basis),
        cost: Cost,
    ) -> Self {
        Self::scaled(
            group,
            name,
            [exact, computed],
            exact,
            (tolerance, basis),
            cost,
        )
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
    pub fn with(self, estimated: Option<Estimated>) -> Self {
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

    /// Whether the error is within the tolerance and within [`bars::LARGEST`] error bars; never for
    /// NaN.
    pub fn passes(&self) -> bool {
        let holds = |bars: f64| bars <= bars::LARGEST;
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
