//! Rules on the stored signals of one drive: rules decided by the file's statistics read no values, the others only the
//! columns of their conditions; columns of moments and requirements are read where there is a match.

use super::prefilter::{Verdict, verdict};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use whyroad_lake::signals::{Range, StoredColumn, StoredDrive, TableKind};
use whyroad_lake::{LakeError, SignalFile};
use whyroad_mining::episode::Found;
use whyroad_mining::episode::kinds::Kinds;
use whyroad_mining::fast::bits::Bits;
use whyroad_mining::fast::numbers::NumberColumn;
use whyroad_mining::fast::truth::Truth;
use whyroad_mining::fast::{Columns, Plan, Search, SignalColumn, Signals};
use whyroad_model::signal::deviation_name;

/// Results of these rules of the plan, in their order, on one drive of a store.
pub fn find_stored(
    plan: &Plan<'_>,
    file: &SignalFile,
    drive: usize,
    rules: &[usize],
) -> Result<Vec<Found>, LakeError> {
    // The signals of a drive that these rules use.
    let spoken_of: BTreeSet<&str> = rules.iter().flat_map(|r| plan.rules[*r].names()).collect();
    let named = spoken_of.into_iter().filter(|n| file.has(drive, n));
    let ranges: BTreeMap<&str, _> = named.map(|n| (n, file.range(drive, n))).collect();
    let known = |range: &Option<Range>| range.is_none_or(|r| r.known > 0);
    let present: BTreeMap<String, bool> =
        ranges.iter().map(|(n, range)| ((*n).to_owned(), known(range))).collect();
    let targets = file.contents().drives[drive].targets.as_slice();
    let StoredDrive { partial, without_boxes, .. } = &file.contents().drives[drive];
    let kinds = Kinds { targets, partial, without_boxes };

    let verdicts: Vec<Verdict> =
        rules.iter().map(|r| verdict(plan, &plan.rules[*r], &ranges, kinds)).collect();
    let open: BTreeSet<&str> = verdicts.iter().filter_map(Verdict::asks).collect();
    let mut columns = read(file, drive, open)?;
    let mut out: Vec<Option<Found>> = Vec::with_capacity(rules.len());
    for (rule, verdict) in rules.iter().zip(verdicts) {
        let subject = plan.rules[*rule].rule.subject;
        out.push(match verdict {
            Verdict::Settled(missing) => Some(Found { episodes: vec![], missing }),
            // It never holds; the only open question is whether that is known for any object that it considers.
            Verdict::SettledIfKnown(signal) => columns.get(&signal).and_then(|column| {
                let of = targets.iter().filter(|t| subject.is_none_or(|s| s.admits(t.class)));
                let rows = of.map(|t| t.first_row..t.first_row + t.frames.len());
                rows.into_iter().any(|rows| column.any_known(rows)).then(Found::default)
            }),
            Verdict::Open => None,
        });
    }
    let left: Vec<usize> = rules.iter().zip(&out).filter(|(_, o)| o.is_none()).map(|(r, _)| *r).collect();
    let wanted: BTreeSet<&str> =
        left.iter().flat_map(|r| &plan.rules[*r].when_signals).map(String::as_str).collect();
    let wanted =
        wanted.into_iter().filter(|s| present.contains_key(*s) && !columns.contains_key(*s)).collect();
    columns.extend(read(file, drive, wanted)?);

    let mut signals = Signals::new(file.times(drive)?, targets, present, columns);
    signals.partial = Cow::Borrowed(partial);
    signals.without_boxes = Cow::Borrowed(without_boxes);
    let search = Search::new(plan, &signals, left);
    let wanted = search.wanted();
    signals.supply(read(file, drive, wanted.iter().map(String::as_str).collect())?);
    let mut found = search.found().into_iter();
    Ok(out.into_iter().map(|settled| settled.or_else(|| found.next()).unwrap_or_default()).collect())
}

/// These signals of a drive, in the evaluator's form, with their standard deviations where they have some.
pub fn read(file: &SignalFile, drive: usize, signals: BTreeSet<&str>) -> Result<Columns<'static>, LakeError> {
    let mut out = Columns::new();
    let of = &file.contents().drives[drive];
    for (scope, rows) in [(TableKind::Frames, of.frames), (TableKind::Targets, of.target_rows())] {
        let asked = || signals.iter().copied().filter(|n| TableKind::of(n) == scope);
        let noisy: Vec<String> = asked().map(deviation_name).filter(|n| file.has(drive, n)).collect();
        let names: Vec<&str> = asked().chain(noisy.iter().map(String::as_str)).collect();
        if names.is_empty() {
            continue;
        }
        for (name, column) in names.iter().zip(file.read(drive, scope, &names)?) {
            out.insert((*name).to_owned(), as_column(column, rows));
        }
    }
    Ok(out)
}

fn as_column(column: StoredColumn, rows: usize) -> SignalColumn<'static> {
    let bits =
        |words: Option<Vec<u64>>| words.map_or_else(|| Bits::ones(rows), |words| Bits::of_words(words, rows));
    match column {
        StoredColumn::Numbers(values, known) => {
            SignalColumn::Numbers(Rc::new(NumberColumn::of_known(values, bits(known))))
        }
        StoredColumn::Flags(yes, known) => {
            let known = bits(known);
            let yes = Bits::of_words(yes, known.count()).spread_over(&known);
            SignalColumn::Packed(Truth::new(yes, known))
        }
        StoredColumn::Words(codes, names) => SignalColumn::Words(Cow::Owned(codes), names),
    }
}

#[cfg(test)]
mod tests;
