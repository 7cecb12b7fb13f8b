//! Construction of a mesh from separate tets: properties of the result, errors of bad input.

use crate::shapes::{Sphere, UNIT_SPHERE, as_quadratic, ball, curved_ball};
use mesh::{LinearTets, MeshError, QuadraticTets, TET_EDGES, TetMesh, Vec3};

fn cube() -> LinearTets {
    LinearTets::cube(2)
}

#[track_caller]
fn refused(tets: LinearTets, message: &str) {
    let error = TetMesh::straight(tets).unwrap_err().to_string();
    assert!(error.contains(message), "{error}");
}

#[test]
fn vertices_come_first_and_midside_nodes_are_midpoints() {
    let mesh = TetMesh::straight(LinearTets::cube(3)).unwrap();
    // 4^3 vertices; together with the midside nodes they are the 7^3 points of the half-width grid.
    assert_eq!(
        (mesh.n_vertices(), mesh.n_points(), mesh.n_cells()),
        (64, 343, 162)
    );
    for (c, cell) in mesh.cells().iter().enumerate() {
        let x = mesh.cell_points(c);
        assert!(cell[..4].iter().all(|&v| (v as usize) < mesh.n_vertices()));
        assert!(cell[4..].iter().all(|&v| (v as usize) >= mesh.n_vertices()));
        for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
            assert_eq!(x[4 + k], 0.5 * (x[i] + x[j]));
        }
        assert!((x[1] - x[0]).cross(&(x[2] - x[0])).dot(&(x[3] - x[0])) > 0.0);
        assert!(mesh.is_affine(c));
    }
}

#[test]
fn facets_point_out_and_belong_to_their_cell_and_side() {
    let mesh = TetMesh::straight(LinearTets::cube(3)).unwrap();
    assert_eq!(mesh.facets().len(), 108);
    for facet in mesh.facets() {
        let cell = mesh.cells()[facet.cell as usize];
        assert!(facet.nodes.iter().all(|node| cell.contains(node)));
        let x = facet.nodes.map(|node| mesh.points()[node as usize]);
        let (axis, side) = (facet.tag as usize / 2, f64::from(facet.tag % 2));
        assert!(x.iter().all(|p| p[axis] == side));
        assert!((x[1] - x[0]).cross(&(x[2] - x[0]))[axis] * (2.0 * side - 1.0) > 0.0);
        for (k, [i, j]) in [[0, 1], [1, 2], [2, 0]].into_iter().enumerate() {
            assert_eq!(x[3 + k], 0.5 * (x[i] + x[j]));
        }
    }
    let top = mesh.tag("z1").unwrap();
    // A 7-by-7 grid of nodes on a side.
    assert_eq!(mesh.nodes_on(top).len(), 49);
    assert!(
        mesh.nodes_on(top)
            .iter()
            .all(|&node| mesh.points()[node as usize].z == 1.0)
    );
    let error = mesh.tag("lid").unwrap_err().to_string();
    assert_eq!(
        error,
        "the mesh has no boundary part 'lid'; it has: x0, x1, y0, y1, z0, z1"
    );
}

#[test]
fn inverted_tets_and_faces_are_reoriented() {
    let mut tets = cube();
    for tet in tets.tets.iter_mut().step_by(2) {
        tet.swap(0, 1);
    }
    for (face, _) in tets.faces.iter_mut().step_by(3) {
        face.swap(1, 2);
    }
    let mesh = TetMesh::straight(tets).unwrap();
    let expected = TetMesh::straight(cube()).unwrap();
    assert_eq!(mesh.points(), expected.points());
    assert!((mesh.volume() - 1.0).abs() < 1e-14);
    for facet in mesh.facets() {
        let [a, b, c, ..] = facet.nodes.map(|node| mesh.points()[node as usize]);
        let outward = (a + b + c) / 3.0 - Vec3::repeat(0.5);
        assert!((b - a).cross(&(c - a)).dot(&outward) > 0.0);
    }
}

#[test]
fn curved_boundary_nodes_are_on_the_sphere_and_the_rest_are_midpoints() {
    let mesh = curved_ball(3);
    let surface = mesh.nodes_on(0);
    for &node in &surface {
        assert!((mesh.points()[node as usize].norm() - 1.0).abs() < 1e-15);
    }
    for cell in mesh.cells() {
        for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
            if surface.binary_search(&cell[4 + k]).is_err() {
                let [a, b, m] =
                    [cell[i], cell[j], cell[4 + k]].map(|node| mesh.points()[node as usize]);
                assert_eq!(m, 0.5 * (a + b));
            }
        }
    }
}

#[test]
fn moved_copies_share_the_topology_and_are_checked() {
    let mesh = curved_ball(2);
    let moved = mesh
        .with_points(mesh.points().iter().map(|p| 2.0 * p).collect())
        .unwrap();
    assert!(std::ptr::eq(moved.cells(), mesh.cells()));
    assert!((moved.volume() - 8.0 * mesh.volume()).abs() < 1e-13);
    assert_eq!(
        moved.bounding_box(),
        mesh.bounding_box().map(|corner| 2.0 * corner)
    );

    let inverted = mesh.points().iter().map(|p| -p).collect();
    assert!(matches!(
        mesh.with_points(inverted),
        Err(MeshError::InvertedCell { .. })
    ));
    let too_few = mesh.points()[1..].to_vec();
    assert!(matches!(
        mesh.with_points(too_few),
        Err(MeshError::WrongLength { .. })
    ));
    let mut nan = mesh.points().to_vec();
    nan[3].y = f64::NAN;
    assert!(matches!(
        mesh.with_points(nan),
        Err(MeshError::NotFinite { point: 3 })
    ));
}

#[test]
fn one_midside_node_pulled_through_its_cell_is_found() {
    let mesh = curved_ball(2);
    let cell = 17;
    let node = mesh.cells()[cell][6] as usize;
    let mut points = mesh.points().to_vec();
    let opposite = mesh.cell_vertices(cell)[3];
    points[node] = 3.0 * opposite - 2.0 * points[node];
    match mesh.with_points(points) {
        Err(MeshError::InvertedCell { cell, jacobian, .. }) => {
            assert!(jacobian < 0.0);
            assert!(mesh.cells()[cell].contains(&(node as u32)));
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn affine_cells_stay_affine_under_rotation_far_from_the_origin() {
    let mesh = TetMesh::straight(cube()).unwrap();
    let rotation = nalgebra::Rotation3::from_euler_angles(0.3, 1.1, -2.0);
    let far = Vec3::new(100.0, -300.0, 700.0);
    let moved = mesh
        .with_points(mesh.points().iter().map(|p| rotation * p + far).collect())
        .unwrap();
    assert!((0..moved.n_cells()).all(|cell| moved.is_affine(cell)));
    assert!((0..curved_ball(2).n_cells()).any(|cell| !curved_ball(2).is_affine(cell)));
}

/// Asserts that a cube with this change is refused.
#[track_caller]
fn changed(change: impl FnOnce(&mut LinearTets), message: &str) {
    let mut tets = cube();
    change(&mut tets);
    refused(tets, message);
}

#[test]
fn empty_meshes_and_bad_numbers_are_refused() {
    refused(LinearTets::default(), "no tetrahedra");
    changed(|t| t.points[5].x = f64::INFINITY, "point 5 are not finite");
    let beyond = "tet 7 refers to number 27, but there are only 27";
    changed(|t| t.tets[7][2] = 27, beyond);
    changed(|t| t.faces[3].0[1] = 99, "face 3 refers to number 99");
    changed(|t| t.faces[3].1 = 6, "tag of face 3 refers to number 6");
}

#[test]
fn unused_and_duplicate_vertices_are_refused() {
    let unused = "vertex 27 at (0.1000, 0.2000, 0.3000) belongs to no tetrahedron";
    changed(|t| t.points.push(Vec3::new(0.1, 0.2, 0.3)), unused);
    // Two copies of the cube, each with its own vertices, at the same position.
    let twice = |t: &mut LinearTets| {
        t.points.extend(cube().points);
        t.tets
            .extend(cube().tets.iter().map(|tet| tet.map(|v| v + 27)));
    };
    let message = "vertices 0 and 27 are both at (0.0000, 0.0000, 0.0000)";
    changed(twice, message);
}

#[test]
fn flat_duplicate_and_overlapping_cells_are_refused() {
    let [a, b, c, _] = cube().tets[0];
    changed(|t| t.tets.push([a, b, c, a]), "tet 48 near (");
    changed(|t| t.tets.push(t.tets[5]), "occurs twice");

    // Three tets on one face, with all their other faces tagged.
    let tip = |x, y, z| Vec3::new(x, y, z);
    let apexes = [3, 4, 5];
    let tets = LinearTets {
        points: vec![
            Vec3::zeros(),
            Vec3::x(),
            Vec3::y(),
            tip(0.2, 0.2, 1.0),
            tip(0.3, 0.3, -1.0),
            tip(0.6, 0.6, 1.0),
        ],
        tets: apexes.map(|apex| [0, 1, 2, apex]).to_vec(),
        faces: apexes
            .iter()
            .flat_map(|&apex| [[0, 1, apex], [1, 2, apex], [2, 0, apex]].map(|face| (face, 0)))
            .collect(),
        tags: vec!["outer".into()],
        ..LinearTets::default()
    };
    refused(
        tets,
        "3 tetrahedra share the face near (0.3333, 0.3333, 0.0000)",
    );
}

#[test]
fn bad_boundary_parts_are_refused() {
    changed(|t| t.faces.truncate(47), "has no tag");
    let twice = "is tagged twice, 'x0' and 'y1'";
    changed(|t| t.faces.push((t.faces[0].0, 3)), twice);
    let [a, b, c, d] = cube().tets[0];
    // The faces a-b-d and a-c-d of Kuhn's first tet are inside the cube.
    let inside = "belongs to 2 tetrahedra instead of one";
    changed(|t| t.faces.push(([a, b, d], 1)), inside);
    let nowhere = "belongs to 0 tetrahedra instead of one";
    changed(|t| t.faces.push(([a, b, 26], 1)), nowhere);
    assert!(c != d);
    let empty = "boundary part 'nowhere' has no faces";
    changed(|t| t.tags.push("nowhere".into()), empty);
    let twice = "boundary part 'x0' is named twice";
    changed(|t| t.tags[4] = "x0".into(), twice);
    changed(|t| t.tags[2] = "line\nbreak".into(), "printable");
}

#[test]
fn surfaces_off_the_boundary_are_refused() {
    let off = Sphere::new(Vec3::new(1e-3, 0.0, 0.0), 1.0);
    let error = TetMesh::curved(ball(2), &[("surface", &off)]).unwrap_err();
    match error {
        MeshError::OffSurface {
            distance, allowed, ..
        } => {
            assert!(distance <= 1e-3 && distance > allowed);
        }
        other => panic!("{other:?}"),
    }
    let error = TetMesh::curved(ball(2), &[("skin", &UNIT_SPHERE)]).unwrap_err();
    assert!(matches!(error, MeshError::UnknownTag { .. }));
}

#[test]
fn elements_too_large_for_their_surface_are_refused_as_inverted() {
    // The tip is at height 0.8 and the flat face below it at 0.71, but between the corners of the
    // face the sphere rises to 1.
    let (z, r) = (0.5_f64.sqrt(), 0.5_f64.sqrt());
    let corner = |angle: f64| Vec3::new(r * angle.cos(), r * angle.sin(), z);
    let third = std::f64::consts::TAU / 3.0;
    let tets = LinearTets {
        points: vec![
            corner(0.0),
            corner(third),
            corner(2.0 * third),
            Vec3::new(0.0, 0.0, 0.8),
        ],
        tets: vec![[0, 1, 2, 3]],
        faces: vec![
            ([0, 1, 2], 0),
            ([0, 1, 3], 1),
            ([1, 2, 3], 1),
            ([2, 0, 3], 1),
        ],
        tags: vec!["body".into(), "cut".into()],
        ..LinearTets::default()
    };
    TetMesh::straight(tets.clone()).unwrap();
    let error = TetMesh::curved(tets, &[("body", &UNIT_SPHERE)]).unwrap_err();
    assert!(
        matches!(error, MeshError::InvertedCell { jacobian, .. } if jacobian < 0.0),
        "{error}"
    );
}

#[test]
fn cells_with_one_rounded_vertex_on_a_surface_stay_affine() {
    // Some files have vertices in single precision. Moving them onto the sphere must move the
    // midpoints too.
    let mut tets = ball(3);
    for p in &mut tets.points {
        *p = p.map(|x| f64::from(x as f32));
    }
    let mesh = TetMesh::curved(tets, &[("surface", &UNIT_SPHERE)]).unwrap();
    let surface = mesh.nodes_on(0);
    for (c, cell) in mesh.cells().iter().enumerate() {
        let touches = cell[4..]
            .iter()
            .any(|node| surface.binary_search(node).is_ok());
        assert_eq!(mesh.is_affine(c), !touches);
    }
}

#[test]
fn nonconforming_second_order_meshes_are_refused() {
    let mesh = curved_ball(1);
    let good = as_quadratic(&mesh);
    let again = TetMesh::quadratic(good.clone(), &[]).unwrap();
    assert!((again.volume() - mesh.volume()).abs() < 1e-15);
    let refused = |change: &dyn Fn(&mut QuadraticTets), message: &str| {
        let mut bad = good.clone();
        change(&mut bad);
        let error = TetMesh::quadratic(bad, &[]).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    };
    refused(
        &|bad| bad.tets[0][4] = bad.tets[0][0],
        "the node is also a vertex",
    );
    refused(&|bad| bad.tets[0][9] = bad.tets[0][8], "");
    let extra = |bad: &mut QuadraticTets| {
        bad.points.push(Vec3::new(0.3, 0.3, 0.3));
        bad.points.len() as u32 - 1
    };
    refused(
        &|bad| bad.tets[0][4] = extra(bad),
        "another cell has a different midside node on this edge",
    );
    refused(
        &|bad| bad.faces[0].0[3] = extra(bad),
        "a face and a cell have different midside nodes on this edge",
    );
    refused(
        &|bad| bad.faces[0].0[0] = extra(bad),
        "it is a vertex of a face, but not of a cell",
    );
    refused(&|bad| bad.tets[0][4] = 1000, "tet 0 refers to number 1000");
}
