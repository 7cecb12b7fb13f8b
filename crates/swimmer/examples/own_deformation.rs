//! A body whose deformation a program gives: a sphere with a bump that travels around it.
//!
//! `cargo run --release --example own_deformation`

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use swimmer::scene::nalgebra::Vector3;
use swimmer::scene::{MaterialMotion, MaterialPoint, ShapeCoordinate};
use swimmer::{Method, Outcome, Scene, SwimError, choose, simulate};

/// Points in the direction `n` move along the radius by `ε (1 + n · e(φ))² / 4` with the unit
/// vector `e(φ)` at the angle `φ` from x to y.
#[derive(Debug)]
struct Bump {
    height: f64,
}

impl Bump {
    /// Radial displacement of a point, and its derivative with respect to the angle.
    fn displacement(&self, x: &Vector3<f64>, angle: f64) -> [f64; 2] {
        let n = x.normalize();
        let (sine, cosine) = angle.sin_cos();
        let along = 1.0 + n.x * cosine + n.y * sine;
        let rate = n.y * cosine - n.x * sine;
        [
            0.25 * self.height * along * along,
            0.5 * self.height * along * rate,
        ]
    }
}

impl MaterialMotion for Bump {
    fn coordinates(&self) -> Vec<ShapeCoordinate> {
        vec![ShapeCoordinate {
            name: "angle".to_owned(),
            start: 0.0,
            period: Some(TAU),
        }]
    }

    fn position(&self, point: &MaterialPoint, amplitudes: &[f64]) -> Vector3<f64> {
        let x = point.position;
        x + self.displacement(&x, amplitudes[0])[0] * x.normalize()
    }

    fn velocity(&self, point: &MaterialPoint, amplitudes: &[f64], _: usize) -> Vector3<f64> {
        let x = point.position;
        self.displacement(&x, amplitudes[0])[1] * x.normalize()
    }

    fn largest_speed(&self, _: usize) -> f64 {
        self.height
    }
}

/// The motion of the body in one turn of its bump.
///
/// # Errors
/// A surface that cannot be read; those of a run.
pub fn turn(surface: &Path, height: f64) -> Result<Outcome, SwimError> {
    let text = format!(
        "bodies = [{{ name = \"cell\", shape = \"surface\", file = {:?}, position = [0, 0, 0] }}]",
        surface.display().to_string()
    );
    let shape = Scene::parse(&text)?.bodies()[0].shape.clone();
    let scene = Scene::builder()
        .shaped("cell", shape, [0.0; 3])
        .deformation("cell", Arc::new(Bump { height }))
        .phase("cell.angle", TAU, 1.0)
        .tolerance(0.2)
        .build()?;
    let mut model = choose(&scene)?.model;
    simulate(&scene, model.as_mut(), Method::from_scene(&scene), &mut ())
}

/// Writes a unit sphere: the faces of the octahedron with four triangles per edge.
///
/// # Errors
/// A file that cannot be written.
fn write_sphere(file: &Path) -> std::io::Result<()> {
    const N: i32 = 4;
    let (mut points, mut text, mut faces) = (Vec::new(), String::new(), String::new());
    for octant in 0..8 {
        let signs = [0, 1, 2].map(|axis| 1 - 2 * (octant >> axis & 1));
        let mut add = |corners: [[i32; 2]; 3]| {
            let mut face = corners.map(|[a, b]| {
                let at = [signs[0] * a, signs[1] * b, signs[2] * (N - a - b)];
                let known = points.iter().position(|known| *known == at);
                1 + known.unwrap_or_else(|| {
                    let x = Vector3::from(at.map(f64::from)).normalize();
                    // Texts can always be written to.
                    let _ = writeln!(text, "v {:?} {:?} {:?}", x.x, x.y, x.z);
                    points.push(at);
                    points.len() - 1
                })
            });
            if signs.iter().product::<i32>() < 0 {
                face.swap(1, 2);
            }
            let _ = writeln!(faces, "f {} {} {}", face[0], face[1], face[2]);
        };
        for i in 0..N {
            for j in 0..N - i {
                add([[i, j], [i + 1, j], [i, j + 1]]);
                if i + j + 2 <= N {
                    add([[i + 1, j], [i + 1, j + 1], [i, j + 1]]);
                }
            }
        }
    }
    std::fs::write(file, text + &faces)
}

/// Prints the rotation of the body, which turns against its bump.
///
/// # Errors
/// As [`turn`].
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::temp_dir().join(format!("sphere-{}.obj", std::process::id()));
    write_sphere(&file)?;
    let outcome = turn(&file, 0.3);
    std::fs::remove_file(&file)?;
    let outcome = outcome?;
    let (angle, bar) = (outcome.rotation.z, outcome.rotation_error.total());
    println!("rotation about z {angle:.4} +- {bar:.4}");
    // About other axes the mirror image in the plane of the bump rotates the other way.
    assert!(angle.abs() > 2.0 * bar && outcome.rotation.xy().norm() < bar);
    Ok(())
}
