//! Two bodies in a box, or in the part of it on one side of symmetry planes.

use fem::{StokesMatrices, TaylorHood};
use linalg::{KrylovParams, fgmres};
use mesh::{LinearTets, SYMMETRY_PLANE_TAGS, TetMesh};
use nalgebra::Vector3;
use rigid::{
    Arms, Articulation, BodyKind, Constrained, Constraints, Drive, ExternalLoad, FlowSolution,
    FluidMatrices, FluidNodes, Formulation, Joint, NodeRole, RigidError, RigidFluid, SurfaceBody,
};

/// Cells along each side of the mesh.
const CELLS: u32 = 6;

/// Relative residual of all solves.
pub const TOLERANCE: f64 = 1e-10;

/// Two bodies on the x axis, cut in halves by symmetry planes normal to `axes`.
///
/// Their sides are two and four cells long, or the half of it on a symmetry plane. The mesh is that
/// of a cube without the cells of the bodies.
pub fn part(axes: &[usize]) -> TetMesh {
    let mut tets = LinearTets::cube(CELLS);
    let index = |p: &Vector3<f64>| p.map(|x| (x * f64::from(CELLS)).round() as i32);
    // Where no plane is normal to y or z, the bodies are in the middle.
    let middle = |axis: usize| {
        if axes.contains(&axis) {
            0
        } else {
            CELLS as i32 / 2
        }
    };
    let inside = |p: Vector3<i32>, [low, high]: [i32; 2], half: i32| {
        (low..=high).contains(&p.x) && (1..3).all(|axis| (p[axis] - middle(axis)).abs() <= half)
    };
    let bodies = [([1, 2], 1), ([4, 5], 1)];
    let body_of = |vertices: &[u32]| {
        bodies.iter().position(|&(x, half)| {
            vertices
                .iter()
                .all(|&v| inside(index(&tets.points[v as usize]), x, half))
        })
    };
    tets.tags = ["left", "right", "wall"].map(String::from).into();
    let (removed, kept): (Vec<[u32; 4]>, Vec<[u32; 4]>) = tets
        .tets
        .iter()
        .partition(|tet| body_of(&tet[..]).is_some());
    let faces_of = |tets: &[[u32; 4]]| -> Vec<[u32; 3]> {
        let faces = |&[a, b, c, d]: &[u32; 4]| [[b, c, d], [a, d, c], [a, b, d], [a, c, b]];
        tets.iter().flat_map(faces).collect()
    };
    let sorted = |mut face: [u32; 3]| {
        face.sort_unstable();
        face
    };
    let of_fluid: std::collections::HashSet<[u32; 3]> =
        faces_of(&kept).into_iter().map(sorted).collect();
    let mut faces: Vec<([u32; 3], u16)> = Vec::new();
    for &(face, tag) in &tets.faces {
        if of_fluid.contains(&sorted(face)) {
            let axis = usize::from(tag / 2);
            let is_plane = tag.is_multiple_of(2) && axes.contains(&axis);
            let name = if is_plane {
                SYMMETRY_PLANE_TAGS[axis]
            } else {
                "wall"
            };
            let known = tets.tags.iter().position(|tag| tag == name);
            let tag = known.unwrap_or_else(|| {
                tets.tags.push(name.into());
                tets.tags.len() - 1
            });
            faces.push((face, tag as u16));
        }
    }
    for face in faces_of(&removed) {
        if of_fluid.contains(&sorted(face)) {
            let [a, b, c] = face;
            let body = body_of(&face).expect("a face of a body");
            faces.push(([a, c, b], body as u16));
        }
    }
    // Vertices inside bodies are not used any more.
    let mut number = vec![u32::MAX; tets.points.len()];
    let mut points = Vec::new();
    for &v in kept.iter().flatten() {
        if number[v as usize] == u32::MAX {
            number[v as usize] = points.len() as u32;
            points.push(tets.points[v as usize]);
        }
    }
    let number = |v: u32| number[v as usize];
    TetMesh::straight(LinearTets {
        points,
        tets: kept.iter().map(|tet| tet.map(number)).collect(),
        faces: faces
            .iter()
            .map(|(face, tag)| (face.map(number), *tag))
            .collect(),
        tags: tets.tags,
        ..LinearTets::default()
    })
    .expect("a mesh")
}

/// Centres of the bodies of [`part`]: on all symmetry planes.
pub fn centres(axes: &[usize]) -> [Vector3<f64>; 2] {
    let across = |axis: usize| if axes.contains(&axis) { 0.0 } else { 0.5 };
    [1.5, 4.5].map(|x| Vector3::new(x / f64::from(CELLS), across(1), across(2)))
}

/// Two bodies in a fluid, with or without a joint.
pub struct Case {
    pub mesh: TetMesh,
    pub set: Articulation,
    pub loads: Vec<ExternalLoad>,
    /// Prescribed velocity of every node on the wall; none for a wall at rest.
    pub wall_velocity: Option<Vec<Vector3<f64>>>,
}

impl Case {
    /// Linked bodies without loads, in fluid at rest on the wall.
    pub fn linked(mesh: TetMesh, centres: [Vector3<f64>; 2]) -> Self {
        let joint = Joint::slide("arm", 1, 0);
        Self::new(mesh, vec![joint], centres, vec![ExternalLoad::default(); 2])
    }

    /// Bodies without joints under loads, in fluid at rest on the wall.
    pub fn loaded(mesh: TetMesh, centres: [Vector3<f64>; 2], loads: Vec<ExternalLoad>) -> Self {
        Self::new(mesh, Vec::new(), centres, loads)
    }

    fn new(
        mesh: TetMesh,
        joints: Vec<Joint>,
        centres: [Vector3<f64>; 2],
        loads: Vec<ExternalLoad>,
    ) -> Self {
        let set = Articulation::new(&[BodyKind::Rigid; 2], joints, Arms::Clamped, &centres)
            .expect("two bodies");
        Self {
            mesh,
            set,
            loads,
            wall_velocity: None,
        }
    }

    /// The system at a rate of the joint, if there is one.
    pub fn constrain(
        &self,
        formulation: &dyn Formulation,
        rate: f64,
    ) -> Result<Constrained, RigidError> {
        formulation.constrain(self.fluid()?, &self.drive(&self.constraints(rate)?))
    }

    pub fn drive<'a>(&'a self, constraints: &'a Constraints) -> Drive<'a> {
        Drive {
            set: &self.set,
            constraints,
            loads: &self.loads,
        }
    }

    /// The constraints at a rate of the joint, if there is one.
    pub fn constraints(&self, rate: f64) -> Result<Constraints, RigidError> {
        let (state, shape) = (self.set.initial_state(), self.set.initial_shape());
        self.set
            .constraints(&state, shape, &vec![rate; shape.len()])
    }

    pub fn fluid(&self) -> Result<RigidFluid, RigidError> {
        let mesh = &self.mesh;
        let mut roles = vec![NodeRole::Free; mesh.n_points()];
        let mut assign = |tag: &str, role| {
            let nodes = mesh.nodes_on(mesh.tag(tag).expect("a tag"));
            nodes.iter().for_each(|&n| roles[n as usize] = role);
        };
        assign("wall", NodeRole::Fixed);
        assign("left", NodeRole::Body(0));
        assign("right", NodeRole::Body(1));
        let centres = self
            .set
            .place(&self.set.initial_state(), self.set.initial_shape())?;
        let bodies = ["left", "right"].map(|tag| {
            let tag_number = mesh.tag(tag).expect("a tag");
            let centre = centres[usize::from(tag == "right")].translation.vector;
            let volume = fem::surface_measures(mesh, tag_number)
                .expect("closed")
                .volume;
            SurfaceBody { centre, volume }
        });
        let space = TaylorHood::new(mesh).expect("a mesh");
        let StokesMatrices {
            stiffness,
            divergence,
            pressure_mass,
            interpolation,
            vertex_stiffness,
        } = space.matrices(mesh).expect("cells");
        let matrices = FluidMatrices {
            stiffness,
            divergence,
            pressure_mass,
            interpolation,
            vertex_stiffness,
        };
        let mut nodes = FluidNodes::new(mesh.points(), &roles)
            .with_symmetry_planes(mesh.nodes_on_symmetry_planes());
        if let Some(velocity) = &self.wall_velocity {
            nodes = nodes.with_wall_velocity(velocity);
        }
        RigidFluid::new(matrices, nodes, &bodies)
    }

    /// The flow at a rate of the joint, its pressure with zero mean, and the number of iterations.
    pub fn solve(&self, formulation: &dyn Formulation, rate: f64) -> (FlowSolution, usize) {
        let system = self.constrain(formulation, rate).expect("a system");
        let mut preconditioner = system.preconditioner().expect("multigrid");
        let mut x = vec![0.0; system.rhs.len()];
        let params = KrylovParams::default().with_rel_tol(TOLERANCE);
        let report = fgmres(
            &system.system,
            &mut preconditioner,
            &system.rhs,
            &mut x,
            &params,
        )
        .expect("a solution");
        let mut flow = system.flow(&x, &self.set).expect("a flow");
        let mean = fem::mean_pressure(&self.mesh, &flow.pressure).expect("a mesh");
        flow.pressure.iter_mut().for_each(|p| *p -= mean);
        (flow, report.iterations)
    }
}
