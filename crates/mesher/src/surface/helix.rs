//! Tubes along a helix.

use super::tube::{Section, intervals, open_tube};
use mesh::{Surface, SurfaceMesh, Vec3};
use std::f64::consts::PI;

/// Sample points of the centreline per turn, from which closest points are searched.
const SAMPLES: usize = 32;

/// A tube with round ends along the helix `(h t, R cos t, R sin t)`, `|t| <= pi turns`.
///
/// `2 pi h` is the pitch, positive for a right-handed helix.
#[derive(Clone, Debug, PartialEq)]
pub struct Helix {
    radius: f64,
    rise: f64,
    end: f64,
    tube: f64,
    reach: f64,
    /// Parameters and points of the centreline, with equal intervals.
    samples: Vec<(f64, Vec3)>,
}

impl Helix {
    /// The helix with the given radius of the centreline, pitch, number of turns and radius of the
    /// tube.
    ///
    /// The tube does not touch itself if [`Surface::reach`] is positive.
    pub fn new(radius: f64, pitch: f64, turns: f64, tube: f64) -> Self {
        let mut helix = Helix {
            radius,
            rise: pitch / (2.0 * PI),
            end: PI * turns,
            tube,
            reach: 0.0,
            samples: Vec::new(),
        };
        // A number that is not finite gives the smallest table.
        let intervals = ((SAMPLES as f64 * turns).ceil() as usize).clamp(4, 1 << 20);
        let parameter = |k: usize| helix.end * (2.0 * k as f64 / intervals as f64 - 1.0);
        helix.samples = (0..=intervals)
            .map(|k| (parameter(k), helix.at(parameter(k))))
            .collect();
        let of_curvature = helix.speed().powi(2) / radius;
        let outside = of_curvature.min(0.5 * helix.turn_distance()) - tube;
        helix.reach = tube.min(outside);
        helix
    }

    fn at(&self, t: f64) -> Vec3 {
        Vec3::new(self.rise * t, self.radius * t.cos(), self.radius * t.sin())
    }

    fn derivative(&self, t: f64) -> Vec3 {
        Vec3::new(self.rise, -self.radius * t.sin(), self.radius * t.cos())
    }

    /// Length of the centreline per unit of the parameter.
    fn speed(&self) -> f64 {
        self.radius.hypot(self.rise)
    }

    /// Parameter of the point of the centreline closest to `x`.
    fn closest(&self, x: Vec3) -> f64 {
        let squared = |k: usize| (x - self.samples[k].1).norm_squared();
        let last = self.samples.len() - 1;
        let lowest = (0..=last).map(squared).fold(f64::INFINITY, f64::min);
        // Half the second derivative of the squared distance is at most `speed^2 + R d`, and the
        // parameter of a minimum is within an interval of that of its sample.
        let step = self.samples[1].0 - self.samples[0].0;
        let curve = self.speed().powi(2) + self.radius * lowest.sqrt();
        let limit = lowest + curve * step * step;
        let (mut best, mut parameter) = (f64::INFINITY, 0.0);
        let [mut before, mut here] = [f64::INFINITY, squared(0)];
        for k in 0..=last {
            let after = if k < last {
                squared(k + 1)
            } else {
                f64::INFINITY
            };
            if here <= before && here <= after && here <= limit {
                let low = self.samples[k.saturating_sub(1)].0;
                let high = self.samples[(k + 1).min(last)].0;
                let t = self.root(x, low, high);
                let distance = (x - self.at(t)).norm_squared();
                if distance < best {
                    (best, parameter) = (distance, t);
                }
            }
            [before, here] = [here, after];
        }
        parameter
    }

    /// Parameter in an interval at which the distance from `x` is stationary, or its nearer end.
    ///
    /// Newton's method for `(c - x) . c' = 0`, with bisection where it leaves the bracket.
    fn root(&self, x: Vec3, mut low: f64, mut high: f64) -> f64 {
        let slope = |t: f64| (self.at(t) - x).dot(&self.derivative(t));
        if slope(low) >= 0.0 {
            return low;
        }
        if slope(high) <= 0.0 {
            return high;
        }
        let mut t = 0.5 * (low + high);
        for _ in 0..60 {
            let f = slope(t);
            if f > 0.0 {
                high = t;
            } else {
                low = t;
            }
            // c'' = (0, -R cos t, -R sin t)
            let outwards = Vec3::new(0.0, t.cos(), t.sin());
            let curve = self.speed().powi(2) - self.radius * (self.at(t) - x).dot(&outwards);
            let newton = t - f / curve;
            let next = match newton > low && newton < high {
                true => newton,
                false => 0.5 * (low + high),
            };
            let change = (next - t).abs();
            t = next;
            if change <= 16.0 * f64::EPSILON * self.end.max(1.0) {
                break;
            }
        }
        t
    }

    /// Smallest distance between turns of the centreline; infinite for less than half a turn.
    fn turn_distance(&self) -> f64 {
        let squared =
            |d: f64| 2.0 * self.radius.powi(2) * (1.0 - d.cos()) + (self.rise * d).powi(2);
        let count = 64 * self.samples.len();
        let step = 2.0 * self.end / count as f64;
        let mut smallest = f64::INFINITY;
        let mut rising = true;
        for k in 1..=count {
            let [before, now] = [squared((k - 1) as f64 * step), squared(k as f64 * step)];
            rising &= now >= before;
            if !rising {
                smallest = smallest.min(now);
            }
        }
        smallest.sqrt()
    }
}

impl Surface for Helix {
    fn signed_distance(&self, point: Vec3) -> f64 {
        (point - self.at(self.closest(point))).norm() - self.tube
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        let t = self.closest(point);
        let foot = self.at(t);
        // From a point of the centreline all directions across it are equally short.
        let inwards = Vec3::new(0.0, -t.cos(), -t.sin());
        let direction = (point - foot).try_normalize(0.0).unwrap_or(inwards);
        foot + self.tube * direction
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        (
            Vec3::zeros(),
            self.radius.hypot(self.rise * self.end) + self.tube,
        )
    }

    /// That of a straight tube of the same length, because the centroids of the cross-sections are
    /// on the centreline (Pappus).
    fn volume(&self) -> f64 {
        let length = 2.0 * self.end * self.speed();
        PI * self.tube.powi(2) * (length + 4.0 / 3.0 * self.tube)
    }

    fn is_convex(&self) -> bool {
        false
    }

    fn reach(&self) -> f64 {
        self.reach
    }

    fn inradius(&self) -> f64 {
        self.tube
    }

    fn triangulation(&self) -> Option<SurfaceMesh> {
        let length = 2.0 * self.end * self.speed();
        // At least eight sections per turn.
        let least = (4.0 * self.end / PI).ceil() as usize;
        let count = intervals(length, self.tube, least.max(2));
        let sections: Vec<Section> = (0..=count)
            .map(|k| {
                let t = self.end * (2.0 * k as f64 / count as f64 - 1.0);
                let out = Vec3::new(0.0, t.cos(), t.sin());
                let tangent = self.derivative(t) / self.speed();
                Section {
                    centre: self.at(t),
                    across: [out, tangent.cross(&out)],
                }
            })
            .collect();
        Some(open_tube(self.tube, &sections))
    }
}
