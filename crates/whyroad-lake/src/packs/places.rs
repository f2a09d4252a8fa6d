//! Where drives are: in folders of their own or in packs, and which packs are held open.

use super::catalog::Catalog;
use super::open_pack::OpenPack;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// What is known of a lake's packs, shared by all clones of a [`crate::Lake`].
#[derive(Debug, Default)]
pub(crate) struct Packs {
    pub(super) catalog: Mutex<Arc<Catalog>>,
    /// The pack used last is first.
    pub(super) open: Mutex<Vec<Arc<OpenPack>>>,
}

/// Where a drive is.
#[derive(Clone, Debug)]
pub(crate) enum Place {
    /// A folder of its own.
    Loose(PathBuf),
    /// A pack, and which drive of it.
    Packed(Arc<OpenPack>, usize),
}

impl PartialEq for Place {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Loose(a), Self::Loose(b)) => a == b,
            (Self::Packed(a, i), Self::Packed(b, j)) => a.dir == b.dir && i == j,
            _ => false,
        }
    }
}

impl Place {
    /// The file of this name, for messages.
    pub fn path(&self, name: &str) -> PathBuf {
        match self {
            Self::Loose(dir) => dir.join(name),
            Self::Packed(pack, _) => pack.dir.join(name),
        }
    }
}
