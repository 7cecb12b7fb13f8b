//! Contact along a path, against dense sampling of the gap.

use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use rigid::{RigidError, State, StateBounds};
use scene::{BodyPath, PathContact, Scene, closest_contact, first_contact};

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

/// The first contact of all bodies of a scene along a path.
fn first_along(
    scene: &Scene,
    at: &dyn Fn(f64) -> Result<(State, Vec<f64>), RigidError>,
    bounds: &StateBounds,
) -> Option<PathContact> {
    let path = BodyPath {
        bodies: scene.bodies(),
        set: scene.articulation(),
        domain: scene.domain(),
        at,
        bounds,
    };
    first_contact(&path).unwrap()
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
        let found = first_along(&scene, &at, &path.bounds(&scene));
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

/// Spheres on straight ways, against the times at which the distances are two radii.
#[test]
fn of_many_spheres_the_first_pair_that_meets_is_found() {
    let mut state = 5_u64;
    let mut random = || {
        state = (state.wrapping_mul(6_364_136_223_846_793_005)).wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    for size in [0.5, 2.0, 6.0] {
        let places: Vec<Vector3<f64>> = (0..27)
            .map(|k| Vector3::new(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9)) * 2.0)
            .map(|place| place + Vector3::from_fn(|_, _| 0.3 * random()))
            .collect();
        let speeds: Vec<Vector3<f64>> = (places.iter())
            .map(|_| Vector3::from_fn(|_, _| size * random()))
            .collect();
        let bodies = places.iter().enumerate().map(|(k, x)| {
            let [x, y, z] = [x.x, x.y, x.z];
            format!("{{ name = \"b{k}\", radius = 0.3, position = [{x:?}, {y:?}, {z:?}] }}")
        });
        let bodies = bodies.collect::<Vec<_>>().join(", ");
        let scene = Scene::parse(&format!("bodies = [{bodies}]")).unwrap();
        let mut bounds = StateBounds::at_rest(scene.articulation(), Vec::new());
        for (frame, speed) in bounds.frames.iter_mut().zip(&speeds) {
            frame.linear.first = speed.norm();
        }
        let at = |t: f64| -> Result<_, RigidError> {
            let mut state = scene.initial_state();
            for (frame, speed) in state.frames.iter_mut().zip(&speeds) {
                frame.translation.vector += t * speed;
            }
            Ok((state, Vec::new()))
        };
        let found = first_along(&scene, &at, &bounds);
        let meeting = |(i, j): (usize, usize)| {
            // |d + v t| = 2 a
            let (d, v) = (places[i] - places[j], speeds[i] - speeds[j]);
            let (square, product) = (v.norm_squared(), d.dot(&v));
            let rest = product * product - square * (d.norm_squared() - 0.36);
            let time = (-product - rest.max(0.0).sqrt()) / square;
            (rest >= 0.0 && (0.0..=1.0).contains(&time)).then_some((time, i, j))
        };
        let pairs = (0..27).flat_map(|j| (0..j).map(move |i| (i, j)));
        let first = pairs.filter_map(meeting).min_by(|a, b| a.0.total_cmp(&b.0));
        match (found, first) {
            (Some(found), Some((time, i, j))) => {
                assert_eq!((found.contact.body, found.contact.other), (i, Some(j)));
                // Places are found to 1/1024 of the path.
                assert!((found.at - time).abs() <= 1.0 / 1024.0, "{found:?} {time}");
            }
            (found, first) => assert!(found.is_none() && first.is_none(), "{found:?} {first:?}"),
        }
        assert_eq!(first.is_some(), size > 1.0, "{size}");
    }
}

/// An arm of twenty radii that sweeps a small sphere by most of a turn.
const ARM: &str = r#"
    bodies = [
        { name = "hub", radius = 1, position = [0, 0, 0] },
        { name = "tip", radius = 0.05, position = [20, 0, 0] },
        { name = "obstacle", radius = 0.05, position = [OBSTACLE] },
    ]
    links = [
        { name = "hinge", joint = "hinge", body = "tip", to = "hub", axis = [0, 0, 1] },
        { name = "rod", joint = "fixed", body = "obstacle", to = "hub" },
    ]
    gait.phases = [{ link = "hinge", length = 5 }]
"#;

/// The arm passes the obstacle in a hundredth of the phase: 0.2 of 100.
#[test]
fn bug_a_hinge_swept_a_small_sphere_through_another_one() {
    let at = |angle: f64, radius: f64| {
        let [x, y] = [angle.cos(), angle.sin()].map(|c| radius * c);
        Scene::parse(&ARM.replace("OBSTACLE", &format!("{x}, {y}, 0")))
    };
    for angle in [0.337, 1.9, 3.21, 4.877] {
        let message = at(angle, 20.0).expect_err("they touch").to_string();
        for part in ["'tip'", "'obstacle'", "touch", "in phase 1"] {
            assert!(message.contains(part), "{angle}: {message}");
        }
        // Radii of 0.05 beside each other, with a gap of a tenth of one.
        assert!(at(angle, 20.105).is_ok(), "{angle}");
        assert!(at(angle, 20.095).is_err(), "{angle}");
    }
}

/// Bodies that are joined to fixed ones are where the gait puts them: another fixed body, or the
/// wall, is in their way before any flow is computed.
#[test]
fn bug_the_check_let_an_arm_of_a_fixed_body_through_a_fixed_post_and_a_wall() {
    let scene = |hub: &str, post: f64, domain: &str| {
        Scene::parse(&format!(
            r#"
            {domain}
            bodies = [
                {{ name = "hub", radius = 1, position = [0, 0, 0], {hub} }},
                {{ name = "tip", radius = 0.1, position = [8, 0, 0] }},
                {{ name = "post", radius = 0.2, position = [0, {post}, 0], fixed = true }},
            ]
            links = [{{ name = "hinge", joint = "hinge", body = "tip", to = "hub",
                pivot = [0, 0, 0], axis = [0, 0, 1] }}]
            gait.phases = [{{ link = "hinge", length = 3 }}]
            "#
        ))
    };
    let fixed = "fixed = true";
    let message = scene(fixed, 8.0, "").expect_err("they touch").to_string();
    for part in ["'tip'", "'post'", "in phase 1"] {
        assert!(message.contains(part), "{message}");
    }
    // Radii of 0.1 and 0.2, with a gap of a hundredth.
    assert!(scene(fixed, 8.31, "").is_ok());
    // A hub that is free turns as well.
    assert!(scene("mass = 1", 8.0, "").is_ok());
    let wall = |width: f64| format!("domain = {{ kind = \"box\", size = [20, {width}, 20] }}");
    let message = scene(fixed, -4.0, &wall(16.0))
        .expect_err("they touch")
        .to_string();
    assert!(
        message.contains("'tip'") && message.contains("wall"),
        "{message}"
    );
    assert!(scene(fixed, -4.0, &wall(16.3)).is_ok());
}

/// The placement of the check puts the frame of a linkage at its first held body: another one that
/// is fixed is turned by the first phase, although in the run it is not. In the second phase
/// nothing turns, and the sphere that slides from the fixed one was looked for where it is not.
#[test]
fn bug_a_body_that_the_placement_had_moved_was_compared_with_fixed_ones() {
    let scene = |post: [f64; 2]| {
        Scene::parse(&format!(
            r#"
            bodies = [
                {{ name = "rotor", radius = 0.5, position = [0, 0, 0], velocity = [0, 0, 0] }},
                {{ name = "base", radius = 0.5, position = [3, 0, 0], fixed = true }},
                {{ name = "tip", radius = 0.2, position = [3, 0, 4] }},
                {{ name = "post", radius = 0.2, position = [{}, {}, 6], fixed = true }},
            ]
            links = [
                {{ name = "hinge", joint = "hinge", body = "base", to = "rotor",
                    pivot = [0, 0, 0], axis = [0, 0, 1] }},
                {{ name = "slide", body = "tip", to = "base" }},
            ]
            gait.phases = [
                {{ link = "hinge", length = 1.5707963267948966 }},
                {{ link = "slide", length = 8 }},
                {{ link = "slide", length = 4 }},
                {{ link = "hinge", length = 0 }},
            ]
            "#,
            post[0], post[1]
        ))
    };
    let placed = scene([0.0, 3.0]);
    assert!(placed.is_ok(), "{placed:?}");
}

/// The positions that flow determines are not known, those that the gait prescribes are.
#[test]
fn bug_a_passive_joint_made_the_check_skip_what_the_gait_prescribes() {
    let with_tail = |obstacle: &str, length: f64| {
        let text = ARM.replace("OBSTACLE", obstacle);
        let text = text.replace(
            "links = [",
            "links = [{ name = \"tail\", body = \"end\", to = \"hub\", drive = \"spring\", \
             stiffness = 1 },",
        );
        let end =
            format!("bodies = [{{ name = \"end\", radius = 1, position = [0, 0, {length}] }},");
        Scene::parse(&text.replace("bodies = [", &end))
    };
    let message = with_tail("0, 20, 0", -10.0)
        .expect_err("they touch")
        .to_string();
    assert!(
        message.contains("'tip'") && message.contains("'obstacle'"),
        "{message}"
    );
    assert!(with_tail("0, 30, 0", -10.0).is_ok());
}

#[test]
fn walls_are_found_along_a_path() {
    // A parabola whose ends are far from the wall, for each kind of wall, towards `down`.
    for (domain, down, distance) in [
        ("{ kind = \"ball\", radius = 8 }", Vector3::x(), 8.0),
        ("{ kind = \"box\", size = [20, 20, 12] }", Vector3::z(), 6.0),
        ("{ kind = \"cylinder\", radius = 5 }", Vector3::y(), 5.0),
    ] {
        let text = format!(
            "domain = {domain}\n\
             bodies = [{{ name = \"a\", radius = 0.01, position = [0, 0, 0] }}]"
        );
        let scene = Scene::parse(&text).unwrap();
        for (gap, touches) in [(1e-4, false), (-1e-4, true)] {
            let deepest = distance - 0.01 - gap;
            let at = |t: f64| -> Result<_, RigidError> {
                let mut state = scene.initial_state();
                state.frames[0].translation.vector = down * (4.0 * deepest * t * (1.0 - t));
                Ok((state, Vec::new()))
            };
            let mut bounds = StateBounds::at_rest(scene.articulation(), Vec::new());
            bounds.frames[0].linear.first = 4.0 * deepest;
            bounds.frames[0].linear.second = 8.0 * deepest;
            let found = first_along(&scene, &at, &bounds);
            assert_eq!(found.is_some(), touches, "{domain} {gap}: {found:?}");
            if let Some(found) = found {
                assert!(found.is_certain && found.contact.other.is_none());
                // The gap closes where `4 t (1 - t) deepest = deepest - 1e-4`.
                let first = 0.5 * (1.0 - (1e-4 / deepest).sqrt());
                assert!((found.at - first).abs() < 1.0 / 512.0, "{found:?} {first}");
            }
        }
    }
}

/// A unit sphere at rest and one that starts at `from`, in a periodic box.
fn periodic(from: &Vector3<f64>) -> Scene {
    let [x, y, z] = [from.x, from.y, from.z];
    let text = format!(
        "domain = {{ kind = \"periodic\", size = [10, 8, 9] }}\n\
         bodies = [{{ name = \"at rest\", radius = 1, position = [0, 0, 0] }},
         {{ name = \"moving\", radius = 1, position = [{x}, {y}, {z}] }}]"
    );
    Scene::parse(&text).unwrap()
}

proptest! {
    #[test]
    fn images_in_a_periodic_box_are_met_where_dense_sampling_finds_them(
        from in prop::array::uniform3(2.2..5.0_f64),
        terms in prop::array::uniform3(prop::array::uniform3(-12.0..12.0_f64)),
    ) {
        let path = Path { from: from.into(), terms: terms.map(Vector3::from), turn: 0.0 };
        let scene = periodic(&path.from);
        let at = |t: f64| -> Result<_, RigidError> { Ok((path.state(&scene, t), Vec::new())) };
        let bounds = path.bounds(&scene);
        let domain = scene.domain();
        let set = scene.articulation();
        let found = first_contact(&BodyPath { bodies: scene.bodies(), set, domain, at: &at, bounds: &bounds })
            .unwrap();
        let (smallest, first) = path.sampled(&scene);
        match (found, first) {
            (Some(found), Some(first)) if found.is_certain => {
                // Two samples and the resolution of the search.
                prop_assert!(found.at <= first + 2e-3, "{} {first}", found.at);
            }
            (Some(found), None) if found.is_certain => {
                // Between two samples the gap changes by their distance times the speed.
                prop_assert!(smallest < 60.0 / f64::from(SAMPLES), "{smallest}");
            }
            (None, first) => prop_assert!(first.is_none(), "{first:?} {smallest}"),
            _ => {}
        }
    }
}

#[test]
fn an_arm_through_a_face_of_the_box_meets_the_image_of_its_own_swimmer() {
    let text = "domain = { kind = \"periodic\", size = [10, 8, 9] }\n\
        bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0] },
        { name = \"b\", radius = 1, position = [5, 0, 0] }]\n\
        links = [{ name = \"arm\", body = \"b\", to = \"a\" }]";
    let scene = Scene::parse(text).unwrap();
    let set = scene.articulation();
    // From 5 to 9: at 8 the body meets the image at 10.
    let at = |t: f64| -> Result<_, RigidError> { Ok((scene.initial_state(), vec![5.0 + 4.0 * t])) };
    let rates = rigid::ValueBounds {
        size: 9.0,
        derivatives: rigid::DerivativeBounds {
            first: 4.0,
            second: 0.0,
        },
    };
    let bounds = StateBounds::at_rest(set, vec![rates]);
    let domain = scene.domain();
    let path = BodyPath {
        bodies: scene.bodies(),
        set,
        domain,
        at: &at,
        bounds: &bounds,
    };
    let found = first_contact(&path).unwrap().unwrap();
    assert!(
        found.is_certain && (found.at - 0.75).abs() < 2e-3,
        "{}",
        found.at
    );
    assert_eq!(
        first_contact(&BodyPath {
            domain: &scene::Domain::Unbounded,
            ..path
        })
        .unwrap(),
        None
    );
}

/// A wave that turns once touches a ball beside it when its hump passes, though the shapes at both
/// ends of the path are the same and far from it.
#[test]
fn the_hump_of_a_wave_meets_a_ball_beside_the_tube() {
    let text = "bodies = [{ name = \"ball\", radius = 0.5, position = [0, 1.9, 0] },
        { name = \"worm\", shape = \"tube\", length = 10, radius = 0.3, position = [0, 0, 0],
        deformation = { kind = \"undulation\", wave = \"displacement\", waves = 0.5,
        amplitude = 0.35, phase = 4.71238898038469 } }]";
    let scene = Scene::parse(text).unwrap();
    let set = scene.articulation();
    let turn = std::f64::consts::TAU;
    // The middle of the wave is at (a / k) cos φ, with k = 2 π 0.5 / 10: the phase starts at 3/4 of
    // a turn, where it is zero, and half a turn later it is so again.
    let values = |t: f64| vec![0.35, turn * (0.75 + 0.5 * t)];
    let gap = |t: f64| {
        let poses = set.place(&scene.initial_state(), &values(t)).unwrap();
        let bodies = scene.bodies_at(&values(t));
        closest_contact(&bodies, scene.domain(), &poses)
            .unwrap()
            .gap
    };
    assert!(gap(0.0) > 0.1 && gap(1.0) > 0.1 && gap(0.5) < -0.01);
    let bound = |size: f64, first: f64| rigid::ValueBounds {
        size,
        derivatives: rigid::DerivativeBounds { first, second: 0.0 },
    };
    let bounds = StateBounds::at_rest(set, vec![bound(0.35, 0.0), bound(2.0 * turn, 0.5 * turn)]);
    let at = |t: f64| -> Result<_, RigidError> { Ok((scene.initial_state(), values(t))) };
    let path = BodyPath {
        bodies: scene.bodies(),
        set,
        domain: scene.domain(),
        at: &at,
        bounds: &bounds,
    };
    let found = first_contact(&path).unwrap().unwrap();
    let first = (0..=SAMPLES).find(|k| gap(f64::from(*k) / f64::from(SAMPLES)) < 0.0);
    let first = f64::from(first.unwrap()) / f64::from(SAMPLES);
    assert!((found.at - first).abs() < 5e-3, "{} {first}", found.at);
}
