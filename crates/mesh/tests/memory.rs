//! The memory for reading a file is bounded by its size, regardless of the counts it announces.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use mesh::MshFile;

/// Counts the bytes of every request. Freed memory is not subtracted, so the count is an upper
/// bound.
struct Counting;

static REQUESTED: AtomicUsize = AtomicUsize::new(0);

// SAFETY: both methods pass their arguments unchanged to the system's allocator, which has the same
// contract; the default `realloc` and `alloc_zeroed` call these two.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        REQUESTED.fetch_add(layout.size(), Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Bytes requested while reading a file, which must be refused.
fn requested(bytes: &[u8]) -> usize {
    let before = REQUESTED.load(Ordering::Relaxed);
    let file = MshFile::parse("file.msh", bytes);
    let after = REQUESTED.load(Ordering::Relaxed);
    assert!(file.is_err());
    after - before
}

#[test]
fn announced_counts_reserve_nothing_beyond_the_size_of_the_file() {
    let padding = "0 ".repeat(5000);
    for count in [
        "5",
        "100",
        "1000",
        "3000",
        "5000",
        "2147483647",
        "99999999999",
        "18446744073709551615",
    ] {
        for section in [
            format!("4.1 0 8\n$EndMeshFormat\n$Nodes\n1 {count} 1 {count}\n3 1 0 {count}\n"),
            format!("4.1 0 8\n$EndMeshFormat\n$Nodes\n{count} 1 1 1\n"),
            format!("4.1 0 8\n$EndMeshFormat\n$Entities\n{count} {count} {count} {count}\n"),
            format!("4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n1 0 0 0 0 0 0 {count} "),
            format!("4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n{count}\n"),
            format!(
                "4.1 0 8\n$EndMeshFormat\n$Nodes\n0 0 0 0\n$EndNodes\n$Elements\n1 {count} 1 {count}\n3 1 4 {count}\n"
            ),
            format!("2.2 0 8\n$EndMeshFormat\n$Nodes\n{count}\n"),
            format!("2.2 0 8\n$EndMeshFormat\n$Nodes\n0\n$EndNodes\n$Elements\n{count}\n"),
            format!("2.2 0 8\n$EndMeshFormat\n$Nodes\n0\n$EndNodes\n$Elements\n1\n1 4 {count} "),
        ] {
            let file = format!("$MeshFormat\n{section}{padding}");
            let bytes = requested(file.as_bytes());
            // A node takes at least 8 bytes of text and 32 of memory; lists of tags grow by
            // doubling; messages are short.
            assert!(
                bytes < 8 * file.len() + 4096,
                "{bytes} for {}: {section}",
                file.len()
            );
        }
    }
}
