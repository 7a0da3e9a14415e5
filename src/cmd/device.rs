//! Where networks are computed.

use crate::ui::Fault;
use dpn_train::Device;

/// The device of a build without features.
pub(crate) const CPU: &str = "cpu";

/// The device called `name`.
pub(crate) fn parse(name: &str) -> Result<Device, Fault> {
    let none = |hint: &str| Fault::new(format!("there is no device `{name}`")).hint(hint);
    match name {
        CPU => Ok(Device::Cpu),
        #[cfg(feature = "wgpu")]
        "wgpu" => match dpn_gpu::Gpu::open() {
            Ok(gpu) => Ok(Device::Gpu(gpu)),
            Err(error) => Err(Fault::new(error.to_string()).hint(error.hint())),
        },
        #[cfg(not(feature = "wgpu"))]
        "wgpu" => Err(Fault::new("this dpn was built without the device `wgpu`")
            .hint("a release's archive that ends in -wgpu has it, or build with `--features wgpu`")),
        "cuda" => Err(none("an NVIDIA card too is reached by `wgpu`, through Vulkan")),
        "flex" | "ndarray" => Err(none("write `cpu`")),
        _ => Err(none(if cfg!(feature = "wgpu") { "known here: cpu, wgpu" } else { "known here: cpu" })),
    }
}
