//! Tables of figures, the best of every column in bold.

use serde::ser::{Serialize, SerializeStruct, Serializer};

/// A table; every row has as many cells as the head.
#[derive(Debug)]
pub(crate) struct Table {
    head: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

/// One entry.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cell {
    /// As shown; nothing is shown as `-`.
    pub(crate) text: String,
    /// The smallest of a column is the best; `None` never is.
    pub(crate) rank: Option<f64>,
}

impl Cell {
    /// A text that is no figure.
    pub(crate) fn plain(text: impl Into<String>) -> Self {
        Cell {
            text: text.into(),
            rank: None,
        }
    }
}

impl Table {
    /// Without rows.
    pub(crate) fn new(head: impl IntoIterator<Item = String>) -> Self {
        Table {
            head: head.into_iter().collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row below.
    pub(crate) fn push(&mut self, row: impl IntoIterator<Item = Cell>) {
        self.rows.push(row.into_iter().collect());
    }

    /// Whether there is nothing but heads.
    pub(super) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// With a final line end.
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

    /// Where nothing is compared, nothing is best; what reads the same is as good.
    fn is_best(&self, column: usize, cell: &Cell) -> bool {
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

/// The heads, and rows of pairs: what is shown, and whether it is the best.
impl Serialize for Table {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let cell = |(c, cell): (usize, &Cell)| (cell.text.clone(), self.is_best(c, cell));
        let row = |row: &Vec<Cell>| row.iter().enumerate().map(cell).collect();
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
        let cell = |text: &str, rank: f64| Cell {
            text: text.into(),
            rank: Some(rank),
        };
        let mut table = Table::new(["".into(), "a|b".into(), "c".into()]);
        table.push([Cell::plain("x"), cell("0.10", 0.101), cell("1", 1.0)]);
        table.push([Cell::plain("y"), cell("0.10", 0.102), Cell::default()]);
        table.push([Cell::plain("z"), cell("0.2", 0.2), Cell::plain("0.5")]);
        assert_eq!(
            table.markdown(),
            "| - | a\\|b | c |\n|---|---|---|\n| x | **0.10** | 1 |\n| y | **0.10** | - |\n| z | 0.2 | 0.5 |\n"
        );
    }
}
