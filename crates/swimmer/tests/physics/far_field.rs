//! Finite elements in unbounded fluid, against exact values.

use std::f64::consts::PI;

use approx::assert_relative_eq;
use swimmer::models::{FemModel, Hydrodynamics, InstantaneousSolution};
use swimmer::{Scene, choose, solve_start, start_resistance};

fn spheres(places: &[f64], more: &str) -> Scene {
    let mut text = format!("domain.kind = \"unbounded\"\nmodel.kind = \"fem\"\n{more}\n");
    for (k, x) in places.iter().enumerate() {
        text += &format!(
            "[[bodies]]\nname = \"s{k}\"\nradius = 1\nposition = [{x:?}, 0, 0]\nforce = [1, 0, 0]\n"
        );
    }
    Scene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn solve(scene: &Scene) -> InstantaneousSolution {
    solve_start(scene, &mut FemModel::new(scene).unwrap()).unwrap()
}

#[test]
fn a_pulled_sphere_has_the_drag_of_stokes() {
    let scene = spheres(&[0.0], "fem.target = 5e-4");
    let instant = solve(&scene);
    let speed = instant.bodies[0].velocity.x;
    let error = 6.0 * PI * speed - 1.0;
    // The effect of the ball, 5/2 / 60^3, is below 2e-5.
    let bar = 6.0 * PI * instant.error_estimate.total();
    assert!(error.abs() < 5e-4 && error.abs() < bar, "{error:e} {bar:e}");
    assert!(instant.error_estimate.container.unwrap() < 2e-5 * speed);
    assert!(instant.dofs.total < 100_000, "{}", instant.dofs.total);
}

#[test]
fn two_spheres_fall_together_as_in_unbounded_fluid() {
    // Stimson & Jeffery 1926: force over 6 pi U at a distance of four.
    let exact = 1.0 / (6.0 * PI * 0.742_258_285_1);
    let instant = solve(&spheres(&[-2.0, 2.0], ""));
    let speed = instant.bodies[0].velocity.x;
    let bar = instant.error_estimate.total();
    assert!((speed - exact).abs() < 1.4 * bar, "{speed} {exact} {bar:e}");
    // Without the correction the effect of the ball would be 3 F / (8 pi R), a hundred times as
    // much.
    assert!(bar < 1e-2 * speed);
}

#[test]
fn the_resistance_is_that_of_unbounded_fluid() {
    let scene = spheres(&[0.0], "fem.size_factor = 1.5");
    let mut model = FemModel::new(&scene).unwrap();
    let moving = solve_start(&scene, &mut model).unwrap();
    let resistance = start_resistance(&scene, &mut model).unwrap();
    // A unit force gives the same velocity as the solve, to the accuracy of the corrections.
    let off = (1.0 / resistance[(0, 0)] - moving.bodies[0].velocity.x).abs();
    let correction = moving.mesh_error.unwrap().bodies[0].velocity.x.abs();
    assert!(off < 0.02 * correction, "{off:e} {correction:e}");
    // The far field of a torque is negligible: 8 pi, up to the discretisation error.
    assert_relative_eq!(resistance[(3, 3)], 8.0 * PI, max_relative = 2e-2);
    assert_eq!(model.name(), "fem");
}

#[test]
fn bug_a_fixed_body_was_moved_by_the_far_field_correction() {
    // Multipoles give the exact velocities and forces.
    let scene = |model: &str| {
        Scene::parse(&format!(
            "model = {{ kind = \"{model}\", tolerance = 1e-8 }}\n\
             [[bodies]]\nname = \"obstacle\"\nradius = 1\nposition = [0, 0, 0]\nfixed = true\n\
             [[bodies]]\nname = \"pulled\"\nradius = 1\nposition = [4, 0, 0]\n\
             force = [1, 0.5, 0]\n"
        ))
        .unwrap()
    };
    let solve = |scene: &Scene| {
        let mut model = choose(scene).unwrap().model;
        solve_start(scene, model.as_mut()).unwrap()
    };
    let (exact, found) = (solve(&scene("multipole")), solve(&scene("fem")));
    let speed = exact.bodies[1].velocity.norm();
    let off = (found.bodies[1].velocity - exact.bodies[1].velocity).norm();
    let bar = found.error_estimate.total();
    // Bars of single solutions are 0.7 to 1.4 of the errors.
    assert!(off < 1.4 * bar && bar < 5e-3 * speed, "{off:e} {bar:e}");
    assert!(found.bodies[0].velocity.norm() < 1e-6 * speed);
    let off = (found.bodies[0].force - exact.bodies[0].force).norm();
    assert!(off < 2e-3 * exact.bodies[0].force.norm(), "{off:e}");
}

#[test]
fn above_a_plane_wall_elements_agree_with_multipoles() {
    // One sphere with two, one or no symmetry planes beside the wall, and a pair with an obstacle;
    // gaps of 0.2 radii and more.
    for bodies in [
        "[[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 1.5]\nforce = [0, 0, 1]\n",
        "[[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 1.2]\nforce = [1, 0, 0]\n",
        "[[bodies]]\nname = \"a\"\nradius = 1\nposition = [0.3, 0.1, 3]\nforce = [1, 0, 0.5]\n\
         [[bodies]]\nname = \"b\"\nradius = 0.7\nposition = [2.3, 0.9, 2]\nfixed = true\n",
    ] {
        let solve = |model: &str| {
            let model = format!("model = {{ kind = \"{model}\", tolerance = 1e-8 }}");
            let text = format!("domain.kind = \"wall\"\n{model}\n{bodies}");
            let scene = Scene::parse(&text).unwrap();
            let mut model = choose(&scene).unwrap().model;
            solve_start(&scene, model.as_mut()).unwrap()
        };
        let (exact, found) = (solve("multipole"), solve("fem"));
        let speed = exact.bodies[0].velocity.norm();
        let off = (found.bodies[0].velocity - exact.bodies[0].velocity).norm();
        let bar = found.error_estimate.total();
        assert!(
            off < 1.4 * bar && bar < 8e-3 * speed,
            "{bodies}{off:e} {bar:e}"
        );
    }
}

#[test]
fn the_resistance_above_a_plane_wall_is_that_of_multipoles() {
    let text = "domain.kind = \"wall\"\nmodel.kind = \"fem\"\n\
                [[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 2]\n";
    let resistance = |text: &str| {
        let scene = Scene::parse(text).unwrap();
        let mut model = choose(&scene).unwrap().model;
        start_resistance(&scene, model.as_mut()).unwrap()
    };
    let found = resistance(text);
    let exact = resistance(&text.replace("fem", "multipole"));
    // The discretisation error of the default size: 3e-3 in drags, 1e-2 in torques.
    for row in 0..6 {
        assert_relative_eq!(found[(row, row)], exact[(row, row)], max_relative = 1e-2);
    }
}
