//! Instantaneous solutions by the mesh-free models, against exact forces and resistances.

use nalgebra::Vector3;
use swimmer::{Scene, choose, solve_start};

use crate::sphere_strokes::{UNBOUNDED, three_spheres};

#[test]
fn forces_of_an_instant_are_exact() {
    let scene = three_spheres(UNBOUNDED, "multipole", 1e-8);
    let mut model = choose(&scene).unwrap().model;
    let instant = solve_start(&scene, model.as_mut()).unwrap();
    // The left arm closes by 4 per unit of time.
    let exact = [13.999647060443143, -7.6075823649615755, -6.39206469548157];
    for (body, force) in instant.bodies.iter().zip(exact) {
        assert!((body.force.x / 4.0 - force).abs() < 1e-8);
    }
    assert!((instant.bodies[1].velocity.x / 4.0 + 0.34319851471562796).abs() < 1e-9);
    // The joint forces equal the forces of the outer spheres on the fluid.
    assert!((instant.joint_forces[0].x / 4.0 - exact[0]).abs() < 1e-8);
    assert!((instant.joint_forces[1].x / 4.0 - exact[2]).abs() < 1e-8);
    assert!(instant.error_estimate.model.unwrap() < 1e-8);
}

#[test]
fn the_grand_resistance_of_two_spheres_is_exact() {
    // Distance; XA, YA over 6 pi and XC, YC over 8 pi, each self and mutual; torque along y on the
    // first and on the second sphere per velocity of the first along x, with the second sphere at
    // +z. Bispherical series and collocation agree to 1e-11.
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
        torque_self,
        torque_mutual,
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
            (4, 0, torque_self),
            (10, 0, torque_mutual),
        ] {
            let size = (r[(row, row)] * r[(column, column)]).sqrt();
            let error = (r[(row, column)] - exact).abs() / size;
            assert!(error < 1e-9, "{distance} ({row}, {column}): {error:e}");
        }
        assert!((&r - r.transpose()).amax() < 1e-11 * r.amax());
    }
}

#[test]
fn a_sphere_pulled_away_from_a_wall_has_the_drag_of_brenner() {
    let scene = Scene::parse(
        "domain.kind = \"wall\"\nmodel = { kind = \"multipole\", tolerance = 1e-6 }\nfluid.viscosity = 2\n\
         bodies = [{ name = \"a\", radius = 0.5, position = [0, 0, 1], force = [0, 0, 1] }]\n",
    )
    .unwrap();
    let mut model = choose(&scene).unwrap().model;
    let instant = solve_start(&scene, model.as_mut()).unwrap();
    // Brenner (1961): 2.1255355667600404 times the Stokes drag at a height of two radii.
    let exact = 1.0 / (6.0 * std::f64::consts::PI * 2.0 * 0.5 * 2.1255355667600404);
    assert!((instant.bodies[0].velocity.z / exact - 1.0).abs() < 1e-8);
    let resistance = swimmer::start_resistance(&scene, model.as_mut()).unwrap();
    assert!((resistance[(2, 2)] * exact - 1.0).abs() < 1e-8);
}

#[test]
fn flow_fields_satisfy_the_boundary_conditions() {
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
        // The largest velocity is on the surface of the pulled sphere.
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

#[test]
fn error_bars_of_a_resistance_contain_its_error() {
    let found = [1e-2, 1e-10].map(|tolerance| {
        let scene = Scene::parse(&format!(
            "model = {{ kind = \"multipole\", tolerance = {tolerance:e} }}\nfluid.viscosity = 3\n\
             [[bodies]]\nname = \"a\"\nradius = 2\nposition = [0, 0, 0]\n\
             [[bodies]]\nname = \"b\"\nradius = 2\nposition = [0, 3, 4]\n"
        ))
        .unwrap();
        let mut model = choose(&scene).unwrap().model;
        let matrix = swimmer::start_resistance(&scene, model.as_mut()).unwrap();
        let errors = swimmer::start_resistance_errors(&scene, model.as_mut()).unwrap();
        (matrix, errors.unwrap())
    });
    let [(coarse, bars), (fine, fine_bars)] = found;
    assert!(fine_bars.amax() < 1e-8 * fine.amax() && bars.amax() > 1e-6 * fine.amax());
    let excess = (&coarse - &fine).abs() - bars - fine_bars;
    assert!(excess.max() < 1e-9 * fine.amax(), "{:e}", excess.max());
}
