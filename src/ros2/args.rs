//! What stands behind `--ros-args`.
//!
//! Source: design.ros2.org, "ROS Command Line Arguments"; parameters in files as `rcl_yaml_param_parser` reads them.

use crate::{Names, Ros2Error};
use std::fs;
use std::path::{Path, PathBuf};

/// A parameter: its name, parts between dots, and its value as text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Param {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: String,
}

/// Remappings, parameters and the node's own names.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RosArgs {
    node: Option<String>,
    namespace: Option<String>,
    rules: Vec<(String, String)>,
    params: Vec<Given>,
}

/// A parameter, or a file of them.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Given {
    One(Option<String>, Param),
    File(PathBuf),
}

impl RosArgs {
    /// Of the words behind `--ros-args`.
    ///
    /// # Errors
    /// A word that is not known, or a rule that is none.
    pub fn parse(words: &[String]) -> Result<Self, Ros2Error> {
        let mut found = Self::default();
        let mut words = words.iter();
        while let Some(word) = words.next() {
            let mut next = || {
                let missing = || Ros2Error::Argument { problem: format!("nothing follows `{word}`") };
                words.next().ok_or_else(missing)
            };
            match word.as_str() {
                "-r" | "--remap" => found.remap(next()?)?,
                "-p" | "--param" => {
                    let ((node, name), value) = rule(next()?)?;
                    found.params.push(Given::One(node, Param { name, value }));
                }
                "--params-file" => found.params.push(Given::File(next()?.into())),
                // What is written goes to standard error, whoever asks.
                "--log-level" | "-e" | "--enclave" => {
                    next()?;
                }
                "--ros-args"
                | "--enable-rosout-logs"
                | "--disable-rosout-logs"
                | "--disable-external-lib-logs" => {}
                other => return Err(Ros2Error::Argument { problem: format!("`{other}` is not known") }),
            }
        }
        Ok(found)
    }

    fn remap(&mut self, text: &str) -> Result<(), Ros2Error> {
        let ((node, from), to) = rule(text)?;
        match from.as_str() {
            // A rule for one node of a process that has one.
            "__ns" => self.namespace = Some(to),
            "__node" | "__name" => self.node = Some(to),
            _ if node.as_ref().is_some_and(|node| Some(node) != self.node.as_ref()) => {}
            _ => self.rules.push((from, to)),
        }
        Ok(())
    }

    /// The node's names; `node` is what it is called where nobody says.
    ///
    /// # Errors
    /// A name that ROS does not have.
    pub fn names(&self, node: &str) -> Result<Names, Ros2Error> {
        let namespace = self.namespace.as_deref().unwrap_or("/");
        Names::new(self.node.as_deref().unwrap_or(node), namespace, &self.rules)
    }

    /// The parameters of the node with these names, in the order in which they were given: a later one is over an earlier.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn params(&self, names: &Names) -> Result<Vec<Param>, Ros2Error> {
        let mut all = Vec::new();
        for given in &self.params {
            match given {
                Given::One(node, param) => {
                    if node.as_deref().is_none_or(|node| is_of(node, names)) {
                        all.push(param.clone());
                    }
                }
                Given::File(path) => all.extend(of_file(path, names)?),
            }
        }
        Ok(all)
    }
}

/// `[NODE:]NAME:=VALUE` in three.
fn rule(text: &str) -> Result<((Option<String>, String), String), Ros2Error> {
    let bad = || Ros2Error::Argument { problem: format!("`{text}` is not NAME:=VALUE") };
    let (left, right) = text.split_once(":=").ok_or_else(bad)?;
    let (node, name) = match left.split_once(':') {
        Some((node, name)) => (Some(node.to_owned()), name),
        None => (None, left),
    };
    if name.is_empty() {
        return Err(bad());
    }
    Ok(((node, name.to_owned()), right.to_owned()))
}

/// Whether `pattern` means this node: its name, with or without its namespace, or `/**`.
fn is_of(pattern: &str, names: &Names) -> bool {
    let node = names.node();
    let last = node.rsplit('/').next().unwrap_or_default();
    pattern == "/**"
        || pattern.strip_prefix("/**/").or(pattern.strip_prefix("/*/")).is_some_and(|name| name == last)
        || pattern.trim_start_matches('/') == node.trim_start_matches('/')
        || pattern == last
}

fn of_file(path: &Path, names: &Names) -> Result<Vec<Param>, Ros2Error> {
    let bad = |problem: String| Ros2Error::ParamsFile { path: path.to_path_buf(), problem };
    let text = fs::read_to_string(path).map_err(|error| bad(error.to_string()))?;
    let file: serde_json::Value = serde_saphyr::from_str(&text).map_err(|error| bad(error.to_string()))?;
    let nodes = file.as_object().ok_or_else(|| bad("it is no mapping".to_owned()))?;
    let mut all = Vec::new();
    for (pattern, node) in nodes {
        let params = node.get("ros__parameters").and_then(serde_json::Value::as_object);
        let params = params.ok_or_else(|| bad(format!("`{pattern}` has no ros__parameters")))?;
        if is_of(pattern, names) {
            flatten("", params, &mut all);
        }
    }
    Ok(all)
}

/// Mappings in mappings become names with dots.
fn flatten(before: &str, params: &serde_json::Map<String, serde_json::Value>, all: &mut Vec<Param>) {
    for (key, value) in params {
        let name = if before.is_empty() { key.clone() } else { format!("{before}.{key}") };
        match value {
            serde_json::Value::Object(inner) => flatten(&name, inner, all),
            serde_json::Value::String(text) => all.push(Param { name, value: text.clone() }),
            other => all.push(Param { name, value: other.to_string() }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<RosArgs, Ros2Error> {
        RosArgs::parse(&text.split_whitespace().map(str::to_owned).collect::<Vec<_>>())
    }

    #[test]
    fn rules_parameters_and_names_are_told_apart() {
        let args = of("-r imu:=/imu0 --remap __ns:=/robot -p use_sim_time:=true --ros-args -r __node:=eye -p other:x:=1 -p eye:window.size:=8 --log-level info").unwrap();
        let names = args.names("dpn").unwrap();
        assert_eq!(names.node(), "/robot/eye");
        assert_eq!(names.topic("imu").unwrap(), "/imu0");
        let params = args.params(&names).unwrap();
        let shown: Vec<String> = params.iter().map(|p| format!("{}={}", p.name, p.value)).collect();
        assert_eq!(shown, ["use_sim_time=true", "window.size=8"]);
        for wrong in ["-r imu", "-r :=b", "-p :=1", "-r", "--what", "imu:=b"] {
            assert!(of(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn files_of_parameters_name_the_node_or_all() {
        let dir = std::env::temp_dir().join(format!("dpn-params-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        let path = dir.join("params.yaml");
        let text = "/**:\n  ros__parameters:\n    use_sim_time: true\n    window:\n      pixel_std: 0.5\nother:\n  ros__parameters:\n    noise: x1\ndpn:\n  ros__parameters:\n    noise: x4\n";
        fs::write(&path, text).unwrap();
        let args = of(&format!("--params-file {}", path.display())).unwrap();
        let mut shown: Vec<String> = args
            .params(&args.names("dpn").unwrap())
            .unwrap()
            .iter()
            .map(|p| format!("{}={}", p.name, p.value))
            .collect();
        shown.sort();
        assert_eq!(shown, ["noise=x4", "use_sim_time=true", "window.pixel_std=0.5"]);
        fs::write(&path, "dpn: 3\n").unwrap();
        let error = args.params(&args.names("dpn").unwrap()).unwrap_err().to_string();
        assert!(error.contains("`dpn` has no ros__parameters"), "{error}");
        fs::remove_dir_all(&dir).unwrap();
    }
}
