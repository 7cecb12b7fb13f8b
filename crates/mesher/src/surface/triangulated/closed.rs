//! Checks that triangles are one closed, oriented surface around a solid.

use crate::surface::triangles;
use std::collections::HashMap;

use super::Defect;
use mesh::{SurfaceMesh, Vec3};

/// Smallest height of a triangle relative to its longest edge; flatter ones have no normal in
/// single precision.
const MIN_RELATIVE_HEIGHT: f64 = 1e-6;

/// Largest number of triangles.
const MAX_TRIANGLES: usize = 2_000_000;

/// Checks every triangle and edge, then every vertex, then the whole.
///
/// Returns the neighbours of each triangle across the edges opposite its vertices.
pub(super) fn neighbours_of_closed(mesh: &SurfaceMesh) -> Result<Vec<[u32; 3]>, Defect> {
    if mesh.triangles.len() > MAX_TRIANGLES {
        let problem = format!(
            "is one of {}, more than {MAX_TRIANGLES}; simplify the surface",
            mesh.triangles.len()
        );
        return Err(Defect::new(MAX_TRIANGLES, Vec3::zeros(), problem));
    }
    if mesh.triangles.is_empty() {
        return Err(Defect::new(
            0,
            Vec3::zeros(),
            "is missing: there are no triangles",
        ));
    }
    check_triangles(mesh)?;
    let neighbours = match_edges(mesh)?;
    check_vertices(mesh, &neighbours)?;
    check_connected(mesh, &neighbours)?;
    let volume: f64 = triangles::corners(mesh)
        .map(|[a, b, c]| a.dot(&b.cross(&c)))
        .sum();
    if volume > 0.0 {
        return Ok(neighbours);
    }
    let problem = "faces inwards like all others: the surface is inside out; reverse the triangles";
    Err(Defect::in_middle(mesh, 0, problem))
}

fn check_triangles(mesh: &SurfaceMesh) -> Result<(), Defect> {
    if let Some(v) = (mesh.points.iter()).position(|x| !x.iter().all(|c| c.is_finite())) {
        let has = |t: &[u32; 3]| t.contains(&(v as u32));
        if let Some(t) = mesh.triangles.iter().position(has) {
            let problem = "has a vertex that is not finite; save the file again";
            return Err(Defect::new(t, mesh.points[v], problem));
        }
    }
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let known = |v: &u32| (*v as usize) < mesh.points.len();
        if !triangle.iter().all(known) {
            let problem = format!(
                "has a vertex beyond the {} of the surface",
                mesh.points.len()
            );
            return Err(Defect::new(t, Vec3::zeros(), problem));
        }
        let [a, b, c] = triangle.map(|v| mesh.points[v as usize]);
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let height = (b - a).cross(&(c - a)).norm() / longest;
        if height.is_nan() || height <= MIN_RELATIVE_HEIGHT * longest {
            let problem = "is degenerate: its corners are on one line; remove it and join its \
                           neighbours";
            return Err(Defect::in_middle(mesh, t, problem));
        }
    }
    Ok(())
}

/// Matches each directed edge with its reverse.
fn match_edges(mesh: &SurfaceMesh) -> Result<Vec<[u32; 3]>, Defect> {
    let mut left: HashMap<[u32; 2], u32> = HashMap::with_capacity(3 * mesh.triangles.len());
    let middle = |[a, b]: [u32; 2]| 0.5 * (mesh.points[a as usize] + mesh.points[b as usize]);
    let edge = |t: usize, i: usize| {
        let triangle = mesh.triangles[t];
        [triangle[(i + 1) % 3], triangle[(i + 2) % 3]]
    };
    let all = || (0..mesh.triangles.len()).flat_map(|t| [0, 1, 2].map(|i| (t, i)));
    for (t, i) in all() {
        let own = edge(t, i);
        let Some(other) = left.insert(own, t as u32) else {
            continue;
        };
        let users = all().filter(|&(t, i)| edge(t, i) == own || edge(t, i) == [own[1], own[0]]);
        let problem = match users.count() {
            2 => format!(
                "is oriented against triangle {} at their common edge; orient all triangles \
                 outwards",
                other + 1
            ),
            count => format!(
                "shares an edge with {} others, but a surface has two triangles at each edge; \
                 remove inner walls and duplicates",
                count - 1
            ),
        };
        return Err(Defect::new(t, middle(own), problem));
    }
    let mut neighbours = vec![[0; 3]; mesh.triangles.len()];
    for (t, i) in all() {
        let [a, b] = edge(t, i);
        match left.get(&[b, a]) {
            Some(other) => neighbours[t][i] = *other,
            None => {
                let problem = "has an edge without a neighbour: the surface is open there; close \
                               the hole";
                return Err(Defect::new(t, middle([a, b]), problem));
            }
        }
    }
    Ok(neighbours)
}

/// Checks that the triangles at every vertex are one fan.
fn check_vertices(mesh: &SurfaceMesh, neighbours: &[[u32; 3]]) -> Result<(), Defect> {
    let mut count = vec![0; mesh.points.len()];
    for v in mesh.triangles.iter().flatten() {
        count[*v as usize] += 1;
    }
    let mut seen = vec![false; mesh.points.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let v = triangle[i] as usize;
            if seen[v] {
                continue;
            }
            seen[v] = true;
            let fan = triangles::fan(mesh, neighbours, t, i).count();
            if fan < count[v] {
                let problem = "touches other parts of the surface in one vertex only; separate \
                               the parts or join them by a face";
                return Err(Defect::new(t, mesh.points[v], problem));
            }
        }
    }
    Ok(())
}

/// Checks that all triangles belong to one surface.
fn check_connected(mesh: &SurfaceMesh, neighbours: &[[u32; 3]]) -> Result<(), Defect> {
    let mut seen = vec![false; mesh.triangles.len()];
    let mut stack = vec![0];
    while let Some(t) = stack.pop() {
        if !std::mem::replace(&mut seen[t], true) {
            stack.extend(neighbours[t].map(|n| n as usize));
        }
    }
    match seen.iter().position(|seen| !seen) {
        None => Ok(()),
        Some(t) => {
            let problem = "is not connected with triangle 1: the surface has several parts; give \
                           every body a file of its own";
            Err(Defect::in_middle(mesh, t, problem))
        }
    }
}
