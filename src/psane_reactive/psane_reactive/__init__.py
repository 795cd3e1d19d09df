# SPDX-License-Identifier: Apache-2.0
"""Steer a robot to its subgoal without leaving the region that it may use."""
