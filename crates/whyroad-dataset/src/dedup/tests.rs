//! Deliberately inserted duplicates.

use super::*;
use crate::item::{Cut, DESCRIPTOR, SKETCH};
use crate::records::RecordRef;
use crate::spec::Spec;

fn item(n: u8, class: u32, split: SplitName, first: f32, content: u8) -> Item {
    let mut descriptor = vec![0.0; DESCRIPTOR];
    descriptor[0] = first;
    Item {
        id: [n; 8],
        label: RecordRef::default(),
        other: None,
        episode: None,
        drive: u32::from(n),
        keyframe_ns: 0,
        class,
        status: 0,
        checked: false,
        score: f32::NAN,
        lang: None,
        decision: None,
        dropped: None,
        cut: Some(Box::new(Cut {
            at: RecordRef::default(),
            content: [content; 16],
            descriptor,
            sketch: [0; SKETCH],
            position: None,
            day: 0,
            longitudinal: None,
            lateral: None,
            images: 0,
        })),
        split: Some(split),
        component: 0,
        place_cell: u32::MAX,
        weight: 1.0,
    }
}

fn reasons(items: &[Item]) -> Vec<Option<&str>> {
    items.iter().map(|i| i.dropped.as_ref().map(|d| &*d.reason)).collect()
}

#[test]
fn duplicates_go_inside_an_l2_and_across_splits_whatever_the_l2() {
    use SplitName::{Test, Train, Val};
    let mut classes = Names::default();
    for class in ["a.b.c", "a.b.d", "a.x.y"] {
        classes.put(class);
    }
    let mut items = vec![
        item(1, 0, Train, 0.0, 1),
        // The same content, in training too.
        item(2, 0, Train, 0.0, 1),
        // Near the first, of another leaf of its L2: 0.1 apart in one of 40 numbers.
        item(3, 1, Train, 0.1, 3),
        // Near the first, of another L2, in the same split: stays.
        item(4, 2, Train, 0.1, 4),
        // Far from all.
        item(5, 0, Train, 90.0, 5),
        // Near a test sample of another L2: the training sample is dropped.
        item(6, 0, Train, 50.0, 6),
        item(7, 2, Test, 50.1, 7),
        // Validation against test: the validation sample is dropped.
        item(8, 1, Val, 50.2, 8),
    ];
    let report = deduplicate(&mut items, &classes, &Spec::default().deduplicate);
    assert_eq!(
        reasons(&items),
        [
            None,
            Some("duplicate_exact"),
            Some("duplicate_near"),
            None,
            None,
            Some("duplicate_across"),
            None,
            Some("duplicate_across")
        ]
    );
    assert_eq!((report.exact, report.near_within, report.near_across), (1, 1, 2));
    let dropped: Vec<usize> = report.curve.iter().map(|t| t.within + t.across).collect();
    assert!(dropped.windows(2).all(|w| w[0] >= w[1]), "a stricter threshold never drops more: {dropped:?}");
    assert_eq!(dropped[0], 3);
}

#[test]
fn the_checked_sample_is_kept_and_nothing_goes_when_switched_off() {
    let mut classes = Names::default();
    classes.put("a.b.c");
    let pair = || {
        let mut second = item(2, 0, SplitName::Train, 0.0, 2);
        second.checked = true;
        vec![item(1, 0, SplitName::Train, 0.0, 1), second]
    };
    let mut items = pair();
    deduplicate(&mut items, &classes, &Spec::default().deduplicate);
    assert_eq!(reasons(&items), [Some("duplicate_near"), None]);
    let mut items = pair();
    let spec = Deduplicate { exact: false, near: None, traces: 0.9 };
    deduplicate(&mut items, &classes, &spec);
    assert_eq!(reasons(&items), [None, None]);
}
