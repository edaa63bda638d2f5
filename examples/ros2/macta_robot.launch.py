"""Starts the adapter beside Nav2: ros2 launch macta_robot.launch.py parameters:=robot.yaml broker:=mqtt://HOST"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration


def generate_launch_description():
    return LaunchDescription(
        [
            DeclareLaunchArgument("parameters", description="the parameter file"),
            DeclareLaunchArgument("broker", default_value="mqtt://127.0.0.1:1883"),
            ExecuteProcess(
                cmd=[
                    "macta-robot",
                    "ros2",
                    LaunchConfiguration("parameters"),
                    "--broker",
                    LaunchConfiguration("broker"),
                ],
                output="screen",
                respawn=True,
                respawn_delay=2.0,
            ),
        ]
    )
