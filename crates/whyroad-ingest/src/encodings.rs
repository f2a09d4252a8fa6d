//! File and message encodings, without any meaning of a data set: bytes in, values out. All of them read untrusted
//! bytes: sizes that a file declares are limited by the bytes it has.

pub(crate) mod bag_records;
pub(crate) mod bzip2;
pub mod can;
pub(crate) mod cdr;
pub(crate) mod cells;
pub(crate) mod columns;
pub(crate) mod compressed;
pub(crate) mod feather;
pub(crate) mod mcap_records;
pub(crate) mod npy;
pub(crate) mod pickle;
pub(crate) mod protobuf;
pub(crate) mod tfrecord;
pub(crate) mod xml;
pub(crate) mod zip_members;
