//! Tables of the model over shape space, and superposed solutions, where they save solves.

use std::collections::HashSet;

use models::{ErrorEstimates, ModelError, Superposed, Tabulated};
use scene::{Gait, Phase, Scene, spans};

use super::Choice;
use crate::integrate::{TYPICAL_SOLVES_PER_SPAN, velocity_tolerance};

/// Number of points per variable in a typical table.
const TYPICAL_POINTS: usize = 9;

/// Time of a solve for a table over that of one along a gait, where estimates are computed on
/// request: all solves of a table have them, and a few of a gait.
///
/// The three-sphere swimmer by elements in unbounded fluid takes 7.7 s of processor time for one
/// cycle of 24 solves, and 29 s for two by a table of 36.
const ESTIMATED_COST: usize = 3;

/// Adds tables over shape space to a model where they save solves: for free swimmers whose gait
/// repeats shapes.
///
/// The tables are added to the reasons of the choice.
///
/// # Errors
/// A model of another scene, whose solutions cannot be superposed.
pub fn with_tables(scene: &Scene, choice: Choice) -> Result<Choice, ModelError> {
    if scene.inertia().is_kept() || scene.noise().is_some() {
        // The motion depends on the past or on chance, not on the shape alone.
        return Ok(choice);
    }
    if scene.viscosity_law().is_some() {
        // Velocities depend on the rates of the joints nonlinearly: tables and sums do not exist.
        return Ok(choice);
    }
    let cost = match choice.model.capabilities().error_estimates {
        ErrorEstimates::OnRequest => ESTIMATED_COST,
        _ => 1,
    };
    let Some(boxes) = boxes(scene, cost) else {
        return with_superposition(scene, choice);
    };
    // The highest accuracy of a table in double precision.
    let tolerance = velocity_tolerance(scene).max(1e-13);
    let mut reasons = choice.reasons;
    reasons.push(match boxes.len() {
        1 => "tabulated over the shapes of the gait, which repeat in every cycle".to_owned(),
        n => format!("tabulated along {n} lines of shape space, which repeat in every cycle"),
    });
    Ok(Choice {
        model: Box::new(Tabulated::new(scene, choice.model, boxes, tolerance)),
        reasons,
    })
}

/// Superposes the solutions of a rigid body in a linear flow, if that saves solves by elements.
fn with_superposition(scene: &Scene, choice: Choice) -> Result<Choice, ModelError> {
    let solves = typical_solves(scene.gait(), |_| true);
    // Other models are fast, or serve bodies that keep their axis only.
    let is_slow = choice.model.capabilities().has_mesh;
    let count = Superposed::count(scene).filter(|&count| is_slow && count < solves);
    let Some(count) = count else {
        return Ok(choice);
    };
    let Choice { model, mut reasons } = choice;
    reasons.push(format!(
        "superposed from {count} orientations, on which the motion of a rigid body depends linearly"
    ));
    let model = Box::new(Superposed::new(model)?);
    Ok(Choice { model, reasons })
}

/// Number of solves of a typical integration over some phases of every cycle.
fn typical_solves(gait: &Gait, is_solved: impl Fn(&Phase) -> bool) -> usize {
    let phases = gait.phases.iter().filter(|phase| is_solved(phase)).count();
    (phases * TYPICAL_SOLVES_PER_SPAN).saturating_mul(gait.cycles as usize)
}

/// The boxes of joint values that the tables for a gait cover; none if tables would take longer
/// than the gait without them, where a solve for a table takes as long as `cost` others.
///
/// Either one box for the shapes of each phase, a line in shape space if one joint moves, or one
/// box for all.
fn boxes(scene: &Scene, cost: usize) -> Option<Vec<Vec<(f64, f64)>>> {
    if !scene.is_free() {
        return None;
    }
    // From the second cycle on, all cycles have the same shapes.
    let gait = Gait {
        cycles: scene.gait().cycles.min(2),
        phases: scene.gait().phases.clone(),
    };
    let mut lines: Vec<Vec<(f64, f64)>> = Vec::new();
    // By their bits, so that thousands of phases are found fast.
    let mut known = HashSet::new();
    let mut all: Vec<(f64, f64)> = Vec::new();
    for span in spans(&gait, scene.articulation().initial_shape()).ok()? {
        let line = span.ranges();
        if all.is_empty() {
            all.clone_from(&line);
        }
        for (whole, part) in all.iter_mut().zip(&line) {
            *whole = (whole.0.min(part.0), whole.1.max(part.1));
        }
        let moves = line.iter().any(|r| r.0 < r.1);
        let bits: Vec<_> = line
            .iter()
            .map(|r| (r.0.to_bits(), r.1.to_bits()))
            .collect();
        if moves && known.insert(bits) {
            lines.push(line);
        }
    }
    let direct = typical_solves(scene.gait(), |phase| !phase.path.joints().is_empty());
    let points = |ranges: &[(f64, f64)]| {
        let variables = ranges.iter().filter(|r| r.0 < r.1).count();
        TYPICAL_POINTS.saturating_pow(variables as u32)
    };
    let whole = points(&all);
    let by_lines = (lines.iter()).fold(0_usize, |sum, line| sum.saturating_add(points(line)));
    if lines.is_empty() || whole.min(by_lines).saturating_mul(cost) >= direct {
        return None;
    }
    Some(if whole < by_lines { vec![all] } else { lines })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(cycles: u32, phases: &[(&str, f64)], domain: &str) -> Scene {
        let phases: String = phases
            .iter()
            .map(|(joint, length)| {
                format!("[[gait.phases]]\nlink = \"{joint}\"\nlength = {length}\n")
            })
            .collect();
        Scene::parse(&format!(
            "domain = {domain}\ngait.cycles = {cycles}\n\
             bodies = [{{ name = \"l\", radius = 1, position = [-10, 0, 0] }}, \
             {{ name = \"c\", radius = 1, position = [0, 0, 0] }}, \
             {{ name = \"r\", radius = 1, position = [10, 0, 0] }}]\n\
             links = [{{ name = \"a\", body = \"l\", to = \"c\" }}, \
             {{ name = \"b\", body = \"r\", to = \"c\" }}]\n{phases}"
        ))
        .unwrap()
    }

    const STROKE: [(&str, f64); 4] = [("a", 6.0), ("b", 6.0), ("a", 10.0), ("b", 10.0)];
    const UNBOUNDED: &str = "{ kind = \"unbounded\" }";

    #[test]
    fn one_cycle_needs_no_table_and_more_cycles_use_one_table_per_line() {
        assert_eq!(boxes(&scene(1, &STROKE, UNBOUNDED), 1), None);
        let lines = boxes(&scene(2, &STROKE, UNBOUNDED), 1).unwrap();
        assert_eq!(lines.len(), 4);
        assert_eq!(lines[0], [(6.0, 10.0), (10.0, 10.0)]);
        assert_eq!(
            boxes(&scene(9, &STROKE, "{ kind = \"ball\", radius = 40 }"), 1),
            None
        );
        // 36 solves with estimates took twice as long as 48 of which 16 had them
        let with_estimates = |cycles| boxes(&scene(cycles, &STROKE, UNBOUNDED), ESTIMATED_COST);
        assert!(with_estimates(2).is_none() && with_estimates(5).is_some());
    }

    #[test]
    fn many_short_phases_share_one_table() {
        // A diagonal of shape space in steps: twenty different lines.
        let steps: Vec<(&str, f64)> = (1..=10)
            .flat_map(|k| {
                let length = 10.0 - 0.4 * f64::from(k);
                [("a", length), ("b", length)]
            })
            .collect();
        let boxes = boxes(&scene(3, &steps, UNBOUNDED), 1).unwrap();
        assert_eq!(boxes, [[(6.0, 10.0), (6.0, 10.0)]]);
    }
}
