//! A second integrator as referee: Radau IIA with two stages, on one mesh and dense matrices.

use fem::TaylorHood;
use inertia::{Convection, Forcing, FrozenMesh, Integrator, Parameters};
use mesh::TetMesh;
use mesher::Container;
use nalgebra::{DMatrix, DVector, Isometry3};
use rigid::ExternalLoad;
use stokes::Options;

use crate::support::{QUARTER, STOKES, Vec3, bodies, free_sphere, sphere_in_ball};

/// A force along z that begins like `t^2`.
struct Pull;

impl Pull {
    fn force(time: f64) -> f64 {
        STOKES * (3.0 * time).sin().powi(2)
    }
}

impl Forcing for Pull {
    fn load(&self, time: f64, _: usize, _: &Isometry3<f64>) -> ExternalLoad {
        ExternalLoad {
            force: Vec3::z() * Self::force(time),
            torque: Vec3::zeros(),
        }
    }
}

/// Semi-discrete unsteady Stokes flow around a free sphere with small displacements,
/// `M dv/dt + K v + B^T p = F(t) e`, `B v = 0`: free velocities of a quarter of the fluid, last the
/// speed of the sphere.
struct SemiDiscrete {
    mass: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    /// Without the row of one vertex: the pressure has no level.
    divergence: DMatrix<f64>,
}

impl SemiDiscrete {
    /// Fluid of this density; the sphere of radius 1 has the mass `mass`.
    fn new(mesh: &TetMesh, density: f64, mass: f64) -> Self {
        let space = TaylorHood::new(mesh).unwrap();
        let nodes = |name: &str| mesh.nodes_on(mesh.tag(name).unwrap());
        let mut is_free = vec![[true; 3]; mesh.n_points()];
        for (node, planes) in mesh.nodes_on_symmetry_planes() {
            for (free, plane) in is_free[node as usize].iter_mut().zip(planes) {
                *free &= !plane;
            }
        }
        for node in nodes("sphere").into_iter().chain(nodes(Container::TAG)) {
            is_free[node as usize] = [false; 3];
        }
        let mut dofs = vec![[None; 3]; mesh.n_points()];
        let mut count = 0;
        for (dofs, free) in dofs.iter_mut().zip(is_free) {
            for (dof, free) in dofs.iter_mut().zip(free) {
                if free {
                    *dof = Some(count);
                    count += 1;
                }
            }
        }
        for node in nodes("sphere") {
            dofs[node as usize][2] = Some(count);
        }
        let vector = |matrix: linalg::Csr| {
            let mut dense = DMatrix::zeros(count + 1, count + 1);
            for (&value, (i, j)) in matrix.iter() {
                for axis in 0..3 {
                    if let (Some(i), Some(j)) = (dofs[i as usize][axis], dofs[j as usize][axis]) {
                        dense[(i, j)] += value;
                    }
                }
            }
            dense
        };
        let mut of_mass = vector(space.velocity_mass(mesh).unwrap()) * density;
        of_mass[(count, count)] += mass / 4.0;
        let mut divergence = DMatrix::zeros(mesh.n_vertices() - 1, count + 1);
        for (value, (i, j)) in space.divergence(mesh).unwrap().iter() {
            for axis in 0..3 {
                if let (true, Some(j)) = (i > 0, dofs[j as usize][axis]) {
                    divergence[(i as usize - 1, j)] += value[axis];
                }
            }
        }
        Self {
            mass: of_mass,
            stiffness: vector(space.stiffness(mesh).unwrap()),
            divergence,
        }
    }

    /// Speeds at the ends of steps of Radau IIA of order 3 (Hairer & Wanner, Solving Ordinary
    /// Differential Equations II, section IV.5), from rest.
    ///
    /// The stages `v_i = v + h sum_j a_ij k_j` solve `M k_i + K v_i + B^T p_i = F(t + c_i h) e` and
    /// `B k_i = 0`, one system for both.
    fn radau(&self, end: f64, steps: usize) -> Vec<f64> {
        let h = end / steps as f64;
        let a = [[5.0 / 12.0, -1.0 / 12.0], [3.0 / 4.0, 1.0 / 4.0]];
        let c = [1.0 / 3.0, 1.0];
        let (n, rows) = (self.mass.nrows(), self.divergence.nrows());
        let size = n + rows;
        let mut matrix = DMatrix::zeros(2 * size, 2 * size);
        for i in 0..2 {
            for j in 0..2 {
                let block = &self.stiffness * (h * a[i][j]);
                (matrix.view_mut((i * size, j * size), (n, n))).copy_from(&block);
            }
            let mut own = matrix.view_mut((i * size, i * size), (size, size));
            let mut velocities = own.view_mut((0, 0), (n, n));
            velocities += &self.mass;
            (own.view_mut((n, 0), (rows, n))).copy_from(&self.divergence);
            (own.view_mut((0, n), (n, rows))).copy_from(&self.divergence.transpose());
        }
        let factors = matrix.lu();
        let mut velocity = DVector::<f64>::zeros(n);
        let mut speeds = vec![0.0];
        for step in 0..steps {
            let mut rhs = DVector::zeros(2 * size);
            let resisted = &self.stiffness * &velocity;
            for i in 0..2 {
                (rhs.rows_mut(i * size, n)).copy_from(&-&resisted);
                rhs[i * size + n - 1] += Pull::force((step as f64 + c[i]) * h) / 4.0;
            }
            let rates = factors.solve(&rhs).unwrap();
            // stiffly accurate: the second stage is the end of the step
            for j in 0..2 {
                velocity += rates.rows(j * size, n) * (h * a[1][j]);
            }
            speeds.push(velocity[n - 1]);
        }
        speeds
    }
}

/// Speeds at the ends of steps of the integrator.
fn integrated(mesh: &TetMesh, (density, of_body): (f64, f64), end: f64, steps: usize) -> Vec<f64> {
    let set = free_sphere(Vec3::zeros());
    let options = Options::default().with_rtol(1e-11);
    let parameters = Parameters::new(density)
        .with_convection(Convection::Neglected)
        .with_options(options);
    let meshes = Box::new(FrozenMesh(mesh.clone()));
    let mut run =
        Integrator::from_rest(bodies(&set, of_body), &Pull, meshes, parameters, 0.0).unwrap();
    let length = end / steps as f64;
    let speeds = (0..steps).map(|_| run.step(length).unwrap().bodies[2]);
    [0.0].into_iter().chain(speeds).collect()
}

/// Both integrate the same equations: the difference between them is the error of BDF2, which falls
/// with the second order, and the limit of this order is what Radau's method finds.
#[test]
fn bdf2_tends_to_what_radau_iia_finds_on_the_same_mesh() {
    let mesh = sphere_in_ball(0.9, 3.0, QUARTER);
    let (end, density) = (1.0, 2.0);
    let largest = |a: &[f64], b: &[f64]| {
        let times = (0..=10).map(|k| [a, b].map(|list| list[k * (list.len() - 1) / 10]));
        times.fold(0.0_f64, |largest, [a, b]| largest.max((a - b).abs()))
    };
    for of_body in [0.0, 5.0] {
        let mass = bodies(&free_sphere(Vec3::zeros()), of_body).masses[0].mass;
        let equations = SemiDiscrete::new(&mesh, density, mass);
        let [coarse, referee] = [20, 40].map(|steps| equations.radau(end, steps));
        let [half, quarter] =
            [40, 80].map(|steps| integrated(&mesh, (density, of_body), end, steps));
        let of_half = half.iter().step_by(4).zip(quarter.iter().step_by(8));
        let limit: Vec<f64> = of_half.map(|(a, b)| b + (b - a) / 3.0).collect();
        let errors = [&half, &quarter].map(|speeds| largest(speeds, &referee));
        let order = (errors[0] / errors[1]).log2();
        let of_limit = largest(&limit, &referee);
        let of_referee = largest(&coarse, &referee);
        println!("{of_body}: {errors:?}, order {order}, limit {of_limit:e}, {of_referee:e}");
        // Of the third order: what is left in the referee is a seventh of its change.
        assert!(of_referee < 0.5 * errors[1], "{of_referee:e} {errors:?}");
        assert!((order - 2.0).abs() < 0.2, "{order}");
        // a term of the third order in steps of 1/80 of the time, of which a period takes 170
        assert!(of_limit < 0.1 * errors[1], "{of_limit:e} {errors:?}");
    }
}
