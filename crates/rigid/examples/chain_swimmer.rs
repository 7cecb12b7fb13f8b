//! A chain of three spheres, one of whose arms closes: velocities, forces and the next state.
//!
//! Every formulation gives the same flow. Its velocity is compared with the far field of three
//! small spheres in unbounded fluid (Najafi & Golestanian 2004).

mod assembled;

use std::error::Error;

use linalg::{KrylovParams, fgmres};
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};
use rigid::{
    Arms, Articulation, BodyKind, DirectRows, Drive, Eliminated, ExternalLoad, FluidNodes,
    Formulation, Joint, Lagrange, RigidFluid,
};

/// Distance of neighbouring spheres, in radii.
const ARM: f64 = 8.0;

/// Runs the example and checks its result.
pub fn main() -> Result<(), Box<dyn Error>> {
    let centres = [-ARM, 0.0, ARM].map(|x| Vector3::new(x, 0.0, 0.0));
    let mesh = assembled::spheres_in_ball(&centres, 0.6, 60.0)?;
    let nodes = FluidNodes::new(&mesh.points, &mesh.roles);
    let fluid = RigidFluid::new(mesh.matrices, nodes, &mesh.bodies)?;

    // Two arms from the centre; the left one closes at unit speed, the right one keeps its length.
    let joint = |name: &str, body: usize| Joint::slide(name, body, 1);
    let joints = vec![joint("left arm", 0), joint("right arm", 2)];
    let set = Articulation::new(&[BodyKind::Rigid; 3], joints, Arms::Clamped, &centres)?;
    let state = set.initial_state();
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&state, set.initial_shape(), &[-1.0, 0.0])?,
        loads: &[ExternalLoad::default(); 3],
    };

    let formulations: [&dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];
    for formulation in formulations {
        let constrained = formulation.constrain(fluid.clone(), &drive)?;
        let mut solution = vec![0.0; constrained.rhs.len()];
        let report = fgmres(
            &constrained.system,
            &mut constrained.preconditioner()?,
            &constrained.rhs,
            &mut solution,
            &KrylovParams::default(),
        )?;
        let flow = constrained.flow(&solution, &set)?;
        println!(
            "{}: {} dofs, {} iterations, velocity of the centre {:.5}, force of the left arm {:.4}",
            formulation.name(),
            solution.len(),
            report.iterations,
            flow.bodies[6],
            flow.joint_load(0)?.force.x
        );

        // The arm closes at the prescribed rate, and no external force acts on the swimmer.
        assert!((flow.bodies[0] - flow.bodies[6] - 1.0).abs() < 1e-9);
        assert!((flow.forces[0] + flow.forces[6] + flow.forces[12]).abs() < 1e-4);
        let expected = far_field();
        assert!((flow.bodies[6] - expected).abs() < 0.02 * expected.abs());

        // The configuration after a small step of time.
        let dt = 0.01;
        let next = set.advance(&state, &(&flow.state * dt))?;
        let poses = set.place(&next, &[ARM - dt, ARM])?;
        let moved = (poses[1].translation.x - centres[1].x) / dt;
        assert!((moved - flow.bodies[6]).abs() < 1e-9);
    }
    Ok(())
}

/// Velocity of the middle sphere from the collinear far-field mobility `(3/2) s^-1 - s^-3`.
fn far_field() -> f64 {
    let mobility = Matrix3::from_fn(|i, j| match i.abs_diff(j) as f64 * ARM {
        0.0 => 1.0,
        s => 1.5 / s - s.powi(-3),
    });
    // Forces f and the velocity V of the middle: mobility f - V 1 = relative velocities, sum f = 0.
    let mut system = Matrix4::zeros();
    system.fixed_view_mut::<3, 3>(0, 0).copy_from(&mobility);
    system.fixed_view_mut::<3, 1>(0, 3).fill(-1.0);
    system.fixed_view_mut::<1, 3>(3, 0).fill(1.0);
    let relative = Vector4::new(1.0, 0.0, 0.0, 0.0);
    system.lu().solve(&relative).map_or(f64::NAN, |x| x[3])
}
