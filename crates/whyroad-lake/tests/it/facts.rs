//! Facts that are stated about a drive after it was ingested.

use whyroad_lake::{DriveFacts, Lake, WriteOutcome};
use whyroad_model::scene::{DriveMeta, GeoPosition};
use whyroad_model::{Drive, Nanos};

fn drive(hash: &str) -> Drive {
    Drive {
        meta: DriveMeta { drive_id: "d".into(), content_hash: hash.into(), ..DriveMeta::default() },
        times: vec![Nanos(0), Nanos(100_000_000)],
        ..Drive::default()
    }
}

#[test]
fn facts_are_kept_until_others_are_stated_and_survive_another_ingest() {
    let dir = tempfile::tempdir().unwrap();
    let lake = Lake::create_or_open(dir.path().join("lake")).unwrap();
    lake.write_drive(&drive("one")).unwrap();
    let position = Some(GeoPosition { latitude_deg: 40.0, longitude_deg: 116.0 });
    let facts = DriveFacts {
        session: Some("s1".into()),
        position,
        place: Some("town".into()),
        licence: Some("MIT".into()),
        ..DriveFacts::default()
    };
    assert!(lake.state_facts(&"d".into(), facts.clone()).unwrap());
    assert!(!lake.state_facts(&"d".into(), facts).unwrap(), "nothing new");
    let vehicle = DriveFacts { vehicle: Some("v7".into()), ..DriveFacts::default() };
    assert!(lake.state_facts(&"d".into(), vehicle).unwrap());
    let meta = lake.read_drive(&"d".into()).unwrap().meta;
    assert_eq!(
        (meta.session.as_deref(), meta.vehicle.as_deref(), meta.position),
        (Some("s1"), Some("v7"), position)
    );
    assert_eq!((meta.place.as_deref(), meta.licence.as_deref()), (Some("town"), Some("MIT")));

    assert_eq!(lake.write_drive(&drive("one")).unwrap(), WriteOutcome::Unchanged);
    assert_eq!(lake.write_drive(&drive("two")).unwrap(), WriteOutcome::Replaced);
    let meta = lake.read_drive(&"d".into()).unwrap().meta;
    assert_eq!((meta.session.as_deref(), meta.vehicle.as_deref()), (Some("s1"), Some("v7")));
    assert_eq!(meta.content_hash, "two");
    assert!(lake.state_facts(&"other".into(), DriveFacts::default()).is_err());
}
