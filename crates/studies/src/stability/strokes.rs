//! Strokes by finite elements with every mesh motion: displacements must be within their error
//! bars.

use std::time::Instant;

use anyhow::Result;
use swimmer::choose;
use swimmer::models::{SphereModel, SpheresModel};
use swimmer::scene::MeshMotionKind;
use swimmer::{Method, Outcome as Swum, Scene, SwimError, simulate};

use super::map::{Cell, Map, Outcome};
use super::store::Store;

/// A stroke of three spheres on a line in a ball of radius 14.
struct Stroke {
    name: &'static str,
    /// Lengths of the arms at the start.
    arm: f64,
    /// Joint and its length after each phase.
    phases: &'static [(&'static str, f64)],
    /// Force on the left sphere.
    force: [f64; 3],
    quick: bool,
}

const STROKES: [Stroke; 5] = [
    Stroke {
        name: "an arm closes from 5 to 2.5",
        arm: 5.0,
        phases: &[("left", 2.5)],
        force: [0.0; 3],
        quick: true,
    },
    Stroke {
        name: "an arm closes to a gap of 0.1",
        arm: 4.0,
        phases: &[("left", 2.1)],
        force: [0.0; 3],
        quick: false,
    },
    Stroke {
        name: "an arm opens from 3 to 9",
        arm: 3.0,
        phases: &[("left", 9.0)],
        force: [0.0; 3],
        quick: false,
    },
    Stroke {
        name: "four phases, arms 6 and 3",
        arm: 6.0,
        phases: &[("left", 3.0), ("right", 3.0), ("left", 6.0), ("right", 6.0)],
        force: [0.0; 3],
        quick: false,
    },
    Stroke {
        name: "pulled sideways by four radii while an arm opens",
        arm: 4.0,
        phases: &[("left", 5.0)],
        force: [0.0, 150.0, 0.0],
        quick: false,
    },
];

impl Stroke {
    fn toml(&self, model: &str, tolerance: f64, motion: &str) -> String {
        let mut text = format!(
            "domain = {{ kind = \"ball\", radius = 14 }}\nmodel = {{ kind = \"{model}\", tolerance = {tolerance:e} }}\n\
             fem = {{ surface_size = 1.0, mesh_motion = \"{motion}\" }}\n"
        );
        for (name, x) in [("l", -self.arm), ("c", 0.0), ("r", self.arm)] {
            let force = if name == "l" { self.force } else { [0.0; 3] };
            text += &format!(
                "[[bodies]]\nname = \"{name}\"\nradius = 1\nposition = [{x:?}, 0, 0]\nforce = {force:?}\n"
            );
        }
        text += "[[links]]\nname = \"left\"\nbody = \"l\"\nto = \"c\"\n[[links]]\nname = \"right\"\nbody = \"r\"\nto = \"c\"\n";
        for (joint, length) in self.phases {
            text += &format!("[[gait.phases]]\nlink = \"{joint}\"\nlength = {length:?}\n");
        }
        text
    }
}

/// The map.
pub fn map(quick: bool, store: &mut Store) -> Result<Map> {
    // The tests use one motion that keeps the mesh and one that remeshes.
    let motions: Vec<&str> = if quick {
        vec!["laplace", "kanchi-masud"]
    } else {
        // Generated meshes are moved by one method: `auto` is the biharmonic one.
        let words = MeshMotionKind::WORDS.iter().copied();
        words.filter(|&word| word != "auto").collect()
    };
    let mut rows = Vec::new();
    for stroke in STROKES.iter().filter(|stroke| !quick || stroke.quick) {
        rows.push(store.row("strokes", stroke.name, || cells(stroke, &motions))?);
    }
    Ok(Map {
        key: "strokes",
        title: "Strokes: mesh motions",
        note: "Displacements of all spheres against multipole expansions in the same ball: the number of meshes, the true error, and the error bar of the run. \
               WRONG means an error of more than twice the bar.",
        columns: motions.iter().map(|&motion| motion.to_owned()).collect(),
        rows,
    })
}

fn cells(stroke: &Stroke, motions: &[&str]) -> Result<Vec<Cell>> {
    let scene = Scene::parse(&stroke.toml("multipole", 1e-6, MeshMotionKind::WORDS[0]))?;
    let mut model = SpheresModel::new(&scene, SphereModel::Multipole(1e-7))?;
    let truth = simulate(&scene, &mut model, Method::Collocation, &mut ())?;
    let cell = |motion: &&str| {
        let clock = Instant::now();
        let outcome = match run(&stroke.toml("fem", 1e-2, motion)) {
            Err(error) => Outcome::Refused(error.to_string()),
            Ok(swum) => judge(&swum, &truth),
        };
        Cell {
            as_expected: matches!(outcome, Outcome::Right { .. }),
            outcome,
            seconds: clock.elapsed().as_secs_f64(),
        }
    };
    Ok(motions.iter().map(cell).collect())
}

fn run(text: &str) -> Result<Swum, SwimError> {
    let scene = Scene::parse(text)?;
    let mut model = choose(&scene)?.model;
    simulate(&scene, model.as_mut(), Method::Collocation, &mut ())
}

fn judge(swum: &Swum, truth: &Swum) -> Outcome {
    let pairs = swum.displacement.iter().zip(&truth.displacement);
    let error = pairs.map(|(a, b)| (a - b).norm()).fold(0.0_f64, f64::max);
    let bar = swum.error_estimate.total();
    let meshes = swum.meshes.len();
    let mark = format!("{meshes}: {error:.0e}, {bar:.0e}");
    Outcome::against_bar(error, bar, 1e-6, mark)
}
