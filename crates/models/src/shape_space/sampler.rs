//! Solutions of a model at the points of nested grids.

use nalgebra::{UnitQuaternion, Vector3};
use rayon::prelude::*;
use rigid::State;
use scene::Scene;
use stokes::{Dofs, SolverReport};

use super::chebyshev::{chebyshev_node, indices};
use super::placement::Placement;
use super::record::{Layout, Record, numbers};
use super::solved_shapes::{Bars, SolvedShapes, TablePart};
use crate::error::ModelError;
use crate::hydrodynamics::Hydrodynamics;
use crate::query::{Configuration, Query};

/// Highest degree in a variable; spheres with gaps of a hundredth of a radius need more.
pub const MAX_DEGREE: usize = 64;

/// Number of shapes that are solved in parallel between two calls of the observer.
const BATCH: usize = 64;

/// Number of successive shapes that one copy of the model solves.
const CHUNK: usize = 4;

/// Motion of the swimmer, relative to the longest joint or in radians, that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// Samples a model at grid points, each at most once.
pub struct Sampler<'a> {
    scene: &'a Scene,
    placement: &'a Placement<'a>,
    ranges: &'a [(f64, f64)],
    /// Joints whose value varies.
    variables: &'a [usize],
    model: &'a mut dyn Hydrodynamics,
    /// What was solved so far.
    pub solved: SolvedShapes,
    /// What is solved here.
    part: TablePart,
}

/// The solutions of one shape.
struct Sample {
    numbers: Vec<f64>,
    mesh_errors: bool,
    bars: Bars,
    last: Option<(Dofs, SolverReport)>,
}

impl<'a> Sampler<'a> {
    /// A sampler of a model; `ranges` has one entry per joint.
    ///
    /// # Errors
    /// Shapes `solved` that do not fit the scene.
    pub fn new(
        scene: &'a Scene,
        model: &'a mut dyn Hydrodynamics,
        placement: &'a Placement<'a>,
        ranges: &'a [(f64, f64)],
        variables: &'a [usize],
        (solved, part): (SolvedShapes, TablePart),
    ) -> Result<Self, ModelError> {
        let sampler = Self {
            scene,
            placement,
            ranges,
            variables,
            model,
            solved,
            part,
        };
        let width = variables.len() * sampler.layout().numbers();
        let is_right =
            |values: &Vec<f64>| values.len() == width && values.iter().all(|x| x.is_finite());
        if !sampler.solved.numbers.values().all(is_right) {
            return Err(ModelError::ShapeSpace {
                problem: "the shapes that were solved before are not of this scene; delete them"
                    .to_owned(),
            });
        }
        if !sampler.solved.is_empty() {
            sampler.model.restore(&sampler.solved.history)?;
        }
        Ok(sampler)
    }

    /// What the records contain.
    pub fn layout(&self) -> Layout {
        Layout {
            bodies: self.scene.bodies().len(),
            joints: self.ranges.len(),
            deforms: self.scene.deforms(),
            mesh_errors: self.solved.mesh_errors,
        }
    }

    /// Numbers of the solutions at all points of a grid: one record per variable, for a unit rate
    /// of it.
    ///
    /// `degrees` has one entry per variable. Models whose solutions do not depend on earlier ones
    /// are solved in parallel.
    ///
    /// # Errors
    /// Those of the model and of `observe`; [`ModelError::NoSolution`] for a list of another
    /// length, or with other numbers of bodies and joints; [`ModelError::MissingShapes`] if the
    /// solved part does not complete the grid.
    pub fn grid(
        &mut self,
        degrees: &[usize],
        observe: &mut dyn FnMut(&SolvedShapes) -> Result<(), ModelError>,
    ) -> Result<Vec<f64>, ModelError> {
        let own: Vec<(usize, Vec<f64>)> = (indices(degrees).enumerate())
            .filter(|(position, _)| self.part.contains(*position))
            .map(|(_, index)| (key(degrees, &index), self.shape(degrees, &index)))
            .filter(|(key, _)| !self.solved.numbers.contains_key(key))
            .collect();
        self.solved.wanted = self.solved.len() + own.len();
        for batch in own.chunks(BATCH) {
            // Copies are only worth their memory if there are several chunks.
            let copies: Option<Vec<_>> = match batch.len() > CHUNK {
                true => (batch.chunks(CHUNK))
                    .map(|chunk| Some((self.model.duplicate()?, chunk)))
                    .collect(),
                false => None,
            };
            let Some(copies) = copies else {
                for (key, shape) in batch {
                    let state = self.placement.state(shape)?;
                    let sample = sample(self.model, &state, shape, self.variables)?;
                    self.insert(*key, sample)?;
                    // The next shape starts from the history alone, as after an interruption.
                    self.solved.history = self.model.history()?;
                    self.model.restore(&self.solved.history)?;
                    observe(&self.solved)?;
                }
                continue;
            };
            let (placement, variables) = (self.placement, self.variables);
            let samples: Vec<(usize, Result<Sample, ModelError>)> = copies
                .into_par_iter()
                .flat_map_iter(|(mut model, chunk)| {
                    let solve = move |(key, shape): &(usize, Vec<f64>)| {
                        let found = (placement.state(shape))
                            .and_then(|state| sample(model.as_mut(), &state, shape, variables));
                        (*key, found)
                    };
                    chunk.iter().map(solve).collect::<Vec<_>>()
                })
                .collect();
            for (key, sample) in samples {
                self.insert(key, sample?)?;
            }
            observe(&self.solved)?;
        }
        let known = |index: &Vec<usize>| self.solved.numbers.contains_key(&key(degrees, index));
        let missing = indices(degrees).filter(|index| !known(index)).count();
        if missing > 0 {
            return Err(ModelError::MissingShapes {
                missing,
                points: degrees.iter().map(|n| n + 1).collect(),
            });
        }
        Ok(indices(degrees)
            .flat_map(|index| self.solved.numbers[&key(degrees, &index)].iter().copied())
            .collect())
    }

    /// Largest change of the velocities for a unit rate when the swimmer moves in its container.
    ///
    /// Evaluated at the corners of the box, for displacements and rotations in both directions of
    /// each axis. Their size is that of the motion while every joint passes its range once.
    ///
    /// # Errors
    /// Those of the model, such as a swimmer that moves into the wall.
    pub fn position_error(&mut self, degrees: &[usize]) -> Result<f64, ModelError> {
        let longest = longest_arm(self.scene, self.ranges);
        let reach = self.reach();
        let corners = indices(&vec![1; degrees.len()]).map(|corner| {
            let ends = corner.iter().zip(degrees);
            ends.map(|(end, degree)| end * degree).collect::<Vec<_>>()
        });
        let mut largest = 0.0_f64;
        for index in corners {
            let shape = self.shape(degrees, &index);
            let state = self.placement.state(&shape)?;
            let known = self.solved.numbers[&key(degrees, &index)].clone();
            for component in 0..6 {
                let unit = if component < 3 { longest } else { 1.0 };
                if reach[component] <= ROUNDING * unit {
                    continue;
                }
                for sign in [1.0, -1.0] {
                    let mut motion = [Vector3::zeros(); 2];
                    motion[component / 3][component % 3] = sign * reach[component];
                    let rotation = UnitQuaternion::from_scaled_axis(motion[1]);
                    let moved = self.placement.moved(&state, &motion[0], &rotation);
                    let sample = sample(self.model, &moved, &shape, self.variables)?;
                    self.check(&sample)?;
                    let turned = |record: Record| {
                        let frame = record.response.motion.frames[0];
                        let back = rotation.inverse();
                        (back * frame.linear, back * frame.angular)
                    };
                    let width = self.layout().numbers();
                    for (a, b) in sample.numbers.chunks(width).zip(known.chunks(width)) {
                        let there = turned(Record::new(a, self.layout()));
                        let frame = Record::new(b, self.layout()).response.motion.frames[0];
                        largest = largest
                            .max((there.0 - frame.linear).norm())
                            .max(longest * (there.1 - frame.angular).norm());
                    }
                }
            }
        }
        Ok(largest)
    }

    /// Upper bounds of the displacement of the mean of the centres and of the rotation of the
    /// frame, while every joint passes its range once.
    fn reach(&self) -> [f64; 6] {
        let layout = self.layout();
        let mut reach = [0.0; 6];
        for (number, &joint) in self.variables.iter().enumerate() {
            let width = self.ranges[joint].1 - self.ranges[joint].0;
            let mut fastest = [0.0_f64; 6];
            for values in self.solved.numbers.values() {
                let numbers = &values[number * layout.numbers()..][..layout.numbers()];
                let record = Record::new(numbers, layout).response;
                let counted = (record.bodies.iter().enumerate())
                    .filter(|(body, _)| self.placement.counts(*body))
                    .map(|(_, body)| body.velocity);
                let count = counted.clone().count().max(1) as f64;
                let mean = counted.sum::<Vector3<f64>>() / count;
                let spin = record.motion.frames[0].angular;
                for (fastest, x) in fastest.iter_mut().zip(mean.iter().chain(spin.iter())) {
                    *fastest = fastest.max(x.abs());
                }
            }
            for (reach, speed) in reach.iter_mut().zip(fastest) {
                *reach += width * speed;
            }
        }
        reach
    }

    /// Values of all joints at a grid point.
    fn shape(&self, degrees: &[usize], index: &[usize]) -> Vec<f64> {
        let mut shape: Vec<f64> = self.ranges.iter().map(|range| range.0).collect();
        for (variable, &joint) in self.variables.iter().enumerate() {
            shape[joint] = chebyshev_node(self.ranges[joint], degrees[variable], index[variable]);
        }
        shape
    }

    fn insert(&mut self, key: usize, sample: Sample) -> Result<(), ModelError> {
        if self.solved.is_empty() {
            self.solved.mesh_errors = sample.mesh_errors;
        }
        self.check(&sample)?;
        self.solved.bars = self.solved.bars.with(&sample.bars);
        self.solved.last = sample.last;
        self.solved.numbers.insert(key, sample.numbers);
        Ok(())
    }

    fn check(&self, sample: &Sample) -> Result<(), ModelError> {
        match sample.numbers.len() == self.variables.len() * self.layout().numbers() {
            true => Ok(()),
            false => Err(ModelError::NoSolution {
                model: self.model.name(),
            }),
        }
    }
}

/// Largest length of the joints in a box, at least the radius of a body.
pub fn longest_arm(scene: &Scene, ranges: &[(f64, f64)]) -> f64 {
    let arm =
        |(joint, range): (usize, &(f64, f64))| scene.articulation().arm_length(joint, range.1);
    let radii = scene.bodies().iter().map(|body| body.bounding_radius());
    let arms = ranges.iter().enumerate().map(arm);
    arms.chain(radii).fold(0.0, f64::max)
}

/// Number of a grid point in the finest grid.
fn key(degrees: &[usize], index: &[usize]) -> usize {
    let finest = index.iter().zip(degrees).map(|(i, n)| i * (MAX_DEGREE / n));
    finest.rev().fold(0, |key, i| key * (MAX_DEGREE + 1) + i)
}

/// Solves a model for a unit rate of each variable.
fn sample(
    model: &mut dyn Hydrodynamics,
    state: &State,
    shape: &[f64],
    variables: &[usize],
) -> Result<Sample, ModelError> {
    let unit_rate = |&joint: &usize| {
        let mut rates = vec![0.0; shape.len()];
        rates[joint] = 1.0;
        rates
    };
    let rates: Vec<Vec<f64>> = variables.iter().map(unit_rate).collect();
    let solutions = model.solve(&Query::new(Configuration::new(state, shape), &rates))?;
    if solutions.len() != rates.len() {
        return Err(ModelError::NoSolution {
            model: model.name(),
        });
    }
    let mut sample = Sample {
        numbers: Vec::new(),
        mesh_errors: (solutions.first()).is_some_and(|solution| solution.mesh_error.is_some()),
        bars: Bars::default(),
        last: None,
    };
    for solution in solutions {
        solution.check(model)?;
        sample.bars.include(&solution);
        sample.numbers.extend(numbers(&solution));
        sample.last = Some((solution.dofs, solution.solver));
    }
    Ok(sample)
}
