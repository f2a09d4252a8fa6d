//! Addresses to which webhooks may connect. A project lead enters an address, and the *service* connects to it from
//! inside its network, which may have access to more than the lead's own computer. So addresses are checked after name
//! resolution, at each delivery, and the connection uses exactly the address that was checked.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};

/// Addresses to which webhooks may connect.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Reach {
    /// All addresses, including this machine itself: for a service that only this machine can reach.
    #[default]
    OwnMachine,
    /// All addresses except this machine: for a service that others can reach, who must not get access to services that
    /// listen here only for this machine.
    Network,
    /// Only these hosts: `host` for all its ports, or `host:port`, as written in an address.
    Only(Vec<String>),
}

/// Metadata services of clouds at addresses that are not link-local: AWS over IPv6, Alibaba, Oracle.
const SECRETS: [IpAddr; 3] = [
    IpAddr::V6(Ipv6Addr::new(0xfd00, 0xec2, 0, 0, 0, 0, 0, 0x254)),
    IpAddr::V4(Ipv4Addr::new(100, 100, 100, 200)),
    IpAddr::V4(Ipv4Addr::new(192, 0, 0, 192)),
];

impl Reach {
    /// Whether a message to `host` and `port` may be sent to `ip`, to which the host's name was resolved.
    pub fn allows(&self, host: &str, port: u16, ip: IpAddr) -> bool {
        let ip = plain(ip);
        match self {
            // The operator of the service has listed it.
            Self::Only(hosts) => hosts.iter().any(|h| *h == host || *h == format!("{host}:{port}")),
            Self::OwnMachine => !is_never_receiver(ip),
            Self::Network => !is_never_receiver(ip) && !ip.is_loopback(),
        }
    }
}

/// The destination of packets to `ip`: an IPv6 address may only wrap an IPv4 address.
fn plain(ip: IpAddr) -> IpAddr {
    let IpAddr::V6(v6) = ip.to_canonical() else { return ip.to_canonical() };
    let s = v6.segments();
    let v4 = |high: u16, low: u16| IpAddr::V4(Ipv4Addr::from((u32::from(high) << 16) | u32::from(low)));
    match s {
        // IPv4-compatible (RFC 4291 2.5.5.1), but not `::` and `::1`.
        [0, 0, 0, 0, 0, 0, high, low] if (high, low) != (0, 0) && (high, low) != (0, 1) => v4(high, low),
        // NAT64, well-known and local prefixes (RFC 6052, RFC 8215).
        [0x64, 0xff9b, 0, 0, 0, 0, high, low] | [0x64, 0xff9b, 1, _, _, _, high, low] => v4(high, low),
        // 6to4 (RFC 3056).
        [0x2002, high, low, ..] => v4(high, low),
        _ => IpAddr::V6(v6),
    }
}

/// Addresses that are never receivers: link-local (metadata services of clouds), multicast, unspecified.
fn is_never_receiver(ip: IpAddr) -> bool {
    let link_local = match ip {
        IpAddr::V4(v4) => v4.is_link_local() || v4.is_broadcast() || v4.octets()[0] == 0,
        IpAddr::V6(v6) => v6.is_unicast_link_local(),
    };
    link_local || ip.is_multicast() || ip.is_unspecified() || SECRETS.contains(&ip)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reached(reach: &Reach, ip: &str) -> bool {
        reach.allows("h", 80, ip.parse().unwrap())
    }

    #[test]
    fn what_is_nobodys_receiver_is_never_called_and_this_machine_only_by_itself() {
        for ip in [
            "169.254.169.254",
            "::ffff:169.254.169.254",
            "fe80::1",
            "0.0.0.0",
            "::",
            "0.1.2.3",
            "224.0.0.1",
            "ff02::1",
            "255.255.255.255",
            "fd00:ec2::254",
            "100.100.100.200",
            "64:ff9b::169.254.169.254",
            "64:ff9b:1::169.254.169.254",
            "::169.254.169.254",
            "2002:a9fe:a9fe::1",
        ] {
            assert!(!reached(&Reach::OwnMachine, ip) && !reached(&Reach::Network, ip), "{ip}");
        }
        for ip in [
            "127.0.0.1",
            "127.9.9.9",
            "::1",
            "::ffff:127.0.0.1",
            "::127.0.0.1",
            "64:ff9b::127.0.0.1",
            "2002:7f00:1::",
        ] {
            assert!(reached(&Reach::OwnMachine, ip) && !reached(&Reach::Network, ip), "{ip}");
        }
        for ip in ["10.1.2.3", "192.168.0.9", "fd12::1", "93.184.216.34", "2606:2800::1"] {
            assert!(reached(&Reach::OwnMachine, ip) && reached(&Reach::Network, ip), "{ip}");
        }
    }

    #[test]
    fn named_hosts_are_the_only_ones() {
        let only = Reach::Only(vec!["ci".into(), "127.0.0.1:9000".into()]);
        let may = |host: &str, port| only.allows(host, port, IpAddr::V4(Ipv4Addr::LOCALHOST));
        assert!(may("ci", 80) && may("ci", 8080) && may("127.0.0.1", 9000));
        assert!(!may("127.0.0.1", 9001) && !may("ci.evil", 80) && !may("localhost", 9000));
    }
}
