//! Where networks are computed.

use crate::ui::Fault;
use burn::tensor::Device;

/// The device of a build without features.
pub(crate) const CPU: &str = "flex";

/// Every device by name, and whether this build has it.
const KNOWN: [(&str, bool); 4] = [
    (CPU, true),
    ("ndarray", cfg!(feature = "ndarray")),
    ("wgpu", cfg!(feature = "wgpu")),
    ("cuda", cfg!(feature = "cuda")),
];

/// The device called `name`, recording gradients.
pub(crate) fn parse(name: &str) -> Result<Device, Fault> {
    let device = match name {
        CPU => Some(Device::flex()),
        #[cfg(feature = "ndarray")]
        "ndarray" => Some(Device::ndarray()),
        #[cfg(feature = "wgpu")]
        "wgpu" => Some(Device::wgpu(burn::tensor::DeviceKind::DefaultDevice)),
        #[cfg(feature = "cuda")]
        "cuda" => Some(Device::cuda(burn::tensor::DeviceIndex::Default)),
        _ => None,
    };
    match device {
        Some(device) => Ok(device.autodiff()),
        None if KNOWN.iter().any(|(known, _)| *known == name) => {
            Err(Fault::new(format!("this dpn was built without the device `{name}`"))
                .hint(format!("build with `--features {name}`")))
        }
        None => {
            let names: Vec<&str> = KNOWN.iter().filter(|(_, built)| *built).map(|(name, _)| *name).collect();
            Err(Fault::new(format!("there is no device `{name}`"))
                .hint(format!("known here: {}", names.join(", "))))
        }
    }
}
