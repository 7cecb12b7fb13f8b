//! The same surface in files of all formats.

use super::shapes::grid_ellipsoid;
use super::smooth;
use mesh::{Surface, SurfaceFormat, SurfaceMesh, Vec3};
use std::fmt::Write as _;

fn ascii_stl(mesh: &SurfaceMesh) -> String {
    let mut text = "solid part\n".to_owned();
    for triangle in &mesh.triangles {
        text += "  facet normal 0 0 0\n    outer loop\n";
        for v in triangle {
            let x = mesh.points[*v as usize];
            writeln!(text, "      vertex {:e} {:e} {:e}", x.x, x.y, x.z).unwrap();
        }
        text += "    endloop\n  endfacet\n";
    }
    text + "endsolid part\n"
}

fn obj(mesh: &SurfaceMesh) -> String {
    let mut text = "# a surface\no part\n".to_owned();
    for x in &mesh.points {
        writeln!(text, "v {} {} {}", x.x, x.y, x.z).unwrap();
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(text, "f {}//1 {}//1 {}//1", a + 1, b + 1, c + 1).unwrap();
    }
    text
}

fn msh(mesh: &SurfaceMesh) -> String {
    let mut text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n",
        mesh.points.len()
    );
    for (k, x) in mesh.points.iter().enumerate() {
        writeln!(text, "{} {} {} {}", k + 1, x.x, x.y, x.z).unwrap();
    }
    write!(text, "$EndNodes\n$Elements\n{}\n", mesh.triangles.len()).unwrap();
    for (k, [a, b, c]) in mesh.triangles.iter().enumerate() {
        writeln!(text, "{} 2 2 1 1 {} {} {}", k + 1, a + 1, b + 1, c + 1).unwrap();
    }
    text + "$EndElements\n"
}

#[test]
fn all_formats_give_the_same_surface() {
    let mesh = grid_ellipsoid(Vec3::new(2.0, 1.0, 0.5), 16);
    let expected = smooth(mesh.clone());
    let files = [
        (ascii_stl(&mesh).into_bytes(), SurfaceFormat::Stl, 0.0),
        // Single precision.
        (mesh.to_stl(), SurfaceFormat::Stl, 1e-6),
        (obj(&mesh).into_bytes(), SurfaceFormat::Obj, 0.0),
        (msh(&mesh).into_bytes(), SurfaceFormat::Msh, 0.0),
    ];
    for (bytes, format, tolerance) in files {
        let read = SurfaceMesh::parse("part", &bytes, format).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(read.points.len(), mesh.points.len());
        assert_eq!(read.triangles.len(), mesh.triangles.len());
        let error = smooth(read).volume() / expected.volume() - 1.0;
        assert!(error.abs() <= tolerance + 1e-13, "{format:?} {error}");
    }
}

/// Corners that differ in the last digit of single precision are one vertex.
#[test]
fn corners_of_stl_files_are_joined_within_their_rounding() {
    let mesh = grid_ellipsoid(Vec3::new(2.0, 1.0, 0.5), 16);
    let mut text = String::from("solid part\n");
    for (k, triangle) in mesh.triangles.iter().enumerate() {
        text += "facet normal 0 0 0\nouter loop\n";
        for v in triangle {
            let shift = if k % 2 == 0 { 4e-7 } else { -4e-7 };
            let x = mesh.points[*v as usize].map(|c| c + shift);
            writeln!(text, "vertex {} {} {}", x.x, x.y, x.z).unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    let read = SurfaceMesh::parse("part.stl", text.as_bytes(), SurfaceFormat::Stl).unwrap();
    assert_eq!(read.points.len(), mesh.points.len());
    smooth(read);
}

/// Quadrangles of OBJ files are divided; vertices may be counted from the last one.
#[test]
fn an_obj_cube_of_quadrangles() {
    let text = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
                f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf -5 -8 -4 -1\n";
    let mesh = SurfaceMesh::parse("cube.obj", text.as_bytes(), SurfaceFormat::Obj).unwrap();
    assert_eq!(mesh.triangles.len(), 12);
    assert!((smooth(mesh).volume() - 8.0).abs() < 1e-12);
}
