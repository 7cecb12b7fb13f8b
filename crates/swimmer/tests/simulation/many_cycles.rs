//! Many cycles: all of them reuse the meshes of the first, and all have its displacement.

use swimmer::choose;
use swimmer::{Method, Outcome, Scene, simulate};

/// The three-sphere swimmer, arms closing from 10 to 6 radii, in a ball so large that the
/// displacement from its centre does not matter.
fn scene(cycles: usize, more: &str) -> Scene {
    let mut text = format!(
        "domain = {{ kind = \"ball\", radius = 400 }}\ngait.cycles = {cycles}\nmodel.kind = \"fem\"\n{more}\n"
    );
    for (name, x) in [("left", -10), ("centre", 0), ("right", 10)] {
        text += &format!("[[bodies]]\nname = \"{name}\"\nradius = 1\nposition = [{x}, 0, 0]\n");
    }
    for name in ["left", "right"] {
        text += &format!("[[links]]\nname = \"{name}-arm\"\nbody = \"{name}\"\nto = \"centre\"\n");
    }
    for (name, length) in [
        ("left", 6.0),
        ("right", 6.0),
        ("left", 10.0),
        ("right", 10.0),
    ] {
        text += &format!("[[gait.phases]]\nlink = \"{name}-arm\"\nlength = {length:?}\n");
    }
    Scene::parse(&text).unwrap()
}

fn swim(scene: &Scene) -> Outcome {
    let mut model = choose(scene).unwrap().model;
    simulate(scene, model.as_mut(), Method::Collocation, &mut ()).unwrap()
}

/// Displacement of the middle sphere in each cycle.
fn cycles(outcome: &Outcome) -> Vec<f64> {
    let spans = outcome.spans.chunks(4);
    spans
        .map(|spans| spans.iter().map(|span| span.displacement[1].x).sum())
        .collect()
}

#[test]
fn later_cycles_reuse_the_meshes_of_the_first() {
    // The plain Laplace extension degrades meshes soon, so a short stroke needs several.
    let scene = Scene::parse(
        r#"
        domain = { kind = "ball", radius = 12 }
        model = { kind = "fem", tolerance = 0.2 }
        fem = { surface_size = 1.2, mesh_motion = "laplace" }
        gait = { cycles = 2, phases = [{ link = "arm", length = 2.8 }, { link = "arm", length = 5 }] }
        bodies = [
            { name = "a", radius = 1, position = [-2.5, 0, 0] },
            { name = "b", radius = 1.2, position = [2.5, 0, 0] },
        ]
        links = [{ name = "arm", body = "b", to = "a" }]
        "#,
    )
    .unwrap();
    let outcome = swim(&scene);
    let meshes = &outcome.meshes;
    assert_eq!(meshes[0].reason, "first mesh");
    assert!(
        meshes.len() > 1 && meshes.iter().all(|mesh| mesh.phase <= 2),
        "{meshes:?}"
    );
    for (first, second) in outcome.spans[..2].iter().zip(&outcome.spans[2..]) {
        let change = (second.displacement[0] - first.displacement[0]).norm();
        // Residuals of 1e-8, for resistances that differ by a factor below 100.
        assert!(change < 1e-6 * first.displacement[0].norm(), "{change:e}");
    }
}

#[test]
#[ignore = "slow: 7 min"]
fn a_hundred_cycles_of_the_default_stroke_have_the_same_displacement() {
    let scene = scene(
        100,
        "model.tolerance = 1e-2\nfem = { surface_size = 1.2, rtol = 1e-9, estimates = \"off\" }",
    );
    let outcome = swim(&scene);
    let net = cycles(&outcome);
    let worst = net
        .iter()
        .map(|n| (n / net[0] - 1.0).abs())
        .fold(0.0, f64::max);
    println!(
        "net displacement per cycle {:.6}, total {:.4}; largest relative change {worst:.2e}; meshes {:?}",
        net[0],
        net.iter().sum::<f64>(),
        outcome.meshes
    );
    assert!(net.len() == 100 && worst < 1e-4, "{worst:e}");
}
