//! The points of a sweep: values of keys, and all combinations of them or random ones.

use std::str::FromStr;

use fastrand::Rng;

use crate::error::DesignError;

/// Largest number of points: the rows of a million take about a gigabyte.
const MAX_POINTS: usize = 1_000_000;

/// A key of a scene with the values that it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct VariedKey {
    /// The key, as for `--set`: `bodies.left.radius`, `fluid.viscosity`; or `links.NAME.length` and
    /// `links.NAME.amplitude`, the [parameters](crate::sensitivities::parameters) of a driven link,
    /// for which bodies are moved and the gait is changed; keys that change with them cannot vary
    /// beside them.
    pub key: String,
    /// Its values.
    pub values: Values,
}

/// The values of a key.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// These, each as it is written in a scene.
    List(Vec<String>),
    /// Random ones between two numbers.
    Between {
        /// Smallest value.
        from: f64,
        /// Largest value.
        to: f64,
        /// Whether the logarithm is distributed evenly.
        is_logarithmic: bool,
    },
}

/// Reads `KEY=FROM:TO:COUNT`, `KEY=FROM:TO` (for random points), each with `:log` for equal ratios,
/// or `KEY=VALUE,VALUE,...`.
///
/// ```
/// use design::{Values, VariedKey};
/// let varied: VariedKey = "fluid.viscosity=1:100:3:log".parse()?;
/// assert_eq!(varied.values, Values::List(["1", "10", "100"].map(str::to_owned).to_vec()));
/// # Ok::<(), design::DesignError>(())
/// ```
impl FromStr for VariedKey {
    type Err = DesignError;

    fn from_str(text: &str) -> Result<Self, DesignError> {
        let refuse = |problem: &str| DesignError::NotApplicable {
            place: format!("vary {text}"),
            problem: problem.to_owned(),
        };
        let (key, values) = (text.split_once('='))
            .filter(|(key, values)| !key.trim().is_empty() && !values.trim().is_empty())
            .ok_or_else(|| {
                refuse("has no values; write key=from:to:count or key=value,value,...")
            })?;
        Ok(Self {
            key: key.trim().to_owned(),
            values: values_of(values.trim()).map_err(|problem| refuse(&problem))?,
        })
    }
}

/// The values of a range or a list.
fn values_of(text: &str) -> Result<Values, String> {
    let (range, is_logarithmic) = match text.strip_suffix(":log") {
        Some(range) => (range, true),
        None => (text, false),
    };
    let parts: Vec<&str> = range.split(':').collect();
    let ends: Vec<Option<f64>> = (parts.iter().take(2))
        .map(|end| end.trim().parse().ok())
        .collect();
    let (Some(from), Some(to)) = (
        ends.first().copied().flatten(),
        ends.get(1).copied().flatten(),
    ) else {
        return match is_logarithmic {
            true => Err("is no range of numbers; write key=from:to:count:log".to_owned()),
            false => Ok(Values::List(entries(text))),
        };
    };
    if !(from.is_finite() && to.is_finite() && (to - from).is_finite()) {
        return Err("has an end that is not finite; give two numbers".to_owned());
    }
    if is_logarithmic && !(from > 0.0 && to > 0.0) {
        return Err("has ends without a logarithm; give positive numbers".to_owned());
    }
    match parts[2..] {
        [] => Ok(Values::Between {
            from: from.min(to),
            to: from.max(to),
            is_logarithmic,
        }),
        [count] => {
            let count: usize = count.trim().parse().unwrap_or(0);
            if !(2..=MAX_POINTS).contains(&count) {
                return Err(format!(
                    "has a count that is no number from 2 to {MAX_POINTS}"
                ));
            }
            let last = (count - 1) as f64;
            let value = |k: usize| match (is_logarithmic, k == count - 1) {
                (_, true) => to,
                (true, _) => rounded(from * (to / from).powf(k as f64 / last)),
                (false, _) => (from * (last - k as f64) + to * k as f64) / last,
            };
            Ok(Values::List((0..count).map(|k| number(value(k))).collect()))
        }
        _ => Err("has too many parts; write key=from:to:count".to_owned()),
    }
}

/// A number as it is written in a scene: a whole one without a point, as counts need it.
fn number(value: f64) -> String {
    let text = format!("{value:?}");
    text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
}

/// A number with six digits, which are as good as any and can be read.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// A positive number of a text.
pub(crate) fn positive(text: &str) -> Option<f64> {
    let value = text.trim().parse().ok();
    value.filter(|value: &f64| value.is_finite() && *value > 0.0)
}

/// The parts of a list, which commas outside brackets and quotes separate.
fn entries(text: &str) -> Vec<String> {
    let (mut depth, mut quote) = (0_i32, None);
    let mut list = vec![String::new()];
    for c in text.chars() {
        match (c, quote) {
            ('"' | '\'', None) => quote = Some(c),
            (_, Some(open)) if c == open => quote = None,
            ('[' | '{', None) => depth += 1,
            (']' | '}', None) => depth -= 1,
            (',', None) if depth == 0 => {
                list.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(last) = list.last_mut() {
            last.push(c);
        }
    }
    list.iter().map(|entry| entry.trim().to_owned()).collect()
}

/// Random points instead of all combinations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomPoints {
    /// Number of points.
    pub count: usize,
    /// Seed: the same points for the same seed.
    pub seed: u64,
}

/// The values of all keys at each point.
///
/// All combinations, of which the last key changes fastest, or random points: each value of a list
/// is as likely as the others, numbers between two ends are distributed evenly.
///
/// # Errors
/// [`DesignError::NotApplicable`] without keys, for a key that is varied twice, for more than a
/// million points, and for a range without a count where the points are not random.
pub fn sweep_points(
    keys: &[VariedKey],
    random: Option<RandomPoints>,
) -> Result<Vec<Vec<String>>, DesignError> {
    let refuse = |place: &str, problem: String| {
        Err(DesignError::NotApplicable {
            place: place.to_owned(),
            problem,
        })
    };
    if keys.is_empty() {
        let problem = "a sweep needs keys that vary: --vary key=from:to:count".to_owned();
        return refuse("vary", problem);
    }
    for (number, varied) in keys.iter().enumerate() {
        if keys[..number].iter().any(|other| other.key == varied.key) {
            let problem = "is varied twice; give all values once".to_owned();
            return refuse(&varied.key, problem);
        }
    }
    if let Some(RandomPoints { count, seed }) = random {
        if !(1..=MAX_POINTS).contains(&count) {
            let problem = format!("{count} points; give a number from 1 to {MAX_POINTS}");
            return refuse("random", problem);
        }
        let mut random = Rng::with_seed(seed);
        let point = |_| {
            keys.iter()
                .map(|key| key.values.random(&mut random))
                .collect()
        };
        return Ok((0..count).map(point).collect());
    }
    let mut points = vec![Vec::new()];
    for varied in keys {
        let Values::List(values) = &varied.values else {
            let problem = "has no count; write key=from:to:count, or ask for random points";
            return refuse(&varied.key, problem.to_owned());
        };
        if points.len().saturating_mul(values.len()) > MAX_POINTS {
            let problem = format!("makes more than {MAX_POINTS} combinations; give fewer values");
            return refuse(&varied.key, problem);
        }
        let with = |point: &Vec<String>, value: &String| {
            let mut point = point.clone();
            point.push(value.clone());
            point
        };
        points = (points.iter())
            .flat_map(|point| values.iter().map(move |value| with(point, value)))
            .collect();
    }
    Ok(points)
}

impl Values {
    /// Refuses values of a parameter that are no positive numbers.
    pub(crate) fn require_positive(&self, key: &str) -> Result<(), DesignError> {
        let bad = match self {
            Self::List(values) => values
                .iter()
                .find(|value| positive(value).is_none())
                .cloned(),
            Self::Between { from, .. } => (*from <= 0.0).then(|| number(*from)),
        };
        match bad {
            None => Ok(()),
            Some(value) => Err(DesignError::NotApplicable {
                place: key.to_owned(),
                problem: format!("cannot be {value}; give positive numbers"),
            }),
        }
    }

    fn random(&self, random: &mut Rng) -> String {
        match self {
            Self::List(values) => values[random.usize(0..values.len())].clone(),
            Self::Between {
                from,
                to,
                is_logarithmic,
            } => {
                let share = random.f64();
                number(rounded(match is_logarithmic {
                    true => from * (to / from).powf(share),
                    false => from + share * (to - from),
                }))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(values: &[&str]) -> Values {
        Values::List(values.iter().map(|v| (*v).to_owned()).collect())
    }

    #[test]
    fn ranges_lists_and_nonsense_are_read_or_refused() {
        let read = |text: &str| text.parse::<VariedKey>().map(|varied| varied.values);
        assert_eq!(read("a.b=1:2:3").unwrap(), list(&["1", "1.5", "2"]));
        assert_eq!(read("a=3:1:3").unwrap(), list(&["3", "2", "1"]));
        assert_eq!(read("a=oseen, rpy").unwrap(), list(&["oseen", "rpy"]));
        assert_eq!(
            read("a=[0, 1],[2, 3]").unwrap(),
            list(&["[0, 1]", "[2, 3]"])
        );
        assert_eq!(read("a=7").unwrap(), list(&["7"]));
        let between = Values::Between {
            from: 1.0,
            to: 4.0,
            is_logarithmic: true,
        };
        assert_eq!(read("a=4:1:log").unwrap(), between);
        for nonsense in [
            "a",
            "=1:2:3",
            "a=",
            "a=1:2:1",
            "a=1:2:x",
            "a=1:2:3:4",
            "a=0:1:3:log",
            "a=1:inf:3",
            "a=-1e308:1e308:3",
            "a=b:log",
        ] {
            assert!(read(nonsense).is_err(), "{nonsense}");
        }
    }

    #[test]
    fn points_are_all_combinations_or_random_ones_of_a_seed() {
        let key = |text: &str| text.parse::<VariedKey>().unwrap();
        let keys = [key("a=1,2"), key("b=x,y,z")];
        let points = sweep_points(&keys, None).unwrap();
        assert_eq!(points.len(), 6);
        assert_eq!(points[1], ["1", "y"]);
        let keys = [key("a=2:8"), key("b=x,y")];
        assert!(sweep_points(&keys, None).is_err(), "no count");
        let of_seed = |seed| sweep_points(&keys, Some(RandomPoints { count: 50, seed })).unwrap();
        assert_eq!(of_seed(1), of_seed(1));
        assert_ne!(of_seed(1), of_seed(2));
        for point in of_seed(3) {
            let value: f64 = point[0].parse().unwrap();
            assert!((2.0..8.0).contains(&value) && ["x", "y"].contains(&&point[1][..]));
        }
        let twice = [key("a=1,2"), key("a=3,4")];
        assert!(sweep_points(&twice, None).is_err());
        let many = [key("a=1:2:2000"), key("b=1:2:2000")];
        assert!(sweep_points(&many, None).is_err());
    }
}
