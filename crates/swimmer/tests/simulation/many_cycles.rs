//! Many cycles: all of them reuse the meshes of the first, and all have its displacement.

use swimmer::Outcome;
use testkit::{pair, run, three_spheres, within};

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
    let text = pair(-2.5, 2.5)
        .phases(&[("arm", 2.8), ("arm", 5.0)])
        .ball(12.0);
    let text = text.elements(1.2).tolerance(0.2);
    let text = text.set(&[
        "bodies.b.radius=1.2",
        "fem.mesh_motion=laplace",
        "gait.cycles=2",
    ]);
    let outcome = run(&text.scene());
    let meshes = &outcome.meshes;
    assert_eq!(meshes[0].reason, "first mesh");
    assert!(
        meshes.len() > 1 && meshes.iter().all(|mesh| mesh.phase <= 2),
        "{meshes:?}"
    );
    for (first, second) in outcome.spans[..2].iter().zip(&outcome.spans[2..]) {
        let change = (second.displacement[0] - first.displacement[0]).norm();
        let why = "residuals of 1e-8, for resistances that differ by a factor below 100";
        within(change, 1e-6 * first.displacement[0].norm(), why);
    }
}

#[test]
#[ignore = "slow: 7 min"]
fn a_hundred_cycles_of_the_default_stroke_have_the_same_displacement() {
    // A ball so large that the displacement from its centre does not matter.
    let text = three_spheres().ball(400.0).elements(1.2).tolerance(1e-2);
    let settings = ["gait.cycles=100", "fem.rtol=1e-9", "fem.estimates=off"];
    let outcome = run(&text.set(&settings).scene());
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
