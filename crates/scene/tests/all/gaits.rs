//! Gaits that move several joints at once.

use nalgebra::Vector3;
use rigid::JointKind;
use scene::{Scene, ShapePath, spans};

/// Three spheres on a line, with arms of the length 10, and a gait.
fn text(gait: &str) -> String {
    format!(
        r#"
        bodies = [
            {{ name = "left", radius = 1, position = [-10, 0, 0] }},
            {{ name = "centre", radius = 1, position = [0, 0, 0] }},
            {{ name = "right", radius = 1, position = [10, 0, 0] }},
        ]
        links = [
            {{ name = "a", body = "left", to = "centre" }},
            {{ name = "b", body = "right", to = "centre" }},
        ]
        {gait}
        "#
    )
}

fn parse(gait: &str) -> Result<Scene, String> {
    Scene::parse(&text(gait)).map_err(|error| error.to_string())
}

#[test]
fn targets_move_several_joints_at_once() {
    let scene = parse("gait.phases = [{ targets = { b = 7, a = 6 }, duration = 2 }]").unwrap();
    let phase = &scene.gait().phases[0];
    assert_eq!(phase.path, ShapePath::Linear(vec![(0, 6.0), (1, 7.0)]));
    assert_eq!(scene.joint_names(&phase.path.joints()), "a + b");
    let span = spans(scene.gait(), &[10.0, 10.0]).unwrap().next().unwrap();
    assert_eq!(span.shape(0.5), [8.0, 8.5]);
    assert_eq!(span.rates(0.1), [-2.0, -1.5]);
    let again = Scene::parse(&scene.to_toml().unwrap()).unwrap();
    assert_eq!(again.gait(), scene.gait());
}

#[test]
fn a_harmonic_gait_starts_from_the_positions_or_from_its_means() {
    let harmonics = |more: &str| {
        format!(
            "gait = {{ kind = \"harmonic\", period = 8, harmonics = [\
             {{ link = \"a\", amplitude = 2, phase = 0.5{more} }}, \
             {{ link = \"a\", amplitude = 0.5, order = 2 }}, \
             {{ link = \"b\", amplitude = 1 }}] }}"
        )
    };
    let scene = parse(&harmonics("")).unwrap();
    assert_eq!(scene.articulation().initial_shape(), [10.0, 10.0]);
    assert_eq!(
        (scene.gait().phases.len(), scene.gait().duration()),
        (4, 8.0)
    );
    let again = Scene::parse(&scene.to_toml().unwrap()).unwrap();
    assert_eq!(again.gait(), scene.gait());

    // The mean and the phase give the length at the start; body 0 is the root and stays.
    let scene = parse(&harmonics(", mean = 8")).unwrap();
    let start = 8.0 + 2.0 * 0.5_f64.sin();
    assert!((scene.articulation().initial_shape()[0] - start).abs() < 1e-14);
    let x = |body: usize| scene.bodies()[body].position.x;
    assert_eq!(x(0), -10.0);
    assert!((x(1) - (start - 10.0)).abs() < 1e-14 && (x(2) - x(1) - 10.0).abs() < 1e-14);
    let first = spans(scene.gait(), scene.articulation().initial_shape())
        .unwrap()
        .next();
    // A quarter of the period later: the sine of the second order is zero again.
    let quarter = 8.0 + 2.0 * (std::f64::consts::FRAC_PI_2 + 0.5).sin();
    assert!((first.unwrap().to[0] - quarter).abs() < 1e-14);
    // Written and read again, it has the same shape to rounding.
    let again = Scene::parse(&scene.to_toml().unwrap()).unwrap();
    assert_eq!(
        again.articulation().initial_shape(),
        scene.articulation().initial_shape()
    );
}

/// A scene with a gait from a table.
fn with_table(table: &str, gait: &str) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("stroke.csv"), table).unwrap();
    let file = folder.path().join("scene.toml");
    let text = text(&format!("gait = {{ file = \"stroke.csv\"{gait} }}"));
    std::fs::write(&file, text).unwrap();
    let scene = Scene::read(&file, &[]).map_err(|error| error.to_string())?;
    // Written and read again while the table exists.
    let again = Scene::parse(&scene.to_toml().unwrap()).unwrap();
    assert_eq!(again.gait(), scene.gait());
    Ok(scene)
}

#[test]
fn a_table_is_a_spline_or_phases_through_its_rows() {
    let table = "# a stroke\ntime, b, a\n\n0, 8, 10\n1, 7, 8.5\n1.5, 7.5, 8\n4, 8, 10\n";
    for (gait, is_linear) in [
        ("", false),
        (", interpolation = \"linear\", cycles = 3", true),
    ] {
        let scene = with_table(table, gait).unwrap();
        // The bodies start at the values of the first row.
        assert_eq!(scene.articulation().initial_shape(), [10.0, 8.0]);
        let all: Vec<_> = spans(scene.gait(), &[10.0, 8.0]).unwrap().collect();
        assert_eq!(scene.gait().phases.len(), 3);
        assert_eq!(all[1].to, [8.0, 7.5]);
        assert_eq!((all[1].start, all[1].duration), (1.0, 0.5));
        assert_eq!(all[0].is_linear(), is_linear);
        for span in &all {
            for (a, b) in span.shape(1.0).iter().zip(&span.to) {
                assert!((a - b).abs() < 1e-14);
            }
            let d = 1e-5;
            for s in [d, 0.3, 1.0 - d] {
                let [before, after] = [span.shape(s - d), span.shape(s + d)];
                for (joint, rate) in span.rates(s).iter().enumerate() {
                    let expected = (after[joint] - before[joint]) / (2.0 * d * span.duration);
                    assert!((rate - expected).abs() < 1e-8, "{rate} {expected}");
                }
            }
        }
        // A spline has no corners, also where the cycle closes; phases have.
        let joints = all.iter().zip(all.iter().cycle().skip(1)).take(3);
        for (before, after) in joints {
            let corners = before.rates(1.0).into_iter().zip(after.rates(0.0));
            let largest = corners.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            assert_eq!(largest > 1e-12, is_linear, "{largest:e}");
        }
    }
}

/// Asserts that each row `case -> part | part` is refused with all of its parts.
fn assert_refused(rows: &str, refuse: impl Fn(&str) -> String) {
    for row in rows.trim().lines() {
        let (case, parts) = row.split_once("-> ").unwrap();
        let message = refuse(case.trim());
        for part in parts.split(" | ") {
            assert!(message.contains(part), "{case}\n{message}\nwithout {part}");
        }
    }
}

#[test]
fn bad_tables_are_refused_with_their_line() {
    // Lines of the table are separated by `/`; `;` ends it before further keys of the gait.
    let rows = r#"
-> gait.file | no rows
time, a / 0, 10 / -> less than two rows
t, a / 0, 10 / 1, 9 / -> line 1 | time
time, c / 0, 10 / 1, 9 / -> line 1 | "c"
time, a, a / 0, 10, 9 / 1, 9, 9 / -> line 1 | two columns
time, a / 0, 10 / / 1, x / -> line 4 | "x" is not a number
time, a / 0, 10 / 1, NaN / -> line 3 | not a number
time, a / 0, 10 / 1, 9, 8 / -> line 3 | 3 columns instead of 2
time, a / 0, 10 / 0, 9 / -> line 3 | not after
time, a / 0, 10 / 1, -9 / -> line 3 | not positive
time, a / 0, 10 / 1, 1e40 / -> gait.file | too large
time, a / 0, 10 / 1, 9 /; cycles = 2 -> gait.cycles | first one
time, a / 0, 10 / 1, 1.5 / -> touch | phase 1
time, a / 0, 10 / 1, 9 /; period = 2 -> gait.period | harmonic
time, a / 0, 10 / 1, 9 /; kind = "phases" -> gait.kind | no gait.phases
"#;
    assert_refused(rows, |case| {
        let (table, keys) = match case.split_once("; ") {
            Some((table, keys)) => (table, format!(", {keys}")),
            None => (case, String::new()),
        };
        let table = table
            .replace(" / ", "\n")
            .replace(" /", "\n")
            .replace("/ ", "\n");
        with_table(&table, &keys).unwrap_err()
    });
    assert_refused(
        r#"gait.file = "nowhere.csv" -> gait.file | nowhere.csv"#,
        |gait| parse(gait).unwrap_err(),
    );
}

#[test]
fn bad_gaits_are_refused_with_their_key() {
    // Both arms at once are shorter than a diameter in the last row.
    let phases = r#"
targets = { c = 7 } -> gait.phases[0].targets | "c"
targets = { a = -7 } -> gait.phases[0].targets | greater
targets = 7 -> gait.phases[0].targets | { arm = 6 }
targets = { a = 1e300 } -> gait.phases[0].targets | 1e50
link = "b", length = 8, targets = { a = 7 } -> gait.phases[0].targets | cannot be combined with link
targets = { a = 1.9, b = 8 } -> touch | phase 1
"#;
    assert_refused(phases, |phase| {
        parse(&format!("gait.phases = [{{ {phase} }}]")).unwrap_err()
    });
    // The arm is shortest, 10 - 8.5, in the third quarter in the last row.
    let harmonics = r#"
-> gait.harmonics | is empty
{ amplitude = 1 } -> gait.harmonics[0].link | missing
{ link = "a" } -> gait.harmonics[0].amplitude | missing
{ link = "c", amplitude = 1 } -> gait.harmonics[0].link | names no link
{ link = "a", amplitude = 1, order = 0 } -> gait.harmonics[0].order | at least 1
{ link = "a", amplitude = 1, mean = 8 }, { link = "a", amplitude = 1, mean = 9 } -> gait.harmonics[1].mean | another entry
{ link = "a", amplitude = 8.5 } -> scene.toml: | touch | phase 3
"#;
    assert_refused(harmonics, |entry| {
        parse(&format!("gait = {{ period = 8, harmonics = [{entry}] }}")).unwrap_err()
    });
    let gaits = r#"
harmonics = [{ link = "a", amplitude = 1 }] -> gait.period | missing
period = 8 -> gait.period | harmonic
phases = [{}], interpolation = "linear" -> gait.interpolation | table
kind = "harmonic" -> gait.kind | no gait.harmonics
kind = "phases", period = 8, harmonics = [{ link = "a", amplitude = 1 }] -> gait.kind | no gait.phases
phases = [{}], period = 8, harmonics = [{ link = "a", amplitude = 1 }] -> gait.harmonics | phases
"#;
    assert_refused(gaits, |keys| {
        parse(&format!("gait = {{ {keys} }}")).unwrap_err()
    });
}

/// The pivot of a hinge stays where it is on its bodies when the mean of a slide moves them.
#[test]
fn bug_means_of_gaits_moved_bodies_without_their_pivots() {
    let scene = Scene::parse(
        "bodies = [\n\
           { name = \"tail\", radius = 1, position = [-5, 0, 0] },\n\
           { name = \"middle\", radius = 1, position = [0, 0, 0] },\n\
           { name = \"head\", radius = 1, position = [4, 0, 0] },\n\
         ]\n\
         links = [\n\
           { name = \"arm\", body = \"middle\", to = \"tail\" },\n\
           { name = \"neck\", body = \"head\", to = \"middle\", joint = \"hinge\", axis = [0, 0, 1], pivot = [2, 0, 0] },\n\
         ]\n\
         [gait]\nperiod = 1\n\
         harmonics = [{ link = \"arm\", amplitude = 1, mean = 8 }, { link = \"neck\", amplitude = 0.5 }]\n",
    )
    .unwrap();
    // The root stays at -5, the rest is three farther.
    assert!((scene.bodies()[2].position - Vector3::new(7.0, 0.0, 0.0)).norm() < 1e-14);
    let JointKind::Turn { pivot, .. } = scene.articulation().joints()[1].kind else {
        panic!("a hinge");
    };
    assert!(
        (pivot - Vector3::new(5.0, 0.0, 0.0)).norm() < 1e-14,
        "{pivot}"
    );
}

/// The sine of such an angle is that of its rounding errors.
#[test]
fn a_phase_angle_of_1e50_is_refused() {
    let gait = |phase: &str| {
        parse(&format!(
            "gait = {{ period = 8, harmonics = [{{ link = \"a\", amplitude = 2, phase = {phase} }}] }}"
        ))
    };
    assert!(gait("1e6").is_ok());
    for phase in ["1.1e6", "1e50"] {
        let message = gait(phase).unwrap_err();
        let start = "scene.toml:11: gait.harmonics[0].phase must be an angle of at most 1e6";
        assert!(message.starts_with(start), "{message}");
    }
    let force = "gait.period = 8\nlinks = [{ name = \"a\", body = \"x\", to = \"y\", force = \
                 { amplitude = 1, phase = 1e50 }, drive = \"force\" }]\n\
                 bodies = [{ name = \"x\", radius = 1, position = [0, 0, 0] },\
                 { name = \"y\", radius = 1, position = [9, 0, 0] }]";
    let error = Scene::parse(force).unwrap_err().to_string();
    assert!(error.contains("links[0].force must be an angle"), "{error}");
    let turned = "bodies = [{ name = \"x\", shape = \"ellipsoid\", semi_axes = [3, 2, 1], \
                  position = [0, 0, 0], orientation = [0, 0, 1e50] }]";
    let error = Scene::parse(turned).unwrap_err().to_string();
    assert!(
        error.contains("bodies[0].orientation must be an angle"),
        "{error}"
    );
}
