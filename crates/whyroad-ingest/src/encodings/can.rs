//! Vehicle bus frames to physical values, by a DBC file. Any source with raw CAN uses this; the adapter defines which
//! signal has which meaning on which car.

use crate::file_reader::FileReader;
use can_dbc::{ByteOrder, Dbc, MultiplexIndicator, ValueType};
use std::collections::BTreeMap;

/// A parsed DBC.
pub struct CanDatabase {
    dbc: Dbc,
}

/// How to read one signal out of the frames of one message.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalCoding {
    /// Arbitration id of the message.
    pub address: u32,
    start_bit: usize,
    size: usize,
    big_endian: bool,
    signed: bool,
    factor: f64,
    offset: f64,
    /// Names of raw values (`VAL_`), where the file has them.
    pub names: BTreeMap<i64, String>,
}

impl CanDatabase {
    /// Reads DBC text. The error states what the parser could not read.
    pub fn parse(text: &str) -> Result<Self, String> {
        Dbc::try_from(text).map(|dbc| Self { dbc }).map_err(|e| e.to_string())
    }

    /// The coding of `signal` in `message`; `None` when the file has no such signal or it is multiplexed.
    pub fn signal(&self, message: &str, signal: &str) -> Option<SignalCoding> {
        let message = self.dbc.messages.iter().find(|m| m.name == message)?;
        let s = message.signals.iter().find(|s| s.name == signal)?;
        if s.multiplexer_indicator != MultiplexIndicator::Plain || s.size == 0 || s.size > 64 {
            return None;
        }
        let names = self
            .dbc
            .value_descriptions
            .iter()
            .find_map(|d| match d {
                can_dbc::ValueDescription::Signal { message_id, name, value_descriptions }
                    if *message_id == message.id && *name == s.name =>
                {
                    Some(value_descriptions.iter().map(|v| (v.id, v.description.clone())).collect())
                }
                _ => None,
            })
            .unwrap_or_default();
        Some(SignalCoding {
            // The crate marks extended ids in bit 31; logs carry the plain 29 bits.
            address: message.id.raw() & 0x1FFF_FFFF,
            start_bit: usize::try_from(s.start_bit).ok()?,
            size: usize::try_from(s.size).ok()?,
            big_endian: s.byte_order == ByteOrder::BigEndian,
            signed: s.value_type == ValueType::Signed,
            factor: s.factor,
            offset: s.offset,
            names,
        })
    }
}

impl SignalCoding {
    /// The raw integer in `frame`; `None` when the frame is too short for the signal.
    ///
    /// Bit numbering is the DBC's: bit 0 is the least significant bit of byte 0. A little-endian signal starts at its
    /// least significant bit and runs upwards; a big-endian one starts at its most significant bit and runs down to
    /// bit 0 of a byte, then on at bit 7 of the next.
    pub fn raw(&self, frame: &[u8]) -> Option<i64> {
        let bit = |at: usize| frame.get(at / 8).map(|byte| u64::from(byte >> (at % 8) & 1));
        let mut value = 0_u64;
        let mut at = self.start_bit;
        for i in 0..self.size {
            if self.big_endian {
                value = value << 1 | bit(at)?;
                at = if at.is_multiple_of(8) { at + 15 } else { at - 1 };
            } else {
                value |= bit(at)? << i;
                at += 1;
            }
        }
        if self.signed && self.size < 64 && value >> (self.size - 1) & 1 == 1 {
            value |= u64::MAX << self.size;
        }
        Some(value as i64)
    }

    /// The physical value in the DBC's unit.
    pub fn value(&self, frame: &[u8]) -> Option<f64> {
        self.raw(frame).map(|raw| raw as f64 * self.factor + self.offset)
    }
}

/// For [`crate::readers`].
pub(crate) const READER: FileReader = FileReader {
    name: "can-database",
    read: |bytes| {
        let Ok(database) = CanDatabase::parse(&String::from_utf8_lossy(bytes)) else { return false };
        let all = database.dbc.messages.iter().flat_map(|m| m.signals.iter().map(|s| (&m.name, &s.name)));
        for coding in all.filter_map(|(message, signal)| database.signal(message, signal)) {
            let _ = (coding.value(&[0xa5; 8]), coding.value(&[0x5a; 3]));
        }
        true
    },
};

#[cfg(test)]
mod recorded;
#[cfg(test)]
mod tests {
    use super::*;

    const DBC: &str = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: XXX\n\nBO_ 100 DEMO: 8 XXX\n SG_ MOTOROLA : 7|16@0- (0.01,0) [0|0] \"m/s\" XXX\n SG_ INTEL : 16|12@1+ (0.5,-10) [0|0] \"\" XXX\n SG_ GEAR : 35|4@0+ (1,0) [0|15] \"\" XXX\n\nVAL_ 100 GEAR 0 \"D\" 2 \"R\" ;\n";

    fn signal(name: &str) -> SignalCoding {
        CanDatabase::parse(DBC).unwrap().signal("DEMO", name).unwrap()
    }

    /// Values by hand from the bit layout of the DBC format.
    #[test]
    fn both_byte_orders_signs_and_scales() {
        let frame = [0xFF, 0x9C, 0x34, 0x12, 0x02, 0, 0, 0];
        // 0xFF9C as a signed 16-bit number is -100.
        assert_eq!(signal("MOTOROLA").value(&frame), Some(-1.0));
        // Bits 16..28, least significant first: 0x34 and the low nibble of 0x12 give 0x234 = 564.
        assert_eq!(signal("INTEL").value(&frame), Some(564.0 * 0.5 - 10.0));
        // Bits 35 down to 32 of byte 4.
        let gear = signal("GEAR");
        assert_eq!(gear.raw(&frame), Some(2));
        assert_eq!(gear.names[&2], "R");
        assert_eq!(signal("MOTOROLA").value(&[0xFF]), None);
    }

    #[test]
    fn what_the_file_does_not_have_is_none_and_what_is_no_dbc_is_an_error() {
        assert!(CanDatabase::parse(DBC).unwrap().signal("DEMO", "SPEED").is_none());
        assert!(CanDatabase::parse("<xml/>").is_err());
    }
}
