//! Key bindings, and the list of all keys and gestures.

use winit::keyboard::KeyCode::{
    self, Comma, Delete, Digit0, Digit1, Digit2, Digit3, Digit4, Digit5, Digit6, Digit7, Digit8, Digit9,
    Equal, Escape, F1, F2, F3, F4, F5, F6, F11, F12, Home, KeyB, KeyC, KeyD, KeyG, KeyH, KeyI, KeyO, KeyP,
    KeyQ, KeyR, KeyS, KeyT, KeyV, KeyX, KeyZ, Minus, Period, Slash, Space, Tab,
};
use winit::keyboard::ModifiersState;

use super::action::{Action, AppAction, EditAction, ViewAction};

/// A key binding: the key as the list of keys shows it, a description, the key itself, its modifiers, the action.
type Binding = (&'static str, &'static str, KeyCode, ModifiersState, fn() -> Action);

const NONE: ModifiersState = ModifiersState::empty();
const SHIFT: ModifiersState = ModifiersState::SHIFT;
const CONTROL: ModifiersState = ModifiersState::CONTROL;

/// Keys that do one thing when pressed.
pub(super) const BINDINGS: &[Binding] = &[
    ("F1", "this list", F1, NONE, || AppAction::ToggleHelp.into()),
    ("Tab", "show or hide panel and handles", Tab, NONE, || AppAction::TogglePanel.into()),
    ("Shift+Tab", "show or hide handles and labels alone", Tab, SHIFT, || AppAction::ToggleOverlays.into()),
    ("F6", "keyboard to the panel (Tab, arrows, Space, Enter), and back", F6, NONE, || {
        AppAction::ToggleKeyboard.into()
    }),
    ("Space", "pause or resume the animation", Space, NONE, || ViewAction::TogglePause.into()),
    ("Home", "reset the camera", Home, NONE, || ViewAction::Home.into()),
    ("F2", "begin or end the tour", F2, NONE, || AppAction::ToggleTour.into()),
    ("F3", "measure frame rate against temporal sets", F3, NONE, || AppAction::ToggleCompare.into()),
    ("F11", "toggle full screen", F11, NONE, || AppAction::ToggleFullscreen.into()),
    ("F12", "screenshot (PNG)", F12, NONE, || AppAction::Screenshot { exr: false }.into()),
    ("Shift+F12", "screenshot (EXR, linear)", F12, SHIFT, || AppAction::Screenshot { exr: true }.into()),
    ("F4", "copy the command line that renders this picture", F4, NONE, || AppAction::CopyCommand.into()),
    ("F5", "reload the scene", F5, NONE, || AppAction::Reload.into()),
    #[cfg(feature = "shader-reload")]
    ("Shift+F5", "compile the shaders again", F5, SHIFT, || AppAction::ReloadShaders.into()),
    ("C", "compare with another method right of a divider", KeyC, NONE, || ViewAction::ToggleSplit.into()),
    ("G", "compare with the reference, by the path tracer", KeyG, NONE, || {
        ViewAction::ToggleReference.into()
    }),
    ("X", "the error of the left side (FLIP)", KeyX, NONE, || ViewAction::ToggleDifference.into()),
    ("B", "flip between the left and the right side", KeyB, NONE, || ViewAction::Flip.into()),
    ("-", "darker by half a stop", Minus, NONE, || ViewAction::Expose(Some(-0.5)).into()),
    ("=", "brighter by half a stop", Equal, NONE, || ViewAction::Expose(Some(0.5)).into()),
    ("0", "automatic exposure", Digit0, NONE, || ViewAction::Expose(None).into()),
    ("V", "next buffer", KeyV, NONE, || ViewAction::StepBuffer(1).into()),
    ("Shift+V", "previous buffer", KeyV, SHIFT, || ViewAction::StepBuffer(-1).into()),
    ("P", "show or hide VPL paths", KeyP, NONE, || ViewAction::TogglePaths.into()),
    (".", "isolate the next VPL", Period, NONE, || ViewAction::StepVpl(1).into()),
    (",", "isolate the previous VPL", Comma, NONE, || ViewAction::StepVpl(-1).into()),
    ("/", "show all VPLs", Slash, NONE, || ViewAction::AllVpls.into()),
    ("I", "inspector: material of the clicked point, and the VPLs that light it", KeyI, NONE, || {
        ViewAction::ToggleInspector.into()
    }),
    ("T", "handles to move, rotate or scale: the next kind", KeyT, NONE, || EditAction::Handles(None).into()),
    ("Esc", "clear the selection; end the tour or a measurement", Escape, NONE, || {
        EditAction::Select(None).into()
    }),
    ("H", "attach the selected light to the camera", KeyH, NONE, || EditAction::ToggleHeadlamp.into()),
    ("Ctrl+D", "duplicate the selected light or object", KeyD, CONTROL, || EditAction::Duplicate.into()),
    ("Del", "delete the selected light or object", Delete, NONE, || EditAction::Delete.into()),
    ("Ctrl+Z", "undo the last edit", KeyZ, CONTROL, || EditAction::Undo.into()),
    ("Ctrl+Shift+Z", "redo it", KeyZ, CONTROL.union(SHIFT), || EditAction::Redo.into()),
    ("Ctrl+O", "open a scene", KeyO, CONTROL, || AppAction::AskOpen.into()),
    ("Ctrl+S", "save the scene", KeyS, CONTROL, || AppAction::AskSave.into()),
    ("Ctrl+R", "start recording; again: stop and save", KeyR, CONTROL, || AppAction::ToggleRecording.into()),
    ("Ctrl+Q", "close", KeyQ, CONTROL, || AppAction::Quit.into()),
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

/// The action bound to `code` with these modifiers.
pub(super) fn action_of(code: KeyCode, modifiers: ModifiersState) -> Option<Action> {
    let with = modifiers & (SHIFT | CONTROL | ModifiersState::ALT);
    let bound = BINDINGS.iter().find(|(_, _, key, modifiers, _)| (*key, *modifiers) == (code, with));
    bound.map(|(.., action)| action()).or_else(|| bookmark_of(code, with))
}

fn bookmark_of(code: KeyCode, with: ModifiersState) -> Option<Action> {
    let digits = [Digit1, Digit2, Digit3, Digit4, Digit5, Digit6, Digit7, Digit8, Digit9];
    let number = digits.iter().position(|digit| *digit == code)?;
    match with {
        CONTROL => Some(ViewAction::StoreBookmark(number).into()),
        NONE => Some(ViewAction::GoToBookmark(number).into()),
        _ => None,
    }
}
