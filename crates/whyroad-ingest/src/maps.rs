//! Map files beside any log: OpenDRIVE and Lanelet2, given with `--map FILE`. The map replaces the log's own. It must
//! be in the frame of the log's poses; this is checked, never guessed.

mod beside;
pub(crate) mod cache;
mod findings;
mod lanelet2;
mod opendrive;
mod options;
mod signs;

pub(crate) use cache::MapBeside;
pub(crate) use findings::CODES;
pub use options::{MAP, MAP_COMPLETE, MAP_DATUM, MAP_OFFSET, MAP_ORIGIN, MAP_PROJECTION, OPTIONS};

use crate::assemble::finish::finish;
use crate::assemble::layers::Declared;
use crate::encodings::compressed;
use crate::encodings::input::Input;
use crate::file_reader::{FileReader, drive_on};
use crate::options::Options;
use crate::report::{RowCount, SourceReport};
use crate::source::{ContentHash, file_label};
use cache::Loaded;
use options::Placement;
use std::io::Read;
use std::path::Path;
use whyroad_model::{Diagnostic, RoadMap};

/// Raised when a reader makes something else of the same file, so that drives in a lake are replaced.
const REVISION: u32 = 3;
/// Bytes at the start of a file that identify its type.
const HEAD: u64 = 1 << 16;
/// Larger files are not maps of one region.
const MAX_FILE_BYTES: u64 = 4 << 30;

/// What a reader extracted from a file.
#[derive(Debug, Default)]
struct MapReading {
    map: RoadMap,
    /// Name in the file.
    name: Option<String>,
    count: RowCount,
    /// Objects, signals and the like.
    features: Option<RowCount>,
    /// Why reading stopped before the end.
    broken: Option<String>,
    /// Descriptions of what could not be used.
    invalid: Vec<String>,
    /// Lanelets of unknown subtype that are taken for road.
    untyped: Vec<String>,
    /// Links to elements missing from the file.
    dangling: Vec<String>,
}

/// Why there is no map.
#[derive(Debug)]
enum MapFault {
    Unreadable(String),
    /// Its location is unknown.
    Unplaced(String),
}

/// The map of these options, if they name one, and what is to be reported, the first time only.
pub(crate) fn of_options(options: &Options) -> (Option<&MapBeside>, Vec<Diagnostic>) {
    options.map.get(|| options.file(&MAP).map(|file| load(file, options)).unwrap_or_default())
}

/// What a file is, by its first element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MapFormat {
    OpenDrive,
    Lanelet2,
}

fn format_of(input: &Input<'_>) -> Result<MapFormat, String> {
    let size = input.open().map_err(|e| e.to_string())?.1;
    if size > MAX_FILE_BYTES {
        return Err(format!("it has {size} bytes"));
    }
    let mut head = Vec::new();
    let mut file = compressed::open(input.clone()).map_err(|e| e.to_string())?.take(HEAD);
    file.read_to_end(&mut head).map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&head);
    let at = |tag: &str| text.find(tag).unwrap_or(usize::MAX);
    match (at("<OpenDRIVE"), at("<osm")) {
        (usize::MAX, usize::MAX) => Err("it is neither OpenDRIVE nor Lanelet2 (OSM XML)".to_owned()),
        (a, b) if a < b => Ok(MapFormat::OpenDrive),
        _ => Ok(MapFormat::Lanelet2),
    }
}

fn load(file: &Path, options: &Options) -> Loaded {
    load_input(file, &file.into(), options)
}

/// The same from any input; `file` is its name.
fn load_input(file: &Path, input: &Input<'_>, options: &Options) -> Loaded {
    let label = file.display().to_string();
    let mut out = Loaded::default();
    let placement = Placement::of(options).and_then(|p| Ok((p, options::offset(options)?)));
    let (placement, offset) = match placement {
        Ok(both) => both,
        Err(problem) => {
            out.diagnostics.push(findings::placement(&label, &problem));
            return out;
        }
    };
    let read = format_of(input).map_err(MapFault::Unreadable).and_then(|format| match format {
        MapFormat::OpenDrive => opendrive::read(input.clone()).map_err(MapFault::Unreadable),
        MapFormat::Lanelet2 => lanelet2::read(input.clone(), &placement),
    });
    let mut reading = match read {
        Ok(reading) => reading,
        Err(fault) => {
            out.diagnostics.push(match fault {
                MapFault::Unreadable(reason) => findings::unreadable(&label, &reason),
                MapFault::Unplaced(reason) => findings::placement(&label, &reason),
            });
            return out;
        }
    };
    out.diagnostics.extend(findings::of_map(&label, &reading));
    if reading.map.lanes.is_empty() {
        out.diagnostics.push(findings::unreadable(&label, "it has no lanes"));
        return out;
    }
    let (declared, unknown) = options::declared(options);
    out.diagnostics.extend(unknown.iter().map(|word| findings::unknown_part(&label, word)));
    let mut hash = ContentHash::new("map", REVISION);
    placement.add_to(&mut hash);
    if declared != Declared::default() {
        declared.apply(&mut reading.map);
        hash.add("complete", format!("{declared:?}").as_bytes());
    }
    if offset != [0.0; 2] {
        shift(&mut reading.map, offset);
        hash.add("offset", format!("{offset:?}").as_bytes());
    }
    hash.add("map", &input.bytes().unwrap_or_default());
    let stem = file_label(file);
    let name = reading.name.unwrap_or_else(|| stem.split('.').next().unwrap_or(&stem).to_owned());
    let tables = std::iter::once(reading.count).chain(reading.features).collect();
    out.map = Some(MapBeside { map: reading.map, name, label, hash: hash.finish(), tables });
    out
}

/// Moves everything on a map.
fn shift(map: &mut RoadMap, [dx, dy]: [f64; 2]) {
    let RoadMap { lanes, crosswalks, junctions, drivable_areas, stop_lines, signs, facilities, .. } = map;
    let areas = crosswalks.iter_mut().chain(junctions).chain(drivable_areas).map(|a| &mut a.boundary);
    let of_lanes = lanes.iter_mut().flat_map(|l| [&mut l.left, &mut l.right, &mut l.center]);
    let lines = stop_lines.iter_mut().map(|s| &mut s.line);
    let lines = of_lanes.chain(areas).chain(lines).chain(facilities.iter_mut().map(|f| &mut f.boundary));
    for p in lines.flatten().chain(signs.iter_mut().map(|s| &mut s.position)) {
        p.x += dx;
        p.y += dy;
    }
}

/// For [`crate::readers`].
pub(crate) const READERS: &[FileReader] = &[
    FileReader { name: "map-meters", read: |bytes| beside(bytes, &Options::default()) },
    FileReader {
        name: "map-degrees",
        read: |bytes| beside(bytes, &Options::default().with(&MAP_ORIGIN, "49,8".to_owned())),
    },
];

/// Reads a map and gives it to a drive.
fn beside(bytes: &[u8], options: &Options) -> bool {
    let Some(map) = load_input(Path::new("map"), &bytes.into(), options).map else { return false };
    let (mut drive, mut report) = (drive_on(None), SourceReport::new("map".to_owned()));
    map.attach(&mut drive, &mut report);
    // The check removes a map that lies elsewhere.
    let has_lanes = drive.map.as_ref().is_some_and(|map| !map.lanes.is_empty());
    drop(finish(&mut drive));
    has_lanes
}
