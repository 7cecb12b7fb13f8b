//! Waves that bend the centreline of a tube, with the material points that they move.

use std::f64::consts::TAU;

use mesher::{BentTube, Centreline, CurvePoint, TubePoint};
use nalgebra::Vector3;

use crate::words::{EnvelopeKind, WaveKind};

/// A wave along the centreline of a tube.
///
/// With the length of arc `s` from the front of the centreline, its length `L`, the wave number
/// `k = 2π n / L` for `n` waves, and the envelope `g = 1` or `g = s / L`, the amplitude `a` and the
/// phase `φ` give
///
/// ```text
/// curvature      θ' = a k g cos(k s - φ), with the angle θ between the tangent and the axis
/// displacement   y = (a / k) g sin(k s - φ) across the axis
/// helix          y = (a / k) g sin(k s - φ) and z = -(a / k) g cos(k s - φ)
/// left-helix     y = (a / k) g sin(k s - φ) and z =  (a / k) g cos(k s - φ)
/// ```
///
/// The curve does not stretch: the position along the axis is the integral of `√(1 - y'² - z'²)`,
/// zero in the middle of the curve. The tangent at the middle is along the axis for waves of
/// curvature. Waves travel from the front to the end while the phase increases. Cross-sections turn
/// with the tangent, by the rotation without twist from the axis to the tangent.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Wave {
    /// What the wave changes.
    pub kind: WaveKind,
    /// The amplitude along the length.
    pub envelope: EnvelopeKind,
    /// Number of waves `n` on the length.
    pub waves: f64,
}

/// A wave at an amplitude and a phase.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Bend {
    /// The wave.
    pub wave: Wave,
    /// Amplitude `a`: of the angle in radians, or of the slope `dy/ds`.
    pub amplitude: f64,
    /// Phase `φ` in radians.
    pub phase: f64,
}

/// The centreline of a tube, straight or bent by a wave, about the middle of the tube along x.
#[derive(Clone, Debug, PartialEq)]
pub struct BentLine {
    length: f64,
    bend: Option<Bend>,
    /// Points at equal intervals.
    nodes: Vec<Node>,
}

/// A tabulated point of a centreline.
#[derive(Clone, Debug, PartialEq)]
struct Node {
    /// The point, with its derivatives with respect to amplitude and phase.
    point: [Vector3<f64>; 3],
    /// The unit tangent and the curvature.
    derivatives: [Vector3<f64>; 2],
}

/// The tangent of a centreline at a point, and its derivatives.
struct Tangent {
    /// The unit tangent.
    at: Vector3<f64>,
    /// With respect to the length of arc.
    curvature: Vector3<f64>,
    /// With respect to the amplitude and to the phase.
    rates: [Vector3<f64>; 2],
}

/// Largest slope of a wave of displacement: the curve has to advance along its axis.
const MAX_SLOPE: f64 = 0.99;

/// Intervals of the table of a centreline per wave and radian of its amplitude, so that Gauss's
/// rule and Hermite's interpolation are exact to rounding for slopes that are not close to one.
///
/// The error of the latter is `(2π / 200)⁶ / 46080 = 2e-14` of a wave length times the sixth
/// derivative in wave numbers.
const INTERVALS_PER_WAVE: f64 = 200.0;

/// Largest number of intervals of the table of a centreline.
const MAX_INTERVALS: usize = 20_000;

/// Abscissae on [0, 1] and weights of Gauss's rule with three points.
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

impl Wave {
    /// Whether the wave bends the tube out of a plane.
    pub(crate) fn is_helical(&self) -> bool {
        matches!(self.kind, WaveKind::Helix | WaveKind::LeftHelix)
    }

    /// Wave number on a centreline of this length.
    fn number(&self, length: f64) -> f64 {
        TAU * self.waves / length
    }

    /// Largest distance of the middle of the centreline from the position of the body, for an
    /// amplitude of one.
    pub(crate) fn offset(&self, length: f64) -> f64 {
        match self.kind {
            WaveKind::Curvature => 0.0,
            _ => 1.0 / self.number(length),
        }
    }

    /// Largest speed of points of a centreline for a rate of one of the amplitude, and for a rate
    /// of one of the phase per amplitude.
    ///
    /// The tangent turns at most at the rate of the angle that the wave adds, over the distance
    /// from the middle; that of waves of curvature with the envelope `s / L` by `2 + 1 / k L`.
    pub(crate) fn speeds(&self, length: f64, amplitude: f64) -> [f64; 2] {
        let slope = match self.kind {
            WaveKind::Curvature => 2.0 + 1.0 / (TAU * self.waves),
            // The tangent turns by d asin(slope).
            _ => {
                let most = self.largest_slope(amplitude).min(MAX_SLOPE);
                (1.0 + 1.0 / (TAU * self.waves)) / (1.0 - most * most).sqrt()
            }
        };
        let speed = 0.5 * length * slope + self.offset(length);
        [speed, speed * amplitude.abs()]
    }

    /// Upper bounds of the rates of the curvature of a centreline for a rate of one of the
    /// amplitude, and of the phase, at amplitudes up to a size; none where the curve may not exist.
    ///
    /// The curvature of a wave of curvature is `a k g cos(k s - φ)`. That of one of displacement is
    /// `|(-p·p'/w, p')|` with the derivative `p = a f'` of the displacement and `w = √(1 - p²)`.
    pub(crate) fn curvature_rates(&self, length: f64, amplitude: f64) -> Option<[f64; 2]> {
        let k = self.number(length);
        if self.kind == WaveKind::Curvature {
            return Some([k, k * amplitude]);
        }
        let (slope, unit) = (self.largest_slope(amplitude), self.largest_slope(1.0));
        // up to the rounding of amplitudes
        let w = (slope <= MAX_SLOPE * (1.0 + 1e-9)).then(|| (1.0 - slope * slope).sqrt())?;
        // g f + 2 g' f' / k with the envelope g, whose derivative is at most 1 / L.
        let of_bend = match self.envelope {
            EnvelopeKind::Uniform => k,
            EnvelopeKind::Linear => k * (1.0 + 2.0 / (TAU * self.waves)),
        };
        let bend = amplitude * of_bend;
        let along = (unit * bend + slope * of_bend) / w + slope * slope * bend * unit / w.powi(3);
        let of_amplitude = of_bend + along;
        Some([of_amplitude, amplitude * of_amplitude])
    }

    /// Upper bound of the slope of a wave of displacement.
    fn largest_slope(&self, amplitude: f64) -> f64 {
        let of_envelope = match self.envelope {
            EnvelopeKind::Uniform => 1.0,
            EnvelopeKind::Linear => 1.0_f64.hypot(1.0 / (TAU * self.waves)),
        };
        amplitude.abs() * of_envelope
    }
}

impl Bend {
    /// What is impossible about the curve; `None` if it exists.
    pub(crate) fn problem(&self) -> Option<String> {
        if !(self.amplitude.is_finite() && self.phase.is_finite()) {
            return Some("has a wave of an amplitude or a phase that is not finite".to_owned());
        }
        let slope = match self.wave.kind {
            WaveKind::Curvature => return None,
            _ => self.wave.largest_slope(self.amplitude),
        };
        (slope > MAX_SLOPE).then(|| {
            format!(
                "would have to stretch: its wave has the slope {slope:.3}, at most {MAX_SLOPE} is \
                 possible; use a smaller amplitude, or a wave of curvature"
            )
        })
    }

    /// Envelope and its derivative with respect to the length of arc.
    fn envelope(&self, arc: f64, length: f64) -> [f64; 2] {
        match self.wave.envelope {
            EnvelopeKind::Uniform => [1.0, 0.0],
            EnvelopeKind::Linear => [arc / length, 1.0 / length],
        }
    }

    /// The angle of the tangent of a wave of curvature, with its derivatives with respect to the
    /// length of arc, the amplitude and the phase.
    fn angle(&self, arc: f64, length: f64) -> [f64; 4] {
        let k = self.wave.number(length);
        // ∫ k g cos(k s - φ) ds and its derivative with respect to φ
        let primitive = |arc: f64| {
            let (sin, cos) = (k * arc - self.phase).sin_cos();
            match self.wave.envelope {
                EnvelopeKind::Uniform => [sin, -cos],
                EnvelopeKind::Linear => [
                    (arc * sin + cos / k) / length,
                    (sin / k - arc * cos) / length,
                ],
            }
        };
        let [here, middle] = [arc, 0.5 * length].map(primitive);
        let [g, _] = self.envelope(arc, length);
        let of_amplitude = here[0] - middle[0];
        [
            self.amplitude * of_amplitude,
            self.amplitude * k * g * (k * arc - self.phase).cos(),
            of_amplitude,
            self.amplitude * (here[1] - middle[1]),
        ]
    }

    /// The displacement `(y, z)` across the axis divided by `a`, then its first derivatives with
    /// respect to the length of arc and to the phase, its second derivative with respect to the
    /// length of arc and its mixed one.
    fn displacement(&self, arc: f64, length: f64) -> [[f64; 2]; 5] {
        let k = self.wave.number(length);
        let [g, slope] = self.envelope(arc, length);
        let (sin, cos) = (k * arc - self.phase).sin_cos();
        // d/ds and d/dφ of g sin, of -g cos and of g cos
        let of = |f: f64, df: f64| {
            [
                g * f / k,
                slope * f / k + g * df,
                -g * df / k,
                2.0 * slope * df - g * k * f,
                g * f - slope * df / k,
            ]
        };
        let y = of(sin, cos);
        let z = match self.wave.kind {
            WaveKind::Helix => of(-cos, sin),
            WaveKind::LeftHelix => of(cos, -sin),
            WaveKind::Curvature | WaveKind::Displacement => [0.0; 5],
        };
        std::array::from_fn(|part| [y[part], z[part]])
    }

    /// The unit tangent.
    fn direction(&self, arc: f64, length: f64) -> Vector3<f64> {
        if self.wave.kind == WaveKind::Curvature {
            let (sin, cos) = self.angle(arc, length)[0].sin_cos();
            return Vector3::new(cos, sin, 0.0);
        }
        let [y, z] = self.displacement(arc, length)[1];
        let across = self.amplitude * Vector3::new(0.0, y, z);
        across + Vector3::x() * (1.0 - across.norm_squared()).max(0.0).sqrt()
    }

    /// The unit tangent with its derivatives.
    fn tangent(&self, arc: f64, length: f64) -> Tangent {
        if self.wave.kind == WaveKind::Curvature {
            let [angle, slope, of_amplitude, of_phase] = self.angle(arc, length);
            let (sin, cos) = angle.sin_cos();
            let normal = Vector3::new(-sin, cos, 0.0);
            return Tangent {
                at: Vector3::new(cos, sin, 0.0),
                curvature: slope * normal,
                rates: [of_amplitude * normal, of_phase * normal],
            };
        }
        let [_, first, _, second, mixed] = self.displacement(arc, length);
        let a = self.amplitude;
        let across = |[y, z]: [f64; 2]| Vector3::new(0.0, y, z);
        let at = self.direction(arc, length);
        let along = at.x;
        // The tangent stays a unit vector.
        let turning = |across: Vector3<f64>| across - Vector3::x() * (at.dot(&across) / along);
        Tangent {
            at,
            curvature: turning(a * across(second)),
            rates: [turning(across(first)), turning(a * across(mixed))],
        }
    }

    /// The middle of the curve, with its derivatives.
    fn middle(&self, length: f64) -> [Vector3<f64>; 3] {
        if self.wave.kind == WaveKind::Curvature {
            return [Vector3::zeros(); 3];
        }
        let [at, _, of_phase, ..] = self.displacement(0.5 * length, length);
        let across = |[y, z]: [f64; 2]| Vector3::new(0.0, y, z);
        let a = self.amplitude;
        [a * across(at), across(at), a * across(of_phase)]
    }
}

impl BentLine {
    /// A centreline of this length.
    pub fn new(length: f64, bend: Option<Bend>) -> Self {
        let mut line = Self {
            length,
            bend,
            nodes: Vec::new(),
        };
        let Some(bend) = bend else {
            return line;
        };
        let turns = line.parts() / TAU;
        let half = (0.5 * INTERVALS_PER_WAVE * turns).ceil() as usize;
        let half = half.clamp(8, MAX_INTERVALS / 2);
        let step = 0.5 * length / half as f64;
        let node = |k: usize, point: [Vector3<f64>; 3]| {
            let tangent = bend.tangent(k as f64 * step, length);
            Node {
                point,
                derivatives: [tangent.at, tangent.curvature],
            }
        };
        let mut nodes = vec![node(0, [Vector3::zeros(); 3])];
        for k in 0..2 * half {
            let part = line.integral(&bend, k as f64 * step, step);
            let last = nodes[k].point;
            nodes.push(node(
                k + 1,
                [0, 1, 2].map(|column| last[column] + part[column]),
            ));
        }
        let (at_middle, middle) = (nodes[half].point, bend.middle(length));
        for node in &mut nodes {
            for column in 0..3 {
                node.point[column] += middle[column] - at_middle[column];
            }
        }
        line.nodes = nodes;
        line
    }

    /// Integrals of the tangent and of its derivatives over a part of the curve.
    fn integral(&self, bend: &Bend, from: f64, width: f64) -> [Vector3<f64>; 3] {
        let mut sums = [Vector3::zeros(); 3];
        for (abscissa, weight) in GAUSS {
            let tangent = bend.tangent(from + abscissa * width, self.length);
            let [of_amplitude, of_phase] = tangent.rates;
            for (sum, value) in sums.iter_mut().zip([tangent.at, of_amplitude, of_phase]) {
                *sum += weight * width * value;
            }
        }
        sums
    }

    /// Distance between nodes.
    fn step(&self) -> f64 {
        self.length / (self.nodes.len() - 1) as f64
    }

    /// Number of the last node before a length of arc, and its own length of arc.
    fn node(&self, arc: f64) -> (usize, f64) {
        let step = self.step();
        let node = ((arc / step).max(0.0) as usize).min(self.nodes.len() - 2);
        (node, node as f64 * step)
    }

    /// The point at a length of arc, by Hermite's interpolation of fifth degree between points,
    /// tangents and curvatures.
    fn interpolated(&self, arc: f64) -> Vector3<f64> {
        let (node, from) = self.node(arc);
        let step = self.step();
        let x = (arc - from) / step;
        // From an end, for the variable that is zero at the other one.
        let basis = |x: f64| {
            let cube = x.powi(3);
            [
                cube * (10.0 - 15.0 * x + 6.0 * x * x),
                cube * (-4.0 + 7.0 * x - 3.0 * x * x),
                0.5 * cube * (1.0 - 2.0 * x + x * x),
            ]
        };
        let end = |node: &Node, [value, slope, curve]: [f64; 3], sign: f64| {
            let [tangent, curvature] = &node.derivatives;
            value * node.point[0] + step * (sign * slope * tangent + step * curve * curvature)
        };
        end(&self.nodes[node], basis(1.0 - x), -1.0) + end(&self.nodes[node + 1], basis(x), 1.0)
    }

    /// The point at a length of arc, with its derivatives with respect to amplitude and phase.
    fn point(&self, bend: &Bend, arc: f64) -> [Vector3<f64>; 3] {
        let (node, from) = self.node(arc);
        let part = self.integral(bend, from, arc - from);
        [0, 1, 2].map(|column| self.nodes[node].point[column] + part[column])
    }

    /// Unit vectors across a tangent: the y and z axes, turned from x to it without twist.
    ///
    /// With `h = (e_x + t) / (1 + t_x)` they are `e_y - t_y h` and `e_z - t_z h`. A plane curve
    /// keeps z, wherever its tangent points.
    fn across(&self, bend: &Bend, tangent: &Vector3<f64>) -> [Vector3<f64>; 2] {
        if !bend.wave.is_helical() {
            return [Vector3::new(-tangent.y, tangent.x, 0.0), Vector3::z()];
        }
        let half = (Vector3::x() + tangent) / (1.0 + tangent.x);
        [
            Vector3::y() - tangent.y * half,
            Vector3::z() - tangent.z * half,
        ]
    }

    /// Derivatives of the unit vectors across for a rate of the tangent.
    fn across_rates(
        &self,
        bend: &Bend,
        tangent: &Vector3<f64>,
        rate: &Vector3<f64>,
    ) -> [Vector3<f64>; 2] {
        if !bend.wave.is_helical() {
            return [Vector3::new(-rate.y, rate.x, 0.0), Vector3::zeros()];
        }
        let half = (Vector3::x() + tangent) / (1.0 + tangent.x);
        let of_half = (rate - rate.x * half) / (1.0 + tangent.x);
        [
            -rate.y * half - tangent.y * of_half,
            -rate.z * half - tangent.z * of_half,
        ]
    }

    /// Velocities of a material point for a rate of one of the amplitude, and of the phase.
    ///
    /// Beyond the ends of the curve points move with the ends.
    pub(crate) fn velocities(&self, at: &TubePoint) -> [Vector3<f64>; 2] {
        let Some(bend) = &self.bend else {
            return [Vector3::zeros(); 2];
        };
        let arc = at.arc.clamp(0.0, self.length);
        let [_, of_amplitude, of_phase] = self.point(bend, arc);
        let tangent = bend.tangent(arc, self.length);
        let velocity = |(of_point, rate): (Vector3<f64>, &Vector3<f64>)| {
            let [one, other] = self.across_rates(bend, &tangent.at, rate);
            of_point + (at.arc - arc) * rate + at.across[0] * one + at.across[1] * other
        };
        let [first, second] = &tangent.rates;
        [(of_amplitude, first), (of_phase, second)].map(velocity)
    }
}

impl Centreline for BentLine {
    fn length(&self) -> f64 {
        self.length
    }

    fn parts(&self) -> f64 {
        self.bend.as_ref().map_or(0.0, |bend| {
            // Slopes turn the tangent at most by three times the angle of a sine of one.
            TAU * bend.wave.waves * bend.amplitude.abs().max(1.0)
        })
    }

    fn at(&self, arc: f64) -> CurvePoint {
        let Some(bend) = &self.bend else {
            return CurvePoint {
                point: Vector3::x() * (arc - 0.5 * self.length),
                axes: [Vector3::x(), Vector3::y(), Vector3::z()],
                curvature: Vector3::zeros(),
            };
        };
        let tangent = bend.tangent(arc, self.length);
        let [one, other] = self.across(bend, &tangent.at);
        CurvePoint {
            point: self.interpolated(arc),
            axes: [tangent.at, one, other],
            curvature: tangent.curvature,
        }
    }
}

/// A tube whose centreline a wave may bend.
pub(crate) type WaveTube = BentTube<BentLine>;

#[cfg(test)]
mod tests {
    use super::*;
    use mesher::{Helix, TubeProfile};

    const KINDS: [WaveKind; 4] = [
        WaveKind::Curvature,
        WaveKind::Displacement,
        WaveKind::Helix,
        WaveKind::LeftHelix,
    ];

    fn bend(kind: WaveKind, envelope: EnvelopeKind, amplitude: f64, phase: f64) -> Bend {
        Bend {
            wave: Wave {
                kind,
                envelope,
                waves: 1.3,
            },
            amplitude,
            phase,
        }
    }

    fn tube(bend: Bend) -> WaveTube {
        let length = 10.0;
        let profile = TubeProfile::new(length, [0.3, 0.2], Some(0.7));
        BentTube::new(BentLine::new(length, Some(bend)), profile)
    }

    /// The curve is the integral of its tangent, the axes are orthonormal, the curvature is the
    /// derivative of the tangent: by differences of fourth order, whose error is
    /// h⁴ f⁽⁵⁾ / 30 = 1e-11.
    #[test]
    fn curves_do_not_stretch_and_frames_are_orthonormal() {
        let h = 2e-3;
        for kind in KINDS {
            for envelope in [EnvelopeKind::Uniform, EnvelopeKind::Linear] {
                let line = BentLine::new(10.0, Some(bend(kind, envelope, 0.7, 0.4)));
                for arc in [0.3, 2.0, 5.0, 7.7] {
                    let here = line.at(arc);
                    let difference = |of: &dyn Fn(f64) -> Vector3<f64>| {
                        (8.0 * (of(arc + h) - of(arc - h)) - of(arc + 2.0 * h) + of(arc - 2.0 * h))
                            / (12.0 * h)
                    };
                    let tangent = difference(&|s| line.at(s).point);
                    assert!((tangent - here.axes[0]).norm() < 1e-10);
                    let curvature = difference(&|s| line.at(s).axes[0]);
                    assert!((curvature - here.curvature).norm() < 1e-10);
                    let frame = nalgebra::Matrix3::from_columns(&here.axes);
                    assert!(
                        (frame.transpose() * frame - nalgebra::Matrix3::identity()).norm() < 1e-14
                    );
                    assert!((frame.determinant() - 1.0).abs() < 1e-14);
                }
            }
        }
    }

    /// Velocities are derivatives of positions, by differences of fourth order.
    #[test]
    fn velocities_are_derivatives_of_positions() {
        let h = 1e-3;
        for kind in KINDS {
            for envelope in [EnvelopeKind::Uniform, EnvelopeKind::Linear] {
                for arc in [-1.0, 0.0, 3.1, 9.4, 10.1] {
                    let at = TubePoint {
                        arc,
                        across: [0.2, -0.1],
                    };
                    let point = |da: f64, dp: f64| {
                        tube(bend(kind, envelope, 0.6 + da, 0.4 + dp)).point(&at)
                    };
                    let difference = |of: &dyn Fn(f64) -> Vector3<f64>| {
                        (8.0 * (of(h) - of(-h)) - of(2.0 * h) + of(-2.0 * h)) / (12.0 * h)
                    };
                    let own = tube(bend(kind, envelope, 0.6, 0.4));
                    let [of_amplitude, of_phase] = own.curve().velocities(&at);
                    assert!((difference(&|x| point(x, 0.0)) - of_amplitude).norm() < 1e-9);
                    assert!((difference(&|x| point(0.0, x)) - of_phase).norm() < 1e-9);
                    let [amplitude, phase] = bend(kind, envelope, 0.6, 0.4).wave.speeds(10.0, 0.6);
                    // Across the tube and beyond its end the turn of the tangent moves points.
                    assert!(of_amplitude.norm() < 1.5 * amplitude && of_phase.norm() < 1.5 * phase);
                }
            }
        }
    }

    /// A helical wave of a constant amplitude is the tube along a helix about x, with the pitch
    /// `2π √(1 - a²) / k` and the radius `a / k`; a phase turns it about the axis.
    #[test]
    fn helical_waves_are_helices() {
        let (length, waves, slope) = (10.0, 1.3, 0.6_f64);
        let k = TAU * waves / length;
        let wave = |phase: f64| {
            let bend = bend(WaveKind::Helix, EnvelopeKind::Uniform, slope, phase);
            let line = BentLine::new(length, Some(bend));
            BentTube::new(line, TubeProfile::new(length, [0.3, 0.3], None))
        };
        let advance = (1.0 - slope * slope).sqrt();
        let helix = Helix::new(slope / k, advance * TAU / k, waves, 0.3);
        use mesh::Surface;
        for phase in [0.0, 1.0, 4.0] {
            let tube = wave(phase);
            assert!((tube.volume() / helix.volume() - 1.0).abs() < 1e-13);
            // The middle of the wave is at the angle k L / 2 - φ - 90 degrees from y.
            let angle = 0.5 * k * length - phase - std::f64::consts::FRAC_PI_2;
            let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::x_axis(), angle);
            for x in [
                Vector3::new(0.3, 1.4, 0.2),
                Vector3::new(-3.0, 0.1, -1.0),
                Vector3::new(6.0, -0.3, 0.4),
            ] {
                let expected = turn * helix.closest_point(x);
                assert!((tube.closest_point(turn * x) - expected).norm() < 1e-9);
            }
        }
    }

    /// A left-handed helix is the mirror image of the right-handed one in the plane `z = 0`, with
    /// the velocities of its material points.
    #[test]
    fn left_helices_are_mirror_images() {
        let mirror = |x: Vector3<f64>| Vector3::new(x.x, x.y, -x.z);
        for envelope in [EnvelopeKind::Uniform, EnvelopeKind::Linear] {
            let [right, left] = [WaveKind::Helix, WaveKind::LeftHelix]
                .map(|kind| tube(bend(kind, envelope, 0.6, 0.4)));
            for arc in [-1.0, 0.0, 3.1, 9.4, 10.1] {
                let [at, mirrored] = [-0.1, 0.1].map(|z| TubePoint {
                    arc,
                    across: [0.2, z],
                });
                assert!((left.point(&mirrored) - mirror(right.point(&at))).norm() < 1e-14);
                let [own, other] = [
                    left.curve().velocities(&mirrored),
                    right.curve().velocities(&at),
                ];
                for (own, other) in own.into_iter().zip(other) {
                    assert!((own - mirror(other)).norm() < 1e-13);
                }
            }
        }
    }

    /// The phase of a helical wave turns the helix about -x, while cross-sections roll about the
    /// tangent: `∂X/∂φ = -e_x × X + t × ρ` with the arm `ρ` from the centreline.
    #[test]
    fn phases_of_helical_waves_are_rotations_of_the_helix_and_rolling() {
        let tube = tube(bend(WaveKind::Helix, EnvelopeKind::Uniform, 0.6, 0.4));
        for arc in [-1.0, 0.0, 3.1, 9.4, 10.1] {
            let at = TubePoint {
                arc,
                across: [0.2, -0.1],
            };
            let [_, velocity] = tube.curve().velocities(&at);
            let CurvePoint { point, axes, .. } = tube.curve().extended(arc);
            let x = tube.point(&at);
            let expected = (x - point).cross(&axes[0]) + Vector3::x().cross(&x);
            assert!((velocity + expected).norm() < 1e-12);
        }
    }

    #[test]
    fn bent_tubes_pass_the_checks_of_surfaces() {
        for kind in KINDS {
            let tube = tube(bend(kind, EnvelopeKind::Linear, 0.8, 2.0));
            use mesh::Surface;
            assert!(tube.reach() > 0.1);
            mesh::check_surface(&tube).unwrap();
        }
    }
}
