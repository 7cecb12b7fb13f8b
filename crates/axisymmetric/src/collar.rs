//! Condensed matrices of collars: the fluid between a body and a confocal spheroid around it.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::AxisymmetricError;
use crate::curve::BoundaryPart;
use crate::generate::generate;
use crate::meridian::{GROWTH, Meridian};
use crate::mesh::MeridianMesh;
use crate::spheroid::AxialSpheroid;
use crate::stokes::stokes;
use crate::surface_modes::{MODES, SpheroidModes};
use crate::swirl::swirl;
use crate::system::System;

/// The motion of the bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Motion {
    /// Along the axis.
    Translation,
    /// About the axis.
    Rotation,
    /// Along the axis, with the modes of the surfaces.
    Surfaces,
}

impl Motion {
    /// The linear system on a mesh, with velocities of degree `order`.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn system(
        self,
        mesh: &MeridianMesh,
        order: usize,
        bodies: &[AxialSpheroid],
    ) -> Result<System, AxisymmetricError> {
        match self {
            Self::Translation => stokes(mesh, order, None),
            Self::Surfaces => stokes(mesh, order, Some((bodies.len(), &SpheroidModes(bodies)))),
            Self::Rotation => swirl(mesh, order),
        }
    }
}

impl Motion {
    /// Prescribed velocities of a number of bodies: their own, then those of the modes.
    pub fn prescribed(self, bodies: usize) -> usize {
        match self {
            Self::Translation | Self::Rotation => bodies,
            Self::Surfaces => bodies * (1 + MODES),
        }
    }

    /// Numbers of the prescribed velocities of one of several bodies: its own, then its modes.
    pub fn of_body(self, body: usize, bodies: usize) -> impl Iterator<Item = usize> {
        let modes = match self {
            Self::Translation | Self::Rotation => 0,
            Self::Surfaces => MODES,
        };
        let first = bodies + MODES * body;
        std::iter::once(body).chain(first..first + modes)
    }
}

/// What a condensed matrix depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    /// Bits of the semi-axes of the body and of the outline.
    semi_axes: [u64; 4],
    motion: Motion,
    order: usize,
}

impl Key {
    fn new(body: &AxialSpheroid, outline: &AxialSpheroid, motion: Motion, order: usize) -> Self {
        let semi_axes = [
            body.axial,
            body.equatorial,
            outline.axial,
            outline.equatorial,
        ];
        Self {
            semi_axes: semi_axes.map(f64::to_bits),
            motion,
            order,
        }
    }
}

/// The condensed matrices computed so far.
#[derive(Debug, Default)]
pub(crate) struct Collars {
    matrices: Mutex<BTreeMap<Key, DMatrix<f64>>>,
}

impl Collars {
    /// Computes the matrices of the collars of a domain, for these orders, where they are missing.
    ///
    /// Of several threads that miss the same matrices each begins with others and takes what is
    /// found meanwhile.
    ///
    /// # Errors
    /// Failures of the mesh or the solver.
    pub fn provide(
        &self,
        meridian: &Meridian,
        motion: Motion,
        orders: &[usize],
    ) -> Result<(), AxisymmetricError> {
        let mut missing = BTreeMap::new();
        let known = self.known();
        for (_, body, outline) in meridian.collars() {
            for &order in orders {
                let key = Key::new(&body, &outline, motion, order);
                if !known.contains_key(&key) {
                    missing.insert(key, (body, outline));
                }
            }
        }
        drop(known);
        let mut missing: Vec<_> = missing.into_iter().collect();
        let thread = rayon::current_thread_index().unwrap_or(0);
        let first = missing.len() * thread / rayon::current_num_threads();
        missing.rotate_left(first);
        missing
            .into_par_iter()
            .try_for_each(|(key, (body, outline))| {
                if self.known().contains_key(&key) {
                    return Ok(());
                }
                let mesh = generate(&Meridian::from_collar(body, outline), GROWTH)?;
                let system = motion.system(&mesh, key.order, &[body.centred()])?;
                let matrix = system.condensed(BoundaryPart::Open, motion.prescribed(1))?;
                self.known().insert(key, matrix);
                Ok(())
            })
    }

    fn known(&self) -> MutexGuard<'_, BTreeMap<Key, DMatrix<f64>>> {
        self.matrices.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The matrix of a collar; empty if it was not computed.
    ///
    /// Degrees of freedom are those of [`System::condensed`].
    pub fn matrix(
        &self,
        body: &AxialSpheroid,
        outline: &AxialSpheroid,
        motion: Motion,
        order: usize,
    ) -> DMatrix<f64> {
        let key = Key::new(body, outline, motion, order);
        self.known().get(&key).cloned().unwrap_or_default()
    }
}
