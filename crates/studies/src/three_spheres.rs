//! Meshes of three unit spheres on a line in a ball, without a scene.

use anyhow::Result;
use mesh::{LinearTets, NamedSurface, TetMesh, Vec3};
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};

/// Names of the spheres, which are the tags of their surfaces.
pub const NAMES: [&str; 3] = ["left", "centre", "right"];

/// Three unit spheres on the x axis, the middle one at the centre of a ball.
pub struct ThreeSpheres {
    pub spheres: [Sphere; 3],
    container: Container,
}

impl ThreeSpheres {
    /// Spheres with these lengths of the arms in a ball of this radius.
    pub fn new([left, right]: [f64; 2], radius: f64) -> Self {
        let centre = Vec3::zeros();
        Self {
            spheres: [-left, 0.0, right].map(|x| Sphere {
                centre: Vec3::new(x, 0.0, 0.0),
                radius: 1.0,
            }),
            container: Container::Ball(Sphere { centre, radius }),
        }
    }

    /// Straight tets with edges of `size` on the spheres, which grow with the distance.
    pub fn tets(&self, size: f64, growth: f64) -> Result<LinearTets> {
        let bodies = [0, 1, 2].map(|k| MeshedBody {
            name: NAMES[k],
            surface: &self.spheres[k],
            size,
        });
        let mut params = GenerateParams::default();
        params.growth = growth;
        Ok(generate(&bodies, &self.container, &params)?.mesh)
    }

    /// The mesh of these tets, curved at all surfaces.
    pub fn curved(&self, tets: LinearTets) -> Result<TetMesh> {
        let spheres = NAMES.iter().zip(&self.spheres);
        let spheres = spheres.map(|(&name, sphere)| (name, sphere as &dyn mesh::Surface));
        let wall = (Container::TAG, self.container.surface());
        let surfaces: Vec<NamedSurface> = spheres.chain([wall]).collect();
        Ok(TetMesh::curved(tets, &surfaces)?)
    }
}
