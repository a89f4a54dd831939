//! Messages on standard input and output.

use std::io::{self, BufRead, Read, Write};
use std::thread::JoinHandle;

use lsp_server::{Connection, Message};
use lsp_types::notification::{Exit, Notification as _};

/// Most bytes of a message.
const MOST_BYTES: u64 = 512 << 20;

/// Most bytes of a line before a message.
const MOST_HEADER_BYTES: u64 = 8 << 10;

/// The threads that read and write.
pub struct Threads([JoinHandle<io::Result<()>>; 2]);

impl Threads {
    /// Waits until everything is written. The connection must be gone.
    ///
    /// # Errors
    /// What was read is no message; nobody reads what is written.
    pub fn join(self) -> io::Result<()> {
        self.0.into_iter().try_for_each(|thread| thread.join().unwrap_or_else(|_| Err(io::Error::other("it stopped"))))
    }
}

/// The connection with the editor that started this program. What it says is read ahead, so that what it takes back is
/// seen before its turn.
///
/// # Errors
/// No threads.
pub fn connect() -> io::Result<(Connection, Threads)> {
    let (server, Connection { sender, receiver }) = Connection::memory();
    let reads = std::thread::Builder::new().name("read".into()).spawn(move || {
        let mut input = io::stdin().lock();
        while let Some(message) = read(&mut input)? {
            let last = matches!(&message, Message::Notification(message) if message.method == Exit::METHOD);
            if sender.send(message).is_err() || last {
                break;
            }
        }
        Ok(())
    })?;
    let writes = std::thread::Builder::new().name("write".into()).spawn(move || {
        let mut output = io::stdout().lock();
        receiver.iter().try_for_each(|message| message.write(&mut output).and_then(|()| output.flush()))
    })?;
    Ok((server, Threads([reads, writes])))
}

/// The next message; `None` at the end.
fn read(input: &mut impl BufRead) -> io::Result<Option<Message>> {
    let wrong = |text: String| io::Error::new(io::ErrorKind::InvalidData, text);
    let mut length = None;
    loop {
        let mut line = Vec::new();
        if input.by_ref().take(MOST_HEADER_BYTES).read_until(b'\n', &mut line)? == 0 {
            return Ok(None);
        }
        let line = String::from_utf8_lossy(&line);
        let line = line.trim_end();
        if line.is_empty() {
            break;
        }
        let begins = || line.chars().take(60).collect::<String>();
        let (name, value) =
            line.split_once(':').ok_or_else(|| wrong(format!("no message begins with {:?}", begins())))?;
        if name.eq_ignore_ascii_case("content-length") {
            length = value.trim().parse::<u64>().ok();
        }
    }
    let length = length.ok_or_else(|| wrong("a message without its length".into()))?;
    if length > MOST_BYTES {
        return Err(wrong(format!("a message of {length} bytes; {MOST_BYTES} are the most")));
    }
    let mut body = Vec::new();
    if (input.take(length).read_to_end(&mut body)? as u64) < length {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    serde_json::from_slice(&body).map(Some).map_err(|error| wrong(format!("a message that is none: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reads(bytes: &[u8]) -> Result<bool, String> {
        read(&mut &*bytes).map(|message| message.is_some()).map_err(|error| error.to_string())
    }

    #[test]
    fn messages() {
        let body = r#"{"jsonrpc":"2.0","method":"exit"}"#;
        let length = body.len();
        assert_eq!(reads(format!("Content-Length: {length}\r\n\r\n{body}").as_bytes()), Ok(true));
        let other = format!("content-type: application/vscode-jsonrpc\r\ncontent-length:{length}\r\n\r\n{body}");
        assert_eq!(reads(other.as_bytes()), Ok(true));
        assert_eq!(reads(b""), Ok(false));
        for (bytes, said) in [
            (&b"GET / HTTP/1.1\r\n\r\n"[..], "no message begins with \"GET / HTTP/1.1\""),
            (b"\xff\xfe\x00", "no message begins with"),
            (b"Content-Length: many\r\n\r\n", "without its length"),
            (b"Content-Length: 99999999999999\r\n\r\n{}", "99999999999999 bytes"),
            (b"Content-Length: 5\r\n\r\nabcde", "a message that is none"),
            (b"Content-Length: 9\r\n\r\n{}", "end of file"),
        ] {
            let found = reads(bytes).unwrap_err();
            assert!(found.contains(said), "{found}");
        }
    }
}
