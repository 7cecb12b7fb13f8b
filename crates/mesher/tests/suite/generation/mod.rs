//! Generated meshes have the promised quality, in the scenes for which the solvers are used.

mod bad_scenes;
mod bodies_of_any_shape;
mod random_scenes;
mod remeshed;

use crate::{ball, curved, on_threads, surfaces};
use mesh::{LinearTets, NamedSurface, Quality, Surface, TetMesh, Vec3};
use mesher::{
    BoxSurface, Capsule, Container, GenerateParams, MeshedBody, Sphere, Spheroid, generate,
};
use std::collections::HashMap;

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

/// Generates and curves a mesh, and checks its volume and vertices against the true shapes.
fn checked(bodies: &[MeshedBody<'_>], container: &Container) -> (LinearTets, Quality) {
    let (mesh, of_mesh) = curved(bodies, container, &GenerateParams::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let surfaces = surfaces(bodies, container);
    for &(face, tag) in &mesh.faces {
        let surface = surfaces[tag as usize].1;
        let (_, radius) = surface.bounding_ball();
        for v in face {
            let x = mesh.points[v as usize];
            // Surface points lie on a grid of the last bit of the largest coordinate, which is
            // below 32; squares add further rounding.
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
    // The volume of the tets is that enclosed by the faces (divergence theorem).
    let enclosed = enclosed(&mesh, |_| true);
    let terms = (mesh.tets.len() + mesh.faces.len()) as f64;
    assert!((volume - enclosed).abs() <= terms * f64::EPSILON * volume);
    (mesh, of_mesh.quality())
}

/// Volume that the faces of some parts enclose.
fn enclosed(mesh: &LinearTets, is_wanted: impl Fn(u16) -> bool) -> f64 {
    let faces = mesh.faces.iter().filter(|(_, tag)| is_wanted(*tag));
    let volume = |(face, _): &([u32; 3], u16)| {
        let [a, b, c] = face.map(|v| mesh.points[v as usize]);
        a.dot(&b.cross(&c)) / 6.0
    };
    faces.map(volume).sum()
}

/// Asserts the quality that every mesh around separate bodies must have.
fn assert_good(label: &str, quality: &Quality) {
    assert!(quality.min_dihedral >= 15.0, "{label}: {quality:?}");
    assert!(quality.max_dihedral <= 165.0, "{label}: {quality:?}");
    assert!(quality.mean_quality >= 0.85, "{label}: {quality:?}");
    assert!(quality.min_jacobian > 0.0, "{label}: {quality:?}");
}

/// Faces of a part in terms of its own vertices, each rotated to begin with its smallest vertex.
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

/// Vertices of a part, by ascending number.
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
        assert_good(&format!("size {size}"), &quality);
    }
}

#[test]
fn mesh_has_at_most_half_more_vertices_than_that_of_gmsh_with_equal_surface_size() {
    // Gmsh: 976 triangles per sphere, 12 598 vertices; the nearest geodesic sphere has 960
    // triangles.
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
fn three_spheres_with_short_arms() {
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
        assert_good(&format!("arms {left}, {right}"), &quality);
    }
}

#[test]
fn one_sphere_in_small_and_large_balls() {
    let shapes = collinear(&[0.0]);
    for radius in [1.1, 1.5, 4.0, 500.0] {
        let (_, quality) = checked(&bodies(&shapes, 0.5), &ball(radius));
        assert_good(&format!("ball {radius}"), &quality);
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
    assert_good("27 spheres", &quality);
}

#[test]
fn volume_enclosed_by_the_walls_of_a_box_is_exact() {
    let sides = BoxSurface {
        min: Vec3::new(-15.0, -8.0, -6.0),
        max: Vec3::new(15.0, 8.0, 9.0),
    };
    let shapes = collinear(&[-10.0, 0.0, 10.0]);
    let (mesh, quality) = checked(&bodies(&shapes, 0.6), &Container::Box(sides));
    assert_good("box", &quality);
    let walls = enclosed(&mesh, |tag| tag == 3);
    assert!((walls - sides.volume()).abs() < 1e-12 * sides.volume());
}

#[test]
fn bodies_in_a_capsule() {
    for (radius, x) in [(4.0, 0.0), (4.0, 2.0), (12.0, 3.0)] {
        let capsule = Capsule::new(Vec3::zeros(), radius, 10.0 + 4.0 * radius);
        let shapes: Vec<Sphere> =
            unit_spheres(&[-6.0, 0.0, 6.0].map(|along| Vec3::new(along, 0.6 * x, -0.8 * x)));
        let (_, quality) = checked(&bodies(&shapes, 0.6), &Container::Capsule(capsule));
        assert_good("cylinder", &quality);
    }
}

#[test]
fn radii_of_one_to_twenty_side_by_side() {
    for gap in [0.15, 0.01] {
        let shapes = [
            Sphere::new(Vec3::zeros(), 1.0),
            Sphere::new(Vec3::new(0.0, 1.05 + gap, 0.0), 0.05),
        ];
        let (_, quality) = checked(&bodies(&shapes, 0.5), &ball(20.0));
        assert_good(&format!("gap {gap}"), &quality);
    }
}

#[test]
fn off_centre_and_tilted() {
    let direction = Vec3::new(0.3, 0.5, -0.7).normalize();
    let centres = [-10.0, 0.0, 7.3].map(|t| Vec3::new(17.3, -20.1, 9.7) + t * direction);
    let (_, quality) = checked(&bodies(&unit_spheres(&centres), 0.5), &ball(40.0));
    assert_good("tilted", &quality);
    let near_wall = unit_spheres(&[Vec3::new(38.9, 0.0, 0.0)]);
    let (_, quality) = checked(&bodies(&near_wall, 0.5), &ball(40.0));
    assert_good("near the wall", &quality);
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
        let body = MeshedBody::new("spheroid", &shape, 0.5);
        let (_, quality) = checked(&[body], &ball(20.0));
        assert_good(&format!("{axial} : {equatorial}"), &quality);
    }
}

#[test]
fn an_empty_container_can_be_meshed() {
    let (mesh, quality) = checked(&[], &ball(2.0));
    assert_good("empty ball", &quality);
    assert_eq!(mesh.tags, ["outer"]);
}

#[test]
fn meshes_are_bitwise_the_same_for_any_number_of_threads() {
    let shapes = collinear(&[-3.0, 0.0, 5.0]);
    let bodies = bodies(&shapes, 0.5);
    let run = |threads| {
        let generated = || generate(&bodies, &ball(40.0), &GenerateParams::default());
        on_threads(threads, generated).expect("a valid scene").mesh
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
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

#[test]
fn gap_ratio_is_about_one_after_generation_and_larger_in_a_closing_gap() {
    let container = ball(12.0);
    let wall = Some(container.surface());
    for gap in [1.0, 0.2] {
        let shapes = collinear(&[-1.0 - gap / 2.0, 1.0 + gap / 2.0]);
        let bodies = bodies(&shapes, 0.8);
        let (_, mesh) = curved(&bodies, &container, &GenerateParams::default()).unwrap();
        let fresh = mesh.gap_ratio(&[&shapes[0], &shapes[1]], wall);
        // The wanted edges are 0.6 of the gap; the longest edge of a regular pair of tets across it
        // is 1.2 of the gap.
        assert!((0.5..1.3).contains(&fresh), "{gap}: {fresh}");
        // With spheres moved into the gap, the same cells are too long.
        let near = collinear(&[-1.0 - gap / 8.0, 1.0 + gap / 8.0]);
        let squeezed = mesh.gap_ratio(&[&near[0], &near[1]], wall);
        assert!(squeezed > 1.5 * fresh, "{gap}: {squeezed}");
        assert_eq!(mesh.gap_ratio(&[&shapes[0]], None), 0.0);
    }
}

#[cfg(feature = "serde")]
#[test]
fn shapes_read_back_as_they_were_serialised() {
    let capsule = Capsule::new(Vec3::new(0.1, 0.2, 0.3), 1.5, 4.0);
    let text = serde_json::to_string(&capsule).unwrap();
    assert_eq!(serde_json::from_str::<Capsule>(&text).unwrap(), capsule);
}

/// The sides of a box have the tags of a cube, on the same mesh; symmetry planes take their sides.
#[test]
fn sides_of_a_box_have_tags_of_their_own() {
    let sphere = Sphere::new(Vec3::zeros(), 1.0);
    let body = [MeshedBody::new("bead", &sphere, 0.8)];
    let half = Vec3::new(3.0, 4.0, 5.0);
    let container = Container::Box(BoxSurface {
        min: -half,
        max: half,
    });
    for planes in [[false; 3], [true, false, false]] {
        let params = GenerateParams::default()
            .with_symmetry_planes(planes)
            .with_growth(0.6);
        let plain = generate(&body, &container, &params).unwrap().mesh;
        let params = params.with_box_sides(true);
        let found = generate(&body, &container, &params).unwrap().mesh;
        assert_eq!((&plain.points, &plain.tets), (&found.points, &found.tets));
        let sides: Vec<&str> = Container::BOX_TAGS
            .into_iter()
            .filter(|side| !(planes[0] && *side == "x0"))
            .collect();
        let others = ["bead"].into_iter().chain(planes[0].then_some("mirror-x"));
        let expected: Vec<&str> = others.chain(sides.iter().copied()).collect();
        assert_eq!(found.tags, expected);
        let mesh = TetMesh::curved(found, &[("bead", &sphere)]).unwrap();
        for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let name = Container::BOX_TAGS[2 * axis + side];
            let at = half[axis] * (2.0 * side as f64 - 1.0);
            if let Ok(tag) = mesh.tag(name) {
                let nodes = mesh.nodes_on(tag);
                assert!(
                    nodes
                        .iter()
                        .all(|&node| mesh.points()[node as usize][axis] == at)
                );
                assert!(nodes.len() > 8, "{name}");
            }
        }
    }
    let params = GenerateParams::default().with_box_sides(true);
    assert!(generate(&body, &ball(5.0), &params).is_err());
    let named = [MeshedBody::new("y1", &sphere, 0.8)];
    assert!(generate(&named, &container, &params).is_err());
}
