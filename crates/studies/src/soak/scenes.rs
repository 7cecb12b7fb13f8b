//! Random scenes.

use std::fmt::Write;

use swimmer::scene::closest_contact;
use swimmer::{Scene, spans};

use crate::random::Random;

/// Fraction of scenes solved by finite elements, which take a thousand times as long.
pub const FINITE_ELEMENTS: f64 = 0.05;

/// Element size on a sphere over its radius: as coarse as is reasonable.
const SURFACE_SIZE: f64 = 0.8;

/// Smallest clearance between surfaces at the ends of phases.
///
/// With narrower gaps between bodies that are not on one axis a solve takes seconds, so few scenes
/// would be run.
const LEAST_GAP: f64 = 1.0;

/// Smallest clearance at the start and at the ends of phases, with linkages at their initial
/// positions; negative if a length is impossible.
fn smallest_gap(scene: &Scene) -> f64 {
    let set = scene.articulation();
    let state = scene.initial_state();
    let Ok(spans) = spans(scene.gait(), set.initial_shape()) else {
        return -1.0;
    };
    let ends = spans.map(|span| span.to);
    std::iter::once(set.initial_shape().to_vec())
        .chain(ends)
        .map(|lengths| {
            set.place(&state, &lengths).map_or(-1.0, |poses| {
                closest_contact(scene.bodies(), scene.domain(), &poses)
                    .map_or(f64::INFINITY, |contact| contact.gap)
            })
        })
        .fold(f64::INFINITY, f64::min)
}

/// Random scene with its text, solved by finite elements with probability `elements`.
///
/// Invalid scenes, such as spheres that touch during the stroke, are replaced by new ones.
pub fn draw(random: &mut Random, elements: f64) -> (String, Scene) {
    loop {
        let text = text(random, elements);
        if let Ok(scene) = Scene::parse(&text)
            && smallest_gap(&scene) > LEAST_GAP
        {
            return (text, scene);
        }
    }
}

fn text(random: &mut Random, elements: f64) -> String {
    let by_elements = random.chance(elements);
    let domain = match by_elements {
        true => "ball",
        false => random.pick(&["unbounded", "unbounded", "ball", "wall"]),
    };
    let bodies = 1 + random.below(if by_elements { 2 } else { 4 });
    let junction = bodies > 2 && random.chance(0.2);
    let mut places = vec![[0.0; 3]];
    let mut joints = Vec::new();
    for body in 1..bodies {
        let to = if junction { 0 } else { random.below(body) };
        let (e, length) = (random.direction(), random.within(3.0, 7.0));
        places.push(std::array::from_fn(|axis| {
            places[to][axis] + length * e[axis]
        }));
        // A body without joints is a separate swimmer.
        if junction || random.chance(0.85) {
            joints.push((body, to, length));
        }
    }
    let mut fixed = None;
    if !junction && random.chance(0.15) {
        fixed = Some(places.len());
        let e = random.direction();
        places.push(e.map(|x| 6.0 * x));
    }
    let farthest = places
        .iter()
        .map(|x| x.iter().map(|c| c * c).sum::<f64>().sqrt())
        .fold(0.0, f64::max);
    if domain == "wall" {
        let low = places.iter().map(|x| x[2]).fold(0.0, f64::min);
        // Closer to the wall, a solve for four spheres takes half a second.
        let height = random.within(3.5, 9.0) - low;
        places.iter_mut().for_each(|x| x[2] += height);
    }
    let kind = match (by_elements, domain) {
        (true, _) => "fem",
        (false, "ball") => random.pick(&["rpy", "multipole", "auto"]),
        (false, _) => random.pick(&["oseen", "rpy", "multipole", "auto"]),
    };
    let digits = random.within(2.0, if by_elements { 2.0 } else { 4.0 });
    let mut text = format!(
        "domain.kind = \"{domain}\"\nmodel = {{ kind = \"{kind}\", tolerance = {:e} }}\n",
        10.0_f64.powf(-digits)
    );
    let mut line = |content: std::fmt::Arguments| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{content}");
    };
    if domain == "ball" {
        line(format_args!(
            "domain.radius = {}",
            2.0 * farthest + random.within(5.0, 15.0)
        ));
    }
    let viscosity = 10.0_f64.powf(random.within(-3.0, 3.0));
    line(format_args!("fluid.viscosity = {viscosity:?}"));
    line(format_args!(
        "gait.arms = \"{}\"",
        random.pick(&["clamped", "clamped", "free", "lab"])
    ));
    let most = if by_elements { 1 } else { 3 };
    line(format_args!("gait.cycles = {}", 1 + random.below(most)));
    let mut smallest = f64::INFINITY;
    for (body, x) in places.iter().enumerate() {
        line(format_args!("[[bodies]]\nname = \"b{body}\""));
        line(format_args!(
            "position = [{:?}, {:?}, {:?}]",
            x[0], x[1], x[2]
        ));
        if junction && body == 0 {
            line(format_args!("shape = \"point\""));
            continue;
        }
        let radius = random.within(0.5, 1.2);
        smallest = smallest.min(radius);
        line(format_args!("radius = {radius:?}"));
        if fixed == Some(body) {
            line(format_args!("fixed = true"));
        } else if random.chance(0.2) {
            // About a twentieth of a radius per unit of time, so that few bodies hit each other or
            // a wall.
            let f = random.direction().map(|x| viscosity * x);
            line(format_args!("force = [{:?}, {:?}, {:?}]", f[0], f[1], f[2]));
        }
    }
    for (number, (body, to, _)) in joints.iter().enumerate() {
        line(format_args!(
            "[[links]]\nname = \"l{number}\"\nbody = \"b{body}\"\nto = \"b{to}\""
        ));
    }
    if !joints.is_empty() {
        let mut lengths: Vec<f64> = joints.iter().map(|l| l.2).collect();
        for _ in 0..1 + random.below(most + 1) {
            let joint = random.below(joints.len());
            lengths[joint] = (lengths[joint] * random.within(0.7, 1.4)).clamp(2.0, 9.0);
            line(format_args!(
                "[[gait.phases]]\nlink = \"l{joint}\"\nlength = {:?}",
                lengths[joint]
            ));
        }
    } else if random.chance(0.5) {
        // Only loads move the bodies.
        line(format_args!("[[gait.phases]]\nduration = 0.5"));
    }
    if by_elements {
        line(format_args!(
            "[fem]\nsurface_size = {:?}\nformulation = \"{}\"",
            SURFACE_SIZE * smallest,
            random.pick(&["p-tilde", "lagrange", "direct-row"])
        ));
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
            assert_eq!(draw(&mut a, 0.5).0, draw(&mut b, 0.5).0);
        }
        assert_ne!(draw(&mut Random(7), 0.5).0, draw(&mut Random(8), 0.5).0);
    }
}
