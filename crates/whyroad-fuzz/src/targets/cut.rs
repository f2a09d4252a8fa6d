//! Small seeds: the first rows of a file. What they refer to may be cut away; readers report that and go on.

use serde_json::Value;

/// The first `most` lines.
pub(super) fn lines(text: &[u8], most: usize) -> Vec<u8> {
    text.split_inclusive(|b| *b == b'\n').take(most).flatten().copied().collect()
}

/// Of each element's children of one name the first `most`; for files without CDATA sections and comments with tags.
pub(super) fn xml(text: &[u8], most: usize) -> Vec<u8> {
    let mut out = Vec::new();
    // Names of the children of each open element so far.
    let mut open: Vec<Vec<&[u8]>> = vec![Vec::new()];
    // Depth of the element that is left out with all that is in it.
    let mut left_out: Option<usize> = None;
    for piece in text.split_inclusive(|b| *b == b'>') {
        let start = piece.iter().position(|b| *b == b'<').unwrap_or(piece.len());
        let tag = &piece[start..];
        let name_of = |tag: &'_ [u8]| tag.iter().take_while(|b| !b" />\n\t".contains(b)).count();
        let ends = tag.starts_with(b"</");
        let markup = tag.is_empty() || tag.starts_with(b"<?") || tag.starts_with(b"<!");
        let alone = tag.ends_with(b"/>");
        if !ends && !markup {
            let name = &tag[..name_of(tag)];
            let siblings = open.last_mut().map(|s| {
                s.push(name);
                s.iter().filter(|n| **n == name).count()
            });
            if left_out.is_none() && siblings.is_some_and(|n| n > most) {
                left_out = Some(open.len());
            }
        }
        if left_out.is_none() {
            out.extend(piece);
        }
        if ends {
            open.pop();
        } else if !markup && !alone {
            open.push(Vec::new());
            continue;
        }
        // An element that was left out has ended.
        if !markup && left_out == Some(open.len()) {
            left_out = None;
        }
    }
    out
}

/// Of each array, and of each object with many members, the first `most`.
pub(super) fn json(text: &[u8], most: usize) -> Vec<u8> {
    /// An object with more members is a table, not a record.
    const RECORD: usize = 24;
    fn cut(value: &mut Value, most: usize) {
        match value {
            Value::Array(all) => {
                all.truncate(most);
                all.iter_mut().for_each(|v| cut(v, most));
            }
            Value::Object(all) => {
                let members = if all.len() > RECORD { most } else { all.len() };
                *all = std::mem::take(all).into_iter().take(members).collect();
                all.values_mut().for_each(|v| cut(v, most));
            }
            _ => {}
        }
    }
    let Ok(mut value) = serde_json::from_slice(text) else { return Vec::new() };
    cut(&mut value, most);
    value.to_string().into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_rows_stay() {
        assert_eq!(lines(b"a\nb\nc\n", 2), b"a\nb\n");
        let text = "<?xml?>\n<a><b x='1'><c/><c/></b> <b/><d>t</d><b><c/></b></a>\n";
        let cut = String::from_utf8(xml(text.as_bytes(), 1)).unwrap_or_default();
        assert_eq!(cut, "<?xml?>\n<a><b x='1'><c/></b><d>t</d></a>\n");
        assert_eq!(json(br#"{"a": [1, [2, 3], 4], "b": {"c": 1}}"#, 2), br#"{"a":[1,[2,3]],"b":{"c":1}}"#);
        assert_eq!(json(b"[1, 2]", 1), b"[1]");
    }
}
