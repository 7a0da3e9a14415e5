//! A YAML or JSON file as a tree whose every key and value knows its line.
//!
//! OpenCV's header `%YAML:1.0` and its tags are taken; of several documents, as `rostopic echo` writes them, the first is read. JSON is YAML.

use super::error::FormatError;
use crate::{printable, yaml};
use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_saphyr::Spanned;
use std::fmt;
use std::path::Path;

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Node {
    Nothing,
    Flag(bool),
    Number(f64),
    Text(String),
    List(Vec<Item>),
    Map(Vec<Entry>),
}

/// A value and the line it stands on, from 1; 0 where that is not known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Item {
    pub node: Node,
    pub line: usize,
}

/// A key with its value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    pub key: String,
    pub line: usize,
    pub value: Item,
}

impl Item {
    /// What it is, for messages.
    pub(crate) fn shown(&self) -> String {
        match &self.node {
            Node::Nothing => "empty".into(),
            Node::Flag(flag) => format!("{flag}"),
            Node::Number(number) => format!("{number}"),
            Node::Text(text) => {
                let cut: String = text.chars().take(40).collect();
                format!("\"{}\"", cut.escape_default())
            }
            Node::List(list) => format!("a list of {}", list.len()),
            Node::Map(_) => "a block of keys".into(),
        }
    }

    /// All numbers of a number, a list or a list of lists, row by row; `None` where anything else stands.
    pub(crate) fn numbers(&self) -> Option<Vec<f64>> {
        match &self.node {
            Node::Number(number) => Some(vec![*number]),
            // Such as `1e-3` in quotes.
            Node::Text(text) => text.trim().parse().ok().map(|number| vec![number]),
            Node::List(list) => {
                list.iter().map(Self::numbers).collect::<Option<Vec<_>>>().map(|l| l.concat())
            }
            _ => None,
        }
    }
}

/// A mapping of the file and the keys above it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Block<'a> {
    /// `imu0`, `value0`; empty for the file's own keys.
    pub path: String,
    pub entries: &'a [Entry],
}

impl<'a> Block<'a> {
    pub(crate) fn get(&self, key: &str) -> Option<&'a Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }
}

/// A whole file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tree {
    root: Vec<Entry>,
}

impl Tree {
    /// Reads `bytes`; `path` is for messages.
    ///
    /// # Errors
    /// No text, no YAML, no keys.
    pub(crate) fn parse(bytes: &[u8], path: &Path) -> Result<Self, FormatError> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let text = yaml::without_directives(first_document(yaml::text(bytes, path)?));
        let node = yaml::parse::<Spanned<Node>>(&text, path)?.value;
        match node {
            Node::Map(root) if !root.is_empty() => Ok(Self { root }),
            _ => Err(FormatError::NoKeys { path: path.to_path_buf() }),
        }
    }

    /// The file's own keys.
    pub(crate) fn root(&self) -> &[Entry] {
        &self.root
    }

    /// The file's own keys, then those of every mapping in it, outer before inner.
    pub(crate) fn blocks(&self) -> Vec<Block<'_>> {
        let mut blocks = vec![Block { path: String::new(), entries: &self.root }];
        let mut at = 0;
        while at < blocks.len() {
            let Block { path, entries } = blocks[at].clone();
            for entry in entries {
                if let Node::Map(inner) = &entry.value.node {
                    let path =
                        if path.is_empty() { entry.key.clone() } else { format!("{path}.{}", entry.key) };
                    blocks.push(Block { path, entries: inner });
                }
            }
            at += 1;
        }
        blocks
    }
}

/// Everything up to the second `---`.
fn first_document(text: &str) -> &str {
    let (mut at, mut begun) = (0, false);
    for line in text.split_inclusive('\n') {
        let word = line.trim_end();
        if word == "---" || word.starts_with("--- ") || word == "..." {
            if begun {
                return &text[..at];
            }
        } else {
            begun |= !word.is_empty() && !word.starts_with(['#', '%']);
        }
        at += line.len();
    }
    text
}

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = Node;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a value")
            }
            fn visit_bool<E>(self, v: bool) -> Result<Node, E> {
                Ok(Node::Flag(v))
            }
            fn visit_i64<E>(self, v: i64) -> Result<Node, E> {
                Ok(Node::Number(v as f64))
            }
            fn visit_u64<E>(self, v: u64) -> Result<Node, E> {
                Ok(Node::Number(v as f64))
            }
            fn visit_i128<E>(self, v: i128) -> Result<Node, E> {
                Ok(Node::Number(v as f64))
            }
            fn visit_u128<E>(self, v: u128) -> Result<Node, E> {
                Ok(Node::Number(v as f64))
            }
            fn visit_f64<E>(self, v: f64) -> Result<Node, E> {
                Ok(Node::Number(v))
            }
            fn visit_str<E>(self, v: &str) -> Result<Node, E> {
                Ok(Node::Text(v.to_owned()))
            }
            fn visit_unit<E>(self) -> Result<Node, E> {
                Ok(Node::Nothing)
            }
            fn visit_none<E>(self) -> Result<Node, E> {
                Ok(Node::Nothing)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut access: A) -> Result<Node, A::Error> {
                let mut list = Vec::new();
                while let Some(item) = access.next_element()? {
                    list.push(item);
                }
                Ok(Node::List(list))
            }
            fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<Node, A::Error> {
                let mut map = Vec::new();
                while let Some((key, value)) = access.next_entry::<Spanned<String>, Item>()? {
                    map.push(Entry { line: line_of(&key), key: printable(&key.value), value });
                }
                Ok(Node::Map(map))
            }
        }
        deserializer.deserialize_any(Any)
    }
}

impl<'de> Deserialize<'de> for Item {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let spanned = Spanned::<Node>::deserialize(deserializer)?;
        Ok(Self { line: line_of(&spanned), node: spanned.value })
    }
}

fn line_of<T>(spanned: &Spanned<T>) -> usize {
    usize::try_from(spanned.referenced.line()).expect("a text in memory has no more lines than bytes")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(text: &str) -> Result<Tree, FormatError> {
        Tree::parse(text.as_bytes(), Path::new("f"))
    }

    #[test]
    fn opencv_json_and_messages_are_read_with_their_lines() {
        let vins = tree(
            "%YAML:1.0\n\n#camera\nextrinsicRotation: !!opencv-matrix\n   rows: 3\n   data: [1.0, 0, 0]\nacc_n: 0.08  # ha\n",
        )
        .unwrap();
        let blocks = vins.blocks();
        assert_eq!(blocks[1].path, "extrinsicRotation");
        let entry = blocks[0].get("acc_n").unwrap();
        assert_eq!((entry.line, entry.value.numbers()), (7, Some(vec![0.08])));

        let json = tree("{\n\t\"value0\": {\n\t\t\"a\": [1, 2.5, 1e-3]\n\t}\n}\n").unwrap();
        let entry = json.blocks()[1].get("a").unwrap();
        assert_eq!((entry.line, entry.value.numbers()), (3, Some(vec![1.0, 2.5, 1e-3])));

        let message = tree("---\na: 1\n---\na: 2\n---\n").unwrap();
        assert_eq!(message.blocks()[0].get("a").unwrap().value.numbers(), Some(vec![1.0]));
    }

    #[test]
    fn what_is_no_tree_says_so_with_its_line() {
        let error = |text| tree(text).unwrap_err().to_string();
        assert_eq!(error(""), "f: holds no keys");
        assert_eq!(error("just words"), "f: holds no keys");
        assert!(error("a: 1\nb: [1, 2\n").starts_with("f:"), "{}", error("a: 1\nb: [1, 2\n"));
        assert!(error("a: 1\na: 2\n").starts_with("f:2: duplicate"), "{}", error("a: 1\na: 2\n"));
        assert_eq!(
            Tree::parse(b"a: 1\nb: \xff\n", Path::new("f")).unwrap_err().to_string(),
            "f:2: not UTF-8 text"
        );
    }
}
