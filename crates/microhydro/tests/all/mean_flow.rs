//! Mean flows through periodic boxes in which the total force is given.

use microhydro::nalgebra::{DMatrix, DVector, Vector3};
use microhydro::{
    HydroError, Linkage, LinkedMotion, LinkedSpheres, Mobility, PointMobility, PointModel, Spheres,
};

use super::{free, held, total_force};

/// Four spheres in a box with different edges, one of them across a face.
fn some(shift: Vector3<f64>) -> (Spheres, Vector3<f64>) {
    let centres = [
        [0.1, 0.3, 0.2],
        [8.8, 0.4, 3.5],
        [3.1, 4.2, 7.7],
        [-5.0, 12.3, 2.9],
    ];
    let centres = centres.map(|x| Vector3::from(x) + shift);
    let spheres = Spheres::new(centres.to_vec(), vec![1.0, 0.7, 1.3, 0.5]).unwrap();
    (spheres, Vector3::new(9.0, 8.0, 11.0))
}

/// The first sphere is held, the second one moves at a given velocity and turns freely, the last
/// two are a pair that moves without turning, with a dashpot between them along x and a load.
fn linkages(scale: f64) -> Vec<Linkage> {
    let mut offset = DVector::zeros(6);
    offset[1] = 0.3 * scale;
    let driven = Linkage {
        spheres: vec![1],
        basis: DMatrix::from_fn(6, 3, |row, column| f64::from(u8::from(row == 3 + column))),
        offset,
        load: DVector::zeros(3),
        damping: DMatrix::zeros(3, 3),
    };
    // Translations of both, and of the second one against the first along x.
    let mut basis = DMatrix::zeros(12, 4);
    for axis in 0..3 {
        (basis[(axis, axis)], basis[(6 + axis, axis)]) = (1.0, 1.0);
    }
    basis[(6, 3)] = 1.0;
    let mut damping = DMatrix::zeros(4, 4);
    damping[(3, 3)] = 5.0;
    let pair = Linkage {
        spheres: vec![2, 3],
        basis,
        offset: DVector::zeros(12),
        load: scale * DVector::from_vec(vec![0.5, -2.0, 1.0, 3.0]),
        damping,
    };
    vec![held(0, DVector::zeros(6)), driven, pair]
}

fn solve(mobility: &PointMobility, scale: f64, total: Vector3<f64>) -> LinkedMotion {
    let linked = LinkedSpheres::new(mobility, linkages(scale)).unwrap();
    linked
        .with_total_force(total)
        .unwrap()
        .solve(1e-12)
        .unwrap()
}

const TOTAL: Vector3<f64> = Vector3::new(-7.0, 2.0, 4.0);

#[test]
fn forces_have_the_given_sum_and_the_motion_is_that_in_the_mean_flow_found() {
    let (spheres, size) = some(Vector3::zeros());
    let mobility = PointMobility::periodic(PointModel::Rpy, &spheres, &size).unwrap();
    let found = solve(&mobility, 1.0, TOTAL);
    assert!((total_force(&found.forces) - TOTAL).norm() < 1e-12 * TOTAL.norm());
    // In this flow spheres move relative to it.
    let mut given = linkages(1.0);
    for linkage in &mut given {
        for sphere in 0..linkage.spheres.len() {
            let mut rows = linkage.offset.fixed_rows_mut::<3>(6 * sphere);
            rows -= found.mean_flow;
        }
    }
    let in_flow = LinkedSpheres::new(&mobility, given)
        .unwrap()
        .solve(1e-12)
        .unwrap();
    let change = (&in_flow.forces - &found.forces).norm() / found.forces.norm();
    // residuals times the condition of the mobility
    assert!(change < 1e-9, "{change:e}");
    let coordinates = in_flow.coordinates.iter().zip(&found.coordinates);
    for (given, found) in coordinates {
        assert!((given - found).norm() < 1e-9);
    }
    // They are the velocities by the forces: M f + u = S v + W.
    let [velocities, _] = mobility.product(&found.forces, &DVector::zeros(0)).unwrap();
    let held = velocities.fixed_rows::<3>(0) + found.mean_flow;
    assert!(held.norm() < 1e-10, "{held}");
}

#[test]
fn the_mean_flow_is_linear_and_does_not_depend_on_the_place_of_the_box() {
    let (spheres, size) = some(Vector3::zeros());
    let mobility = PointMobility::periodic(PointModel::Rpy, &spheres, &size).unwrap();
    let flow = |scale: f64, total| solve(&mobility, scale, total).mean_flow;
    let all = flow(1.0, TOTAL);
    let parts = flow(1.0, Vector3::zeros()) + flow(0.0, TOTAL);
    assert!((all - parts).norm() < 1e-10 * all.norm());
    assert!((flow(2.0, 2.0 * TOTAL) - 2.0 * all).norm() < 1e-10 * all.norm());
    let (moved, size) = some(Vector3::new(2.3, -7.1, 0.4));
    let mobility = PointMobility::periodic(PointModel::Rpy, &moved, &size).unwrap();
    let moved = solve(&mobility, 1.0, TOTAL).mean_flow;
    assert!((moved - all).norm() < 1e-10 * all.norm());
}

#[test]
fn a_total_force_on_free_spheres_is_refused() {
    let (spheres, size) = some(Vector3::zeros());
    let mobility = PointMobility::periodic(PointModel::Rpy, &spheres, &size).unwrap();
    let linkages = (0..4).map(|sphere| free(sphere, DVector::zeros(6)));
    let linked = LinkedSpheres::new(&mobility, linkages.collect()).unwrap();
    let refused = linked.with_total_force(TOTAL).err();
    assert_eq!(refused, Some(HydroError::NothingHeld));
}
