//! Writes the surface of a bent channel as an STL file: `scenes/bent-channel.stl`, if the name is
//! given.

use mesh::{MeshError, Surface, SurfaceMesh, Vec3};
use mesher::{GenerateError, TriangleKind, TriangulatedSurface};
use std::f64::consts::{FRAC_PI_2, PI};

/// Radius of the channel.
const RADIUS: f64 = 4.0;

/// Radius of the middle of the bend.
const BEND: f64 = 12.0;

/// Length of the straight part on either side of the bend.
const STRAIGHT: f64 = 14.0;

/// Points around the channel.
const POINTS_AROUND: usize = 24;

/// The middle of a cross-section and its normal directions, at a length along the channel.
///
/// The channel runs along x to the origin, turns left by a right angle, and runs along y.
fn section(s: f64) -> [Vec3; 3] {
    let arc = (s.clamp(0.0, FRAC_PI_2 * BEND)) / BEND;
    let (sin, cos) = arc.sin_cos();
    let along = Vec3::new(cos, sin, 0.0);
    let beyond = s - arc * BEND;
    let middle = BEND * Vec3::new(sin, 1.0 - cos, 0.0) + beyond * along;
    [middle, Vec3::new(-sin, cos, 0.0), Vec3::z()]
}

fn channel() -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    let length = 2.0 * STRAIGHT + FRAC_PI_2 * BEND;
    let edge = 2.0 * PI * RADIUS / POINTS_AROUND as f64;
    let rows = (length / edge).round() as usize;
    // Rings: those of the first end from its centre outwards, the wall, and those of the other end.
    let inner = (RADIUS / edge).round() as usize;
    let wall = (0..=rows).map(|k| (length * k as f64 / rows as f64 - STRAIGHT, RADIUS));
    let end = |k: usize| RADIUS * k as f64 / inner as f64;
    let rings = ((1..inner).map(|k| (-STRAIGHT, end(k))).chain(wall))
        .chain((1..inner).rev().map(|k| (length - STRAIGHT, end(k))));
    mesh.points.push(section(-STRAIGHT)[0]);
    let mut count = 0;
    for (s, radius) in rings {
        let [middle, u, v] = section(s);
        for k in 0..POINTS_AROUND {
            let (sin, cos) = (2.0 * PI * k as f64 / POINTS_AROUND as f64).sin_cos();
            mesh.points.push(middle + radius * (cos * u + sin * v));
        }
        count += 1;
    }
    mesh.points.push(section(length - STRAIGHT)[0]);
    let last = mesh.points.len() as u32 - 1;
    let at = |ring: usize, k: usize| (1 + ring * POINTS_AROUND + k % POINTS_AROUND) as u32;
    for k in 0..POINTS_AROUND {
        mesh.triangles.push([0, at(0, k + 1), at(0, k)]);
        mesh.triangles
            .push([last, at(count - 1, k), at(count - 1, k + 1)]);
        for ring in 0..count - 1 {
            let (a, b) = (at(ring, k), at(ring, k + 1));
            let (c, d) = (at(ring + 1, k), at(ring + 1, k + 1));
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    mesh
}

pub(crate) fn main() -> Result<(), GenerateError> {
    let mesh = channel();
    if let Some(path) = std::env::args().nth(1).filter(|arg| arg.ends_with(".stl")) {
        std::fs::write(&path, mesh.to_stl()).map_err(|source| MeshError::Io {
            path: path.into(),
            source,
        })?;
    }
    let surface = TriangulatedSurface::new("channel", mesh, TriangleKind::Smooth)?;
    // Pappus' theorem.
    let volume = PI * RADIUS.powi(2) * (2.0 * STRAIGHT + FRAC_PI_2 * BEND);
    let error = surface.volume() / volume - 1.0;
    println!("triangles            {}", surface.n_triangles());
    println!("volume               {:.2}", surface.volume());
    println!("error of the volume  {:.1e} %", 100.0 * error);
    println!("widest ball inside   {:.3}", surface.inradius());
    assert!(error.abs() < 1e-3);
    assert!((surface.inradius() / RADIUS - 1.0).abs() < 1e-2);
    Ok(())
}
