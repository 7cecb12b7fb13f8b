//! Pictures of a mesh: its section with the plane `y = 0`, tets coloured by their quality.

use std::fmt::Write;

use mesh::{TetMesh, Vec3, mean_ratio};

/// Part of the plane that is shown.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Lowest and highest x.
    pub x: [f64; 2],
    /// Highest z; the lowest is its negative.
    pub z: f64,
}

/// Width of a picture in points.
const WIDTH: f64 = 900.0;

/// Section as SVG text, with a title and a colour scale.
pub fn svg(mesh: &TetMesh, window: Window, title: &str) -> String {
    let scale = WIDTH / (window.x[1] - window.x[0]);
    let (height, top) = (2.0 * window.z * scale, 34.0);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH:.0}\" height=\"{:.0}\" font-family=\"sans-serif\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <text x=\"8\" y=\"22\" font-size=\"15\" fill=\"#282828\">{title}</text>\n",
        height + top
    );
    // Writing to a String cannot fail.
    for (k, quality) in [0.0, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0].into_iter().enumerate() {
        let x = WIDTH - 330.0 + 46.0 * k as f64;
        let _ = writeln!(
            text,
            "<rect x=\"{x}\" y=\"9\" width=\"16\" height=\"16\" fill=\"{}\" stroke=\"#555\"/><text x=\"{}\" y=\"22\" font-size=\"12\">{quality}</text>",
            colour(quality),
            x + 19.0
        );
    }
    let _ = writeln!(
        text,
        "<svg y=\"{top}\" width=\"{WIDTH:.0}\" height=\"{height:.0}\" stroke=\"#334\" stroke-width=\"0.5\" stroke-linejoin=\"round\">"
    );
    let place = |p: &Vec3| ((p.x - window.x[0]) * scale, (window.z - p.z) * scale);
    for cell in 0..mesh.n_cells() {
        let corners = mesh.cell_vertices(cell);
        let polygon = section(&corners);
        let shown = |p: &Vec3| p.x > window.x[0] && p.x < window.x[1] && p.z.abs() < window.z;
        if polygon.len() < 3 || !polygon.iter().any(shown) {
            continue;
        }
        let points: Vec<String> = polygon
            .iter()
            .map(|p| {
                let (x, y) = place(p);
                format!("{x:.1},{y:.1}")
            })
            .collect();
        let _ = writeln!(
            text,
            "<polygon points=\"{}\" fill=\"{}\"/>",
            points.join(" "),
            colour(mean_ratio(corners))
        );
    }
    text.push_str("</svg>\n</svg>\n");
    text
}

/// Section of a tet with the plane `y = 0`: corners of a triangle or quadrilateral, or none.
fn section(corners: &[Vec3; 4]) -> Vec<Vec3> {
    // A vertex on the plane counts as above it, so that no degenerate section occurs.
    let above = |p: &Vec3| p.y >= 0.0;
    let (up, down): (Vec<&Vec3>, Vec<&Vec3>) = corners.iter().partition(|p| above(p));
    let between = |a: &Vec3, b: &Vec3| a + (b - a) * (a.y / (a.y - b.y));
    match (&up[..], &down[..]) {
        ([a], [b, c, d]) | ([b, c, d], [a]) => {
            vec![between(a, b), between(a, c), between(a, d)]
        }
        ([a, b], [c, d]) => {
            vec![between(a, c), between(a, d), between(b, d), between(b, c)]
        }
        _ => Vec::new(),
    }
}

/// Colour of a quality, from red (flat) through yellow to pale blue (regular).
fn colour(quality: f64) -> String {
    const STOPS: [(f64, [f64; 3]); 4] = [
        (0.0, [178.0, 24.0, 43.0]),
        (0.2, [244.0, 165.0, 60.0]),
        (0.5, [253.0, 238.0, 170.0]),
        (1.0, [209.0, 229.0, 245.0]),
    ];
    let q = quality.clamp(0.0, 1.0);
    let upper = STOPS
        .iter()
        .position(|stop| q <= stop.0)
        .unwrap_or(3)
        .max(1);
    let ((q0, a), (q1, b)) = (STOPS[upper - 1], STOPS[upper]);
    let t = (q - q0) / (q1 - q0);
    let [r, g, b] = [0, 1, 2].map(|c| (a[c] + t * (b[c] - a[c])).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::LinearTets;

    #[test]
    fn sections_of_all_tets_fill_the_section_of_the_cube() {
        // The plane intersects the shifted unit cube, so the areas of the polygons add up to one.
        let mesh = TetMesh::straight(LinearTets::cube(3)).unwrap();
        let points = mesh
            .points()
            .iter()
            .map(|p| p - Vec3::new(0.0, 0.47, 0.5))
            .collect();
        let mesh = mesh.with_points(points).unwrap();
        let area: f64 = (0..mesh.n_cells())
            .map(|cell| section(&mesh.cell_vertices(cell)))
            .filter(|polygon| polygon.len() >= 3)
            .map(|p| {
                let fan = (1..p.len() - 1).map(|k| (p[k] - p[0]).cross(&(p[k + 1] - p[0])));
                0.5 * fan.sum::<Vec3>().norm()
            })
            .sum();
        assert!((area - 1.0).abs() < 1e-12, "{area}");
        let window = Window {
            x: [0.0, 1.0],
            z: 0.6,
        };
        assert!(svg(&mesh, window, "cube").matches("<polygon").count() > 10);
    }
}
