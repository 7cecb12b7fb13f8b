//! Boxes with sides along the axes.

use mesh::{Surface, Vec3};

/// The surface of the box `min <= x <= max`, sides along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoxSurface {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner, above `min` in each coordinate.
    pub max: Vec3,
}

impl Surface for BoxSurface {
    fn signed_distance(&self, point: Vec3) -> f64 {
        // Distance outside each pair of faces, negative between them.
        let beyond = (self.min - point).sup(&(point - self.max));
        let outside = beyond.map(|b| b.max(0.0)).norm();
        outside + beyond.max().min(0.0)
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        let mut foot = point.sup(&self.min).inf(&self.max);
        if foot == point {
            // Inside: project onto the nearest face; its coordinate is taken exactly.
            let depth = (point - self.min).inf(&(self.max - point));
            let axis = depth.imin();
            let upper = self.max[axis] - point[axis] < point[axis] - self.min[axis];
            foot[axis] = if upper {
                self.max[axis]
            } else {
                self.min[axis]
            };
        }
        foot
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        let half = 0.5 * (self.max - self.min);
        (self.min + half, half.norm())
    }

    fn volume(&self) -> f64 {
        (self.max - self.min).product()
    }

    fn is_convex(&self) -> bool {
        true
    }

    /// Zero: the edges are sharp.
    fn reach(&self) -> f64 {
        0.0
    }

    fn inradius(&self) -> f64 {
        0.5 * (self.max - self.min).min()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn box_distances() {
        let shape = BoxSurface {
            min: Vec3::zeros(),
            max: Vec3::new(1.0, 2.0, 3.0),
        };
        assert_eq!(shape.signed_distance(Vec3::new(0.5, 0.9, 1.0)), -0.5);
        assert_eq!(shape.signed_distance(Vec3::new(4.0, 6.0, 1.0)), 5.0);
        assert_eq!(shape.closest_point(Vec3::new(0.5, 1.9, 1.0)).y, 2.0);
        assert_eq!(
            shape.closest_point(Vec3::new(0.5, 5.0, 7.0)),
            Vec3::new(0.5, 2.0, 3.0)
        );
        assert_eq!(shape.volume(), 6.0);
    }
}
