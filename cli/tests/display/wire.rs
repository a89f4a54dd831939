//! A connection to an X display: as much of its protocol as tests need.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;

/// A connection.
pub struct Wire {
    stream: UnixStream,
    setup: Vec<u8>,
}

impl Wire {
    /// To the display of this name, `:99` for example.
    pub fn to(display: &str) -> Wire {
        let mut stream = UnixStream::connect(format!("/tmp/.X11-unix/X{}", &display[1..])).unwrap();
        // Least significant byte first, protocol 11.0, no authority.
        stream.write_all(&[b'l', 0, 11, 0, 0, 0, 0, 0, 0, 0, 0, 0]).unwrap();
        let mut head = [0; 8];
        stream.read_exact(&mut head).unwrap();
        assert_eq!(head[0], 1, "the display takes no connection");
        let mut setup = vec![0; usize::from(u16::from_le_bytes([head[6], head[7]])) * 4];
        stream.read_exact(&mut setup).unwrap();
        Wire { stream, setup }
    }

    /// The first and the last code of a key.
    pub fn key_codes(&self) -> [u8; 2] {
        [self.setup[26], self.setup[27]]
    }

    /// The windows that stand on their own.
    pub fn windows(&mut self) -> Vec<[u8; 4]> {
        // The root window stands behind the vendor's name and the formats of pixels.
        let vendor = usize::from(u16::from_le_bytes([self.setup[16], self.setup[17]])).next_multiple_of(4);
        let root = 32 + vendor + usize::from(self.setup[21]) * 8;
        let root: [u8; 4] = self.setup[root..root + 4].try_into().unwrap();
        // QueryTree.
        let tree = self.ask(&[&[15, 0, 2, 0], &root[..]].concat());
        tree[32..].as_chunks::<4>().0.to_vec()
    }

    /// Sends a request that has no reply.
    pub fn send(&mut self, request: &[u8]) {
        self.stream.write_all(request).unwrap();
    }

    /// Sends a request; gives its reply.
    pub fn ask(&mut self, request: &[u8]) -> Vec<u8> {
        self.send(request);
        loop {
            let mut reply = vec![0; 32];
            self.stream.read_exact(&mut reply).unwrap();
            assert_ne!(reply[0], 0, "the display refuses a request: {reply:?}");
            // All else is news of the keyboard.
            if reply[0] == 1 {
                let mut rest = vec![0; u32::from_le_bytes(reply[4..8].try_into().unwrap()) as usize * 4];
                self.stream.read_exact(&mut rest).unwrap();
                reply.extend(rest);
                return reply;
            }
        }
    }
}
