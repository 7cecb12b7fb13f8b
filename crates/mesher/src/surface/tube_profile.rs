//! The radius of a tube along its centreline, with round ends and a head.

use std::f64::consts::{FRAC_PI_2, PI};

/// Radius of a tube as a function of the length of arc of its centreline.
///
/// Between the ends of the curve the radius is `a + (b - a) (3 x² - 2 x³)`, with the share `x` of
/// the length: it is constant at the ends, where the curvature jumps to zero, so that the surface
/// is smooth. Half balls close the ends. With a head, a ball of its radius is in front of the
/// curve, and a concave fillet of the radius of the tube joins them at its start.
#[derive(Clone, Debug, PartialEq)]
pub struct TubeProfile {
    length: f64,
    pub(super) radii: [f64; 2],
    head: Option<f64>,
    pub(super) pieces: Vec<Piece>,
}

/// A part of the meridian, in the half-plane of the length of arc and of the distance from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Piece {
    /// A circle about a centre, with the angles of the outward normal at its ends. The radius is
    /// negative where the surface is concave.
    Arc {
        centre: [f64; 2],
        radius: f64,
        angles: [f64; 2],
    },
    /// The radius along the curve of this length, with the radii at its ends.
    Along { length: f64, radii: [f64; 2] },
}

/// A point of the meridian, with its derivative with respect to the parameter of the meridian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeridianPoint {
    pub arc: f64,
    pub radius: f64,
    pub derivative: [f64; 2],
    /// Cosine and sine of the angle of the outward normal with minus the tangent.
    pub normal: [f64; 2],
}

impl TubeProfile {
    /// The profile of a tube along a curve of this length, with the radii at its start and at its
    /// end, and the radius of the head.
    ///
    /// The radii differ by less than the length, and the head is larger than the start.
    pub fn new(length: f64, radii: [f64; 2], head: Option<f64>) -> Self {
        let [start, end] = radii;
        let arc = |at: f64, radius: f64, angles: [f64; 2]| Piece::Arc {
            centre: [at, 0.0],
            radius,
            angles,
        };
        let mut pieces = Vec::with_capacity(4);
        match head {
            None => pieces.push(arc(0.0, start, [0.0, FRAC_PI_2])),
            Some(head) => {
                // The centres of the head and of the fillet are the sum of their radii apart.
                let (fillet, height) = (start, 2.0 * start);
                let along = (head + fillet).powi(2) - height * height;
                let along = along.max(0.0).sqrt();
                let joint = FRAC_PI_2 + along.atan2(height);
                pieces.push(arc(-along, head, [0.0, joint]));
                pieces.push(Piece::Arc {
                    centre: [0.0, height],
                    radius: -fillet,
                    angles: [joint, FRAC_PI_2],
                });
            }
        }
        pieces.push(Piece::Along { length, radii });
        pieces.push(arc(length, end, [FRAC_PI_2, PI]));
        Self {
            length,
            radii,
            head,
            pieces,
        }
    }

    /// The point at a parameter between zero and the number of pieces.
    pub(super) fn at(&self, parameter: f64) -> MeridianPoint {
        let last = self.pieces.len() - 1;
        let number = (parameter.max(0.0) as usize).min(last);
        let share = parameter - number as f64;
        match self.pieces[number] {
            Piece::Arc {
                centre,
                radius,
                angles: [from, to],
            } => {
                let angle = from + share * (to - from);
                // Poles are on the centreline exactly.
                let (sin, cos) = match angle < PI {
                    true => angle.sin_cos(),
                    false => (0.0, -1.0),
                };
                let turned = radius * (to - from);
                MeridianPoint {
                    arc: centre[0] - radius * cos,
                    radius: centre[1] + radius * sin,
                    derivative: [turned * sin, turned * cos],
                    normal: [cos, sin],
                }
            }
            Piece::Along {
                length,
                radii: [start, end],
            } => {
                let change = end - start;
                let derivative = [length, 6.0 * change * share * (1.0 - share)];
                let speed = derivative[0].hypot(derivative[1]);
                MeridianPoint {
                    arc: share * length,
                    radius: start + change * share * share * (3.0 - 2.0 * share),
                    derivative,
                    normal: [derivative[1] / speed, derivative[0] / speed],
                }
            }
        }
    }

    /// Length of the curve.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The balls at both ends: the length of arc of their centres, and their radii.
    ///
    /// A straight tube of one radius is in their convex hull.
    pub fn end_balls(&self) -> [(f64, f64); 2] {
        let ball = |piece: &Piece| match *piece {
            Piece::Arc { centre, radius, .. } => (centre[0], radius),
            Piece::Along { radii, .. } => (0.0, radii[0]),
        };
        let last = self.pieces.len() - 1;
        [ball(&self.pieces[0]), ball(&self.pieces[last])]
    }

    /// Volume of the tube and first moment of its volume along the straight tube, `∫ π r² ds` and
    /// `∫ π r² s ds`.
    ///
    /// The volume is that of the bent tube too, because the centroids of the cross-sections are on
    /// the centreline (Pappus).
    pub fn volume_and_moment(&self) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for piece in &self.pieces {
            let of_piece = match *piece {
                Piece::Along {
                    length,
                    radii: [a, b],
                } => {
                    // Integrals of 1, f and f² of f = 3 x² - 2 x³, and of x times them.
                    let [one, two] = [2.0 * a * (b - a), (b - a).powi(2)];
                    let area = a * a + one * 0.5 + two * 13.0 / 35.0;
                    let moment = a * a * 0.5 + one * 7.0 / 20.0 + two * 2.0 / 7.0;
                    [area * length, moment * length * length]
                }
                // r² = c² + 2 c R sin ν + R² sin² ν and s = s_0 - R cos ν.
                Piece::Arc {
                    centre: [at, c],
                    radius,
                    angles: [from, to],
                } => {
                    let primitive = |angle: f64| {
                        let (sin, cos) = angle.sin_cos();
                        let zeroth = -c * c * cos
                            + c * radius * (angle - sin * cos)
                            + radius * radius * (cos.powi(3) / 3.0 - cos);
                        let first = 0.5 * c * c * sin * sin
                            + 2.0 / 3.0 * c * radius * sin.powi(3)
                            + 0.25 * radius * radius * sin.powi(4);
                        [radius * zeroth, radius * (at * zeroth - radius * first)]
                    };
                    let [low, high] = [primitive(from), primitive(to)];
                    [high[0] - low[0], high[1] - low[1]]
                }
            };
            sums[0] += PI * of_piece[0];
            sums[1] += PI * of_piece[1];
        }
        sums
    }
}
