//! Three spheres in a ball, meshed by Gmsh (MSH 2.2, ascii), with straight edges.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::Stokes;
use super::system::domain::{Domain, Owner};
use super::system::elements::EDGES;

/// The system of `ball_311k_v22.msh`, or `None` if the file is missing.
pub fn three_spheres() -> Option<Stokes> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/meshes/ball_311k_v22.msh"
    );
    let text = std::fs::read_to_string(path).ok()?;
    let numbers =
        |line: &str| -> Vec<f64> { line.split(' ').filter_map(|w| w.parse().ok()).collect() };
    let section = |name: &'static str| {
        let lines = text.lines().skip_while(move |l| l.trim() != name).skip(2);
        lines.take_while(|l| !l.starts_with("$End")).map(numbers)
    };
    let mut points = Vec::new();
    let mut index = BTreeMap::new();
    for node in section("$Nodes") {
        index.insert(node[0] as usize, points.len());
        points.push(Vector3::new(node[1], node[2], node[3]));
    }
    let mut owners = vec![Owner::Fluid; points.len()];
    let mut linear = Vec::new();
    for element in section("$Elements") {
        let tags = element[2] as usize;
        let nodes: Vec<usize> = element[3 + tags..]
            .iter()
            .map(|&n| index[&(n as usize)])
            .collect();
        match (element[1] as usize, element[3] as usize) {
            (2, 20) => nodes.iter().for_each(|&n| owners[n] = Owner::Wall),
            (2, sphere) => nodes
                .iter()
                .for_each(|&n| owners[n] = Owner::Body(sphere - 11)),
            (4, _) => linear.push(nodes),
            _ => {}
        }
    }
    let mut midside = BTreeMap::new();
    let mut tets = Vec::with_capacity(linear.len());
    for vertices in linear {
        let mut tet = [0; 10];
        tet[..4].copy_from_slice(&vertices);
        for (e, [a, b]) in EDGES.iter().enumerate() {
            let ends = (tet[*a].min(tet[*b]), tet[*a].max(tet[*b]));
            tet[4 + e] = *midside.entry(ends).or_insert_with(|| {
                points.push(0.5 * (points[ends.0] + points[ends.1]));
                // in this mesh an edge with both ends on one surface lies in it: the spheres are
                // resolved
                let same = owners[ends.0] == owners[ends.1];
                owners.push(if same { owners[ends.0] } else { Owner::Fluid });
                points.len() - 1
            });
        }
        tets.push(tet);
    }
    let centres = [-10.0, 10.0, 0.0]
        .map(|x| Vector3::new(x, 0.0, 0.0))
        .to_vec();
    let domain = Domain {
        volumes: vec![4.0 / 3.0 * std::f64::consts::PI; 3],
        points,
        tets,
        owners,
        centres,
    };
    Some(domain.assemble(1.0))
}
