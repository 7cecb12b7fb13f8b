//! Finite elements: P2-P1 on a body-fitted mesh that follows the shape.

mod adapt;
mod checks;
mod estimate;
mod far_field;
mod mesh_file;
mod mesher;
mod meshes;
pub(super) mod scale;
mod solve;

use std::time::Instant as Clock;

use linalg::WarmStart;
use mesh::TetMesh;
use nalgebra::{DMatrix, Isometry3, Vector3};
use rigid::{Articulation, Constrained, Constraints, Drive, Formulation, Load, Twist};

use self::estimate::{Duals, Estimate};
use self::far_field::FarField;
pub use self::mesher::{COARSEST_FACTOR, growth};
use self::meshes::{Meshes, ShapeMesh};
use self::scale::Scale;
use self::solve::{Boundary, SolvedFlow};
use crate::model::{
    BodyInstant, Cost, Dofs, ErrorEstimate, Flow, Hydrodynamics, Instant, MeshError, ModelError,
    Placement, Remesh,
};
use crate::scene::{Domain, EstimatesKind, FemOptions, Scene};

/// Taylor-Hood finite elements with curved surfaces, on meshes generated and moved as the shape asks.
pub struct FemModel {
    scale: Scale,
    /// The bodies and links in units of the flow.
    set: Articulation,
    loads: Vec<Load>,
    meshes: Meshes,
    /// Of unbounded fluid.
    far_field: Option<FarField>,
    options: FemOptions,
    estimates: bool,
    duals: Duals,
    /// Solutions of the leg on the mesh in use. Forgotten between legs, where checkpoints are taken, so that these need not carry them: the
    /// first solves of a leg gained nothing from them, for another link moves.
    warm: WarmStart,
    /// Cells' shares in the errors of the last instant's forces and velocities.
    shares: Option<[Vec<f64>; 2]>,
    last: Option<(TetMesh, rigid::Flow)>,
}

/// Solutions that the next solve starts from: a leg has six Gauss points, and each takes 8 bytes an unknown.
const REMEMBERED: usize = 5;

/// Rounds of adapting: two or three reach a thousandth from the coarsest mesh, and one more each next digit.
const MOST_ADAPTATIONS: usize = 8;

/// Seconds a dof for assembly, set-up and solve to 1e-8 on two cores, from the three-sphere scene.
const SECONDS_PER_DOF: f64 = 4e-6;

/// Kibibytes a dof at the peak, from the three-sphere scene.
const KIB_PER_DOF: f64 = 1.2;

impl FemModel {
    /// The model of a scene; meshes are made when the first shape is asked for.
    ///
    /// # Errors
    /// A domain or an option that is not built yet.
    pub fn new(scene: &Scene) -> Result<Self, ModelError> {
        if let (Domain::Unbounded, Some(&body)) = (&scene.domain, scene.fixed_bodies().first()) {
            // Infinity would be answered by a uniform flow, which moves what is held.
            return Err(ModelError::NotBuilt {
                what: format!(
                    "{}: finite elements in unbounded fluid around a fixed body",
                    scene.place(&format!("bodies[{body}].fixed"))
                ),
                instead: "use model.kind = \"multipole\" or domain.kind = \"ball\"".to_owned(),
            });
        }
        let scale = Scale::of(scene);
        let kinds: Vec<_> = scene.bodies.iter().map(|b| b.kind()).collect();
        let positions: Vec<_> = scene
            .bodies
            .iter()
            .map(|b| scale.point(b.position))
            .collect();
        let set = Articulation::new(
            &kinds,
            scene.articulation.links().to_vec(),
            scene.articulation.arms(),
            &positions,
        )?
        .with_fixed(&scene.fixed_bodies())?;
        Ok(Self {
            scale,
            set,
            loads: scene
                .bodies
                .iter()
                .map(|b| scale.load(b.force, b.torque))
                .collect(),
            meshes: Meshes::new(scene, &scale)?,
            far_field: FarField::of(scene, &scale),
            options: scene.fem,
            estimates: scene.fem.estimates == EstimatesKind::On,
            duals: Duals::new(),
            warm: WarmStart::new(REMEMBERED),
            shares: None,
            last: None,
        })
    }

    /// The placement's mesh in units of the flow, with the poses of all bodies.
    fn shape_mesh(
        &mut self,
        placement: &Placement,
    ) -> Result<(ShapeMesh, Vec<Isometry3<f64>>), ModelError> {
        let lengths: Vec<f64> = placement
            .lengths
            .iter()
            .map(|&l| self.scale.length(l))
            .collect();
        let poses = self
            .set
            .place(&self.scale.state(placement.state), &lengths)?;
        let shape = self.meshes.at(&poses)?;
        Ok((shape, poses))
    }

    /// The system of one placement in units of the flow, for solvers of one's own.
    ///
    /// # Errors
    /// As [`Hydrodynamics::instant`], up to the solve.
    pub fn system(
        &mut self,
        placement: &Placement<'_>,
        formulation: &dyn Formulation,
    ) -> Result<Constrained, ModelError> {
        let (ShapeMesh { mesh, .. }, poses) = self.shape_mesh(placement)?;
        let constraints = self.constraints(placement)?;
        let drive = Drive {
            set: &self.set,
            constraints: &constraints,
            loads: &self.loads,
        };
        let space = self.meshes.space().ok_or(ModelError::NoMesh)?;
        solve::assemble(space, &mesh, &self.boundary(&poses), &drive, formulation)
    }

    /// The links' constraints of a placement in units of the flow.
    fn constraints(&self, placement: &Placement) -> Result<Constraints, ModelError> {
        let scaled =
            |list: &[f64]| -> Vec<f64> { list.iter().map(|&l| self.scale.length(l)).collect() };
        let state = self.scale.state(placement.state);
        let (lengths, rates) = (scaled(placement.lengths), scaled(placement.rates));
        Ok(self.set.constraints(&state, &lengths, &rates)?)
    }

    fn boundary(&self, poses: &[Isometry3<f64>]) -> Boundary<'_> {
        let surfaced = self.meshes.surfaced_bodies();
        Boundary {
            bodies: self.meshes.tags().collect(),
            centres: surfaced
                .map(|body| poses[body].translation.vector)
                .collect(),
            walls: self.meshes.wall_tags(),
        }
    }

    /// Meshes the placement anew, so that both relative errors become at most `allowed`; false if meshes cannot be made here.
    fn adapt(
        &mut self,
        placement: &Placement,
        errors: [f64; 2],
        allowed: f64,
    ) -> Result<bool, ModelError> {
        let (ShapeMesh { mesh, .. }, poses) = self.shape_mesh(placement)?;
        let Some(shares) = self.shares.take() else {
            return Ok(false);
        };
        // Both count by how far they are off, and cells by their part in each.
        let mut of_cells = vec![0.0; mesh.n_cells()];
        for (shares, error) in shares.iter().zip(errors) {
            let sum: f64 = shares.iter().map(|share| share.abs()).sum();
            if sum > 0.0 {
                for (cell, share) in of_cells.iter_mut().zip(shares) {
                    *cell += error / allowed * share.abs() / sum;
                }
            }
        }
        let wanted = adapt::wanted_sizes(&mesh, &of_cells);
        self.meshes.adapt(&poses, wanted)
    }

    fn in_scene_units(
        &self,
        solved: SolvedFlow,
        remeshed: Option<Remesh>,
        poses: &[Isometry3<f64>],
    ) -> Instant {
        let flow = &solved.flow;
        let mut bodies = vec![BodyInstant::default(); self.set.kinds().len()];
        let layout = self.set.velocity_layout();
        let at = |first: usize| Vector3::from_fn(|axis, _| flow.generalised[first + axis]);
        for (body, entry) in bodies.iter_mut().enumerate() {
            entry.velocity = self.scale.velocity_back(at(layout.body(body)));
            entry.angular_velocity = flow.state.spins[body];
        }
        for (number, body) in self.meshes.surfaced_bodies().enumerate() {
            let part =
                |first: usize| Vector3::from_fn(|axis, _| flow.forces[6 * number + first + axis]);
            bodies[body].force = self.scale.force_back(part(0));
            bodies[body].torque = self.scale.torque_back(part(3));
        }
        let link_forces = (0..self.set.links().len())
            .map(|link| self.scale.force_back(flow.link_force(link)))
            .collect();
        let speed = largest(bodies.iter().map(|b| b.velocity));
        let container = self.far_field.map_or(0.0, |far| {
            let radii = self.meshes.surfaced_bodies().zip(self.meshes.radii());
            far.relative_error(radii.map(|(body, radius)| (poses[body].translation.vector, radius)))
        });
        Instant {
            bodies,
            link_forces,
            motion: self.scale.motion_back(&flow.state),
            dofs: solved.dofs,
            // A container of the scene's own is no error, and nothing of Stokes flow is left out.
            error_estimate: ErrorEstimate {
                container: Some(container * speed),
                model: Some(0.0),
                algebraic: Some(solved.relative_error * speed),
                ..ErrorEstimate::default()
            },
            mesh_error: None,
            checks: solved.checks,
            solver: solved.solver,
            seconds: solved.seconds,
            remeshed,
        }
    }
}

impl FemModel {
    /// Adds what the wall that stands for infinity took from all velocities.
    fn add_taken(&self, far: FarField, flow: &mut rigid::Flow) {
        let entry = |body: usize, axis: usize| flow.forces[6 * body + axis];
        let forces = (0..flow.forces.len() / 6)
            .map(|body| Vector3::from_fn(|axis, _| entry(body, axis)))
            .sum();
        let taken = far.taken(forces);
        flow.velocity.iter_mut().for_each(|u| *u += taken);
        let layout = self.set.velocity_layout();
        for body in 0..self.set.kinds().len() {
            let mut velocity = flow.generalised.fixed_rows_mut::<3>(layout.body(body));
            velocity += taken;
        }
        for frame in &mut flow.state.frames {
            frame.linear += taken;
        }
        for body in 0..flow.bodies.len() / 6 {
            let mut velocity = flow.bodies.fixed_rows_mut::<3>(6 * body);
            velocity += taken;
        }
    }
}

/// The largest of their norms.
fn largest(vectors: impl Iterator<Item = Vector3<f64>>) -> f64 {
    vectors.fold(0.0, |m, v| m.max(v.norm()))
}

/// Enters estimated errors into an instant in the scene's units.
impl FemModel {
    fn enter_errors(&self, instant: &mut Instant, estimate: &Estimate, poses: &[Isometry3<f64>]) {
        let force = largest(instant.bodies.iter().map(|b| b.force));
        let by_mesh = {
            let mut errors = vec![Vector3::zeros(); poses.len()];
            for (linkage, frame) in self.set.linkages().iter().zip(&estimate.frames) {
                for &body in &linkage.bodies {
                    let [at, root] = [body, linkage.root].map(|b| poses[b].translation.vector);
                    let error = frame.linear + frame.angular.cross(&(at - root));
                    errors[body] = self.scale.velocity_back(error);
                }
            }
            errors
        };
        let spread = self.scale.speed_back(estimate.spread);
        instant.error_estimate.mesh = Some(largest(by_mesh.iter().copied()).hypot(spread));
        instant.mesh_error = Some(MeshError {
            frames: estimate
                .frames
                .iter()
                .map(|frame| Twist {
                    linear: self.scale.velocity_back(frame.linear),
                    angular: frame.angular,
                })
                .collect(),
            bodies: by_mesh,
            spread,
            // Where no link holds, forces are the loads.
            force: if self.set.links().is_empty() {
                0.0
            } else {
                estimate.relative_energy * force
            },
        });
    }
}

impl Hydrodynamics for FemModel {
    fn name(&self) -> &'static str {
        "fem"
    }

    fn want_estimates(&mut self, wanted: bool) -> bool {
        self.estimates = wanted && self.options.estimates == EstimatesKind::On;
        self.estimates
    }

    fn begin_leg(&mut self) {
        self.warm.clear();
        self.duals.clear();
    }

    fn instant(&mut self, placement: &Placement<'_>) -> Result<Instant, ModelError> {
        let clock = Clock::now();
        let (shape, poses) = self.shape_mesh(placement)?;
        let (mesh, remeshed) = (shape.mesh, shape.remeshed);
        // taken out while the rest of `self` is borrowed, and lost if the solve fails
        let mut duals = std::mem::take(&mut self.duals);
        let mesh_seconds = clock.elapsed().as_secs_f64();
        let constraints = self.constraints(placement)?;
        let drive = Drive {
            set: &self.set,
            constraints: &constraints,
            loads: &self.loads,
        };
        let mut warm = std::mem::replace(&mut self.warm, WarmStart::new(REMEMBERED));
        if shape.other_cells {
            // solutions on another mesh have other unknowns
            duals.clear();
            warm.clear();
        }
        if self.estimates {
            self.meshes.prepare_estimates()?;
        }
        let boundary = self.boundary(&poses);
        let space = self.meshes.space().ok_or(ModelError::NoMesh)?;
        let mut solved = solve::solve(
            space,
            &mesh,
            &boundary,
            &drive,
            &self.options,
            &mut warm,
            self.meshes
                .surplus_space()
                .filter(|_| self.estimates)
                .map(|surplus| (surplus, &mut duals)),
        )?;
        self.warm = warm;
        solved.seconds.mesh = mesh_seconds;
        solved.seconds.total = clock.elapsed().as_secs_f64();
        self.duals = duals;
        if let Some(far) = self.far_field {
            self.add_taken(far, &mut solved.flow);
        }
        self.last = Some((mesh, solved.flow.clone()));
        let estimate = solved.estimate.take();
        let mut instant = self.in_scene_units(solved, remeshed, &poses);
        if let Some(estimate) = &estimate {
            self.enter_errors(&mut instant, estimate, &poses);
        }
        self.shares = estimate.map(|estimate| estimate.shares);
        Ok(instant)
    }

    fn instant_within(
        &mut self,
        placement: &Placement<'_>,
        error: f64,
    ) -> Result<Instant, ModelError> {
        self.want_estimates(true);
        let mut instant = self.instant(placement)?;
        for _ in 0..MOST_ADAPTATIONS {
            let errors = instant.relative_mesh_errors();
            let is_fixed = self.options.size_factor.is_some();
            if is_fixed
                || errors.iter().all(|own| *own <= error)
                || !self.adapt(placement, errors, error)?
            {
                break;
            }
            instant = self.instant(placement)?;
        }
        Ok(instant)
    }

    fn resistance(&mut self, placement: &Placement<'_>) -> Result<DMatrix<f64>, ModelError> {
        let (ShapeMesh { mesh, .. }, poses) = self.shape_mesh(placement)?;
        let boundary = self.boundary(&poses);
        let space = self.meshes.space().ok_or(ModelError::NoMesh)?;
        let grand = solve::resistance(space, &mesh, &boundary, self.options.rtol)?;
        let resistance = match self.far_field {
            Some(far) => far.corrected(grand.resistance)?,
            None => grand.resistance,
        };
        Ok(self.scale.resistance_back(resistance))
    }

    fn history(&self) -> Vec<Isometry3<f64>> {
        self.meshes.reference_poses()
    }

    fn restore(&mut self, history: &[Isometry3<f64>]) -> Result<(), ModelError> {
        self.meshes.restore(history)
    }

    fn cost(&mut self, placement: &Placement<'_>) -> Result<Cost, ModelError> {
        let (ShapeMesh { mesh, .. }, _) = self.shape_mesh(placement)?;
        let on_boundary = {
            let mut nodes: Vec<u32> = mesh.facets().iter().flat_map(|facet| facet.nodes).collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes.len()
        };
        let velocity = 3 * (mesh.n_points() - on_boundary);
        let dofs = Dofs {
            velocity,
            pressure: mesh.n_vertices(),
            total: velocity + mesh.n_vertices() + 6,
        };
        Ok(Cost {
            dofs,
            seconds: SECONDS_PER_DOF * dofs.total as f64,
            mib: KIB_PER_DOF * dofs.total as f64 / 1024.0,
        })
    }

    fn mesh(&mut self, placement: &Placement<'_>) -> Result<Option<TetMesh>, ModelError> {
        let (ShapeMesh { mesh, .. }, _) = self.shape_mesh(placement)?;
        let points = mesh
            .points()
            .iter()
            .map(|&x| self.scale.point_back(x))
            .collect();
        Ok(Some(mesh.with_points(points)?))
    }

    fn flow(&self) -> Option<Flow> {
        let (mesh, flow) = self.last.as_ref()?;
        let points = mesh
            .points()
            .iter()
            .map(|&x| self.scale.point_back(x))
            .collect();
        Some(Flow {
            mesh: mesh.with_points(points).ok()?,
            velocity: flow
                .velocity
                .iter()
                .map(|&u| self.scale.velocity_back(u))
                .collect(),
            pressure: flow
                .pressure
                .iter()
                .map(|&p| self.scale.pressure_back(p))
                .collect(),
        })
    }
}
