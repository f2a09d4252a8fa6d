//! The files beside an FCD: vehicle types, the network, light states; found by name or named by the user.

use super::naming::{Companion, beside, companion, run_name};
use super::net::{self, LightLink};
use super::options::{LIGHTS, NET, TYPES};
use super::vehicle_types::VehicleTypes;
use super::{findings, lights, shapes};
use crate::options::Options;
use crate::report::{RowCount, SourceReport};
use crate::source::{ContentHash, file_label};
use std::fs;
use std::io::Read;
use std::path::Path;
use whyroad_model::RoadMap;
use whyroad_model::scene::LightState;

pub(super) fn add_file(hash: &mut ContentHash, path: &Path) {
    // Unreadable files are reported where they are read; here they only change the hash.
    let mut bytes = Vec::new();
    let _ = fs::File::open(path).and_then(|mut f| f.read_to_end(&mut bytes));
    hash.add(&file_label(path), &bytes);
}

pub(super) fn read_types(
    fcd: &Path,
    options: &Options,
    hash: &mut ContentHash,
    report: &mut SourceReport,
) -> VehicleTypes {
    let given = options.files(&TYPES);
    let files = if given.is_empty() { beside(fcd, &["rou", "add"]) } else { given };
    let mut types = VehicleTypes::default();
    for file in files {
        add_file(hash, &file);
        if let Err(reason) = types.read(file.as_path().into()) {
            report.diagnostics.push(findings::type_unreadable(&file.display().to_string(), &reason));
        }
    }
    types
}

/// The map, what its lights control, and its name.
pub(super) type NetParts = (RoadMap, Vec<LightLink>, String);

pub(super) fn read_net(
    fcd: &Path,
    options: &Options,
    hash: &mut ContentHash,
    report: &mut SourceReport,
) -> Option<NetParts> {
    let place = fcd.display().to_string();
    let found = options.file(&NET).map_or_else(|| companion(fcd, "net"), |p| Companion::File(p.to_owned()));
    let file = match found {
        Companion::File(file) => file,
        Companion::None => {
            report.diagnostics.push(findings::net_missing(&place));
            return None;
        }
        Companion::Several(files) => {
            report.diagnostics.push(findings::ambiguous("sumo.net.ambiguous", "--net", &place, &files));
            return None;
        }
    };
    let label = file.display().to_string();
    add_file(hash, &file);
    match net::read(file.as_path().into()) {
        Ok(mut net) => {
            report.diagnostics.extend(findings::of_net(&label, &net));
            report.tables.push(std::mem::take(&mut net.count));
            read_shapes(fcd, &mut net.map, hash, report);
            let name = run_name(&file);
            // `net.xml` in a folder of its own is the folder's network.
            let name = if name == "net" {
                file.canonicalize().ok().and_then(|p| Some(file_label(p.parent()?))).unwrap_or(name)
            } else {
                name
            };
            Some((net.map, net.links, name.trim_end_matches(".net").to_owned()))
        }
        Err(reason) => {
            report.diagnostics.push(findings::net_unreadable(&label, &reason));
            None
        }
    }
}

/// Buildings, other facilities and signs from additional files beside the FCD or one folder up.
fn read_shapes(fcd: &Path, map: &mut RoadMap, hash: &mut ContentHash, report: &mut SourceReport) {
    let mut count = RowCount::new("shapes");
    for file in beside(fcd, &["poly", "add"]) {
        add_file(hash, &file);
        if let Err(reason) = shapes::read(file.as_path().into(), map, &mut count) {
            report.diagnostics.push(findings::shapes_unreadable(&file.display().to_string(), &reason));
        }
    }
    if count.read > 0 {
        report.tables.push(count);
    }
}

pub(super) fn read_lights(
    fcd: &Path,
    options: &Options,
    links: &[LightLink],
    hash: &mut ContentHash,
    report: &mut SourceReport,
) -> Option<Vec<LightState>> {
    let found =
        options.file(&LIGHTS).map_or_else(|| companion(fcd, "tls"), |p| Companion::File(p.to_owned()));
    let file = match found {
        // In the folder above lie those of other runs.
        Companion::File(file) if options.is_set(&LIGHTS) || file.parent() == fcd.parent() => file,
        Companion::Several(files) if files.iter().any(|p| p.parent() == fcd.parent()) => {
            let place = fcd.display().to_string();
            report.diagnostics.push(findings::ambiguous("sumo.lights.ambiguous", "--lights", &place, &files));
            return None;
        }
        _ => return None,
    };
    add_file(hash, &file);
    match lights::read(file.as_path().into(), links, options.start()) {
        Ok(states) => Some(states),
        Err(reason) => {
            report.diagnostics.push(findings::lights_unreadable(&file.display().to_string(), &reason));
            None
        }
    }
}
