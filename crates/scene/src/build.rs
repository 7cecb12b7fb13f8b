//! From the keys of a document to a scene that makes sense.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Vector3;
use rigid::{Articulation, Link};

use crate::clearance;
use crate::document::Document;
use crate::error::SceneError;
use crate::file::{BodyFile, DomainFile, GaitFile, LinkFile, SceneFile};
use crate::gait::{Gait, Phase};
use crate::keys;
use crate::scene::{Body, Domain, FemOptions, ModelOptions, Scene};
use crate::shape::Shape;
use crate::words::{
    ArmsKind, DomainKind, EstimatesKind, FormulationKind, GeometryKind, MeshMotionKind, MirrorKind,
    ModelKind, ShapeKind, SolverKind,
};

/// Makes errors that say where.
pub(crate) struct Checks<'a>(pub &'a Document);

impl Checks<'_> {
    pub fn bad(&self, key: &str, problem: impl Into<String>) -> SceneError {
        SceneError::BadValue {
            place: self.0.place(key),
            key: key.to_owned(),
            problem: problem.into(),
        }
    }

    pub fn required<T>(&self, key: &str, value: Option<T>, why: &str) -> Result<T, SceneError> {
        value.ok_or_else(|| self.bad(key, format!("is missing{why}")))
    }

    fn below_one(&self, key: &str, value: f64, least: f64) -> Result<f64, SceneError> {
        match (least..1.0).contains(&value) {
            true => Ok(value),
            false => Err(self.bad(
                key,
                format!("must be below 1 and at least {least:e}, not {value}"),
            )),
        }
    }
}

/// The word of a key, whose kind the document has checked, or its default.
fn word<T>(word: Option<&str>, of: fn(&str) -> Option<T>, default: T) -> T {
    word.and_then(of).unwrap_or(default)
}

impl Scene {
    /// Reads and checks a scene file, with overrides written `key=value` (as for `--set`).
    ///
    /// # Errors
    /// The first thing that is wrong, with file, line, key and what to do.
    pub fn read(path: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        let mut document = Document::read(path)?;
        overrides
            .iter()
            .try_for_each(|assignment| document.set(assignment))?;
        Self::from_document(document)
    }

    /// Checks the text of a scene; files that it names are sought in the current folder.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        Self::from_document(Document::parse(text, Path::new("scene.toml"))?)
    }

    /// Builds a scene from the keys and values of a document.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn from_document(document: Document) -> Result<Self, SceneError> {
        scene(document)
    }
}

fn scene(document: Document) -> Result<Scene, SceneError> {
    let checks = Checks(&document);
    let file: SceneFile =
        document
            .values()
            .clone()
            .try_into()
            .map_err(|error: toml::de::Error| SceneError::Syntax {
                place: document.path().display().to_string(),
                message: error.message().to_owned(),
            })?;
    let domain = domain(&checks, &file.domain)?;
    let bodies = bodies(&checks, &file.bodies, &domain)?;
    let links = links(&checks, &file.links, &bodies)?;
    let gait = gait(&checks, &file.gait, &links)?;
    let articulation = articulation(&checks, &bodies, links, &file.gait)?;
    let model = ModelOptions {
        kind: word(file.model.kind.as_deref(), ModelKind::of, ModelKind::Auto),
        // A thousandth is what pictures and comparisons with published strokes need.
        tolerance: checks.below_one(
            "model.tolerance",
            file.model.tolerance.unwrap_or(1e-3),
            1e-12,
        )?,
    };
    let fem = FemOptions {
        formulation: word(
            file.fem.formulation.as_deref(),
            FormulationKind::of,
            FormulationKind::PTilde,
        ),
        solver: word(
            file.fem.solver.as_deref(),
            SolverKind::of,
            SolverKind::Block,
        ),
        subdomains: file.fem.subdomains.unwrap_or(8),
        overlap: file.fem.overlap.unwrap_or(1),
        // Below 1e-14 rounding of the residual itself is in the way.
        rtol: checks.below_one("fem.rtol", file.fem.rtol.unwrap_or(1e-8), 1e-14)?,
        surface_size: file.fem.surface_size,
        target: file
            .fem
            .target
            // Beyond, meshes outgrow any memory before the error is there.
            .map(|target| checks.below_one("fem.target", target, 1e-7))
            .transpose()?,
        size_factor: file
            .fem
            .size_factor
            .map(|factor| match (1e-3..=10.0).contains(&factor) {
                true => Ok(factor),
                // Outside, no sphere can be meshed or no memory holds the mesh.
                false => Err(checks.bad(
                    "fem.size_factor",
                    format!("must be between 1e-3 and 10, not {factor}"),
                )),
            })
            .transpose()?,
        estimates: word(
            file.fem.estimates.as_deref(),
            EstimatesKind::of,
            EstimatesKind::On,
        ),
        geometry: word(
            file.fem.geometry.as_deref(),
            GeometryKind::of,
            GeometryKind::Curved,
        ),
        mesh_motion: word(
            file.fem.mesh_motion.as_deref(),
            MeshMotionKind::of,
            MeshMotionKind::KanchiMasud,
        ),
        mirror: word(file.fem.mirror.as_deref(), MirrorKind::of, MirrorKind::Auto),
    };
    let name = document
        .path()
        .file_stem()
        .map_or("scene".into(), |stem| stem.to_string_lossy().into_owned());
    let viscosity = file.fluid.viscosity.unwrap_or(1.0);
    let scene = Scene {
        name,
        viscosity,
        domain,
        bodies,
        articulation,
        gait,
        model,
        fem,
        document,
    };
    clearance::check_start(&scene)?;
    clearance::check_stroke(&scene)?;
    Ok(scene)
}

fn domain(checks: &Checks, file: &DomainFile) -> Result<Domain, SceneError> {
    let is_given =
        file.radius.is_some() || file.size.is_some() || file.file.is_some() || file.walls.is_some();
    if file.kind.is_none() && is_given {
        return Err(checks.bad(
            "domain.kind",
            "is missing: say which domain is meant, such as kind = \"ball\"",
        ));
    }
    let radius = |kind: &str| {
        checks.required(
            "domain.radius",
            file.radius,
            &format!(": a {kind} needs a radius"),
        )
    };
    Ok(
        match word(file.kind.as_deref(), DomainKind::of, DomainKind::Unbounded) {
            DomainKind::Unbounded => Domain::Unbounded,
            DomainKind::Ball => Domain::Ball {
                radius: radius("ball")?,
            },
            DomainKind::Cylinder => Domain::Cylinder {
                radius: radius("cylinder")?,
            },
            DomainKind::Wall => Domain::Wall,
            DomainKind::Box => Domain::Box {
                size: checks
                    .required("domain.size", file.size, ": a box needs [x, y, z] lengths")?
                    .into(),
            },
            DomainKind::Mesh => {
                let name = checks.required(
                    "domain.file",
                    file.file.as_ref(),
                    ": a mesh needs a Gmsh file",
                )?;
                let path = checks.0.path().parent().unwrap_or(Path::new("")).join(name);
                let metadata = std::fs::metadata(&path).map_err(|error| {
                    checks.bad(
                        "domain.file",
                        format!("cannot be read: {}: {error}", path.display()),
                    )
                })?;
                if !metadata.is_file() || metadata.len() == 0 {
                    let what = if metadata.is_file() {
                        "empty"
                    } else {
                        "not a file"
                    };
                    let problem = format!(
                        "names {}, which is {what}; give a Gmsh mesh",
                        path.display()
                    );
                    return Err(checks.bad("domain.file", problem));
                }
                let walls = checks.required(
                    "domain.walls",
                    file.walls.clone(),
                    ": name the mesh's walls",
                )?;
                if walls.is_empty() {
                    return Err(checks.bad(
                        "domain.walls",
                        "is empty: fluid without a wall at rest has no unique flow",
                    ));
                }
                Domain::Mesh { file: path, walls }
            }
        },
    )
}

fn bodies(checks: &Checks, files: &[BodyFile], domain: &Domain) -> Result<Vec<Body>, SceneError> {
    let key = |number: usize, key: &str| format!("bodies[{number}].{key}");
    let mut first_of = BTreeMap::new();
    let mut bodies = Vec::with_capacity(files.len());
    for (number, file) in files.iter().enumerate() {
        let name = checks.required(&key(number, "name"), file.name.clone(), ": name every body")?;
        if let Some(first) = first_of.insert(name.clone(), number) {
            let problem =
                format!("\"{name}\" is the name of bodies[{first}] too; names must differ");
            return Err(checks.bad(&key(number, "name"), problem));
        }
        let shape = shape(checks, number, file)?;
        if matches!(domain, Domain::Mesh { .. }) && shape != Shape::Point && file.surface.is_none()
        {
            let problem = "is missing: name the part of the mesh's boundary that is this body";
            return Err(checks.bad(&key(number, "surface"), problem));
        }
        let position = checks.required(
            &key(number, "position"),
            file.position,
            ": place every body",
        )?;
        bodies.push(Body {
            name,
            shape,
            position: position.into(),
            surface: file.surface.clone(),
            force: file.force.unwrap_or_default().into(),
            torque: file.torque.unwrap_or_default().into(),
            fixed: file.fixed.unwrap_or(false),
            mass: file.mass.unwrap_or(0.0),
            inertia: file.inertia.unwrap_or(0.0),
        });
    }
    for (number, body) in bodies.iter().enumerate().filter(|(_, body)| body.fixed) {
        let problem = if body.shape == Shape::Point {
            "makes no sense for a point, which has no surface to be in the way; remove it"
        } else if body.force.amax() > 0.0 || body.torque.amax() > 0.0 {
            "holds the body against any load; remove its force and torque"
        } else {
            continue;
        };
        return Err(checks.bad(&key(number, "fixed"), problem));
    }
    if bodies
        .iter()
        .all(|body| body.fixed || body.shape == Shape::Point)
        && bodies.iter().any(|body| body.fixed)
    {
        return Err(checks.bad("bodies", "are all fixed, so nothing moves; leave one free"));
    }
    if bodies.iter().all(|body| body.shape == Shape::Point) {
        return Err(checks.bad(
            "bodies",
            "is empty: a scene needs at least one [[bodies]] with a surface",
        ));
    }
    Ok(bodies)
}

fn links(checks: &Checks, files: &[LinkFile], bodies: &[Body]) -> Result<Vec<Link>, SceneError> {
    let mut links: Vec<Link> = Vec::with_capacity(files.len());
    for (number, file) in files.iter().enumerate() {
        let key = |key: &str| format!("links[{number}].{key}");
        let name = checks.required(&key("name"), file.name.clone(), ": name every link")?;
        if let Some(first) = links.iter().position(|link| link.name == name) {
            let problem =
                format!("\"{name}\" is the name of links[{first}] too; names must differ");
            return Err(checks.bad(&key("name"), problem));
        }
        let end = |which: &str, name: &Option<String>| {
            let name =
                checks.required(&key(which), name.as_deref(), ": a link joins two bodies")?;
            find(
                checks,
                &key(which),
                name,
                "body",
                bodies.iter().map(|body| &body.name[..]),
            )
        };
        let (body, to) = (end("body", &file.body)?, end("to", &file.to)?);
        if body == to {
            let problem = format!(
                "links body '{}' to itself; link it to another",
                bodies[to].name
            );
            return Err(checks.bad(&key("to"), problem));
        }
        if links
            .iter()
            .any(|link| (link.body, link.to) == (body, to) || (link.body, link.to) == (to, body))
        {
            let problem = format!(
                "links '{}' and '{}' a second time; remove one",
                bodies[body].name, bodies[to].name
            );
            return Err(checks.bad(&format!("links[{number}]"), problem));
        }
        links.push(Link { name, body, to });
    }
    Ok(links)
}

/// The number of a named thing.
fn find<'n>(
    checks: &Checks,
    key: &str,
    name: &str,
    what: &str,
    names: impl Iterator<Item = &'n str> + Clone,
) -> Result<usize, SceneError> {
    names
        .clone()
        .position(|known| known == name)
        .ok_or_else(|| {
            let remedy = match (
                keys::nearest(name, names.clone()),
                names.collect::<Vec<_>>(),
            ) {
                (Some(near), _) => format!("did you mean \"{near}\"?"),
                (None, known) if known.is_empty() => format!("the scene has no {what}"),
                (None, known) => format!("there are {}", known.join(", ")),
            };
            checks.bad(key, format!("names no {what}: \"{name}\"; {remedy}"))
        })
}

fn gait(checks: &Checks, file: &GaitFile, links: &[Link]) -> Result<Gait, SceneError> {
    if file.phases.as_ref().is_some_and(Vec::is_empty) {
        return Err(checks.bad(
            "gait.phases",
            "is empty; give at least one [[gait.phases]] or remove the key",
        ));
    }
    let files = file.phases.as_deref().unwrap_or_default();
    let phases = files.iter().enumerate().map(|(number, file)| {
        let key = |key: &str| format!("gait.phases[{number}].{key}");
        let change = match (&file.link, file.length) {
            (None, None) => None,
            (None, Some(_)) => {
                return Err(checks.bad(&key("link"), "is missing: say which link gets this length"));
            }
            (Some(_), None) => {
                return Err(checks.bad(&key("length"), "is missing: the link's length at the end"));
            }
            (Some(name), Some(length)) => {
                let link = find(
                    checks,
                    &key("link"),
                    name,
                    "link",
                    links.iter().map(|link| &link.name[..]),
                )?;
                Some((link, length))
            }
        };
        Ok(Phase {
            change,
            duration: file.duration.unwrap_or(1.0),
        })
    });
    Ok(Gait {
        cycles: file.cycles.unwrap_or(1),
        phases: phases.collect::<Result<_, _>>()?,
    })
}

fn articulation(
    checks: &Checks,
    bodies: &[Body],
    links: Vec<Link>,
    gait: &GaitFile,
) -> Result<Articulation, SceneError> {
    for (number, link) in links.iter().enumerate() {
        if bodies[link.body].position == bodies[link.to].position {
            let problem = format!(
                "has no direction: '{}' and '{}' are at the same place; move one",
                bodies[link.body].name, bodies[link.to].name
            );
            return Err(checks.bad(&format!("links[{number}]"), problem));
        }
    }
    for (number, body) in bodies.iter().enumerate() {
        if body.shape == Shape::Point
            && !links
                .iter()
                .any(|link| link.body == number || link.to == number)
        {
            let problem = "is a point that no link holds, so nothing determines its velocity; link it or remove it";
            return Err(checks.bad(&format!("bodies[{number}]"), problem));
        }
    }
    for number in (0..bodies.len()).filter(|&body| bodies[body].fixed) {
        if let Some(link) = links.iter().find(|l| l.body == number || l.to == number) {
            let problem = format!(
                "cannot be: link '{}' would pull at it; an obstacle has no links",
                link.name
            );
            return Err(checks.bad(&format!("bodies[{number}].fixed"), problem));
        }
    }
    let kinds: Vec<_> = bodies.iter().map(Body::kind).collect();
    let positions: Vec<_> = bodies.iter().map(|body| body.position).collect();
    let arms = word(gait.arms.as_deref(), ArmsKind::of, ArmsKind::Clamped);
    let fixed: Vec<usize> = (0..bodies.len()).filter(|&b| bodies[b].fixed).collect();
    Articulation::new(&kinds, links, arms.into(), &positions)
        .and_then(|set| set.with_fixed(&fixed))
        .map_err(|error| checks.bad("links", error.to_string()))
}

/// The shape of a body of a scene file.
///
/// # Errors
/// A key that the shape needs and has not, or has and does not need.
fn shape(checks: &Checks, number: usize, file: &BodyFile) -> Result<Shape, SceneError> {
    let key = |key: &str| format!("bodies[{number}].{key}");
    let kind = file.shape.as_deref().and_then(ShapeKind::of);
    let shape = match kind.unwrap_or(ShapeKind::Sphere) {
        ShapeKind::Sphere => {
            let radius =
                checks.required(&key("radius"), file.radius, ": a sphere needs a radius")?;
            Shape::Sphere { radius }
        }
        ShapeKind::Point if file.radius.is_some() => {
            return Err(checks.bad(&key("radius"), "makes no sense for a point; remove it"));
        }
        ShapeKind::Point if file.torque.is_some() => {
            return Err(checks.bad(
                &key("torque"),
                "cannot act on a point, which has no attitude; remove it",
            ));
        }
        ShapeKind::Point => Shape::Point,
        ShapeKind::Spheroid => {
            let radius = checks.required(
                &key("radius"),
                file.radius,
                ": a spheroid needs the radius of its equator",
            )?;
            let half_length = checks.required(
                &key("half_length"),
                file.half_length,
                ": a spheroid needs half its length along its axis",
            )?;
            let axis = Vector3::from(file.axis.unwrap_or([1.0, 0.0, 0.0]));
            let unit = axis
                .try_normalize(0.0)
                .ok_or_else(|| checks.bad(&key("axis"), "must not be zero: it is a direction"))?;
            // what was written by us is read as it was
            let is_unit = (axis.norm() - 1.0).abs() <= 2.0 * f64::EPSILON;
            let axis = if is_unit { axis } else { unit };
            Shape::Spheroid {
                radius,
                half_length,
                axis,
            }
        }
    };
    if !matches!(shape, Shape::Spheroid { .. }) {
        let given = [
            ("half_length", file.half_length.is_some()),
            ("axis", file.axis.is_some()),
        ];
        if let Some((name, _)) = given.iter().find(|(_, given)| *given) {
            return Err(checks.bad(
                &key(name),
                "belongs to shape = \"spheroid\"; remove it or say so",
            ));
        }
    }
    Ok(shape)
}
