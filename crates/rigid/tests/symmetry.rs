//! A part of the fluid between mirror planes gives the same answer as the whole that it stands for.

use fem::TaylorHood;
use linalg::{BlockDiagonal, KrylovParams, SaddleLdlt, fgmres, minres};
use mesh::{LinearTets, SYMMETRY_PLANE_TAGS, TetMesh};
use nalgebra::Vector3;
use rigid::{
    Arms, Articulation, BodyKind, Constrained, Constraints, DirectRows, Drive, Eliminated,
    ExternalLoad, FlowSolution, FluidMatrices, Formulation, Independent, Lagrange, Link, NodeRole,
    RigidError, RigidFluid, SurfaceBody,
};

/// Cells along each side of the part.
const CELLS: u32 = 6;

/// Relative residual of all solves.
const TOLERANCE: f64 = 1e-10;

/// Two bodies on the x axis, one of two and one of four cells a side, cut out of a box; planes normal to `axes` cut them in halves.
fn part(axes: &[usize]) -> TetMesh {
    let mut tets = LinearTets::cube(CELLS);
    let index = |p: &Vector3<f64>| p.map(|x| (x * f64::from(CELLS)).round() as i32);
    // where no plane is normal to y or z, the bodies are in the middle
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
    // vertices inside bodies are used no more
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

struct Case {
    mesh: TetMesh,
    set: Articulation,
    loads: Vec<ExternalLoad>,
    links: bool,
}

impl Case {
    /// Linked bodies, or bodies that are pulled each for itself.
    fn new(
        mesh: TetMesh,
        middles: [Vector3<f64>; 2],
        links: bool,
        loads: Vec<ExternalLoad>,
    ) -> Self {
        let link = Link {
            name: "arm".into(),
            body: 1,
            to: 0,
        };
        let links_of = if links { vec![link] } else { vec![] };
        let set = Articulation::new(&[BodyKind::Rigid; 2], links_of, Arms::Clamped, &middles)
            .expect("two bodies");
        Self {
            mesh,
            set,
            loads,
            links,
        }
    }

    fn constrain(&self, formulation: &dyn Formulation) -> Result<Constrained, RigidError> {
        formulation.constrain(self.fluid()?, &self.drive(&self.constraints(1.0)?))
    }

    fn drive<'a>(&'a self, constraints: &'a Constraints) -> Drive<'a> {
        Drive {
            set: &self.set,
            constraints,
            loads: &self.loads,
        }
    }

    /// The constraints of the link, if there is one, whose length changes at a rate.
    fn constraints(&self, rate: f64) -> Result<Constraints, RigidError> {
        let (state, lengths) = (self.set.initial_state(), self.set.initial_lengths());
        let rates: &[f64] = if self.links { &[rate] } else { &[] };
        self.set.constraints(&state, lengths, rates)
    }

    fn fluid(&self) -> Result<RigidFluid, RigidError> {
        let mesh = &self.mesh;
        let mut roles = vec![NodeRole::Free; mesh.n_points()];
        let mut put = |tag: &str, role| {
            let nodes = mesh.nodes_on(mesh.tag(tag).expect("a tag"));
            nodes.iter().for_each(|&n| roles[n as usize] = role);
        };
        put("wall", NodeRole::Fixed);
        put("left", NodeRole::Body(0));
        put("right", NodeRole::Body(1));
        let centres = self
            .set
            .place(&self.set.initial_state(), self.set.initial_lengths())?;
        let bodies = ["left", "right"].map(|tag| {
            let tag_number = mesh.tag(tag).expect("a tag");
            let centre = centres[usize::from(tag == "right")].translation.vector;
            let volume = fem::surface_measures(mesh, tag_number)
                .expect("closed")
                .volume;
            SurfaceBody { centre, volume }
        });
        let space = TaylorHood::new(mesh).expect("a mesh");
        RigidFluid::new(
            FluidMatrices {
                stiffness: space.stiffness(mesh).expect("cells"),
                divergence: space.divergence(mesh).expect("cells"),
                pressure_mass: space.pressure_mass(mesh).expect("cells"),
                interpolation: space.vertex_interpolation(mesh).expect("cells"),
                vertex_stiffness: space.vertex_stiffness(mesh).expect("cells"),
                points: mesh.points(),
                roles: &roles,
                on_symmetry_planes: mesh.nodes_on_symmetry_planes(),
            },
            &bodies,
        )
    }

    /// The flow and the iterations to it.
    fn solve(&self, formulation: &dyn Formulation) -> (FlowSolution, usize) {
        let system = self.constrain(formulation).expect("a system");
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

fn close(what: &str, a: impl Iterator<Item = f64>, b: impl Iterator<Item = f64>) {
    let (a, b): (Vec<f64>, Vec<f64>) = (a.collect(), b.collect());
    let size = b.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    // residuals are relative to the right-hand side; errors of fluxes, forces and pressures are larger by the conditions of small parts
    let tolerance = 1e4 * TOLERANCE * size;
    assert_eq!(a.len(), b.len());
    for (k, (a, b)) in a.iter().zip(&b).enumerate() {
        assert!((a - b).abs() <= tolerance, "{what}, entry {k}: {a} for {b}");
    }
}

fn same(part: &Case, whole: &Case, sources: &[(u32, Vector3<f64>)], formulation: &dyn Formulation) {
    let (own, own_iterations) = part.solve(formulation);
    let (all, all_iterations) = whole.solve(formulation);
    let name = formulation.name();
    println!("{name}: {own_iterations} iterations for {all_iterations}");
    close(name, own.bodies.iter().copied(), all.bodies.iter().copied());
    close(name, own.forces.iter().copied(), all.forces.iter().copied());
    if part.links {
        close(
            name,
            own.link_force(0).iter().copied(),
            all.link_force(0).iter().copied(),
        );
    }
    let images = sources
        .iter()
        .map(|(node, signs)| own.velocity[*node as usize].component_mul(signs));
    close(
        name,
        images.flat_map(|u| [u.x, u.y, u.z]),
        all.velocity.iter().flat_map(|u| [u.x, u.y, u.z]),
    );
    let pressures = sources.iter().take(all.pressure.len());
    close(
        name,
        pressures.map(|(node, _)| own.pressure[*node as usize]),
        all.pressure.iter().copied(),
    );
    // a hierarchy that respects the planes is worth about as much as that of the whole
    assert!(
        own_iterations <= all_iterations + 5,
        "{own_iterations} for {all_iterations}"
    );
}

/// Bodies beside planes: middles of their cells along x, on planes across.
fn middles(axes: &[usize]) -> [Vector3<f64>; 2] {
    let across = |axis: usize| if axes.contains(&axis) { 0.0 } else { 0.5 };
    [1.5, 4.5].map(|x| Vector3::new(x / f64::from(CELLS), across(1), across(2)))
}

#[test]
fn a_swimmer_on_a_half_or_a_quarter_swims_as_on_the_whole() {
    for axes in [&[2][..], &[1, 2]] {
        let mesh = part(axes);
        let whole = mesh.unfolded().expect("planes at zero");
        let still = vec![ExternalLoad::default(); 2];
        let [part, all] =
            [mesh, whole.mesh].map(|mesh| Case::new(mesh, middles(axes), true, still.clone()));
        let formulations: [&dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];
        for formulation in formulations {
            same(&part, &all, &whole.sources, formulation);
        }
    }
}

#[test]
fn other_rates_on_a_quarter_are_another_right_hand_side() {
    let axes = [1, 2];
    let case = Case::new(
        part(&axes),
        middles(&axes),
        true,
        vec![ExternalLoad::default(); 2],
    );
    let other = case.constraints(-0.3).expect("a rate");
    let formulations: [&dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];
    for formulation in formulations {
        let system = case.constrain(formulation).expect("a system");
        let imposed = system.imposed(&case.drive(&other)).expect("the same link");
        let fluid = case.fluid().expect("matrices");
        let anew = formulation.constrain(fluid, &case.drive(&other));
        assert_eq!(imposed.rhs, anew.expect("a system").rhs);
    }
}

#[test]
fn pulled_and_turned_bodies_move_as_in_the_whole() {
    let mesh = part(&[2]);
    let whole = mesh.unfolded().expect("planes at zero");
    // in the plane, about its normal
    let loads = vec![
        ExternalLoad {
            force: Vector3::new(1.0, -0.5, 0.0),
            torque: Vector3::new(0.0, 0.0, 0.3),
        },
        ExternalLoad {
            force: Vector3::new(0.0, 2.0, 0.0),
            torque: Vector3::zeros(),
        },
    ];
    let [part, all] =
        [mesh, whole.mesh].map(|mesh| Case::new(mesh, middles(&[2]), false, loads.clone()));
    same(&part, &all, &whole.sources, &Independent);
    same(&part, &all, &whole.sources, &Eliminated);
}

#[test]
fn minres_agrees_and_the_direct_solver_refuses() {
    let axes = [1, 2];
    let case = Case::new(
        part(&axes),
        middles(&axes),
        true,
        vec![ExternalLoad::default(); 2],
    );
    let (flow, _) = case.solve(&Eliminated);
    let system = case.constrain(&Eliminated).expect("a system");
    let mut preconditioner =
        BlockDiagonal::with_prolongation(&system.system, &system.prolongation).expect("definite");
    let mut x = vec![0.0; system.rhs.len()];
    let params = KrylovParams::default().with_rel_tol(1e-8);
    minres(
        &system.system,
        &mut preconditioner,
        &system.rhs,
        &mut x,
        &params,
    )
    .expect("a solution");
    let other = system.flow(&x, &case.set).expect("a flow");
    let difference = (&other.bodies - &flow.bodies).amax();
    assert!(difference <= 1e-5 * flow.bodies.amax());
    let refused = SaddleLdlt::factor(&system.system, &Default::default()).err();
    assert!(matches!(
        refused,
        Some(linalg::LinalgError::ConstrainedDofs { .. })
    ));
}

#[test]
fn what_is_not_symmetric_is_refused() {
    let across = ExternalLoad {
        force: Vector3::new(0.0, 0.0, 1.0),
        torque: Vector3::zeros(),
    };
    let case = Case::new(
        part(&[2]),
        middles(&[2]),
        false,
        vec![ExternalLoad::default(), across],
    );
    let refused = case.constrain(&Independent).err();
    assert_eq!(refused, Some(RigidError::AsymmetricLoad { body: 1 }));
    let off = middles(&[2]).map(|x| x + Vector3::new(0.0, 0.0, 0.1));
    let case = Case::new(part(&[2]), off, false, vec![ExternalLoad::default(); 2]);
    assert!(matches!(
        case.constrain(&Independent).err(),
        Some(RigidError::OffSymmetryPlane { body: 0, .. })
    ));
}
