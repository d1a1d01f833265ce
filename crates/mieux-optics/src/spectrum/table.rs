//! Reads the data tables that are compiled in: comma-separated numbers, `#` comments, one header line.

use super::{Sampled, WavelengthGrid};

/// Columns of a compiled-in table whose first column is `wavelength_nm`.
///
/// Panics on a malformed table; the tables are part of the program and a test reads them all.
pub(crate) fn embedded_table<const COLUMNS: usize>(text: &str) -> [Sampled; COLUMNS] {
    let mut wavelengths = Vec::new();
    let mut columns: [Vec<f64>; COLUMNS] = std::array::from_fn(|_| Vec::new());
    for line in text.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let mut cells = line.split(',').map(|cell| cell.trim().parse::<f64>().expect("a number"));
        wavelengths.push(cells.next().expect("a wavelength") * 1e-9);
        for column in &mut columns {
            column.push(cells.next().expect("one value per column"));
        }
    }
    let grid = WavelengthGrid::new(wavelengths).expect("an increasing grid");
    columns.map(|values| Sampled::new(grid.clone(), values).expect("finite values"))
}
