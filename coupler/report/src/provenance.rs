//! Where a run comes from, and the command that repeats it.

use super::page::table;
use super::units::{four, with_unit};
use draw::picture::escape;
use runs::files::RunFiles;

/// A table of provenance, and the command.
pub(super) fn provenance(run: &RunFiles) -> String {
    let manifest = |key: &str| match &run.manifest[key] {
        serde_json::Value::String(text) => escape(text),
        serde_json::Value::Null => String::new(),
        other => escape(&other.to_string()),
    };
    let hash = |name: &str| escape(run.summary["hashes"][name].as_str().unwrap_or_default());
    let machine = [
        manifest("host"),
        format!("{} cores", manifest("cores")),
        manifest("processor"),
    ];
    let machine: Vec<String> = machine
        .into_iter()
        .filter(|part| !part.is_empty())
        .collect();
    let transport = run.scenario.as_ref().map_or(String::new(), |scenario| {
        format!("{:?}", scenario.run.transport).to_lowercase()
    });
    let rows = [
        (
            "software",
            format!(
                "{}, build {}, git {}",
                manifest("software"),
                manifest("build"),
                manifest("git")
            ),
        ),
        (
            "scenario",
            format!(
                "{}, hash <code>{}</code>",
                manifest("scenario_file"),
                hash("scenario")
            ),
        ),
        ("seed", manifest("seed")),
        ("threads of each participant", manifest("threads")),
        ("transport", transport),
        ("machine", machine.join(", ")),
        ("run", format!("<code>{}</code>", manifest("run_id"))),
        (
            "hash of the exchange",
            format!("<code>{}</code>", hash("exchange")),
        ),
        (
            "hash of the states",
            format!("<code>{}</code>", hash("state")),
        ),
    ];
    let rows: Vec<Vec<String>> = rows
        .into_iter()
        .filter(|(_, text)| !text.is_empty())
        .map(|(name, text)| vec![name.to_string(), text])
        .collect();
    let path = run.path.join("scenario.toml");
    let threads = run.manifest["threads"].as_u64();
    let threads = threads.map_or(String::new(), |count| format!(" --threads {count}"));
    let command = format!(
        "thirdbody run {}{threads}",
        quoted(&path.display().to_string())
    );
    format!(
        "{}<p>Repeat it; the same build gives the same hashes for any number of threads:</p><pre>{}</pre>",
        table(&["", ""], &[], &rows),
        escape(&command)
    )
}

/// A word of a shell.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:@".contains(c);
    if word.chars().all(plain) {
        word.into()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Time of each process as one bar, and work with its pace.
pub(super) fn processes(run: &RunFiles) -> String {
    let rows = run.entries("participants").map(|(name, of)| {
        let number = |key: &str| of[key].as_f64().unwrap_or(0.0);
        let work = of["work"].as_object().into_iter().flatten();
        let work = work.filter(|(_, count)| count.as_f64().is_some_and(|count| count > 0.0));
        let work: Vec<String> = work
            .map(|(kind, count)| {
                format!(
                    "{} {}",
                    four(count.as_f64().unwrap_or(0.0)),
                    kind.replace('_', " ")
                )
            })
            .collect();
        vec![
            escape(name),
            escape(of["kind"].as_str().unwrap_or_default()),
            with_unit(number("cpu_s"), "s"),
            work.join(", "),
            with_unit(1e-9 * number("ns_per_work"), "s"),
            with_unit(number("peak_rss_bytes"), "B"),
        ]
    });
    let mut rows: Vec<Vec<String>> = rows.collect();
    let coordinator = &run.summary["coordinator"];
    if let (Some(cpu), Some(memory)) = (
        coordinator["cpu_s"].as_f64(),
        coordinator["peak_rss_bytes"].as_f64(),
    ) {
        rows.push(vec![
            "coordinator".into(),
            String::new(),
            with_unit(cpu, "s"),
            String::new(),
            String::new(),
            with_unit(memory, "B"),
        ]);
    }
    table(
        &[
            "process",
            "kind",
            "processor time",
            "work",
            "each",
            "memory, at most",
        ],
        &[2, 4, 5],
        &rows,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_shell_are_quoted_where_they_must_be() {
        assert_eq!(quoted("runs/a-1/scenario.toml"), "runs/a-1/scenario.toml");
        assert_eq!(quoted("it's here"), "'it'\\''s here'");
    }
}
