//! Unknowns of the Galerkin system: vector spherical harmonics of the force density on a sphere.
//!
//! With real orthonormal `Y_lm`, the outward normal `n` and the surface gradient `∇_S` of the
//! unit sphere, and the eigenvalue of the single-layer operator of a sphere of radius `a` (Corona
//! & Veerapaneni 2018):
//! ```text
//! harmonic                        eigenvalue                     inside    outside, l = 1
//! W_l = ∇_S Y + l Y n             a (l+1) / ((2l+1) (2l-1))      r^(l-1)   force (Stokeslet)
//! X_l = n × ∇_S Y                 a / (2l+1)                     r^l       torque (rotlet)
//! V_l = ∇_S Y - (l+1) Y n         a l / ((2l+1) (2l+3))          r^(l+1)   source dipole
//! ```
//! A force density with the shape of a harmonic thus gives a velocity on the sphere with the same
//! shape, multiplied by the eigenvalue. Inside the sphere the velocity grows with the stated power
//! of the radius.

/// Families of vector spherical harmonics, named after the singularity of their lowest member.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    /// `W_l`: force and its multipoles.
    Stokeslet,
    /// `X_l`: torque and its multipoles.
    Rotlet,
    /// `V_l`: sources and their multipoles; outside the sphere these flows have no pressure.
    Source,
}

pub(crate) const FAMILIES: [Family; 3] = [Family::Stokeslet, Family::Rotlet, Family::Source];

impl Family {
    /// Degree of the polynomial velocity inside the sphere, plus one, minus `l`: the velocity grows
    /// as `r^(l-1)`, `r^l`, `r^(l+1)`.
    pub fn shift(self) -> usize {
        match self {
            Self::Stokeslet => 0,
            Self::Rotlet => 1,
            Self::Source => 2,
        }
    }

    /// Self energy of a mode whose velocity on a sphere of radius `a` is the harmonic itself.
    ///
    /// The squared norm of the harmonic over the eigenvalue of the single-layer operator. At `l =
    /// 1` it gives the drag coefficients `6π a` and `8π a³`, up to the norm of a rigid motion.
    pub fn energy(self, l: usize, a: f64) -> f64 {
        let l = l as f64;
        a * match self {
            Self::Stokeslet => l * (2.0 * l + 1.0).powi(2) * (2.0 * l - 1.0) / (l + 1.0),
            Self::Rotlet => l * (l + 1.0) * (2.0 * l + 1.0),
            Self::Source => (l + 1.0) * (2.0 * l + 1.0).powi(2) * (2.0 * l + 3.0) / l,
        }
    }

    /// Sign of a mode under reflection along the axis: that of `Y_lm`, reversed for the axial
    /// vectors `X`.
    pub fn parity(self, l: usize, m: usize) -> f64 {
        let odd = (l + m) % 2 == 1;
        if odd == (self == Self::Rotlet) {
            1.0
        } else {
            -1.0
        }
    }
}

/// Modes of one sphere up to an order.
///
/// The order counts the polynomial degree of the velocity inside the sphere: all flows of a degree
/// below the order are contained. The set is closed under rotation, so results do not depend on the
/// frame, and contains the modes of all lower orders. Order 1 stands for the rigid motions, order 0
/// for no modes.
///
/// Sorted by family, degree `l`, then `m = -l ..= l` (`m < 0` is the sine).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Modes {
    pub order: usize,
}

impl Modes {
    /// Highest degree `l` of a family.
    pub fn max_degree(self, family: Family) -> usize {
        match family {
            // order 1 has both rigid motions
            Family::Rotlet if self.order == 1 => 1,
            _ => self.order.saturating_sub(family.shift()),
        }
    }

    /// Number of modes.
    pub fn len(self) -> usize {
        FAMILIES
            .iter()
            .map(|&f| Self::count(self.max_degree(f)))
            .sum()
    }

    /// Whether a mode belongs to the expansion.
    pub fn contains(self, family: Family, l: usize) -> bool {
        l <= self.max_degree(family)
    }

    /// Index of the first mode of a family.
    pub fn first_index(self, family: Family) -> usize {
        FAMILIES
            .iter()
            .take_while(|&&f| f != family)
            .map(|&f| Self::count(self.max_degree(f)))
            .sum()
    }

    /// Indices of the modes `m = -l ..= l` of a family and degree.
    pub fn shell(self, family: Family, l: usize) -> std::ops::Range<usize> {
        let first = self.first_index(family) + l * l - 1;
        first..first + 2 * l + 1
    }

    /// Families with the indices of all their modes.
    pub fn families(self) -> impl Iterator<Item = (Family, std::ops::Range<usize>)> {
        FAMILIES.into_iter().map(move |family| {
            let first = self.first_index(family);
            (family, first..first + Self::count(self.max_degree(family)))
        })
    }

    /// Families and degrees, in the order of the modes.
    pub fn shells(self) -> impl Iterator<Item = (Family, usize)> {
        FAMILIES
            .into_iter()
            .flat_map(move |family| (1..=self.max_degree(family)).map(move |l| (family, l)))
    }

    /// Whether a mode belongs to the expansion whose order is lower by two.
    pub fn in_lower_order(self, family: Family, l: usize) -> bool {
        l + family.shift() + 2 <= self.order
    }

    /// Number of harmonics of degrees `1 ..= top`.
    fn count(top: usize) -> usize {
        top * (top + 2)
    }

    /// Families and degrees of the modes with azimuthal number `m`, family by family, `l` rising.
    pub fn sector(self, m: usize) -> Vec<(Family, usize)> {
        FAMILIES
            .iter()
            .flat_map(|&family| (m.max(1)..=self.max_degree(family)).map(move |l| (family, l)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mode_has_one_place() {
        for order in 2..6 {
            let modes = Modes { order };
            let mut seen = vec![0; modes.len()];
            for (family, l) in modes.shells() {
                modes.shell(family, l).for_each(|k| seen[k] += 1);
            }
            assert!(seen.iter().all(|&n| n == 1));
        }
    }

    #[test]
    fn rigid_motions_have_the_energy_of_stokes_drag() {
        // |e|^2 = 4 pi / 3 in units where the harmonic W_1 is orthonormal: sqrt(3 / 4 pi) e.
        let pi = std::f64::consts::PI;
        let unit = 4.0 * pi / 3.0;
        assert!((Family::Stokeslet.energy(1, 2.0) * unit - 12.0 * pi).abs() < 1e-13);
        // a rotation has the velocity omega a on the equator, here with a = 2
        assert!((Family::Rotlet.energy(1, 2.0) * unit * 4.0 - 64.0 * pi).abs() < 1e-12);
    }
}
