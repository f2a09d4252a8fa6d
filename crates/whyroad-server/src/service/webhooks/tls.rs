//! TLS to receivers at `https://` addresses: trusted certificates, and a connection whose receiver has proved its
//! identity.

use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use std::io::{Read, Write};
use std::sync::{Arc, OnceLock};
use whyroad_model::Bilingual;

/// Trusted certificates: those of the system (`SSL_CERT_FILE` can replace them), and additional ones.
#[derive(Debug, Default)]
pub struct Trust {
    more: Vec<CertificateDer<'static>>,
    /// Created when the first `https://` receiver is called: reading a system's certificates takes a while.
    config: OnceLock<Arc<ClientConfig>>,
}

impl Trust {
    /// The system's certificates and these.
    pub fn with(more: Vec<CertificateDer<'static>>) -> Self {
        Self { more, config: OnceLock::new() }
    }

    fn config(&self) -> Result<Arc<ClientConfig>, Bilingual> {
        if let Some(config) = self.config.get() {
            return Ok(Arc::clone(config));
        }
        let mut roots = RootCertStore::empty();
        roots.add_parsable_certificates(rustls_native_certs::load_native_certs().certs);
        roots.add_parsable_certificates(self.more.iter().cloned());
        let provider = Arc::new(rustls::crypto::ring::default_provider());
        let config = ClientConfig::builder_with_provider(provider)
            .with_safe_default_protocol_versions()
            .map_err(|e| Bilingual::new(format!("无法使用 TLS：{e}"), format!("TLS cannot be used: {e}")))?
            .with_root_certificates(roots)
            .with_no_client_auth();
        Ok(Arc::clone(self.config.get_or_init(|| Arc::new(config))))
    }

    /// A connection to `host` on `stream`. The handshake is done with the first bytes.
    pub(super) fn secure<S: Read + Write>(
        &self,
        stream: S,
        host: &str,
    ) -> Result<StreamOwned<ClientConnection, S>, Bilingual> {
        let odd =
            |why: String| Bilingual::new(format!("主机名无效：{why}"), format!("the host is invalid: {why}"));
        let name = ServerName::try_from(host.to_owned()).map_err(|e| odd(e.to_string()))?;
        let connection = ClientConnection::new(self.config()?, name).map_err(|e| odd(e.to_string()))?;
        Ok(StreamOwned::new(connection, stream))
    }
}
