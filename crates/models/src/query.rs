//! Input of models: a configuration, rates of the joints, and what the solutions contain.

use nalgebra::{DVector, Matrix6};
use rigid::{ExternalLoad, State};

/// Positions of the bodies (the state of the articulated set and the values of its joints), and the
/// time.
#[derive(Clone, Copy, Debug)]
pub struct Configuration<'a> {
    /// Frames of the linkages and attitudes of the bodies, for [`rigid::Articulation::place`].
    pub state: &'a State,
    /// Value of each joint: the length of a slide in the scene's units, or an angle. Those of
    /// passive joints are part of the state, and their entries have no effect.
    pub shape: &'a [f64],
    /// Time, on which forces on joints, loads on bodies and the magnetic field may depend.
    pub time: f64,
}

impl<'a> Configuration<'a> {
    /// The configuration at the time zero.
    pub fn new(state: &'a State, shape: &'a [f64]) -> Self {
        Self {
            state,
            shape,
            time: 0.0,
        }
    }

    /// The same configuration at another time.
    #[must_use]
    pub fn at_time(self, time: f64) -> Self {
        Self { time, ..self }
    }
}

/// Input of a model: one configuration and one or several sets of joint rates.
///
/// ```
/// # let state = rigid::State { frames: vec![], attitudes: vec![], joints: vec![] };
/// use models::{Configuration, Query};
/// let rates = [vec![-4.0, 0.0]];
/// let configuration = Configuration::new(&state, &[10.0, 10.0]);
/// let query = Query::new(configuration, &rates).without_estimates();
/// assert!(!query.estimates && query.accuracy.is_none());
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Query<'a> {
    /// Positions of the bodies.
    pub configuration: Configuration<'a>,
    /// One set of rates per solution: the rate of change of each joint, in the scene's units.
    pub rates: &'a [Vec<f64>],
    /// Whether to estimate discretisation errors
    /// ([`mesh_error`](crate::InstantaneousSolution::mesh_error)).
    pub estimates: bool,
    /// Relative discretisation error of velocities and forces to which the mesh is adapted; `None`
    /// for the usual mesh.
    pub accuracy: Option<f64>,
    /// Inertia of the bodies over an implicit time step, one entry per body of the scene.
    pub inertia: Option<&'a [BodyInertia]>,
    /// Loads conjugate to the generalised velocities
    /// ([`VelocityLayout`](rigid::VelocityLayout)) in addition to those of the scene, such as
    /// those of [`Fluctuations`](crate::Fluctuations); for models with these alone. Solutions then
    /// have no error bars, and the power of these loads, which is the fluid's own, does not count.
    pub random_loads: Option<&'a DVector<f64>>,
    /// Whether to compute stresslets where they cost an additional solve
    /// ([`stresslets`](crate::InstantaneousSolution::stresslets)).
    pub stresslets: bool,
    /// Whether solutions carry their flow, which takes memory as long as it is kept
    /// ([`flow`](crate::InstantaneousSolution::flow)).
    pub flows: bool,
}

/// Terms of an implicit time step for a body with mass, in the scene's units.
///
/// The momentum changes at the rate `dp/dt = D (U, ω) - L`, with the mass matrix over the time step
/// `D` and the known momentum over the time step `L`. In the equations `D` adds to the resistance
/// of the fluid and `L` to the external loads. Forces on the fluid contain neither, forces of
/// joints contain both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyInertia {
    /// `D`, symmetric, in the laboratory axes.
    pub damping: Matrix6<f64>,
    /// `L`.
    pub load: ExternalLoad,
}

impl<'a> Query<'a> {
    /// A query with error estimates, on the usual mesh.
    pub fn new(configuration: Configuration<'a>, rates: &'a [Vec<f64>]) -> Self {
        Self {
            configuration,
            rates,
            estimates: true,
            accuracy: None,
            inertia: None,
            random_loads: None,
            stresslets: false,
            flows: false,
        }
    }

    /// The same query with the inertia of the bodies over an implicit time step.
    #[must_use]
    pub fn with_inertia(self, inertia: &'a [BodyInertia]) -> Self {
        Self {
            inertia: Some(inertia),
            ..self
        }
    }

    /// The same query with random loads.
    #[must_use]
    pub fn with_random_loads(self, loads: &'a DVector<f64>) -> Self {
        Self {
            random_loads: Some(loads),
            ..self
        }
    }

    /// The same query with the stresslets of the bodies.
    #[must_use]
    pub fn with_stresslets(self) -> Self {
        Self {
            stresslets: true,
            ..self
        }
    }

    /// The same query with or without the flow of each solution.
    #[must_use]
    pub fn with_flows(self, flows: bool) -> Self {
        Self { flows, ..self }
    }

    /// The same query without error estimates.
    #[must_use]
    pub fn without_estimates(self) -> Self {
        self.with_estimates(false)
    }

    /// The same query with or without error estimates.
    #[must_use]
    pub fn with_estimates(self, estimates: bool) -> Self {
        Self { estimates, ..self }
    }

    /// The same query on a mesh that is adapted to the relative `accuracy`, if one is given.
    ///
    /// If the accuracy is not reached, the error bars of the solution are larger than it.
    #[must_use]
    pub fn with_accuracy(self, accuracy: Option<f64>) -> Self {
        Self { accuracy, ..self }
    }
}
