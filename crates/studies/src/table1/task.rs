//! Cells of the table to be computed: mesh, formulation and solver.

/// Formulations of the table, the reference first.
pub const FORMULATIONS: [&str; 3] = ["p-tilde", "lagrange", "direct-row"];

/// A mesh of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// Approximate number of dofs.
    pub dofs: usize,
    /// Element size on the spheres that gives about this number of dofs.
    pub surface_size: f64,
    /// Subdomains of additive Schwarz: eight on the smallest mesh, as in the paper, and of the same
    /// size on the others.
    pub subdomains: usize,
    pub solvers: &'static [Solver],
}

/// A solver of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    Block,
    Minres,
    Direct,
    Schwarz,
}

impl Solver {
    pub fn word(self) -> &'static str {
        match self {
            Self::Block => "block",
            Self::Minres => "minres",
            Self::Direct => "direct",
            Self::Schwarz => "schwarz",
        }
    }

    /// Tolerance of the residual; PETSc's additive Schwarz, with which ours is compared, had 1e-6.
    pub fn rtol(self) -> f64 {
        match self {
            Self::Schwarz => 1e-6,
            _ => 1e-8,
        }
    }

    /// Number of rounds: solves that take about a second are repeated, for a median.
    pub fn repeats(self, repeats: usize) -> usize {
        match self {
            Self::Block => repeats,
            _ => 1,
        }
    }
}

/// One cell of the table.
#[derive(Clone, Copy, Debug)]
pub struct Task {
    pub size: Size,
    pub formulation: &'static str,
    pub solver: Solver,
}

impl Task {
    /// Overrides of the scene.
    pub fn overrides(&self) -> Vec<String> {
        vec![
            format!("fem.surface_size={}", self.size.surface_size),
            format!("fem.formulation={}", self.formulation),
            format!("fem.solver={}", self.solver.word()),
            format!("fem.subdomains={}", self.size.subdomains),
            format!("fem.rtol={:e}", self.solver.rtol()),
        ]
    }
}
