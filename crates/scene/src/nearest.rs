//! Items by their names, and suggestions for misspelt keys, words and names.

use std::collections::HashMap;

/// The candidate nearest to a misspelt text, if one is near.
///
/// The distance is the number of characters to insert, delete, replace or swap with a neighbour.
/// It may be about a third of the candidate's length, so that a slip is corrected and a guess
/// is not.
pub(crate) fn nearest<'a>(
    wrong: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    // The cost grows with the product of the lengths; no key is longer than this.
    const MAX_CHARACTERS: usize = 64;
    let shortened = |text: &str| text.chars().take(MAX_CHARACTERS).collect::<String>();
    let wrong = shortened(wrong);
    candidates
        .into_iter()
        .map(|right| (strsim::osa_distance(&wrong, &shortened(right)), right))
        .min()
        .filter(|(distance, right)| 3 * distance <= right.chars().count().max(3) + 2)
        .map(|(_, right)| right)
}

/// Names of a list, with the first position of each.
pub(crate) struct Names<'n> {
    kind: &'static str,
    list: Vec<&'n str>,
    positions: HashMap<&'n str, usize>,
}

impl<'n> Names<'n> {
    /// The names of a list; `kind` names its items, such as "body".
    pub fn new(kind: &'static str, list: impl Iterator<Item = &'n str>) -> Self {
        let list: Vec<&str> = list.collect();
        let mut positions = HashMap::with_capacity(list.len());
        for (position, name) in list.iter().enumerate() {
            positions.entry(*name).or_insert(position);
        }
        Self {
            kind,
            list,
            positions,
        }
    }

    /// Position of a name, or else a message with a suggestion.
    pub fn find(&self, name: &str) -> Result<usize, String> {
        if let Some(position) = self.positions.get(name) {
            return Ok(*position);
        }
        let kind = self.kind;
        let remedy = match nearest(name, self.list.iter().copied()) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None if self.list.is_empty() => format!("the scene has no {kind}"),
            None => format!("there are {}", self.list.join(", ")),
        };
        Err(format!("names no {kind}: \"{name}\"; {remedy}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_is_corrected_and_a_guess_is_not() {
        assert_eq!(
            nearest("viscocity", ["viscosity", "radius"]),
            Some("viscosity")
        );
        assert_eq!(nearest("raduis", ["viscosity", "radius"]), Some("radius"));
        assert_eq!(nearest("temperature", ["viscosity", "radius"]), None);
    }

    #[test]
    fn long_texts_are_compared_by_their_first_characters() {
        let long = "x".repeat(1_000_000);
        assert_eq!(nearest(&long, ["radius"]), None);
    }
}
