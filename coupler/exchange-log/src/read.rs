//! Reading a log, with every checksum verified.

use std::collections::{HashMap, VecDeque};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use prost::Message;
use protocol::link::shm::MAX_DOUBLES;
use protocol::{Frame, Header};

use super::entry::{Entry, Exchange, INTERFACE};
use super::error::{LogError, chain};
use super::lengths::parse;
use super::order::Order;
use super::proto;
use super::provenance::{self, Provenance};
use super::torn::{FRAMING, is_torn};

/// Largest length of our records and chunks: the longest message, and room for a chunk that is about to close.
const RECORD_LIMIT: usize = 8 * MAX_DOUBLES + (4 << 20);

/// lz4 cannot compress further. A chunk that claims more is damaged or malicious.
const SHRINK_LIMIT: u64 = 256;

/// Number of bytes read from the file at once.
const PIECE: usize = 1 << 16;

/// Opens a log. Damage and a missing end are errors.
pub fn read(path: &Path) -> Result<LogFile, LogError> {
    LogFile::open(path, false)
}

/// Opens a log that may be only partly readable, for example after a killed writer. Entries end at the damage; [`LogFile::damage`]
/// describes it.
pub fn recover(path: &Path) -> Result<LogFile, LogError> {
    LogFile::open(path, true)
}

/// Damage inside a log, which is read to its end. `None` for a whole log, for the beginning of a log after a killed writer, and if there is
/// no log.
pub fn damage(path: &Path) -> Result<Option<LogError>, LogError> {
    if !path.exists() || is_as_written(path)? {
        return Ok(None);
    }
    let found = match recover(path) {
        Ok(mut log) => {
            log.try_for_each(|entry| entry.map(|_| ()))?;
            log.damage
        }
        Err(error @ LogError::NotALog { .. }) => Some(error),
        Err(error) => return Err(error),
    };
    Ok(found.filter(|error| !error.is_torn()))
}

/// True if the checksum after all data holds for the whole file. It decodes nothing: if the checksum fails or is missing, reading the
/// entries gives details.
pub(super) fn is_as_written(path: &Path) -> Result<bool, LogError> {
    let mut file = File::open(path).map_err(LogError::read(path))?;
    let mut reader = LinearReader::new_with_options(options());
    let mut summed = false;
    loop {
        match next_record(&mut reader, &mut file, PIECE) {
            // A checksum of zero means no checksum (MCAP 0, "Data End").
            Ok(Some((opcode, data))) => summed |= opcode == op::DATA_END && data != [0; 4],
            Ok(None) => return Ok(summed),
            Err(Failure::Io(source)) => return Err(LogError::read(path)(source)),
            Err(Failure::Damage(_)) => return Ok(false),
        }
    }
}

/// Chunks stay compressed, checksums are verified, and no data may follow the end.
fn options() -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_emit_chunks(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true)
        .with_check_finishes_after_end_magic(true)
        .with_record_length_limit(RECORD_LIMIT)
}

/// The entries of a log in recorded order. One chunk (about 1 MiB, or one long message) is in memory at a time, and its checksum is verified
/// before it yields entries.
pub struct LogFile {
    path: PathBuf,
    file: File,
    reader: LinearReader,
    tolerant: bool,
    /// The run that the log belongs to.
    pub provenance: Provenance,
    interfaces: HashMap<u16, Option<String>>,
    entries: VecDeque<Entry>,
    order: Order,
    /// Start of the next record (bytes).
    offset: u64,
    /// Number of chunks reached.
    chunks: u64,
    /// True while a chunk is read.
    in_chunk: bool,
    /// Damage that ended a recovered log before its end.
    pub damage: Option<LogError>,
    /// True if the data has ended: the rest of the file describes it again, for readers that seek.
    data_ended: bool,
    ended: bool,
}

impl LogFile {
    /// Opens a log; `tolerant` of damage.
    pub(super) fn open(path: &Path, tolerant: bool) -> Result<LogFile, LogError> {
        let file = File::open(path).map_err(LogError::read(path))?;
        let mut log = LogFile {
            path: path.into(),
            file,
            reader: LinearReader::new_with_options(options()),
            tolerant,
            provenance: Provenance::default(),
            interfaces: HashMap::new(),
            entries: VecDeque::new(),
            order: Order::default(),
            offset: mcap::MAGIC.len() as u64,
            chunks: 0,
            in_chunk: false,
            damage: None,
            data_ended: false,
            ended: false,
        };
        match log.read_provenance() {
            Ok(()) => Ok(log),
            Err(Failure::Io(source)) => Err(LogError::read(path)(source)),
            Err(Failure::Damage(why)) => Err(LogError::NotALog {
                path: path.into(),
                why,
                torn: log.is_torn(),
            }),
        }
    }

    /// Reads the first two records, header and metadata; a file without them is not a log.
    fn read_provenance(&mut self) -> Result<(), Failure> {
        let missing = || Failure::Damage("it does not begin with its provenance".into());
        let mut next = |wanted: u8| {
            let start = self.offset;
            let record = self.next_record()?.filter(|(kind, _)| *kind == wanted);
            record.map(|(_, data)| (start, data)).ok_or_else(missing)
        };
        next(op::HEADER)?;
        let (start, data) = next(op::METADATA)?;
        let read = provenance::read(&data).inspect_err(|_| self.offset = start);
        self.provenance = read.map_err(Failure::Damage)?;
        Ok(())
    }

    /// Reads on until there is an entry, or the file has ended.
    fn advance(&mut self) -> Result<(), Failure> {
        while self.entries.is_empty() && !self.ended {
            let start = self.offset;
            let record = self.next_record()?;
            self.ended = record.is_none();
            let Some((opcode, data)) = record.filter(|_| !self.data_ended) else {
                continue;
            };
            self.data_ended = opcode == op::DATA_END;
            self.in_chunk = opcode == op::CHUNK;
            let taken = match opcode {
                op::DATA_END => Ok(()),
                op::CHUNK => self.read_chunk(&data),
                _ => plain_record(opcode, &data),
            };
            taken.inspect_err(|_| self.offset = start)?;
            self.in_chunk = false;
        }
        Ok(())
    }

    /// The next record of the file, with chunks as a whole. A damaged length may claim any size, so memory grows with the data.
    fn next_record(&mut self) -> Result<Option<(u8, Vec<u8>)>, Failure> {
        let record = next_record(&mut self.reader, &mut self.file, PIECE)?;
        let length = record.as_ref().map(|(_, data)| FRAMING + data.len());
        self.offset += length.unwrap_or(0) as u64;
        Ok(record)
    }

    fn read_chunk(&mut self, data: &[u8]) -> Result<(), Failure> {
        let mut entries = VecDeque::new();
        self.chunks += 1;
        let (mut reader, mut rest) = (chunk_reader(data)?, data);
        while let Some((opcode, record)) = next_record(&mut reader, &mut rest, usize::MAX)? {
            match parse(opcode, &record).map_err(Failure::Damage)? {
                Record::Channel(channel) => {
                    let interface = channel.metadata.get(INTERFACE).cloned();
                    self.interfaces.insert(channel.id, interface);
                }
                Record::Message { header, data } => {
                    let entry = self.entry(header.channel_id, &data);
                    let taken = entry.and_then(|entry| self.order.take(&entry).map(|()| entry));
                    let number = entries.len() + 1;
                    let damaged = |why| Failure::Damage(format!("message {number}: {why}"));
                    entries.push_back(taken.map_err(damaged)?);
                }
                _ => (),
            }
        }
        self.entries = entries;
        Ok(())
    }

    fn entry(&self, channel: u16, data: &[u8]) -> Result<Entry, String> {
        let entry = match self.interfaces.get(&channel) {
            None => return Err(format!("channel {channel} was never opened")),
            Some(None) => proto::WindowEnd::decode(data).map(|end| Entry::WindowEnd(end.window)),
            Some(Some(interface)) => proto::ExchangeMessage::decode(data)
                .map(|message| Entry::Exchange(self.exchange(interface, message))),
        };
        entry.map_err(|error| error.to_string())
    }

    fn exchange(&self, interface: &str, message: proto::ExchangeMessage) -> Exchange {
        let header = Header {
            kind: message.kind,
            protocol: message.protocol,
            run_id: self.provenance.run_id,
            interface: message.interface,
            iteration: message.iteration,
            window: message.window,
            step: message.step,
            substeps: message.substeps,
            count: message.payload.len() as u32,
            t0_s: message.t0_s,
            t1_s: message.t1_s,
            checksum: message.checksum,
        };
        Exchange {
            interface: interface.into(),
            sender: message.sender,
            receiver: message.receiver,
            frame: Frame {
                header,
                payload: message.payload,
            },
        }
    }

    fn error(&self, failure: Failure) -> LogError {
        let path = self.path.clone();
        match failure {
            Failure::Io(source) => LogError::Read { path, source },
            Failure::Damage(why) => LogError::Damaged {
                path,
                offset: self.offset,
                part: if self.in_chunk {
                    format!("chunk {}", self.chunks)
                } else {
                    format!("a record after {} chunks", self.chunks)
                },
                why,
                torn: self.is_torn(),
            },
        }
    }

    fn is_torn(&self) -> bool {
        is_torn(&self.file, self.offset).unwrap_or(false)
    }
}

impl Iterator for LogFile {
    type Item = Result<Entry, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Err(failure) = self.advance() {
            self.ended = true;
            let error = self.error(failure);
            if !self.tolerant {
                return Some(Err(error));
            }
            self.damage = Some(error);
        }
        self.entries.pop_front().map(Ok)
    }
}

/// Reasons why reading cannot continue.
enum Failure {
    Io(io::Error),
    Damage(String),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Failure {
        Failure::Io(error)
    }
}

impl From<McapError> for Failure {
    fn from(error: McapError) -> Failure {
        Failure::Damage(chain(&error))
    }
}

/// Checks a record between chunks, where our writer puts only attachments, metadata and message indices. Any other record, or one with a
/// wrong length, is a damaged chunk, and the data after it must not count as its continuation.
fn plain_record(opcode: u8, data: &[u8]) -> Result<(), Failure> {
    let kind = format!("a record of kind {opcode:#04x}");
    let length = match parse(opcode, data).map_err(Failure::Damage)? {
        Record::MessageIndex(index) => 2 + 4 + 16 * index.records.len(),
        Record::Attachment { header, data, .. } => {
            8 + 8 + 4 + header.name.len() + 4 + header.media_type.len() + 8 + data.len() + 4
        }
        Record::Metadata(_) => data.len(),
        _ => return Err(Failure::Damage(format!("{kind} is between chunks"))),
    };
    match data.len() {
        held if held == length => Ok(()),
        held => Err(Failure::Damage(format!(
            "{kind} holds {held} bytes, but counts {length}"
        ))),
    }
}

/// Passes a chunk to a separate reader as if it were a file: only such a reader limits the decompressed size and verifies before it yields
/// records.
fn chunk_reader(data: &[u8]) -> Result<LinearReader, Failure> {
    let Record::Chunk { header, .. } = parse(op::CHUNK, data).map_err(Failure::Damage)? else {
        return Err(Failure::Damage("the record is not a chunk".into()));
    };
    let (length, claimed) = (data.len(), header.uncompressed_size);
    if claimed > SHRINK_LIMIT * length as u64 {
        let why = format!("{length} bytes claim to hold {claimed}");
        return Err(Failure::Damage(why));
    }
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(RECORD_LIMIT);
    let mut reader = LinearReader::new_with_options(options);
    let framing = [&[op::CHUNK][..], &(length as u64).to_le_bytes()].concat();
    reader.insert(framing.len()).copy_from_slice(&framing);
    reader.notify_read(framing.len());
    Ok(reader)
}

/// The next record of a reader that reads from `source`, at most `piece` bytes at once.
fn next_record(
    reader: &mut LinearReader,
    source: &mut impl Read,
    piece: usize,
) -> Result<Option<(u8, Vec<u8>)>, Failure> {
    loop {
        match reader.next_event() {
            None => return Ok(None),
            Some(Err(error)) => return Err(error.into()),
            Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                return Ok(Some((opcode, data.to_vec())));
            }
            Some(Ok(LinearReadEvent::ReadRequest(wanted))) => {
                let got = read_some(source, reader.insert(wanted.min(piece)))?;
                reader.notify_read(got);
            }
        }
    }
}

fn read_some(source: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    loop {
        match source.read(buffer) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => (),
            other => return other,
        }
    }
}
