//! Surfaces of triangles that deform: by frames in files, and by the motion of a program.

use std::sync::Arc;

use nalgebra::Vector3;
use rigid::Joint;

use crate::body::Body;
use crate::checks::Checks;
use crate::deformation::Deformation;
use crate::error::SceneError;
use crate::frames::Frames;
use crate::keys::{BodyFile, DeformationFile};
use crate::shape::Shape;
use crate::shapes::FileShape;
use crate::surface_shape::{SurfaceFiles, SurfaceKeys};
use crate::triangle_deformation::{MotionSource, STEP, STEPS, TriangleDeformation};
use crate::words::DeformationWord;

/// Fewest frames: of two the spline is a line, and a period of two is the way there and back.
const MIN_FRAMES: usize = 2;
const MIN_PERIODIC_FRAMES: usize = 3;

/// Most frames; more have more digits than files of single precision.
const MAX_FRAMES: usize = 1000;

/// Enters the coordinate of frames, and those of a motion of a program.
pub(super) fn enter(
    checks: &Checks,
    (number, file): (usize, &BodyFile),
    body: &mut Body,
    joints: &mut Vec<Joint>,
    files: &mut SurfaceFiles,
) -> Result<(), SceneError> {
    let frames = file.deformation.as_ref();
    let frames = frames.filter(|file| file.kind == DeformationWord::Frames);
    let own = checks.0.motions().get(&body.name);
    if frames.is_none() && own.is_none() {
        return Ok(());
    }
    let key = format!("bodies[{number}].deformation");
    if own.is_some() && (frames.is_some() || body.deformation.is_some()) {
        return Err(checks.bad_value(&key, "is given twice: here, and by a program"));
    }
    let Shape::Surface(shape) = &body.shape else {
        let problem = format!(
            "is unsupported for shape = \"{}\": the vertices of a file move; use shape = \"surface\"",
            body.shape.kind().word()
        );
        return Err(checks.bad_value(&key, problem));
    };
    let source = match (frames, own) {
        (Some(frames), _) => {
            let frames = read_frames(checks, (number, file, frames), shape, files)?;
            MotionSource::Frames(Arc::new(frames))
        }
        (None, Some(own)) => MotionSource::Own(own.clone()),
        (None, None) => return Ok(()),
    };
    let surface = shape.shape.surface.clone();
    let orientation = body.shape.orientation();
    let deformation = TriangleDeformation::new(surface, orientation, source, joints.len());
    if let Some(problem) = deformation.defect() {
        return Err(checks.bad_value(&key, problem));
    }
    for coordinate in &deformation.coordinates {
        let name = format!("{}.{}", body.name, coordinate.name);
        joints.push(Joint::deformation(&name, [number; 2], 0));
    }
    body.deformation = Some(Deformation::Triangles(deformation));
    Ok(())
}

fn read_frames(
    checks: &Checks,
    (number, body, file): (usize, &BodyFile, &DeformationFile),
    first: &FileShape,
    surfaces: &mut SurfaceFiles,
) -> Result<Frames, SceneError> {
    let key = |key: &str| format!("bodies[{number}].deformation.{key}");
    let (key_files, key_at) = (key("files"), key("at"));
    let why = ": name the files of the frames after the first one";
    let names = checks.required(&key_files, file.files.as_ref(), why)?;
    let is_periodic = file.periodic.unwrap_or(false);
    let count = 1 + names.len();
    let least = match is_periodic {
        true => MIN_PERIODIC_FRAMES,
        false => MIN_FRAMES,
    };
    if !(least..=MAX_FRAMES).contains(&count) {
        let problem = format!(
            "has {} files: with that of the body there are {count} frames, and {} to {MAX_FRAMES} \
             are possible; {}",
            names.len(),
            match is_periodic {
                true => format!("for periodic = true {least}"),
                false => format!("{least}"),
            },
            match count < least {
                true => "add files",
                false => "leave some out",
            },
        );
        return Err(checks.bad_value(&key_files, problem));
    }
    let at = values(checks, &key_at, file, count + usize::from(is_periodic))?;
    let own = &first.shape;
    let mut positions = vec![own.surface.vertices()];
    let mut paths = Vec::with_capacity(names.len());
    for (index, name) in names.iter().enumerate() {
        let refuse = |problem: String| {
            let problem = format!("is refused at frame {} ({name}): {problem}", index + 2);
            Err(checks.bad_value(&key_files, problem))
        };
        let keys = SurfaceKeys {
            group: &format!("bodies[{number}]"),
            file: &Some(name.clone()),
            kind: body.surface_kind,
            scale: body.scale,
        };
        let frame = match surfaces.read_at(checks, &key_files, keys) {
            Ok(frame) => frame.about(Some(own.centre)),
            Err(SceneError::BadValue { problem, .. }) => {
                return refuse(problem.trim_start_matches("is refused: ").to_owned());
            }
            Err(error) => return Err(error),
        };
        let [triangles, others] = [&own.surface, &frame.surface].map(|surface| surface.triangles());
        if triangles.len() != others.len() {
            return refuse(format!(
                "it has {} triangles, and the first frame has {}; frames are one triangulation \
                 whose vertices move: export them from one mesh",
                others.len(),
                triangles.len()
            ));
        }
        let mut both = triangles.iter().zip(others);
        if let Some(triangle) = both.position(|(own, other)| own != other) {
            return refuse(format!(
                "its triangle {} has the vertices {:?}, and that of the first frame {:?}; export \
                 the frames from one mesh, with vertices in the same order",
                triangle + 1,
                others[triangle].map(|vertex| vertex + 1),
                triangles[triangle].map(|vertex| vertex + 1),
            ));
        }
        let vertices = frame.surface.vertices();
        if let Err(error) = own.surface.check_moved(name, vertices.clone()) {
            return refuse(error.to_string());
        }
        positions.push(vertices);
        paths.push(frame.file);
    }
    let start = file.frame.unwrap_or(at[0]);
    if !(start.is_finite()) {
        return Err(checks.bad_value(&key("frame"), "must be a finite number"));
    }
    let mut frames = Frames::new(positions, at, is_periodic);
    (frames.files, frames.start) = (paths, start);
    frames.keeps_volume = file.keep_volume.unwrap_or(false);
    Ok(frames)
}

/// Values of the coordinate at the frames.
fn values(
    checks: &Checks,
    key: &str,
    file: &DeformationFile,
    count: usize,
) -> Result<Vec<f64>, SceneError> {
    let Some(at) = &file.at else {
        return Ok((0..count).map(|k| k as f64).collect());
    };
    if at.len() != count {
        let problem = format!(
            "has {} values, and {count} are needed: one for each frame{}",
            at.len(),
            match file.periodic {
                Some(true) => ", and one at which the first frame follows the last one",
                _ => "",
            }
        );
        return Err(checks.bad_value(key, problem));
    }
    if let Some(k) = (1..count).find(|&k| at[k].is_nan() || at[k] <= at[k - 1]) {
        let problem = format!(
            "must increase, and {} follows {}; sort the frames",
            at[k],
            at[k - 1]
        );
        return Err(checks.bad_value(key, problem));
    }
    match at.iter().all(|x| x.is_finite()) {
        true => Ok(at.clone()),
        false => Err(checks.bad_value(key, "must have finite numbers")),
    }
}

/// Largest difference of velocities from those of differences of positions, over the largest speed.
const CONTRADICTION: f64 = 1e-5;

impl TriangleDeformation {
    /// What is wrong with the motion at the start, whatever the gait.
    fn defect(&self) -> Option<String> {
        let motion = self.motion();
        if self.coordinates.is_empty() {
            return Some("has no shape coordinate, so nothing deforms; name one".to_owned());
        }
        let start: Vec<f64> = self.coordinates.iter().map(|own| own.start).collect();
        let (_, radius) = mesh::Surface::bounding_ball(&self.surface);
        for (k, own) in self.coordinates.iter().enumerate() {
            let name = &own.name;
            let is_known = self.coordinates[..k]
                .iter()
                .any(|other| other.name == *name);
            if name.is_empty() || name.contains('.') || is_known {
                return Some(format!(
                    "has a coordinate with the name \"{name}\"; use different names without dots"
                ));
            }
            let speed = motion.largest_speed(k);
            if !(own.start.is_finite() && speed >= 0.0 && speed.is_finite()) {
                return Some(format!(
                    "starts '{name}' at {} with the largest speed {speed}; give finite numbers, \
                     the speed not negative",
                    own.start
                ));
            }
            if let Some(period) = own
                .period
                .filter(|period| !(*period > 0.0 && period.is_finite()))
            {
                return Some(format!(
                    "has the period {period} of '{name}'; it must be positive and finite"
                ));
            }
            // Those of frames are derivatives of their splines, whose third derivatives jump.
            if speed == 0.0 || matches!(self.source, MotionSource::Frames(_)) {
                continue;
            }
            let width = (STEP * radius / speed).min(STEP * own.period.unwrap_or(f64::MAX));
            let moved = |steps: f64| {
                let mut amplitudes = start.clone();
                amplitudes[k] += steps * width;
                self.positions(&amplitudes)
            };
            let ends = STEPS.map(|(steps, weight)| (moved(steps), weight / width));
            let velocities = self.velocities(&start, k);
            for (vertex, velocity) in velocities.iter().enumerate() {
                let terms = ends.iter().map(|(end, weight)| *weight * end[vertex]);
                let found: Vector3<f64> = terms.sum();
                let error = (found - velocity).norm();
                if error.is_nan() || error > CONTRADICTION * speed {
                    return Some(format!(
                        "contradicts itself: for a rate of one of '{name}', vertex {} moves at \
                         {velocity:?} by the velocity, and at {found:?} by differences of \
                         positions; let the velocity be the derivative of the position",
                        vertex + 1
                    ));
                }
                if velocity.norm() > speed * (1.0 + CONTRADICTION) {
                    return Some(format!(
                        "moves vertex {} at {} for a rate of one of '{name}', faster than its \
                         largest speed {speed}; enlarge that",
                        vertex + 1,
                        velocity.norm()
                    ));
                }
            }
        }
        None
    }
}
