//! STL files, text and binary.
//!
//! The reader is our own because stl_io (0.11) reads numbers of text in single precision, takes
//! every file that begins with `solid ` for text, and gives neither line nor offset of an error.

use super::{malformed, number, text};
use crate::{FileLocation, MeshError, SurfaceMesh, Vec3};
use std::collections::HashMap;

/// Bytes before the triangles of a binary file: a comment and the number of triangles.
const HEADER: usize = 84;

/// Bytes of a binary triangle: twelve numbers in single precision and an attribute.
const TRIANGLE: usize = 50;

/// The number of triangles that a binary file announces at its beginning.
fn announced(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(80..HEADER)?.try_into().ok()?;
    Some(u64::from(u32::from_le_bytes(count)))
}

/// Whether a file has binary numbers, which are in single precision.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    // Its length decides, because binary files may begin with the word "solid" too.
    let length = |count: u64| HEADER as u64 + TRIANGLE as u64 * count;
    announced(bytes).is_some_and(|count| bytes.len() as u64 == length(count))
}

/// Reads a file; normals in the file are ignored, the order of the corners decides.
pub(super) fn parse(name: &str, bytes: &[u8]) -> Result<SurfaceMesh, MeshError> {
    let corners = match announced(bytes) {
        _ if is_binary(bytes) => binary(name, bytes)?,
        _ if bytes.trim_ascii_start().starts_with(b"solid") => ascii(name, bytes)?,
        Some(count) => {
            let problem = format!(
                "not an STL file: it neither begins with 'solid' nor has the length of the {count} \
                 triangles that a binary file announces here; save it again"
            );
            return Err(malformed(name, FileLocation::Byte(80), problem));
        }
        None => {
            let problem = "not an STL file: it does not begin with 'solid' and is too short to be \
                           binary";
            return Err(malformed(name, FileLocation::Byte(0), problem));
        }
    };
    Ok(weld(&corners))
}

impl SurfaceMesh {
    /// The triangles as a binary STL file, in single precision.
    pub fn to_stl(&self) -> Vec<u8> {
        let mut bytes = vec![b' '; HEADER - 4];
        bytes.extend((self.triangles.len() as u32).to_le_bytes());
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|v| self.points[v as usize]);
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0);
            for x in [normal.unwrap_or_default(), a, b, c] {
                bytes.extend(x.iter().flat_map(|c| (*c as f32).to_le_bytes()));
            }
            bytes.extend([0, 0]);
        }
        bytes
    }
}

fn binary(name: &str, bytes: &[u8]) -> Result<Vec<[Vec3; 3]>, MeshError> {
    let triangles = bytes[HEADER..].chunks_exact(TRIANGLE).enumerate();
    triangles
        .map(|(k, triangle)| {
            let mut corners = [Vec3::zeros(); 3];
            for (i, word) in triangle[12..48].chunks_exact(4).enumerate() {
                let value = f32::from_le_bytes([word[0], word[1], word[2], word[3]]);
                if !value.is_finite() {
                    let location = FileLocation::Byte(HEADER + TRIANGLE * k + 12 + 4 * i);
                    let problem = format!("a coordinate of triangle {} is not finite", k + 1);
                    return Err(malformed(name, location, problem));
                }
                corners[i / 3][i % 3] = f64::from(value);
            }
            Ok(corners)
        })
        .collect()
}

fn ascii(name: &str, bytes: &[u8]) -> Result<Vec<[Vec3; 3]>, MeshError> {
    let mut triangles = Vec::new();
    let mut corners: Vec<Vec3> = Vec::new();
    let mut is_in_facet = false;
    let mut last = 1;
    for (line, content) in text(name, bytes, "an STL file in text")?
        .lines()
        .enumerate()
    {
        last = line + 1;
        let error = |problem: String| malformed(name, FileLocation::Line(line + 1), problem);
        let mut words = content.split_whitespace();
        let Some(keyword) = words.next() else {
            continue;
        };
        match keyword.to_ascii_lowercase().as_str() {
            "facet" if is_in_facet => {
                return Err(error("a facet begins before the last one ended".to_owned()));
            }
            "facet" => is_in_facet = true,
            "vertex" if !is_in_facet => {
                return Err(error("a vertex outside of a facet".to_owned()));
            }
            "vertex" => {
                let mut next = || number(words.next()).map_err(error);
                corners.push(Vec3::new(next()?, next()?, next()?));
            }
            "endfacet" => match corners[..] {
                [a, b, c] => {
                    triangles.push([a, b, c]);
                    corners.clear();
                    is_in_facet = false;
                }
                _ => {
                    let count = corners.len();
                    return Err(error(format!("a facet with {count} corners instead of 3")));
                }
            },
            "solid" | "outer" | "endloop" | "endsolid" => {}
            other => {
                let other: String = other.chars().take(40).collect();
                return Err(error(format!("'{other}' is no word of an STL file")));
            }
        }
    }
    if is_in_facet {
        let problem = "the file ends in the middle of a facet; save it again";
        return Err(malformed(name, FileLocation::Line(last), problem));
    }
    Ok(triangles)
}

/// Largest distance of corners that are one vertex, as a fraction of the extent of the surface.
///
/// Coordinates in single precision are rounded to 6e-8 of their size, and text files often have
/// six or seven digits.
const TOLERANCE: f64 = 1e-6;

/// Joins corners at nearly the same position; the first one of them is the vertex.
fn weld(corners: &[[Vec3; 3]]) -> SurfaceMesh {
    let all = || corners.iter().flatten();
    let start = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
    let [min, max] = all().fold(start, |[min, max], x| [min.inf(x), max.sup(x)]);
    let tolerance = TOLERANCE * (max - min).amax().max(f64::MIN_POSITIVE);
    let cell = |x: &Vec3| [0, 1, 2].map(|k| ((x[k] - min[k]) / tolerance).floor() as i64);
    let mut mesh = SurfaceMesh::default();
    let mut exact: HashMap<[u64; 3], u32> = HashMap::new();
    let mut vertices: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    for triangle in corners {
        mesh.triangles.push(triangle.map(|x| {
            // Adding zero makes the two zeros equal.
            let bits = [0, 1, 2].map(|k| (x[k] + 0.0).to_bits());
            *exact.entry(bits).or_insert_with(|| {
                let [i, j, k] = cell(&x);
                let around = (-1..=1).flat_map(|di| {
                    (-1..=1).flat_map(move |dj| (-1..=1).map(move |dk| [i + di, j + dj, k + dk]))
                });
                let near = around.filter_map(|cell| vertices.get(&cell)).flatten();
                let close = |v: &&u32| (mesh.points[**v as usize] - x).norm() <= tolerance;
                let found = near.copied().collect::<Vec<u32>>();
                if let Some(vertex) = found.iter().find(close) {
                    return *vertex;
                }
                let vertex = mesh.points.len() as u32;
                mesh.points.push(x);
                vertices.entry([i, j, k]).or_default().push(vertex);
                vertex
            })
        }));
    }
    mesh
}
