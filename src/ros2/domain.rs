//! Where a node looks for others: the domain and the networks, from the environment as ROS 2 has it.

use crate::Ros2Error;
use std::env;

/// The highest domain whose ports exist on every system.
const HIGHEST: u16 = 232;

/// A domain, and whether it ends at this machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Domain {
    /// `ROS_DOMAIN_ID`.
    pub id: u16,
    /// Whether nobody outside this machine is heard (`ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST`; in humble `ROS_LOCALHOST_ONLY=1`).
    pub local: bool,
}

impl Domain {
    /// As the environment says; domain 0 in the whole subnet where it says nothing.
    ///
    /// # Errors
    /// A domain that is no number up to 232; a range that is not known.
    pub fn of_environment() -> Result<Self, Ros2Error> {
        Self::of(|name| env::var(name).ok().filter(|value| !value.is_empty()))
    }

    fn of(variable: impl Fn(&'static str) -> Option<String>) -> Result<Self, Ros2Error> {
        let bad = |name, value, problem| Err(Ros2Error::Environment { name, value, problem });
        let id = match variable("ROS_DOMAIN_ID") {
            None => 0,
            Some(text) => match text.parse() {
                Ok(id) if id <= HIGHEST => id,
                _ => return bad("ROS_DOMAIN_ID", text, "a domain is a number from 0 to 232"),
            },
        };
        let range = variable("ROS_AUTOMATIC_DISCOVERY_RANGE");
        let local = match range.as_deref() {
            None | Some("SYSTEM_DEFAULT") => variable("ROS_LOCALHOST_ONLY").is_some_and(|only| only == "1"),
            Some("SUBNET") => false,
            Some("LOCALHOST") => true,
            Some(_) => {
                let value = range.unwrap_or_default();
                return bad("ROS_AUTOMATIC_DISCOVERY_RANGE", value, "known here are SUBNET and LOCALHOST");
            }
        };
        Ok(Self { id, local })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_environment_says_the_domain_and_how_far_it_reaches() {
        let of = |set: &[(&str, &str)]| {
            Domain::of(|name| set.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned()))
        };
        assert_eq!(of(&[]).unwrap(), Domain { id: 0, local: false });
        assert_eq!(of(&[("ROS_DOMAIN_ID", "42")]).unwrap(), Domain { id: 42, local: false });
        assert!(of(&[("ROS_LOCALHOST_ONLY", "1")]).unwrap().local);
        assert!(of(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")]).unwrap().local);
        // The newer variable has the word.
        let both = [("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"), ("ROS_LOCALHOST_ONLY", "1")];
        assert!(!of(&both).unwrap().local);
        for (name, value) in
            [("ROS_DOMAIN_ID", "233"), ("ROS_DOMAIN_ID", "x"), ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")]
        {
            let error = of(&[(name, value)]).unwrap_err().to_string();
            assert!(error.starts_with(&format!("{name}={value}: ")), "{error}");
        }
    }
}
