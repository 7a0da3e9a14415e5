//! Which of its vectors this machine computes with.

use pulp::Arch;

/// Architecture and widest vectors that the kernels of this workspace use here, `x86_64-v3`: machines that agree in it give the same bits, others sum in
/// another order.
pub fn processor() -> String {
    let vectors = match Arch::new() {
        Arch::Scalar => "scalar",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Arch::V3(_) => "v3",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Arch::V4(_) => "v4",
        #[allow(unreachable_patterns)]
        _ => "vectors",
    };
    format!("{}-{vectors}", std::env::consts::ARCH)
}
