//! Random arrangements of spheres, with their container, joints, rates and loads.

use nalgebra::Vector3;

use crate::random::Random;
use crate::scenes::SceneText;

/// Radii that are drawn.
const RADII: [f64; 2] = [0.2, 2.0];

/// Smallest gap that is drawn, in radii of the smaller neighbour.
const GAPS: [f64; 2] = [0.02, 3.0];

/// Largest gap along a chain of spheres, in radii of the smaller neighbour.
const WIDEST_GAP: f64 = 6.0;

/// Number of chains that are drawn before another smallest gap is.
const MAX_CHAINS: usize = 1000;

/// Radius of the container over the distance of the farthest point of a sphere from its centre.
const CONTAINERS: [f64; 2] = [3.0, 10.0];

/// An instantaneous problem that was drawn.
pub struct Arrangement {
    /// Seed from which it is drawn again.
    pub seed: u64,
    pub radii: Vec<f64>,
    pub centres: Vec<Vector3<f64>>,
    /// Smallest gap between two spheres, in radii of the smaller one.
    pub gap: f64,
    /// Whether the spheres are on the x axis and all loads along it.
    pub is_axisymmetric: bool,
    /// Radius of the container about the origin; `None` for unbounded fluid.
    pub container: Option<f64>,
    /// Whether facets on surfaces are straight.
    pub straight: bool,
    /// Rate of each joint of the chain; empty for free spheres.
    pub rates: Vec<f64>,
    /// Force and torque on each sphere; empty for a chain.
    pub loads: Vec<[Vector3<f64>; 2]>,
    /// Slip of each sphere: the modes `b1` and `b2`, and the axis; empty for rigid surfaces.
    pub slips: Vec<([f64; 2], Vector3<f64>)>,
}

impl Arrangement {
    /// The arrangement of a seed: half are on a line, half chains, half in a container, a quarter
    /// with straight facets.
    pub fn draw(seed: u64) -> Self {
        let random = &mut Random(seed);
        let count = 2 + random.below(4);
        let radii: Vec<f64> = (0..count).map(|_| random.log_within(RADII)).collect();
        let on_axis = random.chance(0.5);
        let (gap, centres) = loop {
            let gap = random.log_within(GAPS);
            // In space, spheres of a chain may come closer to each other than neighbours do, and
            // between some radii no chain has a wide gap everywhere.
            let mut chains = (0..MAX_CHAINS).map(|_| chain(random, &radii, gap, on_axis));
            let has_gap =
                |x: &Vec<Vector3<f64>>| (smallest_gap(&radii, x) - gap).abs() <= 1e-9 * gap;
            if let Some(centres) = chains.find(has_gap) {
                break (gap, centres);
            }
        };
        let farthest = |centre: &Vector3<f64>, radius: &f64| centre.norm() + radius;
        let extent = centres.iter().zip(&radii);
        let extent = extent.map(|(c, r)| farthest(c, r)).fold(0.0, f64::max);
        let container = random
            .chance(0.5)
            .then(|| extent * random.within(CONTAINERS[0], CONTAINERS[1]));
        let (mut rates, mut loads) = (Vec::new(), Vec::new());
        if random.chance(0.5) {
            rates.extend((1..count).map(|_| random.within(-1.0, 1.0)));
        } else {
            // Half of the free spheres on a line have loads along it, so that the flow has
            // rotational symmetry; the others have loads in any direction.
            let along_axis = on_axis && random.chance(0.5);
            loads.extend(radii.iter().map(|radius| {
                let mut load = |size: f64| match along_axis {
                    true => Vector3::x() * random.within(-size, size),
                    false => Vector3::from(random.direction()) * random.within(0.0, size),
                };
                // A torque of the size of the force times the radius.
                [load(1.0), load(*radius)]
            }));
        }
        let straight = random.chance(0.25);
        let has_axis = |loads: &[[Vector3<f64>; 2]]| {
            let mut loads = loads.iter().flatten();
            on_axis && loads.all(|load| load.y == 0.0 && load.z == 0.0)
        };
        Self {
            seed,
            is_axisymmetric: has_axis(&loads),
            radii,
            centres,
            gap,
            container,
            straight,
            rates,
            loads,
            slips: Vec::new(),
        }
    }

    /// Gives each sphere slip: along the axis of an axisymmetric flow; half of the others on a line
    /// have axes in one symmetry plane, all others in any direction.
    pub fn draw_slips(&mut self) {
        // Other numbers than those that the arrangement was drawn from.
        let random = &mut Random(!self.seed);
        let on_axis = self.centres.iter().all(|x| x.y == 0.0 && x.z == 0.0);
        let in_plane = on_axis && random.chance(0.5);
        self.slips = (self.radii.iter())
            .map(|_| {
                let modes = [random.within(-1.0, 1.0), random.within(-2.0, 2.0)];
                let mut axis = Vector3::from(random.direction());
                if self.is_axisymmetric {
                    axis = Vector3::x();
                } else if in_plane {
                    axis.z = 0.0;
                }
                (modes, axis)
            })
            .collect();
    }

    /// The scene with the given model.
    pub fn text(&self, model: &str, tolerance: f64) -> SceneText {
        let model = format!("model = {{ kind = \"{model}\", tolerance = {tolerance:e} }}");
        let mut text = SceneText::new(model);
        if let Some(radius) = self.container {
            text = text.line(format!(
                "domain = {{ kind = \"ball\", radius = {radius:?} }}"
            ));
        }
        if self.straight {
            text = text.line("fem.geometry = \"straight\"");
        }
        for (body, (radius, centre)) in self.radii.iter().zip(&self.centres).enumerate() {
            text = text.sphere(format!("s{body}"), *radius, (*centre).into());
            if let Some([force, torque]) = self.loads.get(body) {
                text = text.key("force", force.as_slice());
                text = text.key("torque", torque.as_slice());
            }
            if let Some(([b1, b2], axis)) = self.slips.get(body) {
                let axis = axis.as_slice();
                let slip = format!("slip = {{ b1 = {b1:?}, b2 = {b2:?}, axis = {axis:?} }}");
                text = text.line(slip);
            }
        }
        (0..self.rates.len()).fold(text, |text, k| {
            text.joint(format!("l{k}"), format!("s{}", k + 1), format!("s{k}"))
        })
    }

    /// What was drawn, in a few words.
    pub fn description(&self) -> String {
        let radii: Vec<String> = self.radii.iter().map(|r| format!("{r:.3}")).collect();
        let centres: Vec<String> = self
            .centres
            .iter()
            .map(|c| format!("{:.3} {:.3} {:.3}", c.x, c.y, c.z))
            .collect();
        let container = match self.container {
            Some(radius) => format!("ball {radius:.2}"),
            None => "unbounded".to_owned(),
        };
        format!(
            "radii {}; centres {}; {container}; {}",
            radii.join(" "),
            centres.join(" / "),
            if self.straight { "straight" } else { "curved" },
        )
    }
}

/// Spheres in a row, one pair of neighbours with the given gap, the others with wider ones, about
/// their mean.
fn chain(random: &mut Random, radii: &[f64], gap: f64, on_axis: bool) -> Vec<Vector3<f64>> {
    let narrowest = random.below(radii.len() - 1);
    let mut centres = vec![Vector3::zeros()];
    for (number, pair) in radii.windows(2).enumerate() {
        let gap = match number == narrowest {
            true => gap,
            false => random.log_within([gap, WIDEST_GAP]),
        };
        let direction = match on_axis {
            true => Vector3::x(),
            false => Vector3::from(random.direction()),
        };
        let distance = pair[0] + pair[1] + gap * pair[0].min(pair[1]);
        centres.push(centres[number] + distance * direction);
    }
    let mean = centres.iter().sum::<Vector3<f64>>() / radii.len() as f64;
    centres.iter().map(|centre| centre - mean).collect()
}

/// Smallest gap between two spheres, in radii of the smaller one; negative if they overlap.
fn smallest_gap(radii: &[f64], centres: &[Vector3<f64>]) -> f64 {
    let mut smallest = f64::INFINITY;
    for (a, radius) in radii.iter().enumerate() {
        for (b, other) in radii.iter().enumerate().skip(a + 1) {
            let gap = (centres[a] - centres[b]).norm() - radius - other;
            smallest = smallest.min(gap / radius.min(*other));
        }
    }
    smallest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_give_valid_scenes_with_the_gaps_that_were_drawn() {
        // No chain of the radii of seed 287 has the gap that was drawn first.
        for seed in (0..50).chain([287]) {
            let drawn = Arrangement::draw(seed);
            assert!(drawn.gap >= GAPS[0] && drawn.gap <= GAPS[1]);
            let gap = smallest_gap(&drawn.radii, &drawn.centres);
            assert!((gap - drawn.gap).abs() < 1e-8 * gap);
            let text = drawn.text("fem", 1e-3);
            assert_eq!(text.0, Arrangement::draw(seed).text("fem", 1e-3).0);
            let scene = text.parse().unwrap();
            assert_eq!(scene.articulation().joints().len(), drawn.rates.len());
            let mut swimming = drawn;
            swimming.draw_slips();
            for drawn in [Arrangement::draw(seed), swimming] {
                let scene = drawn.text("fem", 1e-3).parse().unwrap();
                assert_eq!(scene.has_surface_velocity(), !drawn.slips.is_empty());
                if drawn.is_axisymmetric {
                    drawn.text("axisymmetric", 1e-4).parse().unwrap();
                }
            }
        }
    }
}
