//! Writing of a scene as a file in which every key is written out.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use nalgebra::Vector3;
use rheology::Law;
use rigid::{Freedom, Joint, JointDrive};

use crate::body::Body;
use crate::deformation::Deformation;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::flow::Background;
use crate::gait::Phase;
use crate::harmonics::Harmonic;
use crate::joints::JointKeys;
use crate::keys::{
    BackgroundFile, BodyFile, ContactFile, DeformationFile, DomainFile, DriveFile, FieldFile,
    FluidFile, ForceFile, GaitFile, HarmonicFile, HarmonicForceFile, JointFile, LoadFile,
    PhaseAngles, PhaseFile, SceneFile, SlipFile,
};
use crate::loads::{DrivingLoad, VectorOscillation};
use crate::scene::{Rheology, Scene};
use crate::shape_path::{ShapePath, Sine};
use crate::sphere_deformation::SizeCoordinate;
use crate::triangle_deformation::MotionSource;
use crate::words::{AxesKind, DeformationWord, DriveKind, GaitKind, LawKind, RheologyKind};

impl Scene {
    /// The scene as TOML with every key written out, overrides and defaults included.
    ///
    /// Names of files are relative to the working directory; [`Self::to_toml_in`] is for a scene
    /// that is written into a folder.
    ///
    /// # Errors
    /// [`SceneError::NotApplicable`] for a gait with a path of a program ([`crate::JointPath`]) or
    /// a body with a motion of one ([`crate::MaterialMotion`]);
    /// [`SceneError::Unwritable`], for which no scene is known.
    pub fn to_toml(&self) -> Result<String, SceneError> {
        Ok(toml::to_string(&self.checked_file()?)?)
    }

    /// The scene as TOML like [`Self::to_toml`], with the names of files relative to the folder in
    /// which the scene will be: [`Scene::read`] resolves them from there.
    ///
    /// # Errors
    /// Those of [`Self::to_toml`].
    pub fn to_toml_in(&self, folder: impl AsRef<Path>) -> Result<String, SceneError> {
        let folder = folder.as_ref();
        let mut file = self.checked_file()?;
        let frames = file.bodies.iter_mut();
        let frames = frames.filter_map(|body| body.deformation.as_mut()?.files.as_mut());
        for name in frames.flatten() {
            *name = seen_from(folder, Path::new(name));
        }
        let bodies = file.bodies.iter_mut().map(|body| &mut body.file);
        for name in bodies.chain([&mut file.domain.file, &mut file.gait.file]) {
            *name = name.take().map(|name| seen_from(folder, Path::new(&name)));
        }
        Ok(toml::to_string(&file)?)
    }

    fn checked_file(&self) -> Result<SceneFile, SceneError> {
        let is_own = |phase: &Phase| matches!(phase.path, ShapePath::Own(_));
        if self.gait.phases.iter().any(is_own) {
            return Err(SceneError::NotApplicable {
                place: self.place("gait"),
                problem: "the gait is a path of a program, which no file can contain; use \
                          `swimmer::simulate`, which writes none"
                    .to_owned(),
            });
        }
        if !self.document.motions().is_empty() {
            return Err(SceneError::NotApplicable {
                place: self.place("bodies"),
                problem: "a body deforms by a motion of a program, which no file can contain; use \
                          `swimmer::simulate`, which writes none"
                    .to_owned(),
            });
        }
        Ok(scene_file(self))
    }
}

fn scene_file(scene: &Scene) -> SceneFile {
    let joints = scene.articulation.joints();
    let name = |body: usize| scene.bodies[body].name.clone();
    SceneFile {
        fluid: FluidFile {
            viscosity: scene.viscosity,
            density: Some(scene.density).filter(|density| *density > 0.0),
            inertia: scene.inertia.kind,
            start: scene.inertia.start,
            time_step: (scene.inertia.time_step).or(scene.noise.and_then(|noise| noise.time_step)),
            thermal_energy: scene.noise.map(|noise| noise.energy),
            seed: scene.noise.map(|noise| noise.seed),
            ..law_file(scene.rheology.as_ref())
        },
        gravity: scene.gravity.into(),
        background: scene.background.as_ref().map(background_file),
        domain: domain_file(&scene.domain),
        field: scene.field.as_ref().map(field_file),
        contact: scene.repulsion.map(|repulsion| ContactFile {
            range: Some(repulsion.range),
            strength: Some(repulsion.strength),
        }),
        bodies: (scene.bodies.iter())
            .map(|body| body_file(body, joints))
            .collect(),
        links: (joints.iter().enumerate())
            .filter(|(_, joint)| !joint.kind.is_deformation() || joint.body != joint.to)
            .map(|(number, joint)| {
                let mut file = joint_file(joint);
                (file.body, file.to) = (Some(name(joint.body)), Some(name(joint.to)));
                let mut forces = scene.joint_forces.iter();
                if let Some(force) = forces.find(|force| force.sine.joint == number) {
                    file.drive = Some(DriveKind::Force);
                    file.force = Some(ForceFile::Harmonic(HarmonicForceFile {
                        mean: joint.passive_drive().map_or(0.0, |drive| drive.force),
                        amplitude: Some(force.sine.amplitude),
                        phase: force.sine.phase,
                        order: force.sine.order,
                        period: Some(force.period),
                    }));
                }
                file
            })
            .collect(),
        // Their bodies are written out.
        copies: Vec::new(),
        gait: gait_file(scene),
        model: scene.model,
        fem: scene.fem,
        optimise: scene.optimise.clone(),
        learn: scene.learn.clone(),
        output: scene.output.clone(),
    }
}

fn gait_file(scene: &Scene) -> GaitFile {
    let (gait, joints) = (&scene.gait, scene.articulation.joints());
    let name = |joint: usize| joints[joint].name.clone();
    let mut file = GaitFile {
        arms: scene.articulation.arms().into(),
        cycles: gait.cycles,
        periodic: scene.starts_periodic,
        ..GaitFile::default()
    };
    if let Some(table) = &scene.gait_table {
        file.kind = Some(GaitKind::Table);
        file.file = Some(table.file.display().to_string());
        file.interpolation = Some(table.interpolation);
        return file;
    }
    for phase in &gait.phases {
        let mut phase_file = PhaseFile {
            duration: phase.duration,
            ..PhaseFile::default()
        };
        match &phase.path {
            ShapePath::Linear(changes) => match changes[..] {
                [] => {}
                [(joint, length)] => {
                    phase_file.link = Some(name(joint));
                    phase_file.length = Some(length);
                }
                _ => {
                    let targets = changes.iter().map(|&(joint, length)| (name(joint), length));
                    phase_file.targets = Some(targets.collect());
                }
            },
            // Splines are from a table, and scenes with own paths are not written.
            ShapePath::Spline(_) | ShapePath::Own(_) => {}
            ShapePath::Harmonic { sines, turns, .. } => {
                let at_start = |joint: usize| -> f64 {
                    let terms = sines.iter().filter(|sine| sine.joint == joint);
                    terms.map(|sine| sine.at(0.0)).sum()
                };
                let sine_file = |sine: &Sine| HarmonicFile {
                    link: Some(name(sine.joint)),
                    // Slides start where the bodies are, others from their values.
                    mean: (joints[sine.joint].kind.freedom() != Freedom::Distance).then(|| {
                        scene.articulation.initial_shape()[sine.joint] - at_start(sine.joint)
                    }),
                    amplitude: Some(sine.amplitude),
                    turn: None,
                    phase: sine.phase,
                    order: sine.order,
                };
                let turn_file = |(joint, change): &(usize, f64)| HarmonicFile {
                    link: Some(name(*joint)),
                    turn: Some(*change),
                    ..HarmonicFile::default()
                };
                let all = sines.iter().map(sine_file);
                file.harmonics = Some(all.chain(turns.iter().map(turn_file)).collect());
                *file.period.get_or_insert(0.0) += phase.duration;
                continue;
            }
        }
        file.phases.get_or_insert_default().push(phase_file);
    }
    file
}

/// The keys of a joint, without those of its bodies.
pub(crate) fn joint_file(joint: &Joint) -> JointFile {
    let keys = JointKeys::from_kind(&joint.kind);
    let mut file = JointFile {
        name: Some(joint.name.clone()),
        joint: keys.word,
        axis: keys.axis,
        pivot: keys.pivot,
        pitch: keys.pitch,
        ..JointFile::default()
    };
    let JointDrive::Passive(passive) = joint.drive else {
        return file;
    };
    if !joint.kind.has_value() {
        return file;
    }
    file.damping = Some(passive.damping);
    file.drive = Some(DriveKind::Free);
    if passive.stiffness != 0.0 {
        file.drive = Some(DriveKind::Spring);
        // A constant force on a spring shifts its rest.
        let shift = match passive.force {
            0.0 => 0.0,
            force => force / passive.stiffness,
        };
        (file.stiffness, file.rest) = (Some(passive.stiffness), Some(passive.rest + shift));
    } else if passive.force != 0.0 {
        file.drive = Some(DriveKind::Force);
        file.force = Some(ForceFile::Constant(passive.force));
    }
    file
}

fn background_file(background: &Background) -> BackgroundFile {
    let (mut velocity, mut pressure_gradient, mut gradient) = (None, None, None);
    match background {
        Background::Uniform { velocity: v } => velocity = Some((*v).into()),
        Background::PressureGradient { gradient: g } => pressure_gradient = Some((*g).into()),
        Background::Linear { gradient: g, .. } => {
            gradient = Some([0, 1, 2].map(|row| [0, 1, 2].map(|column| g[(row, column)])));
        }
        Background::Poiseuille { velocity: v, .. } => velocity = Some([*v, 0.0, 0.0]),
    }
    BackgroundFile {
        kind: Some(background.kind()),
        velocity,
        pressure_gradient,
        gradient,
    }
}

/// The group `domain` of a scene file.
pub(crate) fn domain_file(domain: &Domain) -> DomainFile {
    let mut file = DomainFile {
        kind: Some(domain.kind()),
        ..DomainFile::default()
    };
    match domain {
        Domain::Unbounded | Domain::Wall => {}
        Domain::Ball { radius } | Domain::Cylinder { radius } => file.radius = Some(*radius),
        Domain::Box { size } | Domain::Periodic { size } => file.size = Some((*size).into()),
        Domain::Surface(shape) => {
            file.file = Some(shape.file.display().to_string());
            (file.surface_kind, file.scale) = (Some(shape.kind), Some(shape.scale));
        }
        Domain::Mesh {
            file: path, walls, ..
        } => {
            file.file = Some(path.display().to_string());
            file.walls = Some(walls.clone());
        }
    }
    file
}

fn body_file(body: &Body, joints: &[Joint]) -> BodyFile {
    BodyFile {
        deformation: (body.deformation.as_ref())
            .and_then(|deformation| deformation_file(&body.name, deformation, joints)),
        name: Some(body.name.clone()),
        position: Some(body.position.into()),
        surface: body.surface.clone(),
        force: load_file(&body.force, body.driving_force.as_ref()),
        torque: Some(load_file(&body.torque, body.driving_torque.as_ref()))
            .filter(|_| body.shape.has_surface()),
        moment: body.moment.into(),
        fixed: body.fixed,
        velocity: body.velocity.as_ref().map(velocity_file),
        angular_velocity: body.angular_velocity.as_ref().map(velocity_file),
        mass: body.mass,
        inertia: body.inertia,
        density: body.density,
        slip: body.slip.map(|slip| SlipFile {
            b1: slip.b1,
            b2: slip.b2,
            axis: slip.axis.into(),
        }),
        ..body.shape.to_keys()
    }
}

/// The key `deformation` of a body; none for a volume that two bodies exchange.
fn deformation_file(
    body: &str,
    deformation: &Deformation,
    joints: &[Joint],
) -> Option<DeformationFile> {
    let deformation = match deformation {
        Deformation::Sphere(sphere) => sphere,
        Deformation::Undulation(tube) => {
            let [amplitude, phase] = tube.start;
            return Some(DeformationFile {
                kind: DeformationWord::Undulation,
                wave: Some(tube.wave.kind),
                envelope: Some(tube.wave.envelope),
                waves: Some(tube.wave.waves),
                amplitude: Some(amplitude),
                phase: Some(phase),
                ..DeformationFile::default()
            });
        }
        Deformation::Triangles(of) => {
            let MotionSource::Frames(frames) = &of.source else {
                return None;
            };
            let files = frames.files.iter().map(|file| file.display().to_string());
            return Some(DeformationFile {
                kind: DeformationWord::Frames,
                files: Some(files.collect()),
                at: Some(frames.at.clone()),
                periodic: Some(frames.is_periodic),
                frame: Some(frames.start),
                keep_volume: Some(frames.keeps_volume),
                ..DeformationFile::default()
            });
        }
    };
    let prefix = format!("{body}.");
    let named = |&(harmonic, joint): &(Harmonic, usize)| {
        let name = joints.get(joint)?.name.strip_prefix(&prefix)?;
        Some((name.to_owned(), harmonic))
    };
    if let Some(modes) = &deformation.modes {
        let of = |number: &dyn Fn(Harmonic) -> Option<f64>| -> BTreeMap<String, f64> {
            let all = modes.coordinates.iter().filter_map(named);
            all.filter_map(|(name, harmonic)| Some((name, number(harmonic)?)))
                .collect()
        };
        let order = |harmonic: Harmonic| Some(f64::from(harmonic.order)).filter(|m| *m != 0.0);
        let orders = Some(of(&order)).filter(|orders| !orders.is_empty());
        return Some(DeformationFile {
            kind: DeformationWord::Modes,
            modes: Some(of(&|harmonic| Some(harmonic.degree as f64))),
            meridian: orders.as_ref().map(|_| modes.meridian.into()),
            orders,
            motion: Some(modes.motion),
            axis: Some(modes.axis.into()),
            ..DeformationFile::default()
        });
    }
    let (kind, joint) = match deformation.size? {
        SizeCoordinate::Radius(joint) => (DeformationWord::Radius, joint),
        SizeCoordinate::Volume(joint) => (DeformationWord::Volume, joint),
        SizeCoordinate::Remainder { .. } => return None,
    };
    let is_own = joints.get(joint)?.body == joints.get(joint)?.to;
    is_own.then(|| DeformationFile {
        kind,
        ..DeformationFile::default()
    })
}

fn velocity_file(velocity: &VectorOscillation) -> LoadFile {
    let given = DrivingLoad {
        vector: *velocity,
        axes: AxesKind::Laboratory,
    };
    load_file(&velocity.mean, velocity.oscillates().then_some(&given))
}

fn load_file(constant: &Vector3<f64>, driving: Option<&DrivingLoad>) -> LoadFile {
    match driving {
        None => LoadFile::Constant((*constant).into()),
        Some(DrivingLoad { vector, axes }) => LoadFile::Driving(DriveFile {
            mean: vector.mean.into(),
            amplitude: vector.amplitude.into(),
            phase: PhaseAngles::Each(vector.phase.into()),
            order: vector.order,
            period: Some(vector.period),
            axes: *axes,
        }),
    }
}

fn field_file(field: &VectorOscillation) -> FieldFile {
    FieldFile {
        mean: Some(field.mean.into()),
        amplitude: Some(field.amplitude.into()),
        phase: Some(field.phase.into()),
        order: Some(field.order),
        period: Some(field.period),
    }
}

/// The name of a file seen from a folder; absolute if both have no common root.
///
/// Both are relative to the working directory, or absolute. Symbolic links are followed, because
/// `..` leads out of the folder to which a link points.
fn seen_from(folder: &Path, file: &Path) -> String {
    let full = |path: &Path| {
        let canonical = std::fs::canonicalize(path);
        canonical.or_else(|_| std::path::absolute(path))
    };
    // The name itself may be a link to a file elsewhere, and stays.
    let parent = match file.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let name = match (full(folder), full(parent), file.file_name()) {
        (Ok(folder), Ok(parent), Some(name)) => between(&folder, &parent.join(name)),
        _ => file.to_owned(),
    };
    name.display().to_string()
}

/// The way from a folder to a file, both absolute.
fn between(folder: &Path, file: &Path) -> PathBuf {
    let pairs = folder.components().zip(file.components());
    let common = pairs.take_while(|(a, b)| a == b).count();
    if common == 0 {
        return file.to_owned();
    }
    let up = folder
        .components()
        .skip(common)
        .map(|_| Component::ParentDir);
    up.chain(file.components().skip(common)).collect()
}

/// The keys of a law.
fn law_file(rheology: Option<&Rheology>) -> FluidFile {
    let Some(Rheology { law, kind }) = rheology else {
        return FluidFile::default();
    };
    let mut file = FluidFile {
        rheology: Some(*kind).filter(|kind| *kind != RheologyKind::Full),
        ..FluidFile::default()
    };
    let not_zero = |value: f64| Some(value).filter(|value| *value != 0.0);
    match *law {
        Law::Carreau {
            zero_shear_viscosity,
            infinite_shear_viscosity,
            relaxation_time,
            index,
        }
        | Law::CarreauYasuda {
            zero_shear_viscosity,
            infinite_shear_viscosity,
            relaxation_time,
            index,
            ..
        }
        | Law::Cross {
            zero_shear_viscosity,
            infinite_shear_viscosity,
            relaxation_time,
            index,
        } => {
            file.law = LawKind::Carreau;
            file.zero_shear_viscosity = Some(zero_shear_viscosity);
            file.infinite_shear_viscosity = not_zero(infinite_shear_viscosity);
            file.relaxation_time = Some(relaxation_time);
            file.index = Some(index);
            if let Law::CarreauYasuda { transition, .. } = *law {
                (file.law, file.transition) = (LawKind::CarreauYasuda, Some(transition));
            } else if let Law::Cross { .. } = *law {
                file.law = LawKind::Cross;
            }
        }
        Law::PowerLaw {
            consistency,
            index,
            regularisation,
        }
        | Law::HerschelBulkley {
            consistency,
            index,
            regularisation,
            ..
        } => {
            file.law = LawKind::PowerLaw;
            file.consistency = Some(consistency);
            file.index = Some(index);
            file.regularisation = Some(regularisation);
            if let Law::HerschelBulkley { yield_stress, .. } = *law {
                (file.law, file.yield_stress) = (LawKind::HerschelBulkley, Some(yield_stress));
            }
        }
        // `Law` may get more kinds; a scene has no others
        _ => {}
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_seen_from_folders_above_beside_and_below() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("out/deep")).unwrap();
        for (from, file, name) in [
            ("out", "x.stl", "../x.stl"),
            ("out/deep", "x.stl", "../../x.stl"),
            ("out", "out/x.csv", "x.csv"),
            ("out", "out/deep/x.csv", "deep/x.csv"),
            ("out/deep", "out/../x.stl", "../../x.stl"),
        ] {
            let found = seen_from(&at(from), &at(file));
            assert_eq!(PathBuf::from(found), PathBuf::from(name), "{from} {file}");
        }
        // Relative to the working directory, which is another one.
        let found = seen_from(folder.path(), Path::new("Cargo.toml"));
        let again = std::fs::canonicalize(folder.path().join(found)).unwrap();
        assert_eq!(again, std::fs::canonicalize("Cargo.toml").unwrap());
    }
}
