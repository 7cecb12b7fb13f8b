//! Mesh motion around spheres and spheroids: exact on boundaries, reversible, valid over a whole
//! stroke, refused when cells would be inverted.

use ale::{AleError, Harmonic, MovingBody, ReferenceMap, Stiffening};
use mesh::{Surface, TetMesh, Vec3};
use mesher::{Container, GenerateParams, MeshedBody, Sphere, Spheroid};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

const NAMES: [&str; 3] = ["left", "centre", "right"];

fn mesh_around(surfaces: &[&dyn Surface], radius: f64, size: f64) -> TetMesh {
    let container = Container::Ball(Sphere::new(Vec3::zeros(), radius));
    let bodies: Vec<MeshedBody> = surfaces
        .iter()
        .zip(NAMES)
        .map(|(&surface, name)| MeshedBody {
            name,
            surface,
            size,
        })
        .collect();
    let tets = mesher::generate(&bodies, &container, &GenerateParams::default())
        .unwrap()
        .mesh;
    let mut named: Vec<(&str, &dyn Surface)> = bodies.iter().map(|b| (b.name, b.surface)).collect();
    named.push((Container::TAG, container.surface()));
    TetMesh::curved(tets, &named).unwrap()
}

fn moving(surfaces: &[&dyn Surface], rotates: bool) -> Vec<MovingBody> {
    surfaces
        .iter()
        .zip(NAMES)
        .map(|(s, name)| MovingBody {
            tag: name.to_owned(),
            centre: s.centre(),
            rotates,
        })
        .collect()
}

fn spheres(arms: [f64; 2]) -> [Sphere; 3] {
    [-arms[0], 0.0, arms[1]].map(|x| Sphere {
        centre: Vec3::new(x, 0.0, 0.0),
        radius: 1.0,
    })
}

fn shift(x: f64) -> Isometry3<f64> {
    Isometry3::translation(x, 0.0, 0.0)
}

#[test]
fn bodies_move_exactly_and_the_wall_stays() {
    let spheres = spheres([10.0, 10.0]);
    let surfaces: Vec<&dyn Surface> = spheres.iter().map(|s| s as &dyn Surface).collect();
    let mesh = mesh_around(&surfaces, 40.0, 0.6);
    let map = ReferenceMap::new(
        mesh.clone(),
        &moving(&surfaces, false),
        &Harmonic(Stiffening::KanchiMasud),
    )
    .unwrap();
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
    let surfaces: Vec<&dyn Surface> = spheres.iter().map(|s| s as &dyn Surface).collect();
    let mesh = mesh_around(&surfaces, 40.0, 0.6);
    let bodies = moving(&surfaces, false);
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
    let plain = ReferenceMap::new(mesh, &bodies, &Harmonic(Stiffening::None)).unwrap();
    assert!(matches!(plain.moved(&far), Err(AleError::Invalid(_))));
}

#[test]
fn surface_nodes_follow_a_rotating_body() {
    let spheroid = Spheroid {
        centre: Vec3::new(0.5, 0.0, 0.0),
        axis: Vec3::x(),
        axial: 2.0,
        equatorial: 1.0,
    };
    let surfaces: [&dyn Surface; 1] = [&spheroid];
    let mesh = mesh_around(&surfaces, 8.0, 0.6);
    let map = ReferenceMap::new(
        mesh.clone(),
        &moving(&surfaces, true),
        &Harmonic(Stiffening::KanchiMasud),
    )
    .unwrap();
    let motion = Isometry3::from_parts(
        Translation3::new(0.2, 0.1, 0.0),
        UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.1, 0.4)),
    );
    let moved = map.moved(&[motion]).unwrap();
    for node in mesh.nodes_on(mesh.tag("left").unwrap()) {
        let arm = mesh.points()[node as usize] - spheroid.centre;
        let expected = spheroid.centre + motion.translation.vector + motion.rotation * arm;
        assert!((moved.points()[node as usize] - expected).amax() < 1e-13);
    }
    // The body keeps its volume and the container is fixed, so the fluid keeps its volume.
    assert!((moved.volume() - mesh.volume()).abs() < 1e-11 * mesh.volume());
}

#[test]
fn impossible_motions_are_refused() {
    let spheres = spheres([4.0, 4.0]);
    let surfaces: Vec<&dyn Surface> = spheres.iter().map(|s| s as &dyn Surface).collect();
    let mesh = mesh_around(&surfaces, 20.0, 0.7);
    let map = ReferenceMap::new(
        mesh.clone(),
        &moving(&surfaces, false),
        &Harmonic(Stiffening::KanchiMasud),
    )
    .unwrap();
    // A motion through the other sphere.
    assert!(matches!(
        map.moved(&[shift(4.0), shift(0.0), shift(0.0)]),
        Err(AleError::Invalid(_))
    ));
    assert!(matches!(
        map.moved(&[shift(0.0)]),
        Err(AleError::Motions {
            expected: 3,
            found: 1
        })
    ));
    let unknown = [MovingBody {
        tag: "nobody".into(),
        centre: Vec3::zeros(),
        rotates: false,
    }];
    assert!(ReferenceMap::new(mesh, &unknown, &Harmonic(Stiffening::KanchiMasud)).is_err());
}

#[test]
fn stiffening_coefficients_match_the_formula_of_kanchi_and_masud() {
    let spheres = spheres([4.0, 4.0]);
    let surfaces: Vec<&dyn Surface> = spheres.iter().map(|s| s as &dyn Surface).collect();
    let mesh = mesh_around(&surfaces, 20.0, 0.8);
    let volumes: Vec<f64> = (0..mesh.n_cells())
        .map(|cell| mesh.cell_volume(cell))
        .collect();
    let largest = volumes.iter().cloned().fold(0.0, f64::max);
    let smallest = volumes.iter().cloned().fold(f64::INFINITY, f64::min);
    let coefficients = Stiffening::KanchiMasud.coefficients(&mesh);
    for (coefficient, volume) in coefficients.iter().zip(&volumes) {
        // tau = 1 - Vmin/Vmax in the largest cell and Vmax/Vmin - 1 in the smallest.
        let tau = (largest - smallest) / volume;
        assert!((coefficient - 1.0 - tau).abs() <= 1e-12 * coefficient);
    }
}
