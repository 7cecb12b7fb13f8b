//! The flow around spheres on a mesh around them, for pictures.

use mesh::{BoxSurface, Container, GenerateParams, MeshedBody, NamedSurface, Sphere, TetMesh};
use microhydro::multipole::VelocityField;
use microhydro::{Accuracy, Medium, Spheres};
use nalgebra::{DVector, Vector3};

use crate::ModelError;

/// Element size on the spheres, over the radius.
const SURFACE_SIZE: f64 = 0.5;

/// How far the picture reaches beyond the spheres where the fluid does not end, over half of their extent and a radius.
const REACH: f64 = 3.0;

/// Velocities in pictures err by this part of the spheres'.
const ACCURACY: f64 = 1e-3;

/// A mesh in units of the flow around spheres with these `(U, omega)`, and the velocity at all its nodes.
///
/// Cost: a mesh, and some ten microseconds a node and sphere.
///
/// # Errors
/// Spheres that cannot be meshed around, or too close for the expansions.
pub(super) fn picture(
    spheres: &Spheres,
    medium: &Medium,
    names: &[&str],
    velocities: &DVector<f64>,
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
    let flow = VelocityField::new(spheres, medium, velocities, &Accuracy::relative(ACCURACY))?;
    // on surfaces the velocity is known, and rounding may have put nodes inside
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
            known[node as usize] = Some(at(0) + at(3).cross(&arm));
        }
    }
    let unknown: Vec<Vector3<f64>> = (mesh.points().iter().zip(&known))
        .filter(|(_, known)| known.is_none())
        .map(|(x, _)| *x)
        .collect();
    let mut found = flow.velocities(&unknown)?.into_iter();
    let velocity = known
        .into_iter()
        .map(|known| known.or_else(|| found.next()).unwrap_or_default())
        .collect();
    Ok((mesh, velocity))
}

/// What the picture shows: all of the fluid in a ball, as much as is of interest elsewhere.
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
    let reach = REACH * 0.5 * (max - min).norm();
    match *medium {
        Medium::Ball { centre, radius } => Container::Ball(Sphere { centre, radius }),
        Medium::Unbounded => Container::Ball(Sphere {
            centre: middle,
            radius: reach,
        }),
        // scenes have the wall z = 0
        Medium::Wall { .. } => Container::Box(BoxSurface {
            min: Vector3::new(middle.x - reach, middle.y - reach, 0.0),
            max: middle.add_scalar(reach),
        }),
    }
}
