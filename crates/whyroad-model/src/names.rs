//! Displayed names for values that have only ids in the scene tables.

use crate::messages::KeyframeType;
use crate::{Bilingual, ObjectClass};

/// Displayed name of a class of objects.
pub fn class_name(class: ObjectClass) -> Bilingual {
    let (zh, en) = match class {
        ObjectClass::Car => ("轿车", "car"),
        ObjectClass::Truck => ("卡车", "truck"),
        ObjectClass::Bus => ("公交车", "bus"),
        ObjectClass::LargeVehicle => ("大型车辆", "large vehicle"),
        ObjectClass::Motorcycle => ("摩托车", "motorcycle"),
        ObjectClass::Tricycle => ("三轮车", "tricycle"),
        ObjectClass::EmergencyVehicle => ("应急车辆", "emergency vehicle"),
        ObjectClass::EBike => ("电动自行车", "e-bike"),
        ObjectClass::Bicycle => ("自行车", "bicycle"),
        ObjectClass::Bicyclist => ("骑行者", "cyclist"),
        ObjectClass::Motorcyclist => ("摩托车骑手", "motorcyclist"),
        ObjectClass::Pedestrian => ("行人", "pedestrian"),
        ObjectClass::WheeledPedestrian => ("轮椅或婴儿车", "wheeled pedestrian"),
        ObjectClass::Animal => ("动物", "animal"),
        ObjectClass::Cone => ("锥桶", "cone"),
        ObjectClass::Barrier => ("水马或隔离墩", "barrier"),
        ObjectClass::StaticObject => ("静态物体", "static object"),
        ObjectClass::Vehicle => ("机动车", "motor vehicle"),
        ObjectClass::Unknown => ("未知物体", "unknown object"),
    };
    Bilingual::new(zh, en)
}

/// Displayed name of a kind of keyframe.
pub fn keyframe_kind(kind: KeyframeType) -> Bilingual {
    match kind {
        KeyframeType::Reactive => Bilingual::new("时刻型", "one moment"),
        KeyframeType::Proactive => Bilingual::new("区间型", "a range"),
    }
}
