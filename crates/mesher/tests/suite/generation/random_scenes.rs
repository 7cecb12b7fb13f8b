//! Random arrangements of spheres.

use super::{ball, bodies, checked};
use mesh::Vec3;
use mesher::{GenerateError, GenerateParams, Sphere, generate};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Any three spheres give a valid mesh, or an error with the reason.
    #[test]
    fn random_scenes(
        places in prop::collection::vec((prop::array::uniform3(-4.0..4.0f64), 0.3..1.5f64), 3),
        size in 0.4..0.9f64,
    ) {
        let shapes: Vec<Sphere> = places
            .iter()
            .map(|&(centre, radius)| Sphere { centre: Vec3::from(centre), radius })
            .collect();
        let bodies = bodies(&shapes, size);
        let closest = (0..3)
            .map(|i| {
                let (a, b) = (shapes[i], shapes[(i + 1) % 3]);
                (a.centre - b.centre).norm() - a.radius - b.radius
            })
            .fold(f64::INFINITY, f64::min);
        if closest > 0.05 {
            let (_, quality) = checked(&bodies, &ball(12.0));
            prop_assert!(quality.min_jacobian > 0.0);
        } else if closest < 0.0 {
            let outcome = generate(&bodies, &ball(12.0), &GenerateParams::default());
            let refused = matches!(outcome, Err(GenerateError::BodiesTouch { .. }));
            prop_assert!(refused);
        }
    }
}

/// Three tets around three vertices above a sphere had no volume (`FlatCell`), which no move of a
/// single vertex could change.
#[test]
fn bug_tets_without_volume_that_no_single_move_improves() {
    let shapes = [
        Sphere::new(Vec3::new(0.0, 0.4619673773175371, 0.0), 0.3),
        Sphere::new(
            Vec3::new(0.0, 3.601218562168017, -2.9840832370267116),
            1.2136678998138564,
        ),
        Sphere::new(
            Vec3::new(0.0, -2.9325935776604313, -2.8755406890327584),
            1.214531321919653,
        ),
    ];
    let (_, quality) = checked(&bodies(&shapes, 0.4754607427626072), &ball(12.0));
    assert!(quality.min_jacobian > 0.0, "{quality:?}");
}

/// A curved cell above a small sphere was inverted.
#[test]
fn bug_a_curved_cell_above_a_small_sphere_is_inverted() {
    let shapes = [
        Sphere::new(Vec3::new(0.0, 3.7653446046666494, 0.0), 1.4627935356254664),
        Sphere::new(
            Vec3::new(0.0, 0.4808863801593716, 2.6121337578295702),
            0.9792807473036731,
        ),
        Sphere::new(
            Vec3::new(-0.24890092627985383, -3.2461037874742686, 0.0),
            0.3116591585338087,
        ),
    ];
    let (_, quality) = checked(&bodies(&shapes, 0.5056949502229581), &ball(12.0));
    assert!(quality.min_jacobian > 0.0, "{quality:?}");
}
