//! A hand at the mouse and the keyboard of an X display: the few requests of the X protocol that take, by the extension
//! XTEST.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::time::Duration;

/// Events of the core protocol.
const KEY_PRESS: u8 = 2;
const KEY_RELEASE: u8 = 3;
const BUTTON_PRESS: u8 = 4;
const BUTTON_RELEASE: u8 = 5;
const MOTION: u8 = 6;

/// A connection that moves the pointer and presses keys.
pub struct Hand {
    stream: UnixStream,
    xtest: u8,
    /// Key symbols by key code, as many a code.
    first_code: u8,
    symbols: Vec<Vec<u32>>,
}

impl Hand {
    /// At the display of this name, such as `:99`, once a window is seen there.
    pub fn at(display: &str) -> Hand {
        let mut stream = UnixStream::connect(format!("/tmp/.X11-unix/X{}", &display[1..])).unwrap();
        // Least significant byte first, protocol 11.0, no authority.
        stream.write_all(&[b'l', 0, 11, 0, 0, 0, 0, 0, 0, 0, 0, 0]).unwrap();
        let mut head = [0; 8];
        stream.read_exact(&mut head).unwrap();
        assert_eq!(head[0], 1, "the display takes no connection");
        let mut setup = vec![0; usize::from(u16::from_le_bytes([head[6], head[7]])) * 4];
        stream.read_exact(&mut setup).unwrap();
        let (first_code, last_code) = (setup[26], setup[27]);

        let word = |bytes: &[u8], at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        // Behind the vendor's name and the formats of pixels.
        let vendor = usize::from(u16::from_le_bytes([setup[16], setup[17]])).next_multiple_of(4);
        let root = word(&setup, 32 + vendor + usize::from(setup[21]) * 8);

        let mut hand = Hand { stream, xtest: 0, first_code, symbols: Vec::new() };
        hand.focus(root);
        // QueryExtension.
        let name = b"XTEST\0\0\0";
        let mut request = vec![98, 0, 4, 0, 5, 0, 0, 0];
        request.extend(name);
        let reply = hand.ask(&request);
        assert_eq!(reply[8], 1, "the display has no XTEST");
        hand.xtest = reply[9];
        // GetKeyboardMapping.
        let count = last_code - first_code + 1;
        let reply = hand.ask(&[101, 0, 2, 0, first_code, count, 0, 0]);
        let a_code = usize::from(reply[1]);
        hand.symbols = (0..usize::from(count))
            .map(|code| (0..a_code).map(|i| word(&reply, 32 + (code * a_code + i) * 4)).collect())
            .collect();
        hand
    }

    /// Gives the keyboard to the window that is seen, as a window manager does.
    fn focus(&mut self, root: u32) {
        // QueryTree.
        let mut request = vec![15, 0, 2, 0];
        request.extend(root.to_le_bytes());
        let tree = self.ask(&request);
        for window in tree[32..].chunks_exact(4) {
            // GetWindowAttributes; its state is 2 where it is seen.
            let mut request = vec![3, 0, 2, 0];
            request.extend(window);
            if self.ask(&request)[26] == 2 {
                // SetInputFocus.
                let mut request = vec![42, 1, 3, 0];
                request.extend(window);
                request.extend([0; 4]);
                self.stream.write_all(&request).unwrap();
            }
        }
    }

    fn ask(&mut self, request: &[u8]) -> Vec<u8> {
        self.stream.write_all(request).unwrap();
        loop {
            let mut reply = vec![0; 32];
            self.stream.read_exact(&mut reply).unwrap();
            assert_ne!(reply[0], 0, "the display refuses a request: {reply:?}");
            // Events are for others.
            if reply[0] == 1 {
                let more = u32::from_le_bytes(reply[4..8].try_into().unwrap()) as usize * 4;
                let mut rest = vec![0; more];
                self.stream.read_exact(&mut rest).unwrap();
                reply.extend(rest);
                return reply;
            }
        }
    }

    fn fake(&mut self, event: u8, detail: u8, [x, y]: [i16; 2]) {
        let mut request = vec![self.xtest, 2, 9, 0, event, detail, 0, 0];
        request.extend([0; 16]);
        request.extend(x.to_le_bytes());
        request.extend(y.to_le_bytes());
        request.extend([0; 8]);
        self.stream.write_all(&request).unwrap();
        // One frame or more of the window.
        std::thread::sleep(Duration::from_millis(40));
    }

    /// Moves the pointer to a pixel of the screen.
    pub fn to(&mut self, (x, y): (usize, usize)) {
        self.fake(MOTION, 0, [x as i16, y as i16]);
    }

    /// Presses a button (1 left, 2 middle, 3 right, 4 and 5 the wheel) and lets it go.
    pub fn click(&mut self, at: (usize, usize), button: u8) {
        self.to(at);
        self.fake(BUTTON_PRESS, button, [0, 0]);
        self.fake(BUTTON_RELEASE, button, [0, 0]);
    }

    /// Drags from one pixel to another, in a few steps.
    pub fn drag(&mut self, from: (usize, usize), to: (usize, usize), button: u8) {
        self.to(from);
        self.fake(BUTTON_PRESS, button, [0, 0]);
        for step in 1..=5 {
            let along = |a: usize, b: usize| (a * (5 - step) + b * step) / 5;
            self.to((along(from.0, to.0), along(from.1, to.1)));
        }
        self.fake(BUTTON_RELEASE, button, [0, 0]);
    }

    /// Presses the key of an X symbol, which for Latin letters is their code.
    pub fn key(&mut self, symbol: u32) {
        let found = self.symbols.iter().enumerate().find_map(|(code, symbols)| {
            symbols.iter().take(2).position(|own| *own == symbol).map(|level| (code as u8, level))
        });
        let (code, level) = found.unwrap_or_else(|| panic!("no key has the symbol {symbol:#x}"));
        let code = self.first_code + code;
        let shift = (level == 1).then(|| self.code_of(0xffe1));
        if let Some(shift) = shift {
            self.fake(KEY_PRESS, shift, [0, 0]);
        }
        self.fake(KEY_PRESS, code, [0, 0]);
        self.fake(KEY_RELEASE, code, [0, 0]);
        if let Some(shift) = shift {
            self.fake(KEY_RELEASE, shift, [0, 0]);
        }
    }

    fn code_of(&self, symbol: u32) -> u8 {
        let code = self.symbols.iter().position(|symbols| symbols.first() == Some(&symbol)).expect("the key is there");
        self.first_code + code as u8
    }
}
