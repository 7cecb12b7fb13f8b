//! Every public function on hostile arguments: a right answer or an error, never a panic.

use fem::{
    CubicExtension, CurvedBoundary, DirichletCondition, FacetGeometry, FemError, PointValues,
    SurplusSpace, TaylorHood, consistent_load, continuity_residual, dissipation, evaluate,
    field_error, integrate_facets, load_vector, mean_pressure, momentum_residual, pressure_error,
    stress_load, surface_measures,
};
use linalg::{Csr, Csr3};
use mesh::{LinearTets, TetMesh, Vec3};
use mesher::Sphere;
use nalgebra::Matrix3;
use proptest::prelude::*;

fn number() -> impl Strategy<Value = f64> {
    let hostile = [
        0.0,
        5e-324,
        1e-300,
        1e150,
        1e300,
        f64::MAX,
        f64::NAN,
        f64::NEG_INFINITY,
    ];
    prop_oneof![20 => -2.0..2.0, 1 => proptest::sample::select(hostile.to_vec())]
}

fn vector() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(number()).prop_map(Vec3::from)
}

/// Numbers of items near those of a cube of six tets: 8 vertices, 27 points, 6 cells.
fn count() -> impl Strategy<Value = usize> {
    proptest::sample::select(&[27, 27, 27, 8, 8, 6, 6, 0, 1, 26][..])
}

fn cube(n: u32) -> TetMesh {
    TetMesh::straight(LinearTets::cube(n)).expect("a cube")
}

fn finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.is_finite())
}

fn all_finite(vectors: &[Vec3]) -> bool {
    vectors.iter().all(|v| finite(v.as_slice()))
}

/// A matrix with this shape and three entries.
fn matrix(rows: usize, cols: usize, value: f64) -> Csr {
    let nnz = rows.min(cols).min(3);
    let starts = (0..=rows).map(|row| row.min(nnz)).collect();
    Csr::new(
        (rows, cols),
        starts,
        (0..nnz as u32).collect(),
        vec![value; nnz],
    )
}

#[test]
fn bug_a_gradient_that_overflows_was_infinite() {
    let mesh = cube(1);
    let mut field = vec![0.0; 27];
    field[10] = f64::MAX;
    let found = evaluate(&mesh, &field, &[Vec3::new(0.51, 0.0, 1.0)]);
    assert!(
        matches!(found, Err(FemError::NotFiniteInCell { .. })),
        "{found:?}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn integrals_of_hostile_fields_are_finite_or_refused(
        velocity in prop::collection::vec(vector(), 27),
        pressure in prop::collection::vec(number(), 27),
        (nodes, vertices, cells) in (count(), count(), count()),
        (tag, centre, x, is_wall) in (0..9u16, vector(), number(), any::<bool>()),
    ) {
        let mesh = cube(1);
        let (u, p, c) = (&velocity[..nodes], &pressure[..vertices], &pressure[..cells]);
        let scalars = [
            dissipation(&mesh, u),
            mean_pressure(&mesh, p),
            pressure_error(&mesh, p, |at| x * at.x),
            field_error(&mesh, u, |at| (x * at, Matrix3::from_element(x))).map(|e| e.l2),
            field_error(&mesh, p, |at| (x * at.y, x * at)).map(|e| e.h1_seminorm),
            surface_measures(&mesh, tag).map(|measures| measures.volume),
        ];
        prop_assert!(scalars.iter().flatten().all(|value| value.is_finite()), "{scalars:?}");
        let forces = [
            consistent_load(&mesh, tag, u, centre, velocity[0]),
            stress_load(&mesh, tag, u, p, centre),
        ];
        for load in forces.iter().flatten() {
            prop_assert!(all_finite(&[load.force, load.torque]));
        }
        if let Ok(load) = load_vector(&mesh, |at| x * at) {
            prop_assert!(all_finite(&load));
        }
        let space = TaylorHood::new(&mesh).expect("a space");
        let form = |point: &PointValues<'_>, matrix: &mut [[f64; 10]; 4]| {
            let value = x * (point.value(u).x + point.value(p));
            point.add(matrix, |v, u| value * v.value * u.gradient.x);
        };
        for degree in [0, 8, 9, usize::MAX] {
            if let Ok(matrix) = space.assemble(&mesh, degree, form) {
                prop_assert!(finite(matrix.data()));
            }
            let facets = space.assemble_facets(&mesh, tag, degree, |f, m| form(&f.point, m));
            prop_assert!(facets.map_or(true, |matrix| finite(matrix.data())));
            if let Ok(found) = integrate_facets(&mesh, tag, degree, |f| f.point.gradient(u)) {
                prop_assert!(found.iter().all(|x| x.is_finite()));
            }
        }
        if let Ok(found) = evaluate(&mesh, p, &[centre]) {
            prop_assert!(finite(&[found[0].0]) && all_finite(&[found[0].1]));
        }
        let _ = space.weighted_vertex_stiffness(&mesh, c);
        let _ = space.vertex_elasticity(&mesh, c, x);
        let surface = &Sphere::new(centre, x);
        let ball = CurvedBoundary { tag, surface, is_wall };
        if let Ok(geometry) = FacetGeometry::new(&mesh, &[ball]) {
            let _ = (geometry.is_wall().count(), geometry.cells().count());
            if let Ok(load) = geometry.functional(u) {
                prop_assert!(all_finite(&load.velocity) && finite(&load.pressure));
            }
            if let Ok(indicators) = geometry.indicators(u, &velocity) {
                prop_assert!(finite(&indicators));
            }
        }
        let surplus = SurplusSpace::new(&mesh).expect("a space");
        if let Ok(own) = surplus.surplus(&mesh, u, p) {
            if let Ok(energy) = own.energy(&own) {
                prop_assert!(energy.is_finite());
            }
            let _ = surplus.indicators(&mesh, &own, &own);
        }
        if let Ok(cubic) = CubicExtension::new(&surplus, &mesh) {
            let extension = vec![x; cubic.len()];
            let _ = cubic.product(u, p, &extension);
            let _ = cubic.coarse_rows(&extension);
            let _ = cubic.gradient(&mut extension.clone());
        }
    }

    #[test]
    fn restrictions_of_hostile_shapes_answer_or_refuse(
        prescribed in prop::collection::vec(any::<bool>(), 0..5),
        mut field in prop::collection::vec(vector(), 0..5),
        values in prop::collection::vec(number(), 0..12),
        (rows, cols, components) in (0..7usize, 0..7usize, 0..4usize),
        (by_columns, x) in (any::<bool>(), number()),
    ) {
        let condition = DirichletCondition::new(&prescribed);
        let n = prescribed.len();
        prop_assert_eq!(condition.free_nodes().len(), condition.n_free());
        prop_assert_eq!(condition.restrict(&field).is_ok(), field.len() == n);
        prop_assert_eq!(condition.rhs(&field, &field).is_ok(), field.len() == n);
        prop_assert!(condition.rhs(&field, &[]).is_err() || n == 0);
        let fits = field.len() == n && values.len() == 3 * condition.n_free();
        prop_assert_eq!(condition.expand(&values, &mut field).is_ok(), fits);
        prop_assert_eq!(condition.lift(&mut field).is_ok(), field.len() == n);
        let mut scalar = matrix(rows, cols, x);
        let mut divergence: Csr3 = scalar.map(|v| [*v; 3]);
        if by_columns {
            (scalar, divergence) = (scalar.to_csc(), divergence.to_csc());
        }
        for components in [components, usize::MAX] {
            let restricted = condition.restrict_matrix(&scalar, components);
            let fits = (rows, cols) == (components.saturating_mul(n), components.saturating_mul(n));
            prop_assert_eq!(restricted.is_ok(), fits && !by_columns);
        }
        prop_assert_eq!(condition.restrict_divergence(&divergence).is_ok(), cols == n && !by_columns);
        if let Ok(residual) = momentum_residual(&scalar, &divergence, &field, &values) {
            prop_assert!(all_finite(&residual));
        }
        if let Ok(residual) = continuity_residual(&divergence, &field) {
            prop_assert!(finite(&residual));
        }
    }
}

/// Spaces, surpluses and matrices of one mesh are refused on another.
#[test]
fn data_of_another_mesh_are_refused() {
    let (one, two) = (cube(1), cube(2));
    let other = |found: Result<(), FemError>| matches!(found, Err(FemError::OtherMesh { .. }));
    let space = TaylorHood::new(&one).expect("a space");
    assert!(other(space.matrices(&two).map(|_| ())));
    assert!(other(space.vertex_interpolation(&two).map(|_| ())));
    assert!(other(space.velocity_mass(&two).map(|_| ())));
    assert!(other(space.viscous_block(&two).map(|_| ())));
    let spaces = [&one, &two].map(|mesh| SurplusSpace::new(mesh).expect("a space"));
    let [small, large] = [(&one, &spaces[0]), (&two, &spaces[1])].map(|(mesh, space)| {
        let velocity: Vec<Vec3> = mesh.points().iter().map(|x| x.component_mul(x)).collect();
        space
            .surplus(mesh, &velocity, &vec![0.0; mesh.n_vertices()])
            .expect("a surplus")
    });
    assert!(small.energy(&large).is_err());
    assert!(spaces[0].indicators(&one, &small, &large).is_err());
    assert!(other(CubicExtension::new(&spaces[0], &two).map(|_| ())));
}

#[test]
fn bug_a_divergence_stored_by_columns_gave_the_residual_of_another_matrix() {
    let mesh = cube(2);
    let space = TaylorHood::new(&mesh).expect("a space");
    let (stiffness, divergence) = (space.stiffness(&mesh), space.divergence(&mesh));
    let (stiffness, divergence) = (stiffness.expect("a matrix"), divergence.expect("a matrix"));
    let velocity: Vec<Vec3> = mesh.points().iter().map(|x| x.component_mul(x)).collect();
    let pressure = vec![1.0; mesh.n_vertices()];
    let by_columns = divergence.to_csc();
    assert_eq!(
        continuity_residual(&divergence, &velocity),
        continuity_residual(&by_columns, &velocity)
    );
    let residual = |divergence| momentum_residual(&stiffness, divergence, &velocity, &pressure);
    let (a, b) = (residual(&divergence), residual(&by_columns));
    for (a, b) in a.expect("they fit").iter().zip(&b.expect("they fit")) {
        assert!((a - b).norm() < 1e-13);
    }
}
