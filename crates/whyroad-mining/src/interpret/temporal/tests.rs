//! The operators against definitions written out naively, and against properties that hold for every input: more
//! knowledge never contradicts less, time has no origin, negation mirrors.

use super::super::timeline::Timeline;
use super::*;
use proptest::prelude::*;
use whyroad_model::FrameRange;

fn tri() -> impl Strategy<Value = Tri> {
    prop_oneof![3 => Just(Tri::True), 3 => Just(Tri::False), 1 => Just(Tri::Unknown)]
}

/// Times in 10 ms ticks with lost frames and jitter, and one truth per frame.
fn log() -> impl Strategy<Value = (Vec<Nanos>, Vec<Tri>)> {
    prop::collection::vec((prop_oneof![8 => 98i64..=102, 1 => 200i64..700], tri()), 1..40).prop_map(|steps| {
        let mut now = 1_000_000;
        let times = steps
            .iter()
            .map(|(ms, _)| {
                now += ms;
                Nanos(now * 1_000_000)
            })
            .collect();
        (times, steps.into_iter().map(|(_, t)| t).collect())
    })
}

fn duration() -> impl Strategy<Value = Nanos> {
    // Not near a multiple of a frame, so that the clock's tolerance decides nothing here.
    // At least one frame and a half: a past window in which no frame can lie is unknown by definition.
    (1i64..12).prop_map(|k| Nanos(k * 100_000_000 + 50_000_000))
}

fn on_rows(rows: &[Row], frames: &[Tri]) -> Truths {
    Truths::of_flags(rows.iter().map(|r| r.frame.map_or(Tri::Unknown, |f| frames[f])).collect())
}

/// Every possible assignment of the unknown rows.
fn worlds(value: &[Tri]) -> Vec<Vec<bool>> {
    let mut all = vec![vec![]];
    for t in value {
        let options: &[bool] = match t {
            Tri::True => &[true],
            Tri::False => &[false],
            Tri::Unknown => &[true, false],
        };
        all = all
            .into_iter()
            .flat_map(|w: Vec<bool>| options.iter().map(move |o| [w.clone(), vec![*o]].concat()))
            .collect();
    }
    all
}

/// `c for d` with nothing unknown and nothing outside: the row and its neighbors make up `d`.
fn naive_for(c: &[bool], rows: &[Row], d: Nanos, i: usize) -> bool {
    (0..=i).any(|a| {
        (i + 1..=rows.len())
            .any(|b| c[a..b].iter().all(|x| *x) && rows[b - 1].end - rows[a].time + CLOCK_TOLERANCE >= d)
    })
}

fn naive_within(c: &[bool], rows: &[Row], d: Nanos, i: usize) -> bool {
    (i..rows.len()).any(|j| c[j] && rows[j].time - rows[i].time <= d + CLOCK_TOLERANCE)
}

fn naive_previously(c: &[bool], rows: &[Row], d: Nanos, i: usize) -> bool {
    // A gap that reaches into the window is part of it.
    let reaches = |j: usize| rows[j].frame.is_none() && rows[j].end > rows[i].time - d - CLOCK_TOLERANCE;
    (0..i).any(|j| c[j] && (rows[i].time - rows[j].time <= d + CLOCK_TOLERANCE || reaches(j)))
}

/// The result that is equal in all worlds.
fn agreed(answers: impl Iterator<Item = bool>) -> Tri {
    let answers: Vec<bool> = answers.collect();
    match (answers.contains(&true), answers.contains(&false)) {
        (true, false) => Tri::True,
        (false, true) => Tri::False,
        _ => Tri::Unknown,
    }
}

/// Rows of the log with `pad` more frames on either side, as near as the clock's tolerance lets them be, in
/// which the condition is `with`.
fn padded(rows: &[Row], value: &[Tri], pad: usize, with: bool) -> (Vec<Row>, Vec<Tri>) {
    let mut out_rows = Vec::new();
    for k in (1..=pad as i64).rev() {
        let time = rows[0].time - Nanos(STEP.0 * k) + CLOCK_TOLERANCE;
        out_rows.push(Row { time, end: time + STEP, frame: Some(usize::MAX) });
    }
    out_rows.extend_from_slice(rows);
    for k in 0..pad as i64 {
        let time = rows[rows.len() - 1].end + Nanos(STEP.0 * k) - CLOCK_TOLERANCE;
        out_rows.push(Row { time, end: time + STEP, frame: Some(usize::MAX) });
    }
    let edge = vec![Tri::from(with); pad];
    (out_rows, [edge.clone(), value.to_vec(), edge].concat())
}

type Naive = fn(&[bool], &[Row], Nanos, usize) -> bool;

/// The answer that follows from the definition alone: true (false) when it is so in every world, with
/// everything before and after the recording wholly true or wholly false (the operators are monotone, so
/// these two are the extremes).
fn by_definition(naive: Naive, rows: &[Row], value: &[Tri], d: Nanos) -> Vec<Tri> {
    const PAD: usize = 14;
    let per_edge: Vec<_> = [true, false]
        .map(|with| {
            let (rows, value) = padded(rows, value, PAD, with);
            // Monotone operators: all unknown true, and all unknown false, bound every world in between.
            let most: Vec<bool> = value.iter().map(|t| *t != Tri::False).collect();
            let least: Vec<bool> = value.iter().map(|t| *t == Tri::True).collect();
            (rows, most, least)
        })
        .into();
    (0..rows.len())
        .map(|i| {
            agreed(per_edge.iter().flat_map(|(rows, most, least)| {
                [naive(most, rows, d, i + PAD), naive(least, rows, d, i + PAD)]
            }))
        })
        .collect()
}

proptest! {
    #[test]
    fn operators_say_what_their_definitions_say((times, frames) in log(), d in duration()) {
        let rows = Timeline::new(&times).rows;
        let c = on_rows(&rows, &frames);
        prop_assert_eq!(held_for(&c, &rows, d).value, by_definition(naive_for, &rows, &c.value, d));
        prop_assert_eq!(within(&c, &rows, d).value, by_definition(naive_within, &rows, &c.value, d));
        prop_assert_eq!(previously(&c, &rows, Some(d)).value, by_definition(naive_previously, &rows, &c.value, d));
    }

    #[test]
    fn bounds_stand_for_all_worlds(frames in prop::collection::vec(tri(), 1..9), d in duration()) {
        // The shortcut in `by_definition` against every single world, inside the recording.
        let times: Vec<Nanos> = (0..frames.len() as i64).map(|i| Nanos(i * STEP.0)).collect();
        let rows = Timeline::new(&times).rows;
        for naive in [naive_for as Naive, naive_within, naive_previously] {
            for i in 0..rows.len() {
                let all = agreed(worlds(&frames).iter().map(|w| naive(w, &rows, d, i)));
                let most: Vec<bool> = frames.iter().map(|t| *t != Tri::False).collect();
                let least: Vec<bool> = frames.iter().map(|t| *t == Tri::True).collect();
                prop_assert_eq!(all, agreed([naive(&most, &rows, d, i), naive(&least, &rows, d, i)].into_iter()));
            }
        }
    }

    #[test]
    fn a_cut_drive_never_contradicts_the_whole((times, frames) in log(), d in duration(), from in 0usize..40, len in 1usize..40) {
        let whole = Timeline::new(&times);
        let from = from.min(times.len() - 1);
        let to = (from + len).min(times.len());
        let cut = Timeline::new(&times[from..to]);
        let (a, b) = whole.window(FrameRange::new(from, to));
        prop_assume!(b - a == cut.rows.len());
        let has_gap = whole.rows.iter().any(|r| r.frame.is_none());
        let (c_whole, c_cut) = (on_rows(&whole.rows, &frames), on_rows(&cut.rows, &frames[from..to]));
        for op in [
            |c: &Truths, r: &[Row], d| held_for(c, r, d),
            |c: &Truths, r: &[Row], d| within(c, r, d),
            |c: &Truths, r: &[Row], d| previously(c, r, Some(d)),
            |c: &Truths, r: &[Row], _| previously(c, r, None),
            |c: &Truths, _: &[Row], _| c.clone().shifted(),
        ] {
            let (w, k) = (op(&c_whole, &whole.rows, d), op(&c_cut, &cut.rows, d));
            for (i, known) in k.value.iter().enumerate() {
                let whole_answer = w.value[a + i];
                // A gap just outside the cut can leave open what a recorded frame there would settle.
                let open = has_gap && whole_answer == Tri::Unknown;
                prop_assert!(
                    *known == Tri::Unknown || *known == whole_answer || open,
                    "row {}: {:?} against {:?}", i, known, whole_answer
                );
            }
        }
    }

    #[test]
    fn time_has_no_origin((times, frames) in log(), d in duration(), shift in -1_000_000_000_000i64..1_000_000_000_000) {
        let rows = Timeline::new(&times).rows;
        let moved = Timeline::new(&times.iter().map(|t| Nanos(t.0 + shift)).collect::<Vec<_>>()).rows;
        let c = on_rows(&rows, &frames);
        prop_assert_eq!(held_for(&c, &rows, d).value, held_for(&c, &moved, d).value);
        prop_assert_eq!(within(&c, &rows, d).value, within(&c, &moved, d).value);
        prop_assert_eq!(previously(&c, &rows, Some(d)).value, previously(&c, &moved, Some(d)).value);
    }

    #[test]
    fn negation_mirrors_and_is_its_own_inverse(a in prop::collection::vec(tri(), 1..30), b in prop::collection::vec(tri(), 30)) {
        let n = a.len();
        let (a, b) = (Truths::of_flags(a), Truths::of_flags(b[..n].to_vec()));
        prop_assert_eq!(&a.clone().negated().negated().value, &a.value);
        // De Morgan.
        let both = Truths::all(&[a.clone(), b.clone()], n).negated();
        let either: Vec<Tri> = a.value.iter().zip(&b.value).map(|(x, y)| (!*x).or(!*y)).collect();
        prop_assert_eq!(both.value, either);
    }

    #[test]
    fn margins_agree_with_truths((times, frames) in log(), d in duration()) {
        let rows = Timeline::new(&times).rows;
        let c = on_rows(&rows, &frames);
        for t in [held_for(&c, &rows, d), within(&c, &rows, d), previously(&c, &rows, Some(d))] {
            for (v, m) in t.value.iter().zip(&t.margin) {
                let agrees = match v {
                    Tri::True => *m >= 0.0,
                    Tri::False => *m <= 0.0,
                    Tri::Unknown => m.is_nan(),
                };
                prop_assert!(agrees, "{:?} with margin {}", v, m);
            }
        }
    }
}
