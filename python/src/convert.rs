//! Results of the library as dictionaries of numbers, texts and numpy arrays.

use numpy::ndarray::ArrayView2;
use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use swimmer::models::mesh::TetMesh;
use swimmer::models::nalgebra::{DMatrix, Matrix3, Vector3};
use swimmer::models::rigid::JointLoad;
use swimmer::models::{
    BodySolution, ErrorEstimate, FlowField, InstantaneousSolution, MeanFlow, PointFlow, Seconds,
};
use swimmer::{Outcome, Report, Sample, Scene};

use crate::errors::SceneException;

/// A two-dimensional array from its rows.
pub fn rows<'py, T: Element, const N: usize>(
    py: Python<'py>,
    rows: impl ExactSizeIterator<Item = [T; N]>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = [rows.len(), N];
    let flat: Vec<T> = rows.flatten().collect();
    Ok(PyArray1::from_vec(py, flat).reshape(shape)?.into_any())
}

/// Vectors as rows of an array.
pub fn vectors<'py>(py: Python<'py>, vectors: &[Vector3<f64>]) -> PyResult<Bound<'py, PyAny>> {
    rows(py, vectors.iter().map(|v| [v.x, v.y, v.z]))
}

/// A matrix as an array.
pub fn matrix<'py>(py: Python<'py>, matrix: &DMatrix<f64>) -> PyResult<Bound<'py, PyAny>> {
    // Columns of the transposed matrix are rows.
    let flat = matrix.transpose().as_slice().to_vec();
    let shape = [matrix.nrows(), matrix.ncols()];
    Ok(PyArray1::from_vec(py, flat).reshape(shape)?.into_any())
}

/// Matrices of size 3 as an array of shape `(n, 3, 3)`.
pub fn matrices<'py>(py: Python<'py>, matrices: &[Matrix3<f64>]) -> PyResult<Bound<'py, PyAny>> {
    // Columns of a transposed matrix are rows.
    let flat = matrices
        .iter()
        .flat_map(|m| <[[f64; 3]; 3]>::from(m.transpose()));
    let flat: Vec<f64> = flat.flatten().collect();
    let shape = [matrices.len(), 3, 3];
    Ok(PyArray1::from_vec(py, flat).reshape(shape)?.into_any())
}

/// Points from the rows of an array.
pub fn points(rows: &ArrayView2<'_, f64>) -> PyResult<Vec<Vector3<f64>>> {
    if rows.ncols() != 3 {
        let columns = rows.ncols();
        return Err(SceneException::new_err(format!(
            "points have three coordinates in each row, not {columns}"
        )));
    }
    let points = rows.rows().into_iter();
    Ok(points.map(|x| Vector3::new(x[0], x[1], x[2])).collect())
}

/// Velocities and pressures at points, one row each; NaN where there is no fluid.
pub fn point_flows<'py>(
    py: Python<'py>,
    found: &[Option<PointFlow>],
) -> PyResult<[Bound<'py, PyAny>; 2]> {
    let velocity = |flow: &Option<PointFlow>| flow.map_or([f64::NAN; 3], |f| f.velocity.into());
    let pressures = found.iter().map(|flow| flow.and_then(|f| f.pressure));
    let pressures: Vec<f64> = pressures.map(|p| p.unwrap_or(f64::NAN)).collect();
    Ok([rows(py, found.iter().map(velocity))?, array(py, &pressures)])
}

/// A list of numbers as an array.
pub fn array<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyAny> {
    PyArray1::from_slice(py, values).into_any()
}

/// A list of lists of this length as a two-dimensional array, which has it without rows too.
pub fn table<'py>(
    py: Python<'py>,
    lists: &[Vec<f64>],
    width: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = [lists.len(), width];
    let flat: Vec<f64> = lists.iter().flatten().copied().collect();
    Ok(PyArray1::from_vec(py, flat).reshape(shape)?.into_any())
}

/// Error bars by source; None for a source that was not estimated.
pub fn estimate<'py>(py: Python<'py>, bars: &ErrorEstimate) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, value) in bars.sources() {
        dict.set_item(name, value)?;
    }
    Ok(dict)
}

/// Seconds of the parts of the work.
fn seconds<'py>(py: Python<'py>, seconds: &Seconds) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, value) in [
        ("mesh", seconds.mesh),
        ("assembly", seconds.assembly),
        ("setup", seconds.setup),
        ("solve", seconds.solve),
        ("estimate", seconds.estimate),
        ("total", seconds.total),
    ] {
        dict.set_item(name, value)?;
    }
    Ok(dict)
}

/// Names of the bodies of a scene.
pub fn body_names(scene: &Scene) -> Vec<&str> {
    scene.bodies().iter().map(|body| &body.name[..]).collect()
}

/// Names of the joints of a scene.
pub fn joint_names(scene: &Scene) -> Vec<&str> {
    let joints = scene.articulation().joints().iter();
    joints.map(|joint| &joint.name[..]).collect()
}

/// An instantaneous solution.
pub fn solution_dict<'py>(
    py: Python<'py>,
    scene: &Scene,
    model: &str,
    solution: &InstantaneousSolution,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let bodies = |of: fn(&BodySolution) -> Vector3<f64>| -> Vec<Vector3<f64>> {
        solution.bodies.iter().map(of).collect()
    };
    dict.set_item("model", model)?;
    dict.set_item("bodies", body_names(scene))?;
    dict.set_item("links", joint_names(scene))?;
    dict.set_item("velocity", vectors(py, &bodies(|b| b.velocity))?)?;
    dict.set_item(
        "angular_velocity",
        vectors(py, &bodies(|b| b.angular_velocity))?,
    )?;
    dict.set_item("force", vectors(py, &bodies(|b| b.force))?)?;
    dict.set_item("torque", vectors(py, &bodies(|b| b.torque))?)?;
    let links = |of: fn(&JointLoad) -> Vector3<f64>| -> Vec<Vector3<f64>> {
        solution.joint_loads.iter().map(of).collect()
    };
    dict.set_item("link_force", vectors(py, &links(|load| load.force))?)?;
    dict.set_item("link_torque", vectors(py, &links(|load| load.torque))?)?;
    let drives: Vec<f64> = solution.joint_loads.iter().map(|load| load.drive).collect();
    dict.set_item("link_drive", array(py, &drives))?;
    let stresslets = solution.stresslets.as_ref();
    let of_bodies = stresslets.map(|stresslets| matrices(py, &stresslets.bodies));
    dict.set_item("stresslet", of_bodies.transpose()?)?;
    let stresslet_error = stresslets.and_then(|stresslets| stresslets.error);
    dict.set_item("stresslet_error", stresslet_error)?;
    dict.set_item("velocity_errors", estimate(py, &solution.error_estimate)?)?;
    let spins = estimate(py, &solution.angular_velocity_error)?;
    dict.set_item("angular_velocity_errors", spins)?;
    dict.set_item("force_errors", estimate(py, &solution.force_error)?)?;
    dict.set_item("torque_errors", estimate(py, &solution.torque_error)?)?;
    dict.set_item("power", solution.power())?;
    dict.set_item("power_errors", estimate(py, &solution.power_error)?)?;
    let flow = solution.mean_flow.as_ref();
    let flow = flow.map(|flow| mean_flow(py, scene, flow, &solution.mean_flow_error));
    dict.set_item("mean_flow", flow.transpose()?)?;
    dict.set_item("dofs", solution.dofs.total)?;
    let solver = &solution.solver;
    dict.set_item("formulation", &solver.formulation)?;
    dict.set_item("solver", &solver.solver)?;
    dict.set_item("iterations", solver.iterations)?;
    dict.set_item("residual", solver.true_relative_residual)?;
    dict.set_item("seconds", seconds(py, &solution.seconds)?)?;
    Ok(dict)
}

/// A mean flow through a periodic box, with the error bars of what the scene does not give.
fn mean_flow<'py>(
    py: Python<'py>,
    scene: &Scene,
    flow: &MeanFlow,
    bars: &ErrorEstimate,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("velocity", array(py, flow.velocity.as_slice()))?;
    dict.set_item(
        "pressure_gradient",
        array(py, flow.pressure_gradient.as_slice()),
    )?;
    let (found, given) = match scene.finds_mean_flow() {
        true => ("velocity_errors", "pressure_gradient_errors"),
        false => ("pressure_gradient_errors", "velocity_errors"),
    };
    dict.set_item(found, estimate(py, bars)?)?;
    dict.set_item(given, py.None())?;
    Ok(dict)
}

/// A finished run.
pub fn report_dict<'py>(py: Python<'py>, report: &Report) -> PyResult<Bound<'py, PyDict>> {
    let (scene, outcome) = (&report.scene, &report.outcome);
    let dict = PyDict::new(py);
    dict.set_item("scene", scene.name())?;
    dict.set_item("model", report.model)?;
    dict.set_item("reasons", &report.reasons)?;
    dict.set_item("bodies", body_names(scene))?;
    dict.set_item("links", joint_names(scene))?;
    dict.set_item("displacement", vectors(py, &outcome.displacement)?)?;
    dict.set_item("net", outcome.net())?;
    dict.set_item("errors", estimate(py, &outcome.error_estimate)?)?;
    dict.set_item("rotation", array(py, outcome.rotation.as_slice()))?;
    dict.set_item("rotation_errors", estimate(py, &outcome.rotation_error)?)?;
    dict.set_item("work", outcome.work)?;
    dict.set_item("work_errors", estimate(py, &outcome.work_error)?)?;
    let efficiency = report.efficiency;
    dict.set_item("efficiency", efficiency.map(|of_run| of_run.value))?;
    dict.set_item(
        "efficiency_error",
        efficiency.and_then(|of_run| of_run.error),
    )?;
    let means = outcome.mean_holding().unwrap_or_default();
    let held: Vec<&str> = (means.bodies.iter())
        .map(|load| scene.bodies()[load.body].name.as_str())
        .collect();
    dict.set_item("held", held)?;
    let [forces, torques]: [Vec<_>; 2] = [
        means.bodies.iter().map(|load| load.force).collect(),
        means.bodies.iter().map(|load| load.torque).collect(),
    ];
    dict.set_item("mean_force", vectors(py, &forces)?)?;
    dict.set_item("mean_force_errors", estimate(py, &means.force_error)?)?;
    dict.set_item("mean_torque", vectors(py, &torques)?)?;
    dict.set_item("mean_torque_errors", estimate(py, &means.torque_error)?)?;
    let flow = outcome.mean_flow();
    let flow = flow.map(|mean| mean_flow(py, scene, &mean.flow, &mean.error));
    dict.set_item("mean_flow", flow.transpose()?)?;
    dict.set_item("tolerance", scene.model().tolerance)?;
    dict.set_item("tolerance_met", outcome.tolerance_met)?;
    dict.set_item("solves", outcome.model_solves())?;
    let times = seconds(py, &outcome.seconds)?;
    times.set_item("total", report.seconds)?;
    dict.set_item("seconds", times)?;
    let phases = PyList::empty(py);
    for span in &outcome.spans {
        let phase = PyDict::new(py);
        phase.set_item("link", scene.joint_names(&span.joints))?;
        phase.set_item("displacement", vectors(py, &span.displacement)?)?;
        phase.set_item("errors", estimate(py, &span.error_estimate)?)?;
        phase.set_item("solves", span.solves - span.lookups)?;
        phases.append(phase)?;
    }
    dict.set_item("phases", phases)?;
    let swimmers = PyList::empty(py);
    for result in outcome.swimmers(scene) {
        let swimmer = PyDict::new(py);
        let bodies = result.bodies.iter().map(|&body| &scene.bodies()[body].name);
        swimmer.set_item("name", result.name(scene))?;
        swimmer.set_item("bodies", bodies.collect::<Vec<_>>())?;
        swimmer.set_item("displacement", array(py, result.displacement.as_slice()))?;
        swimmer.set_item("errors", estimate(py, &result.error_estimate)?)?;
        swimmer.set_item("rotation", array(py, result.rotation.as_slice()))?;
        swimmer.set_item("rotation_errors", estimate(py, &result.rotation_error)?)?;
        swimmer.set_item("work", result.work)?;
        let work_errors = result.work_error.as_ref().map(|bars| estimate(py, bars));
        swimmer.set_item("work_errors", work_errors.transpose()?)?;
        swimmers.append(swimmer)?;
    }
    dict.set_item("swimmers", swimmers)?;
    trajectory(py, scene, outcome, &dict)?;
    Ok(dict)
}

/// Enters the samples and the curve of a trajectory.
fn trajectory(
    py: Python<'_>,
    scene: &Scene,
    outcome: &Outcome,
    dict: &Bound<'_, PyDict>,
) -> PyResult<()> {
    let samples = outcome.trajectory();
    let times: Vec<f64> = samples.iter().map(|sample| sample.time).collect();
    let bodies = outcome.displacement.len();
    let lengths: Vec<Vec<f64>> = samples.iter().map(|sample| sample.shape.clone()).collect();
    let poses = || samples.iter().flat_map(|sample| &sample.poses);
    let places: Vec<f64> = poses()
        .flat_map(|p| p.translation.vector.as_slice().to_vec())
        .collect();
    // Quaternions (x, y, z, w), as scipy.spatial.transform.Rotation has them.
    let turns: Vec<f64> = poses()
        .flat_map(|p| p.rotation.coords.as_slice().to_vec())
        .collect();
    dict.set_item("times", array(py, &times))?;
    dict.set_item("lengths", table(py, &lengths, joint_names(scene).len())?)?;
    let shaped = |flat: Vec<f64>, count: usize, width: usize| {
        PyArray1::from_vec(py, flat).reshape([count, bodies, width])
    };
    dict.set_item("positions", shaped(places, samples.len(), 3)?)?;
    dict.set_item("quaternions", shaped(turns, samples.len(), 4)?)?;
    let solved: Vec<bool> = (samples.iter())
        .map(|sample| sample.is_solved(scene))
        .collect();
    dict.set_item("solved", PyArray1::from_vec(py, solved))?;
    // NaN where the velocities are not known.
    let of_bodies = |of: fn(&BodySolution) -> Vector3<f64>| -> Vec<f64> {
        let of_sample = |sample: &Sample| match sample.loads() {
            Some(known) => known.iter().map(|body| of(body).into()).collect(),
            None => vec![[f64::NAN; 3]; bodies],
        };
        samples.iter().flat_map(of_sample).flatten().collect()
    };
    for (name, flat) in [
        ("velocities", of_bodies(|body| body.velocity)),
        (
            "angular_velocities",
            of_bodies(|body| body.angular_velocity),
        ),
        ("forces", of_bodies(|body| body.force)),
        ("torques", of_bodies(|body| body.torque)),
    ] {
        dict.set_item(name, shaped(flat, samples.len(), 3)?)?;
    }
    let curve = &outcome.curve;
    let times: Vec<f64> = curve.iter().map(|(time, _)| *time).collect();
    let places = curve.iter().flat_map(|(_, places)| places);
    let places: Vec<f64> = places.flat_map(|x| x.as_slice().to_vec()).collect();
    dict.set_item("curve_times", array(py, &times))?;
    dict.set_item("curve_positions", shaped(places, curve.len(), 3)?)?;
    Ok(())
}

/// A mesh: points, cells, facets with the numbers of their tags, names of the tags.
pub fn mesh_dict<'py>(py: Python<'py>, mesh: &TetMesh) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("points", vectors(py, mesh.points())?)?;
    dict.set_item("cells", rows(py, mesh.cells().iter().copied())?)?;
    dict.set_item("facets", rows(py, mesh.facets().iter().map(|f| f.nodes))?)?;
    let tags: Vec<u16> = mesh.facets().iter().map(|f| f.tag).collect();
    dict.set_item("facet_tags", PyArray1::from_vec(py, tags))?;
    dict.set_item("tags", mesh.tags())?;
    dict.set_item("n_vertices", mesh.n_vertices())?;
    let quality = mesh.quality();
    for (name, value) in [
        ("min_dihedral", quality.min_dihedral),
        ("max_dihedral", quality.max_dihedral),
        ("min_quality", quality.min_quality),
        ("mean_quality", quality.mean_quality),
        ("min_jacobian", quality.min_jacobian),
    ] {
        dict.set_item(name, value)?;
    }
    Ok(dict)
}

/// A flow on the nodes of a mesh; the pressure at vertices is empty if it is not computed.
pub fn flow_dict<'py>(py: Python<'py>, flow: &FlowField) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("mesh", mesh_dict(py, &flow.mesh)?)?;
    dict.set_item("velocity", vectors(py, &flow.velocity)?)?;
    dict.set_item("pressure", array(py, &flow.pressure))?;
    Ok(dict)
}
