//! Classes of tracked objects. The source's own class text is kept beside it in the track.

use crate::Tri;
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
        /// Tricycle with a motor, for goods or people.
        Tricycle = "tricycle",
        /// Police car, ambulance or other emergency vehicle that is not large; a fire engine is a large vehicle.
        EmergencyVehicle = "emergency_vehicle",
        /// E-bike or electric scooter, its rider boxed with it.
        EBike = "e_bike",
        /// Bicycle or scooter in use or parked, rider boxed with it or separately.
        Bicycle = "bicycle",
        /// Person riding a bicycle (boxed as the person).
        Bicyclist = "bicyclist",
        /// Motorcycle with its rider, boxed as the person: in traffic, as a motor vehicle.
        Motorcyclist = "motorcyclist",
        /// Person on foot.
        Pedestrian = "pedestrian",
        /// Stroller, wheelchair, wheeled rider or other slow wheeled road user.
        WheeledPedestrian = "wheeled_pedestrian",
        /// Animal.
        Animal = "animal",
        /// Cone or barrel that marks roadworks.
        Cone = "cone",
        /// Barrier set up on the road: water-filled, concrete or plastic, as at roadworks.
        Barrier = "barrier",
        /// Bollard, sign on a pole, other fixed object.
        StaticObject = "static_object",
        /// Motor vehicle of a kind that the source does not state: any of those above.
        Vehicle = "vehicle",
        /// Not stated by the source.
        #[default]
        Unknown = "unknown",
    }
);

impl ObjectClass {
    /// Motor vehicles, ridden motorcycles included.
    pub fn is_vehicle(self) -> bool {
        matches!(
            self,
            Self::Car
                | Self::Truck
                | Self::Bus
                | Self::LargeVehicle
                | Self::Motorcycle
                | Self::Motorcyclist
                | Self::Tricycle
                | Self::EmergencyVehicle
                | Self::Vehicle
        )
    }

    /// Large vehicles in the sense of `cutin.large_vehicle`: truck, bus, special vehicle.
    pub fn is_large_vehicle(self) -> bool {
        matches!(self, Self::Truck | Self::Bus | Self::LargeVehicle)
    }

    /// [`Self::is_large_vehicle`], unknown where the source does not state the kind.
    pub fn large_vehicle(self) -> Tri {
        match self {
            Self::Vehicle | Self::Unknown => Tri::Unknown,
            known => Tri::from(known.is_large_vehicle()),
        }
    }

    /// Vulnerable road users: people on foot or on two light wheels.
    pub fn is_vru(self) -> bool {
        matches!(
            self,
            Self::Pedestrian | Self::WheeledPedestrian | Self::Bicycle | Self::Bicyclist | Self::EBike
        )
    }

    /// The highest plausible speed over ground of an object of the class, m/s; a higher one is an identity switch or a
    /// bad box, not a motion.
    pub fn max_speed_mps(self) -> f64 {
        match self {
            // The fastest sprint on record peaks at 12.4 m/s (Bolt, Berlin 2009).
            Self::Pedestrian => 12.5,
            // Wheelchairs and skaters downhill.
            Self::WheeledPedestrian => 20.0,
            // Racing cyclists on a descent reach about 110 km/h.
            Self::Bicycle | Self::Bicyclist | Self::EBike => 32.0,
            // Greyhounds and horses: 70 km/h.
            Self::Animal => 20.0,
            _ => 80.0,
        }
    }
}
