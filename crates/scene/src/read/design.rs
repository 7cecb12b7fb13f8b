//! Checks of the groups `optimise` and `learn`.

use rigid::Link;

use super::checks::Checks;
use super::gait::{check_prescribed, check_value};
use crate::design::{JointValues, LearnOptions, OptimiseOptions};
use crate::error::SceneError;
use crate::nearest::find_name;

/// Largest number of terms: more need more memory than a search can use.
const MOST_TERMS: u32 = 128;

/// Refuses values of joints that do not fit the links, and numbers outside their bounds.
pub(super) fn check(
    checks: &Checks,
    optimise: &OptimiseOptions,
    learn: &LearnOptions,
    links: &[Link],
) -> Result<(), SceneError> {
    for (key, values) in [
        ("optimise.lower", &optimise.lower),
        ("optimise.upper", &optimise.upper),
        ("learn.contracted", &learn.contracted),
        ("learn.extended", &learn.extended),
    ] {
        let Some(values) = values else { continue };
        let values = by_link(values, links).map_err(|problem| checks.bad_value(key, problem))?;
        for (link, value) in links.iter().zip(values) {
            value.map_or(Ok(()), |value| check_value(checks, key, link, value))?;
        }
    }
    if let Some(values) = &optimise.max_rate {
        let key = "optimise.max_rate";
        let values = by_link(values, links).map_err(|problem| checks.bad_value(key, problem))?;
        if let Some(value) = values.into_iter().flatten().find(|value| *value <= 0.0) {
            return Err(checks.bad_value(key, format!("must be greater than zero, not {value}")));
        }
    }
    if optimise.power.is_some() && (optimise.max_rate.is_some() || optimise.max_power.is_some()) {
        let problem = "cannot be given with optimise.max_rate or optimise.max_power, which \
                       determine the period; remove it";
        return Err(checks.bad_value("optimise.power", problem));
    }
    for (key, vector) in [
        ("optimise.direction", optimise.direction),
        ("optimise.axis", Some(optimise.axis)),
        ("learn.direction", Some(learn.direction)),
    ] {
        if vector == Some([0.0; 3]) {
            return Err(checks.bad_value(key, "must not be zero"));
        }
    }
    if optimise.terms > MOST_TERMS {
        let problem = format!("must be at most {MOST_TERMS}, not {}", optimise.terms);
        return Err(checks.bad_value("optimise.terms", problem));
    }
    for (key, value) in [
        ("optimise.tolerance", optimise.tolerance),
        ("learn.discount", learn.discount),
    ] {
        if value >= 1.0 {
            return Err(checks.bad_value(key, format!("must be below 1, not {value}")));
        }
    }
    for (key, value) in [
        ("learn.rate", learn.rate),
        ("learn.exploration", learn.exploration),
    ] {
        if value > 1.0 {
            return Err(checks.bad_value(key, format!("must be at most 1, not {value}")));
        }
    }
    Ok(())
}

/// The value of each link; none for links without one.
///
/// # Errors
/// What is wrong with the values.
pub(crate) fn by_link(values: &JointValues, links: &[Link]) -> Result<Vec<Option<f64>>, String> {
    match values {
        JointValues::All(value) => Ok((links.iter())
            .map(|link| check_prescribed(link).is_ok().then_some(*value))
            .collect()),
        JointValues::List(list) if list.len() == links.len() => {
            Ok(list.iter().copied().map(Some).collect())
        }
        JointValues::List(list) => Err(format!(
            "has {} values, and the scene has {} links",
            list.len(),
            links.len()
        )),
        JointValues::Named(values) => {
            let mut found = vec![None; links.len()];
            for (name, value) in values {
                let names = links.iter().map(|link| &link.name[..]);
                let link = find_name(name, "link", names)?;
                check_prescribed(&links[link])?;
                found[link] = Some(*value);
            }
            Ok(found)
        }
    }
}
