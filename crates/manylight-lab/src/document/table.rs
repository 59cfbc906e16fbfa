//! Tables of numbers, with the best value of each column in bold.

use serde::ser::{Serialize, SerializeStruct, Serializer};

/// A table. Every row has as many cells as the head.
#[derive(Debug)]
pub struct DocumentTable {
    head: Vec<String>,
    rows: Vec<Vec<TableCell>>,
}

/// One cell of a table.
#[derive(Clone, Debug, Default)]
pub struct TableCell {
    /// The displayed text; an empty text is displayed as `-`.
    pub text: String,
    /// Sorting key of the value: the smallest of a column is the best. `None` excludes the cell
    /// from the comparison.
    pub rank: Option<f64>,
}

impl TableCell {
    /// A text that is not compared.
    pub fn plain(text: impl Into<String>) -> Self {
        TableCell {
            text: text.into(),
            rank: None,
        }
    }
}

impl DocumentTable {
    /// A table with these column heads and no rows.
    pub fn new(head: impl IntoIterator<Item = String>) -> Self {
        DocumentTable {
            head: head.into_iter().collect(),
            rows: Vec::new(),
        }
    }

    /// Appends a row.
    pub fn push(&mut self, row: impl IntoIterator<Item = TableCell>) {
        self.rows.push(row.into_iter().collect());
    }

    /// Whether the table has no rows.
    pub(super) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The table as Markdown, with a final line end.
    pub(super) fn markdown(&self) -> String {
        let mut lines = vec![line(self.head.iter().map(|text| escaped(text)))];
        lines.push(format!("|{}", "---|".repeat(self.head.len())));
        for row in &self.rows {
            lines.push(line(row.iter().enumerate().map(|(c, cell)| {
                let text = escaped(&cell.text);
                if self.is_best(c, cell) {
                    format!("**{text}**")
                } else {
                    text
                }
            })));
        }
        lines.join("\n") + "\n"
    }

    /// Whether a cell has the best value of its column. Cells with the same text as the best one
    /// count as equally good. A column with fewer than two compared cells has no best value.
    fn is_best(&self, column: usize, cell: &TableCell) -> bool {
        let cells = self.rows.iter().filter_map(|row| row.get(column));
        let ranked: Vec<(f64, &str)> = cells
            .filter_map(|cell| Some((cell.rank?, cell.text.as_str())))
            .collect();
        let best = ranked.iter().min_by(|a, b| a.0.total_cmp(&b.0));
        ranked.len() > 1
            && cell.rank.is_some()
            && best.is_some_and(|(rank, text)| cell.rank == Some(*rank) || *text == cell.text)
    }
}

/// Fields `head`, and `rows` of pairs (displayed text, whether it is the best of its column).
impl Serialize for DocumentTable {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let cell = |(c, cell): (usize, &TableCell)| (cell.text.clone(), self.is_best(c, cell));
        let row = |row: &Vec<TableCell>| row.iter().enumerate().map(cell).collect();
        let rows: Vec<Vec<(String, bool)>> = self.rows.iter().map(row).collect();
        let mut table = serializer.serialize_struct("Table", 2)?;
        table.serialize_field("head", &self.head)?;
        table.serialize_field("rows", &rows)?;
        table.end()
    }
}

fn escaped(text: &str) -> String {
    if text.is_empty() {
        return "-".into();
    }
    text.replace('|', "\\|")
}

fn line(cells: impl Iterator<Item = String>) -> String {
    format!("| {} |", cells.collect::<Vec<_>>().join(" | "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_of_a_column_is_bold() {
        let cell = |text: &str, rank: f64| TableCell {
            text: text.into(),
            rank: Some(rank),
        };
        let mut table = DocumentTable::new(["".into(), "a|b".into(), "c".into()]);
        table.push([TableCell::plain("x"), cell("0.10", 0.101), cell("1", 1.0)]);
        table.push([
            TableCell::plain("y"),
            cell("0.10", 0.102),
            TableCell::default(),
        ]);
        table.push([
            TableCell::plain("z"),
            cell("0.2", 0.2),
            TableCell::plain("0.5"),
        ]);
        assert_eq!(
            table.markdown(),
            "| - | a\\|b | c |\n|---|---|---|\n| x | **0.10** | 1 |\n| y | **0.10** | - |\n| z | 0.2 | 0.5 |\n"
        );
    }
}
