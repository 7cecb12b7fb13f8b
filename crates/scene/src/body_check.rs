//! What is known of the surface of a body that deforms.

/// What is known of the surface of a body at some values of its shape coordinates, and at all that
/// differ from them by no more than given changes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum BodyCheck {
    /// It is that of a body at all these values.
    Within,
    /// It is that of a body at the values, but maybe not within the changes.
    Here,
    /// It is that of a body at the values as far as a fine grid shows, which smaller changes do not
    /// make certain either.
    Unproven,
    /// It may be that of a body at the values, but is so close to none that no mesh follows, in
    /// words.
    Near(String),
    /// What is wrong with the values.
    Problem(String),
}

impl BodyCheck {
    /// What is wrong with the values.
    pub(crate) fn problem(self) -> Option<String> {
        match self {
            Self::Problem(problem) | Self::Near(problem) => Some(problem),
            Self::Within | Self::Here | Self::Unproven => None,
        }
    }
}
