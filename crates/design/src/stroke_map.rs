//! The map of a scene: the table over its shapes, what small strokes yield, and its gait.

use models::TablePart;
use nalgebra::Vector6;
use scene::Scene;
use serde_json::{Value, json};
use swimmer::Folder;

use crate::design_stroke::{gait_shapes, gait_totals};
use crate::error::{DesignError, DesignProgress};
use crate::limits::StrokeLimits;
use crate::table::{StrokeTable, tabulate};
use crate::totals::StrokeTotals;

/// Relative error of the table.
const TOLERANCE: f64 = 1e-6;

/// Connection, curvature and metric over the shapes of a scene.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct StrokeMap {
    /// The table.
    pub table: StrokeTable,
    /// Names of the joints that move.
    pub names: Vec<String>,
    /// The shape in the middle of the limits.
    pub middle: Vec<f64>,
    /// Numbers of two joints each, with the curvature there: displacement and rotation vector of
    /// the frame per area of a small closed stroke in the plane of their values.
    pub curvature: Vec<(usize, usize, Vector6<f64>)>,
    /// Shapes along one cycle of the gait; empty without a gait that closes.
    pub stroke: Vec<Vec<f64>>,
    /// Totals of that cycle by the table, and its energy times period at constant power; none for a
    /// gait that does not close or that leaves the table.
    pub gait: Option<(StrokeTotals, f64)>,
}

/// Computes the map of a scene over its limits, `optimise.lower` and `optimise.upper`; its table is
/// stored in the folder, if there is one, as by [`tabulate`].
///
/// # Errors
/// Those of [`tabulate`]; limits that do not fit the scene.
pub fn stroke_map(
    scene: &Scene,
    place: (Option<&Folder>, TablePart),
    progress: &mut dyn DesignProgress,
) -> Result<StrokeMap, DesignError> {
    let limits = StrokeLimits::from_scene(scene)?;
    let table = tabulate(scene, &limits, TOLERANCE, place, progress)?;
    let geometry = &table.geometry;
    let middle = geometry.ranges().iter().map(|r| 0.5 * (r.0 + r.1));
    let middle: Vec<f64> = middle.collect();
    let local = geometry.at(&middle)?;
    let curvature = pairs(middle.len())
        .map(|(a, b)| (a, b, local.curvature(a, b)))
        .collect();
    Ok(StrokeMap {
        names: limits.joint_names(scene),
        middle,
        curvature,
        stroke: gait_shapes(scene, &limits)?,
        gait: gait_totals(scene, &limits, geometry)?,
        table,
    })
}

/// All pairs of two numbers below `count`, the smaller one first.
fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |first| (first + 1..count).map(move |second| (first, second)))
}

impl StrokeMap {
    /// The map as `swim map --json` prints it.
    pub fn json(&self) -> Value {
        let geometry = &self.table.geometry;
        let names = &self.names;
        let (interpolation, model) = geometry.errors();
        let squares: Vec<Value> = (self.curvature.iter())
            .map(|(a, b, c)| json!({ "links": [names[*a], names[*b]], "curvature": c.as_slice() }))
            .collect();
        json!({
            "model": self.table.model,
            "links": names,
            "ranges": geometry.ranges(),
            "degrees": geometry.degrees(),
            "points": geometry.points(),
            "error_estimate": {
                "interpolation": interpolation,
                "model": model,
                "position": geometry.position_error(),
            },
            "middle": self.middle,
            "curvature": squares,
            "gait": self.gait.as_ref().map(|(totals, product)| json!({
                "displacement": totals.displacement.as_slice(),
                "rotation": totals.rotation.as_slice(),
                "period_energy_product": product,
            })),
        })
    }
}
