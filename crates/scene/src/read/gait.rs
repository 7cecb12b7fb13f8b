//! The gait of a scene file.

use rigid::Link;

use super::checks::Checks;
use crate::error::SceneError;
use crate::file::{GaitFile, PhaseFile};
use crate::gait::{Gait, Phase};

/// The gait, with links by number.
pub(super) fn gait(checks: &Checks, file: &GaitFile, links: &[Link]) -> Result<Gait, SceneError> {
    if file.phases.as_ref().is_some_and(Vec::is_empty) {
        return Err(checks.bad_value(
            "gait.phases",
            "is empty; give at least one [[gait.phases]] or remove the key",
        ));
    }
    let files = file.phases.iter().flatten().enumerate();
    let phases = files.map(|(number, file)| phase(checks, number, file, links));
    Ok(Gait {
        cycles: file.cycles,
        phases: phases.collect::<Result<_, _>>()?,
    })
}

fn phase(
    checks: &Checks,
    number: usize,
    file: &PhaseFile,
    links: &[Link],
) -> Result<Phase, SceneError> {
    let key = |key: &str| format!("gait.phases[{number}].{key}");
    let change = match (&file.link, file.length) {
        (None, None) => None,
        (None, Some(_)) => {
            let problem = "is missing: say which link gets this length";
            return Err(checks.bad_value(&key("link"), problem));
        }
        (Some(_), None) => {
            let problem = "is missing: the link's length at the end";
            return Err(checks.bad_value(&key("length"), problem));
        }
        (Some(name), Some(length)) => {
            let names = links.iter().map(|link| &link.name[..]);
            Some((checks.find(&key("link"), name, "link", names)?, length))
        }
    };
    Ok(Phase {
        change,
        duration: file.duration,
    })
}
