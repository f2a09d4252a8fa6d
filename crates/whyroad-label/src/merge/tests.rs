//! Changes by JSON pointer: examples, and a property test on random drafts: merging does not depend on the order.

use super::*;
use proptest::prelude::*;
use serde_json::json;

fn set(path: &str, value: Value) -> FieldChange {
    FieldChange { path: path.into(), value, remove: false }
}

#[test]
fn fields_are_set_made_appended_and_taken_away() {
    let mut d = json!({"a": [1, 2]});
    for c in [set("/b/c", json!("x")), set("/a/-", json!(3)), set("/a/0", json!(9)), set("/list/-", json!(1))]
    {
        apply(&mut d, &c).unwrap();
    }
    apply(&mut d, &FieldChange { path: "/a/1".into(), value: Value::Null, remove: true }).unwrap();
    assert_eq!(d, json!({"a": [9, 3], "b": {"c": "x"}, "list": [1]}));
    for bad in ["", "a", "/a/7", "/a/x/y", "/b/c/d"] {
        assert_eq!(apply(&mut d, &set(bad, json!(1))).unwrap_err().code(), "draft.path", "{bad}");
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

#[test]
fn an_element_that_moved_and_looks_like_the_wanted_one_is_another() {
    let gone = FieldChange { path: "/l/0".into(), value: Value::Null, remove: true };
    let theirs = [set("/l/-", json!("n")), gone];
    let mut now = json!({"l": ["p", "q", "r"]});
    theirs.iter().for_each(|c| apply(&mut now, c).unwrap());
    assert_eq!(now, json!({"l": ["q", "r", "n"]}));
    // Mine was about r, which is at another index now.
    assert_eq!(conflicts(&now, &[set("/l/2", json!("n"))], &theirs).len(), 1);
}

/// A path in the draft of the property below; some contain others.
fn places() -> impl Strategy<Value = String> {
    let list = prop_oneof![Just("-".to_owned()), (0..3usize).prop_map(|i| i.to_string())];
    prop_oneof![
        proptest::sample::select(vec!["/a", "/b", "/deep", "/deep/x", "/deep/y", "/list", "/list/1/name"])
            .prop_map(str::to_owned),
        list.prop_map(|last| format!("/list/{last}")),
    ]
}

fn changes() -> impl Strategy<Value = FieldChange> {
    let value =
        prop_oneof![Just(json!(null)), Just(json!("text")), Just(json!(7)), Just(json!({"name": "n"}))];
    (places(), value, proptest::bool::weighted(0.2)).prop_map(|(path, value, remove)| FieldChange {
        // There is nothing to remove behind the last element.
        remove: remove && !path.ends_with("/-"),
        path,
        value,
    })
}

fn all(draft: &Value, lists: [&[FieldChange]; 2]) -> Option<Value> {
    let mut out = draft.clone();
    for change in lists.into_iter().flatten() {
        apply(&mut out, change).ok()?;
    }
    Some(out)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]
    /// Where no conflict is reported, mine on theirs equals theirs on mine: no change is lost. (Two appends differ only
    /// in order, so they are left out.)
    #[test]
    fn what_does_not_conflict_merges_the_same_both_ways(
        mine in proptest::collection::vec(changes(), 1..4),
        theirs in proptest::collection::vec(changes(), 1..4),
    ) {
        let appends = |c: &[FieldChange]| c.iter().any(|c| c.path.ends_with("/-"));
        prop_assume!(!(appends(&mine) && appends(&theirs)));
        let draft = json!({"a": 1, "deep": {"x": 1}, "list": [{"name": "p"}, {"name": "q"}, {"name": "r"}]});
        let Some(now) = all(&draft, [&theirs, &[]]) else { return Ok(()) };
        if conflicts(&now, &mine, &theirs).is_empty() {
            let both = (all(&draft, [&theirs, &mine]), all(&draft, [&mine, &theirs]));
            if let (Some(one), Some(other)) = both {
                prop_assert_eq!(one, other);
            }
        }
    }
}
