//! Block-diagonal and block-triangular preconditioners of systems with any blocks.

use std::ops::Range;

use crate::columns::assert_lengths;
use crate::{LinalgError, LinearOperator, Preconditioner, PreconditionerKind};

/// The part of the block matrix that a [`BlockPreconditioner`] inverts.
///
/// With the approximate inverses `N_i` of the blocks `i`, in the order in which they were added:
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum BlockForm {
    /// `z_i = N_i r_i`; couplings are not used.
    ///
    /// Positive definite if all blocks are, as [`minres`](crate::minres) requires. A Schur
    /// complement has a positive sign.
    Diagonal,
    /// `z_i = N_i (r_i - sum_(j < i) A_ij z_j)`, from the first block to the last.
    Lower,
    /// `z_i = N_i (r_i - sum_(j > i) A_ij z_j)`, from the last block to the first.
    Upper,
}

/// A preconditioner of named blocks, each with an approximate inverse given by the user.
///
/// Blocks are contiguous ranges of the vectors and cover all of them. [`BlockForm`] has the
/// formulas. For the saddle-point system `[A B^T; B 0]` add `A`, then the Schur complement
/// `S = B A^-1 B^T` by [`schur_complement`](BlockPreconditionerBuilder::schur_complement). The
/// triangular forms are then those of `[A B^T; 0 -S]` and `[A 0; B -S]`, with which GMRES needs two
/// iterations if both inverses are exact (Murphy, Golub, Wathen, SIAM J. Sci. Comput. 21, 2000).
///
/// For a [`SaddleSystem`](crate::SaddleSystem), [`BlockTriangular`](crate::BlockTriangular) is
/// faster: it subtracts the gradient while it rounds the residual to single precision, and has
/// several columns in one pass. Here they are treated one after another.
///
/// Cost of `apply`: one of each block's inverse and one product with each coupling used; allocates
/// nothing.
///
/// ```
/// use linalg::{
///     BlockForm, BlockPreconditionerBuilder, Csr, CsrOperator, Identity, KrylovParams,
///     MassInverse, fgmres,
/// };
/// // [2 0 1; 0 2 1; 1 1 0]: A = 2 I, B = [1 1], S = 1
/// let (columns, values) = (vec![0, 2, 1, 2, 0, 1], vec![2.0, 1.0, 2.0, 1.0, 1.0, 1.0]);
/// let system = CsrOperator::new(Csr::new((3, 3), vec![0, 2, 4, 6], columns, values))?;
/// let gradient = Csr::new((2, 1), vec![0, 1, 2], vec![0, 0], vec![1.0, 1.0]);
/// let gradient = CsrOperator::new(gradient)?;
/// let velocity = MassInverse::new(&Csr::eye(2).map(|one: &f64| 2.0 * one), 3)?;
/// let mut preconditioner = BlockPreconditionerBuilder::new(3)
///     .block("velocity", 0..2, velocity)
///     .schur_complement("pressure", 2..3, Identity(1))
///     .coupling("velocity", "pressure", &gradient)
///     .build(BlockForm::Upper)?;
/// let mut x = [0.0; 3];
/// let b = [4.0, 6.0, 1.0];
/// fgmres(&system, &mut preconditioner, &b, &mut x, &KrylovParams::default())?;
/// // A x + B^T p = b with x = (0, 1) and p = 4
/// assert!((x[1] - 1.0).abs() < 1e-6 && (x[2] - 4.0).abs() < 1e-6);
/// # Ok::<(), linalg::LinalgError>(())
/// ```
pub struct BlockPreconditioner<'a> {
    size: usize,
    kind: PreconditionerKind,
    /// Blocks in the order in which they are solved for.
    blocks: Vec<Block<'a>>,
    residual: Vec<f64>,
    product: Vec<f64>,
}

struct Block<'a> {
    name: String,
    range: Range<usize>,
    inverse: Box<dyn Preconditioner + 'a>,
    is_schur_complement: bool,
    /// The blocks of the row that are used, with the ranges of their columns.
    couplings: Vec<(Range<usize>, Box<dyn LinearOperator + 'a>)>,
}

struct Coupling<'a> {
    row: String,
    column: String,
    operator: Box<dyn LinearOperator + 'a>,
}

/// The blocks of a [`BlockPreconditioner`] before they are checked.
#[must_use]
pub struct BlockPreconditionerBuilder<'a> {
    size: usize,
    blocks: Vec<Block<'a>>,
    couplings: Vec<Coupling<'a>>,
}

impl<'a> BlockPreconditionerBuilder<'a> {
    /// Begins with no blocks of a system with `size` rows.
    pub fn new(size: usize) -> Self {
        BlockPreconditionerBuilder {
            size,
            blocks: Vec::new(),
            couplings: Vec::new(),
        }
    }

    /// Adds the diagonal block of the rows and columns `range`, with its approximate inverse.
    ///
    /// A matrix that is an approximate inverse itself is an
    /// [`ExplicitInverse`](crate::ExplicitInverse). A reference to a preconditioner is one too.
    pub fn block(self, name: &str, range: Range<usize>, inverse: impl Preconditioner + 'a) -> Self {
        self.push(name, range, Box::new(inverse), false)
    }

    /// Adds a block with the approximate inverse of its Schur complement `S = B A^-1 B^T`.
    ///
    /// The triangular forms have `-S` as the diagonal block, the diagonal form has `S`.
    pub fn schur_complement(
        self,
        name: &str,
        range: Range<usize>,
        inverse: impl Preconditioner + 'a,
    ) -> Self {
        self.push(name, range, Box::new(inverse), true)
    }

    fn push(
        mut self,
        name: &str,
        range: Range<usize>,
        inverse: Box<dyn Preconditioner + 'a>,
        is_schur_complement: bool,
    ) -> Self {
        self.blocks.push(Block {
            name: name.into(),
            range,
            inverse,
            is_schur_complement,
            couplings: Vec::new(),
        });
        self
    }

    /// Adds the off-diagonal block `A_ij` with the rows of block `row` and the columns of `column`.
    ///
    /// Forms use the couplings of their triangle only, so that both triangles may be given.
    pub fn coupling(mut self, row: &str, column: &str, operator: impl LinearOperator + 'a) -> Self {
        self.couplings.push(Coupling {
            row: row.into(),
            column: column.into(),
            operator: Box::new(operator),
        });
        self
    }

    /// Checks the blocks and couplings, and returns their preconditioner of the given form.
    ///
    /// # Errors
    /// [`LinalgError::Block`] for a name that is used twice or unknown, a range that is reversed,
    /// overlaps another or leaves rows without a block, an inverse or a coupling whose size does
    /// not fit, and a triangular form without any coupling in its triangle. The message names the
    /// block.
    pub fn build(self, form: BlockForm) -> Result<BlockPreconditioner<'a>, LinalgError> {
        self.check_ranges()?;
        let BlockPreconditionerBuilder {
            size,
            mut blocks,
            couplings,
        } = self;
        let mut known = Vec::with_capacity(couplings.len());
        for coupling in couplings {
            let (i, j) = place(&coupling, &blocks)?;
            if known.contains(&(i, j)) {
                let problem = format!("its coupling with `{}` is given twice", coupling.column);
                return refuse(&coupling.row, problem);
            }
            known.push((i, j));
            let used = match form {
                BlockForm::Diagonal => false,
                BlockForm::Lower => j < i,
                BlockForm::Upper => j > i,
            };
            if used {
                let columns = blocks[j].range.clone();
                blocks[i].couplings.push((columns, coupling.operator));
            }
        }
        let is_uncoupled = blocks.iter().all(|block| block.couplings.is_empty());
        if form != BlockForm::Diagonal && is_uncoupled && blocks.len() > 1 {
            let problem = format!(
                "no coupling lies in the triangle of {form:?}, which would be block-diagonal; add \
                 one or take BlockForm::Diagonal"
            );
            return refuse(&blocks[0].name, problem);
        }
        let kinds = blocks.iter().map(|block| block.inverse.kind());
        let least = match form {
            BlockForm::Diagonal => PreconditionerKind::PositiveDefinite,
            BlockForm::Lower | BlockForm::Upper => PreconditionerKind::Linear,
        };
        let kind = kinds.fold(least, PreconditionerKind::max);
        match form {
            BlockForm::Diagonal => {
                for block in &mut blocks {
                    block.is_schur_complement = false;
                }
            }
            BlockForm::Lower => {}
            BlockForm::Upper => blocks.reverse(),
        }
        let longest = blocks.iter().map(|block| block.range.len()).max();
        let buffer = vec![0.0; longest.unwrap_or(0)];
        Ok(BlockPreconditioner {
            size,
            kind,
            blocks,
            residual: buffer.clone(),
            product: buffer,
        })
    }

    /// Refuses names that are used twice, inverses of other sizes, overlaps and gaps.
    fn check_ranges(&self) -> Result<(), LinalgError> {
        for (
            k,
            Block {
                name,
                range,
                inverse,
                ..
            },
        ) in self.blocks.iter().enumerate()
        {
            if self.blocks[..k].iter().any(|other| other.name == *name) {
                return refuse(name, "two blocks have this name".into());
            }
            if range.start > range.end || range.end > self.size {
                let size = self.size;
                return refuse(
                    name,
                    format!("its range {range:?} is not part of 0..{size}"),
                );
            }
            let (found, rows) = (inverse.size(), range.len());
            if found != rows {
                let problem =
                    format!("its inverse has {found} rows, its range {range:?} has {rows}");
                return refuse(name, problem);
            }
        }
        let filled = self.blocks.iter().filter(|block| !block.range.is_empty());
        let mut sorted: Vec<&Block> = filled.collect();
        sorted.sort_by_key(|block| block.range.start);
        let mut end = 0;
        let mut before = "";
        for Block { name, range, .. } in sorted {
            if range.start < end {
                let problem =
                    format!("its range {range:?} overlaps that of `{before}`, which ends at {end}");
                return refuse(name, problem);
            }
            if range.start > end {
                return refuse(
                    name,
                    format!("rows {end}..{} before it are in no block", range.start),
                );
            }
            (end, before) = (range.end, name);
        }
        if end < self.size {
            return refuse(
                before,
                format!("rows {end}..{} behind it are in no block", self.size),
            );
        }
        Ok(())
    }
}

/// The numbers of the blocks that a coupling names: its row and its column.
///
/// Refuses unknown names, a block coupled with itself, and an operator of another shape.
fn place(coupling: &Coupling, blocks: &[Block]) -> Result<(usize, usize), LinalgError> {
    let Coupling {
        row,
        column,
        operator,
    } = coupling;
    let place = |name: &str| match blocks.iter().position(|block| block.name == name) {
        Some(block) => Ok(block),
        None => {
            let names: Vec<&str> = blocks.iter().map(|block| block.name.as_str()).collect();
            let problem = format!("a coupling names it, but the blocks are {names:?}");
            refuse(name, problem)
        }
    };
    let (i, j) = (place(row)?, place(column)?);
    if i == j {
        let problem = "it is coupled with itself; the diagonal block is part of its inverse";
        return refuse(row, problem.into());
    }
    let found = (operator.rows(), operator.cols());
    let expected = (blocks[i].range.len(), blocks[j].range.len());
    if found != expected {
        let problem =
            format!("its coupling with `{column}` has shape {found:?}, expected {expected:?}");
        return refuse(row, problem);
    }
    Ok((i, j))
}

fn refuse<T>(block: &str, problem: String) -> Result<T, LinalgError> {
    Err(LinalgError::Block {
        block: block.into(),
        problem,
    })
}

impl Preconditioner for BlockPreconditioner<'_> {
    fn size(&self) -> usize {
        self.size
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        assert_lengths(&[r], self.size, &[&mut *z], self.size);
        for block in &mut self.blocks {
            let rows = block.range.clone();
            if block.couplings.is_empty() {
                block.inverse.apply(&r[rows.clone()], &mut z[rows.clone()]);
            } else {
                let residual = &mut self.residual[..rows.len()];
                let product = &mut self.product[..rows.len()];
                residual.copy_from_slice(&r[rows.clone()]);
                for (columns, operator) in &block.couplings {
                    operator.apply(&z[columns.clone()], product);
                    for (r, p) in residual.iter_mut().zip(&*product) {
                        *r -= p;
                    }
                }
                block.inverse.apply(residual, &mut z[rows.clone()]);
            }
            if block.is_schur_complement {
                z[rows].iter_mut().for_each(|z| *z = -*z);
            }
        }
    }

    fn kind(&self) -> PreconditionerKind {
        self.kind
    }
}
