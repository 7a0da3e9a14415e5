# requirements: numpy, rosbags
"""Writes poses.bag and poses (a rosbag2 of MCAP): one trajectory of 20 poses at 10 Hz as the truth, and the same .25 m higher as an estimate. Values are exact in binary.

poses.bag has geometry_msgs/PoseStamped on /truth and nav_msgs/Odometry on /odometry, poses has geometry_msgs/TransformStamped on /truth and
geometry_msgs/PoseWithCovarianceStamped on /odometry. Run in this folder: python3 poses.py
"""
import shutil
from pathlib import Path

import numpy as np
from rosbags.rosbag1 import Writer as Bag1
from rosbags.rosbag2 import StoragePlugin, Writer as Bag2
from rosbags.typesys import Stores, get_typestore

HERE = Path(__file__).parent
T0 = 1_600_000_000_250_000_000


def write(store, ros1, writer, kinds):
    types = store.types
    header, time = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    point, quaternion = types["geometry_msgs/msg/Point"], types["geometry_msgs/msg/Quaternion"]
    vector, covariance = types["geometry_msgs/msg/Vector3"], np.zeros(36)
    serialise = store.serialize_ros1 if ros1 else store.serialize_cdr
    for topic, kind, up in (("/truth", kinds[0], 0.0), ("/odometry", kinds[1], 0.25)):
        connection = writer.add_connection(topic, kind, typestore=store)
        for i in range(20):
            t = T0 + 100_000_000 * i
            when = time(sec=t // 10**9, nanosec=t % 10**9)
            head = header(seq=i, stamp=when, frame_id="map") if ros1 else header(stamp=when, frame_id="map")
            place, turn = (0.5 * i, 0.125 * (i % 5), up), quaternion(x=0.0, y=0.0, z=0.6, w=0.8)
            pose = types["geometry_msgs/msg/Pose"](position=point(*place), orientation=turn)
            believed = types["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=covariance)
            still = types["geometry_msgs/msg/Twist"](linear=vector(0.0, 0.0, 0.0), angular=vector(0.0, 0.0, 0.0))
            message = {
                "geometry_msgs/msg/PoseStamped": lambda kind: kind(header=head, pose=pose),
                "geometry_msgs/msg/PoseWithCovarianceStamped": lambda kind: kind(header=head, pose=believed),
                "nav_msgs/msg/Odometry": lambda kind: kind(
                    header=head, child_frame_id="base", pose=believed,
                    twist=types["geometry_msgs/msg/TwistWithCovariance"](twist=still, covariance=covariance)),
                "geometry_msgs/msg/TransformStamped": lambda kind: kind(
                    header=head, child_frame_id="base",
                    transform=types["geometry_msgs/msg/Transform"](translation=vector(*place), rotation=turn)),
            }[kind](types[kind])
            writer.write(connection, t + 300_000, serialise(message, kind))


(HERE / "poses.bag").unlink(missing_ok=True)
shutil.rmtree(HERE / "poses", ignore_errors=True)
with Bag1(HERE / "poses.bag") as writer:
    write(get_typestore(Stores.ROS1_NOETIC), True, writer, ["geometry_msgs/msg/PoseStamped", "nav_msgs/msg/Odometry"])
with Bag2(HERE / "poses", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
    kinds = ["geometry_msgs/msg/TransformStamped", "geometry_msgs/msg/PoseWithCovarianceStamped"]
    write(get_typestore(Stores.ROS2_HUMBLE), False, writer, kinds)
