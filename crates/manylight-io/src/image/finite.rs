//! Values of images that are not finite: bright pixels that overflowed, and results of 0/0.

use manylight::image::Image;
use std::fmt;

/// What was replaced in an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NotFinite {
    /// Values that were not numbers.
    not_numbers: usize,
    /// Values that were infinite.
    infinite: usize,
    /// Column and row of the first pixel with such a value.
    first: [usize; 2],
}

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [column, row] = self.first;
        write!(
            f,
            "{} values are not numbers and count as 0, {} are infinite and count as the largest finite value; the first is in column {column} of row {row}",
            self.not_numbers, self.infinite
        )
    }
}

/// Replaces values that are not numbers by 0, and infinite ones by the finite value of the largest
/// magnitude with their sign; `None` if all values are finite.
pub(crate) fn make_finite(image: &mut Image) -> Option<NotFinite> {
    let first = image.data.iter().position(|v| !v.is_finite())?;
    let finite = || image.data.iter().filter(|v| v.is_finite());
    let largest = finite().fold(0.0, |a: f32, v| a.max(*v));
    let smallest = finite().fold(0.0, |a: f32, v| a.min(*v));
    let pixel = first / image.channels.max(1);
    let mut found = NotFinite {
        not_numbers: 0,
        infinite: 0,
        first: [pixel % image.width.max(1), pixel / image.width.max(1)],
    };
    for v in &mut image.data[first..] {
        if v.is_nan() {
            found.not_numbers += 1;
            *v = 0.0;
        } else if v.is_infinite() {
            found.infinite += 1;
            *v = if *v > 0.0 { largest } else { smallest };
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn infinite_values_become_the_largest_finite_ones() {
        let image = |data: Vec<f32>| Image {
            width: 2,
            height: 2,
            channels: 1,
            data,
        };
        assert_eq!(make_finite(&mut image(vec![1.0; 4])), None);
        let mut broken = image(vec![3.0, -1.0, f32::NAN, f32::INFINITY]);
        let found = make_finite(&mut broken).unwrap();
        assert_eq!(broken.data, [3.0, -1.0, 0.0, 3.0]);
        assert!(found.to_string().starts_with("1 values are not numbers"));
        assert!(found.to_string().ends_with("column 0 of row 1"));
    }
}
