//! Zenoh's warnings about connections: programs that it refused, and hosts that it cannot reach.

use std::sync::{Mutex, PoisonError};

/// Most warnings that are kept: an unknown program may cause any number.
const KEPT: usize = 20;

static COMPLAINTS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// From now on zenoh's warnings go to `hear`, unless this process already listens to zenoh elsewhere.
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

/// Zenoh's message without the position in its sources at the end, which helps no user.
pub(crate) fn without_place(said: &str) -> String {
    said.split(" at /").next().unwrap_or_default().into()
}

/// Keeps a warning until it is taken.
pub(crate) fn keep(said: String) {
    let mut kept = COMPLAINTS.lock().unwrap_or_else(PoisonError::into_inner);
    if kept.len() < KEPT && !kept.contains(&said) {
        kept.push(said);
    }
}

/// The kept warnings.
pub(crate) fn take() -> Vec<String> {
    std::mem::take(&mut *COMPLAINTS.lock().unwrap_or_else(PoisonError::into_inner))
}
