//! Checks of keys and values against the table of all keys.

use toml::{Table, Value};

use super::places::Places;
use crate::error::{SceneError, one_line};
use crate::keys::{self, KeyType, Kind, Words, join, without_indices};
use crate::nearest::nearest;
use crate::words::AxesKind;

/// Refuses unknown keys and values that are not of their key's kind, below a group.
pub(super) fn check_table(places: &Places, table: &Table, group: &str) -> Result<(), SceneError> {
    table.iter().try_for_each(|(key, value)| {
        let path = join(group, key);
        // With these characters one name would look like a path of several.
        match key.contains(['.', '[', ']']) {
            true => Err(quoted_key(places, key, &path)),
            false => check_value(places, value, &path),
        }
    })
}

/// Refuses a key such as `"fluid.viscosity"`, which TOML takes for one name with a dot in it.
fn quoted_key(places: &Places, key: &str, path: &str) -> SceneError {
    SceneError::UnknownKey {
        place: places.find(path),
        key: one_line(&format!("\"{key}\"")),
        remedy: "quotation marks make it one name, and no key has dots or brackets in its name; \
                 write it without them, such as fluid.viscosity"
            .to_owned(),
    }
}

/// Makes the checks of [`check_table`] for the value of one key or group.
pub(super) fn check_value(places: &Places, value: &Value, path: &str) -> Result<(), SceneError> {
    let schema = without_indices(path);
    let bad = |problem: String| SceneError::BadValue {
        place: places.find(path),
        key: path.to_owned(),
        problem,
    };
    if let Some(key) = keys::find(&schema) {
        return check_kind(value, key.kind).map_err(bad);
    }
    if !keys::is_group(&schema) {
        return Err(unknown_key(places, path));
    }
    let not_a_list = || bad(format!("must be a list of tables, written as [[{schema}]]"));
    let is_list = keys::is_group(&format!("{schema}[]"));
    match value {
        Value::Table(table) if !is_list => check_table(places, table, path),
        Value::Array(list) if is_list => {
            list.iter()
                .enumerate()
                .try_for_each(|(index, entry)| match entry {
                    Value::Table(table) => check_table(places, table, &format!("{path}[{index}]")),
                    _ => Err(not_a_list()),
                })
        }
        _ if is_list => Err(not_a_list()),
        _ => {
            let header = schema
                .strip_suffix("[]")
                .map_or(format!("[{schema}]"), |list| format!("[[{list}]]"));
            Err(bad(format!("must be a table, written as {header}")))
        }
    }
}

/// What is said about elastic bodies.
const RIGID: &str = "bodies are rigid, or deform as bodies[].deformation says; \
                     links[].drive = \"spring\" makes a link elastic";

/// Where thermal motion is.
const THERMAL: &str = "fluid.thermal_energy is k_B T, by which spheres have thermal motion";

/// Words of quantities that no key has, in lower case without separators, with what exists.
const QUANTITIES: [(&str, &str); 15] = [
    (
        "reynolds",
        "it follows from fluid.density, fluid.viscosity and the gait; fluid.inertia = \"full\" keeps \
         inertia",
    ),
    (
        "inertial",
        "fluid.inertia = \"full\" with fluid.density keeps inertia",
    ),
    (
        "shearthinning",
        "fluid.law = \"carreau\" and others make the viscosity depend on the shear rate",
    ),
    ("temperature", THERMAL),
    ("thermal", THERMAL),
    ("brownian", THERMAL),
    ("noise", THERMAL),
    ("boltzmann", THERMAL),
    ("elastic", RIGID),
    ("young", RIGID),
    ("flexible", RIGID),
    ("bending", RIGID),
    (
        "stiffness",
        "links[].stiffness is that of a link with drive = \"spring\"",
    ),
    (
        "slipvelocity",
        "bodies[].slip is the tangential velocity of a squirmer",
    ),
    (
        "timestep",
        "steps follow from model.tolerance; fluid.time_step fixes them with inertia",
    ),
];

/// Names by which the value of a joint is sought among the keys of its link.
const LINK_VALUES: [&str; 6] = ["length", "angle", "value", "start", "amplitude", "mean"];

/// Whether a name of no key of a link means the value of its joint.
pub(super) fn is_link_value(name: &str) -> bool {
    LINK_VALUES.contains(&name)
}

/// Suggests a key of the same group, or else what is known of the quantity, or else the key of this
/// name in another group; of several, names the groups.
fn unknown_key(places: &Places, path: &str) -> SceneError {
    let schema = without_indices(path);
    let (group, last) = schema.rsplit_once('.').unwrap_or(("", &schema));
    let here = keys::all().filter_map(|key| {
        let below = if group.is_empty() {
            key.path
        } else {
            key.path.strip_prefix(group)?.strip_prefix('.')?
        };
        below.split(['.', '[']).next()
    });
    let elsewhere: Vec<&str> = (keys::all().map(|key| key.path))
        .filter(|path| path.rsplit('.').next() == Some(last))
        .collect();
    let plain: String = (last.chars().filter(char::is_ascii_alphabetic))
        .map(|c| c.to_ascii_lowercase())
        .collect();
    let quantity = (QUANTITIES.iter()).find(|(word, _)| plain.contains(word));
    let remedy = if group == "links[]" && is_link_value(last) {
        "the value of a link at the start follows from the positions of its bodies, later from the \
         gait; `swim sweep` varies `length` and `amplitude` of links, for which it changes all these \
         keys"
            .to_owned()
    } else if let Some(near) = nearest(last, here.clone()) {
        format!("did you mean '{}'?", join(group, near))
    } else if let (true, Some((_, remedy))) = (elsewhere.is_empty(), quantity) {
        (*remedy).to_owned()
    } else if let [only] = &elsewhere[..] {
        format!("did you mean '{only}'?")
    } else {
        let mut known: Vec<&str> = here.collect();
        known.dedup();
        let owner = if group.is_empty() { "a scene" } else { group };
        let owners = elsewhere.iter().filter_map(|path| path.rsplit_once('.'));
        let owners: Vec<&str> = owners.map(|(owner, _)| owner).collect();
        let elsewhere = match owners.is_empty() {
            true => String::new(),
            false => format!("; {last} is a key of {}", owners.join(", ")),
        };
        format!("{owner} has {}{elsewhere}", known.join(", "))
    };
    SceneError::UnknownKey {
        place: places.find(path),
        key: path.to_owned(),
        remedy,
    }
}

/// Sizes of numbers that are not zero.
///
/// The largest powers of them in a computation are torques, `μ L^3 ω`, and power, `μ L U^2`: with
/// products of six numbers, and of reciprocals, below 1e300 they neither overflow nor underflow.
/// In SI units the smallest number that was seen is the moment of inertia of a bacterium, 1e-33.
const MIN_SIZE: f64 = 1e-50;
const MAX_SIZE: f64 = 1e50;

/// Whether a number is zero or of a size that computations allow.
pub(crate) fn is_in_range(x: f64) -> bool {
    x == 0.0 || (MIN_SIZE..=MAX_SIZE).contains(&x.abs())
}

/// The finite numbers of a value, a list, a list of lists or a table.
fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        Value::Table(table) => table.values().flat_map(numbers).collect(),
        value => value
            .as_float()
            .into_iter()
            .filter(|x| x.is_finite())
            .collect(),
    }
}

fn check_kind(value: &Value, kind: Kind) -> Result<(), String> {
    let number = |value: &Value| match value {
        Value::Float(x) => Some(*x).filter(|x| x.is_finite()),
        Value::Integer(i) => Some(*i as f64),
        _ => None,
    };
    let three_numbers = |value: &Value, accept: fn(f64) -> bool| match value {
        Value::Array(list) => list.len() == 3 && list.iter().all(|x| number(x).is_some_and(accept)),
        _ => false,
    };
    let is_count = |value: &Value| {
        let number = value.as_integer();
        number.is_some_and(|n| n > 0 && u32::try_from(n).is_ok())
    };
    let is_full = |value: &Value| value.as_str().is_some_and(|text| !text.trim().is_empty());
    let is_right = match kind {
        Kind::Number => number(value).is_some(),
        Kind::Oscillation => match value {
            Value::Table(table) => table.iter().all(|(key, value)| match &key[..] {
                "mean" | "phase" => number(value).is_some(),
                "amplitude" | "period" => number(value).is_some_and(|x| x > 0.0),
                "order" => is_count(value),
                _ => false,
            }),
            value => number(value).is_some(),
        },
        Kind::Load => match value {
            Value::Table(table) => table.iter().all(|(key, value)| match &key[..] {
                "mean" | "amplitude" => three_numbers(value, |_| true),
                "phase" => number(value).is_some() || three_numbers(value, |_| true),
                "period" => number(value).is_some_and(|x| x > 0.0),
                "order" => is_count(value),
                "axes" => check_kind(value, AxesKind::KIND).is_ok(),
                _ => false,
            }),
            value => three_numbers(value, |_| true),
        },
        Kind::Positive => number(value).is_some_and(|x| x > 0.0),
        Kind::NonNegative => number(value).is_some_and(|x| x >= 0.0),
        Kind::Vector => three_numbers(value, |_| true),
        Kind::Matrix => value.as_array().is_some_and(|rows| {
            rows.len() == 3 && rows.iter().all(|row| three_numbers(row, |_| true))
        }),
        Kind::Vectors => value
            .as_array()
            .is_some_and(|list| list.iter().all(|v| three_numbers(v, |_| true))),
        Kind::PositiveVector => three_numbers(value, |x| x > 0.0),
        Kind::Range => value.as_array().is_some_and(|list| {
            let ends: Vec<Option<f64>> = list.iter().map(number).collect();
            matches!(ends[..], [Some(a), Some(b)] if 0.0 < a && a < b)
        }),
        Kind::Numbers => value
            .as_array()
            .is_some_and(|list| list.iter().all(|x| number(x).is_some())),
        Kind::NumbersByName => value
            .as_table()
            .is_some_and(|table| table.values().all(|x| number(x).is_some())),
        Kind::JointValues => match value {
            Value::Array(list) => list.iter().all(|x| number(x).is_some()),
            Value::Table(table) => table.values().all(|x| number(x).is_some()),
            value => number(value).is_some(),
        },
        Kind::Count => is_count(value),
        Kind::Flag => value.is_bool(),
        Kind::Group => value.is_table(),
        Kind::Text => is_full(value),
        Kind::Texts => value
            .as_array()
            .is_some_and(|list| list.iter().all(is_full)),
        Kind::Word(Words { words, .. }) => match value.as_str() {
            Some(word) if !words.contains(&word) => {
                return Err(match nearest(word, words.iter().copied()) {
                    Some(near) => format!("cannot be \"{word}\"; did you mean \"{near}\"?"),
                    None => format!("cannot be \"{word}\"; it is one of {}", words.join(", ")),
                });
            }
            word => word.is_some(),
        },
    };
    let out_of_range = numbers(value).into_iter().find(|x| !is_in_range(*x));
    match (is_right, out_of_range) {
        (true, None) => Ok(()),
        (true, Some(x)) => Err(format!(
            "must be zero or from {MIN_SIZE:e} to {MAX_SIZE:e} in size, not {x:e}; choose other \
             units"
        )),
        (false, _) => Err(format!("must be {}, not {}", kind.describe(), quote(value))),
    }
}

/// A value in the words of a message.
fn quote(value: &Value) -> String {
    match value {
        Value::String(text) if text.trim().is_empty() => "an empty text".to_owned(),
        Value::String(text) => format!("the text \"{}\"", one_line(text)),
        Value::Table(_) => "a table".to_owned(),
        Value::Array(list) if list.len() > 6 => format!("a list of {}", list.len()),
        value => one_line(&value.to_string()),
    }
}
