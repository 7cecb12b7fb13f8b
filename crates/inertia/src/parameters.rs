//! Parameters of an integration, and the bodies with their parts of the mesh.

use fem::TaylorHood;
use mesh::TetMesh;
use nalgebra::{Isometry3, Vector3};
use rigid::{Articulation, BodyKind};
use stokes::rheology::ViscosityLaw;
use stokes::{Options, Problem};

use crate::{BodyMass, InertiaError};

/// Distance of a centre from a symmetry plane, in sizes of a body, that is rounding of many steps.
const PLANE_ROUNDING: f64 = 1e-9;

/// Terms of the momentum equation of the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Convection {
    /// `ρ ∂u/∂t` at points that move with the mesh, no convection: unsteady Stokes flow.
    ///
    /// Near a body the points move with it, at walls they are at rest. The difference from a
    /// derivative at fixed points, `ρ (w · ∇) u` with the velocity `w` of the mesh, is of the order
    /// of the convective term that is neglected; kept alone it would be an Oseen term in the frame
    /// of the body.
    Neglected,
    /// `ρ (∂u/∂t + (u - w) · ∇u)`: the Navier-Stokes equations.
    #[default]
    Full,
}

/// Parameters of an integration.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct Parameters<'a> {
    /// Density of the fluid, at viscosity 1 and lengths of the order of a body.
    pub density: f64,
    /// Viscosity law in place of viscosity 1; none by default.
    pub law: Option<&'a dyn ViscosityLaw>,
    /// Terms of the momentum equation.
    pub convection: Convection,
    /// Formulation, linear solver and its tolerance.
    pub options: Options,
    /// Largest difference of the positions of a step from those of its mesh, in body sizes.
    ///
    /// A step whose predicted mesh is farther away is solved again on the corrected mesh.
    pub mesh_tolerance: f64,
    /// Largest number of times that a step is solved again.
    pub max_corrections: usize,
}

impl<'a> Parameters<'a> {
    /// The Navier-Stokes equations with this density.
    pub fn new(density: f64) -> Self {
        Self {
            density,
            law: None,
            convection: Convection::Full,
            options: Options::default(),
            // a displacement d of a body changes its drag by about d^2, or d next to others
            mesh_tolerance: 1e-4,
            max_corrections: 3,
        }
    }

    /// The same with a viscosity law.
    #[must_use]
    pub fn with_law(self, law: &'a dyn ViscosityLaw) -> Self {
        Self {
            law: Some(law),
            ..self
        }
    }

    /// The same with other terms.
    #[must_use]
    pub fn with_convection(self, convection: Convection) -> Self {
        Self { convection, ..self }
    }

    /// The same with another formulation, linear solver or tolerance.
    #[must_use]
    pub fn with_options(self, options: Options) -> Self {
        Self { options, ..self }
    }
}

/// Bodies, their surfaces in the mesh, and the walls.
#[derive(Clone, Debug)]
pub struct Bodies<'a> {
    /// The bodies and their joints.
    pub set: &'a Articulation,
    /// Masses, one per body, points included.
    pub masses: Vec<BodyMass>,
    /// Boundary part of each body with a surface, in the order of the bodies.
    pub surfaces: Vec<String>,
    /// Boundary parts that are walls.
    pub walls: Vec<String>,
}

impl Bodies<'_> {
    /// Poses of the bodies with a surface.
    pub(crate) fn surfaced(&self, poses: &[Isometry3<f64>]) -> Vec<Isometry3<f64>> {
        let kinds = self.set.kinds().iter().zip(poses);
        let rigid = kinds.filter(|(kind, _)| **kind == BodyKind::Rigid);
        rigid.map(|(_, pose)| *pose).collect()
    }

    /// The Stokes problem on a mesh around bodies with these poses.
    pub(crate) fn problem<'m>(
        &self,
        mesh: &'m TetMesh,
        space: &'m TaylorHood,
        centres: &[Vector3<f64>],
    ) -> Result<Problem<'m>, InertiaError> {
        let parts = self.surfaces.iter().map(String::as_str);
        let planes = mesh.symmetry_planes();
        let on_planes = |centre: &Vector3<f64>| {
            let snapped = |axis: usize| match planes[axis] && centre[axis].abs() <= PLANE_ROUNDING {
                true => 0.0,
                false => centre[axis],
            };
            Vector3::from_fn(|axis, _| snapped(axis))
        };
        let bodies: Vec<(&str, Vector3<f64>)> = parts.zip(centres.iter().map(on_planes)).collect();
        let walls: Vec<&str> = self.walls.iter().map(String::as_str).collect();
        Ok(Problem::new(mesh, &bodies, &walls)?.with_space(space))
    }
}
