//! Words of a text with remarks, each with its place.

use std::ops::Range;

use crate::text_error::TextError;

/// A word and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Word<'a> {
    pub text: &'a str,
    pub span: Range<usize>,
    /// From 1.
    pub line: usize,
}

/// The words of a file after its mark, in order.
pub(super) struct Words<'a> {
    name: &'a str,
    text: &'a str,
    /// Lines that have words, the next first.
    lines: std::vec::IntoIter<Vec<Word<'a>>>,
    /// What is left of the line at hand.
    line: std::vec::IntoIter<Word<'a>>,
}

const MARK: &str = "IAD1";

impl<'a> Words<'a> {
    /// # Errors
    /// Where the text does not start as such files do.
    pub fn new(name: &'a str, text: &'a str) -> Result<Self, Box<TextError>> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        if !text.starts_with(MARK) {
            let end = text.find(char::is_whitespace).unwrap_or(text.len());
            let error = TextError::new(name, text, 0..end, "the file does not start with `IAD1`");
            return Err(error.with_help("these four letters begin every file of inverse adding-doubling measurements"));
        }
        let mut lines = Vec::new();
        let mut start = 0;
        for (number, line) in text.split_inclusive(['\n', '\r']).enumerate() {
            let skipped = if number == 0 { MARK.len() } else { 0 };
            let end = line.find('#').unwrap_or(line.len()).max(skipped);
            let words = words_in(&line[skipped..end], start + skipped);
            if !words.is_empty() {
                lines.push(words);
            }
            start += line.len();
        }
        let mut known = 1;
        let mut upto = 0;
        for word in lines.iter_mut().flatten() {
            known += text[upto..word.span.start].matches('\n').count();
            upto = word.span.start;
            word.line = known;
        }
        Ok(Self { name, text, lines: lines.into_iter(), line: Vec::new().into_iter() })
    }

    pub fn next_word(&mut self) -> Option<Word<'a>> {
        loop {
            if let Some(word) = self.line.next() {
                return Some(word);
            }
            self.line = self.lines.next()?.into_iter();
        }
    }

    /// What is left of the line at hand, or the next line; nothing at the end.
    pub fn rest_of_line(&mut self) -> Vec<Word<'a>> {
        let rest: Vec<Word<'a>> = self.line.by_ref().collect();
        if rest.is_empty() { self.lines.next().unwrap_or_default() } else { rest }
    }

    /// # Errors
    /// Where the word is no finite number.
    pub fn number(&self, word: &Word, what: &str) -> Result<f64, Box<TextError>> {
        let value = word.text.parse().ok().filter(|value: &f64| value.is_finite());
        value.ok_or_else(|| self.at(word.span.clone(), format!("`{}` is not a number; here stands {what}", word.text)))
    }

    pub fn at(&self, span: Range<usize>, message: String) -> Box<TextError> {
        TextError::new(self.name, self.text, span, message)
    }

    pub fn at_end(&self, message: String) -> Box<TextError> {
        let end = self.text.trim_end().len();
        self.at(end..end, message)
    }
}

fn words_in(text: &str, offset: usize) -> Vec<Word<'_>> {
    let mut words = Vec::new();
    let mut rest = text;
    let mut at = offset;
    loop {
        let blank = rest.len() - rest.trim_start().len();
        (rest, at) = (&rest[blank..], at + blank);
        if rest.is_empty() {
            return words;
        }
        let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
        words.push(Word { text: &rest[..end], span: at..at + end, line: 0 });
        (rest, at) = (&rest[end..], at + end);
    }
}
