//! Estimates and measures of a part between mirror planes are those of the whole.

use fem::SurplusSpace;
use mesh::{LinearTets, SYMMETRY_PLANE_TAGS, TetMesh, Vec3};

/// An eighth or less of a box, cells pushed about but for the planes.
fn part(axes: &[usize]) -> TetMesh {
    let mut cube = LinearTets::cube(3);
    for &axis in axes {
        cube.tags[2 * axis] = SYMMETRY_PLANE_TAGS[axis].into();
    }
    for x in &mut cube.points {
        let inside = x.map(|c| if c > 0.0 && c < 1.0 { 0.05 } else { 0.0 });
        let push = Vec3::new((7.0 * x.y).sin(), (9.0 * x.z).cos(), (5.0 * x.x).sin());
        *x += inside.component_mul(&push);
    }
    TetMesh::straight(cube).expect("a mesh")
}

/// A flow that is its own image in all coordinate planes: components odd across their plane, all else even.
fn flow(x: Vec3) -> (Vec3, f64) {
    let even = |x: Vec3| (1.3 * x.x * x.x).cos() + (x.y * x.y * x.z * x.z).exp();
    let u = Vec3::new(
        x.x.sin() * even(x),
        (2.0 * x.y).sin() * even(x.yzx()),
        x.z.powi(3) * even(x.zxy()),
    );
    (u, even(x.yxz()))
}

fn sampled(mesh: &TetMesh) -> (Vec<f64>, Vec<f64>) {
    let velocity = mesh
        .points()
        .iter()
        .flat_map(|x| <[f64; 3]>::from(flow(*x).0));
    let pressure = mesh.points()[..mesh.n_vertices()]
        .iter()
        .map(|x| flow(*x).1);
    (velocity.collect(), pressure.collect())
}

#[test]
fn estimates_of_a_part_are_those_of_the_whole() {
    for axes in [&[1][..], &[0, 2], &[0, 1, 2]] {
        let part = part(axes);
        let whole = part.unfolded().expect("planes at zero");
        let parts = (1 << axes.len()) as f64;
        let estimated = [&part, &whole.mesh].map(|mesh| {
            let space = SurplusSpace::new(mesh).expect("a mesh");
            let (velocity, pressure) = sampled(mesh);
            let own = space.surplus(mesh, &velocity, &pressure).expect("a flow");
            let energy = own.energy(&own).expect("one space");
            let shares = space.indicators(mesh, &own, &own).expect("one space");
            let functional = space.functional(mesh, &own).expect("one space");
            (energy, shares, functional)
        });
        let [
            (energy, shares, functional),
            (all_energy, all_shares, all_functional),
        ] = estimated;
        // sums of some thousand terms of the size of the whole
        let close = |a: f64, b: f64, size: f64| (a - b).abs() <= 1e-11 * size;
        // no solution, so the sign of the estimate says nothing
        let whole_size = all_energy.abs();
        assert!(close(parts * energy, all_energy, whole_size));
        assert!((0..shares.len()).all(|k| close(shares[k], all_shares[k], whole_size)));
        // nodes on planes belong to as many parts as meet there; across planes loads cancel
        let planes: std::collections::BTreeMap<_, _> =
            part.nodes_on_symmetry_planes().into_iter().collect();
        let size = all_functional
            .velocity
            .iter()
            .fold(0.0_f64, |m, f| m.max(f.abs()));
        for (image, (node, signs)) in whole.sources.iter().enumerate() {
            let on = planes.get(node).copied().unwrap_or_default();
            let meeting = (1 << on.iter().filter(|&&on| on).count()) as f64;
            for axis in 0..3 {
                let own = functional.velocity[3 * *node as usize + axis] * signs[axis];
                let expected = if on[axis] { 0.0 } else { meeting * own };
                assert!(close(
                    all_functional.velocity[3 * image + axis],
                    expected,
                    size
                ));
            }
            if image < whole.mesh.n_vertices() {
                let expected = meeting * functional.pressure[*node as usize];
                assert!(close(all_functional.pressure[image], expected, size));
            }
        }
    }
}

#[test]
fn measures_of_a_part_are_its_share() {
    // the outer sides of an eighth of a cube enclose it together with the planes
    let mut cube = LinearTets::cube(2);
    cube.faces.iter_mut().for_each(|face| {
        face.1 = if face.1.is_multiple_of(2) {
            face.1 / 2
        } else {
            3
        }
    });
    let planes = SYMMETRY_PLANE_TAGS.map(String::from);
    cube.tags = planes.into_iter().chain(["outer".into()]).collect();
    let mesh = TetMesh::straight(cube).expect("a mesh");
    let tag = mesh.tag("outer").expect("a part");
    let measures = fem::surface_measures(&mesh, tag).expect("closed by planes");
    assert!((measures.volume - 1.0).abs() < 1e-14 && (measures.area - 3.0).abs() < 1e-14);
    assert!((measures.centroid - Vec3::repeat(0.5)).norm() < 1e-14);
    // without planes the same faces are open
    let mut cube = LinearTets::cube(2);
    cube.faces.iter_mut().for_each(|face| face.1 %= 2);
    cube.tags = ["lower", "upper"].map(String::from).into();
    let mesh = TetMesh::straight(cube).expect("a mesh");
    assert!(fem::surface_measures(&mesh, mesh.tag("upper").expect("a part")).is_err());
}
