//! Small seeds: the first rows of a file. What they refer to may be cut away; readers report that and go on.

use serde_json::Value;

/// The first `most` lines.
pub(super) fn lines(text: &[u8], most: usize) -> Vec<u8> {
    text.split_inclusive(|b| *b == b'\n').take(most).flatten().copied().collect()
}

/// Of each element's children of one name the first `most`; for files without CDATA sections and comments with tags.
pub(super) fn xml(text: &[u8], most: usize) -> Vec<u8> {
    xml_to(text, most, usize::MAX)
}

/// Of the root's children of one name the first `most`, each whole.
pub(super) fn xml_children(text: &[u8], most: usize) -> Vec<u8> {
    xml_to(text, most, 2)
}

/// Down to `depth`, at which the document has depth 0 and its root 1.
fn xml_to(text: &[u8], most: usize, depth: usize) -> Vec<u8> {
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
            if left_out.is_none() && open.len() <= depth && siblings.is_some_and(|n| n > most) {
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

/// Of each array, and of each object with many members, the first `most`. Vectors and matrices stay.
pub(super) fn json(text: &[u8], most: usize) -> Vec<u8> {
    /// An object with more members is a table, not a record.
    const RECORD: usize = 24;
    /// An array with no more numbers is a vector or a matrix.
    const MATRIX: usize = 16;
    fn cut(value: &mut Value, most: usize) {
        match value {
            Value::Array(all) => {
                if all.len() > MATRIX || !all.iter().all(Value::is_number) {
                    all.truncate(most);
                }
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

/// Of each field of a protobuf message the first `most`; the same in fields that can be read as messages, `depth` deep.
/// Tracks and steps stay equally many where they are fields of one number.
pub(super) fn protobuf(message: &[u8], most: usize, depth: usize) -> Vec<u8> {
    let Some(fields) = fields(message) else { return message.to_vec() };
    let mut out = Vec::new();
    let mut seen = std::collections::BTreeMap::<u64, usize>::new();
    for (key, whole, content) in fields {
        let count = seen.entry(key >> 3).or_default();
        *count += 1;
        if *count > most {
            continue;
        }
        match content {
            Some(content) if depth > 0 => {
                let content = protobuf(content, most, depth - 1);
                varint(key, &mut out);
                varint(content.len() as u64, &mut out);
                out.extend(content);
            }
            _ => out.extend(whole),
        }
    }
    out
}

fn varint(mut value: u64, out: &mut Vec<u8>) {
    while value > 0x7f {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

/// Key and all bytes of a field of a message and, of one with a length, its content.
type Field<'a> = (u64, &'a [u8], Option<&'a [u8]>);

/// The fields of a message; `None` for what is no message.
fn fields(message: &[u8]) -> Option<Vec<Field<'_>>> {
    fn number(bytes: &mut &[u8]) -> Option<u64> {
        let mut value = 0;
        for shift in (0..63).step_by(7) {
            let (first, rest) = bytes.split_first()?;
            *bytes = rest;
            value |= u64::from(first & 0x7f) << shift;
            if first & 0x80 == 0 {
                return Some(value);
            }
        }
        // The tenth byte of a negative number.
        *bytes = bytes.get(1..)?;
        Some(value)
    }
    let (mut rest, mut out) = (message, Vec::new());
    while !rest.is_empty() {
        let whole = rest;
        let key = number(&mut rest)?;
        let length = match key & 7 {
            0 => number(&mut rest).map(|_| 0)?,
            1 => 8,
            2 => usize::try_from(number(&mut rest)?).ok()?,
            5 => 4,
            _ => return None,
        };
        let (content, after) = rest.split_at_checked(length)?;
        rest = after;
        out.push((key, &whole[..whole.len() - rest.len()], (key & 7 == 2).then_some(content)));
    }
    Some(out)
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
        let cut = String::from_utf8(xml_children(text.as_bytes(), 1)).unwrap_or_default();
        assert_eq!(cut, "<?xml?>\n<a><b x='1'><c/><c/></b><d>t</d></a>\n");
        assert_eq!(json(br#"{"a": [1, [2, 3], 4], "b": {"c": 1}}"#, 2), br#"{"a":[1,[2,3]],"b":{"c":1}}"#);
        assert_eq!(json(br#"["a", "b"]"#, 1), br#"["a"]"#);
        // Two times field 1 = 150, field 2 = a message of two fields 1.
        let message = b"\x08\x96\x01\x08\x01\x12\x04\x08\x01\x08\x02";
        assert_eq!(protobuf(message, 1, 1), b"\x08\x96\x01\x12\x02\x08\x01");
    }
}
