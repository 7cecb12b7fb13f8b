//! Continuous detection of contact: bodies and walls along a path, not at points of it.
//!
//! Between two positions of a path at the distance `h` of its parameter, every point of a body
//! deviates from the line between its places there by at most `h² a / 8`, with the largest
//! acceleration `a` of the points of the body (the error of linear interpolation). Hence
//!
//! - the distance of two centres is at least that of two points that move along these lines, minus
//!   `h² (a_1 + a_2) / 8`, and spheres around the bodies do not touch while it exceeds their radii;
//! - two planes of one direction that touch two bodies from between are at least as far apart as at
//!   the nearer of the two positions, minus the same, and the bodies do not touch while this is
//!   positive;
//! - the clearance from a convex wall is at least the smaller one of the two positions, minus
//!   `h² a / 8`.
//!
//! The radius of a body that deforms is a function of its amplitudes that is nowhere larger between
//! two shapes than at one of them, and amplitudes deviate from lines like positions. Tubes that
//! undulate keep the shape of one position, and all distances are smaller by the longest way of
//! their points.
//!
//! Where this does not exclude contact the part of the path is halved (conservative advancement,
//! Mirtich 1996, with a bound of second order, so that bodies that slide along each other in a
//! narrow gap take few parts). Pairs of one linkage are seen from its frame: a swimmer that moves
//! as a rigid body has no relative motion. In a periodic box every image of a body that the other
//! one can reach along the path counts as a body.

use std::borrow::Cow;

use nalgebra::{Isometry3, Translation3, Vector3};
use rigid::{Articulation, MotionBounds, RigidError, State, StateBounds};

use crate::body::Body;
use crate::contact::{Contact, closest_approach};
use crate::deformation::Deformation;
use crate::domain::Domain;
use crate::hull_distance::{Pair, distance_along, separation};
use crate::shape::Shape;

/// Part of the path to which the place of a contact is found.
const RESOLUTION: f64 = 1.0 / 1024.0;

/// Part of the path that is not divided again: about its rounding.
const LEAST_WIDTH: f64 = 1e-15;

/// Largest number of placements of the bodies along one path. A pair of unit spheres that circle
/// about each other in a gap of 1e-6 needs a thousand.
const MAX_PLACEMENTS: usize = 8192;

/// Largest number of periodic images of a body that another one can reach along a path; with more,
/// the path is too long to exclude contact.
const MAX_IMAGES: f64 = 1000.0;

/// Factor on distances within which bodies can meet, so that those that touch by rounding are among
/// them.
const TOUCHING: f64 = 1.0 + 1e-9;

/// The bodies and the motion that they follow along a path with the parameter from 0 to 1.
#[derive(Clone, Copy)]
pub struct BodyPath<'a> {
    /// The bodies. Those that deform count as the balls around them.
    pub bodies: &'a [Body],
    /// The bodies as an articulated set.
    pub set: &'a Articulation,
    /// The region that the fluid fills.
    pub domain: &'a Domain,
    /// State and values of the joints at a position of the path.
    pub at: &'a dyn Fn(f64) -> Result<(State, Vec<f64>), RigidError>,
    /// Bounds on their derivatives with respect to the parameter.
    pub bounds: &'a StateBounds,
}

/// Where bodies touch along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PathContact {
    /// Position on the path, from 0 to 1.
    pub at: f64,
    /// The bodies and their gap at this position.
    pub contact: Contact,
    /// Whether the bodies touch at this position; else contact near it could not be excluded with
    /// thousands of placements.
    pub is_certain: bool,
}

/// The first contact along a path; `None` if no bodies touch, which is certain if the bounds hold.
///
/// They do but for loops that passive joints close, where the bounds leave out the projection onto
/// the loop ([`Articulation::motion_bounds`]). Walls of a mesh file count where its facets are
/// known.
///
/// Bodies touch as [`Contact::touches`] says, at the start and at the end of the path too. Points
/// have no surface and touch nothing; shapes other than spheres count as their convex hulls. Cost
/// where bodies are far apart: two placements, and a few operations per pair whose ways overlap
/// along the x axis, in a periodic box per pair.
///
/// # Errors
/// States or values that cannot be placed, bounds that do not fit the articulated set.
///
/// ```
/// use scene::{BodyPath, Scene, first_contact};
/// use scene::rigid::StateBounds;
///
/// let scene = Scene::builder()
///     .sphere("small", 0.01, [-5.0, 0.0, 0.0])
///     .sphere("fixed", 1.0, [0.0, 0.0, 0.0])
///     .build()?;
/// let set = scene.articulation();
/// // The small sphere moves from -5 to 5 at a constant velocity: through the other one.
/// let at = |t: f64| {
///     let mut state = set.initial_state();
///     state.frames[0].translation.vector.x += 10.0 * t;
///     Ok((state, Vec::new()))
/// };
/// let mut bounds = StateBounds::at_rest(set, Vec::new());
/// bounds.frames[0].linear.first = 10.0;
/// let (bodies, domain) = (scene.bodies(), scene.domain());
/// let path = BodyPath { bodies, set, domain, at: &at, bounds: &bounds };
/// let found = first_contact(&path)?.expect("they touch");
/// assert!((found.at - 0.399).abs() < 1e-3 && found.contact.gap < 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn first_contact(path: &BodyPath) -> Result<Option<PathContact>, RigidError> {
    first_contact_among(path, &|_, _| true)
}

/// As [`first_contact`], of some pairs of bodies; a body with itself stands for the wall.
pub(crate) fn first_contact_among(
    path: &BodyPath,
    includes: &dyn Fn(usize, usize) -> bool,
) -> Result<Option<PathContact>, RigidError> {
    let solid: Vec<usize> = (0..path.bodies.len().min(path.set.kinds().len()))
        .filter(|&body| path.bodies[body].bounding_radius() > 0.0)
        .collect();
    // shapes that no pair depends on need not exist: a run says which loop does not close
    let is_included = |(k, &one): (usize, &usize)| {
        let before = &solid[..k];
        (has_walls(path.domain) && includes(one, one))
            || before.iter().any(|&other| includes(other, one))
    };
    if !solid.iter().enumerate().any(is_included) {
        return Ok(None);
    }
    let mut search = Search {
        path,
        lab: path.set.motion_bounds(path.bounds)?,
        relative: path
            .set
            .motion_bounds(&path.bounds.relative_to_frames(path.set))?,
        placements: MAX_PLACEMENTS,
    };
    let [start, end] = [search.place(0.0)?, search.place(1.0)?];
    let linkage = path.set.linkage_of();
    let pair = |[other, one]: [usize; 2]| match linkage[one] == linkage[other] {
        _ if one == other => ContactPair::Wall(one),
        true => ContactPair::Within(other, one),
        false => ContactPair::Between(other, one, Vector3::zeros()),
    };
    let mut near = search.meeting(&solid, (&start, &end));
    if has_walls(path.domain) {
        near.extend(solid.iter().map(|&body| [body, body]));
    }
    near.retain(|&[other, one]| includes(other, one));
    // A body comes with the wall, and then with those before it.
    near.sort_unstable_by_key(|&[other, one]| (one, other != one, other));
    let mut pairs: Vec<ContactPair> = near.into_iter().map(pair).collect();
    if let Some(size) = path.domain.period() {
        match search.with_images(&pairs, &size, (&start, &end)) {
            Ok(all) => pairs = all,
            Err(contact) => {
                return Ok(Some(PathContact {
                    at: start.at,
                    contact,
                    is_certain: false,
                }));
            }
        }
    }
    let mut first: Option<PathContact> = None;
    for pair in pairs {
        if search.excludes(pair, &start, &end) {
            continue;
        }
        let found = match search.touching(pair, &start) {
            Some(contact) => Some(contact),
            None => search.halve(pair, &start, &end)?,
        };
        if let Some(found) = found
            && first.is_none_or(|first| found.at < first.at)
        {
            first = Some(found);
        }
    }
    Ok(first)
}

/// Whether a domain has walls that bodies can touch.
fn has_walls(domain: &Domain) -> bool {
    !matches!(
        domain,
        Domain::Unbounded | Domain::Periodic { .. } | Domain::Mesh { facets: None, .. }
    )
}

/// Two surfaces that may touch.
#[derive(Clone, Copy)]
enum ContactPair {
    /// Two bodies of one linkage.
    Within(usize, usize),
    /// Two bodies of different linkages, or a body and the image of another one that is shifted by
    /// this vector.
    Between(usize, usize, Vector3<f64>),
    /// A body and the wall.
    Wall(usize),
}

/// The bodies at a position of a path.
struct Placement {
    at: f64,
    state: State,
    values: Vec<f64>,
    poses: Vec<Isometry3<f64>>,
}

struct Search<'a> {
    path: &'a BodyPath<'a>,
    /// Bounds on the motion of the bodies in the laboratory.
    lab: Vec<MotionBounds>,
    /// Bounds on their motion as seen from the frames of their linkages.
    relative: Vec<MotionBounds>,
    /// Number of placements that are left.
    placements: usize,
}

impl Search<'_> {
    fn place(&self, at: f64) -> Result<Placement, RigidError> {
        let (state, shape) = (self.path.at)(at)?;
        let poses = self.path.set.place(&state, &shape)?;
        Ok(Placement {
            at,
            state,
            values: shape,
            poses,
        })
    }

    /// Pairs of different bodies that can reach each other along the path, the first one first; in
    /// a periodic box all pairs.
    fn meeting(&self, bodies: &[usize], (start, end): (&Placement, &Placement)) -> Vec<[usize; 2]> {
        let ball = |&body: &usize| {
            let [from, to] = [start, end].map(|placed| placed.poses[body].translation.vector);
            // The bounds leave out the projection onto loops that passive joints close; those that
            // are no numbers exclude nothing.
            let (most, apart) = (
                self.lab[body].linear.first * (end.at - start.at),
                (to - from).norm(),
            );
            let way = if most >= apart { most } else { most + apart };
            let reach = match self.path.domain.period() {
                Some(_) => f64::INFINITY,
                None => self.largest_radius(body, start, end) + way,
            };
            (from, TOUCHING * reach, body)
        };
        let mut balls: Vec<(Vector3<f64>, f64, usize)> = bodies.iter().map(ball).collect();
        let lowest = |(x, reach, _): &(Vector3<f64>, f64, usize)| match (x.x - reach).is_nan() {
            true => f64::NEG_INFINITY,
            false => x.x - reach,
        };
        balls.sort_by(|one, other| lowest(one).total_cmp(&lowest(other)));
        let mut pairs = Vec::new();
        for (place, (x, reach, body)) in balls.iter().enumerate() {
            let after = balls[place + 1..].iter();
            let is_beyond = |ball: &&_| lowest(ball) > x.x + reach;
            for (y, other_reach, other) in after.take_while(|ball| !is_beyond(ball)) {
                let is_apart = (x - y).norm_squared() > (reach + other_reach).powi(2);
                if !is_apart {
                    pairs.push([*body.min(other), *body.max(other)]);
                }
            }
        }
        pairs
    }

    /// Pairs with the images that the bodies can reach along the path in a periodic box.
    ///
    /// Bodies keep their distance from images of their own.
    ///
    /// # Errors
    /// The gap at the start of a pair that can reach too many.
    fn with_images(
        &self,
        pairs: &[ContactPair],
        size: &Vector3<f64>,
        (start, end): (&Placement, &Placement),
    ) -> Result<Vec<ContactPair>, Contact> {
        let mut all = Vec::new();
        for &pair in pairs {
            let [one, other] = bodies(pair);
            let is_within = matches!(pair, ContactPair::Within(..));
            if is_within {
                all.push(pair);
            }
            let free = ContactPair::Between(one, other, Vector3::zeros());
            let reach = self.size(pair, |body| self.largest_radius(body, start, end))
                + self.speed(free) * (end.at - start.at);
            let apart = offset(&[one, other].map(|body| start.poses[body]));
            let lowest = (apart.add_scalar(-reach)).zip_map(size, |x, edge| (x / edge).ceil());
            let highest = (apart.add_scalar(reach)).zip_map(size, |x, edge| (x / edge).floor());
            let counts = (highest - lowest).map(|count| (count + 1.0).max(0.0));
            // The comparison also rejects bounds that are not numbers.
            let is_few = counts.product() <= MAX_IMAGES;
            if !is_few {
                return Err(self.contact(free, start));
            }
            let [x, y, z] = [0, 1, 2].map(|k| (0..counts[k] as usize).map(move |n| n as f64));
            for number in x.flat_map(|x| {
                let (y, z) = (y.clone(), z.clone());
                y.flat_map(move |y| z.clone().map(move |z| Vector3::new(x, y, z)))
            }) {
                let number = lowest + number;
                if !(is_within && number == Vector3::zeros()) {
                    let shift = number.component_mul(size);
                    all.push(ContactPair::Between(one, other, shift));
                }
            }
        }
        Ok(all)
    }

    /// Radius of the ball around a body.
    fn radius(&self, body: usize, placed: &Placement) -> f64 {
        self.path.bodies[body].bounding_radius_at(&placed.values)
    }

    /// Upper bound of the radius of the ball around a body between two positions.
    ///
    /// Amplitudes exceed those at the ends by at most `h² a'' / 8`.
    fn largest_radius(&self, body: usize, from: &Placement, to: &Placement) -> f64 {
        let body = &self.path.bodies[body];
        let Some(deformation) = &body.deformation else {
            return body.bounding_radius();
        };
        let excess = |joint: usize| self.excess(joint, from, to);
        let deformation = match deformation {
            Deformation::Sphere(sphere) => sphere,
            Deformation::Undulation(tube) => {
                let ends = [from, to].map(|placed| body.bounding_radius_at(&placed.values));
                let [amplitude, _] = tube.joints;
                let offset = tube.wave.offset(tube.tube.length);
                return ends[0].max(ends[1]) + offset * excess(amplitude);
            }
            Deformation::Triangles(of) => {
                // The farthest position is at most half of the way from one of the ends.
                let change = |joint: usize| {
                    0.5 * (to.values[joint] - from.values[joint]).abs() + excess(joint)
                };
                let ends = [from, to].map(|placed| of.largest_radius(&placed.values, &change));
                return ends[0].max(ends[1]);
            }
        };
        let ends = [from, to].map(|placed| {
            let mut values = placed.values.clone();
            if let Some(size) = deformation.size {
                let joint = size.joint();
                values[joint] = match size.grows_with_value() {
                    true => from.values[joint].max(to.values[joint]) + excess(joint),
                    false => from.values[joint].min(to.values[joint]) - excess(joint),
                };
            }
            let modes = deformation
                .modes
                .iter()
                .flat_map(|modes| &modes.coordinates);
            let of_modes: f64 = modes.map(|(_, joint)| excess(*joint)).sum();
            deformation.bounding_radius_within(&values, of_modes)
        });
        ends[0].max(ends[1])
    }

    /// Sum over two bodies of what their largest radii between two positions exceed the smaller
    /// ones there by.
    fn swelling(&self, pair: ContactPair, from: &Placement, to: &Placement) -> f64 {
        let of_body = |body: usize| {
            let least = self.radius(body, from).min(self.radius(body, to));
            self.largest_radius(body, from, to) - least
        };
        members(pair).map(of_body).sum()
    }

    /// Upper bound of the sum of the distances by which points of tubes that undulate move relative
    /// to their bodies between two positions.
    fn bending(&self, pair: ContactPair, from: &Placement, to: &Placement) -> f64 {
        let of_body = |body: usize| {
            let Some(Deformation::Undulation(tube)) = &self.path.bodies[body].deformation else {
                return 0.0;
            };
            let [amplitude, phase] = tube.joints.map(|joint| {
                let [start, end] = [from, to].map(|placed| placed.values[joint]);
                let excess = self.excess(joint, from, to);
                let largest = start.abs().max(end.abs()) + excess;
                (largest, (end - start).abs() + 2.0 * excess)
            });
            let [of_amplitude, of_phase] = tube.speeds(amplitude.0);
            of_amplitude * amplitude.1 + of_phase * phase.1
        };
        members(pair).map(of_body).sum()
    }

    /// Upper bound of the distance of a value between two positions from the line between its
    /// values there.
    fn excess(&self, joint: usize, from: &Placement, to: &Placement) -> f64 {
        let (width, bounds) = (to.at - from.at, self.path.bounds.joints.get(joint));
        bounds.map_or(0.0, |of| width * width / 8.0 * of.derivatives.second)
    }

    /// Poses of two bodies, from their frame if they have the same.
    fn poses(&self, pair: ContactPair, placed: &Placement) -> Option<[Isometry3<f64>; 2]> {
        match pair {
            ContactPair::Wall(_) => None,
            ContactPair::Between(one, other, shift) => Some([
                placed.poses[one],
                Translation3::from(shift) * placed.poses[other],
            ]),
            ContactPair::Within(one, other) => {
                let frame = placed.state.frames[self.path.set.linkage_of()[one]].inverse();
                Some([one, other].map(|body| frame * placed.poses[body]))
            }
        }
    }

    fn contact(&self, pair: ContactPair, placed: &Placement) -> Contact {
        let (body, other) = match pair {
            ContactPair::Wall(body) => (body, None),
            ContactPair::Within(one, other) | ContactPair::Between(one, other, _) => {
                (one, Some(other))
            }
        };
        let gap = match self.poses(pair, placed) {
            Some(poses) => {
                let shapes = self.shapes(pair, placed, |body| self.radius(body, placed));
                separation(placed_shapes(&shapes, &poses), &offset(&poses)).0
            }
            None => self.clearance(body, placed),
        };
        Contact { body, other, gap }
    }

    /// The contact at a position, if the bodies touch there.
    fn touching(&self, pair: ContactPair, placed: &Placement) -> Option<PathContact> {
        let contact = self.contact(pair, placed);
        let size = self.size(pair, |body| self.radius(body, placed));
        contact.touches(size).then_some(PathContact {
            at: placed.at,
            contact,
            is_certain: true,
        })
    }

    /// The first contact on a part of the path at whose start the bodies do not touch.
    fn halve(
        &mut self,
        pair: ContactPair,
        from: &Placement,
        to: &Placement,
    ) -> Result<Option<PathContact>, RigidError> {
        if self.excludes(pair, from, to) {
            return Ok(None);
        }
        let width = to.at - from.at;
        let largest = self.size(pair, |body| self.largest_radius(body, from, to));
        let rounding = 1e-12 * largest;
        let swelling = self.swelling(pair, from, to) + self.bending(pair, from, to);
        match self.touching(pair, to) {
            Some(found) if width <= RESOLUTION => return Ok(Some(found)),
            None if self.deviation(pair, width) + swelling <= rounding => {
                if width <= RESOLUTION
                    && let Some(found) = self.contact_of_lines(pair, from, to)
                {
                    return Ok(Some(found));
                }
                if width * self.speed(pair) <= rounding {
                    return Ok(None);
                }
            }
            _ => {}
        }
        let middle = self.place(0.5 * (from.at + to.at))?;
        // Bounds that are no numbers exclude nothing on any part.
        if self.placements == 0 || width < LEAST_WIDTH {
            let contact = self.contact(pair, &middle);
            return Ok(Some(PathContact {
                at: middle.at,
                contact,
                is_certain: contact.touches(largest),
            }));
        }
        self.placements = self.placements.saturating_sub(self.cost(pair));
        match self.halve(pair, from, &middle)? {
            Some(found) => Ok(Some(found)),
            None => self.halve(pair, &middle, to),
        }
    }

    /// Whether the bounds exclude contact between two positions.
    fn excludes(&self, pair: ContactPair, from: &Placement, to: &Placement) -> bool {
        let width = to.at - from.at;
        let bending = self.bending(pair, from, to);
        let deviation = self.deviation(pair, width) + bending;
        let Some((start, end)) = self.poses(pair, from).zip(self.poses(pair, to)) else {
            let ContactPair::Wall(body) = pair else {
                return false;
            };
            let largest = self.largest_radius(body, from, to);
            let [start, end] = [from, to]
                .map(|placed| self.clearance(body, placed) + self.radius(body, placed) - largest);
            return match self.path.domain {
                // The distance from a wall of any shape changes by the path of the body at most.
                Domain::Surface(_) | Domain::Mesh { .. } => {
                    start + end > width * self.speed(pair) + 2.0 * bending
                }
                // The shape at one end is off by the bending at the other one.
                _ => start.min(end) > deviation + bending,
            };
        };
        let [offset_start, offset_end] = [&start, &end].map(offset);
        let centres = closest_approach(&offset_start, &offset_end).1;
        let bounds = self.bounds(pair);
        let of_centres = width * width / 8.0 * bounds.map(|b| b.linear.second).iter().sum::<f64>();
        let size = self.size(pair, |body| self.largest_radius(body, from, to));
        if centres - size > of_centres {
            return true;
        }
        if self.is_isotropic(pair) {
            return false;
        }
        let shapes = self.shapes(pair, from, |body| self.largest_radius(body, from, to));
        [&start, &end].into_iter().any(|poses| {
            let (gap, normal) = separation(placed_shapes(&shapes, poses), &offset(poses));
            let along = |poses: &[Isometry3<f64>; 2]| {
                distance_along(placed_shapes(&shapes, poses), &offset(poses), &normal)
            };
            gap > deviation && along(&start).min(along(&end)) > deviation
        })
    }

    /// The contact of two spheres whose centres move along lines between two positions.
    fn contact_of_lines(
        &self,
        pair: ContactPair,
        from: &Placement,
        to: &Placement,
    ) -> Option<PathContact> {
        if !self.is_isotropic(pair) {
            return None;
        }
        let (start, end) = self.poses(pair, from).zip(self.poses(pair, to))?;
        let (s, distance) = closest_approach(&offset(&start), &offset(&end));
        let contact = Contact {
            gap: distance - self.size(pair, |body| self.largest_radius(body, from, to)),
            ..self.contact(pair, from)
        };
        Some(PathContact {
            at: from.at + s * (to.at - from.at),
            contact,
            is_certain: true,
        })
    }

    /// Largest deviation of the distance of two points, or of a point and a wall, from linear
    /// interpolation over a part of the path.
    fn deviation(&self, pair: ContactPair, width: f64) -> f64 {
        let bounds = self.bounds(pair);
        let of_body = |(bounds, body): (&MotionBounds, usize)| {
            let shape = &self.path.bodies[body].shape;
            match shape.is_isotropic() {
                true => bounds.linear.second,
                false => bounds.acceleration(self.path.bodies[body].largest_radius()),
            }
        };
        let accelerations = bounds.iter().zip(bodies(pair)).map(of_body);
        width * width / 8.0 * accelerations.sum::<f64>()
    }

    /// Largest speed of the points of the bodies relative to each other or to the wall.
    fn speed(&self, pair: ContactPair) -> f64 {
        let radius = |body: usize| self.path.bodies[body].largest_radius();
        let speeds = (self.bounds(pair).into_iter().zip(bodies(pair)))
            .map(|(bounds, body)| bounds.speed(radius(body)));
        speeds.sum()
    }

    /// Bounds on the motion of the bodies; zero for a wall.
    fn bounds(&self, pair: ContactPair) -> [MotionBounds; 2] {
        match pair {
            ContactPair::Within(one, other) => [one, other].map(|body| self.relative[body]),
            ContactPair::Between(one, other, _) => [one, other].map(|body| self.lab[body]),
            ContactPair::Wall(body) => [self.lab[body], MotionBounds::default()],
        }
    }

    /// Sum of the radii of the balls around the bodies.
    fn size(&self, pair: ContactPair, radius: impl Fn(usize) -> f64) -> f64 {
        members(pair).map(radius).sum()
    }

    fn is_isotropic(&self, pair: ContactPair) -> bool {
        let shape = |body: usize| &self.path.bodies[body].shape;
        bodies(pair).iter().all(|&body| shape(body).is_isotropic())
    }

    fn clearance(&self, body: usize, placed: &Placement) -> f64 {
        let at = self.path.bodies[body].at(&placed.values);
        self.path.domain.clearance(&at, &placed.poses[body])
    }

    /// Shapes of two bodies at a position; spheres and triangles that deform have these radii.
    fn shapes(
        &self,
        pair: ContactPair,
        placed: &Placement,
        radius: impl Fn(usize) -> f64,
    ) -> [Cow<'_, Shape>; 2] {
        bodies(pair).map(|number| {
            let body = &self.path.bodies[number];
            match &body.deformation {
                None => Cow::Borrowed(&body.shape),
                Some(Deformation::Sphere(_) | Deformation::Triangles(_)) => {
                    Cow::Owned(Shape::sphere(radius(number)))
                }
                Some(tube) => Cow::Owned(tube.outline(&placed.values)),
            }
        })
    }

    /// Cost of one position, in placements: the distance from a wall given by a file takes long.
    fn cost(&self, pair: ContactPair) -> usize {
        match (pair, self.path.domain) {
            (ContactPair::Wall(_), Domain::Surface(_) | Domain::Mesh { .. }) => 32,
            _ => 1,
        }
    }
}

/// Shapes with their rotations.
fn placed_shapes<'p>(shapes: &'p [Cow<'_, Shape>; 2], poses: &'p [Isometry3<f64>; 2]) -> Pair<'p> {
    [0, 1].map(|k| (&*shapes[k], &poses[k].rotation))
}

/// The bodies, one or two.
fn members(pair: ContactPair) -> impl Iterator<Item = usize> {
    let count = match pair {
        ContactPair::Wall(_) => 1,
        ContactPair::Within(..) | ContactPair::Between(..) => 2,
    };
    bodies(pair).into_iter().take(count)
}

/// The bodies; twice the same for a body and a wall.
fn bodies(pair: ContactPair) -> [usize; 2] {
    match pair {
        ContactPair::Within(one, other) | ContactPair::Between(one, other, _) => [one, other],
        ContactPair::Wall(body) => [body, body],
    }
}

/// Centre of the first minus that of the second.
fn offset(poses: &[Isometry3<f64>; 2]) -> Vector3<f64> {
    poses[0].translation.vector - poses[1].translation.vector
}
