//! Flow around spheres: at points, on a mesh for visualisation, and their stresslets.

use mesh::{NamedSurface, TetMesh};
use mesher::{BoxSurface, Container, GenerateParams, MeshedBody, Sphere};
use microhydro::multipole::{self, SphereSlip, VelocityField};
use microhydro::{Accuracy, HydroError, Medium, Spheres};
use nalgebra::{DVector, Vector3};
use rayon::prelude::*;

use super::SpheresModel;
use super::sphere_resistances::SphereResistances;
use crate::error::ModelError;
use crate::query::Configuration;
use crate::solution::Stresslets;
use crate::surface_motion::SurfaceMotion;

/// Element size on the spheres, relative to their radius.
const SURFACE_SIZE: f64 = 0.5;

/// Size of the mesh in directions without walls, relative to half the diagonal of the bounding box.
const RELATIVE_SIZE: f64 = 3.0;

/// Relative error of the velocities.
const ACCURACY: f64 = 1e-3;

/// Spheres with their velocities, in scaled units.
pub(super) struct MovingSpheres {
    pub spheres: Spheres,
    /// Six per sphere, `(U, ω)`.
    pub velocities: DVector<f64>,
    /// Motion of the surfaces relative to the spheres, and the background flow.
    pub surfaces: Option<SurfaceMotion>,
    /// Scaled rates of the joints.
    pub rates: Vec<f64>,
}

impl MovingSpheres {
    /// Velocity of a surface relative to its sphere and to the background flow.
    pub fn surface_velocity(&self, sphere: usize, n: &Vector3<f64>) -> Vector3<f64> {
        let spheres = &self.spheres;
        let x = spheres.centres()[sphere] + spheres.radii()[sphere] * n;
        let arm = spheres.radii()[sphere] * n;
        let of = |motion: &SurfaceMotion| {
            motion.slip(sphere, n) + motion.of_deformation(sphere, &arm, &self.rates)
                - motion.background(&x)
        };
        self.surfaces.as_ref().map_or_else(Vector3::zeros, of)
    }

    /// Velocity of the fluid in the absence of the spheres.
    fn background(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let of = |motion: &SurfaceMotion| motion.background(x);
        self.surfaces.as_ref().map_or_else(Vector3::zeros, of)
    }

    /// The disturbance of the background flow.
    fn disturbance(&self, medium: &Medium) -> Result<VelocityField, ModelError> {
        let surface = |sphere: usize, n: &Vector3<f64>| self.surface_velocity(sphere, n);
        Ok(VelocityField::with_surface_velocity(
            &self.spheres,
            medium,
            &self.velocities,
            (self.surfaces.as_ref()).map(|_| &surface as &SphereSlip<'_>),
            &Accuracy::relative(ACCURACY),
        )?)
    }
}

/// Velocities at points; `None` for a point outside the fluid.
///
/// Cost: about ten microseconds per point and sphere, in parallel.
///
/// # Errors
/// Spheres that are too many for the expansions; a point whose velocity is not finite.
pub(super) fn velocities_at(
    moving: &MovingSpheres,
    medium: &Medium,
    points: &[Vector3<f64>],
) -> Result<Vec<Option<Vector3<f64>>>, ModelError> {
    let flow = moving.disturbance(medium)?;
    let velocity = |x: &Vector3<f64>| match flow.velocity(x) {
        Ok(disturbance) => Ok(Some(disturbance + moving.background(x))),
        Err(HydroError::NotInFluid { .. }) => Ok(None),
        Err(error) => Err(error.into()),
    };
    points.par_iter().map(velocity).collect()
}

/// A mesh around spheres in scaled units, and the velocity at its nodes.
///
/// Shapes: `names` one per sphere. Cost: a mesh, and about ten microseconds per node and sphere.
///
/// # Errors
/// Spheres around which no mesh can be generated, or that are too close for the expansions.
pub(super) fn flow_field(
    moving: &MovingSpheres,
    medium: &Medium,
    names: &[&str],
) -> Result<(TetMesh, Vec<Vector3<f64>>), ModelError> {
    let MovingSpheres {
        spheres,
        velocities,
        surfaces: motion,
        ..
    } = moving;
    let surfaces: Vec<Sphere> = spheres
        .centres()
        .iter()
        .zip(spheres.radii())
        .map(|(&centre, &radius)| Sphere { centre, radius })
        .collect();
    let bodies: Vec<MeshedBody> = names
        .iter()
        .zip(&surfaces)
        .map(|(name, surface)| MeshedBody {
            name,
            surface,
            size: SURFACE_SIZE * surface.radius,
        })
        .collect();
    let container = container(spheres, medium);
    let parameters = GenerateParams::default().with_growth(0.5).with_sweeps(4);
    let tets = mesher::generate(&bodies, &container, &parameters)?.mesh;
    let named: Vec<NamedSurface> = bodies
        .iter()
        .map(|b| (b.name, b.surface))
        .chain([(Container::TAG, container.surface())])
        .collect();
    let mesh = TetMesh::curved(tets, &named)?;
    let flow = moving.disturbance(medium)?;
    // On surfaces the velocity is given; by rounding, nodes may lie inside a sphere.
    let mut known = vec![None; mesh.n_points()];
    if *medium != Medium::Unbounded {
        for &node in mesh.nodes_on(mesh.tag(Container::TAG)?).iter() {
            let x = &mesh.points()[node as usize];
            let extent = x.norm().max(1.0);
            if medium.distance(x) <= 1e-9 * extent {
                known[node as usize] = Some(Vector3::zeros());
            }
        }
    }
    for (number, (name, centre)) in names.iter().zip(spheres.centres()).enumerate() {
        let at = |first: usize| velocities.fixed_rows::<3>(6 * number + first).into_owned();
        for &node in mesh.nodes_on(mesh.tag(name)?).iter() {
            let arm = mesh.points()[node as usize] - centre;
            let of_surface = match motion {
                Some(_) => moving.surface_velocity(number, &arm.normalize()),
                None => Vector3::zeros(),
            };
            known[node as usize] = Some(at(0) + at(3).cross(&arm) + of_surface);
        }
    }
    let unknown: Vec<Vector3<f64>> = (mesh.points().iter().zip(&known))
        .filter(|(_, known)| known.is_none())
        .map(|(x, _)| *x)
        .collect();
    let mut found = flow.velocities(&unknown)?.into_iter();
    let velocity = (known.into_iter().zip(mesh.points()))
        .map(|(known, x)| {
            let disturbance = known.or_else(|| found.next()).unwrap_or_default();
            match motion {
                Some(motion) => disturbance + motion.background(x),
                None => disturbance,
            }
        })
        .collect();
    Ok((mesh, velocity))
}

/// Container of the mesh: the ball that contains the fluid, or a neighbourhood of the spheres.
fn container(spheres: &Spheres, medium: &Medium) -> Container {
    let (x, a) = (spheres.centres(), spheres.radii());
    let corner = |sign: f64| {
        x.iter().zip(a).fold(
            Vector3::repeat(-f64::INFINITY),
            |corner: Vector3<f64>, (x, a)| corner.sup(&(sign * x).add_scalar(*a)),
        )
    };
    let (max, min) = (corner(1.0), -corner(-1.0));
    let middle = 0.5 * (max + min);
    let size = RELATIVE_SIZE * 0.5 * (max - min).norm();
    match *medium {
        Medium::Ball { centre, radius } => Container::Ball(Sphere { centre, radius }),
        Medium::Unbounded => Container::Ball(Sphere {
            centre: middle,
            radius: size,
        }),
        // In scenes the wall is the plane z = 0.
        Medium::Wall { .. } => Container::Box(BoxSurface {
            min: Vector3::new(middle.x - size, middle.y - size, 0.0),
            max: middle.add_scalar(size),
        }),
    }
}

impl SpheresModel {
    /// Stresslets of spheres with these generalised velocities and their estimated errors.
    ///
    /// `None` for spheres that are too many for the expansions; models of point forces do not ask.
    ///
    /// Cost: one solve of the expansions.
    ///
    /// # Errors
    /// An iteration that does not converge.
    pub(super) fn stresslets(
        &self,
        (configuration, rates): (Configuration, &[f64]),
        resistances: &SphereResistances,
        [generalised, errors]: [&DVector<f64>; 2],
    ) -> Result<Option<Stresslets>, ModelError> {
        let moving = self.placed(configuration, rates, generalised)?;
        let velocity_errors = errors.select_rows(&self.scaled.set.surface_velocities());
        let surface = |sphere: usize, n: &Vector3<f64>| moving.surface_velocity(sphere, n);
        let found = multipole::stresslets(
            &moving.spheres,
            &self.medium,
            &resistances.orders,
            [&moving.velocities, &velocity_errors],
            (moving.surfaces.as_ref()).map(|_| &surface as &SphereSlip<'_>),
        );
        let found = match found {
            Err(HydroError::TooLarge { .. }) => return Ok(None),
            found => found?,
        };
        let [stresslets, errors] =
            [&found.values, &found.errors].map(|scaled| self.scaled.stresslets_to_scene(scaled));
        // Expansions are not corrected: the change of the order is the error.
        let rounding = found.rounding * stresslets.largest();
        let error = Some(errors.largest() + rounding);
        Ok(Some(Stresslets {
            error,
            ..stresslets
        }))
    }
}
