//! Generalised Newtonian fluids against exact values, and properties of Newton's method.

use std::f64::consts::PI;

use fem::SurplusSpace;
use mesh::TetMesh;
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;
use rheology::{Law, ViscosityLaw};
use rigid::{
    Arms, Articulation, BodyKind, Constraints, DirectRows, Drive, Eliminated, ExternalLoad,
    Formulation, Lagrange, Twist,
};
use stokes::{
    GeneralisedNewtonianSolution, InitialGuesses, Options, Problem, Solver, StokesError,
    SurfaceFlow,
};

use crate::support::sphere_in_ball;

type Vec3 = Vector3<f64>;

fn carreau(time: f64, index: f64, infinite: f64) -> Law {
    Law::Carreau {
        zero_shear_viscosity: 1.0,
        infinite_shear_viscosity: infinite,
        relaxation_time: time,
        index,
    }
}

fn power_law(index: f64) -> Law {
    Law::PowerLaw {
        consistency: 1.0,
        index,
        regularisation: 1e-4,
    }
}

/// A sphere that moves with a given velocity.
fn dragged(
    mesh: &TetMesh,
    law: &dyn ViscosityLaw,
    velocity: Vec3,
    (options, guesses): (&Options, &mut InitialGuesses),
) -> Result<GeneralisedNewtonianSolution, StokesError> {
    let problem = Problem::new(mesh, &[("sphere", Vec3::zeros())], &[Container::TAG])?;
    let set = Articulation::new(&[BodyKind::Rigid], vec![], Arms::Clamped, &[Vec3::zeros()])?;
    let set = set.with_held(&[0], &[0])?;
    let constraints = set.constraints(&set.initial_state(), &[], &[])?;
    let twist = Twist {
        linear: velocity,
        angular: Vec3::zeros(),
    };
    let drive = Drive {
        set: &set,
        constraints: &constraints.with_held_velocity(0, twist)?,
        loads: &[ExternalLoad::default()],
    };
    let space = SurplusSpace::new(mesh)?;
    problem.solve_generalised_newtonian(&drive, law, options, guesses, Some(&space))
}

/// A neutral squirmer of radius 1 that swims along z with the slip `sin θ`.
struct Squirmer;

impl SurfaceFlow for Squirmer {
    fn slip(&self, _: usize, x: &Vec3) -> Vec3 {
        let n = x.normalize();
        -(Vec3::z() - n.z * n)
    }

    fn background(&self, _: &Vec3) -> Vec3 {
        Vec3::zeros()
    }

    fn background_pressure(&self, _: &Vec3) -> f64 {
        0.0
    }
}

/// A neutral squirmer without a force.
fn squirming(
    mesh: &TetMesh,
    law: &dyn ViscosityLaw,
) -> Result<GeneralisedNewtonianSolution, StokesError> {
    let problem = Problem::new(mesh, &[("sphere", Vec3::zeros())], &[Container::TAG])?
        .with_surface_flow(&Squirmer);
    let set = Articulation::new(&[BodyKind::Rigid], vec![], Arms::Clamped, &[Vec3::zeros()])?;
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&set.initial_state(), &[], &[])?,
        loads: &[ExternalLoad::default()],
    };
    let (options, mut guesses) = (Options::default(), InitialGuesses::new(0));
    let space = SurplusSpace::new(mesh).unwrap();
    problem.solve_generalised_newtonian(&drive, law, &options, &mut guesses, Some(&space))
}

/// Drag of a sphere in a ball of 10 radii, over `6π` times the viscosity at rest, by a spectral
/// Galerkin method in spherical coordinates, accurate to the last digit.
const DRAG: [(f64, f64, f64, f64); 5] = [
    (1.0, 0.5, 0.0, 1.1827246),
    (10.0, 0.5, 0.0, 0.597988),
    (1.0, 0.3, 0.0, 1.1293781),
    (10.0, 0.3, 0.0, 0.410398),
    (10.0, 0.3, 0.01, 0.430480),
];

/// Drag by a power law over `6π 2^(1 - n)` times the consistency, for indices `n`, as above.
const POWER_LAW_DRAG: [(f64, f64); 2] = [(0.8, 1.3995224), (0.5, 1.499934)];

#[test]
fn drag_is_within_its_bar_after_at_most_six_steps() {
    let mesh = sphere_in_ball(0.5, 10.0, [true, true, false]);
    let mut cases: Vec<(Law, f64)> = vec![(carreau(0.0, 0.5, 0.0), 1.286_196_338_5)];
    cases.extend(DRAG.map(|(time, index, infinite, drag)| (carreau(time, index, infinite), drag)));
    let power = |(index, drag): (f64, f64)| (power_law(index), drag * 2.0_f64.powf(1.0 - index));
    cases.extend(POWER_LAW_DRAG.map(power));
    for (law, exact) in cases {
        let (options, mut guesses) = (Options::default(), InitialGuesses::new(0));
        let solved = dragged(&mesh, &law, Vec3::z(), (&options, &mut guesses)).unwrap();
        let estimate = solved.solution.estimate.unwrap();
        let force = solved.solution.flow.forces[2];
        let change = estimate.change.forces[2];
        let error = (force + change) / (6.0 * PI) - exact;
        let bar = (estimate.relative_uncertainty * change / (6.0 * PI)).abs();
        let computed = force / (6.0 * PI) - exact;
        assert!(error.abs() < bar, "{law:?}: {error:e} {bar:e}");
        // A bar above the error that the correction removes would say nothing.
        assert!(bar <= computed.abs(), "{law:?}: {computed:e} {bar:e}");
        assert!(
            solved.newton.steps.len() <= 6,
            "{law:?}: {:?}",
            solved.newton
        );
        // Galerkin's method conserves energy: the power is dissipated, up to the residual.
        let checks = solved.solution.checks.unwrap();
        assert!(checks.dissipation.abs() < 1e-7, "{law:?}: {checks:?}");
        assert!((solved.dissipation / force - 1.0).abs() < 1e-7);
        // Stresses converge with a lower order.
        assert!(checks.force_by_stress < 0.2, "{law:?}: {checks:?}");
    }
}

/// From the Newtonian flow alone, power laws of indices 0.4 and 0.3 took up to twelve.
#[test]
fn bug_steep_laws_took_more_than_six_steps() {
    let mesh = sphere_in_ball(0.5, 10.0, [true, true, false]);
    let pair = Pair::new();
    let options = Options::default();
    let laws = [
        carreau(10.0, 0.3, 0.0),
        power_law(0.5),
        power_law(0.4),
        power_law(0.3),
    ];
    for law in laws {
        let mut guesses = InitialGuesses::new(0);
        let held = dragged(&mesh, &law, Vec3::z(), (&options, &mut guesses)).unwrap();
        let load = ExternalLoad {
            force: Vec3::new(3.0, -2.0, 10.0),
            torque: Vec3::zeros(),
        };
        let loaded = pair.solve(&law, (0.0, load), &options).unwrap();
        let linked = pair.solve(&law, (1.0, load), &options).unwrap();
        let unloaded = (pair.solve(&law, (1.0, ExternalLoad::default()), &options)).unwrap();
        for solved in [held, loaded, linked, unloaded] {
            let newton = solved.newton;
            assert!(newton.steps.len() <= 6, "{law:?}: {newton:?}");
            // linear systems of the first guess included
            assert!(newton.iterations() <= 100, "{law:?}: {newton:?}");
        }
    }
}

/// Forces have errors of second order in the error of the flow. With the derivative of the stress
/// alone, without its own terms of second order, corrections left all of what they removed at
/// worst; with them at most 0.26 on edges of 0.6 to 0.2 radii.
#[test]
fn bug_corrections_in_fluids_with_a_law_left_half_of_the_error() {
    let mesh = sphere_in_ball(0.5, 10.0, [true, true, false]);
    for (time, index, infinite, exact) in DRAG {
        let law = carreau(time, index, infinite);
        let (options, mut guesses) = (Options::default(), InitialGuesses::new(0));
        let solved = dragged(&mesh, &law, Vec3::z(), (&options, &mut guesses)).unwrap();
        let force = solved.solution.flow.forces[2] / (6.0 * PI);
        let change = solved.solution.estimate.unwrap().change.forces[2] / (6.0 * PI);
        let left = (force + change - exact).abs();
        assert!(left < 0.3 * change.abs(), "{law:?}: {left:e} of {change:e}");
    }
}

#[test]
fn the_energy_decreases_in_every_step() {
    let pair = Pair::new();
    let options = Options::default();
    let load = ExternalLoad {
        force: Vec3::new(3.0, -2.0, 5.0),
        torque: Vec3::new(1.0, 0.5, -2.0),
    };
    for law in [carreau(10.0, 0.3, 0.0), power_law(0.4), power_law(1.5)] {
        let solved = pair.solve(&law, (0.7, load), &options).unwrap();
        for step in &solved.newton.steps {
            let [start, end] = step.slopes;
            // By convexity the energy decreases if its slope at the end is negative. Near the
            // minimum it is quadratic and changes by the mean of both slopes. Slopes of the last
            // steps are below rounding.
            let is_rounding = start.abs() < 1e-10;
            assert!(
                is_rounding || (start < 0.0 && end < -start),
                "{law:?}: {step:?}"
            );
        }
    }
}

/// The same method: `U / (2 B1 / 3)` and `P / (16π/3)` for the index 1/2 and `λ B1 / a = 1`.
#[test]
fn speed_and_power_of_a_squirmer_are_within_their_bars() {
    let mesh = sphere_in_ball(0.5, 10.0, [true, true, false]);
    let solved = squirming(&mesh, &carreau(1.0, 0.5, 0.0)).unwrap();
    let (solution, steps) = (solved.solution, solved.newton.steps.len());
    let estimate = solution.estimate.unwrap();
    let within = |computed: f64, change: f64, bar: f64, exact: f64| {
        let error = computed + change - exact;
        let computed = computed - exact;
        assert!(
            error.abs() < bar && bar <= 1.5 * computed.abs(),
            "{computed:e} {error:e} {bar:e}"
        );
    };
    let speed = |flow: &rigid::FlowSolution| flow.bodies[2] / (2.0 / 3.0);
    let change = speed(&estimate.change);
    let bar = (estimate.relative_uncertainty * change).hypot(estimate.uncertainty / (2.0 / 3.0));
    within(speed(&solution.flow), change, bar, 0.932_740_640_7);
    let unit = 16.0 * PI / 3.0;
    let change = estimate.powers.slip / unit;
    let bar = (estimate.relative_uncertainty * change).abs();
    within(solution.powers.slip / unit, change, bar, 0.752_406_0);
    assert!(steps <= 6, "{steps} steps");
    assert!((solved.dissipation / solution.powers.slip - 1.0).abs() < 1e-7);
}

/// A mesh of two spheres in a ball, with their centres.
struct Pair {
    mesh: TetMesh,
    centres: [Vec3; 2],
}

impl Pair {
    fn new() -> Self {
        let centres = [-1.6, 1.6].map(|z| Vec3::new(0.0, 0.0, z));
        let spheres = centres.map(|centre| Sphere {
            centre,
            radius: 1.0,
        });
        let ball = Sphere {
            centre: Vec3::zeros(),
            radius: 5.0,
        };
        let names = ["first", "second"];
        let body = |(name, surface)| MeshedBody {
            name,
            surface,
            size: 1.2,
        };
        let parts: Vec<MeshedBody> = names
            .into_iter()
            .zip(&spheres)
            .map(|(name, surface)| body((name, surface as &dyn mesh::Surface)))
            .collect();
        let tets = generate(&parts, &Container::Ball(ball), &GenerateParams::default()).unwrap();
        let surfaces: [mesh::NamedSurface; 3] = [
            ("first", &spheres[0]),
            ("second", &spheres[1]),
            (Container::TAG, &ball),
        ];
        Self {
            mesh: TetMesh::curved(tets.mesh, &surfaces).unwrap(),
            centres,
        }
    }

    /// Both spheres with a slide between them.
    fn articulation(&self) -> Articulation {
        let joint = rigid::Joint::slide("arm", 0, 1);
        let kinds = [BodyKind::Rigid; 2];
        Articulation::new(&kinds, vec![joint], Arms::Free, &self.centres).unwrap()
    }

    fn constraints(&self, set: &Articulation, rate: f64) -> Constraints {
        let distance = (self.centres[1] - self.centres[0]).norm();
        (set.constraints(&set.initial_state(), &[distance], &[rate])).unwrap()
    }

    /// Two spheres that a slide joins, under a load on the first one.
    fn solve(
        &self,
        law: &dyn ViscosityLaw,
        (rate, load): (f64, ExternalLoad),
        options: &Options,
    ) -> Result<GeneralisedNewtonianSolution, StokesError> {
        let set = self.articulation();
        let drive = Drive {
            set: &set,
            constraints: &self.constraints(&set, rate),
            loads: &[load, ExternalLoad::default()],
        };
        let bodies = [("first", self.centres[0]), ("second", self.centres[1])];
        let problem = Problem::new(&self.mesh, &bodies, &[Container::TAG])?;
        let mut guesses = InitialGuesses::new(0);
        problem.solve_generalised_newtonian(&drive, law, options, &mut guesses, None)
    }
}

fn vec3() -> impl Strategy<Value = Vec3> {
    [-1.5..1.5_f64, -1.5..1.5, -1.5..1.5].prop_map(Vec3::from)
}

fn any_law() -> impl Strategy<Value = Law> {
    (0..5_u8, 0.4..1.6_f64, 0.1..3.0_f64).prop_map(|(kind, index, time)| match kind {
        0 => carreau(time, index, 0.05),
        1 => Law::CarreauYasuda {
            zero_shear_viscosity: 2.0,
            infinite_shear_viscosity: 0.1,
            relaxation_time: time,
            index,
            transition: 1.0,
        },
        2 => Law::Cross {
            zero_shear_viscosity: 1.0,
            infinite_shear_viscosity: 0.1,
            relaxation_time: time,
            index: 0.5 * index,
        },
        3 => power_law(index),
        _ => Law::HerschelBulkley {
            yield_stress: 0.2,
            consistency: 1.0,
            index,
            regularisation: 0.05,
        },
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2))]

    #[test]
    fn all_formulations_and_solvers_give_the_same_flow(
        law in any_law(), rate in -1.0..1.0_f64, force in vec3(), torque in vec3(),
    ) {
        prop_assume!(force.norm() > 0.1);
        let pair = Pair::new();
        let load = ExternalLoad { force: 10.0 * force, torque };
        let solve = |formulation: &'static dyn Formulation, solver| {
            let options = Options::default()
                .with_formulation(formulation)
                .with_solver(solver)
                .with_rtol(1e-11);
            pair.solve(&law, (rate, load), &options).unwrap().solution.flow
        };
        let reference = solve(&Eliminated, Solver::Block);
        for flow in [
            solve(&Eliminated, Solver::Direct),
            solve(&Lagrange, Solver::Direct),
            solve(&DirectRows, Solver::Direct),
            solve(&Lagrange, Solver::Minres),
        ] {
            let close = |a: &nalgebra::DVector<f64>, b: &nalgebra::DVector<f64>| {
                (a - b).amax() < 1e-9 * b.amax()
            };
            prop_assert!(close(&flow.bodies, &reference.bodies));
            prop_assert!(close(&flow.forces, &reference.forces));
            prop_assert!(close(&flow.joint_loads, &reference.joint_loads));
        }
        // the loads on the linkage are balanced by the fluid
        for axis in 0..3 {
            let total = reference.forces[axis] + reference.forces[6 + axis];
            prop_assert!((total - load.force[axis]).abs() < 1e-8 * load.force.norm());
        }
    }

    /// With the regularisation scaled like the rates.
    #[test]
    fn power_laws_are_homogeneous_of_degree_one_in_the_rates(
        index in 0.4..1.6_f64, factor in 0.2..5.0_f64,
    ) {
        let pair = Pair::new();
        let solve = |factor: f64| {
            let law = Law::PowerLaw { consistency: 1.0, index, regularisation: 1e-3 * factor };
            let options = Options::default().with_rtol(1e-10);
            let drive = (factor, ExternalLoad::default());
            pair.solve(&law, drive, &options).unwrap().solution.flow
        };
        let (one, scaled) = (solve(1.0), solve(factor));
        let size = one.bodies.amax();
        prop_assert!((&scaled.bodies - &one.bodies * factor).amax() < 1e-7 * factor * size);
        let (force, size) = (factor.powf(index), one.forces.amax());
        prop_assert!((&scaled.forces - &one.forces * force).amax() < 1e-7 * force * size);
    }

    /// With the relaxation time 0 and with equal viscosities at rest and at infinite rate.
    #[test]
    fn carreau_without_thinning_is_newtonian(index in 0.2..1.8_f64, velocity in vec3()) {
        prop_assume!(velocity.norm() > 0.1);
        let mesh = sphere_in_ball(0.8, 3.0, [false; 3]);
        let options = Options::default().with_rtol(1e-10);
        let laws = [
            Law::Newtonian { viscosity: 1.0 },
            carreau(0.0, index, 0.0),
            carreau(2.0, index, 1.0),
        ];
        let [newtonian, others @ ..] = laws.map(|law| {
            let mut guesses = InitialGuesses::new(0);
            let solved = dragged(&mesh, &law, velocity, (&options, &mut guesses)).unwrap();
            solved.solution.flow.forces
        });
        for forces in others {
            prop_assert!((&forces - &newtonian).amax() < 1e-8 * newtonian.amax());
        }
    }

    /// On a mesh that turns with the frame.
    #[test]
    fn forces_turn_with_the_frame(law in any_law(), velocity in vec3(), turn in vec3()) {
        prop_assume!(velocity.norm() > 0.1);
        let mesh = sphere_in_ball(0.8, 3.0, [false; 3]);
        let rotation = Rotation3::new(turn);
        let points = mesh.points().iter().map(|x| rotation * x).collect();
        let turned = mesh.with_points(points).unwrap();
        let options = Options::default().with_rtol(1e-10);
        let force = |mesh: &TetMesh, velocity| {
            let mut guesses = InitialGuesses::new(0);
            let solved = dragged(mesh, &law, velocity, (&options, &mut guesses)).unwrap();
            Vec3::from(solved.solution.flow.forces.fixed_rows::<3>(0))
        };
        let (still, turned) = (force(&mesh, velocity), force(&turned, rotation * velocity));
        let difference = (rotation.inverse() * turned - still).norm();
        prop_assert!(difference < 1e-8 * still.norm(), "{difference:e}");
    }
}

#[test]
fn warm_starts_save_steps_and_change_nothing() {
    let mesh = sphere_in_ball(0.8, 5.0, [true, true, false]);
    let (law, options) = (carreau(3.0, 0.4, 0.0), Options::default());
    let mut guesses = InitialGuesses::new(2);
    let first = dragged(&mesh, &law, Vec3::z(), (&options, &mut guesses)).unwrap();
    let faster = 1.05 * Vec3::z();
    let warm = dragged(&mesh, &law, faster, (&options, &mut guesses)).unwrap();
    let cold = dragged(&mesh, &law, faster, (&options, &mut InitialGuesses::new(0))).unwrap();
    let [warm_force, cold_force] = [&warm, &cold].map(|s| s.solution.flow.forces[2]);
    assert!((warm_force / cold_force - 1.0).abs() < 1e-7);
    assert!(warm.newton.steps.len() < first.newton.steps.len());
    assert!(warm.newton.iterations() < cold.newton.iterations());
}

/// The derivative of velocities and forces by the law is that of full solves, up to terms of the
/// fourth order, about `(λ g)^2` of it for the largest shear rate `g`, and up to the error of the
/// mesh: flows by a law have the rate of strain in their stiffness, the change has the gradient.
///
/// By the reciprocal theorem the change is the product of one stress with the flow of a unit load,
/// of either form, so that its relative error is that of this flow in the norm of the energy. The
/// load does the work of the energy: the square of that error is the relative difference `d` of
/// velocities and forces by both forms, and the bound is `sqrt(d)`.
#[test]
fn the_first_order_change_by_a_law_is_the_derivative_of_full_solves() {
    let pair = Pair::new();
    let options = Options::default().with_rtol(1e-12);
    let load = ExternalLoad {
        force: Vec3::new(3.0, -2.0, 5.0),
        torque: Vec3::new(1.0, 0.5, -2.0),
    };
    let flow = |law: &dyn ViscosityLaw| {
        let solved = pair.solve(law, (0.7, load), &options).unwrap();
        solved.solution.flow
    };
    let newtonian = flow(&Law::Newtonian { viscosity: 1.0 });
    let bodies = [("first", pair.centres[0]), ("second", pair.centres[1])];
    let problem = Problem::new(&pair.mesh, &bodies, &[Container::TAG]).unwrap();
    let set = pair.articulation();
    let constraints = pair.constraints(&set, 0.0);
    let drive = Drive {
        set: &set,
        constraints: &constraints,
        loads: &[ExternalLoad::default(); 2],
    };
    let moving = pair.constraints(&set, 0.7);
    let same_loads = Drive {
        set: &set,
        constraints: &moving,
        loads: &[load, ExternalLoad::default()],
    };
    let by_gradient = problem.solve(&same_loads, &options).unwrap().flow;
    let difference = [
        (&by_gradient.bodies, &newtonian.bodies),
        (&by_gradient.forces, &newtonian.forces),
        (&by_gradient.joint_loads, &newtonian.joint_loads),
    ]
    .map(|(a, b)| (a - b).amax() / b.amax())
    .into_iter()
    .fold(0.0, f64::max);
    let error_of_mesh = difference.sqrt();
    assert!(error_of_mesh < 0.1, "{error_of_mesh:e}");
    let change_by = |time: f64| {
        let law = carreau(time, 0.4, 0.0);
        (problem.viscosity_change(&drive, &newtonian.velocity, &law, &options)).unwrap()
    };
    // Errors of both forms of the change, relative to velocities, forces and loads of joints.
    let errors = |time: f64| {
        let (change, full) = (change_by(time), flow(&carreau(time, 0.4, 0.0)));
        [change.full, change.second_order.unwrap()].map(|found| {
            let pairs = [
                (&found.bodies, &full.bodies - &newtonian.bodies),
                (&found.forces, &full.forces - &newtonian.forces),
                (
                    &found.joint_loads,
                    &full.joint_loads - &newtonian.joint_loads,
                ),
            ];
            pairs.map(|(found, change)| (found - &change).amax() / change.amax())
        })
    };
    let [coarse, fine] = [0.02, 0.01].map(errors);
    for (coarse, fine) in coarse.iter().flatten().zip(fine.iter().flatten()) {
        // Largest shear rates are about 3.
        let fourth_order = (3.0 * 0.02_f64).powi(2);
        assert!((fine - coarse).abs() < fourth_order, "{coarse:e} {fine:e}");
        assert!(*fine < error_of_mesh, "{fine:e} {error_of_mesh:e}");
    }
    let change = change_by(0.02);
    // The forces on a free linkage balance the same loads.
    for axis in 0..3 {
        let total = change.full.forces[axis] + change.full.forces[6 + axis];
        assert!(total.abs() < 1e-8 * change.full.forces.amax());
    }
    let cross = Law::Cross {
        zero_shear_viscosity: 1.0,
        infinite_shear_viscosity: 0.0,
        relaxation_time: 0.02,
        index: 0.5,
    };
    let change = problem
        .viscosity_change(&drive, &newtonian.velocity, &cross, &options)
        .unwrap();
    assert!(change.second_order.is_none(), "it begins with g^(1/2)");
}

/// A fluid whose stress decreases has no unique flow; a viscosity that is not finite is refused.
#[test]
fn laws_without_a_flow_are_refused() {
    #[derive(Debug)]
    struct Decreasing;
    impl ViscosityLaw for Decreasing {
        fn viscosity(&self, shear_rate: f64) -> f64 {
            (1.0 + shear_rate * shear_rate).powi(-4)
        }
        fn derivative(&self, shear_rate: f64) -> f64 {
            -8.0 * shear_rate * (1.0 + shear_rate * shear_rate).powi(-5)
        }
        fn potential(&self, shear_rate: f64) -> f64 {
            (1.0 - (1.0 + shear_rate * shear_rate).powi(-3)) / 6.0
        }
    }
    let mesh = sphere_in_ball(0.8, 3.0, [true, true, false]);
    let refused = |law: &dyn ViscosityLaw| {
        let options = Options::default();
        dragged(
            &mesh,
            law,
            Vec3::z(),
            (&options, &mut InitialGuesses::new(0)),
        )
        .err()
        .unwrap()
    };
    let error = refused(&Decreasing);
    assert!(
        matches!(
            error,
            StokesError::NewtonNotConverged { .. } | StokesError::EnergyNotDecreasing { .. }
        ),
        "{error}"
    );
    assert!(error.to_string().contains("must increase"), "{error}");
    let nan = Law::Newtonian {
        viscosity: f64::NAN,
    };
    let error = refused(&nan);
    assert!(matches!(error, StokesError::Viscosity { .. }), "{error}");
}
