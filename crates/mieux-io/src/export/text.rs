//! How numbers and remarks stand in files.

use super::{Loss, PhaseLoss, Subject};
use crate::quantity::significant;

/// To single precision, which renderers compute in.
pub fn rounded(value: f64) -> f64 {
    f64::from(value as f32)
}

/// The shortest decimal that single precision reads back as the same number.
pub fn single(value: f64) -> String {
    let value = value as f32;
    let size = value.abs();
    if value == 0.0 || (1e-4..1e7).contains(&size) { format!("{value}") } else { format!("{value:e}") }
}

/// Several of them.
pub fn singles(values: impl IntoIterator<Item = f64>, between: &str) -> String {
    values.into_iter().map(single).collect::<Vec<_>>().join(between)
}

/// Wavelengths in nanometres, a round number staying round.
pub fn nanometres(metres: f64) -> f64 {
    (metres * 1e9 * 1e6).round() / 1e6
}

/// A name of letters, digits and `_` that does not start with a digit.
pub fn identifier(name: &str) -> String {
    let mut plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !plain.starts_with(|c: char| c.is_ascii_alphabetic()) {
        plain.insert_str(0, "material_");
    }
    plain
}

/// A name for a file.
pub fn stem(name: &str) -> String {
    let plain: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' }).collect();
    if plain.is_empty() { "material".into() } else { plain }
}

/// What every file says in its first lines: what it is, where from, in which units, and what is lost.
pub fn head(
    subject: &Subject,
    of: &str,
    form: &str,
    loss: &Loss,
    phase: &PhaseLoss,
    remarks: &[String],
) -> Vec<String> {
    let mut lines = vec![format!("{}, for {of}", subject.title), subject.source.clone(), form.to_owned()];
    lines.extend(loss.lines());
    lines.push(phase.line());
    lines.extend(remarks.iter().cloned());
    // Nothing may end a comment early.
    lines.iter().map(|line| line.replace(|c: char| c.is_control(), " ").replace("--", "- -")).collect()
}

/// Lines behind a mark, as comments.
pub fn commented(lines: &[String], mark: &str) -> String {
    lines.iter().map(|line| format!("{mark} {line}\n")).collect()
}

/// Lines as a comment in XML.
pub fn xml_comment(lines: &[String]) -> String {
    let lines: String = lines.iter().map(|line| format!("  {line}\n")).collect();
    format!("<!--\n{lines}-->\n")
}

/// What a scene unit is, in words.
pub fn unit(subject: &Subject) -> String {
    format!("one scene unit = {} m", significant(subject.metres_per_unit, 9))
}
