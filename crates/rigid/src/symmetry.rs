//! Symmetry planes: the motions and loads that they allow, and forces on whole bodies from parts.

use std::borrow::Cow;

use nalgebra::{DVector, Matrix3};

use crate::{Articulation, BodyKind, Constraints, Drive, ExternalLoad, RigidError};

/// Symmetry planes through the origin, normal to coordinate axes; the mesh covers one side of each.
///
/// Bodies, loads and flow are symmetric about each plane. On the plane normal to axis `c` the
/// velocity component `c` is zero and the traction in the other two directions is zero. A body
/// whose centre is on all planes moves along axis `c` only if no plane is normal to it, and rotates
/// about `c` only if no plane is normal to another axis (angular velocities are pseudovectors).
/// With `k` planes the mesh covers `2^-k` of the fluid, and the forces and torques computed on it
/// are this fraction of those on whole bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SymmetryPlanes {
    /// Whether there is a plane normal to each axis.
    pub planes: [bool; 3],
}

impl SymmetryPlanes {
    /// The planes that at least one of these nodes lies on.
    pub fn from_nodes(on_symmetry_planes: &[(u32, [bool; 3])]) -> Self {
        let any = |axis: usize| on_symmetry_planes.iter().any(|(_, on)| on[axis]);
        Self {
            planes: [any(0), any(1), any(2)],
        }
    }

    /// Whether there is no plane.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Number of parts that the planes cut the fluid into, `2^k`.
    pub fn parts(&self) -> f64 {
        2_f64.powi(self.planes.iter().filter(|&&plane| plane).count() as i32)
    }

    /// Whether each component of `(U, ω)`, or of `(F, T)`, may differ from zero.
    pub fn allowed(&self) -> [bool; 6] {
        let planes = self.planes;
        std::array::from_fn(|k| match k {
            0..3 => !planes[k],
            _ => (0..3).all(|axis| axis == k - 3 || !planes[axis]),
        })
    }

    /// Forces and torques on whole bodies from those on their parts, six per body.
    pub(crate) fn whole(&self, mut parts: DVector<f64>) -> DVector<f64> {
        if self.is_empty() {
            return parts;
        }
        let allowed = self.allowed();
        for (k, force) in parts.iter_mut().enumerate() {
            *force = if allowed[k % 6] {
                self.parts() * *force
            } else {
                0.0
            };
        }
        parts
    }

    /// Second-order tensor of a whole body, such as a stresslet, from that of its part.
    ///
    /// A reflection reverses the sign of the components with one index normal to its plane.
    pub fn whole_tensor(&self, part: &Matrix3<f64>) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| match i != j && (self.planes[i] || self.planes[j]) {
            true => 0.0,
            false => self.parts() * part[(i, j)],
        })
    }

    /// Refuses loads that are not symmetric about the planes.
    ///
    /// # Errors
    /// [`RigidError::AsymmetricLoad`] names the first such body.
    fn check_loads(&self, drive: &Drive) -> Result<(), RigidError> {
        let allowed = self.allowed();
        let is_symmetric = |load: &ExternalLoad| {
            let components = load.force.iter().chain(load.torque.iter());
            components
                .zip(allowed)
                .all(|(&load, allowed)| allowed || load == 0.0)
        };
        match drive.loads.iter().position(|load| !is_symmetric(load)) {
            Some(body) => Err(RigidError::AsymmetricLoad { body }),
            None => Ok(()),
        }
    }
}

impl Constraints {
    /// The constraints of a drive, then one row for each component that planes prescribe as zero.
    ///
    /// # Errors
    /// [`RigidError::AsymmetricLoad`] for a load that is not symmetric about the planes.
    pub(crate) fn with_symmetry<'a>(
        drive: &Drive<'a>,
        symmetry_planes: SymmetryPlanes,
    ) -> Result<Cow<'a, Constraints>, RigidError> {
        let own = drive.constraints;
        if symmetry_planes.is_empty() {
            return Ok(Cow::Borrowed(own));
        }
        symmetry_planes.check_loads(drive)?;
        let constrained = constrained_velocities(drive.set, symmetry_planes);
        let mut all = own.clone();
        let rows = all.matrix.nrows();
        all.matrix = all.matrix.resize_vertically(rows + constrained.len(), 0.0);
        all.rates = all.rates.resize_vertically(rows + constrained.len(), 0.0);
        for (number, (velocity, label)) in constrained.into_iter().enumerate() {
            all.matrix[(rows + number, velocity)] = 1.0;
            all.labels.push(label);
        }
        Ok(Cow::Owned(all))
    }
}

/// The generalised velocities that symmetry planes prescribe as zero, with labels for messages.
fn constrained_velocities(
    set: &Articulation,
    symmetry_planes: SymmetryPlanes,
) -> Vec<(usize, String)> {
    let layout = set.velocity_layout();
    let allowed = symmetry_planes.allowed();
    let constrained = |first: usize, components: std::ops::Range<usize>| {
        let offset = components.start;
        components
            .filter(|&k| !allowed[k])
            .map(move |k| first + k - offset)
    };
    let mut all = Vec::new();
    for (body, kind) in set.kinds().iter().enumerate() {
        let components = if *kind == BodyKind::Rigid { 0..6 } else { 0..3 };
        let label = format!("symmetry plane of body {body}");
        all.extend(constrained(layout.bodies()[body], components).map(|v| (v, label.clone())));
    }
    for number in 0..set.frames() {
        if let Some(frame) = layout.frame(number) {
            let label = format!("symmetry plane of frame {number}");
            all.extend(constrained(frame, 3..6).map(|v| (v, label.clone())));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_allow_symmetric_motions_only() {
        let allowed = |planes| SymmetryPlanes { planes }.allowed();
        assert_eq!(allowed([false; 3]), [true; 6]);
        // the plane normal to z: translation along x and y, rotation about z
        assert_eq!(
            allowed([false, false, true]),
            [true, true, false, false, false, true]
        );
        // planes normal to y and to z: translation along x
        assert_eq!(
            allowed([false, true, true]),
            [true, false, false, false, false, false]
        );
        assert_eq!(allowed([true; 3]), [false; 6]);
        assert_eq!(SymmetryPlanes { planes: [true; 3] }.parts(), 8.0);
    }
}
