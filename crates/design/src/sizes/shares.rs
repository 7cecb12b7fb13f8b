//! Sizes of a swimmer as shares of what is kept: the volume of its spheres, the length of its arms.

use nalgebra::{DMatrix, DVector};
use rigid::JointKind;
use scene::Scene;

use super::polytope::Polytope;
use crate::error::DesignError;
use crate::limits::{joint_ranges, smallest_gap, sphere_radius};
use crate::sensitivities::{Parameter, parameter::Kind, parameters, with_values};

/// The radii and arm lengths that vary, with their limits.
///
/// A point is the list of the shares: of every sphere in the sum of the volumes, then of every arm
/// in the sum of the lengths. The shares of each group sum to one.
#[derive(Clone, Debug)]
pub struct SizeSpace {
    /// Radii of spheres, then lengths of arms.
    pub parameters: Vec<Parameter>,
    /// Number of radii among the parameters.
    radii: usize,
    /// Sum of the cubes of the radii that vary.
    cubes: f64,
    /// Sum of the arm lengths that vary.
    length: f64,
    /// Smallest and largest value of each parameter.
    limits: Vec<(f64, f64)>,
    gaps: Vec<Gap>,
}

/// The smallest gap along the gait of two spheres that a driven slide connects.
#[derive(Clone, Debug)]
struct Gap {
    /// Numbers of the parameters: the arm, and the radii of both spheres.
    arm: Option<usize>,
    radii: [Option<usize>; 2],
    /// The gap with the sizes of the scene, above `optimise.gap`.
    excess: f64,
    names: String,
}

impl SizeSpace {
    /// The sizes that `optimise.radii` and `optimise.arms` of a scene let vary.
    ///
    /// # Errors
    /// [`DesignError::NotApplicable`] without both keys, for fewer than two spheres or arms, and if
    /// the sizes of the scene are not strictly inside the limits.
    pub fn from_scene(scene: &Scene) -> Result<Self, DesignError> {
        let refuse = |key, problem| Err(DesignError::not_applicable(scene, key, problem));
        let options = scene.optimise();
        if options.radii.is_none() && options.arms.is_none() {
            return refuse(
                "optimise",
                "no size may vary; give the limits of the radii, optimise.radii = [0.5, 2], or of \
                 the arm lengths, optimise.arms = [4, 20]"
                    .to_owned(),
            );
        }
        let ranges = joint_ranges(scene)?;
        let all = parameters(scene)?;
        let (mut chosen, mut limits): (Vec<Parameter>, Vec<(f64, f64)>) = (Vec::new(), Vec::new());
        let arms = "arms whose lengths the gait gives by phases or harmonics";
        for (key, words, group) in [
            ("optimise.radii", "spheres that move", options.radii),
            ("optimise.arms", arms, options.arms),
        ] {
            let Some([smallest, largest]) = group else {
                continue;
            };
            let before = chosen.len();
            for parameter in &all {
                // Arms keep their limits at every time of the gait.
                let limit = match parameter.kind {
                    Kind::Radius(_) if key == "optimise.radii" => (smallest, largest),
                    Kind::Length(joint) if key == "optimise.arms" => (
                        smallest + parameter.value - ranges[joint].0,
                        largest + parameter.value - ranges[joint].1,
                    ),
                    _ => continue,
                };
                if !(limit.0 < parameter.value && parameter.value < limit.1) {
                    let problem = format!(
                        "the {} must be strictly between {} and {}, so that all lengths along the \
                         gait are inside the limits",
                        parameter.name, limit.0, limit.1
                    );
                    return refuse(key, problem);
                }
                chosen.push(parameter.clone());
                limits.push(limit);
            }
            if chosen.len() < before + 2 {
                let problem = format!(
                    "their sum is kept, so that at least two {words} are required; remove the key"
                );
                return refuse(key, problem);
            }
        }
        let is_radius = |parameter: &&Parameter| matches!(parameter.kind, Kind::Radius(_));
        let radii = chosen.iter().filter(is_radius).count();
        let gaps = gaps(scene, &chosen, &ranges);
        if let Some(gap) = gaps.iter().find(|gap| gap.excess <= 0.0) {
            let wanted = smallest_gap(scene);
            let problem = format!(
                "{} come as close as {:.4} in the gait of the scene, and the gap must be larger \
                 than {wanted}; lower optimise.gap or lengthen the arm",
                gap.names,
                gap.excess + wanted
            );
            return refuse("optimise.gap", problem);
        }
        let values = |range: std::ops::Range<usize>| chosen[range].iter().map(|p| p.value);
        Ok(Self {
            radii,
            cubes: values(0..radii).map(|radius| radius.powi(3)).sum(),
            length: values(radii..chosen.len()).sum(),
            parameters: chosen,
            limits,
            gaps,
        })
    }

    /// The shares of the scene.
    pub fn start(&self) -> Vec<f64> {
        let values: Vec<f64> = self.parameters.iter().map(|p| p.value).collect();
        self.shares(&values)
    }

    /// The numbers of the parameters of each group whose shares sum to one.
    pub fn groups(&self) -> impl Iterator<Item = std::ops::Range<usize>> {
        [0..self.radii, self.radii..self.parameters.len()]
            .into_iter()
            .filter(|group| !group.is_empty())
    }

    fn share(&self, parameter: usize, value: f64) -> f64 {
        match parameter < self.radii {
            true => value.powi(3) / self.cubes,
            false => value / self.length,
        }
    }

    /// Values of the parameters.
    pub fn values(&self, shares: &[f64]) -> Vec<f64> {
        let values = shares.iter().enumerate();
        values
            .map(|(k, share)| match k < self.radii {
                true => (share * self.cubes).cbrt(),
                false => share * self.length,
            })
            .collect()
    }

    /// The shares with these values of the parameters.
    pub fn shares(&self, values: &[f64]) -> Vec<f64> {
        let values = values.iter().enumerate();
        values.map(|(k, value)| self.share(k, *value)).collect()
    }

    /// The shares with another value of a parameter, and the others of its group in their ratios.
    pub fn with_value(&self, shares: &[f64], parameter: usize, value: f64) -> Vec<f64> {
        let share = self.share(parameter, value);
        let factor = (1.0 - share) / (1.0 - shares[parameter]);
        let mut changed = shares.to_vec();
        let groups = self.groups().filter(|group| group.contains(&parameter));
        groups.flatten().for_each(|k| changed[k] *= factor);
        changed[parameter] = share;
        changed
    }

    /// Whether all sizes are within their limits.
    pub fn is_allowed(&self, shares: &[f64]) -> bool {
        let values = self.values(shares);
        let mut pairs = values.iter().zip(&self.limits);
        pairs.all(|(value, limit)| limit.0 <= *value && *value <= limit.1)
            && self.closed_gaps(shares, 0.0).is_empty()
    }

    /// Relative changes of the values for relative changes of the shares.
    pub fn elasticity(&self, parameter: usize) -> f64 {
        match parameter < self.radii {
            true => 1.0 / 3.0,
            false => 1.0,
        }
    }

    /// Smallest and largest value of each parameter.
    pub fn limits(&self) -> &[(f64, f64)] {
        &self.limits
    }

    /// The scene with other sizes.
    ///
    /// # Errors
    /// Sizes that the scene cannot have.
    pub fn scene(&self, scene: &Scene, shares: &[f64]) -> Result<Scene, DesignError> {
        let values = self.values(shares);
        let changes: Vec<_> = self.parameters.iter().zip(values).collect();
        with_values(scene, &changes)
    }

    /// Orthonormal relative changes of the shares that keep their sums, one per column.
    pub fn basis(&self, shares: &[f64]) -> DMatrix<f64> {
        let mut columns: Vec<DVector<f64>> = Vec::new();
        for group in self.groups() {
            let sum = DVector::from_fn(shares.len(), |k, _| match group.contains(&k) {
                true => shares[k],
                false => 0.0,
            });
            let mut known = vec![sum.normalize()];
            // Gram and Schmidt, twice for orthogonality to rounding; the last column would be zero.
            for k in group.start..group.end - 1 {
                let mut column = DVector::zeros(shares.len());
                column[k] = 1.0;
                for _ in 0..2 {
                    for other in &known {
                        column -= other.dot(&column) * other;
                    }
                }
                known.push(&column / column.norm());
            }
            columns.extend(known.split_off(1));
        }
        DMatrix::from_columns(&columns)
    }

    /// The shares after changes along the columns of a basis.
    pub fn moved(shares: &[f64], basis: &DMatrix<f64>, change: &DVector<f64>) -> Vec<f64> {
        let relative = basis * change;
        let pairs = shares.iter().zip(relative.iter());
        pairs.map(|(share, z)| share * (1.0 + z)).collect()
    }

    /// The limits as bounds of changes along a basis, where no share changes by more than the part
    /// `trust`.
    ///
    /// The limits of gaps are linear in the radii, and a radius is a concave function of its share,
    /// so that its tangent is an upper bound: changes inside the bounds keep the gaps.
    pub fn polytope(&self, shares: &[f64], basis: &DMatrix<f64>, trust: f64) -> Polytope {
        let values = self.values(shares);
        let mut polytope = Polytope::new(basis.ncols());
        let mut farthest = Vec::new();
        for (k, limit) in self.limits.iter().enumerate() {
            let relative = |value: f64| self.share(k, value) / shares[k] - 1.0;
            let lower = relative(limit.0).max(-trust);
            let upper = relative(limit.1).min(trust);
            polytope.push(basis.row(k).transpose(), lower, upper);
            farthest.push(upper.max(-lower));
        }
        for gap in &self.gaps {
            let (mut row, mut excess) = (DVector::zeros(basis.ncols()), gap.excess);
            // No change reaches the upper bound of a gap.
            let mut far = 0.0;
            let arm = gap.arm.map(|k| (k, 1.0));
            let radii = gap.radii.iter().flatten().map(|&k| (k, -1.0));
            for (k, sign) in arm.into_iter().chain(radii) {
                excess += sign * (values[k] - self.parameters[k].value);
                let slope = values[k] * self.elasticity(k);
                row += sign * slope * basis.row(k).transpose();
                far += 2.0 * slope * farthest[k];
            }
            polytope.push(row, -excess, far);
        }
        polytope
    }

    /// Names of the spheres whose gap is as small as allowed, relative to the largest value.
    pub fn closed_gaps(&self, shares: &[f64], near: f64) -> Vec<&str> {
        let values = self.values(shares);
        let change = |k: &Option<usize>| k.map_or(0.0, |k| values[k] - self.parameters[k].value);
        let excess =
            |gap: &Gap| gap.excess + change(&gap.arm) - gap.radii.iter().map(change).sum::<f64>();
        let scale = values.iter().fold(0.0_f64, |largest, v| largest.max(*v));
        (self.gaps.iter())
            .filter(|gap| excess(gap) < near * scale)
            .map(|gap| &gap.names[..])
            .collect()
    }
}

/// Gaps of spheres that driven slides connect, as functions of the parameters.
fn gaps(scene: &Scene, parameters: &[Parameter], ranges: &[(f64, f64)]) -> Vec<Gap> {
    let number = |kind: Kind| parameters.iter().position(|p| p.kind == kind);
    let wanted = smallest_gap(scene);
    let joints = scene.articulation().joints().iter().enumerate();
    joints
        .filter_map(|(k, joint)| {
            let ends = [joint.body, joint.to];
            let [a, b] = ends.map(|body| sphere_radius(scene, body));
            let radii = ends.map(|body| number(Kind::Radius(body)));
            let arm = number(Kind::Length(k));
            let varies = arm.is_some() || radii.iter().any(Option::is_some);
            (varies && joint.kind == JointKind::Slide).then_some(Gap {
                arm,
                radii,
                excess: ranges[k].0 - a? - b? - wanted,
                names: format!(
                    "\"{}\" and \"{}\"",
                    scene.bodies()[joint.body].name,
                    scene.bodies()[joint.to].name
                ),
            })
        })
        .collect()
}
