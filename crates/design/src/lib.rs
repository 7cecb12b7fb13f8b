#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

/// Methods that set a public field each and return the struct.
macro_rules! setters {
    ($type:ident { $($set:ident($field:ident: $value:ty),)* }) => {
        impl $type {
            $(
                #[doc = concat!("Sets [`", stringify!($field), "`](Self::", stringify!($field), ").")]
                #[must_use]
                pub fn $set(mut self, $field: $value) -> Self {
                    self.$field = $field;
                    self
                }
            )*
        }
    };
}

mod best_frequency;
mod best_wave;
mod connection;
mod design_stroke;
mod error;
mod evaluation;
mod farthest;
mod interior_point;
pub mod learn;
mod limits;
mod objective;
mod optimise;
mod optimum_scene;
mod quadrature;
mod search;
pub mod sensitivities;
mod sizes;
mod speed;
mod starts;
mod stroke_map;
mod stroke_path;
mod sweep;
mod swept_points;
mod table;
mod timing;
mod totals;

pub use best_frequency::{BestFrequency, FrequencyRun, best_frequency};
pub use best_wave::{BestWave, WaveVariable, best_wave, wave_variables};
pub use connection::{Connection, connection};
pub use design_stroke::{DesignedStroke, design_stroke, gait_shapes, gait_totals, objective_of};
pub use error::{DesignError, DesignProgress};
pub use farthest::farthest;
pub use limits::StrokeLimits;
pub use objective::{
    DisplacementMeasure, HighestEfficiency, LeastEnergy, LeastEnergyRotation, Objective,
    check_objective,
};
pub use optimise::{Optimum, SearchOptions, optimise};
pub use sizes::{BestSizes, SizeRun, SizeSlice, best_sizes, size_slices};
pub use speed::fastest_stroke;
pub use starts::small_stroke_cost;
pub use stroke_map::{StrokeMap, stroke_map};
pub use stroke_path::{SampledPath, Series, StrokeCurve};
pub use sweep::{Sweep, SweepOptions, SweepResult, SweepRow, require_sweep, sweep};
pub use swept_points::{RandomPoints, Values, VariedKey, sweep_points};
pub use table::{StrokeTable, tabulate};
pub use timing::{MotionBounds, Peaks, Timing};
pub use totals::{Stroke, StrokeTotals};

/// Scenes, models and runs, whose types are part of the interface.
pub use swimmer;
