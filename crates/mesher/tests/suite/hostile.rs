//! Surfaces and generation on hostile arguments: a right answer or an error, never a panic.

use crate::surfaces;
use mesh::{LinearTets, Regions, Surface, TetMesh, Vec3, Vtu};
use mesher::{
    BoxSurface, Capsule, Container, Disk, Ellipsoid, GenerateParams, Helix, MeshedBody, SizeMap,
    Sphere, Spheroid, Torus, generate, generate_sized,
};
use proptest::prelude::*;

fn number() -> impl Strategy<Value = f64> {
    let hostile = [0.0, -1.0, 5e-324, 1e-300, 1e-9, 1e9, 1e150, 1e300];
    let beyond = [f64::MAX, f64::NAN, f64::INFINITY];
    let hostile = [&hostile[..], &beyond].concat();
    prop_oneof![10 => -3.0..3.0, 1 => proptest::sample::select(hostile)]
}

fn length() -> impl Strategy<Value = f64> {
    number().prop_map(f64::abs)
}

fn vector() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(number()).prop_map(Vec3::from)
}

/// Numbers of items, most of which exist.
fn item() -> impl Strategy<Value = u32> {
    prop_oneof![20 => 0..8u32, 1 => any::<u32>()]
}

fn surface(kind: usize, centre: Vec3, [a, b]: [f64; 2]) -> Box<dyn Surface> {
    let axis = Vec3::x();
    match kind {
        0 => Box::new(Sphere::new(centre, a)),
        1 => Box::new(Spheroid {
            centre,
            axis,
            axial: a,
            equatorial: b,
        }),
        2 => Box::new(BoxSurface {
            min: -centre,
            max: Vec3::repeat(a),
        }),
        3 => Box::new(Capsule::new(centre, a, b)),
        4 => Box::new(Ellipsoid { semi_axes: centre }),
        5 => Box::new(Disk {
            radius: a,
            half_thickness: b,
        }),
        6 => Box::new(Torus { radius: a, tube: b }),
        _ => Box::new(Helix::new(a, b, centre.x, centre.y)),
    }
}

/// A valid mesh has finite points and cells with positive volumes.
fn check(mesh: &TetMesh) {
    assert!(
        mesh.points()
            .iter()
            .all(|p| p.iter().all(|x| x.is_finite()))
    );
    assert!((0..mesh.n_cells()).all(|cell| mesh.cell_volume(cell) > 0.0));
    assert!(mesh.volume() > 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// A cube of six tets with a few bad numbers.
    #[test]
    fn meshes_of_hostile_arrays_are_valid_or_refused(
        change in 0..12usize, (at, other) in (item(), item()), (x, p) in (number(), vector()),
        scale in length(), (kind, shape) in (0..8usize, [number(), number()]),
    ) {
        let mut tets = LinearTets::cube(1);
        let place = at as usize;
        match change {
            0 => tets.points[place % 8] = p,
            1 => tets.points.iter_mut().for_each(|p| *p *= scale),
            2 => tets.tets[place % 6][0] = other,
            3 => tets.faces[place % 12].0[1] = other,
            4 => tets.faces[place % 12].1 = other as u16,
            5 => tets.tags[place % 6] = "x0".into(),
            6 => tets.regions.of_cells = vec![other as u16; place % 8],
            7 => tets.points.truncate(place % 8),
            8 => tets.faces.truncate(place % 12),
            9 => tets.tags.truncate(place % 6),
            10 => tets.regions = Regions { names: vec!["a".into()], of_cells: vec![0; place % 8] },
            _ => tets.points.iter_mut().for_each(|q| *q += p),
        }
        let surface = surface(kind, p, shape);
        for mesh in [
            TetMesh::straight(tets.clone()),
            TetMesh::curved(tets, &[("x0", surface.as_ref())]),
        ] {
            let Ok(mesh) = mesh else { continue };
            check(&mesh);
            let _ = (mesh.nodes_on(other as u16), mesh.tag("none").is_err(), mesh.quality());
            let _ = mesh.gap_ratio(&[surface.as_ref(); 2], Some(surface.as_ref()));
            let _ = mesh.gap_widths(&[surface.as_ref()], None);
            let _ = (mesh.symmetry_plane_axis(other as u16), mesh.nodes_on_symmetry_planes());
            let _ = mesh.unfolded().map(|unfolded| check(&unfolded.mesh));
            let mut points = mesh.points().to_vec();
            points[place % mesh.n_points()] = p;
            let _ = mesh.with_points(points).map(|mesh| check(&mesh));
            let _ = mesh.with_points(vec![p; place % 9]).is_err();
            let vtu = || Vtu::cells(&mesh);
            prop_assert!(vtu().point_field("u", usize::MAX, &[x]).is_err());
            prop_assert!(vtu().cell_field("u", 0, &[]).is_err());
            prop_assert!(vtu().vertex_field("u", 1, &[x; 3]).is_err());
            let _ = vtu().cell_field("u", 1, &vec![x; mesh.n_cells()]).map(|vtu| vtu.to_bytes());
        }
    }

    #[test]
    fn size_maps_and_surfaces_answer_or_refuse(
        points in prop::collection::vec((vector(), number()), 0..20),
        (growth, x) in (number(), vector()), (kind, shape) in (0..8usize, [number(), number()]),
    ) {
        if let Ok(map) = SizeMap::new(points, growth) {
            let size = map.at(x);
            prop_assert!(size.is_nan() || size > 0.0);
        }
        let surface = surface(kind, x, shape);
        let _ = (surface.signed_distance(x), surface.closest_point(x), surface.bounding_ball());
        let _ = (surface.volume(), surface.reach(), surface.centre());
        let _ = (surface.inradius(), surface.curvature_size(x, 0.7, 0.3), surface.is_convex());
    }

}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// One hostile number in a scene of two bodies; at most 3000 vertices.
    #[test]
    #[ignore = "slow: 20 s"]
    fn generation_from_hostile_numbers_is_valid_or_refused(
        change in 0..13usize, (x, p) in (number(), vector()), kind in 0..3usize,
        container in 0..3usize, planes in any::<[bool; 3]>(),
    ) {
        let mut params = GenerateParams::default();
        params.max_vertices = 3000;
        params.sweeps = 2;
        let (mut centre, mut shape, mut size, mut wall) = (Vec3::zeros(), [1.0; 2], 0.7, [12.0; 2]);
        match change {
            0 => params.growth = x,
            1 => params.gap = x,
            2 => params.max_size = x,
            3 => params.min_gap = x,
            4 => params.target_dihedral = x,
            5 => params.max_vertices = (x.abs() as usize).min(3000),
            6 => centre = p,
            7 => shape[0] = x,
            8 => shape[1] = x,
            9 => size = x,
            10 => wall[0] = x,
            11 => wall[1] = x,
            _ => params.symmetry_planes = planes,
        }
        let axis = Vec3::z();
        let body: Box<dyn Surface> = match kind {
            0 => Box::new(Spheroid { centre, axis, axial: shape[0], equatorial: shape[1] }),
            _ => Box::new(Sphere::new(centre, shape[0])),
        };
        let second = Sphere::new(Vec3::new(0.0, 0.0, 5.0), 1.0);
        let bodies = [
            MeshedBody::new("a", body.as_ref(), size),
            MeshedBody::new("b", &second, 0.7),
        ];
        let centre = Vec3::zeros();
        let container = match container {
            0 => Container::Ball(Sphere::new(centre, wall[0])),
            1 => Container::Box(BoxSurface {
                min: Vec3::repeat(-wall[0]),
                max: Vec3::repeat(wall[1]),
            }),
            _ => Container::Capsule(Capsule::new(centre, wall[0], wall[1])),
        };
        let mesh = match change {
            2 => generate_sized(&bodies, &container, &params, &|q| if q.x > 0.0 { x } else { 0.7 }),
            _ => generate(&bodies, &container, &params),
        };
        if let Ok(generated) = mesh {
            let surfaces = surfaces(&bodies, &container);
            let _ = TetMesh::curved(generated.mesh, &surfaces).map(|mesh| check(&mesh));
        }
    }
}
