//! The mobility of bodies: symmetric and positive definite, as reciprocity and dissipation demand.

use models::InstantaneousSolution;
use nalgebra::{DMatrix, DVector};

use testkit::{SceneText, start, within};

use crate::scenes::COARSE_SETTINGS;

/// Two unequal spheres off the axis of their ball with the unit load number `k`, six per body.
fn loaded(k: usize) -> SceneText {
    let mut load = [0.0; 6];
    load[k % 6] = 1.0;
    let (force, torque) = load.split_at(3);
    SceneText::new()
        .sphere("small", 1.0, [-2.0, 0.5, 1.0])
        .sphere("large", 1.5, [2, 0, -1])
        .ball(8.0)
        .set(&COARSE_SETTINGS)
        .with(&format!("bodies[{}].force", k / 6), format!("{force:?}"))
        .with(&format!("bodies[{}].torque", k / 6), format!("{torque:?}"))
}

#[test]
#[ignore = "slow: 4 s"]
fn mobility_is_symmetric_and_positive_definite() {
    let (mut mobility, mut correction) = (DMatrix::zeros(12, 12), DMatrix::zeros(12, 12));
    let mut tolerance = 0.0_f64;
    for k in 0..12 {
        let corrected = start(&loaded(k).scene());
        let instant = corrected.uncorrected();
        let column = |instant: &InstantaneousSolution| -> DVector<f64> {
            let columns = (instant.bodies.iter()).flat_map(|b| [b.velocity, b.angular_velocity]);
            DVector::from_vec(columns.flat_map(|v| [v.x, v.y, v.z]).collect())
        };
        mobility.set_column(k, &column(&instant));
        correction.set_column(k, &(column(&corrected) - column(&instant)));
        // The system is symmetric and its right-hand sides are unit vectors, so
        // M_ij - M_ji = x_i . r_j - x_j . r_i with |x| <= sqrt(dofs) / 4 pi (no velocity exceeds
        // 1 / 6 pi, no pressure 3/2 of that).
        let largest = (instant.dofs.total as f64).sqrt() / (4.0 * std::f64::consts::PI);
        tolerance = tolerance.max(2.0 * instant.solver.true_relative_residual * largest);
    }
    let asymmetry = (&mobility - mobility.transpose()).amax();
    within(asymmetry, tolerance, "two residuals");
    // So are the corrections.
    let asymmetry = (&correction - correction.transpose()).amax();
    within(
        asymmetry,
        0.05 * correction.amax(),
        "the iteration of the corrections",
    );
    // The off-diagonal entries do not vanish.
    assert!(mobility[(0, 6)].abs() > 1e-3);

    let eigenvalues = mobility.clone().symmetric_eigenvalues();
    // The smallest mobility is the rotation of the larger sphere, 1 / (8 pi 1.5^3), reduced by the
    // walls and the neighbour.
    assert!(
        eigenvalues.min() > 0.5 / (8.0 * std::f64::consts::PI * 1.5_f64.powi(3)),
        "{eigenvalues}"
    );
    let resistance = mobility.try_inverse().unwrap();
    let asymmetry = (&resistance - resistance.transpose()).amax();
    within(
        asymmetry,
        tolerance * resistance.amax().powi(2) * 12.0,
        "that of the mobility",
    );
    assert!(resistance.symmetric_eigenvalues().min() > 0.0);
}
