//! How a window manager closes a window: it asks the program to, in the X protocol.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;

/// Asks all windows of the display, `:99` for example, to close.
pub fn close_windows(display: &str) {
    let mut stream = UnixStream::connect(format!("/tmp/.X11-unix/X{}", &display[1..])).unwrap();
    // Least significant byte first, protocol 11.0, no authority.
    stream.write_all(&[b'l', 0, 11, 0, 0, 0, 0, 0, 0, 0, 0, 0]).unwrap();
    let mut head = [0; 8];
    stream.read_exact(&mut head).unwrap();
    assert_eq!(head[0], 1, "the display takes no connection");
    let mut setup = vec![0; usize::from(u16::from_le_bytes([head[6], head[7]])) * 4];
    stream.read_exact(&mut setup).unwrap();
    // The root window stands behind the vendor's name and the formats of pixels.
    let vendor = usize::from(u16::from_le_bytes([setup[16], setup[17]])).next_multiple_of(4);
    let root = 32 + vendor + usize::from(setup[21]) * 8;
    let root: [u8; 4] = setup[root..root + 4].try_into().unwrap();

    let protocols = atom(&mut stream, "WM_PROTOCOLS");
    let delete = atom(&mut stream, "WM_DELETE_WINDOW");
    // QueryTree.
    let tree = ask(&mut stream, &[&[15, 0, 2, 0], &root[..]].concat());
    let windows: Vec<[u8; 4]> = tree[32..].as_chunks::<4>().0.to_vec();
    assert!(!windows.is_empty(), "there is no window");
    for window in windows {
        // SendEvent of a ClientMessage of format 32.
        let event = [&[33, 32, 0, 0], &window[..], &protocols[..], &delete[..], &[0; 16]].concat();
        stream.write_all(&[&[25, 0, 11, 0], &window[..], &[0; 4], &event[..]].concat()).unwrap();
    }
    // What is answered has been read behind the events.
    ask(&mut stream, &[43, 0, 1, 0]);
}

fn atom(stream: &mut UnixStream, name: &str) -> [u8; 4] {
    let length = name.len().next_multiple_of(4);
    let mut request = vec![16, 0, (2 + length / 4) as u8, 0, name.len() as u8, 0, 0, 0];
    request.extend(name.bytes());
    request.resize(8 + length, 0);
    ask(stream, &request)[8..12].try_into().unwrap()
}

fn ask(stream: &mut UnixStream, request: &[u8]) -> Vec<u8> {
    stream.write_all(request).unwrap();
    let mut reply = vec![0; 32];
    stream.read_exact(&mut reply).unwrap();
    assert_eq!(reply[0], 1, "the display refuses a request: {reply:?}");
    let mut rest = vec![0; u32::from_le_bytes(reply[4..8].try_into().unwrap()) as usize * 4];
    stream.read_exact(&mut rest).unwrap();
    reply.extend(rest);
    reply
}
