//! The page of a run, and the picture of a flow.

use pictures::flow_slice::{FlowSlice, SliceFrame};
use pictures::start_slice;
use serde_json::Value;
use testkit::{SceneText, boxed, contains, pair, within};

use crate::{printed, refused};

/// Three spheres by multipoles: a run of milliseconds whose flow is evaluated point by point.
fn spheres() -> String {
    let text = testkit::chain(&["a<b", "b", "c"], &[-6.0, 0.0, 6.0]);
    let text = text.slide("left", "a<b", "b").slide("right", "c", "b");
    let stroke = [("left", 4.0), ("right", 4.0), ("left", 6.0), ("right", 6.0)];
    text.phases(&stroke).toml()
}

fn data(page: &str) -> Value {
    let (_, rest) = page.split_once("id=\"run-data\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn a_run_writes_a_page_that_needs_no_other_file_and_view_writes_the_same_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("spheres.toml"), spheres()).unwrap();
    let text = printed(at, &["run", "spheres.toml", "--out", "out"]);
    contains("run", &text, &["report                  out/report.html"]);
    let path = at.join("out/report.html");
    let page = std::fs::read_to_string(&path).unwrap();
    // One file: no address but that of the namespace of SVG, no style sheet, no script elsewhere.
    let addresses: Vec<&str> = (page.match_indices("http"))
        .map(|(at, _)| &page[at..at + 26])
        .collect();
    assert_eq!(addresses, ["http://www.w3.org/2000/svg"]);
    for reference in ["src=\"", "href=\"", "url(", "import "] {
        assert!(!page.contains(reference), "{reference}");
    }
    assert!(page.len() < 1_500_000, "{} bytes", page.len());
    // The net displacement is the printed one, and names are text.
    let mut lines = text.lines();
    let net = lines.find_map(|line| line.strip_prefix("net displacement"));
    let net = net.unwrap().trim().replace("+-", "±");
    assert!(page.contains(&net), "{net}");
    assert!(page.contains("class=\"name\">a&lt;b</th>"));
    let numbers = data(&page);
    assert_eq!(numbers["duration"], 4.0);
    assert_eq!(numbers["bodies"][0]["name"], "a<b");
    // Equal spheres share their surface.
    assert_eq!(numbers["meshes"].as_array().unwrap().len(), 1);
    assert_eq!(numbers["plots"].as_array().unwrap().len(), 2);
    let slices = numbers["slices"].as_array().unwrap();
    assert!(slices.len() >= 4, "{}", slices.len());
    for slice in slices {
        assert_eq!(slice["outlines"].as_array().unwrap().len(), 3);
        assert!(slice["lines"].as_array().unwrap().len() > 20);
    }
    // The same page from the files of the folder.
    std::fs::remove_file(&path).unwrap();
    printed(at, &["view", "out"]);
    assert!(std::fs::read_to_string(&path).unwrap() == page);
    // An animated picture of all slices, shown one after the other until the end of the cycle.
    let text = printed(at, &["view", "out", "--movie"]);
    contains("view", &text, &["movie                   out/movie.svg"]);
    let movie = std::fs::read_to_string(at.join("out/movie.svg")).unwrap();
    assert_eq!(movie.matches("@keyframes").count(), slices.len());
    assert_eq!(movie.matches("<g class=\"frame").count(), slices.len());
    assert!(movie.contains(" 100.000% { visibility: hidden }") && !movie.contains("<script"));
    let [begins, ends] = ["<svg", "</svg>"].map(|tag| movie.matches(tag).count());
    assert_eq!(begins, ends);
    // A run of an older version has no flow; the page says so.
    std::fs::remove_file(at.join("out/flow_slices.json")).unwrap();
    printed(at, &["view", "out"]);
    refused(at, &["view", "out", "--movie"]);
    let numbers = data(&std::fs::read_to_string(&path).unwrap());
    assert_eq!(numbers["slices"], serde_json::json!([]));
    contains(
        "page",
        numbers["missing"].as_str().unwrap(),
        &["flow_slices.json"],
    );
}

/// The elements of a page with this name: what stands between `<name` and `>`.
fn elements<'a>(page: &'a str, name: &str) -> Vec<&'a str> {
    let start = format!("<{name}");
    let parts = page.split(&start[..]).skip(1);
    let own = parts.filter(|rest| rest.starts_with([' ', '>', '\n']));
    own.map(|rest| rest.split_once('>').unwrap().0).collect()
}

/// Relative luminance of a colour such as `#14171b`, as the Web Content Accessibility Guidelines
/// 2.2 define it.
fn luminance(colour: &str) -> f64 {
    let channel = |k: usize| {
        let value = u8::from_str_radix(&colour[2 * k + 1..2 * k + 3], 16).unwrap();
        let value = f64::from(value) / 255.0;
        match value <= 0.04045 {
            true => value / 12.92,
            false => ((value + 0.055) / 1.055).powf(2.4),
        }
    };
    0.2126 * channel(0) + 0.7152 * channel(1) + 0.0722 * channel(2)
}

/// Contrast of two colours, from 1 to 21.
fn contrast(a: &str, b: &str) -> f64 {
    let [a, b] = [a, b].map(luminance);
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

/// What axe-core and the guidelines ask for and a text can show: a language, a width for phones,
/// headings in order, names of pictures and controls, heads of tables, and contrast in light and
/// dark colours.
#[test]
fn a_page_keeps_the_rules_of_accessibility_that_its_text_shows() {
    assert!((contrast("#000000", "#ffffff") - 21.0).abs() < 1e-12);
    // A grey that is just too light on white.
    assert!((4.47..4.5).contains(&contrast("#777777", "#ffffff")));
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("spheres.toml"), spheres()).unwrap();
    printed(at, &["run", "spheres.toml", "--out", "out"]);
    let page = std::fs::read_to_string(at.join("out/report.html")).unwrap();
    let (head, rest) = page.split_once("<style>").unwrap();
    let (style, body) = rest.split_once("</style>").unwrap();
    let (body, _) = body.split_once("<script").unwrap();
    let parts = [
        "<html lang=\"en\">",
        "width=device-width, initial-scale=1",
        "<title>spheres",
    ];
    contains("head", head, &parts);
    // Headings: one of the first level, none that leaves out a level.
    let mut level = 0;
    for part in body.split("<h").skip(1) {
        let Some(next) = part.chars().next().and_then(|c| c.to_digit(10)) else {
            continue;
        };
        assert!(next <= level + 1 && (next > 1 || level == 0), "{part:.40}");
        level = next;
    }
    assert!(level > 0);
    // Names.
    let is_named = |element: &&str, names: [&str; 2]| {
        names.iter().any(|name| {
            let value = element.split_once(&format!("{name}=\"")[..]);
            value.is_some_and(|(_, value)| !value.starts_with('"'))
        })
    };
    for (name, names) in [
        ("img", ["alt", "aria-label"]),
        ("svg", ["aria-label", "aria-labelledby"]),
        ("canvas", ["aria-label", "aria-labelledby"]),
        ("section", ["aria-label", "aria-labelledby"]),
        ("th", ["scope", "scope"]),
    ] {
        for element in elements(body, name) {
            assert!(is_named(&element, names), "<{name}{element}>");
        }
    }
    assert!(elements(body, "canvas").len() == 2 && elements(body, "th").len() > 10);
    for name in ["input", "select"] {
        for element in elements(body, name) {
            let (before, _) = body.split_once(element).unwrap();
            let in_label = before.rfind("<label>") > before.rfind("</label>");
            assert!(
                in_label || is_named(&element, ["aria-label", "aria-labelledby"]),
                "{element}"
            );
        }
    }
    let mut ids: Vec<&str> = (body.split(" id=\"").skip(1))
        .map(|rest| rest.split_once('"').unwrap().0)
        .collect();
    let all = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert!(ids.len() == all && all > 10);
    for target in body.split("aria-labelledby=\"").skip(1) {
        assert!(ids.contains(&target.split_once('"').unwrap().0));
    }
    // Colours: texts are ink or soft, on paper, panels and bands.
    let (light, dark) = style
        .split_once("@media (prefers-color-scheme: dark)")
        .unwrap();
    for scheme in [light, dark] {
        let colour = |name: &str| {
            let (_, value) = scheme.split_once(&format!("--{name}: ")[..]).unwrap();
            &value[..7]
        };
        for ground in ["paper", "panel", "band"].map(colour) {
            for text in ["ink", "soft"].map(colour) {
                assert!(contrast(text, ground) >= 4.5, "{text} on {ground}");
            }
        }
        // The frame of what has the focus, and the borders of controls.
        for shape in ["accent", "soft"].map(colour) {
            assert!(contrast(shape, colour("paper")) >= 3.0, "{shape}");
        }
    }
    for text in style
        .split([' ', ';', '{', '\n'])
        .zip(style.split([' ', ';', '{', '\n']).skip(1))
    {
        if text.0 == "color:" || text.0 == "fill:" {
            let known = ["var(--ink)", "var(--soft)", "var(--band)", "none"];
            assert!(known.contains(&text.1), "{text:?}");
        }
    }
    // A readable width, which phones have less of.
    contains(
        "style",
        style,
        &["max-width: 76rem", "@media (max-width: 40rem)"],
    );
    contains(
        "style",
        style,
        &["min(26rem, 100%)", ".scroll { overflow-x: auto; }"],
    );
    // Labels such as those of the energies of a run with inertia were wider than a phone.
    let (_, narrow) = style.split_once("@media (max-width: 40rem)").unwrap();
    contains(
        "style",
        narrow,
        &["th[scope=\"row\"] { white-space: normal; }"],
    );
}

/// Terminal and page have energies and forces by added mass, with bars; curves leave out the first
/// steps of a phase, whose forces are those of a jump.
#[test]
fn a_run_with_inertia_shows_energies_and_forces_by_added_mass() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let text = r#"
        fluid = { density = 1, inertia = "full" }
        domain = { kind = "ball", radius = 5 }
        model.tolerance = 3e-2
        gravity = [0, 0, -1]
        bodies = [{ name = "<b>", radius = 1, density = 2, position = [0, 0, 0] }]
        gait.phases = [{ duration = 1 }]
    "#;
    std::fs::write(at.join("fall.toml"), text).unwrap();
    let text = printed(at, &["run", "fall.toml", "--out", "out"]);
    contains("run", &text, &["added mass, at the end  <b>", "  force"]);
    let page = std::fs::read_to_string(at.join("out/report.html")).unwrap();
    for label in [
        "Kinetic energy of the fluid at the end",
        "Kinetic energy of the bodies at the end",
        "Force by added mass of &lt;b&gt; at the end",
    ] {
        let (_, row) = page.split_once(label).unwrap();
        let (row, _) = row.split_once("</tr>").unwrap();
        assert!(row.contains('±'), "{row}");
    }
    let numbers = data(&page);
    let plots = numbers["plots"].as_array().unwrap();
    let titles: Vec<&str> = plots
        .iter()
        .filter_map(|plot| plot["title"].as_str())
        .collect();
    assert_eq!(
        titles[titles.len() - 2..],
        ["Kinetic energy", "Forces by added mass along z"]
    );
    let curves = plots
        .iter()
        .rev()
        .take(2)
        .map(|plot| plot["series"].as_array());
    let counts: Vec<_> = curves.map(|series| series.unwrap().len()).collect();
    assert_eq!(counts, [1, 2]);
}

#[test]
fn a_folder_without_a_finished_run_has_no_page() {
    let folder = tempfile::tempdir().unwrap();
    contains(
        "view",
        &refused(folder.path(), &["view", "."]),
        &["summary.json"],
    );
}

#[test]
fn long_runs_show_as_many_whole_cycles_as_fit() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("spheres.toml"), spheres()).unwrap();
    let cycles = "gait.cycles=40";
    printed(
        at,
        &["run", "spheres.toml", "--out", "out", "--set", cycles],
    );
    let page = std::fs::read_to_string(at.join("out/report.html")).unwrap();
    let numbers = data(&page);
    let shown = numbers["cycles"]["shown"].as_u64().unwrap();
    assert_eq!(numbers["cycles"]["all"], 40);
    assert!((2..=40).contains(&shown), "{shown}");
    assert!((numbers["duration"].as_f64().unwrap() - 4.0 * shown as f64).abs() < 1e-6);
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
}

/// A thousand spheres settle: the page keeps 36 times of them, 2.4 MB in all.
#[test]
fn the_page_of_a_thousand_bodies_is_small() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let scene = "model = { kind = \"rpy\", estimates = \"off\", tolerance = 0.1 }\n\
        gait.phases = [{ duration = 0.25 }]\noutput = { samples = 4, trajectory = \"npy\" }\n\
        bodies = [{ name = \"s\", radius = 1, position = [0, 0, 0], force = [0, 0, -19] }]\n\
        copies = [{ of = \"s\", count = 999, size = [60, 60, 60], gap = 0.5 }]\n";
    std::fs::write(at.join("many.toml"), scene).unwrap();
    printed(at, &["run", "many.toml", "--out", "out"]);
    let size = |name: &str| std::fs::metadata(at.join("out").join(name)).unwrap().len();
    assert!(size("report.html") < 10_000_000, "{}", size("report.html"));
    // Five rows of 18 numbers of each body.
    assert!((0..1000).contains(&(size("trajectory.npy") - 5 * 1000 * 18 * 8)));
    assert!(!at.join("out/trajectory.csv").exists());
}

#[test]
fn the_picture_of_a_flow_has_colours_streamlines_and_bodies() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("spheres.toml"), spheres()).unwrap();
    printed(at, &["solve", "spheres.toml", "--picture", "flow.svg"]);
    let svg = std::fs::read_to_string(at.join("flow.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    assert_eq!(svg.matches("data:image/png;base64,").count(), 1);
    assert!(svg.contains("plane z = 0"));
    // Two strokes per streamline, one outline per sphere, and the arrow heads.
    assert!(svg.matches("<polyline").count() > 60);
    assert!(svg.matches("<polygon").count() > 30);
    let png = refused(at, &["solve", "spheres.toml", "--picture", "flow.png"]);
    contains("png", &png, &[".svg"]);
}

/// All models with a flow have the same one in the plane, and none inside bodies.
#[test]
fn slices_by_elements_and_by_multipoles_agree() {
    let text = pair(-2.0, 2.0).phases(&[("arm", 5.0)]).ball(8.0);
    let slice = |kind: &str| {
        let scene = text.clone().with("model.kind", kind).scene();
        start_slice(&scene, boxed(&scene).as_mut(), 1500).unwrap()
    };
    let multipoles = slice("multipole");
    // The usual mesh has an error of the velocity of one or two percent, the quadratic elements of
    // the meridian plane of a few thousandths.
    for (kind, allowed) in [("fem", 0.04), ("axisymmetric", 0.01)] {
        compare(&slice(kind), &multipoles, allowed);
    }
}

fn compare(elements: &FlowSlice, multipoles: &FlowSlice, allowed: f64) {
    let inside = |k: usize| {
        let (column, row) = (k % elements.columns, k / elements.columns);
        let [x, y] = [
            column as f64 / (elements.columns - 1) as f64,
            row as f64 / (elements.rows - 1) as f64,
        ];
        let x = elements.plane.point([x, y]);
        [-2.0, 2.0].map(|centre| (x - nalgebra::Vector3::x() * centre).norm() - 1.0)
    };
    let scale = multipoles.largest_speed();
    let mut compared = 0;
    for (k, pair) in elements.values.iter().zip(&multipoles.values).enumerate() {
        let clearance = inside(k).into_iter().fold(f64::INFINITY, f64::min);
        match pair {
            (Some(a), Some(b)) => {
                let difference = (a.velocity - b.velocity).norm() / scale;
                within(difference, allowed, format!("the usual mesh, at point {k}"));
                assert!(a.pressure.is_some() && b.pressure.is_none());
                compared += 1;
            }
            (None, None) => assert!(clearance < 1e-2, "{clearance}"),
            _ => {
                within(
                    clearance,
                    2e-2,
                    "curved cells reach over surfaces by 1e-2 of their size",
                );
            }
        }
    }
    assert!(compared > 1000, "{compared} of {}", elements.values.len());
}

#[test]
fn planes_contain_the_bodies_and_the_direction_of_motion() {
    let normal = |text: &SceneText| {
        let scene = text.scene();
        let values = scene.articulation().initial_shape();
        let poses = (scene.articulation())
            .place(&scene.initial_state(), values)
            .unwrap();
        let plane = SliceFrame::from_scene(&scene)
            .unwrap()
            .around(&scene, values, &poses);
        let normal = plane.normal();
        (normal * normal[normal.iamax()].signum(), plane)
    };
    let two = SceneText::new()
        .sphere("a", 1.0, [0, 0, 5])
        .sphere("b", 1.0, [0, 4, 9]);
    // A triangle in the plane x = 0, and a line in it.
    let three = two.clone().sphere("c", 1.0, [0, -4, 9]);
    for text in [three, two] {
        within(
            (normal(&text).0 - nalgebra::Vector3::x()).norm(),
            1e-12,
            "rounding",
        );
    }
    // Above a wall the window ends with a strip beyond the wall, and its second direction is the
    // normal.
    let wall = SceneText::new()
        .sphere("a", 1.0, [3.0, 0.0, 1.5])
        .with("domain.kind", "wall");
    let plane = normal(&wall).1;
    assert_eq!(plane.up, nalgebra::Vector3::z());
    let strip = 0.02 * plane.width;
    let end = plane.centre.z - 0.5 * plane.height;
    within(end + strip, 1e-12, "rounding");
    // A wall that is near is shown too, and one that is far is not.
    for (height, shown) in [(3.0, true), (8.0, false)] {
        let text = SceneText::new().sphere("a", 1.0, [0.0, 0.0, height]);
        let plane = normal(&text.with("domain.kind", "wall")).1;
        assert_eq!(plane.centre.z - 0.5 * plane.height < 0.0, shown);
    }
    // In a ball it is not larger than the ball and the strip on both sides, and about its centre.
    let ball = SceneText::new().sphere("a", 1.0, [0; 3]).ball(2.0);
    let plane = normal(&ball).1;
    within(plane.width - 4.0 - 2.0 * 0.02 * 5.2, 1e-12, "rounding");
    within(plane.centre.norm(), 1e-12, "rounding");
}
