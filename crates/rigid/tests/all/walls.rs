//! Walls with a prescribed velocity, on exact solutions.

use nalgebra::Vector3;
use rigid::{DirectRows, Eliminated, ExternalLoad, Formulation, Independent, Lagrange, RigidError};

use crate::support::boxes::{Case, TOLERANCE, centres, part};

const LINKED: [&dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];

/// Velocities are of size 1 and forces up to about 20; both have errors larger than the residual.
const COMPARISON_TOLERANCE: f64 = 1e4 * TOLERANCE;

/// Prescribes a velocity on the wall and returns it at all nodes.
fn set_walls(
    case: &mut Case,
    velocity: impl Fn(Vector3<f64>) -> Vector3<f64>,
) -> Vec<Vector3<f64>> {
    let everywhere: Vec<_> = case.mesh.points().iter().map(|&x| velocity(x)).collect();
    case.wall_velocity = Some(everywhere.clone());
    everywhere
}

fn assert_moves_with_walls(case: &Case, formulation: &dyn Formulation, expected: &[Vector3<f64>]) {
    let (flow, _) = case.solve(formulation, 0.0);
    let name = formulation.name();
    for (u, expected) in flow.velocity.iter().zip(expected) {
        assert!(
            (u - expected).amax() < COMPARISON_TOLERANCE,
            "{name}: {u} at {expected}"
        );
    }
    assert!(
        flow.forces.amax() < 20.0 * COMPARISON_TOLERANCE,
        "{name}: {}",
        flow.forces
    );
    let joint_loads = flow.joint_loads.iter();
    assert!(
        joint_loads
            .clone()
            .all(|load| load.abs() < 20.0 * COMPARISON_TOLERANCE)
    );
    assert!(
        flow.pressure
            .iter()
            .all(|p| p.abs() < 1e3 * COMPARISON_TOLERANCE)
    );
}

/// A rigid motion of the walls is a solution for bodies and fluid, with no force and no pressure.
#[test]
fn everything_moves_with_walls_that_translate_and_rotate() {
    let motion =
        |x: Vector3<f64>| Vector3::new(0.3, -1.0, 0.4) + Vector3::new(0.5, 0.2, -0.7).cross(&x);
    let mut linked = Case::linked(part(&[]), centres(&[]));
    let expected = set_walls(&mut linked, motion);
    for formulation in LINKED {
        assert_moves_with_walls(&linked, formulation, &expected);
    }
    let mut separate = Case::loaded(part(&[]), centres(&[]), vec![ExternalLoad::default(); 2]);
    set_walls(&mut separate, motion);
    assert_moves_with_walls(&separate, &Independent, &expected);
}

/// As above, along the line in which two symmetry planes intersect.
#[test]
fn a_quarter_moves_with_its_walls() {
    let axes = [1, 2];
    let mut case = Case::linked(part(&axes), centres(&axes));
    let expected = set_walls(&mut case, |_| Vector3::x());
    for formulation in LINKED {
        assert_moves_with_walls(&case, formulation, &expected);
    }
}

/// Forces on fixed bodies in moving walls, as external loads in walls at rest, give the opposite
/// velocity: only relative velocities matter. The gaps are one cell wide, so that some nodes of the
/// bodies are neighbours of nodes of the wall.
#[test]
fn forces_depend_on_the_velocity_relative_to_the_walls() {
    let wind = Vector3::new(1.0, 0.5, -0.3);
    let still = vec![ExternalLoad::default(); 2];
    let mut obstacles = Case::loaded(part(&[]), centres(&[]), still);
    obstacles.set = (obstacles.set).with_held(&[0, 1], &[0, 1]).expect("bodies");
    set_walls(&mut obstacles, |_| wind);
    let (flow, _) = obstacles.solve(&Eliminated, 0.0);
    assert!(flow.bodies.amax() == 0.0 && flow.forces.amax() > 1.0);
    let load = |body: usize| ExternalLoad {
        force: flow.forces.fixed_rows::<3>(6 * body).into_owned(),
        torque: flow.forces.fixed_rows::<3>(6 * body + 3).into_owned(),
    };
    let dragged = Case::loaded(part(&[]), centres(&[]), vec![load(0), load(1)]);
    let (flow, _) = dragged.solve(&Independent, 0.0);
    for body in 0..2 {
        let velocity = flow.bodies.fixed_rows::<3>(6 * body) + wind;
        assert!(
            velocity.amax() < COMPARISON_TOLERANCE,
            "body {body}: {velocity}"
        );
        let rotation = flow.bodies.fixed_rows::<3>(6 * body + 3);
        assert!(
            rotation.amax() < COMPARISON_TOLERANCE / 0.1,
            "body {body}: {rotation}"
        );
    }
}

#[test]
fn walls_of_zero_velocity_are_walls_at_rest() {
    let mut case = Case::linked(part(&[]), centres(&[]));
    let at_rest = case.constrain(&Eliminated, 1.0).expect("a system");
    set_walls(&mut case, |_| Vector3::zeros());
    let zero = case.constrain(&Eliminated, 1.0).expect("a system");
    assert_eq!(at_rest.rhs, zero.rhs);
}

#[test]
fn walls_that_change_the_volume_are_refused() {
    let mut case = Case::linked(part(&[]), centres(&[]));
    set_walls(&mut case, |x| x);
    let refused = case.constrain(&Eliminated, 0.0).err();
    // the volume of the unit cube grows by its divergence, 3
    assert!(
        matches!(
            refused,
            // All of the walls' fluxes have the same sign.
            Some(RigidError::NetWallFlux { flux, relative })
                if (flux + 3.0).abs() < 1e-9 && (0.1..=1.0 + 1e-12).contains(&relative)
        ),
        "{refused:?}"
    );
    set_walls(&mut case, |x| x * f64::NAN);
    let refused = case.constrain(&Eliminated, 0.0).err();
    assert!(matches!(refused, Some(RigidError::NotFinite { .. })));
}
