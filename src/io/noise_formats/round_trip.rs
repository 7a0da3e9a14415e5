//! Laws over all pairs of formats, and files as people have them.

use super::*;
use dpn_core::noise::{
    AccelBiasWalkDensity, AccelNoiseDensity, Axes, Figure, GyroBiasWalkDensity, GyroNoiseDensity, ImuFigures,
};
use dpn_core::time::SampleRate;
use proptest::prelude::*;
use std::path::Path;

fn none(_: Figure) -> Option<String> {
    None
}

fn text(figures: &ImuFigures, format: Format) -> String {
    write(figures, format, none).unwrap().text
}

fn back(text: &str, format: Format, rate: Option<SampleRate>) -> ImuFigures {
    let given = Given { rate, ..Given::default() };
    parse(text.as_bytes(), Path::new("f"), Some(format), &given)
        .unwrap_or_else(|e| panic!("{e}\n{text}"))
        .figures
}

/// Whether every figure that `format` can hold is the same after `writings`, each of which rounds to eight digits.
fn same(a: &ImuFigures, b: &ImuFigures, format: Format, per_axis: bool, writings: f64) -> Result<(), String> {
    for figure in Figure::ALL {
        if format == Format::Ros && figure.is_walk() {
            continue;
        }
        let (x, y) =
            (a.density(figure).unwrap(), b.density(figure).ok_or(format!("{format} lost the {figure}"))?);
        let (x, y) = if per_axis { (x.each(), y.each()) } else { ([x.largest(); 3], [y.largest(); 3]) };
        // Half a unit of the eighth digit, each time.
        if x.iter().zip(y).any(|(x, y)| (x / y - 1.0).abs() > 6e-8 * writings) {
            return Err(format!("{format}, {figure}: {x:?} became {y:?}"));
        }
    }
    Ok(())
}

prop_compose! {
    fn figures()(logs in prop::array::uniform4(-7.0..0.0f64), spread in 1.0..3.0f64, hz in 20.0..4000.0f64, each: bool) -> ImuFigures {
        let [a, b, c, d] = logs.map(|log| {
            let value = 10f64.powf(log);
            if each { Axes::Each([value, value * spread, value / spread]) } else { Axes::Same(value) }
        });
        ImuFigures {
            rate: SampleRate::from_hz(hz),
            accel_white: Some(a.try_map(AccelNoiseDensity::new).unwrap()),
            accel_walk: Some(b.try_map(AccelBiasWalkDensity::new).unwrap()),
            gyro_white: Some(c.try_map(GyroNoiseDensity::new).unwrap()),
            gyro_walk: Some(d.try_map(GyroBiasWalkDensity::new).unwrap()),
        }
    }
}

proptest! {
    #[test]
    fn every_format_reads_what_it_wrote(figures in figures()) {
        for format in Format::ALL {
            let per_axis = format == Format::Ros || format.layout().is_some_and(|l| l.per_axis);
            let again = back(&text(&figures, format), format, figures.rate);
            prop_assert_eq!(same(&figures, &again, format, per_axis, 1.0), Ok(()));
        }
    }

    #[test]
    fn by_way_of_any_two_formats_figures_come_home(figures in figures()) {
        // ROS's messages have no walks, without which the others cannot be read.
        let formats = Format::ALL.into_iter().filter(|format| *format != Format::Ros);
        for (first, second) in formats.clone().flat_map(|first| formats.clone().map(move |second| (first, second))) {
            let once = back(&text(&figures, first), first, figures.rate);
            let twice = back(&text(&once, second), second, figures.rate);
            let home = back(&text(&twice, first), first, figures.rate);
            prop_assert_eq!(same(&figures, &home, first, false, 3.0), Ok(()));
        }
    }

    #[test]
    fn damaged_configurations_panic_no_reader(at in 0usize..300, byte: u8, which in 0usize..9, cut: bool) {
        let format = Format::ALL[which];
        let mut bytes = text(&ImuFigures::euroc(), format).into_bytes();
        let at = at % bytes.len();
        if cut { bytes.truncate(at) } else { bytes[at] = byte }
        for rate in [None, Some(SampleRate::HZ_200)] {
            for format in [None, Some(format)] {
                if let Err(error) = parse(&bytes, Path::new("f"), format, &Given { rate, ..Given::default() }) {
                    prop_assert!(!error.to_string().contains('\n'), "{error:?}");
                    prop_assert!(error.hint().is_none_or(|hint| !hint.is_empty()));
                }
            }
        }
    }
}

#[test]
fn the_format_is_told_from_what_it_wrote() {
    for format in Format::ALL {
        let given = Given { rate: Some(SampleRate::HZ_200), ..Given::default() };
        let source =
            parse(text(&ImuFigures::euroc(), format).as_bytes(), Path::new("f"), None, &given).unwrap();
        // Nothing but the calibration's other keys tells OpenVINS' chain from Kalibr's.
        let expected = if format == Format::OpenVins { Format::Kalibr } else { format };
        assert_eq!(source.format, expected);
    }
}

#[test]
fn vins_at_another_rate_is_other_noise() {
    let file = "%YAML:1.0\nacc_n: 0.08\ngyr_n: 0.004\nacc_w: 0.00004\ngyr_w: 2.0e-6\ng_norm: 9.81007\n";
    let at =
        |hz| back(file, Format::Vins, SampleRate::from_hz(hz)).density(Figure::AccelWhite).unwrap().largest();
    assert!((at(200.0) - 0.08 / 200f64.sqrt()).abs() < 1e-15);
    assert!((at(800.0) / at(200.0) - 0.5).abs() < 1e-12);
    let source = parse(
        file.as_bytes(),
        Path::new("f"),
        None,
        &Given { rate: SampleRate::from_hz(200.0), ..Given::default() },
    );
    let source = source.unwrap();
    assert_eq!(
        source.steps[0].to_string(),
        "acc_n = 0.08 m/s^2 / sqrt(200.0 Hz) = 0.0056568542 m/s^2/sqrt(Hz) (density)"
    );
    assert!(
        source.remarks[0].to_string().contains("densities of 0.004 m/s^2/sqrt(Hz) and 2.0e-4 rad/s/sqrt(Hz)"),
        "{:?}",
        source.remarks
    );
}

#[test]
fn faults_are_named_with_line_and_remedy() {
    let case = |text: &str, from: Option<Format>, rate: Option<f64>| {
        let given = Given { rate: rate.and_then(SampleRate::from_hz), ..Given::default() };
        let error = parse(text.as_bytes(), Path::new("f.yaml"), from, &given).unwrap_err();
        (error.to_string(), error.hint().unwrap_or_default())
    };
    let vins = "acc_n: 0.08\ngyr_n: 0.004\nacc_w: 4e-5\ngyr_w: 2e-6\n";
    let (error, hint) = case(&vins.replace("gyr_w", "gyrw"), None, Some(200.0));
    assert_eq!(error, "f.yaml: no `gyr_w`, which vins needs");
    assert_eq!(hint, "line 4 has `gyrw`; did you mean `gyr_w`?");
    let (error, hint) = case(&vins.replace("gyr_w: 2e-6\n", ""), None, Some(200.0));
    assert_eq!(error, "f.yaml: no `gyr_w`, which vins needs");
    assert_eq!(hint, "add the key, or give --gyro-walk NUMBER (densities, or with a unit)");
    assert_eq!(
        case(vins, None, None).0,
        "vins has its figures per sample; the rate of the samples is needed"
    );
    assert_eq!(case(vins, Some(Format::Kalibr), None).1, "the file has the keys of vins: say --from vins");
    let (error, hint) = case(&vins.replace("0.004", "0"), None, Some(200.0));
    assert_eq!(error, "f.yaml:2: `gyr_n` is 0; a noise figure is above zero");
    assert!(hint.contains("trusts the IMU without bound"));
    assert_eq!(
        case(&vins.replace("0.004", "-.1"), None, Some(200.0)).0,
        "f.yaml:2: `gyr_n` is -0.1; a noise figure is above zero"
    );
    assert_eq!(
        case(&vins.replace("0.004", "0.004 rad"), None, Some(200.0)).0,
        "f.yaml:2: `gyr_n` is \"0.004 rad\"; one number, or three (x, y, z), is needed"
    );
    let (error, hint) = case("gyroscope_noise: 5 deg/h\n", None, None);
    assert!(error.starts_with("f.yaml:1: `gyroscope_noise`: \"5 deg/h\" is a bias instability"), "{error}");
    assert!(hint.contains("dpn allan"));
    let (error, hint) =
        case("gyroscope_noise: 1 deg/sqrt(h)\ngyroscope_bias_instability: 5 deg/h\n", None, None);
    assert!(error.starts_with("f.yaml:2: `gyroscope_bias_instability` is no key of a datasheet"), "{error}");
    assert!(hint.contains("no walk"), "{hint}");
    let message = "angular_velocity_covariance: [0, 0, 0, 0, 0, 0, 0, 0, 0]\nlinear_acceleration_covariance: [-1, 0, 0, 0, 0, 0, 0, 0, 0]\n";
    assert!(case(message, None, Some(200.0)).0.contains("`linear_acceleration_covariance` begins with -1"));
    let zeros = message.replace("[-1, 0, 0, 0, 0, 0, 0, 0, 0]", "[1e-4, 0, 0, 0, 1e-4, 0, 0, 0, 1e-4]");
    assert!(case(&zeros, None, Some(200.0)).0.contains("`angular_velocity_covariance` is all zeros"));
    assert_eq!(
        case("camera: 1\nacc_nn: 3\n", None, None),
        ("f.yaml: no keys of a known format".into(), "line 2 has `acc_nn`; did you mean `acc_n`?".into())
    );
    assert_eq!(
        case("update_rate: fast\ngyroscope_noise: 1 deg/sqrt(h)\n", None, None).0,
        "f.yaml:1: `update_rate` is \"fast\"; a rate is a number of Hz above zero"
    );
}

#[test]
fn what_is_typed_wins_over_the_file_and_fills_its_gaps() {
    let quantity = |text, figure| Quantity::parse(text, figure).unwrap();
    let given = Given {
        rate: SampleRate::from_hz(100.0),
        quantities: vec![quantity("1 mg rms", Figure::AccelWhite), quantity("2e-5", Figure::GyroWalk)],
        ..Given::default()
    };
    let text = "acc_n: 0.08\ngyr_n: 0.004\nacc_w: 4e-5\n";
    let source = parse(text.as_bytes(), Path::new("f"), None, &given).unwrap();
    let density = |figure| source.figures.density(figure).unwrap().largest();
    assert!((density(Figure::AccelWhite) - 9.80665e-4).abs() < 1e-12);
    assert_eq!(density(Figure::GyroWalk), 2e-5);
    assert!((density(Figure::GyroWhite) - 4e-4).abs() < 1e-12);
}

#[test]
fn a_basalt_file_of_old_with_one_number_and_of_new_with_three_is_read() {
    let file = "{\"value0\": {\"imu_update_rate\": 200.0, \"accel_noise_std\": 0.016, \"gyro_noise_std\": [0.000282, 0.0003, 0.000282],\
        \"accel_bias_std\": 0.001, \"gyro_bias_std\": 0.0001}}";
    let figures = back(file, Format::Basalt, None);
    assert_eq!(figures.rate, Some(SampleRate::HZ_200));
    assert_eq!(figures.density(Figure::AccelWhite), Some(Axes::Same(0.016)));
    assert_eq!(figures.density(Figure::GyroWhite), Some(Axes::Each([0.000_282, 0.0003, 0.000_282])));
}

#[test]
fn what_imu_utils_leaves_is_noise_per_sample_and_no_walk() {
    let sensor = |name: &str, key: &str, n: f64| {
        let axis = |axis: &str, n: f64| format!("   {axis}:\n      {key}_n: {n:e}\n      {key}_w: 2.6e-05\n");
        format!(
            "{name}:\n   unit: \" x\"\n{}{}{}{}",
            axis("avg-axis", n),
            axis("x-axis", 1.1 * n),
            axis("y-axis", n),
            axis("z-axis", 0.9 * n)
        )
    };
    let text = format!(
        "%YAML:1.0\n---\ntype: IMU\nname: any\n{}{}",
        sensor("Gyr", "gyr", 1.2e-3),
        sensor("Acc", "acc", 2e-2)
    );
    let read = |rate| parse(text.as_bytes(), Path::new("f"), None, &Given { rate, ..Given::default() });
    assert!(matches!(read(None), Err(FormatError::NeedsRate { .. })));
    let source = read(Some(SampleRate::HZ_200)).unwrap();
    let density = source.figures.density(Figure::AccelWhite).unwrap().each();
    assert!(
        (density[0] - 2.2e-2 / 200f64.sqrt()).abs() < 1e-12
            && source.figures.density(Figure::AccelWalk).is_none()
    );
    let written = write(&source.figures, Format::Kalibr, |_| None).unwrap();
    assert!(written.text.contains("# accelerometer_random_walk: not known"), "{}", written.text);
}

#[test]
fn a_configured_rate_that_is_not_the_logs_is_said_of_the_log() {
    let text = "accelerometer_noise_density: 1\naccelerometer_random_walk: 1\ngyroscope_noise_density: 1\ngyroscope_random_walk: 1\nupdate_rate: 50\n";
    let said = |rate_of_log| {
        let given = Given { rate: Some(SampleRate::HZ_200), rate_of_log, ..Given::default() };
        parse(text.as_bytes(), Path::new("f"), None, &given).unwrap().remarks[0].to_string()
    };
    assert!(
        said(true).starts_with("f:5: `update_rate` is 50.0 Hz, but the log has 200.0 Hz"),
        "{}",
        said(true)
    );
    assert!(said(false).ends_with("but --rate 200.0 counts"), "{}", said(false));
}
