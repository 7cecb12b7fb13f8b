//! New meshes between the walls of a given mesh and its moved bodies.

use std::path::Path;

use mesh::nalgebra::{Isometry3, UnitQuaternion};
use mesh::{MeshError, MshFile};
use mesher::{GenerateError, MovedBody, remesh, remesh_by_gmsh};
use proptest::prelude::*;

use super::*;

/// Three unit spheres of edge length 0.5 on the x axis in a container.
fn three_spheres(container: &Container) -> TetMesh {
    let shapes = collinear(&[-5.0, 0.0, 5.0]);
    let tets = generate(&bodies(&shapes, 0.5), container, &GenerateParams::default());
    TetMesh::curved(tets.unwrap().mesh, &named(&shapes)).unwrap()
}

fn named(shapes: &[Sphere]) -> Vec<NamedSurface<'_>> {
    let surfaces = shapes.iter().map(|sphere| sphere as &dyn Surface);
    NAMES.into_iter().zip(surfaces).collect()
}

/// Bodies that are known by their facets only.
fn as_they_are<'a>(motions: &[(&'a str, Isometry3<f64>)]) -> Vec<MovedBody<'a>> {
    let body = |&(name, motion): &(&'a str, _)| MovedBody {
        name,
        motion,
        surface: None,
    };
    motions.iter().map(body).collect()
}

/// A rotation about a centre, then a shift of it to another place.
fn placed(centre: Vec3, to: Vec3, axis: Vec3) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_scaled_axis(axis);
    Isometry3::from_parts((to - rotation * centre).into(), rotation)
}

fn small_box() -> Container {
    Container::Box(BoxSurface {
        min: Vec3::new(-9.0, -6.0, -5.0),
        max: Vec3::new(10.0, 6.0, 7.0),
    })
}

/// Asserts that a mesh fills the same volume, but for some rounding of each cell.
fn assert_same_volume(new: &TetMesh, mesh: &TetMesh) {
    let rounding = 16.0 * f64::EPSILON * mesh.volume() * (new.n_cells() as f64).sqrt();
    assert!((new.volume() - mesh.volume()).abs() < rounding);
}

/// The nodes of the facets on a boundary part, moved; as bits, sorted.
fn nodes_on(mesh: &TetMesh, part: &str, motion: &Isometry3<f64>) -> Vec<[[u64; 3]; 6]> {
    let tag = mesh.tag(part).unwrap();
    let bits = |node: u32| {
        let x = mesh.points()[node as usize];
        let moved = match *motion == Isometry3::identity() {
            true => x,
            false => motion.transform_point(&x.into()).coords,
        };
        // Minus zero is zero.
        moved.map(|c| (c + 0.0).to_bits()).into()
    };
    let facets = mesh.facets().iter().filter(|facet| facet.tag == tag);
    let mut nodes: Vec<[[u64; 3]; 6]> = facets
        .map(|facet| {
            let mut nodes = facet.nodes.map(bits);
            nodes[..3].sort_unstable();
            nodes[3..].sort_unstable();
            nodes
        })
        .collect();
    nodes.sort_unstable();
    nodes
}

/// Moves the bodies, known by their facets only, and checks that all facets are kept and that the
/// mesh fills the same volume.
fn moved_as_they_are(
    mesh: &TetMesh,
    motions: &[(&str, Isometry3<f64>)],
) -> Result<TetMesh, GenerateError> {
    let bodies = as_they_are(motions);
    let new = remesh(mesh, &bodies, &GenerateParams::default(), &[])?;
    let identity = Isometry3::identity();
    for name in mesh.tags() {
        let motion = motions.iter().find(|(body, _)| body == name);
        let motion = motion.map_or(&identity, |(_, motion)| motion);
        assert!(
            nodes_on(&new, name, &identity) == nodes_on(mesh, name, motion),
            "{name}"
        );
    }
    assert_same_volume(&new, mesh);
    Ok(new)
}

#[test]
fn walls_and_bodies_keep_their_facets() {
    for container in [ball(12.0), small_box()] {
        let mesh = three_spheres(&container);
        // Gaps of 0.6 and 0.5 between the spheres; then one near the wall.
        for shifts in [
            [(2.4, 0.0), (0.0, 0.0), (-2.5, 0.0)],
            [(0.0, 0.0), (1.0, 4.0), (0.5, 0.0)],
        ] {
            let motions: Vec<_> = (NAMES.into_iter().zip(shifts).zip([-5.0, 0.0, 5.0]))
                .map(|((name, (dx, dy)), x)| {
                    let centre = Vec3::new(x, 0.0, 0.0);
                    let to = centre + Vec3::new(dx, dy, 0.0);
                    (name, placed(centre, to, Vec3::new(0.3, -1.0, 0.5)))
                })
                .collect();
            let new = moved_as_they_are(&mesh, &motions).unwrap();
            let quality = new.quality();
            assert!(quality.min_dihedral > 8.0, "{quality:?}");
            assert!(quality.mean_quality > 0.8, "{quality:?}");
            assert!(quality.min_jacobian > 0.2, "{quality:?}");
        }
    }
}

/// Four of ten placements of bodies known by facets only, with gaps narrower than the facets, were
/// refused because a facet was not a face of the new tets.
#[test]
fn bug_facets_larger_than_their_gap_were_refused() {
    let shapes = collinear(&[-5.0, 0.0, 5.0]);
    let tets = generate(
        &bodies(&shapes, 0.7),
        &small_box(),
        &GenerateParams::default(),
    );
    let mesh = TetMesh::straight(tets.unwrap().mesh).unwrap();
    let width = 0.3;
    for (k, away) in [
        Vec3::x(),
        Vec3::new(0.6, 0.8, 0.0),
        Vec3::new(0.0, 0.48, -0.64),
    ]
    .into_iter()
    .enumerate()
    {
        let places = [-1.0, 0.0, 1.0].map(|side| side * (2.0 + width) * away.normalize());
        let motions: Vec<_> = (NAMES.into_iter().zip(places).zip([-5.0, 0.0, 5.0]))
            .map(|((name, to), x)| {
                let axis = Vec3::new(0.4, x, k as f64);
                (name, placed(Vec3::new(x, 0.0, 0.0), to, axis))
            })
            .collect();
        let moved = as_they_are(&motions);
        let new = remesh(&mesh, &moved, &GenerateParams::default(), &[]).unwrap();
        // Divided facets lie in the planes of the given ones.
        assert_same_volume(&new, &mesh);
        // The narrowest part of the gap, where facets lie opposite each other.
        let tag = new.tag("b").unwrap();
        let longest = (new.facets().iter())
            .filter(|facet| facet.tag == tag)
            .map(|facet| [0, 1, 2].map(|i| new.points()[facet.nodes[i] as usize]))
            .filter(|x| x.iter().any(|x| (x - away.normalize()).norm() < 0.25))
            .flat_map(|[a, b, c]| [a - b, b - c, c - a])
            .fold(0.0, |longest: f64, edge| longest.max(edge.norm()));
        // Between facets, the gap is wider than between the spheres by the rise of both: 0.12.
        assert!(longest < 1.5 * (width + 0.2), "{longest}");
        assert!(new.quality().mean_quality > 0.75, "{:?}", new.quality());
    }
}

/// The same motion gives a mesh of about as many cells, near the size of the old one.
#[test]
fn a_mesh_that_does_not_move_keeps_its_resolution() {
    let mesh = three_spheres(&ball(20.0));
    let motions: Vec<_> = NAMES[..3]
        .iter()
        .map(|&name| (name, Isometry3::identity()))
        .collect();
    let new = moved_as_they_are(&mesh, &motions).unwrap();
    let ratio = new.n_cells() as f64 / mesh.n_cells() as f64;
    assert!((0.7..1.5).contains(&ratio), "{ratio}");
}

#[test]
fn known_surfaces_are_triangulated_again_and_resolve_gaps() {
    let mesh = three_spheres(&ball(12.0));
    let shapes = collinear(&[-2.2, 0.0, 2.2]);
    let moved: Vec<MovedBody> = (NAMES.into_iter().zip(&shapes).zip([2.8, 0.0, -2.8]))
        .map(|((name, sphere), x)| MovedBody {
            name,
            motion: Isometry3::translation(x, 0.0, 0.0),
            surface: Some((sphere, 0.5)),
        })
        .collect();
    let surfaces = named(&shapes);
    let new = remesh(&mesh, &moved, &GenerateParams::default(), &surfaces).unwrap();
    let identity = Isometry3::identity();
    assert!(nodes_on(&new, "outer", &identity) == nodes_on(&mesh, "outer", &identity));
    let of: Vec<&dyn Surface> = shapes.iter().map(|s| s as &dyn Surface).collect();
    let ratio = new.gap_ratio(&of, None);
    assert!(ratio < 1.5, "{ratio}");
    assert!(new.quality().min_jacobian > 0.2);
    for (name, sphere) in &surfaces {
        let tag = new.tag(name).unwrap();
        for node in new.nodes_on(tag) {
            assert!(sphere.signed_distance(new.points()[node as usize]).abs() < 1e-14);
        }
    }
}

/// A sphere, an ellipsoid and a capsule in a ball, known by the nodes of a second-order file.
#[test]
fn bodies_of_a_second_order_file_keep_their_curved_facets() {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../mesh/tests/fixtures/mixed-bodies-order2-v41-binary.msh"
    );
    let mesh = MshFile::read(Path::new(file))
        .unwrap()
        .into_mesh(&[])
        .unwrap();
    let [left, right] = [Vec3::new(-6.0, 0.0, 0.0), Vec3::new(6.0, 0.0, 0.0)];
    let sphere = placed(left, left + Vec3::new(2.5, 0.5, 0.0), Vec3::zeros());
    let ellipsoid = placed(Vec3::zeros(), Vec3::zeros(), Vec3::new(0.0, 0.9, 0.4));
    let to = right + Vec3::new(-1.8, 1.0, 0.5);
    let capsule = placed(right, to, Vec3::new(0.5, 0.0, 1.2));
    let motions = [
        ("sphere", sphere),
        ("ellipsoid", ellipsoid),
        ("capsule", capsule),
    ];
    let new = moved_as_they_are(&mesh, &motions).unwrap();
    let (quality, of_file) = (new.quality(), mesh.quality());
    // The facets of the file bound the quality that is possible; its smallest angle is 7 degrees.
    assert!(
        quality.min_jacobian > 0.2 && quality.min_dihedral > 0.5 * of_file.min_dihedral,
        "{quality:?} {of_file:?}"
    );
}

#[test]
fn bodies_that_touch_and_unknown_bodies_are_errors() {
    let mesh = three_spheres(&ball(12.0));
    let shift = |name, x| (name, Isometry3::translation(x, 0.0, 0.0));
    let moved = |motions: &[(&str, Isometry3<f64>)]| moved_as_they_are(&mesh, motions);
    let touching = moved(&[shift("a", 3.1), shift("b", 0.0), shift("c", 0.0)]);
    assert_refused!(touching, GenerateError::BodiesTouch { .. });
    let outside = moved(&[shift("a", -6.5), shift("b", 0.0), shift("c", 0.0)]);
    assert_refused!(outside, GenerateError::BodyAtWall { .. });
    let unknown = moved(&[shift("d", 0.0)]);
    assert_refused!(unknown, GenerateError::Mesh(MeshError::UnknownTag { .. }));
    let twice = moved(&[shift("a", 0.0), shift("b", 0.0), shift("a", 0.0)]);
    assert_refused!(twice, GenerateError::Mesh(MeshError::BadTag { .. }));
    let nan = moved(&[shift("a", f64::NAN), shift("b", 0.0), shift("c", 0.0)]);
    assert_refused!(
        nan,
        GenerateError::BodiesTouch { .. } | GenerateError::BodyAtWall { .. }
    );
}

/// The command `gmsh` makes a mesh with all facets. Where it is not installed, the error says so.
#[test]
fn gmsh_keeps_all_facets() {
    let command = Path::new("gmsh");
    let mesh = three_spheres(&small_box());
    let motions = [-5.0, 0.0, 5.0].map(|x| {
        let centre = Vec3::new(x, 0.0, 0.0);
        placed(centre, 0.6 * centre, Vec3::new(0.3, -1.0, 0.5))
    });
    let motions: Vec<_> = NAMES.into_iter().zip(motions).collect();
    let moved = as_they_are(&motions);
    let is_installed = std::process::Command::new(command)
        .arg("--version")
        .output()
        .is_ok();
    let new = match remesh_by_gmsh(command, &mesh, &moved, &[]) {
        Err(error) if !is_installed => {
            println!("gmsh is not installed");
            let text = error.to_string();
            assert!(text.contains("there is no command gmsh"), "{text}");
            assert!(text.contains("install Gmsh"), "{text}");
            return;
        }
        new => new.unwrap(),
    };
    for (name, motion) in &motions {
        assert!(nodes_on(&new, name, &Isometry3::identity()) == nodes_on(&mesh, name, motion));
    }
    assert_same_volume(&new, &mesh);
}

/// A command that is missing, one that fails, and one that writes no mesh.
#[cfg(unix)]
#[test]
fn a_gmsh_that_makes_no_mesh_is_an_error() {
    let mesh = three_spheres(&ball(12.0));
    for (command, expected) in [
        ("/nowhere/gmsh", "there is no command /nowhere/gmsh"),
        ("/bin/false", "it wrote no mesh (exit status: 1)"),
        ("/bin/true", "it wrote no mesh (exit status: 0)"),
    ] {
        let error = remesh_by_gmsh(Path::new(command), &mesh, &[], &[]).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]

    /// Spheres at any places with gaps of 0.8 or more have a new mesh, the same for any number of
    /// threads.
    #[test]
    fn spheres_anywhere_are_meshed(places in places()) {
        let mesh = three_spheres(&ball(12.0));
        let motions: Vec<_> = (NAMES.into_iter().zip(places).zip([-5.0, 0.0, 5.0]))
            .map(|((name, to), x)| (name, Isometry3::translation(to.x - x, to.y, to.z)))
            .collect();
        let new = moved_as_they_are(&mesh, &motions).unwrap();
        prop_assert!(new.quality().min_jacobian > 0.1, "{:?}", new.quality());
        let serial = on_threads(1, || moved_as_they_are(&mesh, &motions)).unwrap();
        prop_assert!(serial == new);
    }
}

/// Places of three unit spheres in a ball of radius 12, 0.8 or more from each other and the wall.
fn places() -> impl Strategy<Value = [Vec3; 3]> {
    let place = prop::array::uniform3(-10.0..10.0).prop_map(Vec3::from);
    prop::array::uniform3(place).prop_filter("gaps", |places| {
        places
            .iter()
            .enumerate()
            .all(|(k, x)| x.norm() < 10.2 && places[..k].iter().all(|y| (x - y).norm() > 2.8))
    })
}
