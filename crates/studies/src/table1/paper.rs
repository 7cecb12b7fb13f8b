//! Measurements of others for the same problem, with their sources.

/// One row of published measurements.
pub struct Reported {
    /// Authors and machine.
    pub source: &'static str,
    pub dofs: usize,
    pub formulation: &'static str,
    pub solver: &'static str,
    /// `None` if not reported, or not iterative.
    pub iterations: Option<usize>,
    /// `None` if the solver failed.
    pub seconds: Option<f64>,
}

/// Source of the rows of the paper: Feel++ with PETSc on 8 cores.
///
/// Berti, Chabannes, Giraldi & Prud'homme, ESAIM: ProcS (2021), Table 1. The tolerance is not
/// given; times are those of one time step.
pub const PAPER: &str = "Berti et al. 2021, 8 cores";

/// Source of the rows for PETSc, on two ranks of the kind of machine used for this project.
pub const PETSC: &str = "PETSc, 2 ranks, tuned by an expert";

const fn paper(
    dofs: usize,
    formulation: &'static str,
    solver: &'static str,
    iterations: Option<usize>,
    seconds: Option<f64>,
) -> Reported {
    Reported {
        source: PAPER,
        dofs,
        formulation,
        solver,
        iterations,
        seconds,
    }
}

/// All rows of Table 1 of the paper, then those of PETSc.
///
/// PETSc used a p-multigrid preconditioner (SOR, BoomerAMG on the scalar Laplacian) on straight
/// Gmsh meshes, 2026.
pub const REPORTED: [Reported; 17] = [
    paper(311_000, "lagrange", "LU", None, Some(190.0)),
    paper(311_000, "lagrange", "fieldsplit", Some(41), Some(33.0)),
    paper(311_000, "lagrange", "gasm+LU", None, None),
    paper(311_000, "p-tilde", "LU", None, Some(190.0)),
    paper(311_000, "p-tilde", "fieldsplit", Some(36), Some(30.0)),
    paper(311_000, "p-tilde", "gasm+LU", Some(170), Some(80.0)),
    paper(888_000, "lagrange", "fieldsplit", Some(50), Some(110.0)),
    paper(888_000, "lagrange", "gasm+LU", None, None),
    paper(888_000, "p-tilde", "fieldsplit", Some(43), Some(97.0)),
    paper(888_000, "p-tilde", "gasm+LU", Some(350), Some(505.0)),
    paper(2_094_000, "lagrange", "fieldsplit", Some(66), Some(350.0)),
    paper(2_094_000, "lagrange", "gasm+LU", None, None),
    paper(2_094_000, "p-tilde", "fieldsplit", Some(53), Some(293.0)),
    paper(2_094_000, "p-tilde", "gasm+LU", Some(395), Some(2550.0)),
    Reported {
        source: PETSC,
        dofs: 311_000,
        formulation: "p-tilde",
        solver: "p-multigrid",
        iterations: Some(31),
        seconds: Some(3.8),
    },
    Reported {
        source: PETSC,
        dofs: 876_000,
        formulation: "p-tilde",
        solver: "p-multigrid",
        iterations: Some(34),
        seconds: Some(11.9),
    },
    Reported {
        source: PETSC,
        dofs: 2_060_000,
        formulation: "p-tilde",
        solver: "p-multigrid",
        iterations: Some(37),
        seconds: Some(34.0),
    },
];
