//! Runs in periodic boxes.

use scene::Scene;
use swimmer::{SwimError, choose};
use testkit::within;

/// Four settling spheres of two sizes, one of them across a face of the box, all shifted.
fn settling(shift: [f64; 3]) -> Scene {
    let places = [
        [0.0, 0.0, 0.0],
        [2.5, 0.3, 1.0],
        [4.4, 3.6, -0.5],
        [-2.0, -3.0, 3.8],
    ];
    let bodies = places.iter().enumerate().map(|(number, place)| {
        let radius = [1.0, 0.7, 0.9, 0.5][number];
        let [x, y, z] = [0, 1, 2].map(|k| place[k] + shift[k]);
        format!(
            "[[bodies]]\nname = \"{number}\"\nradius = {radius:?}\n\
             position = [{x:?}, {y:?}, {z:?}]\nforce = [0, 0, -10]\n"
        )
    });
    let bodies: String = bodies.collect();
    let text = format!(
        "domain = {{ kind = \"periodic\", size = [9, 8, 10] }}\nmodel.kind = \"rpy\"\n\
         gait.phases = [{{ duration = 4 }}]\n\
         contact = {{ range = 0.05, strength = 5 }}\n{bodies}"
    );
    Scene::parse(&text).unwrap()
}

#[test]
fn a_whole_run_does_not_depend_on_the_place_of_the_box() {
    let run = |shift| {
        let run = swimmer::run_without_files(settling(shift), &mut ()).unwrap();
        run.outcome
    };
    let (there, here) = (run([123.4, -56.7, 0.89]), run([0.0; 3]));
    // A sphere alone would sink by 10/(6π) 4 = 2.1 and more.
    assert!(here.displacement.iter().all(|moved| moved.norm() > 0.5));
    for (there, here) in there.displacement.iter().zip(&here.displacement) {
        // Positions have 2e-14 of rounding, which differences of steps by their tolerance exceed.
        within(
            (there - here).norm(),
            1e-8,
            "rounding of positions, along the run",
        );
    }
}

#[test]
fn a_sphere_that_meets_an_image_of_another_one_is_reported() {
    // Towards -x, away from the fixed sphere and through the face to its image at -10.
    let text = r#"
        domain = { kind = "periodic", size = [10, 10, 10] }
        model.kind = "rpy"
        bodies = [
            { name = "pulled", radius = 0.2, position = [-2, 0, 0], force = [-1, 0, 0] },
            { name = "fixed", radius = 0.2, position = [2, 0, 0], fixed = true },
        ]
        gait.phases = [{ duration = 100 }]
    "#;
    let run = swimmer::run_without_files(Scene::parse(text).unwrap(), &mut ()).unwrap();
    match run.completed() {
        Err(SwimError::Collision { problem, .. }) => {
            assert!(problem.contains("'pulled' and 'fixed' touch"), "{problem}");
        }
        other => panic!("{:?}", other.map(|run| run.outcome.displacement)),
    }
}

#[test]
fn auto_chooses_expansions_where_they_take_seconds_and_refuses_what_it_cannot_do() {
    let scene = |shape: &str| {
        let text = format!(
            "domain = {{ kind = \"periodic\", size = [9, 9, 9] }}\n\
             bodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0], {shape} }}]"
        );
        Scene::parse(&text).unwrap()
    };
    let chosen = |scene: &Scene| choose(scene).unwrap().model.name();
    assert_eq!(chosen(&scene("force = [1, 0, 0]")), "multipole");
    let squirmer = scene("slip = { b1 = 1, axis = [1, 0, 0] }");
    assert_eq!(chosen(&squirmer), "multipole");
    let long = "domain = { kind = \"periodic\", size = [9, 9, 9] }\n\
        gait = { phases = [{ duration = 1 }], cycles = 10000 }\n\
        bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0], force = [1, 0, 0] },\n\
        { name = \"b\", radius = 1, position = [2.5, 0, 0] }]";
    assert_eq!(chosen(&Scene::parse(long).unwrap()), "rpy");
    let spheroid = "shape = \"spheroid\", half_length = 2, axis = [1, 0, 0]";
    let error = choose(&scene(spheroid)).err().unwrap().to_string();
    let words = "other than rigid spheres";
    assert!(
        error.contains(words) && error.contains("unbounded"),
        "{error}"
    );
    for kind in ["axisymmetric", "fem"] {
        let text = format!(
            "domain = {{ kind = \"periodic\", size = [9, 9, 9] }}\nmodel.kind = \"{kind}\"\n\
             bodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0], force = [1, 0, 0] }}]"
        );
        let error = choose(&Scene::parse(&text).unwrap())
            .err()
            .unwrap()
            .to_string();
        assert!(error.contains("periodic"), "{kind}: {error}");
    }
}

/// Images of a repulsion whose range is that of the box are too many to sum.
#[test]
fn a_repulsion_as_wide_as_the_box_is_refused() {
    let text = "domain = { kind = \"periodic\", size = [10, 9, 10] }\n\
                contact = { range = 1, strength = 1 }\n\
                bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0] }]";
    let error = Scene::parse(text).unwrap_err().to_string();
    assert!(
        error.contains("contact.range must be at most a tenth"),
        "{error}"
    );
}

/// A swimmer of three spheres that is held by its first one pumps the fluid through the box: the
/// mean flow over its stroke, without a pressure gradient, has a bar that contains its error.
#[test]
fn a_tethered_swimmer_drives_a_mean_flow_through_the_box() {
    let scene = |tolerance: f64| {
        Scene::parse(&format!(
            "domain = {{ kind = \"periodic\", size = [40, 15, 15] }}\n\
             background = {{ kind = \"pressure-gradient\", pressure_gradient = [0, 0, 0] }}\n\
             model = {{ kind = \"rpy\", tolerance = {tolerance:?}, estimates = \"off\" }}\n\
             [[bodies]]\nname = \"tether\"\nradius = 1\nposition = [-6, 0, 0]\nfixed = true\n\
             [[bodies]]\nname = \"centre\"\nradius = 1\nposition = [0, 0, 0]\n\
             [[bodies]]\nname = \"right\"\nradius = 1\nposition = [6, 0, 0]\n\
             [[links]]\nname = \"a\"\nbody = \"tether\"\nto = \"centre\"\n\
             [[links]]\nname = \"b\"\nbody = \"right\"\nto = \"centre\"\n\
             [[gait.phases]]\nlink = \"a\"\nlength = 3.5\n\
             [[gait.phases]]\nlink = \"b\"\nlength = 3.5\n\
             [[gait.phases]]\nlink = \"a\"\nlength = 6\n\
             [[gait.phases]]\nlink = \"b\"\nlength = 6\n"
        ))
        .unwrap()
    };
    let found = |tolerance: f64| {
        let run = swimmer::run_without_files(scene(tolerance), &mut ()).unwrap();
        run.outcome.mean_flow().unwrap()
    };
    let (coarse, fine) = (found(0.1), found(1e-7));
    assert_eq!(fine.flow.pressure_gradient, nalgebra::Vector3::zeros());
    let [bar, remaining] = [coarse, fine].map(|mean| mean.error.integration.unwrap());
    let error = (coarse.flow.velocity - fine.flow.velocity).norm();
    within(error, bar + remaining, "the bars of the integration");
    // It pumps along x, by far more than its bar.
    let flow = fine.flow.velocity;
    assert!(flow.x.abs() > 100.0 * remaining, "{flow} {remaining:e}");
    within(flow.yz().norm(), 1e-12, "rounding on an axis of symmetry");
    let json = swimmer::output::summary_json(
        &scene(0.1),
        "rpy",
        &[],
        &swimmer::run_without_files(scene(0.1), &mut ())
            .unwrap()
            .outcome,
        0.0,
    );
    let mean = &json["mean_flow"];
    assert_eq!(mean["velocity"][0].as_f64(), Some(coarse.flow.velocity.x));
    assert_eq!(mean["velocity_error"]["integration"].as_f64(), Some(bar));
    assert!(mean["pressure_gradient_error"].is_null());
}
