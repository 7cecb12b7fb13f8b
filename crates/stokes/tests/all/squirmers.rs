//! Slip on the surface of a sphere against exact values.

use std::f64::consts::{FRAC_PI_2, PI};

use mesh::TetMesh;
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;
use rigid::{DirectRows, Eliminated, Formulation, Lagrange};
use stokes::{Options, Solution, Solver, StokesError, SurfaceFlow};

use crate::support::{solve_free_sphere, sphere_in_ball};

type Vec3 = Vector3<f64>;

/// A squirmer `u_s = -(b1 + b2 n·k) (I - n n^T) k` of radius 1 at the origin, in a shear flow.
struct Squirmer {
    b: [f64; 2],
    axis: Vec3,
    shear: f64,
}

impl SurfaceFlow for Squirmer {
    fn slip(&self, _: usize, x: &Vec3) -> Vec3 {
        let n = x.normalize();
        let cosine = n.dot(&self.axis);
        (self.axis - cosine * n) * -(self.b[0] + self.b[1] * cosine)
    }

    fn background(&self, x: &Vec3) -> Vec3 {
        Vec3::new(self.shear * x.y, 0.0, 0.0)
    }

    fn background_pressure(&self, _: &Vec3) -> f64 {
        0.0
    }
}

/// The part of the fluid between a sphere and a concentric ball of radius 2.
fn part(size: f64, symmetry_planes: [bool; 3]) -> TetMesh {
    sphere_in_ball(size, 2.0, symmetry_planes)
}

/// The solution for a free sphere on such a mesh, with estimates.
fn solve_on(
    mesh: &TetMesh,
    flow: &dyn SurfaceFlow,
    options: &Options,
) -> Result<Solution, StokesError> {
    solve_free_sphere(mesh, 2.0, flow, options)
}

/// The solution on a mesh of the whole fluid.
fn solve(flow: &Squirmer, size: f64, options: &Options) -> Solution {
    solve_on(&part(size, [false; 3]), flow, options).unwrap()
}

#[test]
fn corrected_speeds_of_a_squirmer_in_a_ball_are_within_their_bars() {
    let squirmer = Squirmer {
        b: [1.0, 0.7],
        axis: Vec3::new(1.0, 2.0, -2.0) / 3.0,
        shear: 0.0,
    };
    // U = (2 B1 / 3) (1 - 5 l^3 / 2 + 3 l^5 / 2) / (1 - l^5) for l = 1/2
    let exact = 2.0 / 3.0 * 0.758_064_516_129;
    // The modes have 16π/3 B1^2 (1 + 3 l^5 / 2) / (1 - l^5) and 8π/3 B2^2 times the power of a
    // strain in the ball over that in unbounded fluid.
    let first = 2.0 * (1.0 + 1.5 / 32.0) / (1.0 - 1.0 / 32.0);
    let exact_power = 8.0 * PI / 3.0 * (first + 0.7 * 0.7 * 1.414_872_798);
    for (size, largest) in [(0.6, 2e-2), (0.45, 1e-2), (0.3, 2e-3)] {
        let solved = solve(&squirmer, size, &Options::default());
        let estimate = solved.estimate.unwrap();
        let speed = |flow: &rigid::FlowSolution| flow.bodies.rows(0, 3).dot(&squirmer.axis);
        let (computed, change) = (speed(&solved.flow), speed(&estimate.change));
        let error = computed + change - exact;
        let bar = (estimate.relative_uncertainty * change).hypot(estimate.uncertainty);
        assert!((computed - exact).abs() < largest * exact, "{computed}");
        // A bar above the error that the correction removes would say nothing.
        assert!(
            error.abs() < bar && bar < (computed - exact).abs(),
            "{error:e} {bar:e}"
        );
        let (computed, change) = (solved.powers.slip, estimate.powers.slip);
        let error = computed + change - exact_power;
        let bar = estimate.relative_uncertainty * change.abs();
        assert!(
            error.abs() < bar && bar < 0.5 * (computed - exact_power).abs(),
            "{error:e} {bar:e}"
        );
        // no force, and the power of the slip is dissipated
        assert!(solved.flow.forces.amax() < 1e-6);
        let checks = solved.checks.unwrap();
        assert!(checks.dissipation.abs() < 0.05 && checks.force_by_stress < 0.1);
    }
}

#[test]
fn all_formulations_give_the_same_motion_of_a_squirmer_in_shear() {
    let squirmer = Squirmer {
        b: [1.0, -2.0],
        axis: Vec3::new(0.0, 0.6, 0.8),
        shear: 1.5,
    };
    let formulations: [&dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];
    let motions = formulations.map(|formulation| {
        let mut options = Options::default();
        options.formulation = formulation;
        options.solver = Solver::Direct;
        solve(&squirmer, 0.6, &options).flow.bodies
    });
    for motion in &motions[1..] {
        assert!((motion - &motions[0]).amax() < 1e-9);
    }
    // In a concentric ball whose wall moves with the shear flow, the sphere rotates with the
    // vorticity: -1.5 / 2 about z.
    assert!((motions[0][5] + 0.75).abs() < 1e-3, "{}", motions[0][5]);
}

/// A flow after a rotation of the frame.
struct Turned<'a> {
    flow: &'a Squirmer,
    rotation: Rotation3<f64>,
}

impl SurfaceFlow for Turned<'_> {
    fn slip(&self, body: usize, x: &Vec3) -> Vec3 {
        self.rotation * self.flow.slip(body, &(self.rotation.inverse() * x))
    }

    fn background(&self, x: &Vec3) -> Vec3 {
        self.rotation * self.flow.background(&(self.rotation.inverse() * x))
    }

    fn background_pressure(&self, _: &Vec3) -> f64 {
        0.0
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]

    /// On a mesh that turns with the frame stresslets turn to rounding, also their corrections; on
    /// the same mesh within their bars.
    #[test]
    fn stresslets_turn_with_the_frame(
        (axis, b2, quarter) in (vec3(), -2.0..2.0_f64, 1..4_u8),
        (turn, normal) in (vec3(), 0..3_usize),
    ) {
        prop_assume!(axis.norm() > 0.1);
        let squirmer = Squirmer { b: [1.0, b2], axis: axis.normalize(), shear: 0.8 };
        let mesh = part(0.8, [false; 3]);
        let solve = |mesh: &TetMesh, flow: &dyn SurfaceFlow| {
            solve_on(mesh, flow, &Options::default().with_rtol(1e-10)).unwrap()
        };
        let still = solve(&mesh, &squirmer);
        let corrected = |solved: &Solution| {
            let estimate = solved.estimate.as_ref().unwrap();
            solved.flow.stresslets[0] + estimate.change.stresslets[0]
        };
        let quarter = Vec3::ith(normal, f64::from(quarter) * FRAC_PI_2);
        for (rotation, turns_mesh) in [(quarter, true), (turn, true), (turn, false)] {
            let rotation = Rotation3::new(rotation);
            let points = mesh.points().iter().map(|x| match turns_mesh {
                true => rotation * x,
                false => *x,
            });
            let mesh = mesh.with_points(points.collect()).unwrap();
            let turned = solve(&mesh, &Turned { flow: &squirmer, rotation });
            let of_frame = |s: &Matrix3<f64>| rotation * s * rotation.inverse();
            let size = still.flow.stresslets[0].norm();
            let bar = |solved: &Solution| {
                let estimate = solved.estimate.as_ref().unwrap();
                estimate.relative_uncertainty * estimate.change.stresslets[0].norm()
            };
            let allowed = match turns_mesh {
                true => 1e-8 * size,
                false => bar(&still) + bar(&turned),
            };
            let apart = (corrected(&turned) - of_frame(&corrected(&still))).norm();
            prop_assert!(apart < allowed, "{apart:e} {allowed:e} {size:e}");
        }
    }
}

fn vec3() -> impl Strategy<Value = Vec3> {
    [-1.5..1.5_f64, -1.5..1.5, -1.5..1.5].prop_map(Vec3::from)
}

/// The axis lies in the planes up to rounding, as after rotations.
#[test]
fn a_squirmer_between_symmetry_planes_has_the_solution_on_the_reflected_mesh() {
    let mut options = Options::default();
    options.rtol = 1e-11;
    for (axis, shear, planes) in [
        (Vec3::new(0.6, 0.8, 1e-16), 1.5, [false, false, true]),
        (Vec3::new(1.0, 0.0, 2e-16), 0.0, [false, true, true]),
    ] {
        let squirmer = Squirmer {
            b: [1.0, 0.7],
            axis,
            shear,
        };
        let mesh = part(0.6, planes);
        let whole = mesh.unfolded().unwrap().mesh;
        let [own, all] = [&mesh, &whole].map(|mesh| solve_on(mesh, &squirmer, &options).unwrap());
        // The iteration of the corrections leaves another percent of them.
        let changes = [&own, &all].map(|s| s.estimate.as_ref().unwrap().change.clone());
        for (flows, tolerance) in [([&own.flow, &all.flow], 1e-9), (changes.each_ref(), 0.03)] {
            let [own, all] = flows;
            let size = all.bodies.amax();
            assert!((&own.bodies - &all.bodies).amax() < tolerance * size);
            let (own, all) = (own.stresslets[0], all.stresslets[0]);
            assert!((own - all).norm() < tolerance * all.norm(), "{own} {all}");
        }
        let close = |own: f64, all: f64, tolerance: f64| {
            assert!((own / all - 1.0).abs() < tolerance, "{own} {all}");
        };
        close(own.powers.slip, all.powers.slip, 1e-9);
        let [first, second] = [&own, &all].map(|s| s.checks.unwrap());
        close(1.0 + first.dissipation, 1.0 + second.dissipation, 1e-9);
        close(first.force_by_stress, second.force_by_stress, 1e-6);
        let [first, second] = [own, all].map(|s| s.estimate.unwrap());
        close(first.powers.slip, second.powers.slip, 0.03);
        close(
            first.relative_uncertainty,
            second.relative_uncertainty,
            1e-6,
        );
        close(first.uncertainty, second.uncertainty, 0.05);
    }
}

#[test]
fn slip_that_is_not_symmetric_about_the_planes_is_refused() {
    let squirmer = Squirmer {
        b: [1.0, 0.7],
        axis: Vec3::new(0.8, 0.0, 0.6),
        shear: 0.0,
    };
    let mesh = part(0.8, [false, false, true]);
    let Err(error) = solve_on(&mesh, &squirmer, &Options::default()) else {
        panic!("the slip has a component across the plane");
    };
    assert!(error.to_string().contains("symmetry plane"), "{error}");
}
