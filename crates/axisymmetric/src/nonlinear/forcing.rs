//! What drives bodies in a fluid with inertia, as functions of time.

/// What drives the bodies and the walls; all of it is evaluated at the end of a step.
///
/// Bodies without given displacements, loads and slip need no method: `()` is the forcing of a flow
/// that only decays.
pub trait AxialForcing: Sync {
    /// Displacement of a body along the axis: of a prescribed body in the laboratory, of a free one
    /// relative to its swimmer.
    ///
    /// Only differences count. Velocities follow by the formula of the time step, so that they and
    /// the motion of the mesh belong to one scheme.
    fn displacement(&self, _time: f64, _body: usize) -> f64 {
        0.0
    }

    /// External force along the axis on a body.
    fn load(&self, _time: f64, _body: usize) -> f64 {
        0.0
    }

    /// Whether surfaces move relative to their bodies; without it `slip` is not called.
    fn has_slip(&self) -> bool {
        false
    }

    /// Velocity of the surface of a body relative to it, along the axis and away from it, at the
    /// point `x` relative to the centre of the body.
    fn slip(&self, _time: f64, _body: usize, _x: [f64; 2]) -> [f64; 2] {
        [0.0, 0.0]
    }

    /// Velocity of the wall along the axis. The domain does not move with it.
    fn wall_velocity(&self, _time: f64) -> f64 {
        0.0
    }
}

impl AxialForcing for () {}
