//! Quality of meshes: known numbers, and the same bits for any number of threads.

use crate::shapes::{ball, curved_ball};
use mesh::{LinearTets, Quality, TetMesh, dihedral_angles, mean_ratio};

#[test]
fn kuhn_cube_has_its_known_angles_and_quality() {
    let quality = TetMesh::straight(LinearTets::cube(4)).unwrap().quality();
    // Edges 1, 1, 1, sqrt 2, sqrt 2, sqrt 3 and volume 1/6 give q = 12 (1/2)^(2/3) / 10; the
    // dihedral angles are 45, 60 and 90 degrees.
    let q = 1.2 * 0.25_f64.cbrt();
    assert!((quality.min_quality - q).abs() < 1e-14);
    assert!((quality.mean_quality - q).abs() < 1e-14);
    assert!((quality.min_dihedral - 45.0).abs() < 1e-12);
    assert!((quality.max_dihedral - 90.0).abs() < 1e-12);
    assert_eq!((quality.min_jacobian, quality.cells), (1.0, 384));
}

#[test]
fn linear_and_quadratic_meshes_agree_on_the_shape() {
    let linear = ball(4).quality();
    let quadratic = curved_ball(4).quality();
    // The order of cells and of their vertices differs, and so does the rounding of sums and
    // products.
    assert!((linear.mean_quality - quadratic.mean_quality).abs() < 1e-13);
    assert!((linear.min_quality - quadratic.min_quality).abs() < 1e-13);
    assert!((linear.min_dihedral - quadratic.min_dihedral).abs() < 1e-11);
    assert_eq!(linear.min_jacobian, 1.0);
    assert!(quadratic.min_jacobian < 1.0 && quadratic.min_jacobian > 0.0);
    let worst = quadratic.worst_cell;
    assert_eq!(
        curved_ball(4).scaled_jacobian(worst),
        quadratic.min_jacobian
    );
}

#[test]
fn an_inverted_tet_has_a_negative_quality() {
    let mut tets = LinearTets::cube(2);
    tets.tets[13].swap(1, 2);
    let quality = tets.quality();
    assert!(quality.min_quality < 0.0);
    assert_eq!((quality.min_jacobian, quality.worst_cell), (-1.0, 13));
}

#[test]
fn quality_is_bitwise_the_same_for_any_number_of_threads() {
    let mesh = curved_ball(8);
    let with = |threads| -> Quality {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| mesh.quality())
    };
    let one = with(1);
    for threads in [2, 3, 7] {
        assert_eq!(with(threads), one);
    }
}

#[test]
fn meshes_are_bitwise_the_same_for_any_number_of_threads() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| curved_ball(6))
    };
    assert_eq!(with(1), with(3));
}

/// Cells are measured in chunks of 1024, of which the first has the worst cell.
#[test]
fn extremes_and_mean_of_many_cells_are_those_of_all_chunks() {
    let mut tets = LinearTets::cube(8);
    let first = tets.tets[0][3] as usize;
    let centre = nalgebra::Vector3::repeat(0.5);
    let towards_centre = centre - tets.points[first];
    tets.points[first] += 0.03 * towards_centre;
    let (found, cells) = (tets.quality(), tets.tets.len());
    assert!(cells > 2048 && found.cells == cells);
    let corners = |cell: &[u32; 4]| cell.map(|vertex| tets.points[vertex as usize]);
    let ratios: Vec<f64> = tets
        .tets
        .iter()
        .map(|cell| mean_ratio(corners(cell)))
        .collect();
    let angles: Vec<f64> = tets
        .tets
        .iter()
        .flat_map(|cell| dihedral_angles(corners(cell)))
        .collect();
    let min = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let max = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert_eq!(found.min_quality, min(&ratios));
    assert_eq!(
        (found.min_dihedral, found.max_dihedral),
        (min(&angles), max(&angles))
    );
    let mean = ratios.iter().sum::<f64>() / cells as f64;
    assert!((found.mean_quality - mean).abs() < 1e-13);
    // The last chunk alone has the quality of the undisturbed cube.
    assert!(found.min_quality < min(&ratios[2048..]) && found.max_dihedral > 90.5);
}
