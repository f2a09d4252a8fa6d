//! Options of a map beside a log, and the location of the map that they state.

use crate::assemble::datum::Datum;
use crate::assemble::layers::Declared;
use crate::assemble::projection::{Projection, ProjectionKind};
use crate::options::{OptionSpec, OptionType, Options};
use crate::source::ContentHash;

/// The map file.
pub const MAP: OptionSpec = OptionSpec::new(
    "map",
    OptionType::File,
    "FILE",
    "map of the drives, in place of the log's own: OpenDRIVE (.xodr) or Lanelet2 (.osm)",
);
/// Origin of the log's frame, for maps in degrees.
pub const MAP_ORIGIN: OptionSpec = OptionSpec::new(
    "map-origin",
    OptionType::Text,
    "LAT,LON",
    "Lanelet2 map in degrees: latitude and longitude of the origin of the log's frame",
)
.signed()
.requires("map");
/// How degrees become meters.
pub const MAP_PROJECTION: OptionSpec = OptionSpec::new(
    "map-projection",
    OptionType::Text,
    "NAME",
    "projection of the log's frame: utm (Lanelet2's UtmProjector; the default) or local (tangent plane)",
)
.requires("map-origin");
/// Datum of the degrees.
pub const MAP_DATUM: OptionSpec = OptionSpec::new(
    "map-datum",
    OptionType::Text,
    "NAME",
    "datum of the map's degrees and of --map-origin: wgs84 (default) or gcj02",
)
.requires("map");
/// Shift of a map that is known to lie beside the road.
pub const MAP_OFFSET: OptionSpec = OptionSpec::new(
    "map-offset",
    OptionType::Text,
    "X,Y",
    "moves the map by this in the log's frame, m, as in -1.25,0.5",
)
.signed()
.requires("map");
/// What the map has in full.
pub const MAP_COMPLETE: OptionSpec = OptionSpec::new(
    "map-complete",
    OptionType::Text,
    "LIST",
    "what the map shows in full, so that what it does not show is not there: crosswalks, junctions, lights, ramps, \
     stop_lines, kinds of signs and facilities, tags of lanes; separated by commas",
)
.requires("map");

/// All of them; every format has them.
pub const OPTIONS: &[OptionSpec] = &[MAP, MAP_ORIGIN, MAP_PROJECTION, MAP_DATUM, MAP_OFFSET, MAP_COMPLETE];

/// What the user declares the map to have in full, and words that are not known.
pub(super) fn declared(options: &Options) -> (Declared, Vec<String>) {
    let (mut out, mut unknown) = (Declared::default(), Vec::new());
    let known = Declared::words();
    for text in options.texts(&MAP_COMPLETE) {
        for word in text.split([',', ' ']).filter(|w| !w.is_empty()) {
            if known.contains(&word) {
                out.add(word);
            } else {
                unknown.push(word.to_owned());
            }
        }
    }
    (out, unknown)
}

/// Two numbers, separated by a comma or spaces.
fn pair(text: &str) -> Option<[f64; 2]> {
    let mut parts = text.split([',', ' ']).filter(|p| !p.is_empty()).map(|p| p.parse::<f64>().ok());
    let (first, second) = (parts.next().flatten()?, parts.next().flatten()?);
    parts.next().is_none().then_some([first, second])
}

/// By how much the user moves the map, m; `Err` says why the value cannot be used.
pub(super) fn offset(options: &Options) -> Result<[f64; 2], String> {
    let Some(text) = options.texts(&MAP_OFFSET).pop() else { return Ok([0.0; 2]) };
    pair(&text)
        .filter(|offset| offset.iter().all(|v| v.is_finite()))
        .ok_or_else(|| format!("--map-offset {text}: expected meters, as in -1.25,0.5"))
}

/// Where a map in degrees lies in the log's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub datum: Datum,
    pub projection: Option<Projection>,
}

impl Placement {
    /// From the options; `Err` says which value cannot be used.
    pub fn of(options: &Options) -> Result<Self, String> {
        let text = |spec| options.texts(spec).pop();
        let datum = match text(&MAP_DATUM) {
            None => Datum::Wgs84,
            Some(name) => {
                Datum::parse(&name).ok_or_else(|| format!("--map-datum {name}: expected wgs84 or gcj02"))?
            }
        };
        let kind = match text(&MAP_PROJECTION).as_deref() {
            None | Some("utm") => ProjectionKind::Utm,
            Some("local") => ProjectionKind::Local,
            Some(other) => return Err(format!("--map-projection {other}: expected utm or local")),
        };
        let projection = match text(&MAP_ORIGIN) {
            None => None,
            Some(text) => {
                let [lat, lon] = pair(&text)
                    .filter(|[lat, lon]| lat.abs() <= 84.0 && lon.abs() <= 180.0)
                    .ok_or_else(|| format!("--map-origin {text}: expected degrees, as in 48.99,8.40"))?;
                let (lat, lon) = datum.to_wgs84(lat, lon);
                Some(Projection::new(kind, lat, lon))
            }
        };
        Ok(Self { datum, projection })
    }

    /// The stated values, for the hash of a drive.
    pub fn add_to(&self, hash: &mut ContentHash) {
        hash.add("placement", format!("{self:?}").as_bytes());
    }
}
