//! Slip, background flow, gravity and inertia of a scene file.

use nalgebra::{Matrix3, Vector3};

use crate::body::Body;
use crate::checks::Checks;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::flow::{Background, Slip};
use crate::keys::{BackgroundFile, BodyFile, FluidFile, SceneFile};
use crate::scene::FluidInertia;
use crate::words::{BackgroundKind, InertiaKind, StartKind};

/// Relative size of the rounding errors of numbers that are written with many digits.
const ROUNDING: f64 = 1e-12;

/// The slip of body `number`.
pub(super) fn slip(
    checks: &Checks,
    number: usize,
    file: &BodyFile,
    has_surface: bool,
) -> Result<Option<Slip>, SceneError> {
    let Some(file) = &file.slip else {
        return Ok(None);
    };
    let key = format!("bodies[{number}].slip");
    if !has_surface {
        let problem = "makes no sense for a point, which has no surface; remove it";
        return Err(checks.bad_value(&key, problem));
    }
    let axis = Vector3::from(file.axis).try_normalize(0.0);
    let zero = || checks.bad_value(&format!("{key}.axis"), "has no direction");
    let slip = Slip {
        b1: file.b1,
        b2: file.b2,
        axis: axis.ok_or_else(zero)?,
    };
    Ok(Some(slip).filter(|slip| slip.speed() > 0.0))
}

/// The background flow, which must be incompressible and fit the domain.
pub(super) fn background(
    checks: &Checks,
    file: Option<&BackgroundFile>,
    domain: &Domain,
) -> Result<Option<Background>, SceneError> {
    let Some(file) = file else { return Ok(None) };
    let kind = checks.required("background.kind", file.kind, ": say which flow is meant")?;
    let is_linear = matches!(kind, BackgroundKind::Shear | BackgroundKind::Extension);
    let is_driven = kind == BackgroundKind::PressureGradient;
    checks.refuse_strangers(
        "background",
        [
            (
                "velocity",
                file.velocity.is_some(),
                !is_linear && !is_driven,
            ),
            (
                "pressure_gradient",
                file.pressure_gradient.is_some(),
                is_driven,
            ),
            ("gradient", file.gradient.is_some(), is_linear),
        ],
        &format!("does not belong to kind = \"{}\"; remove it", kind.word()),
    )?;
    let velocity = || -> Result<Vector3<f64>, SceneError> {
        let why = format!(": kind = \"{}\" needs a velocity", kind.word());
        Ok(checks
            .required("background.velocity", file.velocity, &why)?
            .into())
    };
    Ok(Some(match (kind, domain) {
        (BackgroundKind::Uniform, _) => Background::Uniform {
            velocity: velocity()?,
        },
        (BackgroundKind::PressureGradient, Domain::Periodic { .. }) => {
            let why = format!(": kind = \"{}\" needs it", kind.word());
            let key = "background.pressure_gradient";
            Background::PressureGradient {
                gradient: checks.required(key, file.pressure_gradient, &why)?.into(),
            }
        }
        (BackgroundKind::PressureGradient, _) => {
            let problem = "\"pressure-gradient\" needs domain.kind = \"periodic\"; along a tube \
                           use \"poiseuille\"";
            return Err(checks.bad_value("background.kind", problem));
        }
        (BackgroundKind::Shear | BackgroundKind::Extension, _) => {
            let why = format!(": kind = \"{}\" needs a gradient", kind.word());
            let rows = checks.required("background.gradient", file.gradient, &why)?;
            let gradient = Matrix3::from_fn(|i, j| rows[i][j]);
            check_gradient(checks, kind, &gradient)?;
            Background::Linear { kind, gradient }
        }
        (BackgroundKind::Poiseuille, Domain::Cylinder { radius }) => {
            let velocity = velocity()?;
            if velocity.yz().amax() > 0.0 {
                let problem = "must be along x, the axis of the tube";
                return Err(checks.bad_value("background.velocity", problem));
            }
            Background::Poiseuille {
                velocity: velocity.x,
                radius: *radius,
            }
        }
        (BackgroundKind::Poiseuille, _) => {
            let problem = "\"poiseuille\" needs domain.kind = \"cylinder\"";
            return Err(checks.bad_value("background.kind", problem));
        }
    }))
}

/// Refuses gradients of compressible flows, and extensions that rotate.
fn check_gradient(
    checks: &Checks,
    kind: BackgroundKind,
    gradient: &Matrix3<f64>,
) -> Result<(), SceneError> {
    let (trace, limit) = (gradient.trace(), ROUNDING * gradient.amax());
    let problem = if trace.abs() > limit {
        format!("has the trace {trace:e}: the flow would not be incompressible; make it zero")
    } else if kind == BackgroundKind::Extension && (gradient - gradient.transpose()).amax() > limit
    {
        "is not symmetric: an extension does not rotate; use kind = \"shear\"".to_owned()
    } else {
        return Ok(());
    };
    Err(checks.bad_value("background.gradient", problem))
}

/// The inertia of the fluid, which needs a density and a container.
pub(super) fn inertia(
    checks: &Checks,
    file: &SceneFile,
    (domain, has_background): (&Domain, bool),
    bodies: &[Body],
) -> Result<FluidInertia, SceneError> {
    let FluidFile {
        density,
        inertia: kind,
        start,
        time_step,
        ..
    } = file.fluid;
    let inertia = FluidInertia {
        kind,
        start,
        time_step,
    };
    let refuse = |key: &str, problem: &str| Err(checks.bad_value(key, problem));
    if kind == InertiaKind::None {
        let unused = "has no effect without fluid.inertia; remove it, or give the inertia";
        let is_of_noise = file.fluid.thermal_energy.is_some();
        return match (time_step, start) {
            (Some(_), _) if !is_of_noise => refuse(
                "fluid.time_step",
                "has no effect without fluid.inertia or fluid.thermal_energy; remove it, or give \
                 one of them",
            ),
            (_, StartKind::Stokes) => refuse("fluid.start", unused),
            (_, StartKind::Rest) => Ok(FluidInertia::default()),
        };
    }
    if density.unwrap_or(0.0) == 0.0 {
        return refuse(
            "fluid.inertia",
            "needs fluid.density; give the density of the fluid",
        );
    }
    if !domain.is_container() {
        return refuse(
            "fluid.inertia",
            "needs a container, since vorticity spreads without end; choose domain.kind = \
             \"ball\", \"box\", \"surface\" or \"mesh\", as large as vorticity spreads in the run",
        );
    }
    if has_background {
        return refuse(
            "fluid.inertia",
            "is unsupported with a background flow; remove one",
        );
    }
    if file.fem.target.is_some() {
        return refuse(
            "fem.target",
            "is unsupported with the inertia of the fluid, which has no estimate of the mesh's \
             error; set fem.surface_size",
        );
    }
    let density = |body: &Body| body.density.unwrap_or(0.0);
    let unknown = |body: &Body| density(body) > 0.0 && body.mass_matrix_by_density().is_none();
    if let Some(number) = bodies.iter().position(unknown) {
        return refuse(
            &format!("bodies[{number}].density"),
            "is unsupported with inertia for a shape whose moments of inertia are not known; give \
             `inertia` too",
        );
    }
    let off_centre = |body: &Body| body.density.is_some() && body.weight_arm().is_some();
    match bodies.iter().position(off_centre) {
        Some(number) => refuse(
            &format!("bodies[{number}].density"),
            "is unsupported with inertia for a body whose position is not its centre of mass; for \
             a surface from a file remove `centre`",
        ),
        None => Ok(inertia),
    }
}

/// Enters the weights of the bodies: `(density - fluid density) volume g`.
pub(super) fn enter_weights(
    checks: &Checks,
    gravity: &Vector3<f64>,
    fluid_density: f64,
    bodies: &mut [Body],
) -> Result<(), SceneError> {
    for (number, body) in bodies.iter_mut().enumerate() {
        let (density, name) = match (body.density, body.mass) {
            (Some(density), _) => (density, "density"),
            (None, mass) if mass > 0.0 => (mass / body.shape.volume(), "mass"),
            (None, _) => continue,
        };
        let key = format!("bodies[{number}].{name}");
        let refuse = |problem: &str| Err(checks.bad_value(&key, problem));
        match (body.shape.has_surface(), body.fixed) {
            (false, _) => return refuse("makes no sense for a point; remove it"),
            (_, true) => return refuse("has no effect: the body is fixed; remove it"),
            _ if body.mass > 0.0 && body.density.is_some() && gravity.amax() > 0.0 => {
                return refuse(
                    "is given beside a mass, and the weight follows from either; remove one of them",
                );
            }
            _ if body.mass > 0.0 && gravity.amax() > 0.0 && body.weight_arm().is_some() => {
                return refuse(
                    "is unsupported with gravity for a body whose position is not its centre of \
                     mass; without inertia give `density` instead; for a surface from a file \
                     remove `centre`",
                );
            }
            _ => body.weight = gravity * ((density - fluid_density) * body.shape.volume()),
        }
    }
    Ok(())
}
