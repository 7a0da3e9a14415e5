//! Where networks are computed.

use crate::ui::Fault;
use dpn_train::Device;

/// The device of a build without features.
pub(crate) const CPU: &str = "cpu";
/// burn's older CPU backend.
const NDARRAY: &str = "ndarray";
/// A GPU.
const WGPU: &str = "wgpu";

/// The device called `name`.
pub(crate) fn parse(name: &str) -> Result<Device, Fault> {
    let none = || Fault::new(format!("there is no device `{name}`"));
    match name {
        CPU => Ok(Device::Cpu),
        #[cfg(feature = "ndarray")]
        NDARRAY => Ok(Device::Ndarray),
        #[cfg(feature = "wgpu")]
        WGPU => match dpn_gpu::Gpu::open() {
            Ok(gpu) => Ok(Device::Gpu(gpu)),
            Err(error) => Err(Fault::new(error.to_string()).hint(error.hint())),
        },
        #[cfg(not(feature = "ndarray"))]
        NDARRAY => Err(not_built(NDARRAY)),
        #[cfg(not(feature = "wgpu"))]
        WGPU => Err(not_built(WGPU)),
        "cuda" => Err(none().hint("an NVIDIA card too is reached by `wgpu`, through Vulkan")),
        "flex" => Err(none().hint("write `cpu`")),
        _ => {
            let built = [(NDARRAY, cfg!(feature = "ndarray")), (WGPU, cfg!(feature = "wgpu"))];
            let built = built.iter().filter(|(_, built)| *built).map(|(name, _)| format!(", {name}"));
            Err(none().hint(format!("known here: {CPU}{}", built.collect::<String>())))
        }
    }
}

/// What to do where a device is left out of this build.
#[cfg(not(all(feature = "ndarray", feature = "wgpu")))]
fn not_built(name: &str) -> Fault {
    let release = if name == WGPU { "a release's archive that ends in -wgpu has it, or " } else { "" };
    Fault::new(format!("this dpn was built without the device `{name}`"))
        .hint(format!("{release}build with `--features {name}`"))
}
