//! The cameras of a walkthrough: a JSON list of matrices.

use crate::error::{Diagnostic, LoadError, LoadErrorKind, Location, Severity};
use crate::read::read_regular;
use crate::source_text::SourceText;
use manylight::math::{Affine3A, Mat4, Vec4};
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use std::fmt;
use std::path::Path;
use std::sync::Arc;

/// The matrices from the camera to the world in the JSON file `path`, frame by frame. A matrix is a
/// list of four rows, or of 16 numbers row by row. Its last row is 0 0 0 1. As in Mitsuba, a camera
/// looks along +z, with +y up and +x to the left.
///
/// # Errors
/// The file cannot be read, is no such list, or has no matrix.
pub fn read_camera_path(path: &Path) -> Result<Vec<Affine3A>, LoadError> {
    let bytes = read_regular(path).map_err(|error| {
        let message = format!("cannot read the camera path: {error}");
        problem(
            LoadErrorKind::FileSystem,
            "cameras::unreadable",
            message,
            None,
        )
    })?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        let message = format!("the camera path is not UTF-8: invalid byte at offset {offset}");
        problem(LoadErrorKind::Scene, "cameras::malformed", message, None)
    })?;
    let matrices: Result<Vec<CameraMatrix>, _> = serde_json::from_str(&text);
    let (what, line, column) = match matrices {
        Ok(matrices) if !matrices.is_empty() => {
            return Ok(matrices.into_iter().map(|matrix| matrix.0).collect());
        }
        Ok(_) => ("found no camera".to_owned(), 1, 1),
        Err(error) => {
            let text = error.to_string();
            let what = text
                .split(" at line ")
                .next()
                .unwrap_or_default()
                .to_owned();
            (what, error.line(), error.column())
        }
    };
    let before: usize = text
        .split_inclusive('\n')
        .take(line.saturating_sub(1))
        .map(str::len)
        .sum();
    let at = (before + column.saturating_sub(1)).min(text.len());
    let source = Arc::new(SourceText::new(path, text.into()));
    let location = Location::new(path, &source, at..at, "here".into());
    let message = format!("in the camera path: {what}");
    Err(problem(
        LoadErrorKind::Scene,
        "cameras::malformed",
        message,
        Some(location),
    ))
}

fn problem(
    kind: LoadErrorKind,
    code: &'static str,
    message: String,
    location: Option<Location>,
) -> LoadError {
    Diagnostic {
        severity: Severity::Error,
        kind,
        code,
        message,
        location,
        help: Some(
            "expected a JSON list of matrices from the camera to the world, four rows each".into(),
        ),
    }
    .into()
}

/// A matrix from the camera to the world.
struct CameraMatrix(Affine3A);

impl<'de> Deserialize<'de> for CameraMatrix {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_seq(RowsOrNumbers)
    }
}

struct RowsOrNumbers;

impl<'de> Visitor<'de> for RowsOrNumbers {
    type Value = CameraMatrix;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a matrix of four rows or 16 numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<CameraMatrix, A::Error> {
        let mut numbers = Vec::with_capacity(16);
        while let Some(part) = values.next_element()? {
            match part {
                Part::Number(number) => numbers.push(number),
                Part::Row(row) => numbers.extend(row),
            }
            if numbers.len() > 16 {
                return Err(A::Error::custom("found more than 16 numbers in a matrix"));
            }
        }
        let found = numbers.len();
        let numbers: [f32; 16] = numbers.try_into().map_err(|_| {
            A::Error::custom(format!("found {found} numbers in a matrix, expected 16"))
        })?;
        let matrix = Mat4::from_cols_array(&numbers).transpose();
        if matrix.row(3) != Vec4::W {
            let [x, y, z, w] = matrix.row(3).to_array();
            return Err(A::Error::custom(format!(
                "found the last row {x} {y} {z} {w} of a matrix, expected 0 0 0 1"
            )));
        }
        Ok(CameraMatrix(Affine3A::from_mat4(matrix)))
    }
}

/// An element of a matrix.
enum Part {
    Number(f32),
    Row([f32; 4]),
}

impl<'de> Deserialize<'de> for Part {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(RowOrNumber)
    }
}

struct RowOrNumber;

impl<'de> Visitor<'de> for RowOrNumber {
    type Value = Part;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number, or a row of four numbers")
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Part, E> {
        Ok(Part::Number(number as f32))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Part, E> {
        self.visit_f64(number as f64)
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Part, E> {
        self.visit_f64(number as f64)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, row: A) -> Result<Part, A::Error> {
        Deserialize::deserialize(SeqAccessDeserializer::new(row)).map(Part::Row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use manylight::math::Vec3;

    fn read(text: &str) -> Result<Vec<Affine3A>, LoadError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("walk.json");
        std::fs::write(&path, text).unwrap();
        read_camera_path(&path)
    }

    #[test]
    fn a_matrix_is_four_rows_or_their_numbers() {
        let rows = "[[[1,0,0,5],[0,1,0,-6.5],[0,0,1,7e0],[0,0,0,1]]]";
        let numbers =
            "[ [1,0,0,5, 0,1,0,-6.5, 0,0,1,7, 0,0,0,1],\n[1,0,0,5,0,1,0,-6.5,0,0,1,7,0,0,0,1] ]";
        let expected = Affine3A::from_translation(Vec3::new(5.0, -6.5, 7.0));
        assert_eq!(read(rows).unwrap(), [expected]);
        assert_eq!(read(numbers).unwrap(), [expected; 2]);
    }

    #[test]
    fn what_is_no_list_of_matrices_is_located() {
        let identity = "[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]";
        for (text, line, message) in [
            (
                format!("[{identity},\n[1,2,3]]"),
                2,
                "found 3 numbers in a matrix, expected 16",
            ),
            (
                format!("[\n{identity},\n{identity}"),
                3,
                "EOF while parsing a list",
            ),
            ("[]".into(), 1, "found no camera"),
            ("{\"frames\": []}".into(), 1, "expected a sequence"),
            (
                "[\n\n[1,0,0,\"x\"]]".into(),
                3,
                "expected a number, or a row of four numbers",
            ),
            (
                "[[[1,0,0],[0,1,0]]]".into(),
                1,
                "expected an array of length 4",
            ),
            (format!("[[{identity},1]]"), 1, "trailing characters"),
            (
                "[[1,0,0,0,0,1,0,0,0,0,1,0,0,0,1,1]]".into(),
                1,
                "found the last row 0 0 1 1",
            ),
        ] {
            let error = read(&text).unwrap_err();
            let found = error.diagnostic();
            assert!(found.message.contains(message), "{text}: {}", found.message);
            let location = found.location.as_ref().unwrap();
            assert_eq!(location.line(), line, "{text}: {location}");
            assert_eq!(error.kind(), LoadErrorKind::Scene);
        }
        let missing = read_camera_path(Path::new("missing/walk.json")).unwrap_err();
        assert_eq!(missing.kind(), LoadErrorKind::FileSystem);
    }
}
