//! The linear system of flow without swirl by one order of elements.

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::AxisymmetricError;
use crate::element::Lagrange;
use crate::forms::ElementMatrices;
use crate::meridian::Side;
use crate::mesh::MeridianMesh;
use crate::rule::triangle_rule;
use crate::shape::{bends, map_points, node_places};
use crate::space::Space;
use crate::system::{Dof, Element, System, without_gaps};

/// Part of the pressures' mass subtracted in the factors: eight digits a step of refinement.
const SHIFT: f64 = 1e-8;

/// Stokes flow by velocities of degree `order` and pressures of one less, both continuous (Taylor & Hood; stable in two dimensions
/// for `order >= 2` on three triangles or more, Boffi 1994). Bodies move along the axis.
///
/// # Errors
/// [`AxisymmetricError::InvertedTriangle`] where an element is inverted.
pub(crate) fn stokes(mesh: &MeridianMesh, order: usize) -> Result<System, AxisymmetricError> {
    let (velocity, pressure) = (Lagrange::new(order)?, Lagrange::new(order - 1)?);
    let spaces = [Space::new(mesh, &velocity), Space::new(mesh, &pressure)];
    let numbering = Numbering::new(mesh, &spaces, [&velocity, &pressure]);
    let matrices = element_matrices(mesh, &velocity, &pressure)?;
    let mut shift = vec![0.0; numbering.unknowns];
    for (t, matrices) in matrices.iter().enumerate() {
        for (&node, mass) in spaces[1].nodes[t].iter().zip(&matrices.pressure_mass) {
            shift[numbering.first_pressure + node as usize] += SHIFT * mass;
        }
    }
    let elements = matrices
        .into_iter()
        .enumerate()
        .map(|(t, matrices)| Element {
            dofs: numbering.dofs(&spaces[0].nodes[t], &spaces[1].nodes[t]),
            matrix: joined(&matrices),
        })
        .collect();
    Ok(System {
        elements,
        unknowns: numbering.unknowns,
        shift,
        group: numbering.group,
    })
}

/// The forms on every element.
///
/// # Errors
/// [`AxisymmetricError::InvertedTriangle`] where an element is inverted.
pub(crate) fn element_matrices(
    mesh: &MeridianMesh,
    velocity: &Lagrange,
    pressure: &Lagrange,
) -> Result<Vec<ElementMatrices>, AxisymmetricError> {
    let order = velocity.order();
    // on straight elements exact but for 1 / r where an element meets the axis in a corner; on curved ones for the divergence
    let rules = [order + 3, 2 * order].map(triangle_rule);
    let tables = rules
        .each_ref()
        .map(|rule| [velocity.tabulate(rule), pressure.tabulate(rule)]);
    (0..mesh.triangles.len())
        .into_par_iter()
        .map(|t| {
            let rich = bends(mesh, t) || mesh.triangles[t].iter().any(|&v| mesh.points[v].y == 0.0);
            let (rule, [u, p]) = (&rules[usize::from(rich)], &tables[usize::from(rich)]);
            let places = node_places(mesh, t, velocity);
            let points = map_points(t, &places, u, rule)?;
            Ok(ElementMatrices::new(&points, u, p))
        })
        .collect()
}

/// Which nodes are unknown: velocities along the axis, then away from it, then pressures.
struct Numbering {
    axial: Vec<Dof>,
    radial: Vec<Dof>,
    first_pressure: usize,
    unknowns: usize,
    group: Vec<u32>,
}

impl Numbering {
    fn new(mesh: &MeridianMesh, spaces: &[Space; 2], elements: [&Lagrange; 2]) -> Self {
        let sides = spaces[0].sides(mesh, elements[0]);
        let entities = [0, 1].map(|k| spaces[k].entities(mesh, elements[k]));
        let mut group = Vec::new();
        let mut number = |node: usize, space: usize| {
            group.push(entities[space][node]);
            Dof::Unknown(group.len() as u32 - 1)
        };
        let axial = (0..spaces[0].len)
            .map(|node| match sides[node] {
                Some(Side::Body(body)) => Dof::Body(body),
                Some(Side::Wall) => Dof::Held,
                Some(Side::Axis) | None => number(node, 0),
            })
            .collect();
        let radial = (0..spaces[0].len)
            .map(|node| match sides[node] {
                Some(_) => Dof::Held,
                None => number(node, 0),
            })
            .collect();
        for node in 0..spaces[1].len {
            number(node, 1);
        }
        let unknowns = group.len();
        Self {
            axial,
            radial,
            first_pressure: unknowns - spaces[1].len,
            unknowns,
            group: without_gaps(group),
        }
    }

    fn dofs(&self, velocities: &[u32], pressures: &[u32]) -> Vec<Dof> {
        let of =
            |list: &[Dof]| -> Vec<Dof> { velocities.iter().map(|&i| list[i as usize]).collect() };
        let mut dofs = of(&self.axial);
        dofs.extend(of(&self.radial));
        dofs.extend(
            pressures
                .iter()
                .map(|&i| Dof::Unknown(self.first_pressure as u32 + i)),
        );
        dofs
    }
}

/// `[A_z, 0, B_z^T; 0, A_r, B_r^T; B_z, B_r, 0]`.
fn joined(m: &ElementMatrices) -> DMatrix<f64> {
    let (n, k) = (m.axial.nrows(), m.divergence_axial.nrows());
    let mut joined = DMatrix::zeros(2 * n + k, 2 * n + k);
    joined.view_mut((0, 0), (n, n)).copy_from(&m.axial);
    joined.view_mut((n, n), (n, n)).copy_from(&m.radial);
    for (at, divergence) in [(0, &m.divergence_axial), (n, &m.divergence_radial)] {
        joined.view_mut((2 * n, at), (k, n)).copy_from(divergence);
        joined
            .view_mut((at, 2 * n), (n, k))
            .copy_from(&divergence.transpose());
    }
    joined
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::meridian::{Meridian, Point, Spheroid, Surroundings};

    fn mesh(bodies: &[Spheroid], surroundings: Surroundings, growth: f64) -> MeridianMesh {
        let meridian = Meridian::new(bodies, surroundings).expect("room for all");
        MeridianMesh::generate(&meridian, growth).expect("a plain domain")
    }

    /// Rows of the momentum equation and of incompressibility vanish for flows of low degree, wherever elements are straight.
    #[test]
    fn polynomial_flows_are_exact() {
        let bodies = [Spheroid::sphere(-1.5, 1.0), Spheroid::sphere(2.0, 0.5)];
        let mesh = mesh(&bodies, Surroundings::Cylinder { radius: 4.0 }, 0.4);
        // Poiseuille flow, and a stagnation flow whose strength grows along the axis
        let flow = |x: &Point| [x.y * x.y + x.x * x.x, -x.y * x.x, 6.0 * x.x];
        for order in [2, 3, 5] {
            let stokes = stokes(&mesh, order).expect("sound");
            let [velocity, pressure] = [order, order - 1].map(|k| Lagrange::new(k).expect("low"));
            let mut rows = vec![(0.0_f64, 0.0_f64, true); stokes.unknowns];
            for (t, element) in stokes.elements.iter().enumerate() {
                let places = node_places(&mesh, t, &velocity);
                let corners = mesh.triangles[t].map(|v| mesh.points[v]);
                let on_straight = pressure
                    .nodes
                    .iter()
                    .map(|l| flow(&(corners[0] * l[0] + corners[1] * l[1] + corners[2] * l[2]))[2]);
                let values: Vec<f64> = (places.iter().map(|x| flow(x)[0]))
                    .chain(places.iter().map(|x| flow(x)[1]))
                    .chain(on_straight)
                    .collect();
                for (local, dof) in element.dofs.iter().enumerate() {
                    let Dof::Unknown(row) = *dof else { continue };
                    let terms = element.matrix.column(local);
                    let row = &mut rows[row as usize];
                    for (a, v) in terms.iter().zip(&values) {
                        row.0 += a * v;
                        row.1 += (a * v).abs();
                    }
                    row.2 &= !bends(&mesh, t);
                }
            }
            // at ends of the tube the axis goes on into a wall, where rows are no equations but are not unknowns either
            let straight = rows.iter().filter(|row| row.2);
            assert!(straight.clone().count() > stokes.unknowns / 2);
            for (sum, size, _) in straight {
                assert!(
                    sum.abs() < 1e-11 * size.max(1.0),
                    "order {order}: {sum:e} of {size:e}"
                );
            }
        }
    }

    #[test]
    fn nothing_is_lost_of_the_area_of_the_sphere_s_surroundings() {
        let mesh = mesh(
            &[Spheroid::sphere(0.3, 1.0)],
            Surroundings::Ball { radius: 3.0 },
            0.7,
        );
        let element = Lagrange::new(6).expect("low");
        let rule = triangle_rule(10);
        let table = element.tabulate(&rule);
        let volume: f64 = (0..mesh.triangles.len())
            .flat_map(|t| {
                map_points(t, &node_places(&mesh, t, &element), &table, &rule).expect("sound")
            })
            .map(|point| point.measure)
            .sum();
        // 26 parts of 27 of a ball of radius 3; the surface is a polynomial of degree six an edge
        assert!(
            (volume / (4.0 / 3.0 * PI * 26.0) - 1.0).abs() < 1e-8,
            "{volume}"
        );
    }

    /// Drag errs by the square of the velocity's error: `h^(2 k)`.
    #[test]
    fn drag_converges_at_twice_the_order() {
        let l = 0.5_f64;
        // Haberman & Sayre (1958)
        let exact = 6.0 * PI * (1.0 - l.powi(5))
            / (1.0 - 2.25 * l + 2.5 * l.powi(3) - 2.25 * l.powi(5) + l.powi(6));
        for (order, sizes) in [(2, [0.3, 0.15, 0.075]), (3, [0.4, 0.2, 0.1])] {
            let points = sizes.map(|growth| {
                let mesh = mesh(
                    &[Spheroid::sphere(0.0, 1.0)],
                    Surroundings::Ball { radius: 2.0 },
                    growth,
                );
                let solution = stokes(&mesh, order)
                    .and_then(|s| s.resistance(1))
                    .expect("sound");
                let error = solution.resistance[(0, 0)] / exact - 1.0;
                ((mesh.triangles.len() as f64).ln() / 2.0, error.abs().ln())
            });
            let slope = (points[0].1 - points[2].1) / (points[2].0 - points[0].0);
            // meshes are not similar, and bodies are smooth for orders above
            let theory = 2.0 * order as f64;
            assert!(
                (slope - theory).abs() < 0.15 * theory,
                "order {order}: {slope}"
            );
        }
    }
}
