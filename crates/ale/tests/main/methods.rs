//! Properties of every extension method: fields it reproduces exactly, surfaces that follow their
//! body, independence of the number of threads.

use ale::{
    AleError, Biharmonic, Elastic, Harmonic, Kernel, MeshMotion, MovingBody, MovingMesh, Rbf,
    ReferenceMap, Stiffening,
};
use fem::TaylorHood;
use mesh::{Surface, TetMesh, Vec3};
use mesher::{Sphere, Spheroid};
use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion};

/// Bound on the solver's error: the relative residual is 1e-8 (1e-6 for the biharmonic extension)
/// and the condition number on these coarse meshes below 1e3.
const SOLVER_ERROR: f64 = 1e-4;

fn all_methods() -> Vec<Box<dyn MeshMotion>> {
    vec![
        Box::new(Harmonic(Stiffening::None)),
        Box::new(Harmonic(Stiffening::KanchiMasud)),
        Box::new(Harmonic(Stiffening::InverseVolume)),
        Box::new(Elastic::new(0.0)),
        Box::new(Elastic::new(0.3)),
        Box::new(Biharmonic),
        Box::new(Rbf(Kernel::Linear)),
        Box::new(Rbf(Kernel::Cubic)),
    ]
}

fn mesh_around(surface: &dyn Surface, radius: f64) -> TetMesh {
    crate::mesh_around(&[("bead", surface)], radius, 0.7)
}

fn sphere() -> Sphere {
    Sphere::new(Vec3::new(0.5, 0.0, 0.0), 1.0)
}

fn bead(rotates: bool) -> [MovingBody; 1] {
    [MovingBody {
        tag: "bead".into(),
        centre: sphere().centre,
        rotates,
    }]
}

/// Largest difference between a field and the extension of its boundary values.
fn error_of(motion: &dyn MeshMotion, mesh: &TetMesh, exact: impl Fn(&Vec3) -> Vec3) -> f64 {
    let mut prescribed = vec![false; mesh.n_vertices()];
    for facet in mesh.facets() {
        facet.nodes[..3]
            .iter()
            .for_each(|&v| prescribed[v as usize] = true);
    }
    let vertices = &mesh.points()[..mesh.n_vertices()];
    // Interior values of the input are arbitrary.
    let start = vertices.iter().zip(&prescribed);
    let field = start.map(|(x, &on)| if on { exact(x) } else { Vec3::repeat(7.0) });
    let mut fields = [field.collect::<Vec<_>>()];
    let moving = MovingMesh {
        mesh,
        space: &TaylorHood::new(mesh).unwrap(),
        prescribed: &prescribed,
    };
    motion.extend(&moving, &mut fields).unwrap();
    let pairs = vertices.iter().zip(&fields[0]);
    pairs
        .map(|(x, d)| (d - exact(x)).amax())
        .fold(0.0, f64::max)
}

#[test]
fn methods_reproduce_translations_and_some_linear_fields() {
    // Straight edges: on curved cells the interpolant of a linear function's vertex values is not
    // linear.
    let body = sphere();
    let mesh = mesh_around(&body, 5.0);
    let (vertices, n) = (mesh.points().to_vec(), mesh.n_vertices());
    let mut points = vertices;
    for cell in mesh.cells() {
        for (&middle, [a, b]) in cell[4..].iter().zip(mesh::TET_EDGES) {
            points[middle as usize] = 0.5 * (points[cell[a] as usize] + points[cell[b] as usize]);
        }
    }
    let mesh = mesh.with_points(points).unwrap();
    assert!(n > 200);
    let shift = Vec3::new(0.3, -0.2, 0.1);
    let spin = Vec3::new(0.2, 0.1, -0.3);
    let strain = Matrix3::new(0.1, 0.2, 0.0, -0.1, 0.05, 0.3, 0.2, 0.0, -0.1);
    for motion in all_methods() {
        let name = motion.name();
        let moved = error_of(motion.as_ref(), &mesh, |_| shift);
        assert!(
            moved < SOLVER_ERROR,
            "{name}: error of a translation {moved:e}"
        );
        // A linearised rotation has no strain, so elasticity reproduces it for any coefficient.
        if name == "elastic" {
            let rotated = error_of(motion.as_ref(), &mesh, |x| spin.cross(x));
            assert!(
                rotated < SOLVER_ERROR,
                "{name}: error of a rotation {rotated:e}"
            );
        }
        // Linear fields are harmonic, and radial interpolation includes linear polynomials.
        if ["laplace", "rbf-linear", "rbf-cubic"].contains(&name) {
            let strained = error_of(motion.as_ref(), &mesh, |x| strain * x);
            assert!(
                strained < SOLVER_ERROR,
                "{name}: error of a linear field {strained:e}"
            );
        }
    }
}

#[test]
fn surface_nodes_follow_a_rotating_body_with_every_method() {
    let spheroid = Spheroid {
        centre: sphere().centre,
        axis: Vec3::x(),
        axial: 1.6,
        equatorial: 1.0,
    };
    let mesh = mesh_around(&spheroid, 6.0);
    let motion = Isometry3::from_parts(
        Translation3::new(0.2, 0.1, 0.0),
        UnitQuaternion::from_scaled_axis(Vec3::new(0.0, 0.1, 0.2)),
    );
    for method in all_methods() {
        let name = method.name();
        let map = ReferenceMap::new(mesh.clone(), &bead(true), method.as_ref()).unwrap();
        let moved = map.moved(&[motion]).unwrap();
        let nodes = mesh.nodes_on(mesh.tag("bead").unwrap());
        assert!(!nodes.is_empty());
        for node in nodes {
            let arm = mesh.points()[node as usize] - spheroid.centre;
            let expected = spheroid.centre + motion.translation.vector + motion.rotation * arm;
            assert!(
                (moved.points()[node as usize] - expected).amax() < 1e-13,
                "{name}"
            );
        }
        // The body keeps its volume and the container is fixed, so the fluid keeps its volume.
        assert!((moved.volume() - mesh.volume()).abs() < 1e-11 * mesh.volume());
    }
}

#[test]
fn refused_motions_say_why() {
    let mesh = mesh_around(&sphere(), 5.0);
    for motion in all_methods() {
        let map = ReferenceMap::new(mesh.clone(), &bead(false), motion.as_ref()).unwrap();
        let through_the_wall = map.moved(&[Isometry3::translation(5.0, 0.0, 0.0)]);
        assert!(matches!(through_the_wall, Err(AleError::Invalid(_))));
        assert!(matches!(
            map.moved(&[]),
            Err(AleError::Motions {
                expected: 1,
                found: 0
            })
        ));
    }
}

#[test]
fn poisson_ratios_out_of_range_are_refused() {
    let body = sphere();
    let mesh = mesh_around(&body, 5.0);
    for poisson in [0.5, -0.1, f64::NAN] {
        let refused = ReferenceMap::new(mesh.clone(), &bead(false), &Elastic::new(poisson));
        assert!(
            matches!(refused, Err(AleError::Parameter { .. })),
            "{poisson}"
        );
    }
}

#[test]
fn results_are_bitwise_equal_for_one_and_two_threads() {
    let body = sphere();
    let mesh = mesh_around(&body, 8.0);
    let moved = |threads: usize, motion: &dyn MeshMotion| -> Vec<Vec3> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let map = ReferenceMap::new(mesh.clone(), &bead(true), motion).unwrap();
            let rotation = UnitQuaternion::from_scaled_axis(Vec3::new(0.0, 0.0, 0.1));
            let motion = Isometry3::from_parts(Translation3::new(0.3, 0.1, 0.0), rotation);
            map.moved(&[motion]).unwrap().points().to_vec()
        })
    };
    for motion in all_methods() {
        let (one, two) = (moved(1, motion.as_ref()), moved(2, motion.as_ref()));
        assert!(one == two, "{}", motion.name());
    }
}

#[test]
fn stiffening_coefficients_follow_from_the_volumes_of_the_cells() {
    let mut tets = mesh::LinearTets::cube(2);
    for x in &mut tets.points {
        x.x *= 1.0 + x.x;
    }
    let mesh = TetMesh::straight(tets).unwrap();
    let volumes: Vec<f64> = (0..mesh.n_cells())
        .map(|cell| mesh.cell_volume(cell))
        .collect();
    let [smallest, largest] = [f64::min, f64::max].map(|of| volumes.iter().copied().reduce(of));
    let (smallest, largest) = (smallest.unwrap(), largest.unwrap());
    assert!(largest > 1.5 * smallest);
    let [none, kanchi_masud, inverse] = [
        Stiffening::None,
        Stiffening::KanchiMasud,
        Stiffening::InverseVolume,
    ]
    .map(|stiffening| stiffening.coefficients(&mesh));
    for (cell, volume) in volumes.iter().enumerate() {
        assert_eq!(none[cell], 1.0);
        assert!((inverse[cell] * volume / largest - 1.0).abs() < 1e-14);
        // 1 + (1 - V_min / V_max) / (V / V_max), one for the largest of equal cells.
        let expected = 1.0 + (largest - smallest) / volume;
        assert!((kanchi_masud[cell] / expected - 1.0).abs() < 1e-14);
    }
}
