//! The equations of the fluid that all formulations share: blocks of the free nodes, and bodies.

use linalg::{Csr, Csr3, OMITTED};
use nalgebra::Vector3;

use crate::body_forces::Surfaces;
use crate::error::check_length;
use crate::node_blocks::{NodeBlocks, block};
use crate::node_order;
use crate::placement::is_finite;
use crate::prescribed_motion::PrescribedMotion;
use crate::stresslets::SurfaceRows;
use crate::{FluidMatrices, FluidNodes, NodeRole, RigidError, SurfaceBody, SymmetryPlanes};

/// The equations of the fluid at free nodes, with six border columns `(U, ω)` per rigid body.
///
/// With `u_b = P_b (U, ω)` at the nodes of a body, `P_b = [I, -[x_b - c]_×]`, the border is
/// `K_IB P`, the corner `P^T K_BB P + 2 |B_h| ω·ω` and the divergence of rigid motions `B_B P`. The
/// volume term makes the three scalar stiffness blocks equal to `∫ 2 D(u):D(v)` minus a grad-div
/// term, if surfaces are rigid and walls no-slip (by the divergence theorem in the body). Without
/// it torques are a third too small.
#[derive(Clone, Debug)]
pub struct RigidFluid {
    pub(crate) blocks: FluidBlocks,
    pub(crate) surfaces: Surfaces,
}

/// The blocks that become part of a constrained system.
#[derive(Clone, Debug)]
pub(crate) struct FluidBlocks {
    /// Scalar stiffness of the free nodes, in the order of [`Surfaces::free_nodes`].
    pub stiffness: Csr,
    /// Divergence, pressure dofs x free nodes.
    pub divergence: Csr3,
    /// Pressure mass matrix.
    pub pressure_mass: Csr,
    /// Interpolation from free vertices, ascending, to free nodes.
    pub interpolation: Csr,
    /// Interpolation from rigid motions to free nodes: three rows per node, six columns per body.
    pub interpolation_border: Csr,
    /// Stiffness of the free vertices, ascending.
    pub vertex_stiffness: Csr,
    /// Stiffness of narrow gaps, pressure dofs x pressure dofs.
    pub pressure_stiffness: Option<Csr>,
}

impl RigidFluid {
    /// Splits matrices over all nodes into the blocks of free nodes, bodies and walls.
    ///
    /// Free nodes are renumbered so that neighbours are close together in memory. Cost: three
    /// passes over the matrices. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// Arrays or matrices whose sizes do not fit, a role that names a body that does not exist, a
    /// body without a volume or whose centre is not on the symmetry planes, wall velocities that no
    /// flow can satisfy.
    pub fn new(
        matrices: FluidMatrices,
        nodes: FluidNodes,
        bodies: &[SurfaceBody],
    ) -> Result<Self, RigidError> {
        let matrices = matrices.by_rows();
        matrices.check(nodes.points.len())?;
        nodes.check(bodies.len())?;
        let (points, roles) = (nodes.points, nodes.roles);
        let vertices = matrices.vertex_stiffness.rows();
        let is_free = |node: usize| roles[node] == NodeRole::Free;
        let free_nodes = node_order::free_nodes(&matrices.interpolation, is_free);
        let free_number = numbers(points.len(), &free_nodes);
        let free_vertices: Vec<u32> = (0..vertices as u32)
            .filter(|&vertex| is_free(vertex as usize))
            .collect();
        let vertex_number = numbers(vertices, &free_vertices);
        let symmetry_planes = nodes.symmetry();
        let part = nodes.part.clone();
        check_bodies(bodies, symmetry_planes)?;
        let mut constrained: Vec<(u32, [bool; 3])> = nodes
            .on_symmetry_planes
            .iter()
            .filter_map(|&(node, planes)| {
                let number = *free_number.get(node as usize)?;
                (number != OMITTED).then_some((number, planes))
            })
            .collect();
        constrained.sort_unstable_by_key(|&(number, _)| number);
        let arms: Vec<Vector3<f64>> = (0..points.len())
            .map(|node| match roles[node] {
                NodeRole::Body(body) => points[node] - bodies[body as usize].centre,
                _ => Vector3::zeros(),
            })
            .collect();
        let prescribed =
            PrescribedMotion::new(&matrices, &nodes, &free_nodes, &arms, bodies.len())?;
        let rows = SurfaceRows::new(&matrices, &nodes, bodies.len())?;
        let FluidMatrices {
            stiffness,
            divergence,
            pressure_mass,
            interpolation,
            vertex_stiffness,
        } = matrices;
        let blocks = NodeBlocks {
            roles,
            arms: &arms,
            bodies: bodies.len(),
            part: part.as_ref(),
        };
        let mut corner = blocks.corner(&stiffness);
        if let Some(part) = &part {
            part.sum(corner.as_mut_slice());
        }
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
            blocks: FluidBlocks {
                stiffness: stiffness?,
                divergence: divergence?,
                pressure_mass,
                interpolation: interpolation?,
                interpolation_border,
                vertex_stiffness: vertex_stiffness?,
                pressure_stiffness: None,
            },
            surfaces: Surfaces {
                border,
                corner,
                rigid_divergence,
                free_nodes,
                constrained,
                symmetry_planes,
                prescribed,
                roles: roles.to_vec(),
                part,
                bodies: bodies.to_vec(),
                arms,
                rows,
            },
        })
    }

    /// The same fluid with a preconditioner that accounts for narrow gaps and channels.
    ///
    /// `stiffness` is `∫ k ∇ψ_q · ∇ψ_r` over the pressure functions, `k` being twice the
    /// permeability at each point: `2 h^2 / 12` in a gap of width h. It changes the number of
    /// iterations, not the solution; see
    /// [`with_pressure_laplacian`](linalg::BlockTriangular::with_pressure_laplacian).
    ///
    /// # Errors
    /// A matrix of another size than the pressure mass matrix.
    pub fn with_pressure_stiffness(mut self, stiffness: Csr) -> Result<Self, RigidError> {
        let pressures = self.blocks.pressure_mass.rows();
        check_length(
            "rows of the pressure stiffness",
            stiffness.rows(),
            pressures,
        )?;
        check_length(
            "columns of the pressure stiffness",
            stiffness.cols(),
            pressures,
        )?;
        self.blocks.pressure_stiffness = Some(stiffness);
        Ok(self)
    }

    /// Number of rigid bodies with a surface.
    pub fn bodies(&self) -> usize {
        self.surfaces.bodies()
    }

    /// The symmetry planes at which the mesh ends.
    pub fn symmetry_planes(&self) -> SymmetryPlanes {
        self.surfaces.symmetry_planes
    }
}

/// Refuses bodies without a volume, and bodies whose centre is not on every symmetry plane.
fn check_bodies(bodies: &[SurfaceBody], symmetry_planes: SymmetryPlanes) -> Result<(), RigidError> {
    for (number, body) in bodies.iter().enumerate() {
        if !is_finite(&body.centre) {
            return Err(RigidError::NotFinite {
                what: "the centre of a surface",
            });
        }
        if !(body.volume > 0.0 && body.volume.is_finite()) {
            return Err(RigidError::BadVolume {
                body: number,
                volume: body.volume,
            });
        }
        let off = body.centre.iter().zip(symmetry_planes.planes);
        if let Some((distance, _)) = off.into_iter().find(|(x, plane)| *plane && **x != 0.0) {
            return Err(RigidError::OffSymmetryPlane {
                body: number,
                distance: distance.abs(),
            });
        }
    }
    Ok(())
}

/// The position of each of `0..len` in a list; [`OMITTED`] for those that are not in it.
fn numbers(len: usize, list: &[u32]) -> Vec<u32> {
    let mut numbers = vec![OMITTED; len];
    for (number, &item) in list.iter().enumerate() {
        numbers[item as usize] = number as u32;
    }
    numbers
}

#[cfg(test)]
mod tests;
