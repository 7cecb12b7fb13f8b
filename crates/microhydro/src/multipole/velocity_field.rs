//! Velocity field around the spheres, for visualisation and for checks of boundary values.

use std::f64::consts::PI;

use faer::Mat;
use nalgebra::{DVector, Vector3};
use rayon::prelude::*;

use super::axial_translation::{InteriorTranslation, OutgoingTranslation};
use super::coupling::{Expansion, SymmetryClass};
use super::fixed_order::FIXED_ORDER_TOLERANCE;
use super::frame::{Frame, Surroundings};
use super::lamb::LambCoefficients;
use super::memory;
use super::modes::Family;
use super::orders::Orders;
use super::rotation::{AXIS_OF_M, Rotation, rotation_to_z};
use super::slip_expansion::{self, SlipExpansion, SphereSlip};
use super::sources::Sources;
use super::system::System;
use super::truncation::{self, GapCoordinates, MAX_ORDER_OFF_AXIS, MAX_ORDER_ON_CONTAINER};
use super::wall_image::LambExpansion;
use crate::error::check_finite;
use crate::{Accuracy, HydroError, Medium, Spheres};

/// Velocity field around moving spheres, evaluated at any point of the fluid.
pub struct VelocityField {
    spheres: Spheres,
    medium: Medium,
    frame: Frame,
    expansions: Vec<Expansion>,
    /// For each expansion, the coefficients of its own flow on its own surface.
    harmonics: Vec<Vec<f64>>,
    /// Sources in spheres whose radii change.
    sources: Option<Sources>,
    relative_error: f64,
    /// Order that the narrowest gap needs for the tolerance.
    needed: usize,
}

impl VelocityField {
    /// Solves for the flow of spheres with given velocities and angular velocities.
    ///
    /// `velocities` has six entries per sphere. The error of the velocity field is about
    /// `accuracy.tolerance` times the velocity of the spheres. It is the square root of the error
    /// of the resistance, so the order is twice as high. Cost: one solve of the system of
    /// [`super::resistance`] off an axis.
    ///
    /// # Errors
    /// [`HydroError::TooClose`] for gaps whose order is too high: [`VelocityField::best`] has an
    /// answer; otherwise as [`super::resistance`]; [`HydroError::Length`] for velocities of the
    /// wrong length.
    pub fn new(
        spheres: &Spheres,
        medium: &Medium,
        velocities: &DVector<f64>,
        accuracy: &Accuracy,
    ) -> Result<Self, HydroError> {
        let field = Self::best(spheres, medium, velocities, accuracy)?;
        if accuracy.order.is_some() || field.relative_error <= accuracy.tolerance {
            return Ok(field);
        }
        let (surfaces, gap) = spheres.narrowest_gap(medium);
        Err(HydroError::TooClose {
            surfaces,
            gap,
            tolerance: accuracy.tolerance,
            needed: field.needed,
            highest: MAX_ORDER_OFF_AXIS,
        })
    }

    /// [`VelocityField::new`], or the most accurate field at the highest allowed orders.
    ///
    /// [`VelocityField::relative_error`] has the estimate, which may be above the tolerance.
    ///
    /// # Errors
    /// As [`VelocityField::new`], without [`HydroError::TooClose`].
    pub fn best(
        spheres: &Spheres,
        medium: &Medium,
        velocities: &DVector<f64>,
        accuracy: &Accuracy,
    ) -> Result<Self, HydroError> {
        Self::with_surface_velocity(spheres, medium, velocities, None, accuracy)
    }

    /// [`VelocityField::best`] for surfaces that move relative to their spheres; `None` if they are
    /// rigid.
    ///
    /// The orders are raised to those that the [`SphereSlip`] needs; its remainder counts in
    /// [`VelocityField::relative_error`].
    ///
    /// # Errors
    /// As [`VelocityField::best`]; [`HydroError::SlipNotResolved`]; [`HydroError::NetFlux`].
    pub fn with_surface_velocity(
        spheres: &Spheres,
        medium: &Medium,
        velocities: &DVector<f64>,
        surface_velocity: Option<&SphereSlip<'_>>,
        accuracy: &Accuracy,
    ) -> Result<Self, HydroError> {
        spheres.check_inside(medium)?;
        if accuracy.order.is_none() {
            accuracy.check()?;
        }
        // the iteration cannot be more accurate
        let tolerance = accuracy.tolerance.clamp(1e-12, 1.0);
        memory::check_spheres(spheres.len())?;
        let gaps = truncation::gaps(spheres, medium);
        let xi = GapCoordinates::narrowest_of(&gaps, spheres.len());
        let needed = match accuracy.order {
            Some(order) => Orders::all(spheres.len(), medium, order),
            None => truncation::for_tolerance(&xi, medium, tolerance * tolerance),
        };
        let orders = match accuracy.order {
            Some(_) => needed.clone(),
            None => needed.limited(MAX_ORDER_OFF_AXIS, MAX_ORDER_ON_CONTAINER),
        };
        let frame = Frame::new(spheres, medium);
        let slip = surface_velocity
            .map(|slip| SlipExpansion::new(&frame, spheres.radii(), &[slip]))
            .transpose()?;
        let orders = match &slip {
            Some(slip) => orders.at_least(&slip.orders(medium, 0)),
            None => orders,
        };
        let relative_error = match orders.at_least(&needed) == orders && accuracy.order.is_none() {
            true => accuracy.tolerance,
            false => truncation::error(&xi, &orders).sqrt(),
        };
        let remainder = slip.as_ref().map_or(0.0, |slip| slip.remainder);
        memory::check_one_solution(&orders, matches!(medium, Medium::Wall { .. }))?;
        let system =
            System::new(&frame, spheres.radii(), &orders, FIXED_ORDER_TOLERANCE).store_couplings();
        let rhs = slip_expansion::of_moving_spheres(&system, &frame, velocities, slip.as_ref())?;
        let largest = slip_expansion::largest(&rhs);
        let mut coefficients = system.zeros(1);
        let everything = system.mask(|_, _, _| true);
        let residual = match accuracy.order {
            Some(_) => 1e-12,
            None => 0.1 * tolerance,
        };
        system.solve(&everything, &rhs, &mut coefficients, residual * largest)?;
        let unscale = |(expansion, x): (&Expansion, &Mat<f64>)| {
            let mut harmonics = vec![0.0; expansion.modes.len()];
            for (family, l) in expansion.modes.shells() {
                for row in expansion.modes.shell(family, l) {
                    harmonics[row] = x[(row, 0)] / expansion.weight(family, l);
                }
            }
            harmonics
        };
        Ok(Self {
            harmonics: system
                .expansions
                .iter()
                .zip(&coefficients)
                .map(unscale)
                .collect(),
            expansions: system.expansions,
            spheres: spheres.clone(),
            medium: *medium,
            frame,
            sources: slip.map(SlipExpansion::into_sources),
            relative_error: relative_error.max(remainder),
            needed: needed.highest(),
        })
    }

    /// Expected error of the velocities, relative to the velocity of the spheres.
    pub fn relative_error(&self) -> f64 {
        self.relative_error
    }

    /// Velocities at points of the fluid, evaluated in parallel.
    ///
    /// # Errors
    /// [`HydroError::NotInFluid`] for one of the points outside the fluid.
    pub fn velocities(&self, points: &[Vector3<f64>]) -> Result<Vec<Vector3<f64>>, HydroError> {
        points.par_iter().map(|x| self.velocity(x)).collect()
    }

    /// Velocity at a point of the fluid. Cost: `O(L^3)` per sphere.
    ///
    /// # Errors
    /// [`HydroError::NotInFluid`]; [`HydroError::NotFinite`] for a point so far away that powers of
    /// its distance overflow.
    pub fn velocity(&self, point: &Vector3<f64>) -> Result<Vector3<f64>, HydroError> {
        // points on a surface, to rounding, belong to the fluid
        let within = |distance: f64, radius: f64| distance < -1e-12 * radius;
        let (x, a) = (self.spheres.centres(), self.spheres.radii());
        let inside_sphere = (0..a.len()).any(|k| within((point - x[k]).norm() - a[k], a[k]));
        let clearance = self.medium.distance(point);
        if inside_sphere
            || clearance.is_nan()
            || !point.iter().all(|x| x.is_finite())
            || within(clearance, a.iter().fold(0.0, |m, &r| r.max(m)))
        {
            return Err(HydroError::NotInFluid {
                x: point.x,
                y: point.y,
                z: point.z,
            });
        }
        let local = self.frame.to_axes * (point - self.frame.origin);
        let has_wall = self.frame.surroundings == Surroundings::Wall;
        if has_wall && local.z <= 0.0 {
            // on the wall, to rounding, where images have no expansion
            return Ok(Vector3::zeros());
        }
        let sources = self.sources.as_ref();
        let mut velocity =
            sources.map_or_else(Vector3::zeros, |sources| sources.velocity(&local, 0));
        for (sphere, centre) in self.frame.centres.iter().enumerate() {
            let expansion = &self.expansions[sphere];
            let offset = local - centre;
            let distance = offset.norm();
            let flows = [0, 1].map(|m| {
                OutgoingTranslation::new(
                    m,
                    (expansion.radius, expansion.modes.order),
                    (distance, 1),
                    distance,
                )
            });
            velocity +=
                self.expansion_velocity(sphere, &offset, |m, f, l| flows[m].coefficients(f, l, 1));
            if has_wall {
                velocity += self.image_velocity(sphere, centre, &local);
            }
        }
        if let Surroundings::Ball(radius) = self.frame.surroundings {
            let container = self.expansions.len() - 1;
            let order = self.expansions[container].modes.order;
            let flows = [0, 1]
                .map(|m| InteriorTranslation::new(m, (radius, order), (radius, 1), local.norm()));
            velocity += self
                .expansion_velocity(container, &local, |m, f, k| flows[m].coefficients(f, k, 1));
        }
        check_finite("the velocity at a point", &velocity)?;
        Ok(self.frame.to_axes.inverse() * velocity)
    }

    /// Velocity of the flow of one expansion at an offset from its centre.
    ///
    /// With the axis along the offset only `m = 0` and `m = 1` contribute.
    fn expansion_velocity(
        &self,
        expansion: usize,
        offset: &Vector3<f64>,
        flow: impl Fn(usize, Family, usize) -> LambCoefficients,
    ) -> Vector3<f64> {
        let modes = self.expansions[expansion].modes;
        let rotation_to_axis = rotation_to_z(offset);
        let rotation = Rotation::new(&rotation_to_axis, modes.order);
        let mut constant = [0.0; 3];
        for (family, l) in modes.shells() {
            let shell = &self.harmonics[expansion][modes.shell(family, l)];
            for class in SymmetryClass::all(1) {
                let (row, sign) = class.row(family, l);
                let matrix = rotation.degree(l);
                let value: f64 = (0..shell.len()).map(|k| matrix[(row, k)] * shell[k]).sum();
                let (component, _) = class.row(Family::Stokeslet, 1);
                constant[component] += sign * value * flow(class.m, family, l).phi;
            }
        }
        rotation_to_axis.inverse() * vector(&constant)
    }

    /// Velocity of the image of a sphere in the wall `z = 0`.
    fn image_velocity(
        &self,
        sphere: usize,
        centre: &Vector3<f64>,
        local: &Vector3<f64>,
    ) -> Vector3<f64> {
        let expansion = &self.expansions[sphere];
        let offset = local - Vector3::new(centre.x, centre.y, -centre.z);
        let degrees = LambExpansion::MAX_DEGREE_AT_A_POINT;
        let axial: Vec<OutgoingTranslation> = (0..=degrees.min(expansion.modes.order))
            .map(|m| {
                OutgoingTranslation::new(
                    m,
                    (expansion.radius, expansion.modes.order),
                    (local.z, degrees),
                    offset.norm(),
                )
            })
            .collect();
        let rotation = Rotation::new(&rotation_to_z(&offset), expansion.modes.order.max(degrees));
        let mut regular = LambExpansion::zeros(degrees);
        for (family, l) in expansion.modes.shells() {
            let shell = &self.harmonics[sphere][expansion.modes.shell(family, l)];
            let reflected = DVector::from_fn(shell.len(), |k, _| {
                shell[k] * family.parity(l, k.abs_diff(l))
            });
            let rotated = rotation.degree(l) * reflected;
            regular.add(&axial, family, l, rotated.as_slice());
        }
        vector(&regular.rotated_back(&rotation).reflected_velocity(1.0))
    }
}

/// Vector with the given coefficients of `W_1`, `m = -1, 0, 1`.
fn vector(modes: &[f64; 3]) -> Vector3<f64> {
    let mut vector = Vector3::zeros();
    for (axis, value) in AXIS_OF_M.into_iter().zip(modes) {
        vector[axis] = value * (0.75 / PI).sqrt();
    }
    vector
}
