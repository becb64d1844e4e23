//! The wall-clock times of a run as a trace of work and waiting, in the JSON of Chrome's trace events (Google, *Trace Event Format*), which
//! <https://ui.perfetto.dev> opens.
//!
//! Processes are the coordinator (0) and the participants, each with a thread `work` (1) and a thread `wait` (2). Events are complete events
//! (`X`), times are microseconds since the first event. Events of one thread do not overlap, and the two threads of a participant together
//! have no gap.
//!
//! A participant's work is drawn from its own report, request by request. Without a report, or with only a sample because the run was long
//! (see [`protocol::busy`]), work is drawn from request to answer, as the coordinator sees it: its events have
//! `"seen_by": "coordinator"`, and include the time of frames and wake-ups.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;

use protocol::Kind;
use serde_json::{Value, json};

use super::entry::kind_name;
use super::timing::{OwnTimes, ParticipantTimes, RequestTimes, Timing};
use crate::error::ExportError;

/// First and last window to draw.
pub type Windows = [u64; 2];

/// A written trace.
#[derive(Debug, Default)]
pub struct Traced {
    /// Number of events.
    pub events: u64,
    /// Size of the file.
    pub bytes: u64,
    /// Notes on participants whose own report is not drawn, with reasons.
    pub notes: Vec<String>,
}

/// Writes the trace of all windows, or of all events from the first to the last of some windows.
pub fn write(timing: &Timing, windows: Option<Windows>, out: &Path) -> Result<Traced, ExportError> {
    let range = range(timing, windows)?;
    let (mut processes, notes): (Vec<_>, Vec<_>) = timing.participants.iter().map(process).unzip();
    processes.insert(0, coordinator(timing));
    let mut notes: Vec<String> = notes.into_iter().flatten().collect();
    notes.extend(timing.cut_off.iter().map(|why| {
        format!("timing.mcap ends early ({why}): the run was killed; its beginning is drawn")
    }));
    let written = put(processes, range, &notes, out);
    let written = written.and_then(|events| Ok((events, fs::metadata(out)?.len())));
    let (events, bytes) = written.map_err(ExportError::write(out))?;
    Ok(Traced {
        events,
        bytes,
        notes,
    })
}

/// One event; times in ns.
#[derive(Clone, Debug, PartialEq)]
struct Span {
    name: String,
    from_ns: u64,
    to_ns: u64,
    args: Value,
}

impl Span {
    fn new(name: impl Into<String>, [from_ns, to_ns]: [u64; 2], args: Value) -> Span {
        Span {
            name: name.into(),
            from_ns,
            to_ns,
            args,
        }
    }
}

/// Two threads of events, each in order.
#[derive(Debug)]
struct Process {
    name: String,
    work: Vec<Span>,
    wait: Vec<Span>,
}

/// Window and iteration of a request about a window.
fn args(request: &RequestTimes) -> Value {
    if is_about_window(request) {
        json!({ "window": request.window, "iteration": request.iteration })
    } else {
        json!({})
    }
}

fn is_about_window(request: &RequestTimes) -> bool {
    Kind::from_number(request.kind).is_some_and(Kind::is_about_window)
}

/// The coordinator: its recorded waits, and its own work between them.
fn coordinator(timing: &Timing) -> Process {
    let requests = timing.participants.iter();
    let requests = requests.flat_map(|one| one.requests.iter().map(move |request| (one, request)));
    let mut all: Vec<_> = requests.collect();
    all.sort_by_key(|(_, request)| (request.awaited_ns, request.answered_ns));
    let (mut work, mut wait) = (Vec::new(), Vec::new());
    let mut reached_ns = all.iter().map(|(_, one)| one.asked_ns).min().unwrap_or(0);
    for (participant, request) in all {
        let from_ns = request.awaited_ns.max(reached_ns);
        if reached_ns < from_ns {
            work.push(Span::new("couple", [reached_ns, from_ns], args(request)));
        }
        reached_ns = request.answered_ns.max(from_ns);
        let name = format!("wait for {}", participant.name);
        wait.push(Span::new(name, [from_ns, reached_ns], args(request)));
    }
    Process {
        name: "coordinator".into(),
        work,
        wait,
    }
}

/// A participant: its work, and the waits in between. The note says why its own report is not drawn.
fn process(participant: &ParticipantTimes) -> (Process, Option<String>) {
    let name = participant.name.clone();
    let (mut work, begin_ns, note) = match reported(participant) {
        Ok((work, begin_ns)) => (work, begin_ns, None),
        Err(why) => {
            let work = seen(participant);
            let begin_ns = work.first().map_or(0, |first| first.from_ns);
            let note =
                format!("participant `{name}` {why}: its work is drawn from request to answer");
            (work, begin_ns, Some(note))
        }
    };
    let mut reached_ns = begin_ns;
    let between = work.iter().map(|next| {
        let from_ns = std::mem::replace(&mut reached_ns, next.to_ns);
        Span::new("wait", [from_ns, next.from_ns], next.args.clone())
    });
    let wait = between.filter(|span| span.from_ns < span.to_ns).collect();
    if note.is_some() {
        for span in &mut work {
            span.args["seen_by"] = "coordinator".into();
        }
    }
    (Process { name, work, wait }, note)
}

/// The work of a participant from its own report, and its beginning; or the reason why the report cannot be drawn.
fn reported(participant: &ParticipantTimes) -> Result<(Vec<Span>, u64), String> {
    let Some(own) = &participant.own else {
        return Err("did not report its times, because the run ended early".into());
    };
    let [hello, requests @ ..] = &participant.requests[..] else {
        return Err("has answered no request".into());
    };
    let spans = &own.busy.spans_ns;
    let (every, found, due) = (own.busy.every, spans.len(), requests.len());
    if every != 1 {
        return Err(format!("kept one of {every} slots of its times"));
    }
    if found != due {
        return Err(format!("reports {found} requests, but answered {due}"));
    }
    let fits = |(request, [from, to]): (&RequestTimes, &[u64; 2])| {
        request.asked_ns <= *from && from <= to && *to <= request.answered_ns
    };
    if !requests.iter().zip(spans).all(fits) || spans.windows(2).any(|two| two[0][1] > two[1][0]) {
        return Err("has another clock".into());
    }
    let (setup, begin_ns) = setup(hello, own);
    let pairs = requests.iter().zip(spans);
    let work = pairs.map(|(one, span)| Span::new(kind_name(one.kind), *span, args(one)));
    Ok(([setup].into_iter().chain(work).collect(), begin_ns))
}

/// The set-up of a participant, and its beginning: its end minus the time of its work, set-up and waits. The greeting can have arrived at any
/// time after it was sent; the earliest time is drawn.
fn setup(hello: &RequestTimes, own: &OwnTimes) -> (Span, u64) {
    let ns = |seconds: f64| (1e9 * seconds.max(0.0)).round() as u64;
    let spans = &own.busy.spans_ns;
    let (first_ns, last_ns) = match (spans.first(), spans.last()) {
        (Some(first), Some(last)) => (first[0], last[1]),
        _ => (hello.answered_ns, hello.answered_ns),
    };
    let all_ns = ns(own.solve_wall_s) + ns(own.setup_wall_s) + ns(own.wait_s);
    let begin_ns = last_ns.saturating_sub(all_ns).min(first_ns);
    let from_ns = hello.asked_ns.max(begin_ns).min(first_ns);
    let to_ns = (from_ns + ns(own.setup_wall_s)).min(first_ns);
    (Span::new("set-up", [from_ns, to_ns], json!({})), begin_ns)
}

/// The work of a participant as the coordinator sees it.
fn seen(participant: &ParticipantTimes) -> Vec<Span> {
    let mut reached_ns = 0;
    let requests = participant.requests.iter();
    let spans = requests.map(|request| {
        let from_ns = request.asked_ns.max(reached_ns);
        reached_ns = request.answered_ns.max(from_ns);
        let name = if request.kind == Kind::Hello as u32 {
            "set-up".into()
        } else {
            kind_name(request.kind)
        };
        Span::new(name, [from_ns, reached_ns], args(request))
    });
    spans.collect()
}

/// The time to draw: all, or the time of the windows.
fn range(timing: &Timing, windows: Option<Windows>) -> Result<[u64; 2], ExportError> {
    let Some([first, last]) = windows else {
        return Ok([0, u64::MAX]);
    };
    let requests = timing.participants.iter().flat_map(|one| &one.requests);
    let about = requests.filter(|request| is_about_window(request));
    let is_drawn = |request: &&RequestTimes| (first..=last).contains(&request.window);
    let drawn = about.clone().filter(is_drawn);
    let from_ns = drawn.clone().map(|request| request.asked_ns);
    let to_ns = drawn.map(|request| request.answered_ns);
    if let (Some(from_ns), Some(to_ns)) = (from_ns.min(), to_ns.max()) {
        return Ok([from_ns, to_ns]);
    }
    let has = about.map(|request| request.window).max();
    let has = has.map_or("no windows".into(), |end| format!("windows up to {end}"));
    Err(ExportError::NoWindow { first, last, has })
}

/// Writes all events; returns their number.
fn put(processes: Vec<Process>, range: [u64; 2], notes: &[String], out: &Path) -> io::Result<u64> {
    let mut file = BufWriter::new(File::create_new(out)?);
    let about = json!({
        "software": concat!("thirdbody ", env!("CARGO_PKG_VERSION")),
        "notes": notes,
    });
    let head = format!("{{\"displayTimeUnit\": \"ms\", \"otherData\": {about}, \"traceEvents\": [");
    writeln!(file, "{head}")?;
    let drawn = processes.into_iter().map(|Process { name, work, wait }| {
        (name, [work, wait].map(|spans| clipped(spans, range)))
    });
    let drawn = Vec::from_iter(drawn);
    let all = drawn.iter().flat_map(|(_, threads)| threads).flatten();
    let zero_ns = all.map(|span| span.from_ns).min().unwrap_or(0);
    let mut events = 0;
    for (pid, (name, threads)) in drawn.iter().enumerate() {
        let lead = if pid == 0 { "" } else { ",\n" };
        let name = named("process_name", pid, 0, name);
        write!(file, "{lead}{name}")?;
        for (tid, (name, spans)) in (1..).zip(["work", "wait"].into_iter().zip(threads)) {
            write!(file, ",\n{}", named("thread_name", pid, tid, name))?;
            for span in spans {
                write!(file, ",\n{}", event(span, [pid, tid], name, zero_ns))?;
                events += 1;
            }
        }
    }
    writeln!(file, "\n]}}")?;
    file.flush()?;
    Ok(events)
}

/// The parts of spans within a range of time.
fn clipped(spans: Vec<Span>, [from_ns, to_ns]: [u64; 2]) -> Vec<Span> {
    let inside = |span: &Span| span.from_ns < to_ns && span.to_ns > from_ns;
    let cut = |span: Span| Span {
        from_ns: span.from_ns.max(from_ns),
        to_ns: span.to_ns.min(to_ns),
        ..span
    };
    spans.into_iter().filter(inside).map(cut).collect()
}

fn named(what: &str, pid: usize, tid: usize, name: &str) -> Value {
    json!({ "ph": "M", "name": what, "pid": pid, "tid": tid, "args": { "name": name } })
}

/// An event as JSON, with times to the ns: a double of microseconds could not resolve them for long.
fn event(span: &Span, [pid, tid]: [usize; 2], category: &str, zero_ns: u64) -> String {
    let us = |ns: u64| format!("{}.{:03}", ns / 1000, ns % 1000);
    let (ts, dur) = (us(span.from_ns - zero_ns), us(span.to_ns - span.from_ns));
    let name = Value::from(span.name.as_str());
    format!(
        "{{\"ph\":\"X\",\"pid\":{pid},\"tid\":{tid},\"ts\":{ts},\"dur\":{dur},\"name\":{name},\"cat\":\"{category}\",\"args\":{}}}",
        span.args
    )
}

#[cfg(test)]
mod tests;
