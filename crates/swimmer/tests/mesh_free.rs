//! Scenes by the models without a mesh, against exact strokes.

use nalgebra::Vector3;
use swimmer::choose;
use swimmer::{Method, Outcome, Scene, simulate, solve_start};

/// The three-sphere swimmer of Najafi & Golestanian (2004): arms of 10 close to 6 and open again.
fn three_spheres(domain: &str, model: &str, tolerance: f64) -> Scene {
    let phases: String = [("left", 6), ("right", 6), ("left", 10), ("right", 10)]
        .map(|(link, length)| format!("[[gait.phases]]\nlink = \"{link}\"\nlength = {length}\n"))
        .concat();
    Scene::parse(&format!(
        "domain = {domain}\n\
         bodies = [\n\
           {{ name = \"l\", radius = 1, position = [-10, 0, 0] }},\n\
           {{ name = \"c\", radius = 1, position = [0, 0, 0] }},\n\
           {{ name = \"r\", radius = 1, position = [10, 0, 0] }},\n\
         ]\n\
         links = [{{ name = \"left\", body = \"l\", to = \"c\" }}, {{ name = \"right\", body = \"r\", to = \"c\" }}]\n\
         model = {{ kind = \"{model}\", tolerance = {tolerance:e} }}\n{phases}"
    ))
    .unwrap()
}

const UNBOUNDED: &str = "{ kind = \"unbounded\" }";

fn run(scene: &Scene) -> Outcome {
    let mut model = choose(scene).unwrap().model;
    simulate(scene, model.as_mut(), Method::Collocation, &mut ()).unwrap()
}

#[test]
fn the_three_sphere_stroke_by_every_model() {
    // steps of the centre sphere: full-inverse Oseen, RPY, exact (bispherical series and collocation agree to 1e-12)
    for (model, steps, net) in [
        (
            "oseen",
            [-1.353092738366866, 1.4391384581513114],
            0.1720914395688904,
        ),
        (
            "rpy",
            [-1.3529873030998665, 1.435496826965346],
            0.16501904773095988,
        ),
        (
            "multipole",
            [-1.352634331801177, 1.4325370019952646],
            0.1598053403881754,
        ),
    ] {
        let outcome = run(&three_spheres(UNBOUNDED, model, 1e-8));
        for (leg, step) in outcome.legs.iter().zip(steps) {
            assert!(
                (leg.displacement[1].x - step).abs() < 1e-8,
                "{model}: {} {step}",
                leg.displacement[1].x
            );
        }
        assert!(
            (outcome.displacement[1].x - net).abs() < 1e-8,
            "{model}: {}",
            outcome.displacement[1].x
        );
        assert!(outcome.tolerance_met);
        assert!(outcome.displacement[1].yz().norm() < 1e-12 && outcome.rotation.norm() < 1e-12);
    }
}

#[test]
fn the_three_sphere_stroke_in_balls() {
    for (radius, net) in [
        (25, 0.15973257986289502),
        (40, 0.1604180159643671),
        (80, 0.15993017649902952),
    ] {
        let domain = format!("{{ kind = \"ball\", radius = {radius} }}");
        let outcome = run(&three_spheres(&domain, "multipole", 1e-8));
        assert!(
            (outcome.displacement[1].x - net).abs() < 1e-8,
            "{radius}: {}",
            outcome.displacement[1].x
        );
    }
}

#[test]
fn forces_of_an_instant_are_exact() {
    let scene = three_spheres(UNBOUNDED, "multipole", 1e-8);
    let mut model = choose(&scene).unwrap().model;
    let instant = solve_start(&scene, model.as_mut()).unwrap();
    // the left arm closes by 4 in a unit of time
    let exact = [13.999647060443143, -7.6075823649615755, -6.39206469548157];
    for (body, force) in instant.bodies.iter().zip(exact) {
        assert!((body.force.x / 4.0 - force).abs() < 1e-8);
    }
    assert!((instant.bodies[1].velocity.x / 4.0 + 0.34319851471562796).abs() < 1e-9);
    // the arms carry what the fluid takes from the outer spheres
    assert!((instant.link_forces[0].x / 4.0 - exact[0]).abs() < 1e-8);
    assert!((instant.link_forces[1].x / 4.0 - exact[2]).abs() < 1e-8);
    assert!(instant.error_estimate.model.unwrap() < 1e-8);
}

#[test]
fn the_grand_resistance_of_two_spheres_is_exact() {
    // distance; XA, YA over 6 pi and XC, YC over 8 pi, of one sphere and between the two; torque along y on the first and the second per velocity
    // of the first along x, the second at +z (bispherical series and collocation agree to 1e-11)
    let rows: [[f64; 11]; 7] = [
        [
            2.01,
            27.034007866189402,
            -26.38828578772003,
            1.7669601661702743,
            -1.0414384235843006,
            1.0467746330288854,
            -0.14419486273772844,
            1.6350647188909804,
            0.2055510790191471,
            11.573346520607528,
            14.536454293278666,
        ],
        [
            2.1,
            4.032098875535826,
            -3.381198731020948,
            1.3930062706815185,
            -0.6598752547162995,
            1.0283074795047022,
            -0.11682955555065416,
            1.2330279322682758,
            0.1017398793557104,
            4.957514198404454,
            7.755259208338534,
        ],
        [
            2.5,
            1.7226670966621505,
            -1.0497515828969843,
            1.1648646878418492,
            -0.4010789130179469,
            1.0070156351185087,
            -0.06484679489849655,
            1.0527378089611032,
            0.04171539465173547,
            1.5601029448205832,
            3.7325978826509654,
        ],
        [
            3.0,
            1.3684796020864693,
            -0.6701750418364307,
            1.0921017532628983,
            -0.2971758580078487,
            1.00195915423931,
            -0.03714535267810654,
            1.0179857150673868,
            0.02166466501768628,
            0.713097351810985,
            2.329656081973579,
        ],
        [
            4.0,
            1.169470142282521,
            -0.42721185721343546,
            1.0433030159334888,
            -0.2044768580551124,
            1.000296405873926,
            -0.015630696350013323,
            1.0042257330415876,
            0.008458023398865207,
            0.2554921590327844,
            1.2334178824242785,
        ],
        [
            6.0,
            1.0674377123108103,
            -0.26271595164084754,
            1.017109476618295,
            -0.1295730650198114,
            1.0000233242100898,
            -0.0046297474229262175,
            1.0006810036537768,
            0.002392469279884549,
            0.06932504681598606,
            0.5327954313229388,
        ],
        [
            10.0,
            1.0231007598982924,
            -0.15250025700067213,
            1.0058103307936865,
            -0.07594450032495256,
            1.0000010306112477,
            -0.0010000010624835964,
            1.0000795418607156,
            0.000505770665974052,
            0.014416400689443732,
            0.1895992026819556,
        ],
    ];
    for [
        distance,
        xa11,
        xa12,
        ya11,
        ya12,
        xc11,
        xc12,
        yc11,
        yc12,
        own,
        other,
    ] in rows
    {
        let scene = Scene::parse(&format!(
            "domain.kind = \"unbounded\"\nmodel.kind = \"multipole\"\nmodel.tolerance = 1e-8\n\
             [[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 0]\n\
             [[bodies]]\nname = \"b\"\nradius = 1\nposition = [0, 0, {distance}]\n"
        ))
        .unwrap();
        let mut model = choose(&scene).unwrap().model;
        let r = swimmer::start_resistance(&scene, model.as_mut()).unwrap();
        let (force, torque) = (6.0 * std::f64::consts::PI, 8.0 * std::f64::consts::PI);
        for (row, column, exact) in [
            (2, 2, force * xa11),
            (2, 8, force * xa12),
            (0, 0, force * ya11),
            (0, 6, force * ya12),
            (5, 5, torque * xc11),
            (5, 11, torque * xc12),
            (4, 4, torque * yc11),
            (4, 10, torque * yc12),
            (4, 0, own),
            (10, 0, other),
        ] {
            let size = (r[(row, row)] * r[(column, column)]).sqrt();
            let off = (r[(row, column)] - exact).abs() / size;
            assert!(off < 1e-9, "{distance} ({row}, {column}): {off:e}");
        }
        assert!((&r - r.transpose()).amax() < 1e-11 * r.amax());
    }
}

/// Spheres on arms of 6 from a junction; the first two arms close to 4 and open again.
fn star(directions: &[Vector3<f64>], arms: &str) -> Scene {
    let bodies: String = directions
        .iter()
        .enumerate()
        .map(|(k, e)| {
            let x = 6.0 * e;
            format!(
                "[[bodies]]\nname = \"s{k}\"\nradius = 1\nposition = [{:?}, {:?}, {:?}]\n\
                 [[links]]\nname = \"a{k}\"\nbody = \"s{k}\"\nto = \"j\"\n",
                x.x, x.y, x.z
            )
        })
        .collect();
    let phases: String = [("a0", 4), ("a1", 4), ("a0", 6), ("a1", 6)]
        .map(|(link, length)| format!("[[gait.phases]]\nlink = \"{link}\"\nlength = {length}\n"))
        .concat();
    Scene::parse(&format!(
        "domain.kind = \"unbounded\"\nmodel = {{ kind = \"multipole\", tolerance = 1e-6 }}\ngait.arms = \"{arms}\"\n\
         [[bodies]]\nname = \"j\"\nshape = \"point\"\nposition = [0, 0, 0]\n{bodies}{phases}"
    ))
    .unwrap()
}

fn check_star(directions: &[Vector3<f64>], arms: &str, net: [f64; 3], rotation: [f64; 3]) {
    let outcome = run(&star(directions, arms));
    let (net, rotation) = (Vector3::from(net), Vector3::from(rotation));
    let off = (outcome.displacement[0] - net).norm();
    assert!(off < 1e-7, "{arms}: {off:e}, {:?}", outcome.displacement[0]);
    let off = (outcome.rotation - rotation).norm();
    assert!(off < 1e-7, "{arms}: {off:e}, {:?}", outcome.rotation);
}

// Lefebvre-Lepot & Merlet (2009); collocation and a method of fundamental solutions agree to 1e-11.
#[test]
fn the_planar_swimmer_swims_and_turns() {
    let directions = [0.0, 1.0, 2.0].map(|k| {
        let angle = k * std::f64::consts::TAU / 3.0;
        Vector3::new(angle.cos(), angle.sin(), 0.0)
    });
    check_star(
        &directions,
        "clamped",
        [0.004791832418980625, -0.0026805960395928506, 0.0],
        [0.0, 0.0, 0.027120360738385564],
    );
    check_star(
        &directions,
        "free",
        [0.004667202336353144, -0.002607693358089058, 0.0],
        [0.0, 0.0, 0.02815968765431789],
    );
    check_star(
        &directions,
        "lab",
        [0.007340621150791131, -0.004238109597428583, 0.0],
        [0.0, 0.0, 0.0],
    );
}

// Alouges et al. (2013); collocation and a method of fundamental solutions agree to 1e-11.
#[test]
fn the_tetrahedral_swimmer_swims_and_turns() {
    let directions = [
        (1.0, 1.0, 1.0),
        (1.0, -1.0, -1.0),
        (-1.0, 1.0, -1.0),
        (-1.0, -1.0, 1.0),
    ]
    .map(|(x, y, z)| Vector3::new(x, y, z) / 3.0_f64.sqrt());
    check_star(
        &directions,
        "clamped",
        [
            7.608613702185518e-05,
            0.0045765204228767975,
            0.004576520422876715,
        ],
        [0.0, 0.016624558666787786, -0.016624558666787737],
    );
    check_star(
        &directions,
        "free",
        [
            7.758427939318449e-05,
            0.0044049086287823325,
            0.004404908628781979,
        ],
        [0.0, 0.017612231013913925, -0.01761223101391386],
    );
    check_star(
        &directions,
        "lab",
        [0.0, 0.006762950325282432, 0.0067629503252824175],
        [0.0, 0.0, 0.0],
    );
}

#[test]
fn auto_takes_three_rungs_for_three_tolerances_and_meets_each() {
    let exact = 0.1598053403881754;
    let mut taken = Vec::new();
    for tolerance in [1e-2, 1e-4, 1e-8] {
        let scene = three_spheres(UNBOUNDED, "auto", tolerance);
        let mut choice = choose(&scene).unwrap();
        assert_eq!(choice.reasons.len(), 3, "{:?}", choice.reasons);
        let net = run(&scene).displacement[1].x;
        assert!(
            (net / exact - 1.0).abs() <= tolerance,
            "{tolerance:e}: {net}"
        );
        let start = solve_start(&scene, choice.model.as_mut()).unwrap();
        taken.push((choice.model.name(), start.dofs.total));
    }
    taken.dedup();
    assert_eq!(taken.len(), 3, "{taken:?}");
}

#[test]
fn auto_takes_rpy_where_it_is_good_enough() {
    // RPY errs by 3 % of this stroke
    let choice = choose(&three_spheres(UNBOUNDED, "auto", 0.1)).unwrap();
    assert_eq!(choice.model.name(), "rpy");
}

#[test]
fn a_sphere_pulled_along_a_wall_is_slowed_as_goldman_found() {
    let scene = Scene::parse(
        "domain.kind = \"wall\"\nmodel = { kind = \"multipole\", tolerance = 1e-6 }\nfluid.viscosity = 2\n\
         bodies = [{ name = \"a\", radius = 0.5, position = [0, 0, 1], force = [0, 0, 1] }]\n",
    )
    .unwrap();
    let mut model = choose(&scene).unwrap().model;
    let instant = solve_start(&scene, model.as_mut()).unwrap();
    // Brenner (1961): 2.1255355667600404 times Stokes' drag at a height of two radii
    let exact = 1.0 / (6.0 * std::f64::consts::PI * 2.0 * 0.5 * 2.1255355667600404);
    assert!((instant.bodies[0].velocity.z / exact - 1.0).abs() < 1e-8);
    let resistance = model
        .resistance(models::Configuration {
            state: &scene.initial_state(),
            lengths: &[],
        })
        .unwrap();
    assert!((resistance[(2, 2)] * exact - 1.0).abs() < 1e-8);
}

#[test]
fn templates_swim_as_they_say() {
    for (text, body, net) in [
        (
            include_str!("../templates/three-sphere.toml"),
            1,
            [0.1598053404, 0.0, 0.0],
        ),
        (
            include_str!("../templates/planar.toml"),
            0,
            [0.0047918, -0.0026806, 0.0],
        ),
        (
            include_str!("../templates/tetrahedral.toml"),
            0,
            [0.0000761, 0.0045765, 0.0045765],
        ),
    ] {
        let scene = Scene::parse(text).unwrap();
        let found = run(&scene).displacement[body];
        let exact = Vector3::from(net);
        // the tolerance is on the mean of the bodies, a junction turns about it
        let tolerance = 2.0 * scene.model().tolerance * exact.norm();
        assert!((found - exact).norm() < tolerance + 1e-7, "{found} {exact}");
    }
    let chain = run(&Scene::parse(include_str!("../templates/chain.toml")).unwrap());
    assert!(chain.net() > 0.01);
}

#[test]
fn pictures_show_the_flow_around_spheres() {
    for (domain, wall) in [
        ("{ kind = \"unbounded\" }", false),
        ("{ kind = \"ball\", radius = 8 }", true),
        ("{ kind = \"wall\" }", true),
    ] {
        let scene = Scene::parse(&format!(
            "domain = {domain}\nmodel = {{ kind = \"multipole\", tolerance = 1e-4 }}\n\
             bodies = [{{ name = \"a\", radius = 1, position = [0, 0, 2], force = [1, 0, 0] }}, \
             {{ name = \"b\", radius = 0.5, position = [3, 0, 2] }}]"
        ))
        .unwrap();
        let mut model = choose(&scene).unwrap().model;
        let instant = solve_start(&scene, model.as_mut()).unwrap();
        let flow = swimmer::start_flow(&scene, model.as_mut()).unwrap();
        // nothing is faster than the surface that drives it
        let fastest = instant.bodies[0].velocity.norm() + instant.bodies[0].angular_velocity.norm();
        assert!(flow.velocity.iter().all(|u| u.norm() <= 1.001 * fastest));
        let outer = flow.mesh.tag("outer").unwrap();
        let still = flow
            .mesh
            .nodes_on(outer)
            .iter()
            .filter(|&&node| flow.velocity[node as usize] == Vector3::zeros())
            .count();
        assert_eq!(still > 0, wall, "{domain}");
        for (body, motion) in ["a", "b"].iter().zip(&instant.bodies) {
            let tag = flow.mesh.tag(body).unwrap();
            let centre = scene
                .bodies()
                .iter()
                .find(|b| b.name == *body)
                .unwrap()
                .position;
            for &node in flow.mesh.nodes_on(tag).iter() {
                let arm = flow.mesh.points()[node as usize] - centre;
                let exact = motion.velocity + motion.angular_velocity.cross(&arm);
                assert!((flow.velocity[node as usize] - exact).norm() < 1e-9 * fastest);
            }
        }
    }
}
