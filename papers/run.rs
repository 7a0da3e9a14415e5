//! The stages in their order.

use super::drawings;
use super::error::PaperError;
use super::findings::{findings, pairs};
use super::forest::Forest;
use super::id::{id, json};
use super::injected::Response;
use super::overall::Overall;
use super::page::{Page, Picture, Readme, called};
use super::paper::Paper;
use super::results::StageResult;
use super::specs;
use super::tables;
use super::verdict::Verdict;
use askama::Template as _;
use dpn_core::Sensor;
use dpn_core::checksum::of_bytes;
use dpn_core::estimate::NoiseSpec;
use dpn_core::progress::Progress;
use dpn_eval::closed_loop::{Recording, Row, TrackSource};
use dpn_eval::injected::Course;
use dpn_eval::study::{Criterion, RowSet, Study};
use dpn_figures::{Chart, ENDINGS, Provenance, save};
use dpn_io::{IoError, ResultPath, write_file};
use dpn_pronet::network::Network;
use dpn_train::split::Side;
use dpn_vio::estimator::{EstimatorConfig, FedTracks};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// A stage that is over.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageReport {
    /// Its name.
    pub name: String,
    /// The folder of its results, or the checksum of what it was made from.
    pub run: String,
    /// Whether nothing had to be made.
    pub cached: bool,
    /// Wall-clock time \[s\].
    pub seconds: f64,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Done {
    /// The stages, in order.
    pub stages: Vec<StageReport>,
    /// What the tables say, in sentences.
    pub findings: Vec<String>,
    /// Every file written or found whole.
    pub files: Vec<ResultPath>,
    /// The page.
    pub page: ResultPath,
}

/// What a folder of tables and figures was made from: a checksum, and those of its files.
#[derive(Debug, Serialize, serde::Deserialize)]
struct Receipt {
    id: String,
    findings: Vec<String>,
    files: BTreeMap<String, String>,
}

const RECEIPT: &str = "made.json";
const PAGE: &str = "index.html";
const README: &str = "README.md";
/// Noises shown over a flight.
const OVER_FLIGHT: [&str; 3] = ["dualpronet", "diff2", "sg(11,2)"];
/// Noises shown following a step.
const FOLLOWING: [&str; 3] = [specs::WIDE_PLUS, "dualpronet", "diff2"];

impl Paper<'_> {
    /// Runs what has not been run, and makes tables, figures and page where their input or they themselves have changed.
    ///
    /// # Errors
    /// Whatever stops a stage; a request to stop. What is finished stays, and the same call goes on from there.
    pub fn run(&self, stop: &AtomicBool, progress: &mut dyn Progress) -> Result<Done, PaperError> {
        let mut stages = Vec::new();
        let mut overall = Overall::new(progress, self.foreseen()?);
        let clock = Instant::now();
        let networks = self.networks_id()?;
        stages.push(report("networks", &format!("networks-{networks}"), true, clock));
        let clock = Instant::now();
        let open = self.open_loop(&networks, stop, &mut overall)?;
        stages.push(report("open loop", &open.run, open.cached, clock));
        let clock = Instant::now();
        overall.enter(1);
        let (closed, unseen) = self.closed_loop(stop, &mut overall)?;
        stages.push(report("closed loop", &closed.run, closed.cached, clock));
        let input = self.input.without(&unseen);
        if input.places.is_empty() {
            let reasons = input.not_run().map(|m| format!("{}: {}", m.name, m.reason)).collect();
            return Err(PaperError::Nothing { reasons });
        }
        let paper = Paper { input: &input, ..self.clone() };
        paper.after_the_loop(stages, open, closed, stop, &mut overall)
    }

    /// The rest, on the sequences that the odometry has seen.
    fn after_the_loop(
        &self,
        mut stages: Vec<StageReport>,
        open: StageResult<Vec<dpn_eval::open_loop::Row>>,
        closed: StageResult<Vec<Row>>,
        stop: &AtomicBool,
        overall: &mut Overall<'_>,
    ) -> Result<Done, PaperError> {
        let mut injected = Vec::new();
        for (stage, course) in (2..).zip(&self.plan.injected.courses) {
            overall.enter(stage);
            let clock = Instant::now();
            let rows = self.injected(*course, stop, overall)?;
            stages.push(report(&format!("injected noise: {course}"), &rows.run, rows.cached, clock));
            injected.push((*course, rows));
        }
        let clock = Instant::now();
        let responses = self.responses(stop)?;
        stages.push(report("responses", &responses.run, responses.cached, clock));
        let clock = Instant::now();
        let times = self.model_times(stop)?;
        stages.push(report("times", &times.run, times.cached, clock));

        let clock = Instant::now();
        let id = self.paper_id(&stages, &closed.value, &injected)?;
        if let Some(receipt) = self.intact(&id) {
            stages.push(report("tables, figures, page", &id, true, clock));
            return Ok(self.done(stages, receipt));
        }
        let results = Results { open, closed, injected, responses, times };
        overall.enter(usize::MAX);
        let receipt = self.write(&id, &results, overall)?;
        stages.push(report("tables, figures, page", &id, false, clock));
        Ok(self.done(stages, receipt))
    }

    /// What tables, figures and page are a function of.
    fn paper_id(
        &self,
        stages: &[StageReport],
        closed: &[Row],
        injected: &[(Course, StageResult<Vec<Row>>)],
    ) -> Result<String, PaperError> {
        let mut parts = vec![
            self.program.clone(),
            self.command.clone(),
            self.camera.to_owned(),
            format!("{:?}", self.input.not_run().collect::<Vec<_>>()),
        ];
        parts.push(json(self.plan));
        parts.push(json(&self.estimator));
        parts.extend(stages.iter().map(|stage| stage.run.clone()));
        let rows = closed.iter().chain(injected.iter().flat_map(|(_, made)| &made.value));
        parts.extend(rows.map(json));
        parts.extend(self.checksums(&self.input.places)?);
        Ok(id(parts))
    }

    /// The receipt, where it is of `id` and every file is as it was written.
    fn intact(&self, id: &str) -> Option<Receipt> {
        let bytes = self.out.join(RECEIPT).read().ok()??;
        let receipt: Receipt = serde_json::from_slice(&bytes).ok()?;
        let whole =
            |(name, sum): (&String, &String)| checksum(&self.out.join(name)).is_ok_and(|now| now == *sum);
        (receipt.id == id && receipt.files.iter().all(whole)).then_some(receipt)
    }

    fn done(&self, stages: Vec<StageReport>, receipt: Receipt) -> Done {
        let files = receipt.files.keys().map(|name| self.out.join(name)).collect();
        Done { stages, findings: receipt.findings, files, page: self.out.join(PAGE) }
    }

    fn write(&self, id: &str, results: &Results, progress: &mut dyn Progress) -> Result<Receipt, PaperError> {
        let margin = self.plan.margin;
        let rows = RowSet::new(&results.closed.value);
        let study = Study::new(&rows, margin)?;
        let mut courses = Vec::new();
        for (course, made) in &results.injected {
            let rows = RowSet::new(&made.value);
            let best = rows.reference(Criterion::Median);
            courses.push((*course, Study::against(&rows, best, margin)?));
        }
        let step = courses.iter().find(|(course, _)| *course == Course::Step).map(|(_, study)| study);
        let pairs = pairs(&rows, margin)?;
        let program = match self.measured_by {
            Some(measured) => format!("{}, of runs by {measured}", self.program),
            None => self.program.clone(),
        };
        let made_by = Provenance { command: self.command.clone(), program, runs: Vec::new() };
        let injected_runs: Vec<&str> = results.injected.iter().map(|(_, made)| made.run.as_str()).collect();
        let (open, closed) = (results.open.run.as_str(), results.closed.run.as_str());
        let input = self.input;
        let noise = &self.plan.injected.noise;
        let networks: Vec<&Network> = Sensor::ALL.into_iter().filter_map(|s| self.network(s)).collect();
        let tables = vec![
            tables::split(input, made_by.of(&[closed])),
            tables::open_loop(input, &results.open.value, made_by.of(&[open])),
            tables::closed_loop(input, &rows, made_by.of(&[closed])),
            tables::study(input, &study, made_by.of(&[closed])),
            tables::pairs(&pairs, made_by.of(&[closed])),
            tables::courses(input, &courses, noise, made_by.of(&injected_runs)),
            tables::responses(input, &results.responses.value, noise, made_by.of(&[&results.responses.run])),
            tables::networks(&networks, made_by.of(&[closed])),
            tables::timing(&study, &results.times.value, made_by.of(&[closed, &results.times.run])),
        ];
        let mut names: Vec<String> = Vec::new();
        for table in &tables {
            table.save(&self.out.join("tables"))?;
            names.extend(["md", "csv", "tex"].map(|ending| format!("tables/{}.{ending}", table.name)));
        }
        let (pictures, drawn) = self.draw(results, &study, &made_by, progress)?;
        names.extend(drawn);
        let verdict = Verdict::new(input, self.camera, &study, step);
        let findings = findings(input, &study, &pairs, step);
        let page = Page {
            input,
            verdict: &verdict,
            forest: Forest::of_study(&study),
            added: step.and_then(Forest::of_course),
            names: called(&study, &courses, &results.responses.value),
            findings: &findings,
            tables: &tables,
            pictures: &pictures,
            made_by: &made_by.of(&[open, closed]),
        };
        self.write_page(&page)?;
        let findings = std::iter::once(verdict.sentence).chain(findings).collect();
        names.extend([PAGE.to_owned(), README.to_owned()]);
        let mut files = BTreeMap::new();
        for name in names {
            let sum = checksum(&self.out.join(&name))?;
            files.insert(name, sum);
        }
        let receipt = Receipt { id: id.to_owned(), findings, files };
        let text = serde_json::to_string_pretty(&receipt).expect("strings are JSON") + "\n";
        write_file(self.out.join(RECEIPT), &text)?;
        Ok(receipt)
    }

    /// The page and the folder's README.
    fn write_page(&self, page: &Page<'_>) -> Result<(), PaperError> {
        let Page { input, tables, pictures, made_by, .. } = *page;
        let readme = Readme { input, tables, pictures, made_by }.render();
        for (name, text) in [(PAGE, page.render()), (README, readme)] {
            let text = text.expect("a template that compiled writes to a string");
            write_file(self.out.join(name), &text)?;
        }
        Ok(())
    }

    /// Every figure that the results allow.
    fn draw(
        &self,
        results: &Results,
        study: &Study,
        made_by: &Provenance,
        progress: &mut dyn Progress,
    ) -> Result<(Vec<Picture>, Vec<String>), PaperError> {
        const COUNT: u64 = 13;
        progress.start("figures", COUNT);
        let mut figures =
            FigureWriter { out: &self.out, made_by, pictures: Vec::new(), files: Vec::new(), progress };
        let (accel, gyro) = (self.network(Sensor::Accel), self.network(Sensor::Gyro));
        let closed = results.closed.run.as_str();
        let tracks = &self.input.source.tracks;
        let camera = match tracks {
            TrackSource::Simulated(config) => format!("tracks, {} Hz", config.rate_hz),
            TrackSource::File(_) => "given tracks".to_owned(),
            TrackSource::Images { .. } => "images, followed".to_owned(),
            TrackSource::Rendered(_) => "rendered images, followed".to_owned(),
        };
        let fed_tracks = if tracks.has_images() { FedTracks::Followed } else { self.estimator.fed_tracks };
        let estimator = EstimatorConfig { fed_tracks, ..self.estimator.clone() };
        let of_loop = made_by.of(&[closed]);
        let odometry = drawings::OdometryDrawing {
            estimator: &estimator,
            networks: [accel, gyro],
            camera: &camera,
            made_by: &of_loop,
        };
        figures.add_drawing("architecture_odometry", "The odometry with DualProNet", closed, &odometry)?;
        let window = drawings::WindowDrawing { estimator: &estimator, made_by: &of_loop };
        figures.add_drawing("architecture_window", "The sliding window", closed, &window)?;
        let open = results.open.run.as_str();
        let figure = drawings::rmse(&results.open.value, &self.input.corpus.name)?;
        figures.add(
            "open_loop_rmse_vs_sigma",
            "Error of the estimated deviation, with its bound",
            &[open],
            figure,
        )?;
        let recordings = self.recordings()?;
        let keep = self.keep();
        let dir = self.work.join(closed);
        let rows = &results.closed.value;
        let noises = specs::noises([specs::BASELINE, specs::DUALPRONET]);
        figures.add(
            "trajectories",
            "All trajectories: truth, baseline, DualProNet",
            &[closed],
            drawings::trajectories(&recordings, rows, &dir, &keep, &noises)?,
        )?;
        let example = recordings.iter().find(|r| r.side == Side::Test).or(recordings.first());
        if let Some(recording) = example {
            if let Some(figure) = drawings::errors(recording, &dir, &keep, &noises)? {
                figures.add(
                    "error_by_time",
                    "Error by time, with what the estimator believes",
                    &[closed],
                    figure,
                )?;
            }
            for sensor in Sensor::ALL {
                let figure = drawings::sigma_over_flight(
                    recording,
                    &specs::noises(OVER_FLIGHT),
                    self.networks,
                    sensor,
                )?;
                let name = if sensor == Sensor::Accel { "flight_sigma" } else { "flight_sigma_gyro" };
                figures.add(name, "What is said over a flight", &[closed], figure)?;
            }
            let runs = [results.responses.run.as_str()];
            for sensor in Sensor::ALL {
                let noise = self.plan.injected.noise.with(Course::Step);
                let (imu, oracle) = noise.apply(&recording.imu, self.plan.seed);
                let figure = drawings::step_response(
                    recording,
                    &imu,
                    &oracle,
                    &specs::noises(FOLLOWING),
                    self.networks,
                    sensor,
                    self.plan.seed,
                )?;
                let name = if sensor == Sensor::Accel { "step_response" } else { "step_response_gyro" };
                figures.add(name, "Noise added in a step, and who follows", &runs, figure)?;
            }
        }
        if drawings::has_curve(study) {
            let caption = medians(&RowSet::new(&results.closed.value));
            let figure = drawings::sweep(study, &caption)?;
            figures.add("sweep", "Error against the constant given", &[closed], figure)?;
        }
        if let Some((_, made)) = results.injected.iter().find(|(course, _)| *course == Course::Step) {
            let rows = RowSet::new(&made.value);
            let study = Study::new(&rows, self.plan.margin)?;
            if drawings::has_curve(&study) {
                let factor = self.plan.injected.noise.factor;
                let caption = format!("Noise stepped x1, x{factor}, x1. {}", medians(&rows));
                let figure = drawings::injected_sweep(&study, &caption)?;
                figures.add(
                    "injected_sweep",
                    "Error against the constant given, under injected noise",
                    &[&made.run],
                    figure,
                )?;
            }
        }
        let FigureWriter { pictures, files, .. } = figures;
        progress.finish(&format!("{} figures", pictures.len()));
        Ok((pictures, files))
    }

    /// The network that `dualpronet` stands for.
    fn network(&self, sensor: Sensor) -> Option<&Network> {
        let stem = |n: &Network| n.path.file_stem().map(|s| s.to_string_lossy().into_owned());
        let own = |n: &&Network| {
            n.sensor() == sensor && stem(n).as_deref() == Some(dpn_core::estimate::DEFAULT_TAG)
        };
        self.networks.iter().find(own)
    }

    fn recordings(&self) -> Result<Vec<Recording>, PaperError> {
        let read = |place: &usize| self.input.source.recording(*place, self.plan.seed);
        Ok(self.input.places.iter().map(read).collect::<Result<_, _>>()?)
    }
}

/// Every stage's results.
struct Results {
    open: StageResult<Vec<dpn_eval::open_loop::Row>>,
    closed: StageResult<Vec<Row>>,
    injected: Vec<(Course, StageResult<Vec<Row>>)>,
    responses: StageResult<Vec<Response>>,
    times: StageResult<Vec<(NoiseSpec, f64)>>,
}

/// Figures being saved.
struct FigureWriter<'a> {
    out: &'a ResultPath,
    made_by: &'a Provenance,
    pictures: Vec<Picture>,
    /// What was written.
    files: Vec<String>,
    progress: &'a mut dyn Progress,
}

impl FigureWriter<'_> {
    fn add(
        &mut self,
        name: &'static str,
        title: &str,
        runs: &[&str],
        chart: Chart,
    ) -> Result<(), PaperError> {
        save(&chart.made_by(&self.made_by.of(runs)), self.out.join(name))?;
        let svg = self.out.join(format!("{name}.svg")).text()?;
        let beside = ENDINGS.into_iter().filter(|ending| *ending != "svg"); // which `added` names
        self.files.extend(beside.map(|ending| format!("{name}.{ending}")));
        self.added(name, title, runs, svg);
        Ok(())
    }

    /// A drawing from a template, which is SVG alone.
    fn add_drawing(
        &mut self,
        name: &'static str,
        title: &str,
        run: &str,
        drawing: &impl askama::Template,
    ) -> Result<(), PaperError> {
        let svg = drawing.render().expect("a template that compiled writes to a string");
        write_file(self.out.join(format!("{name}.svg")), &svg)?;
        self.added(name, title, &[run], svg);
        Ok(())
    }

    fn added(&mut self, name: &'static str, title: &str, runs: &[&str], svg: String) {
        self.files.push(format!("{name}.svg"));
        let runs = runs.iter().map(|run| (*run).to_owned()).collect();
        self.pictures.push(Picture { name, title: title.to_owned(), runs, svg });
        self.progress.step(self.pictures.len() as u64, name);
    }
}

/// What a mark of a sweep is, and of how many sequences.
fn medians(rows: &RowSet<'_>) -> String {
    format!(
        "Medians over {} sequences of medians over seeds; bands and bars: 95 % bootstrap over sequences. Marks stand at the root mean square of \
         what they say, side by side where they would cover each other.",
        rows.count(None)
    )
}

fn report(name: &str, run: &str, cached: bool, clock: Instant) -> StageReport {
    StageReport { name: name.to_owned(), run: run.to_owned(), cached, seconds: clock.elapsed().as_secs_f64() }
}

fn checksum(path: &ResultPath) -> Result<String, IoError> {
    Ok(of_bytes(&path.read_existing()?))
}
