//! Plain data types read back as they were serialised.

use mesh::{LinearTets, QuadraticTets, TetMesh};
use serde::Serialize;
use serde::de::DeserializeOwned;

fn through_json<T: Serialize + DeserializeOwned>(value: &T) -> T {
    let text = serde_json::to_string(value).unwrap();
    serde_json::from_str(&text).unwrap()
}

#[test]
fn meshes_read_back() {
    let cube = LinearTets::cube(2);
    assert_eq!(through_json(&cube), cube);
    let mesh = TetMesh::straight(cube).unwrap();
    let tets = QuadraticTets {
        points: mesh.points().to_vec(),
        tets: mesh.cells().to_vec(),
        ..QuadraticTets::default()
    };
    assert_eq!(through_json(&tets), tets);
}
