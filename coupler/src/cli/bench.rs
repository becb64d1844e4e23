//! `thirdbody bench`: what the machine gives.

use clap::Subcommand;

use super::{VerbResult, print};
use crate::bench::exchange;
use crate::error::Error;

/// Arguments of `bench`.
#[derive(Debug, clap::Args)]
pub struct BenchArguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Time from a request of the coupler to the answer of a node, over shared memory.
    Exchange {
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// The other end of `exchange`.
    #[command(hide = true)]
    Echo,
}

/// Measures, and prints a table or JSON.
pub fn bench(arguments: &BenchArguments) -> VerbResult {
    match arguments.what {
        What::Exchange { json } => {
            let rows = exchange::measure()?;
            match json {
                true => print(&exchange::json(&rows)),
                false => print(&exchange::table(&rows)),
            }
        }
        What::Echo => exchange::echo().map_err(|error| Error::Refused(error.to_string()))?,
    }
    Ok(0)
}
