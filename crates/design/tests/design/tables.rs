//! Tables over shapes whose values depend on more than the shape.

use design::{StrokeLimits, gait_totals, tabulate};
use models::TablePart;
use testkit::{run, within};

/// In a ball the velocities depend on the place of the swimmer. The table holds it, and what that
/// changes is part of its error bar.
#[test]
fn tables_in_a_ball_have_an_error_bar_for_the_place() {
    for radius in [20.0, 40.0] {
        let scene = crate::three_sphere()
            .ball(radius)
            .with("model.kind", "multipole")
            .scene();
        let limits = StrokeLimits::from_scene(&scene).unwrap();
        let table = tabulate(&scene, &limits, 1e-5, (None, TablePart::Whole), &mut ());
        let table = table.unwrap().geometry;
        let (totals, _) = gait_totals(&scene, &limits, &table).unwrap().unwrap();
        // Four phases in which an arm changes by 4.
        let bar = 16.0 * (table.errors().0 + table.errors().1 + table.position_error());
        let error = (totals.displacement.x - run(&scene).displacement[0].x).abs();
        within(error, bar, format!("the error bar: {radius}"));
        // Without the place, the bar would be wrong; with it, it is not far too large.
        assert!(error > 16.0 * (table.errors().0 + table.errors().1));
        within(
            bar,
            10.0 * error,
            format!("the bar is not too large: {radius}"),
        );
    }
}
