//! Forces on bodies that oscillate with small amplitudes.

use nalgebra::{Complex, DMatrix};

use super::bodies::{AxialBody, check, check_growth, domain};
use super::flow_system::{FlowSystem, Terms, centres};
use super::nested_condensation::NestedCondensation;
use super::orders::{GROWTH, raise_order};
use crate::generate::generate;
use crate::{AxialSpheroid, AxisymmetricError, Surroundings};

/// Parameters of an impedance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ImpedanceParameters {
    /// Density of the fluid times the angular frequency, at viscosity 1: `S / a^2` with the scale
    /// parameter `S = ω a^2 / ν` of a body of the size `a`.
    pub frequency: f64,
    /// Largest estimated error of an entry, relative to the largest one.
    pub tolerance: f64,
    /// Edge length relative to the distance from the focus of the nearest body.
    ///
    /// By default at most 2.5 thicknesses `frequency^(-1/2)` of the boundary layer.
    pub growth: f64,
}

impl ImpedanceParameters {
    /// The impedance at this frequency, to 1e-6.
    pub fn new(frequency: f64) -> Self {
        Self {
            frequency,
            tolerance: 1e-6,
            growth: GROWTH.min(2.5 / frequency.sqrt()),
        }
    }

    /// The same with another tolerance.
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// The same with a mesh that is graded otherwise.
    #[must_use]
    pub fn with_growth(self, growth: f64) -> Self {
        Self { growth, ..self }
    }
}

/// The impedance of bodies on one axis.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Impedance {
    /// `F = Z U`: amplitudes of the forces that the bodies exert on the fluid, with `e^(-iωt)`.
    ///
    /// Symmetric. The forces contain the inertia of the fluid, not that of the bodies.
    pub matrix: DMatrix<Complex<f64>>,
    /// Estimated error relative to the largest entry: the last change of the order.
    pub relative_error: f64,
    /// Polynomial degree of the velocities.
    pub order: usize,
}

/// Computes the forces from oscillating velocities along the axis, for small displacements.
///
/// Unsteady Stokes equations `-iωρ u - Δu + ∇p = 0` at viscosity 1, real and imaginary part as one
/// real system, with elements of increasing order until the result changes by less than the
/// tolerance. At the frequency zero it is the resistance.
///
/// Cost: about a second.
///
/// ```
/// use axisymmetric::{AxialSpheroid, ImpedanceParameters, Surroundings, impedance};
///
/// let sphere = AxialSpheroid::sphere(0.0, 1.0);
/// let parameters = ImpedanceParameters::new(1.0);
/// let found = impedance(&[sphere], Surroundings::Ball { radius: 10.0 }, &parameters)?;
/// let relative = found.matrix[(0, 0)] / (6.0 * std::f64::consts::PI);
/// // in unbounded fluid 1 + α + α^2 / 9 = 1.707 - 0.818 i with α^2 = -i (Stokes 1851)
/// assert!((relative.re - 1.717948332).abs() < 1e-6 && (relative.im + 0.808801198).abs() < 1e-6);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
///
/// # Errors
/// [`AxisymmetricError::NoContainer`], [`AxisymmetricError::FlowNotConverged`], numbers out of
/// range, and domains that cannot be meshed.
pub fn impedance(
    bodies: &[AxialSpheroid],
    surroundings: Surroundings,
    parameters: &ImpedanceParameters,
) -> Result<Impedance, AxisymmetricError> {
    check("the density times the frequency", parameters.frequency)?;
    check_growth(parameters.growth)?;
    let list: Vec<AxialBody> = bodies.iter().map(|b| AxialBody::prescribed(*b)).collect();
    let meridian = domain(&list, surroundings)?;
    // each velocity is an unknown that is kept
    let motions: Vec<Option<usize>> = (0..bodies.len()).map(Some).collect();
    let solve = |order: usize, _: Option<&Impedance>| {
        let mesh = generate(&meridian, parameters.growth)?;
        let system = FlowSystem::new(mesh, order, motions.clone(), bodies.len(), None, None)?;
        Ok(Impedance {
            matrix: of_system(&system, parameters.frequency)?,
            relative_error: f64::INFINITY,
            order,
        })
    };
    let largest =
        |matrix: &DMatrix<Complex<f64>>| matrix.iter().map(|z| z.norm()).fold(0.0, f64::max);
    let (found, error) = raise_order([parameters.tolerance, 0.0], solve, |before, after| {
        largest(&(&after.matrix - &before.matrix)) / largest(&after.matrix)
    })?;
    Ok(Impedance {
        relative_error: error,
        ..found
    })
}

/// The impedance by one discretisation.
///
/// With the matrices `A` of Stokes flow and `M` of the mass, `(A - i s M) (x + i y) = f + i g` is
///
/// ```text
/// [ A    s M ] [x]   [f]
/// [ -s M   A ] [y] = [g]
/// ```
fn of_system(
    system: &FlowSystem,
    frequency: f64,
) -> Result<DMatrix<Complex<f64>>, AxisymmetricError> {
    let (mut unknowns, total, kept) = system.unknowns();
    for list in &mut unknowns {
        let imaginary: Vec<_> = list
            .iter()
            .map(|id| id.map(|id| id + total as u32))
            .collect();
        list.extend(imaginary);
    }
    let imaginary = kept.iter().map(|id| id + total as u32);
    let all_kept: Vec<u32> = kept.iter().copied().chain(imaginary).collect();
    let centres = centres(system.mesh());
    let condensation = NestedCondensation::new(unknowns, &centres, 2 * total, &all_kept);
    let (positions, rest) = (system.positions(), system.rest());
    let both = condensation.condensed(&|t| {
        let element = system.element(t, &positions, &rest, &Terms::default())?;
        let (stokes, mass) = (element.jacobian(), element.mass());
        let (size, n) = (stokes.nrows(), mass.nrows());
        let mut matrix = DMatrix::zeros(2 * size, 2 * size);
        for part in 0..2 {
            let own = part * size;
            matrix.view_mut((own, own), (size, size)).copy_from(&stokes);
            let sign = if part == 0 { frequency } else { -frequency };
            let other = (1 - part) * size;
            for component in [0, n] {
                let mut block = matrix.view_mut((own + component, other + component), (n, n));
                block.copy_from(&(sign * &mass));
            }
        }
        Ok::<_, AxisymmetricError>(matrix)
    })?;
    let n = kept.len();
    // the columns of unit real velocities
    Ok(DMatrix::from_fn(n, n, |i, j| {
        Complex::new(both[(i, j)], both[(n + i, j)])
    }))
}
