//! Vertices of the fluid: a packing that grows from the surfaces inwards.

use super::planes::Planes;
use super::size::SizeField;
use crate::{MeshError, Surface, Vec3};
use std::collections::{HashMap, VecDeque};
use std::hash::{BuildHasherDefault, Hasher};

/// Two vertices are never closer than this part of the wanted edge length.
///
/// The nearest neighbours of a body-centred lattice with mean edge 1 are at 0.93; a front that meets another one leaves
/// vertices in between if they may be a fifth closer. Three spheres of size 0.3 in a ball of radius 40, vertices and mean quality:
/// 0.66: 7312, 0.883; 0.73: 5947, 0.883; 0.76: 5256, 0.880; 0.82: 4191, 0.872; 0.86: 3700, 0.865.
const SPACING: f64 = 0.76;

/// No vertex is closer to a surface than this part of the wanted edge length (0.816 is the height of a regular tet).
const CLEARANCE: f64 = 0.6;

/// Nearest neighbours of a body-centred cubic lattice, in units of half its period: eight along the diagonals, then six.
const LATTICE: [[f64; 3]; 14] = [
    [1.0, 1.0, 1.0],
    [-1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, 1.0, 1.0],
    [1.0, -1.0, -1.0],
    [2.0, 0.0, 0.0],
    [-2.0, 0.0, 0.0],
    [0.0, 2.0, 0.0],
    [0.0, -2.0, 0.0],
    [0.0, 0.0, 2.0],
    [0.0, 0.0, -2.0],
];

/// Half the period over the mean edge length: the Delaunay tets of the lattice have four edges `sqrt(3)` and two edges 2
/// in units of half the period.
const HALF_PERIOD: f64 = 6.0 / (4.0 * 1.732_050_807_568_877_2 + 4.0);

/// Packs vertices into the fluid with the spacing of `field`.
///
/// `surface_points` are there already; `seeds` (apexes of tets on the surface triangles) are tried first, then the lattice
/// neighbours of every vertex taken, in the order of taking. Before that vertices spread along the lines in which `planes` meet, then in the
/// planes, from the surfaces and from each other. Deterministic; cost: some microseconds a vertex.
///
/// # Errors
/// More than `limit` vertices would be needed.
pub(super) fn pack(
    field: &SizeField<'_>,
    surfaces: &[&dyn Surface],
    container: &dyn Surface,
    planes: Planes,
    surface_points: &[Vec3],
    seeds: &[Vec3],
    limit: usize,
) -> Result<Vec<Vec3>, MeshError> {
    let mut packing = Packing {
        field,
        surfaces,
        container,
        planes,
        taken: Vec::new(),
        on_surfaces: surface_points.len(),
        grid: Grid::default(),
    };
    for p in surface_points {
        packing.grid.insert(*p, field.at(*p));
    }
    for own in planes.intersections() {
        let known = surface_points.iter().chain(&packing.taken);
        let sources = known.copied().filter(|p| planes.at(*p).include(own));
        packing.spread(sources.collect(), (1.0, &own.steps()), own, limit)?;
    }
    let mut front: VecDeque<Vec3> = packing.taken.iter().copied().collect();
    for &seed in seeds {
        if packing.offer(seed, Planes::default()) {
            front.push_back(seed);
        }
    }
    let steps = LATTICE.map(Vec3::from);
    packing.spread(front, (HALF_PERIOD, &steps), Planes::default(), limit)?;
    Ok(packing.taken)
}

struct Packing<'a> {
    field: &'a SizeField<'a>,
    surfaces: &'a [&'a dyn Surface],
    container: &'a dyn Surface,
    planes: Planes,
    taken: Vec<Vec3>,
    /// Number of vertices on surfaces.
    on_surfaces: usize,
    grid: Grid,
}

impl Packing<'_> {
    /// Offers what is `steps` in parts of the wanted length from the front, until nothing is taken any more.
    fn spread(
        &mut self,
        mut front: VecDeque<Vec3>,
        (part, steps): (f64, &[Vec3]),
        own: Planes,
        limit: usize,
    ) -> Result<(), MeshError> {
        while let Some(p) = front.pop_front() {
            let length = part * self.field.at(p);
            for step in steps {
                let candidate = p + length * step;
                if self.offer(candidate, own) {
                    front.push_back(candidate);
                }
            }
            if self.on_surfaces + self.taken.len() > limit {
                return Err(MeshError::TooManyVertices { limit });
            }
        }
        Ok(())
    }

    /// Takes the point if it is in the fluid and not too close to anything but its `own` planes.
    fn offer(&mut self, p: Vec3, own: Planes) -> bool {
        let h = self.field.at(p);
        let clear = CLEARANCE * h;
        if self.planes.distance(p, own) < clear
            || -self.container.signed_distance(p) < clear
            || self.grid.any_within(p, SPACING * h, h)
            || self.surfaces.iter().any(|s| is_near(*s, p, clear))
        {
            return false;
        }
        self.grid.insert(p, h);
        self.taken.push(p);
        true
    }
}

/// Whether `p` is inside the shape or within `clear` of it.
pub(super) fn is_near(surface: &dyn Surface, p: Vec3, clear: f64) -> bool {
    let (centre, radius) = surface.bounding_ball();
    (p - centre).norm() < radius + clear && surface.signed_distance(p) < clear
}

/// Points sorted into cubic cells; the cells of a point have about the size wanted there.
///
/// Every point is stored for its own binary order of magnitude of size and the two next to it, so that a search looks at one
/// order only: sizes within one spacing differ by less than a factor of two, as long as they grow by less than a unit a unit.
#[derive(Default)]
struct Grid {
    heads: HashMap<(i32, [i32; 3]), u32, BuildHasherDefault<CellHasher>>,
    /// Points, each with the next one in the same cell.
    entries: Vec<(Vec3, u32)>,
}

impl Grid {
    const NONE: u32 = u32::MAX;

    fn cell(p: Vec3, order: i32) -> [i32; 3] {
        let width = 2f64.powi(order);
        [p.x, p.y, p.z].map(|c| (c / width).floor() as i32)
    }

    fn insert(&mut self, p: Vec3, h: f64) {
        let order = h.log2().ceil() as i32;
        for order in order - 1..=order + 1 {
            let head = self
                .heads
                .entry((order, Self::cell(p, order)))
                .or_insert(Self::NONE);
            self.entries.push((p, *head));
            *head = self.entries.len() as u32 - 1;
        }
    }

    /// Whether a point lies closer to `p` than `reach`, which is at most the size `h`.
    fn any_within(&self, p: Vec3, reach: f64, h: f64) -> bool {
        // Cells are at least `h` wide: those that the ball of radius `reach` meets are at most eight.
        let order = h.log2().ceil() as i32;
        let low = Self::cell(p - Vec3::repeat(reach), order);
        let high = Self::cell(p + Vec3::repeat(reach), order);
        for i in low[0]..=high[0] {
            for j in low[1]..=high[1] {
                for k in low[2]..=high[2] {
                    let head = self.heads.get(&(order, [i, j, k]));
                    let mut entry = head.copied().unwrap_or(Self::NONE);
                    while entry != Self::NONE {
                        let (q, next) = self.entries[entry as usize];
                        if (p - q).norm_squared() < reach * reach {
                            return true;
                        }
                        entry = next;
                    }
                }
            }
        }
        false
    }
}

/// A multiplicative hash of cell numbers (Fibonacci hashing, Knuth volume 3): they need no defence against attacks.
#[derive(Default)]
struct CellHasher(u64);

impl Hasher for CellHasher {
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u32(u32::from(byte));
        }
    }

    fn write_i32(&mut self, i: i32) {
        self.write_u32(i.cast_unsigned());
    }

    fn write_u32(&mut self, i: u32) {
        self.0 = (self.0.rotate_left(23) ^ u64::from(i)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn finish(&self) -> u64 {
        // The map takes its bucket from the low bits, the product is random in the high ones.
        self.0 ^ (self.0 >> 32)
    }
}
