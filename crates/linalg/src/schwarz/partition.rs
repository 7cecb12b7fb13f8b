//! Overlapping subdomains in the graph of velocity nodes and pressures.

use super::subdomain::Members;
use super::{BorderPlacement, SchwarzParams};
use crate::csr::check_shape;
use crate::direct::{Graph, adjacency, weights};
use crate::{LinalgError, SaddleSystem};

/// Largest number of subdomains: more than the cores of any machine.
///
/// Some may be empty, but each takes memory.
const MAX_SUBDOMAINS: usize = 1 << 16;

/// Partitions by METIS into parts of about equal size and extends each by layers of neighbours.
///
/// A subdomain then includes all velocities of its pressures, so that their rows of the divergence
/// are complete. The local problems are therefore saddle-point problems with zero velocity on the
/// boundary of the subdomain, and none has more pressures than its velocities can satisfy.
///
/// # Errors
/// [`LinalgError::Parameter`] for a number of subdomains out of range or a border dof assigned to a
/// missing one, [`LinalgError::Shape`], and those of METIS.
pub(super) fn cut(
    system: &SaddleSystem,
    params: &SchwarzParams,
) -> Result<Vec<Members>, LinalgError> {
    let parts = params.subdomains;
    if !(1..=MAX_SUBDOMAINS).contains(&parts) {
        return Err(LinalgError::Parameter {
            name: "subdomains",
            value: parts as f64,
            range: "from 1 to 65536",
        });
    }
    if let BorderPlacement::Assigned(to) = &params.border {
        let m = system.border_range().len();
        check_shape("assignment of the border", (to.len(), 1), (m, 1))?;
        if let Some(&outside) = to.iter().find(|&&s| s >= parts) {
            return Err(LinalgError::Parameter {
                name: "subdomain of a border dof",
                value: outside as f64,
                range: "below the number of subdomains",
            });
        }
    }
    let neighbours = adjacency(system);
    let part = Graph::new(&neighbours, &weights(system))?.partition(parts)?;
    let nodes = system.velocity_block().nodes();
    let members = |subdomain: usize| {
        let mut inside: Vec<bool> = part.iter().map(|&p| p == subdomain).collect();
        let mut rim: Vec<u32> = (0..part.len() as u32)
            .filter(|&v| inside[v as usize])
            .collect();
        for layer in 0..=params.overlap {
            if rim.is_empty() {
                break;
            }
            // the last layer adds only the velocities of pressures
            let from_all = layer < params.overlap;
            let mut next = Vec::new();
            for &v in rim.iter().filter(|&&v| from_all || v as usize >= nodes) {
                for &w in &neighbours[v as usize] {
                    if !std::mem::replace(&mut inside[w as usize], true) {
                        next.push(w);
                    }
                }
            }
            rim = next;
        }
        let all = || (0..part.len() as u32).filter(|&v| inside[v as usize]);
        let border = match &params.border {
            BorderPlacement::Eliminated => Vec::new(),
            BorderPlacement::Assigned(to) => (0..to.len() as u32)
                .filter(|&c| to[c as usize] == subdomain)
                .collect(),
        };
        Members {
            nodes: all().filter(|&v| (v as usize) < nodes).collect(),
            pressures: all()
                .filter(|&v| v as usize >= nodes)
                .map(|v| v - nodes as u32)
                .collect(),
            owned: all().map(|v| part[v as usize] == subdomain).collect(),
            border,
        }
    };
    Ok((0..parts).map(members).collect())
}
