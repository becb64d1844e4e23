//! Certificates of both ends, and user and password.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rcgen::{
    BasicConstraints, CertificateParams, CertifiedIssuer, DnType, ExtendedKeyUsagePurpose, IsCa,
    KeyPair,
};
use serde_json::{Value, json};

/// Files with certificates (PEM) that both ends show each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CertificateFiles {
    /// Certificate of the authority that has signed the other one.
    pub authority: PathBuf,
    /// Certificate, for the host name or address that participants connect to.
    pub certificate: PathBuf,
    /// Its private key, which only its owner may read.
    pub private_key: PathBuf,
}

/// Certificates and a private key (PEM).
pub struct Certificates {
    authority: String,
    certificate: String,
    private_key: String,
}

impl Certificates {
    /// Reads them.
    pub fn read(files: &CertificateFiles) -> Result<Certificates, String> {
        Ok(Certificates {
            authority: text(&files.authority)?,
            certificate: text(&files.certificate)?,
            private_key: secret(&files.private_key)?,
        })
    }

    /// Makes them for one run, of an authority that signs nothing else and is forgotten.
    pub fn made_for(host: &str) -> Result<Certificates, rcgen::Error> {
        let named = |name: &str, names: Vec<String>| {
            let mut parameters = CertificateParams::new(names)?;
            let distinguished = &mut parameters.distinguished_name;
            distinguished.push(DnType::CommonName, name);
            Ok::<_, rcgen::Error>(parameters)
        };
        let mut authority = named("authority of one run", Vec::new())?;
        authority.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        let authority = CertifiedIssuer::self_signed(authority, KeyPair::generate()?)?;
        let mut both_ends = named("thirdbody", vec![host.into()])?;
        both_ends.extended_key_usages = vec![
            ExtendedKeyUsagePurpose::ServerAuth,
            ExtendedKeyUsagePurpose::ClientAuth,
        ];
        let key = KeyPair::generate()?;
        Ok(Certificates {
            authority: authority.pem(),
            certificate: both_ends.signed_by(&key, &authority)?.pem(),
            private_key: key.serialize_pem(),
        })
    }

    /// The settings of zenoh that show and ask for them: of the end that listens, or of one that connects.
    pub fn settings(&self, listens: bool) -> Value {
        let role = if listens { "listen" } else { "connect" };
        let text = |pem: &String| STANDARD.encode(pem);
        json!({
            "enable_mtls": true,
            "root_ca_certificate_base64": text(&self.authority),
            (format!("{role}_certificate_base64")): text(&self.certificate),
            (format!("{role}_private_key_base64")): text(&self.private_key),
        })
    }
}

/// The settings of zenoh that ask for the `user:password` of this file, and those that show it.
pub fn password(file: &Path) -> Result<[Value; 2], String> {
    let text = secret(file)?;
    let line = text.trim_end_matches(['\n', '\r']);
    let parts = line.split_once(':');
    let sound = |(user, password): &(&str, &str)| {
        !user.is_empty() && !password.is_empty() && !line.contains('\n')
    };
    let (user, word) = parts
        .filter(sound)
        .ok_or_else(|| format!("{}: must hold one line, user:password", file.display()))?;
    let shown = json!({ "user": user, "password": word });
    let mut asked = shown.clone();
    asked["dictionary_file"] = json!(file);
    Ok([asked, shown])
}

fn text(file: &Path) -> Result<String, String> {
    fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))
}

/// The text of a file that nobody but its owner may read.
fn secret(file: &Path) -> Result<String, String> {
    let shown = file.display();
    let held = fs::metadata(file).map_err(|error| format!("{shown}: {error}"))?;
    let mode = held.permissions().mode() & 0o777;
    if mode & 0o077 != 0 {
        return Err(format!(
            "{shown} is a secret that others may read (mode {mode:04o}): chmod 600 {shown}"
        ));
    }
    text(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_secret_that_others_may_read_is_refused() {
        let file = std::env::temp_dir().join(format!("thirdbody-password-{}", std::process::id()));
        let held = |text: &str, mode: u32| {
            fs::write(&file, text).expect("it is written");
            fs::set_permissions(&file, fs::Permissions::from_mode(mode)).expect("it is ours");
            password(&file)
        };
        let [asked, shown] = held("anna:se:cret\n", 0o600).expect("it is one");
        assert_eq!(shown, json!({ "user": "anna", "password": "se:cret" }));
        assert_eq!(asked["dictionary_file"], json!(file));
        assert!(held("anna:secret\n", 0o640).is_err_and(|why| why.contains("0640")));
        for text in ["", "anna", ":secret", "anna:", "anna:secret\nbert:secret\n"] {
            assert!(held(text, 0o600).is_err(), "{text}");
        }
        fs::remove_file(&file).expect("it is there");
    }
}
