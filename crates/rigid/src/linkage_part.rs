//! The linkages of an articulated set as sets of their own.

use crate::articulation::selected;
use crate::{Articulation, Joint, Linkage, State};

/// One linkage of an articulated set, as a set of its own.
///
/// No joint connects two linkages, so that constraints, the motions that they allow and the loads
/// of joints are those of the parts: `O(n)` for `n` linkages, where matrices of the whole set take
/// `O(n²)`.
#[derive(Clone, Debug)]
pub struct LinkagePart {
    set: Articulation,
    linkage: usize,
    bodies: Vec<usize>,
    joints: Vec<usize>,
    /// Places of its passive joints among those of the whole set.
    passive: Vec<usize>,
    /// Generalised velocities of the whole set, one per velocity of the part.
    velocities: Vec<usize>,
}

impl LinkagePart {
    /// The linkage alone. Its bodies and joints are in the order of the whole set.
    pub fn set(&self) -> &Articulation {
        &self.set
    }

    /// Index of the linkage in the whole set.
    pub fn linkage(&self) -> usize {
        self.linkage
    }

    /// Indices of its bodies in the whole set, ascending.
    pub fn bodies(&self) -> &[usize] {
        &self.bodies
    }

    /// Indices of its joints in the whole set, ascending.
    pub fn joints(&self) -> &[usize] {
        &self.joints
    }

    /// Places of its passive joints among those of the whole set, ascending.
    pub fn passive_joints(&self) -> &[usize] {
        &self.passive
    }

    /// Indices of its generalised velocities in the [`VelocityLayout`](crate::VelocityLayout) of
    /// the whole set.
    pub fn velocities(&self) -> &[usize] {
        &self.velocities
    }

    /// State of the part in a state of the whole set; numbers that the state lacks are left out.
    pub fn state(&self, whole: &State) -> State {
        State {
            frames: whole
                .frames
                .get(self.linkage)
                .into_iter()
                .copied()
                .collect(),
            attitudes: selected(&whole.attitudes, &self.bodies),
            joints: selected(&whole.joints, &self.passive),
        }
    }

    /// The entries of its joints in a list with one entry per joint of the whole set.
    pub fn of_joints<T: Clone>(&self, whole: &[T]) -> Vec<T> {
        selected(whole, &self.joints)
    }

    /// The entries of its bodies in a list with one entry per body of the whole set.
    pub fn of_bodies<T: Clone>(&self, whole: &[T]) -> Vec<T> {
        selected(whole, &self.bodies)
    }
}

impl Articulation {
    /// The linkages as sets of their own, in their order.
    ///
    /// Cost: `O(n)` for linkages of bounded size.
    pub fn parts(&self) -> Vec<LinkagePart> {
        let layout = self.velocity_layout();
        let mut joints = vec![Vec::new(); self.linkages().len()];
        for (number, joint) in self.joints().iter().enumerate() {
            // The amplitude of a deformation moves no body and belongs to no linkage.
            if !joint.kind.is_deformation() {
                joints[self.linkage_of()[joint.body]].push(number);
            }
        }
        let mut places = vec![usize::MAX; self.joints().len()];
        for (place, (joint, _)) in self.passive_drives().enumerate() {
            places[joint] = place;
        }
        let passive_columns: Vec<usize> = layout.joints().collect();
        let mut own_number = vec![0; self.kinds().len()];
        let parts = self.linkages().iter().zip(joints).enumerate();
        let part = |(linkage, (whole, joints)): (usize, (&Linkage, Vec<usize>))| {
            let mut bodies = whole.bodies.clone();
            bodies.sort_unstable();
            for (number, &body) in bodies.iter().enumerate() {
                own_number[body] = number;
            }
            let own_joints: Vec<Joint> = (joints.iter())
                .map(|&joint| {
                    let mut own = self.joints()[joint].clone();
                    (own.body, own.to) = (own_number[own.body], own_number[own.to]);
                    own
                })
                .collect();
            let set = self.subset(&bodies, &joints, own_joints);
            let passive: Vec<usize> = (joints.iter().map(|&joint| places[joint]))
                .filter(|&place| place != usize::MAX)
                .collect();
            let mut velocities = Vec::new();
            for &body in &bodies {
                let first = layout.bodies()[body];
                let count = if layout.is_rigid(body) { 6 } else { 3 };
                velocities.extend(first..first + count);
            }
            let frames = (0..set.frames()).filter_map(|k| layout.frame(whole.first_frame + k));
            velocities.extend(frames.flat_map(|first| first..first + 3));
            velocities.extend(passive.iter().map(|&place| passive_columns[place]));
            LinkagePart {
                set,
                linkage,
                bodies,
                joints,
                passive,
                velocities,
            }
        };
        parts.map(part).collect()
    }
}
