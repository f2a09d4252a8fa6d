//! Stored signals: what is written is read, bit by bit; what the files promise is checked; a store of other content
//! or another version is ignored.

use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::metadata::{ParquetMetaDataReader, RowGroupMetaData};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use whyroad_lake::signals::{Range, TableKind, write_signals};
use whyroad_lake::{Lake, LakeError, SignalFile};
use whyroad_model::column::UNKNOWN_CODE;
use whyroad_model::scene::DriveMeta;
use whyroad_model::signal::TargetSpan;
use whyroad_model::{Column, Drive, FrameRange, Nanos, Need, ObjectClass, SignalTable, Tri};

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![3 => any::<f64>(), 2 => (-3i32..3).prop_map(f64::from), 1 => Just(f64::NAN), 1 => Just(f64::INFINITY)]
}

fn tri() -> impl Strategy<Value = Tri> {
    prop_oneof![Just(Tri::True), Just(Tri::False), Just(Tri::Unknown)]
}

fn columns(prefix: &str, rows: &[(f64, Tri, usize)]) -> BTreeMap<String, Column> {
    let names = ["none".to_owned(), "left".to_owned(), "right".to_owned()].into();
    let code = |c: &usize| if *c == 3 { UNKNOWN_CODE } else { *c as u16 };
    BTreeMap::from([
        (format!("{prefix}.n"), Column::Number(rows.iter().map(|r| r.0).collect())),
        (format!("{prefix}.f"), Column::Flag(rows.iter().map(|r| r.1).collect())),
        (format!("{prefix}.c"), Column::Category { codes: rows.iter().map(|r| code(&r.2)).collect(), names }),
    ])
}

pub(crate) fn table() -> impl Strategy<Value = SignalTable> {
    let row = || (number(), tri(), 0usize..4);
    let spans = prop::collection::vec((0usize..20, 1usize..20), 0..4);
    (prop::collection::vec(row(), 1..40), prop::collection::vec(row(), 80), spans).prop_map(
        |(frames, rows, spans)| {
            let n = frames.len();
            let mut table = SignalTable {
                drive_id: "d".into(),
                times: (0..n as i64).map(|i| Nanos(1_700_000_000_000_000_000 + i * 100_196_000)).collect(),
                frame_columns: columns("ego", &frames),
                unavailable: BTreeMap::from([("light.state".to_owned(), vec![Need::TrafficLights])]),
                ..SignalTable::default()
            };
            let mut first_row = 0;
            for (i, (from, len)) in spans.into_iter().enumerate() {
                let frames = FrameRange::new(from % n, (from % n + len).min(n));
                let id = format!("t{i}").as_str().into();
                table.targets.push(TargetSpan { id, class: ObjectClass::Car, first_row, frames });
                first_row += frames.len();
            }
            table.target_columns = columns("target", &rows[..first_row]);
            table
        },
    )
}

pub(crate) fn same_columns(a: &BTreeMap<String, Column>, b: &BTreeMap<String, Column>) {
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (x, y) in a.values().zip(b.values()) {
        match (x, y) {
            (Column::Number(x), Column::Number(y)) => {
                let bits = |v: &[f64]| {
                    v.iter().map(|x| if x.is_nan() { None } else { Some(x.to_bits()) }).collect::<Vec<_>>()
                };
                assert_eq!(bits(x), bits(y));
            }
            (Column::Flag(x), Column::Flag(y)) => assert_eq!(x, y),
            (Column::Category { codes: x, names: m }, Column::Category { codes: y, names: n }) => {
                assert_eq!((x, m), (y, n));
            }
            _ => panic!("another type"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_is_read(table in table()) {
        let dir = tempfile::tempdir().unwrap();
        write_signals(dir.path(), "v1", &[("hash".to_owned(), &table)]).unwrap();
        let file = SignalFile::open(dir.path()).unwrap().unwrap();
        let read = file.read_table(0).unwrap();
        prop_assert_eq!(&read.times, &table.times);
        prop_assert_eq!(&read.targets, &table.targets);
        prop_assert_eq!(&read.unavailable, &table.unavailable);
        same_columns(&read.frame_columns, &table.frame_columns);
        same_columns(&read.target_columns, &table.target_columns);
        // The statistics are those of the values.
        for (name, column) in table.frame_columns.iter().chain(&table.target_columns) {
            let Some(Range { bounds, known, rows }) = file.range(0, name) else {
                panic!("{name} has no statistics")
            };
            prop_assert_eq!((known, rows), (column.known_count(), column.len()));
            let values = || (0..column.len()).filter_map(|i| match column {
                Column::Number(_) => column.number(i),
                Column::Flag(_) => column.flag(i).known().map(|b| if b { 1.0 } else { 0.0 }),
                Column::Category { .. } => None,
            });
            if let Some((least, greatest)) = bounds {
                prop_assert_eq!(least, values().fold(f64::INFINITY, f64::min));
                prop_assert_eq!(greatest, values().fold(f64::NEG_INFINITY, f64::max));
            }
        }
    }
}

pub(crate) fn one() -> SignalTable {
    let rows = [(1.0, Tri::True, 0), (2.0, Tri::False, 1), (3.0, Tri::Unknown, 2)];
    SignalTable {
        drive_id: "d".into(),
        times: (0..3).map(|i| Nanos(i * 100_000_000)).collect(),
        frame_columns: columns("ego", &rows),
        targets: vec![TargetSpan {
            id: "a".into(),
            class: ObjectClass::Car,
            first_row: 0,
            frames: FrameRange::new(0, 3),
        }],
        target_columns: columns("target", &rows),
        unavailable: BTreeMap::new(),
        partial: BTreeMap::new(),
        without_boxes: [].into(),
        pairs: None,
    }
}

/// Signals some of which have the same values: `a` and `b`, `f` and `g`, `u` and `v`. Zero of the other sign, words of
/// other meaning and a value that is unknown in one row only are other values.
pub(crate) fn with_equal_columns() -> SignalTable {
    let numbers = |values: [f64; 3]| Column::Number(values.to_vec());
    let words = |codes: [u16; 3], names: [&str; 2]| {
        let names: Vec<String> = names.map(str::to_owned).to_vec();
        Column::Category { codes: codes.to_vec(), names: names.into() }
    };
    let columns = [
        ("a", numbers([1.5, f64::NAN, 0.0])),
        ("b", numbers([1.5, -f64::NAN, 0.0])),
        ("c", numbers([1.5, f64::NAN, -0.0])),
        ("d", numbers([1.5, 2.5, 0.0])),
        ("f", Column::Flag(vec![Tri::Unknown, Tri::True, Tri::False])),
        ("g", Column::Flag(vec![Tri::Unknown, Tri::True, Tri::False])),
        ("h", Column::Flag(vec![Tri::False, Tri::True, Tri::False])),
        ("u", words([UNKNOWN_CODE; 3], ["left", "right"])),
        ("v", words([UNKNOWN_CODE; 3], ["near", "far"])),
        ("x", words([0, 1, UNKNOWN_CODE], ["left", "right"])),
        ("y", words([0, 1, UNKNOWN_CODE], ["near", "far"])),
    ];
    let columns = columns.map(|(name, column)| (format!("target.{name}"), column));
    SignalTable { target_columns: BTreeMap::from(columns), ..one() }
}

/// The groups of signals that are at the same place in the file of the targets, by their names, in each row group.
pub(crate) fn shared(dir: &Path) -> Vec<Vec<String>> {
    let file = std::fs::File::open(dir.join("targets.parquet")).unwrap();
    let metadata = ParquetMetaDataReader::new().parse_and_finish(&file).unwrap();
    let of_group = |group: &RowGroupMetaData| {
        let mut places = BTreeMap::<(u64, u64), Vec<&str>>::new();
        for column in group.columns() {
            places.entry(column.byte_range()).or_default().push(&column.column_path().parts()[0]);
        }
        places.into_values().filter(|names| names.len() > 1).map(|names| names.join(" ")).collect()
    };
    metadata.row_groups().iter().map(of_group).collect()
}

/// What is shared in [`with_equal_columns`].
pub(crate) const SHARED: [&str; 3] = ["target.a target.b", "target.f target.g", "target.u target.v"];

#[test]
fn equal_columns_are_stored_once_and_read_as_any_others() {
    let dir = tempfile::tempdir().unwrap();
    let table = with_equal_columns();
    write_signals(dir.path(), "v1", &[("h".to_owned(), &table)]).unwrap();
    assert_eq!(shared(dir.path()), [SHARED]);
    let file = SignalFile::open(dir.path()).unwrap().unwrap();
    same_columns(&file.read_table(0).unwrap().target_columns, &table.target_columns);
    for name in ["target.a", "target.b"] {
        let range = Range { bounds: Some((0.0, 1.5)), known: 2, rows: 3 };
        assert_eq!(file.range(0, name), Some(range), "{name}");
    }
    // The common reader, all columns at once and one alone.
    let read = |name: Option<&str>| {
        let file = std::fs::File::open(dir.path().join("targets.parquet")).unwrap();
        let builder = ParquetRecordBatchReaderBuilder::try_new(file).unwrap();
        let columns = builder.parquet_schema().columns().iter().enumerate();
        let leaves = columns.filter(|(_, c)| name.is_none_or(|name| c.path().parts() == [name]));
        let mask = ProjectionMask::leaves(builder.parquet_schema(), leaves.map(|(i, _)| i));
        builder.with_projection(mask).build().unwrap().next().unwrap().unwrap()
    };
    let whole = read(None);
    assert_eq!(whole.num_columns(), 4 + table.target_columns.len());
    for name in ["target.a", "target.b"] {
        let column = whole.column_by_name(name).unwrap();
        let values: Vec<Option<f64>> = column.as_primitive::<Float64Type>().iter().collect();
        assert_eq!(values, [Some(1.5), None, Some(0.0)], "{name}");
        assert_eq!(read(Some(name)).column(0), column);
    }
}

#[test]
fn what_is_equal_in_one_drive_need_not_be_in_another() {
    let dir = tempfile::tempdir().unwrap();
    let (a, mut b) = (with_equal_columns(), SignalTable { drive_id: "e".into(), ..with_equal_columns() });
    b.target_columns.insert("target.b".to_owned(), Column::Number(vec![7.0; 3]));
    b.target_columns.insert("target.d".to_owned(), Column::Number(vec![7.0; 3]));
    write_signals(dir.path(), "v1", &[("h".to_owned(), &a), ("h".to_owned(), &b)]).unwrap();
    assert_eq!(shared(dir.path()), [SHARED, ["target.b target.d", "target.f target.g", "target.u target.v"]]);
    let file = SignalFile::open(dir.path()).unwrap().unwrap();
    same_columns(&file.read_table(0).unwrap().target_columns, &a.target_columns);
    same_columns(&file.read_table(1).unwrap().target_columns, &b.target_columns);
}

#[test]
fn several_drives_are_a_row_group_each() {
    let dir = tempfile::tempdir().unwrap();
    let (a, b) = (one(), SignalTable { drive_id: "e".into(), ..one() });
    write_signals(dir.path(), "v1", &[("h".to_owned(), &a), ("h".to_owned(), &b)]).unwrap();
    let file = SignalFile::open(dir.path()).unwrap().unwrap();
    assert_eq!(file.contents().drives.len(), 2);
    assert_eq!(file.read_table(1).unwrap().drive_id, "e".into());
    // The order of the rows is checked on the first read only; what is read does not depend on it.
    let fresh = SignalFile::open(dir.path()).unwrap().unwrap();
    let first = fresh.read(1, TableKind::Targets, &["target.n"]).unwrap();
    assert_eq!(first.len(), 1);
    assert_eq!(fresh.read(1, TableKind::Targets, &["target.n"]).unwrap(), first);
    assert_eq!(file.read(1, TableKind::Targets, &["target.n"]).unwrap(), first);
}

#[test]
fn tables_of_other_drives_are_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let mut table = one();
    // The object is said to begin a frame later than the rows that are stored for it.
    write_signals(dir.path(), "v1", &[("h".to_owned(), &table)]).unwrap();
    let before = std::fs::read(dir.path().join("frames.parquet")).unwrap();
    table.times.push(Nanos(300_000_000));
    table.targets[0].frames = FrameRange::new(1, 4);
    for column in table.frame_columns.values_mut() {
        *column = match column.clone() {
            Column::Number(mut v) => {
                v.push(0.0);
                Column::Number(v)
            }
            Column::Flag(mut v) => {
                v.push(Tri::True);
                Column::Flag(v)
            }
            Column::Category { mut codes, names } => {
                codes.push(0);
                Column::Category { codes, names }
            }
        };
    }
    write_signals(dir.path(), "v1", &[("h".to_owned(), &table)]).unwrap();
    // One table of each: they are not of the same drives.
    std::fs::write(dir.path().join("frames.parquet"), before).unwrap();
    assert!(matches!(SignalFile::open(dir.path()), Err(LakeError::TableBroken { .. })));
}

#[test]
fn a_store_of_other_content_or_version_is_none() {
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path().join("lake")).unwrap();
    let drive = |hash: &str| Drive {
        meta: DriveMeta { drive_id: "d".into(), content_hash: hash.into(), ..DriveMeta::default() },
        times: one().times,
        ..Drive::default()
    };
    lake.write_drive(&drive("h1")).unwrap();
    let id = "d".into();
    assert!(lake.signals(&id, "v1").unwrap().is_none());
    lake.write_signals(&id, "v1", &one()).unwrap();
    assert!(lake.signals(&id, "v1").unwrap().is_some());
    assert!(lake.signals(&id, "v2").unwrap().is_none());
    // The drive is whole without them, and they are no drive.
    assert_eq!(lake.drive_ids(), std::slice::from_ref(&id));
    assert_eq!(lake.read_drive(&id).unwrap().times.len(), 3);
    let outline = lake.outline(&id).unwrap();
    assert_eq!(outline.clips, lake.clips(&lake.read_drive(&id).unwrap()));
    // Replaced content takes its signals away; a damaged store is made again.
    lake.write_drive(&drive("h2")).unwrap();
    assert!(lake.signals(&id, "v1").unwrap().is_none());
    lake.write_signals(&id, "v1", &one()).unwrap();
    std::fs::write(dir.path().join("lake/drives/d/signals/targets.parquet"), b"PAR1 not").unwrap();
    assert!(lake.signals(&id, "v1").unwrap().is_none());
}

/// A lake with one drive, `d`.
fn lake_of_one(dir: &Path) -> Lake {
    let lake = Lake::create_or_open(dir.join("lake")).unwrap();
    let meta = DriveMeta { drive_id: "d".into(), content_hash: "h".into(), ..DriveMeta::default() };
    lake.write_drive(&Drive { meta, times: one().times, ..Drive::default() }).unwrap();
    lake
}

/// Names of what is being written.
fn aside(lake: &Lake) -> Vec<String> {
    let entries = std::fs::read_dir(lake.dir().join("unfinished")).unwrap();
    entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn writers_of_the_same_signals_leave_nothing_behind() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake_of_one(dir.path());
    // Each opens the lake by itself, as processes do.
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let lake = Lake::open(lake.dir()).unwrap();
                (0..50).for_each(|_| lake.write_signals(&"d".into(), "v1", &one()).unwrap());
            });
        }
    });
    assert_eq!(aside(&lake), Vec::<String>::new());
    assert!(lake.signals(&"d".into(), "v1").unwrap().is_some());
}

#[cfg(target_os = "linux")]
#[test]
fn storing_signals_removes_those_that_killed_processes_left() {
    let dir = tempfile::tempdir().unwrap();
    let lake = lake_of_one(dir.path());
    let mut child = std::process::Command::new("true").spawn().unwrap();
    child.wait().unwrap();
    let make = |pid: u32| {
        let path = lake.dir().join(format!("unfinished/.signals-{pid}-d"));
        std::fs::create_dir(&path).unwrap();
        let an_hour_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(3600);
        std::fs::File::open(&path).unwrap().set_modified(an_hour_ago).unwrap();
    };
    [child.id(), std::process::id()].into_iter().for_each(make);
    let reader = Lake::open(lake.dir()).unwrap();
    assert_eq!(aside(&lake).len(), 2, "reading changes nothing");
    reader.write_signals(&"d".into(), "v1", &one()).unwrap();
    assert_eq!(aside(&lake), [format!(".signals-{}-d", std::process::id())]);
}

#[test]
fn rows_out_of_order_are_an_error() {
    use parquet::arrow::ArrowWriter;
    use parquet::file::properties::WriterProperties;
    let dir = tempfile::tempdir().unwrap();
    write_signals(dir.path(), "v1", &[("h".to_owned(), &one())]).unwrap();
    let path = dir.path().join("targets.parquet");
    let reader = ParquetRecordBatchReaderBuilder::try_new(std::fs::File::open(&path).unwrap()).unwrap();
    let stated = reader.metadata().file_metadata().key_value_metadata().cloned();
    let batch = reader.build().unwrap().next().unwrap().unwrap();
    let properties = WriterProperties::builder().set_key_value_metadata(stated).build();
    let file = std::fs::File::create(&path).unwrap();
    let mut writer = ArrowWriter::try_new(file, batch.schema(), Some(properties)).unwrap();
    // The first two rows change places; everything that the file says about itself stays.
    for row in [1, 0, 2] {
        writer.write(&batch.slice(row, 1)).unwrap();
    }
    writer.close().unwrap();
    let file = SignalFile::open(dir.path()).unwrap().unwrap();
    // Not only the first time.
    for _ in 0..2 {
        let read = file.read(0, TableKind::Targets, &["target.n"]);
        assert!(matches!(read, Err(LakeError::RowOrder { row: 0, .. })));
    }
}
