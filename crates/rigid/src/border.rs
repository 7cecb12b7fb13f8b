//! The border that a formulation adds to the equations of the fluid.

use nalgebra::{DMatrix, DVector};

use crate::joint_loads::JointLoads;

/// Velocities, constraints and multipliers that a formulation adds to the equations of the fluid.
pub(crate) struct Border {
    /// Generalised velocities for each border dof; zero columns for multipliers.
    pub columns: DMatrix<f64>,
    /// Velocities with which each border row is tested, if they differ from `columns`; zero columns
    /// for rows that are constraints.
    pub rows: Option<DMatrix<f64>>,
    /// The velocities `W` that the joints impose: a particular solution of all constraints.
    pub offset: DVector<f64>,
    /// Entries of constraint rows and multiplier columns, added to the corner.
    pub constraints: Option<DMatrix<f64>>,
    /// Data for the loads of the joints; none without joints.
    pub joint_loads: Option<JointLoads>,
    /// The first border dof that is a multiplier.
    pub first_multiplier: Option<usize>,
}
