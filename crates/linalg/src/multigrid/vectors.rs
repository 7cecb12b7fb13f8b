//! Right-hand side and correction of one level.

/// `b` and `x` of one level, nodes and border, in the precision of the cycle.
pub(super) struct Vectors {
    pub b: Vec<[f32; 3]>,
    pub x: Vec<[f32; 3]>,
    pub border_b: Vec<f32>,
    pub border_x: Vec<f32>,
}

impl Vectors {
    pub fn new(nodes: usize, border: usize) -> Self {
        Vectors {
            b: vec![[0.0; 3]; nodes],
            x: vec![[0.0; 3]; nodes],
            border_b: vec![0.0; border],
            border_x: vec![0.0; border],
        }
    }
}
