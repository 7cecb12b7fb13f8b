//! Contents of VTU and PVD files.

use std::io::Read as _;

use flate2::read::ZlibDecoder;
use mesh::{LinearTets, MeshError, Pvd, TetMesh, Vec3, Vtu, VtuEncoding};

use super::dialects::find;
use crate::shapes::curved_ball;

/// The value of `attribute` in the XML element that begins with `start`.
fn attribute(text: &str, start: &str, attribute: &str) -> String {
    let element = &text[text.find(start).unwrap()..];
    let value = element.split(&format!("{attribute}=\"")).nth(1).unwrap();
    value[..value.find('"').unwrap()].to_string()
}

/// The bytes of an appended array, decompressed and without its header.
fn appended(file: &[u8], name: &str) -> Vec<u8> {
    let head = String::from_utf8_lossy(file).into_owned();
    let start = head[..head.find(&format!("Name=\"{name}\"")).unwrap()]
        .rfind('<')
        .unwrap();
    let offset: usize = attribute(&head[start..], "<DataArray", "offset")
        .parse()
        .unwrap();
    let marker = "<AppendedData encoding=\"raw\">\n_";
    let block = &file[find(file, marker) + marker.len() + offset..];
    let header = |k: usize| u64::from_le_bytes(*block[8 * k..].first_chunk().unwrap()) as usize;
    if !head.contains("compressor=\"vtkZLibDataCompressor\"") {
        return block[8..8 + header(0)].to_vec();
    }
    let (blocks, full, last) = (header(0), header(1), header(2));
    let mut place = 8 * (3 + blocks);
    let mut bytes = Vec::new();
    for k in 0..blocks {
        let end = place + header(3 + k);
        let before = bytes.len();
        ZlibDecoder::new(&block[place..end])
            .read_to_end(&mut bytes)
            .unwrap();
        let is_last = k + 1 == blocks && last > 0;
        assert_eq!(bytes.len() - before, if is_last { last } else { full });
        place = end;
    }
    bytes
}

/// Numbers of eight bytes.
fn numbers<T>(bytes: &[u8], from: fn([u8; 8]) -> T) -> Vec<T> {
    bytes
        .as_chunks()
        .0
        .iter()
        .map(|chunk| from(*chunk))
        .collect()
}

fn reals(bytes: &[u8]) -> Vec<f64> {
    numbers(bytes, f64::from_le_bytes)
}

fn integers(bytes: &[u8]) -> Vec<i64> {
    numbers(bytes, i64::from_le_bytes)
}

/// The points of a file.
fn points(file: &[u8]) -> Vec<Vec3> {
    let coordinates = reals(&appended(file, "Points"));
    coordinates.chunks(3).map(Vec3::from_column_slice).collect()
}

/// The mesh of a cube of `n^3` cubes.
fn cube(n: u32) -> TetMesh {
    TetMesh::straight(LinearTets::cube(n)).unwrap()
}

#[test]
fn appended_arrays_are_the_mesh_and_its_fields() {
    let mesh = curved_ball(2);
    let field: Vec<f64> = mesh
        .points()
        .iter()
        .flat_map(|p| [p.x, p.y * p.z, 1.0])
        .collect();
    let file = Vtu::cells(&mesh)
        .point_field("velocity", 3, &field)
        .unwrap()
        .to_bytes();
    let text = String::from_utf8_lossy(&file).into_owned();
    assert_eq!(
        attribute(&text, "<Piece", "NumberOfPoints"),
        mesh.n_points().to_string()
    );
    assert_eq!(attribute(&text, "<Piece", "NumberOfCells"), "64");
    assert_eq!(points(&file), mesh.points());
    assert_eq!(reals(&appended(&file, "velocity")), field);
    let nodes: Vec<i64> = mesh
        .cells()
        .iter()
        .flatten()
        .map(|&node| node.into())
        .collect();
    assert_eq!(integers(&appended(&file, "connectivity")), nodes);
    assert_eq!(integers(&appended(&file, "offsets"))[..2], [10, 20]);
    assert_eq!(appended(&file, "types"), [24; 64]);
}

/// Arrays of the whole file come before the piece, with their number of rows, in every encoding.
#[test]
fn arrays_of_the_whole_file_are_field_data() {
    let mesh = cube(1);
    let loads = [1.0, -2.0, 0.5, 4.0, 0.0, 1e-300];
    for encoding in [VtuEncoding::Compressed, VtuEncoding::Appended] {
        let file = Vtu::cells(&mesh)
            .file_field("loads", 3, &loads)
            .unwrap()
            .with_encoding(encoding)
            .to_bytes();
        let text = String::from_utf8_lossy(&file).into_owned();
        assert!(find(&file, "<FieldData>") < find(&file, "<Piece"));
        assert_eq!(attribute(&text, "<DataArray", "NumberOfTuples"), "2");
        assert_eq!(reals(&appended(&file, "loads")), loads);
        assert_eq!(points(&file), mesh.points());
    }
    let file = || Vtu::cells(&mesh);
    assert!(file().file_field("loads", 0, &loads).is_err());
    assert!(file().file_field("loads", 4, &loads).is_err());
    assert!(file().file_field("loads", 1, &[f64::NAN]).is_err());
    let twice =
        (file().file_field("a", 1, &[1.0])).and_then(|file| file.file_field("a", 1, &[2.0]));
    assert!(twice.is_err());
}

#[test]
fn boundary_file_has_the_boundary_nodes_only() {
    let mesh = cube(3);
    let height: Vec<f64> = mesh.points().iter().map(|p| p.z).collect();
    let file = Vtu::boundary(&mesh)
        .point_field("height", 1, &height)
        .unwrap()
        .to_bytes();
    let points = points(&file);
    // A 6-by-6 grid of half cells on each of six sides: 7^3 - 5^3 nodes.
    assert_eq!(points.len(), 218);
    let heights = reals(&appended(&file, "height"));
    assert!(points.iter().zip(&heights).all(|(p, h)| p.z == *h));
    let nodes = integers(&appended(&file, "connectivity"));
    assert_eq!(appended(&file, "types"), [22; 108]);
    let tags = reals(&appended(&file, "tag"));
    for (facet, tag) in nodes.chunks(6).zip(tags) {
        let [a, b, c] = [0, 1, 2].map(|i| points[facet[i] as usize]);
        let normal = (b - a).cross(&(c - a)).normalize();
        let mut out = Vec3::zeros();
        out[tag as usize / 2] = 2.0 * (tag % 2.0) - 1.0;
        assert!((normal - out).norm() < 1e-14);
        assert!((points[facet[4] as usize] - 0.5 * (b + c)).norm() < 1e-15);
    }
}

#[test]
fn vertex_field_is_linear_along_edges() {
    let mesh = cube(2);
    let linear = |p: &Vec3| 1.0 + 2.0 * p.x - 3.0 * p.y + 5.0 * p.z;
    let pressure: Vec<f64> = mesh.points()[..mesh.n_vertices()]
        .iter()
        .map(linear)
        .collect();
    let file = Vtu::cells(&mesh)
        .vertex_field("pressure", 1, &pressure)
        .unwrap()
        .to_bytes();
    for (value, p) in reals(&appended(&file, "pressure"))
        .iter()
        .zip(mesh.points())
    {
        assert!((value - linear(p)).abs() < 1e-14);
    }
}

#[test]
fn base64_holds_the_same_bytes() {
    let mesh = cube(1);
    let raw = Vtu::cells(&mesh)
        .with_encoding(VtuEncoding::Appended)
        .to_bytes();
    let file = Vtu::cells(&mesh)
        .with_encoding(VtuEncoding::Base64)
        .to_bytes();
    let text = String::from_utf8(file).unwrap();
    for name in ["Points", "connectivity", "offsets", "types"] {
        let array = &text[text.find(&format!("Name=\"{name}\"")).unwrap()..];
        let data = array.lines().nth(1).unwrap();
        let alphabet = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        let mut bytes: Vec<u8> = Vec::new();
        for group in data.as_bytes().chunks(4) {
            let value = |b: &u8| alphabet.iter().position(|a| a == b);
            let sum = group
                .iter()
                .fold(0, |sum, b| sum << 6 | value(b).unwrap_or(0) as u32);
            let kept = 3 - group.iter().filter(|&&b| b == b'=').count();
            bytes.extend(&sum.to_be_bytes()[1..1 + kept]);
        }
        assert_eq!(bytes[..8], (bytes.len() as u64 - 8).to_le_bytes());
        assert_eq!(bytes[8..], appended(&raw, name));
    }
}

#[test]
fn compressed_arrays_hold_the_same_bits_in_all_blocks() {
    // 17^3 vertices: the points take 863 kB, three full blocks of 256 kB and a part of one.
    let mesh = cube(16);
    let field: Vec<f64> = (0..3 * mesh.n_points())
        .map(|k| 1.0 / (1.0 + k as f64))
        .collect();
    let file = |encoding: VtuEncoding| {
        let file = Vtu::cells(&mesh).point_field("velocity", 3, &field);
        file.unwrap().with_encoding(encoding).to_bytes()
    };
    let [small, large] = [VtuEncoding::Compressed, VtuEncoding::Appended].map(file);
    for name in ["Points", "connectivity", "offsets", "types", "velocity"] {
        assert_eq!(appended(&small, name), appended(&large, name), "{name}");
    }
    assert_eq!(reals(&appended(&small, "velocity")), field);
    assert!(2 * small.len() < large.len(), "{}", small.len());
    assert_eq!(small, file(VtuEncoding::default()));
}

#[test]
fn fields_of_wrong_length_and_with_nan_are_refused() {
    let mesh = cube(1);
    let error = Vtu::cells(&mesh)
        .point_field("u", 3, &[0.0; 5])
        .err()
        .unwrap();
    assert_eq!(
        error.to_string(),
        "field 'u' has 5 entries, but the mesh needs 81"
    );
    let error = Vtu::cells(&mesh)
        .vertex_field("p", 1, &[0.0; 9])
        .err()
        .unwrap();
    assert!(matches!(
        error,
        MeshError::WrongLength {
            expected: 8,
            found: 9,
            ..
        }
    ));
    let mut values = [0.0; 6];
    values[4] = f64::NAN;
    let error = Vtu::cells(&mesh).cell_field("q", 1, &values).err().unwrap();
    assert!(matches!(error, MeshError::BadValue { index: 4, .. }));
}

#[test]
fn duplicate_field_names_are_refused() {
    let mesh = cube(1);
    let duplicate = |file: Result<Vtu, MeshError>| match file.err() {
        Some(MeshError::DuplicateField { name }) => name,
        other => panic!("{other:?}"),
    };
    let (on_points, on_vertices, on_cells) = ([0.0; 27], [0.0; 8], [0.0; 6]);
    let file = || Vtu::cells(&mesh).point_field("p", 1, &on_points).unwrap();
    assert_eq!(duplicate(file().point_field("p", 1, &on_points)), "p");
    assert_eq!(duplicate(file().vertex_field("p", 1, &on_vertices)), "p");
    // Fields on nodes and on cells are separate lists.
    let file = file().cell_field("p", 1, &on_cells).unwrap();
    assert_eq!(duplicate(file.cell_field("p", 1, &on_cells)), "p");
    let tags = Vtu::boundary(&mesh).cell_field("tag", 1, &[0.0; 12]);
    assert_eq!(duplicate(tags), "tag");
}

#[test]
fn names_are_escaped() {
    let mesh = cube(1);
    let file = Vtu::cells(&mesh)
        .cell_field("a<b & \"c\"", 1, &[0.0; 6])
        .unwrap()
        .to_bytes();
    assert!(String::from_utf8_lossy(&file).contains("Name=\"a&lt;b &amp; &quot;c&quot;\""));
}

#[test]
fn series_lists_each_file_with_its_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.pvd");
    let mut series = Pvd::new();
    series.push(0.0, "run-0.vtu");
    series.push(0.1, "run-1.vtu");
    series.write(&path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("<DataSet timestep=\"0.1\" part=\"0\" file=\"run-1.vtu\"/>"));
    assert_eq!(text.matches("<DataSet").count(), 2);
    series.push(f64::NAN, "run-2.vtu");
    assert!(matches!(
        series.write(&path),
        Err(MeshError::BadValue { index: 2, .. })
    ));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
}

#[test]
fn format_follows_the_file_extension() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = cube(1);
    mesh.write(folder.path().join("a.vtu")).unwrap();
    mesh.write(folder.path().join("a.msh")).unwrap();
    let start = |name: &str| std::fs::read(folder.path().join(name)).unwrap()[..5].to_vec();
    assert_eq!(
        (start("a.vtu"), start("a.msh")),
        (b"<?xml".to_vec(), b"$Mesh".to_vec())
    );
    assert!(matches!(
        mesh.write("a.stl"),
        Err(MeshError::UnknownFormat { .. })
    ));
}
