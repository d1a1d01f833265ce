//! Every file of the refractiveindex.info database, where there is a copy (`MIEUX_INDEX_DB`).

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use mieux_io::index_file::{IndexDatabase, IndexFileError, read_index_file};

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e == "yml") {
            found.push(path);
        }
    }
}

/// Three wavelengths inside a range, and its ends.
fn wavelengths((first, last): (f64, f64)) -> Vec<f64> {
    [0.0, 0.21, 0.5, 0.83, 1.0].iter().map(|t: &f64| first * (last / first).powf(*t)).collect()
}

/// Every file of indices loads; every other one says what it is. With `MIEUX_INDEX_VALUES`, values go to that file, for
/// comparison with another reader: file, part, wavelength in um, value.
#[test]
fn every_file_loads_or_says_why() {
    let Some(folder) = std::env::var_os("MIEUX_INDEX_DB").map(PathBuf::from) else { return };
    let mut paths = Vec::new();
    files(&folder, &mut paths);
    assert!(paths.len() > 4000, "{} files", paths.len());
    let (mut count, mut values) = (BTreeMap::<String, usize>::new(), String::new());
    for path in &paths {
        let short = path.strip_prefix(&folder).unwrap().display().to_string();
        let outcome = match read_index_file(path) {
            Ok(dispersion) => {
                for (part, range) in ["n", "k"].iter().zip(dispersion.part_ranges()) {
                    for wavelength in range.into_iter().flat_map(wavelengths) {
                        let (n, k) = dispersion.parts(wavelength);
                        let value = if *part == "n" { n } else { k }.unwrap_or(f64::NAN);
                        writeln!(values, "{short}\t{part}\t{:e}\t{value:e}", wavelength * 1e6).unwrap();
                    }
                }
                for note in dispersion.notes() {
                    let note = format!("{note:?}");
                    let kind = note.split(' ').next().unwrap_or_default();
                    *count.entry(format!("note {kind}")).or_default() += 1;
                }
                match dispersion.has_parts() {
                    (true, true) => "n and k".to_string(),
                    (true, false) => "n alone".to_string(),
                    (false, _) => "k alone".to_string(),
                }
            }
            Err(IndexFileError::Other { what, .. }) => format!("{what:?}"),
            Err(error @ IndexFileError::Text(_)) => {
                writeln!(values, "# {error}").unwrap();
                "malformed".into()
            }
            Err(error) => panic!("{error}"),
        };
        *count.entry(outcome).or_default() += 1;
    }
    let listing: String = count.iter().map(|(what, n)| format!("# {n:6} {what}\n")).collect();
    let at_least = [("n and k", 2500), ("n alone", 800), ("Nonlinear", 100), ("About", 100), ("Catalogue", 1)];
    for (what, least) in at_least {
        assert!(count.get(what).is_some_and(|n| *n >= least), "{listing}");
    }
    // One in v2026-05-24: a formula of which the last coefficient is missing.
    assert!(count.get("malformed").is_none_or(|n| *n <= 3), "{listing}{values}");
    if let Some(file) = std::env::var_os("MIEUX_INDEX_VALUES") {
        std::fs::write(file, format!("{listing}{values}")).unwrap();
    }
}

#[test]
fn every_page_of_the_catalogue_reads() {
    let Some(folder) = std::env::var_os("MIEUX_INDEX_DB").map(PathBuf::from) else { return };
    let database = IndexDatabase::open(&folder).unwrap();
    assert!(database.pages().len() > 3000);
    let malformed = database.pages().iter().filter(|page| match database.read(page) {
        Ok(_) => false,
        Err(IndexFileError::Text(_)) => true,
        Err(error) => panic!("{}: {error}", page.name),
    });
    assert!(malformed.count() <= 3);
    let rutile = database.read(database.find("TiO2/Devore-o").unwrap()).unwrap();
    assert!((rutile.assume_transparent().index(589.3e-9).unwrap().re - 2.613).abs() < 1e-3);
}
