//! Work lists: which of the wanted items (groom points or refined vertices) are stale.

use std::ops::Range;

use super::{Gpu, GpuError, Kernel};

/// The passes that fill work lists, with what is to be done or with what is to be changed, and the one that forgets.
pub struct Lister {
    to_do: Kernel,
    again: Kernel,
    forget: Kernel,
}

/// Done, where there is only one way to do it.
pub const DONE: u32 = 1;

impl Lister {
    /// Compiles the pass.
    ///
    /// # Errors
    /// [`GpuError::Refused`].
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            to_do: Kernel::new(gpu, "pass/work_list.wgsl", &[])?,
            again: Kernel::new(gpu, "pass/work_list.wgsl", &[("AGAIN", 1.0)])?,
            forget: Kernel::new(gpu, "pass/work_forget.wgsl", &[])?,
        })
    }
}

/// What is done of a fixed number of items, and the list of those to do next.
pub struct WorkList {
    /// Layout of `WorkList` in `shaders/lib/work_list.wgsl`: number of items, then their indices.
    pub items: wgpu::Buffer,
    done: wgpu::Buffer,
    count: u32,
}

impl WorkList {
    /// A list for `count` items, none of them done.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn new(gpu: &Gpu, label: &str, count: u32) -> Result<Self, GpuError> {
        Ok(Self {
            items: gpu.storage(label, 4 * (u64::from(count.max(1)) + 1))?,
            done: gpu.storage(label, 4 * u64::from(count.max(1)))?,
            count,
        })
    }

    /// All items are stale.
    pub fn forget_all(&self, gpu: &Gpu) {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.forget(&mut encoder, 0..self.count);
        gpu.queue.submit([encoder.finish()]);
    }

    /// The items of `range`, as far as they exist, are stale once `encoder` is submitted.
    pub fn forget(&self, encoder: &mut wgpu::CommandEncoder, range: Range<u32>) {
        let end = range.end.min(self.count);
        if range.start < end {
            let bytes = 4 * u64::from(end - range.start);
            encoder.clear_buffer(&self.done, 4 * u64::from(range.start), Some(bytes));
        }
    }

    /// Items that are marked are stale, and the marks are wiped. Layout of `marks`: a number that is left alone, then u32 an item.
    pub fn forget_marked(&self, gpu: &Gpu, lister: &Lister, marks: &wgpu::Buffer) {
        let bound = lister.forget.bind(gpu, &[(0, marks), (1, &self.done)]);
        lister.forget.run(gpu, &bound, self.count);
    }

    /// Fills the list with the items that are done less well than `level` and that `wanted` (u32 an item) does not hold a 0 for, counts
    /// them as done that well and returns their number.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn collect(
        &self,
        gpu: &Gpu,
        lister: &Lister,
        wanted: &wgpu::Buffer,
        level: u32,
    ) -> Result<u32, GpuError> {
        self.collect_some(gpu, lister, wanted, level, u32::MAX)
    }

    /// The same with no more than `most` of these items; the others stay as they are.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn collect_some(
        &self,
        gpu: &Gpu,
        lister: &Lister,
        wanted: &wgpu::Buffer,
        level: u32,
        most: u32,
    ) -> Result<u32, GpuError> {
        self.list(gpu, &lister.to_do, wanted, [level, most])
    }

    /// Fills the list with the items that are done and wanted, which then count as done no better than `level`, and returns their number;
    /// those that are done and not wanted are stale.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn collect_again(
        &self,
        gpu: &Gpu,
        lister: &Lister,
        wanted: &wgpu::Buffer,
        level: u32,
    ) -> Result<u32, GpuError> {
        self.list(gpu, &lister.again, wanted, [level, u32::MAX])
    }

    fn list(
        &self,
        gpu: &Gpu,
        pass: &Kernel,
        wanted: &wgpu::Buffer,
        [level, most]: [u32; 2],
    ) -> Result<u32, GpuError> {
        let asked = gpu.uniform_of("work asked for", &[level, most, 0, 0]);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.items, 0, Some(4));
        gpu.queue.submit([encoder.finish()]);
        let bound = pass.bind(
            gpu,
            &[(0, wanted), (1, &self.done), (2, &self.items), (3, &asked)],
        );
        pass.run(gpu, &bound, self.count);
        Ok(gpu.read::<u32>(&self.items, 1)?[0])
    }
}
