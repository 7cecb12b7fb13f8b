//! The fluid block that all formulations share: free nodes, and the border that rigid surfaces put around them.

use std::ops::AddAssign;

use linalg::{Csr, Csr3};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::articulation::check_length;
use crate::node_blocks::{NOT_FREE, NodeBlocks, block};
use crate::node_order;
use crate::{RigidError, SymmetryPlanes};

/// What determines the velocity of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeRole {
    /// The flow: an unknown.
    Free,
    /// A no-slip wall at rest.
    Fixed,
    /// The rigid body of this number: $u = U + \omega \times (x - c)$.
    Body(u32),
}

/// Rigid surfaces in the mesh: where they are and how much fluid they displace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceBody {
    /// The point `c` that velocities and torques refer to.
    pub centre: Vector3<f64>,
    /// Volume enclosed by the discrete surface and the mirror planes, $|B_h|$.
    pub volume: f64,
}

/// Finite-element matrices over all nodes, Dirichlet nodes included, for viscosity 1.
///
/// Owned: [`RigidFluid::new`] frees each matrix once its block stands.
#[derive(Clone)]
pub struct FluidMatrices<'a> {
    /// Scalar stiffness $K_{ij} = \int \nabla N_i \cdot \nabla N_j$, nodes x nodes.
    pub stiffness: Csr,
    /// $b_{qj} = -\int \psi_q \nabla N_j$, pressure unknowns x nodes.
    pub divergence: Csr3,
    /// Pressure mass matrix.
    pub pressure_mass: Csr,
    /// Values at all nodes from values at the vertices (the first nodes), nodes x vertices.
    pub interpolation: Csr,
    /// Stiffness of the vertices' own functions, $I^T K I$ with `I` the interpolation; vertices x vertices.
    pub vertex_stiffness: Csr,
    /// Positions of the nodes.
    pub points: &'a [Vector3<f64>],
    /// Role of each node.
    pub roles: &'a [NodeRole],
    /// Nodes on mirror planes, ascending, each with the axes that its planes are normal to; none if the mesh is whole. See [`SymmetryPlanes`].
    pub on_symmetry_planes: Vec<(u32, [bool; 3])>,
}

/// The fluid's equations at free nodes and their border: 6 columns `(U, omega)` a rigid body.
///
/// With $u_b = P_b (U, \omega)$ at the nodes of a body, $P_b = [I, -[x_b - c]_\times]$, the border is $K_{IB} P$, the corner
/// $P^T K_{BB} P + 2 |B_h| \omega\cdot\omega$ and the divergence of rigid motions $B_B P$. The volume term makes the
/// three scalar stiffness blocks equal to $2 D:D$ less a grad-div term for rigid surfaces and no-slip walls
/// (by the divergence theorem in the body; without it torques are a third too small).
#[derive(Clone, Debug)]
pub struct RigidFluid {
    /// Scalar stiffness of the free nodes, in the order of [`free_nodes`](Self::free_nodes).
    pub stiffness: Csr,
    /// Divergence, pressure unknowns x free nodes in that order.
    pub divergence: Csr3,
    /// Pressure mass matrix.
    pub pressure_mass: Csr,
    /// Values at free nodes in that order from values at free vertices, ascending.
    pub interpolation: Csr,
    /// Stiffness of the free vertices, ascending.
    pub vertex_stiffness: Csr,
    /// $K_{IB} P$: three rows a free node, six columns a body.
    pub border: Csr,
    /// $P^T K_{BB} P$ with the volume term.
    pub corner: DMatrix<f64>,
    /// $B_B P$: pressure unknowns x six columns a body.
    pub rigid_divergence: Csr,
    /// The rigid part of values interpolated from vertices: three rows a free node, six columns a body.
    pub interpolation_border: Csr,
    /// Node number of each free node, in the order of the unknowns.
    pub free_nodes: Vec<u32>,
    /// Free nodes on mirror planes by their number among the free ones, with the components that are zero there.
    pub held: Vec<(u32, [bool; 3])>,
    mirrors: SymmetryPlanes,
    roles: Vec<NodeRole>,
    arms: Vec<Vector3<f64>>,
}

impl RigidFluid {
    /// Sorts nodes into free, fixed and body nodes and gathers the border of the bodies.
    ///
    /// Free nodes are renumbered so that neighbours lie close together. Cost: three passes over the matrices. The same for any number of threads.
    ///
    /// # Errors
    /// Arrays or matrices whose sizes do not fit, or a role that names a body that does not exist.
    pub fn new(matrices: FluidMatrices, bodies: &[SurfaceBody]) -> Result<Self, RigidError> {
        let FluidMatrices {
            stiffness,
            divergence,
            pressure_mass,
            interpolation,
            vertex_stiffness,
            points,
            roles,
            on_symmetry_planes,
        } = matrices;
        // compressed matrices may also hold columns
        let (stiffness, interpolation) = (stiffness.into_csr(), interpolation.into_csr());
        let (divergence, vertex_stiffness) = (divergence.into_csr(), vertex_stiffness.into_csr());
        let nodes = points.len();
        let vertices = vertex_stiffness.rows();
        if vertices > nodes {
            return Err(RigidError::Length {
                what: "nodes, vertices among them",
                expected: vertices,
                found: nodes,
            });
        }
        check_length(
            "columns of the vertices' stiffness",
            vertex_stiffness.cols(),
            vertices,
        )?;
        check_length("columns of the stiffness", stiffness.cols(), nodes)?;
        check_length("roles of the nodes", roles.len(), nodes)?;
        check_length("rows of the stiffness", stiffness.rows(), nodes)?;
        check_length("columns of the divergence", divergence.cols(), nodes)?;
        check_length(
            "rows of the pressure mass",
            pressure_mass.rows(),
            divergence.rows(),
        )?;
        check_length("rows of the interpolation", interpolation.rows(), nodes)?;
        check_length(
            "columns of the interpolation",
            interpolation.cols(),
            vertices,
        )?;
        let count = bodies.len();
        if let Some(NodeRole::Body(body)) = roles
            .iter()
            .find(|r| matches!(r, NodeRole::Body(b) if *b as usize >= count))
        {
            return Err(RigidError::Length {
                what: "rigid bodies",
                expected: *body as usize + 1,
                found: count,
            });
        }
        let is_free = |node: usize| roles[node] == NodeRole::Free;
        let free_nodes = node_order::free_nodes(&interpolation, is_free);
        let free_number = numbers(nodes, &free_nodes);
        let free_vertices: Vec<u32> = (0..vertices as u32)
            .filter(|&vertex| is_free(vertex as usize))
            .collect();
        let vertex_number = numbers(vertices, &free_vertices);
        let mirrors = SymmetryPlanes::of(&on_symmetry_planes);
        for (number, body) in bodies.iter().enumerate() {
            let off = body.centre.iter().zip(mirrors.planes);
            if let Some((distance, _)) = off.into_iter().find(|(x, plane)| *plane && **x != 0.0) {
                return Err(RigidError::OffSymmetryPlane {
                    body: number,
                    distance: distance.abs(),
                });
            }
        }
        let mut held: Vec<(u32, [bool; 3])> = on_symmetry_planes
            .iter()
            .filter_map(|&(node, planes)| {
                let number = *free_number.get(node as usize)?;
                (number != NOT_FREE).then_some((number, planes))
            })
            .collect();
        held.sort_unstable_by_key(|&(number, _)| number);
        let arms: Vec<Vector3<f64>> = (0..nodes)
            .map(|node| match roles[node] {
                NodeRole::Body(body) => points[node] - bodies[body as usize].centre,
                _ => Vector3::zeros(),
            })
            .collect();
        let blocks = NodeBlocks {
            roles,
            arms: &arms,
            bodies: count,
        };
        let mut corner = blocks.corner(&stiffness);
        for (number, body) in bodies.iter().enumerate() {
            for axis in 3..6 {
                corner[(6 * number + axis, 6 * number + axis)] += 2.0 * body.volume;
            }
        }
        let (border, (interpolation_border, rigid_divergence)) = rayon::join(
            || blocks.border(&stiffness, &free_nodes),
            || {
                rayon::join(
                    || blocks.border(&interpolation, &free_nodes),
                    || blocks.rigid_divergence(&divergence),
                )
            },
        );
        let all_pressures: Vec<u32> = (0..divergence.rows() as u32).collect();
        let (stiffness, (divergence, (interpolation, vertex_stiffness))) = rayon::join(
            || block(stiffness, &free_nodes, &free_number, free_nodes.len()),
            || {
                let (nodes, vertices) = (free_nodes.len(), free_vertices.len());
                (
                    block(divergence, &all_pressures, &free_number, nodes),
                    (
                        block(interpolation, &free_nodes, &vertex_number, vertices),
                        block(vertex_stiffness, &free_vertices, &vertex_number, vertices),
                    ),
                )
            },
        );
        Ok(Self {
            stiffness,
            divergence,
            pressure_mass,
            interpolation,
            vertex_stiffness,
            border,
            corner,
            rigid_divergence,
            interpolation_border,
            free_nodes,
            held,
            mirrors,
            roles: roles.to_vec(),
            arms,
        })
    }

    /// Refuses a fluid in which some velocity is not determined.
    ///
    /// A Krylov method would answer all the same: the right-hand side of a force-free swimmer is compatible.
    ///
    /// # Errors
    /// [`RigidError::NoWall`], [`RigidError::NoSurface`].
    pub(crate) fn check_determined(&self) -> Result<(), RigidError> {
        if !self.roles.contains(&NodeRole::Fixed) {
            return Err(RigidError::NoWall);
        }
        let is_bare = |body: &usize| !self.roles.contains(&NodeRole::Body(*body as u32));
        match (0..self.bodies()).find(is_bare) {
            Some(body) => Err(RigidError::NoSurface { body }),
            None => Ok(()),
        }
    }

    /// Number of rigid bodies with a surface.
    pub fn bodies(&self) -> usize {
        self.corner.nrows() / 6
    }

    /// Planes beyond which the fluid goes on as its own mirror image.
    pub fn symmetry_planes(&self) -> SymmetryPlanes {
        self.mirrors
    }

    /// Number of nodes, whatever their role.
    pub(crate) fn nodes(&self) -> usize {
        self.roles.len()
    }

    /// Forces and torques on the bodies, `(F, T)` a body, of forces on the nodes of their surfaces (interleaved, one triple a node of the mesh).
    pub(crate) fn loads_of_forces(&self, forces: &[f64]) -> DVector<f64> {
        let mut loads = DVector::zeros(6 * self.bodies());
        let nodes = self.roles.iter().zip(&self.arms);
        for ((role, arm), force) in nodes.zip(forces.chunks_exact(3)) {
            if let NodeRole::Body(body) = role {
                let force = Vector3::from_column_slice(force);
                let first = 6 * *body as usize;
                let mut own = loads.fixed_rows_mut::<6>(first);
                own.fixed_rows_mut::<3>(0).add_assign(&force);
                own.fixed_rows_mut::<3>(3).add_assign(&arm.cross(&force));
            }
        }
        loads
    }

    /// Velocities at all nodes from those at free nodes (interleaved) and of the bodies (six a body).
    pub fn all_velocities(&self, free: &[f64], bodies: &DVector<f64>) -> Vec<Vector3<f64>> {
        let mut velocity: Vec<Vector3<f64>> = self
            .roles
            .iter()
            .zip(&self.arms)
            .map(|(role, arm)| match role {
                NodeRole::Body(body) => {
                    let first = 6 * *body as usize;
                    let angular = bodies.fixed_rows::<3>(first + 3).into_owned();
                    bodies.fixed_rows::<3>(first) + angular.cross(arm)
                }
                _ => Vector3::zeros(),
            })
            .collect();
        for (&node, value) in self.free_nodes.iter().zip(free.chunks_exact(3)) {
            velocity[node as usize] = Vector3::from_column_slice(value);
        }
        velocity
    }

    /// Consistent forces and torques that the bodies exert on the fluid, `(F, T)` a body.
    ///
    /// Those on whole bodies, where mirror planes cut them.
    ///
    /// The residual of the momentum equation tested with rigid motions:
    /// $F = (K_{IB} P)^T u_I + M U + (B_B P)^T p$; fourth order on curved quadratic surfaces, because it is the energy of the flow.
    pub fn forces(&self, free: &[f64], bodies: &DVector<f64>, pressure: &[f64]) -> DVector<f64> {
        let mut forces = &self.corner * bodies;
        add_transposed(&self.border, free, &mut forces);
        add_transposed(&self.rigid_divergence, pressure, &mut forces);
        self.mirrors.whole(forces)
    }
}

/// The place of each of `0..len` in a list; [`NOT_FREE`] for those that are not in it.
fn numbers(len: usize, list: &[u32]) -> Vec<u32> {
    let mut numbers = vec![NOT_FREE; len];
    for (number, &item) in list.iter().enumerate() {
        numbers[item as usize] = number as u32;
    }
    numbers
}

/// `y += A^T x` for a matrix with few columns; serial, so the order of the sum is fixed.
fn add_transposed(matrix: &Csr, x: &[f64], y: &mut DVector<f64>) {
    for (row, &value) in matrix.outer_iterator().zip(x) {
        for (column, &entry) in row.iter() {
            y[column] += entry * value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity(rows: usize, cols: usize) -> Csr {
        let ends = (0..=rows).map(|row| row.min(cols)).collect();
        let entries = rows.min(cols);
        let columns = (0..entries as u32).collect();
        Csr::new((rows, cols), ends, columns, vec![1.0; entries])
    }

    /// Four nodes, two of them vertices.
    fn matrices<'a>(points: &'a [Vector3<f64>], roles: &'a [NodeRole]) -> FluidMatrices<'a> {
        FluidMatrices {
            stiffness: identity(4, 4),
            divergence: Csr3::zero((2, 4)),
            pressure_mass: identity(2, 2),
            interpolation: identity(4, 2),
            vertex_stiffness: identity(2, 2),
            points,
            roles,
            on_symmetry_planes: Vec::new(),
        }
    }

    #[test]
    fn matrices_that_do_not_fit_are_refused() {
        let (points, roles) = ([Vector3::zeros(); 4], [NodeRole::Free; 4]);
        let fluid = |change: &dyn Fn(&mut FluidMatrices)| {
            let mut matrices = matrices(&points, &roles);
            change(&mut matrices);
            RigidFluid::new(matrices, &[])
        };
        assert!(fluid(&|_| ()).is_ok());
        let misfits: [&dyn Fn(&mut FluidMatrices); 8] = [
            &|m| m.stiffness = identity(4, 5),
            &|m| m.stiffness = identity(5, 4),
            &|m| m.divergence = Csr3::zero((2, 3)),
            &|m| m.pressure_mass = identity(3, 3),
            &|m| m.interpolation = identity(3, 2),
            &|m| m.interpolation = identity(4, 3),
            &|m| m.vertex_stiffness = identity(2, 3),
            &|m| {
                m.interpolation = identity(4, 5);
                m.vertex_stiffness = identity(5, 5);
            },
        ];
        for (number, misfit) in misfits.iter().enumerate() {
            let refused = fluid(misfit);
            assert!(
                matches!(refused, Err(RigidError::Length { .. })),
                "{number}"
            );
        }
    }

    /// The same fluid from matrices that are stored by columns.
    #[test]
    fn columns_are_turned_into_rows() {
        let (points, roles) = ([Vector3::zeros(); 4], [NodeRole::Free; 4]);
        let by_rows = RigidFluid::new(matrices(&points, &roles), &[]).expect("they fit");
        let mut by_columns = matrices(&points, &roles);
        by_columns.interpolation = by_columns.interpolation.to_csc();
        by_columns.stiffness = by_columns.stiffness.to_csc();
        let by_columns = RigidFluid::new(by_columns, &[]).expect("they fit");
        assert_eq!(by_rows.interpolation, by_columns.interpolation);
        assert_eq!(by_rows.stiffness, by_columns.stiffness);
    }
}
