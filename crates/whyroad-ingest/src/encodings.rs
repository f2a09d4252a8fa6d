//! File and message encodings, without any meaning of a data set: bytes in, values out. All of them read untrusted
//! bytes: sizes that a file declares are limited by the bytes it has.

use crate::file_reader::FileReader;

pub(crate) mod bag_records;
pub(crate) mod bzip2;
pub mod can;
pub(crate) mod cdr;
pub(crate) mod cells;
pub(crate) mod columns;
pub(crate) mod compressed;
pub(crate) mod feather;
pub(crate) mod input;
pub(crate) mod mcap_records;
pub(crate) mod npy;
pub(crate) mod pickle;
pub(crate) mod protobuf;
pub(crate) mod text;
pub(crate) mod tfrecord;
pub(crate) mod xml;
pub(crate) mod zip_members;

/// Readers of one encoding each.
pub(crate) const READERS: &[FileReader] = &[
    bzip2::READER,
    can::READER,
    cdr::READER,
    columns::FEATHER,
    columns::PARQUET,
    compressed::READER,
    bag_records::READER,
    mcap_records::READER,
    npy::READER,
    pickle::READER,
    protobuf::READER,
    tfrecord::READER,
    xml::READER,
    zip_members::READER,
];
