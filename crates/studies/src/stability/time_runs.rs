//! Runs in time with inertia of the fluid, in the meridian plane and in space.

use anyhow::{Context, Result};
use swimmer::{Outcome as Swum, Scene, SwimError, run_without_files};

use super::map::{Cell, Expected, Map, Outcome, Store};

const MODELS: [&str; 2] = ["axisymmetric", "fem"];

/// Tolerances of the runs and of the run in the meridian plane that they are compared with.
const TOLERANCE: f64 = 3e-2;
const REFERENCE_TOLERANCE: f64 = 3e-3;

/// A scene without its model and tolerance.
struct Case {
    name: &'static str,
    /// Keys besides `density` and `inertia` of the fluid.
    fluid: &'static str,
    density: f64,
    /// Radius of the ball.
    ball: f64,
    text: &'static str,
    /// Factor on the element sizes in space.
    size_factor: f64,
    /// Outcome that every model must have.
    expected: Expected,
    quick: bool,
}

impl Case {
    fn scene(&self, model: &str, tolerance: f64, fluid: &str) -> Result<Scene, SwimError> {
        Ok(Scene::parse(&format!(
            "fluid = {{ density = {:?}, inertia = \"full\"{fluid} }}\n\
             domain = {{ kind = \"ball\", radius = {:?} }}\n\
             model = {{ kind = \"{model}\", tolerance = {tolerance:e}, accept = \"best\" }}\n\
             fem.size_factor = {:?}\n{}",
            self.density, self.ball, self.size_factor, self.text
        ))?)
    }
}

/// A sphere of this density that is released, for two units of time.
macro_rules! released {
    ($density:literal) => {
        concat!(
            "gravity = [0, 0, -1]\n[[gait.phases]]\nduration = 2\n[[bodies]]\nname = \"s\"\n\
             radius = 1\nposition = [0, 0, 0]\ndensity = ",
            $density
        )
    };
}

/// A sphere that is pulled from a place on the axis, and its duration.
macro_rules! pulled {
    ($force:literal, $from:literal, $duration:literal) => {
        concat!(
            "gait.phases = [{ duration = ",
            $duration,
            " }]\n[[bodies]]\nname = \"s\"\nradius = 1\nposition = [0, 0, ",
            $from,
            "]\ndensity = 1\nforce = [0, 0, ",
            $force,
            "]"
        )
    };
}

/// Two spheres that are pulled together, with the inner sides at `±gap / 2`.
macro_rules! approach {
    ($low:literal, $high:literal, $force:literal, $duration:literal) => {
        concat!(
            "gait.phases = [{ duration = ",
            $duration,
            " }]\n[[bodies]]\nname = \"low\"\nradius = 1\nposition = [0, 0, ",
            $low,
            "]\ndensity = 2\nforce = [0, 0, ",
            $force,
            "]\n[[bodies]]\nname = \"high\"\nradius = 0.8\nposition = [0, 0, ",
            $high,
            "]\ndensity = 2\nforce = [0, 0, -",
            $force,
            "]"
        )
    };
}

/// Two spheres on a slide that jumps between constant rates.
const CORNERS: &str = "bodies = [{ name = \"a\", radius = 1, position = [0, 0, -1.5] }, \
    { name = \"b\", radius = 0.6, position = [0, 0, 1.5], density = 3 }]\n\
    links = [{ name = \"arm\", body = \"b\", to = \"a\" }]\n\
    gait.phases = [{ link = \"arm\", length = 2.4, duration = 0.5 }, \
    { link = \"arm\", length = 3.6, duration = 1 }, { link = \"arm\", length = 3, duration = 0.7 }]";

const fn case(name: &'static str, text: &'static str) -> Case {
    Case {
        name,
        fluid: "",
        density: 1.0,
        ball: 8.0,
        text,
        size_factor: 1.2,
        expected: Expected::Right,
        quick: false,
    }
}

const CASES: [Case; 15] = [
    case("a released sphere without mass", released!("0.0")),
    case("a released sphere, density ratio 1e-3", released!("1e-3")),
    case("a released sphere, density ratio 1.05", released!("1.05")),
    case("a released sphere, density ratio 1e3", released!("1e3")),
    Case {
        fluid: ", time_step = 2e-4",
        ..case(
            "given steps of 2e-4 diffusion times",
            pulled!("10", "0", "0.01"),
        )
    },
    Case {
        fluid: ", time_step = 0.5",
        quick: true,
        ..case("four given steps", released!("2"))
    },
    Case {
        fluid: ", time_step = 100",
        ..case("a given step longer than the run", released!("2"))
    },
    Case {
        fluid: ", start = \"stokes\", time_step = 0.25",
        ..case("a start in Stokes flow with given steps", released!("2"))
    },
    case("a gait with corners", CORNERS),
    case(
        "remeshing in mid-flight: through eight radii",
        pulled!("120", "-4", "2"),
    ),
    Case {
        density: 20.0,
        ball: 10.0,
        size_factor: 0.8,
        ..case("Re about 100", pulled!("600", "-6", "2"))
    },
    Case {
        density: 40.0,
        ball: 10.0,
        size_factor: 0.8,
        expected: Expected::NotWrong,
        ..case("Re about 200", pulled!("1000", "-6", "2"))
    },
    case(
        "two spheres approach, gap from 0.2",
        approach!("-1.1", "0.9", "20", "0.3"),
    ),
    Case {
        expected: Expected::NotWrong,
        ..case(
            "two spheres approach, gap from 0.02",
            approach!("-1.01", "0.81", "20", "0.3"),
        )
    },
    case(
        "a fast approach, gap from 0.2 to 0.06",
        approach!("-1.1", "0.9", "200", "0.1"),
    ),
];

/// The map.
pub fn map(quick: bool, store: &mut Store) -> Result<Map> {
    let mut map = Map {
        key: "time",
        title: "Runs in time with inertia",
        note: "Displacements against a run in the meridian plane to a tenth of the tolerance, with \
               steps that their errors choose: the largest error over the bar of both, of which \
               two are allowed. Radii are 1, the viscosity is 1, so that times are in diffusion \
               times over the density.",
        columns: MODELS.map(String::from).to_vec(),
        ..Map::default()
    };
    for case in &CASES {
        if !quick || case.quick {
            map.add(store, case.name, || cells(case))?;
        }
    }
    Ok(map)
}

fn run(scene: Scene) -> Result<Swum, SwimError> {
    Ok(run_without_files(scene, &mut ())?.completed()?.outcome)
}

/// Both models for one case.
fn cells(case: &Case) -> Result<Vec<Cell>> {
    // A start in Stokes flow belongs to the problem, given steps do not.
    let start = match case.fluid.contains("stokes") {
        true => ", start = \"stokes\"",
        false => "",
    };
    let reference = case
        .scene(MODELS[0], REFERENCE_TOLERANCE, start)
        .context(case.name)?;
    let reference = run(reference);
    let cell = |model: &str| {
        let compute = || match &reference {
            Ok(_) => run(case.scene(model, TOLERANCE, case.fluid)?),
            // Without a reference there is no right answer.
            Err(_) => run(case.scene(model, REFERENCE_TOLERANCE, start)?),
        };
        Cell::new(case.expected, compute, |found: Swum| {
            let Ok(exact) = &reference else {
                return Outcome::wrong(f64::NAN);
            };
            let pairs = found.displacement.iter().zip(&exact.displacement);
            let error = pairs.map(|(a, b)| (a - b).norm()).fold(0.0_f64, f64::max);
            let bar = found.error_estimate.total() + exact.error_estimate.total();
            let mark = format!("{:.2}", error / bar);
            Outcome::against_bar(error, bar, 1e-12, mark)
        })
    };
    Ok(MODELS.map(cell).to_vec())
}
