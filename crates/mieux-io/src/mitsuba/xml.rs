//! XML as a tree that knows where it stands in its file. No entities beyond the five of XML, no document types.

use std::ops::Range;
use std::rc::Rc;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use crate::text_error::TextError;

/// Elements in elements in elements: not deeper than this.
const MAX_DEPTH: usize = 64;
/// No more elements in one file.
const MAX_ELEMENTS: usize = 200_000;

/// A file and its text.
#[derive(Debug)]
pub(super) struct Source {
    pub name: String,
    pub text: String,
}

/// An element.
#[derive(Debug, Clone)]
pub(super) struct Element {
    pub tag: String,
    pub attributes: Vec<Attribute>,
    pub children: Vec<Rc<Element>>,
    pub source: Rc<Source>,
    /// Of its opening tag.
    pub span: Range<usize>,
}

/// `name="value"`.
#[derive(Debug, Clone)]
pub(super) struct Attribute {
    pub name: String,
    pub value: String,
    /// Of the value.
    pub span: Range<usize>,
}

impl Element {
    pub fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|a| a.name == name).map(|a| a.value.as_str())
    }

    pub fn error(&self, message: impl Into<String>) -> Box<TextError> {
        TextError::new(&self.source.name, &self.source.text, self.span.clone(), message)
    }

    /// Points at the value of an attribute, or at the element where there is none.
    pub fn error_at(&self, attribute: &str, message: impl Into<String>) -> Box<TextError> {
        let span = self.attributes.iter().find(|a| a.name == attribute).map_or(&self.span, |a| &a.span);
        TextError::new(&self.source.name, &self.source.text, span.clone(), message)
    }
}

/// Reads a text whose outermost element is returned.
pub(super) fn parse(source: &Rc<Source>) -> Result<Rc<Element>, Box<TextError>> {
    let text = source.text.as_str();
    let error = |span: Range<usize>, message: String| TextError::new(&source.name, text, span, message);
    let mut reader = Reader::from_str(text);
    let mut open: Vec<Element> = Vec::new();
    let mut root = None;
    let mut count = 0;
    loop {
        let start = reader.buffer_position() as usize;
        let event = reader.read_event().map_err(|e| {
            let at = reader.error_position() as usize;
            error(at..at + 1, format!("this is not XML: {e}"))
        })?;
        let span = start..reader.buffer_position() as usize;
        match event {
            Event::Start(tag) | Event::Empty(tag) if root.is_some() && open.is_empty() => {
                return Err(error(span, format!("`{}` stands outside the scene", tag.name().as_ref())));
            }
            Event::Start(tag) => {
                count += 1;
                if open.len() >= MAX_DEPTH || count > MAX_ELEMENTS {
                    return Err(error(span, format!("more than {MAX_DEPTH} deep or {MAX_ELEMENTS} elements")));
                }
                open.push(element(source, &tag, span)?);
            }
            Event::Empty(tag) => {
                count += 1;
                if count > MAX_ELEMENTS {
                    return Err(error(span, format!("more than {MAX_ELEMENTS} elements")));
                }
                let element = Rc::new(element(source, &tag, span)?);
                match open.last_mut() {
                    Some(parent) => parent.children.push(element),
                    None => root = Some(element),
                }
            }
            Event::End(_) => {
                // The reader has checked that ends match.
                if let Some(element) = open.pop().map(Rc::new) {
                    match open.last_mut() {
                        Some(parent) => parent.children.push(element),
                        None => root = Some(element),
                    }
                }
            }
            Event::Text(said) if said.trim().is_empty() => {}
            Event::Text(_) | Event::CData(_) | Event::GeneralRef(_) => {
                // Where the text itself starts.
                let blank = text[span.clone()].len() - text[span.clone()].trim_start().len();
                let span = span.start + blank..span.end;
                return Err(error(span, "there is text here, where only elements can be".into()));
            }
            Event::DocType(_) => {
                let help = "take it out, and write what its entities stand for in their places";
                return Err(error(span, "document types and their entities are refused".into()).with_help(help));
            }
            Event::Comment(_) | Event::Decl(_) | Event::PI(_) => {}
            Event::Eof => break,
        }
    }
    if let Some(element) = open.last() {
        return Err(element.error(format!("`{}` is never closed", element.tag)));
    }
    root.ok_or_else(|| error(0..text.len().min(1), "there is no element in this file".into()))
}

fn element(source: &Rc<Source>, tag: &BytesStart<'_>, span: Range<usize>) -> Result<Element, Box<TextError>> {
    let name: &str = tag.name().into_inner();
    let error = |message: String| TextError::new(&source.name, &source.text, span.clone(), message);
    let mut attributes = Vec::new();
    // Where the next value is looked for: attributes come in the order of the text.
    let mut from = span.start;
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|e| error(format!("an attribute of `{name}` is not XML: {e}")))?;
        let key: &str = attribute.key.into_inner();
        let raw: &str = &attribute.value;
        let within = &source.text[from..span.end];
        let after_key = within.find(key).map_or(0, |i| i + key.len());
        let place = within[after_key..].find(raw).map_or(0, |i| i + after_key);
        let at = from + place..from + place + raw.len();
        let value = attribute.normalized_value(XmlVersion::Implicit1_0);
        let value = value.map_err(|e| error(format!("the value of `{key}` is not XML: {e}")))?.into_owned();
        from = at.end;
        attributes.push(Attribute { name: key.to_owned(), value, span: at });
    }
    Ok(Element { tag: name.to_owned(), attributes, children: Vec::new(), source: source.clone(), span })
}
