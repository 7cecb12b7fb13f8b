//! Observed orders on a sphere in a concentric ball, where drag, torque and geometry are known exactly.

mod support;

use std::f64::consts::PI;

use mesh::{TetMesh, Vec3};
use support::meshes::{BODY, curved_shell, straight_shell};
use support::stokes::{Flow, solve_rigid};

const OUTER: f64 = 3.0;

#[test]
fn study() {
    let l: f64 = 1.0 / OUTER;
    let k = (1.0 - l.powi(5)) / (1.0 - 2.25 * l + 2.5 * l.powi(3) - 2.25 * l.powi(5) + l.powi(6));
    for n in [2, 3, 4, 6] {
        for mesh in [curved_shell(n, OUTER), straight_shell(n, OUTER)] {
            let t = std::time::Instant::now();
            let flow = solve_rigid(&mesh, BODY, Vec3::x(), Vec3::z());
            let r = fem::momentum_residual(
                &flow.stiffness,
                &flow.divergence,
                &flow.velocity,
                &flow.pressure,
            )
            .unwrap();
            let c = fem::consistent_load(&mesh, BODY, &r, Vec3::zeros(), Vec3::z()).unwrap();
            let s = fem::stress_load(&mesh, BODY, &flow.velocity, &flow.pressure, Vec3::zeros())
                .unwrap();
            let m = fem::surface_measures(&mesh, BODY).unwrap();
            println!(
                "n {n} cells {} drag {:+.3e} {:+.3e} torque {:+.3e} {:+.3e} vol {:+.3e} area {:+.3e} {:?}",
                mesh.cells().len(),
                c.force.x / (6.0 * PI * k) - 1.0,
                s.force.x / (6.0 * PI * k) - 1.0,
                c.torque.z * (1.0 - l.powi(3)) / (8.0 * PI) - 1.0,
                s.torque.z * (1.0 - l.powi(3)) / (8.0 * PI) - 1.0,
                m.volume * 0.75 / PI - 1.0,
                m.area / 4.0 / PI - 1.0,
                t.elapsed()
            );
        }
    }
}
