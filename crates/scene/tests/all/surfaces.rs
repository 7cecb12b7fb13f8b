//! Bodies and domains whose surfaces are in files.

use std::path::Path;

use mesh::{Surface, SurfaceFormat, SurfaceMesh};
use nalgebra::{Isometry3, Vector3};
use scene::{Domain, FileShape, Scene, Shape, closest_contact};

/// A tetrahedron with corners at the origin and on the axes, in OBJ; its centroid is at 1/4 of
/// each.
const TETRAHEDRON: &str =
    "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

fn scene(folder: &Path, keys: &str) -> Result<Scene, scene::SceneError> {
    let path = folder.join("scene.toml");
    let text = format!(
        "domain = {{ kind = \"ball\", radius = 40 }}\n\
         bodies = [{{ name = \"a\", shape = \"surface\", surface_kind = \"faceted\", {keys} }}]"
    );
    std::fs::write(&path, text).unwrap();
    Scene::read(&path, &[])
}

#[test]
fn the_file_is_found_beside_the_scene_and_its_centroid_is_the_centre() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("part.obj"), TETRAHEDRON).unwrap();
    let scene = |keys: &str| scene(folder.path(), keys).unwrap_or_else(|e| panic!("{e}"));
    let read = scene("file = \"part.obj\", position = [5, 6, 7], scale = 0.5");
    let Shape::Surface(FileShape { shape, .. }) = &read.bodies()[0].shape else {
        panic!("not a surface");
    };
    assert!((shape.surface.volume() - 32.0 / 3.0 / 8.0).abs() < 1e-12);
    assert!(shape.surface.centroid().norm() < 1e-12);
    assert!((shape.centre.amax() - 1.0).abs() < 1e-12 && (shape.centre.amin() - 1.0).abs() < 1e-12);
    // The farthest corner, at (4, 0, 0) in the file.
    let farthest = 0.5 * (9.0_f64 + 1.0 + 1.0).sqrt();
    assert!((read.bodies()[0].bounding_radius() - farthest).abs() < 1e-12);
    // Keys are written out and read back.
    let text = read.to_toml().unwrap();
    assert!(
        text.contains("centre = [") && text.contains("surface_kind = \"faceted\""),
        "{text}"
    );
    assert_eq!(Scene::parse(&text).unwrap().bodies(), read.bodies());

    let at_origin = scene("file = \"part.obj\", position = [5, 6, 7], centre = [0, 0, 0]");
    let Shape::Surface(FileShape { shape, .. }) = &at_origin.bodies()[0].shape else {
        panic!("not a surface");
    };
    assert!((shape.surface.centroid().x - 1.0).abs() < 1e-12);
    assert!((at_origin.bodies()[0].bounding_radius() - 4.0).abs() < 1e-12);
}

#[test]
fn a_bad_surface_is_refused_with_its_triangle_and_the_line_of_its_key() {
    let folder = tempfile::tempdir().unwrap();
    let open = TETRAHEDRON.replace("f 2 3 4\n", "");
    std::fs::write(folder.path().join("open.obj"), open).unwrap();
    let error = scene(folder.path(), "file = \"open.obj\", position = [0, 0, 0]").unwrap_err();
    let text = error.to_string();
    for part in [
        "scene.toml:2: bodies[0].file is refused",
        "open.obj: triangle 1 near (2.000000, 2.000000, 0.000000)",
        "close the hole",
    ] {
        assert!(text.contains(part), "{text}");
    }
    assert!(!text.contains('\n'), "{text}");
}

/// Gaps between surfaces are those of their convex hulls, gaps to a domain from a file those of the
/// closest points.
#[test]
fn gaps_of_surfaces() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("part.obj"), TETRAHEDRON).unwrap();
    let cube = SurfaceMesh::parse(
        "cube",
        b"v -9 -9 -9\nv 9 -9 -9\nv 9 9 -9\nv -9 9 -9\nv -9 -9 9\nv 9 -9 9\nv 9 9 9\nv -9 9 9\n\
          f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 1 5 8 4\n",
        SurfaceFormat::Obj,
    );
    std::fs::write(folder.path().join("cube.stl"), cube.unwrap().to_stl()).unwrap();
    let path = folder.path().join("scene.toml");
    let read = |x: f64| {
        let text = format!(
            "domain = {{ kind = \"surface\", file = \"cube.stl\", surface_kind = \"faceted\" }}\n\
             bodies = [\n\
             {{ name = \"part\", shape = \"surface\", file = \"part.obj\", centre = [0, 0, 0], \
             surface_kind = \"faceted\", position = [{x}, -2, -2] }},\n\
             {{ name = \"ball\", radius = 1, position = [{}, -1, -1] }}]",
            x - 1.5
        );
        std::fs::write(&path, text).unwrap();
        Scene::read(&path, &[])
    };
    let scene = read(0.0).unwrap_or_else(|error| panic!("{error}"));
    assert!(matches!(scene.domain(), Domain::Surface(_)));
    let poses = (scene.articulation())
        .place(&scene.initial_state(), &[])
        .unwrap();
    let contact = closest_contact(scene.bodies(), scene.domain(), &poses).unwrap();
    // From the ball to the face x = 0 of the part.
    assert!((contact.gap - 0.5).abs() < 1e-8, "{contact:?}");
    let to_wall = scene.domain().clearance(&scene.bodies()[0], &poses[0]);
    // The corner (4, 0, 0) is 5 away from the wall x = 9, the face x = 0 is 9 away from the other.
    assert!((to_wall - 5.0).abs() < 1e-9, "{to_wall}");
    let error = read(5.5).unwrap_err().to_string();
    assert!(error.contains("'part' is outside the domain"), "{error}");

    // A scene that is written into another folder names the files from there.
    let below = folder.path().join("out/best");
    std::fs::create_dir_all(&below).unwrap();
    let text = scene.to_toml_in(&below).unwrap();
    assert!(
        text.contains("\"../../cube.stl\"") && text.contains("\"../../part.obj\""),
        "{text}"
    );
    std::fs::write(below.join("scene.toml"), text).unwrap();
    let again = Scene::read(below.join("scene.toml"), &[]).unwrap();
    let Domain::Surface(wall) = again.domain() else {
        panic!("the wall is a surface");
    };
    let same = std::fs::canonicalize(folder.path().join("cube.stl")).unwrap();
    assert_eq!(std::fs::canonicalize(&wall.file).unwrap(), same);
}

#[test]
fn a_self_touching_helix_is_refused_with_the_largest_radius_of_its_tube() {
    let helix = |tube: f64, pitch: f64| {
        let text = format!(
            "bodies = [{{ name = \"a\", shape = \"helix\", radius = 1, tube_radius = {tube}, \
             pitch = {pitch}, turns = 3, position = [0, 0, 0] }}]"
        );
        Scene::parse(&text)
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    // Turns of a small pitch are next to each other, at less than the pitch because they are
    // inclined; a steep tube would reach its centre of curvature.
    assert_eq!(helix(0.2, 0.5), Ok(()));
    for (tube, pitch) in [(0.25, 0.5), (0.5, 0.5), (1.7, 5.0)] {
        let message = helix(tube, pitch).unwrap_err();
        let start = "scene.toml:1: bodies[0].tube_radius must be below ";
        assert!(message.starts_with(start), "{message}");
        let limit = message[start.len()..].split(',').next().unwrap();
        let limit: f64 = limit.parse().unwrap();
        assert!(
            limit < tube && helix(0.999 * limit, pitch).is_ok(),
            "{message}"
        );
    }
}

/// The loop that "did not meet" was none, and the message had no place.
#[test]
fn a_linked_body_at_1e9_is_refused_with_its_place() {
    let linked = |x: f64, joint: &str| {
        Scene::parse(&format!(
            "bodies = [{{ name = \"a\", radius = 1, position = [1, 2, 3] }},\n\
             {{ name = \"b\", radius = 1, position = [{x}, {x}, {x}] }}]\n\
             links = [{{ name = \"l\", body = \"b\", to = \"a\", joint = \"{joint}\", {} }}]",
            if joint == "hinge" {
                "axis = [0, 1, 1]"
            } else {
                ""
            }
        ))
    };
    for joint in ["slide", "hinge", "ball", "rotor"] {
        assert!(linked(5.7e7, joint).is_ok());
        let message = linked(5e8, joint).unwrap_err().to_string();
        let start = "scene.toml:2: bodies[1].position is too far from 'a'";
        assert!(message.starts_with(start), "{message}");
    }
}

/// A binary STL file has seven digits, of which three are those of the distance here.
#[test]
fn a_surface_far_from_its_origin_in_single_precision_is_a_warning_with_the_lost_digits() {
    let folder = tempfile::tempdir().unwrap();
    let mut part = SurfaceMesh::parse("part", TETRAHEDRON.as_bytes(), SurfaceFormat::Obj).unwrap();
    let warnings = |part: &SurfaceMesh| {
        std::fs::write(folder.path().join("part.stl"), part.to_stl()).unwrap();
        let scene = scene(folder.path(), "file = \"part.stl\", position = [0, 0, 0]").unwrap();
        scene.warnings().to_vec()
    };
    assert_eq!(warnings(&part), [""; 0]);
    part.points.iter_mut().for_each(|x| x.y += 4000.0);
    let found = warnings(&part);
    assert_eq!(found.len(), 1);
    // 4004 / 4, and 2^-24 of it.
    for words in ["part.stl: ", "3 of 7 digits", "6.0e-5 of its width"] {
        assert!(found[0].contains(words), "{found:?}");
    }
}

/// The distance from a wall was measured to the opposite side of the body: a sixth of it here.
#[test]
fn bug_clearance_of_bodies_without_symmetry_was_that_of_their_other_side() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("part.obj"), TETRAHEDRON).unwrap();
    let scene = scene(folder.path(), "file = \"part.obj\", position = [0, 0, 0]").unwrap();
    let body = &scene.bodies()[0];
    // From its centroid the body reaches from -1 to 3 along each axis.
    let size = Vector3::new(20.0, 30.0, 40.0);
    for (domain, position, exact) in [
        (Domain::Wall, [0.0, 0.0, 1.5], 0.5),
        (Domain::Box { size }, [6.0, 0.0, 0.0], 1.0),
        (Domain::Box { size }, [-6.0, 0.0, 0.0], 3.0),
        (Domain::Box { size }, [0.0, 0.0, -19.5], -0.5),
    ] {
        let [x, y, z] = position;
        let found = domain.clearance(body, &Isometry3::translation(x, y, z));
        assert!(
            (found - exact).abs() < 1e-12,
            "{position:?}: {found} {exact}"
        );
    }
}
