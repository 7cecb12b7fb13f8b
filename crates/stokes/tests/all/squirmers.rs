//! Slip and background flow against exact values.

use std::f64::consts::PI;

use fem::SurplusSpace;
use mesh::{Container, GenerateParams, MeshedBody, Sphere, Surface, TetMesh, generate};
use nalgebra::Vector3;
use rigid::{Arms, Articulation, BodyKind, Drive, ExternalLoad};
use stokes::{InitialGuesses, Options, Problem, Solution, SurfaceFlow};

type Vec3 = Vector3<f64>;

/// A squirmer `u_s = -(b1 + b2 n·k) (I - n n^T) k` of radius 1 at a point, in a background flow.
struct Squirmer {
    b: [f64; 2],
    axis: Vec3,
    centre: Vec3,
    background: fn(&Vec3) -> Vec3,
}

impl SurfaceFlow for Squirmer {
    fn slip(&self, _: usize, x: &Vec3) -> Vec3 {
        let n = (x - self.centre).normalize();
        let cosine = n.dot(&self.axis);
        (self.axis - cosine * n) * -(self.b[0] + self.b[1] * cosine)
    }

    fn background(&self, x: &Vec3) -> Vec3 {
        (self.background)(x)
    }

    fn background_pressure(&self, _: &Vec3) -> f64 {
        0.0
    }
}

/// The corrected solution for one free or fixed sphere in a ball of the given radius.
fn solve(flow: &Squirmer, ball: f64, size: f64, fixed: bool) -> Solution {
    let sphere = Sphere {
        centre: flow.centre,
        radius: 1.0,
    };
    let container = Container::Ball(Sphere {
        centre: Vec3::zeros(),
        radius: ball,
    });
    let body = MeshedBody {
        name: "sphere",
        surface: &sphere,
        size,
    };
    let tets = generate(&[body], &container, &GenerateParams::default()).unwrap();
    let parts: [(&str, &dyn Surface); 2] =
        [("sphere", &sphere), (Container::TAG, container.surface())];
    let mesh = TetMesh::curved(tets.mesh, &parts).unwrap();
    let problem = Problem::new(&mesh, &[("sphere", flow.centre)], &[Container::TAG])
        .unwrap()
        .with_surfaces(&parts)
        .unwrap()
        .with_surface_flow(flow);
    let set = Articulation::new(&[BodyKind::Rigid], vec![], Arms::Clamped, &[flow.centre]).unwrap();
    let set = match fixed {
        true => set.with_fixed(&[0]).unwrap(),
        false => set,
    };
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&set.initial_state(), &[], &[]).unwrap(),
        loads: &[ExternalLoad::default()],
    };
    let space = SurplusSpace::new(&mesh).unwrap();
    let mut guesses = InitialGuesses::new(0);
    let mut solved = problem
        .solve_all(&[drive], &Options::default(), &mut guesses, Some(&space))
        .unwrap();
    solved.swap_remove(0)
}

#[test]
fn squirmer_in_a_concentric_ball() {
    // l = a / b = 1/2; U = (2 B1 / 3) (1 - 5 l^3 / 2 + 3 l^5 / 2) / (1 - l^5)
    let l: f64 = 0.5;
    let axis = Vec3::new(1.0, 2.0, -2.0) / 3.0;
    let speed = 2.0 / 3.0 * (1.0 - 2.5 * l.powi(3) + 1.5 * l.powi(5)) / (1.0 - l.powi(5));
    let b1 = Squirmer {
        b: [1.0, 0.0],
        axis,
        centre: Vec3::zeros(),
        background: |_| Vec3::zeros(),
    };
    let power = 16.0 * PI / 3.0 * (1.0 + 1.5 * l.powi(5)) / (1.0 - l.powi(5));
    for size in [0.6, 0.45, 0.3] {
        let solved = solve(&b1, 2.0, size, false);
        let estimate = solved.estimate.unwrap();
        let u = |flow: &rigid::FlowSolution| flow.bodies.rows(0, 3).dot(&axis);
        let (computed, change) = (u(&solved.flow), u(&estimate.change));
        println!(
            "{size}: U error {:e} corrected {:e}, bar {:e} {:e}, P error {:e} bar {:e} checks {:?} flow {}",
            computed / speed - 1.0,
            (computed + change) / speed - 1.0,
            change * estimate.relative_uncertainty,
            estimate.uncertainty,
            solved.slip_power / power - 1.0,
            estimate.energy_error / power,
            solved.checks,
            solved.flow.forces.amax(),
        );
        let b2 = Squirmer {
            b: [0.0, 1.0],
            ..b1
        };
        let solved = solve(&b2, 2.0, size, false);
        let estimate = solved.estimate.unwrap();
        let power = 8.0 * PI / 3.0 * 1.414_872_798;
        println!(
            "  B2 P error {:e} bar {:e} U {:e}",
            solved.slip_power / power - 1.0,
            estimate.energy_error / power,
            u(&solved.flow)
        );
    }
    panic!();
}
