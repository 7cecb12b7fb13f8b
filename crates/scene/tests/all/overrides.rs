//! Overrides of single keys have the same effect and pass the same checks as edits of the file.

use scene::{Document, Scene, SceneError, SymmetryKind};

/// The scene of a text with overrides, as by `--set`.
pub fn set(text: &str, assignments: &[&str]) -> Result<Scene, SceneError> {
    let mut document = Document::parse(text, "scene.toml")?;
    assignments
        .iter()
        .try_for_each(|assignment| document.set(assignment))?;
    Scene::from_document(document)
}

/// Two linked spheres in a ball; one has a number as its name.
pub const TWO: &str = r#"
domain = { kind = "ball", radius = 40 }
bodies = [
    { name = "left", radius = 1, position = [-10, 0, 0] },
    { name = "1", radius = 1, position = [0, 0, 0] },
]
links = [{ name = "arm", body = "left", to = "1" }]
gait.phases = [{ link = "arm", length = 6 }]
"#;

#[test]
fn overrides_change_every_kind_of_key() {
    let scene = set(
        TWO,
        &[
            "gait.cycles=3",
            "bodies.left.radius=0.5",
            "bodies[1].position = [0, 0, 5]",
            "fem.solver=direct",
            "fem.formulation=\"lagrange\"",
            "fluid.viscosity=2e-3",
            "gait.phases.0.length=7",
            "domain.kind=box",
            "domain.size=[100, 100, 100]",
        ],
    )
    .unwrap();
    assert_eq!(scene.gait().cycles, 3);
    assert_eq!(scene.bodies()[0].bounding_radius(), 0.5);
    assert_eq!(scene.bodies()[1].position.z, 5.0);
    assert_eq!(scene.fem().solver.word(), "direct");
    assert_eq!(scene.viscosity(), 2e-3);
    assert_eq!(
        scene.gait().phases[0].path,
        scene::ShapePath::Linear(vec![(0, 7.0)])
    );
    assert_eq!(scene.domain().kind().word(), "box");
}

/// A radius of an unbounded domain was read without a word, as if the swimmer were in a ball.
#[test]
fn bug_keys_of_other_domains_had_no_effect_in_silence() {
    let size = "domain.size=[100, 100, 100]";
    let scene = set(TWO, &["domain.kind=unbounded", "domain.radius=9", size]).unwrap();
    let warning = |key: &str, set: &str| {
        format!("--set {set}: domain.{key} has no effect on kind = \"unbounded\"")
    };
    let expected = [warning("radius", "domain.radius=9"), warning("size", size)];
    assert_eq!(scene.warnings(), expected);
    // Once, also of scenes that are made from it.
    assert_eq!(scene.with_cycles(3).unwrap().warnings(), expected);
    assert!(
        set(TWO, &["domain.radius=50"])
            .unwrap()
            .warnings()
            .is_empty()
    );
}

#[test]
fn names_come_before_numbers_in_overrides() {
    // `bodies.1` is the body with the name "1", whatever its number.
    let text = TWO.replace("\"left\"", "\"7\"");
    let scene = set(
        &text,
        &[
            "bodies.1.radius=2",
            "bodies.7.radius=3",
            "bodies.0.force=[1, 0, 0]",
        ],
    )
    .unwrap();
    assert_eq!(scene.bodies()[1].bounding_radius(), 2.0);
    assert_eq!(scene.bodies()[0].bounding_radius(), 3.0);
    assert_eq!(scene.bodies()[0].force.x, 1.0);
}

#[test]
fn bad_overrides_are_refused_with_the_same_checks() {
    let rows = r#"
gait.cycles -> has no value; write key=value
gait.cycle=3 -> did you mean 'gait.cycles'?
bodies.middle.radius=1 -> bodies has no entry 'middle'; there are left, 1
bodies.9.radius=1 -> bodies has no entry '9'
bodies.left.raduis=1 -> did you mean 'bodies[].radius'?
bodies.left.radius=-1 -> must be a number greater than zero, not -1
bodies.left.radius=1,5 -> must be a number greater than zero, not the text "1,5"
links.arm.length=8 -> here they are bodies.left.position, bodies.1.position, gait.phases.0.length
links.arm.lenght=8 -> unknown key
fluid.viscosity.x=1 -> unknown key
fluid=1 -> fluid must be a table
bodies=1 -> bodies must be a list of tables
bodies.left=1 -> bodies[0] must be a table, written as [[bodies]]
=3 -> unknown key
fluid.viscosity=1\nfem.rtol=2 -> must be a number greater than zero
bodies.left.radius=12 -> touch or overlap
gait.phases.0.link=leg -> names no link: "leg"
"#;
    for row in rows.trim().lines() {
        let (assignment, fragment) = row.split_once(" -> ").unwrap();
        let error = set(TWO, &[&assignment.replace("\\n", "\n")]).expect_err(assignment);
        let message = error.to_string();
        assert!(message.contains(fragment), "{assignment}: {message}");
    }
}

/// A renamed key is read under its old name too, with a warning that has its place.
#[test]
fn old_names_of_keys_are_read_with_a_warning() {
    let scene = |key: &str, overrides: &[&str]| {
        let text =
            format!("bodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0] }}]\n{key}");
        set(&text, overrides)
    };
    let old = scene("fem.mirror = \"off\"", &[]).unwrap();
    assert_eq!(old.fem().symmetry, SymmetryKind::Off);
    let renaming = "the key 'fem.mirror' is now 'fem.symmetry'; rename it";
    assert_eq!(old.warnings(), [format!("scene.toml:2: {renaming}")]);
    let set = scene("", &["fem.mirror=off"]).unwrap();
    assert_eq!(
        set.warnings(),
        [format!("--set fem.mirror=off: {renaming}")]
    );
    let new = scene("fem = { symmetry = \"off\" }", &[]).unwrap();
    assert!(new.warnings().is_empty());
    let texts = [&old, &set, &new].map(|scene| scene.to_toml().unwrap());
    assert!(
        texts
            .iter()
            .all(|text| *text == texts[2] && !text.contains("mirror"))
    );

    let bad = scene("\nfem.mirror = \"of\"", &[]).unwrap_err().to_string();
    assert!(
        bad.starts_with("scene.toml:3: fem.symmetry cannot be \"of\""),
        "{bad}"
    );
    let both = scene("fem = { mirror = \"off\", symmetry = \"off\" }", &[]).unwrap_err();
    assert!(
        both.to_string().contains("is the old name of fem.symmetry"),
        "{both}"
    );
}

/// TOML takes `"fluid.viscosity"` for one name with a dot, which no table of the scene has.
#[test]
fn a_key_in_quotation_marks_is_refused_and_not_ignored() {
    for (line, place) in [
        ("\"fluid.viscosity\" = 100.0", "scene.toml:1"),
        ("fluid = { \"viscosity.x\" = 1 }", "scene.toml:1"),
        ("\"gait.phases[0].length\" = 5", "scene.toml:1"),
        ("\"bodies[0].radius\" = 5", "scene.toml:1"),
        (
            "fluid = { viscosity = 1, \"density[]\" = 1 }",
            "scene.toml:1",
        ),
    ] {
        let error = Scene::parse(&format!("{line}\n{TWO}")).expect_err(line);
        let message = error.to_string();
        assert!(message.starts_with(place), "{line}: {message}");
        assert!(message.contains("quotation marks"), "{line}: {message}");
    }
    // Quotation marks around a name without dots change nothing, and names of links may have dots.
    let quoted = format!(
        "\"fluid\".\"viscosity\" = 3.0\n{}",
        TWO.replace("arm", "a.b[0]")
    );
    let quoted = quoted.replace(
        "link = \"a.b[0]\", length = 6",
        "targets = { \"a.b[0]\" = 6 }",
    );
    let scene = Scene::parse(&quoted).unwrap();
    assert_eq!(scene.viscosity(), 3.0);
    assert_eq!(
        scene.gait().phases[0].path,
        scene::ShapePath::Linear(vec![(0, 6.0)])
    );
}

#[test]
fn a_program_adds_keys_with_dots_unless_they_have_a_value() {
    let mut document = Document::parse(TWO, "scene.toml").unwrap();
    document.add("fluid.viscosity", 100.0.into()).unwrap();
    document
        .add("bodies.left.force", vec![1_i64, 0, 0].into())
        .unwrap();
    for (key, fragment) in [
        ("fluid.viscosity", "is given twice"),
        ("bodies[0].radius", "is given twice"),
        ("domain", "is given twice"),
        ("fluid.viscositi", "did you mean"),
        ("bodies.none.radius", "has no entry"),
    ] {
        let message = document.add(key, 3.0.into()).unwrap_err().to_string();
        assert!(message.contains(fragment), "{key}: {message}");
    }
    let scene = Scene::from_document(document).unwrap();
    assert_eq!((scene.viscosity(), scene.bodies()[0].force.x), (100.0, 1.0));
}
