//! New meshes between the walls of a mesh and its moved bodies by the command `gmsh`.

use super::MovedBody;
use super::kept_cells::MovedPart;
use super::{given_surfaces, moved_parts, part_of_tags};
use crate::GenerateError;
use mesh::{LinearTets, MeshError, MshFile, NamedSurface, Regions, TetMesh, Vec3};
use std::collections::HashMap;
use std::fmt::Write;
use std::io::ErrorKind;
use std::path::Path;
use std::process::Command;

/// The boundary as surfaces, each a physical group, and the volume between them.
const SCRIPT: &str = "Merge \"boundary.msh\";\n\
                      Surface Loop(1) = {Surface{:}};\n\
                      Volume(1) = {1};\n\
                      Physical Volume(\"fluid\") = {1};\n";

/// Generates a new mesh between the walls of a mesh and its moved bodies by the program Gmsh.
///
/// `command` is its name or path; it runs as a process of its own. All facets are kept with their
/// nodes, also those of bodies with known surfaces; edges in the fluid have lengths between those
/// on the facets. Midside nodes on the boundary parts named in `surfaces` are moved to them. Named
/// regions of the volume are lost.
///
/// # Errors
/// [`GenerateError::Gmsh`] if the command cannot be started, fails or changes the boundary;
/// [`MeshError::BadTag`] and [`MeshError::UnknownTag`] as [`remesh`](crate::remesh), and those of
/// reading its file and of [`TetMesh::curved`].
pub fn remesh_by_gmsh(
    command: &Path,
    mesh: &TetMesh,
    bodies: &[MovedBody<'_>],
    surfaces: &[NamedSurface],
) -> Result<TetMesh, GenerateError> {
    let part_of_tags = part_of_tags(mesh, bodies)?;
    let given = given_surfaces(mesh, bodies, &part_of_tags);
    let parts = moved_parts(bodies, &given);
    let moved = |node: u32, tag: u16| {
        let part: &MovedPart = &parts[part_of_tags[usize::from(tag)] as usize];
        part.moved(mesh.points()[node as usize])
    };
    let tets = run(command, &boundary_file(mesh, &moved))?;
    let numbers: HashMap<[u64; 3], u32> = tets.points.iter().map(bits).zip(0..).collect();
    let mut new = LinearTets {
        tags: mesh.tags().to_vec(),
        faces: Vec::new(),
        regions: Regions::default(),
        ..tets
    };
    let mut middles = HashMap::new();
    for facet in mesh.facets() {
        let [a, b, c, ab, bc, ca] = facet.nodes;
        let mut face = [0; 3];
        for (number, vertex) in face.iter_mut().zip([a, b, c]) {
            let x = moved(vertex, facet.tag);
            *number = *numbers.get(&bits(&x)).ok_or_else(|| GenerateError::Gmsh {
                problem: format!(
                    "it changed the boundary near ({:.4}, {:.4}, {:.4})",
                    x.x, x.y, x.z
                ),
            })?;
        }
        new.faces.push((face, facet.tag));
        let [a, b, c] = face;
        for ([a, b], node) in [([a, b], ab), ([b, c], bc), ([c, a], ca)] {
            middles.insert([a.min(b), a.max(b)], moved(node, facet.tag));
        }
    }
    Ok(TetMesh::with_middles(new, &middles, surfaces)?)
}

/// The bits of the coordinates of a point; minus zero is zero.
fn bits(x: &Vec3) -> [u64; 3] {
    [x.x, x.y, x.z].map(|c| (c + 0.0).to_bits())
}

/// The vertices and triangles of the boundary as MSH 2.2, text.
///
/// Numbers are written with the digits that give the same bits.
fn boundary_file(mesh: &TetMesh, moved: &dyn Fn(u32, u16) -> Vec3) -> String {
    let mut tag_of_vertices: HashMap<u32, u16> = HashMap::new();
    for facet in mesh.facets() {
        tag_of_vertices.extend(facet.nodes[..3].iter().map(|&v| (v, facet.tag)));
    }
    let mut vertices: Vec<(u32, u16)> = tag_of_vertices.into_iter().collect();
    vertices.sort_unstable();
    let mut text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n",
        mesh.tags().len()
    );
    // Writing to a string does not fail.
    for tag in 1..=mesh.tags().len() {
        let _ = writeln!(text, "2 {tag} \"part{tag}\"");
    }
    let _ = writeln!(text, "$EndPhysicalNames\n$Nodes\n{}", vertices.len());
    for &(vertex, tag) in &vertices {
        let x = moved(vertex, tag);
        let _ = writeln!(text, "{} {} {} {}", vertex + 1, x.x, x.y, x.z);
    }
    let _ = writeln!(text, "$EndNodes\n$Elements\n{}", mesh.facets().len());
    for (k, facet) in mesh.facets().iter().enumerate() {
        let [a, b, c] = [0, 1, 2].map(|i| facet.nodes[i] + 1);
        let tag = facet.tag + 1;
        let _ = writeln!(text, "{} 2 2 {tag} {tag} {a} {b} {c}", k + 1);
    }
    text.push_str("$EndElements\n");
    text
}

/// Runs the command on a boundary, in a folder of its own.
///
/// Debian's Gmsh is built without the optimiser of Netgen and fails if it is asked for. It then
/// runs again without this option; its own optimiser always runs.
fn run(command: &Path, boundary: &str) -> Result<LinearTets, GenerateError> {
    let io = |path: &Path| {
        let path = path.to_path_buf();
        move |source| MeshError::Io { path, source }
    };
    let folder = tempfile::tempdir().map_err(io(&std::env::temp_dir()))?;
    for (name, text) in [("boundary.msh", boundary), ("fluid.geo", SCRIPT)] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).map_err(io(&path))?;
    }
    match mesh_volume(command, folder.path(), &["-optimize_netgen"]) {
        Err(problem) if problem.contains(NO_NETGEN) => mesh_volume(command, folder.path(), &[]),
        done => done,
    }
    .map_err(|problem| GenerateError::Gmsh { problem })?;
    match MshFile::read(folder.path().join(OUTPUT))? {
        MshFile::Linear(tets) => Ok(tets),
        MshFile::Quadratic(_) => Err(GenerateError::Gmsh {
            problem: "its cells are of second order, by an option file".into(),
        }),
    }
}

/// The file that Gmsh writes.
const OUTPUT: &str = "fluid.msh";

/// Part of the message of a Gmsh without Netgen.
const NO_NETGEN: &str = "Netgen optimizer is not compiled";

/// Runs the command in a folder with its input files; an error is what went wrong.
fn mesh_volume(command: &Path, folder: &Path, options: &[&str]) -> Result<(), String> {
    let output = Command::new(command)
        .args(["fluid.geo", "-3", "-nt", "1"])
        .args(options)
        .args(["-bin", "-format", "msh41", "-o", OUTPUT])
        .current_dir(folder)
        .output()
        .map_err(|error| match error.kind() {
            ErrorKind::NotFound => format!("there is no command {}", command.display()),
            _ => error.to_string(),
        })?;
    if output.status.success() && folder.join(OUTPUT).exists() {
        return Ok(());
    }
    let text = [output.stdout, output.stderr].concat();
    Err(message(&String::from_utf8_lossy(&text))
        .unwrap_or_else(|| format!("it wrote no mesh ({})", output.status)))
}

/// The last errors in the output of Gmsh, without the summary between dashed lines that follows
/// them.
fn message(output: &str) -> Option<String> {
    let lines = output
        .lines()
        .filter_map(|line| line.strip_prefix("Error"))
        .map(|line| line.trim_matches([' ', ':']));
    let errors: Vec<&str> = lines.take_while(|line| !line.starts_with("---")).collect();
    let last = &errors[errors.len().saturating_sub(MAX_ERRORS)..];
    (!last.is_empty()).then(|| last.join("; "))
}

/// Largest number of errors of Gmsh in a message.
const MAX_ERRORS: usize = 3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_the_last_errors_before_the_summary() {
        let output = "Info    : Optimizing mesh (Netgen)...\n\
                      Error   : Netgen optimizer is not compiled in this version of Gmsh\n\
                      Error   : ------------------------------\n\
                      Error   : Mesh generation error summary\n\
                      Error   :     1 error\n\
                      Error   : ------------------------------\n";
        let expected = "Netgen optimizer is not compiled in this version of Gmsh";
        assert_eq!(message(output).as_deref(), Some(expected));
        assert!(message(output).is_some_and(|message| message.contains(NO_NETGEN)));
        let errors = "Error : a\nInfo : x\nError   : b\nError   : c: d\nError   : e\n";
        assert_eq!(message(errors).as_deref(), Some("b; c: d; e"));
        assert_eq!(message("Info    : nothing\n"), None);
    }
}
