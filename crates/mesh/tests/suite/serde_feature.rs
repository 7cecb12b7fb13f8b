//! Plain data types read back as they were serialised.

use mesh::{Capsule, LinearTets, QuadraticTets, TetMesh, Vec3};
use serde::Serialize;
use serde::de::DeserializeOwned;

fn through_json<T: Serialize + DeserializeOwned>(value: &T) -> T {
    let text = serde_json::to_string(value).unwrap();
    serde_json::from_str(&text).unwrap()
}

#[test]
fn meshes_and_shapes_read_back() {
    let cube = LinearTets::cube(2);
    assert_eq!(through_json(&cube), cube);
    let mesh = TetMesh::straight(cube).unwrap();
    let tets = QuadraticTets {
        points: mesh.points().to_vec(),
        tets: mesh.cells().to_vec(),
        ..QuadraticTets::default()
    };
    assert_eq!(through_json(&tets), tets);
    let capsule = Capsule {
        centre: Vec3::new(0.1, 0.2, 0.3),
        radius: 1.5,
        half_length: 4.0,
    };
    assert_eq!(through_json(&capsule), capsule);
}
