//! Groups of numbers that are connected by pairs.

/// The numbers below some `n`, divided into groups.
pub(super) struct Groups {
    /// The group of each number.
    group: Vec<u32>,
    /// The numbers of all groups, one group after the other.
    members: Vec<u32>,
    starts: Vec<usize>,
}

impl Groups {
    /// Groups of the numbers below `n` that are connected by chains of pairs.
    pub fn new(n: usize, pairs: &[[usize; 2]]) -> Self {
        let mut parent: Vec<usize> = (0..n).collect();
        fn root(parent: &mut [usize], mut k: usize) -> usize {
            while parent[k] != k {
                parent[k] = parent[parent[k]];
                k = parent[k];
            }
            k
        }
        for &[a, b] in pairs {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            parent[a.max(b)] = a.min(b);
        }
        // The root is the smallest number of its group, so it is numbered first.
        let mut group = vec![0; n];
        let mut starts = vec![0];
        for k in 0..n {
            let root = root(&mut parent, k);
            if root == k {
                group[k] = starts.len() as u32 - 1;
                starts.push(0);
            } else {
                group[k] = group[root];
            }
            starts[group[k] as usize + 1] += 1;
        }
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        let mut next = starts.clone();
        let mut members = vec![0; n];
        for (k, group) in group.iter().enumerate() {
            let slot = &mut next[*group as usize];
            members[*slot] = k as u32;
            *slot += 1;
        }
        Self {
            group,
            members,
            starts,
        }
    }

    /// Number of groups.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The group of a number.
    pub fn number(&self, k: usize) -> usize {
        self.group[k] as usize
    }

    /// The members of a group, ascending.
    pub fn of(&self, group: usize) -> &[u32] {
        &self.members[self.starts[group]..self.starts[group + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_of_pairs_are_groups() {
        let groups = Groups::new(7, &[[5, 2], [6, 5], [1, 0]]);
        let all: Vec<&[u32]> = (0..groups.len()).map(|k| groups.of(k)).collect();
        assert_eq!(all, [&[0, 1][..], &[2, 5, 6], &[3], &[4]]);
        assert!((0..7).all(|k| groups.of(groups.number(k)).contains(&(k as u32))));
    }
}
