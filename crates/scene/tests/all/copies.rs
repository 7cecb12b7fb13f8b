//! Copies of linkages: places, names, gaits, and what is refused.

use nalgebra::{UnitQuaternion, Vector3};
use scene::{Scene, closest_contact};

const SWIMMER: &str = "\
[[bodies]]\nname = \"l\"\nradius = 1\nposition = [-6, 1, 0]\n\
[[bodies]]\nname = \"c\"\nradius = 1\nposition = [0, 1, 0]\n\
[[bodies]]\nname = \"lone\"\nradius = 0.5\nposition = [0, 9, 0]\n\
[[links]]\nname = \"a\"\nbody = \"l\"\nto = \"c\"\n";

fn parse(more: &str) -> Result<Scene, String> {
    Scene::parse(&format!("{SWIMMER}{more}")).map_err(|error| error.to_string())
}

#[test]
fn copies_have_their_places_attitudes_and_gait() {
    let scene = parse(
        "[[copies]]\nof = \"c\"\npositions = [[20, 0, 0], [0, 0, 20]]\n\
         orientations = [[0, 0, 1.5707963267948966], [0, 0, 0]]\n\
         [[gait.phases]]\nlink = \"a\"\nlength = 4\n\
         [[gait.phases]]\ntargets = { a = 5 }\n",
    )
    .unwrap();
    let at = |name: &str| {
        let body = scene.bodies().iter().find(|body| body.name == name);
        body.unwrap().position
    };
    assert_eq!(scene.bodies().len(), 7);
    // A quarter of a turn: the arm along -x is along -y.
    assert!((at("l-2") - Vector3::new(20.0, -6.0, 0.0)).norm() < 1e-14);
    assert_eq!(at("c-2"), Vector3::new(20.0, 0.0, 0.0));
    assert_eq!(at("l-3"), Vector3::new(-6.0, 0.0, 20.0));
    let names: Vec<_> = (scene.articulation().joints().iter())
        .map(|joint| &joint.name[..])
        .collect();
    assert_eq!(names, ["a", "a-2", "a-3"]);
    // All arms follow the gait of the first one.
    let shapes: Vec<_> = scene::spans(scene.gait(), scene.articulation().initial_shape())
        .unwrap()
        .map(|span| span.to.clone())
        .collect();
    assert_eq!(shapes, [[4.0; 3], [5.0; 3]]);
    // What is written has the copies as bodies of their own.
    let text = scene.to_toml().unwrap();
    assert!(!text.contains("copies"), "{text}");
    let again = Scene::parse(&text).unwrap();
    assert_eq!(again.bodies().len(), 7);
    assert_eq!(again.to_toml().unwrap(), text);
}

#[test]
fn axes_turn_with_copies_and_loads_do_not() {
    let turn = [0.4, -1.1, 0.7];
    let text = format!(
        "[[bodies]]\nname = \"s\"\nshape = \"spheroid\"\nradius = 1\nhalf_length = 2\n\
         position = [0, 0, 0]\naxis = [0, 1, 0]\nforce = [1, 2, 3]\nmoment = [0, 0, 1]\n\
         [[copies]]\nof = \"s\"\npositions = [[9, 0, 0]]\norientations = [{turn:?}]\n\
         [field]\nmean = [1, 0, 0]\n"
    );
    let scene = Scene::parse(&text).unwrap();
    let rotation = UnitQuaternion::from_scaled_axis(Vector3::from(turn));
    let [own, copy] = [0, 1].map(|k| &scene.bodies()[k]);
    let axes = [own, copy].map(|body| body.shape.axis().unwrap());
    assert!((rotation * axes[0] - axes[1]).norm() < 1e-14);
    assert!((rotation * own.moment - copy.moment).norm() < 1e-14);
    assert_eq!(own.force, copy.force);
}

#[test]
fn random_copies_are_reproducible_and_leave_gaps() {
    let random = |seed: u32| {
        parse(&format!(
            "[[copies]]\nof = \"c\"\ncount = 60\nsize = [40, 40, 40]\ncentre = [1, 2, 3]\n\
             isotropic = true\ngap = 0.5\nseed = {seed}\n"
        ))
        .unwrap()
    };
    let positions =
        |scene: &Scene| -> Vec<_> { scene.bodies().iter().map(|b| b.position).collect() };
    let scene = random(1);
    assert_eq!(scene.bodies().len(), 3 + 2 * 60);
    assert_eq!(positions(&scene), positions(&random(1)));
    assert_ne!(positions(&scene), positions(&random(2)));
    let set = scene.articulation();
    let poses = set
        .place(&scene.initial_state(), set.initial_shape())
        .unwrap();
    let closest = closest_contact(scene.bodies(), scene.domain(), &poses).unwrap();
    assert!(closest.gap >= 0.5 - 1e-12, "{}", closest.gap);
    // All directions of the arms occur.
    let arms = scene.bodies()[3..]
        .chunks(2)
        .map(|pair| (pair[0].position - pair[1].position) / 6.0);
    let mean: Vector3<f64> = arms.sum::<Vector3<f64>>() / 60.0;
    // The mean of 60 unit vectors is below 0.4 with a probability of 1 - 4e-6.
    assert!(mean.norm() < 0.4, "{mean}");
}

#[test]
fn copies_that_do_not_fit_are_refused_with_their_key() {
    for (copies, words) in [
        (
            "of = \"x\"\npositions = [[9, 9, 9]]",
            &["copies[0].of", "body"][..],
        ),
        ("positions = [[9, 9, 9]]", &["copies[0].of", "missing"]),
        ("of = \"c\"", &["copies[0].count", "missing"]),
        ("of = \"c\"\ncount = 2", &["copies[0].size", "missing"]),
        (
            "of = \"c\"\ncount = 2\nsize = [9, 9, 9]\npositions = [[9, 9, 9]]",
            &["copies[0].count", "random"],
        ),
        (
            "of = \"c\"\npositions = [[9, 9, 9]]\norientations = [[0, 0, 1], [0, 1, 0]]",
            &["copies[0].orientations", "2 entries"],
        ),
        (
            "of = \"c\"\ncount = 500\nsize = [20, 20, 20]",
            &["copies[0].count", "enlarge"],
        ),
        (
            "of = \"c\"\ncount = 4000000000\nsize = [9, 9, 9]",
            &["copies[0].count", "at most"],
        ),
        ("of = \"c\"\npositions = [[0, 1, 0.5]]", &["touch"]),
    ] {
        let error = parse(&format!("[[copies]]\n{copies}\n")).unwrap_err();
        assert!(
            words.iter().all(|word| error.contains(word)),
            "{copies}: {error}"
        );
    }
}

/// They had no effect: a grid was not where its `centre` said.
#[test]
fn bug_keys_of_random_copies_were_ignored_beside_positions() {
    for key in [
        "centre = [1, 0, 0]",
        "gap = 0.5",
        "seed = 2",
        "isotropic = true",
    ] {
        let text = format!("[[copies]]\nof = \"c\"\npositions = [[9, 9, 9]]\n{key}\n");
        let error = parse(&text).unwrap_err();
        let name = key.split(' ').next().unwrap();
        let words = [
            &format!("copies[0].{name}")[..],
            "belongs to copies at random",
        ];
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
}

/// A copy that was turned touched its own image, so that the scene was refused.
#[test]
fn bug_random_copies_did_not_see_the_images_of_their_own_linkage() {
    for seed in [1, 6, 10] {
        let text = format!(
            "domain = {{ kind = \"periodic\", size = [20, 20, 20] }}\n\
             bodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0] }},\n\
             {{ name = \"b\", radius = 1, position = [13.4, 13.4, 0] }}]\n\
             links = [{{ name = \"l\", body = \"b\", to = \"a\" }}]\n\
             [[copies]]\nof = \"a\"\ncount = 30\nsize = [20, 20, 20]\nisotropic = true\n\
             gap = 0.2\nseed = {seed}\n"
        );
        let scene = Scene::parse(&text).unwrap();
        let set = scene.articulation();
        let poses = set
            .place(&scene.initial_state(), set.initial_shape())
            .unwrap();
        let closest = closest_contact(scene.bodies(), scene.domain(), &poses).unwrap();
        assert!(closest.gap >= 0.2 - 1e-12, "{}", closest.gap);
    }
}

const AMOEBA: &str = "\
[[bodies]]\nname = \"s\"\nradius = 1\nposition = [0, 0, 0]\n\
deformation = { modes = { p2 = 2, p3 = 3 } }\n";

/// The axis of the copy was that of the original.
#[test]
fn bug_axes_of_modes_did_not_turn_with_copies() {
    let turn = [0.4, -1.1, 0.7];
    let text = format!(
        "{AMOEBA}[[copies]]\nof = \"s\"\npositions = [[9, 0, 0]]\norientations = [{turn:?}]\n"
    );
    let scene = Scene::parse(&text).unwrap();
    let rotation = UnitQuaternion::from_scaled_axis(Vector3::from(turn));
    let axes = [0, 1].map(|k| scene.bodies()[k].deformation.as_ref().unwrap().axis());
    let [own, copy] = axes.map(|axis| axis.unwrap());
    assert!((rotation * own - copy).norm() < 1e-14);
}

/// The copies stayed as they were, without a word.
#[test]
fn bug_deformations_of_copies_did_not_follow_the_gait() {
    let copies = "[[copies]]\nof = \"s\"\npositions = [[9, 0, 0], [0, 9, 0]]\n";
    for gait in [
        "[[gait.phases]]\ntargets = { \"s.p2\" = 0.1 }\n",
        "[[gait.phases]]\nlink = \"s.p2\"\nlength = 0.1\n",
    ] {
        let scene = Scene::parse(&format!("{AMOEBA}{copies}{gait}")).unwrap();
        let joints = scene.articulation().joints();
        let span = scene::spans(scene.gait(), scene.articulation().initial_shape())
            .unwrap()
            .next()
            .unwrap();
        for (joint, value) in joints.iter().zip(&span.to) {
            let expected = if joint.name.ends_with("p2") { 0.1 } else { 0.0 };
            assert_eq!(*value, expected, "{}", joint.name);
        }
        assert_eq!(joints.len(), 6);
    }
    let waves = "[gait]\nperiod = 1\n[[gait.harmonics]]\nlink = \"s.p3\"\nmean = 0\n\
                 amplitude = 0.1\n";
    let scene = Scene::parse(&format!("{AMOEBA}{copies}{waves}")).unwrap();
    let moving = scene::spans(scene.gait(), scene.articulation().initial_shape())
        .unwrap()
        .next()
        .unwrap()
        .joints
        .len();
    assert_eq!(moving, 3);
}

#[test]
fn copies_of_what_a_table_drives_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("gait.csv"),
        "time,s.radius\n0,1\n1,1.1\n",
    )
    .unwrap();
    let text = "[[bodies]]\nname = \"s\"\nradius = 1\nposition = [0, 0, 0]\n\
                [[bodies]]\nname = \"other\"\nradius = 1\nposition = [0, 9, 0]\n\
                [gait]\nfile = \"gait.csv\"\n[[copies]]\nof = \"NAME\"\npositions = [[9, 0, 0]]\n";
    let read = |name: &str| {
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, text.replace("NAME", name)).unwrap();
        Scene::read(&path, &[]).map_err(|error| error.to_string())
    };
    assert_eq!(read("other").unwrap().bodies().len(), 3);
    let error = read("s").unwrap_err();
    assert!(
        error.contains("copies[0].of") && error.contains("gait.file"),
        "{error}"
    );
}
