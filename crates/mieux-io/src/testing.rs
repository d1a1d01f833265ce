//! What tests of several readers share.

/// Cuts, changes or adds bytes at shares `at` and `more` of the length.
pub(crate) fn damage(bytes: &mut Vec<u8>, at: f64, byte: u8, kind: u8, more: f64) {
    let place = ((at * bytes.len() as f64) as usize).min(bytes.len().saturating_sub(1));
    match kind {
        0 => bytes.truncate(place),
        1 => {
            bytes[place] = byte;
            let other = ((more * bytes.len() as f64) as usize).min(bytes.len() - 1);
            bytes[other] ^= byte;
        }
        _ => {
            let from = ((more * bytes.len() as f64) as usize).min(bytes.len());
            let to = (from + usize::from(byte)).min(bytes.len());
            let piece = bytes[from..to].to_vec();
            bytes.splice(place..place, piece);
        }
    }
}
