//! Files written by Gmsh: three unit spheres in a ball of radius 40, a ball of two regions.

use crate::shapes::Sphere;
use mesh::{MshFile, NamedSurface, TetMesh, Vec3};

/// A file of the folder of fixtures, with straight cells.
fn fixture(name: &str) -> MshFile {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/");
    MshFile::read(format!("{folder}{name}")).unwrap()
}

fn straight(name: &str) -> TetMesh {
    fixture(name).into_mesh(&[]).unwrap()
}

fn sphere(x: f64, radius: f64) -> Sphere {
    Sphere::new(Vec3::new(x, 0.0, 0.0), radius)
}

/// The text has 16 digits of numbers up to 1.
#[test]
fn both_versions_hold_the_same_mesh() {
    let a = straight("ball-order1-v41-binary.msh");
    let b = straight("ball-order1-v22-text.msh");
    assert_eq!((a.cells(), a.facets()), (b.cells(), b.facets()));
    assert_eq!((a.tags(), a.regions()), (b.tags(), b.regions()));
    for (x, y) in a.points().iter().zip(b.points()) {
        assert!((x - y).amax() <= 1e-15);
    }
}

#[test]
fn three_spheres_have_their_parts_and_dofs() {
    let mesh = straight("three-spheres-v41-binary.msh");
    assert_eq!(mesh.tags(), ["sphere1", "sphere2", "sphere3", "outer"]);
    assert_eq!((mesh.n_vertices(), mesh.n_cells()), (2917, 15_177));
    // Taylor-Hood dofs before boundary conditions: three velocities per node, one pressure per
    // vertex.
    assert_eq!(3 * mesh.n_points() + mesh.n_vertices(), 67_993);
}

#[test]
fn curved_real_mesh_is_valid_and_has_the_volume_of_the_ball_minus_the_spheres() {
    let (left, right, centre) = (sphere(-10.0, 1.0), sphere(10.0, 1.0), sphere(0.0, 1.0));
    let outer = sphere(0.0, 40.0);
    let surfaces: [NamedSurface; 4] = [
        ("sphere1", &left),
        ("sphere2", &right),
        ("sphere3", &centre),
        ("outer", &outer),
    ];
    let file = fixture("three-spheres-v41-binary.msh");
    let straight = file.clone().into_mesh(&[]).unwrap();
    let mesh = file.into_mesh(&surfaces).unwrap();
    let volume = 4.0 / 3.0 * std::f64::consts::PI * (40.0_f64.powi(3) - 3.0);
    // Over an arc t the chord is t^2 / 8 too low; the error of the parabola through its middle is
    // less than (t^2 / 8)^2 = t^4 / 64.
    let error = |mesh: &TetMesh| (mesh.volume() / volume - 1.0).abs();
    assert!(error(&mesh) < error(&straight).powi(2));
    let quality = mesh.quality();
    assert!(quality.min_jacobian > 0.5, "{quality:?}");
    assert!((quality.mean_quality - 0.8736).abs() < 5e-5, "{quality:?}");
}

/// Version 2.2 binary and 4.1 text have the same ball, with curved cells and two regions.
#[test]
fn both_versions_hold_the_same_cells_of_second_order() {
    let a = straight("ball-order2-v22-binary.msh");
    let b = straight("ball-order2-v41-text.msh");
    assert_eq!((a.cells(), a.facets()), (b.cells(), b.facets()));
    assert_eq!((a.tags(), a.regions()), (b.tags(), b.regions()));
    assert_eq!(a.regions().names, ["core", "shell"]);
    for (x, y) in a.points().iter().zip(b.points()) {
        assert!((x - y).amax() <= 1e-15);
    }
    assert!((0..a.n_cells()).any(|cell| !a.is_affine(cell)));
    // A chord of the parabolas is about t^2 / 8 high, with edges of t = 0.6 radii.
    let volume = a.volume() / (4.0 / 3.0 * std::f64::consts::PI);
    assert!(
        (volume - 1.0).abs() < (0.6f64.powi(2) / 8.0).powi(2),
        "{volume}"
    );
}
