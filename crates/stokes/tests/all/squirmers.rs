//! Slip on the surface of a sphere against exact values.

use fem::SurplusSpace;
use mesh::{Container, GenerateParams, MeshedBody, Sphere, Surface, TetMesh, generate};
use nalgebra::Vector3;
use rigid::{
    Arms, Articulation, BodyKind, DirectRows, Drive, Eliminated, ExternalLoad, Formulation,
    Lagrange,
};
use stokes::{InitialGuesses, Options, Problem, Solution, Solver, SurfaceFlow};

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

/// The solution for a free sphere in a concentric ball of radius 2, with estimates.
fn solve(flow: &Squirmer, size: f64, options: &Options) -> Solution {
    let [sphere, ball] = [1.0, 2.0].map(|radius| Sphere {
        centre: Vec3::zeros(),
        radius,
    });
    let container = Container::Ball(ball);
    let body = MeshedBody {
        name: "sphere",
        surface: &sphere,
        size,
    };
    let tets = generate(&[body], &container, &GenerateParams::default()).unwrap();
    let parts: [(&str, &dyn Surface); 2] = [("sphere", &sphere), (Container::TAG, &ball)];
    let mesh = TetMesh::curved(tets.mesh, &parts).unwrap();
    let problem = Problem::new(&mesh, &[("sphere", Vec3::zeros())], &[Container::TAG])
        .and_then(|problem| problem.with_surfaces(&parts))
        .unwrap()
        .with_surface_flow(flow);
    let set = Articulation::new(&[BodyKind::Rigid], vec![], Arms::Clamped, &[Vec3::zeros()]);
    let set = set.unwrap();
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&set.initial_state(), &[], &[]).unwrap(),
        loads: &[ExternalLoad::default()],
    };
    let space = SurplusSpace::new(&mesh).unwrap();
    let mut guesses = InitialGuesses::new(0);
    let solved = problem.solve_all(&[drive], options, &mut guesses, Some(&space));
    solved.unwrap().swap_remove(0)
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
