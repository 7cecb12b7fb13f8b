//! The linear system of Stokes flow without swirl for one element order.

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::AxisymmetricError;
use crate::curve::BoundaryPart;
use crate::element::Lagrange;
use crate::forms::{ElementMatrices, enter_divergences};
use crate::geometry_map::{map_points, node_positions};
use crate::mesh::MeridianMesh;
use crate::quadrature::triangle_rule;
use crate::space::Space;
use crate::surface_modes::{SurfaceColumns, SurfaceVelocities};
use crate::system::{Dof, Element, System, condensed, numbered_consecutively};

/// Multiple of the pressure mass subtracted from the factorised matrix.
///
/// Iterative refinement then gains about eight digits per step.
const SHIFT: f64 = 1e-8;

/// Assembles Stokes flow around bodies that move along the axis.
///
/// Continuous velocities of degree `order` and pressures of degree `order - 1` (Taylor-Hood
/// elements, stable in two dimensions for `order >= 2` on three or more triangles, Boffi 1994).
/// Degrees of freedom in the interior of triangles are eliminated by static condensation.
///
/// With `surfaces`, velocities of surfaces are prescribed too ([`SurfaceVelocities`]), beside those
/// of a number of bodies.
///
/// # Errors
/// [`AxisymmetricError::InvertedTriangle`], [`AxisymmetricError::SingularElement`].
pub(crate) fn stokes(
    mesh: &MeridianMesh,
    order: usize,
    surfaces: Option<(usize, &dyn SurfaceColumns)>,
) -> Result<System, AxisymmetricError> {
    let (velocity, pressure) = (Lagrange::new(order)?, Lagrange::new(order - 1)?);
    let spaces = [Space::new(mesh, &velocity), Space::new(mesh, &pressure)];
    let numbering = Numbering::new(mesh, &spaces, [&velocity, &pressure]);
    let matrices = element_matrices(mesh, &velocity, &pressure)?;
    let surfaces = surfaces.map(|(bodies, columns)| {
        SurfaceVelocities::new(columns, bodies, (mesh, &velocity, &spaces[0]), &matrices)
    });
    let mut shift = vec![0.0; numbering.n_dofs];
    for (t, matrices) in matrices.iter().enumerate() {
        let shared = &spaces[1].nodes[t][..pressure.n_shared_nodes()];
        for (&node, mass) in shared.iter().zip(&matrices.pressure_mass) {
            shift[numbering.first_pressure + node as usize] += SHIFT * mass;
        }
    }
    let shared = [&velocity, &pressure].map(Lagrange::n_shared_nodes);
    // local degrees of freedom in the interior of the triangle, in the order of the matrix
    let (n, m) = (velocity.len(), pressure.len());
    let inner: Vec<usize> = (shared[0]..n)
        .chain(n + shared[0]..2 * n)
        .chain(2 * n + shared[1]..2 * n + m)
        .collect();
    let elements = (matrices.into_par_iter().enumerate())
        .map(|(t, matrices)| {
            let nodes = [0, 1].map(|k| &spaces[k].nodes[t][..shared[k]]);
            let matrix = condensed(&saddle_point_matrix(&matrices), &inner)
                .ok_or(AxisymmetricError::SingularElement { triangle: t })?;
            let dofs = numbering.dofs(nodes[0], nodes[1]);
            let (dofs, matrix) = match &surfaces {
                Some(surfaces) => surfaces.with_columns(t, dofs, matrix),
                None => (dofs, matrix),
            };
            Ok(Element { dofs, matrix })
        })
        .collect::<Result<_, AxisymmetricError>>()?;
    Ok(System {
        elements,
        n_dofs: numbering.n_dofs,
        shift,
        traces: numbering.traces(mesh, &spaces, [&velocity, &pressure]),
        group: numbering.group,
    })
}

/// Matrices of the bilinear forms on every element.
///
/// # Errors
/// [`AxisymmetricError::InvertedTriangle`].
pub(crate) fn element_matrices(
    mesh: &MeridianMesh,
    velocity: &Lagrange,
    pressure: &Lagrange,
) -> Result<Vec<ElementMatrices>, AxisymmetricError> {
    let order = velocity.order();
    // The small rule is exact on straight elements except for the term with 1 / r. The large one is
    // for elements that touch the axis, where 1 / r is singular at a corner, and for curved ones,
    // where it is exact for the divergence.
    let rules = [order + 3, 2 * order].map(triangle_rule);
    let tables = rules
        .each_ref()
        .map(|rule| [velocity.tabulate(rule), pressure.tabulate(rule)]);
    (0..mesh.triangles.len())
        .into_par_iter()
        .map(|t| {
            let needs_large_rule =
                mesh.is_curved(t) || mesh.triangles[t].iter().any(|&v| mesh.points[v].y == 0.0);
            let (rule, [u, p]) = (
                &rules[usize::from(needs_large_rule)],
                &tables[usize::from(needs_large_rule)],
            );
            let positions = node_positions(mesh, t, velocity);
            let points = map_points(t, &positions, u, rule)?;
            Ok(ElementMatrices::new(&points, u, p))
        })
        .collect()
}

/// The degrees of freedom of all nodes on vertices and edges: axial velocities, then radial
/// velocities, then pressures.
struct Numbering {
    axial: Vec<Dof>,
    radial: Vec<Dof>,
    first_pressure: usize,
    n_dofs: usize,
    group: Vec<u32>,
}

impl Numbering {
    fn new(mesh: &MeridianMesh, spaces: &[Space; 2], elements: [&Lagrange; 2]) -> Self {
        let parts = spaces[0].parts(mesh, elements[0]);
        let entities = [0, 1].map(|k| spaces[k].entities(mesh, elements[k]));
        let mut group = Vec::new();
        let mut number = |node: usize, space: usize| {
            group.push(entities[space][node]);
            Dof::Free(group.len() as u32 - 1)
        };
        let axial = (0..spaces[0].first_inside)
            .map(|node| match parts[node] {
                Some(BoundaryPart::Body(body)) => Dof::Body(body),
                Some(BoundaryPart::Wall) => Dof::Constrained,
                Some(BoundaryPart::Axis | BoundaryPart::Open | BoundaryPart::Interface(_))
                | None => number(node, 0),
            })
            .collect();
        let radial = (0..spaces[0].first_inside)
            .map(|node| match parts[node] {
                Some(_) => Dof::Constrained,
                None => number(node, 0),
            })
            .collect();
        for node in 0..spaces[1].first_inside {
            number(node, 1);
        }
        let n_dofs = group.len();
        Self {
            axial,
            radial,
            first_pressure: n_dofs - spaces[1].first_inside,
            n_dofs,
            group: numbered_consecutively(group),
        }
    }

    /// Degrees of freedom on boundaries in the fluid, in the order of [`Self::dofs`].
    fn traces(
        &self,
        mesh: &MeridianMesh,
        spaces: &[Space; 2],
        elements: [&Lagrange; 2],
    ) -> BTreeMap<BoundaryPart, Vec<Dof>> {
        let [velocities, mut pressures] = [0, 1].map(|k| spaces[k].traces(mesh, elements[k]));
        (velocities.into_iter())
            .map(|(part, nodes)| {
                let pressures = pressures.remove(&part).unwrap_or_default();
                (part, self.dofs(&nodes, &pressures))
            })
            .collect()
    }

    /// Degrees of freedom of an element with these nodes, in the order of its matrix.
    fn dofs(&self, velocities: &[u32], pressures: &[u32]) -> Vec<Dof> {
        let of =
            |list: &[Dof]| -> Vec<Dof> { velocities.iter().map(|&i| list[i as usize]).collect() };
        let mut dofs = of(&self.axial);
        dofs.extend(of(&self.radial));
        dofs.extend(
            pressures
                .iter()
                .map(|&i| Dof::Free(self.first_pressure as u32 + i)),
        );
        dofs
    }
}

/// The element matrix `[A_z, 0, B_z^T; 0, A_r, B_r^T; B_z, B_r, 0]`.
pub(crate) fn saddle_point_matrix(m: &ElementMatrices) -> DMatrix<f64> {
    let (n, k) = (m.axial.nrows(), m.divergence_axial.nrows());
    let mut matrix = DMatrix::zeros(2 * n + k, 2 * n + k);
    matrix.view_mut((0, 0), (n, n)).copy_from(&m.axial);
    matrix.view_mut((n, n), (n, n)).copy_from(&m.radial);
    enter_divergences([&m.divergence_axial, &m.divergence_radial], &mut matrix);
    matrix
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::curve::Point;
    use crate::generate::generate;
    use crate::meridian::{Meridian, Surroundings};
    use crate::spheroid::AxialSpheroid;

    fn mesh(bodies: &[AxialSpheroid], surroundings: Surroundings, growth: f64) -> MeridianMesh {
        let meridian = Meridian::new(bodies, surroundings).expect("valid bodies");
        generate(&meridian, growth).expect("a simple domain")
    }

    /// For polynomial flows in the space all rows of the residual vanish, except those of curved
    /// elements.
    #[test]
    fn polynomial_flows_have_zero_residual_on_straight_elements() {
        let bodies = [
            AxialSpheroid::sphere(-1.5, 1.0),
            AxialSpheroid::sphere(2.0, 0.5),
        ];
        let mesh = mesh(&bodies, Surroundings::Cylinder { radius: 4.0 }, 0.4);
        // (u_z, u_r, p) of Poiseuille flow plus a stagnation flow whose strength grows along the
        // axis
        let flow = |x: &Point| [x.y * x.y + x.x * x.x, -x.y * x.x, 6.0 * x.x];
        for order in [2, 3, 5] {
            let stokes = stokes(&mesh, order, None).expect("solvable");
            let [velocity, pressure] =
                [order, order - 1].map(|k| Lagrange::new(k).expect("low order"));
            // per row: residual, sum of absolute terms, whether all its elements are straight
            let mut rows = vec![(0.0_f64, 0.0_f64, true); stokes.n_dofs];
            for (t, element) in stokes.elements.iter().enumerate() {
                let positions = node_positions(&mesh, t, &velocity);
                let corners = mesh.triangles[t].map(|v| mesh.points[v]);
                let pressures = pressure
                    .nodes
                    .iter()
                    .map(|l| flow(&(corners[0] * l[0] + corners[1] * l[1] + corners[2] * l[2]))[2]);
                // what is in the interior is eliminated
                let [n, m] = [&velocity, &pressure].map(Lagrange::n_shared_nodes);
                let values: Vec<f64> = (positions.iter().take(n).map(|x| flow(x)[0]))
                    .chain(positions.iter().take(n).map(|x| flow(x)[1]))
                    .chain(pressures.take(m))
                    .collect();
                for (local, dof) in element.dofs.iter().enumerate() {
                    let Dof::Free(row) = *dof else { continue };
                    let terms = element.matrix.column(local);
                    let row = &mut rows[row as usize];
                    for (a, v) in terms.iter().zip(&values) {
                        row.0 += a * v;
                        row.1 += (a * v).abs();
                    }
                    row.2 &= !mesh.is_curved(t);
                }
            }
            let straight = rows.iter().filter(|row| row.2);
            assert!(straight.clone().count() > stokes.n_dofs / 2);
            for (sum, size, _) in straight {
                assert!(
                    sum.abs() < 1e-11 * size.max(1.0),
                    "order {order}: residual {sum:e}, terms {size:e}"
                );
            }
        }
    }

    #[test]
    fn volume_between_concentric_spheres_is_exact_to_the_geometry_error() {
        let mesh = mesh(
            &[AxialSpheroid::sphere(0.3, 1.0)],
            Surroundings::Ball { radius: 3.0 },
            0.7,
        );
        let element = Lagrange::new(6).expect("low order");
        let rule = triangle_rule(10);
        let table = element.tabulate(&rule);
        let volume: f64 = (0..mesh.triangles.len())
            .flat_map(|t| {
                map_points(t, &node_positions(&mesh, t, &element), &table, &rule).expect("solvable")
            })
            .map(|point| point.measure)
            .sum();
        // 3^3 - 1^3 = 26 unit balls; each edge of the surface is a polynomial of degree six
        assert!(
            (volume / (4.0 / 3.0 * PI * 26.0) - 1.0).abs() < 1e-8,
            "{volume}"
        );
    }

    /// The error of the drag is the square of the energy error of the velocity: `O(h^(2 k))`.
    #[test]
    fn drag_converges_at_twice_the_order() {
        let l = 0.5_f64;
        // Haberman & Sayre (1958)
        let exact = 6.0 * PI * (1.0 - l.powi(5))
            / (1.0 - 2.25 * l + 2.5 * l.powi(3) - 2.25 * l.powi(5) + l.powi(6));
        for (order, sizes) in [(2, [0.3, 0.15, 0.075]), (3, [0.4, 0.2, 0.1])] {
            let points = sizes.map(|growth| {
                let mesh = mesh(
                    &[AxialSpheroid::sphere(0.0, 1.0)],
                    Surroundings::Ball { radius: 2.0 },
                    growth,
                );
                let solution = stokes(&mesh, order, None)
                    .and_then(|s| s.resistance(1))
                    .expect("solvable");
                let error = solution.resistance[(0, 0)] / exact - 1.0;
                ((mesh.triangles.len() as f64).ln() / 2.0, error.abs().ln())
            });
            let slope = (points[0].1 - points[2].1) / (points[2].0 - points[0].0);
            // the tolerance is wide because the meshes are not uniform refinements of each other
            let theory = 2.0 * order as f64;
            assert!(
                (slope - theory).abs() < 0.15 * theory,
                "order {order}: {slope}"
            );
        }
    }
}
