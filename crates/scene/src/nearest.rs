//! Suggestions for misspelt keys, words and names.

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

/// Position of a name in a list, or else a message with a suggestion.
///
/// `kind` names the items of the list, such as "body".
pub(crate) fn find_name<'n>(
    name: &str,
    kind: &str,
    names: impl Iterator<Item = &'n str> + Clone,
) -> Result<usize, String> {
    if let Some(position) = names.clone().position(|known| known == name) {
        return Ok(position);
    }
    let remedy = match (nearest(name, names.clone()), names.collect::<Vec<_>>()) {
        (Some(near), _) => format!("did you mean \"{near}\"?"),
        (None, known) if known.is_empty() => format!("the scene has no {kind}"),
        (None, known) => format!("there are {}", known.join(", ")),
    };
    Err(format!("names no {kind}: \"{name}\"; {remedy}"))
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
