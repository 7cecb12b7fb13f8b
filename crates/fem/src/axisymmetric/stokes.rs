//! The linear system of one order of elements, and the forces on bodies that move along the axis.

use linalg::{Csr, ShiftedLdlt};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::element::Lagrange;
use super::forms::ElementMatrices;
use super::meridian::Side;
use super::mesh::MeridianMesh;
use super::rule::triangle_rule;
use super::shape::{bends, map_points, node_places};
use super::space::Space;
use crate::FemError;

/// Stokes flow by elements of one order.
pub(super) struct Stokes {
    elements: Vec<Element>,
    unknowns: usize,
    /// Subtracted from the diagonal of the factors.
    shift: Vec<f64>,
    /// The vertex, edge or triangle of each unknown.
    group: Vec<u32>,
}

/// Resistance matrix and what it took.
pub(super) struct Solution {
    pub resistance: DMatrix<f64>,
    pub unknowns: usize,
    pub residual: f64,
}

struct Element {
    dofs: Vec<Dof>,
    /// Over velocities along the axis, away from it, and pressures.
    matrix: DMatrix<f64>,
}

/// What a velocity component or a pressure at a node is.
#[derive(Clone, Copy, PartialEq)]
enum Dof {
    Unknown(u32),
    /// Zero.
    Held,
    /// The velocity of a body.
    Body(usize),
}

/// Part of the pressures' mass subtracted in the factors: eight digits a step of refinement.
const SHIFT: f64 = 1e-8;

impl Stokes {
    /// Assembles with velocities of degree `order` and pressures of one less, both continuous (Taylor & Hood; stable in two dimensions
    /// for `order >= 2` on three triangles or more, Boffi 1994).
    ///
    /// # Errors
    /// [`FemError::Axisymmetric`] where an element is inverted.
    pub fn new(mesh: &MeridianMesh, order: usize) -> Result<Self, FemError> {
        let (velocity, pressure) = (Lagrange::new(order)?, Lagrange::new(order - 1)?);
        let spaces = [Space::new(mesh, &velocity), Space::new(mesh, &pressure)];
        let numbering = Numbering::new(mesh, &spaces, [&velocity, &pressure]);
        // on straight elements exact but for 1 / r where an element meets the axis in a corner; on curved ones for the divergence
        let rules = [order + 3, 2 * order].map(triangle_rule);
        let tables = rules
            .each_ref()
            .map(|rule| [velocity.tabulate(rule), pressure.tabulate(rule)]);
        let matrices = (0..mesh.triangles.len())
            .into_par_iter()
            .map(|t| {
                let rich =
                    bends(mesh, t) || mesh.triangles[t].iter().any(|&v| mesh.points[v].y == 0.0);
                let (rule, [u, p]) = (&rules[usize::from(rich)], &tables[usize::from(rich)]);
                let places = node_places(mesh, t, &velocity);
                let points = map_points(t, &places, u, rule)?;
                Ok(ElementMatrices::new(&points, u, p))
            })
            .collect::<Result<Vec<_>, FemError>>()?;
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
        Ok(Self {
            elements,
            unknowns: numbering.unknowns,
            shift,
            group: numbering.group,
        })
    }

    /// Forces on the fluid, one column for each of `bodies` moving at unit speed: what the momentum equation at the nodes of a body
    /// leaves (the consistent force), in which errors are second order.
    ///
    /// # Errors
    /// A factorisation or refinement that fails.
    pub fn resistance(&self, bodies: usize) -> Result<Solution, FemError> {
        let mut solver = ShiftedLdlt::factor(self.matrix(), &self.shift, &self.group)?;
        let mut resistance = DMatrix::zeros(bodies, bodies);
        let mut worst = 0.0_f64;
        let mut flow = vec![0.0; self.unknowns];
        for body in 0..bodies {
            let mut right = vec![0.0; self.unknowns];
            for element in &self.elements {
                element.rows_of(body, |dof, value| {
                    if let Dof::Unknown(i) = dof {
                        right[i as usize] -= value;
                    }
                });
            }
            worst = worst.max(solver.solve(&right, &mut flow)?);
            for element in &self.elements {
                element.forces(body, &flow, |on, force| resistance[(on, body)] += force);
            }
        }
        Ok(Solution {
            // symmetric up to the residual of the solve
            resistance: 0.5 * (&resistance + resistance.transpose()),
            unknowns: self.unknowns,
            residual: worst,
        })
    }

    /// The system of the unknowns.
    fn matrix(&self) -> Csr {
        let n = self.unknowns;
        let mut visits: Vec<Vec<(u32, u32)>> = vec![Vec::new(); n];
        for (e, element) in self.elements.iter().enumerate() {
            for (local, dof) in element.dofs.iter().enumerate() {
                if let Dof::Unknown(i) = dof {
                    visits[*i as usize].push((e as u32, local as u32));
                }
            }
        }
        let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        let mut sums = vec![0.0; n];
        let mut met_by = vec![usize::MAX; n];
        for (i, visits) in visits.iter().enumerate() {
            let first = columns.len();
            for &(e, local) in visits {
                let element = &self.elements[e as usize];
                // symmetric: a column is a row
                let row = element.matrix.column(local as usize);
                for (dof, value) in element.dofs.iter().zip(row.iter()) {
                    let Dof::Unknown(j) = *dof else { continue };
                    if met_by[j as usize] != i {
                        met_by[j as usize] = i;
                        sums[j as usize] = 0.0;
                        columns.push(j);
                    }
                    sums[j as usize] += value;
                }
            }
            columns[first..].sort_unstable();
            values.extend(columns[first..].iter().map(|&j| sums[j as usize]));
            starts.push(columns.len());
        }
        Csr::new((n, n), starts, columns, values)
    }
}

impl Element {
    /// Calls `add` with every row's sum over the columns of a body.
    fn rows_of(&self, body: usize, mut add: impl FnMut(Dof, f64)) {
        for (local, dof) in self.dofs.iter().enumerate() {
            if *dof == Dof::Body(body) {
                for (row, value) in self.dofs.iter().zip(self.matrix.column(local).iter()) {
                    add(*row, *value);
                }
            }
        }
    }

    /// Calls `add` with forces on bodies in the flow of one of them moving at unit speed.
    fn forces(&self, moving: usize, flow: &[f64], mut add: impl FnMut(usize, f64)) {
        for (local, dof) in self.dofs.iter().enumerate() {
            let Dof::Body(on) = *dof else { continue };
            let column = self.matrix.column(local);
            let sum: f64 = self
                .dofs
                .iter()
                .zip(column.iter())
                .map(|(dof, value)| match *dof {
                    Dof::Unknown(i) => value * flow[i as usize],
                    Dof::Body(body) if body == moving => *value,
                    Dof::Body(_) | Dof::Held => 0.0,
                })
                .sum();
            add(on, sum);
        }
    }
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

/// Group numbers without those that nothing is in.
fn without_gaps(group: Vec<u32>) -> Vec<u32> {
    let most = group.iter().max().map_or(0, |&g| g as usize + 1);
    let mut new = vec![None; most];
    let mut count = 0;
    group
        .into_iter()
        .map(|g| {
            *new[g as usize].get_or_insert_with(|| {
                count += 1;
                count - 1
            })
        })
        .collect()
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
    use crate::axisymmetric::meridian::{Meridian, Point, Spheroid, Surroundings};

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
            let stokes = Stokes::new(&mesh, order).expect("sound");
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
                let solution = Stokes::new(&mesh, order)
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
