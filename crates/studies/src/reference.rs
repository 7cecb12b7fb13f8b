//! Exact values with their sources; none comes from a finite-element code.
//!
//! Viscosity 1. Forces are those that bodies exert on the fluid. "Spectral" values are from
//! multipole expansions, carried to convergence in two truncation orders (changes below 1e-12) and
//! checked by a second, independent method each (bispherical coordinates or fundamental solutions,
//! agreement to 1e-12).

use std::f64::consts::PI;

/// Drag of a unit sphere at the centre of a ball of radius `1 / lambda`, over `6 pi`.
///
/// ```text
/// K = (1 - lambda^5) / (1 - 9/4 lambda + 5/2 lambda^3 - 9/4 lambda^5 + lambda^6)
/// ```
///
/// Source: Haberman & Sayre 1958; Happel & Brenner 1983, 4-22.
pub fn concentric_drag(lambda: f64) -> f64 {
    let l = |power| lambda.powi(power);
    (1.0 - l(5)) / (1.0 - 2.25 * l(1) + 2.5 * l(3) - 2.25 * l(5) + l(6))
}

/// Torque on a unit sphere that rotates at the centre of a ball of radius `1 / lambda`, over
/// `8 pi`.
///
/// It is `1 / (1 - lambda^3)`.
pub fn concentric_torque(lambda: f64) -> f64 {
    1.0 / (1.0 - lambda.powi(3))
}

/// Spheres on a diameter of a ball with no slip, and their exact axial resistance matrix.
pub struct Collinear {
    pub name: &'static str,
    pub container: f64,
    pub positions: &'static [f64],
    pub radii: &'static [f64],
    /// Upper triangle by rows: force on the fluid of sphere `i` for unit velocity of sphere `j`.
    pub resistance: &'static [f64],
}

/// Spectral values.
#[rustfmt::skip]
pub const COLLINEAR: [Collinear; 6] = [
    Collinear { name: "1 eccentric, z=4 b=10", container: 10.0, positions: &[4.0], radii: &[1.0],
        resistance: &[25.59443285590934] },
    Collinear { name: "1 eccentric, z=2 b=5", container: 5.0, positions: &[2.0], radii: &[1.0],
        resistance: &[37.96695415767978] },
    Collinear { name: "2, b=8", container: 8.0, positions: &[-3.0, 2.0], radii: &[1.0, 1.0],
        resistance: &[28.053090742016554, -2.5710663381106063, 27.052609255108717] },
    Collinear { name: "3 L=10, b=40", container: 40.0,
        positions: &[-10.0, 0.0, 10.0], radii: &[1.0, 1.0, 1.0],
        resistance: &[20.267463367404837, -1.9809051103556108, -0.36714152869806327,
            20.381729640056037, -1.9809051103556188, 20.267463367404837] },
    Collinear { name: "3 6,10, b=25", container: 25.0,
        positions: &[-6.0, 0.0, 10.0], radii: &[1.0, 1.0, 1.0],
        resistance: &[21.54914308019031, -3.7152230485764695, -0.25636053674461917,
            21.52396669750794, -1.4440802655643519, 21.22086203552462] },
    Collinear { name: "3 unequal, b=12", container: 12.0,
        positions: &[-5.0, 1.0, 6.0], radii: &[1.0, 1.5, 0.7],
        resistance: &[24.878061711608638, -3.983214481689879, 0.004052731170952731,
            40.92828880750805, -3.713430263928663, 16.49840851801843] },
];

/// Resistance function `X^A` of prolate spheroids, by aspect ratio.
///
/// The drag along the long semi-axis `a` is `6 pi a X^A U` (Kim & Karrila 1991, table 3.4).
pub const SPHEROIDS: [(f64, f64); 2] = [(2.0, 0.6019704948941008), (4.0, 0.3994857190933892)];

/// Drag over `6 pi` of a unit sphere on the axis of an infinite cylinder of radius `1 / lambda`.
///
/// The fluid is at rest far away. Source: series of Haberman & Sayre 1958, summed until two orders
/// and two quadratures agree to 1e-9.
pub const CYLINDER: [(f64, f64); 5] = [
    (0.1, 1.2632139052745492),
    (0.2, 1.679478884847892),
    (0.3, 2.370094890162442),
    (0.4, 3.5913732679723487),
    (0.5, 5.947374245718559),
];

/// Force over `6 pi U` on each of two unit spheres that approach each other at speed `U`, by
/// distance.
///
/// They move along their line of centres in unbounded fluid; the distance is that of the centres
/// (Stimson & Jeffery 1926, Maude 1961; spectral).
pub const OPPOSITE_MOTION: [(f64, f64); 6] = [
    (6.0, 1.330153663951659),
    (4.0, 1.5966819994959558),
    (3.0, 2.0386546439229005),
    (2.5, 2.772418679559134),
    (2.1, 7.413297606556761),
    (2.05, 12.71128816977892),
];

/// The three-sphere swimmer in one configuration, its middle sphere at the centre of a ball of
/// radius 40.
pub struct Instantaneous {
    /// Lengths of the left and right arm, and their rates.
    pub arms: [f64; 2],
    pub rates: [f64; 2],
    pub centre_velocity: f64,
    /// Forces on the fluid of the left, centre and right sphere.
    pub forces: [f64; 3],
}

/// Spectral values for spheres of radius 1 in a ball of radius 40.
#[rustfmt::skip]
pub const INSTANTANEOUS: [Instantaneous; 6] = [
    Instantaneous { arms: [10.0, 10.0], rates: [-1.0, 0.0], centre_velocity: -0.3428979021151601,
        forces: [14.122932964125914, -7.611261032148927, -6.5116719319769825] },
    Instantaneous { arms: [8.0, 10.0], rates: [-1.0, 0.0], centre_velocity: -0.33804651789074397,
        forces: [14.620217407602777, -8.130806745333922, -6.489410662268859] },
    Instantaneous { arms: [6.0, 10.0], rates: [0.0, -1.0], centre_velocity: 0.3634674179357112,
        forces: [6.4367886755854355, 7.358977854148839, -13.795766529734276] },
    Instantaneous { arms: [6.0, 8.0], rates: [0.0, -1.0], centre_velocity: 0.358597994193361,
        forces: [6.458385173596508, 7.86264482544764, -14.321029999044146] },
    Instantaneous { arms: [6.0, 6.0], rates: [1.0, 0.0], centre_velocity: 0.3511556949452645,
        forces: [-15.298791107588272, 8.83264317277649, 6.4661479348117865] },
    Instantaneous { arms: [10.0, 6.0], rates: [0.0, 1.0], centre_velocity: -0.3307339235651207,
        forces: [-6.436788675585434, -9.121051839831152, 15.557840515416586] },
];

/// Displacement of the middle sphere over a stroke with arms between 10 and 6.
///
/// The left arm closes, the right arm closes, the left arm opens, the right arm opens. The sphere
/// starts at the centre of a ball with no slip (Najafi & Golestanian 2004; spectral).
pub struct Stroke {
    pub container: f64,
    pub steps: [f64; 4],
    pub net: f64,
}

/// Spectral values, integrated to 1e-12.
#[rustfmt::skip]
pub const STROKES: [Stroke; 3] = [
    Stroke { container: 40.0, net: 0.1604180159643671, steps: [
        -1.3514957251156743, 1.4319139911681296, 1.431724700935812, -1.3517249510239002] },
    Stroke { container: 25.0, net: 0.15973257986289502, steps: [
        -1.3503610879624253, 1.4311851768098243, 1.4303415382500426, -1.3514330472345466] },
    Stroke { container: 80.0, net: 0.15993017649902952, steps: [
        -1.352450464277675, 1.4324404989928332, 1.4324177099533573, -1.352477568169486] },
];

/// Net displacement in unbounded fluid of the stroke of three spheres with these open and closed
/// arms; spectral, integrated to 1e-12.
pub const UNBOUNDED_STROKES: [(f64, f64, f64); 3] = [
    (10.0, 6.0, 0.1598053403881754),
    (5.0, 3.0, 0.13218996848920106),
    (4.0, 2.5, 0.09692485291674591),
];

/// Force over `6 pi U` on each of two unit spheres that move together along their line of centres,
/// by distance; spectral.
pub const COMMON_MOTION: [(f64, f64); 2] = [(3.0, 0.6983045602500371), (2.1, 0.6509001445148839)];

/// Height of a unit sphere above a plane wall, and its drag over `6 pi` normal to the wall (Brenner
/// 1961).
pub const NORMAL_TO_WALL: (f64, f64) = (1.5, 3.2053903153526253);

/// Height of a unit sphere above a plane wall; along the wall its drag over `6 pi`, its torque over
/// `8 pi` and their coupling over `8 pi` (Goldman, Cox & Brenner 1967; spectral).
pub const PARALLEL_TO_WALL: (f64, [f64; 3]) = (
    1.1,
    [2.264303035388026, 1.4548512100169821, -0.08876334417411287],
);

/// Net displacement of stars of three or four spheres with arms between 6 and 4, of which two move.
///
/// Collocation and fundamental solutions agree to 1e-11.
#[rustfmt::skip]
pub const STARS: [(&str, &str, [f64; 3]); 4] = [
    ("planar", "clamped", [0.004791832418980625, -0.0026805960395928506, 0.0]),
    ("planar", "free", [0.004667202336353144, -0.002607693358089058, 0.0]),
    ("tetrahedral", "clamped",
        [7.608613702185518e-05, 0.0045765204228767975, 0.004576520422876715]),
    ("tetrahedral", "free", [7.758427939318449e-05, 0.0044049086287823325, 0.004404908628781979]),
];

/// Displacement per cycle of three spheres with one driven and one elastic arm of length 10, for an
/// amplitude and a frequency over `k / G22`: exact multipoles, harmonic balance with 64 points.
pub const ELASTIC_ARMS: [(f64, f64, f64); 4] = [
    (1.0, 0.1, 0.000_866_135_0),
    (1.0, 1.0, 0.004_376_372_2),
    (1.0, 10.0, 0.000_867_111_2),
    (4.0, 1.0, 0.074_714_864_8),
];

/// Displacement and work of a gait.
pub struct NetAndWork {
    pub net: f64,
    pub work: f64,
    /// Relative uncertainty of both.
    pub accuracy: f64,
}

/// Purcell's swimmer of three spheroids 2:1 and angles of 30 degrees, as in the template: the
/// method of fundamental solutions on three levels.
pub const PURCELL: NetAndWork = NetAndWork {
    net: -0.074_667,
    work: 439.603,
    accuracy: 1.4e-5,
};

/// A shape with its drags over `6 pi` and torques over `8 pi` along its own axes.
pub struct ShapeResistance {
    pub name: &'static str,
    /// Keys of the scene file.
    pub keys: &'static str,
    pub drag: [f64; 3],
    pub torque: [f64; 3],
    /// Relative uncertainty of these values.
    pub accuracy: f64,
}

/// Ellipsoids: Oberbeck 1876 and Jeffery 1922, with Carlson's integrals. Capsules, four to five
/// digits: ring Stokeslets on the surface, which meet the values of spheroids to 1e-9.
#[rustfmt::skip]
pub const SHAPES: [ShapeResistance; 7] = [
    ShapeResistance { name: "ellipsoid 2:1:1", accuracy: 1e-9, keys: "shape = \"ellipsoid\"\nsemi_axes = [2, 1, 1]",
        drag: [1.2039409898, 1.3788990569, 1.3788990569], torque: [1.6133533986, 3.0098524745, 3.0098524745] },
    ShapeResistance { name: "capsule 2:1", accuracy: 1e-4, keys: "shape = \"capsule\"\nradius = 1\nhalf_length = 2",
        drag: [1.3153, 1.48523, 1.48523], torque: [2.0552, 3.7799, 3.7799] },
    ShapeResistance { name: "capsule 3:1", accuracy: 1e-4, keys: "shape = \"capsule\"\nradius = 1\nhalf_length = 3",
        drag: [1.5783, 1.89624, 1.89624], torque: [3.0733, 9.2924, 9.2924] },
    ShapeResistance { name: "spheroid 1:2", accuracy: 1e-9, keys: "shape = \"spheroid\"\nradius = 1\nhalf_length = 0.5",
        drag: [0.9053052615, 0.7927074276, 0.7927074276], torque: [0.7050201619, 0.5658157884, 0.5658157884] },
    ShapeResistance { name: "ellipsoid 3:2:1", accuracy: 1e-9, keys: "shape = \"ellipsoid\"\nsemi_axes = [3, 2, 1]",
        drag: [1.7942956646, 1.9415195515, 2.2048206919], torque: [6.0784308862, 10.0844494468, 10.5036820535] },
    ShapeResistance { name: "capsule 10:1", accuracy: 2e-4, keys: "shape = \"capsule\"\nradius = 1\nhalf_length = 10",
        drag: [3.023, 4.2058, 4.2058], torque: [10.1, 176.14, 176.14] },
    ShapeResistance { name: "spheroid 10:1", accuracy: 1e-9, keys: "shape = \"spheroid\"\nradius = 1\nhalf_length = 10",
        drag: [2.6471360019, 3.8115284451, 3.8115284451], torque: [6.8047061205, 133.6803680980, 133.6803680980] },
];

/// Drags over `6 pi` along the axis of the spheroids inside and around a rounded disk of radius 1
/// and half the thickness 0.1.
///
/// The drag of a body is at most that of a body around it (Hill & Power 1956). The spheroid with
/// the semi-axes 1 and 0.1 is inside the disk, that with 1.01 and 0.25758 around it; a disk without
/// thickness has 8 / (3 pi) = 0.8488.
pub const DISK_DRAGS: [f64; 2] = [0.852_450_555, 0.876_660_926];

/// Drag over `6 pi` of a slender torus of radius 1 along its axis, and its relative uncertainty.
///
/// `8 pi^2 / (ln(8 / k) + 1/2)` for the ratio `k` of the radii, up to a relative error of the order
/// `k^2 ln(8 / k)` (Johnson & Wu 1979).
pub fn torus_drag(ratio: f64) -> (f64, f64) {
    let logarithm = (8.0 / ratio).ln();
    let drag = 8.0 * PI * PI / (logarithm + 0.5) / (6.0 * PI);
    (drag, ratio * ratio * logarithm)
}

/// Reynolds number `2 a U / ν` and force over `6 π μ a U` of a fixed sphere of radius 1 in the
/// uniform stream `U` on a concentric ball of radius 10.
///
/// Steady Navier-Stokes flow by a spectral Galerkin method in the meridian plane, two resolutions.
pub const HELD_SPHERE: [(f64, f64); 4] = [
    (1.0, 1.312596826),
    (5.0, 1.579442824),
    (10.0, 1.875208422),
    (20.0, 2.34372910),
];

/// `β`, the Reynolds number `a U_0 / ν` with `U_0 = 2 B_1 / 3`, and speed over `U_0` of squirmers
/// with the surface velocity `B_1 (sin θ + β sin θ cos θ)` at the centre of a ball of radius 10
/// that moves along.
///
/// By the method of [`HELD_SPHERE`]. The speed for `β = 0` does not depend on the Reynolds number:
/// the Stokes flow, uniform with a dipole and Hill's vortex, solves the Navier-Stokes equations.
pub const STEADY_SQUIRMERS: [(f64, f64, f64); 9] = [
    (0.0, 0.1, 0.9975249752),
    (0.0, 10.0, 0.9975249752),
    (1.0, 1.0, 0.9294286562),
    (1.0, 5.0, 0.8841824644),
    (3.0, 0.1, 0.9697853875),
    (3.0, 1.0, 0.8284492722),
    (3.0, 5.0, 0.7955660509),
    (-3.0, 0.1, 1.0276845925),
    (-3.0, 1.0, 1.2899256442),
];

/// Times and speeds of a sphere of radius 1 and density 2 that a force of `6 π` moves from rest, in
/// fluid of density 1 in a ball of radius 10; small displacements.
///
/// By Laplace inversion of the exact impedance.
pub const RELEASED_SPHERE: [(f64, f64); 5] = [
    (0.1, 0.1159380123),
    (0.5, 0.3412379413),
    (1.0, 0.4744134599),
    (2.0, 0.6014484922),
    (5.0, 0.7239314716),
];

/// Density and viscosity of the fluid, time of the fall that is computed, and largest speed of a
/// sphere of 15 mm that falls in a box; in millimetres, seconds and grams.
///
/// ten Cate, Nieuwstad, Derksen & Van den Akker 2002, cases E1 to E4: speeds are 0.947, 0.953,
/// 0.959 and 0.955 times that in unbounded fluid by the correlation of Abraham (1970), as measured,
/// and 0.894, 0.950, 0.955 and 0.947 times it by their lattice-Boltzmann simulations in the same
/// box. In E1 both differ by 6 %, and the simulation is taken: 36.3 mm/s were measured. In the
/// others it is the measurement.
pub const FALLING_SPHERES: [(&str, f64, f64, f64, f64); 4] = [
    ("Re = 1.5 (simulated)", 9.70e-4, 0.373, 2.4, 34.23),
    ("Re = 4.1 (measured)", 9.65e-4, 0.212, 1.7, 57.1),
    ("Re = 11.6 (measured)", 9.62e-4, 0.113, 1.3, 86.9),
    ("Re = 31.9 (measured)", 9.60e-4, 0.058, 1.1, 122.6),
];

/// Index, relaxation time, viscosity at infinite shear rate of a fluid of Carreau with the
/// viscosity 1 at rest, Stokes drags `F / 6 π` of a unit sphere at speed 1 in a ball of radius 10,
/// and their digits.
///
/// By a spectral Galerkin program in spherical coordinates.
pub const CARREAU_SPHERES: [(f64, f64, f64, f64, f64); 5] = [
    (0.5, 1.0, 0.0, 1.1827246, 5e-8),
    (0.3, 1.0, 0.0, 1.1293781, 5e-8),
    (0.5, 10.0, 0.0, 0.597988, 1e-6),
    (0.3, 10.0, 0.0, 0.410398, 1.3e-6),
    (0.3, 10.0, 0.01, 0.430480, 1.3e-6),
];

/// Speed over `2 B_1 / 3` and power over `16 π / 3` of the squirmer `u_θ = B_1 sin θ` with `B_1 =
/// 1` in a ball of radius 10, in a fluid of Carreau with index 0.5 and relaxation time 1; the same
/// program.
pub const CARREAU_SQUIRMER: [f64; 2] = [0.9327406407, 0.7524060];

/// Index, radius of the ball, `X` in `F = X 6 π K a^2 (U / a)^n 2^(1 - n)` of a sphere in a power
/// law, and its digits; the same program.
///
/// In the ball of 10 the last digits are uncertain: elements in the meridian plane give 1.39952186
/// (0.8) and 1.49993221 (0.5) with bars of 2e-10 and 1e-8, whatever the regularisation from 1e-6
/// down, which is 3.9e-7 and 1.2e-6 lower.
///
/// The values of Dazhi & Tanner (1985) for unbounded fluid, here a ball of 1e4 radii, are up to 4 %
/// smaller.
pub const POWER_LAW_SPHERES: [(f64, f64, f64, f64); 7] = [
    (0.8, 10.0, 1.3995224, 4e-7),
    (0.5, 10.0, 1.499934, 1.2e-6),
    (0.9, 1e4, 1.13815, 5e-6),
    (0.8, 1e4, 1.25789, 5e-6),
    (0.7, 1e4, 1.35560, 5e-6),
    (0.6, 1e4, 1.42883, 5e-6),
    (0.5, 1e4, 1.47592, 5e-6),
];

/// Positions of three unit spheres, radius of the ball (infinite for unbounded fluid), velocity of
/// the middle one while the left link becomes shorter at the rate 1, and its first-order change in
/// a fluid of Carreau in units of `(n - 1) / 2 λ^2`.
///
/// By the reciprocal theorem with multipoles.
pub const CARREAU_THREE_SPHERES: [([f64; 3], f64, f64, f64); 3] = [
    ([-10.0, 0.0, 10.0], 40.0, -0.3428979021, -0.022343595),
    (
        [-10.0, 0.0, 10.0],
        f64::INFINITY,
        -0.3431985147,
        -0.021768092,
    ),
    ([-6.0, 0.0, 6.0], f64::INFINITY, -0.3513188138, -0.026939721),
];

/// The square stroke of three unit spheres between links of 10 and 6 in unbounded fluid of Carreau,
/// a unit of time per leg: length of the right link, and the change of the displacement of the
/// middle sphere while the left link closes, in units of `(n - 1) / 2 λ^2`; the same program.
///
/// While the right link closes the changes are the opposite ones, by reflection, and while a link
/// opens too, because the change is of third order in the rate.
pub const CARREAU_LEGS: [(f64, f64); 2] = [(10.0, -1.51971702), (6.0, -1.52113866)];

/// Net displacement of that stroke without thinning, and its change in these units.
pub const CARREAU_STROKE: [f64; 2] = [0.1598053404, 0.0028433];

/// Net displacement of three unit spheres whose left link alone closes from 10 to 6 within a unit
/// of time and opens again within two, in unbounded fluid of Carreau with index 0.5, to first order
/// in `λ^2`.
///
/// A leg of the duration `T` has `T^-2` times the change, so that unequal times break the scallop
/// theorem.
pub fn broken_scallop(relaxation_time: f64) -> f64 {
    -0.25 * relaxation_time.powi(2) * CARREAU_LEGS[0].1 * (1.0 - 0.25)
}

/// First-order change of the speed of the squirmer `u_θ = 1.5 sin θ (1 + β cos θ)` in unbounded
/// fluid of Carreau, in units of `(n - 1) / 2 λ^2`; exact integration of the reciprocal theorem.
pub fn carreau_squirmer_slope(beta: f64) -> f64 {
    72.0 / 65.0 + 12447.0 * beta * beta / 5005.0
}

/// A stroke of the pushmepullyou: spheres of the radii 1 and 2^(1/3) that move apart, exchange
/// their volumes, come together and exchange them back.
pub struct Pushmepullyou {
    /// Distances of the centres.
    pub lengths: [f64; 2],
    /// Radius of the ball whose centre is the middle of the spheres at the start.
    pub ball: Option<f64>,
    /// Displacement of the left sphere.
    pub net: f64,
    /// Relative accuracy of the value.
    pub digits: f64,
    /// Displacement by the connection of Avron, Kenneth & Oaknin (2005) for spheres far apart.
    pub far_field: Option<f64>,
}

/// Computed for this project by Lamb's solution with point sources and by the reciprocal theorem,
/// which agree to 1e-13 at distances from 4 on and to 1e-10 at 2.6.
#[rustfmt::skip]
pub const PUSHMEPULLYOUS: [Pushmepullyou; 5] = [
    Pushmepullyou { lengths: [4.0, 8.0], ball: None,
        net: -0.650163426803, digits: 1e-11, far_field: Some(-0.4756783) },
    Pushmepullyou { lengths: [2.6, 4.0], ball: None,
        net: -0.3023183945, digits: 2e-9, far_field: Some(-0.189495) },
    Pushmepullyou { lengths: [8.0, 16.0], ball: None,
        net: -1.078916618821, digits: 1e-11, far_field: Some(-0.9240129) },
    Pushmepullyou { lengths: [2.4, 3.0], ball: None,
        net: -0.1456704, digits: 3e-7, far_field: Some(-0.0898413) },
    Pushmepullyou { lengths: [4.0, 8.0], ball: Some(10.0),
        net: -0.7178375485, digits: 1e-9, far_field: None },
];

/// A period of a unit sphere with modes of the degrees two and three, `eps cos t` and `eps sin t`.
pub struct ShapeWave {
    /// `eps`.
    pub amplitude: f64,
    /// Word of the scene file.
    pub motion: &'static str,
    /// Radius of the ball whose centre is that of the sphere at the start.
    pub ball: Option<f64>,
    /// Displacement along the axis.
    pub net: f64,
    /// Relative accuracy of the value.
    pub digits: f64,
}

/// Computed for this project by Lamb's solution and by rings of fundamental solutions.
#[rustfmt::skip]
pub const SHAPE_WAVES: [ShapeWave; 7] = [
    ShapeWave { amplitude: 0.1, motion: "isochoric", ball: None, net: -2.658266882e-3, digits: 1e-9 },
    ShapeWave { amplitude: 0.05, motion: "isochoric", ball: None, net: -6.71008102e-4, digits: 2e-9 },
    ShapeWave { amplitude: 0.1, motion: "isochoric", ball: Some(5.0), net: -2.906719955e-3, digits: 1e-9 },
    ShapeWave { amplitude: 0.2, motion: "isochoric", ball: Some(5.0), net: -1.115904e-2, digits: 1e-6 },
    ShapeWave { amplitude: 0.05, motion: "radial", ball: None, net: -6.68851935e-4, digits: 2e-9 },
    ShapeWave { amplitude: 0.1, motion: "radial", ball: None, net: -2.624476269e-3, digits: 1e-9 },
    ShapeWave { amplitude: 0.2, motion: "radial", ball: None, net: -9.7485466e-3, digits: 1e-8 },
];

/// `(1/2) ∫ Θ_t Θ_θ sin^2 Θ dθ` over a period, for `Θ = θ + eps (sin 2θ cos t + sin 3θ sin t)`.
#[rustfmt::skip]
pub const TANGENTIAL_WAVES: [ShapeWave; 2] = [
    ShapeWave { amplitude: 0.05, motion: "tangential", ball: None, net: 0.01316158783268, digits: 1e-12 },
    ShapeWave { amplitude: 0.1, motion: "tangential", ball: None, net: 0.05260820650118, digits: 1e-12 },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms_agree_with_the_table() {
        // Tabulated from an expansion in Lamb's solutions.
        let table = [
            (0.1, 1.2861963385482686, 1.001001001001001),
            (0.2, 1.7558453237410072, 1.0080645161290323),
            (0.5, 7.294117647058823, 1.1428571428571428),
        ];
        for (lambda, drag, torque) in table {
            assert!((concentric_drag(lambda) / drag - 1.0).abs() < 1e-14);
            assert!((concentric_torque(lambda) / torque - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn copies_are_consistent() {
        for case in &COLLINEAR {
            let n = case.positions.len();
            assert_eq!(case.radii.len(), n);
            assert_eq!(case.resistance.len(), n * (n + 1) / 2);
        }
        for instant in &INSTANTANEOUS {
            assert!(instant.forces.iter().sum::<f64>().abs() < 1e-12);
        }
        for stroke in &STROKES {
            assert!((stroke.steps.iter().sum::<f64>() - stroke.net).abs() < 1e-12);
        }
    }
}
