# SPDX-License-Identifier: Apache-2.0
"""Walks that measure a robot: slip over strength, its Twist feed-forward, its strides."""
