//! Mesh motion around spheres: exact on boundaries, reversible, valid over a whole stroke, refused
//! when cells would be inverted.

use ale::{AleError, Harmonic, MovingBody, ReferenceMap, Stiffening};
use mesh::{Surface, TetMesh, Vec3};
use mesher::{Container, Sphere};
use nalgebra::Isometry3;

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
