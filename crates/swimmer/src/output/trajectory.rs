//! `trajectory.csv`: one row per solve and per end of a phase, or at equal intervals of time.

use nalgebra::Vector3;
use scene::Scene;

use crate::outcome::Sample;

/// Suffixes of the columns of a body: position, rotation vector, velocity, angular velocity, force
/// and torque on the fluid.
const COLUMNS: [&str; 18] = [
    "x", "y", "z", "rx", "ry", "rz", "vx", "vy", "vz", "wx", "wy", "wz", "fx", "fy", "fz", "tx",
    "ty", "tz",
];

/// Suffixes of more columns of a body in a fluid with inertia: the parts of its force and torque on
/// the fluid by the accelerations of the bodies.
const ADDED_MASS: [&str; 6] = ["afx", "afy", "afz", "atx", "aty", "atz"];

/// The trajectory as comma-separated values with a header.
///
/// Columns: `time`, `cycle` and `phase` (from one), the value of each joint (`NAME.length`, an
/// angle for joints that turn), and 18 columns per body, such as `left.x`. Where nothing is solved,
/// at the start, at the ends of phases and at equal intervals of time, velocities and forces are
/// those of the polynomial through the solves of a step, with more error than at the solves; at the
/// end of a phase, where rates jump, they are those before it, and at the start they are empty
/// where fluid or bodies have inertia. The last column, `solved`, is 1 in
/// rows of solves and 0 in these. Fluids with inertia have two more columns, the
/// kinetic energies of fluid and bodies, and six more per body, forces and torques by added mass
/// ([`AddedMassForces`](crate::AddedMassForces)) such as `left.afx`, empty where nothing is solved
/// and, in the meridian plane, at every second step. Numbers have as many digits as are needed to
/// restore every bit. Rotation vectors are those from the pose of the scene, and count the full
/// turns since the first sample ([`Turning::after`](crate::Turning::after)).
pub fn trajectory_csv(scene: &Scene, samples: &[Sample]) -> String {
    let mut header = vec!["time".to_owned(), "cycle".to_owned(), "phase".to_owned()];
    header.extend(
        scene
            .articulation()
            .joints()
            .iter()
            .map(|joint| format!("{}.length", joint.name)),
    );
    for body in scene.bodies() {
        header.extend(
            COLUMNS
                .iter()
                .map(|column| format!("{}.{column}", body.name)),
        );
    }
    let has_energy = scene.inertia().is_kept();
    if has_energy {
        header.extend(["kinetic_energy.fluid", "kinetic_energy.bodies"].map(str::to_owned));
        for body in scene.bodies() {
            header.extend(ADDED_MASS.map(|column| format!("{}.{column}", body.name)));
        }
    }
    header.push("solved".to_owned());
    let mut text = header
        .iter()
        .map(|name| quoted(name))
        .collect::<Vec<_>>()
        .join(",");
    text.push('\n');
    let phases = scene.gait().phases.len().max(1);
    for sample in samples {
        let mut row = vec![
            sample.time.to_string(),
            (sample.span / phases + 1).to_string(),
            (sample.span % phases + 1).to_string(),
        ];
        let numbers = |v: &Vector3<f64>| v.iter().map(f64::to_string).collect::<Vec<_>>();
        row.extend(sample.shape.iter().map(f64::to_string));
        for (body, pose) in sample.poses.iter().enumerate() {
            row.extend(numbers(&pose.translation.vector));
            // Samples of older runs have none.
            let turning = sample.turnings.get(body).copied().unwrap_or_default();
            let start = samples[0].poses[body].rotation;
            let turning = turning.after(&start);
            row.extend(numbers(&turning.rotation_vector(&pose.rotation)));
            match sample.loads().and_then(|bodies| bodies.get(body)) {
                Some(b) => {
                    for vector in [b.velocity, b.angular_velocity, b.force, b.torque] {
                        row.extend(numbers(&vector));
                    }
                }
                None => row.extend(vec![String::new(); 12]),
            }
        }
        if has_energy {
            let energies = sample
                .kinetic_energy
                .map(|energy| [energy.fluid, energy.bodies]);
            row.extend(
                energies.map_or([String::new(), String::new()], |e| e.map(|e| e.to_string())),
            );
            match &sample.added_mass {
                Some(added_mass) => {
                    row.extend(added_mass.bodies.iter().flatten().flat_map(numbers))
                }
                None => row.extend(vec![String::new(); ADDED_MASS.len() * scene.bodies().len()]),
            }
        }
        row.push(u8::from(sample.is_solved(scene)).to_string());
        text.push_str(&row.join(","));
        text.push('\n');
    }
    text
}

/// A name as a field, quoted if it contains a separator, a quote or a line break (RFC 4180).
fn quoted(name: &str) -> String {
    match name.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", name.replace('"', "\"\"")),
        false => name.to_owned(),
    }
}
