//! The numbers that the scripts draw, as JSON.

use std::collections::BTreeSet;

use mesh::SurfaceMesh;
use nalgebra::Isometry3;
use rayon::prelude::*;
use scene::{Scene, Shape};
use serde_json::{Value, json};

use super::inertia;
use super::record::RunRecord;
use super::track::Track;
use crate::error::PictureError;
use crate::flow_slice::{SliceFrame, body_surface, section, streamlines, wall_lines};
use crate::flow_slices::StoredSlice;
use crate::packed;
use crate::plot::{Quantity, body_colour, nearest_in_time};

/// Distance of streamlines relative to the width of the window.
const LINE_DISTANCE: f64 = 0.03;

/// Stride at which points of a streamline are kept: one per grid cell. Both ends are kept too.
const STRIDE: usize = 3;

/// Largest number of phases with labels; with more phases none has a label.
const MAX_LABELS: usize = 12;

/// Largest number of curves in a plot: more cannot be told apart, and each has a name.
const MAX_CURVES: usize = 24;

/// All data of the page.
///
/// Arrays are base64 (`packed.rs`). `meshes` have `Float32Array` points and `Uint32Array`
/// triangles; `poses` have seven `Float32Array` numbers per time and body (position, and quaternion
/// x, y, z, w); `values` of plots are one `Float32Array` each.
pub fn page_data(record: &RunRecord) -> Result<Value, PictureError> {
    let scene = &record.scene;
    let track = Track::new(record)?;
    let shapes = distinct_shapes(scene);
    let surfaces: Vec<Option<SurfaceMesh>> = shapes.iter().map(|s| body_surface(s)).collect();
    let number_of = |shape: &Shape| shapes.iter().position(|known| *known == shape);
    let bodies: Vec<Value> = (scene.bodies().iter().enumerate())
        .map(|(k, body)| {
            json!({
                "name": body.name,
                "mesh": number_of(&body.shape).filter(|&k| surfaces[k].is_some()),
                "colour": body_colour(k),
            })
        })
        .collect();
    let poses = track.positions.iter().zip(&track.rotations);
    let poses = poses.flat_map(|(positions, rotations)| {
        positions.iter().zip(rotations).flat_map(|(x, turn)| {
            let q = turn.coords;
            [x.x, x.y, x.z, q.x, q.y, q.z, q.w]
        })
    });
    let values = scene.articulation().initial_shape();
    let view = SliceFrame::from_scene(scene)?.around(scene, values, &start_poses(record));
    let joints = scene.articulation().joints().iter();
    let slices: Vec<Value> = (record.slices.slices.par_iter())
        .filter_map(|stored| slice(record, &shapes, &surfaces, stored))
        .collect();
    Ok(json!({
        "duration": track.times.last(),
        "cycle": scene.gait().cycle_duration(),
        "cycles": { "shown": track.cycles, "all": scene.gait().cycles },
        "bodies": bodies,
        "links": joints.map(|joint| json!([joint.body, joint.to])).collect::<Vec<_>>(),
        "meshes": surfaces.iter().flatten().map(mesh).collect::<Vec<_>>(),
        "times": packed::floats(track.times.iter().copied()),
        "poses": packed::floats(poses),
        "view": view,
        "phases": phases(record, &track),
        "plots": plots(record, &track),
        "slices": slices,
        "missing": record.slices.missing,
    }))
}

/// The distinct shapes of the bodies; shapes with a surface come first.
fn distinct_shapes(scene: &Scene) -> Vec<&Shape> {
    let mut shapes: Vec<&Shape> = Vec::new();
    for body in scene.bodies() {
        if !shapes.contains(&&body.shape) {
            shapes.push(&body.shape);
        }
    }
    shapes.sort_by_key(|shape| !shape.has_surface());
    shapes
}

fn mesh(surface: &SurfaceMesh) -> Value {
    json!({
        "points": packed::floats(surface.points.iter().flat_map(|x| [x.x, x.y, x.z])),
        "triangles": packed::indices(surface.triangles.iter().flatten().copied()),
    })
}

fn start_poses(record: &RunRecord) -> Vec<Isometry3<f64>> {
    let first = record.outcome.samples.first();
    first.map_or(Vec::new(), |sample| sample.poses.clone())
}

/// Begin, end and name of the phases that are shown.
fn phases(record: &RunRecord, track: &Track) -> Vec<Value> {
    let gait = record.scene.gait();
    let mut begin = 0.0;
    let mut phases = Vec::new();
    for span in 0..gait.phases.len() * track.cycles {
        let end = begin + gait.phases[span % gait.phases.len()].duration;
        let done = record.outcome.spans.get(span);
        let joints = done.map_or(&[][..], |span| &span.joints);
        let is_labelled = gait.phases.len() * track.cycles <= MAX_LABELS && !joints.is_empty();
        let name = is_labelled.then(|| record.scene.joint_label(joints));
        phases.push(json!({ "begin": begin, "end": end, "name": name }));
        begin = end;
    }
    phases
}

/// Curves over time: displacements or angles of the bodies, then lengths and angles of the joints,
/// then energies and forces in fluids with inertia.
fn plots(record: &RunRecord, track: &Track) -> Vec<Value> {
    let (scene, outcome) = (&record.scene, &record.outcome);
    let quantity = Quantity::new(scene, outcome);
    let rotation = match quantity {
        Quantity::Displacement(_) => Quantity::rotation(outcome),
        Quantity::Angle(_) => None,
    };
    let series = |name: &str, number: usize, values: Vec<f64>| {
        json!({
            "name": name,
            "colour": body_colour(number),
            "values": packed::floats(values),
        })
    };
    let of_bodies = |quantity: Quantity| {
        let curve = quantity.curve(outcome);
        let shown = scene.bodies().iter().enumerate().take(MAX_CURVES);
        let bodies = shown.map(|(k, body)| {
            let times = track.times.iter();
            let values = times.map(|time| interpolated(&curve, *time, k));
            series(&body.name, k, values.collect())
        });
        json!({
            "title": titled(&quantity.title(), scene.bodies().len()),
            "unit": quantity.label(),
            "series": bodies.collect::<Vec<_>>(),
        })
    };
    let mut plots: Vec<Value> = [quantity]
        .into_iter()
        .chain(rotation)
        .map(of_bodies)
        .collect();
    let passive = scene.articulation().passive_drives();
    let moving: BTreeSet<usize> = (outcome.spans.iter().flat_map(|span| span.joints.clone()))
        .chain(passive.map(|(joint, _)| joint))
        .collect();
    for (turns, title, unit) in [
        (false, "Lengths of the links", "length (the scene's unit)"),
        (true, "Angles of the joints", "angle (radians)"),
    ] {
        let joints = scene.articulation().joints().iter().enumerate();
        let joints = joints.filter(|(k, joint)| joint.kind.turns() == turns && moving.contains(k));
        let count = joints.clone().count();
        let of_joints: Vec<Value> = joints
            .take(MAX_CURVES)
            .map(|(k, joint)| {
                let values = track.joints.iter().map(|values| values[k]);
                // Other colours than those of the first bodies.
                series(&joint.name, k + 3, values.collect())
            })
            .collect();
        if !of_joints.is_empty() {
            plots.push(json!({ "title": titled(title, count), "unit": unit, "series": of_joints }));
        }
    }
    for curves in inertia::curves(scene, outcome) {
        let names = curves.names.iter().enumerate().take(MAX_CURVES);
        let of_names = names.map(|(k, name)| {
            let times = track.times.iter();
            let values = times.map(|time| interpolated(&curves.values, *time, k));
            series(name, k, values.collect())
        });
        plots.push(json!({
            "title": titled(&curves.title, curves.names.len()),
            "unit": curves.unit,
            "series": of_names.collect::<Vec<_>>(),
        }));
    }
    plots
}

/// Value of one body's curve at a time, interpolated linearly.
fn interpolated(curve: &[(f64, Vec<f64>)], time: f64, body: usize) -> f64 {
    let after = curve
        .partition_point(|(t, _)| *t < time)
        .min(curve.len() - 1);
    let ((from, a), (to, b)) = (&curve[after.saturating_sub(1)], &curve[after]);
    let share = match to > from {
        true => (time - from) / (to - from),
        false => 1.0,
    };
    a[body] + share * (b[body] - a[body])
}

/// A slice with its streamlines and the outlines of the bodies; `None` if the data are damaged.
fn slice(
    record: &RunRecord,
    shapes: &[&Shape],
    surfaces: &[Option<SurfaceMesh>],
    stored: &StoredSlice,
) -> Option<Value> {
    let slice = stored.slice()?;
    let packed_curve = |curve: &[[f64; 2]]| packed::shares(curve.iter().flatten().copied());
    let lines: Vec<String> = (streamlines(&slice, LINE_DISTANCE).iter())
        .map(|line| {
            let last = line.len() - 1;
            let kept = line.iter().enumerate();
            let kept = kept.filter(|(k, _)| k % STRIDE == 0 || *k == last);
            packed_curve(&kept.map(|(_, point)| *point).collect::<Vec<_>>())
        })
        .collect();
    let sample = nearest_in_time(&record.outcome.samples, stored.time)?;
    let mut outlines = Vec::new();
    for (number, (body, pose)) in record.scene.bodies().iter().zip(&sample.poses).enumerate() {
        let deformed = body.deformation.as_ref();
        let deformed = deformed.and_then(|_| body_surface(&body.at(&sample.shape).shape));
        let shape = shapes.iter().position(|known| **known == body.shape)?;
        let Some(surface) = deformed.as_ref().or(surfaces[shape].as_ref()) else {
            continue;
        };
        for curve in section(surface, pose, &stored.plane) {
            let curve: Vec<f64> = curve.into_iter().flatten().collect();
            outlines.push(json!({ "body": number, "points": packed::floats(curve) }));
        }
    }
    let walls = wall_lines(record.scene.domain(), &stored.plane);
    Some(json!({
        "time": stored.time,
        "plane": stored.plane,
        "columns": stored.columns,
        "rows": stored.rows,
        "unit": stored.unit,
        "velocity": stored.velocity,
        "pressureUnit": stored.pressure_unit,
        "pressure": stored.pressure,
        "lines": lines,
        "outlines": outlines,
        "walls": packed::floats(walls.into_iter().flatten().flatten()),
    }))
}

/// The title of a plot of some things, of which it has the first [`MAX_CURVES`].
fn titled(title: &str, count: usize) -> String {
    match count > MAX_CURVES {
        true => format!("{}, the first {MAX_CURVES} of {count}", capitalised(title)),
        false => capitalised(title),
    }
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters
        .next()
        .map(|letter| letter.to_uppercase().collect::<String>());
    first.unwrap_or_default() + letters.as_str()
}
