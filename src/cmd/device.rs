//! Where networks are computed.

use crate::ui::Fault;
use dpn_pronet::Device;

/// The device of a build without features.
pub(crate) const CPU: &str = "cpu";

/// Every device by name, and whether this build has it.
const KNOWN: [(&str, bool); 4] = [
    (CPU, true),
    ("ndarray", cfg!(feature = "ndarray")),
    ("wgpu", cfg!(feature = "wgpu")),
    ("cuda", cfg!(feature = "cuda")),
];

/// The device called `name`.
pub(crate) fn parse(name: &str) -> Result<Device, Fault> {
    if let Some(device) = Device::named(name) {
        return Ok(device);
    }
    if KNOWN.iter().any(|(known, _)| *known == name) {
        return Err(Fault::new(format!("this dpn was built without the device `{name}`"))
            .hint(format!("build with `--features {name}`")));
    }
    if name == "flex" {
        return Err(Fault::new("there is no device `flex` since 0.2.0").hint("write `cpu`"));
    }
    let names: Vec<&str> = KNOWN.iter().filter(|(_, built)| *built).map(|(name, _)| *name).collect();
    Err(Fault::new(format!("there is no device `{name}`")).hint(format!("known here: {}", names.join(", "))))
}
