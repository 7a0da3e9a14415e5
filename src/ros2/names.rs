//! Names of topics as `rcl` makes them: relative to the namespace, private to the node, remapped.
//!
//! Source: design.ros2.org, "Topic and Service Names" and "Remapping Names".

use crate::Ros2Error;

/// A node's own names and its rules of remapping.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Names {
    node: String,
    /// Begins with a slash and ends with none but where it is the root.
    namespace: String,
    /// Full names, in the order in which they were given: the first that fits is used.
    rules: Vec<(String, String)>,
}

impl Names {
    /// A node `node` in `namespace` whose topics are renamed by `rules`, both sides as they were given.
    ///
    /// # Errors
    /// A name that ROS does not have.
    pub fn new(node: &str, namespace: &str, rules: &[(String, String)]) -> Result<Self, Ros2Error> {
        if node.contains('/') {
            return Err(bad("node", node, "it holds a slash"));
        }
        check("node", node)?;
        let rooted = if namespace.starts_with('/') { namespace.to_owned() } else { format!("/{namespace}") };
        if rooted != "/" {
            check("namespace", &rooted)?;
        }
        let mut names = Self { node: node.to_owned(), namespace: rooted, rules: Vec::new() };
        names.rules = rules
            .iter()
            .map(|(from, to)| Ok((names.full(from)?, names.full(to)?)))
            .collect::<Result<_, Ros2Error>>()?;
        Ok(names)
    }

    /// The node with its namespace.
    pub fn node(&self) -> String {
        self.under(&self.node)
    }

    /// The topic that is called `name` in this node: `/a` is itself, `a` lies in the namespace, `~/a` below the node; then the first rule that fits.
    ///
    /// # Errors
    /// A name that ROS does not have.
    pub fn topic(&self, name: &str) -> Result<String, Ros2Error> {
        let full = self.full(name)?;
        let rule = self.rules.iter().find(|(from, _)| *from == full);
        Ok(rule.map_or(full, |(_, to)| to.clone()))
    }

    fn full(&self, name: &str) -> Result<String, Ros2Error> {
        let full = match name.strip_prefix("~/") {
            Some(private) => format!("{}/{private}", self.node()),
            None if name.starts_with('/') => name.to_owned(),
            None => self.under(name),
        };
        check("topic", &full).map(|()| full)
    }

    fn under(&self, name: &str) -> String {
        match self.namespace.as_str() {
            "/" => format!("/{name}"),
            namespace => format!("{namespace}/{name}"),
        }
    }
}

fn bad(what: &'static str, name: &str, problem: &'static str) -> Ros2Error {
    Ros2Error::Name { what, name: name.to_owned(), problem }
}

fn check(what: &'static str, name: &str) -> Result<(), Ros2Error> {
    let parts = name.strip_prefix('/').unwrap_or(name).split('/');
    for part in parts {
        let mut letters = part.chars();
        match letters.next() {
            None => return Err(bad(what, name, "it is empty between two slashes, or ends with one")),
            Some(first) if first.is_ascii_digit() => {
                return Err(bad(what, name, "a part begins with a digit"));
            }
            _ => {}
        }
        if !part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return Err(bad(what, name, "it holds more than letters, digits and underscores"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(from: &str, to: &str) -> (String, String) {
        (from.to_owned(), to.to_owned())
    }

    #[test]
    fn topics_lie_in_the_namespace_and_rules_are_held_to_full_names() {
        let names =
            Names::new("dpn", "/robot", &[rule("imu", "/imu0"), rule("~/state", "state"), rule("/a", "b")])
                .unwrap();
        assert_eq!(names.node(), "/robot/dpn");
        for (given, full) in [
            ("imu", "/imu0"),
            ("/imu", "/imu"),
            ("/robot/imu", "/imu0"),
            ("odometry", "/robot/odometry"),
            ("/tf", "/tf"),
            ("~/state", "/robot/state"),
            ("~/other", "/robot/dpn/other"),
            ("/a", "/robot/b"),
        ] {
            assert_eq!(names.topic(given).unwrap(), full, "{given}");
        }
        let rooted = Names::new("dpn", "/", &[]).unwrap();
        assert_eq!(rooted.topic("imu").unwrap(), "/imu");
        assert_eq!(rooted.topic("~/imu").unwrap(), "/dpn/imu");
    }

    #[test]
    fn what_is_no_name_is_refused() {
        let names = Names::new("dpn", "robot/front", &[]).unwrap();
        assert_eq!(names.topic("imu").unwrap(), "/robot/front/imu");
        for name in ["", "a//b", "a/", "0a", "a b", "a-b", "/"] {
            assert!(names.topic(name).is_err(), "{name}");
        }
        assert!(Names::new("a/b", "/", &[]).is_err());
        assert!(Names::new("dpn", "/0", &[]).is_err());
        assert!(Names::new("dpn", "/", &[rule("a", "b c")]).is_err());
    }
}
