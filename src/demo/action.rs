//! User actions, with the values that they carry.

use std::path::PathBuf;

use serde::Serialize;

use super::clock::FramePacing;
use crate::bench::Method;
use crate::formats::{AnimationEntry, EnvironmentEntry, InstanceEntry, LightEntry, MaterialEdit, Primitive};
use crate::renderer::DebugView;
use crate::scene::LightType;
use crate::settings::Settings;
use crate::vulkan::PresentMode;

/// A user action, by key or from the panel. Actions run in order between frames; each is logged by its own name.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Action {
    App(AppAction),
    View(ViewAction),
    Edit(EditAction),
}

/// Actions on the window: panel, device, files, scenes, comparison, tour.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AppAction {
    /// Shows or hides the list of keys.
    ToggleHelp,
    /// Hides the first lines for good.
    DismissWelcome,
    /// Hides the last error.
    DismissError,
    /// Shows or hides the panel and all overlays.
    TogglePanel,
    /// Shows or hides what is drawn over the picture.
    ToggleOverlays,
    /// Gives the keyboard to the panel, or back to the picture.
    ToggleKeyboard,
    /// Begins the tour, or ends it.
    ToggleTour,
    /// Enters or leaves full screen.
    ToggleFullscreen,
    /// Measures frame rates against temporal sets, or closes the comparison.
    ToggleCompare,
    /// Measures these; none: closes the comparison.
    Compare(Option<RequestedSettings>),
    /// Writes the report of the comparison.
    SaveComparison,
    /// Sets the swapchain's present mode.
    SetPresentMode(PresentMode),
    /// Recreates the device and everything on it: the device of this index in `glowworm info`, or the same one.
    RestartDevice(Option<usize>),
    /// Loads a scene by name or file and replaces the current one.
    Open(String),
    /// Reloads the scene from disk.
    Reload,
    /// Compiles the shaders of the repository and makes the renderer anew.
    #[cfg(feature = "shader-reload")]
    ReloadShaders,
    /// Saves the current scene.
    Save(PathBuf),
    /// Opens the file dialog to open a scene.
    AskOpen,
    /// Opens the file dialog to save the scene.
    AskSave,
    /// Opens the file dialog to choose that.
    AskMap,
    /// Opens the file dialog to choose a picture for the right side of the divider.
    AskPicture,
    /// Opens the file dialog to choose the model of an object to add.
    AskModel,
    /// Saves the picture as PNG or EXR.
    Screenshot {
        /// EXR with linear radiance, instead of the tone-mapped PNG.
        exr: bool,
    },
    /// Starts recording; the second time, stops and saves the recording.
    ToggleRecording,
    /// Copies the command line that renders this picture to the clipboard.
    CopyCommand,
    /// Closes the question about unsaved edits; the scene stays.
    KeepScene,
    /// Closes the window.
    Quit,
}

/// Actions on what is shown: time, camera, resolution, exposure, divided window, views, inspector.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ViewAction {
    /// Pauses or resumes the animation.
    TogglePause,
    /// Pauses the animation, or has it go on.
    Pause(bool),
    /// Sets the animation time, seconds.
    Scrub(f64),
    /// Sets how animation time advances.
    SetPacing(FramePacing),
    /// Resets the camera to the scene's.
    Home,
    /// Stores the camera as bookmark 0 to 8.
    StoreBookmark(usize),
    /// Restores a bookmarked camera.
    GoToBookmark(usize),
    /// Sets the window pixels per picture pixel in each direction; none: they follow the frame rate.
    SetCoarseness(Option<u32>),
    /// Changes the exposure by stops; none: it becomes automatic again.
    Expose(Option<f32>),
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
}

/// Actions on the document and the settings, and on what of it is selected.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EditAction {
    /// Changes the settings.
    Set(Box<Settings>),
    /// Selects a light or an instance, or nothing.
    Select(Option<Selected>),
    /// Sets the kind of handles; none: the next one.
    Handles(Option<HandleMode>),
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
    /// Adds a light in view of the camera.
    AddLight(LightType),
    /// Adds an object in view of the camera.
    AddObject(NewObject),
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
}

/// A selectable entry of the document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Selected {
    /// One of the instances.
    Instance(usize),
    /// One of the lights.
    Light(usize),
}

/// An instance or a light of the document.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Entry {
    Instance(usize, InstanceEntry),
    Light(usize, LightEntry),
}

/// An object to add.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NewObject {
    /// Another instance of this model.
    Model(String),
    /// A shape with a material of its own.
    Shape(Primitive),
    /// A model's file.
    File(PathBuf),
}

/// Kind of the handles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum HandleMode {
    /// Arrows.
    #[default]
    Move,
    /// Rings.
    Rotate,
    /// Bars, one factor for all axes.
    Scale,
}

/// The picture to show right of the divider.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RightSide {
    /// A renderer with these settings; their size is that of the picture.
    Settings(Box<Settings>),
    /// The path tracer's picture, as long as nothing moves.
    Reference,
    /// The picture of a file.
    Picture(PathBuf),
}

/// The settings to compare.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RequestedSettings {
    /// Numbers of temporal sets, for the methods that have any.
    pub sets: Vec<u32>,
    /// Methods by their short names; all pictures are compared with the first one at the first number.
    pub methods: Vec<Method>,
}

/// Actions in the order in which they are to run.
#[derive(Default)]
pub(super) struct Actions(pub Vec<Action>);

impl Actions {
    pub fn push(&mut self, action: impl Into<Action>) {
        self.0.push(action.into());
    }

    pub fn extend(&mut self, actions: impl IntoIterator<Item: Into<Action>>) {
        self.0.extend(actions.into_iter().map(Into::into));
    }
}

impl From<AppAction> for Action {
    fn from(action: AppAction) -> Self {
        Self::App(action)
    }
}

impl From<ViewAction> for Action {
    fn from(action: ViewAction) -> Self {
        Self::View(action)
    }
}

impl From<EditAction> for Action {
    fn from(action: EditAction) -> Self {
        Self::Edit(action)
    }
}

impl Entry {
    pub fn animation(&mut self) -> &mut Option<AnimationEntry> {
        match self {
            Self::Instance(_, entry) => &mut entry.animation,
            Self::Light(_, entry) => &mut entry.animation,
        }
    }

    /// The edit that changes the document to it.
    pub fn edit(self) -> EditAction {
        match self {
            Self::Instance(index, entry) => EditAction::EditInstance(index, Box::new(entry)),
            Self::Light(index, entry) => EditAction::EditLight(index, Box::new(entry)),
        }
    }
}

impl HandleMode {
    /// All kinds, in the order in which they follow each other.
    pub const ALL: [Self; 3] = [Self::Move, Self::Rotate, Self::Scale];

    /// A word for people.
    pub fn label(self) -> &'static str {
        ["move", "rotate", "scale"][self as usize]
    }

    /// The kind after this one.
    #[must_use]
    pub fn next(self) -> Self {
        Self::ALL[(self as usize + 1) % Self::ALL.len()]
    }
}
