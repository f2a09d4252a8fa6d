//! Classes of tracked objects. The source's own class text is kept beside it in the track.

use crate::decision::closed_set;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

closed_set!(
    #[derive(Default)]
    /// What a tracked object is, coarse enough that every source can be mapped onto it.
    ObjectClass {
        /// Passenger car or van.
        Car = "car",
        /// Truck of any kind, tractor, box truck, trailer.
        Truck = "truck",
        /// Bus, articulated bus, school bus, tram.
        Bus = "bus",
        /// Other large or oddly shaped vehicle: construction machine, fire engine.
        LargeVehicle = "large_vehicle",
        /// Motorcycle or moped, with or without rider.
        Motorcycle = "motorcycle",
        /// Bicycle or scooter in use or parked, rider boxed with it or separately.
        Bicycle = "bicycle",
        /// Person riding a bicycle (boxed as the person).
        Bicyclist = "bicyclist",
        /// Person riding a motorcycle (boxed as the person).
        Motorcyclist = "motorcyclist",
        /// Person on foot.
        Pedestrian = "pedestrian",
        /// Stroller, wheelchair, wheeled rider or other slow wheeled road user.
        WheeledPedestrian = "wheeled_pedestrian",
        /// Animal.
        Animal = "animal",
        /// Cone or barrel that marks works.
        Cone = "cone",
        /// Barrier, bollard, sign on a pole, other fixed object.
        StaticObject = "static_object",
        /// Not stated by the source.
        #[default]
        Unknown = "unknown",
    }
);

impl ObjectClass {
    /// Motor vehicles with their own box (the riders of two-wheelers are not).
    pub fn is_vehicle(self) -> bool {
        matches!(self, Self::Car | Self::Truck | Self::Bus | Self::LargeVehicle | Self::Motorcycle)
    }

    /// Large vehicles in the sense of `cutin.large_vehicle`: truck, bus, special vehicle.
    pub fn is_large_vehicle(self) -> bool {
        matches!(self, Self::Truck | Self::Bus | Self::LargeVehicle)
    }

    /// Vulnerable road users: people on foot or on two light wheels.
    pub fn is_vru(self) -> bool {
        matches!(
            self,
            Self::Pedestrian | Self::WheeledPedestrian | Self::Bicycle | Self::Bicyclist | Self::Motorcyclist
        )
    }
}
