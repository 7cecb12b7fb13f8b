//! Bodies that deform by shape coordinates.

use std::f64::consts::TAU;
use std::sync::Arc;

use mesh::Surface;
use nalgebra::{Isometry3, Vector3};

use crate::body_check::BodyCheck;
use crate::shape::Shape;
use crate::shapes::TubeShape;
use crate::sphere_deformation::SphereDeformation;
use crate::triangle_deformation::{TriangleDeformation, TriangleShape};
use crate::undulation::{Bend, Wave, WaveTube};

/// Deformation of a body by shape coordinates, which are numbers of joints of the scene.
///
/// The position of the body stays the origin of its own axes, and its rotation turns them: the
/// material point `X` of a shape with the amplitudes `a` is at `x_c + Q X(a)`, and its velocity is
/// `U + ω × (x - x_c) + Q Σ (∂X/∂a) da/dt`.
#[derive(Clone, Debug, PartialEq)]
pub enum Deformation {
    /// Of a sphere or a spheroid about its centre.
    Sphere(SphereDeformation),
    /// Of a tube by a wave along its centreline.
    Undulation(Undulation),
    /// Of a surface of triangles by the motion of its vertices.
    Triangles(TriangleDeformation),
}

/// A wave along the centreline of a tube, whose amplitude and phase are shape coordinates.
///
/// The volume of the tube is constant: centroids of the cross-sections are on the centreline.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Undulation {
    /// The tube before the wave bends it.
    pub tube: TubeShape,
    /// The wave.
    pub wave: Wave,
    /// Amplitude and phase at the start, unless the gait determines them.
    pub start: [f64; 2],
    /// Joints whose values are the amplitude and the phase.
    pub joints: [usize; 2],
}

/// A body at some values of its shape coordinates, with its material points.
///
/// Positions are relative to the position of the body, along the axes of the initial configuration.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum DeformedBody {
    /// A sphere or a spheroid at these values of all joints.
    Sphere(SphereDeformation, Vec<f64>),
    /// A bent tube in its own axes.
    Tube(Box<WaveTube>, Undulation),
    /// Triangles with moved vertices, at these values of all joints.
    Triangles(TriangleDeformation, Arc<TriangleShape>, Vec<f64>),
}

impl Deformation {
    /// The deformation of a sphere or a spheroid; none of another body.
    pub fn sphere(&self) -> Option<&SphereDeformation> {
        match self {
            Self::Sphere(sphere) => Some(sphere),
            Self::Undulation(_) | Self::Triangles(_) => None,
        }
    }

    /// The shape coordinates, by the numbers of their joints.
    pub fn joints(&self) -> Box<dyn Iterator<Item = usize> + '_> {
        match self {
            Self::Sphere(sphere) => Box::new(sphere.joints()),
            Self::Undulation(tube) => Box::new(tube.joints.iter().copied()),
            Self::Triangles(of) => Box::new(of.joints.iter().copied()),
        }
    }

    /// The coordinates with a period, which changes no shape: the phase of a wave, and periodic
    /// ones of triangles.
    pub fn periods(&self) -> Vec<(usize, f64)> {
        match self {
            Self::Sphere(_) => Vec::new(),
            Self::Undulation(tube) => vec![(tube.joints[1], TAU)],
            Self::Triangles(of) => {
                let both = of.joints.iter().zip(&of.coordinates);
                both.filter_map(|(joint, own)| Some((*joint, own.period?)))
                    .collect()
            }
        }
    }

    /// Whether the surface stays a sphere.
    pub fn is_sphere(&self) -> bool {
        self.sphere().is_some_and(SphereDeformation::is_sphere)
    }

    /// Axis of the modes of a sphere or a spheroid in the initial configuration; none without
    /// modes.
    pub fn axis(&self) -> Option<Vector3<f64>> {
        self.sphere()?.axis()
    }

    /// Whether the deformation is symmetric about the axis of its modes, or about every axis.
    pub fn is_axisymmetric(&self) -> bool {
        self.sphere()
            .is_some_and(SphereDeformation::is_axisymmetric)
    }

    /// Radius of a ball about the position of the body that contains it.
    pub fn bounding_radius(&self, values: &[f64]) -> f64 {
        match self {
            Self::Sphere(sphere) => sphere.bounding_radius(values),
            Self::Undulation(tube) => Shape::Tube(tube.at(values)).bounding_radius(),
            Self::Triangles(of) => of.bounding_radius(values),
        }
    }

    /// Shape for distances from other bodies and walls: the ball around a sphere, a spheroid or
    /// triangles that deform, the bent tube.
    pub fn outline(&self, values: &[f64]) -> Shape {
        match self {
            Self::Sphere(sphere) => Shape::sphere(sphere.bounding_radius(values)),
            Self::Undulation(tube) => Shape::Tube(tube.at(values)),
            Self::Triangles(of) => Shape::sphere(of.bounding_radius(values)),
        }
    }

    /// Rate of the volume of the body for a rate of one of a joint.
    pub fn volume_rate(&self, values: &[f64], joint: usize) -> f64 {
        match self {
            Self::Sphere(sphere) => sphere.volume_rate(values, joint),
            Self::Undulation(_) => 0.0,
            Self::Triangles(of) => of.volume_rate(values, joint),
        }
    }

    /// Whether the value of a joint changes the volume: a size, a mode with radial motion, or the
    /// motion of vertices.
    pub fn changes_volume(&self, joint: usize) -> bool {
        match self {
            Self::Sphere(sphere) => sphere.changes_volume(joint),
            Self::Undulation(_) => false,
            Self::Triangles(of) => of.changes_volume() && of.joints.contains(&joint),
        }
    }

    /// What is wrong with these values; `None` if the surface is that of a body.
    pub fn problem(&self, values: &[f64]) -> Option<String> {
        match self {
            Self::Sphere(sphere) => sphere.problem(values),
            Self::Undulation(tube) => tube.problem(values),
            Self::Triangles(of) => of.problem(values),
        }
    }

    /// Whether the surface is that of a body at these values, and at all that differ from them by
    /// at most the changes of the joints.
    ///
    /// Modes neither fold nor reach the centre, and tubes neither fold nor touch themselves.
    /// Triangles do not fold; they may pass through each other by an eighth of their height.
    pub(crate) fn check(&self, values: &[f64], changes: &dyn Fn(usize) -> f64) -> BodyCheck {
        match self {
            Self::Sphere(sphere) => sphere.check(values, changes),
            Self::Undulation(tube) => tube.check(values, changes),
            Self::Triangles(of) => match of.problem(values) {
                Some(problem) => BodyCheck::Problem(problem),
                None if of.keeps_sides_within(values, changes) => BodyCheck::Within,
                None => BodyCheck::Here,
            },
        }
    }

    /// The surface at these values of the joints, at a pose relative to the initial configuration.
    ///
    /// `unit` is the length in the surface that is one in the scene.
    pub fn surface(
        &self,
        values: &[f64],
        pose: &Isometry3<f64>,
        unit: f64,
    ) -> Option<Box<dyn Surface>> {
        match self {
            Self::Sphere(sphere) => Some(sphere.surface(values, pose, unit)),
            Self::Undulation(tube) => Shape::Tube(tube.at(values)).surface(pose, 1.0 / unit),
            Self::Triangles(of) => of.surface(values, pose, unit),
        }
    }

    /// The body at these values of the joints.
    pub fn at(&self, values: &[f64]) -> DeformedBody {
        match self {
            Self::Sphere(sphere) => DeformedBody::Sphere(sphere.clone(), values.to_vec()),
            Self::Undulation(tube) => {
                DeformedBody::Tube(Box::new(tube.at(values).tube(1.0)), tube.clone())
            }
            Self::Triangles(of) => {
                DeformedBody::Triangles(of.clone(), of.shape(values), values.to_vec())
            }
        }
    }
}

impl Undulation {
    /// The tube at these values of the joints; not a number for those that do not exist.
    pub fn at(&self, values: &[f64]) -> TubeShape {
        let value = |joint: usize| values.get(joint).copied().unwrap_or(f64::NAN);
        let [amplitude, phase] = self.joints.map(value);
        TubeShape {
            bend: Some(Bend {
                wave: self.wave,
                amplitude,
                phase,
            }),
            ..self.tube
        }
    }

    /// Normal of the plane in which the wave bends the tube, in the initial configuration; none of
    /// a helical one.
    pub(crate) fn plane_normal(&self) -> Option<Vector3<f64>> {
        let turn = Shape::Tube(self.tube).orientation();
        (!self.wave.is_helical()).then(|| turn * Vector3::z())
    }

    /// Largest speed of points for a rate of one of the amplitude, and of the phase, at amplitudes
    /// up to a size.
    pub(crate) fn speeds(&self, amplitude: f64) -> [f64; 2] {
        let of_line = self.wave.speeds(self.tube.length, amplitude);
        // Points off the centreline and beyond its ends turn with it.
        let arm = self.tube.largest_extent() / (0.5 * self.tube.length);
        of_line.map(|speed| 2.0 * arm * speed)
    }

    fn problem(&self, values: &[f64]) -> Option<String> {
        self.check(values, &|_| 0.0).problem()
    }

    /// Whether the tube neither folds nor touches itself, also at all values that differ from these
    /// by at most the changes.
    ///
    /// Balls of the radius `ρ` fit to both sides of the tube at these values, and must be larger
    /// than `m`, a small part of its radius. Balls of the radius `m` fit between two parts of it
    /// while their points move by less than `ρ - m`. Where its radius is `r` its curvature is at
    /// most `1 / (r + ρ)`, and they fit there while that is below `1 / (r + m)`.
    fn check(&self, values: &[f64], changes: &dyn Fn(usize) -> f64) -> BodyCheck {
        let tube = self.at(values);
        let Some(bend) = &tube.bend else {
            return BodyCheck::Within;
        };
        if let Some(problem) = bend.problem() {
            return BodyCheck::Problem(problem);
        }
        let least = MIN_REACH * self.tube.radius.min(self.tube.end_radius);
        let reach = tube.tube(1.0).reach();
        if reach.is_nan() || reach <= least {
            return BodyCheck::Problem(
                "folds or touches itself: its centreline bends more than its radius allows, or \
                 comes back to itself; use a smaller amplitude, fewer waves or a thinner tube"
                    .to_owned(),
            );
        }
        let [of_amplitude, of_phase] = self.joints.map(changes);
        let largest = bend.amplitude.abs() + of_amplitude;
        let Some(bends) = (self.wave).curvature_rates(self.tube.length, largest) else {
            return BodyCheck::Here;
        };
        let speeds = self.speeds(largest);
        let radii = [
            tube.radius,
            tube.end_radius,
            tube.head_radius.unwrap_or(0.0),
        ];
        let radius = radii.into_iter().fold(0.0, f64::max);
        let sum = |[a, b]: [f64; 2]| a * of_amplitude + b * of_phase;
        let of_curvature = 1.0 / (radius + least) - 1.0 / (radius + reach);
        match sum(speeds) < reach - least && sum(bends) < of_curvature {
            true => BodyCheck::Within,
            false => BodyCheck::Here,
        }
    }
}

/// Smallest radius of balls that fit to both sides of a bent tube, over its radius: below it cells
/// on the inner side become too small for a mesh.
const MIN_REACH: f64 = 0.05;

impl DeformedBody {
    /// Velocity of the material point at `x`, on or near the surface, for a rate of one of a joint.
    pub fn velocity(&self, x: &Vector3<f64>, joint: usize) -> Vector3<f64> {
        match self {
            Self::Sphere(sphere, values) => {
                let n = sphere.material_direction(x, values);
                sphere.velocity(&n, values, joint)
            }
            Self::Tube(tube, undulation) => {
                let turn = Shape::Tube(undulation.tube).orientation();
                let at = tube.coordinates(&turn.inverse_transform_vector(x));
                let velocities = tube.curve().velocities(&at);
                let own = undulation.joints.iter().zip(velocities);
                let moved = own.filter(|(own, _)| **own == joint);
                turn * moved.map(|(_, velocity)| velocity).sum::<Vector3<f64>>()
            }
            Self::Triangles(of, shape, values) => of.velocity(shape, values, x, joint),
        }
    }

    /// Displacement of the surface near `x` to the same body at other values, for the motion of a
    /// mesh.
    ///
    /// Points of a sphere or a spheroid move along their rays, whatever the motion of material
    /// points; those of a tube and of triangles are material points.
    pub fn displacement(&self, to: &Self, x: &Vector3<f64>) -> Vector3<f64> {
        match (self, to) {
            (Self::Sphere(own, from), Self::Sphere(other, to)) => {
                let direction = own.shortened(*x).try_normalize(0.0).unwrap_or_default();
                let change = other.distance(&direction, to) - own.distance(&direction, from);
                own.stretched(change * direction)
            }
            (Self::Tube(own, undulation), Self::Tube(other, _)) => {
                let turn = Shape::Tube(undulation.tube).orientation();
                let at = own.coordinates(&turn.inverse_transform_vector(x));
                turn * (other.point(&at) - own.point(&at))
            }
            (Self::Triangles(of, from, _), Self::Triangles(_, to, _)) => {
                of.displacement([from, to], x)
            }
            _ => Vector3::zeros(),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::words::{EnvelopeKind, WaveKind};

    proptest! {
        #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

        /// Where a tube certainly neither folds nor touches itself, balls fit to both of its sides.
        #[test]
        fn no_tube_folds_where_none_may(
            kind in prop_oneof![
                Just(WaveKind::Curvature), Just(WaveKind::Displacement), Just(WaveKind::Helix),
            ],
            envelope in prop_oneof![Just(EnvelopeKind::Uniform), Just(EnvelopeKind::Linear)],
            waves in 0.3..2.0_f64,
            share in 0.1..0.95_f64,
            phase in -3.0..3.0_f64,
            changes in prop::array::uniform2(0.0..1.0_f64),
            tried in prop::collection::vec(prop::array::uniform2(-1.0..1.0_f64), 6),
        ) {
            let undulation = Undulation {
                tube: TubeShape {
                    length: 8.0,
                    radius: 0.4,
                    end_radius: 0.3,
                    head_radius: None,
                    orientation: Vector3::zeros(),
                    bend: None,
                },
                wave: Wave { kind, envelope, waves },
                start: [0.0; 2],
                joints: [0, 1],
            };
            let (mut low, mut high) = (0.0, 4.0);
            for _ in 0..8 {
                let amplitude = 0.5 * (low + high);
                match undulation.problem(&[amplitude, phase]) {
                    None => low = amplitude,
                    Some(_) => high = amplitude,
                }
            }
            let values = [share * low, phase];
            let mut least = 1.0;
            let is_within = |least: f64| {
                let change = |joint: usize| least * changes[joint];
                undulation.check(&values, &change) == BodyCheck::Within
            };
            while !is_within(least) {
                least *= 0.5;
                prop_assert!(least > 1e-4, "{values:?}");
            }
            for tried in tried {
                let moved = [0, 1].map(|k| values[k] + least * tried[k] * changes[k]);
                let tube = undulation.at(&moved);
                prop_assert!(tube.bend.as_ref().unwrap().problem().is_none());
                prop_assert!(tube.tube(1.0).reach() > 0.0, "{values:?} {moved:?}");
            }
        }
    }
}
