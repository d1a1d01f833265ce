//! As much of YAML as files of refractive indices are written in, every node with its line.

use saphyr_parser::{Event, Parser};

use crate::text_error::TextError;

/// Deepest nesting read.
const MAX_DEPTH: usize = 32;

/// A part of a YAML document.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    /// The line it begins in, from 1; of a block of text its first line.
    pub(super) line: usize,
    pub(super) content: Content,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Content {
    Text(String),
    List(Vec<Node>),
    Map(Vec<(Node, Node)>),
}

impl Node {
    pub(super) fn text(&self) -> Option<&str> {
        match &self.content {
            Content::Text(text) => Some(text),
            _ => None,
        }
    }

    pub(super) fn list(&self) -> Option<&[Node]> {
        match &self.content {
            Content::List(list) => Some(list),
            _ => None,
        }
    }

    /// What stands under a key of a map.
    pub(super) fn get(&self, key: &str) -> Option<&Node> {
        match &self.content {
            Content::Map(map) => map.iter().find(|(name, _)| name.text() == Some(key)).map(|(_, value)| value),
            _ => None,
        }
    }

    /// The text under a key.
    pub(super) fn text_of(&self, key: &str) -> Option<&str> {
        self.get(key).and_then(Node::text)
    }
}

/// Points at a line (from 1) of a text, without the blanks around it.
pub(super) fn line_error(file: &str, text: &str, line: usize, message: impl Into<String>) -> Box<TextError> {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let whole = text[start..].lines().next().unwrap_or("");
    let start = start + whole.len() - whole.trim_start().len();
    TextError::new(file, text, start..start + whole.trim().len(), message)
}

/// The first document of a text; nothing if it is empty.
pub(super) fn read(file: &str, text: &str) -> Result<Option<Node>, Box<TextError>> {
    let mut open: Vec<Open> = Vec::new();
    for next in Parser::new_from_str(text) {
        let (event, span) = next.map_err(|e| line_error(file, text, e.marker().line(), e.info()))?;
        let line = span.start.line();
        let done = match event {
            Event::Scalar(scalar, ..) => Node { line, content: Content::Text(scalar.into_owned()) },
            Event::SequenceStart(..) => {
                open.push(Open { line, map: false, nodes: Vec::new() });
                if open.len() > MAX_DEPTH {
                    return Err(line_error(file, text, line, "nested too deeply for a file of refractive indices"));
                }
                continue;
            }
            Event::MappingStart(..) => {
                open.push(Open { line, map: true, nodes: Vec::new() });
                if open.len() > MAX_DEPTH {
                    return Err(line_error(file, text, line, "nested too deeply for a file of refractive indices"));
                }
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => match open.pop() {
                Some(closed) => closed.close(),
                None => continue,
            },
            Event::Alias(_) => return Err(line_error(file, text, line, "aliases are not understood here")),
            _ => continue,
        };
        match open.last_mut() {
            Some(parent) => parent.nodes.push(done),
            None => return Ok(Some(done)),
        }
    }
    Ok(None)
}

/// A list or map of which the end has not come yet; the nodes of a map are keys and values in turn.
struct Open {
    line: usize,
    map: bool,
    nodes: Vec<Node>,
}

impl Open {
    fn close(self) -> Node {
        let content = if self.map {
            let mut nodes = self.nodes.into_iter();
            let mut map = Vec::new();
            while let (Some(key), Some(value)) = (nodes.next(), nodes.next()) {
                map.push((key, value));
            }
            Content::Map(map)
        } else {
            Content::List(self.nodes)
        };
        Node { line: self.line, content }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_know_their_lines() {
        let text = "# head\nA: µ\nDATA:\n  - type: x\n    data: |\n        1 2\n        3 4\n  - {type: y}\n";
        let node = read("f", text).unwrap().unwrap();
        let data = node.get("DATA").unwrap().list().unwrap();
        assert_eq!((data.len(), data[0].line, data[1].line), (2, 4, 8));
        let block = data[0].get("data").unwrap();
        assert_eq!((block.line, block.text()), (6, Some("1 2\n3 4\n")));
        assert_eq!((node.text_of("A"), data[1].text_of("type")), (Some("µ"), Some("y")));
        assert_eq!(read("f", "# nothing\n").unwrap(), None);
    }

    #[test]
    fn what_is_no_yaml_is_pointed_at() {
        let error = read("f", "A: 1\nB: [1, 2\nC: 3\n").unwrap_err();
        assert!(error.line >= 2, "{error}");
        assert!(read("f", &"[".repeat(40)).unwrap_err().message.contains("deep"));
        assert!(read("f", "A: &x 1\nB: *x\n").unwrap_err().message.contains("alias"));
    }

    proptest::proptest! {
        #[test]
        fn anything_ends_in_a_node_or_an_error(text in "[-:|>&*# \\[\\]{}a1.\n\"']{0,80}") {
            let _ = read("f", &text);
        }
    }
}
