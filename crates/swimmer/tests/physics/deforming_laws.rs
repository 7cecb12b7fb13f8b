//! Bodies that deform in fluids with a viscosity law, by elements in space.

use std::f64::consts::PI;

use swimmer::models::{FemModel, Hydrodynamics, InstantaneousSolution, NeglectedTerm, PathPoint};
use swimmer::{Scene, choose_for_run};
use testkit::{boxed, contains, run, solve_at, within};

/// The law of Carreau with a relaxation time and an index.
fn carreau(time: f64, index: f64) -> String {
    format!(
        "fluid = {{ law = \"carreau\", zero_shear_viscosity = 1, relaxation_time = {time:?}, \
         index = {index:?} }}\n"
    )
}

/// A sphere in a ball of ten radii with keys of the body.
fn in_ball(settings: &str, keys: &str) -> Scene {
    let text = format!(
        "{settings}\nmodel.kind = \"fem\"\ndomain = {{ kind = \"ball\", radius = 10 }}\n\
         [[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 0]\n{keys}"
    );
    Scene::parse(&text).unwrap()
}

fn at_start(scene: &Scene, values: &[f64], rates: &[f64]) -> InstantaneousSolution {
    solve_at(boxed(scene).as_mut(), values, rates)
}

/// The tangential mode of degree one moves the surface like the slip of a neutral squirmer, whose
/// speed in a fluid of Carreau is 93.27406 % of the Newtonian one by a spectral program.
#[test]
fn a_tangential_mode_in_a_fluid_of_carreau_is_a_squirmer() {
    let settings = carreau(1.0, 0.5);
    let mode = "deformation = { motion = \"tangential\", modes = { p = 1 }, axis = [1, 0, 0] }";
    let deforming = at_start(&in_ball(&settings, mode), &[0.0], &[1.0]);
    let slip = "slip = { b1 = 1, b2 = 0, axis = [1, 0, 0] }";
    let slipping = at_start(&in_ball(&settings, slip), &[], &[]);
    let [one, other] = [&deforming, &slipping].map(|of| of.bodies[0].velocity.x);
    within(one - other, 1e-6, "the solver");
    within(
        deforming.power() / slipping.power() - 1.0,
        1e-5,
        "the solver",
    );
    let bar = deforming.error_estimate.total();
    within(one - 0.9327406407 * 2.0 / 3.0, bar, "the error bar");
    within(bar, 1e-2, "the bar says something");
    let unit = 16.0 / 3.0 * PI;
    let bar = deforming.power_error.total() / unit;
    within(deforming.power() / unit - 0.7524060, bar, "the error bar");
    within(bar, 2e-2, "the bar says something");
}

/// A sphere that grows in unbounded fluid has the flow of a source, whatever the viscosity: its
/// power is `∫ η(g) g² dV` with `g = √12 a' a² / r³`, by Simpson's rule in `a / r`.
#[test]
fn a_sphere_that_grows_has_the_dissipation_of_a_source_in_unbounded_fluid() {
    let (rate, index) = (0.8, 0.4);
    let scene = Scene::parse(&format!(
        "{}\nmodel.kind = \"fem\"\nbodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0] }}]\n\
         gait.phases = [{{ targets = {{ \"a.radius\" = 1.5 }} }}]",
        carreau(1.0, index)
    ))
    .unwrap();
    let found = at_start(&scene, &[1.0], &[rate]);
    const PARTS: usize = 1000;
    let density = |t: f64| {
        let g = 12.0_f64.sqrt() * rate * t.powi(3);
        // dV = 4 π r² dr = -4 π t^-4 dt
        let viscosity = (1.0 + g * g).powf(0.5 * (index - 1.0));
        4.0 * PI * viscosity * 12.0 * rate * rate * t * t
    };
    let weight = |k: usize| match k {
        0 | PARTS => 1.0,
        _ if k % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let exact: f64 = (0..=PARTS)
        .map(|k| weight(k) / (3.0 * PARTS as f64) * density(k as f64 / PARTS as f64))
        .sum();
    let bar = found.power_error.total();
    within(found.power() - exact, bar, "the error bar");
    within(bar, 2e-2 * exact, "the bar says something");
    let speed = found.bodies[0].velocity.norm();
    within(speed, found.error_estimate.total(), "the symmetry");
}

/// Two spheres in a ball that exchange volume, with a fluid and a gait.
fn exchange(fluid: &str, gait: &str) -> Scene {
    let text = format!(
        r#"
        {fluid}
        model = {{ kind = "fem", tolerance = 0.02 }}
        fem.size_factor = 1.5
        domain = {{ kind = "ball", radius = 6 }}
        bodies = [
            {{ name = "a", radius = 1, position = [-1.7, 0, 0] }},
            {{ name = "b", radius = 1.2, position = [1.7, 0, 0] }},
        ]
        links = [{{ name = "flow", body = "a", to = "b", joint = "exchange" }}]
        {gait}
        "#
    );
    Scene::parse(&text).unwrap()
}

/// The first-order change by the law, of the reciprocal theorem, is the derivative of full
/// solutions. Its relative error is that of the flow of a unit load in the norm of the energy, the
/// root of the relative difference of both forms of Newtonian flow.
#[test]
fn the_predicted_change_by_a_law_is_that_of_full_solutions() {
    let gait = "gait.phases = [{ targets = { flow = 6 } }]";
    let rates = [2.0];
    let solve = |fluid: &str| {
        let scene = exchange(fluid, gait);
        let values = scene.articulation().initial_shape().to_vec();
        at_start(&scene, &values, &rates).uncorrected()
    };
    let time = 0.1;
    let [by_gradient, newtonian, full] =
        [String::new(), carreau(0.0, 0.5), carreau(time, 0.5)].map(|fluid| solve(&fluid));
    let neglecting = carreau(time, 0.5).replace('}', ", rheology = \"newtonian\" }");
    let scene = exchange(&neglecting, gait);
    let mut model = FemModel::new(&scene).unwrap();
    let state = scene.initial_state();
    let point = PathPoint {
        configuration: testkit::at(&state, scene.articulation().initial_shape()),
        rates: &rates,
        accelerations: &[0.0],
    };
    let terms = model.neglected(NeglectedTerm::Rheology).unwrap();
    let change = terms.change(NeglectedTerm::Rheology, &point).unwrap();
    for body in 0..2 {
        let [by_gradient, newtonian, full] =
            [&by_gradient, &newtonian, &full].map(|of| of.bodies[body].velocity.x);
        let error = (by_gradient / newtonian - 1.0).abs().sqrt();
        within(error, 0.2, "the bound says something");
        // `g λ` is about a half at the surfaces, and its fourth power the next order.
        let exact = full - newtonian;
        for (form, found) in &change.parts {
            let found = found.bodies[body].velocity.x;
            within(
                found / exact - 1.0,
                error + 0.1,
                format!("{form}: the error of the mesh, and higher orders"),
            );
        }
    }
}

/// A reciprocal exchange at unequal speeds returns in a power law, and not in a fluid of Carreau.
#[test]
#[ignore = "slow: 10 s"]
fn a_reciprocal_exchange_returns_in_power_laws_only() {
    let gait = r#"
        [[gait.phases]]
        targets = { flow = 6.5 }
        duration = 1
        [[gait.phases]]
        targets = { flow = 4.1887902047863905 }
        duration = 5
    "#;
    let net = |fluid: &str| {
        let outcome = run(&exchange(fluid, gait));
        let there = outcome.spans[0].displacement[0].x;
        let bar = outcome.error_estimate.total();
        within(bar, 0.1 * there.abs(), "the bar says something");
        (outcome.displacement[0].x, there.abs(), bar)
    };
    let law = "fluid = { law = \"power-law\", consistency = 1, index = 0.6 }";
    let (returned, _, bar) = net(law);
    within(returned, bar, "the error bar");
    let (moved, there, bar) = net(&carreau(1.0, 0.5));
    // Errors of the mesh are nearly the same there and back, so that they are far below the bar.
    assert!(moved.abs() > 1e-3 * there, "{moved:e} of {there} {bar:e}");
    within(returned, 0.1 * moved.abs(), "the same path at other speeds");
}

/// A tube that undulates in a fluid of Carreau: the same on a finer mesh, within both bars, and
/// with less power than in a Newtonian fluid.
#[test]
#[ignore = "slow: 30 s"]
fn an_undulating_tube_in_a_fluid_of_carreau_is_within_its_bars() {
    let solve = |fluid: &str, factor: f64| {
        let text = format!(
            r#"
            {fluid}
            fem.size_factor = {factor:?}
            domain = {{ kind = "ball", radius = 12 }}
            [[bodies]]
            name = "worm"
            shape = "tube"
            length = 6
            radius = 0.5
            position = [0, 0, 0]
            deformation = {{ kind = "undulation", wave = "displacement", amplitude = 0.6 }}
            "#
        );
        let scene = Scene::parse(&text).unwrap();
        let values = scene.articulation().initial_shape().to_vec();
        at_start(&scene, &values, &[0.0, 2.0])
    };
    let law = carreau(1.0, 0.5);
    let [coarse, fine] = [1.5, 1.0].map(|factor| solve(&law, factor));
    let [one, other] = [&coarse, &fine].map(|of| of.bodies[0].velocity);
    let bars = coarse.error_estimate.total() + fine.error_estimate.total();
    within((one - other).norm(), bars, "both error bars");
    within(bars, 0.05 * other.norm(), "the bars say something");
    let bars = coarse.power_error.total() + fine.power_error.total();
    within(coarse.power() - fine.power(), bars, "both error bars");
    let newtonian = solve("", 1.5);
    assert!(fine.power() < 0.9 * newtonian.power());
}

/// In the meridian plane there are no deformations with a law: `auto` takes elements in space.
#[test]
fn laws_and_deformations_need_elements_in_space() {
    let text = |kind: &str| {
        format!(
            "{}model.kind = \"{kind}\"\nfem.size_factor = 2\nbodies = [{{ name = \"a\", radius = 1, \
             position = [0, 0, 0] }}]\ngait.phases = [{{ targets = {{ \"a.radius\" = 1.5 }} }}]",
            carreau(1.0, 0.5)
        )
    };
    let choice = choose_for_run(&Scene::parse(&text("auto")).unwrap(), &mut ()).unwrap();
    assert_eq!(choice.model.name(), "fem");
    for kind in ["axisymmetric", "multipole"] {
        let error = choose_for_run(&Scene::parse(&text(kind)).unwrap(), &mut ())
            .err()
            .unwrap();
        contains(kind, &error.to_string(), &["scene.toml:1", "fem"]);
    }
}
