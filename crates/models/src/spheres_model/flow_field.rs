//! Flow field around spheres on a mesh, for visualisation.

use mesh::{BoxSurface, Container, GenerateParams, MeshedBody, NamedSurface, Sphere, TetMesh};
use microhydro::multipole::{SurfaceVelocity, VelocityField};
use microhydro::{Accuracy, Medium, Spheres};
use nalgebra::{DVector, Vector3};

use crate::ModelError;
use crate::surface_motion::SurfaceMotion;

/// Element size on the spheres, relative to their radius.
const SURFACE_SIZE: f64 = 0.5;

/// Size of the mesh in directions without walls, relative to half the diagonal of the bounding box.
const RELATIVE_SIZE: f64 = 3.0;

/// Relative error of the velocities.
const ACCURACY: f64 = 1e-3;

/// A mesh around spheres in scaled units, and the velocity at its nodes.
///
/// Shapes: `names` one per sphere; `velocities` six per sphere, `(U, ω)`. `motion` is that of the
/// surfaces, and the background flow. Cost: a mesh, and about
/// ten microseconds per node and sphere.
///
/// # Errors
/// Spheres around which no mesh can be generated, or that are too close for the expansions.
pub(super) fn flow_field(
    spheres: &Spheres,
    medium: &Medium,
    names: &[&str],
    velocities: &DVector<f64>,
    motion: Option<&SurfaceMotion>,
) -> Result<(TetMesh, Vec<Vector3<f64>>), ModelError> {
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
    let mut parameters = GenerateParams::default();
    parameters.growth = 0.5;
    parameters.sweeps = 4;
    let tets = mesh::generate(&bodies, &container, &parameters)?.mesh;
    let named: Vec<NamedSurface> = bodies
        .iter()
        .map(|b| (b.name, b.surface))
        .chain([(Container::TAG, container.surface())])
        .collect();
    let mesh = TetMesh::curved(tets, &named)?;
    let surface = |sphere: usize, n: &Vector3<f64>| {
        let x = spheres.centres()[sphere] + spheres.radii()[sphere] * n;
        motion.map_or_else(Vector3::zeros, |motion| {
            motion.slip(sphere, n) - motion.background(&x)
        })
    };
    let flow = VelocityField::with_surface_velocity(
        spheres,
        medium,
        velocities,
        motion.map(|_| &surface as &SurfaceVelocity<'_>),
        &Accuracy::relative(ACCURACY),
    )?;
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
                Some(_) => surface(number, &arm.normalize()),
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
            motion.map_or(disturbance, |motion| disturbance + motion.background(x))
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
