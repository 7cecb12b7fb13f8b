//! Scenes with exact solutions: one velocity or displacement each.

use std::f64::consts::PI;

use anyhow::{Context, Result};
use nalgebra::Vector3;
use swimmer::Scene;

use crate::reference::{OPPOSITE, STROKES, concentric_drag};

/// A scene with the exact value of one quantity.
pub struct Case {
    /// Name in the table.
    pub name: String,
    /// The scene's text without `[model]` and `[fem]`.
    pub text: String,
    /// The quantity and its exact value.
    pub exact: Exact,
}

/// A quantity with its exact value.
#[derive(Clone, Copy, Debug)]
pub enum Exact {
    /// Velocity of the first body at the start.
    Velocity(Vector3<f64>),
    /// Net displacement of the mean of the bodies' centres.
    Net(Vector3<f64>),
}

impl Case {
    /// The scene with a model.
    pub fn scene(&self, model: &str, tolerance: f64, more: &str) -> Result<Scene> {
        let text = format!(
            "model = {{ kind = \"{model}\", tolerance = {tolerance:e} }}\n{more}{}",
            self.text
        );
        Scene::parse(&text).with_context(|| format!("scene '{}'", self.name))
    }

    fn velocity(name: &str, text: String, exact: Vector3<f64>) -> Self {
        Self {
            name: name.to_owned(),
            text,
            exact: Exact::Velocity(exact),
        }
    }

    fn net(name: &str, text: String, exact: [f64; 3]) -> Self {
        Self {
            name: name.to_owned(),
            text,
            exact: Exact::Net(exact.into()),
        }
    }
}

/// All scenes.
///
/// Sources are in [`crate::reference`]. "Spectral" values are converged multipole expansions,
/// confirmed by bispherical coordinates or fundamental solutions.
pub fn all() -> Vec<Case> {
    let unbounded = "domain.kind = \"unbounded\"\n";
    let ball = |radius: f64| format!("domain = {{ kind = \"ball\", radius = {radius} }}\n");
    let pulled = |at: &str, force: &str| {
        format!("[[bodies]]\nname = \"pulled\"\nradius = 1\nposition = {at}\nforce = {force}\n")
    };
    let stokes = 6.0 * PI;
    let mut cases = vec![Case::velocity(
        "a sphere pulled at the centre of a ball of 10",
        ball(10.0) + &pulled("[0, 0, 0]", "[1, 0, 0]"),
        Vector3::x() / (stokes * concentric_drag(0.1)),
    )];
    // A sphere that approaches a fixed one at speed U: half of the force if both approach each
    // other at speed U, plus half of the force if both move together.
    for (distance, together) in [(3.0, 0.6983045602500371), (2.1, 0.6509001445148839)] {
        let Some(opposite) = OPPOSITE.iter().find(|row| row.0 == distance) else {
            continue;
        };
        let own = 0.5 * (opposite.1 + together);
        cases.push(Case::velocity(
            &format!("a sphere pulled to a fixed one, centres {distance} apart"),
            format!(
                "{unbounded}{}[[bodies]]\nname = \"fixed\"\nradius = 1\nposition = [{distance:?}, 0, 0]\nfixed = true\n",
                pulled("[0, 0, 0]", "[1, 0, 0]")
            ),
            Vector3::x() / (stokes * own),
        ));
    }
    // Brenner (1961) normal to the wall; Goldman, Cox & Brenner (1967) along it, free to rotate
    // (spectral).
    let wall = "domain.kind = \"wall\"\n";
    cases.push(Case::velocity(
        "a sphere pulled from a wall, height 1.5",
        wall.to_owned() + &pulled("[0, 0, 1.5]", "[0, 0, 1]"),
        Vector3::z() / (stokes * 3.2053903153526253),
    ));
    let (along, turning, coupling) = (2.264303035388026, 1.4548512100169821, -0.08876334417411287);
    let free = stokes * along - (8.0 * PI * coupling).powi(2) / (8.0 * PI * turning);
    cases.push(Case::velocity(
        "a sphere pulled along a wall, height 1.1",
        wall.to_owned() + &pulled("[0, 0, 1.1]", "[1, 0, 0]"),
        Vector3::x() / free,
    ));
    // Spectral, integrated to 1e-12.
    for (arm, closed, exact) in [
        (10.0, 6.0, 0.1598053403881754),
        (5.0, 3.0, 0.13218996848920106),
        (4.0, 2.5, 0.09692485291674591),
    ] {
        cases.push(Case::net(
            &format!("three spheres, arms {arm} to {closed}"),
            unbounded.to_owned() + &collinear(arm, closed),
            [exact, 0.0, 0.0],
        ));
    }
    for stroke in &STROKES {
        cases.push(Case::net(
            &format!("three spheres in a ball of {}", stroke.container),
            ball(stroke.container) + &collinear(10.0, 6.0),
            [stroke.net, 0.0, 0.0],
        ));
    }
    // Collocation and fundamental solutions agree to 1e-11. After a closed stroke, the mean
    // displacement of the spheres of a star is that of its junction.
    let planar: Vec<[f64; 3]> = (0..3)
        .map(|k| {
            let angle = 2.0 * PI * f64::from(k) / 3.0;
            [angle.cos(), angle.sin(), 0.0]
        })
        .collect();
    let third = 3.0_f64.sqrt().recip();
    let tetrahedral = [
        [third, third, third],
        [third, -third, -third],
        [-third, third, -third],
        [-third, -third, third],
    ];
    for (name, arms, net) in [
        (
            "clamped",
            &planar[..],
            [0.004791832418980625, -0.0026805960395928506, 0.0],
        ),
        (
            "free",
            &planar[..],
            [0.004667202336353144, -0.002607693358089058, 0.0],
        ),
        (
            "clamped",
            &tetrahedral[..],
            [
                7.608613702185518e-05,
                0.0045765204228767975,
                0.004576520422876715,
            ],
        ),
        (
            "free",
            &tetrahedral[..],
            [
                7.758427939318449e-05,
                0.0044049086287823325,
                0.004404908628781979,
            ],
        ),
    ] {
        let shape = if arms.len() == 3 {
            "planar"
        } else {
            "tetrahedral"
        };
        cases.push(Case::net(
            &format!("{shape} swimmer, {name}"),
            format!("gait.arms = \"{name}\"\n{unbounded}{}", star(arms)),
            net,
        ));
    }
    cases
}

fn phases(steps: [(&str, f64); 4]) -> String {
    steps
        .map(|(joint, length)| {
            format!("[[gait.phases]]\nlink = \"{joint}\"\nlength = {length:?}\n")
        })
        .concat()
}

/// The swimmer of Najafi & Golestanian (2004) along x: unit spheres, the arms close and open again
/// one after the other.
fn collinear(arm: f64, closed: f64) -> String {
    let bodies: String = [("left", -arm), ("centre", 0.0), ("right", arm)]
        .map(|(name, x)| {
            format!("[[bodies]]\nname = \"{name}\"\nradius = 1\nposition = [{x:?}, 0, 0]\n")
        })
        .concat();
    let joints: String = ["left", "right"]
        .map(|name| format!("[[links]]\nname = \"{name}\"\nbody = \"{name}\"\nto = \"centre\"\n"))
        .concat();
    bodies
        + &joints
        + &phases([
            ("left", closed),
            ("right", closed),
            ("left", arm),
            ("right", arm),
        ])
}

/// Unit spheres on arms of 6 from a junction; the first two arms close to 4 and open again.
fn star(arms: &[[f64; 3]]) -> String {
    let bodies: String = arms
        .iter()
        .enumerate()
        .map(|(k, e)| {
            let x = e.map(|c| 6.0 * c);
            format!(
                "[[bodies]]\nname = \"s{k}\"\nradius = 1\nposition = [{:?}, {:?}, {:?}]\n\
                 [[links]]\nname = \"a{k}\"\nbody = \"s{k}\"\nto = \"junction\"\n",
                x[0], x[1], x[2]
            )
        })
        .collect();
    let junction =
        "[[bodies]]\nname = \"junction\"\nshape = \"point\"\nposition = [0, 0, 0]\n".to_owned();
    junction + &bodies + &phases([("a0", 4.0), ("a1", 4.0), ("a0", 6.0), ("a1", 6.0)])
}
