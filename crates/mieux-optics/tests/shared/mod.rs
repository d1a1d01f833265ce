//! Shared reference tables, read in place.

use std::path::PathBuf;

/// A reference file; `None` when there is none and nobody insists (`MIEUX_REQUIRE_SHARED=1`).
pub fn text(path: &str) -> Option<String> {
    let folder = std::env::var("MIEUX_SHARED")
        .map_or_else(|_| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared"), PathBuf::from);
    let file = folder.join("data").join(path);
    match std::fs::read_to_string(&file) {
        Ok(text) => Some(text),
        Err(error) if std::env::var("MIEUX_REQUIRE_SHARED").is_ok_and(|v| v == "1") => {
            panic!("{}: {error}", file.display())
        }
        Err(_) => None,
    }
}
