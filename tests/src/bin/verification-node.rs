//! A foreign participant for tests: `verification-node bar|chain|plate`, launched by a scenario's `command`;
//! `verification-node other-version` answers the greeting in a protocol of another version.

use std::error::Error;
use std::process::ExitCode;
use std::time::Duration;

use protocol::link::shm::ShmLink;
use protocol::{Frame, Header, Kind, Link, Transport};

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
    match protocol::participate(solver.build) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("verification-node: {error}");
            ExitCode::from(4)
        }
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
