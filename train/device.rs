//! Where networks learn.

/// The processor, by the kernels of `dpn_pronet` or by burn's plain composition, or a card, by the kernels of `dpn_gpu`.
#[derive(Debug, Clone)]
pub enum Device {
    /// The processor.
    Cpu,
    /// The processor, by burn's ndarray backend.
    #[cfg(feature = "ndarray")]
    Ndarray,
    /// A GPU.
    #[cfg(feature = "wgpu")]
    Gpu(dpn_gpu::Gpu),
}
