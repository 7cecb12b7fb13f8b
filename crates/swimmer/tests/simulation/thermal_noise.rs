//! Runs with thermal noise: diffusion, reproducibility, and what is refused.

use std::f64::consts::PI;

use scene::Scene;
use swimmer::{
    Method, NoiseNumbers, Outcome, Report, choose, choose_for_run, run_without_files, simulate,
};
use testkit::{resumed_after_one_phase, within};

/// A swimmer of three spheres above a wall and a lone sphere, in two phases.
const SWIMMER: &str = r#"
fluid = { thermal_energy = 0.2, seed = 5 }
domain.kind = "wall"
contact = { range = 0.2, strength = 1 }
bodies = [
    { name = "a", radius = 1, position = [0, 0, 4] },
    { name = "b", radius = 1, position = [6, 0, 4] },
    { name = "c", radius = 1, position = [12, 0, 4] },
    { name = "d", radius = 0.5, position = [6, 5, 3] },
]
links = [
    { name = "ab", body = "a", to = "b" },
    { name = "bc", body = "c", to = "b", drive = "spring", stiffness = 5 },
]
[model]
kind = "rpy"
[gait]
cycles = 1
phases = [{ link = "ab", length = 4, duration = 0.2 }, { link = "ab", length = 6, duration = 0.2 }]
"#;

fn run(scene: Scene) -> Report {
    run_without_files(scene, &mut ()).unwrap()
}

#[test]
fn a_sphere_diffuses_as_by_stokes_and_einstein() {
    let (energy, viscosity, radius, duration) = (0.3, 2.0, 0.5, 40.0);
    let text = format!(
        "fluid = {{ thermal_energy = {energy}, viscosity = {viscosity}, time_step = 0.01 }}\n\
         bodies = [{{ name = \"a\", radius = {radius}, position = [0, 0, 0] }}]\n\
         gait.phases = [{{ duration = {duration} }}]\n"
    );
    let report = run(Scene::parse(&text).unwrap());
    let outcome = &report.outcome;
    let velocities = outcome
        .samples
        .iter()
        .filter_map(|sample| sample.bodies.as_ref());
    let (mut moved, mut turned, mut steps) = (0.0, 0.0, 0.0_f64);
    for bodies in velocities {
        moved += (bodies[0].velocity * 0.01).norm_squared();
        turned += (bodies[0].angular_velocity * 0.01).norm_squared();
        steps += 1.0;
    }
    assert_eq!(steps, 4000.0);
    let diffusion = energy / (6.0 * PI * viscosity * radius);
    let rotational = energy / (8.0 * PI * viscosity * radius.powi(3));
    // Sums of 3 n squares of normal numbers: four standard deviations sqrt(2 / (3 n)).
    let bound = 4.0 * (2.0 / (3.0 * steps)).sqrt();
    within(
        moved / (6.0 * diffusion * duration) - 1.0,
        bound,
        "statistics",
    );
    within(
        turned / (6.0 * rotational * duration) - 1.0,
        bound,
        "statistics",
    );
    let numbers = NoiseNumbers::new(&report.scene).unwrap().unwrap();
    assert_eq!((numbers.steps, outcome.solves), (4000, 8000));
    within(numbers.diffusion - diffusion, 1e-15, "rounding");
    within(numbers.rotational_diffusion - rotational, 1e-15, "rounding");
    // A lone sphere does no work on the fluid that moves it.
    within(outcome.work, 1e-9 * energy, "rounding");
    assert!(outcome.error_estimate.estimated().is_none());
    report.check_tolerance().unwrap();
    let summary = report.summary();
    assert_eq!(summary["thermal_noise"]["steps"], 4000);
    assert_eq!(summary["thermal_noise"]["energy"], energy);
    assert_eq!(summary["thermal_noise"]["seed"], 1);
    assert_eq!(summary["tolerance_met"], true);
}

/// Poses of all samples.
fn path(outcome: &Outcome) -> Vec<Vec<nalgebra::Isometry3<f64>>> {
    outcome
        .samples
        .iter()
        .map(|sample| sample.poses.clone())
        .collect()
}

/// Springs between pairs of spheres have their rest length and the energy `k_B T / 2` on average.
#[test]
fn springs_have_half_of_the_thermal_energy_each() {
    let (pairs, steps, stiffness, energy, length) = (8, 4000_u32, 5.0, 0.45, 4.0);
    // the mobility along a pair by Rotne, Prager and Yamakawa, for radii and viscosity 1
    let both = 2.0 - 4.0 / 3.0 / (length * length);
    let mobility = 2.0 * (1.0 / (6.0 * PI) - both / (8.0 * PI * length));
    let rate = stiffness * mobility;
    let part = 0.05;
    let step = part / rate;
    let places = || (0..pairs).map(|k| 60.0 * f64::from(k));
    let bodies = places().enumerate().map(|(k, y)| {
        format!(
            "{{ name = \"a{k}\", radius = 1, position = [0, {y}, 0] }},\n\
             {{ name = \"b{k}\", radius = 1, position = [{length}, {y}, 0] }},\n"
        )
    });
    let links = (0..pairs).map(|k| {
        format!(
            "{{ name = \"l{k}\", body = \"a{k}\", to = \"b{k}\", drive = \"spring\", \
             stiffness = {stiffness} }},\n"
        )
    });
    let text = format!(
        "fluid = {{ thermal_energy = {energy}, seed = 3, time_step = {step} }}\n\
         model.kind = \"rpy\"\n\
         bodies = [\n{}]\nlinks = [\n{}]\n\
         gait.phases = [{{ duration = {} }}]\n",
        bodies.collect::<String>(),
        links.collect::<String>(),
        f64::from(steps) * step,
    );
    let report = run(Scene::parse(&text).unwrap());
    let lengths: Vec<f64> = (report.outcome.samples.iter())
        .filter(|sample| sample.bodies.is_some())
        .flat_map(|sample| {
            let centre = |k: usize| sample.poses[k].translation.vector;
            let pairs = 0..usize::try_from(pairs).unwrap();
            let apart = pairs.map(|k| (centre(2 * k + 1) - centre(2 * k)).norm());
            apart.collect::<Vec<_>>()
        })
        .collect();
    let count = lengths.len() as f64;
    assert_eq!(count, f64::from(steps) * f64::from(pairs));
    let mean = lengths.iter().sum::<f64>() / count;
    let variance = lengths.iter().map(|l| (l - length).powi(2)).sum::<f64>() / count;
    // The midpoint method with a step of `part` relaxation times, and at the middle of steps.
    let ends =
        (1.0 - part + part * part / 4.0) / (1.0 - part + part * part / 2.0 - part.powi(3) / 8.0);
    let middle = ends * (1.0 - part / 2.0).powi(2) + part / 2.0;
    let exact = energy / stiffness;
    // Four standard deviations: squares are correlated over half a relaxation time.
    let bound = 4.0 * (2.0 / (part * count)).sqrt();
    within(variance / (exact * middle) - 1.0, bound, "statistics");
    within((mean - length) / exact.sqrt(), bound, "statistics");
}

#[test]
fn runs_of_a_seed_have_the_same_bits_for_any_threads_and_after_a_resume() {
    let scene = || Scene::parse(SWIMMER).unwrap();
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| path(&run(scene()).outcome))
    };
    let [one, two] = [1, 2].map(with_threads);
    assert_eq!(one, two);
    let resumed = resumed_after_one_phase(scene);
    assert_eq!(path(&resumed.outcome), one);
    let other = Scene::parse(&SWIMMER.replace("seed = 5", "seed = 6")).unwrap();
    assert_ne!(path(&run(other).outcome), one);
}

#[test]
fn instants_other_methods_and_other_models_are_refused() {
    let noisy = Scene::parse(SWIMMER).unwrap();
    let error = choose(&noisy).err().unwrap().to_string();
    for part in ["scene.toml:2", "one instant", "swim run"] {
        assert!(error.contains(part), "{error}");
    }
    let mut model = choose_for_run(&noisy, &mut ()).unwrap().model;
    for method in [
        Method::Collocation,
        Method::RungeKutta,
        Method::Euler { steps: 3 },
    ] {
        let error = simulate(&noisy, model.as_mut(), method, &mut ()).unwrap_err();
        assert!(
            error.to_string().contains("needs the method Brownian"),
            "{error}"
        );
        assert_eq!(error.exit_code(), 2);
    }
    let cold = Scene::parse(&SWIMMER.replace("thermal_energy = 0.2, seed = 5", "")).unwrap();
    let error = simulate(&cold, model.as_mut(), Method::Brownian, &mut ()).unwrap_err();
    assert!(error.to_string().contains("Brownian"), "{error}");
    let body = "name = \"a\", position = [0, 0, 0], radius = 1";
    for (text, part) in [
        (
            format!("bodies = [{{ {body}, shape = \"spheroid\", half_length = 2 }}]"),
            "fluid.thermal_energy",
        ),
        (
            format!("domain = {{ kind = \"cylinder\", radius = 9 }}\nbodies = [{{ {body} }}]"),
            "fluid.thermal_energy",
        ),
    ] {
        let scene = Scene::parse(&format!("fluid.thermal_energy = 1\n{text}")).unwrap();
        let error = choose_for_run(&scene, &mut ()).err().unwrap().to_string();
        assert!(
            error.contains("scene.toml:1") && error.contains("use spheres"),
            "{part}: {error}"
        );
    }
}

#[test]
fn spheres_are_moved_by_expansions_where_these_are_cheap_and_by_rpy_in_crowds() {
    let body = |k: usize| {
        let (x, y) = (4 * (k % 10), 4 * (k / 10));
        format!("{{ name = \"{k}\", radius = 1, position = [{x}, {y}, 9] }},\n")
    };
    let model = |count: usize, keys: &str| {
        let bodies: String = (0..count).map(body).collect();
        let text = format!("fluid.thermal_energy = 1\n{keys}\nbodies = [\n{bodies}]\n");
        choose_for_run(&Scene::parse(&text).unwrap(), &mut ())
            .unwrap()
            .model
            .name()
    };
    assert_eq!(model(2, ""), "multipole");
    assert_eq!(model(2, "domain.kind = \"wall\""), "multipole");
    assert_eq!(model(60, ""), "rpy");
    let boxed = "domain = { kind = \"periodic\", size = [40, 40, 40] }";
    assert_eq!(model(2, boxed), "multipole");
    assert_eq!(model(60, boxed), "rpy");
    assert_eq!(model(2, "model.kind = \"oseen\""), "oseen");
}

#[test]
fn contact_along_a_random_path_ends_the_run_with_the_repulsion_as_remedy() {
    let text = "fluid = { thermal_energy = 3, time_step = 0.01 }\nmodel.kind = \"rpy\"\n\
                bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0] },\n\
                { name = \"b\", radius = 1, position = [2.1, 0, 0] }]\n\
                gait.phases = [{ duration = 100 }]\n";
    let report = run(Scene::parse(text).unwrap());
    let error = report.stopped.expect("contact").to_string();
    assert!(
        error.contains("touch") && error.contains("contact = { range"),
        "{error}"
    );
    assert!(report.outcome.samples.len() > 1);
}
