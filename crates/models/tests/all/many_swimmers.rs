//! Many swimmers by models of point forces: without matrices over all spheres, with sampled bars.

use models::{Hydrodynamics, InstantaneousSolution, ModelError, SphereModel, SpheresModel};
use nalgebra::{DVector, Vector3};
use scene::Scene;
use testkit::within;

use crate::scenes::{errors_and_bars, solve_at_start};

/// A swimmer of three spheres and copies of it at random places, with more keys.
fn swarm(copies: usize, size: f64, keys: &str) -> Scene {
    let text = format!(
        "{keys}\n[[bodies]]\nname = \"l\"\nradius = 1\nposition = [-6, 0, 0]\n\
         [[bodies]]\nname = \"c\"\nradius = 1\nposition = [0, 0, 0]\nforce = [0, 0, -0.5]\n\
         [[bodies]]\nname = \"r\"\nradius = 1\nposition = [6, 0, 0]\n\
         [[links]]\nname = \"a\"\nbody = \"l\"\nto = \"c\"\n\
         [[links]]\nname = \"b\"\nbody = \"r\"\nto = \"c\"\n\
         [[copies]]\nof = \"c\"\ncount = {copies}\nsize = [{size}, {size}, {size}]\n\
         isotropic = true\ngap = 1\nseed = 5\n"
    );
    Scene::parse(&text).unwrap()
}

fn solve(scene: &Scene, kind: SphereModel) -> Result<InstantaneousSolution, ModelError> {
    let rates = vec![-1.0; scene.articulation().joints().len()];
    let mut model = SpheresModel::new(scene, kind)?;
    Ok(solve_at_start(&mut model, &rates))
}

fn largest<T>(list: impl Iterator<Item = T>, of: impl Fn(T) -> Vector3<f64>) -> f64 {
    list.map(of).fold(0.0, |most, v| most.max(v.norm()))
}

/// Squirmers of several sizes and modes, some linked, some with forces.
#[test]
fn bars_of_squirmers_by_rotne_prager_and_yamakawa_contain_their_errors() {
    let body = |name: &str, radius: f64, x: [f64; 3], keys: &str| {
        format!("[[bodies]]\nname = \"{name}\"\nradius = {radius}\nposition = {x:?}\n{keys}\n")
    };
    let slip = |b1: f64, b2: f64, axis: [f64; 3]| {
        format!("slip = {{ b1 = {b1:?}, b2 = {b2:?}, axis = {axis:?} }}")
    };
    let few = [
        body("a", 1.0, [0.0; 3], &slip(1.5, 3.0, [1.0, 0.3, 0.0])),
        body(
            "b",
            0.7,
            [2.2, 1.0, 0.4],
            &slip(1.0, -2.0, [-0.2, 1.0, 0.5]),
        ),
        body("c", 1.2, [-1.0, 3.0, 2.0], "force = [0, 3, -1]"),
        body("d", 1.0, [0.5, -3.5, 1.0], &slip(0.0, 2.0, [0.0, 0.0, 1.0])),
        "[[links]]\nname = \"arm\"\nbody = \"a\"\nto = \"d\"\n".to_owned(),
    ]
    .concat();
    let many: String = (0..14)
        .map(|k| {
            let turn = f64::from(k);
            let x = [
                3.3 * f64::from(k % 3),
                3.1 * f64::from(k / 3 % 3),
                3.5 * f64::from(k / 9),
            ];
            let axis = [turn.sin(), turn.cos(), (2.0 * turn).sin()];
            body(&format!("s{k}"), 1.0, x, &slip(1.0, 2.0 - 0.5 * turn, axis))
        })
        .collect();
    for (text, rates) in [(few, vec![0.5]), (many, vec![])] {
        let scene = Scene::parse(&text).unwrap();
        let solve = |kind| solve_at_start(&mut SpheresModel::new(&scene, kind).unwrap(), &rates);
        let exact = solve(SphereModel::Multipole(1e-6));
        let found = solve(SphereModel::Rpy);
        let compared = errors_and_bars(&found, &exact);
        for (what, error, bar) in compared.into_iter().filter(|(what, ..)| *what != "torque") {
            let bar = bar.model.unwrap();
            assert!(error <= bar + 1e-9, "{what}: error {error:e}, bar {bar:e}");
            // The speed of a squirmer alone is of order one.
            let most = if what == "power" { exact.power() } else { 2.0 };
            assert!(bar < most, "{what}: bar {bar:e}");
        }
        let [(_, velocity, _), ..] = compared;
        assert!(velocity > 1e-4, "{velocity:e}");
    }
}

/// Squirmers at gaps of 0.05 and more, some linked, with forces, or held, against finer expansions
/// without a matrix, which in turn are those of the resistance matrix for few.
#[test]
fn bars_of_many_squirmers_by_expansions_contain_their_errors() {
    let text = |gap: f64, linked: bool| {
        let bodies: String = (0..27)
            .map(|k| {
                let turn = f64::from(k);
                let place = [k % 3, k / 3 % 3, k / 9].map(|x| (2.0 + gap) * f64::from(x));
                let axis = [turn.sin(), turn.cos(), (2.0 * turn).sin()];
                let keys = match k {
                    5 if linked => "force = [0, 3, -1]".to_owned(),
                    11 if linked => "fixed = true".to_owned(),
                    _ => format!(
                        "slip = {{ b1 = 1, b2 = {:?}, axis = {axis:?} }}",
                        2.0 - 0.3 * (turn % 12.0)
                    ),
                };
                format!("[[bodies]]\nname = \"s{k}\"\nradius = 1\nposition = {place:?}\n{keys}\n")
            })
            .collect();
        let link = "[[links]]\nname = \"arm\"\nbody = \"s0\"\nto = \"s1\"\n";
        bodies + if linked { link } else { "" }
    };
    for (gap, linked) in [(1.0, false), (0.05, false), (0.3, true)] {
        let scene = Scene::parse(&text(gap, linked)).unwrap();
        let rates = vec![0.5; usize::from(linked)];
        let solve = |kind| solve_at_start(&mut SpheresModel::new(&scene, kind).unwrap(), &rates);
        let exact = solve(SphereModel::Multipole(1e-6));
        for tolerance in [1e-2, 1e-3] {
            let found = solve(SphereModel::Multipole(tolerance));
            assert!(found.solver.iterations > 1, "not by the resistance matrix");
            for (what, error, bar) in errors_and_bars(&found, &exact) {
                let bar = bar.model.unwrap();
                let case = format!("{what} at {gap} and {tolerance:e}");
                within(error, bar + 1e-9, format!("the bar: {case}"));
                // The speed of a squirmer alone is of order one.
                let size = if what == "power" { exact.power() } else { 10.0 };
                within(bar, 30.0 * tolerance * size, format!("a small bar: {case}"));
            }
        }
    }
}

#[test]
fn slip_by_models_of_point_forces_is_refused_where_it_is_not_computed() {
    let body = "[[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 3]\n\
                slip = { b1 = 1, axis = [1, 0, 0] }\n";
    let refused = |keys: &str, kind: SphereModel, words: &str| {
        let scene = Scene::parse(&format!("{keys}\n{body}")).unwrap();
        let error = SpheresModel::new(&scene, kind).err().unwrap().to_string();
        assert!(error.contains(words), "{error}");
    };
    refused("", SphereModel::Oseen, "use model.kind = \"rpy\"");
    refused(
        "domain.kind = \"wall\"",
        SphereModel::Rpy,
        "\"multipole\" elsewhere",
    );
    let ball = "domain = { kind = \"ball\", radius = 9 }";
    refused(ball, SphereModel::Rpy, "\"multipole\" elsewhere");
    let flow = "background = { kind = \"uniform\", velocity = [1, 0, 0] }";
    refused(flow, SphereModel::Rpy, "background flow");
}

#[test]
fn sampled_bars_contain_the_errors_of_many_swimmers() {
    let scene = swarm(7, 24.0, "");
    assert_eq!(scene.bodies().len(), 24);
    let exact = solve(&scene, SphereModel::Multipole(1e-4)).unwrap();
    for kind in [SphereModel::Oseen, SphereModel::Rpy] {
        let found = solve(&scene, kind).unwrap();
        let compared = errors_and_bars(&found, &exact).into_iter();
        for (what, error, bar) in compared.filter(|(what, ..)| *what != "torque") {
            let what = format!("{kind:?}: {what}");
            let bar = bar.model.unwrap();
            within(error, bar, format!("the error bar: {what}"));
            // The factor of the worst neighbourhood counts for all.
            within(
                bar,
                10.0 * error,
                format!("the bar is not too large: {what}"),
            );
        }
    }
}

#[test]
fn forces_of_linked_spheres_are_those_of_the_grand_resistance() {
    let scene = swarm(7, 24.0, "");
    for kind in [SphereModel::Oseen, SphereModel::Rpy] {
        let mut model = SpheresModel::new(&scene, kind).unwrap();
        let rates = vec![-1.0; scene.articulation().joints().len()];
        let found = solve_at_start(&mut model, &rates);
        assert!(found.solver.iterations > 1 && found.solver.iterations < 30);
        assert!(found.solver.true_relative_residual < 1e-9);
        let state = scene.initial_state();
        let configuration = testkit::at(&state, scene.articulation().initial_shape());
        let resistance = model
            .resistances()
            .unwrap()
            .resistance(configuration)
            .unwrap();
        let rows = found.bodies.iter().flat_map(|body| {
            let (u, w) = (body.velocity, body.angular_velocity);
            [u.x, u.y, u.z, w.x, w.y, w.z]
        });
        let forces = resistance.matrix * DVector::from_iterator(6 * scene.bodies().len(), rows);
        let size = largest(found.bodies.iter(), |body| body.force);
        for (number, body) in found.bodies.iter().enumerate() {
            let expected = forces.fixed_rows::<3>(6 * number).into_owned();
            // The residual of the iteration, amplified by the condition of the mobility.
            within((body.force - expected).norm(), 1e-8 * size, "residual");
        }
        // Each swimmer carries the load on its middle sphere.
        for swimmer in found.bodies.chunks(3) {
            let force: Vector3<f64> = swimmer.iter().map(|body| body.force).sum();
            let load = Vector3::new(0.0, 0.0, -0.5);
            within((force - load).norm(), 1e-12 * size, "rounding");
        }
    }
}

#[test]
fn estimates_are_full_sampled_or_off() {
    let bar = |keys: &str| {
        let found = solve(&swarm(4, 24.0, keys), SphereModel::Rpy).unwrap();
        found.error_estimate.model
    };
    let [full, sampled] =
        ["full", "sampled"].map(|word| bar(&format!("model.estimates = \"{word}\"")).unwrap());
    assert_eq!(bar("model.estimates = \"off\""), None);
    assert_eq!(bar(""), Some(sampled));
    let ratio = sampled / full;
    assert!((0.7..5.0).contains(&ratio), "{ratio}");
}
