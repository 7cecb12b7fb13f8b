//! The unknowns: multipoles of the force density on each sphere.
//!
//! On a sphere of radius $a$ the force density is expanded in vector spherical harmonics of real, orthonormal $Y_{lm}$:
//! $W_l = \nabla_S Y + l Y n$, $X_l = n \times \nabla_S Y$, $V_l = \nabla_S Y - (l+1) Y n$. They diagonalise the single layer of a sphere
//! (Corona & Veerapaneni 2018): a density $W_l$, $X_l$, $V_l$ makes a velocity of the same shape on the sphere, times
//! $a (l+1)/((2l+1)(2l-1))$, $a/(2l+1)$, $a l/((2l+1)(2l+3))$. The density $W_1$ is a force, $X_1$ a torque.

/// The three families of vector spherical harmonics, named by their first member or by what makes their flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    /// $W_l$: the force and its multipoles.
    Stokeslet,
    /// $X_l$: the torque and its multipoles.
    Rotlet,
    /// $V_l$: the flows without pressure outside, of sources and their multipoles.
    Source,
}

pub(crate) const FAMILIES: [Family; 3] = [Family::Stokeslet, Family::Rotlet, Family::Source];

impl Family {
    /// The flow of degree `l` inside a sphere grows as $r^{l-1}$, $r^l$, $r^{l+1}$: what is added to `l` to get one more than that.
    pub fn shift(self) -> usize {
        match self {
            Self::Stokeslet => 0,
            Self::Rotlet => 1,
            Self::Source => 2,
        }
    }

    /// Self energy of a mode whose velocity on a sphere of radius `a` is the harmonic itself: its squared norm over the eigenvalue of
    /// the single layer. $6 \pi a$ and $8 \pi a^3$ of translation and rotation are this at `l` = 1, up to the norm of a rigid motion.
    pub fn energy(self, l: usize, a: f64) -> f64 {
        let l = l as f64;
        a * match self {
            Self::Stokeslet => l * (2.0 * l + 1.0).powi(2) * (2.0 * l - 1.0) / (l + 1.0),
            Self::Rotlet => l * (l + 1.0) * (2.0 * l + 1.0),
            Self::Source => (l + 1.0) * (2.0 * l + 1.0).powi(2) * (2.0 * l + 3.0) / l,
        }
    }

    /// Sign of a mode under reflection along the axis: that of $Y_{lm}$, reversed for the axial vectors $X$.
    pub fn parity(self, l: usize, m: usize) -> f64 {
        let odd = (l + m) % 2 == 1;
        if odd == (self == Self::Rotlet) {
            1.0
        } else {
            -1.0
        }
    }
}

/// The modes of one sphere up to an order: all flows inside the sphere that are polynomials of degree below the order.
///
/// Closed under rotation, so that results do not depend on the frame. Order: family, `l`, `m` = -l ..= l
/// (`m` < 0 is the sine). The modes of order `n - 2` are a subset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Modes {
    pub order: usize,
}

impl Modes {
    /// Highest `l` of a family.
    pub fn top(self, family: Family) -> usize {
        self.order.saturating_sub(family.shift())
    }

    /// Number of modes.
    pub fn len(self) -> usize {
        FAMILIES.iter().map(|&f| Self::count(self.top(f))).sum()
    }

    /// First mode of a family.
    pub fn offset(self, family: Family) -> usize {
        FAMILIES
            .iter()
            .take_while(|&&f| f != family)
            .map(|&f| Self::count(self.top(f)))
            .sum()
    }

    /// Place of the modes `m` = -l ..= l.
    pub fn shell(self, family: Family, l: usize) -> std::ops::Range<usize> {
        let first = self.offset(family) + l * l - 1;
        first..first + 2 * l + 1
    }

    /// Families and degrees, in the order of the modes.
    pub fn shells(self) -> impl Iterator<Item = (Family, usize)> {
        FAMILIES
            .into_iter()
            .flat_map(move |family| (1..=self.top(family)).map(move |l| (family, l)))
    }

    /// Whether a mode is one of the next lower order but one.
    pub fn in_lower_order(self, family: Family, l: usize) -> bool {
        l + family.shift() + 2 <= self.order
    }

    /// Harmonics of degree 1 ..= top.
    fn count(top: usize) -> usize {
        top * (top + 2)
    }

    /// The modes of azimuthal number `m`, families one after the other, `l` rising.
    pub fn sector(self, m: usize) -> Vec<(Family, usize)> {
        FAMILIES
            .iter()
            .flat_map(|&family| (m.max(1)..=self.top(family)).map(move |l| (family, l)))
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
        // a rotation has the velocity omega a on the equator
        assert!((Family::Rotlet.energy(1, 2.0) * unit * 4.0 - 64.0 * pi).abs() < 1e-12);
    }
}
