//! The fluid block that all formulations share: free nodes, and the border that rigid surfaces put around them.

use linalg::{Csr, Csr3};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rayon::prelude::*;

use crate::RigidError;
use crate::articulation::check_length;

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
    /// Volume enclosed by the discrete surface, $|B_h|$.
    pub volume: f64,
}

/// Finite-element matrices over all nodes, Dirichlet nodes included, for viscosity 1.
#[derive(Clone, Copy)]
pub struct FluidMatrices<'a> {
    /// Scalar stiffness $K_{ij} = \int \nabla N_i \cdot \nabla N_j$, nodes x nodes.
    pub stiffness: &'a Csr,
    /// $b_{qj} = -\int \psi_q \nabla N_j$, pressure unknowns x nodes.
    pub divergence: &'a Csr3,
    /// Pressure mass matrix.
    pub pressure_mass: &'a Csr,
    /// Values at all nodes from values at the vertices (the first nodes), nodes x vertices.
    pub interpolation: &'a Csr,
    /// Stiffness of the vertices' own functions, $I^T K I$ with `I` the interpolation; vertices x vertices.
    pub vertex_stiffness: &'a Csr,
    /// Positions of the nodes.
    pub points: &'a [Vector3<f64>],
    /// Role of each node.
    pub roles: &'a [NodeRole],
}

/// The fluid's equations at free nodes and their border: 6 columns `(U, omega)` a rigid body.
///
/// With $u_b = P_b (U, \omega)$ at the nodes of a body, $P_b = [I, -[x_b - c]_\times]$, the border is $K_{IB} P$, the corner
/// $P^T K_{BB} P + 2 |B_h| \omega\cdot\omega$ and the divergence of rigid motions $B_B P$. The volume term makes the
/// three scalar stiffness blocks equal to $2 D:D$ less a grad-div term for rigid surfaces and no-slip walls
/// (by the divergence theorem in the body; without it torques are a third too small).
#[derive(Clone, Debug)]
pub struct RigidFluid {
    /// Scalar stiffness of the free nodes.
    pub stiffness: Csr,
    /// Divergence, pressure unknowns x free nodes.
    pub divergence: Csr3,
    /// Pressure mass matrix.
    pub pressure_mass: Csr,
    /// Values at free nodes from values at free vertices.
    pub interpolation: Csr,
    /// Stiffness of the free vertices.
    pub vertex_stiffness: Csr,
    /// $K_{IB} P$: three rows a free node, six columns a body.
    pub border: Csr,
    /// $P^T K_{BB} P$ with the volume term.
    pub corner: DMatrix<f64>,
    /// $B_B P$: pressure unknowns x six columns a body.
    pub rigid_divergence: Csr,
    /// The rigid part of values interpolated from vertices: three rows a free node, six columns a body.
    pub interpolation_border: Csr,
    /// Node number of each free node.
    pub free_nodes: Vec<u32>,
    roles: Vec<NodeRole>,
    arms: Vec<Vector3<f64>>,
}

impl RigidFluid {
    /// Sorts nodes into free, fixed and body nodes and gathers the border of the bodies.
    ///
    /// Cost: one pass over the matrices. The same for any number of threads.
    ///
    /// # Errors
    /// Arrays or matrices whose sizes do not fit, or a role that names a body that does not exist.
    pub fn new(matrices: &FluidMatrices, bodies: &[SurfaceBody]) -> Result<Self, RigidError> {
        let FluidMatrices {
            stiffness,
            divergence,
            pressure_mass,
            interpolation,
            vertex_stiffness,
            points,
            roles,
        } = *matrices;
        let nodes = points.len();
        let vertices = vertex_stiffness.rows();
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
        let free_nodes: Vec<u32> = (0..nodes as u32)
            .filter(|&node| roles[node as usize] == NodeRole::Free)
            .collect();
        let free_vertices = free_nodes.partition_point(|&node| (node as usize) < vertices);
        let mut free_number = vec![NOT_FREE; nodes];
        for (number, &node) in free_nodes.iter().enumerate() {
            free_number[node as usize] = number as u32;
        }
        let arms: Vec<Vector3<f64>> = (0..nodes)
            .map(|node| match roles[node] {
                NodeRole::Body(body) => points[node] - bodies[body as usize].centre,
                _ => Vector3::zeros(),
            })
            .collect();
        let sorted = Sorted {
            roles,
            arms: &arms,
            free_number: &free_number,
            bodies: count,
        };
        let mut corner = sorted.corner(stiffness);
        for (number, body) in bodies.iter().enumerate() {
            for axis in 3..6 {
                corner[(6 * number + axis, 6 * number + axis)] += 2.0 * body.volume;
            }
        }
        Ok(Self {
            stiffness: sorted.free_block(stiffness, &free_nodes, free_nodes.len()),
            divergence: sorted.free_columns(divergence, free_nodes.len()),
            pressure_mass: pressure_mass.clone(),
            interpolation: sorted.free_block(interpolation, &free_nodes, free_vertices),
            vertex_stiffness: sorted.free_block(
                vertex_stiffness,
                &free_nodes[..free_vertices],
                free_vertices,
            ),
            border: sorted.border(stiffness, &free_nodes),
            corner,
            rigid_divergence: sorted.rigid_divergence(divergence),
            interpolation_border: sorted.border(interpolation, &free_nodes),
            free_nodes,
            roles: roles.to_vec(),
            arms,
        })
    }

    /// Number of rigid bodies with a surface.
    pub fn bodies(&self) -> usize {
        self.corner.nrows() / 6
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
    /// The residual of the momentum equation tested with rigid motions:
    /// $F = (K_{IB} P)^T u_I + M U + (B_B P)^T p$; fourth order on curved quadratic surfaces, because it is the energy of the flow.
    pub fn forces(&self, free: &[f64], bodies: &DVector<f64>, pressure: &[f64]) -> DVector<f64> {
        let mut forces = &self.corner * bodies;
        add_transposed(&self.border, free, &mut forces);
        add_transposed(&self.rigid_divergence, pressure, &mut forces);
        forces
    }
}

/// Marks a node that is no unknown.
const NOT_FREE: u32 = u32::MAX;

/// `y += A^T x` for a matrix with few columns; serial, so the order of the sum is fixed.
fn add_transposed(matrix: &Csr, x: &[f64], y: &mut DVector<f64>) {
    for (row, &value) in matrix.outer_iterator().zip(x) {
        for (column, &entry) in row.iter() {
            y[column as usize] += entry * value;
        }
    }
}

/// The nodes sorted by role, and the blocks of matrices that belong to each role.
struct Sorted<'a> {
    roles: &'a [NodeRole],
    arms: &'a [Vector3<f64>],
    free_number: &'a [u32],
    bodies: usize,
}

/// Weighted sum of rigid motions of one body: $\sum_b w_b u_b = s U + \omega \times g$.
struct RigidSum {
    body: usize,
    weight: f64,
    moment: Vector3<f64>,
}

impl Sorted<'_> {
    /// The rows and columns of free nodes; columns at and past `columns` do not occur.
    fn free_block(&self, matrix: &Csr, rows: &[u32], columns: usize) -> Csr {
        from_rows(
            columns,
            rows.len(),
            |row, indices: &mut Vec<u32>, values: &mut Vec<f64>| {
                if let Some(view) = matrix.outer_view(rows[row] as usize) {
                    for (column, &value) in view.iter() {
                        let number = self.free_number[column as usize];
                        if number != NOT_FREE {
                            indices.push(number);
                            values.push(value);
                        }
                    }
                }
            },
        )
    }

    fn free_columns(&self, matrix: &Csr3, columns: usize) -> Csr3 {
        from_rows(
            columns,
            matrix.rows(),
            |row, indices: &mut Vec<u32>, values: &mut Vec<[f64; 3]>| {
                if let Some(view) = matrix.outer_view(row) {
                    for (column, &value) in view.iter() {
                        let number = self.free_number[column as usize];
                        if number != NOT_FREE {
                            indices.push(number);
                            values.push(value);
                        }
                    }
                }
            },
        )
    }

    /// `A_{IB} P`: three rows for each of `rows`, six columns a body.
    fn border(&self, matrix: &Csr, rows: &[u32]) -> Csr {
        from_rows(
            6 * self.bodies,
            3 * rows.len(),
            |row, indices: &mut Vec<u32>, values: &mut Vec<f64>| {
                let Some(view) = matrix.outer_view(rows[row / 3] as usize) else {
                    return;
                };
                let mut sums: Vec<RigidSum> = Vec::new();
                for (column, &value) in view.iter() {
                    let NodeRole::Body(body) = self.roles[column as usize] else {
                        continue;
                    };
                    let body = body as usize;
                    let place =
                        sums.binary_search_by_key(&body, |s| s.body)
                            .unwrap_or_else(|place| {
                                sums.insert(
                                    place,
                                    RigidSum {
                                        body,
                                        weight: 0.0,
                                        moment: Vector3::zeros(),
                                    },
                                );
                                place
                            });
                    sums[place].weight += value;
                    sums[place].moment += value * self.arms[column as usize];
                }
                let axis = row % 3;
                for sum in sums {
                    // (omega x g)_axis = omega_{a+1} g_{a+2} - omega_{a+2} g_{a+1}
                    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                    let mut entries = [
                        (axis, sum.weight),
                        (3 + next, sum.moment[last]),
                        (3 + last, -sum.moment[next]),
                    ];
                    entries.sort_by_key(|e| e.0);
                    for (column, value) in entries {
                        indices.push((6 * sum.body + column) as u32);
                        values.push(value);
                    }
                }
            },
        )
    }

    /// `B_B P`: row `q` holds `(sum b, sum r x b)` for each body.
    fn rigid_divergence(&self, divergence: &Csr3) -> Csr {
        from_rows(
            6 * self.bodies,
            divergence.rows(),
            |row, indices: &mut Vec<u32>, values: &mut Vec<f64>| {
                let Some(view) = divergence.outer_view(row) else {
                    return;
                };
                let mut sums: Vec<(usize, Vector3<f64>, Vector3<f64>)> = Vec::new();
                for (column, &value) in view.iter() {
                    let NodeRole::Body(body) = self.roles[column as usize] else {
                        continue;
                    };
                    let body = body as usize;
                    let place = sums
                        .binary_search_by_key(&body, |s| s.0)
                        .unwrap_or_else(|place| {
                            sums.insert(place, (body, Vector3::zeros(), Vector3::zeros()));
                            place
                        });
                    let b = Vector3::from(value);
                    sums[place].1 += b;
                    sums[place].2 += self.arms[column as usize].cross(&b);
                }
                for (body, force, torque) in sums {
                    indices.extend((0..6).map(|k| (6 * body + k) as u32));
                    values.extend(force.iter().chain(torque.iter()));
                }
            },
        )
    }

    /// `P^T K_{BB} P`, dense.
    fn corner(&self, stiffness: &Csr) -> DMatrix<f64> {
        let mut corner = DMatrix::zeros(6 * self.bodies, 6 * self.bodies);
        for (row, role) in self.roles.iter().enumerate() {
            let (&NodeRole::Body(own), Some(view)) = (role, stiffness.outer_view(row)) else {
                continue;
            };
            let own_arm = self.arms[row].cross_matrix();
            for (column, &value) in view.iter() {
                let NodeRole::Body(other) = self.roles[column as usize] else {
                    continue;
                };
                let other_arm = self.arms[column as usize].cross_matrix();
                let (i, j) = (6 * own as usize, 6 * other as usize);
                let mut add = |r: usize, c: usize, block: Matrix3<f64>| {
                    let mut view = corner.fixed_view_mut::<3, 3>(r, c);
                    view += value * block;
                };
                add(i, j, Matrix3::identity());
                add(i, j + 3, -other_arm);
                add(i + 3, j, own_arm);
                add(i + 3, j + 3, -own_arm * other_arm);
            }
        }
        corner
    }
}

/// Rows of a compressed matrix that are built together by one task.
const ROWS_A_TASK: usize = 4096;

/// A compressed matrix from a closure that appends the columns (ascending) and values of a row.
fn from_rows<T: Copy + Send + Sync>(
    columns: usize,
    rows: usize,
    row: impl Fn(usize, &mut Vec<u32>, &mut Vec<T>) + Sync,
) -> sprs::CsMatI<T, u32, usize> {
    let parts: Vec<(Vec<usize>, Vec<u32>, Vec<T>)> = (0..rows.div_ceil(ROWS_A_TASK))
        .into_par_iter()
        .map(|task| {
            let (mut lengths, mut indices, mut values) = (Vec::new(), Vec::new(), Vec::new());
            for r in task * ROWS_A_TASK..rows.min((task + 1) * ROWS_A_TASK) {
                let before = indices.len();
                row(r, &mut indices, &mut values);
                lengths.push(indices.len() - before);
            }
            (lengths, indices, values)
        })
        .collect();
    let entries = parts.iter().map(|p| p.1.len()).sum();
    let mut pointers = Vec::with_capacity(rows + 1);
    let (mut indices, mut values) = (Vec::with_capacity(entries), Vec::with_capacity(entries));
    pointers.push(0);
    for (lengths, part_indices, part_values) in parts {
        for length in lengths {
            pointers.push(pointers[pointers.len() - 1] + length);
        }
        indices.extend(part_indices);
        values.extend(part_values);
    }
    // Rows come in order with ascending columns by construction, so the structure is valid.
    sprs::CsMatI::new((rows, columns), pointers, indices, values)
}
