//! A model of one's own: spheres without hydrodynamic interactions, compared with multipoles.
//!
//! Two spheres of radii 2 and 1 are pushed apart at unit speed. Without interactions each has its
//! Stokes drag `6π μ a U`, so the velocities are exactly -1/3 and 2/3.

use std::error::Error;
use std::f64::consts::PI;

use models::nalgebra::{DMatrix, DVector};
use models::rigid::{Drive, ExternalLoad, Reduction};
use models::{
    BodySolution, Configuration, Hydrodynamics, InstantaneousSolution, ModelError, Query,
    SphereModel, SpheresModel,
};
use scene::Scene;

/// Stokes drag and torque of each sphere, as if it were alone in unbounded fluid.
struct NoInteractions(Scene);

impl NoInteractions {
    fn drag(&self) -> DMatrix<f64> {
        let mut diagonal = Vec::new();
        for body in self.0.bodies() {
            if let Some(radius) = body.shape.sphere_radius() {
                diagonal.extend([6.0 * PI * self.0.viscosity() * radius; 3]);
                diagonal.extend([8.0 * PI * self.0.viscosity() * radius.powi(3); 3]);
            }
        }
        DMatrix::from_diagonal(&DVector::from_vec(diagonal))
    }

    fn solve_rates(
        &self,
        configuration: Configuration,
        rates: &[f64],
    ) -> Result<InstantaneousSolution, ModelError> {
        let set = self.0.articulation();
        let constraints = set.constraints(configuration.state, configuration.shape, rates)?;

        // Velocities of the bodies are S v + W: motions that the joints leave free, and the motion
        // that their rates impose. Free motions do no work: S^T R (S v + W) = 0.
        let reduction = Reduction::new(set, &constraints)?;
        let (s, w) = (&reduction.surface_basis, &reduction.surface_offset);
        let drag = self.drag();
        let matrix = s.tr_mul(&(&drag * s));
        let v = matrix.clone().cholesky().ok_or_else(|| {
            let remedy = "all bodies must be spheres";
            ModelError::not_positive_definite("drag of the free motions", &matrix, remedy)
        })?;
        let v = v.solve(&-s.tr_mul(&(&drag * w)));
        let generalised = reduction.velocities(&v)?;
        let motion = set.state_velocity(generalised.as_slice())?;

        let velocities = s * v + w;
        let forces = drag * &velocities;
        let part = |list: &DVector<f64>, first: usize| list.fixed_rows::<3>(first).into_owned();
        let bodies: Vec<BodySolution> = (0..self.0.bodies().len())
            .map(|body| BodySolution {
                velocity: part(&velocities, 6 * body),
                angular_velocity: part(&velocities, 6 * body + 3),
                force: part(&forces, 6 * body),
                torque: part(&forces, 6 * body + 3),
            })
            .collect();
        // The joints transmit what the fluid exerts on the bodies; the scene has no loads.
        let drive = Drive {
            set,
            constraints: &constraints,
            loads: &vec![ExternalLoad::default(); bodies.len()],
        };
        let joint_loads = drive.joint_loads(&forces, &generalised)?;
        Ok(InstantaneousSolution::new(bodies, joint_loads, motion))
    }
}

impl Hydrodynamics for NoInteractions {
    fn name(&self) -> &'static str {
        "no interactions"
    }

    fn scene(&self) -> &Scene {
        &self.0
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let solve = |rates: &Vec<f64>| self.solve_rates(query.configuration, rates);
        query.rates.iter().map(solve).collect()
    }
}

/// Prints the velocities of both models and checks them.
pub fn main() -> Result<(), Box<dyn Error>> {
    let scene = Scene::parse(
        r#"
        bodies = [
            { name = "tail", radius = 2, position = [0, 0, 0] },
            { name = "head", radius = 1, position = [10, 0, 0] },
        ]
        links = [{ name = "arm", body = "head", to = "tail" }]
        "#,
    )?;
    let state = scene.initial_state();
    let configuration = Configuration::new(&state, &[10.0]);
    let multipoles = SpheresModel::new(&scene, SphereModel::Multipole(1e-6))?;
    let models: [Box<dyn Hydrodynamics>; 2] =
        [Box::new(NoInteractions(scene)), Box::new(multipoles)];
    let mut heads = Vec::new();
    let mut pushes = Vec::new();
    for mut model in models {
        let solution = model.solve_one(configuration, &[1.0])?;
        let [tail, head] = [0, 1].map(|body| solution.bodies[body].velocity.x);
        println!("{:>15}: tail {tail:.6}, head {head:.6}", model.name());
        assert!((head - tail - 1.0).abs() < 1e-12, "rate of the arm");
        heads.push(head);
        pushes.push(solution.joint_loads[0].drive);
    }
    assert!((heads[0] - 2.0 / 3.0).abs() < 1e-12, "{heads:?}");
    // The arm pushes the head against its drag 6π·2/3.
    assert!((pushes[0] - 4.0 * PI).abs() < 1e-11, "{pushes:?}");
    // Interactions change the velocity by a relative amount of the order of radius over distance.
    assert!((heads[1] - heads[0]).abs() < 0.1, "{heads:?}");
    Ok(())
}
