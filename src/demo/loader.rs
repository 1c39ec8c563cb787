//! Loads scenes and builds their renderers on a background thread.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rayon::ThreadPoolBuilder;

use super::error::DemoError;
use super::launch::Launch;
use crate::formats::{ReadFiles, SceneDocument};
use crate::renderer::{PreparedScene, Renderer};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::vulkan::Device;

/// A request to load a scene.
pub(super) struct LoadRequest {
    /// Scene, by name or file.
    pub name: String,
    /// The edited scene; none: read it from disk, with the settings of the command line over its own.
    pub edited: Option<Edited>,
    pub device: Arc<Device>,
    /// Pixels of the window.
    pub size: [u32; 2],
}

/// The current scene as it is to be.
pub(super) struct Edited {
    pub document: SceneDocument,
    /// Its files, which need not be read again.
    pub read: ReadFiles,
    pub settings: Settings,
    /// Whether to compile the shaders of the repository before.
    #[cfg(feature = "shader-reload")]
    pub compiles_shaders: bool,
    /// The scene of the current renderer, if that may go on with another one.
    pub current: Option<Arc<Scene>>,
}

/// A loaded scene with its renderer.
pub(super) struct Built {
    pub name: String,
    pub document: SceneDocument,
    pub scene: Arc<Scene>,
    pub settings: Settings,
    pub read: ReadFiles,
    /// None if the current one can go on with the scene.
    pub renderer: Option<Renderer>,
    /// Whether it is a rebuild of the current scene.
    pub same: bool,
}

/// Progress of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    Reading,
    Building,
    Compiling,
}

impl Step {
    pub fn label(self) -> &'static str {
        match self {
            Self::Reading => "reading the scene",
            Self::Building => "building its BVH",
            Self::Compiling => "compiling shaders, uploading, shooting VPLs",
        }
    }
}

/// Runs one job at a time; a newer request replaces any that waits.
pub(super) struct Loader {
    launch: Launch,
    running: Option<Job>,
    waiting: Option<LoadRequest>,
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

    /// Starts `request`, or queues it behind the running job.
    pub fn start(&mut self, request: LoadRequest) {
        if self.running.is_some() {
            self.waiting = Some(request);
            return;
        }
        let (sender, messages) = channel();
        let launch = self.launch.clone();
        let name = request.name.clone();
        let thread = std::thread::spawn(move || {
            let built = in_own_pool("loader", || build(request, &launch, &sender));
            // The receiver may be gone if the window was closed.
            let _ = sender.send(Message::Done(Box::new(built)));
        });
        self.running = Some(Job { name, step: Step::Reading, started: Instant::now(), messages, thread });
    }

    /// Name, progress and elapsed time of the running job.
    pub fn progress(&self) -> Option<(&str, Step, Duration)> {
        self.running.as_ref().map(|job| (job.name.as_str(), job.step, job.started.elapsed()))
    }

    /// The result of the running job, once, when it has ended.
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

    /// Waits for the running job and discards its result.
    pub fn stop(&mut self) {
        self.waiting = None;
        self.next();
    }

    fn next(&mut self) {
        if let Some(job) = self.running.take() {
            let _ = job.thread.join();
        }
        if let Some(request) = self.waiting.take() {
            self.start(request);
        }
    }
}

fn build(request: LoadRequest, launch: &Launch, sender: &Sender<Message>) -> Result<Built, DemoError> {
    let assets = launch.assets.as_deref();
    let LoadRequest { name, edited, device, size } = request;
    let same = edited.is_some();
    #[cfg(feature = "shader-reload")]
    if edited.as_ref().is_some_and(|edited| edited.compiles_shaders) {
        crate::vulkan::compile_shaders().map_err(DemoError::Loading)?;
    }
    let (document, scene, read, settings, current) = match edited {
        Some(Edited { document, mut read, settings, current, .. }) => {
            let scene = document.build(assets, &mut read)?;
            (document, scene, read, Settings { size, ..settings }, current)
        }
        None => {
            let (document, scene, read) = SceneDocument::open(&name, assets)?;
            let settings = Settings::resolve(&scene.settings, &launch.given)
                .map_err(|error| DemoError::Settings { scene: name.clone(), error })?;
            (document, scene, read, Settings { size, ..settings }, None)
        }
    };
    let scene = Arc::new(scene);
    let reuses_renderer = current.is_some_and(|current| scene.same_geometry_and_bindings(&current));
    let renderer = if reuses_renderer {
        None
    } else {
        let _ = sender.send(Message::Step(Step::Building));
        let prepared = PreparedScene::new(&scene);
        let _ = sender.send(Message::Step(Step::Compiling));
        Some(Renderer::with_scene(&device, prepared, &settings, &scene.pose(0.0))?)
    };
    Ok(Built { name, document, scene, read, settings, renderer, same })
}

/// Runs `work` in a thread pool of its own, on at most half as many threads. In the global pool, a frame that waits
/// for a small task could steal a large one; in a shared one, loading would wait for the path tracer.
pub(super) fn in_own_pool<T: Send>(name: &'static str, work: impl FnOnce() -> T + Send) -> T {
    let pool = ThreadPoolBuilder::new()
        .num_threads((rayon::current_num_threads() / 2).max(1))
        .thread_name(move |index| format!("{name} {index}"))
        .build();
    match pool {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}
