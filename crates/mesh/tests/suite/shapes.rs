//! Meshes for tests.

use mesh::{LinearTets, QuadraticTets, Surface, TetMesh, Vec3};

/// A sphere.
#[derive(Clone, Copy)]
pub struct Sphere {
    pub centre: Vec3,
    pub radius: f64,
}

impl Sphere {
    pub const fn new(centre: Vec3, radius: f64) -> Self {
        Self { centre, radius }
    }
}

impl Surface for Sphere {
    fn signed_distance(&self, point: Vec3) -> f64 {
        (point - self.centre).norm() - self.radius
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        let arm = point - self.centre;
        self.centre + arm * (self.radius / arm.norm())
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        (self.centre, self.radius)
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.radius.powi(3)
    }

    fn is_convex(&self) -> bool {
        true
    }

    fn reach(&self) -> f64 {
        self.radius
    }
}

/// The unit ball as a deformed octahedron with edges divided into `n`: `8 n^3` tets, boundary part
/// `surface`.
pub fn ball(n: u32) -> LinearTets {
    let mut mesh = LinearTets {
        tags: vec!["surface".into()],
        ..LinearTets::default()
    };
    let mut numbers = std::collections::BTreeMap::new();
    // Each octant is the image of the simplex n >= x >= y >= z >= 0 of Kuhn's cube.
    let grid = |end: i32| {
        (0..end).flat_map(move |i| (0..end).flat_map(move |j| (0..end).map(move |k| [i, j, k])))
    };
    for octant in 0..8 {
        let sign = [0, 1, 2].map(|axis| if octant >> axis & 1 == 0 { 1 } else { -1 });
        let mut number = |[x, y, z]: [i32; 3]| {
            let at = [sign[0] * (x - y), sign[1] * (y - z), sign[2] * z];
            *numbers.entry(at).or_insert_with(|| {
                let p = Vec3::from(at.map(f64::from)) / f64::from(n);
                let flat: f64 = p.iter().map(|c| c.abs()).sum();
                mesh.points
                    .push(if flat > 0.0 { p * (flat / p.norm()) } else { p });
                mesh.points.len() as u32 - 1
            })
        };
        for corner in grid(n as i32) {
            for path in [
                [0, 1, 2],
                [0, 2, 1],
                [1, 0, 2],
                [1, 2, 0],
                [2, 0, 1],
                [2, 1, 0],
            ] {
                let mut at = corner;
                let mut places = [corner; 4];
                for (place, axis) in places[1..].iter_mut().zip(path) {
                    at[axis] += 1;
                    *place = at;
                }
                if places.iter().all(|[x, y, z]| x >= y && y >= z) {
                    let tet = places.map(&mut number);
                    mesh.tets.push(tet);
                    let outer: Vec<u32> = (0..4)
                        .filter(|&i| places[i][0] == n as i32)
                        .map(|i| tet[i])
                        .collect();
                    if let [a, b, c] = outer[..] {
                        mesh.faces.push(([a, b, c], 0));
                    }
                }
            }
        }
    }
    let LinearTets { points, tets, .. } = &mut mesh;
    for tet in tets {
        let [a, b, c, d] = tet.map(|v| points[v as usize]);
        if (b - a).cross(&(c - a)).dot(&(d - a)) < 0.0 {
            tet.swap(0, 1);
        }
    }
    mesh
}

/// The sphere that bounds [`ball`].
pub const UNIT_SPHERE: Sphere = Sphere::new(Vec3::new(0.0, 0.0, 0.0), 1.0);

/// [`ball`] with its boundary on the sphere.
pub fn curved_ball(n: u32) -> TetMesh {
    TetMesh::curved(ball(n), &[("surface", &UNIT_SPHERE)]).unwrap()
}

/// The nodes and elements of a mesh as in a second-order file.
pub fn as_quadratic(mesh: &TetMesh) -> QuadraticTets {
    QuadraticTets {
        points: mesh.points().to_vec(),
        tets: mesh.cells().to_vec(),
        faces: mesh.facets().iter().map(|f| (f.nodes, f.tag)).collect(),
        tags: mesh.tags().to_vec(),
        regions: mesh.regions().clone(),
    }
}
