//! Cells of comma-separated text, each with its place, for files whose every mistake is pointed at.

use std::ops::Range;

/// A cell without the blanks and quotation marks around it, and where it is.
pub(crate) type Cell<'a> = (&'a str, Range<usize>);

/// Lines that say something, cut into cells without the blanks around them.
pub(crate) fn rows(text: &str) -> impl Iterator<Item = Vec<Cell<'_>>> {
    let mut start = 0;
    let lines = text.split_inclusive('\n').map(move |line| {
        let at = start;
        start += line.len();
        (at, line.trim_end_matches(['\n', '\r']))
    });
    lines.filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#')).map(|(at, line)| {
        let mut from = at;
        line.split(',')
            .map(|cell| {
                let start = from + (cell.len() - cell.trim_start().len());
                from += cell.len() + 1;
                let cell = cell.trim().trim_matches('"');
                (cell, start..start + cell.len())
            })
            .collect()
    })
}
