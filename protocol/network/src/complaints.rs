//! Complaints of zenoh about connections: whom it did not let in, and whom it cannot reach.

use std::sync::{Mutex, PoisonError};

/// Complaints that are kept: a stranger may cause any number.
const KEPT: usize = 20;

static COMPLAINTS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// From now on zenoh complains to `hear`, if nobody else in this process listens to it.
pub(crate) fn listen(hear: fn(String)) {
    let of_connections = ["zenoh_link", "zenoh_transport"];
    zenoh_util::init_log_with_callback(
        move |about| {
            let of_connection = of_connections
                .iter()
                .any(|of| about.target().starts_with(of));
            of_connection && ["WARN", "ERROR"].contains(&about.level().as_str())
        },
        move |record| hear(without_place(&record.message.unwrap_or_default())),
    );
}

/// Words of zenoh without the place in its sources, which they end with and which helps nobody.
pub(crate) fn without_place(said: &str) -> String {
    said.split(" at /").next().unwrap_or_default().into()
}

/// Keeps a complaint until it is taken.
pub(crate) fn keep(said: String) {
    let mut kept = COMPLAINTS.lock().unwrap_or_else(PoisonError::into_inner);
    if kept.len() < KEPT && !kept.contains(&said) {
        kept.push(said);
    }
}

/// Those that were kept.
pub(crate) fn take() -> Vec<String> {
    std::mem::take(&mut *COMPLAINTS.lock().unwrap_or_else(PoisonError::into_inner))
}
