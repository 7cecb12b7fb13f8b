//! The keys of a scene file: the one place where names, types, defaults and meanings are written down.

use crate::words::{
    ArmsKind, DomainKind, EstimatesKind, FormulationKind, GeometryKind, MeshMotionKind, MirrorKind,
    ModelKind, ShapeKind, SolverKind,
};

/// A key of the scene file.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Its full name; `[]` stands for the entries of a list.
    pub path: &'static str,
    /// The values it takes.
    pub kind: Kind,
    /// Its value when it is left out, in words when there is no fixed one.
    pub default: &'static str,
    /// What it means.
    pub meaning: &'static str,
}

/// The values that a key takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A finite number greater than zero.
    Positive,
    /// A finite number that is not negative.
    NonNegative,
    /// Three finite numbers.
    Vector,
    /// Three finite numbers greater than zero.
    PositiveVector,
    /// A whole number of at least one.
    Count,
    /// A text that is not empty.
    Text,
    /// A list of texts.
    Texts,
    /// `true` or `false`.
    Flag,
    /// One of these words.
    Word(&'static [&'static str]),
}

const fn key(path: &'static str, kind: Kind, default: &'static str, meaning: &'static str) -> Key {
    Key {
        path,
        kind,
        default,
        meaning,
    }
}

/// All keys of a scene file, in the order in which scenes are written.
pub const KEYS: &[Key] = &[
    key("fluid.viscosity", Kind::Positive, "1", "dynamic viscosity"),
    key(
        "domain.kind",
        Kind::Word(DomainKind::WORDS),
        "unbounded",
        "where the fluid is: everywhere, in a ball or a box about the origin, in a cylinder about the x axis, \
         above the wall z = 0, or in the volume of a mesh file",
    ),
    key(
        "domain.radius",
        Kind::Positive,
        "required for ball and cylinder",
        "radius of the ball or the cylinder",
    ),
    key(
        "domain.size",
        Kind::PositiveVector,
        "required for box",
        "edge lengths of the box",
    ),
    key(
        "domain.file",
        Kind::Text,
        "required for mesh",
        "Gmsh file, relative to the scene file",
    ),
    key(
        "domain.walls",
        Kind::Texts,
        "required for mesh",
        "names of the parts of the mesh's boundary that are walls",
    ),
    key(
        "bodies[].name",
        Kind::Text,
        "required",
        "name of the body, unique",
    ),
    key(
        "bodies[].shape",
        Kind::Word(ShapeKind::WORDS),
        "sphere",
        "shape; a point is a massless joint without surface",
    ),
    key(
        "bodies[].radius",
        Kind::Positive,
        "required unless the shape is point",
        "radius; of a spheroid that of its equator",
    ),
    key(
        "bodies[].half_length",
        Kind::Positive,
        "required for spheroid",
        "half the length of a spheroid along its axis of revolution",
    ),
    key(
        "bodies[].axis",
        Kind::Vector,
        "[1, 0, 0]",
        "direction of a spheroid's axis at the start",
    ),
    key(
        "bodies[].position",
        Kind::Vector,
        "required",
        "centre at the start",
    ),
    key(
        "bodies[].surface",
        Kind::Text,
        "required for domain.kind = mesh",
        "name of the body's part of the mesh's boundary",
    ),
    key(
        "bodies[].force",
        Kind::Vector,
        "[0, 0, 0]",
        "external force",
    ),
    key(
        "bodies[].torque",
        Kind::Vector,
        "[0, 0, 0]",
        "external torque about the centre",
    ),
    key(
        "bodies[].fixed",
        Kind::Flag,
        "false",
        "whether the body is held still: an obstacle; it has no links and no loads",
    ),
    key(
        "bodies[].mass",
        Kind::NonNegative,
        "0",
        "mass; zero means without inertia",
    ),
    key(
        "bodies[].inertia",
        Kind::NonNegative,
        "0",
        "moment of inertia about the centre; zero means without inertia",
    ),
    key(
        "links[].name",
        Kind::Text,
        "required",
        "name of the link, unique",
    ),
    key(
        "links[].body",
        Kind::Text,
        "required",
        "the body that the link moves, seen from `to`",
    ),
    key(
        "links[].to",
        Kind::Text,
        "required",
        "the body it is linked to",
    ),
    key(
        "gait.arms",
        Kind::Word(ArmsKind::WORDS),
        "clamped",
        "bodies keep their attitude to the frame, spin freely on it, or arms keep their direction in the laboratory",
    ),
    key(
        "gait.cycles",
        Kind::Count,
        "1",
        "how many times the phases are repeated",
    ),
    key(
        "gait.phases[].link",
        Kind::Text,
        "none: all lengths are held",
        "the link whose length changes",
    ),
    key(
        "gait.phases[].length",
        Kind::Positive,
        "required with link",
        "its length at the end of the phase",
    ),
    key(
        "gait.phases[].duration",
        Kind::Positive,
        "1",
        "duration of the phase",
    ),
    key(
        "model.kind",
        Kind::Word(ModelKind::WORDS),
        "auto",
        "model of the flow; auto takes the least model that meets the tolerance",
    ),
    key(
        "model.tolerance",
        Kind::Positive,
        "1e-3",
        "relative error asked of the net displacement of a cycle",
    ),
    key(
        "fem.formulation",
        Kind::Word(FormulationKind::WORDS),
        "p-tilde",
        "how the links are imposed",
    ),
    key(
        "fem.solver",
        Kind::Word(SolverKind::WORDS),
        "block",
        "solver of the linear systems; minres needs the least memory and a symmetric formulation, schwarz is there to compare with",
    ),
    key(
        "fem.subdomains",
        Kind::Count,
        "8",
        "number of subdomains of solver = \"schwarz\"",
    ),
    key(
        "fem.overlap",
        Kind::Count,
        "1",
        "layers of overlap of solver = \"schwarz\"",
    ),
    key(
        "fem.rtol",
        Kind::Positive,
        "1e-8",
        "true residual at which the solver stops, relative to the right side",
    ),
    key(
        "fem.surface_size",
        Kind::Positive,
        "0.4 of the radius",
        "element size on the bodies' surfaces",
    ),
    key(
        "fem.size_factor",
        Kind::Positive,
        "1, or what fem.target needs",
        "factor on the element sizes on all bodies",
    ),
    key(
        "fem.target",
        Kind::Positive,
        "none: the mesh is not adapted",
        "relative error by the mesh: of velocities and forces where one instant is solved, of the net displacement where a gait is run; chooses element sizes, unless size_factor is given too",
    ),
    key(
        "fem.estimates",
        Kind::Word(EstimatesKind::WORDS),
        "on",
        "whether errors by the mesh are estimated; without them a stroke takes about two thirds of the time",
    ),
    key(
        "fem.geometry",
        Kind::Word(GeometryKind::WORDS),
        "curved",
        "shape of the elements at the bodies",
    ),
    key(
        "fem.mesh_motion",
        Kind::Word(MeshMotionKind::WORDS),
        "kanchi-masud",
        "how the mesh follows the bodies until it is made anew; the others are there to compare with",
    ),
    key(
        "fem.mirror",
        Kind::Word(MirrorKind::WORDS),
        "auto",
        "whether coordinate planes through the origin that mirror bodies, loads and domain for the whole run are found, and one side of each is \
         meshed: a half or a quarter of the unknowns",
    ),
];

/// Looks up a key by its path without indices.
pub fn find(path: &str) -> Option<&'static Key> {
    KEYS.iter().find(|key| key.path == path)
}

/// Whether some key lies below this path.
pub fn is_group(path: &str) -> bool {
    KEYS.iter().any(|key| {
        key.path.starts_with(path)
            && matches!(key.path.as_bytes().get(path.len()), Some(b'.' | b'['))
    })
}

/// What to write instead of an unknown key or word: the nearest of the candidates, if one is near.
///
/// Near means at most a third of the letters wrong, so that a slip is corrected and a guess is not.
pub fn nearest<'a>(wrong: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    candidates
        .into_iter()
        .map(|right| (edit_distance(wrong, right), right))
        .min()
        .filter(|(distance, right)| 3 * distance <= right.chars().count().max(3) + 2)
        .map(|(_, right)| right)
}

/// Number of letters to insert, delete, replace or swap with a neighbour to turn one text into the other
/// (optimal string alignment).
fn edit_distance(a: &str, b: &str) -> usize {
    // No key is longer, and a monstrous one must not cost a monstrous table.
    const LONGEST: usize = 64;
    let letters = |text: &str| text.chars().take(LONGEST).collect::<Vec<char>>();
    let (a, b) = (letters(a), letters(b));
    let mut rows = vec![(0..=b.len()).collect::<Vec<_>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replace = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replace.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            row.push(best);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_one_edit_away() {
        assert_eq!(edit_distance("viscosity", "viscosity"), 0);
        assert_eq!(edit_distance("viscocity", "viscosity"), 1);
        assert_eq!(edit_distance("raduis", "radius"), 1);
        assert_eq!(edit_distance("", "abc"), 3);
    }

    #[test]
    fn a_slip_is_corrected_and_a_guess_is_not() {
        assert_eq!(
            nearest("viscocity", ["viscosity", "radius"]),
            Some("viscosity")
        );
        assert_eq!(nearest("temperature", ["viscosity", "radius"]), None);
    }

    #[test]
    fn groups_are_told_from_keys() {
        assert!(
            is_group("fem") && is_group("gait.phases") && !is_group("fem.rtol") && !is_group("f")
        );
        assert!(find("bodies[].radius").is_some() && find("bodies").is_none());
    }
}
