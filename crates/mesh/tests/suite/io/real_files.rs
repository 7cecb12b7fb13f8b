//! A real Gmsh mesh, if its folder exists: three unit spheres in a ball of radius 40.

use std::path::PathBuf;

use crate::shapes::Sphere;
use mesh::{MshFile, NamedSurface, TetMesh, Vec3};

fn path(name: &str) -> Option<PathBuf> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/meshes");
    Some(PathBuf::from(folder).join(name)).filter(|path| path.exists())
}

fn sphere(x: f64, radius: f64) -> Sphere {
    Sphere {
        centre: Vec3::new(x, 0.0, 0.0),
        radius,
    }
}

#[test]
fn both_versions_hold_the_same_mesh() {
    let (Some(binary), Some(text)) = (path("ball_311k.msh"), path("ball_311k_v22.msh")) else {
        return;
    };
    let read = |path| MshFile::read(path).unwrap().into_mesh(&[]).unwrap();
    let (a, b): (TetMesh, TetMesh) = (read(binary), read(text));
    assert_eq!(a.cells(), b.cells());
    assert_eq!(a.facets(), b.facets());
    assert_eq!(a.tags(), ["sphere1", "sphere2", "sphere3", "outer"]);
    assert_eq!(a.tags(), b.tags());
    // The text has 16 digits of numbers up to 40: half a unit of the last digit is 5e-15, half a
    // unit of rounding 3.6e-15.
    for v in 0..a.n_vertices() {
        assert!((a.points()[v] - b.points()[v]).amax() <= 1e-14);
    }
    assert_eq!((a.n_vertices(), a.n_cells()), (12_598, 71_614));
    // Taylor-Hood dofs before boundary conditions: three velocities per node, one pressure per
    // vertex.
    let dofs = 3 * a.n_points() + a.n_vertices();
    assert_eq!(dofs, 309_580);
}

#[test]
fn curved_real_mesh_is_valid_and_has_the_volume_of_the_ball_minus_the_spheres() {
    let Some(path) = path("ball_311k.msh") else {
        return;
    };
    let (left, right, centre) = (sphere(-10.0, 1.0), sphere(10.0, 1.0), sphere(0.0, 1.0));
    let outer = sphere(0.0, 40.0);
    let surfaces: [NamedSurface; 4] = [
        ("sphere1", &left),
        ("sphere2", &right),
        ("sphere3", &centre),
        ("outer", &outer),
    ];
    let file = MshFile::read(path).unwrap();
    let straight = file.clone().into_mesh(&[]).unwrap();
    let mesh = file.into_mesh(&surfaces).unwrap();
    let volume = 4.0 / 3.0 * std::f64::consts::PI * (40.0_f64.powi(3) - 3.0);
    // Over an arc t the chord is t^2 / 8 too low; the error of the parabola through its middle is
    // less than (t^2 / 8)^2 = t^4 / 64.
    let error = |mesh: &TetMesh| (mesh.volume() / volume - 1.0).abs();
    assert!(error(&mesh) < error(&straight).powi(2));
    let quality = mesh.quality();
    assert!(quality.min_jacobian > 0.7, "{quality:?}");
    assert!((quality.mean_quality - 0.8025).abs() < 5e-5, "{quality:?}");
}
