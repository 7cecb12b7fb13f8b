//! Nodes and elements of MSH 2.

use super::gather::{Gather, Group, Kind};
use super::scan::{Encoding, Scanner};
use crate::{MeshError, Vec3};

/// Reads `$Nodes`: a count (text in binary files too), then tag and coordinates of each node.
pub(super) fn nodes(scanner: &mut Scanner, gather: &mut Gather) -> Result<(), MeshError> {
    let count = counted(scanner, "nodes", 4)?;
    gather.reserve_nodes(scanner, count)?;
    for _ in 0..count {
        let tag = node_tag(scanner)?;
        gather.add_node(
            tag,
            Vec3::new(scanner.real()?, scanner.real()?, scanner.real()?),
        );
    }
    gather.finish_nodes(scanner)
}

/// Reads `$Elements`: a count, then each element with its type and tags (text) or blocks of
/// elements of one type (binary).
pub(super) fn elements(scanner: &mut Scanner, gather: &mut Gather) -> Result<(), MeshError> {
    gather.need_nodes(scanner)?;
    let count = counted(scanner, "elements", 2)?;
    let mut read = 0;
    while read < count {
        if scanner.encoding == Encoding::Text {
            scanner.int()?;
            let kind = Kind::read(scanner)?;
            let n_tags = scanner.int()?;
            element(scanner, gather, kind, n_tags)?;
            read += 1;
            continue;
        }
        let kind = Kind::read(scanner)?;
        let in_block = scanner.int()?;
        if in_block < 1 || in_block as usize > count - read {
            return scanner.error(format!(
                "a block of {in_block} elements, although only {} of {count} are left",
                count - read
            ));
        }
        let n_tags = scanner.int()?;
        for _ in 0..in_block {
            scanner.int()?;
            element(scanner, gather, kind, n_tags)?;
        }
        read += in_block as usize;
    }
    Ok(())
}

/// Reads tags and nodes of an element.
///
/// Tags are the physical group, the geometric entity, and partitions, which are skipped.
fn element(
    scanner: &mut Scanner,
    gather: &mut Gather,
    kind: Kind,
    n_tags: i32,
) -> Result<(), MeshError> {
    let mut tags = [0; 2];
    for i in 0..n_tags {
        let tag = scanner.int()?;
        if let Some(slot) = tags.get_mut(i as usize) {
            *slot = tag;
        }
    }
    // Group 0 means "no group"; the number of a group of reversed faces is negative.
    let group = match tags {
        [0, entity] => Group::Entity(entity),
        [physical, _] => Group::Physical(physical.saturating_abs()),
    };
    gather.read_element(scanner, kind, group, node_tag)
}

/// Reads the count of a section and checks that its items fit into the file.
fn counted(scanner: &mut Scanner, what: &str, numbers: u64) -> Result<usize, MeshError> {
    let count = scanner.number()?;
    let count = scanner.fits(what, count, numbers)?;
    scanner.line();
    Ok(count)
}

/// Reads a node tag, which is an `int` in version 2.
fn node_tag(scanner: &mut Scanner) -> Result<u64, MeshError> {
    let tag = scanner.int()?;
    match u64::try_from(tag) {
        Ok(tag) => Ok(tag),
        Err(_) => scanner.error(format!("the node number {tag} is negative")),
    }
}
