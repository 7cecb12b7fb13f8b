//! Links between bodies, and the connected sets (linkages) that they form.

/// A link of prescribed length between the centres of two bodies.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Link {
    /// Name, for messages.
    pub name: String,
    /// The body at the far end: a growing length moves it away from `to`.
    pub body: usize,
    /// The body at the near end.
    pub to: usize,
}

/// A connected set of bodies: while no length changes, it moves as one rigid frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Linkage {
    /// The body at the origin of the frame: the one with the lowest index.
    pub root: usize,
    /// All bodies of the set in breadth-first order, the root first.
    pub bodies: Vec<usize>,
    /// Edges of the spanning tree, one for each body after the root, in the order of `bodies`.
    pub(crate) tree: Vec<TreeEdge>,
}

/// An edge of the spanning tree of a linkage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TreeEdge {
    pub link: usize,
    pub parent: usize,
    pub child: usize,
}

/// Breadth-first spanning trees of the graph of bodies and links, rooted at the lowest indices.
pub(crate) fn find_linkages(bodies: usize, links: &[Link]) -> Vec<Linkage> {
    let mut neighbours = vec![Vec::new(); bodies];
    for (number, link) in links.iter().enumerate() {
        neighbours[link.body].push((number, link.to));
        neighbours[link.to].push((number, link.body));
    }
    let mut reached = vec![false; bodies];
    let mut linkages = Vec::new();
    for root in 0..bodies {
        if reached[root] {
            continue;
        }
        reached[root] = true;
        let mut linkage = Linkage {
            root,
            bodies: vec![root],
            tree: Vec::new(),
        };
        let mut next = 0;
        while let Some(&parent) = linkage.bodies.get(next) {
            next += 1;
            for &(link, child) in &neighbours[parent] {
                if !reached[child] {
                    reached[child] = true;
                    linkage.bodies.push(child);
                    linkage.tree.push(TreeEdge {
                        link,
                        parent,
                        child,
                    });
                }
            }
        }
        linkages.push(linkage);
    }
    linkages
}
