//! Bounds of linear functions in the interior-point method: distances from them, and multipliers.

use nalgebra::DVector;

/// Fraction-to-boundary parameter: largest part of the distance to a bound that a step takes.
const TO_BOUND: f64 = 0.995;

/// Bounds of the rows, without their offset; infinite ones do not count.
pub struct Bounds {
    /// Lower bounds.
    pub lower: DVector<f64>,
    /// Upper bounds.
    pub upper: DVector<f64>,
}

/// Distances from the bounds.
pub struct Slacks {
    pub lower: DVector<f64>,
    pub upper: DVector<f64>,
}

/// Multipliers of the bounds.
pub struct Multipliers {
    pub lower: DVector<f64>,
    pub upper: DVector<f64>,
}

impl Slacks {
    /// None unless the rows are strictly inside the bounds.
    pub fn new(rows: &DVector<f64>, bounds: &Bounds) -> Option<Self> {
        let slacks = Self {
            lower: rows - &bounds.lower,
            upper: &bounds.upper - rows,
        };
        let is_inside = |s: &DVector<f64>| s.iter().all(|s| *s > 0.0);
        (is_inside(&slacks.lower) && is_inside(&slacks.upper)).then_some(slacks)
    }

    /// Sum of the logarithms.
    pub fn logarithms(&self) -> f64 {
        let all = self.lower.iter().chain(self.upper.iter());
        all.filter(|s| s.is_finite()).map(|s| s.ln()).sum()
    }

    /// Multipliers on the central path.
    pub fn multipliers(&self, barrier: f64) -> Multipliers {
        Multipliers {
            lower: self.lower.map(|s| barrier / s),
            upper: self.upper.map(|s| barrier / s),
        }
    }

    /// Longest step, of at most one, that stays inside the bounds.
    pub fn longest(&self, change: &DVector<f64>) -> f64 {
        let lower = self.lower.iter().zip(change.iter().map(|c| -c));
        let upper = self.upper.iter().zip(change.iter().copied());
        lower
            .chain(upper)
            .fold(1.0_f64, |longest, (s, c)| match c > 0.0 {
                true => longest.min(TO_BOUND * s / c),
                false => longest,
            })
    }

    /// Smallest distance from a bound, relative to the distance of both bounds of the row; of rows
    /// with two finite bounds.
    pub fn smallest_share(&self) -> f64 {
        let pairs = self.lower.iter().zip(self.upper.iter());
        let finite = pairs.filter(|(a, b)| a.is_finite() && b.is_finite());
        let shares = finite.map(|(a, b)| a.min(*b) / (a + b));
        shares.fold(f64::INFINITY, f64::min)
    }
}

impl Multipliers {
    /// Newton's step of the multipliers, kept near the central path.
    pub fn moved(&self, old: &Slacks, new: &Slacks, change: &DVector<f64>, barrier: f64) -> Self {
        // Multipliers may leave the central path by this factor (Waechter & Biegler 2006).
        const FREEDOM: f64 = 1e10;
        let moved = |z: &DVector<f64>, s: &DVector<f64>, new: &DVector<f64>, sign: f64| {
            let raw = DVector::from_fn(z.len(), |k, _| {
                barrier / s[k] - z[k] - z[k] / s[k] * sign * change[k]
            });
            let longest = (z.iter().zip(&raw)).fold(1.0_f64, |longest, (z, d)| match *d < 0.0 {
                true => longest.min(-TO_BOUND * z / d),
                false => longest,
            });
            DVector::from_fn(z.len(), |k, _| {
                let centre = barrier / new[k];
                (z[k] + longest * raw[k]).clamp(centre / FREEDOM, centre * FREEDOM)
            })
        };
        Self {
            lower: moved(&self.lower, &old.lower, &new.lower, 1.0),
            upper: moved(&self.upper, &old.upper, &new.upper, -1.0),
        }
    }
}
