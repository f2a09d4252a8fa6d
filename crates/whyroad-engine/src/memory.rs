//! Settings of the allocator for freed memory. A drive takes about 100 MB for a moment, in columns of a few hundred
//! kilobytes each. The allocator of the GNU C library returns such memory to the system at once, and a tenth of the
//! time is spent on getting it again, cleared page by page, for the next drive.

use std::hint::black_box;
use std::sync::Once;

/// A little less than the 32 MiB up to which the allocator learns from what is freed.
const LEARNT_BYTES: usize = (32 << 20) - (64 << 10);

/// Lets the allocator keep up to 64 MiB of freed memory for each thread. The GNU C library learns it from one large
/// piece that is freed: pieces as large come from memory that is kept from then on (mallopt(3), "dynamic mmap
/// threshold"). With other allocators nothing changes. Nothing is written to the piece, so that it takes no memory.
pub fn keep_freed() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| drop(black_box(Vec::<u8>::with_capacity(LEARNT_BYTES))));
}
