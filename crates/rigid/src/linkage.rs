//! Linkages: the connected sets that joints form, with their frames and spanning trees.

use crate::Joint;

/// A connected set of bodies.
///
/// It consists of frames: sets of bodies whose arms keep their angles to each other. Joints that
/// turn connect different frames; without them a linkage has one frame.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Linkage {
    /// The body at the origin of the first frame: of the bodies whose translation is held, or else
    /// of all bodies, the one with the lowest index.
    pub root: usize,
    /// All bodies of the set in breadth-first order, the root first.
    pub bodies: Vec<usize>,
    /// Edges of the spanning tree, one for each body after the root, in the order of `bodies`.
    pub(crate) tree: Vec<TreeEdge>,
    /// Number of the frame of the root; those of the other frames follow it.
    pub(crate) first_frame: usize,
}

/// An edge of the spanning tree of a linkage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TreeEdge {
    pub joint: usize,
    pub parent: usize,
    pub child: usize,
}

/// Breadth-first spanning trees of the graph of bodies and joints, in the order of their lowest
/// indices.
///
/// Each is rooted at its first body that is `held`, whose motion then has no errors of joints; or
/// else at its first body. Returns the linkages and the frames.
pub(crate) fn find_linkages(held: &[bool], joints: &[Joint]) -> (Vec<Linkage>, Frames) {
    let bodies = held.len();
    let mut neighbours = vec![Vec::new(); bodies];
    for (number, joint) in joints.iter().enumerate() {
        if joint.kind.is_deformation() {
            continue;
        }
        neighbours[joint.body].push((number, joint.to));
        neighbours[joint.to].push((number, joint.body));
    }
    let mut reached = vec![false; bodies];
    let mut frames = Frames {
        of_body: vec![usize::MAX; bodies],
        count: 0,
    };
    let mut linkages = Vec::new();
    for first in 0..bodies {
        if reached[first] {
            continue;
        }
        let mut members = vec![first];
        let mut next = 0;
        while let Some(&member) = members.get(next) {
            next += 1;
            for &(_, other) in &neighbours[member] {
                if !members.contains(&other) {
                    members.push(other);
                }
            }
        }
        let of_held = members.iter().filter(|&&member| held[member]).min();
        let root = of_held.copied().unwrap_or(first);
        reached[root] = true;
        let mut linkage = Linkage {
            root,
            bodies: vec![root],
            tree: Vec::new(),
            first_frame: frames.count,
        };
        let mut next = 0;
        while let Some(&parent) = linkage.bodies.get(next) {
            next += 1;
            frames.add(parent, joints, &neighbours);
            for &(joint, child) in &neighbours[parent] {
                if !reached[child] {
                    reached[child] = true;
                    linkage.bodies.push(child);
                    linkage.tree.push(TreeEdge {
                        joint,
                        parent,
                        child,
                    });
                }
            }
        }
        linkages.push(linkage);
    }
    (linkages, frames)
}

/// The frames of all linkages.
pub(crate) struct Frames {
    /// Number of the frame of each body.
    pub of_body: Vec<usize>,
    /// Number of frames.
    pub count: usize,
}

impl Frames {
    /// Numbers the frame of a body, if it has no number yet: all bodies that joints without
    /// rotation connect to it.
    fn add(&mut self, body: usize, joints: &[Joint], neighbours: &[Vec<(usize, usize)>]) {
        if self.of_body[body] != usize::MAX {
            return;
        }
        let mut members = vec![body];
        self.of_body[body] = self.count;
        while let Some(member) = members.pop() {
            for &(joint, other) in &neighbours[member] {
                if !joints[joint].kind.turns() && self.of_body[other] == usize::MAX {
                    self.of_body[other] = self.count;
                    members.push(other);
                }
            }
        }
        self.count += 1;
    }
}
