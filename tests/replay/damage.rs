//! Logs that differ from what their run wrote: damaged, cut off, with a repeated part, changed, or empty. No verb takes one for sound,
//! and each uses the valid part.

use std::path::{Path, PathBuf};
use std::process::{Child, Output, Stdio};
use std::time::{Duration, Instant};

use exchange_log::{Entry, Recorder};
use harness::runs::{Scratch, parse_json, thirdbody};
use protocol::{Frame, Header, Kind};

use super::fuzz::record_ends;
use super::resume::shipped;

/// A short run of the scene `quick` in the folder `out`, and its log.
struct Run {
    work: Scratch,
    bytes: Vec<u8>,
}

const CHUNK: u8 = 6;

impl Run {
    fn new(name: &str) -> Run {
        let work = Scratch::new(name);
        let output = command(work.path(), "6e-5").output().expect("it starts");
        assert!(output.status.success(), "{}", said(&output));
        let log = work.path().join("out/exchange.mcap");
        let bytes = std::fs::read(log).expect("the run wrote it");
        Run { work, bytes }
    }

    fn log(&self) -> PathBuf {
        self.work.path().join("out/exchange.mcap")
    }

    fn put(&self, bytes: &[u8]) {
        std::fs::write(self.log(), bytes).expect("the folder is writable");
    }

    /// Start and end of the chunks that hold messages, in order.
    fn chunks(&self) -> Vec<(usize, usize)> {
        let ends = record_ends(&self.bytes);
        let pairs = ends.iter().zip(&ends[1..]);
        let chunks = pairs.filter(|(start, _)| self.bytes[**start] == CHUNK);
        chunks.map(|(start, end)| (*start, *end)).skip(1).collect()
    }

    /// Writes the log anew with other entries, whole and with all checksums right.
    fn rewrite(&self, change: impl FnOnce(&mut Vec<Entry>)) {
        self.put(&self.bytes);
        let log = exchange_log::read(&self.log()).expect("it is sound");
        let provenance = log.provenance.clone();
        let mut entries: Vec<Entry> = log.collect::<Result<_, _>>().expect("it is sound");
        change(&mut entries);
        let mut recorder = Recorder::create(&self.log(), &provenance, 10).expect("writable");
        for entry in entries {
            recorder.record(vec![entry]).expect("writable");
        }
        recorder.finish().expect("writable");
    }

    /// A verb on the run, with a separate folder for its output.
    fn verb(&self, words: &[&str]) -> Output {
        let results = Scratch::new("verb");
        let mut verb = thirdbody(self.work.path());
        verb.args([words[0], "out"]).args(&words[1..]);
        if ["export", "resume"].contains(&words[0]) {
            verb.arg("--out").arg(results.path().join("results"));
        }
        verb.output().expect("it starts")
    }

    /// Asserts an exit code and that the verb prints these words.
    fn says(&self, words: &[&str], code: i32, expected: &[&str]) -> String {
        let output = self.verb(words);
        let said = said(&output);
        assert_eq!(output.status.code(), Some(code), "{words:?}: {said}");
        for word in expected {
            assert!(said.contains(word), "{words:?}: no `{word}` in {said}");
        }
        said
    }
}

/// Stdout, then stderr.
fn said(output: &Output) -> String {
    let texts = [&output.stdout, &output.stderr];
    texts.map(|text| String::from_utf8_lossy(text)).concat()
}

/// `thirdbody run quick` until this time (s).
fn command(work: &Path, end_s: &str) -> std::process::Command {
    let mut run = thirdbody(work);
    run.arg("run").arg(shipped("quick"));
    run.args(["--json", "--out", "out"]);
    let end = format!("run.end_s={end_s}");
    let often = "run.output.flush_every_windows=10";
    for set in [&end, often, "run.checkpoint_every_windows=20"] {
        run.args(["--set", set]);
    }
    run
}

const VERBS: [&str; 5] = ["inspect", "replay", "export", "report", "resume"];

#[test]
fn damage_inside_a_log_has_code_6_in_every_verb() {
    let run = Run::new("damaged");
    let chunks = run.chunks();
    let flipped = |(start, end): (usize, usize)| {
        let mut bytes = run.bytes.clone();
        bytes[(start + end) / 2] ^= 1;
        run.put(&bytes);
    };
    flipped(chunks[chunks.len() / 2]);
    for verb in VERBS {
        run.says(&[verb], 6, &["damaged at byte", "--recover"]);
    }
    run.says(&["replay"], 6, &["messages equal", "bitwise identical"]);
    run.says(&["export"], 6, &[" messages"]);
    run.says(&["inspect"], 6, &["all numbers are finite"]);
    for verb in ["inspect", "replay", "export", "resume"] {
        run.says(&[verb, "--recover"], 0, &[]);
    }
    // Messages before the first window cannot be compared.
    flipped(chunks[0]);
    let found = run.says(&["replay"], 6, &["nothing was compared"]);
    assert!(!found.contains("identical"), "{found}");
    run.says(&["replay", "--recover"], 8, &["nothing was compared"]);
    // A length that reaches beyond the end is not the end of a killed writer, also not in a file without its end.
    let (start, _) = chunks[chunks.len() / 2];
    for length in [run.bytes.len(), run.bytes.len() * 3 / 4] {
        let mut bytes = run.bytes[..length].to_vec();
        bytes[start + 4] ^= 1;
        run.put(&bytes);
        run.says(&["replay"], 6, &["messages equal", "damaged at byte"]);
        run.says(&["resume"], 6, &["damaged at byte"]);
    }
}

#[test]
fn the_torn_end_of_a_killed_writers_log_is_not_damage() {
    let run = Run::new("torn");
    let chunks = run.chunks();
    let (start, end) = chunks[chunks.len() / 2];
    for length in [start, start + 5, start + 20, end - 1, end, end + 30] {
        run.put(&run.bytes[..length]);
        let verbs: &[&str] = if length == end - 1 {
            &["replay", "report", "resume"]
        } else {
            &["export"]
        };
        for verb in verbs {
            run.says(&[verb], 0, &[]);
        }
        // The run came to its end, so its log was whole.
        run.says(&["inspect"], 6, &["cut off"]);
        run.says(&["inspect", "--recover"], 0, &["cut off"]);
        // A run that was killed has no summary.
        let summary = run.work.path().join("out/summary.json");
        let away = summary.with_extension("away");
        std::fs::rename(&summary, &away).expect("it is there");
        run.says(&["inspect"], 0, &["the log ends early", "cut off"]);
        std::fs::rename(&away, &summary).expect("it is there");
    }
    // A writer killed at once leaves no log; the run begins again.
    for length in [0, 5, 100] {
        run.put(&run.bytes[..length]);
        run.says(&["resume"], 0, &["starts again"]);
    }
    let mut bytes = run.bytes.clone();
    bytes[100] ^= 1;
    run.put(&bytes);
    for verb in VERBS {
        run.says(&[verb], 6, &["exchange.mcap"]);
    }
}

#[test]
fn a_repeated_chunk_is_damage() {
    let run = Run::new("twice");
    let chunks = run.chunks();
    let last = chunks[chunks.len() - 1].1;
    for (start, end) in [chunks[0], chunks[1], chunks[chunks.len() / 2]] {
        for length in [run.bytes.len(), last] {
            let twice = [&run.bytes[..end], &run.bytes[start..length]].concat();
            run.put(&twice);
            let verbs = if start == chunks[1].0 {
                &VERBS
            } else {
                &VERBS[3..]
            };
            for verb in verbs {
                run.says(&[verb], 6, &["repeated"]);
            }
        }
    }
}

#[test]
fn a_replay_of_nothing_is_not_identical() {
    let run = Run::new("nothing");
    run.rewrite(Vec::clear);
    let found = run.says(&["replay"], 8, &["nothing was compared"]);
    assert!(!found.contains("identical"), "{found}");
}

/// Index of the last message of this sender and kind in the first half of a run.
fn in_the_middle(entries: &[Entry], sender: &str, kind: Kind) -> usize {
    let half = &entries[..entries.len() / 2];
    let found = half.iter().rposition(|entry| match entry {
        Entry::Exchange(one) => one.sender == sender && one.frame.kind() == Ok(kind),
        Entry::WindowEnd(_) => false,
    });
    found.expect("it was sent")
}

#[test]
fn a_log_that_is_not_read_to_its_end_is_a_departure() {
    let run = Run::new("unconsumed");
    run.rewrite(|entries| {
        let place = in_the_middle(entries, "rail", Kind::Report);
        entries.remove(place);
    });
    run.says(&["replay", "--node", "rail"], 7, &["has no answer"]);
    run.says(&["replay", "--node", "coupler"], 7, &["departs"]);
    run.says(&["replay", "--node", "third-body"], 0, &[]);
    // One window more than the coupler has.
    run.rewrite(|entries| {
        let ends: Vec<usize> = (0..entries.len())
            .filter(|place| matches!(entries[*place], Entry::WindowEnd(_)))
            .collect();
        let last = entries[ends[ends.len() - 2] + 1..].to_vec();
        entries.extend(last.into_iter().map(|entry| match entry {
            Entry::Exchange(mut exchange) => {
                exchange.frame.header.window += 1;
                Entry::Exchange(exchange)
            }
            Entry::WindowEnd(window) => Entry::WindowEnd(window + 1),
        }));
    });
    run.says(&["replay", "--node", "coupler"], 7, &["the replay its end"]);
    // A run that ended in the middle of a window closed its log as well.
    run.rewrite(|entries| entries.truncate(entries.len() - 2));
    run.says(&["replay"], 0, &["bitwise identical"]);
}

#[test]
fn times_interface_and_version_are_compared() {
    let run = Run::new("headers");
    let changes: [fn(&mut Header); 4] = [
        |header| header.t0_s *= 2.0,
        |header| header.t1_s *= 2.0,
        |header| header.interface += 1,
        |header| header.protocol += 1,
    ];
    let senders = [("rail", Kind::Motion), ("coupler", Kind::Advance)];
    for (sender, kind) in senders {
        for (index, change) in changes.into_iter().enumerate() {
            run.rewrite(|entries| {
                let place = in_the_middle(entries, sender, kind);
                if let Entry::Exchange(exchange) = &mut entries[place] {
                    change(&mut exchange.frame.header);
                }
            });
            let found = run.says(&["replay", "--node", sender], 7, &["departs"]);
            assert!(found.contains(&format!("{kind:?}")), "{index}: {found}");
        }
    }
}

#[test]
fn the_final_state_is_compared() {
    let run = Run::new("states");
    run.says(&["replay"], 0, &[]);
    let path = run.work.path().join("out/summary.json");
    let text = std::fs::read(&path).expect("the run wrote it");
    let mut summary = parse_json(&text);
    let state = &mut summary["participants"]["rail"]["state_hash"];
    assert_eq!(state.as_str().map(str::len), Some(64), "{state}");
    *state = "another".into();
    std::fs::write(&path, summary.to_string()).expect("the folder is writable");
    let expected = ["`rail` departs", "the final state another"];
    run.says(&["replay"], 7, &expected);
    run.says(&["replay", "--from", "75"], 7, &expected);
    run.says(&["replay", "--node", "third-body"], 0, &[]);
    // After a part of the run the state is another one.
    run.put(&run.bytes[..run.chunks()[3].1]);
    run.says(&["replay"], 0, &[]);
}

/// A run in the background; dropping it ends the process.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_log_lost_during_the_run_ends_it_as_output_failed() {
    type Harm = fn(&Path) -> std::io::Result<()>;
    let harms: [(&str, Harm); 3] = [
        ("removed", |log| std::fs::remove_file(log)),
        ("replaced", |log| {
            let other = log.with_extension("other");
            std::fs::copy(log, &other)?;
            std::fs::rename(other, log)
        }),
        ("changed", |log| {
            let file = std::fs::File::options().write(true).open(log)?;
            file.set_len(1000)
        }),
    ];
    for (words, harm) in harms {
        let work = Scratch::new("taken-away");
        let log = work.path().join("out/exchange.mcap");
        let mut run = command(work.path(), "1e-3");
        let run = run.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut running = Running(run.spawn().expect("it starts"));
        let start = Instant::now();
        while std::fs::metadata(&log).map_or(0, |file| file.len()) < 50_000 {
            assert!(start.elapsed() < Duration::from_secs(60), "no log");
            assert!(running.0.try_wait().is_ok_and(|ended| ended.is_none()));
            std::thread::sleep(Duration::from_millis(5));
        }
        harm(&log).expect("the folder is writable");
        let status = running.0.wait().expect("it is our child");
        let summary = std::fs::read(work.path().join("out/summary.json")).expect("written");
        let summary = parse_json(&summary);
        assert_eq!(status.code(), Some(9), "{words}: {summary:#}");
        assert_eq!(summary["status"], "output_failed");
        let message = summary["message"].as_str().expect("a text");
        for word in ["exchange.mcap", words] {
            assert!(message.contains(word), "no `{word}` in {message}");
        }
        assert!(
            summary["windows"].as_u64() < Some(1000),
            "it ends at the next flush: {summary:#}"
        );
    }
}

#[test]
fn participants_that_count_their_own_windows_are_no_repeats() {
    let work = Scratch::new("own-windows");
    let path = work.path().join("log.mcap");
    let mut recorder =
        Recorder::create(&path, &exchange_log::Provenance::default(), 1).expect("writable");
    for window in [0, 1, 2] {
        for name in ["rail", "layer"] {
            let header = Header {
                window,
                ..Header::of(Kind::Motion)
            };
            let exchange = exchange_log::Exchange {
                interface: name.into(),
                sender: name.into(),
                receiver: exchange_log::COUPLER.into(),
                frame: Frame::new(header, vec![1.0]),
            };
            let said = vec![Entry::Exchange(exchange), Entry::WindowEnd(window)];
            recorder.record(said).expect("writable");
        }
    }
    recorder.finish().expect("writable");
    let found = exchange_log::summarize(&path, false).expect("nothing is repeated");
    assert_eq!(found.windows, 6);
}
