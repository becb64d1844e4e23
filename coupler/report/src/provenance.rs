//! The origin of a run, and the command that repeats it.

use serde_json::Value;

use super::page::table;
use draw::svg::escape;
use draw::units::{four, with_unit};
use runs::files::RunFiles;

/// The keys that were set for the run, one per line: the value, and the value in the scene.
pub(super) fn changed(run: &RunFiles) -> Vec<String> {
    let shown = |value: Option<String>| value.unwrap_or("not given".into());
    let changed = run.changed().into_iter();
    let line = |(key, [before, now]): (String, [Option<String>; 2])| {
        format!("{key} = {} (was {})", shown(now), shown(before))
    };
    changed.map(line).collect()
}

/// A table of provenance, and the command.
pub(super) fn provenance(run: &RunFiles) -> String {
    let keys = run.manifest();
    let manifest = |key: &str| match &keys[key] {
        Value::String(text) => escape(text),
        Value::Null => String::new(),
        other => escape(&other.to_string()),
    };
    let code = |text: &str| format!("<code>{text}</code>");
    let hash = |name: &str| code(&escape(run.hash(name).unwrap_or_default()));
    let [software, build, git] = ["software", "build", "git"].map(manifest);
    let [host, cores, processor] = ["host", "cores", "processor"].map(manifest);
    let scene = format!("{}, hash {}", manifest("scenario_file"), hash("scenario"));
    let mut machine = vec![host, format!("{cores} cores"), processor];
    machine.retain(|part| !part.is_empty());
    let transport = match run.path.join("scenario.toml").exists() {
        true => format!("{:?}", run.scenario().transport).to_lowercase(),
        false => String::new(),
    };
    let rows = [
        ("software", format!("{software}, build {build}, git {git}")),
        ("scenario", scene),
        ("seed", manifest("seed")),
        ("threads of each participant", manifest("threads")),
        ("transport", transport),
        ("machine", machine.join(", ")),
        ("run", code(&manifest("run_id"))),
        ("hash of the exchange", hash("exchange")),
        ("hash of the states", hash("state")),
    ];
    let rows = rows.into_iter().filter(|(_, text)| !text.is_empty());
    let threads = keys["threads"].as_u64();
    let threads = threads.map_or(String::new(), |count| format!(" --threads {count}"));
    let file = scenario_file(run);
    format!(
        "{}<p>To repeat the run (the same build gives the same hashes for any number of threads):</p><pre>{}</pre>",
        table(["", ""], &[], rows.map(|(name, text)| [name.into(), text])),
        escape(&format!("thirdbody run {file}{threads}"))
    )
}

/// The run's copy of its scenario, as a word of a shell.
pub(super) fn scenario_file(run: &RunFiles) -> String {
    // A name such as runs/latest points at another run later.
    let path = run.path.canonicalize().unwrap_or_else(|_| run.path.clone());
    quoted(&path.join("scenario.toml").display().to_string())
}

/// A word of a shell.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:@".contains(c);
    if word.chars().all(plain) {
        word.into()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Processor time, memory, work and time per unit of work, for each process.
pub(super) fn processes(run: &RunFiles) -> String {
    let number = |of: &Value, key: &str| of[key].as_f64().unwrap_or(0.0);
    let rows = run.entries("participants").map(|(name, of)| {
        let work = of["work"].as_object().into_iter().flatten();
        let work = work.filter_map(|(kind, count)| Some((kind, count.as_f64()?)));
        let work = work.filter(|(_, count)| *count > 0.0);
        let work = work.map(|(kind, count)| format!("{} {}", four(count), kind.replace('_', " ")));
        [
            escape(name),
            escape(of["kind"].as_str().unwrap_or_default()),
            with_unit(number(of, "cpu_s"), "s"),
            Vec::from_iter(work).join(", "),
            with_unit(1e-9 * number(of, "ns_per_work"), "s"),
            with_unit(number(of, "peak_rss_bytes"), "B"),
        ]
    });
    let coordinator = ["coordinator.cpu_s", "coordinator.peak_rss_bytes"];
    let coordinator = match coordinator.map(|path| run.number(path)) {
        [Some(cpu), Some(memory)] => {
            let [cpu, memory] = [with_unit(cpu, "s"), with_unit(memory, "B")];
            let none = String::new;
            Some(["coordinator".into(), none(), cpu, none(), none(), memory])
        }
        _ => None,
    };
    let [time, memory] = ["processor time", "memory, at most"];
    let head = ["process", "kind", time, "work", "each", memory];
    table(head, &[2, 4, 5], rows.chain(coordinator))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_shell_are_quoted_if_they_need_it() {
        assert_eq!(quoted("runs/a-1/scenario.toml"), "runs/a-1/scenario.toml");
        assert_eq!(quoted("it's here"), "'it'\\''s here'");
    }
}
