//! The force on a sphere that oscillates or accelerates exponentially in a concentric ball.

use std::f64::consts::PI;

use inertia::{Convection, Forcing, FrozenMesh, Integrator, Parameters};
use linalg::WarmStart;
use mesh::{NamedSurface, TetMesh};
use mesher::{Container, Sphere};
use nalgebra::{Complex, DMatrix, DVector};
use rigid::{Drive, ExternalLoad};
use stokes::{InertialTerms, Options, Problem, SurfaceFlow};

use crate::support::{QUARTER, STOKES, Vec3, bodies, free_sphere, sphere_in_ball};

/// `K` in the force `-6π K U e^(st)` of the fluid on a sphere of radius 1 with the velocity
/// `U e^(st)` at the centre of a ball of radius `b`, with `α^2 = ρ s` at viscosity 1.
///
/// Stream function `g(r) sin^2 θ`, `g = A r^2 + B / r + C (ch αr - sh αr / (αr)) + D e^(-αr) (1 +
/// 1 / (αr))` (Stokes 1851; Lamb, Hydrodynamics, section 354), with `g(1) = 1/2`, `g'(1) = 1`, and
/// `g = g' = 0` at `b`. The first two terms are a potential flow with the pressure
/// `-α^2 (2 A r - B / r^2) cos θ`. The traction on the sphere gives
/// `K = 2/9 p(1) - 4/9 (g''(1) - 1)`.
pub fn impedance(alpha: Complex<f64>, b: f64) -> Complex<f64> {
    let one = Complex::new(1.0, 0.0);
    let value = |r: f64| {
        let x = alpha * r;
        let decay = (-(x - alpha)).exp();
        let grow = (x - alpha * b).exp();
        let mirror = (-x - alpha * b).exp();
        // ch and sh scaled by e^(-αb), exp by e^α, so that none overflows
        let (ch, sh) = ((grow + mirror) * 0.5, (grow - mirror) * 0.5);
        let c = ch - sh / x;
        let dc = alpha * (sh - ch / x + sh / (x * x));
        let d = decay * (one + one / x);
        let dd = alpha * decay * (-one - one / x - one / (x * x));
        // g'' = α^2 g + 2 g / r^2 for both viscous functions
        let second = |g: Complex<f64>| (alpha * alpha + 2.0 / (r * r)) * g;
        [
            [one * (r * r), one / r, c, d],
            [one * (2.0 * r), -one / (r * r), dc, dd],
            [one * 2.0, one * (2.0 / (r * r * r)), second(c), second(d)],
        ]
    };
    let (inner, outer) = (value(1.0), value(b));
    let rows = [inner[0], inner[1], outer[0], outer[1]];
    let matrix = DMatrix::from_fn(4, 4, |i, j| rows[i][j]);
    let rhs = DVector::from_vec(vec![one * 0.5, one, one * 0.0, one * 0.0]);
    let x = matrix.lu().solve(&rhs).unwrap();
    let pressure = -alpha * alpha * (x[0] * 2.0 - x[1]);
    let second: Complex<f64> = (0..4).map(|k| inner[2][k] * x[k]).sum();
    pressure * (2.0 / 9.0) - (second - one) * (4.0 / 9.0)
}

#[test]
fn the_closed_form_has_the_published_values() {
    // the 4 x 4 system solved by another program, b = 10
    for (s, re, im) in [
        (0.1, 1.302853564, -0.143279780),
        (1.0, 1.717948332, -0.808801198),
        (10.0, 3.248083854, -3.352958609),
        (100.0, 8.092114115, -18.229823328),
    ] {
        let k = impedance(Complex::new(0.0, -s).sqrt(), 10.0);
        assert!((k - Complex::new(re, im)).norm() < 2e-9, "{s}: {k}");
    }
    // Haberman & Sayre (1958) without inertia
    // up to the first term in α^2, 0.17 α^2 by the values above
    let k = impedance(Complex::new(0.03, 0.0), 10.0);
    assert!((k.re - 1.286_196_338_5).abs() < 2e-3, "{k}");
    // added mass (b^3 + 2) / (2 (b^3 - 1)) of the displaced mass, up to the boundary layer 1 / α
    let alpha = 1e5;
    let added = impedance(Complex::new(alpha, 0.0), 2.0).re * 4.5 / (alpha * alpha);
    assert!(
        (added / (10.0 / 14.0) - 1.0).abs() < 20.0 / alpha,
        "{added}"
    );
}

/// The velocity 1 along z of the whole surface.
struct Translation;

impl SurfaceFlow for Translation {
    fn slip(&self, _: usize, _: &Vec3) -> Vec3 {
        Vec3::z()
    }
    fn background(&self, _: &Vec3) -> Vec3 {
        Vec3::zeros()
    }
    fn background_pressure(&self, _: &Vec3) -> f64 {
        0.0
    }
}

/// Force of the fluid with `κ u - Δu + ∇p = 0` on a fixed sphere whose surface moves at 1 along z.
fn force(mesh: &TetMesh, kappa: f64) -> f64 {
    let set = free_sphere(Vec3::zeros()).with_held(&[0], &[0]).unwrap();
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&set.initial_state(), &[], &[]).unwrap(),
        loads: &[ExternalLoad::default()],
    };
    let problem = Problem::new(mesh, &[("sphere", Vec3::zeros())], &[Container::TAG])
        .unwrap()
        .with_surface_flow(&Translation);
    let terms = InertialTerms {
        density: 1.0,
        coefficient: kappa,
        ..InertialTerms::default()
    };
    let options = Options::default();
    let system = problem
        .assemble_inertial(&drive, options.formulation, &terms)
        .unwrap();
    let (flow, _) = system
        .solve(mesh, &drive, &options, &mut WarmStart::new(0))
        .unwrap();
    flow.forces[2]
}

#[test]
fn exponential_acceleration_has_the_exact_force() {
    let mesh = sphere_in_ball(0.3, 3.0, QUARTER);
    // Haberman & Sayre (1958), l = 1/3
    let l: f64 = 1.0 / 3.0;
    let stokes =
        (1.0 - l.powi(5)) / (1.0 - 2.25 * l + 2.5 * l.powi(3) - 2.25 * l.powi(5) + l.powi(6));
    let mesh_error = force(&mesh, 0.0) / (STOKES * stokes) - 1.0;
    println!("without inertia: {mesh_error:e}");
    assert!(mesh_error.abs() < 3e-3);
    // The boundary layer 1 / κ^(1/2) is resolved by three elements at κ = 1, by one at κ = 10; the
    // error is that of the mesh without inertia until then.
    for (kappa, factor) in [(0.1, 1.2), (1.0, 1.2), (10.0, 2.0)] {
        let exact = STOKES * impedance(Complex::new(kappa, 0.0).sqrt(), 3.0).re;
        let error = force(&mesh, kappa) / exact - 1.0;
        println!("κ = {kappa}: {error:e}");
        assert!(
            error.abs() < factor * mesh_error.abs(),
            "κ = {kappa}: {error:e}"
        );
    }
}

/// Uniform refinement, of which each level is moved onto the spheres. The force converges with the
/// fourth order, twice that of velocity gradients, because it is the residual of the equations.
#[test]
#[ignore = "slow: 30 s"]
fn forces_are_of_fourth_order_in_space() {
    let mut mesh = sphere_in_ball(0.9, 3.0, QUARTER);
    let sphere = |radius| Sphere {
        centre: Vec3::zeros(),
        radius,
    };
    let (body, ball) = (sphere(1.0), sphere(3.0));
    let kappas = [0.1, 1.0, 10.0];
    let mut errors = Vec::new();
    for level in 0..4 {
        if level > 0 {
            let surfaces: [NamedSurface; 2] = [("sphere", &body), (Container::TAG, &ball)];
            mesh = mesh.refined(&surfaces).unwrap();
        }
        errors.push(kappas.map(|kappa: f64| {
            let exact = STOKES * impedance(Complex::new(kappa, 0.0).sqrt(), 3.0).re;
            (force(&mesh, kappa) / exact - 1.0).abs()
        }));
        println!("{} nodes: {:?}", mesh.n_points(), errors[level]);
    }
    for (k, kappa) in kappas.into_iter().enumerate() {
        let order = (errors[2][k] / errors[3][k]).log2();
        println!("κ = {kappa}: order {order}");
        assert!(order > 3.5, "κ = {kappa}: {order}");
    }
}

/// Oscillation of a surface along z.
struct Oscillation {
    frequency: f64,
}

impl Forcing for Oscillation {
    fn has_slip(&self) -> bool {
        true
    }
    fn slip(&self, time: f64, _: usize, _: &Vec3) -> Vec3 {
        Vec3::z() * (self.frequency * time).sin()
    }
}

/// `K` of an oscillation, from the last of `periods` periods of `steps` steps.
fn oscillating(size: f64, b: f64, s: f64, (periods, steps): (usize, usize)) -> Complex<f64> {
    let set = free_sphere(Vec3::zeros()).with_held(&[0], &[0]).unwrap();
    let mesh = FrozenMesh(sphere_in_ball(size, b, QUARTER));
    let forcing = Oscillation {
        frequency: 2.0 * PI,
    };
    let parameters = Parameters::new(s / forcing.frequency).with_convection(Convection::Neglected);
    let mut run =
        Integrator::from_rest(bodies(&set, 0.0), &forcing, Box::new(mesh), parameters, 0.0)
            .unwrap();
    let mut sum = Complex::new(0.0, 0.0);
    for step in 0..periods * steps {
        let report = run.step(1.0 / steps as f64).unwrap();
        if step >= (periods - 1) * steps {
            // the force is the real part of 6π K i e^(-iωt), the velocity that of i e^(-iωt)
            let phase = Complex::new(0.0, forcing.frequency * report.time).exp();
            sum += phase * report.forces[2];
        }
    }
    sum * 2.0 / (steps as f64 * STOKES) / Complex::new(0.0, 1.0)
}

#[test]
fn oscillating_sphere_has_the_exact_force_and_phase() {
    // Transients decay as exp(-π^2 t / (ρ (b - 1)^2)), by e^-15 per period at S = 1.
    let exact = impedance(Complex::new(0.0, -1.0).sqrt(), 3.0);
    let computed = [20, 40].map(|steps| oscillating(0.35, 3.0, 1.0, (2, steps)));
    // BDF2 is of second order: the difference is three times the error of the finer one
    let extrapolated = computed[1] + (computed[1] - computed[0]) / 3.0;
    let error = (extrapolated - exact).norm() / exact.norm();
    println!("{computed:?} {extrapolated} {exact}, relative error {error:e}");
    assert!(error < 5e-3);
}

#[test]
#[ignore = "slow: 2 min"]
fn oscillating_spheres_at_all_frequencies() {
    for (s, size, periods) in [
        (0.1, 0.35, 2),
        (1.0, 0.35, 2),
        (10.0, 0.3, 3),
        (100.0, 0.15, 12),
    ] {
        let exact = impedance(Complex::new(0.0, -s).sqrt(), 3.0);
        let computed = [20, 40].map(|steps| oscillating(size, 3.0, s, (periods, steps)));
        let extrapolated = computed[1] + (computed[1] - computed[0]) / 3.0;
        let error = (extrapolated - exact).norm() / exact.norm();
        println!("S = {s}: {extrapolated} {exact}, relative error {error:e}");
        assert!(error < 5e-3, "S = {s}: {error:e}");
    }
}
