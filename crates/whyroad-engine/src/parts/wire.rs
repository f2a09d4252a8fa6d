//! A mined drive as one line of JSON that is read back exactly: `serde_json` may round the last digit of a number, so
//! numbers are stored beside the text, by their bits, in the order in which they occur.

use crate::mine::MinedDrive;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A mined drive with the bits of its numbers.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Exact {
    drive: Value,
    bits: Vec<u64>,
}

impl Exact {
    /// Of a drive.
    pub fn of(drive: &MinedDrive) -> serde_json::Result<Self> {
        let drive = serde_json::to_value(drive)?;
        let mut bits = Vec::new();
        gather(&drive, &mut bits);
        Ok(Self { drive, bits })
    }

    /// The drive; an error where the bits do not belong to it.
    pub fn read(mut self) -> Result<MinedDrive, String> {
        let mut bits = self.bits.iter();
        put(&mut self.drive, &mut bits)?;
        if bits.next().is_some() {
            return Err("more numbers than places".to_owned());
        }
        serde_json::from_value(self.drive).map_err(|e| e.to_string())
    }
}

fn gather(value: &Value, bits: &mut Vec<u64>) {
    match value {
        Value::Number(n) if n.is_f64() => bits.push(n.as_f64().unwrap_or_default().to_bits()),
        Value::Array(list) => list.iter().for_each(|v| gather(v, bits)),
        Value::Object(fields) => fields.values().for_each(|v| gather(v, bits)),
        _ => {}
    }
}

fn put(value: &mut Value, bits: &mut std::slice::Iter<'_, u64>) -> Result<(), String> {
    match value {
        Value::Number(n) if n.is_f64() => {
            let exact = bits.next().ok_or("fewer numbers than places")?;
            *value = Value::from(f64::from_bits(*exact));
            Ok(())
        }
        Value::Array(list) => list.iter_mut().try_for_each(|v| put(v, bits)),
        Value::Object(fields) => fields.values_mut().try_for_each(|v| put(v, bits)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_come_back_bit_by_bit(numbers in prop::collection::vec(prop::num::f64::NORMAL, 0..20)) {
            let drive = serde_json::json!({"b": numbers, "a": {"z": 1, "y": [true, null, "1.5"]}});
            let mut bits = Vec::new();
            gather(&drive, &mut bits);
            let text = serde_json::to_string(&Exact { drive: drive.clone(), bits }).unwrap();
            let mut read: Exact = serde_json::from_str(&text).unwrap();
            put(&mut read.drive, &mut read.bits.iter()).unwrap();
            prop_assert_eq!(read.drive.to_string(), drive.to_string());
        }
    }

    #[test]
    fn missing_or_surplus_bits_are_an_error() {
        let read = |bits: Vec<u64>| Exact { drive: serde_json::json!([0.5]), bits }.read().unwrap_err();
        assert!(read(vec![]).contains("fewer"));
        assert!(read(vec![1, 2]).contains("more"));
    }
}
