//! Connection and dissipation metric of a free swimmer at one shape.

use models::{Configuration, Hydrodynamics, InstantaneousSolution, ModelError, Query};
use nalgebra::DMatrix;
use rigid::Twist;
use scene::Scene;

use swimmer::check_model;

use crate::error::DesignError;

/// Connection `A` and dissipation metric `G` at one shape `s`, with error bars.
///
/// Without inertia and loads, the twist of the frame is `A(s) ds/dt` and the power on the fluid is
/// `ds/dt · G(s) ds/dt` (Shapere & Wilczek 1989).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Connection {
    /// Joints whose values are the shape, in the order of the scene.
    pub variables: Vec<usize>,
    /// `A`: twist of the frame for a unit rate of each variable, in the attitude of the scene.
    pub twists: Vec<Twist>,
    /// Error bar of the velocities for a unit rate of each variable.
    pub velocity_errors: Vec<f64>,
    /// `G`, symmetric; rows and columns are the variables.
    pub metric: DMatrix<f64>,
    /// Error bars of `G`.
    ///
    /// They are those of the power on the diagonal. Truncation of a mesh or of an expansion changes
    /// the dissipation by a semidefinite form, so off the diagonal the geometric mean of two
    /// diagonal entries is a bound (Cauchy-Schwarz).
    pub metric_errors: DMatrix<f64>,
}

/// Connection and dissipation metric at the values `shape` of the joints that can change theirs.
///
/// Cost: one configuration with one set of rates per variable.
///
/// # Errors
/// [`DesignError::NotApplicable`] for a swimmer whose motion depends on more than the shape, and
/// for a shape with another number of values;
/// [`SwimError::OtherScene`](swimmer::SwimError::OtherScene); those of the model.
///
/// # Examples
/// Two spheres far apart: each covers half of the change of their distance.
///
/// ```
/// use design::connection;
/// use swimmer::{Scene, choose};
/// let scene = Scene::builder()
///     .sphere("left", 1.0, [0.0, 0.0, 0.0])
///     .sphere("right", 1.0, [10.0, 0.0, 0.0])
///     .slide("arm", "right", "left")
///     .build()?;
/// let mut model = choose(&scene)?.model;
/// let found = connection(&scene, model.as_mut(), &[10.0])?;
/// assert!((found.twists[0].linear.x + 0.5).abs() < 1e-12);
/// # Ok::<(), design::DesignError>(())
/// ```
pub fn connection(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    shape: &[f64],
) -> Result<Connection, DesignError> {
    check_model(scene, model)?;
    DesignError::check_rheology(scene)?;
    let set = scene.articulation();
    if !scene.is_free() {
        return Err(DesignError::not_applicable(
            scene,
            "domain.kind",
            "the connection requires a motion that depends only on the shape: one linkage in \
             unbounded fluid without loads, slip, masses and passive joints",
        ));
    }
    let joints = set.joints().iter().enumerate();
    let variables: Vec<usize> = joints
        .filter(|(_, joint)| joint.kind.has_value())
        .map(|(number, _)| number)
        .collect();
    let shape = full_shape(scene, &variables, shape)?;
    let unit_rate = |&joint: &usize| {
        let mut rates = vec![0.0; shape.len()];
        rates[joint] = 1.0;
        rates
    };
    let rates: Vec<Vec<f64>> = variables.iter().map(unit_rate).collect();
    let state = scene.initial_state();
    let configuration = Configuration::new(&state, &shape);
    let solutions = model.solve(&Query::new(configuration, &rates))?;
    if solutions.len() != rates.len() {
        let model = model.name();
        return Err(ModelError::NoSolution { model }.into());
    }
    for solution in &solutions {
        solution.check(model)?;
    }
    let n = solutions.len();
    let power = |i: usize, j: usize| solutions[i].response.power_in(&solutions[j].response);
    let power_error = |i: usize| solutions[i].power_error.total();
    let of_frame = |solution: &InstantaneousSolution| solution.motion.frames[0];
    Ok(Connection {
        variables,
        twists: solutions.iter().map(of_frame).collect(),
        velocity_errors: (solutions.iter())
            .map(|solution| solution.error_estimate.total())
            .collect(),
        // Symmetric by Lorentz reciprocity, up to the errors of the model.
        metric: DMatrix::from_fn(n, n, |i, j| 0.5 * (power(i, j) + power(j, i))),
        metric_errors: DMatrix::from_fn(n, n, |i, j| (power_error(i) * power_error(j)).sqrt()),
    })
}

/// Values of all joints, from those of the joints that can change theirs.
fn full_shape(scene: &Scene, variables: &[usize], shape: &[f64]) -> Result<Vec<f64>, DesignError> {
    let set = scene.articulation();
    if shape.len() != variables.len() {
        let problem = format!(
            "the shape has {} values, and {} links can change theirs ({}); give one value each",
            shape.len(),
            variables.len(),
            scene.joint_label(variables)
        );
        return Err(DesignError::not_applicable(scene, "links", problem));
    }
    let mut full = set.initial_shape().to_vec();
    for (&number, &value) in variables.iter().zip(shape) {
        let joint = &set.joints()[number];
        if !(value.is_finite() && (value > 0.0 || joint.kind.is_signed())) {
            let problem = format!(
                "the value {value} of \"{}\" is no angle, amplitude or positive length",
                joint.name
            );
            let key = format!("links[{number}]");
            return Err(DesignError::not_applicable(scene, &key, problem));
        }
        full[number] = value;
    }
    Ok(full)
}
