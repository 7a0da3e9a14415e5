//! `dpn convert`.

use super::{apart, log};
use crate::args::ResampleArgs;
use crate::ui::{errln, outln, refuse};
use anyhow::{Context, Result};
use dpn_core::ImuRecording;
use dpn_core::signal::resample::{PASSES, STOPS, WINDOW_PERIODS, resampled};
use dpn_io::asl::write_imu_rows;
use dpn_io::atomic_write;

pub(crate) fn run(args: &ResampleArgs) -> Result<()> {
    apart::file("--out", args.out.path(), &[&args.log.path])?;
    let mut recording = log::read(&args.log)?.recording.held()?;
    if let Some(to) = args.to_rate {
        let path = args.log.path.display();
        let rate = recording.rate();
        if to.hz() >= rate.hz() {
            let message =
                format!("{path}: the log has {:.1} Hz, and {:.1} Hz are asked for", rate.hz(), to.hz());
            let hint = "give a lower rate: what was not sampled cannot be made, interpolation only lessens the noise";
            return refuse(message, hint);
        }
        let samples = resampled(recording.samples(), rate, to);
        let too_short =
            || format!("{path}: shorter than the low pass; it needs {:.2} s", WINDOW_PERIODS * to.period());
        let holes =
            samples.windows(2).filter(|two| two[1].t.seconds_since(two[0].t) > 1.5 * to.period()).count();
        if holes > 0 {
            errln!(
                "note: {holes} hole(s): no samples are made where the log has none, nor {:.2} s before and after",
                0.5 * WINDOW_PERIODS * to.period()
            );
        }
        recording = ImuRecording::new(samples).with_context(too_short)?;
        errln!(
            "{:.1} Hz to {:.1} Hz behind a low pass: flat to {:.1} Hz, nothing above {:.1} Hz; white noise keeps its density",
            rate.hz(),
            to.hz(),
            PASSES * to.hz(),
            STOPS * to.hz()
        );
    }
    atomic_write(&args.out, |out| write_imu_rows(out, &recording))?;
    Ok(outln!("{}: {} samples", args.out.display(), recording.samples().len())?)
}
