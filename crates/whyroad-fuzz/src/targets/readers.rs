//! Readers of single files of logs and lakes, on bytes in memory: no file is opened and no other file is read, so that
//! a million inputs take a minute. Seeds have two or three rows.

use super::made::{self, containers, tables};
use super::{cut, file, fixture, unchanged};
use crate::harness::Target;
use whyroad_ingest::readers;

pub(super) fn targets() -> Vec<Target> {
    let target = |reader: readers::FileReader| Target {
        name: reader.name.to_owned(),
        seeds: seeds(reader.name),
        small: Vec::new(),
        repair: if reader.name == "tfrecord" { made::repair_tfrecord } else { unchanged },
        run: Box::new(reader.read),
    };
    readers::all().into_iter().map(target).collect()
}

/// The seeds of a reader; none for a name that is not known here, which the smoke test refuses.
fn seeds(name: &str) -> Vec<Vec<u8>> {
    let sumo = |name: &str| cut::xml(&fixture(&format!("crossroads.{name}")), 2);
    match name {
        "av2-annotations" => tables::feathers(&tables::annotations(2)),
        "av2-map" => vec![made::av2_map()],
        "av2-motion" => {
            vec![tables::parquet(&tables::scenario(2)), tables::plain_parquet(&tables::scenario(2))]
        }
        "av2-poses" => tables::feathers(&tables::poses(2)),
        "bzip2" => made::bzip2(),
        "can-database" => vec![made::DBC.into()],
        "compressed" => vec![
            made::gzip(b"<fcd-export><timestep time='0'/></fcd-export>"),
            fixture("compressed/crossroads.fcd.xml.xz"),
            fixture("compressed/crossroads.fcd.xml.zst"),
        ],
        "feather" => {
            [tables::feathers(&tables::of_many_types()), tables::feathers(&tables::of_other_types())].concat()
        }
        "map-degrees" => vec![made::LANELET.into()],
        "map-meters" => vec![
            cut::xml_children(&fixture("maps/town.xodr"), 1),
            cut::xml_children(&fixture("maps/town.xodr"), 2),
            made::LANELET.into(),
        ],
        "mcap-mapping" => vec![fixture("mcap/fleet.yaml"), fixture("rosbag/tracks.yaml")],
        "mcap-records" => containers::mcaps(1),
        "npy" => made::arrays(),
        "pai-clips" => {
            vec![tables::plain_parquet(&tables::pai_clips()), tables::parquet(&tables::pai_clips())]
        }
        "pai-egomotion" => {
            vec![tables::plain_parquet(&tables::egomotion(3)), tables::parquet(&tables::egomotion(3))]
        }
        "pai-features" => vec![fixture("pai/tree/features.csv")],
        "pai-obstacles" => {
            vec![tables::plain_parquet(&tables::obstacles(3)), tables::parquet(&tables::obstacles(3))]
        }
        "parquet" => {
            vec![tables::plain_parquet(&tables::of_many_types()), tables::parquet(&tables::of_many_types())]
        }
        "pickle" => vec![fixture("fuzz/sd_small_p2.pkl"), fixture("fuzz/sd_small_p4.pkl")],
        "protobuf-message" => vec![made::protobuf_message()],
        "ros-message" => made::ros_messages(),
        "rosbag-records" => containers::bags(1),
        "sumo-fcd" => vec![sumo("fcd.xml")],
        "sumo-fcd-csv" => vec![cut::lines(&fixture("crossroads_table.fcd.csv"), 5)],
        "sumo-lights" => vec![sumo("lights.xml")],
        "sumo-net" => vec![sumo("net.xml"), cut::xml(&fixture("maps/town.net.xml"), 3)],
        "sumo-shapes" => vec![made::SHAPES.into()],
        "sumo-types" => vec![sumo("rou.xml")],
        "table-mapping" => vec![file("examples/table_fleet/fleet.yaml")],
        "tfrecord" => vec![made::tfrecord(&[b"one", b"second"])],
        "waymo-scenario" => made::waymo_records(2),
        "xml" => vec![sumo("rou.xml"), sumo("lights.xml")],
        "zip" => vec![made::zip(&[("a", b"first"), ("b", b"second member")])],
        _ => Vec::new(),
    }
}

/// The texts that drives of tables are described by.
pub(super) fn example(name: &str) -> Vec<u8> {
    file(&format!("examples/table/following/{name}"))
}
