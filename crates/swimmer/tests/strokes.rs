//! Strokes of swimmers on the mesh-free double: exact numbers and exact properties.

mod support;

use approx::assert_abs_diff_eq;
use support::{Tensor, run, scene, three_spheres};
use swimmer::Method;

const FREE: &str = r#"{ kind = "unbounded" }"#;

/// Steps of the centre sphere from the reference table of exact answers (three spheres of radius 1, arms 10 to 6).
const RPY: [f64; 4] = [-1.3529873030998665, 1.435496826965346, 1.435496826965347, -1.3529873030998667];
const OSEEN: [f64; 4] = [-1.353092738366866, 1.4391384581513114, 1.4391384581513114, -1.3530927383668663];

#[test]
fn the_three_sphere_stroke_has_the_steps_of_the_reference() {
    for (tensor, steps) in [(Tensor::Rpy, RPY), (Tensor::Oseen, OSEEN)] {
        let run = run(&scene(&three_spheres("model.tolerance = 1e-9", FREE)), tensor, Method::Collocation).unwrap();
        for (leg, step) in run.moves.iter().zip(steps) {
            assert_abs_diff_eq!(leg[1].x, step, epsilon = 1e-10);
        }
    }
}

#[test]
#[ignore]
fn survey() {
    for (name, domain, z) in [("free", FREE, 0.0), ("wall 20", r#"{ kind = "wall" }"#, 20.0), ("wall 5", r#"{ kind = "wall" }"#, 5.0), ("wall 2", r#"{ kind = "wall" }"#, 2.0)] {
        let text = |tol: &str| three_spheres(&format!("model.tolerance = {tol}"), domain).replace(", 0, 0]", &format!(", 0, {z:?}]"));
        let exact = run(&scene(&text("1e-11")), Tensor::Rpy, Method::Collocation).unwrap();
        println!("{name}: exact net {:?} in {} solves, err {:e}", exact.net(1), exact.solves(), exact.integration_error());
        for tol in ["1e-1", "1e-2", "4e-3", "1e-3", "1e-4", "1e-5", "1e-6"] {
            let r = run(&scene(&text(tol)), Tensor::Rpy, Method::Collocation).unwrap();
            println!("  tol {tol}: {} solves, true err/net {:.2e}, est/net {:.2e} met {:?}", r.solves(), (r.net(1) - exact.net(1)).norm() / exact.net(1).norm(), r.integration_error() / exact.net(1).norm(), r.legs.iter().map(|l| (l.tolerance_met, l.solves)).collect::<Vec<_>>());
        }
        for steps in [1, 10, 100] {
            let r = run(&scene(&text("1e-3")), Tensor::Rpy, Method::Euler { steps }).unwrap();
            println!("  euler {}: true err/net {:.2e}", r.solves(), (r.net(1) - exact.net(1)).norm() / exact.net(1).norm());
        }
    }
}
