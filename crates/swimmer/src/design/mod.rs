//! Design of strokes: tables over shapes, optimal strokes, learned strokes.
//!
//! Without inertia a stroke is a closed curve of shapes. A [`models::ShapeGeometry`] gives the
//! connection `A` and the dissipation metric `G` over a box of shapes; displacement, rotation and
//! energy of any curve then are line integrals, with exact derivatives ([`Stroke`]).
//!
//! - [`optimise()`]: the curve that is best for an [`Objective`], inside limits.
//! - [`fastest_stroke`]: the curve of the largest displacement per time, within bounds on rates and
//!   power.
//! - [`best_sizes`]: the radii and arm lengths that are best for a gait.
//! - [`learn`]: what reinforcement learning finds on the shapes whose joints are contracted or
//!   extended, and the exact optimum there.

mod bounds;
mod design_stroke;
mod efficiency;
mod evaluation;
mod farthest;
mod interior_point;
pub mod learn;
mod limits;
mod objective;
mod optimise;
mod optimum_scene;
mod progress;
mod quadrature;
mod search;
mod sizes;
mod speed;
mod starts;
mod stroke_path;
mod table;
mod timing;
mod totals;

pub use design_stroke::{DesignedStroke, design_stroke, gait_shapes, gait_totals, objective_of};
pub use farthest::farthest;
pub use limits::StrokeLimits;
pub use objective::{
    DisplacementMeasure, HighestEfficiency, LeastEnergy, LeastEnergyRotation, Objective,
    WithDerivatives,
};
pub use optimise::{Optimum, SearchOptions, optimise};
pub use progress::DesignProgress;
pub use sizes::{BestSizes, SizeRun, SizeSlice, best_sizes, size_slices};
pub use speed::fastest_stroke;
pub use starts::small_stroke_cost;
pub use stroke_path::{SampledPath, Series, StrokeCurve};
pub use table::{StrokeTable, tabulate};
pub use timing::{MotionBounds, Peaks, Timing};
pub use totals::{Stroke, StrokeTotals};
