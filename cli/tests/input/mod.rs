//! A hand at the mouse and the keyboard of an X display: the few requests of the X protocol that take, by the extension
//! XTEST.

use std::time::Duration;

use super::display::wire::Wire;

/// Events of the core protocol.
const KEY_PRESS: u8 = 2;
const KEY_RELEASE: u8 = 3;
const BUTTON_PRESS: u8 = 4;
const BUTTON_RELEASE: u8 = 5;
const MOTION: u8 = 6;

/// A connection that moves the pointer and presses keys.
pub struct Hand {
    wire: Wire,
    xtest: u8,
    /// Key symbols by key code, as many a code.
    first_code: u8,
    symbols: Vec<Vec<u32>>,
}

impl Hand {
    /// At the display of this name, such as `:99`, once a window is seen there.
    pub fn at(display: &str) -> Hand {
        let mut wire = Wire::to(display);
        focus(&mut wire);
        // QueryExtension.
        let reply = wire.ask(&[&[98, 0, 4, 0, 5, 0, 0, 0], &b"XTEST\0\0\0"[..]].concat());
        assert_eq!(reply[8], 1, "the display has no XTEST");
        let xtest = reply[9];
        // GetKeyboardMapping.
        let [first_code, last_code] = wire.key_codes();
        let reply = wire.ask(&[101, 0, 2, 0, first_code, last_code - first_code + 1, 0, 0]);
        let words: Vec<u32> = reply[32..].as_chunks::<4>().0.iter().copied().map(u32::from_le_bytes).collect();
        let symbols = words.chunks_exact(usize::from(reply[1]).max(1)).map(<[u32]>::to_vec).collect();
        Hand { wire, xtest, first_code, symbols }
    }

    fn fake(&mut self, event: u8, detail: u8, [x, y]: [i16; 2]) {
        let mut request = vec![self.xtest, 2, 9, 0, event, detail, 0, 0];
        request.extend([0; 16]);
        request.extend(x.to_le_bytes());
        request.extend(y.to_le_bytes());
        request.extend([0; 8]);
        self.wire.send(&request);
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

/// Gives the keyboard to the window that is seen, as a window manager does.
fn focus(wire: &mut Wire) {
    for window in wire.windows() {
        // GetWindowAttributes; its state is 2 where it is seen.
        if wire.ask(&[&[3, 0, 2, 0], &window[..]].concat())[26] == 2 {
            // SetInputFocus.
            wire.send(&[&[42, 1, 3, 0], &window[..], &[0; 4]].concat());
        }
    }
}
