//! The velocity constraints that links put on bodies: rows of `C q = w`.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::articulation::check_length;
use crate::{Arms, Articulation, BodyKind, RigidError, State, StateVelocity, Twist};

/// Where the velocities of bodies and frames stand in the vector of generalised velocities `q`.
///
/// Order: the bodies one after the other (rigid: `U`, `omega`; point: `U`), then the angular velocity of the frame
/// of each linkage of two or more bodies, unless arms keep their direction ([`Arms::Lab`]).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VelocityLayout {
    bodies: Vec<usize>,
    frames: Vec<Option<usize>>,
    len: usize,
}

impl VelocityLayout {
    /// Number of generalised velocities.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// First entry of a body's velocity; a rigid body's angular velocity follows its velocity.
    pub fn body(&self, body: usize) -> usize {
        self.bodies[body]
    }

    /// First entry of the angular velocity of a linkage's frame, when it is an unknown of its own.
    pub fn frame(&self, linkage: usize) -> Option<usize> {
        self.frames[linkage]
    }
}

/// The rows `C q = w` that links put on the generalised velocities.
///
/// For a link of length $l$ and direction $e$ from `to` to `body`, on a frame of angular velocity $\Omega$:
/// $U_{body} - U_{to} - \Omega \times (x_{body} - x_{to}) = \dot l e$; bodies clamped to their arms add
/// $\omega_i - \Omega = 0$, fixed ones $U_i = 0$, $\omega_i = 0$. With [`Arms::Lab`], $\Omega = 0$ and the rows are equation (11) of Berti et al. (2021).
#[derive(Clone, Debug)]
pub struct Constraints {
    /// `C`, one row a scalar constraint.
    pub matrix: DMatrix<f64>,
    /// `w`.
    pub rates: DVector<f64>,
    /// For each row, what to call it in a message: the link's or the body's name.
    pub labels: Vec<String>,
    /// Meaning of the columns.
    pub layout: VelocityLayout,
}

impl Articulation {
    /// Where each velocity stands in the vector of generalised velocities.
    pub fn velocity_layout(&self) -> VelocityLayout {
        let mut len = 0;
        let bodies = self
            .kinds()
            .iter()
            .map(|kind| {
                let first = len;
                len += if *kind == BodyKind::Rigid { 6 } else { 3 };
                first
            })
            .collect();
        let frames = self
            .linkages()
            .iter()
            .map(|linkage| {
                (self.arms() != Arms::Lab && linkage.bodies.len() > 1).then(|| {
                    len += 3;
                    len - 3
                })
            })
            .collect();
        VelocityLayout {
            bodies,
            frames,
            len,
        }
    }

    /// The generalised velocities `(U, omega)` of bodies with surfaces: six a body, in the bodies' order.
    pub fn surface_velocities(&self) -> Vec<usize> {
        let layout = self.velocity_layout();
        (0..self.kinds().len())
            .filter(|&body| self.kinds()[body] == BodyKind::Rigid)
            .flat_map(|body| layout.body(body)..layout.body(body) + 6)
            .collect()
    }

    /// The constraints in a state, when the lengths of the links change at `rates` (one a link).
    ///
    /// # Errors
    /// Arrays whose lengths do not fit the set, a rate that is not finite, lengths that [`Articulation::place`] refuses.
    pub fn constraints(
        &self,
        state: &State,
        lengths: &[f64],
        rates: &[f64],
    ) -> Result<Constraints, RigidError> {
        check_length("rates of the links", rates.len(), self.links().len())?;
        if rates.iter().any(|r| !r.is_finite()) {
            return Err(RigidError::NotFinite {
                what: "the rate of a link",
            });
        }
        let poses = self.place(state, lengths)?;
        let layout = self.velocity_layout();
        let clamped_bodies: Vec<usize> = (0..self.kinds().len())
            .filter(|&body| {
                self.arms() == Arms::Clamped
                    && self.kinds()[body] == BodyKind::Rigid
                    && layout.frame(self.linkage_of()[body]).is_some()
            })
            .collect();
        let fixed_bodies: Vec<usize> = (0..self.kinds().len())
            .filter(|&body| self.fixed()[body])
            .collect();
        let moving_rows = 3 * (self.links().len() + clamped_bodies.len());
        let rows = moving_rows + 6 * fixed_bodies.len();
        let mut matrix = DMatrix::zeros(rows, layout.len());
        let mut rhs = DVector::zeros(rows);
        let mut labels = Vec::with_capacity(rows);
        let identity = Matrix3::<f64>::identity();
        for (number, link) in self.links().iter().enumerate() {
            let row = 3 * number;
            matrix
                .fixed_view_mut::<3, 3>(row, layout.body(link.body))
                .copy_from(&identity);
            matrix
                .fixed_view_mut::<3, 3>(row, layout.body(link.to))
                .copy_from(&-identity);
            if let Some(frame) = layout.frame(self.linkage_of()[link.body]) {
                let arm = poses[link.body].translation.vector - poses[link.to].translation.vector;
                // -Omega x arm = [arm]x Omega
                matrix
                    .fixed_view_mut::<3, 3>(row, frame)
                    .copy_from(&arm.cross_matrix());
            }
            rhs.fixed_rows_mut::<3>(row)
                .copy_from(&(rates[number] * self.direction(state, number)));
            labels.extend(std::iter::repeat_n(link.name.clone(), 3));
        }
        for (number, &body) in clamped_bodies.iter().enumerate() {
            let row = 3 * (self.links().len() + number);
            matrix
                .fixed_view_mut::<3, 3>(row, layout.body(body) + 3)
                .copy_from(&identity);
            if let Some(frame) = layout.frame(self.linkage_of()[body]) {
                matrix
                    .fixed_view_mut::<3, 3>(row, frame)
                    .copy_from(&-identity);
            }
            labels.extend(std::iter::repeat_n(format!("clamp of body {body}"), 3));
        }
        for (number, &body) in fixed_bodies.iter().enumerate() {
            matrix
                .fixed_view_mut::<6, 6>(moving_rows + 6 * number, layout.body(body))
                .fill_with_identity();
            labels.extend(std::iter::repeat_n(format!("hold of body {body}"), 6));
        }
        Ok(Constraints {
            matrix,
            rates: rhs,
            labels,
            layout,
        })
    }

    /// Rate of change of the state when the generalised velocities are `q`.
    ///
    /// # Errors
    /// A `q` of the wrong length.
    pub fn state_velocity(&self, q: &[f64]) -> Result<StateVelocity, RigidError> {
        let layout = self.velocity_layout();
        check_length("generalised velocities", q.len(), layout.len())?;
        let at = |first: usize| Vector3::new(q[first], q[first + 1], q[first + 2]);
        let frame_spin =
            |linkage: usize| match (layout.frame(linkage), &self.linkages()[linkage].bodies[..]) {
                (Some(frame), _) => at(frame),
                // A body without links is its own frame.
                (None, &[body]) if self.kinds()[body] == BodyKind::Rigid => {
                    at(layout.body(body) + 3)
                }
                (None, _) => Vector3::zeros(),
            };
        Ok(StateVelocity {
            frames: self
                .linkages()
                .iter()
                .enumerate()
                .map(|(number, linkage)| Twist {
                    linear: at(layout.body(linkage.root)),
                    angular: frame_spin(number),
                })
                .collect(),
            spins: (0..self.kinds().len())
                .map(|body| match self.kinds()[body] {
                    BodyKind::Rigid => at(layout.body(body) + 3),
                    BodyKind::Point => frame_spin(self.linkage_of()[body]),
                })
                .collect(),
        })
    }
}
