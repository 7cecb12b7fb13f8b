//! Wavefront OBJ files.

use super::{malformed, number, text};
use crate::{FileLocation, MeshError, SurfaceMesh, Vec3};

/// Reads the vertices and faces of a file; normals, textures, groups and materials are ignored.
pub(super) fn parse(name: &str, bytes: &[u8]) -> Result<SurfaceMesh, MeshError> {
    let mut mesh = SurfaceMesh::default();
    let mut face = Vec::new();
    for (line, content) in text(name, bytes, "an OBJ file")?.lines().enumerate() {
        let error = |problem: String| malformed(name, FileLocation::Line(line + 1), problem);
        let mut words = content.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut next = || number(words.next()).map_err(error);
                mesh.points.push(Vec3::new(next()?, next()?, next()?));
            }
            Some("f") => {
                face.clear();
                for word in words {
                    face.push(vertex(word, mesh.points.len()).map_err(error)?);
                }
                if face.len() < 3 {
                    let count = face.len();
                    return Err(error(format!(
                        "a face with {count} corners; at least 3 are needed"
                    )));
                }
                let fan = face.windows(2).skip(1);
                mesh.triangles
                    .extend(fan.map(|pair| [face[0], pair[0], pair[1]]));
            }
            Some("vn" | "vt" | "g" | "o" | "s" | "l" | "p" | "usemtl" | "mtllib") | None => {}
            Some(word) if word.starts_with('#') => {}
            Some(other) => {
                let other: String = other.chars().take(40).collect();
                return Err(error(format!(
                    "'{other}' cannot be used; save the surface as triangles"
                )));
            }
        }
    }
    Ok(mesh)
}

/// Number of the vertex in a word such as `7`, `7/2/3` or `-1`, which counts from the last one.
fn vertex(word: &str, count: usize) -> Result<u32, String> {
    let brief: String = word.chars().take(40).collect();
    let number: i64 = (word.split('/').next().and_then(|n| n.parse().ok()))
        .ok_or_else(|| format!("'{brief}' is not the number of a vertex"))?;
    let index = match number {
        1.. => number - 1,
        _ => count as i64 + number,
    };
    if number == 0 || index < 0 || index >= count as i64 {
        return Err(format!(
            "the face has vertex {brief}, but {count} vertices come before it"
        ));
    }
    u32::try_from(index).map_err(|_| format!("vertex {brief} is beyond the limit of 2^32"))
}
