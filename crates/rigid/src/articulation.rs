//! Articulated sets: bodies joined by extensible links, and the graph that they form.

use nalgebra::Vector3;

use crate::RigidError;
use crate::error::check_length;
use crate::linkage::{Link, Linkage, find_linkages};

/// The kind of a member of an articulated set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum BodyKind {
    /// A rigid body with a surface: three velocities and three angular velocities.
    Rigid,
    /// A massless point without a surface, such as a junction of arms: three velocities.
    Point,
}

/// Attachment of bodies to arms that rotate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Arms {
    /// Bodies do not rotate relative to the frame of their linkage: one angular velocity for all.
    #[default]
    Clamped,
    /// Each body rotates torque-free, and so does the frame of each linkage.
    Free,
    /// Arms keep their direction in the laboratory axes and bodies rotate freely.
    ///
    /// This is the literal reading of equations (11)-(12) of Berti et al. (2021). It is torque-free
    /// only if the swimmer is collinear and moves along its axis.
    Lab,
}

/// Bodies, the links between them, and the directions of the links in the frame of their linkage.
#[derive(Clone, Debug)]
pub struct Articulation {
    kinds: Vec<BodyKind>,
    links: Vec<Link>,
    arms: Arms,
    directions: Vec<Vector3<f64>>,
    linkages: Vec<Linkage>,
    linkage_of: Vec<usize>,
    initial_positions: Vec<Vector3<f64>>,
    initial_lengths: Vec<f64>,
    fixed: Vec<bool>,
}

impl Articulation {
    /// Joins `kinds.len()` bodies at `positions` by `links`.
    ///
    /// The positions give the directions and the initial lengths of the links. Any graph is
    /// allowed: chains, stars, loops, several separate linkages, bodies without links. The root
    /// of a linkage is its body with the lowest index.
    ///
    /// # Errors
    /// A link to a body that does not exist, a link between coincident bodies, a point without a
    /// link, a position or a distance that is not finite.
    pub fn new(
        kinds: &[BodyKind],
        links: Vec<Link>,
        arms: Arms,
        positions: &[Vector3<f64>],
    ) -> Result<Self, RigidError> {
        let bodies = kinds.len();
        check_length("positions of the bodies", positions.len(), bodies)?;
        if positions.iter().any(|x| !x.iter().all(|c| c.is_finite())) {
            return Err(RigidError::NotFinite {
                what: "a body's position",
            });
        }
        let mut directions = Vec::with_capacity(links.len());
        let mut initial_lengths = Vec::with_capacity(links.len());
        for link in &links {
            for body in [link.body, link.to] {
                if body >= bodies {
                    return Err(RigidError::NoSuchBody {
                        link: link.name.clone(),
                        body,
                        bodies,
                    });
                }
            }
            let arm = positions[link.body] - positions[link.to];
            let distance = arm.norm();
            let scale = positions[link.body].norm().max(positions[link.to].norm());
            if !distance.is_finite() {
                return Err(RigidError::NotFinite {
                    what: "the distance between two linked bodies",
                });
            }
            // A distance at the level of rounding of the positions determines no direction.
            if distance <= 1e-12 * scale || distance == 0.0 {
                return Err(RigidError::NoDirection {
                    link: link.name.clone(),
                    distance,
                });
            }
            directions.push(arm / distance);
            initial_lengths.push(distance);
        }
        let linkages = find_linkages(bodies, &links);
        let mut linkage_of = vec![0; bodies];
        for (number, linkage) in linkages.iter().enumerate() {
            if let [body] = linkage.bodies[..]
                && kinds[body] == BodyKind::Point
            {
                return Err(RigidError::LoosePoint { body });
            }
            for &body in &linkage.bodies {
                linkage_of[body] = number;
            }
        }
        Ok(Self {
            kinds: kinds.to_vec(),
            links,
            arms,
            directions,
            linkages,
            linkage_of,
            initial_positions: positions.to_vec(),
            initial_lengths,
            fixed: vec![false; bodies],
        })
    }

    /// The same set with some bodies fixed in space: obstacles with `U = 0` and `ω = 0`.
    ///
    /// # Errors
    /// [`RigidError::FixedBody`] for a body that does not exist, is a point or has a link.
    pub fn with_fixed(mut self, bodies: &[usize]) -> Result<Self, RigidError> {
        for &body in bodies {
            let problem = if body >= self.kinds.len() {
                "there is no such body"
            } else if self.kinds[body] == BodyKind::Point {
                "a point has no surface, so it cannot be an obstacle"
            } else if self.links.iter().any(|l| l.body == body || l.to == body) {
                "it has a link, and only bodies without links can be fixed"
            } else {
                self.fixed[body] = true;
                continue;
            };
            return Err(RigidError::FixedBody { body, problem });
        }
        Ok(self)
    }

    /// Whether each body is fixed in space.
    pub fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    /// Kind of each body.
    pub fn kinds(&self) -> &[BodyKind] {
        &self.kinds
    }

    /// The links.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// Attachment of the bodies to their arms.
    pub fn arms(&self) -> Arms {
        self.arms
    }

    /// The connected sets of bodies.
    pub fn linkages(&self) -> &[Linkage] {
        &self.linkages
    }

    /// Index of the linkage that each body belongs to.
    pub fn linkage_of(&self) -> &[usize] {
        &self.linkage_of
    }

    /// Lengths of the links at the positions given to [`Articulation::new`].
    pub fn initial_lengths(&self) -> &[f64] {
        &self.initial_lengths
    }

    /// Positions given to [`Articulation::new`].
    pub(crate) fn initial_positions(&self) -> &[Vector3<f64>] {
        &self.initial_positions
    }

    /// Unit vectors of the links from `to` to `body`, in the frame of their linkage.
    pub(crate) fn directions(&self) -> &[Vector3<f64>] {
        &self.directions
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separate_linkages_and_loose_points_are_found() {
        let x = [Vector3::zeros(), Vector3::x(), 5.0 * Vector3::y()];
        let link = || {
            vec![Link {
                name: "0-1".into(),
                body: 0,
                to: 1,
            }]
        };
        let set = Articulation::new(&[BodyKind::Rigid; 3], link(), Arms::Free, &x).unwrap();
        assert_eq!(set.linkages().len(), 2);
        assert_eq!(set.linkage_of(), &[0, 0, 1]);
        let kinds = [BodyKind::Rigid, BodyKind::Rigid, BodyKind::Point];
        let loose = Articulation::new(&kinds, link(), Arms::Free, &x);
        assert_eq!(loose.unwrap_err(), RigidError::LoosePoint { body: 2 });
    }
}
