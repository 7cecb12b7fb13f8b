//! Keys of the groups `links` and `gait`.

use super::key::Key;
use super::key::KeyDefault::{Described, Value};
use super::key::Kind;
use super::table::key;
use crate::words::{ArmsKind, DriveKind, GaitKind, InterpolationKind, JointWord};

/// The keys, in the order in which scenes are written.
pub(super) const OF_GAIT: &[Key] = &[
    key(
        "links[].name",
        Kind::Text,
        Described("required"),
        "name of the link, unique",
    ),
    key(
        "links[].body",
        Kind::Text,
        Described("required"),
        "body that the link moves relative to the body `to`",
    ),
    key(
        "links[].to",
        Kind::Text,
        Described("required"),
        "body that it is linked to",
    ),
    key(
        "links[].joint",
        Kind::Word(JointWord::WORDS),
        Value("slide"),
        "relative motion of the two bodies: along the line of their centres (slide), about an axis \
         (hinge, rotor), about a point (ball), about and along an axis (screw), or none (fixed); \
         the value of a slide is the distance of the centres, that of the others the angle in \
         radians from the pose of the file, counterclockwise about the axis for `body`",
    ),
    key(
        "links[].axis",
        Kind::Vector,
        Described("required for hinges; from `to` to `body` for rotors and screws"),
        "direction of the axis in the pose of the file",
    ),
    key(
        "links[].pivot",
        Kind::Vector,
        Described("centre of `to` for hinges and balls, of `body` for rotors and screws"),
        "point of the axis, or centre of a ball, in the pose of the file",
    ),
    key(
        "links[].pitch",
        Kind::Number,
        Described("required for screws"),
        "translation along the axis per turn",
    ),
    key(
        "links[].drive",
        Kind::Word(DriveKind::WORDS),
        Value("prescribed"),
        "what determines the value of the joint: the gait (prescribed), a spring, a force \
         or nothing (free); balls are always free",
    ),
    key(
        "links[].stiffness",
        Kind::NonNegative,
        Described("required for springs"),
        "force of the spring per change of the value; torque per radian for joints that turn",
    ),
    key(
        "links[].rest",
        Kind::Number,
        Described("the value at the start"),
        "value at which the spring has no force",
    ),
    key(
        "links[].force",
        Kind::Oscillation,
        Described("required for the drive `force`"),
        "force that increases the value, torque for joints that turn: a constant, or mean + \
         amplitude sin(2 pi order t / period + phase), with the gait's period by default",
    ),
    key(
        "links[].damping",
        Kind::NonNegative,
        Described("0, if not prescribed"),
        "force against the motion of the joint, per rate of its value",
    ),
    key(
        "gait.arms",
        Kind::Word(ArmsKind::WORDS),
        Value("clamped"),
        "bodies keep their orientation relative to the frame (clamped), rotate freely on it \
         (free), or arms keep their direction in the laboratory frame (lab)",
    ),
    key(
        "gait.cycles",
        Kind::Count,
        Value("1"),
        "number of times that the phases are repeated",
    ),
    key(
        "gait.periodic",
        Kind::Flag,
        Value("false"),
        "whether passive joints start from the values of the periodic state, which are searched \
         first; otherwise they start from the pose of the file",
    ),
    key(
        "gait.phases[].link",
        Kind::Text,
        Described("none: all joints are at rest"),
        "link whose value changes",
    ),
    key(
        "gait.phases[].length",
        Kind::Number,
        Described("required with `link`"),
        "value of the link at the end of the phase: length of a slide, angle of other joints",
    ),
    key(
        "gait.phases[].targets",
        Kind::NumbersByName,
        Described("none; instead of `link` and `length`"),
        "values of several links at the end of the phase, by name; they change at the same time",
    ),
    key(
        "gait.phases[].duration",
        Kind::Positive,
        Value("1"),
        "duration of the phase",
    ),
    key(
        "gait.kind",
        Kind::Word(GaitKind::WORDS),
        Described("what is given"),
        "phases with constant rates, smooth oscillations of several links at once, or a table of \
         times and values",
    ),
    key(
        "gait.file",
        Kind::Text,
        Described("required for a table"),
        "file of comma-separated values beside the scene file: a line with the names `time` and \
         links, then lines of numbers; the bodies start at the values of the first one",
    ),
    key(
        "gait.interpolation",
        Kind::Word(InterpolationKind::WORDS),
        Described("`cubic`, for a table"),
        "between the rows of the table: a spline with two continuous derivatives, periodic if the \
         last row has the values of the first one, the same with a corner there, or constant rates",
    ),
    key(
        "gait.period",
        Kind::Positive,
        Described("required with `harmonics`"),
        "period of the oscillations, one cycle",
    ),
    key(
        "gait.harmonics[].link",
        Kind::Text,
        Described("required"),
        "link with the value mean + amplitude sin(2 pi order t / period + phase); several entries \
         for one link are summed",
    ),
    key(
        "gait.harmonics[].mean",
        Kind::Number,
        Described("that for which the bodies start at their positions"),
        "mean value of the link; the bodies then start at the values of `t = 0`",
    ),
    key(
        "gait.harmonics[].amplitude",
        Kind::Positive,
        Described("required"),
        "amplitude of the term",
    ),
    key(
        "gait.harmonics[].phase",
        Kind::NonNegative,
        Value("0"),
        "phase angle of the term, in radians",
    ),
    key(
        "gait.harmonics[].order",
        Kind::Count,
        Value("1"),
        "number of oscillations in a period",
    ),
];
