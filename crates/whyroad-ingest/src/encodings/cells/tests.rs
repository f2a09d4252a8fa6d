use super::*;
use arrow_array::types::Int8Type;
use arrow_array::{
    ArrayRef, BooleanArray, Date32Array, Decimal128Array, DictionaryArray, Float32Array, Float64Array,
    Int32Array, Int64Array, LargeStringArray, NullArray, StringArray, StringViewArray,
    TimestampMicrosecondArray, TimestampNanosecondArray, UInt8Array, UInt64Array,
};
use proptest::prelude::*;
use std::sync::Arc;

fn texts(array: &dyn Array) -> Result<Vec<Option<String>>, String> {
    super::texts(array, &mut { FREE_TEXT })
}

/// The same cells as Arrow's own cast gives.
fn same_as_arrow(array: &ArrayRef) {
    let cast = |to: &DataType| arrow_cast::cast(array, to).unwrap();
    let expected = cast(&DataType::Float64);
    let ours = numbers(array).unwrap();
    for (ours, theirs) in ours.iter().zip(expected.as_primitive::<Float64Type>()) {
        // NaN is not equal to itself.
        assert_eq!(ours.map(f64::to_bits), theirs.map(f64::to_bits), "{}", array.data_type());
    }
    let expected: Vec<Option<i64>> = cast(&DataType::Int64).as_primitive::<Int64Type>().iter().collect();
    assert_eq!(integers(array).unwrap(), expected, "{}", array.data_type());
    let expected = cast(&DataType::Utf8);
    let ours = texts(array).unwrap();
    for (ours, theirs) in ours.iter().zip(expected.as_string::<i32>()) {
        // A float has more than one shortest text (1e16 and 10000000000000000.0; 522911.12 and 522911.13 as an f32).
        let number = |text: Option<&str>| match array.data_type() {
            DataType::Float32 => text.and_then(|t| t.parse().ok()).map(|v: f32| f64::from(v).to_bits()),
            _ => text.and_then(|t| t.parse().ok()).map(f64::to_bits),
        };
        let same = number(ours.as_deref()) == number(theirs) && number(theirs).is_some();
        assert!(ours.as_deref() == theirs || same, "{}: {ours:?} {theirs:?}", array.data_type());
    }
}

proptest! {
    #[test]
    fn cells_of_every_type_are_what_arrow_casts_them_to(
        integers in prop::collection::vec(any::<Option<i64>>(), 0..20),
        floats in prop::collection::vec(any::<Option<f64>>(), 0..20),
        words in prop::collection::vec(prop::option::of("[+-]?[0-9]{0,4}(\\.[0-9]{1,3})?|[a-zé]{0,5}|inf|nan"), 0..20),
    ) {
        let words = || words.iter().map(Option::as_deref);
        let narrow = |v: &Option<i64>| v.map(|v| v as i32);
        let arrays: Vec<ArrayRef> = vec![
            Arc::new(Int64Array::from(integers.clone())),
            Arc::new(Int32Array::from_iter(integers.iter().map(narrow))),
            Arc::new(UInt8Array::from_iter(integers.iter().map(|v| v.map(|v| v as u8)))),
            Arc::new(UInt64Array::from_iter(integers.iter().map(|v| v.map(|v| v as u64)))),
            Arc::new(BooleanArray::from_iter(integers.iter().map(|v| v.map(|v| v % 2 == 0)))),
            Arc::new(Float64Array::from(floats.clone())),
            Arc::new(Float32Array::from_iter(floats.iter().map(|v| v.map(|v| v as f32)))),
            Arc::new(StringArray::from_iter(words())),
            Arc::new(LargeStringArray::from_iter(words())),
            Arc::new(StringViewArray::from_iter(words())),
            Arc::new(words().collect::<DictionaryArray<Int8Type>>()),
        ];
        arrays.iter().for_each(same_as_arrow);
    }

    #[test]
    fn times_are_counted_as_arrow_counts_them(times in prop::collection::vec(any::<Option<i32>>(), 0..20)) {
        let micros = times.iter().map(|t| t.map(|t| i64::from(t) * 1_000_003));
        let arrays: Vec<ArrayRef> = vec![
            Arc::new(TimestampMicrosecondArray::from_iter(micros.clone())),
            Arc::new(TimestampNanosecondArray::from_iter(micros)),
        ];
        for array in &arrays {
            let expected = arrow_cast::cast(array, &DataType::Int64).unwrap();
            let expected: Vec<Option<i64>> = expected.as_primitive::<Int64Type>().iter().collect();
            prop_assert_eq!(integers(array).unwrap(), expected);
        }
    }
}

#[test]
fn times_and_decimals_as_texts() {
    // 2026-11-22 is day 20,779 (date -u -d @$((20779 * 86400))).
    assert_eq!(texts(&Date32Array::from(vec![20_779])).unwrap(), [Some("2026-11-22".to_owned())]);
    let at = TimestampMicrosecondArray::from(vec![Some(1_795_305_600_250_000), None]);
    assert_eq!(texts(&at).unwrap(), [Some("2026-11-22T00:00:00.250".to_owned()), None]);
    let decimals = Decimal128Array::from(vec![-5, 12_345]).with_precision_and_scale(10, 2).unwrap();
    assert_eq!(texts(&decimals).unwrap(), [Some("-0.05".to_owned()), Some("123.45".to_owned())]);
    assert_eq!(numbers(&decimals).unwrap(), [Some(-0.05), Some(123.45)]);
    assert_eq!(integers(&decimals).unwrap(), [Some(0), Some(123)]);
}

#[test]
fn null_columns_and_wrong_types() {
    assert_eq!(numbers(&NullArray::new(2)).unwrap(), [None, None]);
    let lists = arrow_array::ListArray::from_iter_primitive::<Int8Type, _, _>([Some([Some(1_i8)])]);
    let fault = numbers(&lists).unwrap_err();
    assert!(fault.contains("are not a number"), "{fault}");
}

/// 10,000 rows with one text of 8 MB are 80 GB, and 8 MB in the file.
#[test]
fn a_long_text_that_many_rows_share_is_refused() {
    let long = StringArray::from(vec!["x".repeat(8 << 20)]);
    let keys = Int32Array::from(vec![0; 10_000]);
    let shared = DictionaryArray::new(keys.clone(), Arc::new(long));
    assert!(texts(&shared).unwrap_err().contains("repeats"));
    // So are many batches that share a shorter one: 1,000 of 1,000 rows with 64 kB are 64 GB.
    let batch = DictionaryArray::new(
        arrow_array::Int8Array::from(vec![0; 1000]),
        Arc::new(StringArray::from(vec!["x".repeat(64 << 10)])),
    );
    let mut left = FREE_TEXT;
    assert!((0..1000).any(|_| super::texts(&batch, &mut left).is_err()));
    let short = DictionaryArray::new(keys, Arc::new(StringArray::from(vec!["CAR"])));
    assert_eq!(texts(&short).unwrap().len(), 10_000);
}
