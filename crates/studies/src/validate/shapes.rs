//! K: bodies of other shapes than spheres in unbounded fluid, turned off all axes.

use std::f64::consts::PI;

use anyhow::{Context, Result};
use nalgebra::{UnitQuaternion, Vector3};
use swimmer::models::InstantaneousSolution;

use super::row::{Basis, Cost, Estimated, Row};
use crate::reference::{DISK_DRAGS, SHAPES, ShapeResistance, torus_drag};
use crate::scenes::{SceneText, solve};

/// Number of shapes in the quick part.
const QUICK: usize = 2;

/// Required of drag and torque on the coarsest mesh.
const REQUIRED_ACCURACY: f64 = 1e-3;

/// Rotation of the bodies, so that no axis of theirs is one of the laboratory.
const ORIENTATION: Vector3<f64> = Vector3::new(0.4, -0.7, 1.0);

/// All rows; those of the first shapes only in the quick part.
pub fn rows(quick: bool) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for shape in &SHAPES[..if quick { QUICK } else { SHAPES.len() }] {
        rows.extend(drags_and_torques(shape)?);
    }
    if !quick {
        let [inside, around] = DISK_DRAGS;
        let middle = 0.5 * (inside + around);
        let keys = "shape = \"disk\"\nradius = 1\nhalf_length = 0.1";
        let tolerance = around / middle - 1.0;
        rows.push(along_axis("rounded disk 1:0.1", keys, middle, tolerance)?);
        let (drag, tolerance) = torus_drag(0.1);
        let keys = "shape = \"torus\"\nradius = 1\ntube_radius = 0.1";
        rows.push(along_axis("torus 1:0.1", keys, drag, tolerance)?);
    }
    Ok(rows)
}

/// Drag and torque along the first and the last axis, on the coarsest mesh.
fn drags_and_torques(shape: &ShapeResistance) -> Result<Vec<Row>> {
    let load = Vector3::repeat(1.0);
    let (solution, cost) = loaded(shape.keys, [6.0 * PI * load, 8.0 * PI * load])?;
    let body = &solution.bodies[0];
    let error = solution.mesh_error.as_ref();
    let error = error.context("the errors of elements are estimated")?;
    let turned = |v: Vector3<f64>| rotation().inverse() * v;
    let [velocity, angular_velocity] = [body.velocity, body.angular_velocity].map(turned);
    let mut rows = Vec::new();
    for axis in [0, 2] {
        // The resistance is the inverse of the velocity under a unit load.
        let row = |what: &str, exact: f64, motion: f64| {
            let name = format!("{}, axis {}: {what}", shape.name, axis + 1);
            let tolerance = (REQUIRED_ACCURACY, Basis::Required);
            let row = Row::relative("K", name, [exact, 1.0 / motion], tolerance, cost);
            row.with_exact_bar(shape.accuracy)
        };
        let motion = velocity[axis];
        let estimated = Estimated {
            removed: Some(turned(error.bodies[0].velocity)[axis]),
            bar: solution.error_estimate.total(),
        };
        let estimated = estimated.times(-1.0 / (motion * motion));
        rows.push(row("drag", shape.drag[axis], motion).with(estimated));
        // The bar of angular velocities is that of one direction only.
        rows.push(row("torque", shape.torque[axis], angular_velocity[axis]));
    }
    Ok(rows)
}

fn along_axis(name: &str, keys: &str, drag: f64, tolerance: f64) -> Result<Row> {
    let axis = rotation() * Vector3::x();
    let (solution, cost) = loaded(keys, [6.0 * PI * Vector3::x(), Vector3::zeros()])?;
    let computed = 1.0 / solution.bodies[0].velocity.dot(&axis);
    let name = format!("{name}, axis 1: drag");
    let tolerance = (tolerance, Basis::Limit);
    Ok(Row::relative("K", name, [drag, computed], tolerance, cost))
}

fn rotation() -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(ORIENTATION)
}

/// The body under a force and a torque along its own axes, on the coarsest mesh.
fn loaded(keys: &str, own: [Vector3<f64>; 2]) -> Result<(InstantaneousSolution, Cost)> {
    let [force, torque] = own.map(|load| rotation() * load);
    let scene = SceneText::new("model.kind = \"fem\"\nfem.size_factor = 1.75")
        .body("body", [0.0; 3])
        .line(keys)
        .key("orientation", ORIENTATION.as_slice())
        .key("force", force.as_slice())
        .key("torque", torque.as_slice());
    let solution = solve(&scene.parse()?)?;
    let cost = Cost::new(&solution);
    Ok((solution, cost))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "slow: 3 s"]
    fn a_turned_ellipsoid_has_the_exact_drag_and_torque() {
        for row in drags_and_torques(&SHAPES[0]).expect("it is solved") {
            assert!(row.passes(), "{row:?}");
        }
    }
}
