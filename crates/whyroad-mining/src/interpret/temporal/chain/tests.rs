//! The chains against definitions written out naively. All are monotone: with every unknown row and everything outside
//! the recording true (false), the answers bound those of every other world.

use super::super::{Row, Truths, previously, within};
use super::*;
use crate::interpret::timeline::Timeline;
use proptest::prelude::*;

fn tri() -> impl Strategy<Value = Tri> {
    prop_oneof![4 => Just(Tri::True), 3 => Just(Tri::False), 1 => Just(Tri::Unknown)]
}

/// Rows at 10 Hz with lost frames, and two truths per row (unknown in the gaps).
fn log() -> impl Strategy<Value = (Vec<Row>, Vec<Tri>, Vec<Tri>)> {
    let frame = (prop_oneof![9 => Just(100i64), 1 => (2i64..6).prop_map(|k| k * 100)], tri(), tri());
    prop::collection::vec(frame, 1..30).prop_map(|steps| {
        let mut now = 0;
        let times: Vec<Nanos> = steps
            .iter()
            .map(|(ms, ..)| {
                now += ms;
                Nanos(now * 1_000_000)
            })
            .collect();
        let rows = Timeline::new(&times).rows;
        let of = |pick: fn(&(i64, Tri, Tri)) -> Tri| {
            rows.iter().map(|r| r.frame.map_or(Tri::Unknown, |f| pick(&steps[f]))).collect()
        };
        let (a, b) = (of(|s| s.1), of(|s| s.2));
        (rows, a, b)
    })
}

/// Not near a multiple of a frame, so that the clock's tolerance decides nothing.
fn duration() -> impl Strategy<Value = Nanos> {
    (1i64..8).prop_map(|k| Nanos(k * 100_000_000 + 50_000_000))
}

const PAD: usize = 10;

fn padded(rows: &[Row]) -> Vec<Row> {
    let step = 100_000_000;
    let row = |time: i64| Row { time: Nanos(time), end: Nanos(time + step), frame: Some(usize::MAX) };
    let before = (1..=PAD as i64).rev().map(|k| row(rows[0].time.0 - k * step));
    let after = (0..PAD as i64).map(|k| row(rows[rows.len() - 1].end.0 + k * step));
    before.chain(rows.iter().copied()).chain(after).collect()
}

/// One world: every unknown, and all outside, is `with`.
fn world(value: &[Tri], with: bool) -> Vec<bool> {
    let inside = value.iter().map(|t| t.known().unwrap_or(with));
    std::iter::repeat_n(with, PAD).chain(inside).chain(std::iter::repeat_n(with, PAD)).collect()
}

type Naive<'n> = dyn Fn(&[Row], &[bool], &[bool], usize) -> bool + 'n;

fn by_definition(naive: &Naive<'_>, rows: &[Row], a: &[Tri], b: &[Tri]) -> Vec<Tri> {
    let all = padded(rows);
    let answer = |with: bool, i: usize| naive(&all, &world(a, with), &world(b, with), i + PAD);
    (0..rows.len())
        .map(|i| match (answer(true, i), answer(false, i)) {
            (_, true) => Tri::True,
            (false, false) => Tri::False,
            (true, false) => Tri::Unknown,
        })
        .collect()
}

fn any_of(x: &Truths, y: &Truths) -> Truths {
    Truths::all(&[x.clone().negated(), y.clone().negated()], x.value.len()).negated()
}

/// A gap that reaches into a window is part of it.
fn reaches(rows: &[Row], j: usize, from: Nanos) -> bool {
    rows[j].frame.is_none() && rows[j].end > from
}

proptest! {
    #[test]
    fn chains_say_what_their_definitions_say((rows, a, b) in log()) {
        let (x, y) = (Truths::of_flags(a.clone()), Truths::of_flags(b.clone()));
        let naive_since: &Naive<'_> = &|_, a, b, i| (0..=i).any(|j| b[j] && (j + 1..=i).all(|k| a[k]));
        let naive_until: &Naive<'_> = &|_, a, b, i| (i..a.len()).any(|j| b[j] && (i..j).all(|k| a[k]));
        prop_assert_eq!(since(&x, &y).value, by_definition(naive_since, &rows, &a, &b));
        prop_assert_eq!(until(&x, &y).value, by_definition(naive_until, &rows, &a, &b));
    }

    #[test]
    fn a_time_limit_is_a_conjunction((rows, a, b) in log(), d in duration()) {
        let (x, y) = (Truths::of_flags(a.clone()), Truths::of_flags(b.clone()));
        let naive_since: &Naive<'_> = &|rows, a, b, i| (0..=i).any(|j| {
            let near = rows[i].time - rows[j].time <= d || reaches(rows, j, rows[i].time - d);
            b[j] && near && (j + 1..=i).all(|k| a[k])
        });
        let naive_until: &Naive<'_> = &|rows, a, b, i| (i..a.len()).any(|j| {
            b[j] && rows[j].time - rows[i].time <= d && (i..j).all(|k| a[k])
        });
        let n = rows.len();
        let recent = any_of(&y, &previously(&y, &rows, Some(d)));
        let bounded = Truths::all(&[recent, since(&x, &y)], n);
        prop_assert_eq!(bounded.value, by_definition(naive_since, &rows, &a, &b));
        let bounded = Truths::all(&[within(&y, &rows, d), until(&x, &y)], n);
        prop_assert_eq!(bounded.value, by_definition(naive_until, &rows, &a, &b));
    }

    #[test]
    fn a_bridge_fills_breaks_and_nothing_else((rows, a, _) in log(), d in duration()) {
        let naive: &Naive<'_> = &|rows, c, _, i| c[i] || (0..i).any(|j| {
            c[j] && (i + 1..rows.len()).any(|k| c[k] && rows[k].time - rows[j].end <= d)
        });
        let c = Truths::of_flags(a.clone());
        let filled = bridged(&c, &rows, d);
        prop_assert_eq!(&filled.value, &by_definition(naive, &rows, &a, &a));
        for (v, m) in filled.value.iter().zip(&filled.margin) {
            let agrees = match v {
                Tri::True => *m >= 0.0,
                Tri::False => *m <= 0.0,
                Tri::Unknown => m.is_nan(),
            };
            prop_assert!(agrees, "{:?} with margin {}", v, m);
        }
    }
}
