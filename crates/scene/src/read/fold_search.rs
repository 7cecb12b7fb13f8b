//! The search for values of shape coordinates along a gait at which a body folds.

use crate::body::Body;
use crate::body_check::BodyCheck;
use crate::deformation::Deformation;
use crate::phase_span::PhaseSpan;

/// Number of parts of a phase span at whose ends volumes are checked; see [`MAX_EXAMINED`].
pub(super) const PARTS: usize = 64;

/// Part of a phase span that is not divided in the search for values at which a body folds: what
/// cannot be excluded there is so close that no mesh follows it.
const LEAST_PART: f64 = 1.0 / 1_048_576.0;

/// Number of values of a body in a phase span that are examined before parts below 1 / [`PARTS`]
/// are no longer divided: where many turns or frames are in one phase.
const MAX_EXAMINED: usize = 2048;

/// The search for values along a phase span at which a body folds.
pub(super) struct FoldSearch<'a> {
    span: &'a PhaseSpan,
    /// Largest second derivatives of the values.
    bends: Vec<f64>,
    bodies: Vec<Searched<'a>>,
}

/// A body whose shape changes along a phase span.
struct Searched<'a> {
    name: &'a str,
    deformation: &'a Deformation,
    /// Position in the span from which on its shapes repeat.
    end: f64,
    /// Number of values that were examined.
    examined: usize,
}

/// A place in a span, the number of the body that is wrong there, and what is wrong unless it just
/// cannot be excluded.
type Found = (f64, usize, Option<String>);

impl<'a> FoldSearch<'a> {
    /// The search for the bodies whose shapes change.
    pub fn new(span: &'a PhaseSpan, bodies: &'a [Body]) -> Self {
        let bends = span.second_derivatives();
        let searched = |body: &'a Body| {
            let deformation = body.deformation.as_ref()?;
            let moving = |joint: &usize| span.joints.contains(joint);
            let own: Vec<usize> = deformation.joints().filter(moving).collect();
            let period = match own[..] {
                [] => return None,
                [joint] if bends[joint] == 0.0 => {
                    let periods = deformation.periods();
                    let of_joint = periods.iter().find(|(other, _)| *other == joint);
                    of_joint.map(|(_, period)| period / (span.to[joint] - span.from[joint]).abs())
                }
                _ => None,
            };
            Some(Searched {
                name: &body.name,
                deformation,
                end: period.unwrap_or(1.0).min(1.0),
                examined: 0,
            })
        };
        let bodies = bodies.iter().filter_map(searched).collect();
        Self {
            span,
            bends,
            bodies,
        }
    }

    /// The first place at which something is wrong, the name of the body, and what it is.
    pub fn run(mut self) -> Option<(f64, &'a str, String)> {
        let all: Vec<usize> = (0..self.bodies.len()).collect();
        let (s, body, problem) = self.first((0.0, 1.0), &all)?;
        let near = || "comes so close to a fold that no mesh follows; deform it less".to_owned();
        Some((s, self.bodies[body].name, problem.unwrap_or_else(near)))
    }

    /// The first place on a part of the span at which something is wrong with one of these bodies
    /// or cannot be excluded, and what is wrong there or at the middle of a part around it.
    ///
    /// A part is divided until the bounds of the deformations exclude it for all values, down to
    /// [`LEAST_PART`]; to 1 / [`PARTS`] where smaller parts would not make it certain.
    fn first(&mut self, (from, to): (f64, f64), among: &[usize]) -> Option<Found> {
        if among.is_empty() {
            return None;
        }
        let (middle, width) = (0.5 * (from + to), to - from);
        let values = self.span.shape(middle);
        let bounds = self.span.value_bounds(&self.bends, (from, to));
        let change = |joint: usize| {
            let of_joint = bounds.get(joint);
            of_joint.map_or(0.0, |of| 0.5 * of.derivatives.first)
        };
        let is_short = width <= 1.0 / PARTS as f64;
        let (mut open, mut found): (Vec<usize>, Option<Found>) = (Vec::new(), None);
        for &number in among {
            let body = &mut self.bodies[number];
            if from >= body.end {
                continue;
            }
            body.examined += 1;
            let is_left = match body.deformation.check(&values, &change) {
                BodyCheck::Within => false,
                BodyCheck::Here | BodyCheck::Near(_) => true,
                BodyCheck::Unproven => !is_short,
                BodyCheck::Problem(problem) => {
                    found.get_or_insert((middle, number, Some(problem)));
                    true
                }
            };
            if is_left && !(is_short && body.examined > MAX_EXAMINED) {
                open.push(number);
            }
        }
        if width <= LEAST_PART {
            return found.or_else(|| Some((middle, *open.first()?, None)));
        }
        if let Some((s, number, problem)) = self.first((from, middle), &open) {
            let here = found.filter(|(_, other, _)| *other == number);
            let around = || here.and_then(|(_, _, problem)| problem);
            return Some((s, number, problem.or_else(around)));
        }
        found.or_else(|| self.first((middle, to), &open))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::Scene;
    use crate::gait::spans;

    /// Numbers of values that are examined of the bodies of a gait of one phase.
    fn examined(targets: &str) -> Vec<(String, usize)> {
        let worm = |name: &str, y: f64| {
            format!(
                "[[bodies]]\nname = \"{name}\"\nshape = \"tube\"\nlength = 10\nradius = 0.2\n\
                 position = [0, {y}, 0]\n\
                 deformation = {{ kind = \"undulation\", wave = \"helix\", amplitude = 0.3 }}\n"
            )
        };
        let bodies = worm("a", 0.0) + &worm("b", 5.0);
        let text = format!("{bodies}[[gait.phases]]\ntargets = {{ {targets} }}");
        let scene = Scene::parse(&text).unwrap();
        let start = scene.articulation().initial_shape();
        let span = spans(scene.gait(), start).unwrap().next().unwrap();
        let mut search = FoldSearch::new(&span, scene.bodies());
        let all: Vec<usize> = (0..search.bodies.len()).collect();
        assert_eq!(search.first((0.0, 1.0), &all), None);
        let count = |body: &Searched<'_>| (body.name.to_owned(), body.examined);
        search.bodies.iter().map(count).collect()
    }

    /// All turns of a wave were examined, and bodies at rest as often as those that move.
    #[test]
    fn bug_shapes_that_repeat_were_examined_again() {
        let turns = |number: f64| examined(&format!("\"a.phase\" = {}", number * TAU));
        let [one, many] = [turns(1.0), turns(32.0)];
        assert_eq!(one.len(), 1);
        assert_eq!(one[0].0, "a");
        // The parts around the first turn are those of one turn and five larger ones.
        assert_eq!(many[0].1, one[0].1 + 5);
        // Another amplitude is another shape.
        let both = examined(&format!(
            "\"a.phase\" = {}, \"a.amplitude\" = 0.31",
            4.0 * TAU
        ));
        assert!(both[0].1 > 2 * one[0].1, "{both:?} {one:?}");
    }
}
