//! Writing the log, on a thread of its own.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError, SendTimeoutError, Sender, bounded};
use mcap::records::MessageHeader;
use mcap::{Compression, McapError, WriteOptions, Writer};
use prost::Message;
use protocol::link::shm::MAX_DOUBLES;

use super::entry::{Exchange, INTERFACE, kind_name};
use super::error::LogError;
use super::proto;
use super::provenance::{self, Provenance};

/// Batches that may wait for the writer. More would only hide for longer that the disk is too slow.
const WAITING: usize = 16;

/// A disk that takes nothing for so long is broken (s).
const PATIENCE_S: u64 = 60;

/// A chunk closes beyond this size, whatever the windows do.
const CHUNK_BYTES: u64 = 1 << 20;

/// Amounts that were written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LogStats {
    /// Size of the file.
    pub bytes: u64,
    /// Frames in it.
    pub messages: u64,
    /// Windows that ended.
    pub windows: u64,
    /// Wall-clock time that whoever records spent on it, the wait for a writer that fell behind included.
    pub caller_wall: Duration,
    /// Wall-clock time that the writing thread was at work.
    pub writer_wall: Duration,
}

/// Writes an exchange log. Frames are handed to a thread that compresses and writes them, best those of a window at once: to
/// wake that thread for each would cost more than to write it. When it falls behind, the recorder waits. Nothing is left
/// out.
pub struct Recorder {
    path: PathBuf,
    jobs: Option<Sender<Job>>,
    outcome: Receiver<Result<LogStats, LogError>>,
    caller_wall: Duration,
}

enum Job {
    Write {
        exchanges: Vec<Exchange>,
        /// The window that they end.
        window: Option<u64>,
    },
    Sync(Sender<()>),
}

/// Messages with a channel of their own.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Stream {
    interface: String,
    sender: String,
    receiver: String,
    kind: u32,
}

impl Recorder {
    /// Starts a log at `path`, in place of what is there. What was recorded is on its way to the disk after every
    /// `flush_every_windows` windows (at least 1): a process that is killed loses no more.
    pub fn create(
        path: &Path,
        provenance: &Provenance,
        flush_every_windows: u64,
    ) -> Result<Recorder, LogError> {
        let file = LogWriter::create(path, provenance, flush_every_windows.max(1))?;
        let (jobs, taken) = bounded(WAITING);
        let (report, outcome) = bounded(1);
        thread::Builder::new()
            .name("exchange-log".into())
            .spawn(move || {
                // Nobody hears it if the recorder was dropped, and then nobody cares.
                let _ = report.send(file.write_all(&taken));
            })
            .map_err(|error| LogError::write(path, &error))?;
        Ok(Recorder {
            path: path.into(),
            jobs: Some(jobs),
            outcome,
            caller_wall: Duration::ZERO,
        })
    }

    /// Records frames that passed, and the end of the window that they end. An error may be about earlier ones.
    pub fn record(
        &mut self,
        mut exchanges: Vec<Exchange>,
        window: Option<u64>,
    ) -> Result<(), LogError> {
        if exchanges.is_empty() && window.is_none() {
            return Ok(());
        }
        let start = Instant::now();
        let doubles = |exchange: &Exchange| exchange.frame.payload.len();
        let long = exchanges.iter().position(|e| doubles(e) > MAX_DOUBLES);
        let refused = long.map(|at| LogError::TooLong {
            doubles: doubles(&exchanges[at]),
            capacity: MAX_DOUBLES,
        });
        exchanges.truncate(long.unwrap_or(exchanges.len()));
        let window = window.filter(|_| refused.is_none());
        let handed = self.hand_over(Job::Write { exchanges, window });
        self.caller_wall += start.elapsed();
        handed.and(refused.map_or(Ok(()), Err))
    }

    /// Returns when all that was recorded is on the disk.
    pub fn sync(&mut self) -> Result<(), LogError> {
        let (done, waiting) = bounded(1);
        self.hand_over(Job::Sync(done))?;
        match waiting.recv_timeout(Duration::from_secs(PATIENCE_S)) {
            Ok(()) => Ok(()),
            Err(RecvTimeoutError::Timeout) => Err(self.stalled()),
            Err(RecvTimeoutError::Disconnected) => Err(self.ended()),
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
        match jobs.send_timeout(job, Duration::from_secs(PATIENCE_S)) {
            Ok(()) => Ok(()),
            Err(SendTimeoutError::Timeout(_)) => Err(self.stalled()),
            Err(SendTimeoutError::Disconnected(_)) => Err(self.ended()),
        }
    }

    /// Tells the thread that nothing follows, and waits for what it says.
    fn close(&mut self) -> Result<LogStats, LogError> {
        if self.jobs.take().is_none() {
            return Err(self.closed());
        }
        match self.outcome.recv_timeout(Duration::from_secs(PATIENCE_S)) {
            Ok(outcome) => outcome,
            Err(RecvTimeoutError::Timeout) => Err(self.stalled()),
            Err(RecvTimeoutError::Disconnected) => Err(self.closed()),
        }
    }

    /// The error of a thread that ended before it was told to: closing hands it out.
    fn ended(&mut self) -> LogError {
        self.close().err().unwrap_or_else(|| self.closed())
    }

    fn stalled(&self) -> LogError {
        LogError::Stalled {
            path: self.path.clone(),
            seconds: PATIENCE_S,
        }
    }

    fn closed(&self) -> LogError {
        LogError::Closed {
            path: self.path.clone(),
        }
    }
}

impl Drop for Recorder {
    /// A run that ends early still has a complete file; its error is another one.
    fn drop(&mut self) {
        let _ = self.close();
    }
}

/// The file, on the side of the thread.
struct LogWriter {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    /// Handle of the same file, by which it is told to reach the disk.
    disk: File,
    flush_every_windows: u64,
    exchange_schema: u16,
    window_channel: u16,
    channels: HashMap<Stream, u16>,
    log_time: u64,
    stats: LogStats,
}

impl LogWriter {
    fn create(
        path: &Path,
        provenance: &Provenance,
        flush_every_windows: u64,
    ) -> Result<LogWriter, LogError> {
        let file = File::create(path).map_err(|error| LogError::write(path, &error))?;
        Self::start(path, file, provenance, flush_every_windows)
            .map_err(|error| LogError::write(path, &error))
    }

    fn start(
        path: &Path,
        file: File,
        provenance: &Provenance,
        flush_every_windows: u64,
    ) -> Result<LogWriter, McapError> {
        let disk = file.try_clone()?;
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
            channels: HashMap::new(),
            log_time: 0,
            stats: LogStats::default(),
        })
    }

    fn write_all(mut self, jobs: &Receiver<Job>) -> Result<LogStats, LogError> {
        for job in jobs {
            let start = Instant::now();
            let written = match job {
                Job::Write { exchanges, window } => self.write_batch(exchanges, window),
                Job::Sync(done) => self.sync(&done),
            };
            written.map_err(|error| LogError::write(&self.path, &error))?;
            self.stats.writer_wall += start.elapsed();
        }
        self.finish()
    }

    fn write_batch(
        &mut self,
        exchanges: Vec<Exchange>,
        window: Option<u64>,
    ) -> Result<(), McapError> {
        for exchange in exchanges {
            self.write(exchange)?;
        }
        window.map_or(Ok(()), |window| self.end_window(window))
    }

    fn write(&mut self, exchange: Exchange) -> Result<(), McapError> {
        let frame = exchange.frame;
        let stream = Stream {
            interface: exchange.interface,
            sender: exchange.sender,
            receiver: exchange.receiver,
            kind: frame.header.kind,
        };
        let channel_id = self.channel(&stream)?;
        let header = frame.header;
        // Not a number becomes 0 here; the exact time is in the message.
        self.log_time = (header.t1_s * 1e9).round() as u64;
        let exchange = proto::Exchange {
            kind: header.kind,
            protocol: header.protocol,
            interface: header.interface,
            iteration: header.iteration,
            window: header.window,
            step: header.step,
            substeps: header.substeps,
            t0_s: header.t0_s,
            t1_s: header.t1_s,
            sender: stream.sender,
            receiver: stream.receiver,
            payload: frame.payload,
            checksum: header.checksum,
        };
        self.put(channel_id, header.window, &exchange.encode_to_vec())?;
        self.stats.messages += 1;
        Ok(())
    }

    fn end_window(&mut self, window: u64) -> Result<(), McapError> {
        let end = proto::WindowEnd { window };
        self.put(self.window_channel, window, &end.encode_to_vec())?;
        self.stats.windows += 1;
        if self.stats.windows.is_multiple_of(self.flush_every_windows) {
            self.writer.flush()?;
        }
        Ok(())
    }

    fn sync(&mut self, done: &Sender<()>) -> Result<(), McapError> {
        self.writer.flush()?;
        self.disk.sync_data()?;
        // Whoever waited in vain has gone.
        let _ = done.send(());
        Ok(())
    }

    fn put(&mut self, channel_id: u16, window: u64, data: &[u8]) -> Result<(), McapError> {
        let header = MessageHeader {
            channel_id,
            // The format has 32 bits here; the message has all 64.
            sequence: window as u32,
            log_time: self.log_time,
            publish_time: self.log_time,
        };
        self.writer.write_to_known_channel(&header, data)
    }

    fn channel(&mut self, stream: &Stream) -> Result<u16, McapError> {
        if let Some(channel) = self.channels.get(stream) {
            return Ok(*channel);
        }
        let topic = format!(
            "{}/{}/{}",
            stream.interface,
            stream.sender,
            kind_name(stream.kind)
        );
        let metadata = BTreeMap::from([
            (INTERFACE.to_string(), stream.interface.clone()),
            ("receiver".to_string(), stream.receiver.clone()),
        ]);
        let channel =
            self.writer
                .add_channel(self.exchange_schema, &topic, "protobuf", &metadata)?;
        self.channels.insert(stream.clone(), channel);
        Ok(channel)
    }

    fn finish(mut self) -> Result<LogStats, LogError> {
        let start = Instant::now();
        self.writer
            .finish()
            .map_err(|error| LogError::write(&self.path, &error))?;
        let mut buffer = self.writer.into_inner();
        let size = buffer
            .flush()
            .and_then(|()| buffer.get_ref().metadata())
            .map_err(|error| LogError::write(&self.path, &error))?;
        Ok(LogStats {
            bytes: size.len(),
            writer_wall: self.stats.writer_wall + start.elapsed(),
            ..self.stats
        })
    }
}

/// Chunks are put together in memory and written at once: with mcap's way of going back to fill in their header,
/// a writer that is killed leaves a header that says nothing.
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
