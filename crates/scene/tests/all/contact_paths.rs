//! Contact along a path, against dense sampling of the gap.

use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use rigid::{RigidError, State, StateBounds};
use scene::{BodyPath, Scene, closest_contact, first_contact};

/// Positions at which the gap is sampled.
const SAMPLES: u32 = 2_000;

/// A path `from + a t + b t² + c t³` with a rotation about z, past a body at the origin.
#[derive(Clone, Debug)]
struct Path {
    from: Vector3<f64>,
    terms: [Vector3<f64>; 3],
    turn: f64,
}

impl Path {
    fn state(&self, scene: &Scene, t: f64) -> State {
        let mut state = scene.initial_state();
        let [a, b, c] = self.terms;
        state.frames[1].translation.vector = self.from + t * (a + t * (b + t * c));
        state.frames[1].rotation = UnitQuaternion::from_scaled_axis(Vector3::z() * self.turn * t);
        state
    }

    fn bounds(&self, scene: &Scene) -> StateBounds {
        let mut bounds = StateBounds::at_rest(scene.articulation(), Vec::new());
        let [a, b, c] = self.terms.map(|term| term.norm());
        bounds.frames[1].linear.first = a + 2.0 * b + 3.0 * c;
        bounds.frames[1].linear.second = 2.0 * b + 6.0 * c;
        bounds.frames[1].angular.first = self.turn.abs();
        bounds
    }

    /// Smallest gap, and the position of the first sample that touches.
    fn sampled(&self, scene: &Scene) -> (f64, Option<f64>) {
        let (mut smallest, mut first) = (f64::INFINITY, None);
        for k in 0..=SAMPLES {
            let t = f64::from(k) / f64::from(SAMPLES);
            let poses = scene
                .articulation()
                .place(&self.state(scene, t), &[])
                .unwrap();
            let gap = closest_contact(scene.bodies(), scene.domain(), &poses)
                .unwrap()
                .gap;
            smallest = gap.min(smallest);
            if gap < 0.0 && first.is_none() {
                first = Some(t);
            }
        }
        (smallest, first)
    }
}

fn scene(moving: &str) -> Scene {
    let text = format!(
        "bodies = [{{ name = \"at rest\", radius = 1, position = [0, 0, 0] }},
                   {{ name = \"moving\", position = [5, 0, 0], {moving} }}]"
    );
    Scene::parse(&text).unwrap()
}

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

fn path() -> impl Strategy<Value = Path> {
    let terms = [vector(8.0), vector(8.0), vector(8.0)];
    (vector(1.0), terms, -6.0..6.0).prop_map(|(direction, terms, turn)| Path {
        from: 3.5 * direction.try_normalize(1e-3).unwrap_or_else(Vector3::x),
        terms,
        turn,
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn contact_is_found_if_and_only_if_bodies_touch(path in path(), is_sphere: bool) {
        let scene = scene(match is_sphere {
            true => "radius = 0.1",
            false => "shape = \"spheroid\", radius = 0.05, half_length = 0.5",
        });
        let at = |t: f64| -> Result<_, RigidError> { Ok((path.state(&scene, t), Vec::new())) };
        let found = first_contact(&BodyPath {
            bodies: scene.bodies(),
            set: scene.articulation(),
            domain: Some(scene.domain()),
            at: &at,
            bounds: &path.bounds(&scene),
        }).unwrap();
        let (smallest, first) = path.sampled(&scene);
        // Between samples the gap is smaller by at most half a step times the speed: 48 √3 of the
        // centre and 3 of the surface.
        if smallest > 0.5 / f64::from(SAMPLES) * 87.0 {
            prop_assert!(found.is_none(), "{found:?} at a gap of {smallest:e}");
        }
        if let Some(first) = first {
            let found = found.expect("they touch");
            prop_assert!(found.is_certain);
            // Places are found to 1/1024 of the path.
            prop_assert!(found.at <= first + 1.0 / 1024.0, "{found:?} {first}");
        }
    }
}
