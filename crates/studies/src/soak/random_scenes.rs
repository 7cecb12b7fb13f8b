//! Random scenes.

use swimmer::scene::closest_contact;
use swimmer::{Scene, spans};

use crate::random::Random;
use crate::scenes::SceneText;

/// Fraction of scenes solved by finite elements, which take a thousand times as long.
pub const FINITE_ELEMENTS: f64 = 0.05;

/// Element size on a sphere over its radius: as coarse as is reasonable.
const SURFACE_SIZE: f64 = 0.8;

/// Smallest clearance between surfaces at the ends of phases.
///
/// With narrower gaps between bodies that are not on one axis a solve takes seconds, so few scenes
/// would be run.
const MIN_GAP: f64 = 1.0;

/// Smallest clearance at the start and at the ends of phases, with linkages at their initial
/// positions; negative if a length is impossible.
fn smallest_gap(scene: &Scene) -> f64 {
    let set = scene.articulation();
    let state = scene.initial_state();
    let Ok(spans) = spans(scene.gait(), set.initial_shape()) else {
        return -1.0;
    };
    let ends = spans.map(|span| span.to);
    let shapes = std::iter::once(set.initial_shape().to_vec()).chain(ends);
    let gap = |shape: Vec<f64>| {
        let poses = set.place(&state, &shape).ok()?;
        let contact = closest_contact(scene.bodies(), scene.domain(), &poses);
        Some(contact.map_or(f64::INFINITY, |contact| contact.gap))
    };
    let gaps = shapes.map(|shape| gap(shape).unwrap_or(-1.0));
    gaps.fold(f64::INFINITY, f64::min)
}

/// Random scene with its text, solved by finite elements with probability `elements`.
///
/// Invalid scenes, such as spheres that touch during the stroke, are replaced by new ones.
pub fn draw(random: &mut Random, elements: f64) -> (SceneText, Scene) {
    loop {
        let text = text(random, elements);
        if let Ok(scene) = text.parse()
            && smallest_gap(&scene) > MIN_GAP
        {
            return (text, scene);
        }
    }
}

/// Spheres at random places, each at some distance from an earlier one.
struct Layout {
    /// Whether the first body is a point that all others are linked to.
    has_junction: bool,
    places: Vec<[f64; 3]>,
    /// Joints: the body, the one that it is linked to, and the length.
    joints: Vec<(usize, usize, f64)>,
    /// A body that does not move.
    fixed: Option<usize>,
}

impl Layout {
    fn draw(random: &mut Random, max_bodies: usize) -> Self {
        let bodies = 1 + random.below(max_bodies);
        let has_junction = bodies > 2 && random.chance(0.2);
        let mut places = vec![[0.0; 3]];
        let mut joints = Vec::new();
        for body in 1..bodies {
            let to = if has_junction { 0 } else { random.below(body) };
            let (e, length) = (random.direction(), random.within(3.0, 7.0));
            places.push(std::array::from_fn(|axis| {
                places[to][axis] + length * e[axis]
            }));
            // A body without joints is a separate swimmer.
            if has_junction || random.chance(0.85) {
                joints.push((body, to, length));
            }
        }
        let mut fixed = None;
        if !has_junction && random.chance(0.15) {
            fixed = Some(places.len());
            let e = random.direction();
            places.push(e.map(|x| 6.0 * x));
        }
        Self {
            has_junction,
            places,
            joints,
            fixed,
        }
    }

    /// Distance of the farthest body from the origin.
    fn extent(&self) -> f64 {
        let distances = self.places.iter();
        let distances = distances.map(|x| x.iter().map(|c| c * c).sum::<f64>().sqrt());
        distances.fold(0.0, f64::max)
    }
}

fn text(random: &mut Random, elements: f64) -> SceneText {
    let by_elements = random.chance(elements);
    let domain = match by_elements {
        true => "ball",
        false => random.pick(&["unbounded", "unbounded", "ball", "wall"]),
    };
    let mut layout = Layout::draw(random, if by_elements { 2 } else { 4 });
    let extent = layout.extent();
    if domain == "wall" {
        let low = layout.places.iter().map(|x| x[2]).fold(0.0, f64::min);
        // Closer to the wall, a solve for four spheres takes half a second.
        let height = random.within(3.5, 9.0) - low;
        layout.places.iter_mut().for_each(|x| x[2] += height);
    }
    let kind = match (by_elements, domain) {
        (true, _) => "fem",
        (false, "ball") => random.pick(&["rpy", "multipole", "auto"]),
        (false, _) => random.pick(&["oseen", "rpy", "multipole", "auto"]),
    };
    let digits = random.within(2.0, if by_elements { 2.0 } else { 4.0 });
    let tolerance = 10.0_f64.powf(-digits);
    let model = format!("model = {{ kind = \"{kind}\", tolerance = {tolerance:e} }}");
    let mut text = SceneText::new(format!("domain.kind = \"{domain}\"")).line(model);
    if domain == "ball" {
        text = text.key("domain.radius", 2.0 * extent + random.within(5.0, 15.0));
    }
    let viscosity = 10.0_f64.powf(random.within(-3.0, 3.0));
    let arms = random.pick(&["clamped", "clamped", "free", "lab"]);
    let most = if by_elements { 1 } else { 3 };
    text = text
        .key("fluid.viscosity", viscosity)
        .key("gait.arms", arms);
    text = text.key("gait.cycles", 1 + random.below(most));
    let (text, smallest) = bodies(text, random, &layout, viscosity);
    let text = gait(text, random, &layout, most);
    if !by_elements {
        return text;
    }
    let size = SURFACE_SIZE * smallest;
    let formulation = random.pick(&["p-tilde", "lagrange", "direct-row"]);
    text.line("[fem]")
        .key("surface_size", size)
        .key("formulation", formulation)
}

/// The text with bodies, and the smallest radius.
fn bodies(
    mut text: SceneText,
    random: &mut Random,
    layout: &Layout,
    viscosity: f64,
) -> (SceneText, f64) {
    let mut smallest = f64::INFINITY;
    for (body, &place) in layout.places.iter().enumerate() {
        text = text.body(format_args!("b{body}"), place);
        if layout.has_junction && body == 0 {
            text = text.key("shape", "point");
            continue;
        }
        let radius = random.within(0.5, 1.2);
        smallest = smallest.min(radius);
        text = text.key("radius", radius);
        if layout.fixed == Some(body) {
            text = text.key("fixed", true);
        } else if random.chance(0.2) {
            // About a twentieth of a radius per unit of time, so that few bodies hit each other or
            // a wall.
            text = text.key("force", random.direction().map(|x| viscosity * x));
        }
    }
    (text, smallest)
}

/// The text with joints and phases.
fn gait(mut text: SceneText, random: &mut Random, layout: &Layout, most: usize) -> SceneText {
    let joints = &layout.joints;
    for (number, (body, to, _)) in joints.iter().enumerate() {
        let [name, body] = [format!("l{number}"), format!("b{body}")];
        text = text.joint(name, body, format_args!("b{to}"));
    }
    if !joints.is_empty() {
        let mut lengths: Vec<f64> = joints.iter().map(|joint| joint.2).collect();
        for _ in 0..1 + random.below(most + 1) {
            let joint = random.below(joints.len());
            lengths[joint] = (lengths[joint] * random.within(0.7, 1.4)).clamp(2.0, 9.0);
            text = text.phase(format_args!("l{joint}"), lengths[joint]);
        }
    } else if random.chance(0.5) {
        // Only loads move the bodies.
        text = text.line("[[gait.phases]]\nduration = 0.5");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_seed_gives_the_same_scenes() {
        let (mut a, mut b) = (Random(7), Random(7));
        for _ in 0..20 {
            assert_eq!(draw(&mut a, 0.5).0.0, draw(&mut b, 0.5).0.0);
        }
        assert_ne!(draw(&mut Random(7), 0.5).0.0, draw(&mut Random(8), 0.5).0.0);
    }
}
