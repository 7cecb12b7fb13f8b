//! The cells of a mesh in which points lie.

use nalgebra::Matrix3;

use crate::box_tree::{BoundingBox, BoxTree};
use crate::{TET_EDGES, TetMesh, Vec3};

/// Smallest barycentric coordinate of a point that belongs to a cell.
///
/// Curved cells approximate surfaces: points of a sphere with elements of half its radius are up to
/// a hundredth of a cell outside.
const MIN_BARYCENTRIC: f64 = -0.02;

/// Largest number of iterations; cells that are not badly bent take three to five.
const MAX_ITERATIONS: usize = 20;

/// Largest step in barycentric coordinates: farther away, the linearised map means little.
const LONGEST_STEP: f64 = 0.5;

/// Step at which the iteration ends; the next one is its square.
const LAST_STEP: f64 = 1e-9;

/// A point in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CellPoint {
    /// Number of the cell.
    pub cell: usize,
    /// Barycentric coordinates: the values of the linear shape functions of the four vertices.
    pub barycentric: [f64; 4],
}

impl CellPoint {
    /// Values of the quadratic shape functions of the ten nodes of the cell.
    pub fn quadratic(&self) -> [f64; 10] {
        quadratic_functions(&self.barycentric)
    }
}

/// Finds the cells of a mesh in which points lie.
///
/// ```
/// use mesh::{LinearTets, PointLocator, TetMesh, Vec3};
/// let mesh = TetMesh::straight(LinearTets::cube(2))?;
/// let locator = PointLocator::new(&mesh);
/// let x = Vec3::new(0.3, 0.6, 0.1);
/// let found = locator.locate(&x).ok_or("not in the cube")?;
/// let nodes = mesh.cell_points(found.cell);
/// let y: Vec3 = nodes.iter().zip(found.quadratic()).map(|(node, n)| n * node).sum();
/// assert!((x - y).norm() < 1e-12);
/// assert!(locator.locate(&Vec3::new(2.0, 0.0, 0.0)).is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct PointLocator<'a> {
    mesh: &'a TetMesh,
    boxes: BoxTree,
}

impl<'a> PointLocator<'a> {
    /// Cost: a hierarchy of the boxes around all cells, about a microsecond per cell.
    pub fn new(mesh: &'a TetMesh) -> Self {
        let everywhere = Vec3::repeat(f64::INFINITY);
        Self::within(mesh, &-everywhere, &everywhere)
    }

    /// A locator for points in a box; others may not be found.
    ///
    /// For the points of a plane normal to a coordinate axis it has a tenth of the cells.
    pub fn within(mesh: &'a TetMesh, min: &Vec3, max: &Vec3) -> Self {
        let [min, max] = [*min, *max];
        let range = BoundingBox { min, max };
        let boxes = (0..mesh.n_cells())
            .map(|cell| (cell, cell_box(&mesh.cell_points(cell))))
            .filter(|(_, of_cell)| of_cell.meets(&range));
        let boxes = BoxTree::new(boxes);
        Self { mesh, boxes }
    }

    /// The cell in which a point lies; none outside the mesh.
    ///
    /// Points outside by less than a fiftieth of a cell belong to it. The map of a curved cell is
    /// inverted by Newton's method.
    pub fn locate(&self, x: &Vec3) -> Option<CellPoint> {
        let at = BoundingBox { min: *x, max: *x };
        let depth = |point: &CellPoint| point.barycentric.iter().fold(1.0, |d: f64, l| d.min(*l));
        let mut best: Option<CellPoint> = None;
        self.boxes.visit_meeting(&at, |cell| {
            let Some(barycentric) = invert(&self.mesh.cell_points(cell), x) else {
                return;
            };
            let found = CellPoint { cell, barycentric };
            // The order of the hierarchy does not matter.
            let is_better =
                best.is_none_or(|best| (depth(&found), best.cell) > (depth(&best), found.cell));
            if depth(&found) >= MIN_BARYCENTRIC && is_better {
                best = Some(found);
            }
        });
        best
    }
}

/// A box around a cell and the points that belong to it.
fn cell_box(nodes: &[Vec3; 10]) -> BoundingBox {
    // The cell is in the convex hull of its control points (see `jacobian.rs`).
    let controls = TET_EDGES
        .iter()
        .enumerate()
        .map(|(edge, [i, j])| 2.0 * nodes[4 + edge] - 0.5 * (nodes[*i] + nodes[*j]));
    let points: Vec<Vec3> = nodes[..4].iter().copied().chain(controls).collect();
    let BoundingBox { min, max } = BoundingBox::around(&points);
    // A barycentric coordinate of -s extends an affine cell by three times s of its box.
    let margin = -3.0 * MIN_BARYCENTRIC * (max - min);
    BoundingBox {
        min: min - margin,
        max: max + margin,
    }
}

/// Values of the ten quadratic shape functions at barycentric coordinates.
pub(crate) fn quadratic_functions(l: &[f64; 4]) -> [f64; 10] {
    std::array::from_fn(|node| match node.checked_sub(4) {
        None => l[node] * (2.0 * l[node] - 1.0),
        Some(edge) => 4.0 * l[TET_EDGES[edge][0]] * l[TET_EDGES[edge][1]],
    })
}

/// Barycentric coordinates of a point by Newton's method; none if it does not converge.
fn invert(nodes: &[Vec3; 10], x: &Vec3) -> Option<[f64; 4]> {
    let mut l = [0.25; 4];
    for _ in 0..MAX_ITERATIONS {
        let mut residual = *x;
        let mut slopes = [Vec3::zeros(); 4];
        for (node, n) in nodes.iter().zip(quadratic_functions(&l)) {
            residual -= n * node;
        }
        for k in 0..4 {
            slopes[k] += (4.0 * l[k] - 1.0) * nodes[k];
        }
        for (node, [i, j]) in nodes[4..].iter().zip(TET_EDGES) {
            slopes[i] += 4.0 * l[j] * node;
            slopes[j] += 4.0 * l[i] * node;
        }
        // The coordinates sum to one: that of vertex 0 follows from the others.
        let columns = [1, 2, 3].map(|k| slopes[k] - slopes[0]);
        let step = Matrix3::from_columns(&columns).try_inverse()? * residual;
        let size = step.amax();
        let factor = (LONGEST_STEP / size).min(1.0);
        for k in 0..3 {
            l[k + 1] += factor * step[k];
        }
        l[0] = 1.0 - l[1] - l[2] - l[3];
        if size <= LAST_STEP {
            return Some(l);
        }
    }
    None
}
