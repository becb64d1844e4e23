//! Certificates of both ends, made for one run by an authority that signs nothing else and is then discarded.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rcgen::{
    BasicConstraints, CertificateParams, CertifiedIssuer, DnType, ExtendedKeyUsagePurpose, IsCa,
    KeyPair,
};
use serde_json::{Value, json};

/// Zenoh settings for the end that listens under this name or address, and for the ends that connect: each shows a certificate and asks for one.
pub fn certificates(host: &str) -> Result<[Value; 2], rcgen::Error> {
    let named = |name: &str, names: Vec<String>| {
        let mut parameters = CertificateParams::new(names)?;
        let distinguished = &mut parameters.distinguished_name;
        distinguished.push(DnType::CommonName, name);
        Ok::<_, rcgen::Error>(parameters)
    };
    let mut authority = named("authority of one run", Vec::new())?;
    authority.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    let authority = CertifiedIssuer::self_signed(authority, KeyPair::generate()?)?;
    let mut end = named("thirdbody", vec![host.into()])?;
    end.extended_key_usages = vec![
        ExtendedKeyUsagePurpose::ServerAuth,
        ExtendedKeyUsagePurpose::ClientAuth,
    ];
    let mut settings = Vec::new();
    for role in ["listen", "connect"] {
        let key = KeyPair::generate()?;
        let certificate = end.signed_by(&key, &authority)?;
        settings.push(json!({
            "enable_mtls": true,
            "root_ca_certificate_base64": STANDARD.encode(authority.pem()),
            (format!("{role}_certificate_base64")): STANDARD.encode(certificate.pem()),
            (format!("{role}_private_key_base64")): STANDARD.encode(key.serialize_pem()),
        }));
    }
    Ok(settings.try_into().expect("there are two roles"))
}
