# SPDX-License-Identifier: Apache-2.0
"""The quality-of-service profiles of the topics, each written once."""

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

LATCHED = QoSProfile(depth=1, history=HistoryPolicy.KEEP_LAST,
                     reliability=ReliabilityPolicy.RELIABLE,
                     durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Maps, regions, subgoals and states: reliable, kept for those who come late."""

CONTACTS = QoSProfile(depth=100, history=HistoryPolicy.KEEP_LAST,
                      reliability=ReliabilityPolicy.RELIABLE)
"""Contacts and terrain samples: reliable, none may be lost in a burst."""

COMMANDS = QoSProfile(depth=1, history=HistoryPolicy.KEEP_LAST,
                      reliability=ReliabilityPolicy.RELIABLE)
"""Velocity commands: only the newest counts."""

ODOMETRY = QoSProfile(depth=10, history=HistoryPolicy.KEEP_LAST,
                      reliability=ReliabilityPolicy.RELIABLE)
"""What the robot publishes of its own motion."""

ODOMETRY_INPUT = QoSProfile(depth=10, history=HistoryPolicy.KEEP_LAST,
                            reliability=ReliabilityPolicy.BEST_EFFORT)
"""How odometry is read: fits a reliable and a best-effort publisher alike."""

SENSORS = QoSProfile(depth=10, history=HistoryPolicy.KEEP_LAST,
                     reliability=ReliabilityPolicy.BEST_EFFORT)
"""Joint states, wrenches and inertial measurements at 200 Hz: late data are of no use."""

DEFAULT = QoSProfile(depth=10)
"""Goals and diagnostics."""
