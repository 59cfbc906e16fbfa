//! Lists that are joined from runs of different lengths.

use rayon::prelude::*;

/// Where the runs of a joined list begin.
pub(super) struct Runs {
    /// Element `i` is the first index of run `i`, the last the length of the list.
    first: Vec<usize>,
}

impl Runs {
    /// Runs of these lengths, in this order.
    pub(super) fn new(lengths: impl Iterator<Item = usize>) -> Self {
        let mut first = vec![0];
        let mut end = 0;
        first.extend(lengths.map(|length| {
            end += length;
            end
        }));
        Runs { first }
    }

    /// Length of the list.
    pub(super) fn len(&self) -> usize {
        self.first[self.first.len() - 1]
    }

    /// First index of a run.
    pub(super) fn first(&self, run: usize) -> usize {
        self.first[run]
    }

    /// `element(run, i)` for each element `i` of each run, in parallel.
    pub(super) fn par_map<T: Send>(
        &self,
        element: impl Fn(usize, usize) -> T + Sync + Send,
    ) -> impl IndexedParallelIterator<Item = T> {
        self.par_groups(move |[(run, i)]| element(run, i))
    }

    /// `group` of the runs and places of `N` elements after another, in parallel. The last group
    /// repeats the last element.
    pub(super) fn par_groups<const N: usize, T: Send>(
        &self,
        group: impl Fn([(usize, usize); N]) -> T + Sync + Send,
    ) -> impl IndexedParallelIterator<Item = T> {
        /// Elements per task: smaller tasks cost more to distribute than to fill.
        const SMALL: usize = 1 << 11;
        let groups = (0..self.len().div_ceil(N)).into_par_iter();
        groups.with_min_len(SMALL / N).map_init(
            || 0,
            move |near, first| {
                group(std::array::from_fn(|k| {
                    self.find(near, (first * N + k).min(self.len() - 1))
                }))
            },
        )
    }

    /// The run of an element, and its place there. The search begins at the run `near`, which
    /// becomes the one that was found.
    #[inline]
    fn find(&self, near: &mut usize, index: usize) -> (usize, usize) {
        if !(self.first[*near]..self.first[*near + 1]).contains(&index) {
            *near = self.first.partition_point(|&first| first <= index) - 1;
        }
        (*near, index - self.first[*near])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_joined_in_order() {
        let lengths = [0, 3, 0, 0, 5000, 1, 0, 2501, 0];
        let runs = Runs::new(lengths.into_iter());
        let joined: Vec<(usize, usize)> = runs.par_map(|run, i| (run, i)).collect();
        let expected = lengths.iter().enumerate();
        let expected = expected.flat_map(|(run, &length)| (0..length).map(move |i| (run, i)));
        assert!(joined.into_iter().eq(expected));
        let groups: Vec<[(usize, usize); 16]> = runs.par_groups(|group| group).collect();
        assert_eq!((groups[0][3], groups[469]), ((4, 0), [(7, 2500); 16]));
        assert_eq!((runs.first(4), runs.first(7), runs.len()), (3, 5004, 7505));
        assert_eq!(Runs::new(std::iter::empty()).par_map(|_, i| i).count(), 0);
    }
}
