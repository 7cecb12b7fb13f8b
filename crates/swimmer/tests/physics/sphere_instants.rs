//! Instantaneous solutions by the mesh-free models, against exact forces and resistances.

use nalgebra::Vector3;
use testkit::exact::{INSTANT, NORMAL_TO_WALL_2};
use testkit::{SceneText, boxed, chain, start, start_by, start_resistance, three_spheres, within};

#[test]
fn forces_of_an_instant_are_exact() {
    let instant = start(&three_spheres().model("multipole", 1e-8).scene());
    // The left arm closes by 4 per unit of time.
    let exact = INSTANT.forces;
    for (body, force) in instant.bodies.iter().zip(exact) {
        within(body.force.x / 4.0 - force, 1e-8, "the tolerance");
    }
    within(
        instant.bodies[1].velocity.x / 4.0 - INSTANT.velocity,
        1e-9,
        "a tenth of the tolerance",
    );
    // The joint forces equal the forces of the outer spheres on the fluid.
    within(
        instant.joint_loads[0].force.x / 4.0 - exact[0],
        1e-8,
        "the tolerance",
    );
    within(
        instant.joint_loads[1].force.x / 4.0 - exact[2],
        1e-8,
        "the tolerance",
    );
    within(instant.error_estimate.model.unwrap(), 1e-8, "the tolerance");
}

#[test]
fn the_grand_resistance_of_two_spheres_is_exact() {
    // Distance; XA, YA over 6 pi and XC, YC over 8 pi, each self and mutual; torque along y on the
    // first and on the second sphere per velocity of the first along x, with the second sphere at
    // +z. Bispherical series and collocation agree to 1e-11.
    let rows = "
        2.01 27.034007866189402 -26.38828578772003 1.7669601661702743
            -1.0414384235843006 1.0467746330288854 -0.14419486273772844 1.6350647188909804
            0.2055510790191471 11.573346520607528 14.536454293278666
        2.1 4.032098875535826 -3.381198731020948 1.3930062706815185
            -0.6598752547162995 1.0283074795047022 -0.11682955555065416 1.2330279322682758
            0.1017398793557104 4.957514198404454 7.755259208338534
        2.5 1.7226670966621505 -1.0497515828969843 1.1648646878418492
            -0.4010789130179469 1.0070156351185087 -0.06484679489849655 1.0527378089611032
            0.04171539465173547 1.5601029448205832 3.7325978826509654
        3.0 1.3684796020864693 -0.6701750418364307 1.0921017532628983
            -0.2971758580078487 1.00195915423931 -0.03714535267810654 1.0179857150673868
            0.02166466501768628 0.713097351810985 2.329656081973579
        4.0 1.169470142282521 -0.42721185721343546 1.0433030159334888
            -0.2044768580551124 1.000296405873926 -0.015630696350013323 1.0042257330415876
            0.008458023398865207 0.2554921590327844 1.2334178824242785
        6.0 1.0674377123108103 -0.26271595164084754 1.017109476618295
            -0.1295730650198114 1.0000233242100898 -0.0046297474229262175 1.0006810036537768
            0.002392469279884549 0.06932504681598606 0.5327954313229388
        10.0 1.0231007598982924 -0.15250025700067213 1.0058103307936865
            -0.07594450032495256 1.0000010306112477 -0.0010000010624835964 1.0000795418607156
            0.000505770665974052 0.014416400689443732 0.1895992026819556
    ";
    let numbers: Vec<f64> = rows
        .split_whitespace()
        .map(|n| n.parse().unwrap())
        .collect();
    assert_eq!(numbers.len(), 7 * 11);
    for row in numbers.chunks(11) {
        let distance = row[0];
        let text = SceneText::new()
            .sphere("a", 1.0, [0; 3])
            .sphere("b", 1.0, [0.0, 0.0, distance]);
        let r = start_resistance(&text.model("multipole", 1e-8).scene());
        let (force, torque) = (6.0 * std::f64::consts::PI, 8.0 * std::f64::consts::PI);
        let places = [
            (2, 2),
            (2, 8),
            (0, 0),
            (0, 6),
            (5, 5),
            (5, 11),
            (4, 4),
            (4, 10),
            (4, 0),
            (10, 0),
        ];
        let units = [
            force, force, force, force, torque, torque, torque, torque, 1.0, 1.0,
        ];
        for (k, (row_number, column)) in places.into_iter().enumerate() {
            let exact = units[k] * row[1 + k];
            let size = (r[(row_number, row_number)] * r[(column, column)]).sqrt();
            let why = format!("a tenth of the tolerance: {distance} ({row_number}, {column})");
            within(r[(row_number, column)] - exact, 1e-9 * size, why);
        }
        assert!((&r - r.transpose()).amax() < 1e-11 * r.amax());
    }
}

#[test]
fn a_sphere_pulled_away_from_a_wall_has_the_drag_of_brenner() {
    let text = SceneText::new()
        .sphere("a", 0.5, [0, 0, 1])
        .model("multipole", 1e-6);
    let scene = text
        .set(&[
            "domain.kind=wall",
            "fluid.viscosity=2",
            "bodies.a.force=[0, 0, 1]",
        ])
        .scene();
    let drag = NORMAL_TO_WALL_2.value;
    let exact = 1.0 / (6.0 * std::f64::consts::PI * 2.0 * 0.5 * drag);
    let why = "a hundredth of the tolerance";
    within(start(&scene).bodies[0].velocity.z / exact - 1.0, 1e-8, why);
    within(start_resistance(&scene)[(2, 2)] * exact - 1.0, 1e-8, why);
}

#[test]
fn flow_fields_satisfy_the_boundary_conditions() {
    for (domain, wall) in [
        ("{ kind = \"unbounded\" }", false),
        ("{ kind = \"ball\", radius = 8 }", true),
        ("{ kind = \"wall\" }", true),
    ] {
        let text = SceneText::new()
            .sphere("a", 1.0, [0, 0, 2])
            .sphere("b", 0.5, [3, 0, 2]);
        let text = text
            .with("domain", domain)
            .with("bodies.a.force", "[1, 0, 0]");
        let scene = text.model("multipole", 1e-4).scene();
        let mut model = boxed(&scene);
        let instant = start_by(model.as_mut());
        let flow = swimmer::start_flow(&scene, model.as_mut()).unwrap();
        // The largest velocity is on the surface of the pulled sphere.
        let fastest = instant.bodies[0].velocity.norm() + instant.bodies[0].angular_velocity.norm();
        assert!(flow.velocity.iter().all(|u| u.norm() <= 1.001 * fastest));
        let outer = flow.mesh.tag("outer").unwrap();
        let is_still = |node: &&u32| flow.velocity[**node as usize] == Vector3::zeros();
        let still = flow.mesh.nodes_on(outer).iter().filter(is_still).count();
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
                let error = (flow.velocity[node as usize] - exact).norm();
                within(
                    error,
                    1e-9 * fastest,
                    "boundary values are set, and not computed",
                );
            }
        }
    }
}

#[test]
fn error_bars_of_a_resistance_contain_its_error() {
    let found = [1e-2, 1e-10].map(|tolerance| {
        let text = chain(&["a", "b"], &[0.0, 0.0]).model("multipole", tolerance);
        let places = ["bodies.b.position=[0, 3, 4]", "fluid.viscosity=3"];
        let radii = ["bodies.a.radius=2", "bodies.b.radius=2"];
        let scene = text.set(&places).set(&radii).scene();
        let mut model = boxed(&scene);
        let matrix = swimmer::start_resistance(&scene, model.as_mut()).unwrap();
        let errors = swimmer::start_resistance_errors(&scene, model.as_mut()).unwrap();
        (matrix, errors.unwrap())
    });
    let [(coarse, bars), (fine, fine_bars)] = found;
    assert!(fine_bars.amax() < 1e-8 * fine.amax() && bars.amax() > 1e-6 * fine.amax());
    let excess = (&coarse - &fine).abs() - bars - fine_bars;
    assert!(
        excess.max() < 1e-9 * fine.amax(),
        "rounding, {:e}",
        excess.max()
    );
}
