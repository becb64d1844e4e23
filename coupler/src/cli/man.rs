//! `thirdbody man`: manual pages.

use std::fs;
use std::path::PathBuf;

use clap_mangen::{Man, generate_to};

use super::common::{VerbResult, print};
use scenario::error::Error;

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
pub struct ManArguments {
    /// Folder for one page per verb (default: print the main page on stdout).
    dir: Option<PathBuf>,
}

/// Prints the main page of a command, or writes all pages.
pub fn man(arguments: &ManArguments, command: clap::Command) -> VerbResult {
    let Some(folder) = &arguments.dir else {
        let mut page = Vec::new();
        let rendered = Man::new(command).render(&mut page);
        rendered.map_err(Error::output("the manual page"))?;
        return print(String::from_utf8_lossy(&page).trim_end());
    };
    fs::create_dir_all(folder)
        .and_then(|()| generate_to(command, folder))
        .map_err(Error::output(folder.display()))?;
    print(&format!("man -l {}", folder.join("thirdbody.1").display()))
}
