//! Checks that the numbers of a scene can be computed with: their sizes relative to the bodies.

use nalgebra::Vector3;

use super::checks::Checks;
use crate::body::Body;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::file::GaitFile;
use crate::gait::Gait;
use crate::gait_table::GaitTable;
use crate::length_path::LengthPath;
use crate::options::FemOptions;

/// Largest length of a scene over the smallest length of a body.
///
/// Positions are rounded to 1.1e-16 of their size. At this distance that is 1e-7 of the smallest
/// body: less than the error of the finest mesh, and less than a thousandth of the smallest gap
/// that a mesh resolves, 1e-3 radii. Far beyond this ratio symmetry planes, points inside bodies
/// and gaps are lost in rounding.
const LARGEST_RATIO: f64 = 1e9;

/// Refuses lengths that are too large for the smallest body, and loads that move bodies too far.
pub(super) fn check(
    checks: &Checks,
    viscosity: f64,
    domain: &Domain,
    bodies: &[Body],
    (gait, gait_file, gait_table): (&Gait, &GaitFile, Option<&GaitTable>),
    fem: &FemOptions,
) -> Result<(), SceneError> {
    let all = (bodies.iter()).flat_map(|body| body.shape.lengths().into_iter().map(|l| l.1));
    let smallest = all.fold(f64::INFINITY, f64::min);
    let demand = |key: String, length: f64| {
        if length <= LARGEST_RATIO * smallest {
            return Ok(());
        }
        let problem = format!(
            "is too large: at {:.1e} times the smallest radius of the bodies ({smallest:e}) \
             rounding errors reach the size of the gaps between bodies; the limit is \
             {LARGEST_RATIO:e} times",
            length / smallest
        );
        Err(checks.bad_value(&key, problem))
    };
    match domain {
        Domain::Ball { radius } | Domain::Cylinder { radius } => {
            demand("domain.radius".to_owned(), *radius)?;
        }
        Domain::Box { size } => demand("domain.size".to_owned(), size.amax())?,
        Domain::Surface(shape) => demand("domain.file".to_owned(), shape.bounding_radius())?,
        Domain::Unbounded | Domain::Wall | Domain::Mesh { .. } => {}
    }
    for (number, body) in bodies.iter().enumerate() {
        let key = |key: &str| format!("bodies[{number}].{key}");
        demand(key("position"), body.position.amax())?;
        for (name, length) in body.shape.lengths() {
            demand(key(name), length)?;
        }
    }
    if let Some(table) = gait_table {
        demand("gait.file".to_owned(), table.largest())?;
    }
    for (number, phase) in gait.phases.iter().enumerate() {
        match &phase.path {
            LengthPath::Cubic(_) => {}
            LengthPath::Linear(changes) => {
                for (_, length) in changes {
                    demand(format!("gait.phases[{number}].length"), *length)?;
                }
            }
            LengthPath::Harmonic { sines, .. } => {
                for (number, sine) in sines.iter().enumerate() {
                    demand(
                        format!("gait.harmonics[{number}].amplitude"),
                        sine.amplitude,
                    )?;
                }
            }
        }
    }
    for (number, file) in gait_file.harmonics.iter().flatten().enumerate() {
        if let Some(mean) = file.mean {
            demand(format!("gait.harmonics[{number}].mean"), mean)?;
        }
    }
    if let Some(size) = fem.surface_size {
        let radii = bodies.iter().map(Body::bounding_radius);
        let (low, high) = (4e-4 * smallest, 4.0 * radii.fold(0.0, f64::max));
        if !(low..=high).contains(&size) {
            let problem = format!(
                "must be between {low:e} and {high:e}: 4e-4 times the smallest and 4 times the \
                 largest radius of the bodies, not {size:e}"
            );
            return Err(checks.bad_value("fem.surface_size", problem));
        }
    }
    // A body under a load moves at about load / (viscosity size).
    for (number, body) in bodies.iter().enumerate() {
        let unit = viscosity * smallest * smallest;
        let distance = |load: &Vector3<f64>, unit: f64| gait.duration() * load.amax() / unit;
        let loads = [
            ("force", distance(&body.force, unit)),
            ("torque", distance(&body.torque, unit * smallest)),
        ];
        for (name, radii) in loads {
            if radii.is_nan() || radii > LARGEST_RATIO {
                let problem = format!(
                    "is too large: it would move a body by about {radii:.1e} times the smallest \
                     radius during the gait; the limit is {LARGEST_RATIO:e} times"
                );
                return Err(checks.bad_value(&format!("bodies[{number}].{name}"), problem));
            }
        }
    }
    Ok(())
}
