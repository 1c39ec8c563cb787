//! Huge pages and prefetching, against TLB and cache misses. Neither changes a result.

use std::ops::Deref;
use std::sync::Arc;

use bytemuck::Pod;
use memmap2::{MmapMut, MmapOptions};

/// A shared array with random access, in huge pages where the system has them, which saves TLB misses. Clones share
/// the memory.
#[derive(Clone, Debug)]
pub(crate) struct Pages<T> {
    content: Arc<Content<T>>,
}

#[derive(Debug)]
enum Content<T> {
    Mapped {
        memory: MmapMut,
        bytes: usize,
    },
    /// Fallback for an empty array or a failed mapping.
    Plain(Vec<T>),
}

impl<T: Pod> Pages<T> {
    pub(crate) fn new(values: Vec<T>) -> Self {
        let content = match Self::map(&values) {
            Some(memory) => Content::Mapped { memory, bytes: size_of_val(values.as_slice()) },
            None => Content::Plain(values),
        };
        Self { content: Arc::new(content) }
    }

    #[cfg(target_os = "linux")]
    fn map(values: &[T]) -> Option<MmapMut> {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        let mut memory = MmapOptions::new().len(bytes.len()).map_anon().ok()?;
        memory.advise(memmap2::Advice::HugePage).ok()?;
        memory[..bytes.len()].copy_from_slice(bytes);
        Some(memory)
    }

    #[cfg(not(target_os = "linux"))]
    fn map(_values: &[T]) -> Option<MmapMut> {
        None
    }
}

impl<T> Default for Pages<T> {
    fn default() -> Self {
        Self { content: Arc::new(Content::Plain(Vec::new())) }
    }
}

impl<T: Pod> Deref for Pages<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        match &*self.content {
            Content::Mapped { memory, bytes } => bytemuck::cast_slice(&memory[..*bytes]),
            Content::Plain(values) => values,
        }
    }
}

/// Prefetches the cache lines of `value` into all cache levels.
#[inline(always)]
pub(crate) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    if let Some(sse) = pulp::core_arch::x86::Sse::try_new() {
        let start = std::ptr::from_ref(value).cast::<i8>();
        for line in 0..size_of::<T>().div_ceil(64) {
            sse._mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T0 }>(start.wrapping_add(64 * line));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}
