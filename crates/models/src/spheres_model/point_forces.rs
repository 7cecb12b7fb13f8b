//! Solutions by models of point forces, without matrices over all spheres, and their error bars.

use std::f64::consts::PI;
use std::time::Instant as Clock;

use microhydro::{Medium, PointMobility, PointModel, Spheres, Squirmer, multipole};
use nalgebra::{DVector, Vector3};
use rayon::prelude::*;
use scene::{Domain, ModelEstimatesKind};
use stokes::{Seconds, SolverReport};

use super::error_bars::{ModelErrors, SurfaceEffects, follow, references};
use super::sphere_resistances::SphereResistances;
use super::{SphereModel, SpheresModel};
use crate::error::ModelError;
use crate::linked_bodies::{
    IteratedSolution, LargestDifferences, LinkedBodies, MobilitySolution, SomeLinkages,
};
use crate::query::{Configuration, Query};
use crate::solution::InstantaneousSolution;
use crate::surface_motion::SurfaceEffect;

/// Residual of changes from which errors are estimated: two digits.
const ESTIMATE_RESIDUAL: f64 = 1e-2;

/// Largest number of spheres of a neighbourhood that is solved by expansions, and of a scene that
/// is one neighbourhood: a system of order 4 takes a few hundredths of a second.
pub(super) const NEIGHBOURHOOD: usize = 12;

/// Largest number of neighbourhoods of a sampled error bar.
const SAMPLES: usize = 5;

/// Largest factor from the first reflection to the error bar: where a neighbourhood asks for more,
/// its own error is the bar.
const LARGEST_FACTOR: f64 = 10.0;

impl IteratedSolution<'_> {
    /// The solution with the stresslets that the spheres have in the flow of the forces.
    fn reflected(&self, linkages: &SomeLinkages) -> Result<MobilitySolution, ModelError> {
        let velocities = self.mobility.first_reflection(&self.found.forces)?;
        let change = self.system.change(&velocities, ESTIMATE_RESIDUAL)?;
        let coordinates = self.found.coordinates.iter().zip(&change.coordinates);
        let coordinates: Vec<_> = coordinates.map(|(v, change)| v + change).collect();
        let forces = &self.found.forces + &change.forces;
        let mean_flow = self.solution.mean_flow + change.mean_flow;
        let mut reflected = linkages.solution(&coordinates, forces, mean_flow, 0.0)?;
        reflected.slip_power = self.solution.slip_power;
        Ok(reflected)
    }
}

impl SpheresModel {
    /// The mobility in the domain of the scene.
    ///
    /// # Errors
    /// Spheres that touch the wall, or images of each other.
    pub(super) fn mobility<'s>(
        &self,
        model: PointModel,
        spheres: &'s Spheres,
    ) -> Result<PointMobility<'s>, ModelError> {
        Ok(match &self.period {
            None => PointMobility::new(model, spheres, &self.medium)?,
            Some(size) => PointMobility::periodic(model, spheres, size)?,
        })
    }

    /// The effect of slip in a model of point forces; none without.
    ///
    /// Its power is that of lone squirmers.
    fn effect_of_slip(
        mobility: &PointMobility,
        squirmers: &[Squirmer],
    ) -> Result<Option<SurfaceEffect>, ModelError> {
        if squirmers.is_empty() {
            return Ok(None);
        }
        let radii = mobility.spheres().radii().iter();
        let power = squirmers.iter().zip(radii).map(|(own, &a)| own.power(a));
        let velocities = mobility.by_slip(squirmers)?;
        Ok(Some(SurfaceEffect::of_slip(velocities, power.sum())))
    }

    /// The motion of all bodies by a model of point forces, without error bars.
    ///
    /// # Errors
    /// Spheres that are too close; joints that contradict each other.
    pub(super) fn point_solution(
        &self,
        model: PointModel,
        linked: &LinkedBodies,
        (spheres, squirmers): (&Spheres, &[Squirmer]),
    ) -> Result<MobilitySolution, ModelError> {
        let mobility = self.mobility(model, spheres)?;
        let effect = Self::effect_of_slip(&mobility, squirmers)?;
        let solved = linked.all().by_point_forces(&mobility, effect.as_ref())?;
        Ok(solved.solution)
    }

    /// Velocities at points in scaled units by the forces of many spheres in unbounded fluid, or of
    /// any in a periodic box (of expansions by those of Rotne, Prager and Yamakawa), `None` inside
    /// them; none at all for other models, few spheres and walls, which expansions serve.
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
        let by_expansions = spheres.len() <= NEIGHBOURHOOD || self.medium != Medium::Unbounded;
        let in_box = self.period.map(|_| PointModel::Rpy);
        let model = match self.kind.point_model().or(in_box) {
            Some(model) if self.period.is_some() || !by_expansions => model,
            _ => return Ok(None),
        };
        let all_rates = [rates.to_vec()];
        let query = Query::new(configuration, &all_rates);
        let linked = LinkedBodies::new(&self.scaled, &query, rates)?;
        let squirmers = self.squirmers(configuration)?;
        let mobility = self.mobility(model, &spheres)?;
        let effect = Self::effect_of_slip(&mobility, &squirmers)?;
        let solved = linked.all().by_point_forces(&mobility, effect.as_ref())?;
        let flow = mobility.flow(&solved.found.forces, &squirmers, points)?;
        let mean_flow = solved.solution.mean_flow;
        Ok(Some(
            flow.into_iter().map(|u| u.map(|u| u + mean_flow)).collect(),
        ))
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
        let estimates = match query.random_loads {
            Some(_) => ModelEstimatesKind::Off,
            None => self.scaled.scene.model().estimates,
        };
        // They belong to the configuration, and not to the rates.
        let resistances = self
            .estimates_by_expansions(estimates, &spheres)
            .then(|| self.resistances_of(&spheres))
            .transpose()?;
        let of_references = clock.elapsed().as_secs_f64();
        let linked = LinkedBodies::new(&self.scaled, query, rates)?;
        let squirmers = self.squirmers(query.configuration)?;
        let mobility = self.mobility(model, &spheres)?;
        let effect = Self::effect_of_slip(&mobility, &squirmers)?;
        let assembly = clock.elapsed().as_secs_f64();
        let solved = linked.all().by_point_forces(&mobility, effect.as_ref())?;
        let solve = clock.elapsed().as_secs_f64() - assembly;
        let response = linked.response(&solved.solution)?;
        let mut errors = match &resistances {
            Some(resistances) => {
                let surfaces = self.effects_of_slip(resistances, &spheres, &squirmers)?;
                let references = references(resistances, surfaces.as_ref());
                let mut errors = self.errors_by(&linked, &solved.solution, &references)?;
                // Errors of slip have no sign.
                errors.signed = errors.signed.filter(|_| surfaces.is_none());
                errors
            }
            None if estimates == ModelEstimatesKind::Off => ModelErrors::default(),
            None => {
                let bodies = (&linked, &spheres, &squirmers[..]);
                let mut errors = match &self.period {
                    None => self.sampled_errors(model, bodies, &solved)?,
                    Some(_) => self.errors_among_neighbours(bodies, &solved.solution)?,
                };
                if self.period.is_none() && !squirmers.is_empty() {
                    // The first reflection is one of forces alone.
                    let of_slip = self.errors_among_neighbours(bodies, &solved.solution)?;
                    errors = ModelErrors {
                        bars: errors.bars.zip(of_slip.bars).map(|(mut bars, of_slip)| {
                            bars.raise(&of_slip);
                            bars
                        }),
                        ..ModelErrors::default()
                    };
                }
                errors
            }
        };
        if let Some(bars) = &mut errors.bars {
            let of_sums = mobility.sum_errors(&solved.found.forces, &squirmers)?;
            let mut of_sums = Self::errors_of_sums(of_sums, &spheres, &solved.found.forces);
            if of_sums.power > 0.0 {
                let size = linked.all().size_of_powers(&solved.solution);
                of_sums.linkage_power = of_sums.power / size.max(of_sums.power);
            }
            bars.add(1.0, &of_sums);
        }
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

    /// Errors of a solution, in scaled units, by those of the velocities and angular velocities
    /// that its forces cause at a sphere: of loads, the drag on the largest lone sphere.
    fn errors_of_sums(
        [velocity, angular_velocity]: [f64; 2],
        spheres: &Spheres,
        forces: &DVector<f64>,
    ) -> LargestDifferences {
        let radius = spheres.radii().iter().fold(0.0_f64, |most, a| most.max(*a));
        let loads = forces.as_slice().chunks_exact(6);
        let power = loads.map(|load| {
            let [force, torque] =
                [&load[..3], &load[3..]].map(|v| Vector3::from_column_slice(v).norm());
            force * velocity + torque * angular_velocity
        });
        let power = power.sum();
        LargestDifferences {
            velocity,
            angular_velocity,
            force: 6.0 * PI * radius * velocity,
            torque: 8.0 * PI * radius.powi(3) * angular_velocity,
            power,
            ..LargestDifferences::default()
        }
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
        model: PointModel,
        (linked, spheres, squirmers): (&LinkedBodies, &Spheres, &[Squirmer]),
        solved: &IteratedSolution,
    ) -> Result<ModelErrors, ModelError> {
        let all = linked.all();
        let reflected = solved.reflected(&all)?;
        let of_reflection = all.largest_differences(&solved.solution, &reflected);
        let mut bars = LargestDifferences::default();
        let mut factors = LargestDifferences::of_all(1.0);
        let far = all.farthest_change(&solved.solution, &reflected);
        let count = all.count();
        let mut centres = vec![far, count / 3, 2 * count / 3];
        if let Some((first, _)) = spheres.closest_pair() {
            centres.insert(0, all.linkage_of_spheres()[first]);
        }
        for members in neighbourhoods(&all, spheres, centres, &Domain::Unbounded)
            .into_iter()
            .flatten()
        {
            // Spheres that expansions refuse leave the reflection, which has no order to lower.
            let of_bodies = (linked, spheres, squirmers);
            let found = self.neighbourhood(of_bodies, &members, (model, &solved.solution))?;
            if let Some(found) = found {
                bars.raise(&found.errors);
                factors.raise(&found.errors.over(&found.of_reflection, LARGEST_FACTOR));
            }
        }
        bars.raise(&of_reflection.times(&factors));
        let signed = &linked.response(&solved.solution)? - &linked.response(&reflected)?;
        Ok(ModelErrors {
            bars: Some(bars),
            signed: Some(&signed * factors.velocity),
            generalised: None,
        })
    }

    /// Errors in a periodic box, or of squirmers: the largest ones by expansions in neighbourhoods
    /// of the linkages with the largest forces and velocities and with the narrowest gap, and of
    /// two more, with their nearest neighbours and images, also those of the linkage itself; none
    /// where expansions refuse a neighbourhood, or where it has no room for the linkage, and in a
    /// periodic box for its nearest neighbour. The error of the power is the largest relative one
    /// of a neighbourhood.
    ///
    /// What the model neglects of forces decays like `(a/d)^4`, and so the neighbourhood has the
    /// most of it; of squirmers it has a part ([`SLIP_FACTOR`]).
    /// The finite size of the spheres, which points lack, decays like
    /// `(a/d)^3`: of these it is the difference from Rotne, Prager and Yamakawa, with all images.
    /// Cost: that of the expansions, for points a solution more.
    ///
    /// # Errors
    /// Those of the solutions.
    fn errors_among_neighbours(
        &self,
        (linked, spheres, squirmers): (&LinkedBodies, &Spheres, &[Squirmer]),
        computed: &MobilitySolution,
    ) -> Result<ModelErrors, ModelError> {
        let all = linked.all();
        let domain = match self.period {
            Some(size) => Domain::Periodic { size },
            None => Domain::Unbounded,
        };
        // Bodies that rest among themselves say nothing about those that move.
        let mut centres = vec![all.strongest(computed), all.fastest(computed)];
        centres.push(closest_among_images(&all, spheres, &domain));
        centres.extend([all.count() / 3, 2 * all.count() / 3]);
        let none = ModelErrors::default();
        let mut bars = LargestDifferences::default();
        for members in neighbourhoods(&all, spheres, centres, &domain) {
            let Some(members) = members else {
                return Ok(none);
            };
            let members = &members[..];
            let of_bodies = (linked, spheres, squirmers);
            let by = (PointModel::Rpy, computed);
            let Some(found) = self.neighbourhood(of_bodies, members, by)? else {
                return Ok(none);
            };
            let mut errors = found.errors;
            errors.total_force *= spheres.len() as f64 / found.spheres as f64;
            if found.power != 0.0 {
                errors.power *= (all.power(computed) / found.power).abs();
            }
            bars.raise(&errors);
        }
        if !squirmers.is_empty() {
            bars = bars.times(&LargestDifferences::of_all(SLIP_FACTOR));
        }
        if self.kind == SphereModel::Oseen {
            let finite = self.point_solution(PointModel::Rpy, linked, (spheres, squirmers))?;
            bars.add(1.0, &all.largest_differences(computed, &finite));
        }
        Ok(ModelErrors {
            bars: Some(bars),
            ..ModelErrors::default()
        })
    }

    /// Effects of slip by expansions of the orders of the last reference; none without slip.
    fn effects_of_slip(
        &self,
        resistances: &SphereResistances,
        spheres: &Spheres,
        squirmers: &[Squirmer],
    ) -> Result<Option<SurfaceEffects>, ModelError> {
        if squirmers.is_empty() {
            return Ok(None);
        }
        let slip = |sphere: usize, n: &Vector3<f64>| squirmers[sphere].slip(n);
        let rest = |_: usize, _: &Vector3<f64>| Vector3::zeros();
        let place = (spheres, &self.medium);
        SurfaceEffects::by_expansions(place, &resistances.orders, &[&slip, &rest], &[]).map(Some)
    }

    /// Errors by expansions in a neighbourhood, and by the first reflection, of the model by which
    /// all linkages were computed; none if expansions refuse the spheres.
    fn neighbourhood(
        &self,
        (linked, spheres, squirmers): (&LinkedBodies, &Spheres, &[Squirmer]),
        members: &[Member],
        (model, computed): (PointModel, &MobilitySolution),
    ) -> Result<Option<Neighbourhood>, ModelError> {
        let numbers: Vec<usize> = members.iter().map(|member| member.linkage).collect();
        let own = linked.some(&numbers, computed);
        let (mut centres, mut radii, mut of_near) = (Vec::new(), Vec::new(), Vec::new());
        for member in members {
            for k in linked.all().spheres_of(&[member.linkage]) {
                centres.push(spheres.centres()[k] + member.shift);
                radii.push(spheres.radii()[k]);
                of_near.extend(squirmers.get(k).copied());
            }
        }
        let near = Spheres::new(centres, radii)?;
        // Images are members; the fluid around them is unbounded.
        let mobility = PointMobility::new(model, &near, &self.medium)?;
        let effect = Self::effect_of_slip(&mobility, &of_near)?;
        let solved = own.by_point_forces(&mobility, effect.as_ref())?;
        let reflected = solved.reflected(&own)?;
        let of_reflection = own.largest_differences(&solved.solution, &reflected);
        let kind = match model {
            PointModel::Oseen => SphereModel::Oseen,
            PointModel::Rpy => SphereModel::Rpy,
        };
        let found = SphereResistances::limited(kind, &near, &self.medium).and_then(|found| {
            let surfaces = self.effects_of_slip(&found, &near, &of_near)?;
            Ok((found, surfaces))
        });
        let (resistances, surfaces) = match found {
            Ok(found) => found,
            Err(ModelError::Spheres(_)) => return Ok(None),
            Err(error) => return Err(error),
        };
        let mut errors = LargestDifferences::default();
        let power = own.power(&solved.solution);
        let all = references(&resistances, surfaces.as_ref());
        follow(&all, &own, solved.solution, |factor, [from, to]| {
            errors.add(factor, &own.largest_differences(from, to));
            Ok(())
        })?;
        Ok(Some(Neighbourhood {
            errors,
            of_reflection,
            power,
            spheres: near.len(),
        }))
    }

    /// Whether errors are estimated by expansions over all spheres.
    fn estimates_by_expansions(&self, estimates: ModelEstimatesKind, spheres: &Spheres) -> bool {
        match estimates {
            ModelEstimatesKind::Full => true,
            ModelEstimatesKind::Sampled => spheres.len() <= NEIGHBOURHOOD && self.period.is_none(),
            ModelEstimatesKind::Off => false,
        }
    }

    /// Predicted seconds of a solution by point forces, on two cores.
    pub(super) fn predicted_point_seconds(&self, spheres: &Spheres) -> Result<f64, ModelError> {
        let count = spheres.len() as f64;
        let product = match self.period {
            None => PointMobility::pairs_of_product(spheres.len()) * SECONDS_PER_PAIR,
            Some(_) => count.powf(1.5) * SECONDS_PER_EWALD_TERM,
        };
        let solve = EXPECTED_PRODUCTS * product;
        let estimates = self.scaled.scene.model().estimates;
        if !self.estimates_by_expansions(estimates, spheres) {
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

/// Errors among all squirmers over the largest ones in five neighbourhoods, at most: they were 1.5
/// to 2.0 times these among 40 and 48 squirmers in unbounded fluid, against multipoles.
const SLIP_FACTOR: f64 = 3.0;

/// Products with the mobility in a solution and its sampled error bar.
const EXPECTED_PRODUCTS: f64 = 30.0;

/// Time of a pair of spheres in a product, on two cores.
const SECONDS_PER_PAIR: f64 = 3e-9;

/// Time of `n^1.5` spheres in a product with Ewald's sums, on two cores.
const SECONDS_PER_EWALD_TERM: f64 = 2e-5;

/// What expansions in a neighbourhood say.
struct Neighbourhood {
    /// Errors of the model there.
    errors: LargestDifferences,
    /// Those that the first reflection finds.
    of_reflection: LargestDifferences,
    /// Power of the bodies on the fluid.
    power: f64,
    /// Number of its spheres.
    spheres: usize,
}

/// A linkage of a neighbourhood, or an image of it.
#[derive(Clone, Copy, PartialEq)]
struct Member {
    linkage: usize,
    /// Place of the image relative to the linkage.
    shift: Vector3<f64>,
}

/// Neighbourhoods that are solved by expansions: of the first [`SAMPLES`] different ones of these
/// linkages. Each has at most [`NEIGHBOURHOOD`] spheres, the nearest linkages and images of those
/// that fit; none of a linkage that is larger, or whose nearest one does not fit in a periodic box.
fn neighbourhoods(
    all: &SomeLinkages,
    spheres: &Spheres,
    centres: Vec<usize>,
    domain: &Domain,
) -> Vec<Option<Vec<Member>>> {
    let of_sphere = all.linkage_of_spheres();
    let mut chosen = Vec::new();
    for centre in centres {
        if !chosen.contains(&centre) && chosen.len() < SAMPLES {
            chosen.push(centre);
        }
    }
    let (x, a) = (spheres.centres(), spheres.radii());
    let lists = chosen.into_iter().map(|centre| {
        let own = all.spheres_of(&[centre]);
        let mut nearest: Vec<(f64, Member)> = Vec::new();
        for k in 0..x.len() {
            let linkage = of_sphere[k];
            for &from in &own {
                for shift in domain.shifts_near(&(x[from] - x[k])) {
                    let apart = own.iter().map(|&o| (x[o] - x[k] - shift).norm() - a[k]);
                    let distance = apart.fold(f64::INFINITY, f64::min);
                    nearest.push((distance, Member { linkage, shift }));
                }
                if domain.period().is_none() {
                    break;
                }
            }
        }
        // Equal distances stay in the order of the spheres.
        nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
        let itself = Member {
            linkage: centre,
            shift: Vector3::zeros(),
        };
        let mut list = vec![itself];
        let mut size = own.len();
        for (_, member) in nearest {
            let more = all.spheres_of(&[member.linkage]).len();
            if list.contains(&member) {
                continue;
            }
            if size + more > NEIGHBOURHOOD {
                break;
            }
            list.push(member);
            size += more;
        }
        let has_neighbour = list.len() > 1 || domain.period().is_none();
        (size <= NEIGHBOURHOOD && has_neighbour).then_some(list)
    });
    lists.collect()
}

/// The linkage with the smallest gap, to images of its own too.
///
/// Cost: all pairs of spheres.
fn closest_among_images(all: &SomeLinkages, spheres: &Spheres, domain: &Domain) -> usize {
    let (x, a) = (spheres.centres(), spheres.radii());
    let edge = domain.period().map_or(f64::INFINITY, |size| size.min());
    let gap = |k: usize| {
        let to_others = (0..x.len()).filter(|&other| other != k).map(|other| {
            let apart = domain.nearest_image(&(x[other] - x[k]));
            (apart.norm() - a[other] - a[k]) / a[other].min(a[k])
        });
        to_others.fold((edge - 2.0 * a[k]) / a[k], f64::min)
    };
    let gaps: Vec<f64> = (0..x.len()).into_par_iter().map(gap).collect();
    let closest = (0..x.len()).min_by(|&a, &b| gaps[a].total_cmp(&gaps[b]));
    closest.map_or(0, |k| all.linkage_of_spheres()[k])
}
