//! Writing the log, on a separate thread.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError, SendTimeoutError, Sender, bounded, select};
use mcap::records::MessageHeader;
use mcap::{Compression, McapError, WriteOptions, Writer};
use prost::Message;
use protocol::link::shm::MAX_DOUBLES;

use super::entry::{Entry, Exchange, INTERFACE};
use super::error::LogError;
use super::proto;
use super::provenance::{self, Provenance};

/// Number of batches that may wait for the writer. More would only delay the detection of a slow disk.
const WAITING: usize = 16;

/// A disk that takes no data for this time is broken.
const PATIENCE: Duration = Duration::from_secs(60);

/// A chunk closes beyond this size, also within a window.
const CHUNK_BYTES: u64 = 1 << 20;

/// Written amounts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LogStats {
    /// Size of the file.
    pub bytes: u64,
    /// Frames in it.
    pub messages: u64,
    /// Windows that ended.
    pub windows: u64,
    /// Wall-clock time that the caller spent on recording, including waits for a slow writer.
    pub caller_wall: Duration,
    /// Wall-clock time of the writing thread at work.
    pub writer_wall: Duration,
}

/// Writes an exchange log. A thread compresses and writes the frames. Pass the frames of a window at once: to wake the thread costs more
/// than to write a frame. If the thread falls behind, the recorder waits; no frame is dropped.
pub struct Recorder {
    path: PathBuf,
    jobs: Option<Sender<Job>>,
    outcome: Receiver<Result<LogStats, LogError>>,
    caller_wall: Duration,
}

enum Job {
    Write(Vec<Entry>),
    Sync(Sender<()>),
}

impl Recorder {
    /// Starts a log at `path`, replacing any file there. The log is flushed after every `flush_every_windows` windows (at least 1): a killed
    /// process loses no more than that.
    pub fn create(
        path: &Path,
        provenance: &Provenance,
        flush_every_windows: u64,
    ) -> Result<Recorder, LogError> {
        let file = Counted::create(path).map_err(LogError::write(path))?;
        let file = LogWriter::start(path, file, provenance, flush_every_windows.max(1));
        let file = file.map_err(LogError::write(path))?;
        let (jobs, taken) = bounded(WAITING);
        let (report, outcome) = bounded(1);
        thread::Builder::new()
            .name("exchange-log".into())
            .spawn(move || {
                // If the recorder was dropped, nothing needs the outcome.
                let _ = report.send(file.write_all(&taken));
            })
            .map_err(LogError::write(path))?;
        Ok(Recorder {
            path: path.into(),
            jobs: Some(jobs),
            outcome,
            caller_wall: Duration::ZERO,
        })
    }

    /// Records entries. An error may be about earlier entries.
    pub fn record(&mut self, mut entries: Vec<Entry>) -> Result<(), LogError> {
        if entries.is_empty() {
            return Ok(());
        }
        let start = Instant::now();
        let doubles = |entry: &Entry| match entry {
            Entry::Exchange(exchange) => exchange.frame.payload.len(),
            Entry::WindowEnd(_) => 0,
        };
        let long = entries.iter().position(|e| doubles(e) > MAX_DOUBLES);
        let refused = long.map(|at| LogError::TooLong {
            doubles: doubles(&entries[at]),
            capacity: MAX_DOUBLES,
        });
        entries.truncate(long.unwrap_or(entries.len()));
        let handed = self.hand_over(Job::Write(entries));
        self.caller_wall += start.elapsed();
        handed.and(refused.map_or(Ok(()), Err))
    }

    /// Returns when all recorded entries are on the disk.
    pub fn sync(&mut self) -> Result<(), LogError> {
        let (done, waiting) = bounded(1);
        self.hand_over(Job::Sync(done))?;
        // A job left in the queue by a failed thread keeps its channel open, so the outcome of the thread is received as well.
        select! {
            recv(waiting) -> done => done.map_err(|_| self.ended()),
            recv(self.outcome) -> outcome => Err(self.reason(outcome.ok())),
            default(PATIENCE) => Err(self.stalled()),
        }
    }

    /// Completes the file.
    pub fn finish(mut self) -> Result<LogStats, LogError> {
        let start = Instant::now();
        let stats = self.close()?;
        Ok(LogStats {
            caller_wall: self.caller_wall + start.elapsed(),
            ..stats
        })
    }

    fn hand_over(&mut self, job: Job) -> Result<(), LogError> {
        let Some(jobs) = &self.jobs else {
            return Err(self.closed());
        };
        match jobs.send_timeout(job, PATIENCE) {
            Err(SendTimeoutError::Disconnected(_)) => Err(self.ended()),
            other => other.map_err(|_| self.stalled()),
        }
    }

    /// Closes the queue of the thread and waits for its outcome.
    fn close(&mut self) -> Result<LogStats, LogError> {
        self.jobs.take().ok_or_else(|| self.closed())?;
        match self.outcome.recv_timeout(PATIENCE) {
            Err(RecvTimeoutError::Disconnected) => Err(self.closed()),
            other => other.map_err(|_| self.stalled())?,
        }
    }

    /// The error of a thread that ended early, from closing it.
    fn ended(&mut self) -> LogError {
        let outcome = self.close();
        self.reason(Some(outcome))
    }

    fn reason(&self, outcome: Option<Result<LogStats, LogError>>) -> LogError {
        let reason = outcome.and_then(Result::err);
        reason.unwrap_or_else(|| self.closed())
    }

    fn stalled(&self) -> LogError {
        let (path, seconds) = (self.path.clone(), PATIENCE.as_secs());
        LogError::Stalled { path, seconds }
    }

    fn closed(&self) -> LogError {
        let path = self.path.clone();
        LogError::Closed { path }
    }
}

impl Drop for Recorder {
    /// Completes the file of a run that ends early; errors are ignored, because the run has its own error.
    fn drop(&mut self) {
        let _ = self.close();
    }
}

/// The file, on the thread's side.
struct LogWriter {
    path: PathBuf,
    writer: Writer<BufWriter<Counted>>,
    /// The same file, for syncing it to the disk.
    disk: Counted,
    flush_every_windows: u64,
    exchange_schema: u16,
    window_channel: u16,
    log_time: u64,
    stats: LogStats,
}

impl LogWriter {
    fn start(
        path: &Path,
        file: Counted,
        provenance: &Provenance,
        flush_every_windows: u64,
    ) -> Result<LogWriter, McapError> {
        let disk = Counted {
            file: file.file.try_clone()?,
            written: Arc::clone(&file.written),
        };
        let mut writer = options().create(BufWriter::new(file))?;
        provenance::write(&mut writer, provenance)?;
        let descriptors = proto::descriptors();
        let exchange_schema = writer.add_schema(proto::EXCHANGE, "protobuf", &descriptors)?;
        let window_schema = writer.add_schema(proto::WINDOW_END, "protobuf", &descriptors)?;
        let window_channel =
            writer.add_channel(window_schema, "windows", "protobuf", &BTreeMap::new())?;
        writer.flush()?;
        Ok(LogWriter {
            path: path.into(),
            writer,
            disk,
            flush_every_windows,
            exchange_schema,
            window_channel,
            log_time: 0,
            stats: LogStats::default(),
        })
    }

    fn write_all(mut self, jobs: &Receiver<Job>) -> Result<LogStats, LogError> {
        for job in jobs {
            let start = Instant::now();
            let written = match job {
                Job::Write(entries) => entries.into_iter().try_for_each(|entry| self.write(entry)),
                Job::Sync(done) => self.sync(&done),
            };
            written.map_err(LogError::write(&self.path))?;
            self.stats.writer_wall += start.elapsed();
        }
        self.finish()
    }

    fn write(&mut self, entry: Entry) -> Result<(), McapError> {
        match entry {
            Entry::Exchange(exchange) => self.write_one(exchange),
            Entry::WindowEnd(window) => self.end_window(window),
        }
    }

    fn write_one(&mut self, exchange: Exchange) -> Result<(), McapError> {
        let channel_id = self.channel(&exchange)?;
        let header = exchange.frame.header;
        // NaN becomes 0 here; the exact time is in the message.
        self.log_time = (header.t1_s * 1e9).round() as u64;
        let message = proto::ExchangeMessage {
            kind: header.kind,
            protocol: header.protocol,
            interface: header.interface,
            iteration: header.iteration,
            window: header.window,
            step: header.step,
            substeps: header.substeps,
            t0_s: header.t0_s,
            t1_s: header.t1_s,
            sender: exchange.sender,
            receiver: exchange.receiver,
            payload: exchange.frame.payload,
            checksum: header.checksum,
        };
        self.put(channel_id, header.window, &message.encode_to_vec())?;
        self.stats.messages += 1;
        Ok(())
    }

    fn end_window(&mut self, window: u64) -> Result<(), McapError> {
        let end = proto::WindowEnd { window };
        self.put(self.window_channel, window, &end.encode_to_vec())?;
        self.stats.windows += 1;
        if self.stats.windows.is_multiple_of(self.flush_every_windows) {
            self.writer.flush()?;
            self.disk.in_place(&self.path)?;
        }
        Ok(())
    }

    fn sync(&mut self, done: &Sender<()>) -> Result<(), McapError> {
        self.writer.flush()?;
        self.disk.file.sync_data()?;
        self.disk.in_place(&self.path)?;
        // The caller may have stopped waiting.
        let _ = done.send(());
        Ok(())
    }

    fn put(&mut self, channel_id: u16, window: u64, data: &[u8]) -> Result<(), McapError> {
        let header = MessageHeader {
            channel_id,
            // The format has only 32 bits here; the message has all 64.
            sequence: window as u32,
            log_time: self.log_time,
            publish_time: self.log_time,
        };
        self.writer.write_to_known_channel(&header, data)
    }

    /// The channel for messages like this one, opened by the first of them.
    fn channel(&mut self, exchange: &Exchange) -> Result<u16, McapError> {
        let metadata = BTreeMap::from([
            (INTERFACE.to_string(), exchange.interface.clone()),
            ("receiver".to_string(), exchange.receiver.clone()),
        ]);
        let (schema, topic) = (self.exchange_schema, exchange.topic());
        let writer = &mut self.writer;
        writer.add_channel(schema, &topic, "protobuf", &metadata)
    }

    fn finish(mut self) -> Result<LogStats, LogError> {
        let start = Instant::now();
        let ended = self.writer.finish();
        ended.map_err(LogError::write(&self.path))?;
        let mut buffer = self.writer.into_inner();
        let size = buffer.flush().and_then(|()| self.disk.in_place(&self.path));
        let bytes = size.map_err(LogError::write(&self.path))?;
        Ok(LogStats {
            bytes,
            writer_wall: self.stats.writer_wall + start.elapsed(),
            ..self.stats
        })
    }
}

/// A file opened to append, and the number of bytes written.
struct Counted {
    file: File,
    written: Arc<AtomicU64>,
}

impl Counted {
    fn create(path: &Path) -> io::Result<Counted> {
        File::create(path)?;
        Ok(Counted {
            file: File::options().append(true).open(path)?,
            written: Arc::default(),
        })
    }

    /// Number of bytes written, if all of them are in the file with this name: a file that was removed, replaced or truncated accepts data
    /// without keeping it.
    fn in_place(&self, path: &Path) -> io::Result<u64> {
        let (ours, written) = (self.file.metadata()?, self.written.load(Ordering::Relaxed));
        let refuse = |why: String| Err(io::Error::other(why));
        match path.metadata() {
            Err(error) => refuse(format!("it was removed during the run ({error})")),
            Ok(found) if (found.dev(), found.ino()) != (ours.dev(), ours.ino()) => {
                refuse("it was replaced by another file during the run".into())
            }
            Ok(found) if found.len() != written => refuse(format!(
                "it was changed during the run: it holds {} bytes, but {written} were written",
                found.len()
            )),
            Ok(_) => Ok(written),
        }
    }
}

impl Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.written.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Counted {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// Chunks are assembled in memory and written at once. By default mcap seeks back to fill in their headers, and a killed writer leaves an
/// empty header.
fn options() -> WriteOptions {
    WriteOptions::new()
        .profile("thirdbody")
        .library(concat!("thirdbody ", env!("CARGO_PKG_VERSION")))
        .compression(Some(Compression::Lz4))
        .chunk_size(Some(CHUNK_BYTES))
        .disable_seeking(true)
        .calculate_chunk_crcs(true)
        .calculate_data_section_crc(true)
        .calculate_summary_section_crc(true)
        .calculate_attachment_crcs(true)
}
