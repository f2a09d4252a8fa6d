//! Sizes and classes of SUMO's vehicle types: from `<vType>` elements where given, else SUMO's defaults for the class.

use crate::encodings::input::Input;
use crate::encodings::xml::{Tag, for_each_tag};
use std::collections::BTreeMap;
use whyroad_model::ObjectClass;

/// Properties that all vehicles of a type have.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct VehicleType {
    pub class: ObjectClass,
    /// SUMO's name of the class.
    pub vclass: String,
    pub length_m: f64,
    pub width_m: f64,
    pub height_m: f64,
}

/// Types by id.
#[derive(Clone, Debug, Default)]
pub(super) struct VehicleTypes(BTreeMap<String, VehicleType>);

impl VehicleTypes {
    /// Adds the types of a route or additional file. SUMO has no class for animals and the like: `<param
    /// key="whyroad.class" value="animal"/>` inside a type states our class.
    pub fn read(&mut self, input: Input<'_>) -> Result<(), String> {
        let mut inside: Option<String> = None;
        for_each_tag(input, |tag| {
            let e = match tag {
                Tag::Open(e) => e,
                Tag::Close("vType") => return inside = None,
                Tag::Close(_) => return,
            };
            if e.name() == "param" && e.get("key").as_deref() == Some("whyroad.class") {
                let class = e.get("value").and_then(|v| ObjectClass::from_id(&v));
                if let (Some(class), Some(t)) = (class, inside.as_ref().and_then(|id| self.0.get_mut(id))) {
                    t.class = class;
                }
                return;
            }
            if e.name() != "vType" {
                return;
            }
            let Some(id) = e.text("id") else { return };
            let mut t = of_class(e.get("vClass").as_deref().unwrap_or("passenger"));
            let size = |name: &str, default: f64| e.number(name).filter(|v| *v > 0.0).unwrap_or(default);
            t.length_m = size("length", t.length_m);
            t.width_m = size("width", t.width_m);
            t.height_m = size("height", t.height_m);
            inside = Some(id.clone());
            self.0.insert(id, t);
        })
    }

    /// The type, and whether it was given (or is one of SUMO's own) rather than assumed.
    pub fn get(&self, id: &str, is_person: IsPerson) -> (VehicleType, bool) {
        if let Some(t) = self.0.get(id) {
            return (t.clone(), true);
        }
        let (class, known) = match id {
            "DEFAULT_VEHTYPE" => ("passenger", true),
            "DEFAULT_PEDTYPE" => ("pedestrian", true),
            "DEFAULT_BIKETYPE" => ("bicycle", true),
            "DEFAULT_TAXITYPE" => ("taxi", true),
            "DEFAULT_RAILTYPE" => ("rail", true),
            "DEFAULT_CONTAINERTYPE" => ("container", true),
            _ if is_person == IsPerson::Yes => ("pedestrian", false),
            _ => ("passenger", false),
        };
        (of_class(class), known)
    }
}

/// Whether FCD states the object as a person.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum IsPerson {
    Yes,
    No,
}

/// SUMO's default size for a vClass, as SUMO 1.28.0 reports it (`traci.vehicletype.getLength` and so on), and our
/// class.
fn of_class(vclass: &str) -> VehicleType {
    use ObjectClass as C;
    let (class, length_m, width_m, height_m) = match vclass {
        "pedestrian" => (C::Pedestrian, 0.215, 0.478, 1.719),
        "wheelchair" => (C::WheeledPedestrian, 1.2, 0.72, 1.2),
        "bicycle" => (C::Bicycle, 1.6, 0.65, 1.7),
        "scooter" => (C::EBike, 1.2, 0.5, 1.7),
        "moped" => (C::Motorcycle, 2.1, 0.78, 1.7),
        "motorcycle" => (C::Motorcycle, 2.2, 0.9, 1.5),
        "delivery" => (C::Truck, 6.5, 2.16, 2.86),
        "emergency" => (C::EmergencyVehicle, 6.5, 2.16, 2.86),
        "truck" => (C::Truck, 7.1, 2.4, 2.4),
        "trailer" => (C::Truck, 16.5, 2.55, 4.0),
        "bus" => (C::Bus, 12.0, 2.5, 3.4),
        "coach" => (C::Bus, 14.0, 2.6, 4.0),
        "tram" => (C::Bus, 22.0, 2.4, 3.2),
        "rail_urban" | "subway" => (C::LargeVehicle, 109.5, 3.0, 3.6),
        "rail" => (C::LargeVehicle, 135.0, 2.84, 3.75),
        "rail_electric" | "rail_fast" => (C::LargeVehicle, 200.0, 2.95, 3.89),
        "container" => (C::StaticObject, 6.096, 2.438, 2.591),
        "ship" => (C::Unknown, 17.0, 4.0, 4.0),
        "aircraft" => (C::Unknown, 72.7, 79.8, 1.5),
        "drone" => (C::Unknown, 0.5, 0.5, 1.5),
        // passenger, private, hov, taxi, evehicle, authority, army, vip, custom1, custom2, ignoring
        _ => (C::Car, 5.0, 1.8, 1.5),
    };
    VehicleType { class, vclass: vclass.to_owned(), length_m, width_m, height_m }
}
