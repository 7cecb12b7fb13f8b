//! Stokes flow around rigid bodies on one mesh, as a problem to assemble and solve.

use fem::{CurvedBoundary, FacetGeometry, StokesMatrices, SurfaceVelocity, TaylorHood};
use mesh::{NamedSurface, Submesh, TetMesh};
use nalgebra::Vector3;
use rigid::{
    Constrained, Drive, FluidMatrices, FluidNodes, Formulation, MeshPart, NodeRole, RigidFluid,
    SurfaceBody, SymmetryPlanes,
};

use crate::StokesError;
use crate::inertial_terms::InertialTerms;
use crate::permeability::{permeability_of_channels, torsion};
use crate::surface_flow::{BoundaryParts, NodalSurfaceFlow, SurfaceFlow};

/// Stokes flow around rigid bodies on one mesh, viscosity 1.
///
/// The problem contains everything that does not depend on the motion of the bodies: which parts
/// of the boundary are bodies and walls, and the centres of the bodies. A [`Drive`] moves the
/// bodies: their joints, the rates of the joints and external loads. Names of boundary parts are
/// resolved once, in [`Problem::new`].
///
/// ```
/// use mesh::TetMesh;
/// use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
/// use nalgebra::Vector3;
///
/// let sphere = Sphere { centre: Vector3::zeros(), radius: 1.0 };
/// let ball = Container::Ball(Sphere { centre: Vector3::zeros(), radius: 10.0 });
/// let body = MeshedBody { name: "sphere", surface: &sphere, size: 0.8 };
/// let tets = generate(&[body], &ball, &GenerateParams::default())?.mesh;
/// let mesh = TetMesh::curved(tets, &[("sphere", &sphere), (Container::TAG, ball.surface())])?;
/// let problem = stokes::Problem::new(&mesh, &[("sphere", sphere.centre)], &[Container::TAG])?;
/// let resistance = problem.resistance(1e-8)?.resistance;
/// // Haberman & Sayre (1958): 1.286196 times the drag in unbounded fluid, 6π μ a
/// let ratio = resistance[(0, 0)] / (6.0 * std::f64::consts::PI);
/// assert!((ratio / 1.286196 - 1.0).abs() < 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Problem<'a> {
    pub(crate) mesh: &'a TetMesh,
    pub(crate) space: Option<&'a TaylorHood>,
    /// Boundary part and centre of each body.
    pub(crate) bodies: Vec<(u16, Vector3<f64>)>,
    walls: Vec<u16>,
    curved: Vec<CurvedBoundary<'a>>,
    permeability: Option<Vec<f64>>,
    pub(crate) surface_flow: Option<&'a dyn SurfaceFlow>,
}

impl<'a> Problem<'a> {
    /// Creates the problem on `mesh` with the given bodies and walls.
    ///
    /// A body is a part of the boundary and its centre, to which velocities and torques refer. A
    /// wall is a part of the boundary at which the velocity is zero. On parts that are neither, the
    /// natural boundary condition `∂u/∂n = p n` holds.
    ///
    /// # Errors
    /// A name that the mesh does not have: [`mesh::MeshError::UnknownTag`]. A part that is given
    /// twice, such as a body that is a wall too: [`StokesError::PartTwice`].
    pub fn new(
        mesh: &'a TetMesh,
        bodies: &[(&str, Vector3<f64>)],
        walls: &[&str],
    ) -> Result<Self, StokesError> {
        let names = || bodies.iter().map(|(name, _)| name).chain(walls);
        let twice = names()
            .enumerate()
            .find(|(k, name)| names().take(*k).any(|n| n == *name));
        if let Some((_, name)) = twice {
            let name = (*name).to_owned();
            return Err(StokesError::PartTwice { name });
        }
        let body = |&(name, centre): &(&str, _)| Ok((mesh.tag(name)?, centre));
        let wall = |name: &&str| mesh.tag(name);
        Ok(Self {
            mesh,
            space: None,
            bodies: bodies
                .iter()
                .map(body)
                .collect::<Result<_, StokesError>>()?,
            walls: walls.iter().map(wall).collect::<Result<_, _>>()?,
            curved: Vec::new(),
            permeability: None,
            surface_flow: None,
        })
    }

    /// Uses an existing space instead of creating one for each assembly.
    ///
    /// The space may come from another mesh with the same cells and other points.
    #[must_use]
    pub fn with_space(mut self, space: &'a TaylorHood) -> Self {
        self.space = Some(space);
        self
    }

    /// Declares which smooth surfaces the facets of these boundary parts approximate.
    ///
    /// Error estimates then include the geometry error, of straight and of curved facets.
    ///
    /// # Errors
    /// A name that the mesh does not have.
    pub fn with_surfaces(mut self, parts: &[NamedSurface<'a>]) -> Result<Self, StokesError> {
        for &(name, surface) in parts {
            let tag = self.mesh.tag(name)?;
            let is_wall = self.walls.contains(&tag);
            self.curved.push(CurvedBoundary {
                tag,
                surface,
                is_wall,
            });
        }
        Ok(self)
    }

    /// Improves the preconditioner in narrow gaps.
    ///
    /// `permeability` is twice the permeability of each cell: `2 h^2 / 12` in a gap of width `h`.
    /// It changes the number of iterations, not the solution.
    #[must_use]
    pub fn with_permeability(mut self, permeability: Vec<f64>) -> Self {
        self.permeability = Some(permeability);
        self
    }

    /// Adds slip and deformation of the bodies and a background flow.
    ///
    /// Solutions are then the disturbance flow.
    #[must_use]
    pub fn with_surface_flow(mut self, flow: &'a dyn SurfaceFlow) -> Self {
        self.surface_flow = Some(flow);
        self
    }

    /// Whether no fluid leaves: the boundary consists of walls, bodies and symmetry planes.
    pub fn is_closed(&self) -> bool {
        self.mesh.facets().iter().all(|facet| {
            let tag = facet.tag;
            self.walls.contains(&tag)
                || self.bodies.iter().any(|(body, _)| *body == tag)
                || self.mesh.is_symmetry_plane(tag)
        })
    }

    /// Twice the permeability of each cell, where narrow gaps or channels make it matter.
    ///
    /// `torsion` is the solution of `-Δ psi = 1` at the vertices, with `psi = 0` at walls and
    /// bodies. Pass `None` if the boundary is not closed: its open part fixes the pressure, which a
    /// Laplacian with natural boundary conditions does not.
    pub fn permeability(&self, torsion: Option<&[f64]>) -> Option<Vec<f64>> {
        let of_channels = torsion.and_then(|torsion| permeability_of_channels(self.mesh, torsion));
        match (&self.permeability, of_channels) {
            (Some(gaps), Some(channels)) if gaps.len() == channels.len() => {
                Some(gaps.iter().zip(channels).map(|(g, c)| g.min(c)).collect())
            }
            (Some(gaps), _) => Some(gaps.clone()),
            (None, channels) => channels,
        }
    }

    /// The permeability of the fluid that these matrices of viscosity 1 describe.
    pub(crate) fn permeability_of(
        &self,
        roles: &[NodeRole],
        matrices: &StokesMatrices,
    ) -> Result<Option<Vec<f64>>, StokesError> {
        let torsion = match self.is_closed() {
            true => torsion(self.mesh.n_vertices(), roles, matrices)?,
            false => None,
        };
        Ok(self.permeability(torsion.as_deref()))
    }

    /// The mesh.
    pub fn mesh(&self) -> &'a TetMesh {
        self.mesh
    }

    /// The space of the problem, or a new one.
    pub(crate) fn space_or_new<'s>(
        &self,
        new: &'s mut Option<TaylorHood>,
    ) -> Result<&'s TaylorHood, StokesError>
    where
        'a: 's,
    {
        match self.space {
            Some(space) => Ok(space),
            None => Ok(new.insert(TaylorHood::new(self.mesh)?)),
        }
    }

    /// Role of each node of the mesh: free, on a wall, or on a body.
    pub fn roles(&self) -> Vec<NodeRole> {
        let mut roles = vec![NodeRole::Free; self.mesh.n_points()];
        let bodies = (0..).zip(&self.bodies);
        let parts = (self.walls.iter().map(|&tag| (tag, NodeRole::Fixed)))
            .chain(bodies.map(|(number, &(tag, _))| (tag, NodeRole::Body(number))));
        for (tag, role) in parts {
            for node in self.mesh.nodes_on(tag) {
                roles[node as usize] = role;
            }
        }
        roles
    }

    /// Symmetry planes at which the mesh ends.
    pub(crate) fn symmetry(&self) -> SymmetryPlanes {
        let planes = self.mesh.symmetry_planes();
        SymmetryPlanes { planes }
    }

    /// Number of parts into which symmetry planes cut the fluid; the mesh covers one of them.
    pub(crate) fn parts(&self) -> f64 {
        self.symmetry().parts()
    }

    /// Centres and volumes of the bodies.
    pub(crate) fn surface_bodies(&self) -> Result<Vec<SurfaceBody>, StokesError> {
        let body = |&(tag, centre): &(u16, _)| {
            let volume = fem::surface_measures(self.mesh, tag)?.volume;
            Ok(SurfaceBody { centre, volume })
        };
        self.bodies.iter().map(body).collect()
    }

    /// Centres of the bodies.
    pub(crate) fn centres(&self) -> Vec<Vector3<f64>> {
        self.bodies.iter().map(|(_, centre)| *centre).collect()
    }

    /// The facets that approximate smooth surfaces.
    pub(crate) fn facet_geometry(&self) -> Result<FacetGeometry<'a>, StokesError> {
        Ok(FacetGeometry::new(self.mesh, &self.curved)?)
    }

    /// The surface flow with the parts that it is on.
    fn boundary_parts(&self) -> Option<BoundaryParts<'_>> {
        self.surface_flow.map(|flow| BoundaryParts {
            flow,
            bodies: &self.bodies,
            walls: &self.walls,
        })
    }

    /// Velocity of the boundary relative to rigid motions; none without a surface flow.
    pub(crate) fn surface_velocity(&self) -> Option<Box<SurfaceVelocity<'_>>> {
        self.boundary_parts().map(BoundaryParts::velocity)
    }

    /// A part of the velocity of bodies: the slip, or that of a coordinate after it.
    pub(crate) fn surface_part(&self, part: usize) -> Option<Box<SurfaceVelocity<'_>>> {
        Some(self.boundary_parts()?.part(part))
    }

    /// Nodal values of the surface flow; none without one.
    ///
    /// # Errors
    /// A velocity that is not finite.
    pub(crate) fn nodal_surface_flow(&self) -> Result<Option<NodalSurfaceFlow>, StokesError> {
        let nodal = |parts| NodalSurfaceFlow::new(parts, self.mesh, 1.0 / self.parts());
        self.boundary_parts().map(nodal).transpose()
    }

    /// Assembles the system of one drive in a formulation, to be solved by the caller.
    ///
    /// Cost: one pass over the cells and three over the matrices.
    ///
    /// # Errors
    /// Degenerate cells, contradictory constraints, a flow that is not unique.
    pub fn assemble(
        &self,
        drive: &Drive,
        formulation: &dyn Formulation,
    ) -> Result<Constrained, StokesError> {
        self.assemble_with(drive, formulation, self.nodal_surface_flow()?.as_ref())
    }

    /// The system of [`Problem::assemble`] with these velocities of surfaces.
    pub(crate) fn assemble_with(
        &self,
        drive: &Drive,
        formulation: &dyn Formulation,
        surfaces: Option<&NodalSurfaceFlow>,
    ) -> Result<Constrained, StokesError> {
        Ok(self.assemble_terms(drive, formulation, surfaces, None)?.0)
    }

    /// The system with terms of inertia, and their forces on the nodes; none without terms.
    pub(crate) fn assemble_terms(
        &self,
        drive: &Drive,
        formulation: &dyn Formulation,
        surfaces: Option<&NodalSurfaceFlow>,
        terms: Option<&InertialTerms>,
    ) -> Result<(Constrained, Vec<Vector3<f64>>), StokesError> {
        let mesh = self.mesh;
        let mut new_space = None;
        let space = self.space_or_new(&mut new_space)?;
        let roles = self.roles();
        let bodies = self.surface_bodies()?;
        let matrices = space.matrices(mesh)?;
        let permeability = self.permeability_of(&roles, &matrices)?;
        let of_gaps = permeability
            .map(|permeability| space.weighted_vertex_stiffness(mesh, &permeability))
            .transpose()?;
        let mut nodes = FluidNodes::new(mesh.points(), &roles)
            .with_symmetry_planes(mesh.nodes_on_symmetry_planes());
        if let Some(surfaces) = surfaces {
            nodes = surfaces.on_nodes(nodes, &surfaces.velocity);
        }
        let (mut fluid, forces) = match terms {
            None => {
                // The blocks of the matrices are the peak of the memory.
                drop(new_space.take());
                let fluid = RigidFluid::new(fluid_matrices(matrices), nodes, &bodies)?;
                (fluid, Vec::new())
            }
            Some(terms) => {
                if let Some(velocity) = terms.wall_velocity {
                    nodes = nodes.with_wall_velocity(velocity);
                }
                let (inertia, forces) = terms.assemble(space, mesh, &matrices)?;
                let matrices = fluid_matrices(matrices);
                (
                    RigidFluid::with_inertia(matrices, inertia, nodes, &bodies)?,
                    forces,
                )
            }
        };
        if let Some(stiffness) = of_gaps {
            fluid = fluid.with_pressure_stiffness(stiffness)?;
        }
        Ok((formulation.constrain(fluid, drive)?, forces))
    }

    /// Assembles the equations of the nodes that this process owns.
    ///
    /// `submesh` has all cells around these nodes, `part` says which of its nodes they are. Rows of
    /// other nodes are incomplete. Border, right-hand side of the border and corner are those of
    /// the whole problem, the same on every process; columns of the border have the rows of owned
    /// nodes only. Every process calls this function, because it sums over processes.
    ///
    /// Pressure Laplacians for narrow gaps and channels are not assembled: they need
    /// [`Problem::permeability`] of the whole mesh.
    ///
    /// # Errors
    /// Those of [`Problem::assemble`].
    pub fn assemble_part(
        &self,
        submesh: &Submesh,
        part: MeshPart,
        drive: &Drive,
        formulation: &dyn Formulation,
    ) -> Result<Constrained, StokesError> {
        let mesh = &submesh.mesh;
        let restricted = |values: &[_]| -> Vec<_> {
            let nodes = submesh.nodes.iter();
            nodes.map(|&node| values[node as usize]).collect()
        };
        let all_roles = self.roles();
        let roles: Vec<_> = (submesh.nodes.iter())
            .map(|&node| all_roles[node as usize])
            .collect();
        drop(all_roles);
        let on_planes = self.mesh.nodes_on_symmetry_planes();
        let on_planes = on_planes.into_iter().filter_map(|(node, axes)| {
            let number = submesh.number(node)?;
            Some((number, axes))
        });
        let surfaces = self.nodal_surface_flow()?;
        let velocity = surfaces.as_ref().map(|s| restricted(&s.velocity));
        let mut nodes = FluidNodes::new(mesh.points(), &roles)
            .with_symmetry_planes(on_planes.collect())
            .with_part(part);
        if let (Some(surfaces), Some(velocity)) = (&surfaces, &velocity) {
            nodes = surfaces.on_nodes(nodes, velocity);
        }
        let matrices = TaylorHood::new(mesh)?.matrices(mesh)?;
        let fluid = RigidFluid::new(fluid_matrices(matrices), nodes, &self.surface_bodies()?)?;
        Ok(formulation.constrain(fluid, drive)?)
    }
}

/// Matrices of Stokes flow in the form that [`rigid::RigidFluid::new`] takes.
///
/// The crates `fem` and `rigid` do not depend on each other; their fields correspond one to one.
pub fn fluid_matrices(matrices: StokesMatrices) -> FluidMatrices {
    let StokesMatrices {
        stiffness,
        divergence,
        pressure_mass,
        interpolation,
        vertex_stiffness,
    } = matrices;
    FluidMatrices {
        stiffness,
        divergence,
        pressure_mass,
        interpolation,
        vertex_stiffness,
    }
}
