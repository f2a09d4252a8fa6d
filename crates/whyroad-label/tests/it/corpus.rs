//! The corpus of true and faulty labels in both languages (`corpus/*.yaml`, written by hand; structural faults are
//! generated here). A fault counts as found only by a code that names it; a true label must have no finding. Half of
//! the base labels were held out while the checks were tuned: the first run, before any tuning, found 435 of 474 seen
//! and 439 of 474 held-out faults, with 20 of 200 and 15 of 205 false alarms.
#![allow(clippy::print_stdout)] // the table is what a reader wants to see

mod build;
mod faults;
mod fewer_words;

use build::{Base, bases, eleventh, evidence, forms, general, styles, thirteenth, unseen, voices, weak};
use std::collections::BTreeMap;
use whyroad_framework::Framework;
use whyroad_label::check::Checker;
use whyroad_model::{Diagnostic, Severity};

/// Minimum share of faults found, of each half and of each kind with ten or more.
const FOUND: f64 = 0.95;
const FOUND_OF_A_KIND: f64 = 0.80;
/// Maximum share of true labels with a finding.
const FALSE_ALARMS: f64 = 0.05;

/// The same of the half of the third set that was run once; it was 253 of 274 and 11 of 75 then.
const OTHER_HALF: (f64, f64) = (0.94, FALSE_ALARMS);

/// The same of the fifth set; it was 55 of 64 and 12 of 48 when it was first run.
const FIFTH: (f64, f64) = (0.92, FALSE_ALARMS);

/// The same of the sixth set, written by somebody who had not seen the checks; it was 62 of 80 and 20 of 80 then.
const SIXTH: (f64, f64) = (0.86, FALSE_ALARMS);

/// The same of the seventh set, by a third author; it was 61 of 100 and 11 of 100 then.
const SEVENTH: (f64, f64) = (0.92, 0.0);

/// The same of the eighth set, by a fourth author; it was 59 of 100 and 13 of 100 when it was first run.
const EIGHTH: (f64, f64) = (0.87, 0.0);

/// The same of the ninth set, by a fifth author; it was 65 of 100 and 7 of 100 when it was first run.
const NINTH: (f64, f64) = (0.88, 0.01);

/// The same of the tenth set, by a sixth author; it was 56 of 100 and 15 of 100 when it was first run.
const TENTH: (f64, f64) = (0.58, 0.01);

/// The same of the halves of the general set, the second of which is less looked at: 41 of 71 and 15 of 40, 49 of 64
/// and 14 of 42 when they were written.
const GENERAL: [(f64, f64); 2] = [(0.87, FALSE_ALARMS), (0.90, 0.08)];

/// The same of the halves of the set of weak kinds.
const WEAK: [(f64, f64); 2] = [(0.86, 0.0), (0.87, 0.014)];

/// The same of the halves of the eleventh set, the second of which was not improved on: 79 of 232 and 31 of 146, 85 of
/// 227 and 33 of 142 when it was first run.
const ELEVENTH: [(f64, f64); 2] = [(0.70, 0.055), (0.63, 0.078)];

/// The same of the twelfth set, by an eighth author; it was 67 of 100 and 8 of 100 when it was first run.
const TWELFTH: (f64, f64) = (0.77, 0.01);

/// The same of the halves of the thirteenth set, by a ninth author, the second of which was run once: the first was 68
/// of 130 and 9 of 60 when it was first run.
const THIRTEENTH: [(f64, f64); 2] = [(0.61, 0.10), (0.56, 0.15)];

/// The same of the fourteenth set, by a tenth author; it was 79 of 100 and 15 of 100 when it was first run.
const FOURTEENTH: (f64, f64) = (0.87, 0.02);

/// The same of the fifteenth set, by two more authors; it was 68 of 100 and 7 of 100 when it was first run.
const FIFTEENTH: (f64, f64) = (0.89, 0.01);

/// The same of the sixteenth set, by another author; it was 69 of 100 and 17 of 100 when it was first run.
const SIXTEENTH: (f64, f64) = (0.91, 0.0);

/// The same of the seventeenth set, by another author; it was 67 of 100 and 6 of 100 when it was first run.
const SEVENTEENTH: (f64, f64) = (0.95, 0.0);

/// The same of the eighteenth set, by another author, run once with the checks before the work on the seventeenth (57
/// of 100 and 19 of 100) and once after it (65 and 19, 16 of them for records, which its author had not been asked
/// for).
const EIGHTEENTH: (f64, f64) = (0.86, 0.0);

/// The same of the nineteenth set, by another author; it was 70 of 100 and 10 of 100 when it was first run.
const NINETEENTH: (f64, f64) = (0.87, 0.01);

/// The same of the twentieth set, by two other authors, run once with the checks after the work on the nineteenth: 77
/// of 100 and 8 of 100.
const TWENTIETH: (f64, f64) = (0.93, 0.01);

/// The same of the twenty-first set, by another author, run once with the same checks: 38 of 50 and 7 of 50. Words were
/// added for four of the seven since.
const TWENTY_FIRST: (f64, f64) = (0.94, 0.02);

/// The same of the twenty-second set, by another author, run once with the checks of the twenty-first: 38 of 50 and 7
/// of 50. The checks were changed for five of the seven since.
const TWENTY_SECOND: (f64, f64) = (0.90, 0.0);

/// The same of the twenty-third set, by another author, run once with the checks of the twenty-second: 35 of 50 and 4
/// of 50. The words were changed for the four since.
const TWENTY_THIRD: (f64, f64) = (0.86, 0.0);

/// The same of the twenty-fourth set, by another author, run once with the checks of the twenty-third: 37 of 50 and 4
/// of 50. The words were changed for one of the four since.
const TWENTY_FOURTH: (f64, f64) = (0.84, 0.02);

/// The same of the twenty-fifth set, by another author, run once after statements were read by their place: 35 of 50
/// and 4 of 50 (34 and 4 before). The checks were changed for two of the four since.
const TWENTY_FIFTH: (f64, f64) = (0.86, 0.0);

/// The same of the twenty-sixth set, by two other authors, one for each language, run once with the checks before and
/// after words were completed by a thesaurus: 79 of 100 and 14 of 100 both times.
const TWENTY_SIXTH: (f64, f64) = (0.85, 0.02);

/// The same of the twenty-seventh set, by two other authors, one for each language, run once with the checks before and
/// after they were made to ask for evidence: 67 of 100 and 9 of 100, then 67 and 7. Words were changed for six of the
/// seven since.
const TWENTY_SEVENTH: (f64, f64) = (0.83, 0.0);

/// The same of the twenty-eighth set, by two further authors, one for each language, run once, with the checks of the
/// repaired twenty-seventh.
const TWENTY_EIGHTH: (f64, f64) = (0.85, 0.02);

/// The same of the twenty-ninth set, by two further authors, one for each language, run once: 67 of 100 and 11 of 100
/// with the checks of the repaired twenty-eighth, 70 and 12 after the last clauses were read by meaning. The checks
/// were changed for the twelve since.
const TWENTY_NINTH: (f64, f64) = (0.85, 0.0);

/// The same of the thirtieth set, by two further authors, one for each language, run once: 76 of 101 and 9 of 100, as
/// with the checks before the work on the twenty-ninth.
const THIRTIETH: (f64, f64) = (0.75, 0.09);

/// The same of the labels in twelve voices, which were used for development: at first 36 of 60 and 16 of 120.
const VOICES: (f64, f64) = (0.81, 0.034);

/// The same of the labels with three traces each, which were used for development: at first 56 of 76 and 22 of 120.
const EVIDENCE: (f64, f64) = (0.81, 0.042);

/// The same with one word in five missing from the lists; it was 3240 of 3575 and 124 of 1265 before the checks were
/// made to ask what was read.
const UNKNOWN_WORDS: (f64, f64) = (0.93, 0.013);

#[derive(Default)]
struct Tally {
    all: usize,
    found: usize,
    findings: usize,
}

/// Bases with an odd number are the held-out half.
fn is_held_out(base: usize) -> bool {
    base % 2 == 1
}

#[test]
fn faults_are_found_and_true_labels_pass() {
    let checker = Checker::new(Framework::bundled());
    let mut kinds: BTreeMap<&str, [Tally; 2]> = BTreeMap::new();
    let mut halves: [[Tally; 2]; 2] = Default::default();
    for (language, all) in bases() {
        for (i, base) in all.iter().enumerate() {
            let half = usize::from(is_held_out(i));
            for form in forms(base, language) {
                let found = checker.check_text(&form.to_string());
                halves[half][0].all += 1;
                halves[half][0].findings += found.len();
                if !found.is_empty() {
                    halves[half][0].found += 1;
                    let text = form["coc_trace"].as_str().unwrap_or_default();
                    println!("FALSE ALARM [{half}] {}: {} | {text}", found[0].code, found[0].message.en);
                }
            }
            for fault in faults::of(base, language) {
                let found = checker.check_text(&fault.label.to_string());
                let expected = faults::codes(fault.kind);
                let hit = found.iter().any(|d| expected.iter().any(|c| d.code.starts_with(c)));
                for tally in [&mut kinds.entry(fault.kind).or_default()[half], &mut halves[half][1]] {
                    tally.all += 1;
                    tally.found += usize::from(hit);
                    tally.findings += found.len();
                }
                if !hit {
                    let codes: Vec<_> = found.iter().map(|d| d.code).collect();
                    println!("MISSED [{half}] {} ({}): {codes:?} | {}", fault.kind, base.class, fault.what);
                }
            }
        }
    }
    println!("{:<24} {:>12} {:>12} {:>9}", "kind", "seen", "held out", "findings");
    for (kind, [seen, held]) in &kinds {
        let share = |t: &Tally| format!("{}/{}", t.found, t.all);
        let per = (seen.findings + held.findings) as f64 / (seen.all + held.all).max(1) as f64;
        println!("{kind:<24} {:>12} {:>12} {per:>9.2}", share(seen), share(held));
    }
    for (half, [true_labels, faulty]) in halves.iter().enumerate() {
        let name = ["seen", "held out"][half];
        println!(
            "{name}: found {}/{}, false alarms {}/{}, findings per fault {:.2}",
            faulty.found,
            faulty.all,
            true_labels.found,
            true_labels.all,
            faulty.findings as f64 / faulty.all as f64
        );
    }
    let sum = |k: usize| halves[0][k].all + halves[1][k].all;
    assert!(
        kinds.len() >= 25 && sum(1) >= 400 && sum(0) >= 400,
        "{} kinds, {} faults, {} true",
        kinds.len(),
        sum(1),
        sum(0)
    );
    for (kind, [seen, held]) in &kinds {
        let (found, all) = (seen.found + held.found, seen.all + held.all);
        assert!(all < 10 || found as f64 >= FOUND_OF_A_KIND * all as f64, "{kind}: {found} of {all}");
    }
    for [true_labels, faulty] in &halves {
        assert!(faulty.found as f64 >= FOUND * faulty.all as f64);
        assert!(true_labels.found as f64 <= FALSE_ALARMS * true_labels.all as f64);
        assert!(faulty.findings as f64 <= 1.5 * faulty.all as f64, "one finding for one fault");
    }
}

/// Results for the labels of `unseen_*.yaml`, by kind: found, all. Only faults of text and of decision, as they were
/// written; structural faults are in the other test.
fn written(language: &str, all: &[Base], tally: &mut BTreeMap<&'static str, (usize, usize)>) {
    let checker = Checker::new(Framework::bundled());
    let mut note = |kind: &'static str, hit: bool| {
        let t = tally.entry(kind).or_default();
        *t = (t.0 + usize::from(hit), t.1 + 1);
    };
    for base in all {
        for form in forms(base, language).into_iter().step_by(5) {
            let found = checker.check_text(&form.to_string());
            let flagged = found.iter().find(|d| d.severity != Severity::Note);
            note("true label flagged", flagged.is_some());
            note("true label flagged or noted", !found.is_empty());
            if let Some(d) = flagged {
                let text = form["coc_trace"].as_str().unwrap_or_default();
                println!("FALSE ALARM {}: {} | {text}", d.code, d.message.en);
            }
        }
        for fault in faults::written(base, language) {
            let found = checker.check_text(&fault.label.to_string());
            let expected = faults::codes(fault.kind);
            let names = |d: &&Diagnostic| expected.iter().any(|c| d.code.starts_with(c));
            let hit = found.iter().filter(names).any(|d| d.severity != Severity::Note);
            note(fault.kind, hit);
            note("fault found or noted", found.iter().any(|d| names(&d)));
            if !hit {
                if found.iter().any(|d| names(&d)) {
                    println!(
                        "HINT {} ({}): {} | {}",
                        fault.kind, base.class, found[0].message.en, fault.what
                    );
                    continue;
                }
                let codes: Vec<_> = found.iter().map(|d| d.code).collect();
                println!("MISSED {} ({}): {codes:?} | {}", fault.kind, base.class, fault.what);
            }
        }
    }
}

/// Labels that were unseen when their first figures were taken (docs/explanation/label-checks-history.md has those).
/// Here they must not get worse.
#[test]
fn labels_that_were_unseen_stay_found() {
    let [
        first,
        second,
        third,
        fourth,
        fifth,
        sixth,
        seventh,
        eighth,
        ninth,
        tenth,
        twelfth,
        fourteenth,
        fifteenth,
        sixteenth,
        seventeenth,
        eighteenth,
        nineteenth,
        twentieth,
        twenty_first,
        twenty_second,
        twenty_third,
        twenty_fourth,
        twenty_fifth,
        twenty_sixth,
        twenty_seventh,
        twenty_eighth,
        twenty_ninth,
        thirtieth,
    ] = unseen();
    // Of the third set and of the general one the bases with an even number were improved on, the others were run once.
    let half_of = |set: &[(&'static str, Vec<Base>)], odd: usize| -> Vec<(&'static str, Vec<Base>)> {
        set.iter().map(|(l, all)| (*l, all.iter().skip(odd).step_by(2).cloned().collect())).collect()
    };
    let half = |odd| half_of(&third, odd);
    // Of the thirteenth set the first half of each file was improved on.
    let half_by_place = |set: &[(&'static str, Vec<Base>)], first: bool| -> Vec<(&'static str, Vec<Base>)> {
        let part =
            |all: &Vec<Base>| if first { &all[..all.len() / 2] } else { &all[all.len() / 2..] }.to_vec();
        set.iter().map(|(l, all)| (*l, part(all))).collect()
    };
    let thirteenth = thirteenth();
    let sets = [
        ("first set", first, (300, 50), (FOUND, FALSE_ALARMS)),
        ("second set", second, (120, 30), (FOUND, FALSE_ALARMS)),
        ("third set, half that was improved on", half(0), (250, 70), (FOUND, FALSE_ALARMS)),
        ("third set, other half", half(1), (250, 70), OTHER_HALF),
        ("fourth set", fourth, (160, 90), (FOUND, FALSE_ALARMS)),
        ("fifth set", fifth, (55, 48), FIFTH),
        ("sixth set", sixth, (80, 80), SIXTH),
        ("seventh set", seventh, (100, 100), SEVENTH),
        ("eighth set", eighth, (100, 100), EIGHTH),
        ("ninth set", ninth, (100, 100), NINTH),
        ("tenth set", tenth, (100, 100), TENTH),
        ("general set, half that was improved on", half_of(&general(), 0), (50, 40), GENERAL[0]),
        ("general set, other half", half_of(&general(), 1), (50, 40), GENERAL[1]),
        ("weak kinds, half that was improved on", half_of(&weak(), 0), (150, 80), WEAK[0]),
        ("weak kinds, other half", half_of(&weak(), 1), (130, 70), WEAK[1]),
        ("eleventh set, half that was improved on", half_of(&eleventh(), 0), (150, 100), ELEVENTH[0]),
        ("eleventh set, other half", half_of(&eleventh(), 1), (150, 100), ELEVENTH[1]),
        ("twelfth set", twelfth, (100, 100), TWELFTH),
        (
            "thirteenth set, half that was improved on",
            half_by_place(&thirteenth, true),
            (120, 55),
            THIRTEENTH[0],
        ),
        ("thirteenth set, other half", half_by_place(&thirteenth, false), (120, 55), THIRTEENTH[1]),
        ("fourteenth set", fourteenth, (100, 100), FOURTEENTH),
        ("fifteenth set", fifteenth, (100, 100), FIFTEENTH),
        ("sixteenth set", sixteenth, (100, 100), SIXTEENTH),
        ("seventeenth set", seventeenth, (100, 100), SEVENTEENTH),
        ("eighteenth set", eighteenth, (100, 100), EIGHTEENTH),
        ("nineteenth set", nineteenth, (100, 100), NINETEENTH),
        ("twentieth set", twentieth, (100, 100), TWENTIETH),
        ("twenty-first set", twenty_first, (50, 50), TWENTY_FIRST),
        ("twenty-second set", twenty_second, (50, 50), TWENTY_SECOND),
        ("twenty-third set", twenty_third, (50, 50), TWENTY_THIRD),
        ("twenty-fourth set", twenty_fourth, (50, 50), TWENTY_FOURTH),
        ("twenty-fifth set", twenty_fifth, (50, 50), TWENTY_FIFTH),
        ("twenty-sixth set", twenty_sixth, (100, 100), TWENTY_SIXTH),
        ("twenty-seventh set", twenty_seventh, (100, 100), TWENTY_SEVENTH),
        ("twenty-eighth set", twenty_eighth, (95, 95), TWENTY_EIGHTH),
        ("twenty-ninth set", twenty_ninth, (100, 100), TWENTY_NINTH),
        ("thirtieth set", thirtieth, (100, 100), THIRTIETH),
        ("twelve voices", voices(), (60, 120), VOICES),
        ("three voices each", evidence(), (70, 120), EVIDENCE),
    ];
    let mut worse = Vec::new();
    for (name, bases, least, (found_of, flagged_of)) in &sets {
        println!("{name}");
        let mut tally = BTreeMap::new();
        for (language, all) in bases {
            written(language, all, &mut tally);
        }
        let flagged = tally.remove("true label flagged").unwrap();
        let [noted, found_or_noted] =
            ["true label flagged or noted", "fault found or noted"].map(|k| tally[k].0);
        tally.retain(|kind, _| !kind.ends_with("or noted"));
        let (found, all) = tally.values().fold((0, 0), |a, t| (a.0 + t.0, a.1 + t.1));
        for (kind, (found, all)) in &tally {
            println!("{kind:<24} {found:>4}/{all}");
        }
        println!("found {found}/{all}, true labels flagged {}/{}", flagged.0, flagged.1);
        println!("with notes: found {found_or_noted}, flagged {noted}");
        assert!(all >= least.0 && flagged.1 >= least.1);
        let share = |(some, all): (usize, usize)| some as f64 / all as f64;
        if share((found, all)) < *found_of || share(flagged) > *flagged_of {
            worse.push(*name);
        }
    }
    assert!(worse.is_empty(), "{worse:?}");
}

/// With one word in five missing from the lists: text in words that are in no list is neither misread nor taken for
/// empty.
#[test]
fn labels_in_unknown_words_are_left_alone() {
    let (mut all, mut flagged, mut faults, mut found_of) = (0, 0, 0, 0);
    let mut by_code: BTreeMap<&str, usize> = BTreeMap::new();
    let mut by_kind: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    for part in 0..fewer_words::PARTS {
        let framework = fewer_words::without(part);
        let checker = Checker::new(&framework);
        // The first six sets, as in the figures before.
        let sets = unseen().into_iter().take(6).flatten().chain(bases()).chain(general());
        for (language, base) in sets.flat_map(|(l, bases)| bases.into_iter().map(move |b| (l, b))) {
            // The first form of each: all forms with all five parts would take too long.
            for form in forms(&base, language).into_iter().take(1) {
                let found = checker.check_text(&form.to_string());
                all += 1;
                if let Some(d) = found.iter().find(|d| d.severity != Severity::Note) {
                    flagged += 1;
                    *by_code.entry(d.code).or_default() += 1;
                    let text = form["coc_trace"].as_str().unwrap_or_default();
                    println!("FALSE ALARM {}: {} | {text}", d.code, d.message.en);
                }
            }
            for fault in faults::written(&base, language).into_iter().step_by(3) {
                let found = checker.check_text(&fault.label.to_string());
                let expected = faults::codes(fault.kind);
                let named = |d: &Diagnostic| expected.iter().any(|c| d.code.starts_with(c));
                faults += 1;
                let hit = usize::from(found.iter().any(|d| named(d) && d.severity != Severity::Note));
                found_of += hit;
                let kind = by_kind.entry(fault.kind).or_default();
                *kind = (kind.0 + hit, kind.1 + 1);
            }
        }
    }
    println!("one word in five missing: found {found_of}/{faults}, true labels flagged {flagged}/{all}");
    println!("{by_code:?}\n{by_kind:?}");
    assert!(all >= 500 && faults >= 500);
    assert!(
        flagged as f64 <= UNKNOWN_WORDS.1 * all as f64 && found_of as f64 >= UNKNOWN_WORDS.0 * faults as f64
    );
}

/// Twenty true labels per language, terse, chatty and technical.
#[test]
fn true_labels_in_other_styles_pass() {
    let checker = Checker::new(Framework::bundled());
    let (mut all, mut flagged) = (0, 0);
    for (language, bases) in styles() {
        for label in bases.iter().flat_map(|base| forms(base, language).into_iter().take(1)) {
            let found = checker.check_text(&label.to_string());
            let text = label["coc_trace"].as_str().unwrap_or_default();
            all += 1;
            flagged += usize::from(!found.is_empty());
            for d in &found {
                println!("FALSE ALARM {}: {} | {text}", d.code, d.message.en);
            }
        }
    }
    println!("true labels in other styles flagged {flagged}/{all}");
    // It was 5 when they were written, after the checks.
    assert!(all >= 40 && flagged as f64 <= FALSE_ALARMS * all as f64);
}

/// The corpus can fail: a checker without word lists finds none of the faults of text.
#[test]
fn without_words_the_faults_of_text_are_missed() {
    let framework = Framework::bundled().clone().with_reading(|t| t.label_words = Default::default());
    let checker = Checker::new(&framework);
    let of_kind = |kind: &str| -> usize {
        let all = bases();
        let faults = all.iter().flat_map(|(l, bases)| bases.iter().flat_map(|b: &Base| faults::of(b, l)));
        let texts = faults.filter(|f| f.kind == kind);
        texts
            .filter(|f| {
                checker.check_text(&f.label.to_string()).iter().any(|d| d.code == "label.text.hindsight")
            })
            .count()
    };
    assert_eq!(of_kind("hindsight_trace"), 0);
}
