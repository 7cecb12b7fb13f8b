//! Estimates and surface measures on a part between symmetry planes agree with those of the whole.

use fem::{CubicExtension, SurplusSpace};
use mesh::{LinearTets, SYMMETRY_PLANE_TAGS, TetMesh, Vec3};

/// Part of a box between symmetry planes normal to `axes`, with displaced interior vertices.
fn part(axes: &[usize]) -> TetMesh {
    let mut cube = LinearTets::cube(3);
    for &axis in axes {
        cube.tags[2 * axis] = SYMMETRY_PLANE_TAGS[axis].into();
    }
    for x in &mut cube.points {
        let inside = x.map(|c| if c > 0.0 && c < 1.0 { 0.05 } else { 0.0 });
        let displacement = Vec3::new((7.0 * x.y).sin(), (9.0 * x.z).cos(), (5.0 * x.x).sin());
        *x += inside.component_mul(&displacement);
    }
    TetMesh::straight(cube).expect("a mesh")
}

/// Flow that is symmetric about all coordinate planes.
///
/// Each velocity component is odd across the plane normal to it and even across the others; the
/// pressure is even.
fn flow(x: Vec3) -> (Vec3, f64) {
    let even = |x: Vec3| (1.3 * x.x * x.x).cos() + (x.y * x.y * x.z * x.z).exp();
    let u = Vec3::new(
        x.x.sin() * even(x),
        (2.0 * x.y).sin() * even(x.yzx()),
        x.z.powi(3) * even(x.zxy()),
    );
    (u, even(x.yxz()))
}

fn sampled(mesh: &TetMesh) -> (Vec<Vec3>, Vec<f64>) {
    let velocity = mesh.points().iter().map(|x| flow(*x).0);
    let pressure = mesh.points()[..mesh.n_vertices()]
        .iter()
        .map(|x| flow(*x).1);
    (velocity.collect(), pressure.collect())
}

#[test]
fn estimates_of_a_part_equal_those_of_the_whole() {
    for axes in [&[1][..], &[0, 2], &[0, 1, 2]] {
        let part = part(axes);
        let whole = part.unfolded().expect("planes at zero");
        let parts = (1 << axes.len()) as f64;
        let estimated = [&part, &whole.mesh].map(|mesh| {
            let space = SurplusSpace::new(mesh).expect("a mesh");
            let (velocity, pressure) = sampled(mesh);
            let surplus = space.surplus(mesh, &velocity, &pressure).expect("a flow");
            let energy = surplus.energy(&surplus).expect("one space");
            let indicators = space
                .indicators(mesh, &surplus, &surplus)
                .expect("one space");
            let cubic = CubicExtension::new(&space, mesh).expect("a mesh");
            let at_rest = vec![0.0; cubic.len()];
            let product = cubic.product(&velocity, &pressure, &at_rest);
            // The sum of the squares of the residuals, which reflections do not change; those of
            // bubbles and edges in planes belong to both sides.
            let residual = product.expect("a flow").extension;
            let inside = residual.iter().filter(|r| **r != 0.0).count();
            (energy, indicators, (residual.len(), inside))
        });
        let [
            (energy, indicators, (dofs, free)),
            (all_energy, all_indicators, (all_dofs, all_free)),
        ] = estimated;
        // Dofs in the planes are not repeated, and normal components there are prescribed.
        assert!(all_dofs < (1 << axes.len()) * dofs && all_free <= (1 << axes.len()) * free);
        // Rounding of sums of some thousand terms of the size of the whole.
        let close = |a: f64, b: f64, size: f64| (a - b).abs() <= 1e-11 * size;
        // The flow is not a discrete solution, so the estimate may be negative.
        let whole_size = all_energy.abs();
        assert!(close(parts * energy, all_energy, whole_size));
        assert!((0..indicators.len()).all(|k| close(indicators[k], all_indicators[k], whole_size)));
    }
}

#[test]
fn surface_measures_of_a_part_are_closed_by_symmetry_planes() {
    // Together with the symmetry planes the outer sides of an eighth of a cube enclose it.
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
    // Without symmetry planes the same faces do not form a closed surface.
    let mut cube = LinearTets::cube(2);
    cube.faces.iter_mut().for_each(|face| face.1 %= 2);
    cube.tags = ["lower", "upper"].map(String::from).into();
    let mesh = TetMesh::straight(cube).expect("a mesh");
    assert!(fem::surface_measures(&mesh, mesh.tag("upper").expect("a part")).is_err());
}
