//! A simple mesh-free flow model, with which gaits and integration can be tested to rounding.
//!
//! Translations interact by the Oseen or the Rotne-Prager-Yamakawa tensor, optionally with Blake's
//! image in a no-slip wall z = 0; rotations do not interact. The mobility has the right structure
//! (symmetric positive definite, smooth, equivariant) but is not accurate for close spheres.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rigid::{BodyKind, Reduction};
use swimmer::models::{
    BodySolution, Configuration, Hydrodynamics, InstantaneousSolution, ModelError, Query,
};
use swimmer::scene::Domain;
use swimmer::{Integrator, Method, Scene, SpanResult, SwimError, spans};
use testkit::SceneText;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tensor {
    Oseen,
    Rpy,
}

/// The test model for one scene; for `domain.kind = "wall"` it includes Blake's images.
pub struct TestModel {
    scene: Scene,
    tensor: Tensor,
}

impl TestModel {
    pub fn new(scene: &Scene, tensor: Tensor) -> Self {
        Self {
            scene: scene.clone(),
            tensor,
        }
    }

    fn mobility(&self, centres: &[Vector3<f64>], radii: &[f64]) -> DMatrix<f64> {
        let (n, pi) = (centres.len(), std::f64::consts::PI);
        let mut mobility = DMatrix::zeros(6 * n, 6 * n);
        for i in 0..n {
            for j in 0..n {
                let mut block = if i == j {
                    Matrix3::identity() * (4.0 / (3.0 * radii[i]))
                } else {
                    self.pair(centres[i] - centres[j], radii[i], radii[j])
                };
                if *self.scene.domain() == Domain::Wall {
                    block += image(&centres[i], &centres[j]);
                }
                block /= 8.0 * pi * self.scene.viscosity();
                mobility
                    .fixed_view_mut::<3, 3>(6 * i, 6 * j)
                    .copy_from(&block);
            }
            let rotation =
                Matrix3::identity() / (8.0 * pi * self.scene.viscosity() * radii[i].powi(3));
            mobility
                .fixed_view_mut::<3, 3>(6 * i + 3, 6 * i + 3)
                .copy_from(&rotation);
        }
        mobility
    }

    /// 8 pi mu times the mobility of two spheres apart.
    fn pair(&self, r: Vector3<f64>, a: f64, b: f64) -> Matrix3<f64> {
        let distance = r.norm();
        let outer = r * r.transpose() / (distance * distance);
        let squared = match self.tensor {
            Tensor::Oseen => 0.0,
            Tensor::Rpy => (a * a + b * b) / (distance * distance),
        };
        (Matrix3::identity() * (1.0 + squared / 3.0) + outer * (1.0 - squared)) / distance
    }
}

/// 8 pi mu times Blake's (1971) image of a point force at `y` above the wall z = 0, at `x`.
fn image(x: &Vector3<f64>, y: &Vector3<f64>) -> Matrix3<f64> {
    let h = y.z;
    let r = Vector3::new(x.x - y.x, x.y - y.y, x.z + h);
    let (r1, r3, r5) = (r.norm(), r.norm().powi(3), r.norm().powi(5));
    let delta = |i: usize, j: usize| f64::from(u8::from(i == j));
    Matrix3::from_fn(|i, j| {
        let stokeslet = delta(i, j) / r1 + r[i] * r[j] / r3;
        let dipole = h * (delta(i, j) / r3 - 3.0 * r[i] * r[j] / r5);
        let gradient = -delta(i, 2) * r[j] / r3 + (delta(i, j) * r[2] + r[i] * delta(j, 2)) / r3
            - 3.0 * r[i] * r[2] * r[j] / r5;
        let sign = if j == 2 { -1.0 } else { 1.0 };
        -stokeslet + 2.0 * h * sign * (dipole - gradient)
    })
}

impl Hydrodynamics for TestModel {
    fn name(&self) -> &'static str {
        "rpy"
    }

    fn scene(&self) -> &Scene {
        &self.scene
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        (query.rates.iter())
            .map(|rates| self.solution(query.configuration, rates))
            .collect()
    }
}

impl TestModel {
    fn solution(
        &self,
        configuration: Configuration<'_>,
        rates: &[f64],
    ) -> Result<InstantaneousSolution, ModelError> {
        let set = self.scene.articulation();
        let poses = set.place(configuration.state, configuration.shape)?;
        let constraints = set.constraints(configuration.state, configuration.shape, rates)?;
        let reduction = Reduction::new(set, &constraints)?;
        let layout = set.velocity_layout();
        let rigid: Vec<usize> = (0..poses.len())
            .filter(|&b| set.kinds()[b] == BodyKind::Rigid)
            .collect();
        let centres: Vec<_> = rigid.iter().map(|&b| poses[b].translation.vector).collect();
        let radii: Vec<_> = rigid
            .iter()
            .map(|&b| self.scene.bodies()[b].bounding_radius())
            .collect();
        let resistance = self
            .mobility(&centres, &radii)
            .cholesky()
            .expect("spheres apart")
            .inverse();
        let (s, w) = (&reduction.surface_basis, &reduction.surface_offset);
        let mut loads = DVector::zeros(layout.len());
        for (b, body) in self.scene.bodies().iter().enumerate() {
            loads
                .fixed_rows_mut::<3>(layout.bodies()[b])
                .copy_from(&body.force);
            if rigid.contains(&b) {
                loads
                    .fixed_rows_mut::<3>(layout.bodies()[b] + 3)
                    .copy_from(&body.torque);
            }
        }
        let rhs = reduction.all.basis.transpose() * loads - s.transpose() * &resistance * w;
        let matrix = s.transpose() * &resistance * s;
        let v = if matrix.nrows() > 0 {
            matrix.cholesky().expect("resistance").solve(&rhs)
        } else {
            rhs
        };
        let q = reduction.velocities(&v)?;
        let forces = &resistance * (s * &v + w);
        let at =
            |q: &DVector<f64>, first: usize| Vector3::new(q[first], q[first + 1], q[first + 2]);
        let mut bodies = vec![BodySolution::default(); poses.len()];
        for (b, body) in bodies.iter_mut().enumerate() {
            body.velocity = at(&q, layout.bodies()[b]);
        }
        for (k, &b) in rigid.iter().enumerate() {
            bodies[b].angular_velocity = at(&q, layout.bodies()[b] + 3);
            bodies[b].force = at(&forces, 6 * k);
            bodies[b].torque = at(&forces, 6 * k + 3);
        }
        let motion = set.state_velocity(q.as_slice())?;
        Ok(InstantaneousSolution::new(bodies, Vec::new(), motion))
    }
}

/// The result of a whole gait.
pub struct Run {
    pub spans: Vec<SpanResult>,
    /// Displacement of every body, phase span by phase span.
    pub moves: Vec<Vec<Vector3<f64>>>,
}

impl Run {
    /// Net displacement of a body.
    pub fn net(&self, body: usize) -> Vector3<f64> {
        self.moves.iter().map(|span| span[body]).sum()
    }

    pub fn solves(&self) -> usize {
        self.spans.iter().map(|span| span.solves).sum()
    }

    pub fn integration_error(&self) -> f64 {
        self.spans
            .iter()
            .filter_map(|span| span.error_estimate.integration)
            .sum()
    }
}

/// The gait by the test model, integrated by collocation.
pub fn follow(text: &SceneText) -> Run {
    run(&text.scene(), Tensor::Rpy, Method::Collocation).unwrap()
}

pub fn run(scene: &Scene, tensor: Tensor, method: Method) -> Result<Run, SwimError> {
    run_with(scene, &mut TestModel::new(scene, tensor), method)
}

/// Runs a gait with any model.
pub fn run_with(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    method: Method,
) -> Result<Run, SwimError> {
    let mut integrator = Integrator::new(scene, model, method);
    let mut state = scene.initial_state();
    let mut run = Run {
        spans: Vec::new(),
        moves: Vec::new(),
    };
    for span in spans(scene.gait(), scene.articulation().initial_shape())? {
        let result = integrator.span(&span, &state, &mut |_, _| Ok(()))?;
        let before = scene.articulation().place(&state, &span.from)?;
        let after = scene.articulation().place(&result.end, &span.to)?;
        run.moves.push(
            before
                .iter()
                .zip(&after)
                .map(|(a, b)| b.translation.vector - a.translation.vector)
                .collect(),
        );
        state = result.end.clone();
        run.spans.push(result);
    }
    Ok(run)
}
