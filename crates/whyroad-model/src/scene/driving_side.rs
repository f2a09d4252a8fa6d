//! On which side of the road traffic drives: by location, else by lanes that run against each other. No rule or signal
//! may assume a side.

use super::Drive;
use crate::road_map::{Lane, LaneKind, LayerState, MapLayer, Point3, RoadMap};

/// Side of the road on which traffic drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrivingSide {
    /// Right-hand traffic: oncoming traffic is on the left.
    Right,
    /// Left-hand traffic.
    Left,
}

/// Places with left-hand traffic within a country with right-hand traffic, in lower case.
const LEFT_WITHIN: &[&str] = &["hong kong", "hong-kong", "macau", "macao", "香港", "澳门", "澳門"];
/// Places with left-hand traffic, in lower case, as logs write them.
const LEFT: &[&str] = &[
    "singapore",
    "japan",
    "tokyo",
    "united kingdom",
    "uk",
    "great britain",
    "england",
    "scotland",
    "wales",
    "london",
    "ireland",
    "australia",
    "new zealand",
    "india",
    "thailand",
    "malaysia",
    "indonesia",
    "south africa",
    "kenya",
    "cyprus",
    "新加坡",
    "日本",
    "东京",
    "英国",
    "伦敦",
    "澳大利亚",
    "新西兰",
    "泰国",
    "马来西亚",
    "印度",
];
/// Places with right-hand traffic: of the public sets and of our users, and countries.
const RIGHT: &[&str] = &[
    "china",
    "beijing",
    "shanghai",
    "shenzhen",
    "guangzhou",
    "hangzhou",
    "wuhan",
    "chongqing",
    "chengdu",
    "suzhou",
    "tianjin",
    "中国",
    "北京",
    "上海",
    "深圳",
    "广州",
    "杭州",
    "武汉",
    "重庆",
    "成都",
    "苏州",
    "天津",
    "united states",
    "usa",
    "us",
    "boston",
    "pittsburgh",
    "miami",
    "austin",
    "detroit",
    "palo alto",
    "washington",
    "las vegas",
    "las-vegas",
    "san francisco",
    "美国",
    "canada",
    "ontario",
    "germany",
    "berlin",
    "munich",
    "karlsruhe",
    "德国",
    "france",
    "paris",
    "法国",
    "netherlands",
    "italy",
    "spain",
    "sweden",
    "poland",
    "austria",
    "switzerland",
    "korea",
    "韩国",
];
/// Lanes whose neighbor runs against them decide, when at least this share of them agrees; this many where the map
/// does not state neighbors, so that they are derived from the geometry.
const SHARE: f64 = 0.9;
const DERIVED: usize = 3;

impl Drive {
    /// On which side traffic drives; `None` when neither the place nor the map says.
    pub fn driving_side(&self) -> Option<DrivingSide> {
        let place = self.meta.place.as_deref().unwrap_or_default();
        of_place(place).or_else(|| self.map.as_ref()?.driving_side())
    }
}

/// By a place as logs write it: `Singapore, one-north`, `London, Ontario`, `中国香港`. Of parts between commas the last
/// one that is known decides: the country or region before the city.
fn of_place(place: &str) -> Option<DrivingSide> {
    let place = place.to_lowercase();
    if LEFT_WITHIN.iter().any(|name| names_place(&place, name)) {
        return Some(DrivingSide::Left);
    }
    place.rsplit([',', '，']).find_map(|part| {
        let is = |names: &[&str]| names.iter().any(|name| names_place(part, name));
        match (is(LEFT), is(RIGHT)) {
            (true, false) => Some(DrivingSide::Left),
            (false, true) => Some(DrivingSide::Right),
            _ => None,
        }
    })
}

/// True when `text` has `name` as a word of its own: not as a part of another one, and not as in `New London`. Chinese
/// has no spaces between words.
fn names_place(text: &str, name: &str) -> bool {
    text.match_indices(name).any(|(at, _)| {
        let (before, after) = (&text[..at], &text[at + name.len()..]);
        let joins = |c: Option<char>| c.is_some_and(char::is_alphabetic);
        !name.is_ascii()
            || !(joins(before.chars().next_back()) || joins(after.chars().next()) || before.ends_with("new "))
    })
}

impl RoadMap {
    /// By lanes for vehicles whose neighbor runs the other way: on the left of the lane in right-hand traffic. Cycle
    /// paths of both directions run on either side of a road.
    pub fn driving_side(&self) -> Option<DrivingSide> {
        let rolls =
            |lane: &&Lane| matches!(lane.kind, LaneKind::Vehicle | LaneKind::Bus) && !lane.in_junction;
        let against = |lane: &Lane, id: &Option<String>| {
            let other = id.as_deref().and_then(|id| self.lane(id)).filter(rolls);
            other.is_some_and(|o| direction(lane).zip(direction(o)).is_some_and(|(a, b)| dot(a, b) < -0.5))
        };
        let count = |of: fn(&Lane) -> &Option<String>| {
            self.lanes.iter().filter(|l| rolls(l) && against(l, of(l))).count()
        };
        let (left, right) = (count(|l| &l.left_neighbor), count(|l| &l.right_neighbor));
        let agree = left.max(right) as f64 >= SHARE * (left + right) as f64;
        let least = if self.layer(MapLayer::Neighbors) == LayerState::Derived { DERIVED } else { 1 };
        if left + right < least || !agree {
            return None;
        }
        Some(if left > right { DrivingSide::Right } else { DrivingSide::Left })
    }
}

fn direction(lane: &Lane) -> Option<(f64, f64)> {
    let (a, b): (&Point3, &Point3) = (lane.center.first()?, lane.center.last()?);
    let length = (b.x - a.x).hypot(b.y - a.y);
    (length > 0.0).then(|| ((b.x - a.x) / length, (b.y - a.y) / length))
}

fn dot(a: (f64, f64), b: (f64, f64)) -> f64 {
    a.0 * b.0 + a.1 * b.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_decides_by_its_region_and_by_whole_words() {
        for left in [
            "singapore-onenorth",
            "Singapore, one-north",
            "Tokyo",
            "香港",
            "中国香港",
            "Hong Kong, China",
            "London, UK",
            "伦敦",
        ] {
            assert_eq!(of_place(left), Some(DrivingSide::Left), "{left}");
        }
        for right in ["boston-seaport", "us-nv-las-vegas-strip", "London, Ontario", "上海", "Munich, Germany"]
        {
            assert_eq!(of_place(right), Some(DrivingSide::Right), "{right}");
        }
        for unknown in ["", "New London", "nowhere", "Indianapolis"] {
            assert_eq!(of_place(unknown), None, "{unknown}");
        }
    }

    /// Two-way streets; the oncoming neighbor is on the given side.
    fn map(oncoming_left: bool) -> RoadMap {
        let lane = |id: String, towards: f64, other: String| {
            let center = [0.0, 50.0].map(|x| Point3 { x: towards * x, y: 0.0, z: 0.0 }).to_vec();
            let (left, right) = if oncoming_left { (Some(other), None) } else { (None, Some(other)) };
            Lane { id, center, left_neighbor: left, right_neighbor: right, ..Lane::default() }
        };
        let mut lanes: Vec<Lane> = (0..2)
            .flat_map(|i| {
                let (a, b) = (format!("{i}a"), format!("{i}b"));
                [lane(a.clone(), 1.0, b.clone()), lane(b, -1.0, a)]
            })
            .collect();
        lanes.sort_by(|a, b| a.id.cmp(&b.id));
        RoadMap { lanes, ..RoadMap::default() }
    }

    #[test]
    fn lanes_tell_where_the_place_does_not() {
        let drive = |place: Option<&str>, map| {
            let mut drive = Drive { map: Some(map), ..Drive::default() };
            drive.meta.place = place.map(str::to_owned);
            drive.driving_side()
        };
        assert_eq!(drive(None, map(true)), Some(DrivingSide::Right));
        // One road is enough where the map states which lanes are beside each other, not where that is derived.
        let mut one_road = map(false);
        one_road.lanes.truncate(2);
        assert_eq!(drive(Some("Springfield"), one_road.clone()), Some(DrivingSide::Left));
        one_road.layers.insert(MapLayer::Neighbors, LayerState::Derived);
        assert_eq!(drive(Some("Springfield"), one_road), None);
        // A cycle path of both directions to the right of the road.
        let mut beside = map(false);
        beside.lanes.iter_mut().filter(|l| l.id.ends_with('b')).for_each(|l| l.kind = LaneKind::Bike);
        assert_eq!(drive(None, beside), None);
        assert_eq!(drive(Some("net_7"), map(false)), Some(DrivingSide::Left));
        assert_eq!(drive(Some("singapore-onenorth"), map(true)), Some(DrivingSide::Left));
        assert_eq!(drive(Some("Pittsburgh"), RoadMap::default()), Some(DrivingSide::Right));
        assert_eq!(drive(None, RoadMap::default()), None);
    }
}
