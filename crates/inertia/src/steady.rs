//! Steady states in the frame of the bodies.

use fem::TaylorHood;
use linalg::WarmStart;
use mesh::TetMesh;
use nalgebra::Vector3;
use rigid::{Drive, FlowSolution};
use stokes::rheology::ViscosityLaw;
use stokes::{InertialTerms, Options, Problem, Solution, StokesError, SurfaceFlow};

use crate::InertiaError;
use crate::error::{is_negative, is_unsolved, linear_failure};
use crate::projection::square_integral;

/// Residual of the linear solve of an iteration, relative to the change of the velocity before it.
///
/// The solutions then have errors of a few per cent of their change, and the last one of its
/// tolerance.
const RELATIVE_RTOL: f64 = 1e-2;

/// Parameters of the iteration for a steady state.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct SteadyParameters<'a> {
    /// Viscosity law in place of viscosity 1; none by default.
    pub law: Option<&'a dyn ViscosityLaw>,
    /// Relative change of the velocity in L2 at which the iteration ends.
    pub tolerance: f64,
    /// Largest number of iterations at one density.
    pub max_iterations: usize,
    /// Densities at which the flow is found first, as fractions of the last one.
    pub stages: usize,
    /// Formulation, linear solver and its tolerance.
    pub options: Options,
}

impl Default for SteadyParameters<'_> {
    fn default() -> Self {
        Self {
            law: None,
            tolerance: 1e-7,
            max_iterations: 60,
            stages: 1,
            options: Options::default(),
        }
    }
}

impl<'a> SteadyParameters<'a> {
    /// The same with a viscosity law.
    #[must_use]
    pub fn with_law(self, law: &'a dyn ViscosityLaw) -> Self {
        Self {
            law: Some(law),
            ..self
        }
    }

    /// The same with another tolerance.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// The same with this number of densities on the way.
    #[must_use]
    pub fn with_stages(self, stages: usize) -> Self {
        Self { stages, ..self }
    }
}

/// A steady state and how it was found.
pub struct Steady {
    /// Flow, velocities and forces.
    pub solved: Solution,
    /// Fixed-point iterations of all stages.
    pub iterations: usize,
    /// Relative change of the velocity in the last iteration.
    pub change: f64,
}

/// Steady flow around bodies on one mesh: what does not change between iterations.
#[derive(Clone, Copy)]
pub struct SteadyFlow<'a> {
    /// The mesh.
    pub mesh: &'a TetMesh,
    /// Boundary part and centre of each body.
    pub bodies: &'a [(&'a str, Vector3<f64>)],
    /// Boundary parts that are walls.
    pub walls: &'a [&'a str],
    /// Slip of the bodies, without background flow.
    pub slip: Option<&'a dyn SurfaceFlow>,
    /// Velocity of the walls, one per node of the mesh, in the laboratory.
    pub wall_velocity: Option<&'a [Vector3<f64>]>,
    /// Whether the mesh moves with the first body, walls included.
    ///
    /// The flow is then steady in its frame: the fluid enters and leaves through the walls of a
    /// domain that moves with the body, at the velocity that the walls have in the laboratory.
    pub moves_with_body: bool,
}

impl SteadyFlow<'_> {
    /// Finds the steady state at a density, at viscosity 1.
    ///
    /// Each iteration solves the equations with the convecting velocity of the iteration before
    /// (Picard), which are linear but for a viscosity law, and the result is the combination of the
    /// last five whose change is smallest (Anderson 1965), which converges where the plain
    /// iteration does not. Velocities are those in the laboratory.
    ///
    /// # Errors
    /// [`InertiaError::NotSteady`], [`InertiaError::Unresolved`], [`InertiaError::Turning`], those
    /// of assembly and of the first solve.
    pub fn solve(
        &self,
        drive: &Drive,
        density: f64,
        parameters: &SteadyParameters<'_>,
    ) -> Result<Steady, InertiaError> {
        if !(density >= 0.0 && density.is_finite()) {
            return Err(InertiaError::OutOfRange {
                what: "the density of the fluid",
                value: density,
                range: "zero or positive",
            });
        }
        let space = TaylorHood::new(self.mesh)?;
        let mut problem = Problem::new(self.mesh, self.bodies, self.walls)?.with_space(&space);
        if let Some(slip) = self.slip {
            problem = problem.with_surface_flow(slip);
        }
        let mut warm = WarmStart::new(5);
        let mut mixing = Mixing::default();
        let options = parameters.options;
        let first = InertialTerms {
            law: parameters.law,
            wall_velocity: self.wall_velocity,
            ..InertialTerms::default()
        };
        let first = problem.solve_inertial(drive, &options, &first, &mut warm)?;
        let mut steady = Steady {
            solved: first,
            iterations: 0,
            change: 0.0,
        };
        let stages = parameters.stages.max(1);
        for stage in 1..=stages {
            let density = density * stage as f64 / stages as f64;
            // a stage on the way only needs to lead to the next one
            let tolerance = match stage == stages {
                true => parameters.tolerance,
                false => parameters.tolerance.max(1e-2),
            };
            mixing.clear();
            let mut convecting = self.relative(&steady.solved.flow)?;
            steady.change = 1.0;
            for iteration in 1.. {
                if density == 0.0 {
                    steady.change = 0.0;
                    break;
                }
                let terms = InertialTerms {
                    density,
                    convecting: Some(&convecting),
                    law: parameters.law,
                    // the convecting velocity differs from it by a uniform one
                    near: Some(&convecting),
                    wall_velocity: self.wall_velocity,
                    ..InertialTerms::default()
                };
                // from the last solution, whose residual is as large as the change
                let rtol = (RELATIVE_RTOL * steady.change).max(parameters.options.rtol);
                let options = parameters.options.with_rtol(rtol);
                let solved = self.picard(&terms, |terms| {
                    problem.solve_inertial(drive, &options, terms, &mut warm)
                })?;
                let next = self.relative(&solved.flow)?;
                let difference: Vec<Vector3<f64>> =
                    next.iter().zip(&convecting).map(|(a, b)| a - b).collect();
                let size = square_integral(self.mesh, &next)?;
                let change = square_integral(self.mesh, &difference)?;
                steady.change = if change > 0.0 {
                    (change / size).sqrt()
                } else {
                    0.0
                };
                steady.solved = solved;
                steady.iterations += 1;
                if steady.change <= tolerance {
                    break;
                }
                if iteration >= parameters.max_iterations || !steady.change.is_finite() {
                    return Err(InertiaError::NotSteady {
                        density,
                        iterations: iteration,
                        change: steady.change,
                        tolerance,
                    });
                }
                convecting = mixing.next(convecting, difference);
            }
        }
        if let Some(law) = parameters.law {
            let convecting = self.relative(&steady.solved.flow)?;
            let terms = InertialTerms {
                density,
                convecting: (density > 0.0).then_some(&convecting),
                wall_velocity: self.wall_velocity,
                ..InertialTerms::default()
            };
            let flow = &steady.solved.flow;
            steady.solved.regularisation = self.picard(&terms, |terms| {
                problem.effect_of_regularisation((drive, law), &options, terms, flow)
            })?;
        }
        Ok(steady)
    }

    /// Solves with the convecting velocity of these terms.
    ///
    /// In large cells the divergence of a discrete flow can make diagonal entries negative, which
    /// solvers refuse. The skew-symmetric form has none, but with it the iteration took 23 instead
    /// of 12 steps for a sphere at a Reynolds number of 47, and 60 did not suffice at 100.
    fn picard<T>(
        &self,
        terms: &InertialTerms,
        mut solve: impl FnMut(&InertialTerms) -> Result<T, StokesError>,
    ) -> Result<T, InertiaError> {
        match solve(terms) {
            Err(error) if is_negative(linear_failure(&error)) => {}
            solved => return solved.map_err(|error| unresolved(error, terms.density)),
        }
        // the mesh moves with a uniform velocity
        solve(&InertialTerms {
            divergence_of: terms.convecting,
            ..*terms
        })
        .map_err(|error| unresolved(error, terms.density))
    }

    /// Velocity relative to the mesh.
    fn relative(&self, flow: &FlowSolution) -> Result<Vec<Vector3<f64>>, InertiaError> {
        if !self.moves_with_body || flow.bodies.is_empty() {
            return Ok(flow.velocity.clone());
        }
        let velocity: Vector3<f64> = flow.bodies.fixed_rows::<3>(0).into();
        let spin = flow.bodies.rows(3, 3).amax();
        let fastest = flow.velocity.iter().map(|u| u.norm()).fold(0.0, f64::max);
        // rounding and meshes without symmetry make bodies turn a little
        const MAX_RELATIVE_SPIN: f64 = 1e-2;
        if spin > MAX_RELATIVE_SPIN * fastest {
            return Err(InertiaError::Turning { body: 0, spin });
        }
        Ok(flow.velocity.iter().map(|u| u - velocity).collect())
    }
}

fn unresolved(error: StokesError, density: f64) -> InertiaError {
    match is_unsolved(&error) {
        true => InertiaError::Unresolved {
            density,
            source: error,
        },
        false => error.into(),
    }
}

/// A velocity per node.
type Field = Vec<Vector3<f64>>;

/// Anderson mixing of the last iterates of a fixed-point iteration.
#[derive(Default)]
struct Mixing {
    /// Iterates and their changes, the newest last.
    history: Vec<(Field, Field)>,
}

impl Mixing {
    /// Pairs that are combined, besides the newest.
    const DEPTH: usize = 4;

    fn clear(&mut self) {
        self.history.clear();
    }

    /// The next iterate, from the present one and its change.
    ///
    /// With differences `ΔX`, `ΔF` of successive iterates and changes, the next iterate is
    /// `x + f - (ΔX + ΔF) γ` with the `γ` for which `|f - ΔF γ|` is smallest.
    fn next(&mut self, x: Field, f: Field) -> Field {
        self.history.push((x, f));
        if self.history.len() > Self::DEPTH + 1 {
            self.history.remove(0);
        }
        let last = self.history.len() - 1;
        let (x, f) = &self.history[last];
        let difference = |k: usize, n: usize| {
            let ((xa, fa), (xb, fb)) = (&self.history[k], &self.history[k + 1]);
            (xb[n] - xa[n], fb[n] - fa[n])
        };
        let mut normal = nalgebra::DMatrix::<f64>::zeros(last, last);
        let mut rhs = nalgebra::DVector::<f64>::zeros(last);
        for n in 0..f.len() {
            for j in 0..last {
                let dj = difference(j, n).1;
                rhs[j] += dj.dot(&f[n]);
                for k in 0..=j {
                    normal[(j, k)] += dj.dot(&difference(k, n).1);
                }
            }
        }
        for j in 0..last {
            for k in 0..j {
                normal[(k, j)] = normal[(j, k)];
            }
        }
        // differences that depend on each other are left out
        let threshold = 1e-12 * normal.amax();
        let gamma = match last {
            // an empty matrix has no singular value decomposition
            0 => rhs,
            _ => match normal.svd(true, true).solve(&rhs, threshold) {
                Ok(gamma) => gamma,
                Err(_) => nalgebra::DVector::zeros(last),
            },
        };
        (0..f.len())
            .map(|n| {
                let mixed = (0..last).map(|k| {
                    let (dx, df) = difference(k, n);
                    (dx + df) * gamma[k]
                });
                x[n] + f[n] - mixed.sum::<Vector3<f64>>()
            })
            .collect()
    }
}
