//! The order of a log: an entry of a finished window means that a part of the file was inserted twice.

use std::collections::HashMap;

use protocol::Kind;

use super::entry::{COUPLER, Entry, Exchange};
use super::hash::is_handshake;

/// Finished windows and blocks.
#[derive(Default)]
pub(super) struct Order {
    blocks: u64,
    participants: HashMap<String, Progress>,
}

/// Windows of a participant: independent interfaces count their own windows.
#[derive(Default)]
struct Progress {
    at_hand: Option<u64>,
    over: Option<u64>,
}

impl Order {
    /// Takes the next entry, or refuses it as a repetition.
    pub(super) fn take(&mut self, entry: &Entry) -> Result<(), String> {
        match entry {
            Entry::Exchange(exchange) => self.take_exchange(exchange),
            Entry::WindowEnd(window) => self.end_block(*window),
        }
    }

    fn take_exchange(&mut self, exchange: &Exchange) -> Result<(), String> {
        let header = &exchange.frame.header;
        let (kind, window) = (Kind::from_number(header.kind), header.window);
        if matches!(kind, Some(Kind::Couple | Kind::Surface)) && self.blocks > 0 {
            return Err("the handshake is repeated".into());
        }
        if is_handshake(header.kind) {
            return Ok(());
        }
        let name = match exchange.sender.as_str() {
            COUPLER => &exchange.receiver,
            _ => &exchange.sender,
        };
        let progress = self.participants.entry(name.clone()).or_default();
        if progress.over.is_some_and(|over| window <= over) {
            return Err(format!("window {window} of `{name}` is repeated"));
        }
        progress.at_hand = Some(window);
        Ok(())
    }

    /// Ends a block. Only the first block, the handshake of a coupled run, has no window.
    fn end_block(&mut self, window: u64) -> Result<(), String> {
        let mut progressed = false;
        for progress in self.participants.values_mut() {
            if let Some(done) = progress.at_hand.take() {
                progress.over = Some(done);
                progressed = true;
            }
        }
        if !progressed && self.blocks > 0 {
            return Err(format!("the end of window {window} is repeated"));
        }
        self.blocks += 1;
        Ok(())
    }
}
