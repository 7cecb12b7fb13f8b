//! Invalid input leads to an error that names the quantity and the place.

use crate::support::meshes::fan;
use fem::{
    FemError, TaylorHood, consistent_load, continuity_residual, dissipation, load_vector,
    momentum_residual, stress_load, surface_measures,
};
use mesh::{LinearTets, TetMesh, Vec3};

fn cube(n: u32) -> TetMesh {
    TetMesh::straight(LinearTets::cube(n)).unwrap()
}

#[test]
fn a_mesh_other_than_that_of_the_space_is_an_error() {
    let (mesh, other) = (cube(2), cube(3));
    let space = TaylorHood::new(&mesh).unwrap();
    let error = space.stiffness(&other).unwrap_err();
    assert_eq!(
        error,
        FemError::OtherMesh {
            expected: 48,
            found: 162
        }
    );
    assert!(space.vertex_interpolation(&other).is_err());
}

#[test]
fn a_mesh_of_the_same_size_with_other_connectivity_is_an_error() {
    let cube = LinearTets::cube(2);
    let mut other = cube.clone();
    // The same tetrahedra; permuted vertices of the first give its local nodes other rows.
    other.tets[0][..3].rotate_left(1);
    let (mesh, other) = (
        TetMesh::straight(cube).unwrap(),
        TetMesh::straight(other).unwrap(),
    );
    assert_eq!(
        (mesh.n_cells(), mesh.n_points()),
        (other.n_cells(), other.n_points())
    );
    assert_ne!(mesh.cells(), other.cells());
    assert!(TaylorHood::new(&mesh).unwrap().stiffness(&other).is_err());
}

#[test]
fn arrays_of_the_wrong_length_or_with_nan_are_errors() {
    let mesh = cube(2);
    let space = TaylorHood::new(&mesh).unwrap();
    let (k, b) = (
        space.stiffness(&mesh).unwrap(),
        space.divergence(&mesh).unwrap(),
    );
    let (u, p) = (
        vec![Vec3::zeros(); mesh.n_points()],
        vec![0.0; mesh.n_vertices()],
    );
    let mut nan = u.clone();
    nan[1].z = f64::NAN;
    let not_finite = FemError::NotFinite {
        what: "the velocity",
        index: 1,
    };
    let short = FemError::Length {
        what: "the velocity",
        found: 2,
        expected: u.len(),
    };

    assert_eq!(dissipation(&mesh, &nan).unwrap_err(), not_finite);
    assert_eq!(dissipation(&mesh, &u[..2]).unwrap_err(), short);
    assert_eq!(momentum_residual(&k, &b, &nan, &p).unwrap_err(), not_finite);
    assert_eq!(momentum_residual(&k, &b, &u[..2], &p).unwrap_err(), short);
    assert!(momentum_residual(&k, &b, &u, &p[..2]).is_err());
    assert_eq!(continuity_residual(&b, &nan).unwrap_err(), not_finite);
    assert_eq!(continuity_residual(&b, &u[..2]).unwrap_err(), short);
    assert!(momentum_residual(&space.vertex_stiffness(&mesh).unwrap(), &b, &u, &p).is_err());
    assert_eq!(
        stress_load(&mesh, 0, &nan, &p, Vec3::zeros()).unwrap_err(),
        not_finite
    );
    assert!(consistent_load(&mesh, 0, &u[..2], Vec3::zeros(), Vec3::zeros()).is_err());
    assert!(
        space
            .weighted_vertex_stiffness(&mesh, &[f64::INFINITY; 48])
            .is_err()
    );
    assert!(space.weighted_vertex_stiffness(&mesh, &[1.0]).is_err());
    assert!(fem::mean_pressure(&mesh, &[f64::NAN; 27]).is_err());
    let undefined = |_| (Vec3::repeat(f64::NAN), nalgebra::Matrix3::zeros());
    assert!(fem::field_error(&mesh, &u, undefined).is_err());
    assert!(fem::pressure_error(&mesh, &p, |_| f64::NAN).is_err());
    assert!(load_vector(&mesh, |_| Vec3::repeat(f64::NAN)).is_err());
}

#[test]
fn a_surface_that_is_not_closed_is_an_error() {
    let mesh = cube(2);
    let open = surface_measures(&mesh, 0).unwrap_err();
    assert!(
        matches!(open, FemError::OpenSurface { tag: 0, gap } if (gap - 1.0).abs() < 1e-12),
        "{open}"
    );
    assert_eq!(
        surface_measures(&mesh, 6).unwrap_err(),
        FemError::EmptyTag { tag: 6, n_tags: 6 }
    );
}

#[test]
fn too_many_neighbours_of_a_node_are_an_error() {
    // The centre of an icosphere with n triangles per edge has as neighbours 10 n^2 + 2 vertices,
    // the midside nodes of as many spokes and of 30 n^2 edges, and itself.
    let neighbours = |n: usize| 50 * n * n + 5;
    assert!(TaylorHood::new(&fan(36)).is_ok());
    let error = TaylorHood::new(&fan(37)).err();
    let expected = FemError::TooLarge {
        what: "the number of neighbours of a node",
        found: neighbours(37),
        limit: 65_535,
    };
    assert_eq!(error, Some(expected));
}
