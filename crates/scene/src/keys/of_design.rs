//! Keys of the groups `optimise` and `learn`.

use super::key::KeyDefault::{Described, Value};
use super::key::{Key, Kind};
use super::table::key;
use crate::design_words::{LearnKind, ObjectiveKind, StrokeStart};

/// The keys, in the order in which scenes are written.
pub(super) const OF_DESIGN: &[Key] = &[
    key(
        "optimise.objective",
        Kind::Word(ObjectiveKind::WORDS),
        Value("efficiency"),
        "what `swim optimise` searches: the stroke of the highest Lighthill efficiency, of the \
         largest displacement, of the least energy for a displacement or a rotation, or of the \
         largest displacement per time within `max_rate` and `max_power`",
    ),
    key(
        "optimise.start",
        Kind::Word(StrokeStart::WORDS),
        Value("closed"),
        "a smooth closed stroke, or one that starts at the shape of the scene, where it may have a \
         corner (fixed)",
    ),
    key(
        "optimise.displacement",
        Kind::Positive,
        Described("that of the gait; for `objective = \"energy\"`"),
        "net displacement of the stroke",
    ),
    key(
        "optimise.rotation",
        Kind::Number,
        Described("required for `objective = \"rotation\"`"),
        "net rotation of the stroke about `axis`, in radians",
    ),
    key(
        "optimise.direction",
        Kind::Vector,
        Described("none: the length of the displacement counts"),
        "direction in which the displacement counts, in the frame of the start",
    ),
    key(
        "optimise.axis",
        Kind::Vector,
        Value("[0, 0, 1]"),
        "axis of the rotation that `objective = \"rotation\"` asks for",
    ),
    key(
        "optimise.lower",
        Kind::JointValues,
        Described("the smallest values in the gait"),
        "smallest values of the joints, for `swim map` and `swim optimise`",
    ),
    key(
        "optimise.upper",
        Kind::JointValues,
        Described("the largest values in the gait"),
        "largest values of the joints",
    ),
    key(
        "optimise.gap",
        Kind::NonNegative,
        Described("a tenth of the smallest radius"),
        "smallest gap between bodies that a slide connects; it raises `lower`",
    ),
    key(
        "optimise.radii",
        Kind::Range,
        Described("none: the radii stay"),
        "smallest and largest radius that `swim sizes` may choose; the sum of the volumes stays",
    ),
    key(
        "optimise.arms",
        Kind::Range,
        Described("none: the lengths stay"),
        "smallest and largest length along the gait of the arms that `swim sizes` may lengthen or \
         shorten; the sum of the lengths stays",
    ),
    key(
        "optimise.period",
        Kind::Positive,
        Value("1"),
        "period of the stroke",
    ),
    key(
        "optimise.power",
        Kind::Positive,
        Described("none: the period is given"),
        "mean power of the stroke, which determines its period",
    ),
    key(
        "optimise.max_rate",
        Kind::JointValues,
        Described("none"),
        "largest rates of the joints: the stroke is as fast as they and `max_power` allow",
    ),
    key(
        "optimise.max_power",
        Kind::Positive,
        Described("none"),
        "largest power on the fluid along the stroke, instead of `power` and `period`",
    ),
    key(
        "optimise.terms",
        Kind::Count,
        Value("64"),
        "largest number of terms of the series of each joint, at most 128; strokes of \
         `objective = \"speed\"` have at most twice as many corners",
    ),
    key(
        "optimise.tolerance",
        Kind::Positive,
        Value("2e-4"),
        "relative change of the optimum, with twice as many terms, at which the search ends",
    ),
    key(
        "learn.method",
        Kind::Word(LearnKind::WORDS),
        Value("q"),
        "Q-learning, or double Q-learning",
    ),
    key(
        "learn.contracted",
        Kind::JointValues,
        Described("required for `swim learn`"),
        "values of contracted joints",
    ),
    key(
        "learn.extended",
        Kind::JointValues,
        Described("the values at the start"),
        "values of extended joints",
    ),
    key(
        "learn.direction",
        Kind::Vector,
        Value("[1, 0, 0]"),
        "direction in which the displacement of the mean of the bodies is rewarded",
    ),
    key(
        "learn.episodes",
        Kind::Count,
        Value("100"),
        "number of episodes; each starts with all joints extended",
    ),
    key(
        "learn.steps",
        Kind::Count,
        Value("100"),
        "number of steps of an episode; a step contracts or extends one joint",
    ),
    key(
        "learn.discount",
        Kind::NonNegative,
        Value("0.9"),
        "discount of rewards per step, below 1; short-sighted swimmers do not learn to swim",
    ),
    key(
        "learn.rate",
        Kind::Positive,
        Value("0.5"),
        "share of an old value that an update replaces, at most 1",
    ),
    key(
        "learn.exploration",
        Kind::NonNegative,
        Value("0.3"),
        "probability of a random step, at most 1",
    ),
    key(
        "learn.seed",
        Kind::Count,
        Value("1"),
        "seed of the random numbers",
    ),
];
