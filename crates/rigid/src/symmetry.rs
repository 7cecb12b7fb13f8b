//! Mirror planes: the motions and loads that they leave, and what a part of the fluid knows of the whole.

use std::borrow::Cow;

use nalgebra::DVector;

use crate::{Articulation, BodyKind, Constraints, Drive, ExternalLoad, RigidError};

/// Planes through the origin, normal to coordinate axes, that mirror bodies, loads and flow onto themselves; the mesh covers one side of each.
///
/// On the plane normal to axis `c` the velocity's component `c` is zero and the other two are free of traction. A body whose centre is on all planes
/// moves along axis `c` only if no plane is normal to it, and turns about `c` only if no plane is normal to another axis (angular velocities
/// are pseudovectors). A mesh of $2^{-k}$ of the fluid carries as much of forces and torques.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SymmetryPlanes {
    /// Whether there is a plane normal to each axis.
    pub planes: [bool; 3],
}

impl SymmetryPlanes {
    /// The planes that some of these nodes are on.
    pub fn of(on_symmetry_planes: &[(u32, [bool; 3])]) -> Self {
        let any = |axis: usize| on_symmetry_planes.iter().any(|(_, on)| on[axis]);
        Self {
            planes: [any(0), any(1), any(2)],
        }
    }

    /// Whether there is no plane.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// In how many parts the planes cut the fluid: $2^k$.
    pub fn parts(&self) -> f64 {
        2_f64.powi(self.planes.iter().filter(|&&plane| plane).count() as i32)
    }

    /// Whether each component of a velocity or force, then of an angular velocity or torque, may differ from zero.
    pub fn allowed(&self) -> [bool; 6] {
        let planes = self.planes;
        std::array::from_fn(|k| match k {
            0..3 => !planes[k],
            _ => (0..3).all(|axis| axis == k - 3 || !planes[axis]),
        })
    }

    /// Forces and torques on whole bodies from those on their parts, six a body.
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

    /// That loads are their own mirror images.
    ///
    /// # Errors
    /// [`RigidError::AsymmetricLoad`] names a body whose load is not.
    fn check_loads(&self, drive: &Drive) -> Result<(), RigidError> {
        let allowed = self.allowed();
        let is_mirrored = |load: &ExternalLoad| {
            let components = load.force.iter().chain(load.torque.iter());
            components
                .zip(allowed)
                .all(|(&load, allowed)| allowed || load == 0.0)
        };
        match drive.loads.iter().position(|load| !is_mirrored(load)) {
            Some(body) => Err(RigidError::AsymmetricLoad { body }),
            None => Ok(()),
        }
    }
}

impl Constraints {
    /// With rows that hold at zero what `mirrors` do not allow, after all others.
    ///
    /// # Errors
    /// [`RigidError::AsymmetricLoad`] for a load that is not its own mirror image.
    pub(crate) fn with_symmetry<'a>(
        drive: &Drive<'a>,
        mirrors: SymmetryPlanes,
    ) -> Result<Cow<'a, Constraints>, RigidError> {
        let own = drive.constraints;
        if mirrors.is_empty() {
            return Ok(Cow::Borrowed(own));
        }
        mirrors.check_loads(drive)?;
        let held = constrained_velocities(drive.set, mirrors);
        let mut all = own.clone();
        let rows = all.matrix.nrows();
        all.matrix = all.matrix.resize_vertically(rows + held.len(), 0.0);
        all.rates = all.rates.resize_vertically(rows + held.len(), 0.0);
        for (number, (velocity, label)) in held.into_iter().enumerate() {
            all.matrix[(rows + number, velocity)] = 1.0;
            all.labels.push(label);
        }
        Ok(Cow::Owned(all))
    }
}

/// The generalised velocities that mirrors hold at zero, with what to call them.
fn constrained_velocities(set: &Articulation, mirrors: SymmetryPlanes) -> Vec<(usize, String)> {
    let layout = set.velocity_layout();
    let allowed = mirrors.allowed();
    let held = |first: usize, components: std::ops::Range<usize>| {
        let offset = components.start;
        components
            .filter(|&k| !allowed[k])
            .map(move |k| first + k - offset)
    };
    let mut all = Vec::new();
    for (body, kind) in set.kinds().iter().enumerate() {
        let components = if *kind == BodyKind::Rigid { 0..6 } else { 0..3 };
        let label = format!("mirror plane of body {body}");
        all.extend(held(layout.body(body), components).map(|v| (v, label.clone())));
    }
    for number in 0..set.linkages().len() {
        if let Some(frame) = layout.frame(number) {
            let label = format!("mirror plane of frame {number}");
            all.extend(held(frame, 3..6).map(|v| (v, label.clone())));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_that_planes_leave() {
        let allowed = |planes| SymmetryPlanes { planes }.allowed();
        assert_eq!(allowed([false; 3]), [true; 6]);
        // the plane normal to z: along x and y, about z
        assert_eq!(
            allowed([false, false, true]),
            [true, true, false, false, false, true]
        );
        // normal to y and to z: along x
        assert_eq!(
            allowed([false, true, true]),
            [true, false, false, false, false, false]
        );
        assert_eq!(allowed([true; 3]), [false; 6]);
        assert_eq!(SymmetryPlanes { planes: [true; 3] }.parts(), 8.0);
    }
}
