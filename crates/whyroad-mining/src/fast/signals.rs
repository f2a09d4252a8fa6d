//! Input of the fast evaluator: the columns of one drive, from any source. Borrowed from a
//! [`SignalTable`], or owned as a store decoded them.

use super::layout::{RowLayout, RowSet};
use super::numbers::{NumberColumn, Numbers};
use super::truth::Truth;
use crate::episode::kinds::Kinds;
use crate::language::program::{PairSide, Subject};
use std::borrow::Cow;
use std::cell::{Cell, OnceCell};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::rc::Rc;
use std::sync::Arc;
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::pair::PairTable;
use whyroad_model::signal::{TargetSpan, is_deviation, is_of_object};
use whyroad_model::{Column, Nanos, Need, ObjectClass, SignalTable, Tri};

/// One signal: a value per frame, or a value per row of the targets' table.
#[derive(Debug)]
pub enum SignalColumn<'a> {
    /// Numbers.
    Numbers(Rc<NumberColumn<'a>>),
    /// Truth values.
    Flags(Cow<'a, [Tri]>),
    /// Truth values, packed.
    Packed(Truth),
    /// Codes into names.
    Words(Cow<'a, [u16]>, Arc<[String]>),
}

/// One category per row.
#[derive(Clone, Debug)]
pub struct Words<'a> {
    codes: Rc<Cow<'a, [u16]>>,
    rows: Range<usize>,
    /// The closed set.
    pub names: Arc<[String]>,
}

impl<'a> Words<'a> {
    /// All rows of a column.
    pub fn of(codes: Vec<u16>, names: Arc<[String]>) -> Self {
        let rows = 0..codes.len();
        Self { codes: Rc::new(Cow::Owned(codes)), rows, names }
    }

    /// The codes.
    pub fn codes(&self) -> &[u16] {
        &self.codes[self.rows.clone()]
    }

    /// These rows alone.
    #[must_use]
    pub fn slice(&self, rows: Range<usize>) -> Self {
        let rows = self.rows.start + rows.start..self.rows.start + rows.end;
        Self { codes: self.codes.clone(), rows, names: self.names.clone() }
    }
}

/// The values of a node.
#[derive(Clone, Debug)]
pub enum NodeValue<'a> {
    /// Of a condition.
    Truth(Truth),
    /// Of a number.
    Numbers(Numbers<'a>),
    /// Of a category.
    Words(Words<'a>),
}

impl NodeValue<'_> {
    /// These rows alone.
    #[must_use]
    pub fn slice(&self, rows: Range<usize>) -> Self {
        match self {
            Self::Truth(t) => Self::Truth(t.slice(rows)),
            Self::Numbers(n) => Self::Numbers(n.slice(rows)),
            Self::Words(w) => Self::Words(w.slice(rows)),
        }
    }
}

/// Columns by name.
pub type Columns<'a> = BTreeMap<String, SignalColumn<'a>>;

/// The signals of one drive.
#[derive(Debug, Default)]
pub struct Signals<'a> {
    /// Frame times.
    pub times: Cow<'a, [Nanos]>,
    /// Objects in the order of their rows.
    pub targets: Cow<'a, [TargetSpan]>,
    /// Every signal that the drive has, of frames and targets, and whether any of its values is known.
    pub present: BTreeMap<String, bool>,
    /// As [`SignalTable::partial`].
    pub partial: Cow<'a, BTreeMap<String, Vec<Need>>>,
    /// As [`SignalTable::without_boxes`].
    pub without_boxes: Cow<'a, BTreeSet<ObjectClass>>,
    /// Signals of pairs, where the rules use them.
    pub pairs: Option<&'a PairTable>,
    columns: Columns<'a>,
    more: OnceCell<Columns<'a>>,
    /// True when a column of standard deviations is available.
    noisy: Cell<bool>,
}

impl<'a> Signals<'a> {
    /// The columns that are needed first; [`Signals::supply`] can bring others.
    pub fn new(
        times: impl Into<Cow<'a, [Nanos]>>,
        targets: impl Into<Cow<'a, [TargetSpan]>>,
        present: BTreeMap<String, bool>,
        columns: Columns<'a>,
    ) -> Self {
        let noisy = Cell::new(has_noise(&columns));
        let (times, targets) = (times.into(), targets.into());
        Self { times, targets, present, columns, noisy, ..Self::default() }
    }

    /// All signals of a table, borrowed.
    pub fn of_table(table: &'a SignalTable) -> Self {
        let all = || table.frame_columns.iter().chain(&table.target_columns);
        let named = all().filter(|(n, _)| !is_deviation(n));
        let of_pairs = table.pairs.iter().flat_map(|p| &p.columns).filter(|(n, _)| !is_deviation(n));
        let present = named.chain(of_pairs).map(|(n, c)| (n.clone(), (0..c.len()).any(|i| c.is_known(i))));
        let present = present.collect();
        let columns = all().map(|(n, c)| (n.clone(), SignalColumn::borrowed(c))).collect();
        let signals = Self::new(table.times.as_slice(), table.targets.as_slice(), present, columns);
        let noisy_pairs = table.pairs.iter().flat_map(|p| p.columns.keys()).any(|name| is_deviation(name));
        signals.noisy.set(signals.noisy.get() || noisy_pairs);
        Self {
            pairs: table.pairs.as_ref(),
            partial: Cow::Borrowed(&table.partial),
            without_boxes: Cow::Borrowed(&table.without_boxes),
            ..signals
        }
    }

    /// Whether the drive has a signal, for all objects that `subject` admits.
    pub fn shown_to(&self, subject: Option<Subject>) -> impl Fn(&str) -> bool {
        let kinds =
            Kinds { targets: &self.targets, partial: &self.partial, without_boxes: &self.without_boxes };
        let shown = kinds.shown_to(subject);
        move |signal| self.present.contains_key(signal) && shown(signal)
    }

    /// Columns that turned out to be needed as well. Only the first call supplies them.
    pub fn supply(&self, columns: Columns<'a>) {
        self.noisy.set(self.noisy.get() || has_noise(&columns));
        let _ = self.more.set(columns);
    }

    /// True when some signal has standard deviations.
    pub fn is_noisy(&self) -> bool {
        self.noisy.get()
    }

    /// True when the column is available.
    pub fn holds(&self, name: &str) -> bool {
        self.column(name).is_some()
    }

    /// True when the column is available and has numbers.
    pub fn has_numbers(&self, name: &str) -> bool {
        matches!(self.column(name), Some(SignalColumn::Numbers(_)))
    }

    fn column(&self, name: &str) -> Option<&SignalColumn<'a>> {
        self.columns.get(name).or_else(|| self.more.get()?.get(name))
    }

    /// A flag of an object in a frame that its span covers; `None` where the drive has no such flag.
    pub fn flag_of_object(&self, name: &str, object: usize, frame: usize) -> Option<Tri> {
        let row = self.targets[object].row(frame);
        match self.column(name)? {
            SignalColumn::Flags(values) => Some(row.map_or(Tri::Unknown, |r| values[r])),
            SignalColumn::Packed(truth) => Some(row.map_or(Tri::Unknown, |r| truth.at(r))),
            _ => None,
        }
    }

    /// The values of a signal of pairs on the rows of all pairs; `None` where the drive does not have it.
    pub fn of_pairs(&self, name: &str, side: PairSide, layout: &RowLayout) -> Option<NodeValue<'a>> {
        Some(match self.pairs?.columns.get(name)? {
            Column::Number(values) => {
                NodeValue::Numbers(Numbers::of(layout.of_pairs(values, side, f64::NAN)))
            }
            Column::Flag(values) => NodeValue::Truth(packed(&layout.of_pairs(values, side, Tri::Unknown))),
            Column::Category { codes, names } => {
                NodeValue::Words(Words::of(layout.of_pairs(codes, side, UNKNOWN_CODE), names.clone()))
            }
        })
    }

    /// The values of a signal on a row set; `None` where the drive does not have it.
    pub fn value(&'a self, name: &str, layout: &RowLayout, row_set: RowSet) -> Option<NodeValue<'a>> {
        let column = self.column(name)?;
        let of_target = is_of_object(name);
        Some(match column {
            SignalColumn::Numbers(column) => {
                NodeValue::Numbers(match layout.stored_rows(row_set, of_target, column.len()) {
                    Some(rows) => Numbers::Column(column.clone(), rows),
                    None => Numbers::of(cut(layout, row_set, of_target, column.values(), f64::NAN)),
                })
            }
            SignalColumn::Flags(values) => {
                NodeValue::Truth(packed(&cut(layout, row_set, of_target, values, Tri::Unknown)))
            }
            SignalColumn::Packed(truth) => NodeValue::Truth(cut_packed(layout, row_set, of_target, truth)),
            SignalColumn::Words(codes, names) => {
                let codes = cut(layout, row_set, of_target, codes, UNKNOWN_CODE);
                let rows = 0..codes.len();
                NodeValue::Words(Words { codes: Rc::new(codes), rows, names: names.clone() })
            }
        })
    }
}

impl<'a> SignalColumn<'a> {
    /// True when a value in these rows of the stored column is known.
    pub fn any_known(&self, mut rows: Range<usize>) -> bool {
        match self {
            Self::Numbers(column) => column.known().any_in(rows),
            Self::Flags(values) => rows.any(|i| values[i] != Tri::Unknown),
            Self::Packed(truth) => truth.known.any_in(rows),
            Self::Words(codes, _) => rows.any(|i| codes[i] != UNKNOWN_CODE),
        }
    }

    /// A column of a table, without copying it.
    pub fn borrowed(column: &'a Column) -> Self {
        match column {
            Column::Number(v) => Self::Numbers(Rc::new(NumberColumn::of_rows(v.as_slice()))),
            Column::Flag(v) => Self::Flags(Cow::Borrowed(v)),
            Column::Category { codes, names } => Self::Words(Cow::Borrowed(codes), names.clone()),
        }
    }
}

fn has_noise(columns: &Columns<'_>) -> bool {
    columns.keys().any(|name| is_deviation(name))
}

fn cut<'v, T: Copy>(
    layout: &RowLayout,
    row_set: RowSet,
    of_target: bool,
    values: &'v [T],
    hole: T,
) -> Cow<'v, [T]> {
    if of_target { layout.of_objects(values, row_set, hole) } else { layout.of_frames(values, hole) }
}

fn packed(values: &[Tri]) -> Truth {
    let yes = super::compare::pack_all(values, |t| t == Tri::True);
    Truth::new(yes, super::compare::pack_all(values, |t| t != Tri::Unknown))
}

fn cut_packed(layout: &RowLayout, row_set: RowSet, of_target: bool, truth: &Truth) -> Truth {
    if let Some(rows) = layout.stored_rows(row_set, of_target, truth.len()) {
        return truth.slice(rows);
    }
    // Rows of gaps come in between: rare, so there is no special code for it.
    let values: Vec<Tri> = (0..truth.len()).map(|i| truth.at(i)).collect();
    packed(&cut(layout, row_set, of_target, &values, Tri::Unknown))
}
