//! Drops a file on a window, as a file manager does (the XDND protocol, version 5).

use std::path::Path;
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConnectionExt, CreateWindowAux, EventMask, PropMode,
    SELECTION_NOTIFY_EVENT, SelectionNotifyEvent, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

use crate::x_server::{PATIENCE, atom, root};

/// XdndVersion in the highest byte, and that the kinds of data fit into the message.
const VERSION: u32 = 5 << 24;

/// Drops `file` on the middle of `target`.
pub fn drop_file(display: &str, target: u32, file: &Path) {
    let connection = x11rb::connect(Some(display)).unwrap().0;
    let root = root(&connection);
    let source = connection.generate_id().unwrap();
    let look = CreateWindowAux::new();
    connection.create_window(0, source, root, 0, 0, 1, 1, 0, WindowClass::INPUT_ONLY, 0, &look).unwrap();
    let atom = |name: &str| atom(&connection, name);
    let (selection, list, copy) = (atom("XdndSelection"), atom("text/uri-list"), atom("XdndActionCopy"));
    connection.set_selection_owner(source, selection, x11rb::CURRENT_TIME).unwrap();

    let shape = connection.get_geometry(target).unwrap().reply().unwrap();
    let middle = connection
        .translate_coordinates(target, root, (shape.width / 2) as i16, (shape.height / 2) as i16)
        .unwrap()
        .reply()
        .unwrap();
    let place = (middle.dst_x as u32) << 16 | middle.dst_y as u32;
    let send = |kind: &str, data: [u32; 5]| {
        let event = ClientMessageEvent::new(32, target, atom(kind), data);
        connection.send_event(false, target, EventMask::NO_EVENT, event).unwrap();
        connection.flush().unwrap();
    };
    let uri = format!("file://{}\r\n", file.display());
    let answer = |kind: &str| serve_until(&connection, atom(kind), list, &uri);
    send("XdndEnter", [source, VERSION, list, 0, 0]);
    send("XdndPosition", [source, 0, place, x11rb::CURRENT_TIME, copy]);
    assert_eq!(answer("XdndStatus")[1] & 1, 1, "the window takes no files");
    send("XdndDrop", [source, 0, x11rb::CURRENT_TIME, 0, 0]);
    answer("XdndFinished");
}

/// Serves `data` on request until a message of this kind arrives; returns that message's data.
fn serve_until(connection: &RustConnection, kind: u32, list: u32, data: &str) -> [u32; 5] {
    let end = Instant::now() + PATIENCE;
    loop {
        match connection.poll_for_event().unwrap() {
            Some(Event::ClientMessage(message)) if message.type_ == kind => return message.data.as_data32(),
            Some(Event::SelectionRequest(request)) => {
                let (owner, property) = (request.requestor, request.property);
                let known = request.target == list;
                if known {
                    let bytes = data.as_bytes();
                    connection.change_property8(PropMode::REPLACE, owner, property, list, bytes).unwrap();
                }
                let notice = SelectionNotifyEvent {
                    response_type: SELECTION_NOTIFY_EVENT,
                    sequence: 0,
                    time: request.time,
                    requestor: owner,
                    selection: request.selection,
                    target: request.target,
                    property: if known { property } else { AtomEnum::NONE.into() },
                };
                connection.send_event(false, owner, EventMask::NO_EVENT, notice).unwrap();
                connection.flush().unwrap();
            }
            Some(_) => {}
            None => {
                assert!(Instant::now() < end, "no answer to what is dropped");
                std::thread::sleep(Duration::from_millis(10));
            }
        }
    }
}
