//! A foreign participant for tests: `verification-node bar|chain|plate`, launched by a scenario's `command`;
//! `verification-node bar FIELD` answers with this field of the header wrong;
//! `verification-node other-version` answers the greeting in another version of the protocol.

use std::error::Error;
use std::process::ExitCode;
use std::time::Duration;

use coordinator::participants::ShippedSolver;
use protocol::link::shm::ShmLink;
use protocol::{Frame, Header, Kind, Link, LinkError, Transport};

fn main() -> ExitCode {
    let kind = std::env::args().nth(1).unwrap_or_default();
    if kind == "other-version" {
        return match answer_in_another_version() {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("verification-node: {error}");
                ExitCode::FAILURE
            }
        };
    }
    let registry = harness::registry();
    let Some(solver) = registry.get(&kind) else {
        eprintln!("verification-node: no solver of kind `{kind}`");
        return ExitCode::from(2);
    };
    let served: Result<(), Box<dyn Error>> = match std::env::args().nth(2) {
        None => protocol::participate(solver.build).map_err(Into::into),
        Some(field) => serve_misframed(solver, field),
    };
    match served {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("verification-node: {error}");
            ExitCode::from(4)
        }
    }
}

/// Serves a solver whose answers to windows have one field of their header wrong.
fn serve_misframed(solver: &ShippedSolver, field: String) -> Result<(), Box<dyn Error>> {
    let session = protocol::participate::read_session()?;
    let Transport::Shm { root, prefix } = &session.transport else {
        return Err("no shared memory".into());
    };
    let name = &session.setting.participant;
    let mut link = Misframed {
        link: ShmLink::participant(root, prefix, name, Duration::from_secs(10))?,
        field,
        turn: 0,
    };
    Ok(protocol::serve(&session, &mut link, solver.build)?)
}

struct Misframed {
    link: ShmLink,
    field: String,
    turn: u64,
}

impl Link for Misframed {
    fn send(&mut self, frame: &Frame, patience: Duration) -> Result<(), LinkError> {
        let mut frame = frame.clone();
        let turn = self.turn;
        self.turn += 1;
        if frame.kind().is_ok_and(|kind| kind == Kind::Motion) {
            let _ = frame.open(turn);
            let header = &mut frame.header;
            match self.field.as_str() {
                "t0" => header.t0_s += 1.0,
                "t1" => header.t1_s += 1.0,
                "step" => header.step += 1,
                "substeps" => header.substeps += 1,
                "window" => header.window += 1,
                "iteration" => header.iteration += 1,
                "interface" => header.interface += 1,
                _ => {}
            }
            let late = u64::from(self.field == "turn");
            frame.stamp(turn + late);
        }
        self.link.send(&frame, patience)
    }

    fn receive(&mut self, patience: Duration) -> Result<Option<Frame>, LinkError> {
        self.link.receive(patience)
    }
}

fn answer_in_another_version() -> Result<(), Box<dyn Error>> {
    let session = protocol::participate::read_session()?;
    let Transport::Shm { root, prefix } = &session.transport else {
        return Err("no shared memory".into());
    };
    let patience = Duration::from_secs(10);
    let mut link = ShmLink::participant(root, prefix, &session.setting.participant, patience)?;
    link.receive(patience)?;
    let header = Header {
        protocol: 77,
        run_id: session.run_id,
        ..Header::of(Kind::Welcome)
    };
    link.send(&Frame::new(header, vec![1.0, 2.0]), patience)?;
    // The coordinator ends this process once it has read the answer.
    std::thread::sleep(patience);
    Ok(())
}
