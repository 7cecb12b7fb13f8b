//! Values grouped by small numbers, in compressed rows.

/// Values with the keys `0..n_keys`, those of one key next to each other.
///
/// ```
/// let around = mesh::Grouped::new(3, || [(2, 'a'), (0, 'b'), (2, 'c')].into_iter());
/// assert_eq!((around.of(0), around.of(1), around.of(2)), (&['b'][..], &[][..], &['a', 'c'][..]));
/// ```
#[derive(Clone, Debug)]
pub struct Grouped<T> {
    /// The values of key `k` are `starts[k]..starts[k + 1]`.
    starts: Vec<usize>,
    values: Vec<T>,
}

impl<T: Copy + Default> Grouped<T> {
    /// Groups `(key, value)` pairs; the values of each key are in order of arrival. Cost: O(n).
    ///
    /// # Panics
    /// If a key is not below `n_keys`.
    pub fn new<I: Iterator<Item = (u32, T)>>(n_keys: usize, pairs: impl Fn() -> I) -> Self {
        let mut starts = vec![0; n_keys + 1];
        for (key, _) in pairs() {
            starts[key as usize + 1] += 1;
        }
        for k in 0..n_keys {
            starts[k + 1] += starts[k];
        }
        let mut next = starts.clone();
        let mut values = vec![T::default(); starts[n_keys]];
        for (key, value) in pairs() {
            values[next[key as usize]] = value;
            next[key as usize] += 1;
        }
        Self { starts, values }
    }

    /// Number of keys.
    pub fn n_keys(&self) -> usize {
        self.starts.len() - 1
    }

    /// The values of a key.
    ///
    /// # Panics
    /// If there is no such key.
    #[inline]
    pub fn of(&self, key: u32) -> &[T] {
        &self.values[self.starts[key as usize]..self.starts[key as usize + 1]]
    }

    /// The values of a key, which may be changed.
    ///
    /// # Panics
    /// If there is no such key.
    pub fn of_mut(&mut self, key: u32) -> &mut [T] {
        &mut self.values[self.starts[key as usize]..self.starts[key as usize + 1]]
    }
}
