//! Surfaces that are refused, each with the place.

use super::shapes::grid_box;
use mesh::{FileLocation, MeshError, SurfaceFormat, SurfaceMesh, Vec3};
use mesher::{GenerateError, TriangleKind, TriangulatedSurface};
use proptest::prelude::*;

/// Asserts that a file is refused at a line or byte with a part of the message.
#[track_caller]
fn refused(bytes: &[u8], format: SurfaceFormat, place: FileLocation, message: &str) {
    match SurfaceMesh::parse("part", bytes, format) {
        Err(MeshError::Malformed {
            location, problem, ..
        }) => {
            assert!(problem.contains(message), "{problem}");
            assert_eq!(location, place, "{problem}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn malformed_stl_files() {
    use FileLocation::{Byte, Line};
    let check = |text: &str, line: usize, message: &str| {
        refused(text.as_bytes(), SurfaceFormat::Stl, Line(line), message);
    };
    let binary = |bytes: &[u8], place: usize, message: &str| {
        refused(bytes, SurfaceFormat::Stl, Byte(place), message);
    };
    binary(b"", 0, "too short to be binary");
    binary(b"ply\nformat ascii", 0, "does not begin with 'solid'");
    check("solid part\nendsolid\n", 1, "no triangles");
    let facet = "solid part\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n";
    check(facet, 5, "ends in the middle of a facet");
    for (rest, line, message) in [
        ("endloop\nendfacet\n", 7, "a facet with 2 corners"),
        ("vertex 0 1\n", 6, "a coordinate is missing"),
        ("vertex 0 1 zero\n", 6, "'zero' is not a number"),
        ("vertex 0 1 nan\n", 6, "'nan' is not finite"),
        ("vertex 0 1e999 0\n", 6, "'1e999' is not finite"),
        ("facet normal 0 0 1\n", 6, "before the last one ended"),
    ] {
        check(&format!("{facet}{rest}"), line, message);
    }
    let outside = "a vertex outside of a facet";
    check("solid part\nvertex 0 0 0\n", 2, outside);
    let face = "'face' is no word of an STL file";
    check("solid part\nface 1 2 3\n", 2, face);
    let four = format!("{facet}vertex 0 1 0\nvertex 0 1 1\nendloop\nendfacet\n");
    check(&four, 9, "a facet with 4 corners");
    let cube = grid_box(Vec3::repeat(1.0), 1).to_stl();
    binary(&cube[..600], 80, "the length of the 12 triangles");
    let mut bytes = cube;
    let place = 84 + 50 + 12 + 4;
    bytes[place..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    binary(&bytes, place, "a coordinate of triangle 2 is not finite");
    binary(b"solid \xff\xfe\nfacet", 6, "not an STL file in text");
}

#[test]
fn malformed_obj_and_gmsh_files() {
    use FileLocation::Line;
    let check = |text: &str, line: usize, message: &str| {
        refused(text.as_bytes(), SurfaceFormat::Obj, Line(line), message);
    };
    check("", 1, "no triangles");
    check("v 0 0 0\nv 1 0 0\nf 1 2\n", 3, "a face with 2 corners");
    check(
        "v 0 0 0\nv 1 0 0\nf 1 2 3\n",
        3,
        "the face has vertex 3, but 2 vertices",
    );
    check("v 0 0 0\nf 0 1 1\n", 2, "the face has vertex 0");
    check("v 0 0 0\nf -2 1 1\n", 2, "the face has vertex -2");
    check("v 0 0 0\nf a b c\n", 2, "'a' is not the number of a vertex");
    check("v 0 0\n", 1, "a coordinate is missing");
    check("v 0 0 inf\n", 1, "not finite");
    check("v 0 0 0\ncurv 0 1 1 2\n", 2, "'curv' cannot be used");
    let msh = |text: &str, line: usize, message: &str| {
        refused(text.as_bytes(), SurfaceFormat::Msh, Line(line), message);
    };
    msh("hello", 1, "expected a section");
    let head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
    msh(head, 1, "no triangles");
    let nodes = "$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n1\n1 3 2 1 1 1 1 1 1\n$EndElements\n";
    msh(&format!("{head}{nodes}"), 10, "quadrangles");
    for name in ["part.ply", "part", "part.step"] {
        let error = SurfaceMesh::read(name).unwrap_err().to_string();
        assert!(error.contains("use .stl, .obj or .msh"), "{error}");
    }
    let error = SurfaceMesh::read("no/such.stl").unwrap_err();
    assert!(matches!(error, MeshError::Io { .. }), "{error}");
}

/// Asserts that a surface is refused with a part of the message, at the triangle with this number,
/// counted from one, if it is given.
#[track_caller]
fn not_a_surface(mesh: SurfaceMesh, number: impl Into<Option<usize>>, message: &str) {
    match TriangulatedSurface::new("part", mesh, TriangleKind::Smooth) {
        Err(GenerateError::BadSurface {
            surface,
            triangle,
            problem,
            ..
        }) => {
            assert_eq!(surface, "part");
            assert!(problem.contains(message), "{problem}");
            if let Some(number) = number.into() {
                assert_eq!(triangle, number, "{problem}");
            }
        }
        other => panic!("{other:?}"),
    }
}

fn cube() -> SurfaceMesh {
    grid_box(Vec3::repeat(1.0), 2)
}

/// A second surface beside the first one.
fn with(mut mesh: SurfaceMesh, other: &SurfaceMesh) -> SurfaceMesh {
    let first = mesh.points.len() as u32;
    mesh.points.extend(&other.points);
    let triangles = other.triangles.iter().map(|t| t.map(|v| v + first));
    mesh.triangles.extend(triangles);
    mesh
}

#[test]
fn triangles_that_are_no_closed_surface() {
    let changed = |change: &dyn Fn(&mut SurfaceMesh)| {
        let mut mesh = cube();
        change(&mut mesh);
        mesh
    };
    let open = changed(&|m| {
        m.triangles.remove(7);
    });
    not_a_surface(open, 3, "the surface is open there");
    let twice = changed(&|m| m.triangles.push(m.triangles[4]));
    not_a_surface(twice, 49, "shares an edge with 2 others");
    let turned = changed(&|m| m.triangles[9].swap(0, 1));
    not_a_surface(turned, 10, "is oriented against triangle");
    let inside_out = changed(&|m| m.triangles.iter_mut().for_each(|t| t.swap(0, 1)));
    not_a_surface(inside_out, 1, "inside out");
    let repeated = changed(&|m| m.triangles[5][1] = m.triangles[5][0]);
    not_a_surface(repeated, 6, "degenerate");
    let beyond = changed(&|m| m.triangles[3][2] = 1000);
    not_a_surface(beyond, 4, "a vertex beyond the 26");
    let not_finite = changed(&|m| m.points[0].y = f64::NAN);
    not_a_surface(not_finite, 1, "not finite");
    // A wall inside, from edge to edge.
    let walled = changed(&|m| {
        let find = |x: Vec3| m.points.iter().position(|p| *p == x).unwrap() as u32;
        let [a, b, c] = [
            Vec3::new(-1.0, -1.0, -1.0),
            Vec3::new(0.0, -1.0, -1.0),
            Vec3::new(1.0, 1.0, 1.0),
        ]
        .map(find);
        m.triangles.push([a, b, c]);
    });
    not_a_surface(walled, 49, "shares an edge with 2 others");
    // A bar bent into a circle and beyond.
    let mut bent = grid_box(Vec3::new(1.2 * std::f64::consts::PI, 0.25, 0.25), 16);
    for x in &mut bent.points {
        let (sin, cos) = x.x.sin_cos();
        *x = Vec3::new((2.0 - x.y) * cos, (2.0 - x.y) * sin, x.z + 0.05 * x.x);
    }
    not_a_surface(bent, None, "passes through itself");
    // A vertex moved through the opposite face.
    let pierced = changed(&|m| {
        let top = m.points.iter().position(|p| *p == Vec3::z()).unwrap();
        m.points[top] = Vec3::new(0.1, 0.2, -1.5);
    });
    not_a_surface(pierced, None, "is folded onto triangle");
    let two = |shift: Vec3| {
        let shifted = changed(&|m| m.points.iter_mut().for_each(|x| *x += shift));
        with(cube(), &shifted)
    };
    for shift in [5.0 * Vec3::x(), Vec3::new(1.1, 0.3, 0.2)] {
        not_a_surface(two(shift), 49, "several parts");
    }
    // Two cubes with one corner in common.
    let mut both = two(Vec3::repeat(2.0));
    let [own, other] = [0, 26].map(|first| {
        let at = both.points[first..]
            .iter()
            .position(|x| *x == Vec3::repeat(1.0));
        (first + at.unwrap()) as u32
    });
    for v in both.triangles.iter_mut().flatten().filter(|v| **v == other) {
        *v = own;
    }
    let first = both
        .triangles
        .iter()
        .position(|t| t.contains(&own))
        .unwrap();
    not_a_surface(both, first + 1, "in one vertex only");
    not_a_surface(SurfaceMesh::default(), 1, "no triangles");
}

#[test]
fn surfaces_that_cannot_be_meshed() {
    let thin = grid_box(Vec3::new(1.0, 1.0, 5e-4), 1);
    let error = TriangulatedSurface::new("part", thin, TriangleKind::Smooth).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("tiny feature: half the thickness") || text.contains("5.0"),
        "{text}"
    );
    // A wedge of 20 degrees.
    let wedge = SurfaceMesh {
        points: vec![
            Vec3::zeros(),
            Vec3::new(0.0, 1.0, 0.0),
            Vec3::new(1.0, 0.5, 0.18),
            Vec3::new(1.0, 0.5, -0.18),
        ],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..SurfaceMesh::default()
    };
    not_a_surface(wedge, 1, "sharper than 30 degrees");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Damaged files and surfaces are refused or read, but never a panic.
    #[test]
    fn damaged_surfaces_do_not_panic(
        changes in prop::collection::vec((0usize..2000, any::<u8>()), 1..4),
        moves in prop::collection::vec((0usize..26, -2.0f64..2.0), 0..3),
    ) {
        let mut mesh = cube();
        for (v, shift) in moves {
            mesh.points[v].x += shift;
        }
        let mut bytes = mesh.to_stl();
        let length = bytes.len();
        for (at, value) in changes {
            bytes[at % length] = value;
        }
        for format in [SurfaceFormat::Stl, SurfaceFormat::Obj, SurfaceFormat::Msh] {
            if let Ok(mesh) = SurfaceMesh::parse("damaged", &bytes, format) {
                let _ = TriangulatedSurface::new("damaged", mesh, TriangleKind::Smooth);
            }
        }
    }
}
