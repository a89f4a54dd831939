//! How a window manager closes a window: it asks the program to, in the X protocol.

use super::wire::Wire;

/// Asks all windows of the display, `:99` for example, to close.
pub fn close_windows(display: &str) {
    let mut wire = Wire::to(display);
    let protocols = atom(&mut wire, "WM_PROTOCOLS");
    let delete = atom(&mut wire, "WM_DELETE_WINDOW");
    let windows = wire.windows();
    assert!(!windows.is_empty(), "there is no window");
    for window in windows {
        // SendEvent of a ClientMessage of format 32.
        let event = [&[33, 32, 0, 0], &window[..], &protocols[..], &delete[..], &[0; 16]].concat();
        wire.send(&[&[25, 0, 11, 0], &window[..], &[0; 4], &event[..]].concat());
    }
    // What is answered has been read behind the events.
    wire.ask(&[43, 0, 1, 0]);
}

fn atom(wire: &mut Wire, name: &str) -> [u8; 4] {
    let length = name.len().next_multiple_of(4);
    let mut request = vec![16, 0, (2 + length / 4) as u8, 0, name.len() as u8, 0, 0, 0];
    request.extend(name.bytes());
    request.resize(8 + length, 0);
    wire.ask(&request)[8..12].try_into().unwrap()
}
