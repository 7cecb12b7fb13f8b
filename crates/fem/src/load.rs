//! Forces and torques that bodies exert on the fluid, by residual and by stress.

use linalg::{Csr, Csr3};
use mesh::{Facet, TetMesh, Vec3};
use nalgebra::Matrix3;
use rayon::prelude::*;

use crate::FemError;
use crate::check::check_array;
use crate::geometry::MapAt;
use crate::quadrature::{CellPoint, FacetPoint, facet_degree_6};
use crate::sum::sum_over;
use crate::surface::{facet_nodes, position_and_normal, surface_measures, tagged_facets};

/// Force and torque exerted by a body on the fluid, at viscosity 1: the drag on a moving body has the sign of its
/// velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadOnFluid {
    /// Force.
    pub force: Vec3,
    /// Torque about the centre asked for.
    pub torque: Vec3,
}

/// The residual of momentum without loads, `r = K u + B^T p`: zero at free nodes of a solution, the nodal forces of
/// the bodies on the fluid at theirs.
///
/// Shapes: `stiffness` and `divergence` as [`TaylorHood::stiffness`](crate::TaylorHood::stiffness) and
/// [`TaylorHood::divergence`](crate::TaylorHood::divergence) make them, over all points; `velocity` and the result
/// `3 n_points` (`3 j + c` is component `c` at point `j`); `pressure` `n_vertices`.
/// # Errors
/// Shapes that do not fit; a velocity or pressure that is not finite.
pub fn momentum_residual(
    stiffness: &Csr,
    divergence: &Csr3,
    velocity: &[f64],
    pressure: &[f64],
) -> Result<Vec<f64>, FemError> {
    let n = stiffness.rows();
    let expect = |what, found, expected| {
        if found == expected {
            Ok(())
        } else {
            Err(FemError::Length {
                what,
                found,
                expected,
            })
        }
    };
    expect("a row of the stiffness matrix", stiffness.cols(), n)?;
    expect("a row of the divergence", divergence.cols(), n)?;
    check_array("the velocity", velocity, 3 * n)?;
    check_array("the pressure", pressure, divergence.rows())?;

    let mut residual = vec![0.0; 3 * n];
    let (starts, columns, values) = (stiffness.indptr(), stiffness.indices(), stiffness.data());
    residual
        .par_chunks_mut(3)
        .enumerate()
        .with_min_len(256)
        .for_each(|(row, r)| {
            for k in starts.outer_inds_sz(row) {
                let u = &velocity[3 * columns[k] as usize..][..3];
                for c in 0..3 {
                    r[c] += values[k] * u[c];
                }
            }
        });
    for (b, (row, column)) in divergence.iter() {
        let (p, r) = (pressure[row as usize], 3 * column as usize);
        for c in 0..3 {
            residual[r + c] += b[c] * p;
        }
    }
    Ok(residual)
}

/// Force and torque about `centre` of the body whose facets have `tag`, from the momentum residual:
/// `F = sum r_b`, `T = sum (x_b - centre) x r_b + 2 |B_h| omega`.
///
/// These are the consistent loads: their error is the energy of the discretisation error, fourth order on curved
/// cells. The last term turns the torque of the grad-grad form into that of the stress; `omega` is the angular
/// velocity of the body, `|B_h|` its discrete volume. Needs velocities that are rigid on the body and zero or rigid
/// on the rest of the boundary.
/// Shapes: `residual` `3 n_points`, of [`momentum_residual`]. The force does not depend on the mean of the pressure
/// beyond rounding: the surface is closed.
/// # Errors
/// As [`surface_measures`]; a residual of the wrong length or not finite.
pub fn consistent_load(
    mesh: &TetMesh,
    tag: u16,
    residual: &[f64],
    centre: Vec3,
    angular_velocity: Vec3,
) -> Result<LoadOnFluid, FemError> {
    check_array("the residual", residual, 3 * mesh.n_points())?;
    let volume = surface_measures(mesh, tag)?.volume;
    let mut load = LoadOnFluid {
        force: Vec3::zeros(),
        torque: 2.0 * volume * angular_velocity,
    };
    for node in mesh.nodes_on(tag) {
        let node = node as usize;
        let r = Vec3::from_column_slice(&residual[3 * node..3 * node + 3]);
        load.force += r;
        load.torque += (mesh.points()[node] - centre).cross(&r);
    }
    Ok(load)
}

/// Force and torque about `centre` of the body whose facets have `tag`, from the stress on its surface:
/// `F = oint s n dS`, `T = oint (x - centre) x s n dS` with `s = -p 1 + grad u + grad u^T` and `n` out of the fluid.
///
/// A second path, independent of the matrices and right for every boundary condition, but of lower order (1.3 to 2
/// measured) than [`consistent_load`]: for checks.
/// Shapes: `velocity` `3 n_points`, `pressure` `n_vertices`.
/// # Errors
/// No facet has the tag; arrays of the wrong length or not finite; an inverted cell at the surface.
pub fn stress_load(
    mesh: &TetMesh,
    tag: u16,
    velocity: &[f64],
    pressure: &[f64],
    centre: Vec3,
) -> Result<LoadOnFluid, FemError> {
    check_array("the velocity", velocity, 3 * mesh.n_points())?;
    check_array("the pressure", pressure, mesh.n_vertices())?;
    let facets = tagged_facets(mesh, tag)?;
    let [fx, fy, fz, tx, ty, tz] = sum_over(facets.len(), |k| {
        let facet = facets[k];
        let (mut force, mut torque) = (Vec3::zeros(), Vec3::zeros());
        let cell = facet.cell as usize;
        let nodes = &mesh.cells()[cell];
        let (positions, surface) = (mesh.cell_points(cell), facet_nodes(mesh, facet));
        for point in facet_degree_6() {
            let at = facet_cell_point(facet, nodes, point);
            let map = MapAt::new(cell, &positions, &at)?;
            let mut stress = velocity_gradient(nodes, velocity, &map.gradients(&at));
            stress += stress.transpose();
            let p: f64 = (0..4)
                .map(|q| at.barycentric[q] * pressure[nodes[q] as usize])
                .sum();
            stress -= Matrix3::from_diagonal_element(p);
            let (x, normal) = position_and_normal(&surface, point);
            let traction = stress * normal * point.weight;
            force += traction;
            torque += (x - centre).cross(&traction);
        }
        Ok([force.x, force.y, force.z, torque.x, torque.y, torque.z])
    })?;
    Ok(LoadOnFluid {
        force: Vec3::new(fx, fy, fz),
        torque: Vec3::new(tx, ty, tz),
    })
}

/// A point of a facet as one of its cell, which has these nodes.
pub(crate) fn facet_cell_point(facet: &Facet, nodes: &[u32; 10], point: &FacetPoint) -> CellPoint {
    // Of the cell's four vertices three are the facet's; the coordinate of the fourth is zero.
    let barycentric = [0, 1, 2, 3].map(|local| {
        let corner = facet.nodes[..3]
            .iter()
            .position(|&node| node == nodes[local]);
        corner.map_or(0.0, |corner| point.barycentric[corner])
    });
    CellPoint::new(barycentric, point.weight)
}

/// `(c, k) -> d u_c / d x_k` in a cell with the given shape gradients.
pub(crate) fn velocity_gradient(
    nodes: &[u32; 10],
    velocity: &[f64],
    gradients: &[Vec3; 10],
) -> Matrix3<f64> {
    let mut gradient = Matrix3::zeros();
    for (&node, g) in nodes.iter().zip(gradients) {
        let u = Vec3::from_column_slice(&velocity[3 * node as usize..][..3]);
        gradient += u * g.transpose();
    }
    gradient
}
