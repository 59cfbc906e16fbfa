//! Joins the divisions of chunks of a list to a division of the list.

use super::item_box::ItemBox;
use rayon::prelude::*;

/// Moves the first `counts[i]` items of every chunk `i` to the front of the list; returns their
/// number. The chunks have `chunk_size` items, the last one the rest.
pub(super) fn join_chunks(items: &mut [ItemBox], chunk_size: usize, counts: &[usize]) -> usize {
    let count = counts.iter().sum();
    let (front, back) = items.split_at_mut(count);
    // Items of the right side in front of the border, items of the left side behind it: as many.
    let (mut in_front, mut behind) = (Vec::new(), Vec::new());
    let (mut front, mut back) = ((0, front), (count, back));
    for (chunk, left) in counts.iter().enumerate() {
        let start = chunk * chunk_size;
        let end = start + chunk_size;
        in_front.extend(take(&mut front, start + left, end));
        behind.extend(take(&mut back, start, start + left));
    }
    exchange(in_front, behind);
    count
}

/// Takes the part `from..to` out of a list, up to its end, where the list begins at the first
/// index. Drops what comes before.
fn take<'a>(
    list: &mut (usize, &'a mut [ItemBox]),
    from: usize,
    to: usize,
) -> Option<&'a mut [ItemBox]> {
    let (first, items) = std::mem::take(list);
    let skipped = from.saturating_sub(first).min(items.len());
    let (_, items) = items.split_at_mut(skipped);
    let first = first + skipped;
    let (taken, rest) = items.split_at_mut(to.saturating_sub(first).min(items.len()));
    *list = (first + taken.len(), rest);
    (!taken.is_empty()).then_some(taken)
}

/// Exchanges two lists of runs with equal numbers of items.
fn exchange(a: Vec<&mut [ItemBox]>, b: Vec<&mut [ItemBox]>) {
    let (mut a, mut b) = (a.into_iter(), b.into_iter());
    let (mut x, mut y): (&mut [ItemBox], &mut [ItemBox]) = (&mut [], &mut []);
    let mut pairs = Vec::new();
    loop {
        if x.is_empty() {
            x = a.next().unwrap_or_default();
        }
        if y.is_empty() {
            y = b.next().unwrap_or_default();
        }
        let count = x.len().min(y.len());
        if count == 0 {
            break;
        }
        let p = std::mem::take(&mut x).split_at_mut(count);
        let q = std::mem::take(&mut y).split_at_mut(count);
        pairs.push((p.0, q.0));
        (x, y) = (p.1, q.1);
    }
    pairs
        .into_par_iter()
        .for_each(|(p, q)| p.swap_with_slice(q));
}
