//! Bodies that move along the axis of a fluid with inertia.

use crate::meridian::Meridian;
use crate::{AxialSpheroid, AxisymmetricError, Surroundings};

/// What determines the velocity of a body along the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxialMotion {
    /// The velocity is prescribed.
    Prescribed,
    /// The body moves freely, together with all bodies of the same number.
    ///
    /// The bodies of a number form a swimmer: the velocities between them are prescribed, and the
    /// balance of the forces on all of them determines the velocity that they share.
    Free(usize),
}

/// A body of revolution on the axis with its mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxialBody {
    /// Its shape and position.
    pub shape: AxialSpheroid,
    /// Mass; zero for a body without.
    pub mass: f64,
    /// What determines its velocity.
    pub motion: AxialMotion,
}

impl AxialBody {
    /// A body with a prescribed velocity.
    pub fn prescribed(shape: AxialSpheroid) -> Self {
        Self {
            shape,
            mass: 0.0,
            motion: AxialMotion::Prescribed,
        }
    }

    /// A homogeneous body of this density that moves freely as a part of swimmer `swimmer`.
    pub fn free(shape: AxialSpheroid, density: f64, swimmer: usize) -> Self {
        Self {
            shape,
            mass: density * shape.volume(),
            motion: AxialMotion::Free(swimmer),
        }
    }
}

/// Shapes of bodies.
pub(crate) fn shapes(bodies: &[AxialBody]) -> Vec<AxialSpheroid> {
    bodies.iter().map(|body| body.shape).collect()
}

/// Number of the free motion of each body, from zero without gaps, and their number.
pub(crate) fn motions(bodies: &[AxialBody]) -> (Vec<Option<usize>>, usize) {
    let mut numbers = Vec::new();
    let motions = (bodies.iter())
        .map(|body| match body.motion {
            AxialMotion::Prescribed => None,
            AxialMotion::Free(swimmer) => {
                let known = numbers.iter().position(|&number| number == swimmer);
                Some(known.unwrap_or_else(|| {
                    numbers.push(swimmer);
                    numbers.len() - 1
                }))
            }
        })
        .collect();
    (motions, numbers.len())
}

/// The domain around bodies in a container.
///
/// # Errors
/// [`AxisymmetricError::NoContainer`], masses that are not numbers, those of [`Meridian::new`].
pub(crate) fn domain(
    bodies: &[AxialBody],
    surroundings: Surroundings,
) -> Result<Meridian, AxisymmetricError> {
    if surroundings == Surroundings::Unbounded {
        return Err(AxisymmetricError::NoContainer);
    }
    for body in bodies {
        check("the mass of a body", body.mass)?;
    }
    Meridian::new(&shapes(bodies), surroundings)
}

/// Refuses a number that is negative or not finite.
pub(crate) fn check(what: &'static str, value: f64) -> Result<(), AxisymmetricError> {
    if value >= 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(AxisymmetricError::InvalidNumber {
        what,
        value,
        range: "zero or positive",
    })
}

/// Refuses a list whose length is not the number of bodies.
pub(crate) fn check_length(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), AxisymmetricError> {
    match expected == found {
        true => Ok(()),
        false => Err(AxisymmetricError::Length {
            what,
            expected,
            found,
        }),
    }
}

/// Refuses a growth of the mesh that is not positive or leads to elements as large as the domain.
pub(crate) fn check_growth(growth: f64) -> Result<(), AxisymmetricError> {
    if growth > 0.0 && growth <= 1.0 {
        return Ok(());
    }
    Err(AxisymmetricError::InvalidNumber {
        what: "the growth of the mesh",
        value: growth,
        range: "positive and at most 1",
    })
}
