//! All dialects of MSH give the same mesh.

use mesh::{LinearTets, MeshError, MshFile, TetMesh};

use super::encode::{Bytes, Dialect, encode};
use crate::shapes::{UNIT_SPHERE, as_quadratic, curved_ball};

#[test]
fn all_dialects_of_an_order_hold_the_same_mesh() {
    let ball = as_quadratic(&curved_ball(2));
    for second_order in [false, true] {
        let files: Vec<MshFile> = Dialect::all()
            .into_iter()
            .filter(|dialect| dialect.second_order == second_order)
            .map(|dialect| MshFile::parse("ball.msh", &encode(&ball, dialect)).unwrap())
            .collect();
        assert_eq!(files.len(), 6);
        assert_eq!(files[0].tags(), ["surface"]);
        assert!(files.iter().all(|file| *file == files[0]));
        assert_eq!(matches!(files[0], MshFile::Quadratic(_)), second_order);
    }
}

#[test]
fn second_order_files_keep_their_nodes_and_first_order_files_can_be_curved() {
    let mesh = curved_ball(2);
    let ball = as_quadratic(&mesh);
    let read = |second_order| {
        let dialect = Dialect {
            version4: true,
            second_order,
            bytes: Bytes::Little,
        };
        MshFile::parse("ball.msh", &encode(&ball, dialect)).unwrap()
    };
    // Every midside node is on the sphere or at a midpoint; the exact volume shows whether it kept
    // its position.
    let as_saved = read(true).into_mesh(&[]).unwrap();
    let curved = read(false).into_mesh(&[("surface", &UNIT_SPHERE)]).unwrap();
    let straight = read(false).into_mesh(&[]).unwrap();
    assert!((as_saved.volume() - mesh.volume()).abs() < 1e-14);
    assert!((curved.volume() - mesh.volume()).abs() < 1e-14);
    assert!(straight.volume() < mesh.volume() - 0.1);
}

#[test]
fn written_msh_reads_back_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    for mesh in [
        curved_ball(3),
        TetMesh::straight(LinearTets::cube(3)).unwrap(),
    ] {
        let path = folder.path().join("mesh.msh");
        mesh.write(&path).unwrap();
        let MshFile::Quadratic(read) = MshFile::read(&path).unwrap() else {
            panic!("written as second order");
        };
        assert_eq!(read, as_quadratic(&mesh));
    }
}

#[test]
fn unknown_sections_are_skipped_and_groups_without_a_name_are_named_by_number() {
    let ball = as_quadratic(&curved_ball(1));
    for dialect in Dialect::all() {
        let bytes = encode(&ball, dialect);
        let names = find(&bytes, "$PhysicalNames")..find(&bytes, "$EndPhysicalNames\n") + 18;
        let comment = b"$Comments\n12 $Nodes \"\n$EndComments\n";
        let bytes = [&bytes[..names.start], comment, &bytes[names.end..]].concat();
        let file = MshFile::parse("ball.msh", &bytes).unwrap();
        assert_eq!(file.tags(), ["10"]);
    }
}

#[test]
fn faces_in_no_group_are_named_by_their_surface() {
    let ball = as_quadratic(&curved_ball(1));
    let dialect = Dialect {
        version4: false,
        second_order: false,
        bytes: Bytes::Text,
    };
    let text = String::from_utf8(encode(&ball, dialect)).unwrap();
    // Type 2 (triangle), two tags, group 10, surface 1.
    let file = MshFile::parse(
        "ball.msh",
        text.replace(" 2 2 10 1 ", " 2 2 0 1 ").as_bytes(),
    )
    .unwrap();
    assert_eq!(file.tags(), ["surface 1"]);
}

#[test]
fn windows_line_ends_are_read() {
    let ball = as_quadratic(&curved_ball(1));
    for dialect in Dialect::all()
        .into_iter()
        .filter(|d| d.bytes == Bytes::Text)
    {
        let unix = encode(&ball, dialect);
        let windows = String::from_utf8(unix.clone())
            .unwrap()
            .replace('\n', "\r\n");
        let read = |bytes| MshFile::parse("ball.msh", bytes).unwrap();
        assert_eq!(read(&unix), read(windows.as_bytes()));
    }
}

#[test]
fn missing_file_is_an_error_with_its_name() {
    let error = MshFile::read("no/such.msh").unwrap_err();
    assert!(matches!(error, MeshError::Io { .. }));
    assert!(error.to_string().starts_with("no/such.msh: "), "{error}");
}

pub fn find(bytes: &[u8], text: &str) -> usize {
    bytes
        .windows(text.len())
        .position(|window| window == text.as_bytes())
        .unwrap()
}
