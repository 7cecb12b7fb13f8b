//! Cases A, B and D: spheres on the x axis in a ball, by finite elements.

use std::f64::consts::PI;

use anyhow::{Context, Result};
use nalgebra::{DMatrix, Vector3};

use super::expected;
use super::row::{Basis, Cost, Estimated, Row};
use crate::reference::{COLLINEAR, Collinear, OPPOSITE_MOTION, concentric_drag, concentric_torque};
use crate::scenes::{by_elements, in_ball, loaded_sphere, solve};

/// A: drag and torque of a sphere in balls of 10, 5 and 2 radii.
pub fn concentric(quick: bool) -> Result<Vec<Row>> {
    let sizes: &[f64] = if quick { &[0.4] } else { &[0.4, 0.2] };
    let mut rows = Vec::new();
    for lambda in [0.1, 0.2, 0.5] {
        for &size in sizes {
            rows.extend(drag_and_torque(lambda, size)?);
        }
    }
    Ok(rows)
}

fn drag_and_torque(lambda: f64, size: f64) -> Result<[Row; 2]> {
    let solution = solve(&loaded_sphere(lambda, size)?)?;
    let cost = Cost::new(&solution);
    let body = &solution.bodies[0];
    let drag = 1.0 / (6.0 * PI * body.velocity.x);
    let torque = 1.0 / (8.0 * PI * body.angular_velocity.z);
    let of_drag = Estimated::velocity(&solution, 0).times(-drag / body.velocity.x);
    let of_torque = Estimated::angular_velocity(&solution, 0)
        .map(|estimated| estimated.times(-torque / body.angular_velocity.z));
    let tolerances = expected::sphere(size, lambda)?;
    let row = |name: &str, values, tolerance| {
        let name = format!("{name}, lambda {lambda}, h {size}");
        Row::relative("A", name, values, (tolerance, Basis::Interpolation), cost)
    };
    let drags = [concentric_drag(lambda), drag];
    let torques = [concentric_torque(lambda), torque];
    Ok([
        row("drag / 6 pi", drags, tolerances.drag).with(of_drag),
        row("torque / 8 pi", torques, tolerances.torque).with(of_torque),
    ])
}

/// Radius of the ball around two spheres.
///
/// The pair has no net force, so its image is a quadratic flow: at centre distance `s` the force
/// changes by less than `(s / radius)^3`, 4e-6 at the largest distance.
const PAIR_CONTAINER: f64 = 400.0;

/// Element size on two spheres; the tolerance follows from the change from twice this size.
///
/// The size must be below 0.26, from where on the growth rate of the elements has its largest value
/// (`FemModel::default_growth`). Between two larger sizes, elements far from the spheres are hardly
/// refined, so the change would not contain their error.
/// Besides, a gap of one radius refines a mesh of size above 0.45, but not the one of half that
/// size. Measured at distance 3: from size 0.6 to 0.3 the error decreases by a factor of 3.7 only,
/// from 0.4 to 0.2 by 9.3.
const PAIR_SIZE: f64 = 0.2;

/// Footnote on the container of two spheres and on missing rows.
pub const PAIR_NOTE: &str = "B: the ball of radius 400 changes forces on a force-free pair by less than (s / 400)^3, at most 4e-6. Two spheres that move \
     together have a net force, whose container effect of 9/4 over the ball radius would need a far-field correction: they are left out.";

/// B: force over `6 pi U` on each of two spheres that move in opposite directions.
pub fn pairs(quick: bool) -> Result<Vec<Row>> {
    let least = if quick { 3.0 } else { 2.05 };
    let cases = OPPOSITE_MOTION
        .iter()
        .filter(|(distance, _)| *distance >= least);
    let row = |&(distance, exact): &(f64, f64)| {
        let coarse = opposite(distance, exact, 2.0 * PAIR_SIZE)?;
        let fine = opposite(distance, exact, PAIR_SIZE)?;
        let refined = expected::from_halving(coarse.computed, fine.computed);
        let unrefined = expected::gap(distance - 2.0, 2.0 * PAIR_SIZE);
        Ok(Row {
            tolerance: (refined + unrefined) / exact + fine.exact_bar,
            ..fine
        })
    };
    cases.map(row).collect()
}

/// Row of one distance, without a tolerance. A joint between the two spheres closes at rate two.
fn opposite(distance: f64, exact: f64, size: f64) -> Result<Row> {
    // A hundredth of the gap: only the rate matters, but the spheres must not touch during the
    // phase.
    let change = 0.01 * (distance - 2.0);
    let scene = in_ball(PAIR_CONTAINER, &by_elements(size))
        .spheres_on_axis(&[1.0; 2], [-0.5, 0.5].map(|side| side * distance))
        .joint("link", "s1", "s0")
        .phase("link", distance - change)
        .key("duration", change / 2.0);
    let solution = solve(&scene.parse()?)?;
    let [left, right] = [0, 1].map(|k| &solution.bodies[k]);
    // Half of the difference, so that a common velocity of both spheres does not matter.
    let approach = 0.5 * (left.velocity.x - right.velocity.x);
    let unit = 6.0 * PI * approach;
    let force = 0.5 * (left.force.x - right.force.x);
    let name = format!("opposite, s {distance}, h {size}");
    let tolerance = (f64::INFINITY, Basis::Halving);
    let cost = Cost::new(&solution);
    Ok(
        Row::relative("B", name, [exact, force / unit], tolerance, cost)
            .with(Estimated::force(&solution, 0).map(|own| own.times(1.0 / unit)))
            .with_exact_bar((distance / PAIR_CONTAINER).powi(3)),
    )
}

/// D: the entry with the largest error of each axial resistance matrix of spheres on a diameter of
/// a ball, relative to the largest entry.
pub fn collinear(quick: bool) -> Result<Vec<Row>> {
    let size = if quick { 0.4 } else { 0.25 };
    COLLINEAR.iter().map(|case| axial(case, size)).collect()
}

/// Row of the axial resistance of spheres, the inverse of the mobility matrix `M`, whose columns
/// come from forces on one sphere at a time.
///
/// The bars are upper bounds: `dR = -R dM R`, with all terms added up.
fn axial(case: &Collinear, size: f64) -> Result<Row> {
    let n = case.positions.len();
    let [mut mobility, mut uncorrected, mut bars] = [(); 3].map(|()| DMatrix::zeros(n, n));
    let mut cost = Cost::default();
    for pulled in 0..n {
        let mut text = in_ball(case.container, &by_elements(size));
        for (k, (&position, &radius)) in case.positions.iter().zip(case.radii).enumerate() {
            let force = Vector3::x() * f64::from(u8::from(k == pulled));
            let name = format!("s{k}");
            text = text.sphere(name, radius, [position, 0.0, 0.0]);
            text = text.key("force", force.as_slice());
        }
        let solution = solve(&text.parse()?)?;
        let before = solution.uncorrected();
        for row in 0..n {
            mobility[(row, pulled)] = solution.bodies[row].velocity.x;
            uncorrected[(row, pulled)] = before.bodies[row].velocity.x;
            bars[(row, pulled)] = solution.error_estimate.total();
        }
        cost.add(&Cost::new(&solution));
    }
    let inverse = |mobility: DMatrix<f64>| {
        let inverse = mobility.try_inverse();
        inverse.context("the mobility matrix is singular")
    };
    let found = inverse(mobility)?;
    let removed = inverse(uncorrected)? - &found;
    let bars = found.abs() * bars * found.abs();
    let exact = symmetric(case.resistance, n);
    let (i, j) = (&found - &exact).icamax_full();
    let name = format!("{}: R{}{}, h {size}", case.name, i + 1, j + 1);
    let values = [exact[(i, j)], found[(i, j)]];
    let tolerance = (axial_tolerance(case, size)?, Basis::Interpolation);
    let row = Row::scaled("D", name, values, exact.amax(), tolerance, cost);
    Ok(row.with(Estimated {
        removed: Some(removed[(i, j)]),
        bar: bars[(i, j)],
    }))
}

/// Largest tolerance over the spheres, each taken at the centre of a ball that touches the wall at
/// its nearest point.
///
/// Errors of a resistance matrix are a scalar product, so those of off-diagonal entries are not
/// larger than those of diagonal entries (Cauchy & Schwarz).
fn axial_tolerance(case: &Collinear, size: f64) -> Result<f64> {
    let mut worst = 0.0_f64;
    for (position, radius) in case.positions.iter().zip(case.radii) {
        let to_wall = case.container - position.abs();
        worst = worst.max(expected::sphere(size / radius, radius / to_wall)?.drag);
    }
    Ok(worst)
}

/// Symmetric matrix from the rows of its upper triangle.
pub fn symmetric(upper: &[f64], n: usize) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(n, n);
    let places = (0..n).flat_map(|i| (i..n).map(move |j| (i, j)));
    for ((i, j), &value) in places.zip(upper) {
        matrix[(i, j)] = value;
        matrix[(j, i)] = value;
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::super::row::assert_corrected;
    use super::*;

    #[test]
    fn drag_and_torque_are_corrected_and_within_their_bars() {
        for row in drag_and_torque(0.25, 0.4).expect("it is solved") {
            assert_corrected(&row);
        }
    }

    fn check_pair(distance: f64) {
        let exact = OPPOSITE_MOTION.iter().find(|(own, _)| *own == distance);
        let &(_, exact) = exact.expect("the distance is tabulated");
        assert_corrected(&opposite(distance, exact, 0.5).expect("it is solved"));
    }

    #[test]
    fn bars_hold_in_a_gap_of_half_a_radius() {
        check_pair(2.5);
    }

    #[test]
    #[ignore = "slow: 5 s"]
    fn bars_hold_in_a_gap_of_a_twentieth_radius() {
        check_pair(2.05);
    }
}
