//! Where networks learn.

/// The processor, by the kernels of `dpn_pronet`, or a card, by the kernels of `dpn_gpu`.
#[derive(Debug, Clone)]
pub enum Device {
    /// The processor.
    Cpu,
    /// A GPU.
    #[cfg(feature = "wgpu")]
    Gpu(dpn_gpu::Gpu),
}
