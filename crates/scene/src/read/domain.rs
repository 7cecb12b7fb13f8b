//! The domain of a scene file.

use std::path::{Path, PathBuf};

use crate::checks::Checks;
use crate::document::Document;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::keys::DomainFile;
use crate::surface_shape::{SurfaceFiles, SurfaceKeys};
use crate::wall_facets::WallFacets;
use crate::words::DomainKind;

/// The domain, with the mesh file found and not empty.
pub(super) fn domain(
    checks: &Checks,
    file: &DomainFile,
    surfaces: &mut SurfaceFiles,
) -> Result<Domain, SceneError> {
    let given = [
        file.radius.is_some(),
        file.size.is_some(),
        file.file.is_some(),
        file.walls.is_some(),
        file.surface_kind.is_some(),
        file.scale.is_some(),
    ];
    if file.kind.is_none() && given.contains(&true) {
        return Err(checks.bad_value(
            "domain.kind",
            "is missing: say which domain is meant, such as kind = \"ball\"",
        ));
    }
    let radius = |kind: DomainKind| {
        let why = format!(": a {} needs a radius", kind.word());
        checks.required("domain.radius", file.radius, &why)
    };
    let kind = file.kind.unwrap_or_default();
    let is_surface = kind == DomainKind::Surface;
    checks.refuse_strangers(
        "domain",
        [
            ("surface_kind", file.surface_kind.is_some(), is_surface),
            ("scale", file.scale.is_some(), is_surface),
        ],
        "belongs to kind = \"surface\"; remove it or set the kind",
    )?;
    Ok(match kind {
        DomainKind::Unbounded => Domain::Unbounded,
        kind @ DomainKind::Ball => Domain::Ball {
            radius: radius(kind)?,
        },
        kind @ DomainKind::Cylinder => Domain::Cylinder {
            radius: radius(kind)?,
        },
        DomainKind::Wall => Domain::Wall,
        DomainKind::Box => Domain::Box {
            size: checks
                .required("domain.size", file.size, ": a box needs [x, y, z] lengths")?
                .into(),
        },
        DomainKind::Periodic => {
            let why = ": a periodic box needs [x, y, z] lengths";
            Domain::Periodic {
                size: checks.required("domain.size", file.size, why)?.into(),
            }
        }
        DomainKind::Surface => {
            let keys = SurfaceKeys {
                group: "domain",
                file: &file.file,
                kind: file.surface_kind,
                scale: file.scale,
            };
            Domain::Surface(surfaces.read(checks, keys)?)
        }
        DomainKind::Mesh => {
            let (path, walls) = (mesh_file(checks, file, surfaces)?, walls(checks, file)?);
            let facets = (surfaces.mesh(&path).ok()).and_then(|mesh| WallFacets::new(mesh, &walls));
            Domain::Mesh {
                file: path,
                walls,
                facets,
            }
        }
    })
}

/// Warnings about lengths and files of other domains, which have no effect on this one.
///
/// They are no errors: `--set domain.kind=unbounded` leaves the radius of a ball where it is.
pub(super) fn without_effect(document: &Document, file: &DomainFile) -> Vec<String> {
    let kind = file.kind.unwrap_or_default();
    let is_round = matches!(kind, DomainKind::Ball | DomainKind::Cylinder);
    let is_box = matches!(kind, DomainKind::Box | DomainKind::Periodic);
    let has_file = matches!(kind, DomainKind::Surface | DomainKind::Mesh);
    let keys = [
        ("radius", file.radius.is_some() && !is_round),
        ("size", file.size.is_some() && !is_box),
        ("file", file.file.is_some() && !has_file),
        ("walls", file.walls.is_some() && kind != DomainKind::Mesh),
    ];
    let warning = |(key, _): (&str, bool)| {
        let path = format!("domain.{key}");
        let place = document.place(&path);
        format!(
            "{place}: {path} has no effect on kind = \"{}\"",
            kind.word()
        )
    };
    let unused = keys.into_iter().filter(|(_, is_unused)| *is_unused);
    unused.map(warning).collect()
}

fn mesh_file(
    checks: &Checks,
    file: &DomainFile,
    files: &mut SurfaceFiles,
) -> Result<PathBuf, SceneError> {
    let key = "domain.file";
    let name = checks.required(key, file.file.as_ref(), ": a mesh needs a Gmsh file")?;
    let path = checks.0.path().parent().unwrap_or(Path::new("")).join(name);
    // The models read it again; here it is looked for, and its hash is taken.
    let bytes = (files.bytes(&path))
        .map_err(|error| checks.bad_value(key, format!("cannot be read: {error}")))?;
    if bytes.is_empty() {
        let problem = format!("names {}, which is empty; give a Gmsh mesh", path.display());
        return Err(checks.bad_value(key, problem));
    }
    Ok(path)
}

fn walls(checks: &Checks, file: &DomainFile) -> Result<Vec<String>, SceneError> {
    let key = "domain.walls";
    let walls = checks.required(key, file.walls.clone(), ": name the mesh's walls")?;
    if walls.is_empty() {
        let problem = "is empty: without a wall at rest the flow is not unique; name the walls";
        return Err(checks.bad_value(key, problem));
    }
    Ok(walls)
}
