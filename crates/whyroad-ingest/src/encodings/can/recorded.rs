//! Every frame of the recorded Toyota's messages, decoded here and by cantools 45.1 (Python) with the same DBC.
//! cantools' result is recorded here as two figures per signal: how many frames the message has on bus 0, and the sum
//! over them of value times position (counted from 1), which differs when one frame differs or two are exchanged.

use super::CanDatabase;
use crate::encodings::npy::{byte_strings, numbers};
use std::path::PathBuf;

type Expected = (&'static str, &'static str, usize, f64);

/// `sum((i + 1) * message.decode(data[i])[signal] for i in ...)`.
const BY_CANTOOLS: &[Expected] = &[
    ("WHEEL_SPEEDS", "WHEEL_SPEED_FR", 4974, 746791465.629999),
    ("WHEEL_SPEEDS", "WHEEL_SPEED_FL", 4974, 746861200.4699969),
    ("WHEEL_SPEEDS", "WHEEL_SPEED_RR", 4974, 745393943.5600011),
    ("WHEEL_SPEEDS", "WHEEL_SPEED_RL", 4974, 745702936.0400003),
    ("STEER_ANGLE_SENSOR", "STEER_ANGLE", 4974, -2932969.5),
    ("STEER_ANGLE_SENSOR", "STEER_FRACTION", 4974, -186953.1),
    ("STEER_ANGLE_SENSOR", "STEER_RATE", 4974, -796955.0),
    ("VSC1S07", "BRKON", 1243, 201577.0),
    ("VSC1S07", "ASLP", 1243, 494921.0),
    ("VSC1S07", "GVC", 1243, -116712.52),
    ("VSC1S07", "VSC07SUM", 1243, 40676283.0),
    ("PCM_CRUISE_SM", "MAIN_ON", 62, 1953.0),
    ("PCM_CRUISE_SM", "DISTANCE_LINES", 62, 5724.0),
    ("PCM_CRUISE_SM", "CRUISE_CONTROL_STATE", 62, 11538.0),
    ("PCM_CRUISE_SM", "UI_SET_SPEED", 62, 97120.0),
    ("PCM_CRUISE_2", "BRAKE_PRESSED", 1890, 0.0),
    ("PCM_CRUISE_2", "SET_SPEED", 1890, 138822416.0),
    ("PCM_CRUISE_2", "CHECKSUM", 1890, 312827519.0),
    ("BLINKERS_STATE", "BLINKER_BUTTON_PRESSED", 8, 30.0),
    ("BLINKERS_STATE", "TURN_SIGNALS", 8, 108.0),
    ("BLINKERS_STATE", "HAZARD_LIGHT", 8, 0.0),
    ("GEAR_PACKET", "GEAR", 66, 0.0),
    ("GEAR_PACKET", "DRIVE_ENGAGED", 66, 2211.0),
    ("KINEMATICS", "YAW_RATE", 4974, -5305794.04),
    ("KINEMATICS", "ACCEL_X", 4974, 523284.85724),
    ("KINEMATICS", "ACCEL_Y", 4974, -768600.85165),
];

#[test]
fn every_frame_decodes_as_cantools_decodes_it() {
    let data = std::env::var_os("WHYROAD_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let raw =
        data.join("comma2k19/Example_1/b0c9d2329ad1606b|2018-08-02--08-34-47/40/processed_log/CAN/raw_can");
    let Ok(dbc) = std::fs::read(data.join("opendbc/_toyota_2017.dbc")) else {
        crate::require::skipped("recorded", "no recorded data");
        return;
    };
    let dbc = CanDatabase::parse(&String::from_utf8_lossy(&dbc)).unwrap();
    let file = |name: &str| std::fs::read(raw.join(name)).unwrap();
    let sources = numbers(&file("src")).unwrap().column(0);
    let addresses = numbers(&file("address")).unwrap().column(0);
    let frames = byte_strings(&file("data")).unwrap();
    assert_eq!(frames.rows(), 135_468);
    for &(message, signal, count, weighted) in BY_CANTOOLS {
        let coding = dbc.signal(message, signal).unwrap();
        let rows = (0..frames.rows())
            .filter(|&i| sources[i] == 0.0 && addresses[i] == f64::from(coding.address))
            .map(|i| coding.value(frames.row(i)).unwrap());
        let (n, sum) = rows.fold((0, 0.0), |(n, sum), value| (n + 1, sum + (n + 1) as f64 * value));
        assert_eq!(n, count, "{message}.{signal}");
        // Only the order of rounding may differ.
        assert!(
            (sum - weighted).abs() <= 1e-9 * weighted.abs() + 1e-3,
            "{message}.{signal}: {sum} for {weighted}"
        );
    }
}
