//! On a part of the mesh between symmetry planes the solution is the same as on the whole mesh.

use linalg::{BlockDiagonal, KrylovParams, SaddleLdlt, minres};
use nalgebra::Vector3;
use rigid::{DirectRows, Eliminated, ExternalLoad, Formulation, Independent, Lagrange, RigidError};

use crate::support::boxes::{Case, TOLERANCE, centres, part};

fn close(what: &str, a: impl Iterator<Item = f64>, b: impl Iterator<Item = f64>) {
    let (a, b): (Vec<f64>, Vec<f64>) = (a.collect(), b.collect());
    let size = b.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    // Residuals are relative to the right-hand side; errors of fluxes, forces and pressures are
    // larger by the condition number of their blocks.
    let tolerance = 1e4 * TOLERANCE * size;
    assert_eq!(a.len(), b.len());
    for (k, (a, b)) in a.iter().zip(&b).enumerate() {
        assert!(
            (a - b).abs() <= tolerance,
            "{what}, entry {k}: {a} instead of {b}"
        );
    }
}

/// Compares the flows on a part and on the whole mesh.
///
/// For each node of the whole mesh, `sources` lists its symmetry image on the part and the signs of
/// the velocity components.
fn same(part: &Case, whole: &Case, sources: &[(u32, Vector3<f64>)], formulation: &dyn Formulation) {
    let (own, own_iterations) = part.solve(formulation, 1.0);
    let (all, all_iterations) = whole.solve(formulation, 1.0);
    let name = formulation.name();
    println!("{name}: {own_iterations} iterations on the part, {all_iterations} on the whole mesh");
    close(name, own.bodies.iter().copied(), all.bodies.iter().copied());
    close(name, own.forces.iter().copied(), all.forces.iter().copied());
    if !part.set.joints().is_empty() {
        close(
            name,
            own.joint_load(0).unwrap().force.iter().copied(),
            all.joint_load(0).unwrap().force.iter().copied(),
        );
    }
    let images = sources
        .iter()
        .map(|(node, signs)| own.velocity[*node as usize].component_mul(signs));
    close(
        name,
        images.flat_map(|u| [u.x, u.y, u.z]),
        all.velocity.iter().flat_map(|u| [u.x, u.y, u.z]),
    );
    let pressures = sources.iter().take(all.pressure.len());
    close(
        name,
        pressures.map(|(node, _)| own.pressure[*node as usize]),
        all.pressure.iter().copied(),
    );
    // A multigrid hierarchy that respects the planes is about as good as that of the whole mesh.
    assert!(
        own_iterations <= all_iterations + 5,
        "{own_iterations} iterations on the part, {all_iterations} on the whole mesh"
    );
}

#[test]
fn a_swimmer_moves_on_a_half_or_a_quarter_as_on_the_whole_mesh() {
    for axes in [&[2][..], &[1, 2]] {
        let mesh = part(axes);
        let whole = mesh.unfolded().expect("planes at zero");
        let [part, all] = [mesh, whole.mesh].map(|mesh| Case::linked(mesh, centres(axes)));
        let formulations: [&dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];
        for formulation in formulations {
            same(&part, &all, &whole.sources, formulation);
        }
    }
}

#[test]
fn other_rates_on_a_quarter_are_another_right_hand_side() {
    let axes = [1, 2];
    let case = Case::linked(part(&axes), centres(&axes));
    let other = case.constraints(-0.3).expect("a rate");
    let formulations: [&dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];
    for formulation in formulations {
        let system = case.constrain(formulation, 1.0).expect("a system");
        let imposed = system.imposed(&case.drive(&other)).expect("the same link");
        let direct = case.constrain(formulation, -0.3).expect("a system");
        assert_eq!(imposed.rhs, direct.rhs);
    }
}

#[test]
fn loaded_bodies_move_on_a_half_as_on_the_whole_mesh() {
    let mesh = part(&[2]);
    let whole = mesh.unfolded().expect("planes at zero");
    // Forces in the plane and a torque about its normal are symmetric.
    let loads = vec![
        ExternalLoad {
            force: Vector3::new(1.0, -0.5, 0.0),
            torque: Vector3::new(0.0, 0.0, 0.3),
        },
        ExternalLoad {
            force: Vector3::new(0.0, 2.0, 0.0),
            torque: Vector3::zeros(),
        },
    ];
    let [part, all] =
        [mesh, whole.mesh].map(|mesh| Case::loaded(mesh, centres(&[2]), loads.clone()));
    same(&part, &all, &whole.sources, &Independent);
    same(&part, &all, &whole.sources, &Eliminated);
}

#[test]
fn minres_agrees_and_the_direct_solver_refuses() {
    let axes = [1, 2];
    let case = Case::linked(part(&axes), centres(&axes));
    let (flow, _) = case.solve(&Eliminated, 1.0);
    let system = case.constrain(&Eliminated, 1.0).expect("a system");
    let mut preconditioner =
        BlockDiagonal::with_prolongation(&system.system, &system.prolongation).expect("definite");
    let mut x = vec![0.0; system.rhs.len()];
    let params = KrylovParams::default().with_rel_tol(1e-8);
    minres(
        &system.system,
        &mut preconditioner,
        &system.rhs,
        &mut x,
        &params,
    )
    .expect("a solution");
    let other = system.flow(&x, &case.set).expect("a flow");
    let difference = (&other.bodies - &flow.bodies).amax();
    assert!(difference <= 1e-5 * flow.bodies.amax());
    let refused = SaddleLdlt::factor(&system.system, &Default::default()).err();
    assert!(matches!(
        refused,
        Some(linalg::LinalgError::ConstrainedDofs { .. })
    ));
}

#[test]
fn asymmetric_loads_bodies_and_walls_are_refused() {
    let across = ExternalLoad {
        force: Vector3::new(0.0, 0.0, 1.0),
        torque: Vector3::zeros(),
    };
    let still = ExternalLoad::default();
    let case = Case::loaded(part(&[2]), centres(&[2]), vec![still, across]);
    let refused = case.constrain(&Independent, 1.0).err();
    assert_eq!(refused, Some(RigidError::AsymmetricLoad { body: 1 }));
    let off = centres(&[2]).map(|x| x + Vector3::new(0.0, 0.0, 0.1));
    let case = Case::loaded(part(&[2]), off, vec![still; 2]);
    assert!(matches!(
        case.constrain(&Independent, 1.0).err(),
        Some(RigidError::OffSymmetryPlane { body: 0, .. })
    ));
    let mut case = Case::loaded(part(&[2]), centres(&[2]), vec![still; 2]);
    case.wall_velocity = Some(vec![Vector3::z(); case.mesh.n_points()]);
    assert!(matches!(
        case.constrain(&Independent, 1.0).err(),
        Some(RigidError::AsymmetricWallVelocity { normal: 1.0, .. })
    ));
}
