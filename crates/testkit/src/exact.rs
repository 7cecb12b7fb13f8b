//! Exact values with their accuracy and source; none comes from a finite-element code.
//!
//! Viscosity 1, forces on the fluid. "Spectral" are multipole expansions, carried to convergence in
//! two truncation orders and checked by a second method (bispherical coordinates or fundamental
//! solutions).

use std::f64::consts::PI;

use crate::bounds::within;

/// A number that is known.
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    /// The number.
    pub value: f64,
    /// Its relative accuracy.
    pub accuracy: f64,
    /// Where it comes from.
    pub source: &'static str,
}

impl Exact {
    const fn new(value: f64, accuracy: f64, source: &'static str) -> Self {
        Self {
            value,
            accuracy,
            source,
        }
    }

    /// Asserts that a number is within a bound, which is at least the accuracy of the exact one;
    /// returns the ratio.
    ///
    /// # Panics
    /// As [`within`].
    #[track_caller]
    pub fn check(&self, found: f64, bound: f64, why: &str) -> f64 {
        within(
            self.accuracy * self.value,
            bound,
            "accuracy of the exact value",
        );
        let why = format!("{why}; {found}, exact {} ({})", self.value, self.source);
        within(found - self.value, bound, why)
    }
}

/// Spectral values are integrated to this relative accuracy.
const SPECTRAL: f64 = 1e-12;

/// Net displacement of the stroke of [`crate::three_spheres`] in unbounded fluid.
pub const STROKE: Exact = Exact::new(0.1598053403881754, SPECTRAL, "spectral");

/// The same from the centre of a ball, by its radius.
pub const STROKE_IN_BALL: [(f64, Exact); 3] = [
    (25.0, Exact::new(0.15973257986289502, SPECTRAL, "spectral")),
    (40.0, Exact::new(0.1604180159643671, SPECTRAL, "spectral")),
    (80.0, Exact::new(0.15993017649902952, SPECTRAL, "spectral")),
];

/// The same from the centre of a ball of radius 40.
pub const STROKE_IN_BALL_40: Exact = STROKE_IN_BALL[1].1;

/// Displacements of the centre sphere of [`crate::three_spheres`] per phase by models of point
/// forces, from an independent program; the last phase is as the first, the third as the second.
pub const STEPS_OSEEN: [f64; 2] = [-1.353092738366866, 1.4391384581513114];
/// The same by the tensor of Rotne, Prager and Yamakawa.
pub const STEPS_RPY: [f64; 2] = [-1.3529873030998665, 1.435496826965346];
/// The same with all multipoles; bispherical series and collocation agree to 1e-12.
pub const STEPS: [f64; 2] = [-1.352634331801177, 1.4325370019952646];

/// Net displacement of the same stroke by point forces.
pub const STROKE_OSEEN: f64 = 0.1720914395688904;
/// Net displacement of the same stroke by the tensor of Rotne, Prager and Yamakawa.
pub const STROKE_RPY: f64 = 0.16501904773095988;

/// [`crate::three_spheres`] at the start, the left arm closing at unit rate: velocity of the centre
/// sphere and forces of all.
pub struct Instant {
    /// Velocity of the centre sphere along x.
    pub velocity: f64,
    /// Forces on the fluid along x.
    pub forces: [f64; 3],
}

/// In unbounded fluid; spectral.
pub const INSTANT: Instant = Instant {
    velocity: -0.34319851471562796,
    forces: [13.999647060443143, -7.6075823649615755, -6.39206469548157],
};

/// At the centre of a ball of radius 40; spectral.
pub const INSTANT_IN_BALL_40: Instant = Instant {
    velocity: -0.3428979021151601,
    forces: [14.122932964125914, -7.611261032148927, -6.5116719319769825],
};

/// Force over `6 pi U` of each of two unit spheres that approach each other, by the distance of
/// their centres (Stimson & Jeffery 1926, Maude 1961).
pub const OPPOSITE: [(f64, f64); 4] = [
    (3.0, 2.0386546439229005),
    (2.5, 2.772418679559134),
    (2.1, 7.413297606556761),
    (2.05, 12.71128816977892),
];

/// Drag over `6 pi` of a unit sphere at the centre of a ball of radius `1 / l` (Haberman & Sayre
/// 1958; Happel & Brenner 1983, 4-22).
pub fn concentric_drag(l: f64) -> f64 {
    (1.0 - l.powi(5)) / (1.0 - 2.25 * l + 2.5 * l.powi(3) - 2.25 * l.powi(5) + l.powi(6))
}

/// Torque over `8 pi` of a unit sphere that rotates at the centre of a ball of radius `1 / l`.
pub fn concentric_torque(l: f64) -> f64 {
    1.0 / (1.0 - l.powi(3))
}

/// Drag over `6 pi` of a unit sphere on the axis of a cylinder of radius 5 (Haberman & Sayre 1958,
/// by a collocation of their series).
pub const CYLINDER_5: Exact = Exact::new(1.679478884847892, 1e-9, "Haberman & Sayre 1958");

/// Drag over `6 pi` of a unit sphere that leaves a plane wall at a height of two.
pub const NORMAL_TO_WALL_2: Exact = Exact::new(2.1255355667600404, 1e-12, "Brenner 1961");

/// Height of a unit sphere above a plane wall; along the wall its drag over `6 pi`, its torque over
/// `8 pi` and their coupling over `8 pi` (Goldman, Cox & Brenner 1967; spectral).
pub const PARALLEL_TO_WALL: (f64, [f64; 3]) = (
    1.1,
    [2.264303035388026, 1.4548512100169821, -0.08876334417411287],
);

/// Displacement per cycle and work of Purcell's swimmer of three spheroids 2:1, as in the template.
pub const PURCELL: [Exact; 2] = {
    let source = "fundamental solutions on three levels";
    [
        Exact::new(-0.074_667, 1.4e-5, source),
        Exact::new(439.603, 3e-6, source),
    ]
};

/// A body with its drags over `6 pi` and torques over `8 pi` along its own axes.
pub struct Body {
    /// Keys of the scene file.
    pub keys: &'static str,
    /// Drags.
    pub drag: [f64; 3],
    /// Torques.
    pub torque: [f64; 3],
    /// Relative accuracy of these values.
    pub accuracy: f64,
}

/// Ellipsoids: Oberbeck 1876 and Jeffery 1922, `F_i = 16 pi U_i / (chi + a_i^2 alpha_i)` and
/// `T_1 = 16 pi (b^2 + c^2) omega_1 / (3 (b^2 beta + c^2 gamma))` with Carlson's integrals.
/// Capsules, 4 to 5 digits: ring Stokeslets on the surface, which meet the values of spheroids to
/// 1e-9.
pub const BODIES: [Body; 7] = [
    Body {
        keys: "shape = \"ellipsoid\", semi_axes = [2, 1, 1]",
        drag: [1.2039409898, 1.3788990569, 1.3788990569],
        torque: [1.6133533986, 3.0098524745, 3.0098524745],
        accuracy: 1e-9,
    },
    Body {
        keys: "shape = \"capsule\", radius = 1, half_length = 2",
        drag: [1.3153, 1.48523, 1.48523],
        torque: [2.0552, 3.7799, 3.7799],
        accuracy: 2e-4,
    },
    Body {
        keys: "shape = \"spheroid\", radius = 1, half_length = 10",
        drag: [2.6471360019, 3.8115284451, 3.8115284451],
        torque: [6.8047061205, 133.6803680980, 133.6803680980],
        accuracy: 1e-9,
    },
    Body {
        keys: "shape = \"spheroid\", radius = 1, half_length = 0.5",
        drag: [0.9053052615, 0.7927074276, 0.7927074276],
        torque: [0.7050201619, 0.5658157884, 0.5658157884],
        accuracy: 1e-9,
    },
    Body {
        keys: "shape = \"ellipsoid\", semi_axes = [3, 2, 1]",
        drag: [1.7942956646, 1.9415195515, 2.2048206919],
        torque: [6.0784308862, 10.0844494468, 10.5036820535],
        accuracy: 1e-9,
    },
    Body {
        keys: "shape = \"capsule\", radius = 1, half_length = 3",
        drag: [1.5783, 1.89624, 1.89624],
        torque: [3.0733, 9.2924, 9.2924],
        accuracy: 2e-4,
    },
    Body {
        keys: "shape = \"capsule\", radius = 1, half_length = 10",
        drag: [3.023, 4.2058, 4.2058],
        torque: [10.100, 176.14, 176.14],
        accuracy: 1e-3,
    },
];

/// Drag over `6 pi a` of a spheroid of aspect ratio 2 along its long semi-axis `a`.
pub const SPHEROID_2: Exact =
    Exact::new(0.6019704948941008, 1e-12, "Kim & Karrila 1991, table 3.4");

/// Velocity of a unit sphere at the centre of a ball of radius `1 / l` under a unit force, and its
/// angular velocity under a unit torque.
pub fn concentric_mobility(l: f64) -> [f64; 2] {
    [
        1.0 / (6.0 * PI * concentric_drag(l)),
        1.0 / (8.0 * PI * concentric_torque(l)),
    ]
}
