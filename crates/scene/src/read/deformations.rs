//! The shape coordinates of bodies that deform, and the checks of their values along the gait.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;
use rigid::{Articulation, Joint};

use super::fold_search::{FoldSearch, PARTS};
use super::gait::is_whole;
use super::triangles;
use crate::body::{Body, volume_problem};
use crate::checks::Checks;
use crate::deformation::{Deformation, Undulation};
use crate::domain::Domain;
use crate::error::SceneError;
use crate::frames::FRAME;
use crate::gait::{Gait, spans};
use crate::gait_table::GaitTable;
use crate::harmonics::{Harmonic, MAX_MODE_DEGREE};
use crate::joints::JointWord;
use crate::keys::{BodyFile, DeformationFile, JointValues, SceneFile};
use crate::material_motion::ShapeCoordinate;
use crate::phase_span::PhaseSpan;
use crate::shape::Shape;
use crate::shape_path::ShapePath;
use crate::shapes::TubeShape;
use crate::sphere_deformation::{SizeCoordinate, SphereDeformation};
use crate::surface_modes::{SurfaceModes, any_normal};
use crate::surface_shape::SurfaceFiles;
use crate::undulation::{Bend, Wave};
use crate::words::{DeformationWord, InertiaKind, ModeMotion};

/// The coordinates that every sphere offers.
const OF_SPHERES: [&str; 2] = ["radius", "volume"];

/// Enters the deformations of the bodies, and their coordinates after the joints between bodies.
///
/// These are all modes, the volumes that spheres exchange, and the radii and volumes that the gait
/// or the design names.
pub(super) fn enter(
    checks: &Checks,
    file: &SceneFile,
    bodies: &mut [Body],
    joints: &mut Vec<Joint>,
    surfaces: &mut SurfaceFiles,
) -> Result<(), SceneError> {
    let between = joints.len();
    enter_exchanges(checks, file, bodies, joints)?;
    let names = names(checks, file);
    for number in 0..bodies.len() {
        enter_size(
            checks,
            (number, &file.bodies[number]),
            &names,
            bodies,
            joints,
        )?;
        let own = &file.bodies[number];
        enter_modes(checks, number, own, bodies, joints)?;
        enter_undulation(checks, number, own, &mut bodies[number], joints)?;
        triangles::enter(checks, (number, own), &mut bodies[number], joints, surfaces)?;
    }
    check_names(checks, &names, bodies, joints)?;
    let (links, coordinates) = joints.split_at(between);
    let is_link = |coordinate: &&Joint| links.iter().any(|link| link.name == coordinate.name);
    if let Some(coordinate) = coordinates.iter().find(is_link) {
        let number = links.iter().position(|link| link.name == coordinate.name);
        let problem = format!(
            "\"{}\" is the name of a shape coordinate of the body '{}' too; names must differ",
            coordinate.name, bodies[coordinate.body].name
        );
        let key = format!("links[{}].name", number.unwrap_or_default());
        return Err(checks.bad_value(&key, problem));
    }
    Ok(())
}

/// Refuses names of coordinates that the body before the dot does not have.
fn check_names(
    checks: &Checks,
    names: &Names,
    bodies: &[Body],
    joints: &[Joint],
) -> Result<(), SceneError> {
    for (key, name) in names {
        if joints.iter().any(|joint| joint.name == **name) {
            continue;
        }
        let of = |body: &&Body| {
            let rest = name.strip_prefix(&body.name[..]);
            rest.is_some_and(|rest| rest.starts_with('.'))
        };
        let Some(body) = bodies.iter().find(of) else {
            continue;
        };
        let known = joints.iter().map(|joint| &joint.name[..]);
        let mut coordinates: Vec<String> = known
            .filter(|known| {
                known
                    .strip_prefix(&body.name[..])
                    .is_some_and(|r| r.starts_with('.'))
            })
            .map(str::to_owned)
            .collect();
        if body.shape.sphere_radius().is_some() {
            let others = OF_SPHERES.map(|word| format!("{}.{word}", body.name));
            coordinates.extend(
                others
                    .into_iter()
                    .filter(|o| !coordinates.contains(o))
                    .collect::<Vec<_>>(),
            );
        }
        let remedy = match coordinates.is_empty() {
            true => "which has none".to_owned(),
            false => format!("which has {}", coordinates.join(", ")),
        };
        let problem = format!(
            "names \"{name}\", no shape coordinate of '{}', {remedy}",
            body.name
        );
        return Err(checks.bad_value(key, problem));
    }
    Ok(())
}

/// Volumes that two spheres exchange.
fn enter_exchanges(
    checks: &Checks,
    file: &SceneFile,
    bodies: &mut [Body],
    joints: &[Joint],
) -> Result<(), SceneError> {
    for (number, (joint, file)) in joints.iter().zip(&file.links).enumerate() {
        if file.joint != JointWord::Exchange {
            continue;
        }
        for (end, body) in [("body", joint.body), ("to", joint.to)] {
            let problem = match &bodies[body] {
                body if body.shape.sphere_radius().is_none() => "is no sphere",
                body if body.deformation.is_some() => "exchanges volume with another body already",
                _ => continue,
            };
            let problem = format!("names '{}', which {problem}", bodies[body].name);
            return Err(checks.bad_value(&format!("links[{number}].{end}"), problem));
        }
        let total = bodies[joint.body].shape.volume() + bodies[joint.to].shape.volume();
        let remainder = SizeCoordinate::Remainder {
            joint: number,
            total,
        };
        let coordinates = [SizeCoordinate::Volume(number), remainder];
        for (body, size) in [joint.body, joint.to].into_iter().zip(coordinates) {
            let radius = bodies[body].shape.sphere_radius().unwrap_or_default();
            bodies[body].deformation = Some(Deformation::Sphere(SphereDeformation {
                radius,
                size: Some(size),
                ..SphereDeformation::default()
            }));
        }
    }
    Ok(())
}

/// Keys of a scene that name shape coordinates, with these names.
type Names = Vec<(String, String)>;

/// The names of shape coordinates in the gait and the design.
fn names(checks: &Checks, file: &SceneFile) -> Names {
    let mut names = Names::new();
    for (number, phase) in file.gait.phases.iter().flatten().enumerate() {
        let key = |key: &str| format!("gait.phases[{number}].{key}");
        let targets = phase.targets.iter().flat_map(|targets| targets.keys());
        names.extend(targets.map(|name| (key("targets"), name.clone())));
        names.extend(phase.link.iter().map(|name| (key("link"), name.clone())));
    }
    for (number, term) in file.gait.harmonics.iter().flatten().enumerate() {
        let key = format!("gait.harmonics[{number}].link");
        names.extend(term.link.iter().map(|name| (key.clone(), name.clone())));
    }
    if let Some(table) = &file.gait.file {
        let path = super::gait::table_path(checks, table);
        // What is wrong with the file is reported when it is read.
        let columns = GaitTable::columns(&path).unwrap_or_default();
        names.extend(
            columns
                .into_iter()
                .map(|name| ("gait.file".to_owned(), name)),
        );
    }
    for (key, values) in [
        ("optimise.lower", &file.optimise.lower),
        ("optimise.upper", &file.optimise.upper),
        ("optimise.max_rate", &file.optimise.max_rate),
        ("learn.contracted", &file.learn.contracted),
        ("learn.extended", &file.learn.extended),
    ] {
        if let Some(JointValues::Named(values)) = values {
            names.extend(values.keys().map(|name| (key.to_owned(), name.clone())));
        }
    }
    // Those of other joints; scenes of copies have thousands.
    names.retain(|(_, name)| name.contains('.'));
    names
}

/// The radius or the volume of a sphere, if the body or another key names one of them.
fn enter_size(
    checks: &Checks,
    (number, file): (usize, &BodyFile),
    names: &Names,
    bodies: &mut [Body],
    joints: &mut Vec<Joint>,
) -> Result<(), SceneError> {
    let body = &mut bodies[number];
    let prefix = format!("{}.", body.name);
    let declared = file.deformation.as_ref().map(|file| file.kind);
    let is_size = |kind: &DeformationWord| OF_SPHERES.contains(&kind.word());
    let declared = declared.filter(is_size);
    let declared = declared.map(|kind| {
        let key = format!("bodies[{number}].deformation.kind");
        (key, format!("{prefix}{}", kind.word()))
    });
    let mut found: BTreeSet<&str> = BTreeSet::new();
    for (key, name) in declared.iter().chain(names) {
        let Some(coordinate) = name.strip_prefix(&prefix) else {
            continue;
        };
        let Some(word) = OF_SPHERES.into_iter().find(|word| *word == coordinate) else {
            continue;
        };
        if joints.iter().any(|joint| joint.name == **name) {
            continue;
        }
        let refuse = |problem: String| {
            let problem = format!("names \"{name}\", {problem}");
            Err(checks.bad_value(key, problem))
        };
        if body.shape.sphere_radius().is_none() {
            let shape = body.shape.kind().word();
            return refuse(format!("but '{}' is a {shape} and no sphere", body.name));
        }
        if body.deformation.is_some() {
            return refuse("but a link determines the volume of the body".to_owned());
        }
        found.insert(word);
        if found.len() > 1 {
            return refuse(
                "and the scene names the radius and the volume of this body; use one of them"
                    .to_owned(),
            );
        }
    }
    let (Some(word), Some(radius)) = (found.into_iter().next(), body.shape.sphere_radius()) else {
        return Ok(());
    };
    let joint = joints.len();
    let (size, power) = match word {
        "radius" => (SizeCoordinate::Radius(joint), 1),
        _ => (SizeCoordinate::Volume(joint), 3),
    };
    joints.push(Joint::deformation(
        &format!("{prefix}{word}"),
        [number; 2],
        power,
    ));
    body.deformation = Some(Deformation::Sphere(SphereDeformation {
        radius,
        size: Some(size),
        ..SphereDeformation::default()
    }));
    Ok(())
}

/// The modes of a body.
fn enter_modes(
    checks: &Checks,
    number: usize,
    file: &BodyFile,
    bodies: &mut [Body],
    joints: &mut Vec<Joint>,
) -> Result<(), SceneError> {
    let Some(file) = &file.deformation else {
        return Ok(());
    };
    let body = &mut bodies[number];
    let key = |key: &str| format!("bodies[{number}].deformation.{key}");
    let has_modes = file.kind == DeformationWord::Modes;
    let undulates = file.kind == DeformationWord::Undulation;
    let has_frames = file.kind == DeformationWord::Frames;
    checks.refuse_strangers(
        &format!("bodies[{number}].deformation"),
        [
            ("modes", file.modes.is_some(), has_modes),
            ("motion", file.motion.is_some(), has_modes),
            ("orders", file.orders.is_some(), has_modes),
            ("meridian", file.meridian.is_some(), has_modes),
            ("axis", file.axis.is_some(), has_modes),
            ("wave", file.wave.is_some(), undulates),
            ("envelope", file.envelope.is_some(), undulates),
            ("waves", file.waves.is_some(), undulates),
            ("amplitude", file.amplitude.is_some(), undulates),
            ("phase", file.phase.is_some(), undulates),
            ("files", file.files.is_some(), has_frames),
            ("at", file.at.is_some(), has_frames),
            ("periodic", file.periodic.is_some(), has_frames),
            ("frame", file.frame.is_some(), has_frames),
            ("keep_volume", file.keep_volume.is_some(), has_frames),
        ],
        &format!(
            "does not belong to kind = \"{}\"; remove it",
            file.kind.word()
        ),
    )?;
    if undulates || has_frames || (has_modes && file.modes.is_none()) {
        return Ok(());
    }
    let of_modes = match &body.shape {
        Shape::Spheroid(shape) if has_modes => Some((shape.radius, Some(shape))),
        shape => shape.sphere_radius().map(|radius| (radius, None)),
    };
    let Some((radius, spheroid)) = of_modes else {
        let problem = format!(
            "is unsupported for shape = \"{}\"; spheres deform, shape = \"spheroid\" by kind = \
             \"modes\", shape = \"tube\" by kind = \"undulation\" and shape = \"surface\" by kind = \
             \"frames\"",
            body.shape.kind().word()
        );
        return Err(checks.bad_value(&format!("bodies[{number}].deformation"), problem));
    };
    let Some(modes) = file.modes.as_ref().filter(|_| has_modes) else {
        return Ok(());
    };
    if modes.is_empty() {
        let problem =
            "is empty; give the degree of each mode by its name, such as { p2 = 2, p3 = 3 }";
        return Err(checks.bad_value(&key("modes"), problem));
    }
    let own = spheroid.map(|shape| shape.axis);
    let given = file.axis.map(Vector3::from);
    let zero = || checks.bad_value(&key("axis"), "has no direction");
    let axis = match given.or(own).unwrap_or_else(Vector3::x).try_normalize(0.0) {
        Some(axis) => axis,
        None => return Err(zero()),
    };
    let axis = match own {
        // Angles above rounding are another axis.
        Some(own) if axis.cross(&own).norm() > 1e-9 => {
            let problem = "is not the axis of the spheroid, about which its modes are symmetric; \
                           remove it, or turn the spheroid by its own axis";
            return Err(checks.bad_value(&key("axis"), problem));
        }
        Some(own) => own * own.dot(&axis).signum(),
        None => axis,
    };
    let mut coordinates = Vec::new();
    for (name, &degree) in modes {
        let of_mode = format!("{}.{name}", body.name);
        let limits = 1.0..=MAX_MODE_DEGREE as f64;
        let problem = if OF_SPHERES.contains(&&name[..]) {
            format!("cannot be named \"{name}\", which every sphere has; choose another name")
        } else if degree.fract() != 0.0 || !limits.contains(&degree) {
            format!("must have a whole degree from 1 to {MAX_MODE_DEGREE}, not {degree}")
        } else {
            let harmonic = Harmonic {
                degree: degree as usize,
                order: order_of(checks, &key("orders"), file, (name, degree))?,
            };
            if coordinates.iter().all(|(other, _)| *other != harmonic) {
                coordinates.push((harmonic, joints.len()));
                joints.push(Joint::deformation(&of_mode, [number; 2], 0));
                continue;
            }
            let order = harmonic.order;
            format!("have the degree {degree} and the order {order} twice; both have one amplitude")
        };
        return Err(checks.bad_value(&key("modes"), problem));
    }
    let modes = SurfaceModes {
        motion: file.motion.unwrap_or_default(),
        axis,
        meridian: meridian(checks, &key("meridian"), file, &axis, &coordinates)?,
        coordinates,
    };
    let of_size = body.deformation.as_ref().and_then(Deformation::sphere);
    body.deformation = Some(Deformation::Sphere(SphereDeformation {
        radius,
        elongation: spheroid.map_or(0.0, |shape| shape.half_length / shape.radius - 1.0),
        size: of_size.and_then(|sphere| sphere.size),
        modes: Some(modes),
    }));
    Ok(())
}

/// The order of a mode with a degree.
fn order_of(
    checks: &Checks,
    key: &str,
    file: &DeformationFile,
    (name, degree): (&str, f64),
) -> Result<i32, SceneError> {
    let modes = file.modes.iter().flat_map(BTreeMap::keys);
    let orders = file.orders.iter().flatten();
    let is_mode = |name: &str| modes.clone().any(|mode| *mode == name);
    if let Some((stranger, _)) = orders.clone().find(|(name, _)| !is_mode(name)) {
        let names: Vec<&str> = modes.map(String::as_str).collect();
        let problem = format!("names \"{stranger}\", no mode of {}", names.join(", "));
        return Err(checks.bad_value(key, problem));
    }
    let order = orders.clone().find(|(own, _)| *own == name);
    let order = order.map_or(0.0, |(_, order)| *order);
    let problem = if order.fract() != 0.0 || order.abs() > degree {
        format!("must be whole numbers from -{degree} to {degree} for \"{name}\", not {order}")
    } else if order != 0.0 && file.motion == Some(ModeMotion::Tangential) {
        "does not belong to motion = \"tangential\"; use motion = \"gradient\" or \"curl\", or \
         remove it"
            .to_owned()
    } else {
        return Ok(order as i32);
    };
    Err(checks.bad_value(key, problem))
}

/// The direction from which azimuths about an axis are counted.
fn meridian(
    checks: &Checks,
    key: &str,
    file: &DeformationFile,
    axis: &Vector3<f64>,
    modes: &[(Harmonic, usize)],
) -> Result<Vector3<f64>, SceneError> {
    let has_orders = modes.iter().any(|(harmonic, _)| harmonic.order != 0);
    let next = default_meridian(axis);
    let own = match file.meridian.map(Vector3::from).or(next) {
        None if has_orders => {
            let problem = "is missing: azimuths about an axis that is no coordinate axis have no \
                           default; give a direction across the axis";
            return Err(checks.bad_value(key, problem));
        }
        own => own.unwrap_or_else(|| any_normal(axis)),
    };
    let across = own - own.dot(axis) * axis;
    match across.norm() > 1e-6 * own.norm() {
        true => Ok(across.normalize()),
        false => Err(checks.bad_value(key, "has no direction across the axis")),
    }
}

/// The coordinate axis that follows a coordinate axis, in either direction; none after others.
pub(super) fn default_meridian(axis: &Vector3<f64>) -> Option<Vector3<f64>> {
    let along = (0..3).find(|&k| axis[k].abs() == axis.norm())?;
    Some(Vector3::ith((along + 1) % 3, 1.0))
}

/// Fewest and most waves on the length of a tube: below a tenth the wave is a bow, whose angles are
/// differences of large numbers; no mesh follows more.
const WAVES: std::ops::RangeInclusive<f64> = 0.1..=20.0;

/// Amplitude and phase of the undulation of a tube.
fn enter_undulation(
    checks: &Checks,
    number: usize,
    file: &BodyFile,
    body: &mut Body,
    joints: &mut Vec<Joint>,
) -> Result<(), SceneError> {
    let given = file.deformation.as_ref();
    let Some(file) = given.filter(|file| file.kind == DeformationWord::Undulation) else {
        return Ok(());
    };
    let key = |key: &str| format!("bodies[{number}].deformation.{key}");
    let Shape::Tube(tube) = body.shape else {
        let problem = format!(
            "= \"undulation\" is unsupported for shape = \"{}\"; use shape = \"tube\"",
            body.shape.kind().word()
        );
        return Err(checks.bad_value(&key("kind"), problem));
    };
    let why = ": an undulation needs its amplitude at the start";
    let amplitude = checks.required(&key("amplitude"), file.amplitude, why)?;
    let waves = file.waves.unwrap_or(1.0);
    if !WAVES.contains(&waves) {
        let problem = format!("must be from {} to {}", WAVES.start(), WAVES.end());
        return Err(checks.bad_value(&key("waves"), problem));
    }
    let wave = Wave {
        kind: file.wave.unwrap_or_default(),
        envelope: file.envelope.unwrap_or_default(),
        waves,
    };
    let (start, first) = ([amplitude, file.phase.unwrap_or(0.0)], joints.len());
    for word in ["amplitude", "phase"] {
        let name = format!("{}.{word}", body.name);
        joints.push(Joint::deformation(&name, [number; 2], 0));
    }
    let [amplitude, phase] = start;
    body.shape = Shape::Tube(TubeShape {
        bend: Some(Bend {
            wave,
            amplitude,
            phase,
        }),
        ..tube
    });
    body.deformation = Some(Deformation::Undulation(Undulation {
        tube,
        wave,
        start,
        joints: [first, first + 1],
    }));
    Ok(())
}

/// Refuses what a deformation does not go with.
pub(super) fn check_bodies(
    checks: &Checks,
    file: &SceneFile,
    domain: &Domain,
    bodies: &[Body],
) -> Result<(), SceneError> {
    if bodies.iter().all(|body| body.deformation.is_none()) {
        return Ok(());
    }
    let refuse = |key: String, problem: &str| Err(checks.bad_value(&key, problem));
    if file.fluid.inertia != InertiaKind::None {
        return refuse(
            "fluid.inertia".to_owned(),
            "is unsupported for bodies that deform; remove it, or the deformation",
        );
    }
    if file.contact.is_some() {
        return refuse(
            "contact".to_owned(),
            "is unsupported for bodies that deform; remove it, or the deformation",
        );
    }
    if matches!(domain, Domain::Mesh { .. }) {
        return refuse(
            "domain.kind".to_owned(),
            "\"mesh\" has bodies that cannot deform; use \"surface\", or remove the deformation",
        );
    }
    for (number, body) in bodies.iter().enumerate() {
        let key = |key: &str| format!("bodies[{number}].{key}");
        let Some(deformation) = &body.deformation else {
            continue;
        };
        let has_mass = body.mass > 0.0 || body.inertia > 0.0;
        let changes_size = (deformation.sphere()).is_some_and(|own| own.modes.is_none());
        if has_mass && !changes_size {
            return refuse(
                key("mass"),
                "is unsupported for a body that changes more than its size: its surface does not \
                 tell how the mass inside moves; remove it, or the deformation",
            );
        }
        if has_mass && Vector3::from(file.gravity) != Vector3::zeros() {
            return refuse(
                key("mass"),
                "is unsupported beside gravity for a body that deforms, whose buoyancy changes; \
                 remove one of them, or give a force",
            );
        }
        if body.density.is_some() {
            return refuse(
                key("density"),
                "is unsupported for a body that deforms, whose buoyancy changes; remove it, or give \
                 a force",
            );
        }
        if body.slip.is_some() {
            return refuse(
                key("slip"),
                "is unsupported for a body that deforms; use tangential modes, or remove one",
            );
        }
    }
    Ok(())
}

/// Values of the coordinates at the start, unless the gait determines them: the sphere of the
/// scene.
pub(super) fn initial_values(bodies: &[Body]) -> Vec<(usize, f64)> {
    let mut values = Vec::new();
    for body in bodies {
        let deformation = match &body.deformation {
            None => continue,
            Some(Deformation::Undulation(tube)) => {
                values.extend(tube.joints.into_iter().zip(tube.start));
                continue;
            }
            Some(Deformation::Triangles(of)) => {
                let starts = of.coordinates.iter().map(|own| own.start);
                values.extend(of.joints.iter().copied().zip(starts));
                continue;
            }
            Some(Deformation::Sphere(sphere)) => sphere,
        };
        match deformation.size {
            Some(SizeCoordinate::Radius(joint)) => values.push((joint, deformation.radius)),
            Some(SizeCoordinate::Volume(joint)) => values.push((joint, body.shape.volume())),
            Some(SizeCoordinate::Remainder { .. }) | None => {}
        }
        let modes = deformation
            .modes
            .iter()
            .flat_map(|modes| &modes.coordinates);
        values.extend(modes.map(|(_, joint)| (*joint, 0.0)));
    }
    values
}

/// Refuses gaits along which bodies deform too much, or change their volume in a container.
pub(super) fn check_gait(
    checks: &Checks,
    (domain, bodies): (&Domain, &[Body]),
    (gait, table): (&Gait, Option<&GaitTable>),
    set: &Articulation,
) -> Result<(), SceneError> {
    if bodies.iter().all(|body| body.deformation.is_none()) {
        return Ok(());
    }
    let start = set.initial_shape();
    let problem_of = |values: &[f64]| {
        bodies.iter().find_map(|body| {
            let problem = body.deformation.as_ref()?.problem(values)?;
            Some(format!("'{}' {problem}", body.name))
        })
    };
    if let Some(problem) = problem_of(start) {
        return Err(checks.bad_value("gait", format!("is impossible at the start: {problem}")));
    }
    check_waves(checks, bodies, (gait, table), start)?;
    check_turns(checks, bodies, gait, set)?;
    // All cycles after the second one repeat the shapes of the second one.
    let gait = Gait {
        cycles: gait.cycles.min(2),
        phases: gait.phases.clone(),
    };
    let is_closed = domain.keeps_volume();
    for span in spans(&gait, start)? {
        let refuse = |s: f64, problem: String| {
            let key = span_key(checks, table, &span);
            let part = (1000.0 * s).round() / 10.0;
            let problem = format!(
                "is impossible in phase {} at {part} % of it: {problem}",
                span.phase + 1
            );
            Err(checks.bad_value(&key, problem))
        };
        if let Some((s, name, problem)) = FoldSearch::new(&span, bodies).run() {
            return refuse(s, format!("'{name}' {problem}"));
        }
        for k in (0..=PARTS).filter(|_| is_closed) {
            let s = k as f64 / PARTS as f64;
            if let Some(problem) = volume_problem(bodies, &span.shape(s), &span.rates(s)) {
                return refuse(s, problem);
            }
        }
    }
    Ok(())
}

/// Refuses waves and frames that stand still from the second cycle on, and values of the body that
/// are not those at the start of the gait.
fn check_waves(
    checks: &Checks,
    bodies: &[Body],
    (gait, table): (&Gait, Option<&GaitTable>),
    start: &[f64],
) -> Result<(), SceneError> {
    let last = spans(gait, start)?.nth(gait.phases.len().saturating_sub(1));
    for (number, body) in bodies.iter().enumerate() {
        // Keys of the body with their values and joints.
        let written: Vec<(&str, f64, usize)> = match &body.deformation {
            Some(Deformation::Undulation(tube)) => {
                let [amplitude, phase] = tube.start;
                let [of_amplitude, of_phase] = tube.joints;
                vec![
                    ("amplitude", amplitude, of_amplitude),
                    ("phase", phase, of_phase),
                ]
            }
            Some(Deformation::Triangles(of)) => {
                let coordinates = of.joints.iter().zip(&of.coordinates).take(1);
                let key = |(joint, own): (&usize, &ShapeCoordinate)| (FRAME, own.start, *joint);
                coordinates.map(key).collect()
            }
            _ => continue,
        };
        for (word, given, joint) in written {
            let key = format!("bodies[{number}].deformation.{word}");
            let differs = (given - start[joint]).abs() > 1e-9 * start[joint].abs().max(1.0);
            if checks.0.has(&key) && differs {
                let problem = format!(
                    "is {given}, and the gait starts at {}; give that, or change the gait",
                    start[joint]
                );
                return Err(checks.bad_value(&key, problem));
            }
        }
        let Some(last) = last
            .as_ref()
            .filter(|last| gait.cycles > 1 && last.is_linear())
        else {
            continue;
        };
        let periods = body.deformation.as_ref().map(Deformation::periods);
        let mut joints = periods.into_iter().flatten().map(|(joint, _)| joint);
        if let Some(joint) = joints.find(|joint| last.to[*joint] != start[*joint]) {
            let what = match &body.deformation {
                Some(Deformation::Undulation(_)) => "phase",
                _ => "periodic coordinate",
            };
            let problem = format!(
                "must be 1: the {what} of '{}' ends a cycle at {}, where the next one would leave \
                 it; turn it by more in one cycle",
                body.name, last.to[joint]
            );
            let key = match table {
                Some(_) => "gait.file",
                None => "gait.cycles",
            };
            return Err(checks.bad_value(key, problem));
        }
    }
    Ok(())
}

/// Refuses coordinates that turn by other changes than their periods: each cycle would begin with
/// another shape.
fn check_turns(
    checks: &Checks,
    bodies: &[Body],
    gait: &Gait,
    set: &Articulation,
) -> Result<(), SceneError> {
    let Some(ShapePath::Harmonic { turns, .. }) = gait.phases.first().map(|phase| &phase.path)
    else {
        return Ok(());
    };
    let deformations = bodies.iter().filter_map(|body| body.deformation.as_ref());
    let periods: Vec<_> = deformations.flat_map(Deformation::periods).collect();
    for (joint, change) in turns {
        let own = &set.joints()[*joint];
        if !own.kind.is_deformation() {
            continue;
        }
        let period = periods.iter().find(|(other, _)| other == joint);
        let problem = match period {
            Some((_, period)) if is_whole(*change, *period) => continue,
            Some((_, period)) => format!("must turn by whole periods of {period}, not by {change}"),
            None => "has no period, so that it cannot turn; use amplitude".to_owned(),
        };
        return Err(checks.bad_value("gait.harmonics", format!("\"{}\" {problem}", own.name)));
    }
    Ok(())
}

/// The key of a phase span.
fn span_key(checks: &Checks, table: Option<&GaitTable>, span: &PhaseSpan) -> String {
    let phase = |name: &str| format!("gait.phases[{}].{name}", span.phase);
    match (table, span.is_linear()) {
        (Some(_), _) => "gait.file".to_owned(),
        (None, true) if checks.0.has(&phase("targets")) => phase("targets"),
        (None, true) => phase("length"),
        (None, false) => "gait.harmonics".to_owned(),
    }
}
