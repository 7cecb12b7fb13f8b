//! Motion of the fluid that does not come from the joints: slip of surfaces, background flow.

use nalgebra::{Matrix3, Vector3};

use crate::words::BackgroundKind;

/// Tangential velocity of the surface of a body, in the axes of the body: a squirmer.
///
/// With the unit vector `k` along the axis and the outward unit normal `n`,
///
/// ```text
/// u_s = -(B1 + B2 n·k) (I - n n^T) k
/// ```
///
/// On a sphere this is `u_θ = B1 sin θ + B2 sin θ cos θ` with the angle `θ` from the axis
/// (Lighthill 1952, Blake 1971). On a spheroid about its axis, with the unit tangent `s` of a
/// meridian, it is
/// `-(B1 + B2 n·k) (s·k) s` (Keller & Wu 1977).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slip {
    /// Coefficient of the first mode: a free sphere swims along the axis at `2 B1 / 3`.
    pub b1: f64,
    /// Coefficient of the second mode: positive for pullers, negative for pushers, if `B1 > 0`.
    pub b2: f64,
    /// Unit vector along the axis in the initial configuration; it turns with the body.
    pub axis: Vector3<f64>,
}

impl Slip {
    /// Velocity of the surface relative to the body where its outward unit normal is `normal`.
    ///
    /// Normal and velocity are in the axes of the initial configuration.
    pub fn velocity(&self, normal: &Vector3<f64>) -> Vector3<f64> {
        let cosine = normal.dot(&self.axis);
        (self.axis - cosine * normal) * -(self.b1 + self.b2 * cosine)
    }

    /// Whether a reflection at the plane normal to a coordinate axis does not change the slip of a
    /// sphere in the plane, nor its axis.
    ///
    /// The axis lies in the plane, or is normal to it and the first mode is zero: the second one is
    /// symmetric about its equator.
    pub(crate) fn is_symmetric(&self, normal: usize) -> bool {
        let others = (0..3).filter(|&other| other != normal);
        let is_normal = || others.map(|other| self.axis[other]).all(|a| a == 0.0);
        self.axis[normal] == 0.0 || (self.b1 == 0.0 && is_normal())
    }

    /// Largest speed of the surface, up to a factor of two.
    pub fn speed(&self) -> f64 {
        self.b1.abs().max(self.b2.abs())
    }
}

/// Flow in the absence of the bodies, a solution of the Stokes equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// The same velocity everywhere.
    Uniform {
        /// The velocity.
        velocity: Vector3<f64>,
    },
    /// Velocity `u_i = sum_j G_ij x_j` with a constant gradient.
    Linear {
        /// Word of the scene file: `shear` or `extension`.
        kind: BackgroundKind,
        /// The gradient `G`, with zero trace.
        gradient: Matrix3<f64>,
    },
    /// A mean pressure gradient in a periodic box, whose mean flow past bodies that are held is a
    /// result.
    PressureGradient {
        /// The mean of the gradient of the pressure: the flow is against it.
        gradient: Vector3<f64>,
    },
    /// Poiseuille flow along a tube about the x axis, `u_x = velocity (1 - (y^2 + z^2) / R^2)`.
    Poiseuille {
        /// Velocity on the axis of the tube along x, twice the mean velocity.
        velocity: f64,
        /// Radius `R` of the tube.
        radius: f64,
    },
}

impl Background {
    /// Kind of flow, as in the scene file.
    pub fn kind(&self) -> BackgroundKind {
        match self {
            Self::Uniform { .. } => BackgroundKind::Uniform,
            Self::Linear { kind, .. } => *kind,
            Self::PressureGradient { .. } => BackgroundKind::PressureGradient,
            Self::Poiseuille { .. } => BackgroundKind::Poiseuille,
        }
    }

    /// Velocity at a point; zero for a mean pressure gradient, which determines it with the bodies.
    pub fn velocity(&self, x: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Uniform { velocity } => *velocity,
            Self::PressureGradient { .. } => Vector3::zeros(),
            Self::Linear { gradient, .. } => gradient * x,
            Self::Poiseuille { velocity, radius } => {
                let r = x.yz().norm() / radius;
                Vector3::x() * (velocity * (1.0 - r * r))
            }
        }
    }

    /// Gradient `G_ij = ∂u_i/∂x_j` at a point.
    pub fn gradient(&self, x: &Vector3<f64>) -> Matrix3<f64> {
        match self {
            Self::Uniform { .. } | Self::PressureGradient { .. } => Matrix3::zeros(),
            Self::Linear { gradient, .. } => *gradient,
            Self::Poiseuille { velocity, radius } => {
                let factor = -2.0 * velocity / (radius * radius);
                let mut gradient = Matrix3::zeros();
                (gradient[(0, 1)], gradient[(0, 2)]) = (factor * x.y, factor * x.z);
                gradient
            }
        }
    }

    /// Gradient of the pressure over the viscosity by which the velocity varies: its Laplacian.
    pub fn pressure_gradient(&self) -> Vector3<f64> {
        match self {
            Self::Uniform { .. } | Self::PressureGradient { .. } | Self::Linear { .. } => {
                Vector3::zeros()
            }
            Self::Poiseuille { velocity, radius } => {
                Vector3::x() * (-4.0 * velocity / (radius * radius))
            }
        }
    }

    /// The same flow with `unit` as unit of length; times and the unit of the viscosity do not
    /// change.
    #[must_use]
    pub fn in_units_of(&self, unit: f64) -> Self {
        match *self {
            Self::Uniform { velocity } => Self::Uniform {
                velocity: velocity / unit,
            },
            Self::PressureGradient { gradient } => Self::PressureGradient {
                gradient: gradient * unit,
            },
            Self::Linear { .. } => *self,
            Self::Poiseuille { velocity, radius } => Self::Poiseuille {
                velocity: velocity / unit,
                radius: radius / unit,
            },
        }
    }

    /// Whether a reflection at the plane through the origin normal to a coordinate axis does not
    /// change the flow.
    pub(crate) fn is_symmetric(&self, normal: usize) -> bool {
        match self {
            Self::Uniform { velocity: v } | Self::PressureGradient { gradient: v } => {
                v[normal] == 0.0
            }
            Self::Linear { gradient, .. } => (0..3)
                .filter(|&other| other != normal)
                .all(|other| gradient[(normal, other)] == 0.0 && gradient[(other, normal)] == 0.0),
            Self::Poiseuille { .. } => normal != 0,
        }
    }

    /// Whether rotations about the line through `point` along the unit vector `axis` do not change
    /// the flow, and it has no swirl about this line.
    pub(crate) fn is_axisymmetric(&self, point: &Vector3<f64>, axis: &Vector3<f64>) -> bool {
        /// Relative size of rounding errors of directions that are written with a few digits.
        const ROUNDING: f64 = 1e-9;
        let is_along = |v: &Vector3<f64>| v.cross(axis).norm() <= ROUNDING * v.norm();
        let through_origin = || is_along(point);
        match self {
            Self::Uniform { velocity: v } | Self::PressureGradient { gradient: v } => is_along(v),
            Self::Linear { gradient, .. } => {
                let rate = axis.dot(&(gradient * axis));
                let along = axis * axis.transpose();
                let axial = (along * 3.0 - Matrix3::identity()) * (0.5 * rate);
                through_origin() && (gradient - axial).norm() <= ROUNDING * gradient.norm()
            }
            Self::Poiseuille { .. } => is_along(&Vector3::x()) && through_origin(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slip_on_a_sphere_has_the_two_modes_of_a_squirmer() {
        let slip = Slip {
            b1: 0.7,
            b2: -0.4,
            axis: Vector3::z(),
        };
        let (sin, cos) = 0.9_f64.sin_cos();
        let along_theta = Vector3::new(cos, 0.0, -sin);
        let expected = along_theta * (0.7 * sin - 0.4 * sin * cos);
        let velocity = slip.velocity(&Vector3::new(sin, 0.0, cos));
        assert!((velocity - expected).norm() < 1e-15);
    }

    /// `P u(P x) = u(x)` for the reflection `P`, at points of the sphere or of space.
    #[test]
    fn symmetric_flows_are_their_own_reflections() {
        let points = [
            Vector3::new(0.6, -0.48, 0.64),
            Vector3::new(-0.36, 0.8, 0.48),
        ];
        let reflected = |normal: usize, mut x: Vector3<f64>| {
            x[normal] = -x[normal];
            x
        };
        let is_own = |normal: usize, velocity: &dyn Fn(&Vector3<f64>) -> Vector3<f64>| {
            points.iter().all(|x| {
                let image = reflected(normal, velocity(&reflected(normal, *x)));
                (image - velocity(x)).norm() < 1e-14
            })
        };
        let axes = [Vector3::z(), Vector3::new(0.8, 0.0, -0.6), Vector3::x()];
        for (b1, b2) in [(1.0, 0.5), (0.0, 0.5), (1.0, 0.0)] {
            for axis in axes {
                let slip = Slip { b1, b2, axis };
                for normal in 0..3 {
                    let own = is_own(normal, &|x| slip.velocity(x));
                    assert_eq!(slip.is_symmetric(normal), own, "{slip:?} {normal}");
                }
            }
        }
        let linear = |gradient| Background::Linear {
            kind: BackgroundKind::Shear,
            gradient,
        };
        for flow in [
            linear(Matrix3::new(1.0, 2.0, 0.0, 4.0, -3.0, 0.0, 0.0, 0.0, 2.0)),
            linear(Matrix3::new(1.0, 0.0, 0.0, 0.0, -3.0, 6.0, 0.0, 0.0, 2.0)),
            linear(Matrix3::from_diagonal(&Vector3::new(1.0, -3.0, 2.0))),
            Background::Uniform {
                velocity: Vector3::new(0.0, 1.0, -2.0),
            },
            Background::Poiseuille {
                velocity: 2.0,
                radius: 3.0,
            },
        ] {
            for normal in 0..3 {
                let own = is_own(normal, &|x| flow.velocity(x));
                assert_eq!(flow.is_symmetric(normal), own, "{flow:?} {normal}");
            }
        }
    }

    #[test]
    fn gradients_are_those_of_the_velocities() {
        let flows = [
            Background::Linear {
                kind: BackgroundKind::Shear,
                gradient: Matrix3::new(1.0, 2.0, 3.0, 4.0, -3.0, 6.0, 7.0, 8.0, 2.0),
            },
            Background::Poiseuille {
                velocity: 2.0,
                radius: 3.0,
            },
        ];
        let (x, h) = (Vector3::new(0.3, -0.7, 1.1), 1e-5);
        for flow in flows {
            for axis in 0..3 {
                let step = Vector3::ith(axis, h);
                let difference =
                    (flow.velocity(&(x + step)) - flow.velocity(&(x - step))) / (2.0 * h);
                assert!((difference - flow.gradient(&x).column(axis)).norm() < 1e-9);
            }
        }
    }
}
