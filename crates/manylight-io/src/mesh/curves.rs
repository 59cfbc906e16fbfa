//! Text files of curves, as Mitsuba's `linearcurve` and `bsplinecurve` read them: a control point
//! on each line, as position and radius, and an empty line between curves.

use super::text::Cursor;
use crate::file_error::{Fault, FileError, read_bytes};
use crate::gzip::unpacked;
use manylight::math::Vec4;
use std::path::Path;

/// Reads the curves of a file: for each the control points, with the radius as fourth component.
/// Every curve has at least `least` points.
///
/// # Errors
/// The file cannot be read or is malformed; the error gives line and column.
pub fn read_curves(path: &Path, least: usize) -> Result<Vec<Vec<Vec4>>, FileError> {
    let parsed = unpacked(read_bytes(path)?).and_then(|bytes| parse(&bytes, least));
    parsed.map_err(|fault| fault.in_file(path))
}

fn parse(bytes: &[u8], least: usize) -> Result<Vec<Vec<Vec4>>, Fault> {
    let mut cursor = Cursor::new(bytes, 1);
    let mut curves: Vec<Vec<Vec4>> = Vec::new();
    let mut curve: Vec<Vec4> = Vec::new();
    loop {
        cursor.skip_spaces();
        if cursor.at_end() || cursor.at_line_end() {
            if !curve.is_empty() && curve.len() < least {
                let message = format!(
                    "a curve with {} control points ends here, expected at least {least}",
                    curve.len()
                );
                return Err(cursor.fault(message));
            }
            if !curve.is_empty() {
                curves.push(std::mem::take(&mut curve));
            }
            if cursor.at_end() {
                break;
            }
        } else {
            curve.push(control_point(&mut cursor)?);
        }
        cursor.next_line();
    }
    if curves.is_empty() {
        return Err(cursor.expected("a control point: x, y, z and radius"));
    }
    Ok(curves)
}

fn control_point(cursor: &mut Cursor) -> Result<Vec4, Fault> {
    let mut values = [0.0_f32; 4];
    for (i, value) in values.iter_mut().enumerate() {
        cursor.skip_spaces();
        let start = *cursor;
        *value = cursor.number()? as f32;
        if !value.is_finite() || i == 3 && *value < 0.0 {
            let expected = if i == 3 {
                "a radius of at least 0"
            } else {
                "a finite number"
            };
            return Err(start.expected(expected));
        }
    }
    Ok(Vec4::from(values))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        format!("{:?}", parse(text.as_bytes(), 2).unwrap_err())
    }

    #[test]
    fn empty_lines_separate_curves() {
        let curves = parse(b"\n0 0 0 1\n1 0 0 .5\r\n\n\n 1 2 3 4\n5 6 7 8e-1", 2).unwrap();
        assert_eq!(curves.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2]);
        assert_eq!(curves[1][1], Vec4::new(5.0, 6.0, 7.0, 0.8));
    }

    #[test]
    fn errors_name_what_was_expected() {
        assert!(message("0 0 0\n1 0 0 1").contains("expected a number"));
        assert!(message("0 0 0 -1\n1 0 0 1").contains("a radius of at least 0"));
        assert!(message("0 0 inf 1\n1 0 0 1").contains("a finite number"));
        assert!(message("0 0 0 1\n\n1 0 0 1").contains("expected at least 2"));
        assert!(message(" \n").contains("a control point"));
    }
}
