//! Thermal noise: random loads have the covariance that the mobility dissipates.

use models::{
    Capabilities, Configuration, FemModel, Hydrodynamics, Query, SphereModel, SpheresModel,
};
use nalgebra::{DMatrix, DVector};
use rigid::{Articulation, StateVelocity};
use scene::Scene;
use testkit::within;

/// Rates of the coordinates of the state, in the order of `Articulation::state_velocities`.
fn coordinates(set: &Articulation, motion: &StateVelocity) -> DVector<f64> {
    let mut vectors = Vec::new();
    for (linkage, frame) in set.linkages().iter().zip(&motion.frames) {
        vectors.push(frame.linear);
        if linkage.bodies.len() > 1 {
            vectors.push(frame.angular);
        }
    }
    let own = (0..set.kinds().len()).filter(|&body| set.has_own_attitude(body));
    vectors.extend(own.map(|body| motion.spins[body]));
    let entries = vectors.iter().flatten().chain(&motion.joints).copied();
    DVector::from_vec(entries.collect())
}

/// The change of the motion at the start by loads, with the velocity without loads as origin.
fn moved(model: &mut SpheresModel, loads: &DVector<f64>) -> DVector<f64> {
    let scene = model.scene().clone();
    let (state, shape) = (scene.initial_state(), scene.articulation().initial_shape());
    let rates = [vec![0.5; shape.len()]];
    let query = Query::new(Configuration::new(&state, shape), &rates);
    let motions = [query, query.with_random_loads(loads)].map(|query| {
        let solution = model.solve(&query).unwrap().remove(0);
        coordinates(scene.articulation(), &solution.motion)
    });
    &motions[1] - &motions[0]
}

/// Random loads at the start for one of the standard normal numbers one, the others zero; none
/// beyond the last number.
fn loads_of(model: &mut SpheresModel, power: f64, one: usize) -> Option<DVector<f64>> {
    let scene = model.scene().clone();
    let (state, shape) = (scene.initial_state(), scene.articulation().initial_shape());
    let mut count = 0;
    let loads = model.fluctuations().unwrap().random_loads(
        Configuration::new(&state, shape),
        power,
        &mut || {
            count += 1;
            f64::from(u8::from(count == one + 1))
        },
    );
    (one < count).then(|| loads.unwrap())
}

/// The covariance of the random velocities per power, which is exact, as the velocities are linear
/// in the normal numbers.
fn covariance(model: &mut SpheresModel, power: f64) -> DMatrix<f64> {
    let columns = (0..).map_while(|one| loads_of(model, power, one));
    let columns: Vec<_> = columns.collect();
    let velocities: Vec<_> = columns.iter().map(|loads| moved(model, loads)).collect();
    let velocities = DMatrix::from_columns(&velocities);
    &velocities * velocities.transpose() / power
}

/// The mobility of the coordinates of the state: columns of unit loads.
fn mobility(model: &mut SpheresModel) -> DMatrix<f64> {
    let set = model.scene().articulation().clone();
    let unit = |place: &usize| {
        let mut load = DVector::zeros(set.velocity_layout().len());
        load[*place] = 1.0;
        moved(model, &load)
    };
    DMatrix::from_columns(&set.state_velocities().iter().map(unit).collect::<Vec<_>>())
}

const SWIMMER: &str = r#"
bodies = [
    { name = "a", radius = 1, position = [0, 0, 3] },
    { name = "b", radius = 0.7, position = [4, 0, 3] },
    { name = "c", radius = 1.3, position = [8, 1, 4] },
    { name = "free", radius = 1, position = [3, 5, 4] },
    { name = "other", radius = 0.5, position = [-3, 2, 3] },
]
"#;

const SPRINGS: &str = r#"
[[links]]
name = "ab"
body = "b"
to = "a"
drive = "spring"
stiffness = 2
damping = 30
[[links]]
name = "bc"
body = "c"
to = "b"
joint = "hinge"
axis = [0, 1, 0]
pivot = [5, 0, 3]
drive = "free"
"#;

/// The scenes by each of the models.
fn cases() -> Vec<(String, SphereModel)> {
    let gait = "[[links]]\nname = \"ab\"\nbody = \"b\"\nto = \"a\"\n[[gait.phases]]\nlink = \"ab\"\n\
                length = 5\n";
    let ball = "[[links]]\nname = \"bc\"\nbody = \"c\"\nto = \"b\"\njoint = \"ball\"\n\
                pivot = [5, 0, 3]\n";
    let free = &format!("gait.arms = \"free\"\n{gait}")[..];
    let periodic = "domain = { kind = \"periodic\", size = [20, 18, 16] }\n";
    let wall = "domain.kind = \"wall\"\n";
    let mut cases = Vec::new();
    for kind in [
        SphereModel::Oseen,
        SphereModel::Rpy,
        SphereModel::Multipole(1e-3),
    ] {
        for joints in ["", SPRINGS, gait, ball, free] {
            cases.push((format!("{SWIMMER}{joints}"), kind));
        }
        cases.push((format!("{wall}{SWIMMER}{SPRINGS}"), kind));
    }
    let fixed = SWIMMER.replace("name = \"other\"", "name = \"other\", fixed = true");
    cases.push((format!("{fixed}{SPRINGS}"), SphereModel::Rpy));
    cases.push((format!("{fixed}{SPRINGS}"), SphereModel::Multipole(1e-3)));
    cases.push((format!("{periodic}{SWIMMER}{SPRINGS}"), SphereModel::Rpy));
    cases
}

#[test]
fn random_velocities_have_the_mobility_as_covariance() {
    for (text, kind) in cases() {
        let units = format!("fluid = {{ viscosity = 0.3, thermal_energy = 1 }}\n{text}");
        let mut model = SpheresModel::new(&Scene::parse(&units).unwrap(), kind).unwrap();
        let exact = mobility(&mut model);
        let found = covariance(&mut model, 7.0);
        // The inverse square root of point forces has a relative accuracy of 1e-6 in each number.
        let error = (&found - &exact).amax() / exact.amax();
        within(error, 1e-5, format!("{kind:?}: {text}"));
    }
}

/// The loads had the resistance of unbounded fluid, so that a sphere alone diffused as slowly as
/// the square of the mobility.
#[test]
fn bug_random_loads_by_multipoles_did_not_know_the_images_of_a_periodic_box() {
    let text = "fluid.thermal_energy = 1\n\
        domain = { kind = \"periodic\", size = [8, 7, 6] }\n\
        bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0] },\n\
        { name = \"b\", radius = 0.7, position = [4, 1, 0] }]\n\
        links = [{ name = \"ab\", body = \"b\", to = \"a\", drive = \"spring\", stiffness = 2, \
        damping = 30 }]\n";
    let kind = SphereModel::Multipole(1e-2);
    let mut model = SpheresModel::new(&Scene::parse(text).unwrap(), kind).unwrap();
    let exact = mobility(&mut model);
    let found = covariance(&mut model, 7.0);
    let error = (&found - &exact).amax() / exact.amax();
    within(error, 1e-5, "ten times the accuracy of the inverse root");
}

/// Of 17 spheres loads are found by iteration: the sum of their squares in the norm of the mobility
/// is that of as many standard normal numbers as there are coordinates.
#[test]
fn random_loads_of_many_spheres_have_the_resistance_as_covariance() {
    const SPHERES: usize = 17;
    const DRAWS: usize = 20;
    let bodies = (0..SPHERES).map(|k| {
        let place = [k % 3, k / 3 % 3, k / 9].map(|n| 2.5 * n as f64);
        format!("{{ name = \"{k}\", radius = 1, position = {place:?} }},\n")
    });
    let bodies: String = bodies.collect();
    let text = format!("fluid.thermal_energy = 1\nbodies = [\n{bodies}]\n");
    let kind = SphereModel::Multipole(1e-2);
    let mut model = SpheresModel::new(&Scene::parse(&text).unwrap(), kind).unwrap();
    let scene = model.scene().clone();
    let (state, shape) = (scene.initial_state(), scene.articulation().initial_shape());
    let places = scene.articulation().state_velocities();
    // Sums of twelve uniform numbers have a variance of one.
    let mut random = fastrand::Rng::with_seed(1);
    let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
    let mut sum = 0.0;
    for _ in 0..DRAWS {
        let configuration = Configuration::new(&state, shape);
        let fluctuations = model.fluctuations().unwrap();
        let loads = fluctuations.random_loads(configuration, 1.0, &mut normal);
        let loads = loads.unwrap();
        sum += loads.select_rows(&places).dot(&moved(&mut model, &loads));
    }
    let numbers = (6 * SPHERES * DRAWS) as f64;
    within(
        sum / numbers - 1.0,
        4.0 * (2.0 / numbers).sqrt(),
        "four standard deviations",
    );
}

#[test]
fn random_loads_do_no_work_of_the_bodies_and_have_no_bars() {
    for kind in [SphereModel::Rpy, SphereModel::Multipole(1e-3)] {
        let scene = Scene::parse(&format!("fluid.thermal_energy = 1\n{SWIMMER}{SPRINGS}")).unwrap();
        let mut model = SpheresModel::new(&scene, kind).unwrap();
        let loads = loads_of(&mut model, 1.0, 3).unwrap();
        let (state, shape) = (scene.initial_state(), scene.articulation().initial_shape());
        let rates = [vec![0.0; shape.len()]];
        let query = Query::new(Configuration::new(&state, shape), &rates);
        let solution = model
            .solve(&query.with_random_loads(&loads))
            .unwrap()
            .remove(0);
        // Springs are at rest; the bodies take from the fluid what the dashpot dissipates.
        let dashpot = -30.0 * solution.motion.joints[0].powi(2);
        let of_bodies = solution.power_in(&solution);
        let error = solution.power() - dashpot;
        within(error, 1e-8 * of_bodies, "residuals of 1e-10");
        assert!(solution.error_estimate.estimated().is_none());
    }
}

#[test]
fn other_models_have_no_thermal_noise() {
    let text = "domain = { kind = \"ball\", radius = 9 }\n\
                bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0] }]";
    let noisy = Scene::parse(&format!("fluid.thermal_energy = 1\n{text}")).unwrap();
    let mut model = FemModel::new(&Scene::parse(text).unwrap()).unwrap();
    let error = model.fluctuations().err().unwrap().to_string();
    assert!(
        error.contains("thermal noise by the model 'fem'"),
        "{error}"
    );
    let error = model.capabilities().check_noise(&noisy, "fem").unwrap_err();
    assert!(
        error.to_string().contains("scene.toml:1: thermal noise"),
        "{error}"
    );
    let spheres = SpheresModel::new(&noisy, SphereModel::Rpy).unwrap();
    spheres.capabilities().check_noise(&noisy, "rpy").unwrap();
    Capabilities::default()
        .check_noise(model.scene(), "any")
        .unwrap();
}
