//! Walls of the domain in a plane.

use mesh::Surface;
use nalgebra::{Isometry3, Vector3};
use scene::Domain;

use super::plane::SlicePlane;
use super::section::section;

/// Number of cells of the grid along each side of the window on which walls are found.
const CELLS: usize = 96;

/// Piece of a wall in coordinates of the window, from 0 to 1, with the fluid on its right.
pub type WallPiece = [[f64; 2]; 2];

/// The straight pieces in which the plane cuts the walls of a domain, within the window.
///
/// They are where the depth below the wall, interpolated between the points of a grid, is zero. A
/// domain from a file has none here.
fn walls(domain: &Domain, plane: &SlicePlane) -> Vec<WallPiece> {
    let place = |k: usize| k as f64 / CELLS as f64;
    let mut depths = Vec::with_capacity((CELLS + 1) * (CELLS + 1));
    for row in 0..=CELLS {
        for column in 0..=CELLS {
            let right = (place(column) - 0.5) * plane.width * plane.right;
            let x = plane.centre + right + (place(row) - 0.5) * plane.height * plane.up;
            let Some(depth) = depth(domain, &x) else {
                return Vec::new();
            };
            depths.push(depth);
        }
    }
    let mut pieces = Vec::new();
    for (row, column) in (0..CELLS).flat_map(|row| (0..CELLS).map(move |column| (row, column))) {
        // The corners of a cell, anticlockwise.
        let corners = [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(up, right)| {
            let (row, column) = (row + up, column + right);
            let depth = depths[row * (CELLS + 1) + column];
            ([place(column), place(row)], depth)
        });
        // Anticlockwise around the fluid, so that the wall is left where it is entered last.
        let (mut into, mut out) = (Vec::new(), Vec::new());
        for k in 0..4 {
            let ((a, from), (b, to)) = (corners[k], corners[(k + 1) % 4]);
            if (from > 0.0) == (to > 0.0) {
                continue;
            }
            let share = from / (from - to);
            let crossing = [0, 1].map(|c| a[c] + share * (b[c] - a[c]));
            match to > 0.0 {
                true => into.push(crossing),
                false => out.push(crossing),
            }
        }
        pieces.extend(into.into_iter().zip(out).map(|(into, out)| [into, out]));
    }
    pieces
}

/// The closed curves in which the plane cuts the walls of a domain with the surface of a file; none
/// for other domains.
pub fn walls_of_file(domain: &Domain, plane: &SlicePlane) -> Vec<Vec<[f64; 2]>> {
    let Domain::Surface(domain) = domain else {
        return Vec::new();
    };
    let mesh = domain.surface.triangulation();
    let curves = mesh.map(|mesh| section(&mesh, &Isometry3::identity(), plane));
    curves.unwrap_or_default()
}

/// The lines that show the walls of a domain in the window: those with a formula with strokes on
/// the side without fluid, those of a file as they are.
pub fn wall_lines(domain: &Domain, plane: &SlicePlane) -> Vec<WallPiece> {
    let mut lines = hatched(&walls(domain, plane), plane);
    for curve in walls_of_file(domain, plane) {
        let edges = curve.iter().zip(curve.iter().cycle().skip(1));
        lines.extend(edges.filter_map(|(a, b)| within_window([*a, *b])));
    }
    lines
}

/// The part of a piece within the window; none if it is outside.
fn within_window([a, b]: WallPiece) -> Option<WallPiece> {
    // Shares of the way from a to b between which both coordinates are from 0 to 1.
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let step = b[axis] - a[axis];
        if step == 0.0 {
            if !(0.0..=1.0).contains(&a[axis]) {
                return None;
            }
            continue;
        }
        let ends = [-a[axis] / step, (1.0 - a[axis]) / step];
        from = from.max(ends[0].min(ends[1]));
        to = to.min(ends[0].max(ends[1]));
    }
    let at = |share: f64| [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis]));
    (from < to).then(|| [at(from), at(to)])
}

/// Whether a point of the window is inside closed curves, which do not cross each other.
pub fn is_inside(curves: &[Vec<[f64; 2]>], [x, y]: [f64; 2]) -> bool {
    let edges = curves
        .iter()
        .flat_map(|curve| curve.iter().zip(curve.iter().cycle().skip(1)));
    let to_the_right = edges.filter(|(a, b)| {
        (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    });
    to_the_right.count() % 2 == 1
}

/// The pieces of walls with short strokes on the side without fluid, as drawings have them.
fn hatched(pieces: &[WallPiece], plane: &SlicePlane) -> Vec<WallPiece> {
    /// Length of a stroke relative to the width of the window.
    const LENGTH: f64 = 0.018;
    // Every second piece of each wall, whatever walls lie between two of its pieces.
    let is_second = |[a, b]: &&WallPiece| {
        let axis = usize::from((b[0] - a[0]).abs() < (b[1] - a[1]).abs());
        ((a[axis].min(b[axis]) * CELLS as f64).round() as usize).is_multiple_of(2)
    };
    let strokes = pieces.iter().filter(is_second).filter_map(|[a, b]| {
        let along = [(b[0] - a[0]) * plane.width, (b[1] - a[1]) * plane.height];
        let norm = along[0].hypot(along[1]);
        // To the left and back.
        let [x, y] = [-along[0] - along[1], along[0] - along[1]].map(|c| c / norm);
        let end = [
            a[0] + LENGTH * x,
            a[1] + LENGTH * y * plane.width / plane.height,
        ];
        (norm > 0.0).then_some([*a, end])
    });
    pieces.iter().copied().chain(strokes).collect()
}

/// Whether a point is beyond a wall for which there is a formula.
pub fn is_beyond_wall(domain: &Domain, x: &Vector3<f64>) -> bool {
    depth(domain, x).is_some_and(|depth| depth < 0.0)
}

/// Distance from the wall into the fluid, negative outside it; none without a formula.
fn depth(domain: &Domain, x: &Vector3<f64>) -> Option<f64> {
    Some(match domain {
        Domain::Unbounded => f64::INFINITY,
        Domain::Wall => x.z,
        Domain::Ball { radius } => radius - x.norm(),
        Domain::Cylinder { radius } => radius - x.yz().norm(),
        Domain::Box { size } => (0.5 * size - x.abs()).min(),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(centre: Vector3<f64>) -> SlicePlane {
        SlicePlane {
            centre,
            right: Vector3::x(),
            up: Vector3::z(),
            width: 4.0,
            height: 2.0,
        }
    }

    /// Twice the area to the right of the pieces of a closed curve is the sum of their cross
    /// products; the interpolation of a circle is short by the square of the size of a cell.
    #[test]
    fn walls_have_the_fluid_on_their_right() {
        let wall = walls(&Domain::Wall, &plane(Vector3::new(7.0, 0.0, 0.5)));
        assert_eq!(wall.len(), CELLS);
        for [from, to] in wall {
            assert!((from[1] - 0.25).abs() < 1e-12 && (to[1] - 0.25).abs() < 1e-12);
            assert!(from[0] > to[0], "the fluid is above");
        }
        let ball = walls(&Domain::Ball { radius: 0.8 }, &plane(Vector3::zeros()));
        let twice: f64 = (ball.iter()).map(|[a, b]| b[0] * a[1] - a[0] * b[1]).sum();
        let area = 0.5 * twice * 8.0;
        let exact = std::f64::consts::PI * 0.64;
        assert!((area / exact - 1.0).abs() < 1e-2, "{area} {exact}");
        assert!(walls(&Domain::Unbounded, &plane(Vector3::zeros())).is_empty());
        assert!(is_beyond_wall(&Domain::Wall, &-Vector3::z()));
        assert!(!is_beyond_wall(&Domain::Wall, &Vector3::z()));
    }

    /// They were drawn along the frame, and the flow beyond them.
    #[test]
    fn bug_walls_of_files_outside_the_window_became_walls_at_its_frame() {
        assert_eq!(within_window([[0.5, 1.2], [0.5, 3.0]]), None);
        assert_eq!(within_window([[-1.0, 2.0], [2.0, 2.0]]), None);
        let diagonal = within_window([[-1.0, -1.0], [3.0, 3.0]]);
        assert_eq!(diagonal, Some([[0.0, 0.0], [1.0, 1.0]]));
        let inner = [[0.25, 0.5], [0.75, 0.5]];
        assert_eq!(within_window(inner), Some(inner));
        let square = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let hole = vec![[0.5, 0.5], [0.5, 1.5], [1.5, 1.5], [1.5, 0.5]];
        let curves = [square, hole];
        for (at, inside) in [([0.2, 0.7], true), ([1.0, 0.7], false), ([3.0, 0.7], false)] {
            assert_eq!(is_inside(&curves, at), inside, "{at:?}");
        }
    }

    #[test]
    fn bug_only_one_of_two_opposite_walls_had_strokes() {
        let size = Vector3::new(3.0, 3.0, 9.0);
        let view = plane(Vector3::zeros());
        let pieces = walls(&Domain::Box { size }, &view);
        let strokes = hatched(&pieces, &view).split_off(pieces.len());
        let left = strokes.iter().filter(|[a, _]| a[0] < 0.5).count();
        assert_eq!(
            (pieces.len(), left, strokes.len()),
            (2 * CELLS, CELLS / 2, CELLS)
        );
    }
}
