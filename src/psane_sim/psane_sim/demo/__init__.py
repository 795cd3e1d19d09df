# SPDX-License-Identifier: Apache-2.0
"""The demo: a run from start to goal, on a ROS 2 graph or in one process, alone or as a team."""
