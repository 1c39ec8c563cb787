//! Key bindings, and the list of all keys and gestures.

use winit::keyboard::{KeyCode, ModifiersState};

use super::action::{Action, AppAction, EditAction, ViewAction};

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
    bind("F1", "this list", KeyCode::F1, NONE, || AppAction::ToggleHelp.into()),
    bind("Tab", "show or hide panel and handles", KeyCode::Tab, NONE, || AppAction::TogglePanel.into()),
    bind("Shift+Tab", "show or hide handles and labels alone", KeyCode::Tab, SHIFT, || {
        AppAction::ToggleOverlays.into()
    }),
    bind("F6", "keyboard to the panel (Tab, arrows, Space, Enter), and back", KeyCode::F6, NONE, || {
        AppAction::ToggleKeyboard.into()
    }),
    bind("Space", "pause or resume the animation", KeyCode::Space, NONE, || ViewAction::TogglePause.into()),
    bind("Home", "reset the camera", KeyCode::Home, NONE, || ViewAction::Home.into()),
    bind("F2", "begin or end the tour", KeyCode::F2, NONE, || AppAction::ToggleTour.into()),
    bind("F3", "measure frame rate against temporal sets", KeyCode::F3, NONE, || {
        AppAction::ToggleCompare.into()
    }),
    bind("F11", "toggle full screen", KeyCode::F11, NONE, || AppAction::ToggleFullscreen.into()),
    bind("F12", "screenshot (PNG)", KeyCode::F12, NONE, || AppAction::Screenshot { exr: false }.into()),
    bind("Shift+F12", "screenshot (EXR, linear)", KeyCode::F12, SHIFT, || {
        AppAction::Screenshot { exr: true }.into()
    }),
    bind("F4", "copy the command line that renders this picture", KeyCode::F4, NONE, || {
        AppAction::CopyCommand.into()
    }),
    bind("F5", "reload the scene", KeyCode::F5, NONE, || AppAction::Reload.into()),
    #[cfg(feature = "shader-reload")]
    bind("Shift+F5", "compile the shaders again", KeyCode::F5, SHIFT, || AppAction::ReloadShaders.into()),
    bind("C", "compare with another method right of a divider", KeyCode::KeyC, NONE, || {
        ViewAction::ToggleSplit.into()
    }),
    bind("G", "compare with the reference, by the path tracer", KeyCode::KeyG, NONE, || {
        ViewAction::ToggleReference.into()
    }),
    bind("X", "the error of the left side (FLIP)", KeyCode::KeyX, NONE, || {
        ViewAction::ToggleDifference.into()
    }),
    bind("B", "flip between the left and the right side", KeyCode::KeyB, NONE, || ViewAction::Flip.into()),
    bind("-", "darker by half a stop", KeyCode::Minus, NONE, || ViewAction::Expose(Some(-0.5)).into()),
    bind("=", "brighter by half a stop", KeyCode::Equal, NONE, || ViewAction::Expose(Some(0.5)).into()),
    bind("0", "automatic exposure", KeyCode::Digit0, NONE, || ViewAction::Expose(None).into()),
    bind("V", "next buffer", KeyCode::KeyV, NONE, || ViewAction::StepBuffer(1).into()),
    bind("Shift+V", "previous buffer", KeyCode::KeyV, SHIFT, || ViewAction::StepBuffer(-1).into()),
    bind("P", "show or hide VPL paths", KeyCode::KeyP, NONE, || ViewAction::TogglePaths.into()),
    bind(".", "isolate the next VPL", KeyCode::Period, NONE, || ViewAction::StepVpl(1).into()),
    bind(",", "isolate the previous VPL", KeyCode::Comma, NONE, || ViewAction::StepVpl(-1).into()),
    bind("/", "show all VPLs", KeyCode::Slash, NONE, || ViewAction::AllVpls.into()),
    bind(
        "I",
        "inspector: material of the clicked point, and the VPLs that light it",
        KeyCode::KeyI,
        NONE,
        || ViewAction::ToggleInspector.into(),
    ),
    bind("T", "handles to move, rotate or scale: the next kind", KeyCode::KeyT, NONE, || {
        EditAction::Handles(None).into()
    }),
    bind("Esc", "clear the selection; end the tour or a measurement", KeyCode::Escape, NONE, || {
        EditAction::Select(None).into()
    }),
    bind("H", "attach the selected light to the camera", KeyCode::KeyH, NONE, || {
        EditAction::ToggleHeadlamp.into()
    }),
    bind("Ctrl+D", "duplicate the selected light or object", KeyCode::KeyD, CONTROL, || {
        EditAction::Duplicate.into()
    }),
    bind("Del", "delete the selected light or object", KeyCode::Delete, NONE, || EditAction::Delete.into()),
    bind("Ctrl+Z", "undo the last edit", KeyCode::KeyZ, CONTROL, || EditAction::Undo.into()),
    bind("Ctrl+Shift+Z", "redo it", KeyCode::KeyZ, CONTROL.union(SHIFT), || EditAction::Redo.into()),
    bind("Ctrl+O", "open a scene", KeyCode::KeyO, CONTROL, || AppAction::AskOpen.into()),
    bind("Ctrl+S", "save the scene", KeyCode::KeyS, CONTROL, || AppAction::AskSave.into()),
    bind("Ctrl+R", "start recording; again: stop and save", KeyCode::KeyR, CONTROL, || {
        AppAction::ToggleRecording.into()
    }),
    bind("Ctrl+Q", "close", KeyCode::KeyQ, CONTROL, || AppAction::Quit.into()),
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
        CONTROL => Some(ViewAction::StoreBookmark(number).into()),
        NONE => Some(ViewAction::GoToBookmark(number).into()),
        _ => None,
    }
}
