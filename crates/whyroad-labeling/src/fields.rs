//! Fields of a draft by JSON pointer (RFC 6901): reading, changing, and merging two people's changes field by field.

use crate::api::wire::task::{FieldChange, FieldConflict};
use crate::problem::{Answer, Problem};
use serde_json::{Map, Value};

/// Greatest size of a draft in bytes.
pub const MAX_DRAFT: usize = 256 * 1024;
/// Most changes of one request.
pub const MAX_CHANGES: usize = 100;

/// Makes one change. Objects on the way are made where they are missing; list elements must be there.
pub fn apply(draft: &mut Value, change: &FieldChange) -> Answer<()> {
    let parts = parts(&change.path)?;
    let wrong = || {
        Problem::new(
            422,
            "draft.path",
            format!("路径 {} 不存在", change.path),
            format!("there is no {}", change.path),
        )
    };
    let Some((last, way)) = parts.split_last() else { return Err(wrong()) };
    let mut at = draft;
    for part in way {
        if at.is_null() {
            *at = Value::Object(Map::new());
        }
        at = match at {
            Value::Object(fields) => fields.entry(part.clone()).or_insert(Value::Null),
            Value::Array(items) => {
                part.parse::<usize>().ok().and_then(|i| items.get_mut(i)).ok_or_else(wrong)?
            }
            _ => return Err(wrong()),
        };
    }
    if at.is_null() {
        *at = if last == "-" { Value::Array(vec![]) } else { Value::Object(Map::new()) };
    }
    match at {
        Value::Object(fields) if change.remove => {
            fields.remove(last);
        }
        Value::Object(fields) => {
            fields.insert(last.clone(), change.value.clone());
        }
        Value::Array(items) if last == "-" && !change.remove => items.push(change.value.clone()),
        Value::Array(items) => {
            let i = last.parse::<usize>().ok().filter(|i| *i < items.len()).ok_or_else(wrong)?;
            if change.remove {
                items.remove(i);
            } else {
                items[i] = change.value.clone();
            }
        }
        _ => return Err(wrong()),
    }
    Ok(())
}

fn parts(path: &str) -> Answer<Vec<String>> {
    if path.len() > 200 || !path.starts_with('/') || path.split('/').count() > 8 {
        return Err(Problem::new(
            422,
            "draft.path",
            format!("'{path}' 不是字段路径"),
            format!("'{path}' is not the path of a field"),
        ));
    }
    Ok(path.split('/').skip(1).map(|p| p.replace("~1", "/").replace("~0", "~")).collect())
}

/// The first part of a path: the field of the label.
pub fn top(path: &str) -> &str {
    path.trim_start_matches('/').split('/').next().unwrap_or_default()
}

/// True when two changes cannot both stand: one's field is the other's or lies in it, or one takes an element out of a
/// list that the other counts on. Two that append do not meet.
fn meet(a: &FieldChange, b: &FieldChange) -> bool {
    if a.path.ends_with("/-") && b.path.ends_with("/-") {
        return false;
    }
    let within = |inner: &str, outer: &str| inner == outer || inner.starts_with(&format!("{outer}/"));
    let list_of = |c: &FieldChange| {
        let (list, last) = c.path.rsplit_once('/').unwrap_or_default();
        (c.remove && last.parse::<usize>().is_ok()).then(|| list.to_owned())
    };
    let shifts = |a: &FieldChange, b: &FieldChange| list_of(a).is_some_and(|list| within(&b.path, &list));
    within(&a.path, &b.path) || within(&b.path, &a.path) || shifts(a, b) || shifts(b, a)
}

/// What of `mine` clashes with `theirs`, which came between; equal values do not.
pub fn conflicts(now: &Value, mine: &[FieldChange], theirs: &[FieldChange]) -> Vec<FieldConflict> {
    let there = |path: &str| now.pointer(path).cloned().unwrap_or(Value::Null);
    mine.iter()
        .filter(|m| theirs.iter().any(|t| meet(m, t)) && (m.remove || now.pointer(&m.path) != Some(&m.value)))
        .map(|m| FieldConflict { path: m.path.clone(), mine: m.value.clone(), theirs: there(&m.path) })
        .collect()
}

/// Top fields in which two drafts differ, sorted.
pub fn differing(a: &Value, b: &Value) -> Vec<String> {
    let (Some(a), Some(b)) = (a.as_object(), b.as_object()) else { return vec![] };
    let mut names: Vec<&String> = a.keys().chain(b.keys()).collect();
    names.sort_unstable();
    names.dedup();
    names.into_iter().filter(|k| a.get(*k) != b.get(*k)).map(|k| format!("/{k}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn set(path: &str, value: Value) -> FieldChange {
        FieldChange { path: path.into(), value, remove: false }
    }

    #[test]
    fn fields_are_set_made_appended_and_taken_away() {
        let mut d = json!({"a": [1, 2]});
        for c in
            [set("/b/c", json!("x")), set("/a/-", json!(3)), set("/a/0", json!(9)), set("/list/-", json!(1))]
        {
            apply(&mut d, &c).unwrap();
        }
        apply(&mut d, &FieldChange { path: "/a/1".into(), value: Value::Null, remove: true }).unwrap();
        assert_eq!(d, json!({"a": [9, 3], "b": {"c": "x"}, "list": [1]}));
        for bad in ["", "a", "/a/7", "/a/x/y", "/b/c/d"] {
            assert_eq!(apply(&mut d, &set(bad, json!(1))).unwrap_err().code, "draft.path", "{bad}");
        }
    }

    #[test]
    fn only_changes_of_one_field_clash() {
        let now = json!({"a": {"b": 1, "c": 2}, "l": [1, 2]});
        let clash = |mine: FieldChange, theirs: FieldChange| !conflicts(&now, &[mine], &[theirs]).is_empty();
        assert!(clash(set("/a/b", json!(5)), set("/a/b", json!(1))));
        assert!(clash(set("/a", json!({})), set("/a/b", json!(1))));
        assert!(!clash(set("/a/b", json!(5)), set("/a/c", json!(2))));
        assert!(!clash(set("/a/b", json!(1)), set("/a/b", json!(1))), "the same value");
        assert!(!clash(set("/ab", json!(5)), set("/a", json!(1))), "a name is no prefix of another");
        assert!(!clash(set("/l/-", json!(5)), set("/l/-", json!(4))), "both append");
        let gone = FieldChange { path: "/l/0".into(), value: Value::Null, remove: true };
        assert!(clash(set("/l/1", json!(5)), gone), "an element that moved");
    }
}
