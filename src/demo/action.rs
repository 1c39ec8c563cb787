//! What a person can ask for, by key or in the panel, and which key asks for what.

use std::path::PathBuf;

use serde::Serialize;
use winit::keyboard::{KeyCode, ModifiersState};

use super::stage::Selected;
use crate::renderer::DebugView;
use crate::scene::{InstanceEntry, LightEntry, LightType};
use crate::settings::Settings;
use crate::vulkan::PresentMode;

/// One wish. They are carried out one after the other, between frames, and each is in the log.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Action {
    /// Shows or hides the list of keys.
    ToggleHelp,
    /// Shows or hides the panel and everything else that is drawn over the picture.
    TogglePanel,
    /// Stops or starts the animation.
    TogglePause,
    /// Goes to a time of the animation, seconds.
    Scrub(f64),
    /// Back to the scene's own camera.
    Home,
    /// Keeps the camera under a number, 0 to 8.
    StoreBookmark(usize),
    /// Goes to a camera that was kept.
    GoToBookmark(usize),
    /// Enters or leaves full screen.
    ToggleFullscreen,
    /// Changes how frames reach the screen.
    SetPresentMode(PresentMode),
    /// Makes the device and everything on it anew: the one of this index in `glowworm info`, or the same.
    RestartDevice(Option<usize>),
    /// Loads a scene by name or file and shows it instead of this one.
    Open(String),
    /// How many pixels of the window, each way, one pixel of the picture covers.
    SetCoarseness(u32),
    /// Loads the scene again as it is on disk.
    Reload,
    /// Changes the settings.
    Set(Box<Settings>),
    /// Shows something else in place of the picture, or over it.
    View(Box<DebugView>),
    /// Shows the next buffer, or the one before.
    StepBuffer(i32),
    /// Shows the light of the next VPL alone, or of the one before.
    StepVpl(i32),
    /// Shows the light of all VPLs again.
    AllVpls,
    /// Draws the paths of VPLs, or no longer.
    TogglePaths,
    /// Lists the VPLs that light the next point that is clicked, or no longer.
    ToggleInspector,
    /// Chooses a light or an instance, or nothing.
    Select(Option<Selected>),
    /// Handles that turn in place of those that move, and back.
    ToggleHandles,
    /// Changes a light.
    EditLight(usize, Box<LightEntry>),
    /// Changes an instance.
    EditInstance(usize, Box<InstanceEntry>),
    /// Adds a light where the camera looks.
    AddLight(LightType),
    /// Adds a light like the one that is chosen.
    Duplicate,
    /// Deletes the light that is chosen.
    Delete,
    /// The chosen light goes with the camera, or stays where it is.
    ToggleHeadlamp,
    /// Writes the scene as it is now.
    Save(PathBuf),
    /// Asks for a file to open.
    AskOpen,
    /// Asks for a file to save the scene to.
    AskSave,
    /// Writes the picture to a file: PNG, or EXR.
    Screenshot {
        /// Linear radiance instead of what is on screen.
        exr: bool,
    },
    /// Records all that is done from now on; the second time, writes it to a file.
    ToggleRecording,
    /// Puts the command line that renders this picture into the clipboard.
    CopyCommand,
    /// Closes the window.
    Quit,
}

/// A key with what it asks for.
pub(super) struct Binding {
    /// As people write it.
    pub keys: &'static str,
    pub what: &'static str,
    code: KeyCode,
    with: ModifiersState,
    action: fn() -> Action,
}

const NONE: ModifiersState = ModifiersState::empty();
const SHIFT: ModifiersState = ModifiersState::SHIFT;
const CONTROL: ModifiersState = ModifiersState::CONTROL;

/// Keys that do one thing when pressed.
pub(super) const BINDINGS: &[Binding] = &[
    bind("F1", "this list", KeyCode::F1, NONE, || Action::ToggleHelp),
    bind("Tab", "panel and handles on and off", KeyCode::Tab, NONE, || Action::TogglePanel),
    bind("Space", "animation on and off", KeyCode::Space, NONE, || Action::TogglePause),
    bind("Home", "the scene's own camera", KeyCode::Home, NONE, || Action::Home),
    bind("F11", "full screen on and off", KeyCode::F11, NONE, || Action::ToggleFullscreen),
    bind("F12", "screenshot (PNG)", KeyCode::F12, NONE, || Action::Screenshot { exr: false }),
    bind("Shift+F12", "screenshot (EXR, linear)", KeyCode::F12, SHIFT, || Action::Screenshot { exr: true }),
    bind("F4", "copy the command line of this picture", KeyCode::F4, NONE, || Action::CopyCommand),
    bind("F5", "load the scene again", KeyCode::F5, NONE, || Action::Reload),
    bind("V", "next buffer", KeyCode::KeyV, NONE, || Action::StepBuffer(1)),
    bind("Shift+V", "buffer before", KeyCode::KeyV, SHIFT, || Action::StepBuffer(-1)),
    bind("P", "paths of VPLs on and off", KeyCode::KeyP, NONE, || Action::TogglePaths),
    bind(".", "next VPL alone", KeyCode::Period, NONE, || Action::StepVpl(1)),
    bind(",", "VPL before alone", KeyCode::Comma, NONE, || Action::StepVpl(-1)),
    bind("/", "all VPLs again", KeyCode::Slash, NONE, || Action::AllVpls),
    bind("I", "inspector: which VPLs light the point that is clicked", KeyCode::KeyI, NONE, || {
        Action::ToggleInspector
    }),
    bind("T", "handles that move, handles that turn", KeyCode::KeyT, NONE, || Action::ToggleHandles),
    bind("Esc", "choose nothing", KeyCode::Escape, NONE, || Action::Select(None)),
    bind("H", "the chosen light goes with the camera", KeyCode::KeyH, NONE, || Action::ToggleHeadlamp),
    bind("Ctrl+D", "copy the chosen light", KeyCode::KeyD, CONTROL, || Action::Duplicate),
    bind("Del", "delete the chosen light", KeyCode::Delete, NONE, || Action::Delete),
    bind("Ctrl+O", "open a scene", KeyCode::KeyO, CONTROL, || Action::AskOpen),
    bind("Ctrl+S", "save the scene", KeyCode::KeyS, CONTROL, || Action::AskSave),
    bind("Ctrl+R", "record all that is done; again: save it", KeyCode::KeyR, CONTROL, || {
        Action::ToggleRecording
    }),
    bind("Ctrl+Q", "close", KeyCode::KeyQ, CONTROL, || Action::Quit),
];

/// What is held or dragged, for the list of keys.
pub(super) const GESTURES: &[(&str, &str)] = &[
    ("W A S D", "fly forwards, left, back, right"),
    ("Q E", "fly down, up"),
    ("Shift", "fly four times as fast"),
    ("Wheel", "fly slower, faster"),
    ("Click", "choose a thing or a light"),
    ("Left drag", "a handle: move or turn what is chosen"),
    ("Right drag", "look around"),
    ("Middle drag", "orbit about the point under the pointer"),
    ("Ctrl+1 … 9", "keep this camera"),
    ("1 … 9", "go to a kept camera"),
];

const fn bind(
    keys: &'static str,
    what: &'static str,
    code: KeyCode,
    with: ModifiersState,
    action: fn() -> Action,
) -> Binding {
    Binding { keys, what, code, with, action }
}

/// What pressing `code` with these modifiers asks for.
pub(super) fn action_of(code: KeyCode, modifiers: ModifiersState) -> Option<Action> {
    let with = modifiers & (SHIFT | CONTROL | ModifiersState::ALT);
    let bound = BINDINGS.iter().find(|binding| binding.code == code && binding.with == with);
    bound.map(|binding| (binding.action)()).or_else(|| bookmark_of(code, with))
}

fn bookmark_of(code: KeyCode, with: ModifiersState) -> Option<Action> {
    use KeyCode::{Digit1, Digit2, Digit3, Digit4, Digit5, Digit6, Digit7, Digit8, Digit9};
    let digits = [Digit1, Digit2, Digit3, Digit4, Digit5, Digit6, Digit7, Digit8, Digit9];
    let number = digits.iter().position(|digit| *digit == code)?;
    match with {
        CONTROL => Some(Action::StoreBookmark(number)),
        NONE => Some(Action::GoToBookmark(number)),
        _ => None,
    }
}
