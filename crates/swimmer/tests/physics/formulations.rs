//! The three formulations of the constraints have the same solution, with every solver, for every
//! kind of arm.

use linalg::SaddleLdlt;
use nalgebra::{DMatrix, DVector, Vector3};
use rigid::{DirectRows, Eliminated, Formulation, Lagrange, Reduction};
use swimmer::models::{FemModel, Hydrodynamics, InstantaneousSolution};
use swimmer::start_resistance;
use testkit::{SceneText, boxed, chain, start, start_by, within};

/// A bent chain of three unequal spheres off the centre of a ball, with external loads.
fn scene(arms: &str) -> SceneText {
    SceneText::new()
        .shape("a", "radius = 1, force = [0, 0.5, 0]", [-4, 0, 0])
        .shape("b", "radius = 1.3, torque = [0, 0, 1]", [0.5, 0.0, 0.0])
        .sphere("c", 0.8, [1.0, 4.0, 0.5])
        .slide("ab", "a", "b")
        .slide("cb", "c", "b")
        .phase("link = \"ab\", length = 4, duration = 0.5")
        .ball(6.5)
        .elements(0.7)
        .with("gait.arms", arms)
        .with("fem.rtol", "1e-11")
}

fn instant(arms: &str, formulation: &str, solver: &str) -> InstantaneousSolution {
    solved(arms, formulation, solver, "on")
}

/// The solution of the discrete problem: corrections agree to the accuracy of their iteration only.
fn discrete(arms: &str, formulation: &str, solver: &str) -> InstantaneousSolution {
    solved(arms, formulation, solver, "off")
}

fn solved(arms: &str, formulation: &str, solver: &str, estimates: &str) -> InstantaneousSolution {
    let text = scene(arms)
        .with("fem.formulation", formulation)
        .with("fem.solver", solver);
    start(&text.with("fem.estimates", estimates).scene())
}

/// Relative differences of velocities and of forces, including those of the joints.
fn difference(a: &InstantaneousSolution, b: &InstantaneousSolution) -> [f64; 2] {
    let (mut error, mut size) = ([0.0_f64; 2], [0.0_f64; 2]);
    for (a, b) in a.bodies.iter().zip(&b.bodies) {
        for (k, (x, y)) in [
            (a.velocity, b.velocity),
            (a.angular_velocity, b.angular_velocity),
            (a.force, b.force),
            (a.torque, b.torque),
        ]
        .into_iter()
        .enumerate()
        {
            error[k / 2] = error[k / 2].max((x - y).amax());
            size[k / 2] = size[k / 2].max(x.amax());
        }
    }
    for (x, y) in a.joint_loads.iter().zip(&b.joint_loads) {
        let difference = (x.force - y.force).amax().max((x.torque - y.torque).amax());
        error[1] = error[1].max(difference).max((x.drive - y.drive).abs());
        size[1] = size[1].max(x.force.amax());
    }
    [error[0] / size[0], error[1] / size[1]]
}

#[test]
fn formulations_agree_with_the_direct_solver_to_rounding() {
    for arms in ["clamped", "free", "lab"] {
        let eliminated = discrete(arms, "p-tilde", "direct");
        for formulation in ["lagrange", "direct-row"] {
            let [velocity, force] = difference(&eliminated, &discrete(arms, formulation, "direct"));
            let why = "a true residual of 1e-12, which forces amplify by about 1e3";
            within(
                velocity.max(force),
                1e-9,
                format!("{why}: {arms} {formulation}"),
            );
        }
    }
}

#[test]
fn formulations_need_the_same_number_of_iterations() {
    let iterations = |formulation| instant("clamped", formulation, "block").solver.iterations;
    let eliminated = iterations("p-tilde");
    for formulation in ["lagrange", "direct-row"] {
        // At most 10 % more, because the coarsest level solves the constraint rows exactly.
        let count = iterations(formulation);
        assert!(
            10 * count <= 11 * eliminated,
            "{formulation}: {count} against {eliminated}"
        );
    }
}

#[test]
fn bug_direct_rows_mixed_momentum_into_constraints() {
    // Restricting constraint rows with the motions of their columns doubled the iterations.
    let [velocity, _] = difference(
        &discrete("free", "direct-row", "block"),
        &discrete("free", "p-tilde", "block"),
    );
    within(velocity, 1e-8, "true residuals of 1e-11 on both sides");
}

#[test]
fn joint_forces_balance_fluid_forces_and_external_loads() {
    for formulation in ["p-tilde", "lagrange", "direct-row"] {
        let solution = instant("free", formulation, "direct");
        // Sphere `a` has the joint `ab` only, and the external force (0, 0.5, 0); `c` has `cb`
        // only.
        let [a, c] = [0, 2].map(|body| solution.bodies[body].force);
        let scale = a.amax();
        let pull = Vector3::new(0.0, 0.5, 0.0);
        let why = "balances to 1e-12, amplified by resistances of about 6 pi over velocities of 1";
        within(
            (solution.joint_loads[0].force + pull - a).amax(),
            1e-10 * scale,
            why,
        );
        within(
            (solution.joint_loads[1].force - c).amax(),
            1e-10 * scale,
            why,
        );
    }
}

#[test]
fn the_condensed_resistance_gives_the_motion_of_the_coupled_solve() {
    // The scene's units are not those of the flow: viscosity 3, smallest radius 0.8.
    let text = scene("free").with("fluid.viscosity", 3);
    // Corrections agree to the accuracy of their iteration only.
    let scene = text.with("fem.estimates", "off").scene();
    let mut model = boxed(&scene);
    let coupled = start_by(model.as_mut());
    let resistance: DMatrix<f64> = start_resistance(&scene, model.as_mut()).unwrap();
    assert_eq!(resistance.shape(), (18, 18));

    let set = scene.articulation();
    // The first phase closes "ab" from 4.5 to 4 in half a unit of time.
    let constraints = set
        .constraints(&scene.initial_state(), set.initial_shape(), &[-1.0, 0.0])
        .unwrap();
    let Reduction {
        surface_basis: s,
        surface_offset: w,
        ..
    } = Reduction::new(set, &constraints).unwrap();
    let mut external = DVector::zeros(18);
    external[1] = 0.5;
    external[6 + 5] = 1.0;
    let balance = s.tr_mul(&(external - &resistance * &w));
    let v = s.tr_mul(&(&resistance * &s)).lu().solve(&balance).unwrap();
    let velocities = s * v + w;
    let largest = velocities.amax();
    for (body, solved) in coupled.bodies.iter().enumerate() {
        let u = velocities.fixed_rows::<3>(6 * body) - solved.velocity;
        let omega = velocities.fixed_rows::<3>(6 * body + 3) - solved.angular_velocity;
        let why = "residuals of 1e-11, amplified by the condition of resistances from 1 to 100";
        within(u.amax().max(omega.amax()), 1e-8 * largest, why);
    }
}

/// Reciprocity: with the flow `b_k` of a unit load on the velocity `k`, nodal forces `f` change
/// that velocity by `f . b_k`, in every formulation.
#[test]
fn nodal_forces_move_bodies_according_to_the_reciprocal_theorem() {
    let scene = scene("free").scene();
    let mut model = FemModel::new(&scene).unwrap();
    let state = scene.initial_state();
    let configuration = testkit::at(&state, scene.articulation().initial_shape());
    let mesh = model.mesh(configuration).unwrap().unwrap();
    let forces: Vec<_> = (0..mesh.n_points())
        .map(|i| Vector3::from_fn(|c, _| ((3 * i + c) as f64).sin()))
        .collect();
    // The fluid is enclosed, so the sources have zero mean.
    let mut sources: Vec<f64> = (0..mesh.n_vertices()).map(|i| (i as f64).cos()).collect();
    let mean = sources.iter().sum::<f64>() / sources.len() as f64;
    sources.iter_mut().for_each(|s| *s -= mean);
    let formulations: [&dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];
    for formulation in formulations {
        let system = model
            .system(configuration, &[0.0, 0.0], formulation)
            .unwrap();
        let mut factor = SaddleLdlt::factor(&system.system, &Default::default()).unwrap();
        let mut solve = |rhs: &[f64]| {
            let mut solution = vec![0.0; rhs.len()];
            factor.solve(rhs, &mut solution).unwrap();
            solution
        };
        let moved = solve(&system.rhs_of_forces(&forces, &sources).unwrap());
        let moved = system.generalised_of_loads(&moved).unwrap();
        for k in 0..moved.len() {
            let mut load = DVector::zeros(moved.len());
            load[k] = 1.0;
            let unit = solve(&system.rhs_of_loads(&load).unwrap());
            let (velocity, pressure) = system.flow_of_loads(&unit).unwrap();
            let by_velocity: f64 = velocity.iter().zip(&forces).map(|(u, f)| u.dot(f)).sum();
            let by_pressure: f64 = pressure.iter().zip(&sources).map(|(p, s)| p * s).sum();
            let difference = moved[k] - by_velocity - by_pressure;
            let why = format!("true residuals of 1e-12: {} {k}", formulation.name());
            within(difference, 1e-8 * moved.amax(), why);
        }
    }
}

/// The pressure preconditioner accounts for narrow gaps; with the mass matrix alone the number of
/// iterations grows by two thirds.
#[test]
fn narrow_gaps_do_not_increase_the_iterations() {
    let iterations = |gap: f64| {
        let pair = chain(&["a", "b"], &[0.0, 2.0 + gap])
            .ball(6.5)
            .elements(0.7);
        let loads = ["bodies.a.force=[1, 0, 0]", "bodies.b.force=[0, 1, 1]"];
        let text = pair.with("fem.estimates", "off").set(&loads);
        start(&text.scene()).solver.iterations
    };
    let (wide, narrow) = (iterations(2.0), iterations(0.1));
    assert!(5 * narrow <= 6 * wide, "{wide} and {narrow}");
}
