//! The input of the crate: assembled finite-element matrices and the roles of the nodes.

use linalg::{Csr, Csr3};
use nalgebra::{Matrix3, Vector3};

use crate::error::{check_finite, check_length};
use crate::mesh_part::Ownership;
use crate::{MeshPart, RigidError, SymmetryPlanes};

/// Role of a node: the equation or condition that determines its velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeRole {
    /// The momentum equation: the velocity is unknown.
    Free,
    /// A no-slip wall, at rest unless [`FluidNodes::with_wall_velocity`] prescribes its velocity.
    Fixed,
    /// The surface of the rigid body with this index: `u = U + ω × (x - c)`.
    Body(u32),
}

/// Reference point and volume of a rigid body whose surface is meshed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceBody {
    /// The point `c` that velocities and torques refer to.
    pub centre: Vector3<f64>,
    /// Volume `|B_h|` enclosed by the discrete surface and the symmetry planes.
    pub volume: f64,
}

/// Finite-element matrices over all nodes, Dirichlet nodes included, for viscosity 1.
///
/// They are passed by value: [`RigidFluid::new`](crate::RigidFluid::new) frees each matrix as soon
/// as its block is extracted. The first nodes are the vertices, in the same order.
#[derive(Clone, Debug)]
pub struct FluidMatrices {
    /// Scalar stiffness `K_ij = ∫ ∇N_i · ∇N_j`, nodes x nodes.
    pub stiffness: Csr,
    /// Divergence `b_qj = -∫ ψ_q ∇N_j`, pressure dofs x nodes.
    pub divergence: Csr3,
    /// Pressure mass matrix `∫ ψ_q ψ_r`.
    pub pressure_mass: Csr,
    /// Interpolation `I` from values at the vertices to values at all nodes, nodes x vertices.
    pub interpolation: Csr,
    /// Stiffness of the linear functions, `I^T K I`, vertices x vertices: the coarse operator.
    pub vertex_stiffness: Csr,
}

/// Terms of inertia in the momentum equation, of a step in time or of a steady flow.
///
/// The momentum equation of the step is `(K + κ M + N) u + B^T p = f` for each component of the
/// velocity, with the stiffness `K` of [`FluidMatrices`], at viscosity 1. Known velocities of
/// earlier times are forces on the nodes
/// ([`Constrained::rhs_of_forces`](crate::Constrained::rhs_of_forces)), masses of bodies are
/// [`Constraints::body_damping`](crate::Constraints::body_damping).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Inertia {
    /// `κ`: the density times the coefficient of the new velocity in its derivative; not negative.
    pub coefficient: f64,
    /// Scalar mass matrix `M_ij = ∫ N_i N_j`, nodes x nodes.
    pub mass: Csr,
    /// Mass matrix of the vertices, `I^T M I` with the interpolation of [`FluidMatrices`].
    pub vertex_mass: Csr,
    /// Convection `N_ij = ρ ∫ N_i (c · ∇N_j)`, nodes x nodes, and for the preconditioner that of
    /// the pressures, `ρ ∫ ψ_q (c · ∇ψ_r)`, with their diffusion along `c`
    /// ([`linalg::SchurInertia::convection`]); none in a linear flow.
    pub convection: Option<(Csr, [Csr; 2])>,
    /// Laplacian of the pressure, `∫ ∇ψ_q · ∇ψ_r`, with natural boundary conditions.
    pub pressure_laplacian: Csr,
}

impl Inertia {
    /// Inertia without convection.
    pub fn new(coefficient: f64, mass: Csr, vertex_mass: Csr, pressure_laplacian: Csr) -> Self {
        Self {
            coefficient,
            mass,
            vertex_mass,
            convection: None,
            pressure_laplacian,
        }
    }

    /// The same with convection of the velocity, and for the preconditioner that of the pressure
    /// and its diffusion along it.
    #[must_use]
    pub fn with_convection(mut self, of_velocity: Csr, of_pressure: [Csr; 2]) -> Self {
        self.convection = Some((of_velocity, of_pressure));
        self
    }

    /// Refuses matrices whose shapes do not fit, and a coefficient that is negative or not finite.
    pub(crate) fn check(&self, nodes: usize, pressures: usize) -> Result<(), RigidError> {
        if !(self.coefficient >= 0.0 && self.coefficient.is_finite()) {
            return Err(RigidError::NotFinite {
                what: "a coefficient of inertia that is zero or positive",
            });
        }
        let convection =
            self.convection
                .iter()
                .flat_map(|(of_velocity, [of_pressure, diffusion])| {
                    [
                        ("convection", of_velocity, nodes),
                        ("convection of the pressure", of_pressure, pressures),
                        ("diffusion of the pressure", diffusion, pressures),
                    ]
                });
        let others = [
            ("mass matrix", &self.mass, nodes),
            ("mass matrix of the vertices", &self.vertex_mass, pressures),
            ("pressure Laplacian", &self.pressure_laplacian, pressures),
        ];
        for (what, matrix, size) in others.into_iter().chain(convection) {
            check_length(what, matrix.rows(), size)?;
            check_length(what, matrix.cols(), size)?;
        }
        Ok(())
    }
}

/// Positions and roles of the nodes, symmetry planes and wall velocities.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FluidNodes<'a> {
    /// Position of each node.
    pub points: &'a [Vector3<f64>],
    /// Role of each node.
    pub roles: &'a [NodeRole],
    /// Nodes on symmetry planes, ascending, with the axes that their planes are normal to.
    pub on_symmetry_planes: Vec<(u32, [bool; 3])>,
    /// Prescribed velocity, one per node, of which those at [`NodeRole::Fixed`] nodes are used.
    pub wall_velocity: Option<&'a [Vector3<f64>]>,
    /// Velocity of the surfaces relative to the rigid motion of their bodies, one per node of the
    /// mesh, of which those at [`NodeRole::Body`] nodes are used.
    pub surface_velocity: Option<&'a [Vector3<f64>]>,
    /// `∮ s n^T dS` of each body for the surface velocity `s`; empty without one.
    pub surface_moments: &'a [Matrix3<f64>],
    /// The part of this process if the mesh is divided between processes.
    pub part: Option<MeshPart>,
}

impl<'a> FluidNodes<'a> {
    /// Nodes of a mesh without symmetry planes, all walls at rest.
    pub fn new(points: &'a [Vector3<f64>], roles: &'a [NodeRole]) -> Self {
        Self {
            points,
            roles,
            on_symmetry_planes: Vec::new(),
            wall_velocity: None,
            surface_velocity: None,
            surface_moments: &[],
            part: None,
        }
    }

    /// The same nodes as the part of a mesh that is divided between processes.
    #[must_use]
    pub fn with_part(mut self, part: MeshPart) -> Self {
        self.part = Some(part);
        self
    }

    /// The same nodes of a mesh that ends at symmetry planes; see [`SymmetryPlanes`].
    ///
    /// `nodes` lists the nodes on the planes, ascending, each with the axes that its planes are
    /// normal to. An empty list means that the mesh covers the whole fluid.
    #[must_use]
    pub fn with_symmetry_planes(mut self, nodes: Vec<(u32, [bool; 3])>) -> Self {
        self.on_symmetry_planes = nodes;
        self
    }

    /// The same nodes with walls that move: one velocity per node of the mesh.
    ///
    /// Only the values at [`NodeRole::Fixed`] nodes are used. They enter the right-hand side and
    /// the forces on bodies; the matrix does not change.
    #[must_use]
    pub fn with_wall_velocity(mut self, velocity: &'a [Vector3<f64>]) -> Self {
        self.wall_velocity = Some(velocity);
        self
    }

    /// The same nodes with surfaces that move relative to their bodies, as by slip.
    ///
    /// `velocity` is the velocity `s` relative to the rigid motion, one per node of the mesh, of
    /// which those at [`NodeRole::Body`] nodes are used. `moments` are `∮ s n^T dS` over each body,
    /// with the normal out of the body: they have the torques `∮ n × s dS` by which the stiffness
    /// `∫ ∇u:∇v` differs from `∫ 2 D(u):D(v)` for velocities that are not rigid. The matrix does
    /// not change.
    #[must_use]
    pub fn with_surface_velocity(
        mut self,
        velocity: &'a [Vector3<f64>],
        moments: &'a [Matrix3<f64>],
    ) -> Self {
        self.surface_velocity = Some(velocity);
        self.surface_moments = moments;
        self
    }

    /// The symmetry planes that some node lies on, in any part of the mesh.
    pub(crate) fn symmetry(&self) -> SymmetryPlanes {
        let of_nodes = SymmetryPlanes::from_nodes(&self.on_symmetry_planes);
        let mut parts_at_plane = of_nodes.planes.map(|on| f64::from(u8::from(on)));
        self.part.sum(&mut parts_at_plane);
        SymmetryPlanes {
            planes: parts_at_plane.map(|parts| parts > 0.0),
        }
    }

    /// Refuses arrays of the wrong length, and nodes and bodies that do not exist.
    pub(crate) fn check(&self, bodies: usize) -> Result<(), RigidError> {
        let nodes = self.points.len();
        check_length("roles of the nodes", self.roles.len(), nodes)?;
        if let Some(part) = &self.part {
            check_length("nodes of the part", part.len(), nodes)?;
        }
        if let Some(velocity) = self.wall_velocity {
            check_length("wall velocities of the nodes", velocity.len(), nodes)?;
        }
        if let Some(velocity) = self.surface_velocity {
            check_length("surface velocities of the nodes", velocity.len(), nodes)?;
            let moments = self.surface_moments.len();
            check_length("moments of the surface velocities", moments, bodies)?;
        }
        check_finite("the position of a node", self.points.iter().flatten())?;
        let mut next = 0;
        for &(node, _) in &self.on_symmetry_planes {
            if !(next..nodes).contains(&(node as usize)) {
                return Err(RigidError::Length {
                    what: "nodes, including all on symmetry planes in ascending order",
                    expected: node as usize + 1,
                    found: nodes,
                });
            }
            next = node as usize + 1;
        }
        let is_unknown =
            |role: &&NodeRole| matches!(role, NodeRole::Body(b) if *b as usize >= bodies);
        match self.roles.iter().find(is_unknown) {
            Some(NodeRole::Body(body)) => Err(RigidError::Length {
                what: "rigid bodies",
                expected: *body as usize + 1,
                found: bodies,
            }),
            _ => Ok(()),
        }
    }
}

impl FluidMatrices {
    /// The same matrices, each compressed by rows: sprs matrices may also be compressed by columns.
    pub(crate) fn by_rows(self) -> Self {
        Self {
            stiffness: self.stiffness.into_csr(),
            divergence: self.divergence.into_csr(),
            interpolation: self.interpolation.into_csr(),
            vertex_stiffness: self.vertex_stiffness.into_csr(),
            pressure_mass: self.pressure_mass,
        }
    }

    /// Refuses matrices whose shapes do not fit each other or the number of nodes.
    pub(crate) fn check(&self, nodes: usize) -> Result<(), RigidError> {
        let Self {
            stiffness,
            divergence,
            pressure_mass,
            interpolation,
            vertex_stiffness,
        } = self;
        let vertices = vertex_stiffness.rows();
        if vertices > nodes {
            return Err(RigidError::Length {
                what: "nodes, including all vertices",
                expected: vertices,
                found: nodes,
            });
        }
        for (what, found, expected) in [
            (
                "columns of the vertex stiffness",
                vertex_stiffness.cols(),
                vertices,
            ),
            ("columns of the stiffness", stiffness.cols(), nodes),
            ("rows of the stiffness", stiffness.rows(), nodes),
            ("columns of the divergence", divergence.cols(), nodes),
            (
                "rows of the pressure mass matrix",
                pressure_mass.rows(),
                divergence.rows(),
            ),
            ("rows of the interpolation", interpolation.rows(), nodes),
            (
                "columns of the interpolation",
                interpolation.cols(),
                vertices,
            ),
        ] {
            check_length(what, found, expected)?;
        }
        Ok(())
    }
}
