//! V-cycle for a bordered operator: given levels, then smoothed aggregation.
//!
//! Border dofs are kept on every level.

mod coarse;
mod coupled_multigrid;
mod incomplete_lu;
mod level;
mod params;
mod scalar_multigrid;

pub use coupled_multigrid::CoupledMultigrid;
pub use params::{BorderInverse, MultigridParams};
pub use scalar_multigrid::ScalarMultigrid;

use std::array::from_fn;
use std::borrow::Cow;
use std::fmt;

use coarse::CoarseSolver;
use incomplete_lu::{IncompleteLu, convection_dominates, stabilised};
use level::{Alike, Columns, Components, Level, Vectors};

use crate::bordered::{nodes, nodes_mut};
use crate::chebyshev::JacobiScaling;
use crate::columns::{assert_lengths, in_passes, split};
use crate::csr::positive_diagonal;
use crate::transpose::symmetric_part;
use crate::vector::{for_each_chunk, max_abs, power_of_two_below};
use crate::{
    Bordered, Csr, LinalgError, Preconditioner, PreconditionerKind, Prolongation, csr,
    smoothed_aggregation,
};

/// Size of one level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct LevelSize {
    /// Number of nodes n.
    pub nodes: usize,
    /// Number of nonzeros of the scalar matrix K.
    pub nnz: usize,
    /// Number of nonzeros of the border C.
    pub border_nnz: usize,
    /// Number of nonzeros of the prolongation to the nodes from the next coarser level; zero on the
    /// coarsest.
    pub prolongation_nnz: usize,
    /// Number of smoothing steps before, and after, the coarse correction; zero on the coarsest.
    pub sweeps: usize,
}

/// A part of a V-cycle, to measure its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CyclePart {
    /// One smoothing step on the finest level.
    SmoothingStep,
    /// The residual of the finest level and its restriction.
    Restriction,
    /// The prolongation to the finest level.
    Prolongation,
    /// The cycle on all coarser levels.
    CoarserLevels,
}

/// One V-cycle as an approximate inverse of a [`Bordered`] operator.
///
/// Chebyshev-Jacobi steps before and after each coarse correction smooth the nodes: one on the
/// finest level, where passes are expensive, two on coarser ones. Border dofs are kept on all
/// levels and solved for exactly on the coarsest one. The cycle runs in f32 on values scaled by
/// powers of two, so right-hand sides may have any size. It is symmetric (to f32 precision) and
/// positive definite if the operator is.
///
/// In an operator with convection
/// ([`Bordered::with_unsymmetric_stiffness`](crate::Bordered::with_unsymmetric_stiffness)) the
/// skew-symmetric part of `K` may be so large that Jacobi steps diverge.
/// [`with_prolongation`](Multigrid::with_prolongation) then smooths by incomplete LU factors, one
/// step before and after the coarse correction, of `K` and a tenth of the artificial diffusion of
/// upwinding; the coarse matrices are Galerkin products with this diffusion. Aggregates are those
/// of the symmetric part. Other nonsymmetric matrices are those of
/// [`ScalarMultigrid::from_symmetric_part`] and [`CoupledMultigrid::from_symmetric_part`].
///
/// Cost of `apply`: two passes over the finest K, four over the others. `{}` prints the table of
/// levels.
pub struct Multigrid {
    levels: Vec<Level<Alike>>,
    coarse: CoarseSolver,
    sizes: Vec<LevelSize>,
    /// Power of two by which the operator is divided.
    unit: f64,
}

impl Multigrid {
    /// Builds all coarse levels by smoothed aggregation.
    ///
    /// # Errors
    /// [`LinalgError::NotPositive`], [`LinalgError::Parameter`], [`LinalgError::Factorisation`] for
    /// a singular matrix or border, [`LinalgError::CoarseningStalled`] for a level that is too
    /// large to be factorised and cannot be aggregated.
    pub fn new(operator: &Bordered, params: &MultigridParams) -> Result<Self, LinalgError> {
        params.check()?;
        let diagonal = positive_diagonal("stiffness matrix", operator.stiffness())?;
        Builder::new(&diagonal, params).aggregate(Cow::Borrowed(operator))
    }

    /// Builds the first coarse level by a given prolongation, the others by smoothed aggregation.
    ///
    /// The prolongation is usually that from P1 to P2 elements. `coarse_stiffness` is the scalar
    /// matrix of the coarse space if it is known (on straight-sided meshes the P1 stiffness matrix
    /// is the Galerkin product); otherwise, and where convection dominates, the product is
    /// computed.
    ///
    /// # Errors
    /// Those of [`Multigrid::new`], and [`LinalgError::Shape`].
    pub fn with_prolongation(
        operator: &Bordered,
        prolongation: &Prolongation,
        coarse_stiffness: Option<Csr>,
        params: &MultigridParams,
    ) -> Result<Self, LinalgError> {
        params.check()?;
        prolongation.check_against(operator)?;
        if let Some(k) = &coarse_stiffness {
            let nc = prolongation.nodes().cols();
            csr::check_shape("coarse stiffness matrix", k.shape(), (nc, nc))?;
            csr::check_finite("coarse stiffness matrix", k.data())?;
        }
        let diagonal = positive_diagonal("stiffness matrix", operator.stiffness())?;
        let prolongation = &*prolongation.constrain(operator.constrained_dofs());
        let mut builder = Builder::new(&diagonal, params);
        let unsymmetric = !operator.has_symmetric_stiffness();
        if unsymmetric && convection_dominates(operator.stiffness()) {
            builder.convection = true;
            let stable = stabilised(operator.stiffness());
            let coarse = builder.push_convection(operator, stable, prolongation)?;
            return builder.aggregate(Cow::Owned(coarse));
        }
        let (pushed, coarse) = rayon::join(
            || {
                let scaling = JacobiScaling::new(operator.stiffness())?;
                builder.push(operator, prolongation, &scaling);
                Ok(())
            },
            || prolongation.galerkin(operator, coarse_stiffness.map(csr::into_rows)),
        );
        pushed?;
        builder.aggregate(Cow::Owned(coarse))
    }

    /// Sizes from the finest level down.
    pub fn level_sizes(&self) -> &[LevelSize] {
        &self.sizes
    }

    /// Operator complexity: nonzeros of K on all levels over those on the finest.
    pub fn operator_complexity(&self) -> f64 {
        let all: usize = self.sizes.iter().map(|s| s.nnz).sum();
        all as f64 / self.sizes[0].nnz.max(1) as f64
    }

    /// Runs one part of a cycle on the vectors that the last cycle left.
    ///
    /// The next cycle does not depend on it. On a single level all parts are empty.
    pub fn run_part(&mut self, part: CyclePart) {
        let coarse = &mut self.coarse;
        let Some((fine, rest)) = self.levels.split_first_mut() else {
            return;
        };
        match part {
            CyclePart::SmoothingStep => fine.sweep::<1>(fine.factors[0]),
            CyclePart::Restriction => fine.restrict::<1>(top(rest, coarse)),
            CyclePart::Prolongation => fine.prolong::<1>(top(rest, coarse)),
            CyclePart::CoarserLevels => cycle::<1, _>(rest, coarse),
        }
    }
}

/// The levels built so far.
struct Builder<'a> {
    params: &'a MultigridParams,
    unit: f64,
    levels: Vec<Level<Alike>>,
    sizes: Vec<LevelSize>,
    /// Whether all levels have convection, with factors for smoothers.
    convection: bool,
}

impl<'a> Builder<'a> {
    fn new(diagonal: &[f64], params: &'a MultigridParams) -> Self {
        Builder {
            params,
            unit: power_of_two_below(max_abs(diagonal)),
            levels: Vec::new(),
            sizes: Vec::new(),
            convection: false,
        }
    }

    /// Adds a level whose smoother is [`IncompleteLu`] of its stabilised matrix; returns the
    /// operator of the next one, that of the same matrix.
    fn push_convection(
        &mut self,
        operator: &Bordered,
        stable: Csr,
        prolongation: &Prolongation,
    ) -> Result<Bordered, LinalgError> {
        let stable = operator.with_stiffness(stable)?;
        let constrained = operator.constrained_dofs();
        let unit = self.unit.recip();
        let (factors, coarse) = rayon::join(
            || IncompleteLu::new(stable.stiffness(), constrained, unit),
            || prolongation.galerkin(&stable, None),
        );
        self.record(operator, prolongation.nodes().nnz(), 1);
        let diagonal = csr::diagonal(operator.stiffness());
        let level = Level::new(operator, prolongation, &diagonal, unit, &[1.0]);
        self.levels.push(level.with_factors(Some(factors)));
        Ok(coarse.with_unsymmetric_stiffness())
    }

    fn record(&mut self, operator: &Bordered, prolongation_nnz: usize, sweeps: usize) {
        self.sizes.push(LevelSize {
            nodes: operator.nodes(),
            nnz: operator.stiffness().nnz(),
            border_nnz: operator.border().nnz(),
            prolongation_nnz,
            sweeps,
        });
    }

    fn push(&mut self, operator: &Bordered, prolongation: &Prolongation, scaling: &JacobiScaling) {
        let factors = (self.params).relaxation_factors(self.levels.len(), scaling.upper);
        self.record(operator, prolongation.nodes().nnz(), factors.len());
        self.levels.push(Level::new(
            operator,
            prolongation,
            &scaling.diagonal,
            self.unit.recip(),
            &factors,
        ));
    }

    /// Aggregates until the coarsest level is reached.
    fn aggregate(mut self, mut operator: Cow<Bordered>) -> Result<Multigrid, LinalgError> {
        while operator.nodes() > self.params.coarsest_nodes {
            let diagonal = positive_diagonal("coarse stiffness matrix", operator.stiffness())?;
            let stable = (self.convection).then(|| stabilised(operator.stiffness()));
            // aggregates and their smoothing are those of the diffusion
            let symmetric = match &stable {
                Some(stable) => Cow::Owned(operator.with_stiffness(symmetric_part(stable)?)?),
                None => Cow::Borrowed(&*operator),
            };
            let scaling = JacobiScaling::new(symmetric.stiffness())?;
            let MultigridParams {
                coarsening,
                strength,
                ..
            } = *self.params;
            let next = smoothed_aggregation::prolongation(
                &symmetric, &diagonal, &scaling, coarsening, strength,
            );
            drop(symmetric);
            let Some(prolongation) = next else {
                self.params
                    .check_stalled(self.levels.len(), operator.nodes())?;
                break;
            };
            if let Some(stable) = stable {
                let coarse = self.push_convection(&operator, stable, &prolongation)?;
                operator = Cow::Owned(coarse);
                continue;
            }
            let fine = &operator;
            let ((), coarse) = rayon::join(
                || self.push(fine, &prolongation, &scaling),
                || prolongation.galerkin(fine, None),
            );
            operator = Cow::Owned(coarse);
        }
        self.record(&operator, 0, 0);
        Ok(Multigrid {
            coarse: CoarseSolver::new(&operator, self.unit.recip(), self.params)?,
            levels: self.levels,
            sizes: self.sizes,
            unit: self.unit,
        })
    }
}

/// One V-cycle from zero on the first of `levels`, for `S` columns.
///
/// Leaves each level's solution in its vectors.
fn cycle<const S: usize, C: Components>(levels: &mut [Level<C>], coarse: &mut CoarseSolver) {
    let Some((fine, rest)) = levels.split_first_mut() else {
        return coarse.solve::<S>();
    };
    fine.smooth_from_zero::<S>();
    fine.restrict::<S>(top(rest, coarse));
    cycle::<S, C>(rest, coarse);
    fine.prolong::<S>(top(rest, coarse));
    fine.smooth::<S>();
}

fn top<'a, C: Components>(
    levels: &'a mut [Level<C>],
    coarse: &'a mut CoarseSolver,
) -> &'a mut Vectors {
    match levels.first_mut() {
        Some(level) => &mut level.vectors,
        None => &mut coarse.vectors,
    }
}

/// One cycle for each right-hand side `(nodes(i), border)`, see [`Multigrid::apply_to`].
fn apply_cycle<const S: usize, C: Components>(
    levels: &mut [Level<C>],
    coarse: &mut CoarseSolver,
    unit: f64,
    size: [f64; S],
    nodes: impl Fn(usize) -> [[f64; 3]; S] + Sync,
    border: [&[f64]; S],
    z: [&mut [f64]; S],
) {
    levels.iter_mut().for_each(|l| l.vectors.widen(S));
    coarse.vectors.widen(S);
    let scale = size.map(power_of_two_below);
    let (down, up) = (scale.map(f64::recip), scale.map(|scale| scale / unit));
    let Columns {
        b,
        border_b,
        constrained,
        ..
    } = top(levels, coarse).columns::<S>();
    for_each_chunk(b, &|start, b| {
        for (i, b) in b.iter_mut().enumerate() {
            let r = nodes(start + i);
            for s in 0..S {
                let [x, y, z] = r[s].map(|r| (r * down[s]) as f32);
                b[s] = [x, y, z, 0.0];
            }
        }
    });
    constrained.clear_columns(b);
    for (c, b) in border_b.iter_mut().enumerate() {
        *b = from_fn(|s| (border[s][c] * down[s]) as f32);
    }
    cycle::<S, C>(levels, coarse);
    let Columns { x, border_x, .. } = top(levels, coarse).columns::<S>();
    for (s, z) in z.into_iter().enumerate() {
        let (z_nodes, z_border) = z.split_at_mut(3 * x.len());
        for_each_chunk(nodes_mut(z_nodes), &|start, z| {
            for (z, x) in z.iter_mut().zip(&x[start..]) {
                *z = [x[s][0], x[s][1], x[s][2]].map(|v| f64::from(v) * up[s]);
            }
        });
        for (z, x) in z_border.iter_mut().zip(&*border_x) {
            *z = f64::from(x[s]) * up[s];
        }
    }
}

impl Multigrid {
    /// One cycle for each right-hand side `(nodes(i), border)`.
    ///
    /// `size` is the order of magnitude of the entries of the right-hand sides.
    pub(crate) fn apply_to<const S: usize>(
        &mut self,
        size: [f64; S],
        nodes: impl Fn(usize) -> [[f64; 3]; S] + Sync,
        border: [&[f64]; S],
        z: [&mut [f64]; S],
    ) {
        apply_cycle(
            &mut self.levels,
            &mut self.coarse,
            self.unit,
            size,
            nodes,
            border,
            z,
        );
    }

    fn pass<const S: usize>(&mut self, r: [&[f64]; S], z: [&mut [f64]; S]) {
        assert_lengths(&r, self.size(), &z, self.size());
        let (r_nodes, r_border) = split(r, 3 * self.sizes[0].nodes);
        let r_nodes = r_nodes.map(nodes);
        self.apply_to(r.map(max_abs), |i| r_nodes.map(|r| r[i]), r_border, z);
    }
}

impl Preconditioner for Multigrid {
    fn size(&self) -> usize {
        3 * self.sizes[0].nodes + self.coarse.vectors.border()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        self.pass([r], [z]);
    }

    fn apply_columns(&mut self, r: &[&[f64]], z: &mut [&mut [f64]]) {
        in_passes!(self.pass(r, z));
    }

    fn kind(&self) -> PreconditionerKind {
        if self.coarse.definite {
            PreconditionerKind::PositiveDefinite
        } else {
            PreconditionerKind::Linear
        }
    }
}

impl fmt::Display for Multigrid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "level     nodes   nonzeros  per row     border")?;
        for (l, size) in self.sizes.iter().enumerate() {
            let per_row = size.nnz as f64 / size.nodes.max(1) as f64;
            let LevelSize {
                nodes,
                nnz,
                border_nnz,
                ..
            } = size;
            writeln!(f, "{l:5} {nodes:9} {nnz:10} {per_row:8.1} {border_nnz:10}")?;
        }
        write!(f, "operator complexity {:.3}", self.operator_complexity())
    }
}
