"""The odometry beside other nodes: ros2 launch dpn.launch.py calib:=camchain.yaml imu:=/imu/data_raw image:=/camera/image_raw namespace:=/robot"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration

ARGUMENTS = {
    "calib": ("", "calibration of the camera; empty: CameraInfo and /tf_static"),
    "imu": ("imu", "topic of the IMU"),
    "image": ("image_raw", "topic of the images"),
    "image_transport": ("raw", "raw or compressed"),
    "namespace": ("/", "namespace of the node"),
    "noise": ("self", "where the noise comes from"),
    "use_sim_time": ("false", "whether time is what /clock says"),
}


def generate_launch_description():
    said = {name: LaunchConfiguration(name) for name in ARGUMENTS}
    command = ["dpn", "ros2", "--imu", said["imu"], "--image", said["image"], "--ros-args", "-r", ["__ns:=", said["namespace"]]]
    for name in ("calib", "image_transport", "noise", "use_sim_time"):
        command += ["-p", [name, ":=", said[name]]]
    node = ExecuteProcess(cmd=command, output="screen", respawn=True, respawn_delay=1.0)
    return LaunchDescription([*(DeclareLaunchArgument(name, default_value=value, description=words) for name, (value, words) in ARGUMENTS.items()), node])
