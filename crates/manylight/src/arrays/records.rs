//! Lists of records as arrays: an array for each field, with a row for each record.

use super::{ArrayKind, ArrayValues, InvalidArray, NamedArray};
use crate::color::Rgb;
use crate::ids::LightId;
use crate::math::Vec3;
use std::borrow::Cow;
use std::rc::Rc;

/// Index of no light in an array.
const NO_LIGHT: u32 = u32::MAX;

/// An array that was found by its name: its shape and values.
pub type FoundArray = (Vec<usize>, ArrayValues);

/// A record that files keep.
pub(crate) trait Record: Copy + Sync {
    /// The record before its fields are read.
    const EMPTY: Self;

    /// Hands all fields to `f`, which reads or sets them: always the same fields in the same order.
    fn fields(&mut self, f: &mut impl Fields);
}

/// The numbers that a field may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Domain {
    /// Finite ones.
    Finite,
    /// All but NaN.
    Extended,
}

/// What is done with the fields of a record.
pub(crate) trait Fields {
    /// A field of numbers.
    fn numbers(&mut self, name: &'static str, values: &mut [f32], domain: Domain);
    /// A field of counts or ids.
    fn words(&mut self, name: &'static str, values: &mut [u32]);
    /// Says that the record cannot have the value of a field.
    fn refuse(&mut self, name: &'static str, message: String);

    /// Finite numbers.
    fn floats(&mut self, name: &'static str, values: &mut [f32]) {
        self.numbers(name, values, Domain::Finite);
    }

    /// A finite number.
    fn float(&mut self, name: &'static str, value: &mut f32) {
        self.floats(name, std::slice::from_mut(value));
    }

    /// A number that may be infinite.
    fn extended(&mut self, name: &'static str, value: &mut f32) {
        self.numbers(name, std::slice::from_mut(value), Domain::Extended);
    }

    /// A point or a direction.
    fn vec3(&mut self, name: &'static str, value: &mut Vec3) {
        self.floats(name, value.as_mut());
    }

    /// A color.
    fn rgb(&mut self, name: &'static str, value: &mut Rgb) {
        let mut channels = value.to_array();
        self.floats(name, &mut channels);
        *value = channels.into();
    }

    /// A count or an id.
    fn word<T: Copy + Into<u32> + TryFrom<u32>>(&mut self, name: &'static str, value: &mut T) {
        let mut word = (*value).into();
        self.words(name, std::slice::from_mut(&mut word));
        match T::try_from(word) {
            Ok(found) => *value = found,
            Err(_) => self.refuse(name, format!("found {word}, which is too large")),
        }
    }

    /// The light that represents something, if there is one.
    fn light(&mut self, name: &'static str, value: &mut Option<LightId>) {
        let mut word = value.map_or(NO_LIGHT, |light| light.0);
        self.words(name, std::slice::from_mut(&mut word));
        *value = (word != NO_LIGHT).then_some(LightId(word));
    }

    /// A condition.
    fn flag(&mut self, name: &'static str, value: &mut bool) {
        let mut word = u32::from(*value);
        self.words(name, std::slice::from_mut(&mut word));
        *value = word != 0;
    }
}

/// Name, type and number of values of a field.
#[derive(Clone, Copy, Debug)]
struct Column {
    name: &'static str,
    kind: ArrayKind,
    width: usize,
}

/// The fields of a type of records.
#[derive(Default)]
struct Columns(Vec<Column>);

impl Fields for Columns {
    fn numbers(&mut self, name: &'static str, values: &mut [f32], _: Domain) {
        self.add(name, ArrayKind::F32, values.len());
    }

    fn words(&mut self, name: &'static str, values: &mut [u32]) {
        self.add(name, ArrayKind::U32, values.len());
    }

    fn refuse(&mut self, _: &'static str, _: String) {}
}

impl Columns {
    fn of<T: Record>() -> Vec<Column> {
        let mut columns = Columns::default();
        let mut record = T::EMPTY;
        record.fields(&mut columns);
        columns.0
    }

    fn add(&mut self, name: &'static str, kind: ArrayKind, width: usize) {
        self.0.push(Column { name, kind, width });
    }
}

/// The values of one field of many records.
struct Taken {
    /// Fields before it that are still to come in the record at hand.
    ahead: usize,
    floats: Vec<f32>,
    words: Vec<u32>,
}

impl Fields for Taken {
    fn numbers(&mut self, _: &'static str, values: &mut [f32], _: Domain) {
        if self.is_here() {
            self.floats.extend_from_slice(values);
        }
    }

    fn words(&mut self, _: &'static str, values: &mut [u32]) {
        if self.is_here() {
            self.words.extend_from_slice(values);
        }
    }

    fn refuse(&mut self, _: &'static str, _: String) {}
}

impl Taken {
    /// Those of field `column`.
    fn of<T: Record>(records: &[T], column: usize) -> Self {
        let mut taken = Taken {
            ahead: column,
            floats: Vec::new(),
            words: Vec::new(),
        };
        for record in records {
            taken.ahead = column;
            let mut record = *record;
            record.fields(&mut taken);
        }
        taken
    }

    /// Whether this field is the one to be taken.
    fn is_here(&mut self) -> bool {
        let here = self.ahead == 0;
        self.ahead = self.ahead.wrapping_sub(1);
        here
    }
}

/// Sets the fields of one record after the other.
struct Given<'a> {
    columns: &'a [ArrayValues],
    /// The field that comes next.
    column: usize,
    row: usize,
    fault: Option<(&'static str, String)>,
}

impl Fields for Given<'_> {
    fn numbers(&mut self, name: &'static str, values: &mut [f32], domain: Domain) {
        if let ArrayValues::F32(all) = &self.columns[self.column] {
            values.copy_from_slice(&all[self.row * values.len()..][..values.len()]);
        }
        self.column += 1;
        let is_wrong =
            |value: &&f32| value.is_nan() || domain == Domain::Finite && value.is_infinite();
        if let Some(value) = values.iter().find(is_wrong) {
            let message = format!("found {value} in row {}, expected finite numbers", self.row);
            self.refuse(name, message);
        }
    }

    fn words(&mut self, _: &'static str, values: &mut [u32]) {
        if let ArrayValues::U32(all) = &self.columns[self.column] {
            values.copy_from_slice(&all[self.row * values.len()..][..values.len()]);
        }
        self.column += 1;
    }

    fn refuse(&mut self, name: &'static str, message: String) {
        self.fault.get_or_insert((name, message));
    }
}

/// One array for each field of `records`. Its name is `prefix` and the name of the field.
pub(crate) fn arrays_of_records<'a, T: Record + 'a>(
    prefix: &str,
    records: impl Into<Cow<'a, [T]>>,
) -> Vec<NamedArray<'a>> {
    let records: Rc<Cow<'a, [T]>> = Rc::new(records.into());
    let array = |(k, column): (usize, Column)| {
        let records = records.clone();
        let name = format!("{prefix}{}", column.name);
        let shape = match column.width {
            1 => vec![records.len()],
            width => vec![records.len(), width],
        };
        match column.kind {
            ArrayKind::U32 => NamedArray::words(name, shape, move || Taken::of(&records, k).words),
            _ => NamedArray::floats(name, shape, move || Taken::of(&records, k).floats),
        }
    };
    Columns::of::<T>()
        .into_iter()
        .enumerate()
        .map(array)
        .collect()
}

/// The inverse of [`arrays_of_records`].
///
/// # Errors
/// Those of `read`, and arrays of the wrong type or length, or with values that no record has.
pub(crate) fn records_of_arrays<T: Record, E: From<InvalidArray>>(
    prefix: &str,
    read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
) -> Result<Vec<T>, E> {
    let mut columns = Vec::new();
    let mut rows = None;
    for Column { name, kind, width } in Columns::of::<T>() {
        let name = format!("{prefix}{name}");
        let (shape, values) = read(&name)?;
        let rows = *rows.get_or_insert(shape.first().copied().unwrap_or(0));
        if values.kind() != kind || values.count() != rows * width {
            return Err(InvalidArray::unexpected(&name, &values, kind, rows * width).into());
        }
        columns.push(values);
    }
    let mut records = Vec::with_capacity(rows.unwrap_or(0));
    for row in 0..rows.unwrap_or(0) {
        let mut given = Given {
            columns: &columns,
            column: 0,
            row,
            fault: None,
        };
        let mut record = T::EMPTY;
        record.fields(&mut given);
        if let Some((name, message)) = given.fault {
            return Err(InvalidArray::new(format!("{prefix}{name}"), message).into());
        }
        records.push(record);
    }
    Ok(records)
}

/// The values of an array of floats that are at least 0 and may be infinite, with rows of `width`.
///
/// # Errors
/// Those of `read`, and another array.
pub(crate) fn read_floats<E: From<InvalidArray>>(
    name: &str,
    width: usize,
    read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
) -> Result<Vec<f32>, E> {
    match read(name)? {
        (_, ArrayValues::F32(values)) if values.len().is_multiple_of(width) => {
            match values.iter().find(|&&value| value.is_nan() || value < 0.0) {
                None => Ok(values),
                Some(value) => {
                    let message = format!("found {value}, expected numbers of at least 0");
                    Err(InvalidArray::new(name, message).into())
                }
            }
        }
        (_, found) => Err(InvalidArray::unexpected(name, &found, ArrayKind::F32, width).into()),
    }
}

/// The values of an array of words with rows of `width`.
///
/// # Errors
/// Those of `read`, and another array.
pub(crate) fn read_words<E: From<InvalidArray>>(
    name: &str,
    width: usize,
    read: &mut impl FnMut(&str) -> Result<FoundArray, E>,
) -> Result<Vec<u32>, E> {
    match read(name)? {
        (_, ArrayValues::U32(values)) if values.len().is_multiple_of(width) => Ok(values),
        (_, found) => Err(InvalidArray::unexpected(name, &found, ArrayKind::U32, width).into()),
    }
}
