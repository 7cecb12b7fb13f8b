//! Viscosity and thermal noise of the fluid of a scene file.

use rheology::{Law, RheologyError};
use rigid::Articulation;

use crate::ArmsKind;
use crate::body::Body;
use crate::checks::Checks;
use crate::error::SceneError;
use crate::keys::{FluidFile, SceneFile};
use crate::scene::Rheology;
use crate::thermal_noise::ThermalNoise;
use crate::words::{BackgroundKind, InertiaKind, LawKind, ModelKind, RheologyKind};

/// Default of `fluid.regularisation`: the rates of strokes with times of order 1 are a million
/// times larger.
const REGULARISATION: f64 = 1e-6;

/// The viscosity, which is that at rest or the consistency if there is a law, and the law.
pub(super) fn viscosity(
    checks: &Checks,
    file: &FluidFile,
    has_background: bool,
) -> Result<(f64, Option<Rheology>), SceneError> {
    let kind = file.law;
    let has_plateaus = matches!(
        kind,
        LawKind::Carreau | LawKind::CarreauYasuda | LawKind::Cross
    );
    let is_power = matches!(kind, LawKind::PowerLaw | LawKind::HerschelBulkley);
    let is_law = has_plateaus || is_power;
    checks.refuse_strangers(
        "fluid",
        [
            (
                "zero_shear_viscosity",
                file.zero_shear_viscosity.is_some(),
                has_plateaus,
            ),
            (
                "infinite_shear_viscosity",
                file.infinite_shear_viscosity.is_some(),
                has_plateaus,
            ),
            (
                "relaxation_time",
                file.relaxation_time.is_some(),
                has_plateaus,
            ),
            ("index", file.index.is_some(), is_law),
            (
                "transition",
                file.transition.is_some(),
                kind == LawKind::CarreauYasuda,
            ),
            ("consistency", file.consistency.is_some(), is_power),
            (
                "yield_stress",
                file.yield_stress.is_some(),
                kind == LawKind::HerschelBulkley,
            ),
            ("regularisation", file.regularisation.is_some(), is_power),
            ("rheology", file.rheology.is_some(), is_law),
        ],
        &format!(
            "does not belong to fluid.law = \"{}\"; remove it",
            kind.word()
        ),
    )?;
    let why = format!(": fluid.law = \"{}\" needs it", kind.word());
    let required =
        |name: &str, value: Option<f64>| checks.required(&format!("fluid.{name}"), value, &why);
    let law = if has_plateaus {
        let zero_shear_viscosity = required("zero_shear_viscosity", file.zero_shear_viscosity)?;
        let infinite_shear_viscosity = file.infinite_shear_viscosity.unwrap_or(0.0);
        let relaxation_time = required("relaxation_time", file.relaxation_time)?;
        let index = required("index", file.index)?;
        match kind {
            LawKind::CarreauYasuda => Law::CarreauYasuda {
                zero_shear_viscosity,
                infinite_shear_viscosity,
                relaxation_time,
                index,
                transition: file.transition.unwrap_or(2.0),
            },
            LawKind::Cross => Law::Cross {
                zero_shear_viscosity,
                infinite_shear_viscosity,
                relaxation_time,
                index,
            },
            _ => Law::Carreau {
                zero_shear_viscosity,
                infinite_shear_viscosity,
                relaxation_time,
                index,
            },
        }
    } else if is_power {
        let consistency = required("consistency", file.consistency)?;
        let index = required("index", file.index)?;
        let regularisation = file.regularisation.unwrap_or(REGULARISATION);
        match kind {
            LawKind::HerschelBulkley => Law::HerschelBulkley {
                yield_stress: required("yield_stress", file.yield_stress)?,
                consistency,
                index,
                regularisation,
            },
            _ => Law::PowerLaw {
                consistency,
                index,
                regularisation,
            },
        }
    } else {
        return Ok((file.viscosity, None));
    };
    law.validate().map_err(|error| match error {
        RheologyError::Parameter {
            parameter, range, ..
        } => checks.bad_value(&format!("fluid.{parameter}"), format!("must be {range}")),
        other => checks.bad_value("fluid.law", format!("is no fluid: {other}")),
    })?;
    let rheology = Rheology {
        law,
        kind: file.rheology.unwrap_or_default(),
    };
    let refuse = |key: &str, problem: &str| Err(checks.bad_value(key, problem));
    if is_power && rheology.kind != RheologyKind::Full {
        return refuse(
            "fluid.rheology",
            "must be \"full\" for a power law, which has no Newtonian limit; use a law with \
             zero_shear_viscosity",
        );
    }
    if has_background {
        return refuse(
            "fluid.law",
            "is unsupported with a background flow, which is one of a Newtonian fluid; remove one \
             of them",
        );
    }
    let at_rest = file
        .zero_shear_viscosity
        .or(file.consistency)
        .unwrap_or(1.0);
    if checks.0.has("fluid.viscosity") && file.viscosity != at_rest {
        return refuse(
            "fluid.viscosity",
            &format!("is not {at_rest}, that of fluid.law at rest; remove it"),
        );
    }
    Ok((at_rest, Some(rheology)))
}

/// Default of `fluid.seed`.
const SEED: u32 = 1;

/// The thermal noise, which needs a Newtonian fluid without inertia, bodies without mass and joints
/// without loops.
pub(super) fn thermal_noise(
    checks: &Checks,
    file: &SceneFile,
    bodies: &[Body],
    set: &Articulation,
) -> Result<Option<ThermalNoise>, SceneError> {
    let FluidFile {
        thermal_energy,
        seed,
        ..
    } = file.fluid;
    let refuse = |key: &str, problem: &str| Err(checks.bad_value(key, problem));
    let energy = match (thermal_energy, seed) {
        (None, Some(_)) => {
            let problem =
                "has no effect without fluid.thermal_energy; remove it, or give the energy";
            return refuse("fluid.seed", problem);
        }
        (None | Some(0.0), _) => return Ok(None),
        (Some(energy), _) => energy,
    };
    if file.fluid.inertia != InertiaKind::None {
        return refuse(
            "fluid.inertia",
            "is unsupported with fluid.thermal_energy: thermal noise is that of Stokes flow; remove \
             one of them",
        );
    }
    if file.fluid.law != LawKind::Newtonian {
        return refuse(
            "fluid.law",
            "is unsupported with fluid.thermal_energy: thermal noise is that of a Newtonian fluid; \
             remove one of them",
        );
    }
    let background = file.background.as_ref().and_then(|flow| flow.kind);
    if background == Some(BackgroundKind::PressureGradient) {
        return refuse(
            "background.kind",
            "is unsupported with fluid.thermal_energy: the mean flow would fluctuate too; give it by \
             kind = \"uniform\", or remove one of them",
        );
    }
    if matches!(file.model.kind, ModelKind::Fem | ModelKind::Axisymmetric) {
        return refuse(
            "model.kind",
            "has no thermal noise; use spheres with model.kind = \"rpy\", \"multipole\", \"oseen\" \
             or \"auto\", or remove fluid.thermal_energy",
        );
    }
    if let Some(number) = bodies.iter().position(|body| body.mass_matrix().is_some()) {
        return refuse(
            &format!("bodies[{number}].mass"),
            "is unsupported with fluid.thermal_energy: thermal motion is integrated without \
             inertia; give a density instead, or remove the mass",
        );
    }
    if file.gait.periodic {
        return refuse(
            "gait.periodic",
            "is unsupported with fluid.thermal_energy: random motion has no periodic state; remove \
             one of them",
        );
    }
    let is_in_loop = |linkage: &rigid::Linkage| {
        let moving = set
            .joints()
            .iter()
            .filter(|joint| !joint.kind.is_deformation());
        let own = moving.filter(|joint| linkage.bodies.contains(&joint.body));
        own.count() >= linkage.bodies.len()
    };
    let held = |linkage: &rigid::Linkage| {
        let bodies = linkage.bodies.iter();
        bodies
            .filter(|body| set.held_bodies().any(|held| held == **body))
            .count()
    };
    let has_passive = set.passive_joints().next().is_some();
    if has_passive && set.linkages().iter().any(|linkage| held(linkage) > 1) {
        return refuse(
            "links",
            "join bodies whose motion is given, which is unsupported with fluid.thermal_energy \
             and free joints: their values are no independent coordinates; give the motion of one \
             body alone, or remove the energy",
        );
    }
    let has_free_slide = set
        .passive_joints()
        .any(|joint| joint.kind.length_power() > 0);
    if has_free_slide && file.gait.arms == ArmsKind::Free {
        return refuse(
            "gait.arms",
            "is unsupported with fluid.thermal_energy and springs or free slides: arms that turn \
             freely have more room the longer they are, which the equation of motion lacks; use \
             \"clamped\", or remove the energy",
        );
    }
    match set.linkages().iter().any(is_in_loop) {
        true => refuse(
            "links",
            "form a loop, which is unsupported with fluid.thermal_energy: the values of its joints \
             are no independent coordinates; open the loop, or remove the energy",
        ),
        false => Ok(Some(ThermalNoise {
            energy,
            seed: seed.unwrap_or(SEED),
            time_step: file.fluid.time_step,
        })),
    }
}
