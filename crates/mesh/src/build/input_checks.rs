//! Checks of the arrays from which a mesh is built.

use rayon::prelude::*;

use crate::tet_mesh::check_finite;
use crate::{Facet, LinearTets, MeshError};

/// Checks that coordinates are finite and that vertex and tag numbers exist.
///
/// # Errors
/// [`MeshError::Empty`], [`MeshError::TooLarge`], [`MeshError::NotFinite`],
/// [`MeshError::OutOfRange`].
pub(super) fn check_numbers(linear: &LinearTets) -> Result<(), MeshError> {
    let n = linear.points.len();
    if linear.tets.is_empty() {
        return Err(MeshError::Empty);
    }
    for (what, count) in [("vertices", n), ("tets", linear.tets.len())] {
        if count > i32::MAX as usize {
            return Err(MeshError::TooLarge { what, count });
        }
    }
    check_finite(&linear.points)?;
    let tet = |(i, tet): (usize, &[u32; 4])| ("tet", i, *tet.iter().max().unwrap_or(&0), n);
    let face =
        |(i, face): (usize, &([u32; 3], u16))| ("face", i, *face.0.iter().max().unwrap_or(&0), n);
    let n_tags = linear.tags.len();
    let tag = |(i, face): (usize, &([u32; 3], u16))| ("tag of face", i, u32::from(face.1), n_tags);
    let tets = linear.tets.iter().enumerate().map(tet);
    let faces = linear.faces.iter().enumerate();
    for (what, index, number, len) in tets.chain(faces.clone().map(face)).chain(faces.map(tag)) {
        let number = number as usize;
        if number >= len {
            return Err(MeshError::OutOfRange {
                what,
                index,
                number,
                len,
            });
        }
    }
    Ok(())
}

/// Checks that every vertex belongs to a tet and that no two vertices coincide.
///
/// # Errors
/// [`MeshError::UnusedVertex`], [`MeshError::DuplicateVertices`].
pub(super) fn check_vertices(linear: &LinearTets) -> Result<(), MeshError> {
    let mut used = vec![false; linear.points.len()];
    for &v in linear.tets.iter().flatten() {
        used[v as usize] = true;
    }
    if let Some(vertex) = used.iter().position(|used| !used) {
        return Err(MeshError::UnusedVertex {
            vertex,
            at: linear.points[vertex].into(),
        });
    }
    // Adding zero turns -0 into +0, which is the same position. Vertices that differ by rounding
    // are not found here; they show up as a flat tet or an untagged crack.
    let place = |&v: &u32| linear.points[v as usize].map(|x| (x + 0.0).to_bits());
    let mut by_place: Vec<u32> = (0..linear.points.len() as u32).collect();
    by_place.par_sort_unstable_by_key(|v| {
        let p = place(v);
        (p.x, p.y, p.z, *v)
    });
    match by_place
        .windows(2)
        .find(|pair| place(&pair[0]) == place(&pair[1]))
    {
        Some(pair) => Err(MeshError::DuplicateVertices {
            first: pair[0] as usize,
            second: pair[1] as usize,
            at: linear.points[pair[0] as usize].into(),
        }),
        None => Ok(()),
    }
}

/// Checks that each tag has a face and a unique name that files can hold.
///
/// # Errors
/// [`MeshError::BadTag`].
pub(super) fn check_tags(tags: &[String], facets: &[Facet]) -> Result<(), MeshError> {
    for (i, name) in tags.iter().enumerate() {
        let problem = match name_problem(tags, i) {
            Some(problem) => problem,
            None if facets.iter().any(|facet| facet.tag as usize == i) => continue,
            None => "has no faces; remove it or tag its faces",
        };
        return Err(MeshError::BadTag {
            name: name.clone(),
            problem,
        });
    }
    Ok(())
}

/// Checks that each cell has a region if regions are named, and that the names are unique.
///
/// # Errors
/// [`MeshError::WrongLength`], [`MeshError::OutOfRange`], [`MeshError::BadRegion`].
pub(super) fn check_regions(linear: &LinearTets) -> Result<(), MeshError> {
    let regions = &linear.regions;
    let expected = if regions.is_empty() {
        0
    } else {
        linear.tets.len()
    };
    if regions.of_cells.len() != expected {
        return Err(MeshError::WrongLength {
            what: "list of the cells' regions".into(),
            expected,
            found: regions.of_cells.len(),
        });
    }
    let len = regions.names.len();
    if let Some(index) = regions.of_cells.iter().position(|&r| r as usize >= len) {
        return Err(MeshError::OutOfRange {
            what: "region of tet",
            index,
            number: regions.of_cells[index] as usize,
            len,
        });
    }
    for (i, name) in regions.names.iter().enumerate() {
        if let Some(problem) = name_problem(&regions.names, i) {
            return Err(MeshError::BadRegion {
                name: name.clone(),
                problem,
            });
        }
    }
    Ok(())
}

/// The reason why `names[i]` cannot be the name of a part, if there is one.
fn name_problem(names: &[String], i: usize) -> Option<&'static str> {
    let name = &names[i];
    if name.is_empty() || name.contains(char::is_control) {
        Some("must have a name of printable characters")
    } else if names[..i].contains(name) {
        Some("is named twice; give every part its own name")
    } else {
        None
    }
}
