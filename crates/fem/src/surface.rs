//! Area, enclosed volume and centroid of parts of the boundary.

use mesh::{Facet, TetMesh, Vec3};

use crate::FemError;
use crate::quadrature::{CellPoint, FacetPoint, facet_degree_6};
use crate::sum::sum_over;

/// Area, enclosed volume and centroid of a closed part of the boundary, from its curved facets.
///
/// The part is closed by itself or together with symmetry planes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfaceMeasures {
    /// Area of the discrete surface.
    pub area: f64,
    /// Volume of the discrete body (or container) that the surface encloses, `|B_h|`, positive.
    pub volume: f64,
    /// Centroid of the enclosed volume.
    pub centroid: Vec3,
}

/// Largest `|∮ n dS|` of a closed surface divided by its area: rounding of the sum over its facets.
const MAX_CLOSED_GAP: f64 = 1e-9;

/// Area, enclosed volume and centroid of the surface that consists of the facets with `tag`.
///
/// ```text
/// |B_h| = |∮ x·n dS| / 3,   centroid_k = ∮ x_k^2 n_k dS / (2 |B_h|)
/// ```
///
/// Volume and centroid are exact for the quadratic facets (degrees 4 and 6, 12-point rule of
/// degree 6); the integrand of the area is a square root. With curved facets the volume of a sphere
/// is of fourth order in the facet size. If symmetry planes cut the surface, the results are those
/// of the part in the mesh: planes through the origin contribute nothing to the integrals.
///
/// # Errors
/// No facet has the tag; the facets are not a closed surface; a point is not finite.
pub fn surface_measures(mesh: &TetMesh, tag: u16) -> Result<SurfaceMeasures, FemError> {
    let facets = tagged_facets(mesh, tag)?;
    let symmetry_planes = mesh.symmetry_planes();
    // The integrals of a closed surface do not depend on the origin if it is on the symmetry
    // planes; an origin near the surface avoids cancellation.
    let mut origin = facet_nodes(mesh, facets[0])[0];
    for axis in (0..3).filter(|&axis| symmetry_planes[axis]) {
        origin[axis] = 0.0;
    }
    let sums = sum_over(facets.len(), |k| {
        let nodes = facet_nodes(mesh, facets[k]).map(|x| x - origin);
        let mut terms = [0.0; 8];
        for point in facet_degree_6() {
            let (x, normal) = position_and_normal(&nodes, point);
            let normal = normal * point.weight;
            terms[0] += normal.norm();
            terms[1] += x.dot(&normal) / 3.0;
            for c in 0..3 {
                terms[2 + c] += normal[c];
                terms[5 + c] += 0.5 * x[c] * x[c] * normal[c];
            }
        }
        Ok(terms)
    })?;
    let [area, signed_volume, nx, ny, nz, cx, cy, cz] = sums;
    if let Some(index) = sums.iter().position(|sum| !sum.is_finite()) {
        return Err(FemError::NotFinite {
            what: "the surface integrals",
            index,
        });
    }
    // The open part of the surface on a symmetry plane contributes to the normal component only.
    let open = [0, 1, 2].map(|axis| {
        if symmetry_planes[axis] {
            0.0
        } else {
            [nx, ny, nz][axis]
        }
    });
    let gap = Vec3::from(open).norm() / area;
    if gap.is_nan() || gap > MAX_CLOSED_GAP || signed_volume == 0.0 {
        return Err(FemError::OpenSurface { tag, gap });
    }
    let centroid = origin + Vec3::new(cx, cy, cz) / signed_volume;
    Ok(SurfaceMeasures {
        area,
        volume: signed_volume.abs(),
        centroid,
    })
}

/// Facets with `tag`; an error if there is none.
pub(crate) fn tagged_facets(mesh: &TetMesh, tag: u16) -> Result<Vec<&Facet>, FemError> {
    let facets: Vec<&Facet> = mesh
        .facets()
        .iter()
        .filter(|facet| facet.tag == tag)
        .collect();
    if facets.is_empty() {
        return Err(FemError::EmptyTag {
            tag,
            n_tags: mesh.tags().len(),
        });
    }
    Ok(facets)
}

/// Positions of the six nodes of a facet.
pub(crate) fn facet_nodes(mesh: &TetMesh, facet: &Facet) -> [Vec3; 6] {
    facet.nodes.map(|node| mesh.points()[node as usize])
}

/// Position and normal `∂_1 x × ∂_2 x` at a quadrature point of a quadratic facet.
///
/// The normal points out of the fluid; its length is the surface element.
pub(crate) fn position_and_normal(nodes: &[Vec3; 6], point: &FacetPoint) -> (Vec3, Vec3) {
    let l = point.barycentric;
    let (mut x, mut by_1, mut by_2) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
    // l_0 = 1 - l_1 - l_2: the derivative with respect to l_0 is subtracted from the two others.
    let mut add = |node: &Vec3, value: f64, d: [f64; 3]| {
        x += node * value;
        by_1 += node * (d[1] - d[0]);
        by_2 += node * (d[2] - d[0]);
    };
    for i in 0..3 {
        let j = (i + 1) % 3;
        let mut d = [0.0; 3];
        d[i] = 4.0 * l[i] - 1.0;
        add(&nodes[i], l[i] * (2.0 * l[i] - 1.0), d);
        // Midside node of edge (i, i + 1).
        let mut d = [0.0; 3];
        (d[i], d[j]) = (4.0 * l[j], 4.0 * l[i]);
        add(&nodes[3 + i], 4.0 * l[i] * l[j], d);
    }
    (x, by_1.cross(&by_2))
}

/// Quadrature point of a facet as a point of its cell, whose nodes are `nodes`.
pub(crate) fn facet_cell_point(facet: &Facet, nodes: &[u32; 10], point: &FacetPoint) -> CellPoint {
    // Three of the four vertices of the cell are on the facet; the coordinate of the fourth is 0.
    let barycentric = [0, 1, 2, 3].map(|local| {
        let corner = facet.nodes[..3]
            .iter()
            .position(|&node| node == nodes[local]);
        corner.map_or(0.0, |corner| point.barycentric[corner])
    });
    CellPoint::new(barycentric, point.weight)
}
