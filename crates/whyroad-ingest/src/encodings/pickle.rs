//! Python pickles as plain data: dicts, lists, numbers, texts and numpy arrays. **Nothing that a pickle names is ever
//! called or imported**: there is a closed list of names whose meaning is known here (numpy's reconstructors, plain
//! containers), and a pickle that asks for any other is refused with that name.
//!
//! Protocols 2 to 5 (PEP 307, 3154, 574; the opcodes of CPython's `pickletools`). Objects live in one arena and refer
//! to each other by number: a pickle that refers to one object a million times costs a million small numbers, cycles
//! are harmless, and nothing recurses over what the file nests. Bytes and texts stay where they are in the file.

use crate::file_reader::FileReader;

mod arena;
mod array;
mod construct;
mod machine;
mod names;
mod reference;
mod value;

pub(crate) use arena::{Pickle, PickleError};
pub(crate) use value::Value;

/// Reads a pickle.
pub(crate) fn read(file: &[u8]) -> Result<Pickle<'_>, PickleError> {
    machine::run(file)
}

/// For [`crate::readers`].
pub(crate) const READER: FileReader = FileReader {
    name: "pickle",
    read: |bytes| read(bytes).is_ok_and(|pickle| pickle.root().entries().is_some_and(|all| all.count() > 0)),
};

#[cfg(test)]
mod tests;
