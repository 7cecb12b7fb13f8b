//! The mesh motions on meshes of files with three spheres on the x axis.

use std::path::{Path, PathBuf};
use std::time::Instant;

use ale::{AleError, MovingBody, ReferenceMap};
use anyhow::{Context, Result, bail, ensure};
use mesh::{MshFile, NamedSurface, Surface, TetMesh, Vec3};
use mesher::Sphere;
use nalgebra::{DMatrix, DVector, Isometry3};

use super::methods::{METHODS, Method};
use crate::page::Page;
use crate::table::{Cell, Table, count, fixed};

/// Largest radius of a body relative to the extent of the mesh; larger spheres are containers.
const MAX_BODY_RADIUS: f64 = 0.1;

/// Smallest Jacobian of a cell, relative to its mean, that the program accepts in a moved mesh.
const MIN_JACOBIAN: f64 = 0.2;

/// Smallest mean ratio of a cell that the program accepts in a moved mesh.
const MIN_QUALITY: f64 = 0.1;

/// Largest length of a cell in a gap, relative to its width, that the program accepts.
const MAX_GAP_RATIO: f64 = 1.5;

/// Relative deterioration that the program accepts in meshes that exceed these limits themselves.
const ALWAYS_ALLOWED: f64 = 0.9;

/// Distance that a swimmer with the default stroke covers in twenty cycles.
const TWENTY_CYCLES: f64 = 3.2;

/// Gaps that arms close to, in radii.
const GAPS: [f64; 14] = [
    4.0, 3.0, 2.5, 2.0, 1.75, 1.5, 1.25, 1.0, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3,
];

/// Runs the study on the Gmsh files of a folder and writes `ale-files.md`.
pub fn run(folder: &Path, out: &Path) -> Result<()> {
    let mut page = Page::new(
        "Mesh motions on the meshes of files",
        "ale --files FOLDER",
        "On meshes of Gmsh \
         (`scenes/three-sphere.geo`; size, growth and largest size: *coarse* about 0.65, 0.3, 8; *fast* 0.4, 0.6, 12; *middle* 0.4, 0.25, 6; *fine* 0.25, 0.2, 5; \
         *near* 0.3, 0.3, 8 with arms of 4; *close* 0.25, 0.3, 8 with arms of 3; some with -optimize_netgen).\n\n\
         Three spheres of radius 1 on a line, cells curved at the spheres, extensions computed once on the mesh of the file. \
         *Cycle*: the arms close by four tenths one after the other and open again (from 10 to 6: the default stroke); the smallest quality \
         and Jacobian and the largest gap ratio. *Accepted*: the program uses all meshes of this cycle / of the same cycle after the swimmer has moved by \
         3.2 radii, the distance of twenty default strokes. The last columns say how far the program follows until a cell is too poor or too long for its gap: \
         smallest gap when both arms close / the left one only; distance by which both open / the left sphere moves sideways (at most 6).",
    );
    let mut returns = true;
    for path in files(folder)? {
        let file = match FileMesh::read(&path) {
            Ok(file) => file,
            Err(error) => {
                eprintln!("{}: skipped, {error:#}", path.display());
                continue;
            }
        };
        let mut table = Table::new([
            "motion",
            "cycle: quality / Jacobian / gap ratio",
            "accepted",
            "gap, both / left",
            "opens / sideways",
            "iterations",
            "seconds",
        ]);
        for method in &METHODS {
            eprintln!("{}: {}", file.name, method.name);
            if let Some((cells, returned)) = reach(&file, method)? {
                table.push(cells);
                returns &= returned;
            }
        }
        let ([left, right], vertices) = (file.arms(), file.mesh.n_vertices());
        page.heading(format!(
            "{}: arms {left:.0} and {right:.0}, {vertices} vertices",
            file.name
        ));
        page.table(table);
    }
    let returns = if returns { "always" } else { "NOT always" };
    page.text(format!(
        "After all motions the mesh of the initial configuration is that of the file, bit for bit: {returns}."
    ));
    page.write(out, "ale-files")
}

/// The Gmsh files in a folder, in the order of their names.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder)
        .with_context(|| format!("could not read the folder {}", folder.display()))?;
    let paths = entries.map(|entry| Ok(entry?.path()));
    let mut paths = paths.collect::<Result<Vec<_>>>()?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "msh"));
    paths.sort();
    Ok(paths)
}

/// A mesh with three equal spheres.
struct FileMesh {
    name: String,
    mesh: TetMesh,
    /// The spheres from left to right, with the names of their boundary parts.
    spheres: [(String, Sphere); 3],
}

/// Positions of the spheres.
#[derive(Clone, Copy, Debug)]
struct Placement {
    /// Lengths of the arms.
    arms: [f64; 2],
    /// Displacement of all spheres along the line.
    shift: f64,
    /// Displacement of the left sphere across the line.
    sideways: f64,
}

impl FileMesh {
    /// Reads a mesh, with curved cells at the spheres.
    fn read(path: &Path) -> Result<Self> {
        let file = MshFile::read(path)?;
        let flat = file.clone().into_mesh(&[])?;
        let [low, high] = flat.bounding_box();
        let mut spheres = Vec::new();
        for (number, tag) in flat.tags().iter().enumerate() {
            let sphere = fitted(&flat, number as u16);
            let is_body = |sphere: &Sphere| sphere.radius < MAX_BODY_RADIUS * (high - low).amax();
            spheres.extend(sphere.filter(is_body).map(|sphere| (tag.clone(), sphere)));
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
    fn bodies(&self) -> Vec<MovingBody> {
        let body = |(tag, sphere): &(String, Sphere)| MovingBody {
            tag: tag.clone(),
            centre: sphere.centre,
            rotates: false,
        };
        self.spheres.iter().map(body).collect()
    }

    /// Lengths of the arms in the mesh.
    fn arms(&self) -> [f64; 2] {
        let [left, centre, right] = [0, 1, 2].map(|k| self.spheres[k].1.centre.x);
        [centre - left, right - centre]
    }

    /// The spheres where the mesh has them.
    fn at_rest(&self) -> Placement {
        Placement {
            arms: self.arms(),
            shift: 0.0,
            sideways: 0.0,
        }
    }

    /// Motions of the spheres to a placement.
    fn motions(&self, placement: Placement) -> [Isometry3<f64>; 3] {
        let [left, right] = self.arms();
        let own = [
            Vec3::new(left - placement.arms[0], placement.sideways, 0.0),
            Vec3::zeros(),
            Vec3::new(placement.arms[1] - right, 0.0, 0.0),
        ];
        let shift = placement.shift * Vec3::x();
        own.map(|own| Isometry3::from_parts((shift + own).into(), Default::default()))
    }

    fn shape(&self, moved: &TetMesh, placement: Placement) -> Shape {
        let spheres: Vec<Sphere> = (self.spheres.iter().zip(self.motions(placement)))
            .map(|((_, sphere), motion)| Sphere {
                centre: sphere.centre + motion.translation.vector,
                radius: sphere.radius,
            })
            .collect();
        let surfaces: Vec<&dyn Surface> = spheres.iter().map(|s| s as &dyn Surface).collect();
        let quality = moved.quality();
        Shape {
            quality: quality.min_quality,
            jacobian: quality.min_jacobian,
            gap_ratio: moved.gap_ratio(&surfaces, None),
        }
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
    let lie_on_it = points.iter().all(|x| deviation(x) < 1e-6);
    lie_on_it.then_some(Sphere { centre, radius })
}

/// A moved mesh: smallest mean ratio and Jacobian of a cell, and largest length of cells in gaps
/// relative to their width.
#[derive(Clone, Copy, Debug)]
struct Shape {
    quality: f64,
    jacobian: f64,
    gap_ratio: f64,
}

/// A motion on a mesh, and the mesh before it.
struct Moving<'a> {
    file: &'a FileMesh,
    map: ReferenceMap,
    start: Shape,
}

impl Moving<'_> {
    /// The mesh of a placement; `None` if a cell is inverted.
    fn shape(&self, placement: Placement) -> Result<Option<Shape>> {
        match self.map.moved(&self.file.motions(placement)) {
            Ok(moved) => Ok(Some(self.file.shape(&moved, placement))),
            Err(AleError::Invalid(_)) => Ok(None),
            Err(other) => Err(other.into()),
        }
    }

    fn is_accepted(&self, shape: Shape) -> bool {
        shape.jacobian >= MIN_JACOBIAN.min(ALWAYS_ALLOWED * self.start.jacobian)
            && shape.quality >= MIN_QUALITY.min(ALWAYS_ALLOWED * self.start.quality)
            && shape.gap_ratio <= MAX_GAP_RATIO.max(self.start.gap_ratio / ALWAYS_ALLOWED)
    }

    /// The worst values over a cycle in which the arms close by four tenths one after the other;
    /// `None` if a cell is inverted.
    fn cycle(&self, shift: f64) -> Result<Option<Shape>> {
        let [left, right] = self.file.arms();
        let corners = [[1.0, 1.0], [0.6, 1.0], [0.6, 0.6], [1.0, 0.6]];
        let mut worst = self.start;
        for phase in 0..4 {
            let (from, to) = (corners[phase], corners[(phase + 1) % 4]);
            for s in [0.5, 1.0] {
                let factor = [0, 1].map(|k| from[k] + s * (to[k] - from[k]));
                let placement = Placement {
                    arms: [factor[0] * left, factor[1] * right],
                    shift,
                    sideways: 0.0,
                };
                let Some(shape) = self.shape(placement)? else {
                    return Ok(None);
                };
                worst = Shape {
                    quality: worst.quality.min(shape.quality),
                    jacobian: worst.jacobian.min(shape.jacobian),
                    gap_ratio: worst.gap_ratio.max(shape.gap_ratio),
                };
            }
        }
        Ok(Some(worst))
    }

    /// The last value on a path for which, and for all before, the program accepts the mesh.
    fn last_accepted(
        &self,
        path: impl IntoIterator<Item = f64>,
        placement: impl Fn(f64) -> Placement,
    ) -> Result<Option<f64>> {
        let mut last = None;
        for value in path {
            match self.shape(placement(value))? {
                Some(shape) if self.is_accepted(shape) => last = Some(value),
                _ => break,
            }
        }
        Ok(last)
    }
}

/// Measures how far a motion takes a mesh: the cells of the table, and whether the mesh returns to
/// that of the file, bit for bit; `None` if the motion does not support the mesh.
fn reach(file: &FileMesh, method: &Method) -> Result<Option<([Cell; 7], bool)>> {
    let clock = Instant::now();
    let motion = (method.make)();
    let map = match ReferenceMap::new(file.mesh.clone(), &file.bodies(), motion.as_ref()) {
        Ok(map) => map,
        Err(AleError::TooManyCentres { .. }) => return Ok(None),
        Err(other) => return Err(other.into()),
    };
    let setup = clock.elapsed().as_secs_f64();
    let still = file.at_rest();
    let start = file.shape(&file.mesh, still);
    let moving = Moving { file, map, start };
    let cycles = [moving.cycle(0.0)?, moving.cycle(TWENTY_CYCLES)?];
    let Ok(returned) = moving.map.moved(&file.motions(still)) else {
        bail!("{}: the mesh itself is not valid", file.name);
    };
    let arms = file.arms();
    let closed = |gap: f64| 2.0 * file.spheres[0].1.radius + gap;
    let gaps = GAPS.into_iter();
    let gaps = gaps.filter(|&gap| closed(gap) < arms[0].min(arms[1]));
    let with_arms = |arms: [f64; 2]| Placement { arms, ..still };
    let both = moving.last_accepted(gaps.clone(), |gap| with_arms([closed(gap); 2]))?;
    let left = moving.last_accepted(gaps, |gap| with_arms([closed(gap), arms[1]]))?;
    // Larger moves leave the container.
    let steps = || (1..=12).map(|k| 0.5 * f64::from(k));
    let opens = moving.last_accepted(steps(), |x| with_arms(arms.map(|arm| arm + x)))?;
    let sideways = moving.last_accepted(steps(), |y| Placement {
        sideways: y,
        ..still
    })?;
    let [is_accepted, is_accepted_later] = cycles.map(|shape| match shape {
        Some(shape) if moving.is_accepted(shape) => "yes",
        _ => "no",
    });
    let gap = |gap: Option<f64>| gap.map_or("-".to_owned(), |gap| format!("{gap:.2}"));
    let [opens, sideways] = [opens, sideways].map(|distance| distance.unwrap_or(0.0));
    let cycle = cycles[0].map_or("inverted".to_owned(), |s| {
        format!("{:.3} / {:.2} / {:.2}", s.quality, s.jacobian, s.gap_ratio)
    });
    let cells = [
        method.name.into(),
        cycle.into(),
        format!("{is_accepted} / {is_accepted_later}").into(),
        format!("{} / {}", gap(both), gap(left)).into(),
        format!("{opens:.1} / {sideways:.1}").into(),
        count(moving.map.iterations()),
        fixed(setup, 2),
    ];
    Ok(Some((cells, returned.points() == file.mesh.points())))
}
