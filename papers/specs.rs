//! Noise specs that the paper again names: its columns, controls and drawings.

use dpn_core::estimate::NoiseSpec;

/// The paper's columns of the closed loop.
pub(super) const PAPER: [&str; 4] = ["x0.5", "x1", "x2", "dualpronet"];
/// The baseline.
pub(super) const BASELINE: &str = "x1";
/// The paper's networks.
pub(super) const DUALPRONET: &str = "dualpronet";
/// The truth of what was added.
pub(super) const ORACLE: &str = "oracle";
/// What EuRoC's sensor, an ADIS16448, says in its data sheet: deviations a sample at 200 Hz.
pub(super) const DATA_SHEET: &str = "const(0.0283,0.0024)";
/// A network trained on raw signals and a wide range, beside a constant: what follows added noise best.
pub(super) const WIDE_PLUS: &str = "plus(dualpronet(wide-s0),x4)";

/// A spec that stands in this program, parsed.
pub(super) fn noise(spec: &str) -> NoiseSpec {
    spec.parse().expect("a spec written in this program, held to the grammar by a test")
}

/// Several of them.
pub(super) fn noises<const N: usize>(specs: [&str; N]) -> [NoiseSpec; N] {
    specs.map(noise)
}

/// A control: a root mean square or values at other times, of another's.
pub(super) fn is_control(noise: &NoiseSpec) -> bool {
    matches!(noise, NoiseSpec::Shuffled(_) | NoiseSpec::Mean(_) | NoiseSpec::MeanOfTrain(_))
}

/// Whether networks say the noise, alone or beside a constant.
pub(super) fn is_network(noise: &NoiseSpec) -> bool {
    !is_control(noise) && matches!(noise.source(), NoiseSpec::DualProNet { .. })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn specs_of_the_program_are_written_canonically() {
        for spec in PAPER.into_iter().chain([BASELINE, DUALPRONET, ORACLE, DATA_SHEET, WIDE_PLUS]) {
            assert_eq!(noise(spec).to_string(), spec);
        }
    }

    #[test]
    fn controls_of_a_network_are_no_network() {
        let of = |spec: &str| (is_network(&noise(spec)), is_control(&noise(spec)));
        assert_eq!(of(WIDE_PLUS), (true, false));
        assert_eq!(of("mean-of-train(dualpronet)"), (false, true));
        assert_eq!(of("plus(diff2,x4)"), (false, false));
    }
}
