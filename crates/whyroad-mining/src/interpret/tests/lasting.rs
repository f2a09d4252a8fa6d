//! `since`, `until` and bridged breaks, by tables worked out by hand from `docs/reference/rules.md`. `a` is
//! `ego.brake`, `b` is `ego.aeb`.

use super::*;

fn flags(signs: &str) -> Column {
    let flag = |c| match c {
        '1' => Tri::True,
        '0' => Tri::False,
        _ => Tri::Unknown,
    };
    Column::Flag(signs.chars().map(flag).collect())
}

fn with_flags(times: &[f64], a: &str, b: &str) -> SignalTable {
    let mut t = table(times, &[]);
    t.frame_columns = BTreeMap::from([("ego.brake".to_owned(), flags(a)), ("ego.aeb".to_owned(), flags(b))]);
    t
}

/// Truth of `text` for these courses of a and b.
fn of(text: &str, a: &str, b: &str) -> String {
    truths(text, &with_flags(&tenths(a.len()), a, b), None)
}

#[test]
fn since_needs_its_beginning_and_no_break_after_it() {
    let text = "ego.brake since ego.aeb";
    // Before the first frame, b may have occurred; after a break in a, it no longer matters.
    assert_eq!(of(text, "11111011", "00100001"), "??111001");
    assert_eq!(of(text, "001", "010"), "011", "at the frame of b itself, a is not asked for");
    assert_eq!(of(text, "1?1", "100"), "1??");
    assert_eq!(of(text, "1?0", "100"), "1?0");
    assert_eq!(of(text, "010", "0?0"), "0?0");
    assert_eq!(of(text, "0", "0"), "0");
}

#[test]
fn until_is_open_where_the_log_ends() {
    let text = "ego.brake until ego.aeb";
    assert_eq!(of(text, "11011", "01000"), "110??", "b may come after the last frame");
    assert_eq!(of(text, "11101", "00000"), "0000?");
    assert_eq!(of(text, "0001", "0001"), "0001", "b at once needs nothing of a");
    assert_eq!(of(text, "1?1", "001"), "??1");
    assert_eq!(of(text, "0?1", "001"), "0?1");
}

#[test]
fn a_time_limit_bounds_how_far_b_is() {
    assert_eq!(of("ego.brake until ego.aeb within 0.2 s", "111111", "000001"), "000111");
    assert_eq!(of("ego.brake until ego.aeb within 0.2 s", "111111", "000000"), "0000??");
    assert_eq!(of("ego.brake since ego.aeb within 0.2 s", "111111", "100000"), "111000");
    assert_eq!(of("ego.brake since ego.aeb within 0.2 s", "101111", "100000"), "100000");
    // In the first 0.2 s, b may have been before the beginning.
    assert_eq!(of("ego.brake since ego.aeb within 0.2 s", "1111", "0000"), "??00");
}

#[test]
fn neither_runs_across_a_gap_in_the_log() {
    // 0.2 s and 0.3 s are lost: the third row is the gap.
    let times = [0.0, 0.1, 0.4, 0.5];
    let t = with_flags(&times, "1111", "1000");
    assert_eq!(truths("ego.brake since ego.aeb", &t, None), "11???");
    let t = with_flags(&times, "1111", "0001");
    assert_eq!(truths("ego.brake until ego.aeb", &t, None), "???11");
    let t = with_flags(&times, "1101", "1000");
    assert_eq!(truths("ego.brake since ego.aeb", &t, None), "11?00", "a broke off after the gap");
}

#[test]
fn short_breaks_are_bridged() {
    let text = "ego.brake for 0.5 s gaps 0.1 s";
    let of = |a: &str| of(text, a, &a.replace(|_| true, "0"));
    assert_eq!(of("00110110000"), "00111110000");
    assert_eq!(of("001100110000"), "000000000000", "a break of 0.2 s is not short");
    assert_eq!(of("0011?110000"), "00111110000", "held or not, the break is short");
    assert_eq!(of("00110?10000"), "00?????0000", "the last but one decides how long the break is");
    // The last frame may be a break that ended just after it.
    assert_eq!(of("0011110"), "00?????");
    assert_eq!(of("00111100"), "00000000");
    assert_eq!(of("000"), "000", "no break: nothing that it could be a break of");
}

#[test]
fn a_short_gap_in_the_log_is_bridged_like_a_break() {
    let times = [0.0, 0.1, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8];
    let t = with_flags(&times, "01111000", "00000000");
    assert_eq!(truths("ego.brake for 0.4 s", &t, None), "0?????000", "one frame was lost");
    assert_eq!(truths("ego.brake for 0.4 s gaps 0.1 s", &t, None), "?11111000");
}

#[test]
fn margins_of_chains_are_those_of_their_weakest_link() {
    // STL: since is the best beginning, each with the worst row after it.
    let mut checker = Checker::new(Catalog::bundled());
    let text = "ego.speed > 5 m/s since ego.speed > 20 m/s";
    let id = checker.condition(&parse::parse(text).unwrap()).unwrap();
    // Scale 5 m/s. a: 4 -> 2 (cut off), 1, 0.2, 1; b: 0.5, -2, -2, -2 (cut off).
    let t = table(&tenths(4), &[22.5, 10.0, 6.0, 10.0]);
    let mut evaluator = Evaluator::new(&checker.program, &t);
    let mut pass = evaluator.pass(None);
    let Series::Truths(t) = evaluator.series(id, &mut pass).as_ref().clone() else { panic!() };
    let rounded: Vec<f64> = t.margin.iter().map(|m| (m * 1e9).round() / 1e9).collect();
    assert_eq!(rounded, [0.5, 0.5, 0.2, 0.2]);
}
