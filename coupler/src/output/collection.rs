//! `fields/<participant>.pvd`: the snapshots of a participant over time, as ParaView opens them.

use std::path::Path;

/// A moment at which the participants wrote their fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Name of the snapshot.
    pub name: String,
    /// Simulated time (s).
    pub time_s: f64,
}

/// The collection of a participant, of those moments at which `fields` holds a file of it; `None` without any.
pub fn pvd(fields: &Path, participant: &str, moments: &[Moment]) -> Option<String> {
    let mut sets = String::new();
    for moment in moments {
        let stem = format!("{participant}-{}", moment.name);
        let files = ["vtu", "vtp"].map(|extension| format!("{stem}.{extension}"));
        let time_s = moment.time_s;
        if let Some(file) = files.iter().find(|file| fields.join(file).exists()) {
            let set = format!("<DataSet timestep=\"{time_s:e}\" part=\"0\" file=\"{file}\"/>\n");
            sets.push_str(&set);
        }
    }
    (!sets.is_empty()).then(|| {
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n{sets}</Collection>\n</VTKFile>\n"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rundir::Scratch;

    #[test]
    fn only_files_that_exist_are_listed() {
        let scratch = Scratch::new("pvd", 1);
        std::fs::create_dir_all(scratch.path()).expect("a folder");
        let moments = ["hold", "cycling", "end"].map(|name| Moment {
            name: name.into(),
            time_s: 0.5,
        });
        assert_eq!(pvd(scratch.path(), "rail", &moments), None);
        for file in ["rail-hold.vtu", "grains-end.vtp"] {
            std::fs::write(scratch.path().join(file), "").expect("a file");
        }
        let rail = pvd(scratch.path(), "rail", &moments).expect("one file");
        assert!(rail.contains("timestep=\"5e-1\" part=\"0\" file=\"rail-hold.vtu\""));
        assert!(!rail.contains("rail-end"));
        let grains = pvd(scratch.path(), "grains", &moments).expect("one file");
        assert_eq!(grains.matches("<DataSet").count(), 1);
    }
}
