//! Plain tables: columns as wide as their content, two blanks between them.

/// Lays out rows under a header; no header line when there is no row.
pub(crate) fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let mut widths: Vec<usize> = header.iter().map(|cell| cell.chars().count()).collect();
    for row in rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let mut out = String::new();
    let head = header.iter().map(|&cell| cell.to_owned()).collect::<Vec<_>>();
    for row in std::iter::once(&head).chain(rows) {
        let mut line = String::new();
        for (cell, width) in row.iter().zip(&widths) {
            line.push_str(&format!("{cell:<width$}  "));
        }
        out.push_str(line.trim_end());
        out.push('\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    #[test]
    fn columns_line_up() {
        let rows = [vec!["demo".into(), "shm".into()], vec!["x".into(), "local".into()]];
        expect![[r#"
            NAME  BACKEND
            demo  shm
            x     local
        "#]]
        .assert_eq(&table(&["NAME", "BACKEND"], &rows));
    }
}
