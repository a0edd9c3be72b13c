//! Tables that stand in a narrow window too: there each row is a block of its own.

use maud::{Markup, html};

/// Headings and rows; the first cell of a row is its name.
pub(super) fn table(headings: &[&str], rows: &[Vec<String>]) -> Markup {
    html! {
        table.rows {
            thead { tr { @for heading in headings { th scope="col" { (heading) } } } }
            tbody {
                @for row in rows {
                    tr {
                        @for (column, cell) in row.iter().enumerate() {
                            @if column == 0 {
                                th scope="row" { (cell) }
                            } @else {
                                td data-name=[headings.get(column).filter(|name| !name.is_empty())] {
                                    (cell)
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Names and values, without headings.
pub(super) fn values(rows: &[Vec<String>]) -> Markup {
    html! {
        table.rows {
            tbody {
                @for row in rows {
                    tr {
                        @if let [name, values @ ..] = row.as_slice() {
                            th scope="row" { (name) }
                            @for value in values { td { (value) } }
                        }
                    }
                }
            }
        }
    }
}
