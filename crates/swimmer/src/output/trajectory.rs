//! `trajectory.csv` or `trajectory.npy`: one row per solve and per end of a phase, or at equal
//! intervals of time.

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

/// Numbers of a body in every row, three of each quantity, as in [`COLUMNS`].
const QUANTITIES: [&str; 6] = [
    "position",
    "rotation",
    "velocity",
    "angular_velocity",
    "force",
    "torque",
];

/// The numbers of one row; those that are not known are NaN.
struct Row<'s> {
    sample: &'s Sample,
    cycle: usize,
    phase: usize,
    is_solved: bool,
    /// By body and quantity.
    bodies: Vec<[Vector3<f64>; QUANTITIES.len()]>,
    /// Of fluid and bodies.
    energies: [f64; 2],
    /// Forces and torques by added mass.
    added_mass: Vec<[Vector3<f64>; 2]>,
}

const UNKNOWN: Vector3<f64> = Vector3::new(f64::NAN, f64::NAN, f64::NAN);

impl<'s> Row<'s> {
    fn new(scene: &Scene, first: &Sample, sample: &'s Sample) -> Self {
        let phases = scene.gait().phases.len().max(1);
        let count = scene.bodies().len();
        let loads = sample.loads().unwrap_or_default();
        let of_body = |body: usize| {
            let pose = &sample.poses[body];
            // Samples of older runs have none.
            let turning = sample.turnings.get(body).copied().unwrap_or_default();
            let turning = turning.after(&first.poses[body].rotation);
            let [velocity, angular, force, torque] = match loads.get(body) {
                Some(b) => [b.velocity, b.angular_velocity, b.force, b.torque],
                None => [UNKNOWN; 4],
            };
            let position = pose.translation.vector;
            let rotation = turning.rotation_vector(&pose.rotation);
            [position, rotation, velocity, angular, force, torque]
        };
        let added_mass = sample.added_mass.as_ref();
        Self {
            sample,
            cycle: sample.span / phases + 1,
            phase: sample.span % phases + 1,
            is_solved: sample.is_solved(scene),
            bodies: (0..count).map(of_body).collect(),
            energies: (sample.kinetic_energy).map_or([f64::NAN; 2], |e| [e.fluid, e.bodies]),
            added_mass: added_mass.map_or(vec![[UNKNOWN; 2]; count], |found| found.bodies.clone()),
        }
    }

    fn all(scene: &Scene, samples: &'s [Sample]) -> impl Iterator<Item = Self> {
        let first = samples.first();
        (first.into_iter()).flat_map(move |first| {
            samples
                .iter()
                .map(move |sample| Self::new(scene, first, sample))
        })
    }
}

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
    let joints = scene.articulation().joints().iter();
    header.extend(joints.map(|joint| format!("{}.length", joint.name)));
    let of_bodies = |columns: &'static [&str]| {
        let bodies = scene.bodies().iter();
        bodies.flat_map(move |body| columns.iter().map(move |c| format!("{}.{c}", body.name)))
    };
    header.extend(of_bodies(&COLUMNS));
    let has_energy = scene.inertia().is_kept();
    if has_energy {
        header.extend(["kinetic_energy.fluid", "kinetic_energy.bodies"].map(str::to_owned));
        header.extend(of_bodies(&ADDED_MASS));
    }
    header.push("solved".to_owned());
    let mut text = header
        .iter()
        .map(|name| quoted(name))
        .collect::<Vec<_>>()
        .join(",");
    text.push('\n');
    for row in Row::all(scene, samples) {
        text += &format!("{},{},{}", row.sample.time, row.cycle, row.phase);
        let mut add = |number: f64| match number.is_nan() {
            true => text.push(','),
            false => text += &format!(",{number}"),
        };
        row.sample.shape.iter().copied().for_each(&mut add);
        let all = row.bodies.iter().flatten().flatten();
        all.copied().for_each(&mut add);
        if has_energy {
            row.energies.into_iter().for_each(&mut add);
            let all = row.added_mass.iter().flatten().flatten();
            all.copied().for_each(&mut add);
        }
        text += &format!(",{}\n", u8::from(row.is_solved));
    }
    text
}

/// The trajectory as an array of NumPy's format (`.npy`, version 1.0), with one record for each row
/// of [`trajectory_csv`].
///
/// Fields: `time`, `cycle` and `phase` (from one), `solved`, the values of the `joints`, and
/// `position`, `rotation`, `velocity`, `angular_velocity`, `force` and `torque` by body and axis;
/// in fluids with inertia `kinetic_energy` (of fluid and bodies), `added_mass_force` and
/// `added_mass_torque`. Joints and bodies have the order of the scene, that of `links` and `bodies`
/// in `summary.json`. Numbers that are not known are NaN. 8 bytes for each of 18 numbers of a body.
pub fn trajectory_npy(scene: &Scene, samples: &[Sample]) -> Vec<u8> {
    let bodies = scene.bodies().len();
    let joints = scene.articulation().joints().len();
    let of_bodies = |name: &str| format!("('{name}', '<f8', ({bodies}, 3))");
    let mut fields = vec![
        "('time', '<f8')".to_owned(),
        "('cycle', '<u4')".to_owned(),
        "('phase', '<u4')".to_owned(),
        "('solved', '|b1')".to_owned(),
        format!("('joints', '<f8', ({joints},))"),
    ];
    fields.extend(QUANTITIES.map(of_bodies));
    let has_energy = scene.inertia().is_kept();
    if has_energy {
        fields.push("('kinetic_energy', '<f8', (2,))".to_owned());
        fields.extend(["added_mass_force", "added_mass_torque"].map(of_bodies));
    }
    let rows = samples.len();
    let mut header = format!(
        "{{'descr': [{}], 'fortran_order': False, 'shape': ({rows},), }}",
        fields.join(", ")
    );
    // The data begin at a multiple of 64 bytes, after eight of the magic string and version, and
    // two of the length of the header, which ends with a line break.
    let length = (header.len() + 1 + 10).next_multiple_of(64) - 10;
    header = format!("{header:<0$}\n", length - 1);
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(header.into_bytes());
    for row in Row::all(scene, samples) {
        let counts = [row.cycle, row.phase].map(|count| (count as u32).to_le_bytes());
        bytes.extend(row.sample.time.to_le_bytes());
        bytes.extend(counts.as_flattened());
        bytes.push(u8::from(row.is_solved));
        let mut add = |number: &f64| bytes.extend(number.to_le_bytes());
        row.sample.shape.iter().for_each(&mut add);
        for quantity in 0..QUANTITIES.len() {
            let of_bodies = row.bodies.iter().flat_map(|body| body[quantity].iter());
            of_bodies.for_each(&mut add);
        }
        if has_energy {
            row.energies.iter().for_each(&mut add);
            for part in 0..2 {
                let of_bodies = row.added_mass.iter().flat_map(|body| body[part].iter());
                of_bodies.for_each(&mut add);
            }
        }
    }
    bytes
}

/// A name as a field, quoted if it contains a separator, a quote or a line break (RFC 4180).
pub(super) fn quoted(name: &str) -> String {
    match name.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", name.replace('"', "\"\"")),
        false => name.to_owned(),
    }
}
