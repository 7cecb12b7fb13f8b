//! Strokes by finite elements with every mesh motion: displacements must be within their error
//! bars.

use anyhow::Result;
use swimmer::models::{SphereModel, SpheresModel};
use swimmer::scene::{Document, MeshMotionKind};
use swimmer::{Method, Outcome as Swum, Scene, SwimError, choose, simulate};

use super::map::{Cell, Expected, Map, Outcome, Store};
use crate::scenes::in_ball;

/// A stroke of three spheres on a line in a ball of radius 14.
struct Stroke {
    name: &'static str,
    /// Lengths of the arms at the start.
    arm: f64,
    /// Lengths of both arms after each phase.
    phases: &'static [(&'static str, f64)],
    /// Force across the line on the left sphere.
    force: f64,
}

/// All strokes, that of the quick part first.
fn strokes() -> [Stroke; 5] {
    let stroke = |name, arm, phases, force| Stroke {
        name,
        arm,
        phases,
        force,
    };
    let four = &[("left", 3.0), ("right", 3.0), ("left", 6.0), ("right", 6.0)];
    let sideways = "pulled sideways by four radii while an arm opens";
    [
        stroke("an arm closes from 5 to 2.5", 5.0, &[("left", 2.5)], 0.0),
        stroke("an arm closes to a gap of 0.1", 4.0, &[("left", 2.1)], 0.0),
        stroke("an arm opens from 3 to 9", 3.0, &[("left", 9.0)], 0.0),
        stroke("four phases, arms 6 and 3", 6.0, four, 0.0),
        stroke(sideways, 4.0, &[("left", 5.0)], 150.0),
    ]
}

impl Stroke {
    fn scene(&self, model: &str, tolerance: f64, motion: &str) -> Result<Scene, SwimError> {
        let model = format!("model = {{ kind = \"{model}\", tolerance = {tolerance:e} }}");
        let fem = format!("fem = {{ surface_size = 1.0, mesh_motion = \"{motion}\" }}");
        let text = in_ball(14.0, &model).line(fem);
        let text = text.swimmer([1.0; 3], [self.arm; 2]).phases(self.phases);
        let mut document = Document::parse(&text.0, "stroke.toml")?;
        document.set(&format!("bodies.s0.force=[0, {}, 0]", self.force))?;
        Ok(Scene::from_document(document)?)
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
    let mut map = Map {
        key: "strokes",
        title: "Strokes: mesh motions",
        note: "Displacements of all spheres against multipole expansions in the same ball: the number of meshes, the true error, and the error bar of the run. \
               WRONG means an error of more than twice the bar.",
        columns: motions.iter().map(|&motion| motion.to_owned()).collect(),
        ..Map::default()
    };
    for stroke in strokes().iter().take(if quick { 1 } else { usize::MAX }) {
        map.add(store, stroke.name, || cells(stroke, &motions))?;
    }
    Ok(map)
}

fn cells(stroke: &Stroke, motions: &[&str]) -> Result<Vec<Cell>> {
    let scene = stroke.scene("multipole", 1e-6, MeshMotionKind::WORDS[0])?;
    let mut model = SpheresModel::new(&scene, SphereModel::Multipole(1e-7))?;
    let truth = simulate(&scene, &mut model, Method::Collocation, &mut ())?;
    let cell = |motion: &&str| {
        let run = || {
            let scene = stroke.scene("fem", 1e-2, motion)?;
            let mut model = choose(&scene)?.model;
            simulate(&scene, model.as_mut(), Method::Collocation, &mut ())
        };
        Cell::new(Expected::Right, run, |swum| compare(&swum, &truth))
    };
    Ok(motions.iter().map(cell).collect())
}

fn compare(swum: &Swum, truth: &Swum) -> Outcome {
    let pairs = swum.displacement.iter().zip(&truth.displacement);
    let error = pairs.map(|(a, b)| (a - b).norm()).fold(0.0_f64, f64::max);
    let bar = swum.error_estimate.total();
    let mark = format!("{}: {error:.0e}, {bar:.0e}", swum.meshes.len());
    Outcome::against_bar(error, bar, 1e-6, mark)
}
