//! User actions, and their key bindings.

use std::path::PathBuf;

use serde::Serialize;
use winit::keyboard::{KeyCode, ModifiersState};

use super::compare::Wanted;
use super::edit::NewObject;
use super::handles::Mode;
use super::session::Selected;
use super::split::RightSide;
use crate::formats::{EnvironmentEntry, InstanceEntry, LightEntry, MaterialEdit};
use crate::renderer::DebugView;
use crate::scene::LightType;
use crate::settings::Settings;
use crate::vulkan::PresentMode;

/// A user action, by key or from the panel. Actions run in order between frames; each is logged.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Action {
    /// Shows or hides the list of keys.
    ToggleHelp,
    /// Hides the first lines for good.
    DismissWelcome,
    /// Shows or hides the panel and all overlays.
    TogglePanel,
    /// Shows or hides what is drawn over the picture.
    ToggleOverlays,
    /// Gives the keyboard to the panel, or back to the picture.
    ToggleKeyboard,
    /// Pauses or resumes the animation.
    TogglePause,
    /// Pauses the animation, or has it go on.
    Pause(bool),
    /// Begins the tour, or ends it.
    ToggleTour,
    /// Sets the animation time, seconds.
    Scrub(f64),
    /// Resets the camera to the scene's.
    Home,
    /// Stores the camera as bookmark 0 to 8.
    StoreBookmark(usize),
    /// Restores a bookmarked camera.
    GoToBookmark(usize),
    /// Enters or leaves full screen.
    ToggleFullscreen,
    /// Measures frame rates against temporal sets, or closes the comparison.
    ToggleCompare,
    /// Measures these; none: closes the comparison.
    Compare(Option<Wanted>),
    /// Writes the report of the comparison.
    SaveComparison,
    /// Sets the swapchain's present mode.
    SetPresentMode(PresentMode),
    /// Recreates the device and everything on it: the device of this index in `glowworm info`, or the same one.
    RestartDevice(Option<usize>),
    /// Loads a scene by name or file and replaces the current one.
    Open(String),
    /// Sets the window pixels per picture pixel in each direction; none: they follow the frame rate.
    SetCoarseness(Option<u32>),
    /// Reloads the scene from disk.
    Reload,
    /// Compiles the shaders of the repository and makes the renderer anew.
    #[cfg(feature = "shader-reload")]
    ReloadShaders,
    /// Changes the settings.
    Set(Box<Settings>),
    /// Divides the window, or shows something else right of the divider; none: the whole window is one picture again.
    Split(Option<RightSide>),
    /// Divides the window between two methods, or no longer.
    ToggleSplit,
    /// Shows the reference right of the divider, or no longer.
    ToggleReference,
    /// Moves the divider, share of the width.
    MoveDivider(f32),
    /// Shows the left side in the whole window, or the right one.
    Flip,
    /// Changes the exposure by stops; none: it becomes automatic again.
    Expose(Option<f32>),
    /// Shows or hides the error of the left side.
    ToggleDifference,
    /// Sets the debug view.
    View(Box<DebugView>),
    /// Steps to the next (+1) or previous (-1) buffer view.
    StepBuffer(i32),
    /// Isolates the next (+1) or previous (-1) VPL.
    StepVpl(i32),
    /// Shows the light of all VPLs again.
    AllVpls,
    /// Toggles the display of VPL paths.
    TogglePaths,
    /// Toggles the inspector, which lists the VPLs that light the clicked point.
    ToggleInspector,
    /// Edits a material of the scene.
    ChooseMaterial(usize),
    /// Selects a light or an instance, or nothing.
    Select(Option<Selected>),
    /// Sets the kind of handles; none: the next one.
    Handles(Option<Mode>),
    /// Changes a light.
    EditLight(usize, Box<LightEntry>),
    /// Changes an instance.
    EditInstance(usize, Box<InstanceEntry>),
    /// Changes the materials of a name.
    EditMaterial(Box<MaterialEdit>),
    /// Changes the environment, or takes it away.
    EditEnvironment(Option<Box<EnvironmentEntry>>),
    /// Uses an `.hdr` or `.exr` as the map of the environment.
    OpenMap(PathBuf),
    /// Opens the file dialog to choose that.
    AskMap,
    /// Opens the file dialog to choose a picture for the right side of the divider.
    AskPicture,
    /// Adds a light in view of the camera.
    AddLight(LightType),
    /// Adds an object in view of the camera.
    AddObject(NewObject),
    /// Opens the file dialog to choose the model of an object to add.
    AskModel,
    /// Duplicates the selected light or object.
    Duplicate,
    /// Deletes the selected light or object.
    Delete,
    /// Attaches the selected light to the camera, or detaches it.
    ToggleHeadlamp,
    /// Takes the last edit or change of settings back.
    Undo,
    /// Makes it again.
    Redo,
    /// Saves the current scene.
    Save(PathBuf),
    /// Opens the file dialog to open a scene.
    AskOpen,
    /// Opens the file dialog to save the scene.
    AskSave,
    /// Saves the picture as PNG or EXR.
    Screenshot {
        /// EXR with linear radiance, instead of the tone-mapped PNG.
        exr: bool,
    },
    /// Starts recording; the second time, stops and saves the recording.
    ToggleRecording,
    /// Copies the command line that renders this picture to the clipboard.
    CopyCommand,
    /// Closes the window.
    Quit,
}

/// A key binding.
pub(super) struct Binding {
    /// Key as shown in the list of keys.
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
    bind("Tab", "show or hide panel and handles", KeyCode::Tab, NONE, || Action::TogglePanel),
    bind("Shift+Tab", "show or hide handles and labels alone", KeyCode::Tab, SHIFT, || {
        Action::ToggleOverlays
    }),
    bind("F6", "keyboard to the panel (Tab, arrows, Space, Enter), and back", KeyCode::F6, NONE, || {
        Action::ToggleKeyboard
    }),
    bind("Space", "pause or resume the animation", KeyCode::Space, NONE, || Action::TogglePause),
    bind("Home", "reset the camera", KeyCode::Home, NONE, || Action::Home),
    bind("F2", "begin or end the tour", KeyCode::F2, NONE, || Action::ToggleTour),
    bind("F3", "measure frame rate against temporal sets", KeyCode::F3, NONE, || Action::ToggleCompare),
    bind("F11", "toggle full screen", KeyCode::F11, NONE, || Action::ToggleFullscreen),
    bind("F12", "screenshot (PNG)", KeyCode::F12, NONE, || Action::Screenshot { exr: false }),
    bind("Shift+F12", "screenshot (EXR, linear)", KeyCode::F12, SHIFT, || Action::Screenshot { exr: true }),
    bind("F4", "copy the command line that renders this picture", KeyCode::F4, NONE, || Action::CopyCommand),
    bind("F5", "reload the scene", KeyCode::F5, NONE, || Action::Reload),
    #[cfg(feature = "shader-reload")]
    bind("Shift+F5", "compile the shaders again", KeyCode::F5, SHIFT, || Action::ReloadShaders),
    bind("C", "compare with another method right of a divider", KeyCode::KeyC, NONE, || Action::ToggleSplit),
    bind("G", "compare with the reference, by the path tracer", KeyCode::KeyG, NONE, || {
        Action::ToggleReference
    }),
    bind("X", "the error of the left side (FLIP)", KeyCode::KeyX, NONE, || Action::ToggleDifference),
    bind("B", "flip between the left and the right side", KeyCode::KeyB, NONE, || Action::Flip),
    bind("-", "darker by half a stop", KeyCode::Minus, NONE, || Action::Expose(Some(-0.5))),
    bind("=", "brighter by half a stop", KeyCode::Equal, NONE, || Action::Expose(Some(0.5))),
    bind("0", "automatic exposure", KeyCode::Digit0, NONE, || Action::Expose(None)),
    bind("V", "next buffer", KeyCode::KeyV, NONE, || Action::StepBuffer(1)),
    bind("Shift+V", "previous buffer", KeyCode::KeyV, SHIFT, || Action::StepBuffer(-1)),
    bind("P", "show or hide VPL paths", KeyCode::KeyP, NONE, || Action::TogglePaths),
    bind(".", "isolate the next VPL", KeyCode::Period, NONE, || Action::StepVpl(1)),
    bind(",", "isolate the previous VPL", KeyCode::Comma, NONE, || Action::StepVpl(-1)),
    bind("/", "show all VPLs", KeyCode::Slash, NONE, || Action::AllVpls),
    bind(
        "I",
        "inspector: material of the clicked point, and the VPLs that light it",
        KeyCode::KeyI,
        NONE,
        || Action::ToggleInspector,
    ),
    bind("T", "handles to move, rotate or scale: the next kind", KeyCode::KeyT, NONE, || {
        Action::Handles(None)
    }),
    bind("Esc", "clear the selection; end the tour or a measurement", KeyCode::Escape, NONE, || {
        Action::Select(None)
    }),
    bind("H", "attach the selected light to the camera", KeyCode::KeyH, NONE, || Action::ToggleHeadlamp),
    bind("Ctrl+D", "duplicate the selected light or object", KeyCode::KeyD, CONTROL, || Action::Duplicate),
    bind("Del", "delete the selected light or object", KeyCode::Delete, NONE, || Action::Delete),
    bind("Ctrl+Z", "undo the last edit", KeyCode::KeyZ, CONTROL, || Action::Undo),
    bind("Ctrl+Shift+Z", "redo it", KeyCode::KeyZ, CONTROL.union(SHIFT), || Action::Redo),
    bind("Ctrl+O", "open a scene", KeyCode::KeyO, CONTROL, || Action::AskOpen),
    bind("Ctrl+S", "save the scene", KeyCode::KeyS, CONTROL, || Action::AskSave),
    bind("Ctrl+R", "start recording; again: stop and save", KeyCode::KeyR, CONTROL, || {
        Action::ToggleRecording
    }),
    bind("Ctrl+Q", "close", KeyCode::KeyQ, CONTROL, || Action::Quit),
];

/// Held keys and mouse gestures, for the list of keys.
pub(super) const GESTURES: &[(&str, &str)] = &[
    ("W A S D", "fly forwards, left, back, right"),
    ("Q E", "fly down, up"),
    ("Shift", "fly four times as fast"),
    ("Wheel", "fly slower, faster"),
    ("Ctrl+Wheel", "zoom out, in"),
    ("Click", "select an object or a light"),
    ("Left drag", "a handle: move, rotate or scale the selection"),
    ("Right drag", "look around"),
    ("Middle drag", "orbit around the point under the pointer"),
    ("Ctrl+1 … 9", "store a camera bookmark"),
    ("1 … 9", "go to a camera bookmark"),
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

/// The action bound to `code` with these modifiers.
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
