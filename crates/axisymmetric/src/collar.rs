//! Condensed matrices of collars: the fluid between a body and a confocal spheroid around it.

use std::collections::BTreeMap;

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
#[derive(Clone, Debug, Default)]
pub(crate) struct Collars {
    matrices: BTreeMap<Key, DMatrix<f64>>,
}

impl Collars {
    /// Computes the matrices of the collars of a domain, for these orders, where they are missing.
    ///
    /// # Errors
    /// Failures of the mesh or the solver.
    pub fn provide(
        &mut self,
        meridian: &Meridian,
        motion: Motion,
        orders: &[usize],
    ) -> Result<(), AxisymmetricError> {
        let mut missing = BTreeMap::new();
        for (_, body, outline) in meridian.collars() {
            for &order in orders {
                let key = Key::new(&body, &outline, motion, order);
                if !self.matrices.contains_key(&key) {
                    missing.insert(key, (body, outline));
                }
            }
        }
        let missing: Vec<_> = missing.into_iter().collect();
        let computed = (missing.into_par_iter())
            .map(|(key, (body, outline))| {
                let mesh = generate(&Meridian::from_collar(body, outline), GROWTH)?;
                let system = motion.system(&mesh, key.order, &[body.centred()])?;
                let prescribed = motion.prescribed(1);
                Ok((key, system.condensed(BoundaryPart::Open, prescribed)?))
            })
            .collect::<Result<Vec<_>, AxisymmetricError>>()?;
        self.matrices.extend(computed);
        Ok(())
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
        let matrix = self.matrices.get(&Key::new(body, outline, motion, order));
        matrix.cloned().unwrap_or_default()
    }
}
