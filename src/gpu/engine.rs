//! Batches and steps of several networks on the card: what is put there, which kernels run, what comes back.

use crate::error::GpuError;
use crate::kernels::pass::{Job, pass};
use crate::kernels::update::{Constants, adam, gather};
use crate::plan::UNITS;
use crate::room::Room;
use crate::state::{Examples, State};
use cubecl::prelude::*;
use std::fmt;
use std::sync::Arc;
use std::sync::mpsc::Sender;

/// Workgroups that a network's batch is spread over at most; each sums its windows' gradients in their order.
const GROUPS: usize = 512;
/// Memory that workgroups may take at a time, beside what the card binds at most.
const ROOM: usize = 1 << 30;

/// What is compiled and laid out once for all steps of one shape.
#[derive(Debug, PartialEq)]
pub(crate) struct Shape {
    pub(crate) job: Job,
    pub(crate) constants: Constants,
    /// Places of packed parameters in the flat vector, and in the turned copy.
    pub(crate) flat: Vec<u32>,
    pub(crate) turned: Vec<u32>,
    /// Longest gradient; 0 leaves it as it is.
    pub(crate) clip: f32,
}

/// Steps of one network.
pub(crate) struct Steps {
    pub(crate) shape: Arc<Shape>,
    pub(crate) units: [f32; 2],
    pub(crate) state: State,
    pub(crate) examples: Examples,
    pub(crate) batch: usize,
    /// Numbers of each step, as the kernel of Adam reads them.
    pub(crate) table: Vec<f32>,
    pub(crate) reply: Sender<Result<(State, Vec<f32>), GpuError>>,
}

impl Steps {
    /// Steps that may go to the card together have this in common.
    pub(crate) fn alike(&self) -> (Arc<Shape>, usize, usize, bool) {
        (
            Arc::clone(&self.shape),
            self.examples.rows(),
            self.batch,
            matches!(self.examples, Examples::Drawn { .. }),
        )
    }
}

/// Windows to be answered by one network.
pub(crate) struct Asked {
    pub(crate) shape: Arc<Shape>,
    pub(crate) units: [f32; 2],
    pub(crate) weights: Vec<f32>,
    pub(crate) windows: Vec<f32>,
    pub(crate) reply: Sender<Result<Vec<f32>, GpuError>>,
}

pub(crate) enum Wanted {
    Steps(Box<Steps>),
    Answers(Asked),
}

/// The card's client.
pub(crate) struct Engine {
    client: Client,
    adapter: Arc<str>,
}

impl Engine {
    pub(crate) fn new(client: Client, adapter: Arc<str>) -> Self {
        Self { client, adapter }
    }

    pub(crate) fn failed(&self, error: &dyn fmt::Display) -> GpuError {
        // What follows is where in the program it happened.
        let error = error.to_string();
        let reason = error.split_once("Backtrace:").map_or(&*error, |(reason, _)| reason).trim().to_owned();
        GpuError::Failed { adapter: self.adapter.to_string(), reason }
    }

    /// The job with the near arena where this card has room for it.
    fn placed(&self, job: &Job) -> Job {
        let shared = 4 * job.plan.near <= self.client.properties().hardware.max_shared_memory_size;
        Job { shared, ..job.clone() }
    }

    /// Bytes that are bound at a time.
    fn most(&self) -> usize {
        (self.client.properties().memory.max_page_size as usize).min(ROOM)
    }

    /// Workgroups a network, and networks at a time, of which each has `rows` windows there and `out` numbers a workgroup.
    fn spread(
        &self,
        job: &Job,
        (batch, rows): (usize, usize),
        networks: usize,
        out: usize,
    ) -> Result<(usize, usize), GpuError> {
        let most = self.most();
        let room = |what, bytes| match bytes <= most {
            true => Ok(bytes),
            false => {
                let (adapter, bytes, most) = (self.adapter.to_string(), bytes as u64, most as u64);
                Err(GpuError::Memory { adapter, what, bytes, most })
            }
        };
        let each = room("a window", 4 * job.plan.near.max(job.plan.far).max(out))?;
        let windows = room("a batch", 4 * rows * job.plan.window)?;
        let groups = batch.min(GROUPS).min(most / each);
        Ok((groups, (most / (each * groups).max(windows)).clamp(1, networks)))
    }

    pub(crate) fn answers(&self, asked: &Asked) -> Result<Vec<f32>, GpuError> {
        let plan = &asked.shape.job.plan;
        let job = self.placed(&Job { loss: None, ..asked.shape.job.clone() });
        let outputs = plan.outputs();
        let (weights, turned) = packed(&asked.shape, [&asked.weights]);
        let [weights, turned] = [weights, turned].map(|numbers| Room::of(&self.client, &numbers));
        let units = Room::of(&self.client, &asked.units);
        let most = self.most();
        let mut answers = Vec::new();
        for windows in asked.windows.chunks((most / (4 * plan.window)).max(1) * plan.window) {
            let rows = windows.len() / plan.window;
            let (groups, _) = self.spread(&job, (rows, rows), 1, 0)?;
            let out = Room::empty(&self.client, rows * outputs);
            let near = if job.shared { 0 } else { plan.near };
            pass::launch(
                &self.client,
                CubeCount::Static(groups as u32, 1, 1),
                CubeDim::new_1d(UNITS as u32),
                weights.arg(),
                turned.arg(),
                Room::of(&self.client, windows).arg(),
                units.arg(),
                units.arg(),
                Room::empty(&self.client, groups * near).arg(),
                Room::empty(&self.client, groups * plan.far).arg(),
                out.arg(),
                0,
                rows as u32,
                rows as u32,
                job.clone(),
            );
            answers.extend(self.read([&out])?.remove(0));
        }
        Ok(answers)
    }

    /// Takes networks of one shape through their steps, in one launch as far as memory reaches; states and each step's loss.
    pub(crate) fn steps(&self, gang: &[Steps]) -> Result<Vec<(State, Vec<f32>)>, GpuError> {
        let (shape, rows, batch, _) = gang[0].alike();
        let job = self.placed(&shape.job);
        let (groups, networks) =
            self.spread(&job, (batch.min(rows), rows), gang.len(), job.plan.parameters + 1)?;
        let mut done = Vec::new();
        for gang in gang.chunks(networks) {
            done.extend(self.together(gang, &shape, &job, groups, rows, batch)?);
        }
        Ok(done)
    }

    fn together(
        &self,
        gang: &[Steps],
        shape: &Shape,
        job: &Job,
        groups: usize,
        rows: usize,
        batch: usize,
    ) -> Result<Vec<(State, Vec<f32>)>, GpuError> {
        let (client, plan) = (&self.client, &job.plan);
        let (networks, parameters) = (gang.len(), plan.parameters);
        let steps = rows.div_ceil(batch);
        let all =
            |of: fn(&Steps) -> &[f32]| Room::of(client, &gang.iter().map(of).collect::<Vec<_>>().concat());
        let (weights, turned) = packed(shape, gang.iter().map(|steps| &steps.state.weights));
        let [weights, turned] = [weights, turned].map(|numbers| Room::of(client, &numbers));
        let of: [fn(&Steps) -> &Vec<f32>; 3] =
            [|steps| &steps.state.averaged, |steps| &steps.state.mean, |steps| &steps.state.square];
        let [averaged, mean, square] = of.map(|of| Room::of(client, &packed(shape, gang.iter().map(of)).0));
        let (windows, labels) = self.examples(gang, rows, plan.window);
        let (units, table) = (all(|steps| &steps.units), all(|steps| &steps.table));
        let order = Room::of(client, &shape.turned);
        let near = Room::empty(client, if job.shared { 0 } else { networks * groups * plan.near });
        let far = Room::empty(client, networks * groups * plan.far);
        let partial = Room::empty(client, networks * groups * (parameters + 1));
        let gradient = Room::empty(client, networks * parameters);
        let parts = (parameters + 1).div_ceil(UNITS);
        let squares = Room::empty(client, networks * parts);
        let losses = Room::empty(client, networks * steps);
        let units_of = CubeDim::new_1d(UNITS as u32);
        for step in 0..steps {
            let count = batch.min(rows - step * batch);
            let groups = groups.min(count);
            pass::launch(
                client,
                CubeCount::Static(groups as u32, networks as u32, 1),
                units_of,
                weights.arg(),
                turned.arg(),
                windows.arg(),
                labels.arg(),
                units.arg(),
                near.arg(),
                far.arg(),
                partial.arg(),
                (step * batch) as u32,
                count as u32,
                rows as u32,
                job.clone(),
            );
            gather::launch(
                client,
                CubeCount::Static(parts as u32, networks as u32, 1),
                units_of,
                partial.arg(),
                gradient.arg(),
                squares.arg(),
                losses.arg(),
                groups as u32,
                step as u32,
                steps as u32,
                count as u32,
                parameters,
            );
            adam::launch(
                client,
                CubeCount::Static(parts as u32, networks as u32, 1),
                units_of,
                gradient.arg(),
                squares.arg(),
                order.arg(),
                table.arg(),
                weights.arg(),
                turned.arg(),
                averaged.arg(),
                mean.arg(),
                square.arg(),
                parts as u32,
                step as u32,
                steps as u32,
                shape.clip,
                shape.constants,
            );
        }
        let read = self.read([&weights, &averaged, &mean, &square, &losses])?;
        let of = |vector: usize, network: usize| {
            let packed = &read[vector][network * parameters..(network + 1) * parameters];
            let mut flat = vec![0.0; parameters];
            for (number, place) in packed.iter().zip(&shape.flat) {
                flat[*place as usize] = *number;
            }
            flat
        };
        let state = |network| {
            let [weights, averaged, mean, square] = [0, 1, 2, 3].map(|vector| of(vector, network));
            let losses = read[4][network * steps..(network + 1) * steps].to_vec();
            (State { weights, averaged, mean, square }, losses)
        };
        Ok((0..networks).map(state).collect())
    }

    /// Windows, `[networks, rows, window]`, and labels, `[networks, rows]`, on the card: brought there, or drawn there where all networks' are.
    fn examples(&self, gang: &[Steps], rows: usize, window: usize) -> (Room, Room) {
        let client = &self.client;
        let (mut windows, mut labels) = (Vec::new(), Vec::new());
        for steps in gang {
            if let Examples::Given(some, their) = &steps.examples {
                windows.extend_from_slice(some);
                labels.extend_from_slice(their);
            }
        }
        if !labels.is_empty() {
            return (Room::of(client, &windows), Room::of(client, &labels));
        }
        let windows = Room::empty(client, gang.len() * rows * window);
        let labels = Room::empty(client, gang.len() * rows);
        for (network, steps) in gang.iter().enumerate() {
            let Examples::Drawn { source, rows: chosen, key } = &steps.examples else { continue };
            source.draw(client, chosen, *key, &windows, &labels, network * rows);
        }
        (windows, labels)
    }

    fn read<const N: usize>(&self, rooms: [&Room; N]) -> Result<Vec<Vec<f32>>, GpuError> {
        let handles = rooms.iter().map(|room| room.handle.clone()).collect();
        let bytes = self.client.read(handles).map_err(|error| self.failed(&error))?;
        Ok(bytes.iter().map(|bytes| f32::from_bytes(bytes).to_vec()).collect())
    }
}

/// Flat vectors packed, one behind the other, and turned.
fn packed<'a>(shape: &Shape, flat: impl IntoIterator<Item = &'a Vec<f32>>) -> (Vec<f32>, Vec<f32>) {
    let (mut packed, mut turned) = (Vec::new(), Vec::new());
    for flat in flat {
        let from = packed.len();
        packed.extend(shape.flat.iter().map(|place| flat[*place as usize]));
        turned.resize(packed.len(), 0.0);
        for (number, place) in packed[from..].iter().zip(&shape.turned) {
            turned[from + *place as usize] = *number;
        }
    }
    (packed, turned)
}
