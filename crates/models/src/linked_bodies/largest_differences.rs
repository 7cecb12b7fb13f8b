//! Differences between solutions for linked bodies, by which errors are estimated.

use nalgebra::{DVector, Vector3};
use rigid::ExternalLoad;

use super::SomeLinkages;
use super::solutions::MobilitySolution;

/// Largest differences between two solutions, or sums of them, in scaled units.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LargestDifferences {
    pub velocity: f64,
    pub angular_velocity: f64,
    pub force: f64,
    pub torque: f64,
    pub power: f64,
    /// Of the power of the bodies of one linkage, relative to the sum of the sizes of its parts.
    pub linkage_power: f64,
    /// Of the mean flow of a periodic box.
    pub mean_flow: f64,
    /// Of the sum of all forces, which belongs to the mean pressure gradient.
    pub total_force: f64,
}

impl LargestDifferences {
    /// Adds `factor` times other differences.
    pub fn add(&mut self, factor: f64, other: &Self) {
        let mut other = *other;
        for (sum, term) in self.numbers().into_iter().zip(other.numbers()) {
            *sum += factor * *term;
        }
    }

    /// The larger of each of two.
    pub fn raise(&mut self, other: &Self) {
        let mut other = *other;
        for (most, found) in self.numbers().into_iter().zip(other.numbers()) {
            *most = most.max(*found);
        }
    }

    /// The same number for all.
    pub fn of_all(number: f64) -> Self {
        let mut all = Self::default();
        all.numbers().into_iter().for_each(|own| *own = number);
        all
    }

    /// Products of corresponding numbers.
    pub fn times(mut self, factors: &Self) -> Self {
        let mut factors = *factors;
        for (own, factor) in self.numbers().into_iter().zip(factors.numbers()) {
            *own *= *factor;
        }
        self
    }

    /// Quotients of corresponding numbers, at most `largest`; zero over zero.
    pub fn over(mut self, others: &Self, largest: f64) -> Self {
        let mut others = *others;
        for (own, other) in self.numbers().into_iter().zip(others.numbers()) {
            *own = if *other > 0.0 {
                (*own / *other).min(largest)
            } else {
                0.0
            };
        }
        self
    }

    fn numbers(&mut self) -> [&mut f64; 8] {
        [
            &mut self.velocity,
            &mut self.angular_velocity,
            &mut self.force,
            &mut self.torque,
            &mut self.power,
            &mut self.linkage_power,
            &mut self.mean_flow,
            &mut self.total_force,
        ]
    }
}

impl SomeLinkages<'_> {
    /// The linkage whose velocities differ most between two solutions.
    pub fn farthest_change(&self, one: &MobilitySolution, other: &MobilitySolution) -> usize {
        largest_of(&self.velocities, |k| {
            one.generalised[k] - other.generalised[k]
        })
    }

    /// The linkage with the largest velocities.
    pub fn fastest(&self, solution: &MobilitySolution) -> usize {
        largest_of(&self.velocities, |k| solution.generalised[k])
    }

    /// The linkage with the largest forces on the fluid.
    pub fn strongest(&self, solution: &MobilitySolution) -> usize {
        let force = |sphere: usize| solution.forces.fixed_rows::<3>(6 * sphere).norm();
        largest_of(&self.surfaces, force)
    }

    /// Power of the bodies, their deformation and their slip on the fluid.
    pub fn power(&self, solution: &MobilitySolution) -> f64 {
        let velocities = solution.generalised.select_rows(&self.surface_velocities);
        let amplitudes = solution.amplitudes.iter();
        let of_deformation: f64 = amplitudes.map(|(rate, drive)| rate * drive).sum();
        solution.forces.dot(&velocities) + solution.slip_power + of_deformation
    }

    /// Largest difference of the power of the bodies of a linkage, relative to the sum of the sizes
    /// of the powers of forces and torques on its bodies; of all together if bodies deform, because
    /// the powers of amplitudes are not known by linkage.
    fn linkage_power_difference(&self, one: &MobilitySolution, other: &MobilitySolution) -> f64 {
        let linkages = self.surfaces.iter().map(|spheres| {
            let parts = |solution| {
                spheres
                    .iter()
                    .flat_map(move |&k| self.powers_of(solution, k))
            };
            let difference: f64 = parts(one).zip(parts(other)).map(|(a, b)| a - b).sum();
            let size: f64 = parts(one).map(f64::abs).sum();
            (difference.abs(), size)
        });
        let ratio = |(difference, size): (f64, f64)| match size > 0.0 {
            true => difference / size,
            false => 0.0,
        };
        if one.amplitudes.is_empty() {
            return linkages.map(ratio).fold(0.0, f64::max);
        }
        let amplitudes = one.amplitudes.iter().zip(&other.amplitudes);
        let amplitudes = amplitudes.map(|((rate, drive), (other_rate, other_drive))| {
            let power = rate * drive;
            ((power - other_rate * other_drive).abs(), power.abs())
        });
        let all = linkages.chain(amplitudes);
        ratio(all.fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1)))
    }

    /// Sum of the sizes of the powers of forces and torques on all bodies.
    pub fn size_of_powers(&self, solution: &MobilitySolution) -> f64 {
        let spheres = 0..self.surface_velocities.len() / 6;
        let powers = spheres.flat_map(|sphere| self.powers_of(solution, sphere));
        powers.map(f64::abs).sum()
    }

    /// Powers of the force and of the torque of a sphere on the fluid.
    fn powers_of(&self, solution: &MobilitySolution, sphere: usize) -> [f64; 2] {
        [0, 3].map(|part| {
            let rows = 6 * sphere + part..6 * sphere + part + 3;
            let velocity = |row: usize| solution.generalised[self.surface_velocities[row]];
            rows.map(|row| solution.forces[row] * velocity(row)).sum()
        })
    }

    /// Largest differences between the velocities, and between the angular velocities, of a body
    /// with a surface in two solutions, each times the factor of its body.
    pub fn largest_weighted(
        &self,
        (one, other): (&MobilitySolution, &MobilitySolution),
        factors: &[f64],
    ) -> [f64; 2] {
        [0, 3].map(|part| {
            let rows = self.surface_velocities.iter().skip(part).step_by(6);
            let difference =
                |&k| (vector(&one.generalised, k) - vector(&other.generalised, k)).norm();
            let weighted = rows
                .map(difference)
                .zip(factors)
                .map(|(d, factor)| d * factor);
            weighted.fold(0.0, f64::max)
        })
    }

    /// Largest differences between the motions and loads of a body in two solutions, and that of
    /// the power.
    pub fn largest_differences(
        &self,
        one: &MobilitySolution,
        other: &MobilitySolution,
    ) -> LargestDifferences {
        type Part = fn(&MobilitySolution) -> &DVector<f64>;
        let difference = |of: Part, rows: &mut dyn Iterator<Item = usize>| {
            let norms = rows.map(|k| (vector(of(one), k) - vector(of(other), k)).norm());
            norms.fold(0.0, f64::max)
        };
        let velocities: Part = |solution| &solution.generalised;
        let forces: Part = |solution| &solution.forces;
        // Six rows per body with a surface, of which the last three are its angular velocity.
        let spins = self.surface_velocities.iter().copied().skip(3).step_by(6);
        let loads = one.forces.len();
        let of_holding = |part: fn(&ExternalLoad) -> &Vector3<f64>| {
            let pairs = one.holding.iter().zip(&other.holding);
            let norms = pairs.map(|((_, a), (_, b))| (part(a) - part(b)).norm());
            norms.fold(0.0, f64::max)
        };
        LargestDifferences {
            velocity: difference(velocities, &mut self.bodies.iter().copied()),
            angular_velocity: difference(velocities, &mut { spins }),
            force: difference(forces, &mut (0..loads).step_by(6))
                .max(of_holding(|load| &load.force)),
            torque: difference(forces, &mut (3..loads).step_by(6))
                .max(of_holding(|load| &load.torque)),
            power: (self.power(one) - self.power(other)).abs(),
            linkage_power: self.linkage_power_difference(one, other),
            mean_flow: (one.mean_flow - other.mean_flow).norm(),
            total_force: (one.total_force() - other.total_force()).norm(),
        }
    }
}

/// Three successive entries.
fn vector(list: &DVector<f64>, first: usize) -> Vector3<f64> {
    list.fixed_rows::<3>(first).into_owned()
}

/// Number of the first group whose entries have the largest sum of squares.
fn largest_of(groups: &[Vec<usize>], entry: impl Fn(usize) -> f64) -> usize {
    let squares = groups
        .iter()
        .map(|group| group.iter().map(|&k| entry(k).powi(2)).sum::<f64>());
    let largest = squares.enumerate().fold(
        (0, -1.0),
        |most, found| {
            if found.1 > most.1 { found } else { most }
        },
    );
    largest.0
}
