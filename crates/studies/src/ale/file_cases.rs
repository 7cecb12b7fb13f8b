//! Meshes of files with three spheres on the x axis, and the paths that they must follow.

use std::path::{Path, PathBuf};

use ale::MovingBody;
use anyhow::{Context, Result, ensure};
use mesh::{MshFile, NamedSurface, Surface, TetMesh, Vec3};
use mesher::Sphere;
use nalgebra::{DMatrix, DVector, Isometry3};

/// Largest radius of a body relative to the extent of the mesh; larger spheres are containers.
const BODY: f64 = 0.1;

/// A mesh with three equal spheres.
pub struct FileMesh {
    pub name: String,
    pub mesh: TetMesh,
    /// The spheres from left to right, with the names of their boundary parts.
    pub spheres: [(String, Sphere); 3],
}

/// Positions of the spheres.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// Lengths of the arms.
    pub arms: [f64; 2],
    /// Displacement of the middle sphere.
    pub shift: Vec3,
    /// Displacement of the left sphere across the line.
    pub sideways: f64,
}

/// The Gmsh files in a folder, in the order of their names.
pub fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder)
        .with_context(|| format!("could not read the folder {}", folder.display()))?;
    let mut paths = entries
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<Vec<_>>>()?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "msh"));
    paths.sort();
    Ok(paths)
}

impl FileMesh {
    /// Reads a mesh, with curved cells at the spheres.
    pub fn read(path: &Path) -> Result<Self> {
        let file = MshFile::read(path)?;
        let flat = file.clone().into_mesh(&[])?;
        let [low, high] = flat.bounding_box();
        let mut spheres = Vec::new();
        for (number, tag) in flat.tags().iter().enumerate() {
            let sphere = fitted(&flat, number as u16);
            if sphere.is_some_and(|sphere| sphere.radius < BODY * (high - low).amax()) {
                spheres.extend(sphere.map(|sphere| (tag.clone(), sphere)));
            }
        }
        spheres.sort_by(|(_, a), (_, b)| a.centre.x.total_cmp(&b.centre.x));
        let found = spheres.len();
        let spheres: Option<[(String, Sphere); 3]> = spheres.try_into().ok();
        let spheres = spheres.with_context(|| format!("{found} spheres instead of three"))?;
        let radius = spheres[0].1.radius;
        let is_equal = |(_, s): &(String, Sphere)| (s.radius / radius - 1.0).abs() < 1e-6;
        ensure!(spheres.iter().all(is_equal), "spheres of different radii");
        let surfaces: Vec<NamedSurface> = (spheres.iter())
            .map(|(tag, sphere)| (tag.as_str(), sphere as &dyn Surface))
            .collect();
        let mesh = file.into_mesh(&surfaces)?;
        let name = path.file_stem().unwrap_or_default();
        Ok(Self {
            name: name.to_string_lossy().into_owned(),
            mesh,
            spheres,
        })
    }

    /// The bodies where the mesh has them.
    pub fn bodies(&self) -> Vec<MovingBody> {
        let body = |(tag, sphere): &(String, Sphere)| MovingBody {
            tag: tag.clone(),
            centre: sphere.centre,
            rotates: false,
        };
        self.spheres.iter().map(body).collect()
    }

    /// Lengths of the arms in the mesh.
    pub fn arms(&self) -> [f64; 2] {
        let [left, centre, right] = [0, 1, 2].map(|k| self.spheres[k].1.centre.x);
        [centre - left, right - centre]
    }

    /// Radius of the spheres.
    pub fn radius(&self) -> f64 {
        self.spheres[0].1.radius
    }

    /// The spheres where the mesh has them.
    pub fn at_rest(&self) -> Placement {
        Placement {
            arms: self.arms(),
            shift: Vec3::zeros(),
            sideways: 0.0,
        }
    }

    /// Motions of the spheres to a placement.
    pub fn motions(&self, placement: Placement) -> [Isometry3<f64>; 3] {
        let [left, right] = self.arms();
        let own = [
            Vec3::new(left - placement.arms[0], placement.sideways, 0.0),
            Vec3::zeros(),
            Vec3::new(placement.arms[1] - right, 0.0, 0.0),
        ];
        own.map(|own| Isometry3::from_parts((placement.shift + own).into(), Default::default()))
    }

    /// Largest length of cells in gaps between the spheres of a placement, relative to the width of
    /// the gap.
    pub fn gap_ratio(&self, moved: &TetMesh, placement: Placement) -> f64 {
        let spheres: Vec<Sphere> = (self.spheres.iter().zip(self.motions(placement)))
            .map(|((_, sphere), motion)| Sphere {
                centre: sphere.centre + motion.translation.vector,
                radius: sphere.radius,
            })
            .collect();
        let surfaces: Vec<&dyn Surface> = spheres.iter().map(|s| s as &dyn Surface).collect();
        moved.gap_ratio(&surfaces, None)
    }
}

/// The sphere through the vertices of a boundary part, if they lie on one.
fn fitted(mesh: &TetMesh, tag: u16) -> Option<Sphere> {
    let nodes = mesh.nodes_on(tag);
    let points: Vec<Vec3> = (nodes.iter().map(|&node| node as usize))
        .filter(|&node| node < mesh.n_vertices())
        .map(|node| mesh.points()[node])
        .collect();
    // |x|^2 = 2 c.x + (r^2 - |c|^2), by least squares for c and the bracket.
    let matrix = DMatrix::from_fn(points.len(), 4, |i, j| match j {
        3 => 1.0,
        _ => 2.0 * points[i][j],
    });
    let squares = DVector::from_fn(points.len(), |i, _| points[i].norm_squared());
    let fit = matrix.svd(true, true).solve(&squares, 1e-12).ok()?;
    let centre = Vec3::new(fit[0], fit[1], fit[2]);
    let radius = (fit[3] + centre.norm_squared()).sqrt();
    let deviation = |x: &Vec3| ((x - centre).norm() / radius - 1.0).abs();
    points
        .iter()
        .all(|x| deviation(x) < 1e-6)
        .then_some(Sphere { centre, radius })
}
