//! Fluid outside a sphere, unbounded or up to a concentric wall: the exact relation between
//! velocities on the sphere and the tractions of the flow beyond it.
//!
//! On a sphere of radius `R` let the velocity be the sum over `l` of `a_l P_l(cos θ)` along the
//! radius and `b_l dP_l(cos θ)/dθ` along the meridian. The flow outside decays (Lamb 1932, 336), so
//! it is a combination of a potential flow and a flow with pressure for each `l`. Its dissipation,
//! for the form of [`crate::forms`], is
//!
//! ```text
//! 4 π R / (2 l + 1) ((2 + l (2 l - 1) / (l + 1)) a^2 + 2 l (l - 2) a b + 2 l^2 (l + 1) b^2)
//! ```
//!
//! That of pure swirl `c_l dP_l(cos θ)/dθ` is `4 π R l (l + 1)^2 / (2 l + 1) c^2`. Such a
//! Dirichlet-to-Neumann map replaces the mesh outside the sphere without an error (Givoli & Keller
//! 1989); only the series is truncated. Up to a wall of the radius `B` flows that grow with the
//! radius join in ([`dissipation_inside_wall`]); of swirl the factor `l + 1` becomes
//! `(l + 1 + l t)/(1 - t)` with `t = (R/B)^(2 l + 1)`.

use std::f64::consts::PI;

use nalgebra::{DMatrix, Matrix2, Matrix2x4, Matrix4, Matrix4x2, Vector2, Vector4};

use crate::curve::BoundaryPart;
use crate::meridian::{OPEN_RADIUS_RATIO, OpenSphere};
use crate::mesh::MeridianMesh;
use crate::quadrature::{gauss, legendre, lobatto};

/// Dissipation outside the open boundary that is neglected, relative to the rest.
const MAX_NEGLECTED_DISSIPATION: f64 = 1e-18;

/// Quadrature points per edge beyond those that the polynomial degrees need.
const EXTRA_POINTS: usize = 12;

/// The matrix of the flow outside a sphere, for motion along the axis.
///
/// Degrees of freedom are axial velocities at all nodes of the open boundary from left to right,
/// then radial velocities.
pub(crate) fn exterior_flow(
    mesh: &MeridianMesh,
    order: usize,
    sphere: &OpenSphere,
) -> DMatrix<f64> {
    let trace = Trace::new(mesh, order);
    let n = trace.nodes;
    let mut matrix = DMatrix::zeros(2 * n, 2 * n);
    for l in 0..=degrees() {
        // rows: coefficients a and b; columns: degrees of freedom
        let mut modes = DMatrix::<f64>::zeros(2, 2 * n);
        for point in &trace.points {
            let (sin, cos) = point.angle.sin_cos();
            let [p, dp] = polynomial(l, point.angle);
            for (k, value) in point.values.iter().enumerate() {
                let node = point.first + k;
                let weight = point.weight * sin * value;
                modes[(0, node)] += weight * cos * p;
                modes[(0, n + node)] += weight * sin * p;
                modes[(1, node)] -= weight * sin * dp;
                modes[(1, n + node)] += weight * cos * dp;
            }
        }
        let d = l as f64;
        modes.row_mut(0).scale_mut(0.5 * (2.0 * d + 1.0));
        modes.row_mut(1).scale_mut(if l == 0 {
            0.0
        } else {
            0.5 * (2.0 * d + 1.0) / (d * (d + 1.0))
        });
        let form = match sphere.wall.is_finite() {
            true => dissipation_inside_wall(d, sphere.wall / sphere.radius),
            false => {
                let mixed = d * (d - 2.0);
                Matrix2::new(
                    2.0 + d * (2.0 * d - 1.0) / (d + 1.0),
                    mixed,
                    mixed,
                    2.0 * d * d * (d + 1.0),
                )
            }
        };
        let form = form * (4.0 * PI * sphere.radius / (2.0 * d + 1.0));
        matrix += modes.transpose() * form * &modes;
    }
    matrix
}

/// The dissipation of degree `l` in [`exterior_flow`] between a sphere and a wall of `wall` times
/// its radius, where the velocity is zero.
///
/// The velocities `f P_l` along the radius and `g dP_l/dθ` along the meridian are those of Lamb's
/// solution of the degrees `k = l` and `k = -l - 1`: `r^(k - 1)` times `k` and 1 without pressure,
/// and `r^(k + 1)` times `c k - e` and `c` with the pressure `r^k P_l`. At `r = 1` the form is
/// `-a (f' - p) - l (l + 1) b g'`. No fluid flows through the sphere, so that degree zero has none.
fn dissipation_inside_wall(l: f64, wall: f64) -> Matrix2<f64> {
    if l == 0.0 {
        return Matrix2::zeros();
    }
    // columns: the four solutions, of size one where they are largest
    let mut velocities = Matrix4::zeros();
    let mut tractions = Matrix2x4::zeros();
    for (number, k) in [l, -l - 1.0].into_iter().enumerate() {
        let e = k / ((k + 1.0) * (2.0 * k + 3.0));
        let c = (k + 3.0) / (2.0 * (k + 1.0) * (2.0 * k + 3.0));
        let solutions = [(k, 1.0, k - 1.0, 0.0), (c * k - e, c, k + 1.0, 1.0)];
        for (with_pressure, (f, g, power, p)) in solutions.into_iter().enumerate() {
            let column = 2 * number + with_pressure;
            let [own, at_wall] = match k > 0.0 {
                true => [wall.powf(-power), 1.0],
                false => [1.0, wall.powf(power)],
            };
            velocities.set_column(
                column,
                &(Vector4::new(f * own, g * own, f * at_wall, g * at_wall)),
            );
            let traction = Vector2::new(power * f - p, l * (l + 1.0) * power * g);
            tractions.set_column(column, &(-own * traction));
        }
    }
    let unit = Matrix4x2::identity();
    // the four solutions are independent
    let amplitudes = velocities.lu().solve(&unit).unwrap_or_default();
    let form = tractions * amplitudes;
    0.5 * (form + form.transpose())
}

/// The matrix of the flow outside a sphere, for pure swirl.
pub(crate) fn exterior_swirl(
    mesh: &MeridianMesh,
    order: usize,
    sphere: &OpenSphere,
) -> DMatrix<f64> {
    let trace = Trace::new(mesh, order);
    let mut matrix = DMatrix::zeros(trace.nodes, trace.nodes);
    for l in 1..=degrees() {
        let mut mode = DMatrix::<f64>::zeros(1, trace.nodes);
        for point in &trace.points {
            let [_, dp] = polynomial(l, point.angle);
            for (k, value) in point.values.iter().enumerate() {
                mode[(0, point.first + k)] += point.weight * point.angle.sin() * value * dp;
            }
        }
        let d = l as f64;
        mode *= 0.5 * (2.0 * d + 1.0) / (d * (d + 1.0));
        // c (r^-(l+1) - t r^l) / (1 - t) vanishes on the wall
        let t = (sphere.radius / sphere.wall).powf(2.0 * d + 1.0);
        let slope = (d + 1.0 + d * t) / (1.0 - t);
        let form = 4.0 * PI * sphere.radius * d * (d + 1.0) * slope / (2.0 * d + 1.0);
        matrix += mode.transpose() * form * &mode;
    }
    matrix
}

/// Largest degree `l`.
///
/// Coefficients of the flow decrease as the `l`-th power of the radius of the ball around the
/// bodies over that of the open boundary, their dissipation as its square.
fn degrees() -> usize {
    (MAX_NEGLECTED_DISSIPATION.ln() / (-2.0 * OPEN_RADIUS_RATIO.ln())).ceil() as usize
}

/// `P_l(cos θ)` and its derivative with respect to `θ`.
fn polynomial(l: usize, angle: f64) -> [f64; 2] {
    if l == 0 {
        return [1.0, 0.0];
    }
    let [p, dp, _] = legendre(l, angle.cos());
    [p, -angle.sin() * dp]
}

/// The open boundary with the basis functions of its nodes.
struct Trace {
    nodes: usize,
    points: Vec<TracePoint>,
}

/// A quadrature point of an edge.
struct TracePoint {
    /// Angle `θ` from the axis.
    angle: f64,
    /// Quadrature weight for integrals over `θ`.
    weight: f64,
    /// First node of the edge.
    first: usize,
    /// Basis functions of the edge's nodes.
    values: Vec<f64>,
}

impl Trace {
    fn new(mesh: &MeridianMesh, order: usize) -> Self {
        let edges = open_edges(mesh);
        let nodes = lobatto(order);
        // On an edge, a polynomial of degree `l` in the cosine of an angle is smooth on the scale
        // of `1 / l`: a few points more than half of `l` times half the angle give all digits.
        let widest = edges
            .iter()
            .map(|[left, right]| left - right)
            .fold(0.0, f64::max);
        let turns = (0.5 * degrees() as f64 * widest).ceil() as usize;
        let line = gauss((order + turns) / 2 + EXTRA_POINTS);
        let mut points = Vec::with_capacity(edges.len() * line.len());
        for (e, [left, right]) in edges.iter().enumerate() {
            points.extend(line.iter().map(|&(s, weight)| TracePoint {
                angle: left + s * (right - left),
                weight: weight * (left - right),
                first: e * order,
                values: interpolation(&nodes, s),
            }));
        }
        Self {
            nodes: edges.len() * order + 1,
            points,
        }
    }
}

/// Angles of the two ends of each edge of the open boundary, from left to right.
fn open_edges(mesh: &MeridianMesh) -> Vec<[f64; 2]> {
    let boundary = mesh.boundary.iter().flatten();
    let mut edges: Vec<[f64; 2]> = boundary
        .filter(|edge| edge.part() == BoundaryPart::Open)
        .map(|edge| {
            let [one, other] = edge.parameters.map(|t| PI * t);
            [one.max(other), one.min(other)]
        })
        .collect();
    edges.sort_by(|one, other| other[0].total_cmp(&one[0]));
    edges
}

/// Lagrange polynomials of `nodes` at `x`.
fn interpolation(nodes: &[f64], x: f64) -> Vec<f64> {
    let factor = |i: usize| {
        let others = nodes.iter().enumerate().filter(move |(j, _)| *j != i);
        others
            .map(|(_, node)| (x - node) / (nodes[i] - node))
            .product()
    };
    (0..nodes.len()).map(factor).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::generate::generate;
    use crate::meridian::{GROWTH, Meridian, Surroundings};
    use crate::spheroid::AxialSpheroid;

    /// A mesh around the unit sphere and its open boundary.
    fn mesh() -> (MeridianMesh, OpenSphere) {
        let sphere = [AxialSpheroid::sphere(0.0, 1.0)];
        let meridian = Meridian::new(&sphere, Surroundings::Unbounded).expect("a sphere");
        let open = meridian.open_sphere().expect("unbounded");
        (generate(&meridian, GROWTH).expect("a mesh"), open)
    }

    /// Stokes' law; Kirchhoff's for the torque, inside a wall that of Landau & Lifshitz (section
    /// 20), of which the form omits twice the volume.
    #[test]
    fn a_sphere_of_fluid_that_moves_rigidly_has_the_drag_of_a_sphere() {
        let (mesh, open) = mesh();
        for order in [3, 6] {
            let flow = exterior_flow(&mesh, order, &open);
            let n = flow.nrows() / 2;
            let axial = DVector::from_fn(2 * n, |i, _| if i < n { 1.0 } else { 0.0 });
            let drag = (&flow * &axial).dot(&axial);
            assert!(
                (drag / (6.0 * PI * open.radius) - 1.0).abs() < 1e-12,
                "{drag}"
            );
            let mut azimuthal = DVector::zeros(n);
            let nodes = lobatto(order);
            for (e, [left, right]) in open_edges(&mesh).into_iter().enumerate() {
                for (k, s) in nodes.iter().enumerate() {
                    azimuthal[e * order + k] = open.radius * (left + s * (right - left)).sin();
                }
            }
            for ratio in [f64::INFINITY, 2.0] {
                let wall = ratio * open.radius;
                let swirl = exterior_swirl(&mesh, order, &OpenSphere { wall, ..open });
                let torque = (&swirl * &azimuthal).dot(&azimuthal);
                let resistance = 8.0 / (1.0 - ratio.powi(-3));
                let exact = (resistance - 8.0 / 3.0) * PI * open.radius.powi(3);
                // the sine is interpolated by polynomials
                let tolerance = 0.1_f64.powi(order as i32);
                assert!(
                    (torque / exact - 1.0).abs() < tolerance,
                    "order {order}: {torque}"
                );
            }
        }
    }

    /// Haberman & Sayre (1958).
    #[test]
    fn a_sphere_of_fluid_inside_a_wall_has_the_drag_of_a_sphere() {
        for ratio in [1.2_f64, 2.0, 5.0, 1e3] {
            let x = 1.0 / ratio;
            let form = dissipation_inside_wall(1.0, ratio);
            // the velocity e_z is cos θ along the radius and dcos θ/dθ along the meridian
            let drag = 4.0 * PI / 3.0 * form.sum();
            let exact = 6.0 * PI * (1.0 - x.powi(5))
                / (1.0 - 2.25 * x + 2.5 * x.powi(3) - 2.25 * x.powi(5) + x.powi(6));
            assert!(
                (drag / exact - 1.0).abs() < 1e-9,
                "{ratio}: {drag}, {exact}"
            );
            // far away it is that of unbounded fluid
            for l in [2.0, 7.0, 43.0] {
                let form = dissipation_inside_wall(l, ratio);
                let alone = 2.0 + l * (2.0 * l - 1.0) / (l + 1.0);
                assert!(form[(0, 0)] > alone * (1.0 - 1e-12) && form.determinant() > 0.0);
                if ratio > 10.0 {
                    assert!((form[(0, 0)] / alone - 1.0).abs() < 1e-8);
                    assert!((form[(0, 1)] - l * (l - 2.0)).abs() < 1e-8 * alone);
                }
            }
        }
    }

    /// Eigenvalues are those of the form for each degree: positive except for rounding.
    #[test]
    fn dissipation_outside_is_not_negative() {
        let (mesh, open) = mesh();
        for matrix in [
            exterior_flow(&mesh, 4, &open),
            exterior_swirl(&mesh, 4, &open),
        ] {
            let largest = matrix.amax();
            assert!((&matrix - matrix.transpose()).amax() < 1e-14 * largest);
            assert!(matrix.symmetric_eigenvalues().min() > -1e-13 * largest);
        }
    }
}
