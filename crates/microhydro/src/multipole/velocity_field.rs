//! Velocity field around the spheres, for visualisation and for checks of boundary values.

use std::f64::consts::PI;

use faer::Mat;
use nalgebra::{DVector, Vector3};
use rayon::prelude::*;

use super::axial::{Interior, Outgoing};
use super::collinear::Around;
use super::frame::Frame;
use super::lamb::Lamb;
use super::link::{Body, Half, onto_axis};
use super::lubrication::{MOST_IN_SPACE, MOST_ON_CONTAINER};
use super::modes::Family;
use super::order::{self, Orders};
use super::rotation::Rotation;
use super::system::System;
use super::wall_block::Regular;
use super::{AXES, FIXED_ORDER_TOLERANCE, drag_units};
use crate::{Accuracy, HydroError, Medium, Spheres};

/// Velocity field around moving spheres, evaluated at any point of the fluid.
pub struct VelocityField {
    spheres: Spheres,
    medium: Medium,
    frame: Frame,
    bodies: Vec<Body>,
    /// For each expansion, the coefficients of its own flow on its own surface.
    harmonics: Vec<Vec<f64>>,
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
    /// As [`super::resistance`]; [`HydroError::Length`] for velocities of the wrong length.
    pub fn new(
        spheres: &Spheres,
        medium: &Medium,
        velocities: &DVector<f64>,
        accuracy: &Accuracy,
    ) -> Result<Self, HydroError> {
        if velocities.len() != 6 * spheres.len() {
            return Err(HydroError::Length {
                what: "velocities of the spheres",
                expected: 6 * spheres.len(),
                found: velocities.len(),
            });
        }
        spheres.check_inside(medium)?;
        let tolerance = accuracy.tolerance.clamp(1e-12, 1.0);
        let closeness = order::closeness(spheres, medium);
        let orders = match accuracy.order {
            Some(order) => Orders::all(spheres.len(), medium, order),
            None => order::for_tolerance(&closeness, medium, tolerance * tolerance)
                .cut(MOST_IN_SPACE, MOST_ON_CONTAINER),
        };
        let frame = Frame::of(spheres, medium);
        let system = System::new(&frame, spheres.radii(), &orders, FIXED_ORDER_TOLERANCE);
        let units = drag_units(spheres.radii());
        let mut right = system.zeros(1);
        let mut largest = 0.0_f64;
        for sphere in 0..spheres.len() {
            for (k, row) in system.rigid_rows(sphere).into_iter().enumerate() {
                let first = 6 * sphere + 3 * (k / 3);
                let turned = frame.turn * velocities.fixed_rows::<3>(first).into_owned();
                let value = units[6 * sphere + k] * turned[AXES[k % 3]];
                right[sphere][(row, 0)] = value;
                largest = largest.max(value.abs());
            }
        }
        let mut unknowns = system.zeros(1);
        let everything = system.mask(|_, _, _| true);
        let residual = match accuracy.order {
            Some(_) => 1e-12,
            None => 0.1 * tolerance,
        };
        system.solve(&everything, &right, &mut unknowns, residual * largest)?;
        let unscale = |(body, x): (&Body, &Mat<f64>)| {
            let mut harmonics = vec![0.0; body.modes.len()];
            for (family, l) in body.modes.shells() {
                for row in body.modes.shell(family, l) {
                    harmonics[row] = x[(row, 0)] / body.weight(family, l);
                }
            }
            harmonics
        };
        Ok(Self {
            harmonics: system.bodies.iter().zip(&unknowns).map(unscale).collect(),
            bodies: system.bodies,
            spheres: spheres.clone(),
            medium: *medium,
            frame,
        })
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
    /// [`HydroError::NotInFluid`].
    pub fn velocity(&self, point: &Vector3<f64>) -> Result<Vector3<f64>, HydroError> {
        // points on a surface, to rounding, belong to the fluid
        let within = |distance: f64, radius: f64| distance < -1e-12 * radius;
        let (x, a) = (self.spheres.centres(), self.spheres.radii());
        let inside_sphere = (0..a.len()).any(|k| within((point - x[k]).norm() - a[k], a[k]));
        let room = self.medium.distance(point);
        if inside_sphere || room.is_nan() || within(room, a.iter().fold(0.0, |m, &r| r.max(m))) {
            return Err(HydroError::NotInFluid {
                x: point.x,
                y: point.y,
                z: point.z,
            });
        }
        let seen = self.frame.turn * (point - self.frame.origin);
        let mut velocity = Vector3::zeros();
        for (sphere, centre) in self.frame.centres.iter().enumerate() {
            let body = &self.bodies[sphere];
            let offset = seen - centre;
            let distance = offset.norm();
            let flows = [0, 1].map(|m| {
                Outgoing::new(m, (body.radius, body.modes.order), (distance, 1), distance)
            });
            velocity += self.on_axis(sphere, &offset, |m, f, l| flows[m].lamb(f, l, 1));
            if self.frame.around == Around::Wall && seen.z > 0.0 {
                velocity += self.reflected(sphere, centre, &seen);
            }
        }
        if let Around::Ball(radius) = self.frame.around {
            let container = self.bodies.len() - 1;
            let order = self.bodies[container].modes.order;
            let flows = [0, 1].map(|m| Interior::new(m, (radius, order), (radius, 1), seen.norm()));
            velocity += self.on_axis(container, &seen, |m, f, k| flows[m].lamb(f, k, 1));
        }
        Ok(self.frame.turn.inverse() * velocity)
    }

    /// Velocity of the flow of one expansion at an offset from its centre.
    ///
    /// With the axis along the offset only `m = 0` and `m = 1` contribute.
    fn on_axis(
        &self,
        body: usize,
        offset: &Vector3<f64>,
        flow: impl Fn(usize, Family, usize) -> Lamb,
    ) -> Vector3<f64> {
        let modes = self.bodies[body].modes;
        let turn = onto_axis(offset);
        let rotation = Rotation::new(&turn, modes.order);
        let mut constant = [0.0; 3];
        for (family, l) in modes.shells() {
            let shell = &self.harmonics[body][modes.shell(family, l)];
            for half in Half::all(1) {
                let (row, sign) = half.row(family, l);
                let matrix = rotation.degree(l);
                let value: f64 = (0..shell.len()).map(|k| matrix[(row, k)] * shell[k]).sum();
                let (plain, _) = half.row(Family::Stokeslet, 1);
                constant[plain] += sign * value * flow(half.m, family, l).phi;
            }
        }
        turn.inverse() * vector(&constant)
    }

    /// Velocity of the image of a sphere in the wall `z = 0`.
    fn reflected(&self, sphere: usize, centre: &Vector3<f64>, seen: &Vector3<f64>) -> Vector3<f64> {
        let body = &self.bodies[sphere];
        let offset = seen - Vector3::new(centre.x, centre.y, -centre.z);
        let degrees = Regular::FOR_A_POINT;
        let axial: Vec<Outgoing> = (0..=degrees.min(body.modes.order))
            .map(|m| {
                Outgoing::new(
                    m,
                    (body.radius, body.modes.order),
                    (seen.z, degrees),
                    offset.norm(),
                )
            })
            .collect();
        let rotation = Rotation::new(&onto_axis(&offset), body.modes.order.max(degrees));
        let mut regular = Regular::zeros(degrees);
        for (family, l) in body.modes.shells() {
            let shell = &self.harmonics[sphere][body.modes.shell(family, l)];
            let mirrored = DVector::from_fn(shell.len(), |k, _| {
                shell[k] * family.parity(l, k.abs_diff(l))
            });
            let turned = rotation.degree(l) * mirrored;
            regular.add(&axial, family, l, turned.as_slice());
        }
        vector(&regular.turned_back(&rotation).reflected_velocity(1.0))
    }
}

/// Vector with the given coefficients of `W_1`, `m = -1, 0, 1`.
fn vector(modes: &[f64; 3]) -> Vector3<f64> {
    let mut vector = Vector3::zeros();
    for (axis, value) in AXES.into_iter().zip(modes) {
        vector[axis] = value * (0.75 / PI).sqrt();
    }
    vector
}
