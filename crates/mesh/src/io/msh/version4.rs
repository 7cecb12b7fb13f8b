//! Entities, nodes and elements of MSH 4.1.

use std::collections::HashMap;

use super::gather::{Gather, Group, Kind};
use super::scan::Scanner;
use crate::{MeshError, Vec3};

/// Physical groups of each geometric surface and volume, by dimension and tag.
///
/// `None` if the file has no `$Entities`.
pub(super) type EntityGroups = Option<HashMap<(i32, i32), Vec<i32>>>;

/// Reads `$Entities`: points, curves, surfaces and volumes.
///
/// Only the physical groups of surfaces and volumes are kept.
pub(super) fn entities(scanner: &mut Scanner) -> Result<EntityGroups, MeshError> {
    let mut groups = HashMap::new();
    // An entity has a tag, a position (points) or bounding box, and one or two counts.
    const NUMBERS: [u64; 4] = [5, 9, 9, 9];
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = scanner.size()?;
    }
    for dimension in 0..4 {
        scanner.fits("entities", counts[dimension], NUMBERS[dimension])?;
        for _ in 0..counts[dimension] {
            let entity = scanner.int()?;
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                scanner.real()?;
            }
            let of_entity = ints(scanner, "physical groups")?;
            if dimension > 0 {
                ints(scanner, "bounding entities")?;
            }
            if dimension >= 2 {
                groups.insert((dimension as i32, entity), of_entity);
            }
        }
    }
    Ok(Some(groups))
}

/// Reads a count and as many `int`s.
fn ints(scanner: &mut Scanner, what: &str) -> Result<Vec<i32>, MeshError> {
    let count = scanner.size()?;
    let count = scanner.fits(what, count, 1)?;
    (0..count).map(|_| scanner.int()).collect()
}

/// Reads `$Nodes`: blocks of nodes on one entity, first their tags, then their coordinates.
pub(super) fn nodes(scanner: &mut Scanner, gather: &mut Gather) -> Result<(), MeshError> {
    let [blocks, total, lowest, highest] = header(scanner)?;
    let total = scanner.fits("nodes", total, 4)?;
    gather.reserve_nodes(scanner, total)?;
    let mut read = 0;
    for _ in 0..blocks {
        let dimension = scanner.int()?;
        let _entity = scanner.int()?;
        let parametric = scanner.int()? != 0;
        let count = scanner.size()?;
        let count = in_block(scanner, "nodes", count, total - read)?;
        let tags: Vec<u64> = (0..count)
            .map(|_| scanner.size())
            .collect::<Result<_, _>>()?;
        if let Some(tag) = tags.iter().find(|&tag| !(lowest..=highest).contains(tag)) {
            return scanner.error(format!(
                "node {tag} is outside the range {lowest} to {highest} announced by $Nodes"
            ));
        }
        for tag in tags {
            gather.add_node(
                tag,
                Vec3::new(scanner.real()?, scanner.real()?, scanner.real()?),
            );
            if parametric {
                for _ in 0..dimension {
                    scanner.real()?;
                }
            }
        }
        read += count;
    }
    if read != total {
        return scanner.error(format!(
            "$Nodes announces {total} nodes, but its blocks have {read}"
        ));
    }
    gather.finish_nodes(scanner)
}

/// Reads `$Elements`: blocks of elements of one type on one entity.
pub(super) fn elements(
    scanner: &mut Scanner,
    gather: &mut Gather,
    groups: &EntityGroups,
) -> Result<(), MeshError> {
    gather.need_nodes(scanner)?;
    let [blocks, total, ..] = header(scanner)?;
    let total = scanner.fits("elements", total, 2)?;
    let mut read = 0;
    for _ in 0..blocks {
        let _dimension = scanner.int()?;
        let entity = scanner.int()?;
        let kind = Kind::read(scanner)?;
        let group = match kind {
            Kind::Triangle { .. } => surface_group(scanner, entity, groups)?,
            Kind::Tet { .. } => volume_group(entity, groups),
            Kind::Skip { .. } => Group::Entity(entity),
        };
        let count = scanner.size()?;
        let count = in_block(scanner, "elements", count, total - read)?;
        for _ in 0..count {
            scanner.size()?;
            gather.read_element(scanner, kind, group, Scanner::size)?;
        }
        read += count;
    }
    if read != total {
        return scanner.error(format!(
            "$Elements announces {total} elements, but its blocks have {read}"
        ));
    }
    Ok(())
}

/// Number of blocks, number of items, lowest and highest tag.
fn header(scanner: &mut Scanner) -> Result<[u64; 4], MeshError> {
    let header = [
        scanner.size()?,
        scanner.size()?,
        scanner.size()?,
        scanner.size()?,
    ];
    // Each block begins with four numbers.
    scanner.fits("blocks", header[0], 4)?;
    Ok(header)
}

/// The number of items in a block, if no more than `to_come`.
fn in_block(scanner: &Scanner, what: &str, count: u64, to_come: usize) -> Result<usize, MeshError> {
    if count <= to_come as u64 {
        return Ok(count as usize);
    }
    scanner.error(format!(
        "a block of {count} {what}, although only {to_come} are left"
    ))
}

/// The physical group of a surface, which must be in one at most.
fn surface_group(
    scanner: &Scanner,
    entity: i32,
    groups: &EntityGroups,
) -> Result<Group, MeshError> {
    let Some(groups) = groups else {
        return Ok(Group::Entity(entity));
    };
    match groups.get(&(2, entity)).map(Vec::as_slice) {
        Some([]) => Ok(Group::Entity(entity)),
        // The number of a group of reversed faces is negative.
        Some([physical]) => Ok(Group::Physical(physical.saturating_abs())),
        Some(several) => scanner.error(format!(
            "surface {entity} is in the physical groups {several:?}; keep it in one only"
        )),
        None => scanner.error(format!(
            "triangles on surface {entity}, which is missing in $Entities"
        )),
    }
}

/// The first physical group of a volume; volumes may be in several.
fn volume_group(entity: i32, groups: &EntityGroups) -> Group {
    let of_volume = groups.as_ref().and_then(|groups| groups.get(&(3, entity)));
    match of_volume.and_then(|of_volume| of_volume.first()) {
        Some(physical) => Group::Physical(physical.saturating_abs()),
        None => Group::Entity(entity),
    }
}
