//! Local feature sizes: the radii of balls that touch a surface.

use super::Defect;
use super::patch::Patch;
use super::tree::PatchTree;
use mesh::{SurfaceMesh, Vec3};

/// Largest cosine between the normals at two ends of a ball's chord that count as opposite sides of
/// a part or of a gap. The faces at a sharp edge, up to 120 degrees between normals, do not.
const MAX_OPPOSITE_COSINE: f64 = -0.5;

/// Smallest feature relative to the radius of the surface; 1e3 is the ratio of the smallest gap
/// between bodies that is meshed to their radius.
const MIN_FEATURE: f64 = 1e-3;

/// Steps of shrinking a ball; each halves its excess or better.
const STEPS: usize = 40;

/// Smallest slope of edge lengths along the surface, relative to those at its sharpest point, for
/// which few points represent all.
const SLOPE: f64 = 0.4;

/// Largest ratio by which a point may have smaller features than its representative says.
const SLACK: f64 = 1.15;

/// The local feature sizes of a surface.
#[derive(Clone)]
pub(super) struct FeatureSizes {
    /// Points with the feature size there, such that at every point `y` of the surface one of them
    /// at `x` has at most `1.15` of the size at `y`, minus `0.4 |x - y|`.
    pub samples: Vec<(Vec3, f64)>,
    /// The smallest feature size.
    pub smallest: f64,
    /// Radius of the largest of all balls found inside.
    pub inradius: f64,
}

/// A triangle at which the thickness of the part and of the gap outside was measured.
struct Thickness {
    at: Vec3,
    normal: Vec3,
    thinnest: f64,
}

/// Largest distance, relative to the thickness, of a triangle that has the thickness of another one
/// that faces the same way.
const MAX_SHARED_DISTANCE: f64 = 0.25;

impl FeatureSizes {
    /// No sizes yet.
    pub fn none() -> Self {
        Self {
            samples: Vec::new(),
            smallest: 0.0,
            inradius: 0.0,
        }
    }

    /// Measures the feature size at the centroid of each triangle.
    ///
    /// It is the radius of the largest balls that touch the surface there from inside and outside
    /// and contain no point of the opposite side (shrinking balls, Ma et al. 2012), or the radius
    /// of curvature that the normals at the corners give, if that is smaller.
    ///
    /// # Errors
    /// A defect at a feature below 1e-3 of `radius`, that of a ball around the surface.
    pub fn new(
        mesh: &SurfaceMesh,
        patches: &[Patch],
        tree: &PatchTree,
        normals: &[[Option<Vec3>; 3]],
        radius: f64,
        signed_distance: &dyn Fn(&Vec3) -> f64,
    ) -> Result<Self, Defect> {
        const CENTROID: [f64; 3] = [1.0 / 3.0; 3];
        let at_centroid: Vec<Vec3> = patches.iter().map(|p| p.normal(CENTROID)).collect();
        // The largest ball on one side of a triangle.
        let ball = |x: &Vec3, n: &Vec3, side: f64| {
            let is_opposite = |t: usize| at_centroid[t].dot(n) < MAX_OPPOSITE_COSINE;
            let mut r = radius;
            for _ in 0..STEPS {
                let centre = x + (side * r) * n;
                let Some(foot) = tree.closest(patches, &centre, r, is_opposite) else {
                    break;
                };
                let arm = foot.point - x;
                let along = side * arm.dot(n);
                let next = arm.norm_squared() / (2.0 * along);
                if next.is_nan() || along <= 0.0 || next >= 0.999 * r {
                    break;
                }
                r = next;
            }
            r
        };
        let mut thicknesses: Vec<Thickness> = Vec::new();
        let mut inradius = 0f64;
        let mut measured: Vec<(Vec3, f64)> = Vec::with_capacity(patches.len());
        let mut is_curved = Vec::with_capacity(patches.len());
        for (t, patch) in patches.iter().enumerate() {
            let (at, normal) = (patch.at(CENTROID), at_centroid[t]);
            let stands_for = |other: &&Thickness| {
                (other.at - at).norm() < MAX_SHARED_DISTANCE * other.thinnest
                    && other.normal.dot(&normal) > 0.9
            };
            let thinnest = match thicknesses.iter().rev().find(stands_for) {
                Some(other) => other.thinnest,
                None => {
                    let inner = ball(&at, &normal, -1.0);
                    inradius = inradius.max(-signed_distance(&(at - inner * normal)));
                    let thinnest = inner.min(ball(&at, &normal, 1.0));
                    thicknesses.push(Thickness {
                        at,
                        normal,
                        thinnest,
                    });
                    thinnest
                }
            };
            let curvature = radius_of_curvature(&patch.corners, &normals[t]);
            measured.push((at, curvature.min(thinnest)));
            is_curved.push(curvature < thinnest);
        }
        let mut order: Vec<usize> = (0..measured.len()).collect();
        order.sort_by(|&i, &j| measured[i].1.total_cmp(&measured[j].1));
        let sharpest = order[0];
        let smallest = measured[sharpest].1;
        if smallest.is_nan() || smallest < MIN_FEATURE * radius {
            let what = match is_curved[sharpest] {
                true => "radius of curvature",
                false => "half the thickness of the part or gap",
            };
            let problem = format!(
                "is at a tiny feature: the {what} is {smallest:.2e} there, below {MIN_FEATURE:e} of the \
                 radius {radius:.2e} of the surface; remove it"
            );
            return Err(Defect::in_middle(mesh, sharpest, problem));
        }
        Ok(Self {
            inradius: inradius.max(smallest),
            samples: representatives(order.into_iter().map(|t| measured[t])),
            smallest: smallest / SLACK,
        })
    }

    /// The minimum of `factor rho(y) + growth |x - y|` over the surface, or up to 15 per cent less.
    pub fn edge_length(&self, x: &Vec3, factor: f64, growth: f64) -> f64 {
        let sizes = self.samples.iter();
        sizes
            .map(|(y, rho)| factor / SLACK * rho + growth * (x - y).norm())
            .fold(f64::INFINITY, f64::min)
    }
}

/// Some of the measured points and sizes, given in ascending order, that stand for all of them.
fn representatives(measured: impl Iterator<Item = (Vec3, f64)>) -> Vec<(Vec3, f64)> {
    let mut samples: Vec<(Vec3, f64)> = Vec::new();
    for (at, size) in measured {
        let stands_for = |(x, rho): &(Vec3, f64)| {
            let rest = SLACK * size - rho;
            rest >= 0.0 && SLOPE * (at - x).norm() <= rest
        };
        if !samples.iter().any(stands_for) {
            samples.push((at, size));
        }
    }
    samples
}

/// Smallest radius of curvature along the edges of a triangle: the change of the normal along an
/// edge gives `1 / rho = |dn . e| / e^2`.
fn radius_of_curvature(corners: &[Vec3; 3], normals: &[Option<Vec3>; 3]) -> f64 {
    (0..3)
        .filter_map(|i| {
            let j = (i + 1) % 3;
            let edge = corners[j] - corners[i];
            let change = normals[j]? - normals[i]?;
            Some(edge.norm_squared() / change.dot(&edge).abs())
        })
        .fold(f64::INFINITY, f64::min)
}
