//! Tables over shapes whose values depend on more than the shape.

use design::{StrokeLimits, gait_totals, tabulate};
use models::TablePart;
use scene::{Document, Scene};
use swimmer::{Method, choose, simulate};

const THREE_SPHERES: &str = include_str!("../../../swimmer/templates/three-sphere.toml");

/// In a ball the velocities depend on the place of the swimmer. The table holds it, and what that
/// changes is part of its error bar.
#[test]
fn tables_in_a_ball_have_an_error_bar_for_the_place() {
    for radius in [20, 40] {
        let radius = format!("domain.radius={radius}");
        let mut document = Document::parse(THREE_SPHERES, "scene.toml".as_ref()).unwrap();
        for assignment in ["model.kind=\"multipole\"", "domain.kind=\"ball\"", &radius] {
            document.set(assignment).unwrap();
        }
        let scene = Scene::from_document(document).unwrap();
        let limits = StrokeLimits::from_scene(&scene).unwrap();
        let table = tabulate(&scene, &limits, 1e-5, (None, TablePart::Whole), &mut ())
            .unwrap()
            .geometry;
        let (totals, _) = gait_totals(&scene, &limits, &table).unwrap().unwrap();
        let mut model = choose(&scene).unwrap().model;
        let run = simulate(&scene, model.as_mut(), Method::Collocation, &mut ()).unwrap();
        let found = totals.displacement.x;
        // Four phases in which an arm changes by 4.
        let bar = 16.0 * (table.errors().0 + table.errors().1 + table.position_error());
        let error = (found - run.displacement[0].x).abs();
        assert!(error <= bar, "{radius}: {found} {error:e} {bar:e}");
        // Without the place, the bar would be wrong; with it, it is not far too large.
        assert!(error > 16.0 * (table.errors().0 + table.errors().1));
        assert!(bar <= 10.0 * error, "{radius}: {error:e} {bar:e}");
    }
}
