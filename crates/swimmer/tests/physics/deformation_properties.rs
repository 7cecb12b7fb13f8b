//! What all deformations have in common: velocities turn with the scene, reverse with the rates,
//! and one coordinate leads nowhere.

use std::f64::consts::PI;

use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use swimmer::Scene;
use testkit::{boxed, run, solve_at, within};

/// A kind of deformation, with a model that has it.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Radius,
    Volume,
    Isochoric,
    Tangential,
    Gradient,
    Harmonic,
    Undulation,
}

/// A quaternion's axis and angle, and a vector, as they stand in a file.
fn list(v: Vector3<f64>) -> String {
    format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
}

impl Kind {
    /// The body without its position, and the names of its coordinates with values where it may be.
    fn body(self, turn: &UnitQuaternion<f64>) -> (String, Vec<(&'static str, [f64; 2])>) {
        let modes = |motion: &str, orders: &str| {
            format!(
                "radius = 1\ndeformation = {{ motion = \"{motion}\", modes = {{ p = 2, q = 3 }}, \
                 {orders}axis = {}, meridian = {} }}",
                list(turn * Vector3::x()),
                list(turn * Vector3::y()),
            )
        };
        let amplitudes = vec![("b.p", [-0.1, 0.1]), ("b.q", [-0.1, 0.1])];
        let size = |word: &str| format!("radius = 1\ndeformation = {{ kind = \"{word}\" }}");
        match self {
            Self::Radius => (size("radius"), vec![("b.radius", [0.9, 1.3])]),
            Self::Volume => (size("volume"), vec![("b.volume", [3.0, 8.0])]),
            Self::Isochoric => (modes("isochoric", ""), amplitudes),
            // Of expansions, which resolve small changes of slopes: where both are -0.1 the flow on
            // the surface needs more than 25 degrees for some rates.
            Self::Tangential => (
                modes("tangential", ""),
                vec![("b.p", [-0.08, 0.08]), ("b.q", [-0.08, 0.08])],
            ),
            Self::Gradient => (
                modes("gradient", "orders = { p = 1, q = -2 }, "),
                vec![("b.p", [-0.04, 0.04]), ("b.q", [-0.02, 0.02])],
            ),
            Self::Harmonic => (
                modes("isochoric", "orders = { p = 1, q = -2 }, "),
                amplitudes,
            ),
            Self::Undulation => (
                format!(
                    "shape = \"tube\"\nlength = 4\nradius = 0.4\norientation = {}\ndeformation = \
                     {{ kind = \"undulation\", amplitude = 0.5 }}",
                    list(turn.scaled_axis())
                ),
                vec![("b.amplitude", [0.3, 0.7]), ("b.phase", [-PI, PI])],
            ),
        }
    }

    /// Model, and position of the other body.
    fn settings(self) -> (&'static str, Vector3<f64>) {
        match self {
            Self::Radius | Self::Volume | Self::Tangential | Self::Gradient => (
                "model = { kind = \"multipole\", tolerance = 1e-5 }",
                Vector3::new(2.6, 0.6, 0.3),
            ),
            // On its axis.
            Self::Isochoric => (
                "model = { kind = \"axisymmetric\", tolerance = 1e-4 }",
                Vector3::new(2.6, 0.0, 0.0),
            ),
            Self::Harmonic | Self::Undulation => (
                "model = { kind = \"fem\", tolerance = 0.2 }\nfem.size_factor = 1.6",
                Vector3::new(0.5, 2.6, 0.3),
            ),
        }
    }

    fn scene(self, turn: &UnitQuaternion<f64>, gait: &str) -> Scene {
        let (settings, other) = self.settings();
        let text = format!(
            "{settings}\n[[bodies]]\nname = \"b\"\nposition = [0, 0, 0]\n{}\n[[bodies]]\n\
             name = \"o\"\nradius = 0.7\nposition = {}\n{gait}",
            self.body(turn).0,
            list(turn * other),
        );
        Scene::parse(&text).unwrap()
    }

    /// Values and rates at shares of the ranges of the coordinates.
    fn values(self, shares: [f64; 2]) -> Vec<f64> {
        let (_, coordinates) = self.body(&UnitQuaternion::identity());
        let all = coordinates.iter().zip(shares);
        all.map(|((_, [low, high]), share)| low + share * (high - low))
            .collect()
    }

    fn check_instant(self, turn: Vector3<f64>, shares: [f64; 2], rates: [f64; 2]) {
        let values = self.values(shares);
        let rates = &rates[..values.len()];
        let what = format!("{self:?}");
        check_instant(&|turn| self.scene(turn, ""), turn, (&values, rates), &what);
    }

    /// The first coordinate goes from one end of its range to the other and back, at other rates.
    fn check_scallop(self, turn: Vector3<f64>, slower: f64) {
        let turn = UnitQuaternion::from_scaled_axis(turn);
        let (_, coordinates) = self.body(&turn);
        let (name, [_, high]) = coordinates[0];
        let start = match self {
            Self::Radius => 1.0,
            Self::Volume => 4.0 / 3.0 * PI,
            Self::Undulation => 0.5,
            _ => 0.0,
        };
        let gait = format!(
            "[[gait.phases]]\ntargets = {{ \"{name}\" = {high:?} }}\nduration = 1\n\
             [[gait.phases]]\ntargets = {{ \"{name}\" = {start:?} }}\nduration = {slower:?}\n"
        );
        check_scallop(&self.scene(&turn, &gait), &format!("{self:?}"));
    }
}

/// Velocities are those of the turned scene, turned back, and reverse with the rates.
pub fn check_instant(
    scene: &dyn Fn(&UnitQuaternion<f64>) -> Scene,
    turn: Vector3<f64>,
    (values, rates): (&[f64], &[f64]),
    what: &str,
) {
    let turn = UnitQuaternion::from_scaled_axis(turn);
    let solve = |turn: &UnitQuaternion<f64>, sign: f64| {
        let rates: Vec<f64> = rates.iter().map(|rate| sign * rate).collect();
        solve_at(boxed(&scene(turn)).as_mut(), values, &rates)
    };
    let unit = UnitQuaternion::identity();
    let [own, back, turned] = [solve(&unit, 1.0), solve(&unit, -1.0), solve(&turn, 1.0)];
    let bars = own.error_estimate.total() + turned.error_estimate.total();
    let bodies = own.bodies.iter();
    let fastest = bodies.map(|body| body.velocity.norm()).fold(0.0, f64::max);
    for body in 0..own.bodies.len() {
        let [own, back, turned] = [&own, &back, &turned].map(|of| of.bodies[body].velocity);
        within(
            (turn * own - turned).norm(),
            bars + 1e-9,
            format!("the error bars: {what}"),
        );
        within(
            (own + back).norm(),
            1e-7 * fastest + 1e-12,
            format!("the solver: {what}"),
        );
    }
    // Corrections are solved less accurately than flows.
    let both = own.power_error.total() + back.power_error.total();
    let allowed = both + 1e-6 * own.power();
    within(own.power() - back.power(), allowed, "the error bars");
    let bars = own.power_error.total() + turned.power_error.total();
    within(
        own.power() - turned.power(),
        bars + 1e-9 * own.power(),
        "the error bars",
    );
    assert!(own.power() > 0.0 || rates.iter().all(|rate| *rate == 0.0));
}

/// A stroke of one coordinate, there and back, leads nowhere.
pub fn check_scallop(scene: &Scene, what: &str) {
    let outcome = run(scene);
    let bodies = 0..outcome.displacement.len();
    let there = bodies
        .clone()
        .map(|body| outcome.spans[0].displacement[body].norm());
    let there = there.fold(0.0, f64::max);
    assert!(there > 1e-5, "{what}");
    let bar = outcome.error_estimate.total().max(1e-8);
    for body in bodies {
        within(
            outcome.displacement[body].norm(),
            bar,
            format!("the error bar: {what}"),
        );
    }
    within(bar, there, "the bar says something");
}

fn without_a_mesh() -> impl Strategy<Value = Kind> {
    prop_oneof![
        Just(Kind::Radius),
        Just(Kind::Volume),
        Just(Kind::Tangential),
        Just(Kind::Gradient),
        Just(Kind::Isochoric),
    ]
}

pub fn turns() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-2.0..2.0_f64).prop_map(Vector3::from)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 15, ..ProptestConfig::default() })]

    #[test]
    fn deformations_are_the_same_in_all_frames_and_reverse_with_their_rates(
        kind in without_a_mesh(),
        turn in turns(),
        shares in prop::array::uniform2(0.0..1.0_f64),
        rates in prop::array::uniform2(-1.0..1.0_f64),
    ) {
        kind.check_instant(turn, shares, rates);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, ..ProptestConfig::default() })]

    #[test]
    #[ignore = "slow: 60 s"]
    fn one_coordinate_leads_nowhere(
        kind in without_a_mesh(),
        turn in turns(),
        slower in 0.3..6.0_f64,
    ) {
        kind.check_scallop(turn, slower);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4, ..ProptestConfig::default() })]

    #[test]
    #[ignore = "slow: 60 s"]
    fn deformations_by_elements_are_the_same_in_all_frames_and_reverse_with_their_rates(
        kind in prop_oneof![Just(Kind::Harmonic), Just(Kind::Undulation)],
        turn in turns(),
        shares in prop::array::uniform2(0.0..1.0_f64),
        rates in prop::array::uniform2(-1.0..1.0_f64),
    ) {
        kind.check_instant(turn, shares, rates);
    }
}
