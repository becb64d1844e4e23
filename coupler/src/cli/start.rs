//! Options, signals and dry runs of the verbs that start runs.

use std::path::Path;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use super::common::own_program;
use coordinator::participants::{Registry, Watch};
use coordinator::run::session::{Ended, RunOptions};
use scenario::error::Error;
use scenario::load::Loaded;
use study::forecast;

/// Options of a run that ends in order on a signal; progress needs a listener in addition.
pub(super) fn options<'a>(
    out: Option<&'a Path>,
    threads: usize,
    registry: &'a Registry,
) -> Result<RunOptions<'a>, Error> {
    Ok(RunOptions {
        threads,
        watch: listen()?,
        ..RunOptions::quiet(out, registry, &own_program()?)
    })
}

/// Runs the first windows of a scenario in a temporary folder, to predict its cost.
pub(super) fn rehearse(
    loaded: &Loaded,
    threads: usize,
    registry: &Registry,
) -> Result<Ended, Error> {
    Ok(forecast::rehearse(loaded, &options(None, threads, registry)?)?.0)
}

/// Listens for the signals that end a run in order.
pub(super) fn listen() -> Result<Watch, Error> {
    let watch = Watch::default();
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        signal_hook::flag::register_usize(signal, watch.flag(), signal as usize)
            .map_err(Error::input("listening for signals"))?;
    }
    Ok(watch)
}
