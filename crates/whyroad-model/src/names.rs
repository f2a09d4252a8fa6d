//! Names for people of what the scene tables only have ids for.

use crate::messages::KeyframeType;
use crate::{Bilingual, ObjectClass};

/// What a class of objects is called.
pub fn class_name(class: ObjectClass) -> Bilingual {
    let (zh, en) = match class {
        ObjectClass::Car => ("轿车", "car"),
        ObjectClass::Truck => ("卡车", "truck"),
        ObjectClass::Bus => ("公交车", "bus"),
        ObjectClass::LargeVehicle => ("大型车辆", "large vehicle"),
        ObjectClass::Motorcycle => ("摩托车", "motorcycle"),
        ObjectClass::Bicycle => ("自行车", "bicycle"),
        ObjectClass::Bicyclist => ("骑行者", "cyclist"),
        ObjectClass::Motorcyclist => ("摩托车骑手", "motorcyclist"),
        ObjectClass::Pedestrian => ("行人", "pedestrian"),
        ObjectClass::WheeledPedestrian => ("轮椅或婴儿车行人", "wheeled pedestrian"),
        ObjectClass::Animal => ("动物", "animal"),
        ObjectClass::Cone => ("锥桶", "cone"),
        ObjectClass::StaticObject => ("静态物体", "static object"),
        ObjectClass::Unknown => ("未知物体", "unknown object"),
    };
    Bilingual::new(zh, en)
}

/// What a kind of keyframe is called.
pub fn keyframe_kind(kind: KeyframeType) -> Bilingual {
    match kind {
        KeyframeType::Reactive => Bilingual::new("时刻型", "one moment"),
        KeyframeType::Proactive => Bilingual::new("区间型", "a range"),
    }
}

/// What a log lacks, in the words that the adapters use; a word that is not in the list stays as it is.
pub fn missing_name(word: &str) -> Bilingual {
    let zh = match word {
        "ego pose" => "自车位姿",
        "map" => "地图",
        "traffic lights" => "信号灯",
        "vehicle bus" => "车辆总线信号",
        "weather and surface" => "天气与路面",
        "camera pictures" => "相机图像",
        "lidar points in boxes" => "框内点云数",
        "object classes and sizes" => "目标类别与尺寸",
        "object classes" => "目标类别",
        "object sizes" => "目标尺寸",
        "turn signals" => "转向灯",
        "visibility" => "可见性",
        "steering angle" => "方向盘转角",
        _ => return Bilingual::same(word),
    };
    Bilingual::new(zh, word)
}
