//! Names that logs with free class names give to objects, and our classes. One table for all of them: `mcap`, `rosbag`,
//! `openlabel`, `table`. Formats with a closed list of classes have their own.

use whyroad_model::ObjectClass;

/// Usual names, in lower case with underscores.
const NAMES: &[(&str, ObjectClass)] = &[
    ("auto", ObjectClass::Car),
    ("automobile", ObjectClass::Car),
    ("passenger_car", ObjectClass::Car),
    ("sedan", ObjectClass::Car),
    ("suv", ObjectClass::Car),
    ("taxi", ObjectClass::Car),
    ("minivan", ObjectClass::Car),
    ("van", ObjectClass::Car),
    ("pickup", ObjectClass::Car),
    ("pickup_truck", ObjectClass::Car),
    ("box_truck", ObjectClass::Truck),
    ("heavy_truck", ObjectClass::Truck),
    ("lorry", ObjectClass::Truck),
    ("semi", ObjectClass::Truck),
    ("semi_trailer", ObjectClass::Truck),
    ("trailer", ObjectClass::Truck),
    ("truck_cab", ObjectClass::Truck),
    ("coach", ObjectClass::Bus),
    ("minibus", ObjectClass::Bus),
    ("school_bus", ObjectClass::Bus),
    ("tram", ObjectClass::Bus),
    ("construction_vehicle", ObjectClass::LargeVehicle),
    ("excavator", ObjectClass::LargeVehicle),
    ("fire_engine", ObjectClass::LargeVehicle),
    ("fire_truck", ObjectClass::LargeVehicle),
    ("ambulance", ObjectClass::EmergencyVehicle),
    ("police", ObjectClass::EmergencyVehicle),
    ("police_car", ObjectClass::EmergencyVehicle),
    ("moped", ObjectClass::Motorcycle),
    ("motorbike", ObjectClass::Motorcycle),
    ("moto", ObjectClass::Motorcycle),
    ("motorcycle_rider", ObjectClass::Motorcyclist),
    ("tricyclist", ObjectClass::Tricycle),
    ("rickshaw", ObjectClass::Tricycle),
    ("ebike", ObjectClass::EBike),
    ("e_scooter", ObjectClass::EBike),
    ("bike", ObjectClass::Bicycle),
    ("cycle", ObjectClass::Bicycle),
    ("cyclist", ObjectClass::Bicyclist),
    ("bike_rider", ObjectClass::Bicyclist),
    ("rider", ObjectClass::Bicyclist),
    ("adult", ObjectClass::Pedestrian),
    ("child", ObjectClass::Pedestrian),
    ("human", ObjectClass::Pedestrian),
    ("people", ObjectClass::Pedestrian),
    ("ped", ObjectClass::Pedestrian),
    ("person", ObjectClass::Pedestrian),
    ("vru", ObjectClass::Pedestrian),
    ("walker", ObjectClass::Pedestrian),
    ("stroller", ObjectClass::WheeledPedestrian),
    ("wheelchair", ObjectClass::WheeledPedestrian),
    ("cat", ObjectClass::Animal),
    ("dog", ObjectClass::Animal),
    ("traffic_cone", ObjectClass::Cone),
    ("bollard", ObjectClass::StaticObject),
    ("motor_vehicle", ObjectClass::Vehicle),
    ("other", ObjectClass::Unknown),
    ("none", ObjectClass::Unknown),
];

/// The class of a name, whatever its case and prefix: `Car`, `vehicle.car`, `http://.../Pedestrian`, `Traffic Cone`.
/// `None` for a name that is not known.
pub(crate) fn class_of(name: &str) -> Option<ObjectClass> {
    let plain = |text: &str| text.trim().to_lowercase().replace([' ', '-'], "_");
    let of = |word: &str| {
        let named = || NAMES.iter().find(|(name, _)| *name == word).map(|(_, class)| *class);
        ObjectClass::from_id(word).or_else(named)
    };
    let last = name.rsplit(['.', '/', '#', ':']).next().unwrap_or_default();
    of(&plain(name)).or_else(|| of(&plain(last)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_names_have_their_class_in_any_spelling() {
        for (name, class) in [
            ("Van", ObjectClass::Car),
            ("vehicle.car", ObjectClass::Car),
            ("LORRY", ObjectClass::Truck),
            ("Traffic Cone", ObjectClass::Cone),
            ("http://vocabulary/Pedestrian", ObjectClass::Pedestrian),
            ("cyclist", ObjectClass::Bicyclist),
            ("school-bus", ObjectClass::Bus),
            ("e_bike", ObjectClass::EBike),
        ] {
            assert_eq!(class_of(name), Some(class), "{name}");
        }
        assert_eq!((class_of("spaceship"), class_of("")), (None, None));
        // No name says again what an id says.
        assert!(NAMES.iter().all(|(name, _)| ObjectClass::from_id(name).is_none()));
    }
}
