//! Runs in background flows, with slip and with gravity.

use std::f64::consts::PI;

use swimmer::{Method, choose, simulate, with_tables};

use crate::scenes::parse;

/// Gravity: the weight is the excess of the density times the volume.
#[test]
fn spheres_settle_with_the_velocity_of_stokes() {
    let scene = parse(
        "gravity = [0, 0, -9]\nfluid = { viscosity = 2, density = 3 }\n\
         [[bodies]]\nname = \"s\"\nradius = 0.5\nposition = [0, 0, 0]\ndensity = 4\n",
    );
    let solution = swimmer::solve_start(&scene, &mut *choose(&scene).unwrap().model).unwrap();
    // U = 2 a^2 (rho - rho_f) g / (9 mu)
    let expected = -2.0 * 0.25 * 9.0 / (9.0 * 2.0);
    assert!((solution.bodies[0].velocity.z - expected).abs() < 1e-9);
}

/// Drift angle atan((U1 - U2) / (U1 + U2)) at 45 degrees, with the speeds along and across the axis
/// of Oberbeck's formulas.
#[test]
fn the_settling_template_has_the_exact_drift_angle() {
    let scene = parse(include_str!("../../templates/settling.toml"));
    let solution = swimmer::solve_start(&scene, &mut *choose(&scene).unwrap().model).unwrap();
    let u = solution.bodies[0].velocity;
    let angle = (u.x.abs() / -u.z).atan().to_degrees();
    assert!((angle - 3.875_218).abs() < 1e-3, "{angle}");
    let bar = solution.error_estimate.total();
    assert!(u.y.abs() < bar && bar < 1e-3 * u.norm());
}

#[test]
fn auto_takes_multipoles_for_spheres_with_slip_and_elements_for_tumbling_spheroids() {
    let squirmer = parse(include_str!("../../templates/squirmer.toml"));
    assert_eq!(choose(&squirmer).unwrap().model.name(), "multipole");
    let jeffery = parse(include_str!("../../templates/jeffery.toml"));
    assert_eq!(choose(&jeffery).unwrap().model.name(), "fem");
    let axial = parse(
        "background = { kind = \"uniform\", velocity = [1, 0, 0] }\n[[bodies]]\nname = \"s\"\n\
         shape = \"spheroid\"\nradius = 1\nhalf_length = 2\nposition = [0, 0, 0]\n\
         slip = { b1 = 1 }\n",
    );
    let mut model = choose(&axial).unwrap().model;
    assert_eq!(model.name(), "axisymmetric");
    // carried by the flow
    let solution = swimmer::solve_start(&axial, &mut *model).unwrap();
    assert!((solution.bodies[0].velocity.x - 1.826_436_002_5).abs() < 1e-6);
}

/// A squirmer alone swims straight at 2 B1 / 3, whatever its second mode.
#[test]
fn a_lone_squirmer_swims_straight() {
    let scene = parse(
        "gait.phases = [{ duration = 3 }]\n\
         [[bodies]]\nname = \"s\"\nradius = 2\nposition = [1, 0, 0]\n\
         slip = { b1 = 1.5, b2 = -4, axis = [0, 1, 0] }\n",
    );
    let mut model = choose(&scene).unwrap().model;
    let outcome = simulate(&scene, &mut *model, Method::Collocation, &mut ()).unwrap();
    assert!((outcome.displacement[0].y - 3.0).abs() < 1e-9);
    assert!(outcome.displacement[0].xz().norm() < 1e-9);
    // the dissipation 8 pi a (2 B1^2 + B2^2) / 3 over the duration
    let work = 3.0 * 8.0 * PI * 2.0 * (2.0 * 2.25 + 16.0) / 3.0;
    assert!((outcome.work / work - 1.0).abs() < 1e-6, "{}", outcome.work);
}

/// Jeffery (1922): the period is 2 pi (r + 1 / r) over the shear rate; half of it turns by pi.
///
/// Solutions are superposed from five orientations, so that a run takes seconds. A spheroid of
/// aspect ratio 10 is a row of `cargo xtask validate`.
#[test]
fn jeffery_orbits_have_the_exact_period() {
    let scene = parse(include_str!("../../templates/jeffery.toml"));
    let mut model = with_tables(&scene, choose(&scene).unwrap()).unwrap().model;
    let outcome = simulate(&scene, &mut *model, Method::Collocation, &mut ()).unwrap();
    let turned = outcome.rotation.norm();
    assert!((turned - PI).abs() < 1e-3 * 2.0 * PI, "{turned}");
}
