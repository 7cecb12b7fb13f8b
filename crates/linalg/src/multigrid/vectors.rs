//! Right-hand side and correction of one level.

use crate::node_kernel::Padded;

/// `b` and `x` of one level, nodes and border, in the precision of the cycle.
pub(super) struct Vectors {
    pub b: Vec<Padded>,
    pub x: Vec<Padded>,
    pub border_b: Vec<f32>,
    pub border_x: Vec<f32>,
}

impl Vectors {
    pub fn new(nodes: usize, border: usize) -> Self {
        Vectors {
            b: vec![[0.0; 4]; nodes],
            x: vec![[0.0; 4]; nodes],
            border_b: vec![0.0; border],
            border_x: vec![0.0; border],
        }
    }
}
