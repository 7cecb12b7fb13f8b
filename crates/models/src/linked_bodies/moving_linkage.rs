//! One linkage in one configuration, with what moves it.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rigid::{Articulation, Constraints, Drive, ExternalLoad, LinkagePart, Reduction};

use crate::error::ModelError;

/// One linkage in one configuration, for one set of rates, in scaled units.
#[derive(Clone)]
pub(super) struct MovingLinkage<'a> {
    pub part: &'a LinkagePart,
    pub constraints: Constraints,
    pub loads: Vec<ExternalLoad>,
    pub reduction: Reduction,
    /// `B^T (F - D W)` for the loads `F`, the dashpots `D` and the basis `B` of all velocities.
    pub load: DVector<f64>,
    /// `B^T D B`.
    pub damping: DMatrix<f64>,
    /// The part of the load that is random.
    pub random: Option<DVector<f64>>,
}

impl<'a> MovingLinkage<'a> {
    pub fn new(
        part: &'a LinkagePart,
        mut constraints: Constraints,
        loads: Vec<ExternalLoad>,
    ) -> Result<Self, ModelError> {
        let reduction = Reduction::new(part.set(), &constraints)?;
        if let Some(random) = &mut constraints.random_loads {
            // The motions that no surface resists turn with the linkage.
            let places = part.set().state_velocities();
            let unresisted = &reduction.all.unresisted;
            let power = unresisted.tr_mul(random);
            let own = on_state(unresisted, &places, &power)?;
            places
                .iter()
                .zip(own.iter())
                .for_each(|(&k, load)| random[k] -= load);
        }
        let drive = Drive {
            set: part.set(),
            constraints: &constraints,
            loads: &loads,
        };
        let all = &reduction.all;
        let acting = drive.generalised_loads()? - drive.damping_times(&all.offset)?;
        let (load, damping) = (
            all.basis.tr_mul(&acting),
            drive.damping_projected(&all.basis, &all.basis)?,
        );
        let random = constraints.random_loads.as_ref();
        Ok(Self {
            part,
            random: random.map(|random| reduction.all.basis.tr_mul(random)),
            reduction,
            load,
            damping,
            constraints,
            loads,
        })
    }

    pub fn set(&self) -> &Articulation {
        self.part.set()
    }

    /// Whether the linkage cannot follow a flow: the velocity of a body is given.
    pub fn is_held(&self) -> bool {
        self.set().held_translation().contains(&true)
    }

    pub fn drive(&self) -> Drive<'_> {
        Drive {
            set: self.set(),
            constraints: &self.constraints,
            loads: &self.loads,
        }
    }
}

/// Loads of the smallest norm on the velocities at `places` that do the work of `loads` on the
/// motions in the columns of `basis`.
///
/// # Errors
/// Motions that do not differ at these places.
pub(super) fn on_state(
    basis: &DMatrix<f64>,
    places: &[usize],
    loads: &DVector<f64>,
) -> Result<DVector<f64>, ModelError> {
    let moved = basis.select_rows(places);
    Ok(&moved * cholesky(moved.tr_mul(&moved))?.solve(loads))
}

/// The factor of a resistance to the motions of linkages.
///
/// # Errors
/// A matrix that is not positive definite.
pub(super) fn cholesky(matrix: DMatrix<f64>) -> Result<Cholesky<f64, Dyn>, ModelError> {
    matrix.clone().cholesky().ok_or_else(|| {
        let name = "resistance of the motions that the links leave free";
        let remedy = "the bodies are too close for this model; use a more accurate one";
        ModelError::not_positive_definite(name, &matrix, remedy)
    })
}
