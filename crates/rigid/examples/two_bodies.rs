//! Two spheres that are pushed apart: from the matrices of any finite-element code to velocities.
//!
//! The relative velocity is compared with the mobility functions of two equal spheres in unbounded
//! fluid at a distance of four radii (Jeffrey & Onishi 1984).

mod assembled;

use std::error::Error;
use std::f64::consts::PI;

use linalg::{KrylovParams, fgmres};
use nalgebra::Vector3;
use rigid::{
    Arms, Articulation, BodyKind, Drive, ExternalLoad, FluidNodes, Formulation, Independent,
    RigidFluid,
};

/// Runs the example and checks its result.
pub fn main() -> Result<(), Box<dyn Error>> {
    let centres = [-2.0, 2.0].map(|x| Vector3::new(x, 0.0, 0.0));

    // Input from your own finite-element code: matrices over all nodes, the nodes and their roles.
    let mesh = assembled::spheres_in_ball(&centres, 0.5, 60.0)?;

    // The fluid with its rigid surfaces.
    let nodes = FluidNodes::new(&mesh.points, &mesh.roles);
    let fluid = RigidFluid::new(mesh.matrices, nodes, &mesh.bodies)?;

    // Two independent bodies with opposite forces of size 1.
    let set = Articulation::new(&[BodyKind::Rigid; 2], Vec::new(), Arms::Clamped, &centres)?;
    let push = |force: Vector3<f64>| ExternalLoad {
        force,
        torque: Vector3::zeros(),
    };
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&set.initial_state(), &[], &[])?,
        loads: &[push(-Vector3::x()), push(Vector3::x())],
    };

    // The system, solved to a true relative residual of 1e-8.
    let constrained = Independent.constrain(fluid, &drive)?;
    let mut preconditioner = constrained.preconditioner()?;
    let mut solution = vec![0.0; constrained.rhs.len()];
    let report = fgmres(
        &constrained.system,
        &mut preconditioner,
        &constrained.rhs,
        &mut solution,
        &KrylovParams::default(),
    )?;
    let flow = constrained.flow(&solution, &set)?;

    println!("{} dofs, {} iterations", solution.len(), report.iterations);
    println!("velocity of the right sphere {:.5}", flow.bodies[6]);
    println!(
        "force of the right sphere on the fluid {:.5}",
        flow.forces[6]
    );

    // 6 π a U / F = x_11 - x_12 with x_11 = 1 - (15/4) s^-4 + (11/2) s^-6 and
    // x_12 = (3/2) s^-1 - s^-3 + (75/4) s^-7, s = 4. The mesh is coarse: the error is 0.5 %.
    let mobility = 6.0 * PI * flow.bodies[6];
    assert!((mobility - 0.6262).abs() < 0.01 * 0.6262, "{mobility}");
    assert!((flow.forces[6] - 1.0).abs() < 1e-6);
    Ok(())
}
