//! A node's names and parameters, as they stand behind `--ros-args`.

use crate::args::NodeArgs;
use crate::ui::Fault;
use anyhow::Result;
use dpn_ros2::{Names, Param, RosArgs};

/// What a node is called where nobody says.
const NODE: &str = "dpn";

/// Both, where there are any.
pub(super) fn named(args: &NodeArgs) -> Result<(Names, Vec<Param>)> {
    let ros = RosArgs::parse(&args.ros_args)?;
    let names = ros.names(NODE)?;
    let params = ros.params(&names)?;
    Ok((names, params))
}

/// Takes a parameter that every node has; whether it is one.
pub(super) fn take(args: &mut NodeArgs, param: &Param) -> Result<bool> {
    match param.name.as_str() {
        "use_sim_time" => args.use_sim_time = truth(param)?,
        "reliable" => args.reliable = truth(param)?,
        _ => return Ok(false),
    }
    Ok(true)
}

/// A parameter's yes or no.
pub(super) fn truth(param: &Param) -> Result<bool> {
    match param.value.as_str() {
        "true" => Ok(true),
        "false" => Ok(false),
        _ => {
            Err(Fault::new(format!("parameter {}: `{}` is neither true nor false", param.name, param.value))
                .into())
        }
    }
}

/// That a parameter is none.
pub(super) fn unknown(param: &Param, known: &str) -> Fault {
    Fault::new(format!("there is no parameter `{}`", param.name)).hint(format!("known are {known}"))
}
