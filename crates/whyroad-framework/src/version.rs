//! Versions `major.minor.patch` (DATA_FORMAT.md 1.3) and the steps between them.

use std::fmt;

/// A version. Ordered as numbers, not as text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version {
    /// Raised by incompatible changes.
    pub major: u64,
    /// Raised by compatible additions.
    pub minor: u64,
    /// Raised by changes of wording and fixed mistakes.
    pub patch: u64,
}

impl Version {
    /// Reads `2.0.0`; `None` for anything else, also for `2.0`, `v2.0.0` and `02.0.0`.
    pub fn parse(text: &str) -> Option<Self> {
        let mut parts = text.split('.').map(|p| {
            let plain =
                !p.is_empty() && p.bytes().all(|b| b.is_ascii_digit()) && (p == "0" || !p.starts_with('0'));
            if plain { p.parse().ok() } else { None }
        });
        let version = Self { major: parts.next()??, minor: parts.next()??, patch: parts.next()?? };
        if parts.next().is_some() { None } else { Some(version) }
    }

    /// The smallest version that states a change of this size since `self`.
    pub fn after(self, step: Step) -> Self {
        match step {
            Step::None => self,
            Step::Patch => Self { patch: self.patch + 1, ..self },
            Step::Minor => Self { minor: self.minor + 1, patch: 0, ..self },
            Step::Major => Self { major: self.major + 1, minor: 0, patch: 0 },
        }
    }

    /// The size of the step from `self` to `later`; `None` when `later` is earlier.
    pub fn step_to(self, later: Version) -> Option<Step> {
        if later < self {
            return None;
        }
        Some(if later.major > self.major {
            Step::Major
        } else if later.minor > self.minor {
            Step::Minor
        } else if later.patch > self.patch {
            Step::Patch
        } else {
            Step::None
        })
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// Size of a change (DATA_FORMAT.md 1.3), smallest first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Step {
    /// Nothing changed.
    #[default]
    None,
    /// Wording.
    Patch,
    /// Compatible additions.
    Minor,
    /// Previously valid data may be invalid or have another meaning.
    Major,
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Step::None => "none",
            Step::Patch => "patch",
            Step::Minor => "minor",
            Step::Major => "major",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_three_plain_numbers_are_a_version() {
        // Grammar of the core of a version: semver.org 2.0.0, items 2 and 9.
        assert_eq!(Version::parse("2.0.10"), Some(Version { major: 2, minor: 0, patch: 10 }));
        for bad in ["", "2", "2.0", "2.0.0.0", "v2.0.0", "2.0.x", "02.0.0", "2..0", "-1.0.0", "2.0.0-rc1"] {
            assert_eq!(Version::parse(bad), None, "{bad}");
        }
    }

    #[test]
    fn steps_compare_numbers_not_text() {
        let v = |t| Version::parse(t).unwrap();
        assert_eq!(v("2.9.0").step_to(v("2.10.0")), Some(Step::Minor));
        assert_eq!(v("2.0.0").step_to(v("1.9.9")), None);
        assert_eq!(v("1.9.9").step_to(v("2.0.0")), Some(Step::Major));
        assert_eq!(v("2.1.3").after(Step::Minor).to_string(), "2.2.0");
    }
}
