//! What zenoh complains of about connections: whom it did not let in, and whom it cannot reach.

use std::fmt::{Debug, Write};
use std::sync::{Mutex, PoisonError};

use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Level, Metadata, Subscriber};

/// Complaints that are kept: a stranger may cause any number.
const KEPT: usize = 20;

static KEPT_BACK: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Whether a process prints complaints or keeps them.
pub(crate) enum Complaints {
    /// On its standard error, which its coordinator keeps.
    Printed,
    /// Until they are asked for.
    Kept,
}

impl Complaints {
    /// From now on, in this process, if nobody else does.
    pub fn begin(self) {
        let _ = tracing::subscriber::set_global_default(self);
    }

    /// Those that were kept.
    pub fn take() -> Vec<String> {
        let mut kept = KEPT_BACK.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut *kept)
    }
}

impl Subscriber for Complaints {
    fn enabled(&self, metadata: &Metadata) -> bool {
        let of_connections = ["zenoh_link", "zenoh_transport"];
        let target = metadata.target();
        *metadata.level() <= Level::WARN && of_connections.iter().any(|of| target.starts_with(of))
    }

    fn event(&self, event: &Event) {
        let mut text = Text::default();
        event.record(&mut text);
        // Where in its sources zenoh stands then helps nobody.
        let said = text.0.split(" at /").next().unwrap_or_default().to_string();
        match self {
            Complaints::Printed => {
                let _ = std::io::Write::write_fmt(
                    &mut std::io::stderr(),
                    format_args!("zenoh: {said}\n"),
                );
            }
            Complaints::Kept => {
                let mut kept = KEPT_BACK.lock().unwrap_or_else(PoisonError::into_inner);
                if kept.len() < KEPT && !kept.contains(&said) {
                    kept.push(said);
                }
            }
        }
    }

    fn new_span(&self, _: &Attributes) -> Id {
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Record) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}
}

#[derive(Default)]
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        if field.name() == "message" {
            let _ = write!(self.0, "{value:?}");
        }
    }
}
