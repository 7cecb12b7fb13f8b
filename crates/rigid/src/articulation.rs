//! Bodies joined by extensible links: which graph they form and where a state puts every body.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::RigidError;

/// What a member of an articulated set is to the fluid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyKind {
    /// A rigid body with a surface: three velocities and three angular velocities.
    Rigid,
    /// A massless point without surface, such as the junction of arms: three velocities.
    Point,
}

/// How bodies sit on arms that turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arms {
    /// Bodies keep their attitude to the frame of their linkage: one angular velocity for all.
    #[default]
    Clamped,
    /// Bodies spin freely, each without torque, on a frame that turns without torque.
    Free,
    /// Arms keep their direction in the laboratory and bodies spin freely (Berti et al. 2021, equations
    /// (11)-(12) read literally). Not torque-free off the axis of a collinear swimmer.
    Lab,
}

/// An arm of prescribed length from one body to another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Link {
    /// Name used in messages.
    pub name: String,
    /// The body that moves when the length changes, seen from `to`.
    pub body: usize,
    /// The body it is linked to.
    pub to: usize,
}

/// A connected set of bodies; it moves as one frame when no length changes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Linkage {
    /// The body at the origin of the frame.
    pub root: usize,
    /// All its bodies, the root first, in the order in which links reach them.
    pub bodies: Vec<usize>,
    /// For each body after the root: the link that reaches it and whether it runs from child to parent.
    tree: Vec<TreeEdge>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct TreeEdge {
    link: usize,
    parent: usize,
    child: usize,
}

/// Where an articulated set is: one frame a linkage and one attitude a body.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Pose of each linkage's frame; its origin is the linkage's root body.
    pub frames: Vec<Isometry3<f64>>,
    /// Attitude of each body in the laboratory (the identity at the start).
    pub attitudes: Vec<UnitQuaternion<f64>>,
}

/// Bodies, the links between them, and the directions of the links in the frame of their linkage.
#[derive(Clone, Debug)]
pub struct Articulation {
    kinds: Vec<BodyKind>,
    links: Vec<Link>,
    arms: Arms,
    /// Unit vectors from `to` to `body`, in the linkage's frame.
    directions: Vec<Vector3<f64>>,
    linkages: Vec<Linkage>,
    linkage_of: Vec<usize>,
    initial_positions: Vec<Vector3<f64>>,
    initial_lengths: Vec<f64>,
    fixed: Vec<bool>,
}

impl Articulation {
    /// Joins `kinds.len()` bodies at `positions` by `links`; directions and initial lengths of the links are those of the positions.
    ///
    /// Any graph is allowed: chains, stars, loops, several separate linkages, bodies without links. The root
    /// of a linkage is its lowest-numbered body.
    ///
    /// # Errors
    /// A link to a body that does not exist, a link without direction, a point without link, a position that is not finite.
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
            // A distance lost in the rounding of the positions carries no direction.
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

    /// The same set with some bodies held still: obstacles, with zero velocity and angular velocity.
    ///
    /// # Errors
    /// [`RigidError::FixedBody`] for a body that does not exist, is a point or has a link.
    pub fn with_fixed(mut self, bodies: &[usize]) -> Result<Self, RigidError> {
        for &body in bodies {
            let problem = if body >= self.kinds.len() {
                "there is no such body"
            } else if self.kinds[body] == BodyKind::Point {
                "a point has no surface to be in the way"
            } else if self.links.iter().any(|l| l.body == body || l.to == body) {
                "it has a link, and a linkage cannot be held by one body"
            } else {
                self.fixed[body] = true;
                continue;
            };
            return Err(RigidError::FixedBody { body, problem });
        }
        Ok(self)
    }

    /// For each body whether it is held still.
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

    /// How bodies sit on their arms.
    pub fn arms(&self) -> Arms {
        self.arms
    }

    /// The connected sets of bodies.
    pub fn linkages(&self) -> &[Linkage] {
        &self.linkages
    }

    /// The linkage that each body belongs to.
    pub fn linkage_of(&self) -> &[usize] {
        &self.linkage_of
    }

    /// Lengths of the links at the positions given to [`Articulation::new`].
    pub fn initial_lengths(&self) -> &[f64] {
        &self.initial_lengths
    }

    /// Direction of a link in the laboratory, from `to` to `body`.
    pub fn direction(&self, state: &State, link: usize) -> Vector3<f64> {
        let frame = &state.frames[self.linkage_of[self.links[link].body]];
        frame.rotation * self.directions[link]
    }

    /// The state of the positions given to [`Articulation::new`]: frames at the roots, all attitudes the identity.
    pub fn initial_state(&self) -> State {
        State {
            frames: self
                .linkages
                .iter()
                .map(|l| {
                    Isometry3::from_parts(
                        Translation3::from(self.initial_positions[l.root]),
                        UnitQuaternion::identity(),
                    )
                })
                .collect(),
            attitudes: vec![UnitQuaternion::identity(); self.kinds.len()],
        }
    }

    /// Pose of every body, points included, when the links have these lengths.
    ///
    /// $x_{body} = x_{to} + l\, Q\, e$ along the tree of each linkage, $Q$ the rotation of its frame.
    ///
    /// # Errors
    /// A length that is not positive, or lengths that do not close a loop (to 1e-9 of the longest link: rounding
    /// along any realistic loop is far below, and a real misfit far above).
    pub fn place(&self, state: &State, lengths: &[f64]) -> Result<Vec<Isometry3<f64>>, RigidError> {
        self.check(state)?;
        check_length("lengths of the links", lengths.len(), self.links.len())?;
        if let Some(bad) = lengths.iter().position(|l| !(l.is_finite() && *l > 0.0)) {
            return Err(RigidError::BadLength {
                link: self.links[bad].name.clone(),
                length: lengths[bad],
            });
        }
        let mut positions = vec![Vector3::zeros(); self.kinds.len()];
        for (linkage, frame) in self.linkages.iter().zip(&state.frames) {
            positions[linkage.root] = frame.translation.vector;
            for edge in &linkage.tree {
                let arm = lengths[edge.link] * (frame.rotation * self.directions[edge.link]);
                let outward = if self.links[edge.link].body == edge.child {
                    arm
                } else {
                    -arm
                };
                positions[edge.child] = positions[edge.parent] + outward;
            }
        }
        let longest = lengths.iter().fold(0.0_f64, |a, &b| a.max(b));
        for (number, link) in self.links.iter().enumerate() {
            let arm = lengths[number] * self.direction(state, number);
            let gap = (positions[link.body] - positions[link.to] - arm).norm();
            if gap > 1e-9 * longest {
                return Err(RigidError::OpenLoop {
                    link: link.name.clone(),
                    gap,
                });
            }
        }
        Ok(positions
            .into_iter()
            .zip(&state.attitudes)
            .map(|(x, q)| Isometry3::from_parts(Translation3::from(x), *q))
            .collect())
    }

    pub(crate) fn check(&self, state: &State) -> Result<(), RigidError> {
        check_length(
            "frames of the linkages",
            state.frames.len(),
            self.linkages.len(),
        )?;
        check_length(
            "attitudes of the bodies",
            state.attitudes.len(),
            self.kinds.len(),
        )
    }
}

pub(crate) fn check_length(
    what: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), RigidError> {
    if found == expected {
        Ok(())
    } else {
        Err(RigidError::Length {
            what,
            expected,
            found,
        })
    }
}

/// Breadth-first spanning trees of the joint graph, roots being the lowest-numbered bodies.
fn find_linkages(bodies: usize, links: &[Link]) -> Vec<Linkage> {
    let mut neighbours = vec![Vec::new(); bodies];
    for (number, link) in links.iter().enumerate() {
        neighbours[link.body].push((number, link.to));
        neighbours[link.to].push((number, link.body));
    }
    let mut reached = vec![false; bodies];
    let mut linkages = Vec::new();
    for root in 0..bodies {
        if reached[root] {
            continue;
        }
        reached[root] = true;
        let mut linkage = Linkage {
            root,
            bodies: vec![root],
            tree: Vec::new(),
        };
        let mut next = 0;
        while let Some(&parent) = linkage.bodies.get(next) {
            next += 1;
            for &(link, child) in &neighbours[parent] {
                if !reached[child] {
                    reached[child] = true;
                    linkage.bodies.push(child);
                    linkage.tree.push(TreeEdge {
                        link,
                        parent,
                        child,
                    });
                }
            }
        }
        linkages.push(linkage);
    }
    linkages
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn link(body: usize, to: usize) -> Link {
        Link {
            name: format!("{body}-{to}"),
            body,
            to,
        }
    }

    #[test]
    fn a_chain_is_placed_along_its_links() {
        let x = [
            Vector3::new(-10.0, 0.0, 0.0),
            Vector3::zeros(),
            Vector3::new(10.0, 0.0, 0.0),
        ];
        let set = Articulation::new(
            &[BodyKind::Rigid; 3],
            vec![link(0, 1), link(2, 1)],
            Arms::Clamped,
            &x,
        )
        .unwrap();
        let state = set.initial_state();
        let poses = set.place(&state, &[6.0, 10.0]).unwrap();
        // The root is body 0: its frame stays and the others come closer.
        assert_relative_eq!(poses[0].translation.vector, x[0]);
        assert_relative_eq!(poses[1].translation.vector, Vector3::new(-4.0, 0.0, 0.0));
        assert_relative_eq!(poses[2].translation.vector, Vector3::new(6.0, 0.0, 0.0));
    }

    #[test]
    fn a_triangle_must_close() {
        let x = [Vector3::zeros(), Vector3::x(), Vector3::y()];
        let links = vec![link(1, 0), link(2, 0), link(2, 1)];
        let set = Articulation::new(&[BodyKind::Rigid; 3], links, Arms::Clamped, &x).unwrap();
        let lengths = set.initial_lengths().to_vec();
        assert!(set.place(&set.initial_state(), &lengths).is_ok());
        let longer = [lengths[0], lengths[1], lengths[2] + 0.1];
        assert!(matches!(
            set.place(&set.initial_state(), &longer),
            Err(RigidError::OpenLoop { .. })
        ));
    }

    #[test]
    fn separate_linkages_and_loose_points_are_found() {
        let x = [Vector3::zeros(), Vector3::x(), 5.0 * Vector3::y()];
        let set =
            Articulation::new(&[BodyKind::Rigid; 3], vec![link(0, 1)], Arms::Free, &x).unwrap();
        assert_eq!(set.linkages().len(), 2);
        assert_eq!(set.linkage_of(), &[0, 0, 1]);
        let kinds = [BodyKind::Rigid, BodyKind::Rigid, BodyKind::Point];
        let loose = Articulation::new(&kinds, vec![link(0, 1)], Arms::Free, &x);
        assert_eq!(loose.unwrap_err(), RigidError::LoosePoint { body: 2 });
    }
}
