//! Generated meshes keep what the generator promises, on the scenes that the solvers are used for.

use mesh::{
    BoxSurface, Capsule, Container, GenerateParams, LinearTets, MeshError, MeshedBody,
    NamedSurface, Quality, Sphere, Spheroid, Surface, TetMesh, Vec3, generate,
};
use proptest::prelude::*;
use std::collections::HashMap;

fn ball(radius: f64) -> Container {
    Container::Ball(Sphere {
        centre: Vec3::zeros(),
        radius,
    })
}

fn unit_spheres(centres: &[Vec3]) -> Vec<Sphere> {
    let sphere = |&centre| Sphere {
        centre,
        radius: 1.0,
    };
    centres.iter().map(sphere).collect()
}

fn collinear(x: &[f64]) -> Vec<Sphere> {
    unit_spheres(
        &x.iter()
            .map(|&x| Vec3::new(x, 0.0, 0.0))
            .collect::<Vec<_>>(),
    )
}

const NAMES: [&str; 27] = [
    "a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l", "m", "n", "o", "p", "q", "r", "s",
    "t", "u", "v", "w", "x", "y", "z", "aa",
];

fn bodies(shapes: &[Sphere], size: f64) -> Vec<MeshedBody<'_>> {
    shapes
        .iter()
        .zip(NAMES)
        .map(|(surface, name)| MeshedBody {
            name,
            surface,
            size: size * surface.radius,
        })
        .collect()
}

/// Generates, curves (which refuses inverted cells), and checks volume and vertices against the true shapes.
fn checked(bodies: &[MeshedBody<'_>], container: &Container) -> (LinearTets, Quality) {
    let mesh = generate(bodies, container, &GenerateParams::default())
        .unwrap_or_else(|e| panic!("{e}"))
        .mesh;
    let mut surfaces: Vec<NamedSurface<'_>> = bodies.iter().map(|b| (b.name, b.surface)).collect();
    surfaces.push((Container::TAG, container.surface()));
    for &(face, tag) in &mesh.faces {
        let surface = surfaces[tag as usize].1;
        let (_, radius) = surface.bounding_ball();
        for v in face {
            let x = mesh.points[v as usize];
            // Surface points lie on a grid of the last bit of the largest coordinate, which is below 32 here;
            // the rest is rounding of squares.
            let rounding = 64.0 * f64::EPSILON * (x.norm() + radius);
            assert!(surface.signed_distance(x).abs() <= rounding, "{x}");
        }
    }
    let volume: f64 = mesh
        .tets
        .iter()
        .map(|tet| {
            let [a, b, c, d] = tet.map(|v| mesh.points[v as usize]);
            let six = (b - a).cross(&(c - a)).dot(&(d - a));
            assert!(six > 0.0);
            six / 6.0
        })
        .sum();
    // The tets fill exactly what the faces enclose (divergence theorem).
    let enclosed: f64 = mesh
        .faces
        .iter()
        .map(|(face, _)| {
            let [a, b, c] = face.map(|v| mesh.points[v as usize]);
            a.dot(&b.cross(&c)) / 6.0
        })
        .sum();
    let terms = (mesh.tets.len() + mesh.faces.len()) as f64;
    assert!((volume - enclosed).abs() <= terms * f64::EPSILON * volume);
    let quality = TetMesh::curved(mesh.clone(), &surfaces)
        .unwrap_or_else(|e| panic!("{e}"))
        .quality();
    (mesh, quality)
}

/// What issue and users ask of every mesh of separate bodies.
fn demand_good(label: &str, quality: &Quality) {
    assert!(quality.min_dihedral >= 15.0, "{label}: {quality:?}");
    assert!(quality.max_dihedral <= 165.0, "{label}: {quality:?}");
    assert!(quality.mean_quality >= 0.85, "{label}: {quality:?}");
    assert!(quality.min_jacobian > 0.0, "{label}: {quality:?}");
}

/// Faces of a part, relative to its first vertex number, each turned to begin with its smallest.
fn relative_faces(mesh: &LinearTets, tag: u16) -> Vec<[u32; 3]> {
    let own = || mesh.faces.iter().filter(move |f| f.1 == tag);
    let first = own().flat_map(|f| f.0).min().expect("the part has faces");
    let mut faces: Vec<[u32; 3]> = own()
        .map(|&(mut face, _)| {
            while face[0] > face[1] || face[0] > face[2] {
                face.rotate_left(1);
            }
            face.map(|v| v - first)
        })
        .collect();
    faces.sort_unstable();
    faces
}

/// Vertices of a part by rising number.
fn vertices(mesh: &LinearTets, tag: u16) -> Vec<Vec3> {
    let mut numbers: Vec<u32> = mesh
        .faces
        .iter()
        .filter(|f| f.1 == tag)
        .flat_map(|f| f.0)
        .collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
        .into_iter()
        .map(|v| mesh.points[v as usize])
        .collect()
}

#[test]
fn three_spheres_at_all_sizes() {
    let shapes = collinear(&[-10.0, 0.0, 10.0]);
    for size in [0.8, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15] {
        let (_, quality) = checked(&bodies(&shapes, size), &ball(40.0));
        demand_good(&format!("size {size}"), &quality);
    }
}

#[test]
fn vertices_at_equal_surface_size_are_at_most_half_more_than_gmsh_spends() {
    // Gmsh: 976 triangles a sphere, 12 598 vertices; the geodesic sphere nearest to it has 960.
    let shapes = collinear(&[-10.0, 0.0, 10.0]);
    let (mesh, _) = checked(&bodies(&shapes, 0.172), &ball(40.0));
    assert_eq!(relative_faces(&mesh, 0).len(), 960);
    assert!(2 * mesh.points.len() <= 3 * 12_598, "{}", mesh.points.len());
}

#[test]
fn equal_spheres_have_bitwise_equal_surface_meshes() {
    for arms in [[-10.0, 10.0], [-6.0, 10.0], [-2.125, 3.0]] {
        let shapes = collinear(&[arms[0], 0.0, arms[1]]);
        let (mesh, _) = checked(&bodies(&shapes, 0.4), &ball(40.0));
        let offsets: Vec<Vec<Vec3>> = (0..3u16)
            .map(|tag| {
                let centre = shapes[tag as usize].centre;
                vertices(&mesh, tag).iter().map(|x| x - centre).collect()
            })
            .collect();
        assert_eq!(offsets[0], offsets[1]);
        assert_eq!(offsets[0], offsets[2]);
        assert_eq!(relative_faces(&mesh, 0), relative_faces(&mesh, 1));
        assert_eq!(relative_faces(&mesh, 0), relative_faces(&mesh, 2));
    }
}

#[test]
fn closing_arms() {
    for (left, right) in [
        (6.0, 10.0),
        (6.0, 6.0),
        (3.0, 3.0),
        (2.25, 2.25),
        (2.1, 2.1),
        (2.05, 4.0),
    ] {
        let shapes = collinear(&[-left, 0.0, right]);
        let (_, quality) = checked(&bodies(&shapes, 0.5), &ball(40.0));
        demand_good(&format!("arms {left}, {right}"), &quality);
    }
}

#[test]
fn one_sphere_in_small_and_large_balls() {
    let shapes = collinear(&[0.0]);
    for radius in [1.1, 1.5, 4.0, 500.0] {
        let (_, quality) = checked(&bodies(&shapes, 0.5), &ball(radius));
        demand_good(&format!("ball {radius}"), &quality);
    }
}

#[test]
fn many_spheres() {
    let centre = |i: i32| {
        Vec3::new(
            f64::from(i % 3 - 1),
            f64::from(i / 3 % 3 - 1),
            f64::from(i / 9 - 1),
        )
    };
    let centres: Vec<Vec3> = (0..27).map(|i| 4.0 * centre(i)).collect();
    let (_, quality) = checked(&bodies(&unit_spheres(&centres), 0.6), &ball(40.0));
    demand_good("27 spheres", &quality);
}

#[test]
fn a_box_keeps_its_corners_and_volume() {
    let sides = BoxSurface {
        min: Vec3::new(-15.0, -8.0, -6.0),
        max: Vec3::new(15.0, 8.0, 9.0),
    };
    let shapes = collinear(&[-10.0, 0.0, 10.0]);
    let (mesh, quality) = checked(&bodies(&shapes, 0.6), &Container::Box(sides));
    demand_good("box", &quality);
    let walls: f64 = mesh
        .faces
        .iter()
        .filter(|f| f.1 == 3)
        .map(|(face, _)| {
            let [a, b, c] = face.map(|v| mesh.points[v as usize]);
            a.dot(&b.cross(&c)) / 6.0
        })
        .sum();
    assert!((walls - sides.volume()).abs() < 1e-12 * sides.volume());
}

#[test]
fn a_cylinder_is_followed_by_its_wall() {
    for (radius, x) in [(4.0, 0.0), (4.0, 2.0), (12.0, 3.0)] {
        let capsule = Capsule {
            centre: Vec3::zeros(),
            radius,
            half_length: 10.0 + 4.0 * radius,
        };
        let shapes: Vec<Sphere> =
            unit_spheres(&[-6.0, 0.0, 6.0].map(|along| Vec3::new(along, 0.6 * x, -0.8 * x)));
        let (_, quality) = checked(&bodies(&shapes, 0.6), &Container::Capsule(capsule));
        demand_good("cylinder", &quality);
    }
}

#[test]
fn radii_of_one_to_twenty_side_by_side() {
    for gap in [0.15, 0.01] {
        let shapes = [
            Sphere {
                centre: Vec3::zeros(),
                radius: 1.0,
            },
            Sphere {
                centre: Vec3::new(0.0, 1.05 + gap, 0.0),
                radius: 0.05,
            },
        ];
        let (_, quality) = checked(&bodies(&shapes, 0.5), &ball(20.0));
        demand_good(&format!("gap {gap}"), &quality);
    }
}

#[test]
fn off_centre_and_tilted() {
    let direction = Vec3::new(0.3, 0.5, -0.7).normalize();
    let centres = [-10.0, 0.0, 7.3].map(|t| Vec3::new(17.3, -20.1, 9.7) + t * direction);
    let (_, quality) = checked(&bodies(&unit_spheres(&centres), 0.5), &ball(40.0));
    demand_good("tilted", &quality);
    let near_wall = unit_spheres(&[Vec3::new(38.9, 0.0, 0.0)]);
    let (_, quality) = checked(&bodies(&near_wall, 0.5), &ball(40.0));
    demand_good("near the wall", &quality);
}

#[test]
fn spheroids() {
    for (axial, equatorial) in [(2.0, 1.0), (4.0, 1.0), (0.5, 1.0), (0.25, 1.0)] {
        let shape = Spheroid {
            centre: Vec3::new(1.0, 2.0, 3.0),
            axis: Vec3::new(1.0, 2.0, 2.0) / 3.0,
            axial,
            equatorial,
        };
        let body = MeshedBody {
            name: "spheroid",
            surface: &shape,
            size: 0.5,
        };
        let (_, quality) = checked(&[body], &ball(20.0));
        demand_good(&format!("{axial} : {equatorial}"), &quality);
    }
}

#[test]
fn an_empty_container_is_meshed_too() {
    let (mesh, quality) = checked(&[], &ball(2.0));
    demand_good("empty ball", &quality);
    assert_eq!(mesh.tags, ["outer"]);
}

#[test]
fn meshes_are_bitwise_the_same_for_any_number_of_threads() {
    let shapes = collinear(&[-3.0, 0.0, 5.0]);
    let bodies = bodies(&shapes, 0.5);
    let run = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads")
            .install(|| generate(&bodies, &ball(40.0), &GenerateParams::default()))
            .expect("a valid scene")
            .mesh
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}

#[test]
fn bad_scenes_are_errors_that_name_the_bodies_and_the_distance() {
    let run = |shapes: &[Sphere], container: &Container| match generate(
        &bodies(shapes, 0.4),
        container,
        &GenerateParams::default(),
    ) {
        Ok(_) => panic!("a mesh of a scene that has none"),
        Err(error) => error,
    };
    let message = run(&collinear(&[0.0, 1.5]), &ball(40.0)).to_string();
    assert!(
        message.contains("'a' and 'b'") && message.contains("-5.000e-1"),
        "{message}"
    );
    assert!(matches!(
        run(&collinear(&[0.0, 2.0]), &ball(40.0)),
        MeshError::BodiesTouch { .. }
    ));
    assert!(matches!(
        run(&collinear(&[39.5]), &ball(40.0)),
        MeshError::BodyAtWall { .. }
    ));
    assert!(matches!(
        run(&collinear(&[100.0]), &ball(40.0)),
        MeshError::BodyAtWall { .. }
    ));
    assert!(matches!(
        run(&collinear(&[0.0]), &ball(1.0)),
        MeshError::BodyAtWall { .. }
    ));
    assert!(matches!(
        run(&collinear(&[f64::NAN]), &ball(40.0)),
        MeshError::BadParameter { .. }
    ));
    assert!(matches!(
        run(&collinear(&[0.0]), &ball(-1.0)),
        MeshError::BadParameter { .. }
    ));
    let flat = Container::Box(BoxSurface {
        min: Vec3::repeat(-5.0),
        max: Vec3::new(5.0, 5.0, -5.0),
    });
    assert!(matches!(
        run(&collinear(&[0.0]), &flat),
        MeshError::BadParameter { .. }
    ));

    let shapes = collinear(&[-5.0, 5.0]);
    let mut twins = bodies(&shapes, 0.4);
    twins[1].name = twins[0].name;
    let params = GenerateParams::default();
    assert!(matches!(
        generate(&twins, &ball(40.0), &params),
        Err(MeshError::BadTag { .. })
    ));
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            generate(&bodies(&shapes, size), &ball(40.0), &params),
            Err(MeshError::BadParameter { .. })
        ));
    }
    assert!(matches!(
        generate(&bodies(&shapes, 1e-9), &ball(40.0), &params),
        Err(MeshError::TooManyVertices { .. })
    ));
}

#[test]
fn every_edge_of_a_surface_joins_two_triangles() {
    let shapes = collinear(&[-2.2, 0.0, 3.0]);
    let (mesh, _) = checked(&bodies(&shapes, 0.5), &ball(20.0));
    let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
    for ([a, b, c], _) in mesh.faces {
        for [i, j] in [[a, b], [b, c], [c, a]] {
            *edges.entry([i.min(j), i.max(j)]).or_default() += if i < j { 1 } else { -1 };
        }
    }
    assert!(edges.values().all(|&turns| turns == 0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Any three spheres give a sound mesh, or an error that says why there is none.
    #[test]
    fn random_scenes(
        places in prop::collection::vec((prop::array::uniform3(-4.0..4.0f64), 0.3..1.5f64), 3),
        size in 0.4..0.9f64,
    ) {
        let shapes: Vec<Sphere> = places
            .iter()
            .map(|&(centre, radius)| Sphere { centre: Vec3::from(centre), radius })
            .collect();
        let bodies = bodies(&shapes, size);
        let closest = (0..3)
            .map(|i| {
                let (a, b) = (shapes[i], shapes[(i + 1) % 3]);
                (a.centre - b.centre).norm() - a.radius - b.radius
            })
            .fold(f64::INFINITY, f64::min);
        if closest > 0.05 {
            let (_, quality) = checked(&bodies, &ball(12.0));
            prop_assert!(quality.min_jacobian > 0.0);
        } else if closest < 0.0 {
            let outcome = generate(&bodies, &ball(12.0), &GenerateParams::default());
            let refused = matches!(outcome, Err(MeshError::BodiesTouch { .. }));
            prop_assert!(refused);
        }
    }
}
