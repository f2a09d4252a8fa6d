//! Where a rule's text stands in its file. The YAML reader tells where a block begins; where in it an
//! expression stands is found by its text, so that a fault is shown on the line that has to be changed.

use crate::language::Fault;
use whyroad_model::{Diagnostic, Location};

/// A block of a file.
#[derive(Clone, Debug)]
pub struct Origin<'a> {
    /// Name of the file.
    pub file: &'a str,
    /// The whole file.
    pub text: &'a str,
    /// Line of the block, from 1.
    pub line: usize,
    /// JSON pointer of what the block belongs to: `/leaves/urgent`, or nothing for the L2.
    pub owner: String,
}

impl Origin<'_> {
    /// The diagnostic for a fault in `expression`, which stands under `key` of the owner.
    pub fn diagnose(&self, key: &str, expression: &str, fault: Fault) -> Diagnostic {
        let pointer = format!("{}{key}", self.owner);
        let start = fault.span.start.min(expression.len());
        let marked = &expression[start..fault.span.end.clamp(start, expression.len())];
        let name = pointer.rsplit('/').next().unwrap_or_default();
        let at = self
            .find(name, expression)
            .map(|i| i + start)
            // An expression that is folded over lines is not found whole, its faulty part is.
            .or_else(|| self.find(name, marked.lines().next().unwrap_or_default()));
        let Some(at) = at else {
            let origin = Location {
                file: Some(self.file.to_owned()),
                line: Some(self.line),
                pointer: Some(pointer),
                ..Location::default()
            };
            return fault.about(expression, &origin);
        };
        let line_start = self.text[..at].rfind('\n').map_or(0, |i| i + 1);
        fault.at(Location {
            file: Some(self.file.to_owned()),
            line: Some(self.text[..at].matches('\n').count() + 1),
            column: Some(self.text[line_start..at].chars().count() + 1),
            pointer: Some(pointer),
            snippet: self.text[line_start..].lines().next().map(str::to_owned),
            snippet_start: 0,
            span: marked.lines().next().unwrap_or_default().chars().count().max(1),
        })
    }

    /// The place of the block itself.
    pub fn place(&self, key: &str) -> Location {
        Location {
            file: Some(self.file.to_owned()),
            line: Some(self.line),
            pointer: Some(format!("{}{key}", self.owner)),
            ..Location::default()
        }
    }

    /// Where a part of the text under the key `name` stands: there, else from the block's line on, else anywhere (a leaf's
    /// rule inherits from the L2's above it). What is the key itself is found as a key.
    fn find(&self, name: &str, part: &str) -> Option<usize> {
        if part.trim().is_empty() {
            return None;
        }
        let block: usize =
            self.text.split_inclusive('\n').take(self.line.saturating_sub(1)).map(str::len).sum();
        let keys = || self.keys(block, name).chain(self.keys(0, name));
        if part == name {
            return keys().next();
        }
        let under = keys().find_map(|key| {
            let value = key + name.len();
            self.text[value..self.end_of(key)].find(part).map(|i| i + value)
        });
        under.or_else(|| self.text[block..].find(part).map(|i| i + block)).or_else(|| self.text.find(part))
    }

    /// Places at which `name` stands as a key, from `start` on.
    fn keys(&self, start: usize, name: &str) -> impl Iterator<Item = usize> {
        let places = self.text[start..].match_indices(name).map(move |(i, _)| start + i);
        places.filter(|_| !name.is_empty()).filter(move |&at| {
            let before = self.text[..at].chars().next_back();
            let after = self.text[at + name.len()..].trim_start_matches(['"', '\'', ' ']);
            before.is_none_or(|c| c.is_whitespace() || "{,\"'".contains(c)) && after.starts_with(':')
        })
    }

    /// Where the value of the key at `key` ends at the latest: before the next line that is not further in.
    fn end_of(&self, key: usize) -> usize {
        let line_start = self.text[..key].rfind('\n').map_or(0, |i| i + 1);
        let depth = indent(&self.text[line_start..]);
        let mut end = line_start;
        for (i, line) in self.text[line_start..].split_inclusive('\n').enumerate() {
            let item = line.trim_start().starts_with("- ");
            if i > 0 && !line.trim().is_empty() && (indent(line) < depth || indent(line) == depth && !item) {
                break;
            }
            end += line.len();
        }
        end
    }
}

fn indent(line: &str) -> usize {
    line.len() - line.trim_start_matches(' ').len()
}
