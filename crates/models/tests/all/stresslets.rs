//! Stresslets: all models that compute them, against exact values and each other.

use std::f64::consts::PI;

use models::{InstantaneousSolution, SphereModel, SpheresModel};
use nalgebra::{Matrix3, Vector3};
use testkit::{SceneText, within};

use crate::scenes::{elements, meridian, multipole, with_stresslets};

fn only(solution: &InstantaneousSolution) -> Matrix3<f64> {
    solution.stresslets.as_ref().unwrap().bodies[0]
}

/// Functions `X^M`, `Y^M`, `Z^M` of a prolate spheroid (Kim & Karrila 1991, table 3.4): with the
/// larger semi-axis `a` along the axis `S = 20π/3 μ a^3 (X^M E_0 + Y^M E_1 + Z^M E_2)` if it does
/// not rotate, for the parts of the strain along, out of and across the axis.
fn of_prolate_spheroid(ratio: f64) -> [f64; 3] {
    let e = (1.0 - ratio.powi(-2)).sqrt();
    let (s, l) = (e * e, ((1.0 + e) / (1.0 - e)).ln());
    let fifth = e.powi(5);
    let of_y = 2.0 * e * (1.0 - 2.0 * s) - (1.0 - s) * l;
    let below_y = (2.0 * e * (2.0 * s - 3.0) + 3.0 * (1.0 - s) * l) * (-2.0 * e + (1.0 + s) * l);
    let below_z = 3.0 * (1.0 - s).powi(2) * l - 2.0 * e * (3.0 - 5.0 * s);
    [
        8.0 / 15.0 * fifth / ((3.0 - s) * l - 6.0 * e),
        0.8 * fifth * of_y / below_y,
        3.2 * fifth * (1.0 - s) / below_z,
    ]
}

const EXTENSION: &str =
    "{ kind = \"extension\", gradient = [[-0.5, 0, 0], [0, -0.5, 0], [0, 0, 1]] }";

/// `4π/3 μ a^2 B2 (3 e e^T - I)` (Ishikawa et al. 2006) and `20π/3 μ a^3 E` (Einstein 1906).
fn exact_of_spheres() -> [(SceneText, Matrix3<f64>); 2] {
    let shape = Matrix3::from_diagonal(&Vector3::new(-0.5, -0.5, 1.0));
    let sphere = SceneText::new()
        .sphere("s", 2.0, [0, 0, 1])
        .with("fluid.viscosity", 3);
    let squirmer = "{ b1 = 0.3, b2 = -0.7, axis = [0, 0, 1] }";
    let squirmer = sphere.clone().with("bodies.s.slip", squirmer);
    [
        (squirmer, shape * (8.0 * PI / 3.0 * 3.0 * 4.0 * -0.7)),
        (
            sphere.with("background", EXTENSION),
            shape * (20.0 * PI / 3.0 * 3.0 * 8.0),
        ),
    ]
}

#[test]
fn spheres_have_the_exact_stresslet_by_expansions_and_in_the_meridian_plane() {
    for (text, exact) in exact_of_spheres() {
        let error = (only(&multipole(&text)) - exact).norm();
        within(
            error,
            1e-11 * exact.norm(),
            "one sphere needs three multipoles",
        );
        let solution = meridian(&text);
        let stresslets = solution.stresslets.as_ref().unwrap();
        let (error, bar) = ((only(&solution) - exact).norm(), stresslets.error.unwrap());
        within(error, bar, "the error bar");
        within(
            bar,
            1.1e-7 * exact.norm(),
            "a hundred times the accuracy of 1e-9",
        );
    }
}

#[test]
#[ignore = "slow: 20 s"]
fn spheres_have_the_exact_stresslet_by_elements() {
    for (text, exact) in exact_of_spheres() {
        let solution = elements(&text);
        let stresslets = solution.stresslets.as_ref().unwrap();
        let error = (only(&solution) - exact).norm();
        within(error, 1e-3 * exact.norm(), "the default accuracy");
        within(error, stresslets.error.unwrap(), "the error bar");
        let before = (stresslets.uncorrected[0] - exact).norm();
        assert!(before > 10.0 * error, "{before:e}");
        within(before, 0.03 * exact.norm(), "before the correction");
    }
}

/// A spheroid in the meridian plane, and one by elements in a strain of all three kinds.
#[test]
fn spheroids_along_a_strain_have_the_stresslet_of_kim_and_karrila() {
    let keys = "shape = \"spheroid\", radius = 0.5, half_length = 1, axis = [0, 0, 1]";
    let text = SceneText::new()
        .shape("s", keys, [0; 3])
        .with("background", EXTENSION);
    let text = text.with("fluid.viscosity", 3);
    let exact = 20.0 * PI / 3.0 * 3.0 * of_prolate_spheroid(2.0)[0];
    let solution = meridian(&text);
    let bar = solution.stresslets.as_ref().unwrap().error.unwrap();
    let error = (only(&solution)[(2, 2)] - exact).abs();
    // The bar is that of the norm, which is sqrt(3/2) times this component.
    within(error, bar, "the error bar");
    within(bar, 1.4e-7 * exact, "a hundred times the accuracy of 1e-9");
}

#[test]
#[ignore = "slow: 20 s"]
fn a_spheroid_that_is_held_in_a_strain_has_the_stresslet_of_kim_and_karrila() {
    let keys = "shape = \"spheroid\", radius = 1, half_length = 2, axis = [0, 0, 1], fixed = true";
    let strain =
        "{ kind = \"extension\", gradient = [[0.2, 0.3, 0.7], [0.3, -1.2, 0], [0.7, 0, 1]] }";
    let text = SceneText::new()
        .shape("s", keys, [0; 3])
        .with("background", strain);
    let [x, y, z] = of_prolate_spheroid(2.0);
    let along = Matrix3::from_diagonal(&Vector3::new(-0.5, -0.5, 1.0));
    let out = Matrix3::new(0.0, 0.0, 0.7, 0.0, 0.0, 0.0, 0.7, 0.0, 0.0);
    let across = Matrix3::new(0.7, 0.3, 0.0, 0.3, -0.7, 0.0, 0.0, 0.0, 0.0);
    let exact = (along * x + out * y + across * z) * (20.0 * PI / 3.0 * 8.0);
    let error = (only(&elements(&text)) - exact).norm();
    within(error, 1e-3 * exact.norm(), "the default accuracy");
}

/// Two spheres that are pulled along their line in a ball: expansions, the meridian plane, and
/// elements on a quarter of the fluid.
#[test]
fn models_agree_on_the_stresslets_of_spheres_in_a_ball() {
    let text = SceneText::new()
        .shape("a", "radius = 1, force = [5, 0, 0]", [-1.6, 0.0, 0.0])
        .shape("b", "radius = 0.8, force = [-2, 0, 0]", [1.5, 0.0, 0.0])
        .ball(6.0)
        .with("fem.size_factor", 1.75);
    let all = [multipole(&text), meridian(&text), elements(&text)].map(|s| s.stresslets.unwrap());
    let size = all[0].largest();
    for body in 0..2 {
        let [spheres, plane, space] = [0, 1, 2].map(|model: usize| all[model].bodies[body]);
        within(
            (plane - spheres).norm(),
            1e-6 * size,
            "the accuracy of 1e-9, of stresses",
        );
        let error = (space - spheres).norm();
        within(error, all[2].error.unwrap(), "the error bar");
        within(
            error,
            0.01 * size,
            "elements of 1.75 times the default size",
        );
        assert_eq!(space[(0, 1)], 0.0);
        within(
            space[(1, 2)],
            1e-12 * size,
            "symmetry planes leave nothing off the diagonal",
        );
    }
}

/// Flat facets cut off a part of the spheres, which changes stresslets by the relative size of the
/// volume; slip and a strain of the fluid, in a ball that moves with it.
#[test]
fn stresslets_with_flat_facets_are_corrected_for_the_volume_that_they_lack() {
    let shear = "{ kind = \"shear\", gradient = [[0.4, 0, 0], [0.6, -0.1, 0], [0, 0, -0.3]] }";
    let slip = "radius = 0.8, slip = { b1 = 1, b2 = -1.5, axis = [0.6, 0, 0.8] }";
    let text = SceneText::new()
        .shape("a", "radius = 1, force = [2, 0, 1]", [-1.4, 0.2, 0.0])
        .shape("b", slip, [1.3, 0.0, 0.0])
        .ball(5.0)
        .with("background", shear)
        .set(&["fem.size_factor=1.4", "fem.geometry=straight"]);
    let exact = multipole(&text).stresslets.unwrap();
    let found = elements(&text).stresslets.unwrap();
    let of = |stresslets: &[Matrix3<f64>]| {
        let errors = stresslets.iter().zip(&exact.bodies);
        errors.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    };
    let (before, after) = (of(&found.uncorrected), of(&found.bodies));
    within(after, found.error.unwrap(), "the error bar");
    // The correction is of first order in the distance of the facets.
    let why = "the next order is smaller by the length of an edge in radii, 0.4 times the factor";
    within(after, 0.4 * 1.4 * before, why);
}

#[test]
fn models_of_point_forces_have_no_stresslets() {
    let scene = SceneText::new().sphere("a", 1.0, [0; 3]).scene();
    for kind in [SphereModel::Oseen, SphereModel::Rpy] {
        let mut model = SpheresModel::new(&scene, kind).unwrap();
        assert!(with_stresslets(&mut model).stresslets.is_none());
    }
}
