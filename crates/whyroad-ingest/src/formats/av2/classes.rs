//! AV2's annotation categories on our scale of classes.
//! Source: the category list of the AV2 sensor data set (Wilson et al. 2021, appendix; 30 names with the later
//! additions).

use whyroad_model::ObjectClass;

/// Category of the recording vehicle's own rows.
pub(super) const EGO: &str = "EGO_VEHICLE";

/// Our class for an AV2 category; `None` for one that AV2 does not define.
pub(super) fn class_of(category: &str) -> Option<ObjectClass> {
    Some(match category {
        "REGULAR_VEHICLE" => ObjectClass::Car,
        "TRUCK" | "BOX_TRUCK" | "TRUCK_CAB" | "VEHICULAR_TRAILER" => ObjectClass::Truck,
        "BUS" | "SCHOOL_BUS" | "ARTICULATED_BUS" | "RAILED_VEHICLE" => ObjectClass::Bus,
        "LARGE_VEHICLE" => ObjectClass::LargeVehicle,
        "MOTORCYCLE" => ObjectClass::Motorcycle,
        "MOTORCYCLIST" => ObjectClass::Motorcyclist,
        "BICYCLE" => ObjectClass::Bicycle,
        "BICYCLIST" => ObjectClass::Bicyclist,
        "PEDESTRIAN" | "OFFICIAL_SIGNALER" => ObjectClass::Pedestrian,
        "STROLLER" | "WHEELCHAIR" | "WHEELED_DEVICE" | "WHEELED_RIDER" => ObjectClass::WheeledPedestrian,
        "DOG" | "ANIMAL" => ObjectClass::Animal,
        "CONSTRUCTION_CONE" | "CONSTRUCTION_BARREL" => ObjectClass::Cone,
        "BOLLARD"
        | "SIGN"
        | "STOP_SIGN"
        | "MOBILE_PEDESTRIAN_CROSSING_SIGN"
        | "MESSAGE_BOARD_TRAILER"
        | "TRAFFIC_LIGHT_TRAILER" => ObjectClass::StaticObject,
        _ => return None,
    })
}
