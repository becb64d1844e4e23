//! The run that a log belongs to, as a metadata record and as attachments.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use mcap::records::{Metadata, Record, op};
use mcap::{Attachment, McapError, Writer};

use super::hash::add_text;
use super::lengths::parse;

/// The name and version of this format, in the metadata of every log.
pub const FORMAT: &str = "thirdbody.exchange/1";

/// The run that a log belongs to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// The resolved scenario, TOML.
    pub scenario_toml: String,
    /// The text of manifest.json: versions, seeds, host.
    pub manifest_json: String,
    /// The run id of all frames.
    pub run_id: u64,
}

/// Name of the metadata record, and its keys.
const PROVENANCE: &str = "thirdbody.provenance";
const FORMAT_KEY: &str = "format";
const RUN_ID_KEY: &str = "run_id";
const SCENARIO_KEY: &str = "scenario.toml";
const MANIFEST_KEY: &str = "manifest.json";
const HASH_KEY: &str = "hash";

/// Writes the provenance as metadata for our reader and as attachments for other tools.
pub(super) fn write<W: Write + Seek>(
    writer: &mut Writer<W>,
    provenance: &Provenance,
) -> Result<(), McapError> {
    let texts = [
        (SCENARIO_KEY, "application/toml", &provenance.scenario_toml),
        (MANIFEST_KEY, "application/json", &provenance.manifest_json),
    ];
    let metadata = texts.map(|(key, _, text)| (key.to_string(), text.clone()));
    let mut metadata = BTreeMap::from(metadata);
    metadata.insert(FORMAT_KEY.into(), FORMAT.into());
    metadata.insert(RUN_ID_KEY.into(), format!("{:016x}", provenance.run_id));
    metadata.insert(HASH_KEY.into(), provenance_hash(&metadata));
    writer.write_metadata(&Metadata {
        name: PROVENANCE.into(),
        metadata,
    })?;
    for (name, media_type, text) in texts {
        writer.attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: name.into(),
            media_type: media_type.into(),
            data: text.as_bytes().into(),
        })?;
    }
    Ok(())
}

/// The provenance of a metadata record.
pub(super) fn read(data: &[u8]) -> Result<Provenance, String> {
    let Record::Metadata(mut record) = parse(op::METADATA, data)? else {
        return Err("it has no metadata record".into());
    };
    if record.name != PROVENANCE {
        return Err(format!("its metadata is `{}`", record.name));
    }
    let hash = provenance_hash(&record.metadata);
    let mut take = |key: &str| {
        let value = record.metadata.remove(key);
        value.ok_or_else(|| format!("its metadata has no `{key}`"))
    };
    let format = take(FORMAT_KEY)?;
    if format != FORMAT {
        return Err(format!("its format is `{format}`, this is `{FORMAT}`"));
    }
    if take(HASH_KEY)? != hash {
        return Err("its metadata does not match its hash: the file is damaged".into());
    }
    let run_id = take(RUN_ID_KEY)?;
    Ok(Provenance {
        run_id: u64::from_str_radix(&run_id, 16)
            .map_err(|_| format!("`{run_id}` is not the number of a run"))?,
        scenario_toml: take(SCENARIO_KEY)?,
        manifest_json: take(MANIFEST_KEY)?,
    })
}

/// blake3 over keys and values, each after its length, without the hash itself. Metadata has no checksum in MCAP, and after a killed
/// writer the file has none.
fn provenance_hash(metadata: &BTreeMap<String, String>) -> String {
    let mut hasher = blake3::Hasher::new();
    for (key, value) in metadata.iter().filter(|(key, _)| *key != HASH_KEY) {
        add_text(&mut hasher, key);
        add_text(&mut hasher, value);
    }
    hasher.finalize().to_hex().to_string()
}
