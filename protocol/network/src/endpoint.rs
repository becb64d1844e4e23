//! The address where the coordinator listens.

use std::net::{IpAddr, TcpListener, UdpSocket};

/// Protocol, host and port of an endpoint, written `quic/192.168.7.1:7447`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Endpoint {
    /// `quic` or `tcp`.
    pub protocol: String,
    /// Name or address of the host.
    pub host: String,
    /// Port; 0 for any free port.
    pub port: u16,
}

impl Endpoint {
    /// Reads an endpoint; the error says what is wrong with the text.
    pub fn read(text: &str) -> Result<Endpoint, String> {
        let form = || {
            format!(
                "`{text}` must be written protocol/host:port with the protocol quic or, on loopback, tcp, for instance quic/192.168.7.1:7447"
            )
        };
        // zenoh reads and writes such a connection in two threads at a time, which rustls does not allow: zenoh issue 2557.
        if text.starts_with("tls/") {
            return Err(format!(
                "`{text}`: TLS over TCP makes processes crash in zenoh 1.10 when both ends send; quic/ encrypts and asks for certificates as well"
            ));
        }
        let (protocol, address) = text.split_once('/').ok_or_else(form)?;
        let (host, port) = address.rsplit_once(':').ok_or_else(form)?;
        let bare = host
            .strip_prefix('[')
            .and_then(|host| host.strip_suffix(']'));
        let host = bare.unwrap_or(host);
        let sound =
            |c: char| c.is_ascii_alphanumeric() || ".-".contains(c) || (bare.is_some() && c == ':');
        let known = ["tcp", "quic"].contains(&protocol);
        if !known || host.is_empty() || !host.chars().all(sound) {
            return Err(form());
        }
        Ok(Endpoint {
            protocol: protocol.into(),
            host: host.into(),
            port: port.parse().map_err(|_| form())?,
        })
    }

    /// True for an address that only this host reaches.
    pub fn is_loopback(&self) -> bool {
        let address = self.host.parse::<IpAddr>();
        self.host == "localhost" || address.is_ok_and(|address| address.is_loopback())
    }

    /// True for an address that stands for all addresses of this host; no other host can connect to it.
    pub fn is_unspecified(&self) -> bool {
        let address = self.host.parse::<IpAddr>();
        address.is_ok_and(|address| address.is_unspecified())
    }

    /// True for a protocol that encrypts.
    pub fn is_encrypted(&self) -> bool {
        self.protocol != "tcp"
    }

    /// This endpoint with a port that is free now, if its port is 0.
    pub fn with_port(mut self) -> Result<Endpoint, String> {
        if self.port == 0 {
            let address = (self.host.as_str(), 0);
            let bound = match &*self.protocol {
                "quic" => UdpSocket::bind(address).and_then(|socket| socket.local_addr()),
                _ => TcpListener::bind(address).and_then(|socket| socket.local_addr()),
            };
            let bound = bound.map_err(|error| format!("{}: {error}", self.text()))?;
            self.port = bound.port();
        }
        Ok(self)
    }

    /// Its text.
    pub fn text(&self) -> String {
        let mut host = self.host.clone();
        if host.contains(':') {
            host = format!("[{host}]");
        }
        format!("{}/{host}:{}", self.protocol, self.port)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_endpoint_is_a_protocol_a_host_and_a_port() {
        for text in [
            "tcp/127.0.0.1:0",
            "quic/login-1.cluster:7447",
            "quic/[::1]:80",
        ] {
            assert_eq!(
                Endpoint::read(text).map(|endpoint| endpoint.text()),
                Ok(text.into())
            );
        }
        // Text that zenoh would read as settings of the connection is refused.
        for text in [
            "",
            "tcp",
            "udp/a:1",
            "tcp/:1",
            "tcp/a",
            "tcp/a:70000",
            "tls/a:1",
            "quic/a:1#b=c",
            "quic/a?b=c:1",
            "tcp/::1:80",
        ] {
            assert!(Endpoint::read(text).is_err(), "{text}");
        }
    }

    #[test]
    fn only_this_host_reaches_a_loopback_address() {
        let endpoint = |host: &str| Endpoint::read(&format!("tcp/{host}:1")).expect("it is one");
        for host in ["localhost", "127.0.0.1", "127.1.2.3", "[::1]"] {
            assert!(endpoint(host).is_loopback(), "{host}");
        }
        for host in ["0.0.0.0", "[::]", "192.168.7.1", "host"] {
            assert!(!endpoint(host).is_loopback(), "{host}");
        }
        assert!(endpoint("0.0.0.0").is_unspecified() && endpoint("[::]").is_unspecified());
    }
}
