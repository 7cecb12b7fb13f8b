//! Accuracy and cost of the integration methods.

use approx::assert_abs_diff_eq;
use swimmer::Method;

use crate::strokes::{FREE, follow, over_wall};
use crate::support::{Tensor, run, scene, three_spheres};

#[test]
fn collocation_meets_its_tolerance_and_the_error_bar_holds() {
    for text in [
        |tolerance: f64| three_spheres(&format!("model.tolerance = {tolerance}"), FREE),
        |tolerance: f64| over_wall(20.0, tolerance),
        |tolerance: f64| over_wall(5.0, tolerance),
    ] {
        let exact = follow(&text(1e-11)).net(1);
        for tolerance in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
            let run = follow(&text(tolerance));
            let error = (run.net(1) - exact).norm();
            // The error bar of a leg refers to the largest displacement of any body, so the sum
            // over the legs bounds the error of the net displacement.
            assert!(
                error <= run.integration_error(),
                "{error:e} > {:e}",
                run.integration_error()
            );
            assert!(
                error <= tolerance * exact.norm(),
                "{error:e} at {tolerance:e}"
            );
            assert!(run.integration_error() <= tolerance * exact.norm());
        }
    }
}

#[test]
fn a_stroke_takes_24_solves_to_1e_3_and_40_to_1e_4() {
    // Orders of one to three and of one to four points on each of four legs.
    for (tolerance, solves) in [(1e-3, 24), (1e-4, 40)] {
        let text = format!("model.tolerance = {tolerance}");
        assert!(follow(&three_spheres(&text, FREE)).solves() <= solves);
        assert!(follow(&over_wall(20.0, tolerance)).solves() <= solves);
    }
}

#[test]
fn euler_is_of_first_order_where_the_position_matters() {
    let exact = follow(&over_wall(5.0, 1e-10)).net(1);
    let error = |steps| {
        let scene = scene(&over_wall(5.0, 1e-3));
        (run(&scene, Tensor::Rpy, Method::Euler { steps })
            .unwrap()
            .net(1)
            - exact)
            .norm()
    };
    // Halving the step halves the error, up to the next order: 1/40 relative at 20 steps a leg.
    assert_abs_diff_eq!(error(20) / error(40), 2.0, epsilon = 0.1);
    assert!(error(40) > 100.0 * (follow(&over_wall(5.0, 1e-3)).net(1) - exact).norm());
}

#[test]
fn the_runge_kutta_pair_meets_its_tolerance_and_its_error_bar_holds() {
    for text in [
        |tolerance: f64| three_spheres(&format!("model.tolerance = {tolerance}"), FREE),
        |tolerance: f64| over_wall(5.0, tolerance),
    ] {
        let exact = follow(&text(1e-11)).net(1);
        let mut solves = 0;
        for tolerance in [1e-2, 1e-4, 1e-6, 1e-8] {
            let run = run(&scene(&text(tolerance)), Tensor::Rpy, Method::RungeKutta).unwrap();
            let error = (run.net(1) - exact).norm();
            // The estimate is the error of the less accurate formula and bounds that of the other.
            assert!(
                error <= run.integration_error(),
                "{error:e} at {tolerance:e}"
            );
            assert!(
                error <= tolerance * exact.norm(),
                "{error:e} at {tolerance:e}"
            );
            assert!(run.integration_error() <= tolerance * exact.norm());
            assert!(run.solves() >= solves);
            solves = run.solves();
        }
        // Order five: a tolerance smaller by a factor of a million needs 16 times as many steps.
        assert!(solves < 1000, "{solves}");
    }
}
