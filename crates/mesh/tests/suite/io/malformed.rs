//! Malformed files are errors with a location, never panics.

use mesh::{FileLocation, MeshError, MshFile};
use proptest::prelude::*;

use super::dialects::find;
use super::encode::{Bytes, Dialect, encode, node_tag};
use crate::shapes::{as_quadratic, curved_ball};

fn ball(version4: bool, bytes: Bytes) -> Vec<u8> {
    let dialect = Dialect {
        version4,
        second_order: false,
        bytes,
    };
    encode(&as_quadratic(&curved_ball(1)), dialect)
}

fn text(version4: bool) -> String {
    String::from_utf8(ball(version4, Bytes::Text)).unwrap()
}

/// Asserts that a text file is refused with the given line and a part of the message.
#[track_caller]
fn refused(text: &str, line: usize, message: &str) {
    match MshFile::parse("bad.msh", text.as_bytes()) {
        Err(MeshError::Malformed {
            file,
            location,
            problem,
        }) => {
            assert_eq!(file, "bad.msh");
            assert!(problem.contains(message), "{problem}");
            assert_eq!(location, FileLocation::Line(line), "{problem}");
        }
        other => panic!("{other:?}"),
    }
}

/// The line on which `part` begins.
fn line_of(text: &str, part: &str) -> usize {
    1 + text[..text.find(part).unwrap()].matches('\n').count()
}

/// As [`refused`], for a line so many lines below the one on which `part` begins.
#[track_caller]
fn refused_below(text: &str, part: &str, lines: usize, message: &str) {
    refused(text, line_of(text, part) + lines, message);
}

#[test]
fn files_without_a_mesh_are_refused() {
    refused("", 1, "no $MeshFormat");
    refused("hello\n", 1, "found 'hello'");
    refused("$Nodes\n0\n$EndNodes\n", 1, "$MeshFormat must come first");
    refused("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", 4, "no tetrahedra");
    refused("$MeshFormat\n4.0 0 8\n$EndMeshFormat\n", 2, "version '4.0'");
    refused(
        "$NOD\n1\n1 0 0 0\n$ENDNOD\n",
        1,
        "MSH version 1, which is too old",
    );
    refused(
        "$MeshFormat\n1.0 0 8\n$EndMeshFormat\n",
        2,
        "'1.0' is too old; save it as version 4.1 or 2.2",
    );
    refused(
        "$MeshFormat\n4.1 2 8\n$EndMeshFormat\n",
        2,
        "0 (text) or 1 (binary)",
    );
    refused("$MeshFormat\n4.1 0 16\n$EndMeshFormat\n", 2, "data size");
    refused("$MeshFormat\n4.1 0", 2, "ends in the middle of $MeshFormat");
}

#[test]
fn wrong_counts_are_refused() {
    for version4 in [false, true] {
        let good = text(version4);
        // With a count too large, the end of the section is found where a number should be; with a
        // count too small, a number where the end should be.
        let n_nodes = 7;
        let (more, fewer) = if version4 {
            (
                good.replace(" 3 \n7 \n", " 4 \n7 \n")
                    .replace("$Nodes\n2 7 ", "$Nodes\n2 8 "),
                good.replace("$Nodes\n2 7 ", "$Nodes\n2 6 "),
            )
        } else {
            (
                good.replace("$Nodes\n7\n", "$Nodes\n8\n"),
                good.replace("$Nodes\n7\n", "$Nodes\n6\n"),
            )
        };
        assert_ne!(good, more);
        assert_ne!(good, fewer);
        assert!(good.contains(&node_tag(n_nodes - 1).to_string()));
        assert!(MshFile::parse("more", more.as_bytes()).is_err());
        assert!(MshFile::parse("fewer", fewer.as_bytes()).is_err());
    }
    let fewer = text(false).replace("$Nodes\n7\n", "$Nodes\n6\n");
    let last = format!("\n{} ", node_tag(6));
    refused_below(&fewer, &last, 1, "should end here");
    let more = text(false).replace("$Nodes\n7\n", "$Nodes\n8\n");
    refused_below(
        &more,
        "$EndNodes",
        0,
        "expected a number, found '$EndNodes'",
    );
}

#[test]
fn huge_counts_are_refused_before_memory_is_reserved() {
    for huge in ["99999999999", "18446744073709551615"] {
        for (version4, count, huge, section) in [
            (false, "$Nodes\n7\n", format!("$Nodes\n{huge}\n"), "$Nodes"),
            (true, "$Nodes\n2 7 ", format!("$Nodes\n{huge} 7 "), "$Nodes"),
            (true, "$Nodes\n2 7 ", format!("$Nodes\n2 {huge} "), "$Nodes"),
            (
                true,
                "$Entities\n1 0 ",
                format!("$Entities\n{huge} 0 "),
                "$Entities",
            ),
        ] {
            let text = text(version4).replace(count, &huge);
            refused_below(&text, section, 1, "can hold at most");
        }
    }
}

#[test]
fn bad_nodes_are_refused() {
    let good = text(false);
    let first = format!("\n{} ", node_tag(0));
    let second = format!("\n{} ", node_tag(1));
    let twice = good.replacen(&second, &first, 1);
    refused(&twice, line_of(&twice, "$EndNodes") - 2, "node 7 twice");
    let negative = good.replacen(&first, "\n-7 ", 1);
    refused_below(&negative, "-7", 0, "negative");
    let at = line_of(&good, "$Nodes") + 2;
    let coordinates = good.lines().nth(at - 1).unwrap();
    let tag = node_tag(0);
    for (bad, message) in [
        (format!("{tag} nan 0 0"), "not a finite number"),
        (format!("{tag} 0 inf 0"), "not a finite number"),
        (format!("{tag} 0 1e999 0"), "not a finite number"),
        (format!("{tag} 0 zero 0"), "found 'zero'"),
    ] {
        refused(&good.replace(coordinates, &bad), at, message);
    }
    let outside = text(true).replace("$Nodes\n2 7 7 25 ", "$Nodes\n2 7 7 24 ");
    assert_ne!(outside, text(true));
    assert!(
        MshFile::parse("bad.msh", outside.as_bytes())
            .unwrap_err()
            .to_string()
            .contains("outside the range 7 to 24")
    );
}

#[test]
fn parametric_nodes_of_version_2_are_reported_as_the_cause() {
    // Such files of Gmsh have no $Nodes; the message once blamed the order of sections.
    let text = text(false).replace("Nodes\n", "ParametricNodes\n");
    refused_below(&text, "$ParametricNodes", 0, "Mesh.SaveParametric = 0");
}

#[test]
fn bad_elements_are_refused() {
    let good = text(false);
    let tets = line_of(&good, " 4 2 10 1 ");
    let tet = good.lines().nth(tets - 1).unwrap();
    let words: Vec<&str> = tet.split_whitespace().collect();
    let with = |index: usize, word: &str| {
        let mut words = words.clone();
        words[index] = word;
        good.replace(tet, &words.join(" "))
    };
    refused(&with(8, "8"), tets, "node 8, which $Nodes does not have");
    refused(&with(8, "4000000000"), tets, "expected a number");
    refused(&with(1, "5"), tets, "hexahedra (element type 5)");
    refused(&with(1, "6"), tets, "prisms (element type 6)");
    refused(&with(1, "7"), tets, "pyramids (element type 7)");
    refused(&with(1, "29"), tets, "order above two");
    refused(&with(1, "3"), tets, "quadrangles");
    refused(&with(1, "777"), tets, "unknown kind (element type 777)");
    let nodes = good.find("$Nodes").unwrap()..good.find("$Elements").unwrap();
    let without_nodes = good.replace(&good[nodes], "");
    refused_below(&without_nodes, "$Elements", 0, "before $Nodes");
    let mixed = with(1, "11").replace(&words.join(" "), "");
    let ten = [
        &["99", "11", "2", "10", "1"],
        &words[5..9],
        &words[5..9],
        &words[5..7],
    ]
    .concat()
    .join(" ");
    let mixed = mixed.replace(&mixed.lines().nth(tets - 1).unwrap().to_string(), &ten);
    refused(&mixed, tets, "order 1 and 2 are mixed");
}

#[test]
fn bad_groups_are_refused() {
    let good = text(true);
    let two = good.replacen(" 1 10 0 \n", " 2 10 11 0 \n", 1);
    assert_ne!(two, good);
    refused_below(&two, "\n2 1 2 ", 1, "in the physical groups [10, 11]");
    let other = good.replacen("\n2 1 2 ", "\n2 5 2 ", 1);
    refused_below(
        &other,
        "\n2 5 2 ",
        1,
        "surface 5, which is missing in $Entities",
    );
    let unquoted = good.replace("\"surface\"", "surface");
    refused_below(&unquoted, "2 10 surface", 0, "needs a name in quotes");
}

#[test]
fn errors_of_binary_files_have_the_offset() {
    for version4 in [false, true] {
        let good = ball(version4, Bytes::Little);
        let mark = find(&good, "$EndMeshFormat") - 5;
        let mut bad = good.clone();
        bad[mark] = 2;
        let error = MshFile::parse("bad.msh", &bad).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("bad.msh: byte {mark}: the byte order mark is not the number 1")
        );
        let cut = find(&good, "$EndElements") - 3;
        let error = MshFile::parse("bad.msh", &good[..cut]).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("ends in the middle of $Elements"),
            "{error}"
        );
    }
}

#[test]
fn every_truncation_is_an_error_with_a_place() {
    for dialect in Dialect::all() {
        let good = encode(&as_quadratic(&curved_ball(1)), dialect);
        let end = find(&good, "$EndElements") + "$EndElements".len();
        for length in 0..end {
            let error = MshFile::parse("cut.msh", &good[..length]).unwrap_err();
            assert!(
                matches!(error, MeshError::Malformed { .. }),
                "{dialect:?} {length}: {error}"
            );
        }
        MshFile::parse("whole.msh", &good[..end]).unwrap();
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Whatever is changed in a file, reading and building it end in a mesh or in an error.
    #[test]
    fn mutated_files_never_panic(
        dialect in prop::sample::select(Dialect::all()),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4), 1..6),
    ) {
        let mut bytes = encode(&as_quadratic(&curved_ball(1)), dialect);
        for (index, byte, kind) in changes {
            let at = index.index(bytes.len());
            match kind {
                0 => bytes[at] = byte,
                1 => bytes[at] ^= 1 << (byte % 8),
                2 => { bytes.remove(at); }
                // Digits make other numbers where random bytes make no number.
                _ => bytes.insert(at, b'0' + byte % 10),
            }
        }
        if let Ok(file) = MshFile::parse("mutated.msh", &bytes) {
            let _ = file.into_mesh(&[]);
        }
    }
}
