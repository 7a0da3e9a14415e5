//! What people type most, under each command's help. A test types them.

pub(super) const TRAIN: &str = "Examples:
  dpn train --sensor accel --data data/euroc            weights, summary and training.svg, the curve
  dpn train --sensor accel --data data/euroc --out runs/accel --resume
  dpn train --sensor accel --data data/euroc --config constant.toml --out runs/accel --resume --epochs 300
  dpn train --sensor gyro --config configs/train/gyro.toml --data data/euroc --out runs/gyro --seed 1
  dpn train --sensor accel --set network.block_order=conv-act-norm --data data/euroc
  dpn train --model inertial --config configs/inertial/euroc.toml --data data/euroc
  dpn train --many configs/sweep/train.toml --data data --jobs 2 --out runs/many";

pub(super) const EVAL: &str = "Examples:
  dpn eval --open-loop --data data/euroc
  dpn eval --closed-loop --data data/euroc --noise 'x1;x4;dualpronet' --seeds 3
  dpn eval --closed-loop --data data/euroc --noise 'x1;self' --calib camchain.yaml
  dpn eval --inertial configs/inertial/euroc.toml --data data/euroc --models runs
  dpn eval --closed-loop --noise 'oracle;x1' --sequences f07-room-medium        simulated flights: no data needed";

pub(super) const FIT: &str = "Example:
  dpn fit flight.bag --against mocap.tum --out runs/calibration";

pub(super) const RUN: &str = "Examples:
  dpn run data/euroc/V1_02_medium
  dpn run data/euroc/V1_02_medium --noise x4 --from 10 --to 40 --draw album
  dpn run data/motion/MH_01_easy_start --noise 'file(\"noise.csv\")' --set window.pixel_std=0.5
  dpn run flight.bag --calib camchain.yaml --image-topic /cam0/image_raw --topic /imu0
  dpn run data/euroc/V1_02_medium --mcap run.mcap                           for Foxglove
  cat flight.bag | dpn run - --calib camchain.yaml                          poses as they are made";

#[cfg(feature = "ros2")]
pub(super) const ROS2: &str = "Examples:
  dpn ros2 --calib camchain.yaml --imu /imu0 --image /cam0/image_raw
  dpn ros2 --imu /imu/data_raw --image /camera/image_raw --camera-info /camera/camera_info      calibration from /tf_static too
  dpn ros2 --calib camchain.yaml --compressed --ros-args -r __ns:=/robot -p use_sim_time:=true";

#[cfg(feature = "ros2")]
pub(super) const ROS2_NOISE: &str = "Example:
  dpn ros2 noise --imu /imu/data_raw          for robot_localization and others: imu/with_covariance";

pub(super) const PAPER: &str = "Examples:
  dpn paper --quick                          simulated flights, some minutes: is everything there?
  dpn paper --data data                      the whole study
  dpn paper --data data --plan configs/paper/figures.toml --out figures/mine";

pub(super) const SWEEP_PLAN: &str = "Examples:
  dpn sweep plan configs/sweep/closed_loop.toml --data data --shards 64 --out sweep
  dpn sweep plan configs/sweep/paper.toml --data data --minutes 10 --out sweep --json";

pub(super) const SWEEP_RUN: &str = "Examples:
  dpn sweep run sweep --shard 3
  dpn sweep run sweep --shard all
  dpn sweep run sweep                        in a Slurm array: the shard is the task's number";

pub(super) const SWEEP_COLLECT: &str = "Example:
  dpn sweep collect sweep --out runs/whole";

pub(super) const SWEEP_STATUS: &str = "Examples:
  dpn sweep status sweep
  dpn sweep status sweep --json";

pub(super) const PAGE: &str = "Examples:
  dpn page flight.bag
  dpn page rosbag2_folder --topic /imu0
  dpn page log.csv --columns 1,2,3,4,5,6,7 --gyro-unit deg/s --web target/web/page";

pub(super) const NOISE: &str = "Examples:
  dpn noise flight.bag
  dpn noise logs/ robot1.bag                 a table, a row a log
  dpn noise log.csv --columns 1,2,3,4,5,6,7 --gyro-unit deg/s --out runs/mine
  dpn noise flight.mcap --into with_covariances.mcap
  dpn noise flight.bag --noise 'dualpronet(wide-s0)' --check vins.yaml --check-as vins
  dpn noise log.csv --paste vins,kalibr
  dpn noise --learned runs/run-flight1 runs/run-flight2 --paste vins
  dpn noise flight.bag --against mocap.tum --paste all
  my-driver | dpn noise --follow --rate 200
  dpn noise convert imu.yaml --to vins --rate 200";

pub(super) const CONVERT: &str = "Examples:
  dpn noise convert imu.yaml --to vins --rate 200
  dpn noise convert --from datasheet --accel-noise '120 ug/sqrt(Hz)' --gyro-noise '0.007 deg/s/sqrt(Hz)' --to kalibr --rate 200";

pub(super) const RESAMPLE: &str = "Examples:
  dpn convert flight.bag --to-rate 100 --out flight100.csv
  dpn convert phone.zip --out phone.csv";

pub(super) const ALLAN: &str = "Examples:
  dpn allan static.csv
  dpn allan two_hours_at_rest.mcap --check imu.yaml --out runs/allan";

pub(super) const CHECK: &str = "Examples:
  dpn check flight.bag
  dpn check logs/ --fail-on bad              a table, a row a log; for CI
  dpn check log.csv --json | jq '.findings[].text'";

pub(super) const COMPARE: &str = "Examples:
  dpn compare before.bag after.bag
  dpn compare monday.csv friday.csv --from 0 --to 60 --json";

pub(super) const REPORT: &str = "Examples:
  dpn report flight.bag --out flight.html
  dpn report flight.bag --figures figures    every figure as SVG, PDF, PNG and CSV too
  dpn report logs/ --out robots.html         a section a log";

pub(super) const FLEET: &str = "Examples:
  dpn fleet configs/fleet/fleet.toml --data data --out runs/fleet
  dpn fleet configs/fleet/fleet.toml --platforms flights,flights-still";

pub(super) const TRUTH: &str = "Examples:
  dpn truth data/euroc --out truth
  dpn eval --closed-loop --data data/euroc --truth truth --noise x1";

pub(super) const ONNX: &str = "Examples:
  dpn export onnx --out onnx
  dpn export onnx --network sg11-s0,wide-s0 --json
  dpn export onnx --inertial runs/train-euroc-seed0/network.safetensors";

pub(super) const FLIGHT: &str = "Examples:
  dpn simulate flight --list
  dpn simulate flight f07-room-medium --seed 3 --out flights";

pub(super) const TRACKS: &str = "Example:
  dpn simulate tracks data/euroc/V1_02_medium --out tracks.txt";

pub(super) const IMAGES: &str = "Example:
  dpn simulate images data/euroc/V1_02_medium --out rendered";

pub(super) const COMPLETIONS: &str = "Examples:
  dpn completions bash > ~/.local/share/bash-completion/completions/dpn
  dpn completions zsh > ~/.zfunc/_dpn
  dpn completions fish > ~/.config/fish/completions/dpn.fish";

pub(super) const MANUAL: &str = "Example:
  dpn manual --out ~/.local/share/man/man1";

pub(super) const APE: &str = "Examples:
  dpn ape truth.tum estimate.tum -a
  dpn ape data/euroc/V1_02_medium vins.tum runs/run -as --save_plot runs/ape.svg
  dpn ape flight.bag:/vicon/pose flight.bag:/odometry -a
  dpn ape truths/ vins/ mine/ -a             folders of V1_01.tum, V1_02.tum ...: ratio, interval and tests over sequences";

pub(super) const RPE: &str = "Examples:
  dpn rpe truth.tum estimate.tum -d 1 -u m --all_pairs
  dpn rpe poses/00.txt results/00.txt -d 10 -u f -r angle_deg      KITTI, line by line";

#[cfg(test)]
mod tests {
    use crate::args::Cli;
    use clap::{Command, CommandFactory, Parser};

    /// The words of a line as a shell cuts them, up to its redirection or pipe.
    fn words(line: &str) -> Vec<String> {
        let (mut all, mut word, mut quoted) = (Vec::new(), String::new(), false);
        for c in line.chars() {
            match c {
                '\'' => quoted = !quoted,
                '|' | '>' if !quoted => break,
                ' ' if !quoted => all.extend((!word.is_empty()).then(|| std::mem::take(&mut word))),
                _ => word.push(c),
            }
        }
        all.extend((!word.is_empty()).then_some(word));
        all
    }

    fn look(command: &Command, path: &str) {
        let path = format!("{path} {}", command.get_name());
        let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        let leaf = command.get_subcommands().next().is_none();
        assert!(!leaf || help.starts_with("Example"), "{path}: no example");
        for line in help.lines().skip(1) {
            // Several spaces stand before a remark.
            let line = line.trim().split("    ").next().unwrap_or_default();
            let typed = line.find("dpn ").map_or_else(|| panic!("{line}"), |at| &line[at..]);
            Cli::try_parse_from(words(typed)).unwrap_or_else(|error| panic!("{typed}: {error}"));
        }
        command.get_subcommands().for_each(|command| look(command, &path));
    }

    #[test]
    fn every_command_has_examples_and_each_can_be_typed() {
        look(&Cli::command(), "");
    }
}
