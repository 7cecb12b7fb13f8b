//! Mesh motion around spheres: exact on boundaries, reversible, valid over a whole stroke, refused
//! when cells would be inverted.

use ale::{AleError, Elastic, Harmonic, MeshMotion, MovingBody, ReferenceMap, Stiffening};
use mesh::{Surface, TetMesh, Vec3};
use mesher::{Container, Sphere};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

const NAMES: [&str; 3] = ["left", "centre", "right"];

fn mesh_around(spheres: &[Sphere]) -> TetMesh {
    let surfaces = spheres.iter().map(|sphere| sphere as &dyn Surface);
    let bodies: Vec<_> = NAMES.into_iter().zip(surfaces).collect();
    crate::mesh_around(&bodies, 40.0, 0.6)
}

fn moving(spheres: &[Sphere]) -> Vec<MovingBody> {
    (spheres.iter().zip(NAMES))
        .map(|(sphere, name)| MovingBody {
            tag: name.to_owned(),
            centre: sphere.centre,
            rotates: false,
        })
        .collect()
}

fn spheres(arms: [f64; 2]) -> [Sphere; 3] {
    [-arms[0], 0.0, arms[1]].map(|x| Sphere::new(Vec3::new(x, 0.0, 0.0), 1.0))
}

fn shift(x: f64) -> Isometry3<f64> {
    Isometry3::translation(x, 0.0, 0.0)
}

#[test]
fn bodies_move_exactly_and_the_wall_stays() {
    let spheres = spheres([10.0, 10.0]);
    let mesh = mesh_around(&spheres);
    let method = Harmonic(Stiffening::KanchiMasud);
    let map = ReferenceMap::new(mesh.clone(), &moving(&spheres), &method).unwrap();
    let motions = [shift(2.0), shift(-1.0), shift(0.5)];
    let moved = map.moved(&motions).unwrap();
    for (name, motion) in NAMES.iter().zip(&motions) {
        for node in mesh.nodes_on(mesh.tag(name).unwrap()) {
            let expected = mesh.points()[node as usize] + motion.translation.vector;
            // The other bodies' fields are exactly zero here, so the only error is rounding in one
            // sum.
            assert!((moved.points()[node as usize] - expected).amax() < 1e-14);
        }
    }
    for node in mesh.nodes_on(mesh.tag(Container::TAG).unwrap()) {
        assert_eq!(moved.points()[node as usize], mesh.points()[node as usize]);
    }
    // The same configuration gives the same mesh, bit for bit, independent of the history.
    assert_eq!(map.moved(&[shift(0.0); 3]).unwrap().points(), mesh.points());
    assert_eq!(map.moved(&motions).unwrap().points(), moved.points());
}

/// Spheres that move and grow at once: surfaces are the true spheres, for a scalar and for a
/// coupled motion, and a displacement of the wrong kind is refused.
#[test]
fn surfaces_that_are_displaced_stay_true_surfaces() {
    let pair = [-2.5, 2.5].map(|x| Sphere::new(Vec3::new(x, 0.0, 0.0), 1.0));
    let surfaces = [("left", &pair[0] as &dyn Surface), ("right", &pair[1])];
    let mesh = crate::mesh_around(&surfaces, 12.0, 0.8);
    let bodies = moving(&pair).into_iter().zip(["left", "right"]);
    let bodies: Vec<_> = bodies
        .map(|(body, tag)| MovingBody {
            tag: tag.to_owned(),
            ..body
        })
        .collect();
    let elastic = Elastic::default();
    let methods: [&dyn MeshMotion; 2] = [&Harmonic(Stiffening::KanchiMasud), &elastic];
    for method in methods {
        let map = ReferenceMap::new(mesh.clone(), &bodies, method).unwrap();
        let motions = [shift(0.3), shift(-0.2)];
        let growth = |x: &Vec3| 0.3 * (x - pair[0].centre).normalize();
        let moved = map
            .moved_and_deformed(&motions, &[Some(&growth), None])
            .unwrap();
        for (name, sphere, motion, radius) in [
            ("left", &pair[0], &motions[0], 1.3),
            ("right", &pair[1], &motions[1], 1.0),
        ] {
            let centre = sphere.centre + motion.translation.vector;
            for node in moved.nodes_on(moved.tag(name).unwrap()) {
                let distance = (moved.points()[node as usize] - centre).norm();
                assert!((distance - radius).abs() < 1e-13, "{distance}");
            }
        }
        for node in mesh.nodes_on(mesh.tag(Container::TAG).unwrap()) {
            assert_eq!(moved.points()[node as usize], mesh.points()[node as usize]);
        }
        let rigid = map.moved_and_deformed(&motions, &[None, None]).unwrap();
        assert_eq!(rigid.points(), map.moved(&motions).unwrap().points());
        let nowhere = |_: &Vec3| Vec3::repeat(f64::NAN);
        assert!(matches!(
            map.moved_and_deformed(&motions, &[None, Some(&nowhere)]),
            Err(AleError::NotFinite { index: 1, .. })
        ));
        assert!(matches!(
            map.moved_and_deformed(&motions, &[None]),
            Err(AleError::Length { .. })
        ));
        // A surface that passes its centre inverts cells.
        let inwards = |x: &Vec3| -2.5 * (x - pair[0].centre).normalize();
        assert!(matches!(
            map.moved_and_deformed(&motions, &[Some(&inwards), None]),
            Err(AleError::Invalid(_))
        ));
    }
}

#[test]
fn meshes_of_a_stroke_are_valid_with_stiffening_and_inverted_without() {
    // From the middle of the stroke each arm changes by two radii, and the swimmer translates.
    let spheres = spheres([8.0, 8.0]);
    let mesh = mesh_around(&spheres);
    let bodies = moving(&spheres);
    let map = ReferenceMap::new(mesh.clone(), &bodies, &Harmonic(Stiffening::KanchiMasud)).unwrap();
    for (left, right) in [(10.0, 10.0), (6.0, 10.0), (6.0, 6.0), (10.0, 6.0)] {
        for translation in [-1.5, 0.0, 1.5] {
            let motions = [
                shift(8.0 - left + translation),
                shift(translation),
                shift(right - 8.0 + translation),
            ];
            let quality = map.moved(&motions).unwrap().quality();
            // Measured on similar meshes: motions of four radii leave a mean ratio of 0.2 to 0.34.
            assert!(
                quality.min_quality > 0.15 && quality.min_jacobian > 0.2,
                "{left} {right}: {quality:?}"
            );
        }
    }
    // A motion of four radii inverts the cells at the sphere unless they are stiffened.
    let far = [shift(4.0), shift(0.0), shift(0.0)];
    assert!(map.moved(&far).is_ok());
    let through = map.moved(&[shift(8.0), shift(0.0), shift(0.0)]);
    assert!(matches!(through, Err(AleError::Invalid(_))));
    let plain = ReferenceMap::new(mesh, &bodies, &Harmonic(Stiffening::None)).unwrap();
    assert!(matches!(plain.moved(&far), Err(AleError::Invalid(_))));
}

/// One body that rotates and one that does not, in configurations far from the reference, for a
/// scalar and for a coupled motion.
///
/// The positions along a motion with constant twists are smooth in time: the error of central
/// differences falls as the square of the step, with the constant `|ω|^2 |w| / 6`.
#[test]
fn mesh_velocities_are_the_derivatives_of_the_moved_mesh() {
    let pair = [-3.0, 3.0].map(|x| Sphere::new(Vec3::new(x, 0.0, 0.0), 1.0));
    let surfaces = [("left", &pair[0] as &dyn Surface), ("right", &pair[1])];
    let mesh = crate::mesh_around(&surfaces, 12.0, 1.0);
    let bodies =
        [("left", &pair[0], true), ("right", &pair[1], false)].map(|(tag, at, rotates)| {
            MovingBody {
                tag: tag.into(),
                centre: at.centre,
                rotates,
            }
        });
    let twists = [
        [Vec3::new(0.3, -0.5, 0.2), Vec3::new(0.8, -0.4, 0.6)],
        [Vec3::new(-0.4, 0.1, 0.7), Vec3::new(5.0, 6.0, 7.0)],
    ];
    let speed: f64 = 1.0 + 0.9;
    let configurations = [
        [(Vec3::zeros(), Vec3::zeros()); 2],
        [
            (Vec3::new(0.1, 0.05, -0.2), Vec3::new(0.1, 0.15, -0.1)),
            (Vec3::z() * -0.3, Vec3::y() * 0.8),
        ],
    ];
    let elastic = Elastic::default();
    let methods: [&dyn MeshMotion; 2] = [&Harmonic(Stiffening::KanchiMasud), &elastic];
    for method in methods {
        let map = ReferenceMap::new(mesh.clone(), &bodies, method).unwrap();
        for configuration in configurations {
            // The rotation increments are about the axes of the laboratory.
            let at = |time: f64| {
                [0, 1].map(|k| {
                    let ((shift, turn), [velocity, angular]) = (configuration[k], twists[k]);
                    let turned = UnitQuaternion::new(angular * time) * UnitQuaternion::new(turn);
                    Isometry3::from_parts(Translation3::from(shift + velocity * time), turned)
                })
            };
            let velocities = map.velocity(&at(0.0), &twists).unwrap();
            for step in [0.02, 0.01] {
                let [ahead, behind] = [step, -step].map(|time| map.moved(&at(time)).unwrap());
                let pairs = ahead.points().iter().zip(behind.points()).zip(&velocities);
                let error = pairs.fold(0.0_f64, |error, ((a, b), w)| {
                    error.max(((a - b) / (2.0 * step) - w).norm())
                });
                // Of the left body: |ω| = 1.08, arms of 1; rounding is 1e-13 / step.
                let bound = 1.08_f64.powi(3) * step * step / 6.0 * 1.01 + 1e-11;
                assert!(error < bound, "{}: {error:e} {bound:e}", method.name());
                assert!(error > 0.5 * bound, "not at its order: {error:e} {bound:e}");
            }
            let moved = map.moved(&at(0.0)).unwrap();
            for (k, name) in ["left", "right"].into_iter().enumerate() {
                let centre = pair[k].centre + configuration[k].0;
                for node in mesh.nodes_on(mesh.tag(name).unwrap()) {
                    let arm = moved.points()[node as usize] - centre;
                    let spin = [twists[k][1].cross(&arm), Vec3::zeros()][k];
                    let exact = twists[k][0] + spin;
                    assert!((velocities[node as usize] - exact).norm() < 1e-14 * 12.0 * speed);
                }
            }
            for node in mesh.nodes_on(mesh.tag(Container::TAG).unwrap()) {
                assert_eq!(velocities[node as usize], Vec3::zeros());
            }
        }
        let motions = [Isometry3::identity(); 2];
        assert!(matches!(
            map.velocity(&motions, &twists[..1]),
            Err(AleError::Twists {
                expected: 2,
                found: 1
            })
        ));
        let nan = [twists[0], [Vec3::repeat(f64::NAN); 2]];
        assert!(matches!(
            map.velocity(&motions, &nan),
            Err(AleError::NotFinite { index: 1, .. })
        ));
    }
}
