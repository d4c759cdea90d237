//! An allocator that ends the fuzzer where a small input takes much memory.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Inputs have at most 64 KiB, blocks 8 MiB.
const MAX: usize = 256 << 20;

struct Counted;

static HELD: AtomicUsize = AtomicUsize::new(0);

fn hold(size: usize) {
    let held = HELD.fetch_add(size, Ordering::Relaxed) + size;
    if held > MAX {
        // So that the message itself can be allocated.
        HELD.store(0, Ordering::Relaxed);
        eprintln!("ERROR: the target holds {held} bytes, {size} of them asked for now");
        eprintln!("{}", std::backtrace::Backtrace::force_capture());
        std::process::abort();
    }
}

// SAFETY: all work is done by the system's allocator, with the arguments as they are.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        hold(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        hold(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        hold(size);
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counted = Counted;
