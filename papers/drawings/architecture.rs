//! The architecture, from the estimator's configuration and the networks' layer shapes.

use dpn_figures::{Arrow, Block, BlockKind, Diagram, FigureError};
use dpn_pronet::DualProNet;
use dpn_pronet::config::{BlockOrder, NormAxes, ProNetConfig};
use dpn_pronet::network::Network;
use dpn_pronet::shape::{LayerKind, LayerShape, layers};
use dpn_vio::EstimatorConfig;
use dpn_vio::estimator::FedTracks;

fn block(at: (i32, i32), size: (i32, i32), kind: BlockKind, lines: &[&str]) -> Block {
    Block { at, size, kind, lines: lines.iter().map(|line| (*line).to_owned()).collect() }
}

fn arrow(path: Vec<(i32, i32)>, words: &str) -> Arrow {
    Arrow { path, words: words.to_owned(), head: true, dashed: false }
}

/// A word of the configuration as it is written in a file.
fn word(value: impl serde::Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(text)) => text,
        Ok(other) => other.to_string(),
        Err(_) => String::new(),
    }
}

/// The odometry with DualProNet: what is fed where.
pub(crate) fn odometry(
    estimator: &EstimatorConfig,
    pair: Option<(&Network, &Network)>,
    camera: &str,
) -> Result<Diagram, FigureError> {
    let window = &estimator.window;
    let net = |network: &Network| {
        let config = network.weights.config();
        let parameters: usize = layers(config).iter().map(|layer| layer.parameters).sum();
        let label = format!("x, y, z: {} samples each", config.window);
        [label, format!("{parameters} parameters, {}", network.base)]
    };
    let none = ["no network".to_owned(), String::new()];
    let [accel_shape, accel_size] = pair.map_or(none.clone(), |(accel, _)| net(accel));
    let [gyro_shape, gyro_size] = pair.map_or(none, |(_, gyro)| net(gyro));
    use BlockKind::{Data, Network as Net, Step};
    let imu = block((20, 105), (240, 120), Data, &["IMU", "gyro, accelerometer", "200 Hz"]);
    let accel = block((400, 20), (370, 120), Net, &["Accel-ProNet", &accel_shape, &accel_size]);
    let gyro = block((400, 190), (370, 120), Net, &["Gyro-ProNet", &gyro_shape, &gyro_size]);
    let covariance = format!("covariance: {}", word(estimator.imu.imu_cov));
    let preint =
        block((960, 105), (330, 120), Step, &["pre-integration", "each sample with its σ", &covariance]);
    let camera_box = block((20, 470), (240, 120), Data, &["camera", camera]);
    let init = block((400, 470), (370, 120), Step, &["initialisation", "until there is a first state"]);
    let frames = format!("{} key frames and the newest", window.key_frames);
    let loss = match estimator.fed_tracks {
        FedTracks::White => format!("loss: {} at {} deviations", word(window.loss), window.loss_scale),
        FedTracks::Followed => format!("loss: {} at {} px", word(window.loss), window.followed_loss_px),
    };
    let pixels = format!("pixels: {} px", window.pixel_std);
    let solver = block(
        (960, 430),
        (330, 200),
        Step,
        &["sliding window", &frames, &pixels, &loss, &format!("at most {} steps", window.max_iterations)],
    );
    let output = block((1400, 470), (180, 120), Data, &["state", "pose, velocity,", "biases"]);
    let prior = block((960, 720), (330, 90), Step, &["prior", "of states that left"]);
    let hop = format!("σ, every {} samples", DualProNet::HOP);
    let arrows = vec![
        arrow(vec![imu.east(), (330, 165), (330, 80), accel.west()], ""),
        arrow(vec![imu.east(), (330, 165), (330, 250), gyro.west()], ""),
        arrow(vec![accel.east(), (865, 80), (865, 145), (960, 145)], ""),
        arrow(vec![gyro.east(), (865, 250), (865, 190), (960, 190)], ""),
        arrow(vec![imu.south(), (140, 370), (1040, 370), (1040, 225)], "samples"),
        arrow(vec![(1210, 225), (1210, 430)], "motion with covariance"),
        arrow(vec![camera_box.east(), init.west()], ""),
        arrow(vec![init.east(), solver.west()], "states, tracks"),
        arrow(vec![solver.east(), output.west()], ""),
        arrow(vec![(1050, 630), (1050, 720)], ""),
        arrow(vec![(1200, 720), (1200, 630)], ""),
    ];
    let caption = format!(
        "The odometry with DualProNet. Green: what DualProNet adds ({hop}); without it a constant stands in its place. Words and numbers \
         are those of the configuration and of the networks in use."
    );
    let blocks = vec![imu, accel, gyro, preint, camera_box, init, solver, output, prior];
    Diagram::new(blocks, arrows, &caption)
}

/// The sliding window: states, what ties them together, what is forgotten.
pub(crate) fn window(estimator: &EstimatorConfig) -> Result<Diagram, FigureError> {
    let frames = estimator.window.key_frames;
    let shown = ["x1", "x2", "x3", "...", &format!("x{frames}"), "newest"].map(str::to_owned);
    let (step, left, top, size) = (235, 190, 330, (120, 80));
    let mut blocks = vec![block((20, top - 10), (130, 100), BlockKind::Factor, &["prior", "of what left"])];
    let mut arrows = vec![Arrow {
        path: vec![(150, top + 40), (left, top + 40)],
        words: String::new(),
        head: false,
        dashed: false,
    }];
    let x = |i: usize| left + i as i32 * step;
    for (i, name) in shown.iter().enumerate() {
        if i > 0 {
            let middle = (x(i - 1) + size.0 + x(i)) / 2;
            let ends = vec![(x(i - 1) + size.0, top + 40), (x(i), top + 40)];
            arrows.push(Arrow { path: ends, words: String::new(), head: false, dashed: name == "..." });
            blocks.push(block((middle - 50, top + 12), (100, 56), BlockKind::Factor, &["IMU"]));
        }
    }
    for (i, name) in shown.iter().enumerate() {
        let kind = if name == "..." { BlockKind::Data } else { BlockKind::State };
        blocks.push(block((x(i), top), size, kind, &[name]));
    }
    // Three landmarks, each seen from its host and from two later frames.
    for (l, seen) in [[0, 1, 2], [1, 2, 4], [2, 4, 5]].into_iter().enumerate() {
        let at = (430 + 360 * l as i32, 60);
        for i in seen {
            let path = vec![(at.0 + 90, at.1 + 90), (x(i) + size.0 / 2, top)];
            arrows.push(Arrow { path, words: String::new(), head: false, dashed: i != seen[0] });
        }
        blocks.push(block(at, (180, 90), BlockKind::Data, &["landmark", "depth at its host"]));
    }
    let window = &estimator.window;
    let words = |flag: bool| if flag { "estimated" } else { "held" };
    let caption = format!(
        "The sliding window: {frames} key frames and the newest frame. A state holds pose, velocity and biases; IMU factors weigh by the noise told; \
         landmarks are seen from their host (full line) and from other frames (dashed), {} px a pixel, {} loss. The newest frame becomes a key frame \
         at {} px of parallax. Extrinsics {}, time offset {}; tracks that outlive their host: {}.",
        window.pixel_std,
        word(window.loss),
        window.key_frame_parallax_px,
        words(window.estimate_extrinsics),
        words(window.estimate_time_offset),
        word(window.handover),
    );
    Diagram::new(blocks, arrows, &caption)
}

/// Boxes side by side.
const ACROSS: usize = 9;

/// The layers of each network.
pub(crate) fn network(networks: &[&Network]) -> Result<Diagram, FigureError> {
    let (mut blocks, mut arrows, mut top) = (Vec::new(), Vec::new(), 20);
    for network in networks {
        let config = network.weights.config();
        let title = format!("{} ({})", network.path.display(), network.name);
        blocks.push(block((20, top), (700, 44), BlockKind::Network, &[&title]));
        top += 64;
        let rows = layers(config);
        for part in rows.chunks(ACROSS) {
            for (i, layer) in part.iter().enumerate() {
                let kind =
                    if matches!(layer.kind, LayerKind::Input) { BlockKind::Data } else { BlockKind::Step };
                let lines = lines(config, layer);
                let at = (20 + i as i32 * 174, top);
                if i > 0 {
                    arrows.push(arrow(vec![(at.0 - 20, top + 105), (at.0, top + 105)], ""));
                }
                blocks.push(Block { at, size: (154, 210), kind, lines });
            }
            top += 240;
        }
        top += 20;
    }
    let total =
        |network: &&Network| -> usize { layers(network.weights.config()).iter().map(|l| l.parameters).sum() };
    let totals: Vec<String> =
        networks.iter().map(|n| format!("{} {} parameters", n.sensor(), total(n))).collect();
    let caption = format!(
        "Layers of the networks in use, from their configuration: {}. conv 41, / 4: a kernel of 41 samples every 4. Last line of a box: channels x time steps out of it.",
        totals.join(", ")
    );
    Diagram::new(blocks, arrows, &caption)
}

fn lines(config: &ProNetConfig, layer: &LayerShape) -> Vec<String> {
    let shape = if layer.length > 1 {
        format!("{} x {}", layer.channels, layer.length)
    } else {
        format!("{}", layer.channels)
    };
    let act = format!("leaky {}", config.leak);
    let mut lines = vec![layer.name.clone()];
    match layer.kind {
        LayerKind::Input => {
            let input = word(config.input);
            lines.push(format!("{} samples", config.window));
            lines.extend(input.split('-').map(str::to_owned));
        }
        LayerKind::Block { kernel, stride, .. } => {
            lines.push(format!("conv {kernel}, / {stride}"));
            let norm = match config.norm_axes {
                NormAxes::None => None,
                _ => Some("layer norm".to_owned()),
            };
            match config.block_order {
                BlockOrder::ConvNormAct => {
                    lines.extend(norm);
                    lines.push(act);
                }
                BlockOrder::ConvActNorm => {
                    lines.push(act);
                    lines.extend(norm);
                }
            }
        }
        LayerKind::Pool => lines.extend(word(config.pool).split("-and-").map(str::to_owned)),
        LayerKind::Linear => {
            lines.push("linear".into());
            lines.push(if layer.name == format!("fc{}", config.hidden.len() + 1) {
                word(config.head)
            } else {
                act
            });
        }
    }
    lines.push(shape);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_figures::Plot;

    #[test]
    fn drawings_follow_the_configuration() {
        let mut estimator = EstimatorConfig::default();
        estimator.window.key_frames = 7;
        let words = |diagram: &Diagram| {
            diagram.csv().rows.iter().map(|row| row[1].clone()).collect::<Vec<_>>().join("\n")
        };
        let text = words(&window(&estimator).unwrap());
        assert!(text.contains("x7") && !text.contains("x10"), "{text}");
        let text = words(&odometry(&estimator, None, "tracks, 10 Hz").unwrap());
        for expected in
            ["7 key frames and the newest", "tracks, 10 Hz", "covariance: exact", "loss: huber at 1.5"]
        {
            assert!(text.contains(expected), "{expected}: {text}");
        }
        estimator.fed_tracks = FedTracks::Followed;
        let text = words(&odometry(&estimator, None, "images, followed").unwrap());
        assert!(text.contains("loss: huber at 0.5 px"), "{text}");
    }

    #[test]
    fn every_layer_has_its_box() {
        let config = ProNetConfig::default();
        let rows = layers(&config);
        let text: Vec<String> = rows.iter().map(|layer| lines(&config, layer).join("; ")).collect();
        assert_eq!(text.len(), 9);
        assert!(text[1].contains("conv 7, / 1") && text[1].ends_with("16 x 200"), "{text:?}");
        assert!(text[8].contains("softplus") && text[8].ends_with("; 1"), "{text:?}");
    }
}
