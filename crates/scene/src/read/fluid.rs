//! Viscosity of the fluid of a scene file.

use rheology::{Law, RheologyError};

use crate::checks::Checks;
use crate::error::SceneError;
use crate::keys::FluidFile;
use crate::scene::Rheology;
use crate::words::{LawKind, RheologyKind};

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
