//! Velocities, pressure and forces from the solution vector of a system.

use nalgebra::{DVector, Matrix3, Vector3};

use crate::constraints::{HeldRows, JointLoad, JointRows};
use crate::error::check_length;
use crate::mesh_part::Ownership;
use crate::{Articulation, Constrained, ExternalLoad, Imposed, RigidError, StateVelocity};

/// Velocities, pressure and forces of one configuration.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FlowSolution {
    /// Velocity of each node.
    pub velocity: Vec<Vector3<f64>>,
    /// Pressure at each pressure dof as the solver returned it; in enclosed flow up to a constant.
    pub pressure: Vec<f64>,
    /// Generalised velocities (see [`VelocityLayout`](crate::VelocityLayout)).
    pub generalised: DVector<f64>,
    /// `(U, ω)` of each rigid body.
    pub bodies: DVector<f64>,
    /// `(F, T)` that each rigid body exerts on the fluid.
    pub forces: DVector<f64>,
    /// Stresslet of each rigid body about its centre, symmetric without trace, with the sign of
    /// Batchelor (1970): the moment of the traction of the fluid on the body,
    ///
    /// ```text
    /// S = ∮ [(σ n) x^T + x (σ n)^T] / 2 - I (x · σ n) / 3 - (u n^T + n u^T) dS
    /// ```
    ///
    /// It is `20π/3 a^3 E` for a rigid sphere of radius `a` in the strain `E`. The first moment of
    /// the forces on the fluid, which have the opposite sign, is `-S` for rigid surfaces.
    pub stresslets: Vec<Matrix3<f64>>,
    /// Loads `λ` of the joints, one per row of [`Constraints::matrix`](crate::Constraints::matrix).
    ///
    /// Bodies receive `C^T λ` in addition to the external loads. Redundant rows carry zero.
    /// [`FlowSolution::joint_load`] names those of a joint; after the joints come the torques of
    /// clamps and the loads that hold bodies, [`FlowSolution::holding_loads`].
    pub joint_loads: DVector<f64>,
    /// Rate of change of the state of the articulated set.
    pub state: StateVelocity,
    /// Rows of each joint; none without joint loads.
    joint_rows: Vec<JointRows>,
    /// Rows of the held bodies; none without joint loads.
    held_rows: Vec<HeldRows>,
}

impl FlowSolution {
    /// Force, torque and drive of a joint.
    ///
    /// Available from every formulation: it is a multiplier of Berti et al. (2021), equations
    /// (16)-(18), up to sign or, where velocities were eliminated, the load that balances the
    /// bodies.
    ///
    /// # Errors
    /// [`RigidError::NoSuchJoint`].
    pub fn joint_load(&self, joint: usize) -> Result<JointLoad, RigidError> {
        JointRows::load_of(&self.joint_rows, &self.joint_loads, joint)
    }

    /// Loads that hold bodies, by whatever imposes their velocities, with the indices of the bodies
    /// ([`Drive::holding_loads`](crate::Drive::holding_loads)).
    pub fn holding_loads(&self) -> Vec<(usize, ExternalLoad)> {
        HeldRows::loads_of(&self.held_rows, &self.joint_loads)
    }

    /// Adds a change of this flow, such as [`Constrained::change`].
    ///
    /// # Errors
    /// A change of a flow on another mesh or of other bodies.
    pub fn add(&mut self, change: &Self) -> Result<(), RigidError> {
        let lengths = |flow: &Self| {
            [
                ("velocities of a change", flow.velocity.len()),
                ("pressures of a change", flow.pressure.len()),
                ("generalised velocities of a change", flow.generalised.len()),
                ("bodies of a change", flow.bodies.len()),
                ("forces of a change", flow.forces.len()),
                ("stresslets of a change", flow.stresslets.len()),
                ("loads of links of a change", flow.joint_loads.len()),
                ("frames of a change", flow.state.frames.len()),
                ("angular velocities of a change", flow.state.spins.len()),
            ]
        };
        for ((what, found), (_, expected)) in lengths(change).into_iter().zip(lengths(self)) {
            check_length(what, found, expected)?;
        }
        (self.velocity.iter_mut().zip(&change.velocity)).for_each(|(u, du)| *u += du);
        (self.pressure.iter_mut().zip(&change.pressure)).for_each(|(p, dp)| *p += dp);
        self.generalised += &change.generalised;
        self.bodies += &change.bodies;
        self.forces += &change.forces;
        (self.stresslets.iter_mut().zip(&change.stresslets)).for_each(|(s, ds)| *s += ds);
        self.joint_loads += &change.joint_loads;
        self.state = &self.state + &change.state;
        Ok(())
    }
}

/// A solution vector split into its blocks.
struct Blocks<'s> {
    /// Velocities of the free nodes.
    free: &'s [f64],
    border: DVector<f64>,
    pressure: &'s [f64],
}

impl Constrained {
    /// Velocities, forces and pressure from a solution of the system.
    ///
    /// # Errors
    /// A solution of the wrong length, [`RigidError::OtherSet`].
    pub fn flow(&self, solution: &[f64], set: &Articulation) -> Result<FlowSolution, RigidError> {
        self.flow_with(solution, &self.border.offset, &[], set)
    }

    /// Velocities, forces and pressure of a flow that forces on the nodes drive too.
    ///
    /// `solution` belongs to the sum of the right-hand side of this system and of
    /// [`Constrained::rhs_of_forces`] of `forces_on_nodes`, one per node of the mesh: the known
    /// momentum of a step in time. The forces of the bodies on the fluid are residuals of the whole
    /// momentum equation, these forces included.
    ///
    /// # Errors
    /// A solution or forces of the wrong length, [`RigidError::OtherSet`].
    pub fn flow_with_forces(
        &self,
        solution: &[f64],
        forces_on_nodes: &[Vector3<f64>],
        set: &Articulation,
    ) -> Result<FlowSolution, RigidError> {
        let nodes = self.surfaces.nodes();
        check_length("forces on the nodes", forces_on_nodes.len(), nodes)?;
        self.flow_with(solution, &self.border.offset, forces_on_nodes, set)
    }

    /// Velocities, forces and pressure from a solution for the right-hand side of other rates.
    ///
    /// # Errors
    /// A solution of the wrong length, another number of imposed velocities,
    /// [`RigidError::OtherSet`].
    pub fn flow_at(
        &self,
        solution: &[f64],
        imposed: &Imposed,
        set: &Articulation,
    ) -> Result<FlowSolution, RigidError> {
        check_length(
            "imposed velocities",
            imposed.offset.len(),
            self.border.offset.len(),
        )?;
        self.flow_with(solution, &imposed.offset, &[], set)
    }

    fn flow_with(
        &self,
        solution: &[f64],
        offset: &DVector<f64>,
        on_nodes: &[Vector3<f64>],
        set: &Articulation,
    ) -> Result<FlowSolution, RigidError> {
        self.solved(solution, Some(offset), set, |flow, free, border| {
            flow.forces = (self.surfaces).forces(free, &flow.bodies, &flow.pressure, on_nodes);
            // Where a symmetry plane cuts bodies, multipliers also include the loads of the plane.
            let is_whole = self.surfaces.symmetry_planes.is_empty();
            let multipliers = self.border.first_multiplier.filter(|_| is_whole);
            flow.joint_loads = match (&self.border.joint_loads, multipliers) {
                (None, _) => DVector::zeros(0),
                (Some(loads), Some(first)) => loads.of_multipliers(&border.as_slice()[first..]),
                (Some(loads), None) => loads.balancing(&flow.forces, &flow.generalised)?,
            };
            flow.velocity = self.surfaces.with_prescribed(free, &flow.bodies);
            flow.stresslets = (self.surfaces).stresslets(&flow.velocity, &flow.pressure, on_nodes);
            Ok(())
        })
    }

    /// The flow of a solution, whose forces and velocities of nodes `complete` fills in from the
    /// velocities of the free nodes and the border.
    fn solved(
        &self,
        solution: &[f64],
        offset: Option<&DVector<f64>>,
        set: &Articulation,
        complete: impl FnOnce(&mut FlowSolution, &[f64], &DVector<f64>) -> Result<(), RigidError>,
    ) -> Result<FlowSolution, RigidError> {
        if set.velocity_layout() != self.layout {
            return Err(RigidError::OtherSet);
        }
        let solution = self.surfaces.part.completed(solution);
        let blocks = self.split(&solution)?;
        let mut generalised = &self.border.columns * &blocks.border;
        if let Some(offset) = offset {
            generalised += offset;
        }
        let mut flow = FlowSolution {
            velocity: Vec::new(),
            pressure: blocks.pressure.to_vec(),
            bodies: generalised.select_rows(&self.surface_rows),
            forces: DVector::zeros(self.surface_rows.len()),
            stresslets: Vec::new(),
            joint_loads: DVector::zeros(0),
            state: set.state_velocity(generalised.as_slice())?,
            generalised,
            joint_rows: (self.border.joint_loads.as_ref())
                .map(|loads| loads.joint_rows().to_vec())
                .unwrap_or_default(),
            held_rows: (self.border.joint_loads.as_ref())
                .map(|loads| loads.held_rows().to_vec())
                .unwrap_or_default(),
        };
        complete(&mut flow, blocks.free, &blocks.border)?;
        // Forces were computed with the divergence and the pressures of the system.
        let scale = self.surfaces.pressure_scale;
        flow.pressure.iter_mut().for_each(|p| *p *= scale);
        Ok(flow)
    }

    /// Change of a flow by forces on the nodes, at the same rates, loads and wall velocities.
    ///
    /// `solution` belongs to the right-hand side [`Constrained::rhs_of_forces`] of
    /// `forces_on_nodes`, one per node of the mesh. The change of the force of a body is the
    /// residual of the momentum equation tested with its rigid motions, without the part that the
    /// joints cannot balance: the sum of the forces on a linkage does not change, however
    /// inaccurate the solution, and bodies without joints keep the given loads.
    ///
    /// # Errors
    /// Arrays of the wrong length, [`RigidError::OtherSet`],
    /// [`RigidError::DependentConstraints`].
    pub fn change(
        &self,
        solution: &[f64],
        forces_on_nodes: &[Vector3<f64>],
        set: &Articulation,
    ) -> Result<FlowSolution, RigidError> {
        let (surfaces, nodes) = (&self.surfaces, forces_on_nodes);
        check_length("forces on the nodes", nodes.len(), surfaces.nodes())?;
        self.solved(solution, None, set, |flow, free, _| {
            let residuals = surfaces.change_of_forces(free, &flow.bodies, &flow.pressure, nodes);
            if let Some(loads) = &self.border.joint_loads {
                (flow.joint_loads, flow.forces) = loads.change(&residuals, &flow.generalised)?;
            }
            flow.velocity = surfaces.all_velocities(free, &flow.bodies);
            flow.stresslets = surfaces.change_of_stresslets(&flow.velocity, &flow.pressure, nodes);
            Ok(())
        })
    }

    /// Generalised velocities of a solution for [`Constrained::rhs_of_loads`] or
    /// [`Constrained::rhs_of_forces`].
    ///
    /// # Errors
    /// A solution of the wrong length.
    pub fn generalised_of_loads(&self, solution: &[f64]) -> Result<DVector<f64>, RigidError> {
        Ok(&self.border.columns * self.split(&self.surfaces.part.completed(solution))?.border)
    }

    /// Velocity of each node and pressure of a solution for [`Constrained::rhs_of_loads`] or
    /// [`Constrained::rhs_of_forces`].
    ///
    /// # Errors
    /// A solution of the wrong length.
    pub fn flow_of_loads(
        &self,
        solution: &[f64],
    ) -> Result<(Vec<Vector3<f64>>, Vec<f64>), RigidError> {
        let solution = self.surfaces.part.completed(solution);
        let blocks = self.split(&solution)?;
        let bodies = (&self.border.columns * blocks.border).select_rows(&self.surface_rows);
        let velocity = self.surfaces.all_velocities(blocks.free, &bodies);
        let scale = self.surfaces.pressure_scale;
        Ok((
            velocity,
            blocks.pressure.iter().map(|p| scale * p).collect(),
        ))
    }

    fn split<'s>(&self, solution: &'s [f64]) -> Result<Blocks<'s>, RigidError> {
        check_length("entries of the solution", solution.len(), self.dofs())?;
        let (free, rest) = solution.split_at(3 * self.surfaces.free_nodes.len());
        let (border, pressure) = rest.split_at(self.border.columns.ncols());
        Ok(Blocks {
            free,
            border: DVector::from_column_slice(border),
            pressure,
        })
    }
}
