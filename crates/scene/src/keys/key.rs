//! Description of a key: name, kind of values, default and meaning.

/// A key of the scene file.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Full name; `[]` stands for an entry of a list.
    pub path: &'static str,
    /// Kind of its values.
    pub kind: Kind,
    /// Default, which applies if the key is absent.
    pub default: KeyDefault,
    /// Meaning of the key.
    pub meaning: &'static str,
}

/// Default of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyDefault {
    /// The key has this value, written as for `--set`.
    Value(&'static str),
    /// No fixed value; the text describes the behaviour if the key is absent.
    Described(&'static str),
}

/// Kind of the values of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A finite number.
    Number,
    /// A finite number greater than zero.
    Positive,
    /// A finite number that is not negative.
    NonNegative,
    /// A finite number, or the parameters of an oscillation.
    Oscillation,
    /// Three finite numbers.
    Vector,
    /// Three rows of three finite numbers.
    Matrix,
    /// Three finite numbers greater than zero.
    PositiveVector,
    /// Two finite numbers greater than zero, the smaller one first.
    Range,
    /// Finite numbers, each with a name.
    NumbersByName,
    /// One number, a list of numbers, or numbers with names.
    JointValues,
    /// A whole number of at least one.
    Count,
    /// A text that is not empty.
    Text,
    /// A list of texts that are not empty.
    Texts,
    /// `true` or `false`.
    Flag,
    /// One of these words.
    Word(&'static [&'static str]),
}

impl Kind {
    /// The admissible values, as in "must be ...".
    pub fn describe(self) -> String {
        match self {
            Self::Number => "a number".to_owned(),
            Self::Oscillation => {
                "a number, or a table such as { mean = 0, amplitude = 1, phase = 0, order = 1, \
                 period = 2 }"
                    .to_owned()
            }
            Self::Positive => "a number greater than zero".to_owned(),
            Self::NonNegative => "a number that is not negative".to_owned(),
            Self::Vector => "three numbers, such as [0, 0, 1]".to_owned(),
            Self::Matrix => {
                "three rows of three numbers, such as [[0, 1, 0], [0, 0, 0], [0, 0, 0]]".to_owned()
            }
            Self::PositiveVector => "three numbers greater than zero".to_owned(),
            Self::Range => {
                "two numbers greater than zero, the smaller one first, such as [0.5, 2]".to_owned()
            }
            Self::NumbersByName => "a table of numbers, such as { arm = 6 }".to_owned(),
            Self::JointValues => {
                "a number for all links, a list of numbers, or a table such as { arm = 6 }"
                    .to_owned()
            }
            Self::Count => "a whole number of at least 1".to_owned(),
            Self::Text => "a text that is not empty".to_owned(),
            Self::Texts => "a list of texts that are not empty".to_owned(),
            Self::Flag => "true or false".to_owned(),
            Self::Word(words) => format!("one of {}", words.join(", ")),
        }
    }
}
