//! Solutions by models of point forces, without matrices over all spheres, and their error bars.

use std::time::Instant as Clock;

use microhydro::{Medium, PointMobility, PointModel, Spheres, multipole};
use nalgebra::{DMatrix, Vector3};
use scene::ModelEstimatesKind;
use stokes::{Seconds, SolverReport};

use super::SpheresModel;
use super::sphere_resistances::SphereResistances;
use crate::error::ModelError;
use crate::linked_bodies::{
    LargestDifferences, LinkedBodies, MobilitySolution, PointSolution, SomeLinkages,
};
use crate::query::{Configuration, Query};
use crate::response::Response;
use crate::solution::InstantaneousSolution;
use crate::surface_motion::SurfaceEffect;

/// Residual of changes from which errors are estimated: two digits.
const ESTIMATE_RESIDUAL: f64 = 1e-2;

/// Largest number of spheres of a neighbourhood that is solved by expansions, and of a scene that
/// is one neighbourhood: a system of order 4 takes a few hundredths of a second.
pub(super) const NEIGHBOURHOOD: usize = 12;

/// Largest number of neighbourhoods of a sampled error bar.
const SAMPLES: usize = 4;

/// Largest factor from the first reflection to the error bar: where a neighbourhood asks for more,
/// its own error is the bar.
const LARGEST_FACTOR: f64 = 10.0;

/// Errors of a solution.
#[derive(Default)]
pub(super) struct ModelErrors {
    /// Largest errors of any body; none if they are not estimated.
    pub bars: Option<LargestDifferences>,
    /// The error, computed minus exact.
    pub signed: Option<Response>,
}

impl PointSolution<'_> {
    /// The solution with the stresslets that the spheres have in the flow of the forces.
    fn reflected(&self, linkages: &SomeLinkages) -> Result<MobilitySolution, ModelError> {
        let velocities = self.mobility.first_reflection(&self.found.forces)?;
        let change = self.system.change(&velocities, ESTIMATE_RESIDUAL)?;
        let coordinates = self.found.coordinates.iter().zip(&change.coordinates);
        let coordinates: Vec<_> = coordinates.map(|(v, change)| v + change).collect();
        linkages.solution(&coordinates, &self.found.forces + change.forces, 0.0)
    }
}

impl SpheresModel {
    /// The motion of all bodies by a model of point forces, without error bars.
    ///
    /// # Errors
    /// Spheres that are too close; joints that contradict each other.
    pub(super) fn point_solution(
        &self,
        model: PointModel,
        linked: &LinkedBodies,
        spheres: &Spheres,
    ) -> Result<MobilitySolution, ModelError> {
        let mobility = PointMobility::new(model, spheres, &self.medium)?;
        Ok(linked.all().by_point_forces(&mobility)?.solution)
    }

    /// Velocities at points in scaled units by the forces of many spheres in unbounded fluid,
    /// `None` inside them; none at all for other models, few spheres and walls, which expansions
    /// serve.
    ///
    /// # Errors
    /// As [`SpheresModel::point_solution`].
    pub(super) fn flow_of_point_forces(
        &self,
        configuration: Configuration,
        rates: &[f64],
        points: &[Vector3<f64>],
    ) -> Result<Option<Vec<Option<Vector3<f64>>>>, ModelError> {
        let spheres = self.spheres(configuration)?;
        let model = match self.kind.point_model() {
            Some(model) if spheres.len() > NEIGHBOURHOOD && self.medium == Medium::Unbounded => {
                model
            }
            _ => return Ok(None),
        };
        let all_rates = [rates.to_vec()];
        let query = Query::new(configuration, &all_rates);
        let linked = LinkedBodies::new(&self.scaled, &query, rates)?;
        let mobility = PointMobility::new(model, &spheres, &self.medium)?;
        let solved = linked.all().by_point_forces(&mobility)?;
        Ok(Some(mobility.flow(&solved.found.forces, points)?))
    }

    /// The solution for one set of rates by a model of point forces.
    ///
    /// # Errors
    /// As [`SpheresModel::point_solution`].
    pub(super) fn point_forces(
        &mut self,
        model: PointModel,
        query: &Query,
        rates: &[f64],
    ) -> Result<InstantaneousSolution, ModelError> {
        let clock = Clock::now();
        let spheres = self.spheres(query.configuration)?;
        let estimates = self.scaled.scene.model().estimates;
        // They belong to the configuration, and not to the rates.
        let resistances = self
            .estimates_by_expansions(&spheres)
            .then(|| self.resistances_of(&spheres))
            .transpose()?;
        let of_references = clock.elapsed().as_secs_f64();
        let linked = LinkedBodies::new(&self.scaled, query, rates)?;
        let mobility = PointMobility::new(model, &spheres, &self.medium)?;
        let assembly = clock.elapsed().as_secs_f64();
        let solved = linked.all().by_point_forces(&mobility)?;
        let solve = clock.elapsed().as_secs_f64() - assembly;
        let response = linked.response(&solved.solution)?;
        let errors = match &resistances {
            Some(resistances) => {
                let references = (&resistances.references[..], None);
                self.errors_by(&linked, &solved.solution, references)?
            }
            None if estimates == ModelEstimatesKind::Off => ModelErrors::default(),
            None => self.sampled_errors(&linked, &spheres, &solved)?,
        };
        let total = clock.elapsed().as_secs_f64();
        let mut solution = InstantaneousSolution {
            seconds: Seconds {
                assembly: assembly - of_references,
                solve,
                estimate: of_references + total - assembly - solve,
                total,
                ..Seconds::default()
            },
            ..InstantaneousSolution::from(response)
        };
        solution.dofs.total = 6 * spheres.len();
        solution.solver = SolverReport {
            formulation: "p-tilde".to_owned(),
            solver: "conjugate gradients".to_owned(),
            iterations: solved.found.iterations,
            true_relative_residual: solved.found.residual,
        };
        self.enter_errors(&mut solution, errors);
        Ok(solution)
    }

    /// Errors that are found by other models: the differences of successive solutions, the first of
    /// them `computed`, each times the factor of the later one.
    ///
    /// # Errors
    /// Bodies that are too close.
    pub(super) fn errors_by(
        &self,
        linked: &LinkedBodies,
        computed: &MobilitySolution,
        (references, effect): (&[(DMatrix<f64>, f64)], Option<&SurfaceEffect>),
    ) -> Result<ModelErrors, ModelError> {
        let all = linked.all();
        let mut bars = LargestDifferences::default();
        let mut signed: Option<Response> = None;
        let mut previous = computed.clone();
        for (reference, factor) in references {
            let reference = all.by_resistance(reference, effect)?;
            bars.add(*factor, &all.largest_differences(&previous, &reference));
            let change = &linked.response(&previous)? - &linked.response(&reference)?;
            let change = &change * *factor;
            signed = Some(match signed {
                Some(sum) => sum + &change,
                None => change,
            });
            previous = reference;
        }
        Ok(ModelErrors {
            bars: Some(bars),
            signed,
        })
    }

    /// Errors by the first reflection over all spheres and by expansions in some neighbourhoods.
    ///
    /// The first reflection finds what the model neglects to its order, everywhere and with the sum
    /// over all spheres. Expansions in the neighbourhoods of at most [`SAMPLES`] linkages find the
    /// errors that are left, near contact above all: the bar is the reflection times the largest
    /// ratio of the two in a neighbourhood, at least the errors there. Cost: two products with the
    /// mobility (four for points), a solution to two digits, and the expansions, whose cost does
    /// not depend on the number of spheres.
    ///
    /// # Errors
    /// Those of the solutions.
    fn sampled_errors(
        &self,
        linked: &LinkedBodies,
        spheres: &Spheres,
        solved: &PointSolution,
    ) -> Result<ModelErrors, ModelError> {
        let all = linked.all();
        let reflected = solved.reflected(&all)?;
        let of_reflection = all.largest_differences(&solved.solution, &reflected);
        let mut bars = LargestDifferences::default();
        let mut factors = LargestDifferences::of_all(1.0);
        let far = all.farthest_change(&solved.solution, &reflected);
        for linkages in neighbourhoods(&all, spheres, far) {
            // Spheres that expansions refuse leave the reflection, which has no order to lower.
            if let Some((found, reflected)) = self.neighbourhood(linked, spheres, &linkages)? {
                bars.raise(&found);
                factors.raise(&found.over(&reflected, LARGEST_FACTOR));
            }
        }
        bars.raise(&of_reflection.times(&factors));
        let signed = &linked.response(&solved.solution)? - &linked.response(&reflected)?;
        Ok(ModelErrors {
            bars: Some(bars),
            signed: Some(&signed * factors.velocity),
        })
    }

    /// Errors by expansions in a neighbourhood, and by the first reflection; none if expansions
    /// refuse the spheres.
    fn neighbourhood(
        &self,
        linked: &LinkedBodies,
        spheres: &Spheres,
        numbers: &[usize],
    ) -> Result<Option<(LargestDifferences, LargestDifferences)>, ModelError> {
        let own = linked.some(numbers);
        let members = linked.all().spheres_of(numbers);
        let centres = members.iter().map(|&k| spheres.centres()[k]).collect();
        let radii = members.iter().map(|&k| spheres.radii()[k]).collect();
        let near = Spheres::new(centres, radii)?;
        let model = match self.kind.point_model() {
            Some(model) => model,
            None => return Ok(None),
        };
        let mobility = PointMobility::new(model, &near, &self.medium)?;
        let solved = own.by_point_forces(&mobility)?;
        let reflected = solved.reflected(&own)?;
        let of_reflection = own.largest_differences(&solved.solution, &reflected);
        let references = match SphereResistances::limited(self.kind, &near, &self.medium) {
            Ok(resistances) => resistances.references,
            Err(ModelError::Spheres(_)) => return Ok(None),
            Err(error) => return Err(error),
        };
        let mut errors = LargestDifferences::default();
        let mut previous = solved.solution;
        for (reference, factor) in references {
            let reference = own.by_resistance(&reference, None)?;
            errors.add(factor, &own.largest_differences(&previous, &reference));
            previous = reference;
        }
        Ok(Some((errors, of_reflection)))
    }

    /// Whether errors are estimated by expansions over all spheres.
    fn estimates_by_expansions(&self, spheres: &Spheres) -> bool {
        match self.scaled.scene.model().estimates {
            ModelEstimatesKind::Full => true,
            ModelEstimatesKind::Sampled => spheres.len() <= NEIGHBOURHOOD,
            ModelEstimatesKind::Off => false,
        }
    }

    /// Predicted seconds of a solution by point forces, on two cores.
    pub(super) fn predicted_point_seconds(&self, spheres: &Spheres) -> Result<f64, ModelError> {
        let pairs = (spheres.len() as f64).powi(2);
        let solve = EXPECTED_PRODUCTS * pairs * SECONDS_PER_PAIR;
        if !self.estimates_by_expansions(spheres) {
            return Ok(solve);
        }
        // The expansions from which errors are estimated take almost all of the time.
        let mut sum = solve;
        let needed = multipole::predicted_order(spheres, &self.medium, super::POINT_FORCE_ERROR)?;
        for order in super::REFERENCE_ORDERS {
            let accuracy = microhydro::Accuracy::order(order);
            sum += multipole::predicted_seconds(spheres, &self.medium, &accuracy, 0)?;
            if order >= needed {
                break;
            }
        }
        Ok(sum)
    }
}

/// Products with the mobility in a solution and its sampled error bar.
const EXPECTED_PRODUCTS: f64 = 30.0;

/// Time of a pair of spheres in a product, on two cores.
const SECONDS_PER_PAIR: f64 = 3e-9;

/// Linkages whose neighbourhoods are solved by expansions: of the closest spheres, of the largest
/// error by the first reflection, and two others. Each is a list of linkages of at most
/// [`NEIGHBOURHOOD`] spheres, the nearest ones of those that fit.
fn neighbourhoods(all: &SomeLinkages, spheres: &Spheres, far: usize) -> Vec<Vec<usize>> {
    let count = all.count();
    let of_sphere = all.linkage_of_spheres();
    let mut centres = vec![far, count / 3, 2 * count / 3];
    if let Some((first, _)) = spheres.closest_pair() {
        centres.insert(0, of_sphere[first]);
    }
    let mut chosen = Vec::new();
    for centre in centres {
        if !chosen.contains(&centre) && chosen.len() < SAMPLES {
            chosen.push(centre);
        }
    }
    let x = spheres.centres();
    let lists = chosen.into_iter().map(|centre| {
        let own = all.spheres_of(&[centre]);
        let distance = |k: usize| {
            let apart = own
                .iter()
                .map(|&o| (x[o] - x[k]).norm() - spheres.radii()[k]);
            apart.fold(f64::INFINITY, f64::min)
        };
        let mut nearest: Vec<(f64, usize)> = (0..x.len()).map(|k| (distance(k), k)).collect();
        nearest.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut list = vec![centre];
        let mut size = own.len();
        for (_, k) in nearest {
            let linkage = of_sphere[k];
            let more = all.spheres_of(&[linkage]).len();
            if list.contains(&linkage) {
                continue;
            }
            if size + more > NEIGHBOURHOOD {
                break;
            }
            list.push(linkage);
            size += more;
        }
        (size, list)
    });
    let fitting = lists.filter(|(size, _)| *size <= NEIGHBOURHOOD);
    fitting.map(|(_, list)| list).collect()
}
