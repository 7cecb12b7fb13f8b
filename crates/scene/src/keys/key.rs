//! Description of a key: name, kind of values, default and meaning.

use std::collections::BTreeMap;

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
#[non_exhaustive]
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
    /// Three finite numbers, or the parameters of their oscillation.
    Load,
    /// Three finite numbers.
    Vector,
    /// A list of three finite numbers each.
    Vectors,
    /// Three rows of three finite numbers.
    Matrix,
    /// Three finite numbers greater than zero.
    PositiveVector,
    /// Two finite numbers greater than zero, the smaller one first.
    Range,
    /// A list of finite numbers.
    Numbers,
    /// Finite numbers, each with a name.
    NumbersByName,
    /// One number, a list of numbers, or numbers with names.
    JointValues,
    /// A whole number of at least one.
    Count,
    /// A non-empty string.
    Text,
    /// A list of non-empty strings.
    Texts,
    /// `true` or `false`.
    Flag,
    /// One of these words.
    Word(Words),
    /// No value but a table of keys, or a list of such tables.
    Group,
}

/// Words with their meanings.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Words {
    /// The words.
    pub words: &'static [&'static str],
    /// The meaning of each word.
    pub meanings: &'static [&'static str],
}

impl Kind {
    /// The admissible values, as in "must be ...".
    pub fn describe(self) -> String {
        let text = match self {
            Self::Number => "a number",
            Self::Oscillation => {
                "a number, or a table such as { mean = 0, amplitude = 1, phase = 0, order = 1, \
                 period = 2 }"
            }
            Self::Load => {
                "three numbers, such as [0, 0, 1], or a table such as { mean = [0, 0, 0], amplitude = \
                 [1, 0, 0], phase = 0, order = 1, period = 2, axes = \"laboratory\" }"
            }
            Self::Positive => "a number greater than zero",
            Self::NonNegative => "a number that is not negative",
            Self::Vector => "three numbers, such as [0, 0, 1]",
            Self::Vectors => "a list of three numbers each, such as [[0, 0, 1], [2, 0, 0]]",
            Self::Matrix => {
                "three rows of three numbers, such as [[0, 1, 0], [0, 0, 0], [0, 0, 0]]"
            }
            Self::PositiveVector => "three numbers greater than zero",
            Self::Range => "two numbers greater than zero, the smaller one first, such as [0.5, 2]",
            Self::Numbers => "a list of numbers, such as [0, 1, 2]",
            Self::NumbersByName => "a table of numbers, such as { arm = 6 }",
            Self::JointValues => {
                "a number for all links, a list of numbers, or a table such as { arm = 6 }"
            }
            Self::Count => "a whole number of at least 1",
            Self::Text => "a text that is not empty",
            Self::Texts => "a list of texts that are not empty",
            Self::Flag => "true or false",
            Self::Word(words) => return format!("one of {}", words.words.join(", ")),
            Self::Group => "a table",
        };
        text.to_owned()
    }
}

/// A table of the scene file, such as `[fluid]`.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct KeyTable {
    /// What stands before the names of its keys: `fluid.`, or `bodies[].` for a list.
    pub prefix: &'static str,
    /// What the table describes.
    pub meaning: &'static str,
    /// Its keys, and the tables in it, in the order in which scenes are written.
    pub keys: &'static [Key],
}

/// A type of values of keys: the kind that is checked, and the default if the table of keys gives
/// none.
pub(crate) trait KeyType {
    const KIND: Kind;
    const DEFAULT: &'static str = "";

    /// Asserts that serde reads and writes the words of a type of words.
    #[cfg(test)]
    fn check_words() {}
}

macro_rules! key_types {
    ($($kind:ident $(= $default:literal)?: $ty:ty;)+) => { $(
        impl KeyType for $ty {
            const KIND: Kind = Kind::$kind;
            $(const DEFAULT: &'static str = $default;)?
        }
    )+ };
}

key_types! {
    Number: f64;
    Vector: [f64; 3];
    Vectors: Vec<[f64; 3]>;
    Matrix: [[f64; 3]; 3];
    Range: [f64; 2];
    Numbers: Vec<f64>;
    NumbersByName: BTreeMap<String, f64>;
    Count: u32;
    Text: String;
    Texts: Vec<String>;
    Flag = "false": bool;
}

impl<T: KeyType> KeyType for Option<T> {
    const KIND: Kind = T::KIND;

    #[cfg(test)]
    fn check_words() {
        T::check_words();
    }
}

/// Defines the tables of a scene file: for each a struct that serde reads and writes, with its
/// default, and the description of its keys, whose meanings are the comments of the fields.
///
/// A field is written as `name: type [Kind] | "default in words"`, or with `= value` for a default
/// that is a value, or with `; value` for that of an `Option` which is filled in later. The kind
/// follows from the type unless it is given.
macro_rules! tables {
    ($(
        $(#[doc = $doc:literal])+
        $vis:vis struct $name:ident $(: $derive:ident)? in $prefix:literal {
            $(
                $(#[doc = $meaning:literal])+
                $(#[serde($serde:meta)])?
                $field:ident: $ty:ty $([$kind:ident])?
                    $(| $described:literal)? $(; $written:tt)? $(= $value:tt)?,
            )+
        }
    )+) => {
        /// All tables of a scene file, in the order in which scenes are written.
        pub const TABLES: &[KeyTable] = &[$($name::TABLE),+];

        /// Checks the words of all keys.
        #[cfg(test)]
        pub(super) fn check_words() {
            $( $( <$ty as KeyType>::check_words(); )+ )+
        }

        $(
            $(#[doc = $doc])+
            #[derive(Clone, Debug, PartialEq, Serialize, Deserialize $(, $derive)?)]
            #[serde(default)]
            #[non_exhaustive]
            $vis struct $name {
                $( $(#[doc = $meaning])+ $(#[serde($serde)])? pub $field: $ty, )+
            }

            impl $name {
                pub(crate) const TABLE: KeyTable = KeyTable {
                    prefix: $prefix,
                    meaning: concat!($($doc),+).trim_ascii(),
                    keys: &[$( Key {
                        path: concat!($prefix, stringify!($field)),
                        kind: tables!(@kind $ty $(, $kind)?),
                        default: tables!(@default $ty $(| $described)? $(; $written)? $(= $value)?),
                        meaning: concat!($($meaning),+).trim_ascii(),
                    } ),+],
                };
            }

            impl KeyType for $name {
                const KIND: Kind = Kind::Group;
            }

            impl KeyType for Vec<$name> {
                const KIND: Kind = Kind::Group;
            }

            impl Default for $name {
                fn default() -> Self {
                    Self { $( $field: tables!(@value $($value)?) ),+ }
                }
            }
        )+
    };
    (@kind $ty:ty) => { <$ty as KeyType>::KIND };
    (@kind $ty:ty, $kind:ident) => { Kind::$kind };
    (@default $ty:ty) => { KeyDefault::Value(<$ty as KeyType>::DEFAULT) };
    (@default $ty:ty | $described:literal) => { KeyDefault::Described($described) };
    (@default $ty:ty; $written:tt) => { KeyDefault::Value(stringify!($written)) };
    (@default $ty:ty = $value:tt) => { KeyDefault::Value(stringify!($value)) };
    (@value) => { Default::default() };
    (@value $value:tt) => { $value };
}

pub(super) use tables;
