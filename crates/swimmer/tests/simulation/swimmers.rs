//! Results of each swimmer of a run with several.

use nalgebra::{UnitQuaternion, Vector3};
use swimmer::output::{summary_json, swimmers_csv};
use swimmer::{Outcome, Scene};
use testkit::{resumed_after_one_phase, run, within};

/// Three spheres on the x axis, whose arms contract one after the other, with more keys.
fn three_spheres(model: &str, more: &str) -> Scene {
    let text = format!(
        "model.kind = \"{model}\"\n[[bodies]]\nname = \"left\"\nradius = 1\nposition = [-10, 0, 0]\n\
         [[bodies]]\nname = \"middle\"\nradius = 1\nposition = [0, 0, 0]\n\
         [[bodies]]\nname = \"right\"\nradius = 1\nposition = [10, 0, 0]\n\
         [[links]]\nname = \"a\"\nbody = \"left\"\nto = \"middle\"\n\
         [[links]]\nname = \"b\"\nbody = \"right\"\nto = \"middle\"\n\
         [[gait.phases]]\nlink = \"a\"\nlength = 7\n[[gait.phases]]\nlink = \"b\"\nlength = 7\n\
         [[gait.phases]]\nlink = \"a\"\nlength = 10\n[[gait.phases]]\nlink = \"b\"\nlength = 10\n\
         {more}"
    );
    Scene::parse(&text).unwrap()
}

/// Distance of the copies, and what a swimmer moves another one by over a gait.
///
/// The sphere of an arm moves by three radii in a unit of time, with a force of at most 6π 3; the
/// stresslet of both arms of ten radii is below 1131, its flow at D below 3 S/(8π D²) = 135/D², and
/// the gait takes 4 units.
const FAR: f64 = 1e4;
const BY_OTHERS: f64 = 540.0 / (FAR * FAR);

/// Two copies: turned by a right angle to the y axis, and by a third of a turn about (1, 1, 1).
fn copies() -> (String, [UnitQuaternion<f64>; 2]) {
    let vectors = [
        Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2),
        Vector3::repeat(std::f64::consts::TAU / 3.0 / 3_f64.sqrt()),
    ];
    let [a, b] = vectors.map(|v| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z));
    let text = format!(
        "[[copies]]\nof = \"middle\"\npositions = [[{FAR:?}, 0, 0], [0, 0, {FAR:?}]]\n\
         orientations = [{a}, {b}]\n"
    );
    (text, vectors.map(UnitQuaternion::from_scaled_axis))
}

fn works(outcome: &Outcome, scene: &Scene) -> Vec<f64> {
    let swimmers = outcome.swimmers(scene).into_iter();
    swimmers.map(|swimmer| swimmer.work.unwrap()).collect()
}

#[test]
fn each_of_distant_swimmers_has_the_results_of_a_lone_one() {
    let lone_scene = three_spheres("rpy", "");
    let lone = run(&lone_scene);
    assert!(lone.swimmers(&lone_scene).is_empty());
    assert!(summary_json(&lone_scene, "rpy", &[], &lone, 0.0)["swimmers"].is_null());
    let (copies, rotations) = copies();
    // Bodies that rest relative to each other are no swimmer.
    let sphere = format!(
        "[[bodies]]\nname = \"stone\"\nradius = 1\nposition = [0, {FAR:?}, 0]\n\
         [[bodies]]\nname = \"other\"\nradius = 1\nposition = [0, {:?}, 0]\n\
         [[links]]\nname = \"rod\"\nbody = \"other\"\nto = \"stone\"\n",
        2.0 * FAR
    );
    let scene = three_spheres("rpy", &(copies + &sphere));
    let outcome = run(&scene);
    let swimmers = outcome.swimmers(&scene);
    let names: Vec<&str> = swimmers
        .iter()
        .map(|swimmer| swimmer.name(&scene))
        .collect();
    assert_eq!(names, ["left", "left-2", "left-3"]);
    let turns = [UnitQuaternion::identity(), rotations[0], rotations[1]];
    for (swimmer, turn) in swimmers.iter().zip(turns) {
        assert_eq!(swimmer.bodies.len(), 3);
        let expected = turn * lone.net_vector();
        let bar = swimmer.error_estimate.integration.unwrap();
        let own = lone.error_estimate.integration.unwrap();
        within(
            (swimmer.displacement - expected).norm(),
            BY_OTHERS + bar + own,
            "flow of the others, and both integrations",
        );
        assert!(swimmer.rotation.norm() < BY_OTHERS);
        // Flows of the others do work on the forces of the arms, at most 6π 3 on each sphere.
        let change = 3.0 * 18.0 * std::f64::consts::PI * BY_OTHERS;
        let bars = lone.work_error.integration.unwrap() + outcome.work_error.integration.unwrap();
        within(
            (swimmer.work.unwrap() - lone.work).abs(),
            change + bars,
            "work of a lone swimmer",
        );
        let total = swimmer.error_estimate.total();
        assert!(total > 0.0 && total <= outcome.error_estimate.total());
    }
    let sum: f64 = works(&outcome, &scene).iter().sum();
    within(
        (sum - outcome.work).abs(),
        1e-12 * outcome.work,
        "rounding of sums: the stone does no work",
    );
    let json = summary_json(&scene, "rpy", &[], &outcome, 0.0);
    let second = &json["swimmers"][1];
    assert_eq!(second["name"], "left-2");
    assert_eq!(
        second["bodies"],
        serde_json::json!(["left-2", "middle-2", "right-2"])
    );
    assert_eq!(second["work"], serde_json::json!(swimmers[1].work));
    let y = second["displacement"][1].as_f64().unwrap();
    assert_eq!(y, swimmers[1].displacement.y);
    let csv = swimmers_csv(&scene, &swimmers);
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0].join(" "), "swimmer dx dy dz error rx ry rz work");
    assert_eq!((rows.len(), rows[2][0]), (4, "left-2"));
    let number = |column: usize| rows[2][column].parse::<f64>().unwrap();
    assert_eq!((number(2), number(8)), (y, swimmers[1].work.unwrap()));
    assert_eq!(number(4), swimmers[1].error_estimate.total());
    assert_eq!(number(7), swimmers[1].rotation.z);
}

#[test]
fn the_work_of_swimmers_with_slip_is_known_in_total_only() {
    let scene = Scene::parse(
        "gait.phases = [{ duration = 1 }]\n\
         [[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 0]\nslip = { b1 = 1 }\n\
         [[bodies]]\nname = \"b\"\nradius = 1\nposition = [0, 9, 0]\nslip = { b1 = -1 }\n",
    )
    .unwrap();
    let outcome = run(&scene);
    let swimmers = outcome.swimmers(&scene);
    assert_eq!(swimmers.len(), 2);
    assert!(swimmers.iter().all(|swimmer| swimmer.work.is_none()));
    // They swim in opposite directions along x by 2/3 of B1, less what they move each other by.
    let along = [0, 1].map(|k| swimmers[k].displacement.x);
    assert!(along[0] > 0.6 && along[1] < -0.6, "{along:?}");
}

#[test]
fn many_joints_are_named_by_the_first_and_their_number() {
    let scene = three_spheres(
        "rpy",
        "[[copies]]\nof = \"middle\"\ncount = 9\nsize = [200, 200, 200]\ngap = 1\n",
    );
    let all: Vec<usize> = (0..scene.articulation().joints().len()).collect();
    assert_eq!(scene.joint_label(&all), "a + b + a-2 + 17 more");
    assert_eq!(scene.joint_label(&all[..2]), "a + b");
    // Two phases with the same label have different names.
    assert!(scene.joint_names(&all).ends_with("a-10 + b-10"));
}

/// Two pairs of spheres in a ball, each with an arm; `volumes` says how they change their volumes.
fn pairs_in_a_ball(volumes: &str, domain: &str) -> Scene {
    let text = format!(
        "model.kind = \"multipole\"\n{domain}{volumes}\
         [[bodies]]\nname = \"a\"\nradius = 1\nposition = [-2, 4, 0]\n\
         [[bodies]]\nname = \"b\"\nradius = 1\nposition = [2, 4, 0]\n\
         [[bodies]]\nname = \"c\"\nradius = 1\nposition = [-2, -4, 0]\n\
         [[bodies]]\nname = \"d\"\nradius = 1\nposition = [2, -4, 0]\n\
         [[links]]\nname = \"upper\"\nbody = \"b\"\nto = \"a\"\n\
         [[links]]\nname = \"lower\"\nbody = \"d\"\nto = \"c\"\n"
    );
    Scene::parse(&text).unwrap()
}

/// Works of swimmers that share a volume are not known apart: the drive of an exchange, or the
/// pressure of a container up to a constant, works on both.
#[test]
fn bug_works_of_swimmers_that_share_a_volume_were_given() {
    let exchange = |body: &str, to: &str| {
        format!(
            "gait.phases = [{{ targets = {{ flux = 4.5, upper = 3.9, lower = 3.9 }} }}]\n\
             [[links]]\nname = \"flux\"\njoint = \"exchange\"\nbody = \"{body}\"\nto = \"{to}\"\n"
        )
    };
    let volumes = |body: &str, to: &str| {
        format!(
            "gait.phases = [{{ targets = {{ \"{body}.volume\" = 4, \"{to}.volume\" = {:?}, \
             upper = 3.9, lower = 3.9 }} }}]\n",
            8.0 * std::f64::consts::PI / 3.0 - 4.0
        )
    };
    let ball = "domain = { kind = \"ball\", radius = 12 }\n";
    for (scene, is_known) in [
        (pairs_in_a_ball(&exchange("a", "b"), ""), true),
        (pairs_in_a_ball(&exchange("a", "c"), ""), false),
        (pairs_in_a_ball(&volumes("a", "c"), ""), true),
        (pairs_in_a_ball(&volumes("a", "b"), ball), true),
        (pairs_in_a_ball(&volumes("a", "c"), ball), false),
    ] {
        let outcome = run(&scene);
        let swimmers = outcome.swimmers(&scene);
        assert_eq!(swimmers.len(), 2);
        for swimmer in swimmers {
            assert_eq!(swimmer.work.is_some(), is_known);
        }
    }
}

/// Works and displacements of swimmers are in checkpoints.
#[test]
fn a_resumed_run_has_the_results_of_its_swimmers() {
    let (copies, _) = copies();
    let scene = three_spheres("rpy", &copies);
    let results = |outcome: &Outcome| -> Vec<_> {
        (outcome.swimmers(&scene).into_iter())
            .map(|swimmer| {
                (
                    swimmer.displacement,
                    swimmer.rotation,
                    swimmer.work.unwrap(),
                )
            })
            .collect()
    };
    let whole = run(&scene);
    let resumed = resumed_after_one_phase(|| scene.clone()).outcome;
    assert_eq!(resumed.swimmers(&scene).len(), 3);
    assert_eq!(results(&resumed), results(&whole));
}
