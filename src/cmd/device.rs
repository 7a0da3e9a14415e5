//! Where networks are computed.

use crate::ui::Fault;
use dpn_train::Device;

/// The device of a build without features.
pub(crate) const CPU: &str = "cpu";
/// A GPU.
const WGPU: &str = "wgpu";

/// The device called `name`.
pub(crate) fn parse(name: &str) -> Result<Device, Fault> {
    let none = || Fault::new(format!("there is no device `{name}`"));
    match name {
        CPU => Ok(Device::Cpu),
        #[cfg(feature = "wgpu")]
        WGPU => match dpn_gpu::Gpu::open() {
            Ok(gpu) => Ok(Device::Gpu(gpu)),
            Err(error) => Err(Fault::new(error.to_string()).hint(error.hint())),
        },
        #[cfg(not(feature = "wgpu"))]
        WGPU => {
            Err(Fault::new("this dpn was built without the device `wgpu`")
                .hint("build with `--features wgpu`"))
        }
        "cuda" => Err(none().hint("an NVIDIA card too is reached by `wgpu`, through Vulkan")),
        "flex" | "ndarray" => Err(none().hint("write `cpu`")),
        _ if cfg!(feature = "wgpu") => Err(none().hint("known here: cpu, wgpu")),
        _ => Err(none().hint("known here: cpu")),
    }
}
