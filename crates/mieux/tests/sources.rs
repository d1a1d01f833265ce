//! Every source that the code names is in `references.bib`, once.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn keys() -> Vec<String> {
    let text = std::fs::read_to_string(root().join("references.bib")).unwrap();
    let key = |line: &str| line.strip_prefix('@')?.split_once('{')?.1.strip_suffix(',').map(str::to_owned);
    text.lines().filter_map(key).collect()
}

/// Words in backquotes that look like a key: letters, a year, perhaps one letter more.
fn cited(text: &str) -> Vec<String> {
    let is_key = |word: &&str| {
        let name = word.trim_end_matches(|c: char| c.is_ascii_lowercase());
        let (letters, year) = name.split_at(name.len().saturating_sub(4));
        let after = word.len() - name.len();
        after <= 1
            && letters.len() >= 3
            && letters.bytes().all(|b| b.is_ascii_lowercase())
            && (1700..2100).contains(&year.parse::<u32>().unwrap_or(0))
    };
    text.split('`').skip(1).step_by(2).filter(is_key).map(str::to_owned).collect()
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let path = entry.path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs" || e == "md") {
            found.push(path);
        }
    }
}

#[test]
fn every_source_named_is_listed_once() {
    let keys = keys();
    let known: BTreeSet<&String> = keys.iter().collect();
    assert_eq!(known.len(), keys.len(), "a key stands twice");
    let mut files = Vec::new();
    ["crates", "apps", "docs", "benches"].iter().for_each(|folder| sources(&root().join(folder), &mut files));
    let mut count = 0;
    for file in files {
        // Code comes in pairs of backquotes only line by line.
        for line in std::fs::read_to_string(&file).unwrap().lines() {
            for key in cited(line) {
                assert!(known.contains(&key), "{key}, named in {}, is not in references.bib", file.display());
                count += 1;
            }
        }
    }
    assert!(count > 100, "only {count} were found");
}
