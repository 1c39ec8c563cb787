//! Device buffers with a CPU copy, so that a frame uploads only what changed.

use std::sync::Arc;

use bytemuck::Pod;

use super::{Buffer, Device, Frame, VulkanError};

/// A device-local buffer and a CPU copy of its content as of the last recorded frame.
pub struct Mirror {
    buffer: Arc<Buffer>,
    content: Vec<u8>,
}

impl Mirror {
    /// Creates a zeroed buffer of `size` bytes.
    pub fn new(device: &Arc<Device>, name: &str, size: usize) -> Result<Self, VulkanError> {
        let content = vec![0; size.next_multiple_of(16).max(16)];
        let buffer = Buffer::with_data(device, name, &content)?;
        Ok(Self { buffer: Arc::new(buffer), content })
    }

    /// The buffer.
    pub fn buffer(&self) -> &Arc<Buffer> {
        &self.buffer
    }

    /// Sets the content from byte `offset` on to `data`; uploads the elements that differ and returns their number.
    pub fn update<T: Pod>(
        &mut self,
        frame: &mut Frame<'_>,
        offset: usize,
        data: &[T],
    ) -> Result<usize, VulkanError> {
        let new: &[u8] = bytemuck::cast_slice(data);
        let old = &self.content[offset..offset + new.len()];
        let changed = changed_runs(old, new, size_of::<T>());
        self.content[offset..offset + new.len()].copy_from_slice(new);
        if !changed.is_empty() {
            let bytes: Vec<u8> = changed.iter().flat_map(|&(first, end)| &new[first..end]).copied().collect();
            let runs: Vec<_> = changed.iter().map(|&(first, end)| (offset + first, offset + end)).collect();
            let upload = frame.upload(&bytes)?;
            frame.copy_runs(&upload, &self.buffer, &runs);
        }
        Ok(changed.iter().map(|(first, end)| (end - first) / size_of::<T>()).sum())
    }
}

/// Byte ranges (start, end) of the runs of elements that differ.
fn changed_runs(old: &[u8], new: &[u8], size: usize) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (index, (old, new)) in old.chunks_exact(size).zip(new.chunks_exact(size)).enumerate() {
        let (first, end) = (index * size, (index + 1) * size);
        match runs.last_mut() {
            _ if old == new => {}
            Some(last) if last.1 == first => last.1 = end,
            _ => runs.push((first, end)),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_hold_what_differs_and_no_more() {
        assert_eq!(changed_runs(&[1, 2, 3, 4], &[1, 2, 3, 4], 2), []);
        assert_eq!(changed_runs(&[1, 2, 3, 4, 5, 6, 7, 8], &[0, 2, 3, 0, 5, 6, 7, 0], 2), [(0, 4), (6, 8)]);
    }
}
