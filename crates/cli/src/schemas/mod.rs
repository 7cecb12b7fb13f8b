//! `swim schema`: JSON schemas of what the commands write and print with `--json`.
//!
//! A test compares them with real output: every key must be described, and every described key be
//! there unless its name ends with a question mark here, and have a description.

mod build;
mod designs;
mod run;
mod solve;

use serde_json::Value;

use super::error::CliError;
use super::text::entry;
use designs::{frequency, learn, map, optimise, share, sizes, sweep, wave};
use run::run;
use solve::solve;

/// Name, output that is described, schema.
type Schema = (&'static str, &'static str, fn() -> Value);

/// Names of the schemas, with the outputs that they describe and the functions that make them.
const SCHEMAS: [Schema; 10] = [
    ("run", "summary.json of swim run, and swim run --json", run),
    ("solve", "swim solve --json", solve),
    ("map", "swim map --json", map),
    (
        "share",
        "swim map --shard --json, while shapes of other shares are missing",
        share,
    ),
    (
        "optimise",
        "optimum.json of swim optimise for a stroke",
        optimise,
    ),
    (
        "wave",
        "optimum.json of swim optimise for a tube that waves",
        wave,
    ),
    ("frequency", "swim frequency --json", frequency),
    ("sizes", "swim sizes --json", sizes),
    (
        "learn",
        "learned.json of swim learn, and swim learn --json",
        learn,
    ),
    ("sweep", "swim sweep --json", sweep),
];

/// The schema with a name, or without a name the list of all.
pub fn schema(name: Option<&str>) -> Result<String, CliError> {
    let Some(name) = name else {
        return Ok(SCHEMAS
            .iter()
            .map(|(name, what, _)| entry(name, what))
            .collect());
    };
    let Some((_, what, make)) = SCHEMAS.iter().find(|(known, ..)| *known == name) else {
        return Err(CliError::NotApplicable {
            place: format!("swim schema {name}"),
            problem: format!("unknown; choose one of {}", SCHEMAS.map(|s| s.0).join(", ")),
        });
    };
    let mut schema = make();
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
    schema["title"] = (*what).into();
    Ok(format!("{schema:#}\n"))
}
