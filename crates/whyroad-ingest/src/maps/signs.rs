//! Numbers of sign catalogs as our words: the German one (StVO), which OpenDRIVE's and Lanelet2's examples use, and
//! the American one (MUTCD).

/// The word for a sign; `None` for those that have none.
pub(super) fn kind(country: &str, number: &str) -> Option<&'static str> {
    match country.to_uppercase().as_str() {
        "DE" | "DEU" | "GER" | "GERMANY" | "OPENDRIVE" | "" => {
            Some(match number.split(['-', '.']).next().unwrap_or_default() {
                "205" => "yield",
                "206" => "stop",
                "253" => "no_trucks",
                "262" => "weight_limit",
                "264" => "width_limit",
                "265" => "height_limit",
                "267" => "no_entry",
                "272" => "no_u_turn",
                "274" => "speed_limit",
                "276" => "no_overtaking",
                "283" | "286" => "no_parking",
                "294" => "stop_line",
                "301" => "priority",
                "306" => "priority_road",
                n if n.len() == 3 && n.starts_with('1') => "warning",
                _ => return None,
            })
        }
        "US" | "USA" => Some(match number.to_uppercase().as_str() {
            "R1-1" => "stop",
            "R1-2" => "yield",
            "R2-1" => "speed_limit",
            "R5-1" | "R5-1A" => "no_entry",
            "R3-4" => "no_u_turn",
            n if n.starts_with('W') => "warning",
            _ => return None,
        }),
        _ => None,
    }
}

/// A speed with its unit, m/s: `50`, `50 km/h`, `30 mph`; km/h where no unit is stated.
pub(super) fn speed(text: &str) -> Option<f64> {
    let text = text.trim().to_lowercase();
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let value: f64 = text[..digits].parse().ok().filter(|v: &f64| v.is_finite() && *v > 0.0)?;
    let to_mps = match text[digits..].trim() {
        "" | "km/h" | "kmh" | "kph" => 1.0 / 3.6,
        "mph" | "mp/h" => 0.447_04,
        "m/s" | "mps" => 1.0,
        _ => return None,
    };
    Some(value * to_mps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_two_countries_and_speeds_in_three_units() {
        assert_eq!(
            [kind("de", "206"), kind("US", "R1-2"), kind("DE", "274-50")],
            [Some("stop"), Some("yield"), Some("speed_limit")]
        );
        // Right of way at the next junction; a priority road (StVO, annex 3).
        assert_eq!([kind("DE", "301"), kind("de", "306")], [Some("priority"), Some("priority_road")]);
        assert_eq!((kind("CN", "206"), kind("DE", "600")), (None, None));
        let near = |text: &str, want: f64| speed(text).is_some_and(|v| (v - want).abs() < 1e-9);
        assert!(near("36", 10.0) && near("36 km/h", 10.0) && near("10 m/s", 10.0) && near("100 mph", 44.704));
        assert_eq!((speed("none"), speed("5 knots"), speed("")), (None, None, None));
    }
}
