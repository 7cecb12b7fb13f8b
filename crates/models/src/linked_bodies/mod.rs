//! Velocities and forces of linked bodies, linkage by linkage.

mod largest_differences;
mod moving_linkage;
mod random_loads;
mod solutions;

use nalgebra::DVector;
use rayon::prelude::*;
use rigid::{Articulation, BodyKind, ExternalLoad, JointLoad, StateVelocity};

pub(crate) use self::largest_differences::LargestDifferences;
use self::moving_linkage::MovingLinkage;
pub(crate) use self::solutions::{IteratedSolution, MobilitySolution};
use crate::error::ModelError;
use crate::query::{Configuration, Query};
use crate::response::Response;
use crate::scaled_scene::{MeanFlowCondition, ScaledResponse, ScaledScene};

/// All linkages of a scene in one configuration, for one set of rates.
///
/// Linkages act on each other by the fluid alone: everything else is done for each by itself, which
/// costs `O(n)` for `n` linkages.
pub(crate) struct LinkedBodies<'a> {
    scaled: &'a ScaledScene,
    time: f64,
    linkages: Vec<MovingLinkage<'a>>,
    mean_flow: MeanFlowCondition,
}

/// Some linkages as if there were no others.
pub(crate) struct SomeLinkages<'a> {
    linkages: Vec<&'a MovingLinkage<'a>>,
    /// For each linkage the places of its velocities among all.
    velocities: Vec<Vec<usize>>,
    /// For each linkage the numbers of its bodies with surfaces among all.
    surfaces: Vec<Vec<usize>>,
    /// Place of the first velocity of each body.
    bodies: Vec<usize>,
    /// Places of the velocities of bodies with surfaces, six per body.
    surface_velocities: Vec<usize>,
    mean_flow: MeanFlowCondition,
}

impl<'a> LinkedBodies<'a> {
    /// The linkages of a scene for a query and one of its sets of rates.
    ///
    /// # Errors
    /// Values of joints for which a loop does not close; joints that contradict each other.
    pub fn new(scaled: &'a ScaledScene, query: &Query, rates: &[f64]) -> Result<Self, ModelError> {
        let loads = scaled.loads(query.configuration, query.inertia)?;
        let constraints = scaled.part_constraints(query, rates)?;
        let parts = scaled.parts.par_iter().zip(constraints);
        let linkages = parts.map(|(part, constraints)| {
            MovingLinkage::new(part, constraints?, part.of_bodies(&loads))
        });
        Ok(Self {
            scaled,
            time: query.configuration.time,
            linkages: linkages.collect::<Result<_, _>>()?,
            mean_flow: scaled.mean_flow(),
        })
    }

    /// The linkages at rest and without loads, but for a unit force on one passive joint, if there
    /// is one, by its place among these.
    ///
    /// # Errors
    /// Those of [`LinkedBodies::new`].
    pub fn at_rest(
        scaled: &'a ScaledScene,
        configuration: Configuration,
        unit_force: Option<usize>,
    ) -> Result<Self, ModelError> {
        let rates = [vec![0.0; scaled.set.joints().len()]];
        let query = Query::new(configuration, &rates);
        let parts = scaled.parts.iter();
        let linkages =
            parts
                .zip(scaled.part_constraints(&query, &rates[0])?)
                .map(|(part, constraints)| {
                    let mut constraints = constraints?;
                    // All else is at rest, also bodies whose velocities are given.
                    constraints.rates.fill(0.0);
                    constraints.joint_forces.fill(0.0);
                    let own = part
                        .passive_joints()
                        .iter()
                        .position(|&place| Some(place) == unit_force);
                    if let Some(own) = own
                        && let Some(joint) = part.set().passive_joints().nth(own)
                    {
                        constraints.joint_forces[own] = scaled.scale.joint_force(joint, 1.0);
                    }
                    let loads = vec![ExternalLoad::default(); part.bodies().len()];
                    MovingLinkage::new(part, constraints, loads)
                });
        Ok(Self {
            scaled,
            time: configuration.time,
            linkages: linkages.collect::<Result<_, _>>()?,
            mean_flow: MeanFlowCondition::default(),
        })
    }

    /// All linkages, in the numbering of the scene.
    pub fn all(&self) -> SomeLinkages<'_> {
        let set = &self.scaled.set;
        let mut numbers = vec![0; set.kinds().len()];
        for (number, body) in self.scaled.surfaced().enumerate() {
            numbers[body] = number;
        }
        let surfaces = self.linkages.iter().map(|one| {
            let bodies = surfaced(one.set()).map(|own| numbers[one.part.bodies()[own]]);
            bodies.collect()
        });
        let velocities = self
            .linkages
            .iter()
            .map(|one| one.part.velocities().to_vec());
        SomeLinkages {
            velocities: velocities.collect(),
            surfaces: surfaces.collect(),
            bodies: set.velocity_layout().bodies().to_vec(),
            surface_velocities: set.surface_velocities(),
            linkages: self.linkages.iter().collect(),
            mean_flow: self.mean_flow,
        }
    }

    /// Some linkages, numbered in their order, in the flow of a solution for all.
    ///
    /// Where the total force is given and holds some of them, it is that of these linkages.
    pub fn some(&self, numbers: &[usize], computed: &MobilitySolution) -> SomeLinkages<'_> {
        let are_held = numbers.iter().any(|&k| self.linkages[k].is_held());
        let mean_flow = match self.mean_flow {
            MeanFlowCondition::TotalForce(_) if are_held => {
                let spheres = self.all().spheres_of(numbers).into_iter();
                let forces = spheres.map(|k| computed.forces.fixed_rows::<3>(6 * k).into_owned());
                MeanFlowCondition::TotalForce(forces.sum())
            }
            _ => MeanFlowCondition::Velocity(computed.mean_flow),
        };
        let mut some = SomeLinkages {
            linkages: numbers.iter().map(|&k| &self.linkages[k]).collect(),
            velocities: Vec::new(),
            surfaces: Vec::new(),
            bodies: Vec::new(),
            surface_velocities: Vec::new(),
            mean_flow,
        };
        let (mut first, mut surface) = (0, 0);
        for one in &some.linkages {
            let layout = one.set().velocity_layout();
            some.bodies
                .extend(layout.bodies().iter().map(|k| first + k));
            let own = one.set().surface_velocities();
            some.surface_velocities
                .extend(own.iter().map(|k| first + k));
            some.velocities
                .push((first..first + layout.len()).collect());
            let count = own.len() / 6;
            some.surfaces.push((surface..surface + count).collect());
            (first, surface) = (first + layout.len(), surface + count);
        }
        some
    }

    /// Motion and loads in the scene's units, of a solution for all linkages.
    ///
    /// # Errors
    /// Joints that contradict each other.
    pub fn response(&self, solution: &MobilitySolution) -> Result<Response, ModelError> {
        self.converted(solution, |scaled| {
            self.scaled.response_to_scene(self.time, scaled)
        })
    }

    /// Change of motion and loads in the scene's units, of a solution for all linkages at rest.
    ///
    /// # Errors
    /// As [`LinkedBodies::response`].
    pub fn change(&self, solution: &MobilitySolution) -> Result<Response, ModelError> {
        self.converted(solution, |scaled| self.scaled.change_to_scene(scaled))
    }

    fn converted(
        &self,
        solution: &MobilitySolution,
        to_scene: impl FnOnce(ScaledResponse) -> Response,
    ) -> Result<Response, ModelError> {
        let set = &self.scaled.set;
        let all = self.all();
        let mut joint_loads = vec![JointLoad::default(); set.joints().len()];
        let of_linkages = all.each().map(|(one, own)| {
            let (forces, velocities) = all.of(own, solution);
            one.drive().joint_loads(&forces, &velocities)
        });
        for (one, loads) in self.linkages.iter().zip(of_linkages.collect::<Vec<_>>()) {
            for (&joint, load) in one.part.joints().iter().zip(loads?) {
                joint_loads[joint] = load;
            }
        }
        Ok(to_scene(ScaledResponse {
            motion: &set.state_velocity(solution.generalised.as_slice())?,
            generalised: &solution.generalised,
            forces: &solution.forces,
            joint_loads,
            holding: solution.holding.clone(),
            mean_flow: solution.mean_flow,
            slip_power: solution.slip_power,
            amplitudes: solution.amplitudes.clone(),
        }))
    }
}

/// Own numbers of the bodies with surfaces.
fn surfaced(set: &Articulation) -> impl Iterator<Item = usize> {
    let kinds = set.kinds().iter().enumerate();
    kinds
        .filter(|(_, kind)| **kind == BodyKind::Rigid)
        .map(|(body, _)| body)
}

impl SomeLinkages<'_> {
    /// The linkages with their numbers, in parallel.
    fn each(&self) -> impl IndexedParallelIterator<Item = (&MovingLinkage<'_>, usize)> {
        let numbered = self.linkages.par_iter().enumerate();
        numbered.map(|(own, one)| (*one, own))
    }

    /// Forces and generalised velocities of a linkage in a solution.
    fn of(&self, linkage: usize, solution: &MobilitySolution) -> (DVector<f64>, DVector<f64>) {
        let rows: Vec<usize> = (self.surfaces[linkage].iter())
            .flat_map(|&k| 6 * k..6 * k + 6)
            .collect();
        let velocities = &self.velocities[linkage];
        (
            solution.forces.select_rows(&rows),
            solution.generalised.select_rows(velocities),
        )
    }

    /// Number of linkages.
    pub fn count(&self) -> usize {
        self.linkages.len()
    }

    /// Whether joints and given velocities determine all motions.
    pub fn is_held(&self) -> bool {
        self.linkages.iter().all(|one| one.load.is_empty())
    }

    /// Whether no joint and no given velocity takes part, so that all forces are given.
    pub fn has_given_forces(&self) -> bool {
        let mut linkages = self.linkages.iter().zip(&self.surfaces);
        linkages.all(|(one, spheres)| one.load.len() == 6 * spheres.len())
    }

    /// Bodies with surfaces of some linkages, by their numbers.
    pub fn spheres_of(&self, linkages: &[usize]) -> Vec<usize> {
        let lists = linkages.iter().map(|&k| &self.surfaces[k]);
        lists.flatten().copied().collect()
    }

    /// The linkage of each body with a surface.
    pub fn linkage_of_spheres(&self) -> Vec<usize> {
        let mut of_sphere = vec![0; self.surface_velocities.len() / 6];
        for (linkage, spheres) in self.surfaces.iter().enumerate() {
            for &sphere in spheres {
                of_sphere[sphere] = linkage;
            }
        }
        of_sphere
    }
}

/// Velocities in the scene's units for a unit force on each passive joint, all else at rest, by the
/// solutions of `solve`.
///
/// # Errors
/// Joints that contradict each other; those of `solve`.
pub(crate) fn joint_responses(
    scaled: &ScaledScene,
    configuration: Configuration,
    solve: impl Fn(&LinkedBodies) -> Result<MobilitySolution, ModelError>,
) -> Result<Vec<StateVelocity>, ModelError> {
    let passive = 0..scaled.set.passive_joints().count();
    let response = |joint: usize| {
        let solved = solve(&LinkedBodies::at_rest(scaled, configuration, Some(joint))?)?;
        let motion = scaled.set.state_velocity(solved.generalised.as_slice())?;
        Ok(scaled.motion_to_scene(&motion))
    };
    passive.map(response).collect()
}
