//! One box of shapes with the answers of a model.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, Vector3};
use rigid::{State, StateVelocity, Twist};

use super::chebyshev::{Interpolant, indices, node};
use crate::error::ModelError;
use crate::error_estimate::ErrorEstimate;
use crate::hydrodynamics::{Configuration, Hydrodynamics, Query};
use crate::solution::{BodySolution, InstantaneousSolution};
use scene::Scene;
use stokes::{Dofs, SolverReport};

/// The degree in each variable to begin with.
const FIRST_DEGREE: usize = 4;

/// The highest degree in a variable: spheres that come as close as a hundredth of a radius need more.
const MOST_DEGREE: usize = 64;

/// Tables of more points than this take longer than they save.
const MOST_POINTS: usize = 5000;

/// Answers of a model for a box of lengths of the links, for a free swimmer in the attitude of its start.
#[derive(Clone, Debug)]
pub struct ShapeSpace {
    start: State,
    /// For each link the least and the greatest length.
    ranges: Vec<(f64, f64)>,
    /// Links whose length varies in the box.
    variables: Vec<usize>,
    /// One block a link of `variables`: the answer for a unit rate of it.
    answers: Interpolant,
    bodies: usize,
    links: usize,
    dofs: Dofs,
    solver: SolverReport,
    points: usize,
    /// Error of velocities for a unit rate: of the interpolation, and the model's own.
    errors: (f64, f64),
}

impl ShapeSpace {
    /// Asks `model` at the Chebyshev points of a box until velocities and forces are interpolated to the relative error `tolerance`, or as well as
    /// the model's own jumps allow.
    ///
    /// Links whose range has no width are held. Cost: 5, 9, 17 ... points in each variable; at each of them the links that vary are asked for at once
    /// ([`Hydrodynamics::instants`]).
    ///
    /// # Errors
    /// [`ModelError::ShapeSpace`] for a scene whose motion does not depend on the shape alone, a box without a length that varies, and for tables
    /// that would be too large; what the model fails with.
    pub fn tabulate(
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
        ranges: &[(f64, f64)],
        tolerance: f64,
    ) -> Result<Self, ModelError> {
        Self::sample(scene, model, ranges, tolerance, true)
    }

    /// As [`ShapeSpace::tabulate`], with error estimates of the model or without.
    pub(super) fn sample(
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
        ranges: &[(f64, f64)],
        tolerance: f64,
        estimates: bool,
    ) -> Result<Self, ModelError> {
        let refuse = |problem: &str| {
            Err(ModelError::ShapeSpace {
                problem: problem.to_owned(),
            })
        };
        if !scene.is_free() {
            return refuse(
                "the motion depends on the shape alone only for one linkage in unbounded fluid without external forces",
            );
        }
        let links = scene.articulation().links().len();
        let sound = |r: &(f64, f64)| r.0.is_finite() && r.1.is_finite() && 0.0 < r.0 && r.0 <= r.1;
        if ranges.len() != links || !ranges.iter().all(sound) {
            return refuse("every link needs a range of positive lengths, the smaller one first");
        }
        let variables: Vec<usize> = (0..links).filter(|&k| ranges[k].0 < ranges[k].1).collect();
        if variables.is_empty() {
            return refuse("no length varies");
        }
        let mut sampler = Sampler {
            start: scene.initial_state(),
            held: ranges.iter().map(|r| r.0).collect(),
            variables: &variables,
            model,
            estimates,
            known: BTreeMap::new(),
            own_error: 0.0,
            last: None,
        };
        let box_ranges: Vec<(f64, f64)> = variables.iter().map(|&k| ranges[k]).collect();
        let mut degrees = vec![FIRST_DEGREE; variables.len()];
        let mut before = f64::INFINITY;
        loop {
            let points: usize = degrees.iter().map(|n| n + 1).product();
            if points > MOST_POINTS || degrees.iter().any(|&n| n > MOST_DEGREE) {
                return refuse("the table would be too large; take a smaller box");
            }
            let mut values = Vec::new();
            for index in indices(&degrees) {
                values.extend_from_slice(sampler.at(&box_ranges, &degrees, &index)?);
            }
            let bodies = scene.bodies().len();
            let (weights, speed) = weights(&values, variables.len(), (bodies, links), ranges);
            let width = weights.len();
            let answers = Interpolant::new(box_ranges.clone(), degrees.clone(), width, values);
            let tails = answers.tails(&weights);
            let tail: f64 = tails.iter().sum();
            // the model's own error jumps from shape to shape, with the order of its expansions; no table gets below it
            let is_noise = tail > 0.5 * before
                && tail * speed <= NOISE * sampler.own_error.max(tolerance * speed);
            if tail <= tolerance || is_noise {
                let (dofs, solver) = sampler.last.clone().unwrap_or_default();
                return Ok(Self {
                    start: sampler.start,
                    ranges: ranges.to_vec(),
                    answers,
                    bodies,
                    links,
                    dofs,
                    solver: SolverReport {
                        solver: "table".to_owned(),
                        ..solver
                    },
                    points,
                    errors: (tail * speed, sampler.own_error),
                    variables,
                });
            }
            before = tail;
            let share = 0.5 * tolerance / tails.len() as f64;
            for (degree, tail) in degrees.iter_mut().zip(&tails) {
                if *tail > share {
                    *degree *= 2;
                }
            }
        }
    }

    /// Whether the lengths are in the box and only lengths that vary in it change.
    pub fn contains(&self, lengths: &[f64], rates: &[f64]) -> bool {
        covers(&self.ranges, lengths, rates)
    }

    /// Number of shapes at which the model was asked.
    pub fn points(&self) -> usize {
        self.points
    }

    /// Estimated error of velocities for a unit rate of one length: by the interpolation, and by the model.
    pub fn errors(&self) -> (f64, f64) {
        self.errors
    }

    /// The connection: twist of the frame for a unit rate of each length that varies, in the attitude of the start.
    ///
    /// Links that vary are counted in the order of the scene. `lengths` should be in the box. Cost: microseconds.
    pub fn connection(&self, lengths: &[f64]) -> Vec<Twist> {
        let rows = self.rows(lengths);
        rows.into_iter()
            .map(|row| Answer::from(row, self).motion.frames[0])
            .collect()
    }

    /// The dissipation metric $G$: the power of the swimmer on the fluid is $\dot s \cdot G\, \dot s$.
    ///
    /// Rows and columns are the links that vary. Symmetric to the errors of the table. Cost: microseconds.
    pub fn metric(&self, lengths: &[f64]) -> DMatrix<f64> {
        let answers: Vec<Answer> = self
            .rows(lengths)
            .into_iter()
            .map(|row| Answer::from(row, self))
            .collect();
        let n = answers.len();
        DMatrix::from_fn(n, n, |i, j| {
            answers[i]
                .bodies
                .iter()
                .zip(&answers[j].bodies)
                .map(|(a, b)| a.force.dot(&b.velocity) + a.torque.dot(&b.angular_velocity))
                .sum()
        })
    }

    /// The answer to a configuration in the box. Cost: microseconds.
    pub fn solution(
        &self,
        configuration: Configuration<'_>,
        rates: &[f64],
    ) -> InstantaneousSolution {
        let turn = configuration.state.frames[0].rotation * self.start.frames[0].rotation.inverse();
        let rates: Vec<f64> = self.variables.iter().map(|&k| rates[k]).collect();
        let rows = self.rows(configuration.lengths);
        let width = rows.first().map_or(0, Vec::len);
        let mut sum = vec![0.0; width];
        for (row, rate) in rows.iter().zip(&rates) {
            for (sum, value) in sum.iter_mut().zip(row) {
                *sum += rate * value;
            }
        }
        for vector in sum.chunks_exact_mut(3) {
            let turned = turn * Vector3::new(vector[0], vector[1], vector[2]);
            vector.copy_from_slice(turned.as_slice());
        }
        let answer = Answer::from(sum, self);
        let speed: f64 = rates.iter().map(|r| r.abs()).sum();
        InstantaneousSolution {
            dofs: self.dofs,
            solver: self.solver.clone(),
            error_estimate: ErrorEstimate {
                model: Some(speed * (self.errors.0 + self.errors.1)),
                ..ErrorEstimate::default()
            },
            ..InstantaneousSolution::new(answer.bodies, answer.link_forces, answer.motion)
        }
    }

    /// For each link that varies, the numbers of the answer for a unit rate.
    fn rows(&self, lengths: &[f64]) -> Vec<Vec<f64>> {
        let point: Vec<f64> = self.variables.iter().map(|&k| lengths[k]).collect();
        let values = self.answers.evaluate(&point);
        values
            .chunks(values.len() / self.variables.len())
            .map(<[f64]>::to_vec)
            .collect()
    }
}

/// Interpolation errors up to this times the model's own are taken for its jumps when more points do not lower them.
const NOISE: f64 = 10.0;

/// An answer as vectors, in the order in which they are tabulated.
struct Answer {
    motion: StateVelocity,
    bodies: Vec<BodySolution>,
    link_forces: Vec<Vector3<f64>>,
}

impl Answer {
    fn from(numbers: Vec<f64>, space: &ShapeSpace) -> Self {
        let mut vectors = numbers
            .chunks_exact(3)
            .map(|v| Vector3::new(v[0], v[1], v[2]));
        let mut next = || vectors.next().unwrap_or_default();
        let frame = Twist {
            linear: next(),
            angular: next(),
        };
        let spins = (0..space.bodies).map(|_| next()).collect();
        let bodies = (0..space.bodies)
            .map(|_| BodySolution {
                velocity: next(),
                angular_velocity: next(),
                force: next(),
                torque: next(),
            })
            .collect();
        Self {
            motion: StateVelocity {
                frames: vec![frame],
                spins,
            },
            bodies,
            link_forces: (0..space.links).map(|_| next()).collect(),
        }
    }
}

/// The vectors of an answer as [`Answer::from`] reads them.
fn numbers(instant: &InstantaneousSolution) -> Vec<f64> {
    let frame = &instant.motion.frames[0];
    let mut vectors = vec![frame.linear, frame.angular];
    vectors.extend(&instant.motion.spins);
    for body in &instant.bodies {
        vectors.extend([
            body.velocity,
            body.angular_velocity,
            body.force,
            body.torque,
        ]);
    }
    vectors.extend(&instant.link_forces);
    vectors.iter().flatten().copied().collect()
}

/// What makes each number of all answers relative to the fastest velocity or the largest force, and that velocity.
///
/// Angular velocities count at the distance of the longest link, torques on an arm as long.
fn weights(
    values: &[f64],
    blocks: usize,
    (bodies, links): (usize, usize),
    ranges: &[(f64, f64)],
) -> (Vec<f64>, f64) {
    #[derive(Clone, Copy, PartialEq)]
    enum Kind {
        Velocity,
        Angular,
        Force,
        Torque,
    }
    use Kind::{Angular, Force, Torque, Velocity};
    let mut kinds = vec![Velocity, Angular];
    kinds.extend(vec![Angular; bodies]);
    kinds.extend([Velocity, Angular, Force, Torque].repeat(bodies));
    kinds.extend(vec![Force; links]);
    let kinds: Vec<Kind> = kinds.into_iter().flat_map(|kind| [kind; 3]).collect();
    let kinds = kinds.repeat(blocks);
    let largest = |wanted: Kind| {
        values
            .chunks(kinds.len())
            .flat_map(|point| point.iter().zip(&kinds))
            .filter(|(_, kind)| **kind == wanted)
            .fold(f64::MIN_POSITIVE, |m, (x, _)| m.max(x.abs()))
    };
    let (speed, force) = (largest(Velocity), largest(Force));
    let reach = ranges.iter().fold(0.0_f64, |m, r| m.max(r.1));
    let weight = |kind: &Kind| match kind {
        Velocity => 1.0 / speed,
        Angular => reach / speed,
        Force => 1.0 / force,
        Torque => 1.0 / (force * reach),
    };
    (kinds.iter().map(weight).collect(), speed)
}

/// Asks the model at points of the grid, once each.
struct Sampler<'a> {
    start: State,
    held: Vec<f64>,
    variables: &'a [usize],
    model: &'a mut dyn Hydrodynamics,
    estimates: bool,
    /// Answers by their place on the finest grid.
    known: BTreeMap<Vec<usize>, Vec<f64>>,
    own_error: f64,
    last: Option<(Dofs, SolverReport)>,
}

impl Sampler<'_> {
    fn at(
        &mut self,
        ranges: &[(f64, f64)],
        degrees: &[usize],
        index: &[usize],
    ) -> Result<&[f64], ModelError> {
        let place: Vec<usize> = index
            .iter()
            .zip(degrees)
            .map(|(i, n)| i * (MOST_DEGREE / n))
            .collect();
        if !self.known.contains_key(&place) {
            let mut lengths = self.held.clone();
            for (a, &link) in self.variables.iter().enumerate() {
                lengths[link] = node(ranges[a], degrees[a], index[a]);
            }
            let unit_rate = |&link: &usize| {
                let mut rates = vec![0.0; lengths.len()];
                rates[link] = 1.0;
                rates
            };
            let rates: Vec<Vec<f64>> = self.variables.iter().map(unit_rate).collect();
            let configuration = Configuration {
                state: &self.start,
                lengths: &lengths,
            };
            let query = Query::new(configuration, &rates).with_estimates(self.estimates);
            let mut values = Vec::new();
            for instant in self.model.solve(&query)? {
                instant.check_finite(self.model.name())?;
                self.own_error = self.own_error.max(instant.error_estimate.total());
                values.extend(numbers(&instant));
                self.last = Some((instant.dofs, instant.solver));
            }
            self.known.insert(place.clone(), values);
        }
        Ok(self.known.get(&place).map_or(&[], Vec::as_slice))
    }
}

/// Whether lengths lie in a box of `ranges`, and change along its extended sides only.
pub(super) fn covers(ranges: &[(f64, f64)], lengths: &[f64], rates: &[f64]) -> bool {
    let inside = |((range, length), rate): ((&(f64, f64), &f64), &f64)| {
        range.0 <= *length && *length <= range.1 && (range.0 < range.1 || *rate == 0.0)
    };
    lengths.len() == ranges.len()
        && rates.len() == ranges.len()
        && ranges.iter().zip(lengths).zip(rates).all(inside)
}
