//! Forms of callers: the matrices of this crate again, integral theorems, errors.

use crate::support::meshes::{curved_shell, random_affine};
use crate::support::{noise, noise_field, noise_vector};
use fem::{
    DirichletCondition, FemError, TaylorHood, assemble_facet_load, assemble_load, evaluate,
    field_error, integrate, integrate_facets, interleaved, interpolate, load_vector,
};
use linalg::Csr;
use mesh::{LinearTets, TetMesh, Vec3};
use nalgebra::Matrix3;
use sprs::CsMatI;

fn cube(n: u32) -> TetMesh {
    TetMesh::straight(LinearTets::cube(n)).unwrap()
}

/// An affine mesh, and one whose cells are all curved: each coordinate is moved by up to 0.02.
fn meshes() -> [TetMesh; 2] {
    let mesh = curved_shell(2, 3.0);
    let points = mesh.points().iter().enumerate();
    let moved = points.map(|(i, x)| x + Vec3::from_fn(|c, _| 0.02 * noise(5, 3 * i + c)));
    [
        random_affine(2, 4),
        mesh.with_points(moved.collect()).unwrap(),
    ]
}

/// Largest difference of two matrices with the same pattern, relative to the largest entry.
fn difference<T: AsRef<[f64]>>(a: (&[T], &[u32]), b: (&[T], &[u32])) -> f64 {
    assert_eq!(a.1, b.1);
    let (a, b) = (
        a.0.iter().flat_map(T::as_ref),
        b.0.iter().flat_map(T::as_ref),
    );
    let (mut largest, mut size) = (0f64, 0f64);
    for (a, b) in a.zip(b) {
        largest = largest.max((a - b).abs());
        size = size.max(a.abs());
    }
    largest / size
}

fn parts(matrix: &Csr) -> (&[[f64; 1]], &[u32]) {
    (matrix.data().as_chunks().0, matrix.indices())
}

/// Rounding: an entry is a sum of at most 14 points in each of a few dozen cells, whose terms are
/// at most a hundred times the largest entry.
const ROUNDING: f64 = 1e-12;

/// The rule of degree 5 is that of the curved cells of this crate, and exact on affine ones.
#[test]
fn forms_of_callers_give_the_matrices_of_this_crate() {
    for mesh in meshes() {
        let space = TaylorHood::new(&mesh).unwrap();
        let stiffness = space
            .assemble(&mesh, 5, |q, k: &mut [[f64; 10]; 10]| {
                q.add(k, |v, u| v.gradient.dot(&u.gradient));
            })
            .unwrap();
        let ours = space.stiffness(&mesh).unwrap();
        assert!(difference(parts(&ours), parts(&stiffness)) < ROUNDING);

        let mass = space
            .assemble(&mesh, 5, |q, m: &mut [[f64; 4]; 4]| {
                q.add(m, |v, u| v.value * u.value);
            })
            .unwrap();
        let ours = space.pressure_mass(&mesh).unwrap();
        assert!(difference(parts(&ours), parts(&mass)) < ROUNDING);

        let divergence = space
            .assemble(&mesh, 5, |q, b: &mut [[Vec3; 10]; 4]| {
                q.add(b, |v, u| -v.value * u.gradient);
            })
            .unwrap();
        let ours = space.divergence(&mesh).unwrap();
        let [a, b] = [&ours, &divergence].map(|m| (m.data(), m.indices()));
        assert!(difference(a, b) < ROUNDING);

        let viscous = space
            .assemble(&mesh, 5, |q, k: &mut [[Matrix3<f64>; 10]; 10]| {
                q.add(k, |v, u| {
                    Matrix3::from_diagonal_element(v.gradient.dot(&u.gradient))
                        + u.gradient * v.gradient.transpose()
                });
            })
            .unwrap();
        let ours = space.viscous_block(&mesh).unwrap();
        assert!(difference(parts(&ours), parts(&interleaved(&viscous).unwrap())) < ROUNDING);
    }
}

#[test]
fn a_mixed_form_and_its_adjoint_are_transposes() {
    for mesh in meshes() {
        let space = TaylorHood::new(&mesh).unwrap();
        let wide = space
            .assemble(&mesh, 5, |q, b: &mut [[f64; 10]; 4]| {
                q.add(b, |v, u| v.value * u.gradient.x + v.gradient.y * u.value);
            })
            .unwrap();
        let tall = space
            .assemble(&mesh, 5, |q, b: &mut [[f64; 4]; 10]| {
                q.add(b, |v, u| u.value * v.gradient.x + u.gradient.y * v.value);
            })
            .unwrap();
        assert_eq!(tall.shape(), (mesh.n_points(), mesh.n_vertices()));
        // The same products in the same order.
        assert_eq!(wide.transpose_into().to_csr(), tall);
    }
}

/// `∫ ∂_k u = ∮ u n_k` on each cell, for `u` in the space: exact rules on affine cells, and on
/// curved ones, where the Jacobian cancels (degree 4 in cells, 2 + 4 on facets).
#[test]
fn the_gauss_theorem_holds_between_cells_and_facets() {
    for mesh in meshes() {
        let u = noise_vector(3, mesh.n_points());
        let inside = integrate(&mesh, 4, |q| q.gradient(&u)).unwrap();
        let mut boundary = Vec3::zeros();
        for tag in 0..mesh.tags().len() as u16 {
            boundary += integrate_facets(&mesh, tag, 6, |f| {
                assert_eq!(f.tag, tag);
                f.point.value(&u) * f.normal
            })
            .unwrap();
        }
        let size: f64 = u.iter().map(|u| u.abs()).sum();
        assert!(
            (inside - boundary).norm() < 1e-14 * size,
            "{inside} {boundary}"
        );

        // The same for matrices and loads: ∫ (v ∂_k u + u ∂_k v) = ∮ u v n_k, tested with v = 1.
        let space = TaylorHood::new(&mesh).unwrap();
        let (mut sum, mut load) = (Vec3::zeros(), Vec3::zeros());
        for tag in 0..mesh.tags().len() as u16 {
            let matrix = space
                .assemble_facets(&mesh, tag, 6, |f, m: &mut [[Vec3; 10]; 4]| {
                    let normal = f.normal;
                    f.point.add(m, |v, u| v.value * u.value * normal);
                })
                .unwrap();
            for (entry, (_, j)) in matrix.iter() {
                sum += Vec3::from(*entry) * u[j as usize];
            }
            let loads = assemble_facet_load(&mesh, tag, 6, |f, load: &mut [Vec3; 10]| {
                let normal = f.normal;
                f.point.add_load(load, |v| v.value * normal);
            });
            for (load_j, u) in loads.unwrap().iter().zip(&u) {
                load += load_j * *u;
            }
        }
        assert!((sum - boundary).norm() < 1e-14 * size);
        assert!((load - boundary).norm() < 1e-14 * size);
    }
}

#[test]
fn loads_and_fields_of_any_number_of_components_agree() {
    let [mesh, _] = meshes();
    let force = |x: Vec3| [x.x * x.y, 1.0 - x.z, 2.0];
    let vectors = load_vector(&mesh, |x| Vec3::from(force(x))).unwrap();
    let arrays = load_vector(&mesh, force).unwrap();
    let numbers = load_vector(&mesh, |x| force(x)[0]).unwrap();
    for ((vector, array), number) in vectors.iter().zip(&arrays).zip(&numbers) {
        assert_eq!(<[f64; 3]>::from(*vector), *array);
        assert_eq!(vector.x, *number);
    }
    let linear = assemble_load(&mesh, 6, |q, load: &mut [f64; 4]| {
        let f = force(q.position())[0];
        q.add_load(load, |v| v.value * f);
    });
    // Both test spaces contain the constant 1.
    let sums = [linear.unwrap(), numbers].map(|load| load.iter().sum::<f64>());
    assert!((sums[0] - sums[1]).abs() < 1e-12 * sums[0].abs().max(1.0));

    let field = noise_field(8, mesh.n_points());
    let arrays: Vec<[f64; 3]> = field.iter().map(|&v| v.into()).collect();
    let exact = |x: Vec3| (Vec3::new(x.y, 0.0, x.x * x.z), Matrix3::identity());
    let by_rows = |m: Matrix3<f64>| [0, 1, 2].map(|c| [0, 1, 2].map(|k| m[(c, k)]));
    let of_arrays = |x: Vec3| (exact(x).0.into(), by_rows(exact(x).1));
    let a = field_error(&mesh, &field, exact).unwrap();
    let b = field_error(&mesh, &arrays, of_arrays).unwrap();
    assert!((a.l2 / b.l2 - 1.0).abs() < 1e-14);
    assert!((a.h1_seminorm / b.h1_seminorm - 1.0).abs() < 1e-14);
}

/// A field in the space is reproduced with its gradient at any point of affine and curved cells.
#[test]
fn fields_are_evaluated_at_points() {
    let mesh = curved_shell(2, 3.0);
    let linear = |x: Vec3| Vec3::new(x.x - 2.0 * x.y, x.z, 1.0 + x.y);
    let gradient = Matrix3::new(1.0, -2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0);
    let field = interpolate::<_, 10>(&mesh, linear).unwrap();
    let points = [Vec3::new(1.5, 0.2, 0.1), Vec3::new(-0.3, 2.2, 1.0)];
    for (x, found) in points.iter().zip(evaluate(&mesh, &field, &points).unwrap()) {
        assert!((found.0 - linear(*x)).norm() < 1e-12);
        assert!((found.1 - gradient).norm() < 1e-12);
    }
    let error = evaluate(&mesh, &field, &[points[0], Vec3::zeros()]).unwrap_err();
    assert!(
        matches!(error, FemError::OutsideMesh { index: 1, .. }),
        "{error}"
    );
}

/// Two coupled components with a solution in the space: `-Δu + (u - w) = f`, `-Δw + (w - u) = g`.
#[test]
fn a_system_of_two_components_reproduces_quadratics() {
    let mesh = random_affine(2, 6);
    let space = TaylorHood::new(&mesh).unwrap();
    let blocks = space
        .assemble(&mesh, 4, |q, m: &mut [[[[f64; 2]; 2]; 10]; 10]| {
            q.add(m, |v, u| {
                let (k, m) = (v.gradient.dot(&u.gradient), v.value * u.value);
                [[k + m, -m], [-m, k + m]]
            });
        })
        .unwrap();
    let exact = |x: Vec3| [x.x * x.x - x.y, x.y * x.z];
    let load = load_vector(&mesh, |x| {
        let [u, w] = exact(x);
        [u - w - 2.0, w - u]
    });
    let expected = interpolate::<_, 10>(&mesh, exact).unwrap();
    let condition = DirichletCondition::on_tags(&mesh, &[0, 1]).unwrap();
    let (a, b) = condition
        .reduce(&interleaved(&blocks).unwrap(), &load.unwrap(), &expected)
        .unwrap();
    // The residual of the interpolant is rounding.
    let values = condition.restrict(&expected).unwrap();
    let size = b.iter().fold(0.0, |size: f64, b| size.max(b.abs()));
    for (row, b) in a.outer_iterator().zip(&b) {
        assert!((row.iter().map(|(j, a)| a * values[j]).sum::<f64>() - b).abs() < 1e-12 * size);
    }
    let mut field = expected.clone();
    condition.expand(&values, &mut field).unwrap();
    assert_eq!(field, expected);
}

#[test]
fn blocks_stored_by_columns_give_the_same_numbers() {
    let blocks = CsMatI::<[[f64; 3]; 3], u32, usize>::new(
        (2, 2),
        vec![0, 2, 3],
        vec![0, 1, 1],
        [1.0, 2.0, 3.0]
            .map(|s| std::array::from_fn(|c| std::array::from_fn(|d| s + (3 * c + d) as f64 / 9.0)))
            .to_vec(),
    );
    let numbers = interleaved(&blocks).unwrap();
    assert_eq!(numbers.shape(), (6, 6));
    assert_eq!(Ok(numbers), interleaved(&blocks.to_csc()));
    let wide = CsMatI::<[[f64; 3]; 3], u32, usize>::zero((1, 1 << 31));
    assert!(matches!(interleaved(&wide), Err(FemError::TooLarge { .. })));
}

#[test]
fn wrong_input_of_forms_is_an_error() {
    let (mesh, other) = (cube(2), cube(3));
    let space = TaylorHood::new(&mesh).unwrap();
    let assemble = |mesh: &TetMesh, degree, value: &(dyn Fn(usize, &[f64]) -> f64 + Sync)| {
        let nodal = vec![1.0; mesh.n_points()];
        space.assemble(mesh, degree, |q, m: &mut [[f64; 4]; 4]| {
            let value = value(q.cell, &nodal);
            q.add(m, |_, _| value);
        })
    };
    let error = assemble(&other, 2, &|_, _| 1.0).unwrap_err();
    assert!(matches!(error, FemError::OtherMesh { .. }));
    let error = assemble(&mesh, 9, &|_, _| 1.0).unwrap_err();
    assert!(matches!(
        error,
        FemError::Degree {
            degree: 9,
            largest: 8
        }
    ));
    let error = assemble(&mesh, 2, &|cell, _| if cell < 7 { 1.0 } else { f64::NAN }).unwrap_err();
    assert!(
        matches!(error, FemError::NotFiniteInCell { cell: 7, .. }),
        "{error}"
    );

    // Nodal fields of the wrong length, in every kind of integral.
    let refused = |found: Option<FemError>| {
        let found = found.expect("an error");
        assert!(
            matches!(found, FemError::NotFiniteInCell { cell: 0.., .. }),
            "{found}"
        );
    };
    let short = vec![Vec3::x(); 5];
    refused(integrate(&mesh, 2, |q| q.value(&short)).err());
    refused(integrate(&mesh, 2, |q| q.gradient(&short)).err());
    refused(integrate_facets(&mesh, 0, 2, |f| f.point.value(&short)).err());
    let load = |q: &fem::PointValues<'_>, load: &mut [Vec3; 10]| {
        let value = q.value(&short);
        q.add_load(load, |v| v.value * value);
    };
    refused(assemble_load(&mesh, 2, load).err());
    refused(assemble_facet_load(&mesh, 0, 2, |f, l: &mut [Vec3; 10]| load(&f.point, l)).err());
    let robin = |tag, value: f64| {
        space.assemble_facets(&mesh, tag, 2, |f, m: &mut [[f64; 4]; 4]| {
            f.point.add(m, |v, u| value * v.value * u.value);
        })
    };
    refused(robin(0, f64::NAN).err());
    let unknown = FemError::EmptyTag { tag: 6, n_tags: 6 };
    assert_eq!(robin(6, 1.0).unwrap_err(), unknown);
    assert_eq!(integrate_facets(&mesh, 6, 2, |_| 1.0).unwrap_err(), unknown);
    assert_eq!(
        DirichletCondition::on_tags(&mesh, &[0, 6]).err(),
        Some(unknown)
    );
    assert!(interpolate::<_, 4>(&mesh, |x| 1.0 / x.x).is_err());
    assert!(evaluate(&mesh, &short, &[]).is_err());
    assert!(field_error(&mesh, &short, |x| (x, Matrix3::identity())).is_err());
    let condition = DirichletCondition::on_boundary(&mesh);
    let k = space.stiffness(&mesh).unwrap();
    assert!(condition.reduce(&k, &short, &short).is_err());
}

#[test]
fn forms_know_the_cell_and_its_region() {
    let mut tets = LinearTets::cube(2);
    tets.regions.names = vec!["lower".into(), "upper".into()];
    let is_upper =
        |tet: &[u32; 4]| tet.iter().map(|&v| tets.points[v as usize].z).sum::<f64>() > 2.0;
    tets.regions.of_cells = tets
        .tets
        .iter()
        .map(|tet| u16::from(is_upper(tet)))
        .collect();
    let mesh = TetMesh::straight(tets).unwrap();
    let volumes = integrate(&mesh, 0, |q| {
        let mut volumes = [0.0; 2];
        volumes[usize::from(q.region().unwrap())] = 1.0;
        volumes
    });
    assert!(
        volumes
            .unwrap()
            .iter()
            .all(|volume| (volume - 0.5).abs() < 1e-14)
    );
    let unnamed = integrate(&cube(1), 0, |q| f64::from(u8::from(q.region().is_none())));
    assert!((unnamed.unwrap() - 1.0).abs() < 1e-14);
}
