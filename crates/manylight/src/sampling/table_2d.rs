//! A piecewise-constant density on the unit square.

use crate::math::Vec2;

/// A density on [0, 1]² that is constant on each cell of a `width` x `height` grid.
#[derive(Clone, Debug)]
pub struct Table2d {
    width: usize,
    height: usize,
    density: Vec<f32>,
    rows: Cumulative,
    columns: Vec<Cumulative>,
}

impl Table2d {
    /// Density proportional to `weights` (row-major, all >= 0). `None` if none is positive.
    pub fn new(weights: &[f32], width: usize, height: usize) -> Option<Self> {
        let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        if !(total.is_finite() && total > 0.0) {
            return None;
        }
        let cells = (width * height) as f64;
        let row_sums: Vec<f64> =
            weights.chunks_exact(width).map(|row| row.iter().map(|&w| f64::from(w)).sum()).collect();
        let columns = weights.chunks_exact(width).map(|row| Cumulative::new(row.iter().map(|&w| w.into()))).collect();
        let rows = Cumulative::new(row_sums.into_iter());
        let density = weights.iter().map(|&w| (f64::from(w) / total * cells) as f32).collect();
        Some(Table2d { width, height, density, rows, columns })
    }

    /// A point and its density.
    #[inline]
    pub fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let (row, fy) = self.rows.pick(u.y);
        let (column, fx) = self.columns[row].pick(u.x);
        let p = Vec2::new((column as f32 + fx) / self.width as f32, (row as f32 + fy) / self.height as f32);
        (p, self.density[row * self.width + column])
    }

    /// Density at `p`.
    #[inline]
    pub fn pdf(&self, p: Vec2) -> f32 {
        let column = ((p.x * self.width as f32) as usize).min(self.width - 1);
        let row = ((p.y * self.height as f32) as usize).min(self.height - 1);
        self.density[row * self.width + column]
    }
}

/// Running sums over a line of cells, with a guide that makes lookups constant-time on average.
/// Source: Chen and Asau, "On Generating Random Variates from an Empirical Distribution", 1974.
#[derive(Clone, Debug)]
struct Cumulative {
    /// One more than cells; from 0 to 1, or all 0 where no cell has weight.
    sums: Vec<f32>,
    /// Per k of n cells: the cell that k / n falls into.
    guide: Vec<u32>,
}

impl Cumulative {
    fn new(weights: impl Iterator<Item = f64> + Clone) -> Self {
        let total: f64 = weights.clone().sum();
        let mut running = 0.0;
        let mut sums = vec![0.0];
        sums.extend(weights.map(|w| {
            running += w;
            if total > 0.0 { (running / total) as f32 } else { 0.0 }
        }));
        let cells = sums.len() - 1;
        let mut cell = 0;
        let guide = (0..cells).map(|k| {
            let u = k as f32 / cells as f32;
            while cell + 1 < cells && sums[cell + 1] <= u {
                cell += 1;
            }
            cell as u32
        });
        let guide = guide.collect();
        Cumulative { sums, guide }
    }

    /// The cell that `u` falls into and where inside it.
    #[inline]
    fn pick(&self, u: f32) -> (usize, f32) {
        let cells = self.guide.len();
        let mut i = self.guide[((u * cells as f32) as usize).min(cells - 1)] as usize;
        // The product may have been rounded up into the next entry.
        while i > 0 && self.sums[i] > u {
            i -= 1;
        }
        while i + 1 < cells && self.sums[i + 1] <= u {
            i += 1;
        }
        let width = self.sums[i + 1] - self.sums[i];
        (i, if width > 0.0 { ((u - self.sums[i]) / width).min(1.0 - f32::EPSILON) } else { 0.5 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_follow_the_density() {
        let weights = [1.0, 0.0, 3.0, 2.0, 0.0, 2.0];
        let table = Table2d::new(&weights, 3, 2).unwrap();
        let n = 200;
        let mut counts = [0; 6];
        for i in 0..n * n {
            let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let (p, pdf) = table.sample(u);
            assert_eq!(pdf, table.pdf(p));
            counts[(p.y * 2.0) as usize * 3 + (p.x * 3.0) as usize] += 1;
        }
        for (count, weight) in counts.iter().zip(weights) {
            assert!((*count as f32 / (n * n) as f32 - weight / 8.0).abs() < 5e-3);
        }
    }
}
