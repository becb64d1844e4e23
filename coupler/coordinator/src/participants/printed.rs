//! The output of a participant, kept up to a limit: endless output must not fill the disk.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{PipeReader, Read, Write};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Number of bytes kept from the beginning.
const HEAD: usize = 8 << 20;

/// Number of bytes kept from the end, where a lost participant states the reason.
const TAIL: usize = 64 << 10;

/// Time for the last output to arrive after the process has ended: a child program may hold the pipe open.
const LAST_WORDS: Duration = Duration::from_millis(200);

/// A thread that copies the output of a participant from a pipe into a log.
pub struct Printed(Option<JoinHandle<()>>);

impl Printed {
    /// Reads until the other end of the pipe is closed, even if the log cannot be written: a full pipe would stop the participant.
    pub fn keep(mut pipe: PipeReader, mut log: File) -> std::io::Result<Printed> {
        let thread = std::thread::Builder::new().name("printed".into());
        let carry = move || {
            let mut kept = Kept::default();
            let mut buffer = [0; 8192];
            while let Ok(length @ 1..) = pipe.read(&mut buffer) {
                let _ = log.write_all(kept.head(&buffer[..length]));
            }
            let _ = log.write_all(&kept.end());
        };
        Ok(Printed(Some(thread.spawn(carry)?)))
    }
}

impl Printed {
    /// Waits for the last output of a process that has ended.
    pub fn end(&mut self) {
        let start = Instant::now();
        let Some(thread) = self.0.take() else { return };
        while !thread.is_finished() {
            if start.elapsed() > LAST_WORDS {
                return;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        let _ = thread.join();
    }
}

impl Drop for Printed {
    fn drop(&mut self) {
        self.end();
    }
}

/// Beginning and end of a text of any length.
#[derive(Default)]
struct Kept {
    written: usize,
    left_out: u64,
    tail: VecDeque<u8>,
}

impl Kept {
    /// The part of the next output that belongs to the beginning.
    fn head<'a>(&mut self, words: &'a [u8]) -> &'a [u8] {
        let (head, rest) = words.split_at(words.len().min(HEAD - self.written));
        self.written += head.len();
        self.tail.extend(rest);
        let over = self.tail.len().saturating_sub(TAIL);
        self.tail.drain(..over);
        self.left_out += over as u64;
        head
    }

    /// The text to write after the beginning.
    fn end(self) -> Vec<u8> {
        let mut text = Vec::new();
        if self.left_out > 0 {
            let note = format!("\n[{} bytes are left out here]\n", self.left_out);
            text.extend(note.into_bytes());
        }
        text.extend(self.tail);
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(text: &[u8], piece: usize) -> Vec<u8> {
        let mut kept = Kept::default();
        let mut log: Vec<u8> = Vec::new();
        for words in text.chunks(piece) {
            log.extend(kept.head(words));
        }
        log.extend(kept.end());
        log
    }

    #[test]
    fn a_text_that_fits_stays_as_it_is() {
        let text: Vec<u8> = (0..HEAD + TAIL).map(|i| i as u8).collect();
        assert!(kept(&text, 1000) == text);
        assert_eq!(kept(b"", 1), b"");
    }

    #[test]
    fn beginning_and_end_of_a_longer_text_are_kept() {
        let text: Vec<u8> = (0..HEAD + TAIL + 5000).map(|i| (i / 7) as u8).collect();
        let log = kept(&text, 999);
        let note = b"\n[5000 bytes are left out here]\n";
        assert!(log[..HEAD] == text[..HEAD]);
        assert_eq!(&log[HEAD..HEAD + note.len()], note);
        assert!(log[HEAD + note.len()..] == text[HEAD + 5000..]);
    }

    #[test]
    fn the_end_follows_a_full_beginning() {
        let path = std::env::temp_dir().join(format!("thirdbody-words-{}", std::process::id()));
        let (pipe, mut printer) = std::io::pipe().expect("the system gives a pipe");
        let log = File::create(&path).expect("the folder is writable");
        let mut printed = Printed::keep(pipe, log).expect("a thread starts");
        let words = vec![b'w'; HEAD];
        printer.write_all(&words).expect("a thread reads");
        printer.write_all(b" and why").expect("a thread reads");
        drop(printer);
        let thread = printed.0.take().expect("it was started");
        thread.join().expect("it does not panic");
        let text = std::fs::read(&path).expect("it was written");
        std::fs::remove_file(&path).expect("it is ours");
        assert_eq!(text.len(), HEAD + b" and why".len());
        assert!(text.ends_with(b"w and why"));
    }
}
