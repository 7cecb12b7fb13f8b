//! The equations of the fluid that all formulations share: blocks of the free nodes, and bodies.

use linalg::{Csr, Csr3, OMITTED};
use nalgebra::{Matrix3, Vector3};

use crate::body_forces::Surfaces;
use crate::error::{check_finite, check_length};
use crate::mesh_part::Ownership;
use crate::node_blocks::{self, NodeBlocks, block};
use crate::prescribed_motion::PrescribedMotion;
use crate::stresslets::SurfaceRows;
use crate::{
    FluidMatrices, FluidNodes, Inertia, NodeRole, RigidError, SurfaceBody, SymmetryPlanes,
};

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
    /// What the preconditioner needs to know of a mass matrix in the stiffness.
    pub inertia: Option<InertiaBlocks>,
}

/// The mass matrix in the stiffness, as far as the Schur complement of the pressure needs it.
#[derive(Clone, Debug)]
pub(crate) struct InertiaBlocks {
    /// Coefficient of the mass matrix, and factor of the divergence.
    pub factors: (f64, f64),
    /// Diagonal of the mass matrix, one entry per free node.
    pub mass_diagonal: Vec<f64>,
    pub pressure_laplacian: Csr,
    /// Convection of the pressures and their diffusion along it.
    pub pressure_convection: Option<[Csr; 2]>,
}

impl FluidBlocks {
    /// The blocks of free nodes and vertices; each matrix is freed as soon as its block is
    /// complete.
    fn new(
        matrices: FluidMatrices,
        interpolation_border: Csr,
        free: &Numbering,
        free_vertices: &Numbering,
    ) -> Result<Self, RigidError> {
        let FluidMatrices {
            stiffness,
            divergence,
            pressure_mass,
            interpolation,
            vertex_stiffness,
        } = matrices;
        let all_pressures: Vec<u32> = (0..divergence.rows() as u32).collect();
        let (nodes, vertices) = (free.list.len(), free_vertices.list.len());
        let (of_nodes, of_vertices) = (&free.numbers, &free_vertices.numbers);
        let (stiffness, (divergence, (interpolation, vertex_stiffness))) = rayon::join(
            || block(stiffness, &free.list, of_nodes, nodes),
            || {
                (
                    block(divergence, &all_pressures, of_nodes, nodes),
                    (
                        block(interpolation, &free.list, of_vertices, vertices),
                        block(vertex_stiffness, &free_vertices.list, of_vertices, vertices),
                    ),
                )
            },
        );
        Ok(Self {
            stiffness: stiffness?,
            divergence: divergence?,
            pressure_mass,
            interpolation: interpolation?,
            interpolation_border,
            vertex_stiffness: vertex_stiffness?,
            pressure_stiffness: None,
            inertia: None,
        })
    }
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
        Self::split(matrices, None, 1.0, nodes, bodies)
    }

    /// Splits matrices whose stress is completed by forces on the nodes, as of varying viscosity.
    ///
    /// With a viscosity `η` that varies, `∫ η ∇u:∇v` has no term on the surfaces by which it is
    /// `∫ 2 η D(u):D(v)`. The caller adds the difference `∫ η ∇u^T:∇v` as forces on the nodes
    /// ([`Constrained::rhs_of_forces`](crate::Constrained::rhs_of_forces),
    /// [`Constrained::flow_with_forces`](crate::Constrained::flow_with_forces)), also on those of
    /// bodies. There is no volume term, and moments of surface velocities are not used: stresslets
    /// are then the first moments of the traction alone. `inertia` is that of
    /// [`RigidFluid::with_inertia`].
    ///
    /// # Errors
    /// Those of [`RigidFluid::new`] and [`RigidFluid::with_inertia`].
    pub fn with_stress_on_nodes(
        matrices: FluidMatrices,
        inertia: Option<Inertia>,
        nodes: FluidNodes,
        bodies: &[SurfaceBody],
    ) -> Result<Self, RigidError> {
        let moments = vec![Matrix3::zeros(); nodes.surface_moments.len()];
        let nodes = FluidNodes {
            surface_moments: &moments,
            ..nodes
        };
        match inertia {
            None => Self::split(matrices, None, 0.0, nodes, bodies),
            Some(inertia) => Self::split_inertial(matrices, inertia, 0.0, nodes, bodies),
        }
    }

    /// Splits the matrices of a fluid with inertia; `matrices` are those without.
    ///
    /// The stiffness becomes `K + κ M + N`, and that of the vertices `K_c + κ M_c`. The volume term
    /// of the bodies is viscous and does not change. With convection the border rows contain the
    /// transpose of the matrix and the system is not symmetric. The preconditioner has the Schur
    /// complement of inertia with the motions of the bodies
    /// ([`BlockTriangular::with_inertia`](linalg::BlockTriangular::with_inertia)).
    ///
    /// # Errors
    /// Those of [`RigidFluid::new`]; matrices of inertia whose sizes do not fit.
    pub fn with_inertia(
        matrices: FluidMatrices,
        inertia: Inertia,
        nodes: FluidNodes,
        bodies: &[SurfaceBody],
    ) -> Result<Self, RigidError> {
        Self::split_inertial(matrices, inertia, 1.0, nodes, bodies)
    }

    /// `viscosity` is that of the volume term of the bodies.
    fn split_inertial(
        mut matrices: FluidMatrices,
        inertia: Inertia,
        viscosity: f64,
        nodes: FluidNodes,
        bodies: &[SurfaceBody],
    ) -> Result<Self, RigidError> {
        matrices = matrices.by_rows();
        inertia.check(nodes.points.len(), matrices.divergence.rows())?;
        matrices.check(nodes.points.len())?;
        let Inertia {
            coefficient,
            mass,
            vertex_mass,
            convection,
            pressure_laplacian,
        } = inertia;
        check_length(
            "pressures, one per vertex",
            matrices.pressure_mass.rows(),
            matrices.vertex_stiffness.rows(),
        )?;
        let mass = mass.into_csr();
        matrices.stiffness = sum(matrices.stiffness, coefficient, &mass);
        matrices.vertex_stiffness = sum(matrices.vertex_stiffness, coefficient, &vertex_mass);
        drop(vertex_mass);
        // matrices are freed as soon as they are not needed: the assembly is the peak of memory
        let mass_diagonal: Vec<f64> = (0..mass.rows())
            .map(|i| mass.get(i, i).copied().unwrap_or(0.0))
            .collect();
        drop(mass);
        let scale = pressure_scale(coefficient, &matrices);
        for b in matrices.divergence.data_mut() {
            *b = b.map(|b| scale * b);
        }
        let (convection, pressure_convection) = match convection {
            Some((of_velocity, of_pressure)) => (Some(of_velocity.into_csr()), Some(of_pressure)),
            None => (None, None),
        };
        let mut fluid = Self::split(matrices, convection, viscosity, nodes, bodies)?;
        fluid.surfaces.pressure_scale = scale;
        if coefficient > 0.0 || pressure_convection.is_some() {
            let free = fluid.surfaces.free_nodes.iter();
            fluid.blocks.inertia = Some(InertiaBlocks {
                factors: (coefficient, scale),
                mass_diagonal: free.map(|&node| mass_diagonal[node as usize]).collect(),
                pressure_laplacian,
                pressure_convection,
            });
        }
        Ok(fluid)
    }

    /// `viscosity` is that of the volume term of the bodies.
    fn split(
        matrices: FluidMatrices,
        convection: Option<Csr>,
        viscosity: f64,
        nodes: FluidNodes,
        bodies: &[SurfaceBody],
    ) -> Result<Self, RigidError> {
        let mut matrices = matrices.by_rows();
        matrices.check(nodes.points.len())?;
        nodes.check(bodies.len())?;
        let (points, roles) = (nodes.points, nodes.roles);
        let vertices = matrices.vertex_stiffness.rows();
        let is_free = |node: usize| roles[node] == NodeRole::Free;
        let free = Numbering::new(
            points.len(),
            node_blocks::free_nodes(&matrices.interpolation, is_free),
        );
        let free_vertices = (0..vertices as u32).filter(|&vertex| is_free(vertex as usize));
        let free_vertices = Numbering::new(vertices, free_vertices.collect());
        let symmetry_planes = nodes.symmetry();
        let part = nodes.part.clone();
        check_bodies(bodies, symmetry_planes)?;
        let arms: Vec<Vector3<f64>> = (0..points.len())
            .map(|node| match roles[node] {
                NodeRole::Body(body) => points[node] - bodies[body as usize].centre,
                _ => Vector3::zeros(),
            })
            .collect();
        let blocks = NodeBlocks {
            roles,
            arms: &arms,
            bodies: bodies.len(),
            part: &part,
        };
        let border_left = convection.map(|convection| {
            // in place, so that no matrix is copied
            let stiffness = std::mem::replace(&mut matrices.stiffness, Csr::zero((0, 0)));
            matrices.stiffness = sum(stiffness, 1.0, &convection);
            drop(convection);
            let is_body = |node: usize| matches!(roles[node], NodeRole::Body(_));
            let rows = rows_where(&matrices.stiffness, is_body);
            blocks.border(&rows.transpose_view().to_csr(), &free.list)
        });
        let prescribed = PrescribedMotion::new(&matrices, &nodes, &free.list, &arms, bodies.len())?;
        let rows = SurfaceRows::new(&matrices, &nodes, bodies.len())?;
        let mut corner = blocks.corner(&matrices.stiffness);
        part.sum(corner.as_mut_slice());
        for (number, body) in bodies.iter().enumerate() {
            for axis in 3..6 {
                corner[(6 * number + axis, 6 * number + axis)] += 2.0 * viscosity * body.volume;
            }
        }
        let (border, (interpolation_border, rigid_divergence)) = rayon::join(
            || blocks.border(&matrices.stiffness, &free.list),
            || {
                rayon::join(
                    || blocks.border(&matrices.interpolation, &free.list),
                    || blocks.rigid_divergence(&matrices.divergence),
                )
            },
        );
        Ok(Self {
            blocks: FluidBlocks::new(matrices, interpolation_border, &free, &free_vertices)?,
            surfaces: Surfaces {
                border,
                border_left,
                pressure_scale: 1.0,
                corner,
                rigid_divergence,
                constrained: free.constrained(&nodes.on_symmetry_planes),
                free_nodes: free.list,
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

/// Factor of the divergence by which the pressures of the system are smaller than those of the
/// flow.
///
/// Where the mass matrix dominates, the Schur complement is the Laplacian over `κ`. With `κ^(1/2)`
/// it is as large as the pressure mass matrix again at the size of a body, and a residual norm sees
/// errors of the divergence. The second bound keeps the ratio that `linalg::SaddleSystem`
/// requires, on meshes with large elements.
fn pressure_scale(coefficient: f64, matrices: &FluidMatrices) -> f64 {
    const MIN_RATIO: f64 = 1e-3;
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let divergence = largest(matrices.divergence.data().as_flattened());
    let required = MIN_RATIO * largest(matrices.stiffness.data()) / divergence;
    let scale = coefficient.sqrt().max(1.0);
    if coefficient > 0.0 && required.is_finite() {
        scale.max(required)
    } else {
        scale
    }
}

/// `A + factor B`, in place if both have the same pattern, as matrices of one space have.
fn sum(mut a: Csr, factor: f64, b: &Csr) -> Csr {
    if a.indptr() == b.indptr() && a.indices() == b.indices() {
        for (a, b) in a.data_mut().iter_mut().zip(b.data()) {
            *a += factor * b;
        }
        return a;
    }
    &a + &b.map(|b| factor * b)
}

/// The rows for which `keep` is true; the others become empty.
fn rows_where(matrix: &Csr, keep: impl Fn(usize) -> bool) -> Csr {
    let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for (row, entries) in matrix.outer_iterator().enumerate() {
        if keep(row) {
            columns.extend_from_slice(entries.indices());
            values.extend_from_slice(entries.data());
        }
        starts.push(columns.len());
    }
    Csr::new(matrix.shape(), starts, columns, values)
}

/// Refuses bodies without a volume, and bodies whose centre is not on every symmetry plane.
fn check_bodies(bodies: &[SurfaceBody], symmetry_planes: SymmetryPlanes) -> Result<(), RigidError> {
    for (number, body) in bodies.iter().enumerate() {
        check_finite("the centre of a surface", &body.centre)?;
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

/// Some of the nodes or vertices of a mesh, in the order of their dofs.
struct Numbering {
    list: Vec<u32>,
    /// Position of each node in the list; [`OMITTED`] for those that are not in it.
    numbers: Vec<u32>,
}

impl Numbering {
    fn new(len: usize, list: Vec<u32>) -> Self {
        let mut numbers = vec![OMITTED; len];
        for (number, &item) in list.iter().enumerate() {
            numbers[item as usize] = number as u32;
        }
        Self { list, numbers }
    }

    /// The nodes of the list that are on symmetry planes, by their numbers, ascending.
    fn constrained(&self, on_symmetry_planes: &[(u32, [bool; 3])]) -> Vec<(u32, [bool; 3])> {
        let numbered = on_symmetry_planes.iter().filter_map(|&(node, planes)| {
            let number = *self.numbers.get(node as usize)?;
            (number != OMITTED).then_some((number, planes))
        });
        let mut constrained: Vec<_> = numbered.collect();
        constrained.sort_unstable_by_key(|&(number, _)| number);
        constrained
    }
}

#[cfg(test)]
mod tests;
