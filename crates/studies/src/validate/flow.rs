//! Scenes of spheres on the x axis in a ball, and quantities from one solve.

use anyhow::{Context, Result};
use nalgebra::{DMatrix, Vector3};
use swimmer::choose;
use swimmer::models::InstantaneousSolution;
use swimmer::{Scene, solve_start};

use super::row::Cost;

/// A sphere on the x axis with its loads.
#[derive(Clone, Copy, Default)]
pub struct Sphere {
    pub position: f64,
    pub radius: f64,
    pub force: Vector3<f64>,
    pub torque: Vector3<f64>,
}

/// Scene of spheres named `s0`, `s1`, ... in a ball around the origin, by finite elements.
///
/// `more` is further TOML.
pub fn scene(container: f64, size: f64, spheres: &[Sphere], more: &str) -> Result<Scene> {
    let model = format!("model.kind = \"fem\"\nfem.surface_size = {size:?}");
    scene_by(&model, container, spheres, more)
}

/// Same scene as [`scene`], with `model` for the lines that choose the model.
pub fn scene_by(model: &str, container: f64, spheres: &[Sphere], more: &str) -> Result<Scene> {
    let bodies: String = spheres
        .iter()
        .enumerate()
        .map(|(number, s)| {
            let (force, torque) = (s.force.as_slice(), s.torque.as_slice());
            format!(
                "[[bodies]]\nname = \"s{number}\"\nradius = {:?}\nposition = [{:?}, 0, 0]\nforce = {force:?}\ntorque = {torque:?}\n",
                s.radius, s.position
            )
        })
        .collect();
    let text =
        format!("domain = {{ kind = \"ball\", radius = {container:?} }}\n{model}\n{bodies}{more}");
    Scene::parse(&text).context("a scene of the validation is wrong")
}

/// Solves a scene at its start.
pub fn solve(scene: &Scene) -> Result<(InstantaneousSolution, Cost)> {
    let mut model = choose(scene)?.model;
    let instant = solve_start(scene, model.as_mut())?;
    let cost = Cost::of(&instant);
    Ok((instant, cost))
}

/// Axial resistance of spheres on the x axis.
pub struct AxialResistance {
    pub matrix: DMatrix<f64>,
    /// Estimated errors that were subtracted from the entries.
    pub removed: DMatrix<f64>,
    /// Error bars of the entries.
    pub bars: DMatrix<f64>,
    pub cost: Cost,
}

/// Axial resistance of spheres on the x axis.
///
/// It is the inverse of the mobility matrix `M`, whose columns come from forces on one sphere at a
/// time. The bars are upper bounds: `dR = -R dM R`, with all terms added up.
pub fn axial_resistance(container: f64, size: f64, spheres: &[Sphere]) -> Result<AxialResistance> {
    let n = spheres.len();
    let [mut mobility, mut uncorrected, mut bars] = [(); 3].map(|()| DMatrix::zeros(n, n));
    let mut cost = Cost::default();
    for pulled in 0..n {
        let mut loaded = spheres.to_vec();
        loaded[pulled].force = Vector3::x();
        let (instant, one) = solve(&scene(container, size, &loaded, "")?)?;
        let before = instant.uncorrected();
        for row in 0..n {
            mobility[(row, pulled)] = instant.bodies[row].velocity.x;
            uncorrected[(row, pulled)] = before.bodies[row].velocity.x;
            bars[(row, pulled)] = instant.error_estimate.total();
        }
        cost.add(&one);
    }
    let inverse = |mobility: DMatrix<f64>| {
        mobility
            .try_inverse()
            .context("the mobility matrix is singular")
    };
    let matrix = inverse(mobility)?;
    Ok(AxialResistance {
        removed: inverse(uncorrected)? - &matrix,
        bars: matrix.abs() * bars * matrix.abs(),
        matrix,
        cost,
    })
}
