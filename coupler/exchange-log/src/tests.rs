//! Recording, reading, and damage.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use protocol::link::shm::MAX_DOUBLES;
use protocol::{Frame, Header, Kind};

use super::export::{Selection, bytes, long};
use super::read::is_as_written;
use super::*;

/// A file of one test, removed with it.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Scratch {
        static FILES: AtomicU64 = AtomicU64::new(0);
        let file = FILES.fetch_add(1, Ordering::Relaxed);
        let name = format!("thirdbody-log-{}-{file}.mcap", std::process::id());
        Scratch(std::env::temp_dir().join(name))
    }

    fn holding(bytes: &[u8]) -> Scratch {
        let scratch = Scratch::new();
        fs::write(&scratch.0, bytes).expect("the folder can be written to");
        scratch
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

const RUN: u64 = 0xfeed_0000_beef_0001;

fn origin() -> Provenance {
    Provenance {
        scenario_toml: "[run]\nname = \"Zügig\"\n".into(),
        manifest_json: "{\"seed\": 7}".into(),
        run_id: RUN,
    }
}

fn exchange(sender: &str, kind: Kind, window: u64, payload: Vec<f64>) -> Exchange {
    let receiver = if sender == "coupler" {
        "rail"
    } else {
        "coupler"
    };
    let header = Header {
        run_id: RUN,
        interface: 0,
        iteration: window as u32 % 3,
        window,
        step: 7 * window,
        substeps: 7,
        t0_s: window as f64 * 1e-7,
        t1_s: (window + 1) as f64 * 1e-7,
        ..Header::of(kind)
    };
    Exchange {
        interface: "layer-base".into(),
        sender: sender.into(),
        receiver: receiver.into(),
        frame: Frame::new(header, payload),
    }
}

/// A handshake and `windows` windows of two frames each.
fn story(windows: u64) -> Vec<Entry> {
    let mut entries = vec![
        Entry::Exchange(exchange("coupler", Kind::Columns, 0, vec![])),
        Entry::Exchange(exchange("rail", Kind::Compliance, 0, vec![0.5; 9])),
    ];
    for window in 0..windows {
        let force = vec![window as f64, -0.0, f64::MIN_POSITIVE / 4.0];
        let motion = vec![1.0 / (window + 3) as f64; 5];
        entries.push(Entry::Exchange(exchange(
            "coupler",
            Kind::Advance,
            window,
            force,
        )));
        entries.push(Entry::Exchange(exchange(
            "rail",
            Kind::Motion,
            window,
            motion,
        )));
        entries.push(Entry::WindowEnd(window));
    }
    entries
}

fn recorded(path: &Path, entries: &[Entry], flush_every_windows: u64) -> LogStats {
    let mut recorder =
        Recorder::create(path, &origin(), flush_every_windows).expect("it is created");
    for entry in entries {
        recorder
            .record(vec![entry.clone()])
            .expect("it is recorded");
    }
    recorder.finish().expect("it is completed")
}

fn bytes_of(entries: &[Entry], flush_every_windows: u64) -> Vec<u8> {
    let scratch = Scratch::new();
    recorded(&scratch.0, entries, flush_every_windows);
    fs::read(&scratch.0).expect("it was written")
}

fn hash_of(entries: &[Entry]) -> String {
    let mut hasher = ExchangeHasher::default();
    entries.iter().for_each(|entry| hasher.add_entry(entry));
    hasher.finish()
}

/// Equal to the bit, which `==` on doubles is not.
fn assert_same(read: &[Entry], expected: &[Entry]) {
    assert_eq!(read.len(), expected.len());
    for (read, expected) in read.iter().zip(expected) {
        match (read, expected) {
            (Entry::Exchange(read), Entry::Exchange(expected)) => {
                let bits = |e: &Exchange| {
                    e.frame
                        .payload
                        .iter()
                        .map(|v| v.to_bits())
                        .collect::<Vec<_>>()
                };
                assert_eq!(bits(read), bits(expected));
                assert_eq!(read.frame.header, expected.frame.header);
                assert_eq!(
                    (&read.interface, &read.sender, &read.receiver),
                    (&expected.interface, &expected.sender, &expected.receiver)
                );
            }
            _ => assert_eq!(read, expected),
        }
    }
}

fn read_all(path: &Path) -> Result<Vec<Entry>, LogError> {
    read(path)?.collect()
}

#[test]
fn a_log_restores_recorded_entries_to_the_bit() {
    let scratch = Scratch::new();
    let mut entries = story(40);
    let odd = vec![
        f64::NAN,
        f64::from_bits(0x7ff0_0000_0000_0001),
        f64::from_bits(0xfff8_dead_beef_cafe),
        f64::NEG_INFINITY,
        -0.0,
    ];
    entries.push(Entry::Exchange(exchange(
        "rail",
        Kind::Motion,
        u64::MAX,
        odd,
    )));
    let stats = recorded(&scratch.0, &entries, 3);
    assert_eq!((stats.messages, stats.windows), (83, 40));
    assert_eq!(
        Some(stats.bytes),
        fs::metadata(&scratch.0).ok().map(|m| m.len())
    );
    let log = read(&scratch.0).expect("it is a log");
    assert_eq!(log.provenance, origin());
    assert_same(&read_all(&scratch.0).expect("it is whole"), &entries);
}

#[test]
fn a_large_message_is_restored() {
    let scratch = Scratch::new();
    let matrix = (0..1_000_000).map(|i| f64::from(i).sqrt()).collect();
    let entries = [Entry::Exchange(exchange(
        "rail",
        Kind::Compliance,
        0,
        matrix,
    ))];
    recorded(&scratch.0, &entries, 1);
    assert_same(&read_all(&scratch.0).expect("it is whole"), &entries);
}

#[test]
fn a_payload_that_compresses_to_almost_nothing_is_restored() {
    let scratch = Scratch::new();
    let entries = [Entry::Exchange(exchange(
        "rail",
        Kind::Motion,
        0,
        vec![0.0; 500_000],
    ))];
    recorded(&scratch.0, &entries, 1);
    assert_same(&read_all(&scratch.0).expect("it is whole"), &entries);
}

#[test]
fn a_message_beyond_the_cap_is_refused() {
    let scratch = Scratch::new();
    let mut recorder = Recorder::create(&scratch.0, &origin(), 1).expect("it is created");
    let mut long = exchange("rail", Kind::Motion, 0, Vec::new());
    long.frame.payload = vec![0.0; MAX_DOUBLES + 1];
    let refused = recorder.record(vec![Entry::Exchange(long)]);
    assert!(matches!(refused, Err(LogError::TooLong { .. })));
    recorder.finish().expect("the log continues without it");
}

#[test]
fn equal_exchanges_of_different_runs_have_equal_messages() {
    let mut other = story(3);
    for entry in &mut other {
        if let Entry::Exchange(exchange) = entry {
            exchange.frame.header.run_id = 1;
        }
    }
    assert_eq!(bytes_of(&story(3), 1), bytes_of(&other, 1));
}

/// A killed writer leaves the beginning of a file. For any length, the readable part is the beginning of the story, and a longer file never
/// has fewer entries.
#[test]
fn a_truncated_log_holds_the_beginning_of_the_story() {
    let entries = story(12);
    let bytes = bytes_of(&entries, 2);
    let mut most = 0;
    for length in 0..bytes.len() {
        let scratch = Scratch::holding(&bytes[..length]);
        assert!(
            read_all(&scratch.0).is_err(),
            "{length} bytes are not whole"
        );
        let Ok(mut log) = recover(&scratch.0) else {
            assert_eq!(most, 0, "{length} bytes");
            continue;
        };
        let found: Vec<Entry> = log
            .by_ref()
            .collect::<Result<_, _>>()
            .expect("unreadable entries are left out");
        let damage = log.damage.as_ref().expect("it has no end");
        assert!(damage.is_torn(), "{length} bytes: {damage}");
        assert!(found.len() >= most, "{length} bytes");
        most = found.len();
        assert_same(&found, &entries[..most]);
    }
    assert_eq!(most, entries.len());
}

#[test]
fn one_flipped_bit_anywhere_is_an_error() {
    let entries = story(4);
    let bytes = bytes_of(&entries, 2);
    for index in 0..bytes.len() {
        for bit in [0, 7] {
            let mut damaged = bytes.clone();
            damaged[index] ^= 1 << bit;
            let scratch = Scratch::holding(&damaged);
            assert!(
                read_all(&scratch.0).is_err(),
                "byte {index} of {}, bit {bit}",
                bytes.len()
            );
            assert!(!is_as_written(&scratch.0).expect("it is read"));
            if let Ok(mut log) = recover(&scratch.0) {
                let mut found: Vec<Entry> = log.by_ref().filter_map(Result::ok).collect();
                let damage = log.damage.as_ref().expect("a bit was flipped");
                // The flipped bit at the end may look like the kind of a torn record.
                let torn = damage.is_torn() && index != bytes.len() - 8;
                assert!(!torn, "byte {index} of {}, bit {bit}", bytes.len());
                // The run id is in no chunk: only the checksum at the end of the file covers it.
                for entry in &mut found {
                    if let Entry::Exchange(exchange) = entry {
                        exchange.frame.header.run_id = RUN;
                    }
                }
                assert_same(&found, &entries[..found.len()]);
            }
        }
    }
}

#[test]
fn the_checksum_of_its_data_identifies_a_whole_log() {
    let scratch = Scratch::holding(&bytes_of(&story(4), 2));
    assert!(is_as_written(&scratch.0).expect("it is read"));
    assert!(damage(&scratch.0).expect("it is read").is_none());
}

#[test]
fn bytes_after_the_end_are_an_error() {
    let mut bytes = bytes_of(&story(2), 1);
    bytes.push(0);
    let scratch = Scratch::holding(&bytes);
    assert!(read_all(&scratch.0).is_err());
}

#[test]
fn damage_is_named_with_its_chunk_and_byte() {
    let entries = story(6);
    let bytes = bytes_of(&entries, 2);
    // Three chunks hold two windows each, after the chunk that declares the messages.
    let needle = b"lz4";
    let chunks: Vec<usize> = (0..bytes.len() - 3)
        .filter(|start| &bytes[*start..start + 3] == needle)
        .collect();
    let mut damaged = bytes.clone();
    damaged[chunks[2] + 40] ^= 0x10;
    let scratch = Scratch::holding(&damaged);
    let error = read_all(&scratch.0).expect_err("the third chunk is damaged");
    let text = error.to_string();
    assert!(text.contains("in chunk 3"), "{text}");
    // The chunk's record begins 9 + 32 bytes before the name of its compression.
    assert!(text.contains(&format!("byte {}", chunks[2] - 41)), "{text}");
    let mut log = recover(&scratch.0).expect("its beginning is fine");
    assert_eq!(log.by_ref().count(), 8, "the handshake and two windows");
    assert!(log.damage.is_some());
}

#[test]
fn a_killed_writer_loses_no_more_than_the_windows_since_the_last_flush() {
    let scratch = Scratch::new();
    let entries = story(7);
    let mut recorder = Recorder::create(&scratch.0, &origin(), 3).expect("it is created");
    for entry in &entries {
        recorder
            .record(vec![entry.clone()])
            .expect("it is recorded");
    }
    // Killed here, as soon as the writer has flushed six windows.
    let found = loop {
        let copy = Scratch::holding(&fs::read(&scratch.0).expect("it exists"));
        let summary = summarize(&copy.0, true).expect("its beginning is fine");
        if summary.windows >= 6 {
            break summary;
        }
        std::thread::sleep(Duration::from_millis(1));
    };
    assert_eq!(found.last_window, Some(5));
    assert!(found.damage.is_some(), "it has no end");
    drop(recorder);
    let whole = summarize(&scratch.0, false).expect("a recorder that is dropped ends its file");
    assert_eq!(whole.windows, 7);
}

#[test]
fn a_full_disk_is_an_error_and_not_a_panic() {
    let full = Path::new("/dev/full");
    let error = Recorder::create(full, &origin(), 1).err();
    let text = error.expect("nothing fits there").to_string();
    assert!(text.contains("No space left"), "{text}");
    let nowhere = Recorder::create(Path::new("/nowhere/log.mcap"), &origin(), 1);
    assert!(matches!(nowhere.err(), Some(LogError::Write { .. })));
}

#[test]
fn closing_a_log_that_was_removed_replaced_or_changed_is_an_error() {
    type Harm = fn(&Path) -> std::io::Result<()>;
    let harms: [(&str, Harm); 4] = [
        ("removed", |log| fs::remove_file(log)),
        ("replaced", |log| {
            fs::remove_file(log)?;
            fs::write(log, b"")
        }),
        ("changed", |log| fs::write(log, b"")),
        ("changed", |log| {
            let mut file = fs::File::options().append(true).open(log)?;
            std::io::Write::write_all(&mut file, &[0])
        }),
    ];
    for (words, harm) in harms {
        let scratch = Scratch::new();
        let mut recorder = Recorder::create(&scratch.0, &origin(), 100).expect("it is created");
        story(3)
            .iter()
            .try_for_each(|entry| recorder.record(vec![entry.clone()]))
            .expect("it is recorded");
        harm(&scratch.0).expect("the folder is writable");
        let error = recorder.finish().expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
        assert!(error.contains(&scratch.0.display().to_string()), "{error}");
    }
}

#[test]
fn a_wait_for_the_disk_ends_at_once_if_the_writer_has_failed() {
    for trial in 0..100 {
        let scratch = Scratch::new();
        let mut recorder = Recorder::create(&scratch.0, &origin(), 1).expect("it is created");
        fs::remove_file(&scratch.0).expect("the folder is writable");
        // The writer fails at the end of the first window; the wait is behind it in the queue, or comes too late.
        let start = Instant::now();
        let error = story(3)
            .iter()
            .try_for_each(|entry| recorder.record(vec![entry.clone()]))
            .and_then(|()| recorder.sync())
            .expect_err("the file is gone")
            .to_string();
        assert!(error.contains("removed"), "trial {trial}: {error}");
        assert!(start.elapsed() < Duration::from_secs(10), "trial {trial}");
    }
}

#[test]
fn an_export_takes_every_second_window_and_predicts_its_size() {
    let scratch = Scratch::new();
    recorded(&scratch.0, &story(5), 2);
    let out = scratch.0.with_extension("csv");
    let every = |every| Selection {
        kind: Some(Kind::Motion),
        every: Some(every),
        ..Selection::default()
    };
    let exported = long(&scratch.0, &every(2), &out).expect("it is whole");
    let text = fs::read_to_string(&out).expect("it was written");
    let windows = text
        .lines()
        .skip(1)
        .filter_map(|line| line.split(',').next());
    let windows: BTreeSet<&str> = windows.collect();
    assert_eq!(
        (exported.messages, windows),
        (3, BTreeSet::from(["0", "2", "4"]))
    );
    let _ = fs::remove_file(&out);
    // Five numbers per message.
    let size = |n, is_long| bytes(&scratch.0, &every(n), is_long).expect("it is whole");
    assert_eq!((size(1, true), size(2, true)), (25 * 82, 15 * 82));
    assert!(size(1, false) < size(1, true));
}

#[test]
fn a_summary_counts_streams_and_repeats_the_hash() {
    let scratch = Scratch::new();
    let mut entries = story(5);
    // It names window 0 again, like the handshake of a shorter window.
    entries.push(Entry::Exchange(exchange(
        "coupler",
        Kind::Columns,
        0,
        vec![],
    )));
    recorded(&scratch.0, &entries, 2);
    let summary = summarize(&scratch.0, false).expect("it is whole");
    assert_eq!(summary.hash, hash_of(&entries));
    assert_eq!(summary.provenance, origin());
    assert_eq!((summary.windows, summary.last_window), (5, Some(4)));
    assert_eq!(summary.non_finite, None);
    let topics: Vec<String> = summary.streams.iter().map(|s| s.topic.clone()).collect();
    let expected = [
        "coupler/Columns",
        "rail/Compliance",
        "coupler/Advance",
        "rail/Motion",
    ];
    assert_eq!(topics, expected.map(|topic| format!("layer-base/{topic}")));
    let motion = &summary.streams[3];
    assert_eq!((motion.messages, motion.bytes), (5, 5 * 5 * 8));
    assert_eq!((motion.first_window, motion.last_window), (0, 4));
}

#[test]
fn the_first_nan_or_infinite_number_is_found() {
    let scratch = Scratch::new();
    let mut entries = story(3);
    for window in 3..5 {
        let payload = vec![0.0, 1.0, f64::NEG_INFINITY, f64::NAN];
        entries.push(Entry::Exchange(exchange(
            "rail",
            Kind::Motion,
            window,
            payload,
        )));
    }
    recorded(&scratch.0, &entries, 1);
    let expected = NonFinite {
        topic: "layer-base/rail/Motion".into(),
        window: 3,
        iteration: 0,
        entry: 2,
        value: f64::NEG_INFINITY,
    };
    let summary = summarize(&scratch.0, false).expect("it is whole");
    assert_eq!(summary.non_finite, Some(expected));
}

#[test]
fn a_file_that_is_not_a_log_is_refused_by_name() {
    let missing = read(Path::new("/nowhere/exchange.mcap")).err();
    assert!(matches!(missing, Some(LogError::Read { .. })));
    let folder = read(&std::env::temp_dir()).err();
    assert!(matches!(folder, Some(LogError::Read { .. })));
    let contents: [&[u8]; 3] = [b"", b"window,iteration\n0,0\n", &[0; 4096]];
    for content in contents {
        let scratch = Scratch::holding(content);
        let refused = recover(&scratch.0).err();
        assert!(matches!(refused, Some(LogError::NotALog { .. })));
    }
}

#[test]
fn a_file_of_another_program_is_refused() {
    let scratch = Scratch::new();
    let file = fs::File::create(&scratch.0).expect("it can be written");
    mcap::Writer::new(file)
        .and_then(|mut writer| writer.finish())
        .expect("it is written");
    assert!(matches!(
        read(&scratch.0).err(),
        Some(LogError::NotALog { .. })
    ));
}
