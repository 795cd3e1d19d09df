# SPDX-License-Identifier: Apache-2.0
"""The acceleration of free fall, for the simulator and for what reads an accelerometer alike."""

GRAVITY = 9.81
"""[m/s^2]."""
