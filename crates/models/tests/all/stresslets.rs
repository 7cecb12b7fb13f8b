//! Stresslets: all models that compute them, against exact values and each other.

use std::f64::consts::PI;

use models::{InstantaneousSolution, SphereModel, SpheresModel};
use nalgebra::{Matrix3, Vector3};
use scene::Scene;

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

const SQUIRMER: &str = "fluid.viscosity = 3\n[[bodies]]\nname = \"s\"\nradius = 2\n\
     position = [0, 0, 1]\nslip = { b1 = 0.3, b2 = -0.7, axis = [0, 0, 1] }\n";

const STRAINED: &str = "fluid.viscosity = 3\n[[bodies]]\nname = \"s\"\nradius = 2\n\
     position = [0, 0, 1]\n[background]\nkind = \"extension\"\n\
     gradient = [[-0.5, 0, 0], [0, -0.5, 0], [0, 0, 1]]\n";

/// `4π/3 μ a^2 B2 (3 e e^T - I)` (Ishikawa et al. 2006) and `20π/3 μ a^3 E` (Einstein 1906).
fn exact_of_spheres() -> [(&'static str, Matrix3<f64>); 2] {
    let shape = Matrix3::from_diagonal(&Vector3::new(-0.5, -0.5, 1.0));
    [
        (SQUIRMER, shape * (8.0 * PI / 3.0 * 3.0 * 4.0 * -0.7)),
        (STRAINED, shape * (20.0 * PI / 3.0 * 3.0 * 8.0)),
    ]
}

#[test]
fn spheres_have_the_exact_stresslet_by_expansions_and_in_the_meridian_plane() {
    for (text, exact) in exact_of_spheres() {
        let found = only(&multipole(text));
        assert!((found - exact).norm() < 1e-11 * exact.norm(), "{found}");
        let solution = meridian(text);
        let stresslets = solution.stresslets.as_ref().unwrap();
        let (error, bar) = ((only(&solution) - exact).norm(), stresslets.error.unwrap());
        assert!(
            error <= bar && bar < 1.1e-7 * exact.norm(),
            "{error:e} {bar:e}"
        );
    }
}

#[test]
#[ignore = "slow: 20 s"]
fn spheres_have_the_exact_stresslet_by_elements() {
    for (text, exact) in exact_of_spheres() {
        let solution = elements(text);
        let stresslets = solution.stresslets.as_ref().unwrap();
        let error = (only(&solution) - exact).norm();
        assert!(error < 1e-3 * exact.norm(), "{error:e}");
        assert!(error < stresslets.error.unwrap());
        let before = (stresslets.uncorrected[0] - exact).norm();
        assert!(
            before > 10.0 * error && before < 0.03 * exact.norm(),
            "{before:e}"
        );
    }
}

/// A spheroid in the meridian plane, and one by elements in a strain of all three kinds.
#[test]
fn spheroids_along_a_strain_have_the_stresslet_of_kim_and_karrila() {
    let text = "fluid.viscosity = 3\n[[bodies]]\nname = \"s\"\nshape = \"spheroid\"\nradius = 0.5\n\
         half_length = 1\naxis = [0, 0, 1]\nposition = [0, 0, 0]\n[background]\n\
         kind = \"extension\"\ngradient = [[-0.5, 0, 0], [0, -0.5, 0], [0, 0, 1]]\n";
    let exact = 20.0 * PI / 3.0 * 3.0 * of_prolate_spheroid(2.0)[0];
    let solution = meridian(text);
    let bar = solution.stresslets.as_ref().unwrap().error.unwrap();
    let error = (only(&solution)[(2, 2)] - exact).abs();
    // The bar is that of the norm, which is sqrt(3/2) times this component.
    assert!(error <= bar && bar < 1.4e-7 * exact, "{error:e} {bar:e}");
}

#[test]
#[ignore = "slow: 20 s"]
fn a_spheroid_that_is_held_in_a_strain_has_the_stresslet_of_kim_and_karrila() {
    let text = "[[bodies]]\nname = \"s\"\nshape = \"spheroid\"\nradius = 1\nhalf_length = 2\n\
         axis = [0, 0, 1]\nposition = [0, 0, 0]\nfixed = true\n[background]\nkind = \"extension\"\n\
         gradient = [[0.2, 0.3, 0.7], [0.3, -1.2, 0], [0.7, 0, 1]]\n";
    let [x, y, z] = of_prolate_spheroid(2.0);
    let along = Matrix3::from_diagonal(&Vector3::new(-0.5, -0.5, 1.0));
    let out = Matrix3::new(0.0, 0.0, 0.7, 0.0, 0.0, 0.0, 0.7, 0.0, 0.0);
    let across = Matrix3::new(0.7, 0.3, 0.0, 0.3, -0.7, 0.0, 0.0, 0.0, 0.0);
    let exact = (along * x + out * y + across * z) * (20.0 * PI / 3.0 * 8.0);
    let found = only(&elements(text));
    assert!(
        (found - exact).norm() < 1e-3 * exact.norm(),
        "{found} {exact}"
    );
}

/// Two spheres that are pulled along their line in a ball: expansions, the meridian plane, and
/// elements on a quarter of the fluid.
#[test]
fn models_agree_on_the_stresslets_of_spheres_in_a_ball() {
    let text = "domain = { kind = \"ball\", radius = 6 }\nfem = { size_factor = 1.75 }\n\
         [[bodies]]\nname = \"a\"\nradius = 1\nposition = [-1.6, 0, 0]\nforce = [5, 0, 0]\n\
         [[bodies]]\nname = \"b\"\nradius = 0.8\nposition = [1.5, 0, 0]\nforce = [-2, 0, 0]\n";
    let all = [multipole(text), meridian(text), elements(text)].map(|s| s.stresslets.unwrap());
    let size = all[0].largest();
    for body in 0..2 {
        let [spheres, plane, space] = [0, 1, 2].map(|model: usize| all[model].bodies[body]);
        assert!((plane - spheres).norm() < 1e-6 * size, "{plane} {spheres}");
        let error = (space - spheres).norm();
        assert!(
            error < all[2].error.unwrap(),
            "{error:e} {:?}",
            all[2].error
        );
        assert!(error < 0.01 * size, "{error:e} of {size:e}");
        // Off the diagonal symmetry planes leave nothing.
        assert!(space[(0, 1)] == 0.0 && space[(1, 2)].abs() < 1e-12 * size);
    }
}

/// Flat facets cut off a part of the spheres, which changes stresslets by the relative size of the
/// volume; slip and a strain of the fluid, in a ball that moves with it.
#[test]
fn stresslets_with_flat_facets_are_corrected_for_the_volume_that_they_lack() {
    let text = "domain = { kind = \"ball\", radius = 5 }\n\
         fem = { size_factor = 1.4, geometry = \"straight\" }\n\
         background = { kind = \"shear\", gradient = [[0.4, 0, 0], [0.6, -0.1, 0], [0, 0, -0.3]] }\n\
         [[bodies]]\nname = \"a\"\nradius = 1\nposition = [-1.4, 0.2, 0]\nforce = [2, 0, 1]\n\
         [[bodies]]\nname = \"b\"\nradius = 0.8\nposition = [1.3, 0, 0]\n\
         slip = { b1 = 1, b2 = -1.5, axis = [0.6, 0, 0.8] }\n";
    let exact = multipole(text).stresslets.unwrap();
    let found = elements(text).stresslets.unwrap();
    let (bar, size) = (found.error.unwrap(), exact.largest());
    let of = |stresslets: &[Matrix3<f64>]| {
        let errors = stresslets.iter().zip(&exact.bodies);
        errors.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    };
    let (before, after) = (of(&found.uncorrected), of(&found.bodies));
    // The correction is of first order in the distance of the facets. The next order is smaller by
    // the length of an edge in radii, 0.4 times the size factor.
    assert!(
        after < bar && after < 0.4 * 1.4 * before,
        "{before:e} {after:e} {bar:e} {size:e}"
    );
}

#[test]
fn models_of_point_forces_have_no_stresslets() {
    let scene =
        Scene::parse("[[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 0]\n").unwrap();
    for kind in [SphereModel::Oseen, SphereModel::Rpy] {
        let mut model = SpheresModel::new(&scene, kind).unwrap();
        assert!(with_stresslets(&mut model).stresslets.is_none());
    }
}
