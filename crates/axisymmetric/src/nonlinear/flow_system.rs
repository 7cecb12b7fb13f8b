//! The nonlinear system of a flow with inertia around bodies that move along the axis.

use std::sync::{Arc, OnceLock};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::momentum::{Coefficients, LocalValues, MomentumElement, Rule};
use super::nested_condensation::{CondensedFactors, ElementUnknowns, NestedCondensation, Singular};
use crate::AxisymmetricError;
use crate::curve::{BoundaryPart, Point};
use crate::element::Lagrange;
use crate::geometry_map::node_positions;
use crate::meridian::OpenSphere;
use crate::mesh::MeridianMesh;
use crate::open_boundary::exterior_flow;
use crate::space::Space;

impl From<Singular> for AxisymmetricError {
    fn from(singular: Singular) -> Self {
        Self::SingularElement {
            triangle: singular.element,
        }
    }
}

/// A velocity and a pressure per node, and the velocities of the free motions.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
pub(crate) struct Fields {
    pub velocity: Vec<Point>,
    pub pressure: Vec<f64>,
    pub motions: Vec<f64>,
}

impl Fields {
    /// Adds a multiple of a change.
    pub fn add(&mut self, change: &Self, length: f64) {
        for (u, change) in self.velocity.iter_mut().zip(&change.velocity) {
            *u += length * change;
        }
        for (p, change) in self.pressure.iter_mut().zip(&change.pressure) {
            *p += length * change;
        }
        for (motion, change) in self.motions.iter_mut().zip(&change.motions) {
            *motion += length * change;
        }
    }

    /// The largest velocity of this change relative to the largest one of a flow.
    pub fn relative_to(&self, flow: &Self) -> f64 {
        // the maximum of numbers ignores NaN
        let largest_change = self
            .velocity
            .iter()
            .fold(0.0, |largest: f64, u| match u.amax() {
                size if size.is_finite() => largest.max(size),
                _ => f64::INFINITY,
            });
        let largest = (flow.velocity.iter()).fold(0.0, |m: f64, u| m.max(u.amax()));
        match largest_change == 0.0 {
            true => 0.0,
            false => largest_change / largest,
        }
    }
}

/// Prescribed velocities on the boundary.
pub(crate) struct BoundaryVelocity {
    /// Velocity of each body, without that of its free motion.
    pub bodies: Vec<f64>,
    /// Velocity of the surface relative to its body at each node; empty without slip.
    pub slip: Vec<Point>,
    /// Velocity of the wall along the axis.
    pub wall: f64,
}

/// Terms of the momentum equation: see [`super::momentum`].
#[derive(Clone, Copy, Default)]
pub(crate) struct Terms<'a> {
    pub coefficients: Coefficients<'a>,
    /// `w` at each node, without that of [`FlowSystem::frame`].
    pub mesh_velocity: Option<&'a [f64]>,
    /// `h` at each node.
    pub history: Option<&'a [Point]>,
}

/// Residuals of the equations at all nodes.
pub(crate) struct Residual {
    /// Residual of the momentum equation; on a body the force that it exerts on the fluid there.
    pub momentum: Vec<Point>,
    pub continuity: Vec<f64>,
}

impl Residual {
    /// Power of the forces at the nodes with these velocities, one each; zero for an empty list.
    pub fn power(&self, velocities: &[Point]) -> f64 {
        let forces = velocities.iter().zip(&self.momentum);
        forces.map(|(u, force)| u.dot(force)).sum()
    }

    /// Subtracts other residuals.
    pub fn subtract(&mut self, other: &Self) {
        for (own, other) in self.momentum.iter_mut().zip(&other.momentum) {
            *own -= other;
        }
        for (own, other) in self.continuity.iter_mut().zip(&other.continuity) {
            *own -= other;
        }
    }
}

/// The balance of forces of the free motions: `matrix U - load` is the part that is not exerted by
/// the fluid.
pub(crate) struct Balance {
    pub matrix: DMatrix<f64>,
    pub load: Vec<f64>,
}

/// A discrete flow: mesh, elements and unknowns.
///
/// Unknowns are numbered: axial velocities of all nodes, radial velocities, pressures, velocities
/// of free motions. The axial velocity of a node on a body is that of the body's motion.
pub(crate) struct FlowSystem {
    pub(super) mesh: Arc<MeridianMesh>,
    pub(super) velocity: Lagrange,
    pub(super) pressure: Lagrange,
    /// Of velocities and of pressures.
    pub(super) spaces: [Space; 2],
    n_nodes: [usize; 2],
    /// Boundary part of the first velocity nodes, those on vertices and edges.
    pub(super) parts: Vec<Option<BoundaryPart>>,
    /// A small rule for straight elements off the axis, a large one for the others, and one for
    /// viscosities that vary.
    rules: [Rule; 3],
    /// Unknown that determines each value; `None` for prescribed values.
    roles: Vec<Option<u32>>,
    condensation: Arc<NestedCondensation>,
    /// The same for a potential, with one unknown per velocity node but the first; made when it is
    /// needed first.
    potential: OnceLock<Arc<NestedCondensation>>,
    /// Unbounded fluid beyond the mesh, at viscosity 1.
    pub(super) exterior: Option<Exterior>,
    pub(super) motions: Vec<Option<usize>>,
    n_motions: usize,
    /// Free motion with which the whole mesh moves.
    frame: Option<usize>,
}

/// The flow beyond an open boundary: see [`crate::open_boundary`].
pub(super) struct Exterior {
    /// Radius of the boundary and position of its centre.
    pub radius: f64,
    pub centre: f64,
    /// Nodes of the boundary from left to right.
    nodes: Vec<u32>,
    /// Of axial and then radial velocities.
    matrix: DMatrix<f64>,
}

impl Exterior {
    /// The tractions of velocities on the boundary, axial ones first, at viscosity 1.
    pub fn tractions(&self, velocity: &[Point]) -> (DVector<f64>, DVector<f64>) {
        let n = self.nodes.len();
        let at = |i: usize| velocity[self.nodes[i % n] as usize][i / n];
        let velocities = DVector::from_fn(2 * n, |i, _| at(i));
        (&self.matrix * &velocities, velocities)
    }
}

/// Reduction of the change per iteration above which the matrix is factorised again.
///
/// A factorisation costs about as much as five evaluations of the residual.
pub(crate) const MAX_CHORD_REDUCTION: f64 = 0.1;

impl FlowSystem {
    /// The unknowns of elements of this order, for bodies with these free motions.
    ///
    /// # Errors
    /// [`AxisymmetricError::NoNodalBasis`].
    pub fn new(
        mesh: impl Into<Arc<MeridianMesh>>,
        order: usize,
        motions: Vec<Option<usize>>,
        n_motions: usize,
        frame: Option<usize>,
        open_sphere: Option<OpenSphere>,
    ) -> Result<Self, AxisymmetricError> {
        let mesh = mesh.into();
        let [velocity, pressure] = [Lagrange::new(order)?, Lagrange::new(order - 1)?];
        let spaces = [Space::new(&mesh, &velocity), Space::new(&mesh, &pressure)];
        let n_nodes = [(&spaces[0], &velocity), (&spaces[1], &pressure)].map(|(space, element)| {
            space.first_inside + element.n_inner_nodes() * mesh.triangles.len()
        });
        let parts = spaces[0].parts(&mesh, &velocity);
        let [n, m] = n_nodes;
        let motion = |g: usize| (2 * n + m + g) as u32;
        let part = |node: usize| parts.get(node).copied().flatten();
        let axial = (0..n).map(|node| match part(node) {
            Some(BoundaryPart::Body(body)) => motions[body].map(motion),
            Some(BoundaryPart::Wall) => None,
            _ => Some(node as u32),
        });
        let radial = (0..n).map(|node| match part(node) {
            Some(_) => None,
            None => Some((n + node) as u32),
        });
        // The pressure is determined up to a constant; that of the first node is zero. Its
        // equation follows from the others, because no fluid enters or leaves. In unbounded fluid
        // it is determined by its decay.
        let first = usize::from(open_sphere.is_none());
        let pressures = (0..m).map(|node| (node >= first).then_some((2 * n + node) as u32));
        let all_motions = (0..n_motions).map(|g| Some(motion(g)));
        let roles: Vec<Option<u32>> = (axial.chain(radial).chain(pressures))
            .chain(all_motions.clone())
            .collect();
        let mut unknowns = element_unknowns(&spaces, n_nodes, &roles);
        let mut centres = centres(&mesh);
        if let Some(g) = frame {
            unknowns
                .iter_mut()
                .for_each(|list| list.push(Some(motion(g))));
        }
        // the balance of forces is one more element, with no place of its own
        unknowns.push(all_motions.collect());
        centres.push(Point::zeros());
        let exterior = open_sphere.map(|sphere| Exterior {
            radius: sphere.radius,
            centre: sphere.centre,
            nodes: (spaces[0].traces(&mesh, &velocity))
                .remove(&BoundaryPart::Open)
                .unwrap_or_default(),
            matrix: exterior_flow(&mesh, order, &sphere),
        });
        if let Some(exterior) = &exterior {
            let of = |first: usize| (exterior.nodes.iter()).map(move |&node| first + node as usize);
            unknowns.push(of(0).chain(of(n)).map(|i| roles[i]).collect());
            centres.push(Point::zeros());
        }
        let rules = [(3 * order).div_ceil(2) + 2, 2 * order + 1, 2 * order + 2]
            .map(|points| Rule::new(points, &velocity, &pressure));
        Ok(Self {
            condensation: Arc::new(NestedCondensation::new(
                unknowns,
                &centres,
                roles.len(),
                &[],
            )),
            potential: OnceLock::new(),
            mesh,
            velocity,
            pressure,
            spaces,
            n_nodes,
            parts,
            rules,
            roles,
            exterior,
            motions,
            n_motions,
            frame,
        })
    }

    /// Number of unknowns.
    pub fn n_dofs(&self) -> usize {
        (self.roles.iter().enumerate())
            .filter(|(i, role)| **role == Some(*i as u32))
            .count()
    }

    /// The mesh.
    pub fn mesh(&self) -> &MeridianMesh {
        &self.mesh
    }

    /// Unknowns of each triangle in the order of its matrix, their number, and those of the free
    /// motions.
    pub fn unknowns(&self) -> (Vec<ElementUnknowns>, usize, Vec<u32>) {
        let total = self.roles.len();
        let motions = (total - self.n_motions) as u32..total as u32;
        let unknowns = element_unknowns(&self.spaces, self.n_nodes, &self.roles);
        (unknowns, total, motions.collect())
    }

    /// Values at the velocity nodes of a function that is linear in each triangle.
    pub fn linear_at_nodes(&self, at_vertices: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.n_nodes[0]];
        for (corners, nodes) in self.mesh.triangles.iter().zip(&self.spaces[0].nodes) {
            for (&node, l) in nodes.iter().zip(&self.velocity.nodes) {
                values[node as usize] = (0..3).map(|k| l[k] * at_vertices[corners[k]]).sum();
            }
        }
        values
    }

    /// Positions of the velocity nodes, on the true boundary.
    pub fn positions(&self) -> Vec<Point> {
        let mut positions = vec![Point::zeros(); self.n_nodes[0]];
        for (t, nodes) in self.spaces[0].nodes.iter().enumerate() {
            let local = node_positions(&self.mesh, t, &self.velocity);
            for (&node, x) in nodes.iter().zip(local) {
                positions[node as usize] = x;
            }
        }
        positions
    }

    /// A flow at rest.
    pub fn rest(&self) -> Fields {
        Fields {
            velocity: vec![Point::zeros(); self.n_nodes[0]],
            pressure: vec![0.0; self.n_nodes[1]],
            motions: vec![0.0; self.n_motions],
        }
    }

    /// Nodes on bodies, with the body.
    pub fn nodes_on_bodies(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (self.parts.iter().enumerate()).filter_map(|(node, part)| match part {
            Some(BoundaryPart::Body(body)) => Some((node, *body)),
            _ => None,
        })
    }

    /// Velocity of each body.
    pub fn body_velocities(&self, fields: &Fields, boundary: &BoundaryVelocity) -> Vec<f64> {
        let motion = |g: &Option<usize>| g.map_or(0.0, |g| fields.motions[g]);
        (self.motions.iter().zip(&boundary.bodies))
            .map(|(g, own)| motion(g) + own)
            .collect()
    }

    /// Sets the velocities of the nodes on bodies and walls.
    pub fn set_boundary(&self, boundary: &BoundaryVelocity, fields: &mut Fields) {
        let bodies = self.body_velocities(fields, boundary);
        for (node, part) in self.parts.iter().enumerate() {
            let slip = boundary.slip.get(node).copied().unwrap_or_default();
            match part {
                Some(BoundaryPart::Body(body)) => {
                    fields.velocity[node] = Point::new(bodies[*body], 0.0) + slip;
                }
                Some(BoundaryPart::Wall) => {
                    fields.velocity[node] = Point::new(boundary.wall, 0.0);
                }
                _ => {}
            }
        }
    }

    /// Slip at the nodes on bodies without flux through any of them, `slip` being a velocity and
    /// the normal at a node of a body.
    ///
    /// The flux of interpolated slip is an interpolation error; in a container there would be no
    /// flow with it. The nodal normals times the ratio of the fluxes are subtracted.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn slip(
        &self,
        positions: &[Point],
        slip: impl Fn(usize, &Point) -> [Point; 2],
    ) -> Result<Vec<Point>, AxisymmetricError> {
        let mut result = vec![Point::zeros(); self.n_nodes[0]];
        let flux = |body: usize, part: usize| {
            let mut fields = self.rest();
            for (node, _) in self.nodes_on_bodies().filter(|(_, on)| *on == body) {
                fields.velocity[node] = slip(body, &positions[node])[part];
            }
            let residual = self.residual(positions, &fields, &Terms::default())?;
            Ok::<f64, AxisymmetricError>(residual.continuity.iter().sum())
        };
        for body in 0..self.motions.len() {
            let ratio = flux(body, 0)? / flux(body, 1)?;
            for (node, _) in self.nodes_on_bodies().filter(|(_, on)| *on == body) {
                let [velocity, normal] = slip(body, &positions[node]);
                result[node] = velocity - ratio * normal;
            }
        }
        Ok(result)
    }

    /// The equations on one triangle.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn element<'a>(
        &'a self,
        t: usize,
        positions: &[Point],
        fields: &Fields,
        terms: &Terms<'a>,
    ) -> Result<MomentumElement<'a>, AxisymmetricError> {
        let nodes = &self.spaces[0].nodes[t];
        let frame = self.frame.map_or(0.0, |g| fields.motions[g]);
        let at = |i: usize| {
            let node = nodes[i] as usize;
            let w = frame + terms.mesh_velocity.map_or(0.0, |w| w[node]);
            let h = terms.history.map_or(Point::zeros(), |h| h[node]);
            (positions[node], fields.velocity[node], w, h)
        };
        let pressure = DVector::from_iterator(
            self.pressure.len(),
            (self.spaces[1].nodes[t].iter()).map(|&node| fields.pressure[node as usize]),
        );
        let local = LocalValues::new(nodes.len(), at, pressure);
        let on_axis = |k: usize| positions[nodes[k] as usize].y == 0.0;
        // corners are the first nodes; 1 / r is singular at those on the axis
        let needs_large_rule = self.mesh.is_curved(t) || (0..3).any(on_axis);
        let rule = match terms.coefficients.viscosity.law {
            Some(_) => &self.rules[2],
            None => &self.rules[usize::from(needs_large_rule)],
        };
        MomentumElement::new(t, rule, terms.coefficients, &local)
    }

    /// Residuals of a flow.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn residual(
        &self,
        positions: &[Point],
        fields: &Fields,
        terms: &Terms,
    ) -> Result<Residual, AxisymmetricError> {
        let locals = (0..self.mesh.triangles.len())
            .into_par_iter()
            .map(|t| Ok(self.element(t, positions, fields, terms)?.residual()))
            .collect::<Result<Vec<_>, AxisymmetricError>>()?;
        let mut residual = self.no_residual();
        for (t, local) in locals.iter().enumerate() {
            self.add_local(t, local, &mut residual);
        }
        if let Some(exterior) = &self.exterior {
            let constant = terms.coefficients.viscosity.constant;
            let (tractions, _) = exterior.tractions(&fields.velocity);
            let n = exterior.nodes.len();
            for (k, &node) in exterior.nodes.iter().enumerate() {
                residual.momentum[node as usize] +=
                    constant * Point::new(tractions[k], tractions[n + k]);
            }
        }
        Ok(residual)
    }

    /// Residuals that are zero.
    pub(super) fn no_residual(&self) -> Residual {
        Residual {
            momentum: vec![Point::zeros(); self.n_nodes[0]],
            continuity: vec![0.0; self.n_nodes[1]],
        }
    }

    /// Adds the residuals of one triangle.
    pub(super) fn add_local(&self, t: usize, local: &DVector<f64>, residual: &mut Residual) {
        let [velocities, pressures] = [0, 1].map(|k| &self.spaces[k].nodes[t]);
        let n = velocities.len();
        for (k, &node) in velocities.iter().enumerate() {
            residual.momentum[node as usize] += Point::new(local[k], local[n + k]);
        }
        for (k, &node) in pressures.iter().enumerate() {
            residual.continuity[node as usize] += local[2 * n + k];
        }
    }

    /// The order in which the unknowns of a potential are eliminated: one per velocity node but the
    /// first, because it is determined up to a constant.
    pub(super) fn potential_condensation(&self) -> &Arc<NestedCondensation> {
        self.potential.get_or_init(|| {
            let unknown = |node: &u32| (*node > 0).then_some(*node);
            let nodes = self.spaces[0].nodes.iter();
            Arc::new(NestedCondensation::new(
                nodes
                    .map(|nodes| nodes.iter().map(unknown).collect())
                    .collect(),
                &centres(&self.mesh),
                self.n_nodes[0],
                &[],
            ))
        })
    }

    /// Integrals `-∮ N_i n_z dS` over the surfaces of bodies, with normals into the fluid, at the
    /// velocity nodes of the bodies; other entries are partial sums.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub(super) fn axial_normals(&self, positions: &[Point]) -> Result<Vec<f64>, AxisymmetricError> {
        // By the divergence theorem they are the residuals of a uniform pressure.
        let mut uniform = self.rest();
        uniform.pressure.fill(-1.0);
        let mut residual = self.no_residual();
        for (t, nodes) in self.spaces[0].nodes.iter().enumerate() {
            let part = |node: &u32| self.parts.get(*node as usize).copied().flatten();
            if nodes
                .iter()
                .any(|node| matches!(part(node), Some(BoundaryPart::Body(_))))
            {
                let element = self.element(t, positions, &uniform, &Terms::default())?;
                self.add_local(t, &element.residual(), &mut residual);
            }
        }
        Ok(residual
            .momentum
            .iter()
            .map(|momentum| momentum.x)
            .collect())
    }

    /// Force that each body exerts on the fluid.
    ///
    /// It is the residual of the momentum equation summed over the nodes of the body (the
    /// consistent force); its error is of twice the order of that of the flow.
    pub fn forces(&self, residual: &Residual) -> Vec<f64> {
        let mut forces = vec![0.0; self.motions.len()];
        for (node, body) in self.nodes_on_bodies() {
            forces[body] += residual.momentum[node].x;
        }
        forces
    }

    /// One iteration of Newton's method; returns the largest change of a velocity relative to the
    /// largest velocity.
    ///
    /// Existing `factors` are used whatever the flow from which they are. Velocities on the
    /// boundary must have been set.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`], [`AxisymmetricError::SingularElement`].
    pub fn iterate(
        &self,
        positions: &[Point],
        fields: &mut Fields,
        terms: &Terms,
        balance: &Balance,
        factors: &mut Option<CondensedFactors>,
    ) -> Result<f64, AxisymmetricError> {
        let residual = self.residual(positions, fields, terms)?;
        let factors = match factors {
            Some(factors) => factors,
            None => factors.insert(self.factor(positions, fields, terms, balance)?),
        };
        let change = self.change(fields, &residual, balance, factors);
        fields.add(&change, 1.0);
        Ok(change.relative_to(fields))
    }

    /// The change of a flow with these residuals by an iteration.
    pub(super) fn change(
        &self,
        fields: &Fields,
        residual: &Residual,
        balance: &Balance,
        factors: &CondensedFactors,
    ) -> Fields {
        let [n, m] = self.n_nodes;
        let mut rhs = vec![0.0; self.roles.len()];
        let axial = residual.momentum.iter().map(|r| r.x);
        let radial = residual.momentum.iter().map(|r| r.y);
        let rows = axial
            .chain(radial)
            .chain(residual.continuity.iter().copied());
        for (role, value) in self.roles.iter().zip(rows) {
            if let Some(row) = role {
                rhs[*row as usize] -= value;
            }
        }
        let momenta = &balance.matrix * DVector::from_column_slice(&fields.motions);
        for (g, (momentum, load)) in momenta.iter().zip(&balance.load).enumerate() {
            rhs[2 * n + m + g] += load - momentum;
        }
        let x = factors.solve(&rhs);
        let change = |i: usize| self.roles[i].map_or(0.0, |role| x[role as usize]);
        Fields {
            velocity: (0..n)
                .map(|node| Point::new(change(node), change(n + node)))
                .collect(),
            pressure: (0..m).map(|node| change(2 * n + node)).collect(),
            motions: (0..self.n_motions).map(|g| change(2 * n + m + g)).collect(),
        }
    }

    pub(super) fn factor(
        &self,
        positions: &[Point],
        fields: &Fields,
        terms: &Terms,
        balance: &Balance,
    ) -> Result<CondensedFactors, AxisymmetricError> {
        self.condensation.factor(&|t| {
            if t == self.mesh.triangles.len() {
                return Ok(balance.matrix.clone());
            }
            if let Some(exterior) = self
                .exterior
                .as_ref()
                .filter(|_| t > self.mesh.triangles.len())
            {
                return Ok(&exterior.matrix * terms.coefficients.viscosity.constant);
            }
            let element = self.element(t, positions, fields, terms)?;
            let mut matrix = element.jacobian();
            if self.frame.is_some() {
                let size = matrix.nrows();
                matrix = matrix.resize(size + 1, size + 1, 0.0);
                let mut column = matrix.view_mut((0, size), (size, 1));
                column.copy_from(&element.by_mesh_velocity());
            }
            Ok::<_, AxisymmetricError>(matrix)
        })
    }

    /// Iterates until the change is at most `tolerance`; returns the number of iterations and the
    /// last change.
    ///
    /// # Errors
    /// Those of [`FlowSystem::iterate`].
    pub fn solve(
        &self,
        positions: &[Point],
        fields: &mut Fields,
        terms: &Terms,
        balance: &Balance,
        factors: &mut Option<CondensedFactors>,
        tolerance: f64,
    ) -> Result<(usize, f64), AxisymmetricError> {
        /// Iterations of a Newton method that converges are fewer than ten.
        const MAX_ITERATIONS: usize = 20;
        let mut last = f64::INFINITY;
        for iteration in 1.. {
            let change = self.iterate(positions, fields, terms, balance, factors)?;
            if change <= tolerance || iteration == MAX_ITERATIONS || !change.is_finite() {
                return Ok((iteration, change));
            }
            if change > MAX_CHORD_REDUCTION * last {
                *factors = None;
            }
            last = change;
        }
        Ok((0, 0.0))
    }

    /// The same unknowns but for the motions of the bodies, which are all prescribed.
    ///
    /// # Errors
    /// [`AxisymmetricError::NoNodalBasis`].
    pub fn held(&self) -> Result<Self, AxisymmetricError> {
        let (mesh, order) = (Arc::clone(&self.mesh), self.velocity.order());
        Self::new(mesh, order, vec![None; self.motions.len()], 0, None, None)
    }

    /// Factors of Stokes flow with the mass matrix times `coefficient`.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`], [`AxisymmetricError::SingularElement`].
    pub fn factor_projection(
        &self,
        positions: &[Point],
        coefficient: f64,
    ) -> Result<CondensedFactors, AxisymmetricError> {
        let terms = Terms {
            coefficients: Coefficients {
                mass: coefficient,
                ..Coefficients::default()
            },
            ..Terms::default()
        };
        let balance = Balance {
            matrix: DMatrix::zeros(self.n_motions, self.n_motions),
            load: vec![0.0; self.n_motions],
        };
        self.factor(positions, &self.rest(), &terms, &balance)
    }

    /// Adds the velocity that removes the divergence of a flow, by factors of
    /// [`FlowSystem::factor_projection`].
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn remove_divergence(
        &self,
        positions: &[Point],
        fields: &mut Fields,
        factors: &CondensedFactors,
    ) -> Result<(), AxisymmetricError> {
        let residual = self.residual(positions, fields, &Terms::default())?;
        let n = self.n_nodes[0];
        let mut rhs = vec![0.0; self.roles.len()];
        for (role, value) in self.roles[2 * n..].iter().zip(&residual.continuity) {
            if let Some(row) = role {
                rhs[*row as usize] -= value;
            }
        }
        let x = factors.solve(&rhs);
        let change = |i: usize| self.roles[i].map_or(0.0, |role| x[role as usize]);
        for (node, u) in fields.velocity.iter_mut().enumerate() {
            *u += Point::new(change(node), change(n + node));
        }
        Ok(())
    }

    /// The momentum of a flow along the axis over the density, `∫ u_z`.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn momentum(&self, positions: &[Point], fields: &Fields) -> Result<f64, AxisymmetricError> {
        self.sum(positions, fields, &Terms::default(), |element| {
            element.momentum()
        })
    }

    /// Twice the kinetic energy of a flow over the density, `∫ |u|²`.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn square_integral(
        &self,
        positions: &[Point],
        fields: &Fields,
    ) -> Result<f64, AxisymmetricError> {
        self.sum(positions, fields, &Terms::default(), |element| {
            element.square_integral()
        })
    }
}

/// Unknowns of each triangle: axial velocities, radial velocities, pressures.
fn element_unknowns(
    spaces: &[Space; 2],
    [n, _]: [usize; 2],
    roles: &[Option<u32>],
) -> Vec<ElementUnknowns> {
    let of = |nodes: &[u32], first: usize| -> ElementUnknowns {
        nodes
            .iter()
            .map(|&node| roles[first + node as usize])
            .collect()
    };
    (spaces[0].nodes.iter().zip(&spaces[1].nodes))
        .map(|(velocities, pressures)| {
            let mut list = of(velocities, 0);
            list.extend(of(velocities, n));
            list.extend(of(pressures, 2 * n));
            list
        })
        .collect()
}

/// Centres of all triangles.
pub(crate) fn centres(mesh: &MeridianMesh) -> Vec<Point> {
    (mesh.triangles.iter())
        .map(|corners| corners.iter().map(|&v| mesh.points[v]).sum::<Point>() / 3.0)
        .collect()
}
