//! Errors that point at a place in a text somebody wrote.

use std::ops::Range;

/// Something wrong in a text file, with the place where it is.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name}, line {line}, column {column}: {message}")]
pub struct TextError {
    /// Name of the file.
    pub name: String,
    /// All of its text, to show the place in.
    pub text: String,
    /// Bytes of the text that are meant.
    pub span: Range<usize>,
    /// Line of the start, from 1.
    pub line: usize,
    /// Column of the start in characters, from 1.
    pub column: usize,
    /// What is wrong.
    pub message: String,
    /// What would do.
    pub help: Option<String>,
}

impl TextError {
    /// Points at `span` in `text`; a span beyond the text points at its end.
    pub fn new(name: &str, text: &str, span: Range<usize>, message: impl Into<String>) -> Box<Self> {
        let mut start = span.start.min(text.len());
        while !text.is_char_boundary(start) {
            start -= 1;
        }
        let end = span.end.clamp(start, text.len());
        let before = &text[..start];
        Box::new(Self {
            name: name.into(),
            text: text.into(),
            span: start..end,
            line: before.matches('\n').count() + 1,
            column: before.rsplit('\n').next().unwrap_or("").chars().count() + 1,
            message: message.into(),
            help: None,
        })
    }

    /// Adds what would do.
    #[must_use]
    pub fn with_help(mut self: Box<Self>, help: impl Into<String>) -> Box<Self> {
        self.help = Some(help.into());
        self
    }

    /// From what the TOML reader says.
    pub(crate) fn from_toml(name: &str, text: &str, error: &toml::de::Error) -> Box<Self> {
        let span = error.span().unwrap_or(0..text.len().min(1));
        Self::new(name, text, span, error.message())
    }
}

/// The names that look most like `name`, at most three, the nearest first.
pub fn nearest_names<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let lower = name.to_lowercase();
    let mut scored: Vec<(f64, &str)> = known
        .into_iter()
        .map(|k| {
            let bonus = if k.contains(&lower) || lower.contains(k) { 0.2 } else { 0.0 };
            (strsim::jaro_winkler(&lower, k) + bonus, k)
        })
        .filter(|(score, _)| *score > 0.7)
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored.into_iter().take(3).map(|(_, k)| k).collect()
}

/// "did you mean a, b or c?", or nothing when no name is near.
pub(crate) fn did_you_mean(nearest: &[&str]) -> String {
    match nearest {
        [] => String::new(),
        [one] => format!("did you mean `{one}`?"),
        [first @ .., last] => format!("did you mean `{}` or `{last}`?", first.join("`, `")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_from_one_and_in_characters() {
        let text = "a = 1\nµ = x\n";
        let at = |start| TextError::new("t", text, start..start + 1, "m");
        assert_eq!((at(0).line, at(0).column), (1, 1));
        let x = text.find('x').unwrap();
        assert_eq!((at(x).line, at(x).column), (2, 5));
        assert_eq!((at(999).line, at(999).span.start), (3, text.len()));
        // Inside a character: its start.
        assert_eq!(at(7).column, 1);
        assert_eq!(at(x).to_string(), "t, line 2, column 5: m");
    }

    #[test]
    fn near_names_are_found() {
        let known = ["whole-milk", "skim-milk", "low-fat-milk", "water"];
        assert_eq!(nearest_names("whle-milk", known)[0], "whole-milk");
        assert!(nearest_names("milk", known).contains(&"skim-milk"));
        assert!(nearest_names("xyzzy", known).is_empty());
        assert_eq!(did_you_mean(&["a", "b", "c"]), "did you mean `a`, `b` or `c`?");
    }
}
