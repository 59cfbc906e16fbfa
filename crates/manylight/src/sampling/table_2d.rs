//! A piecewise-constant density on the unit square.

use super::alias::Alias;
use crate::math::Vec2;

/// A density on [0, 1]² that is constant on each cell of a `width` x `height` grid.
#[derive(Clone, Debug)]
pub struct Table2d {
    width: usize,
    height: usize,
    density: Vec<f32>,
    rows: Alias,
    /// Row by row; empty for rows without weight.
    columns: Vec<Alias>,
}

impl Table2d {
    /// Density proportional to `weights` (row-major, all >= 0). `None` if none is positive.
    pub fn new(weights: &[f32], width: usize, height: usize) -> Option<Self> {
        let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        if !(total.is_finite() && total > 0.0) {
            return None;
        }
        let cells = (width * height) as f64;
        let row_sums: Vec<f32> = weights
            .chunks_exact(width)
            .map(|row| row.iter().map(|&w| f64::from(w)).sum::<f64>() as f32)
            .collect();
        let columns = weights
            .chunks_exact(width)
            .map(|row| Alias::new(row).unwrap_or_default())
            .collect();
        let rows = Alias::new(&row_sums)?;
        let density = weights
            .iter()
            .map(|&w| (f64::from(w) / total * cells) as f32)
            .collect();
        Some(Table2d {
            width,
            height,
            density,
            rows,
            columns,
        })
    }

    /// A point and its density.
    #[inline]
    pub fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let (row, fy) = self.rows.sample_reusing(u.y);
        let (column, fx) = self.columns[row].sample_reusing(u.x);
        let p = Vec2::new(
            (column as f32 + fx) / self.width as f32,
            (row as f32 + fy) / self.height as f32,
        );
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
