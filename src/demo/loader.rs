//! Loads scenes and builds their renderers on a thread of its own, while the window goes on.

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::{DemoError, Launch};
use crate::renderer::Renderer;
use crate::scene::{Scene, SceneDocument};
use crate::settings::Settings;
use crate::vulkan::Device;

/// What to build.
pub(super) struct Order {
    /// Scene, by name or file, as people know it.
    pub name: String,
    /// The scene itself where it has been edited; none: to be read.
    pub document: Option<SceneDocument>,
    pub device: Arc<Device>,
    /// Settings of a scene that is already on show; none: the scene's own, below those of the command line.
    pub settings: Option<Settings>,
    /// Pixels of the window.
    pub size: [u32; 2],
}

/// What was built.
pub(super) struct Built {
    pub name: String,
    pub document: SceneDocument,
    pub scene: Arc<Scene>,
    pub settings: Settings,
    pub renderer: Renderer,
    /// Whether it is the scene that was on show already.
    pub same: bool,
}

/// How far a job is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    Reading,
    Building,
}

impl Step {
    pub fn label(self) -> &'static str {
        match self {
            Self::Reading => "reading the scene",
            Self::Building => "building its BVH, shooting VPLs, uploading",
        }
    }
}

/// One job at a time; a newer order waits for the running one and replaces any that waits.
pub(super) struct Loader {
    launch: Launch,
    running: Option<Job>,
    waiting: Option<Order>,
}

struct Job {
    name: String,
    step: Step,
    started: Instant,
    messages: Receiver<Message>,
    thread: JoinHandle<()>,
}

enum Message {
    Step(Step),
    Done(Box<Result<Built, DemoError>>),
}

impl Loader {
    pub fn new(launch: &Launch) -> Self {
        Self { launch: launch.clone(), running: None, waiting: None }
    }

    /// Starts on `order`, or puts it in line.
    pub fn start(&mut self, order: Order) {
        if self.running.is_some() {
            self.waiting = Some(order);
            return;
        }
        let (sender, messages) = channel();
        let launch = self.launch.clone();
        let name = order.name.clone();
        let thread = std::thread::spawn(move || {
            let built = pool(|| build(order, &launch, &sender));
            // The window may have closed meanwhile.
            let _ = sender.send(Message::Done(Box::new(built)));
        });
        self.running = Some(Job { name, step: Step::Reading, started: Instant::now(), messages, thread });
    }

    /// What is being loaded, how far it is and for how long.
    pub fn progress(&self) -> Option<(&str, Step, Duration)> {
        self.running.as_ref().map(|job| (job.name.as_str(), job.step, job.started.elapsed()))
    }

    /// The outcome of the running job, once, if it has ended.
    pub fn poll(&mut self) -> Option<Result<Built, DemoError>> {
        let job = self.running.as_mut()?;
        loop {
            match job.messages.try_recv() {
                Ok(Message::Step(step)) => job.step = step,
                Ok(Message::Done(built)) => {
                    self.next();
                    return Some(*built);
                }
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => {
                    let name = job.name.clone();
                    self.next();
                    return Some(Err(DemoError::Loading(format!("{name}: internal error"))));
                }
            }
        }
    }

    /// Waits for the running job and throws away what it makes.
    pub fn stop(&mut self) {
        self.waiting = None;
        if let Some(job) = self.running.take() {
            let _ = job.thread.join();
        }
    }

    fn next(&mut self) {
        if let Some(job) = self.running.take() {
            let _ = job.thread.join();
        }
        if let Some(order) = self.waiting.take() {
            self.start(order);
        }
    }
}

fn build(order: Order, launch: &Launch, sender: &Sender<Message>) -> Result<Built, DemoError> {
    let assets = launch.assets.as_deref();
    let (document, scene) = match order.document.clone() {
        Some(document) => {
            let scene = document.build(assets)?;
            (document, scene)
        }
        None => SceneDocument::open(&order.name, assets)?,
    };
    let scene = Arc::new(scene);
    let same = order.settings.is_some();
    let settings = match &order.settings {
        Some(settings) => Settings { size: order.size, ..settings.clone() },
        None => settings_for(&scene, &order, launch)?,
    };
    let _ = sender.send(Message::Step(Step::Building));
    let renderer = Renderer::new(&order.device, &scene, &settings, &scene.pose(0.0))?;
    Ok(Built { name: order.name, document, scene, settings, renderer, same })
}

/// The settings of the scene and the command line, for the window's size. On a CPU what neither of them
/// says is less than elsewhere.
fn settings_for(scene: &Scene, order: &Order, launch: &Launch) -> Result<Settings, DemoError> {
    let mut table = scene.settings.clone();
    if order.device.is_cpu() {
        table.entry("vpls").or_insert(toml::Value::Integer(CPU_VPLS));
    }
    let given: Vec<&str> = launch.given.iter().map(String::as_str).collect();
    let resolved = Settings::resolve(&table, &launch.settings, &given);
    let settings = resolved.map_err(|error| DemoError::Settings { scene: order.name.clone(), error })?;
    Ok(Settings { size: order.size, ..settings })
}

/// VPL slots on a CPU driver, where nobody asks for another number.
const CPU_VPLS: i64 = 128;

/// Runs `work` on half of the cores at most, and away from those that frames need: a frame that waits for
/// its own small task would otherwise get a large one of the loader's to do meanwhile.
fn pool<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    static POOL: OnceLock<Option<ThreadPool>> = OnceLock::new();
    let pool = POOL.get_or_init(|| {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        ThreadPoolBuilder::new()
            .num_threads((cores / 2).max(1))
            .thread_name(|index| format!("loader {index}"))
            .build()
            .ok()
    });
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}
